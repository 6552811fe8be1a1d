"""Ellipses with Coulomb friction in contacts alone: inclines, equal axes, momentum, energy, restart, refusals."""
import numpy as np
import pytest

from tests.friction import G, R, SCENE, goes_on, last, leaning, plane, runner
from tests.tables import assert_refused
from tools.base.tables import read_table


@pytest.fixture
def scene(freefem_text, tmp_path):
    return runner(freefem_text, tmp_path)


def ellipse(x, y, major, minor, theta, mu=None):
    made = "bodyEllipse(" + ", ".join(f"{float(value)!r}" for value in (x, y, major, minor, theta, 1000)) + ")"
    return made + ";" if mu is None else f"bodyRough({made}, {float(mu)!r});"


def thrown(motions):
    """The line, after all bodies, that gives them velocities (u, v, omega)."""
    return "bodyQ = [" + ", ".join(f"{float(value)!r}" for value in np.transpose(motions).ravel()) + "];"


def test_an_ellipse_stays_or_slides_down_an_incline(scene):
    """Where its point of contact is under its centre (tan a < mu), it stays; where the force of mu passes through its centre, it
    slides with g (sin a - mu cos a) and does not turn. It leans at most (a^2 - b^2)/(2 a b)."""
    mu, angles = 0.3, np.radians([3, 12, 16.6, 16.8, 30, 50])
    bodies, walls = [], []
    for k, angle in enumerate(angles):
        wall, e = plane(k, angle, mu)
        walls.append(wall)
        minor = [0.5, 0.3, 0.6][k % 3] * R
        normal, height = leaning(R, minor, min(np.tan(angle), mu))
        at = np.array([k + 0.1 * np.cos(angle), -0.1 * np.sin(angle)]) + height * np.array(e)
        bodies.append(ellipse(*at, R, minor, np.pi / 2 - angle - normal))
    folder = scene(bodies, walls, "-friction", 0.9, "-dt", 0.001, "-tend", 0.1, "-every", 0.05)
    end, contacts = last(folder), last(folder, "contacts")
    along, across = end["u"] * np.cos(angles) - end["v"] * np.sin(angles), end["u"] * np.sin(angles) + end["v"] * np.cos(angles)
    slides = np.tan(angles) > mu
    np.testing.assert_allclose(along, np.where(slides, 0.1 * G * (np.sin(angles) - mu * np.cos(angles)), 0), atol=1e-9)
    np.testing.assert_allclose(across, 0, atol=1e-9)
    np.testing.assert_allclose(end["omega"] * R, 0, atol=1e-8)
    order = np.argsort(contacts["i"])
    assert (contacts["sliding"][order] == slides).all()
    np.testing.assert_allclose(np.abs(contacts["tangential"])[order], contacts["impulse"][order] * np.minimum(np.tan(angles), mu),
        rtol=1e-7)


def test_an_ellipse_of_equal_axes_is_a_disk(scene):
    """Rolling, sliding, and hit by another one: an ellipse stands beside, so that all take its path."""
    bodies, walls, motions = [], [], []
    for k, angle in enumerate(np.radians([16, 60])):
        wall, e = plane(k, angle, 0.3)
        walls.append(wall)
        for along, speed in ((0.1, 0.0), (0.14, -0.8)):
            bodies.append(ellipse(k + along * np.cos(angle) + R * e[0], -along * np.sin(angle) + R * e[1], R, R, 0.0))
            motions.append((speed * np.cos(angle), -speed * np.sin(angle), 20.0))
    words = ["-friction", 0.4, "-dt", 0.001, "-tend", 0.06, "-every", 0.001]
    disks = read_table(scene([*bodies, thrown(motions)], walls, *words, name="disks") / "particles.csv")
    mixed = read_table(scene([*bodies, ellipse(-1, 0, R, 0.5 * R, 0.3), thrown([*motions, (0, 0, 0)])], walls, *words, name="mixed")
        / "particles.csv")
    own = mixed["id"] < len(bodies)
    for name in ("x", "y", "theta", "u", "v", "omega"):
        np.testing.assert_allclose(mixed[name][own], disks[name], atol=1e-8 * np.abs(disks[name]).max())


def crowd(seed, rows=5):
    """Ellipses that fly at random in a box, its walls, and their aspects."""
    rng = np.random.default_rng(seed)
    bodies, aspects = [], rng.uniform(0.3, 1, rows * rows)
    for k, aspect in enumerate(aspects):
        major = R * rng.uniform(0.7, 1.2)
        bodies.append(ellipse(0.025 * (k % rows + 0.5), 0.025 * (k // rows + 0.5), major, major * aspect, rng.uniform(0, np.pi),
            rng.uniform(0, 1)))
    bodies.append(thrown(rng.standard_normal((rows * rows, 3)) * [1, 1, 50]))
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]) * 0.025 * rows
    return bodies, [f"contactWallSegment({a}, {b}, {c}, {d});" for (a, b), (c, d) in zip(corners, corners[1:])], aspects


@pytest.mark.parametrize("words", [("-friction", 0.5, "-friction-maxit", 20), *(pytest.param(more, marks=pytest.mark.slow)
    for more in [("-friction", 0.5), ("-friction", 0), ("-friction", 0.5, "-friction-law", "relaxed")])])
def test_energy_never_rises_in_a_violent_crowd(scene, words):
    bodies, walls, _ = crowd(1)
    folder = scene(bodies, walls, "-friction-tol", 1e-6, "-dt", 0.004, "-tend", 0.12, "-every", 0.004, *words,
        gravity=(0.0, 0.0))
    motion = read_table(folder / "motion.csv")
    energy = motion["kinetic_energy"]
    assert np.diff(energy).max() < 1e-11 * energy[0] and energy[-1] < 0.5 * energy[0], np.diff(energy).max() / energy[0]
    assert motion["worst_gap"].min() > -1e-7 * R and motion["momentum_error"].max() < 1e-9
    assert motion["contacts"].max() > 10


@pytest.mark.parametrize("friction", [pytest.param(0, marks=pytest.mark.slow), 1])
def test_momentum_and_angular_momentum_of_free_ellipses_hold(friction, scene):
    """To rounding of the tables, also where the problem is linearised again."""
    bodies, _, aspects = crowd(2)
    n = len(aspects)
    rng = np.random.default_rng(3)
    places = np.array([(0.025 * (k % 5 - 2), 0.025 * (k // 5 - 2)) for k in range(n)])
    bodies[-1] = thrown(np.column_stack([-20 * places + rng.standard_normal((n, 2)), 50 * rng.standard_normal(n)]))
    table = read_table(scene(bodies, [], "-friction", friction, "-dt", 0.002, "-tend", 0.05, "-every", 0.002, gravity=(0.0, 0.0))
        / "particles.csv")
    x, y, u, v, w, r = (np.array(table[name]).reshape(-1, n) for name in ("x", "y", "u", "v", "omega", "radius"))
    mass = 1000 * np.pi * r**2 * aspects
    turning = mass * (x * v - y * u) + mass * r**2 * (1 + aspects**2) / 4 * w
    size = np.abs(turning).sum(axis=1).max()
    assert np.abs(np.diff(turning.sum(axis=1))).max() < 1e-11 * size
    for part in (u, v):
        assert np.abs(np.diff((mass * part).sum(axis=1))).max() < 1e-11 * (mass * np.abs(part)).sum(axis=1).max()
    assert np.abs(np.diff(w, axis=0)).max() > 1


def test_a_run_of_ellipses_goes_on_bit_for_bit(scene, freefem_text):
    words = ["-friction", 0.4, "-friction-tol", 1e-6, "-dt", 0.004, "-every", 0.02, "-checkpoint", 10]
    bodies, walls, _ = crowd(2, 3)
    assert goes_on(scene, freefem_text, bodies, walls, 0.08, *words)


def test_held_and_pinned_ellipses(scene):
    """A held one stops another and does not move; a pinned one is turned by one that slides over it, and stays where it is."""
    bodies = [ellipse(0, 0, R, 0.5 * R, 0.4).replace("bodyEllipse", "bodyHeld(bodyEllipse").replace(";", ");"),
        ellipse(0.3 * R, 1.2 * R, R, 0.4 * R, 0.0),
        ellipse(1, 0, R, 0.5 * R, 0.0).replace("bodyEllipse", "bodyPinned(bodyEllipse").replace(";", ");"),
        ellipse(1 - R, 0.9 * R + 1e-6, R, 0.4 * R, 0.0), thrown([(0, 0, 0)] * 3 + [(0.5, 0, 0)])]
    end = last(scene(bodies, [], "-friction", 0.5, "-dt", 0.001, "-tend", 0.03))
    assert (end["x"][0], end["y"][0], end["omega"][0]) == (0, 0, 0) and (end["x"][2], end["y"][2]) == (1, 0)
    assert np.hypot(end["u"][1], end["v"][1] + 0.03 * G) > 0.01 and end["omega"][2] < -1


@pytest.mark.parametrize("words", [("-cohesion", 0.1), pytest.param(("-contact-form", "ballistic"), marks=pytest.mark.slow)])
def test_what_ellipses_do_not_take_is_refused(words, freefem_text, tmp_path):
    text = SCENE.format(bodies=ellipse(0, 0.1, R, 0.5 * R, 0.1), walls="contactWallSegment(-1, 0, 1, 0);", gravity=(0.0, -G))
    assert_refused(freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run", *words, check=False), [3],
        "ellipses take neither -cohesion nor -contact-form ballistic")
