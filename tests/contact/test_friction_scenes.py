"""Scenes of contacts alone with Coulomb friction against closed forms: inclines, impacts, stacks; tables and restarts.

Several scenes stand side by side in one run, each with walls and coefficients of its own.
"""
import filecmp

import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.friction import G, R, SCENE, goes_on, last, plane, runner
from tools.base.tables import read_table

@pytest.fixture
def scene(freefem_text, tmp_path):
    return runner(freefem_text, tmp_path)


def disk(x, y, mu=None, motion=(0.0, 0.0, 0.0), radius=R, free=1):
    made = "bodyAdd(" + ", ".join(f"{float(value)!r}" for value in (x, y, radius, 1000, *motion)) + f", {free})"
    return made + ";" if mu is None else f"bodyRough({made}, {float(mu)!r});"


def test_a_disk_rolls_or_slips_down_an_incline(scene):
    """It rolls with 2/3 g sin a where tan a <= 3 mu, else slips with g (sin a - mu cos a) and turns with 2 mu g cos a/R."""
    mu, angles = 0.3, np.radians([5, 16, 17.5, 30, 41.9, 42.1, 60])
    bodies, walls = [], []
    for k, a in enumerate(angles):
        wall, e = plane(k, a, mu)
        walls.append(wall)
        # the coefficient is the lesser of the two
        bodies.append(disk(k + 0.1 * np.cos(a) + R * e[0], -0.1 * np.sin(a) + R * e[1], [0.9, 0.3][k % 2]))
    folder = scene(bodies, walls, "-friction", 0.9, "-dt", 0.001, "-tend", 0.1, "-every", 0.05)
    end, contacts = last(folder), last(folder, "contacts")
    along = (end["u"] * np.cos(angles) - end["v"] * np.sin(angles)) / 0.1
    across = end["u"] * np.sin(angles) + end["v"] * np.cos(angles)
    rolls = np.tan(angles) <= 3 * mu
    exact = np.where(rolls, 2 / 3 * G * np.sin(angles), G * (np.sin(angles) - mu * np.cos(angles)))
    turning = np.where(rolls, exact, 2 * mu * G * np.cos(angles)) / R
    np.testing.assert_allclose(along, exact, atol=1e-7)
    np.testing.assert_allclose(across, 0, atol=1e-8)
    np.testing.assert_allclose(-end["omega"] / 0.1, turning, atol=1e-5)
    np.testing.assert_allclose(end["theta"] / end["omega"], 0.5 * (0.1 + 0.001), rtol=1e-7)
    order = np.argsort(contacts["i"])
    weight = 1000 * np.pi * R**2 * G * 0.001
    assert (contacts["sliding"][order] == ~rolls).all()
    np.testing.assert_allclose(contacts["impulse"][order], weight * np.cos(angles), rtol=1e-7)
    np.testing.assert_allclose(np.abs(contacts["tangential"][order]), weight * np.where(rolls, np.sin(angles) / 3,
        mu * np.cos(angles)), rtol=1e-6)


def test_a_thrown_disk_rolls_at_two_thirds_of_its_speed(scene):
    """It slides for v0/(3 mu g), a time that steps meet to a step."""
    mu, dt = 0.3, 0.002
    folder = scene([disk(0.0, R, motion=(1.0, 0.0, 0.0))], [f"contactWallRough(contactWallSegment(-1, 0, 9, 0), {mu});"],
        "-friction", 0.8, "-dt", dt, "-tend", 0.2, "-every", dt)
    rows = read_table(folder / "particles.csv")
    slides = 1 / (3 * mu * G)
    early, late = rows["t"] < slides, rows["t"] > slides + dt
    np.testing.assert_allclose(rows["u"][early], 1 - mu * G * rows["t"][early], atol=1e-9)
    np.testing.assert_allclose(rows["u"][late], 2 / 3, atol=1e-9)
    np.testing.assert_allclose(-rows["omega"][late] * R, 2 / 3, atol=1e-9)
    assert np.abs(rows["y"] - R).max() < 1e-9 * R  # it does not leave the floor
    sliding = read_table(folder / "contacts.csv")
    assert (sliding["sliding"][sliding["t"] < slides] == 1).all() and (sliding["sliding"][sliding["t"] > slides + dt] == 0).all()


@pytest.mark.parametrize("beside", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_disk_on_a_belt_rolls_at_a_third_of_its_speed(beside, scene):
    """The wall stays where it is, its surface moves along it; beside an ellipse the disk takes the path of ellipses."""
    mu, dt, belt = 0.3, 0.002, 0.5
    folder = scene([disk(0.0, R)] + ["bodyEllipse(5, 5, 0.01, 0.005, 0, 1000);"] * beside,
        [f"contactWallGlide(contactWallRough(contactWallSegment(-1, 0, 9, 0), {mu}), {belt});"], "-friction", 0.8, "-dt", dt,
        "-tend", 0.1, "-every", dt)
    rows = read_table(folder / "particles.csv")
    own, slides = rows["id"] == 0, belt / (3 * mu * G)
    t, u, spin = rows["t"][own], rows["u"][own], rows["omega"][own] * R
    np.testing.assert_allclose(u[t < slides], mu * G * t[t < slides], atol=1e-9)
    np.testing.assert_allclose(u[t > slides + dt], belt / 3, atol=1e-9)
    np.testing.assert_allclose(spin[t > slides + dt], 2 * belt / 3, atol=1e-9)


def test_the_relaxed_law_lifts_what_slides(scene):
    """By mu dt times the speed of sliding, which the exact law does not."""
    folder = scene([disk(0.0, R, motion=(1.0, 0.0, 0.0))], ["contactWallSegment(-1, 0, 9, 0);"], "-friction", 0.3, "-friction-law",
        "relaxed", "-dt", 0.002, "-tend", 0.02, "-every", 0.002)
    assert (read_table(folder / "particles.csv")["y"].max() - R) / R > 0.01


def test_a_disk_falls_onto_an_incline(scene):
    """After the impact it rolls at once (tan a <= 3 mu), or slips: the test of SCoPI (github.com/hpc-maths/scopi,
    test/analytical_solution.cpp). Velocities to what gravity adds in two steps."""
    dt, end, height = 1e-4, 0.1, 0.01
    cases = [(np.radians(20), 0.3), (np.radians(35), 0.25), (np.radians(50), 0.2), (np.radians(30), 0.1)]
    bodies, walls = [], []
    for k, (a, mu) in enumerate(cases):
        wall, e = plane(k, a, mu)
        walls.append(wall)
        bodies.append(disk(k + 0.1 * np.cos(a) + (R + height) * e[0], -0.1 * np.sin(a) + (R + height) * e[1]))
    found = last(scene(bodies, walls, "-friction", 0.9, "-dt", dt, "-tend", end, "-every", 0.05))
    kinds = set()
    for k, (a, mu) in enumerate(cases):
        hit = np.sqrt(2 * height / (G * np.cos(a)))
        vt, vn, left = G * hit * np.sin(a), G * hit * np.cos(a), end - hit
        rolls = np.tan(a) <= 3 * mu
        kinds.add(bool(rolls))
        speed = 2 / 3 * (vt + G * np.sin(a) * left) if rolls else vt - mu * vn + G * (np.sin(a) - mu * np.cos(a)) * left
        rim = speed if rolls else 2 * mu * (vn + G * np.cos(a) * left)
        assert found["u"][k] * np.cos(a) - found["v"][k] * np.sin(a) == pytest.approx(speed, abs=2 * G * dt)
        assert -found["omega"][k] * R == pytest.approx(rim, abs=2 * G * dt)
    assert kinds == {True, False}


def test_oblique_impacts_of_two_disks(scene):
    """P_n = max(0, -v_n/W_n), P_t = clip(-v_t/W_t, +-mu P_n), W_n = 1/m_1 + 1/m_2, W_t = 3 W_n for solid disks."""
    rng = np.random.default_rng(1)
    bodies, exact, sticks = [], [], []
    for trial in range(16):
        radius, mu, angle = rng.uniform(0.005, 0.02, 2), rng.uniform(0, 1), rng.uniform(0, 2 * np.pi)
        q = rng.standard_normal((2, 3)) * [1, 1, 50]
        e = np.array([np.cos(angle), np.sin(angle)])
        t = np.array([-e[1], e[0]])
        m = 1000 * np.pi * radius**2
        vn, vt = e @ (q[0] - q[1])[:2], t @ (q[0] - q[1])[:2] - radius @ q[:, 2]
        press = max(0, -vn / (1 / m).sum())
        rub = np.clip(-vt / (3 * (1 / m).sum()), -mu * press, mu * press)
        after = q.copy()
        for k, sign in ((0, 1), (1, -1)):
            after[k, :2] += sign * (press * e + rub * t) / m[k]
            after[k, 2] -= radius[k] * rub / (m[k] * radius[k]**2 / 2)
        sticks.append(press > 0 and abs(rub) < mu * press)
        exact.append(after)
        places = np.array([[0.2 * trial, 0.0], [0.2 * trial, 0.0]])
        places[0] += e * radius.sum() * (1 + 1e-14)
        bodies += [disk(*places[k], mu, q[k], radius[k]) for k in (0, 1)]
    found = last(scene(bodies, [], "-friction", 1, "-dt", 1e-4, "-tend", 1e-4, gravity=(0.0, 0.0)))
    got = np.column_stack([found["u"], found["v"], found["omega"]]).reshape(-1, 2, 3)
    assert 1 < sum(sticks) < 8 and np.abs((got - exact) * [1, 1, 0.01]).max() < 1e-9


def test_a_pyramid_of_three_stands_or_slips(scene):
    """Equal disks stand for mu >= 2 - sqrt 3 between them and mu >= (2 - sqrt 3)/3 on the floor."""
    disks, floors = 2 - np.sqrt(3), (2 - np.sqrt(3)) / 3
    bodies, walls = [], []
    for k, (between, floor) in enumerate([(1.01 * disks, 0.5), (0.99 * disks, 0.5), (0.5, 1.01 * floors), (0.5, 0.99 * floors)]):
        walls.append(f"contactWallRough(contactWallSegment({k}, 0, {k + 0.9}, 0), {float(floor)!r});")
        bodies += [disk(k + 0.3 + x * R, y * R, between) for x, y in ((-1, 1), (1, 1), (0, 1 + np.sqrt(3)))]
    found = last(scene(bodies, walls, "-friction", 1, "-dt", 0.001, "-tend", 0.05))
    sunk = 1 + np.sqrt(3) - found["y"][2::3] / R
    assert (np.abs(sunk[[0, 2]]) < 1e-7).all() and (sunk[[1, 3]] > 1e-3).all(), sunk


def test_a_stack_of_two_rows_stays_and_a_held_disk_stops_another(scene):
    bodies = [disk(0.1 + 2 * k * R, R) for k in range(5)] + [disk(0.1 + (2 * k + 1) * R, R * (1 + np.sqrt(3))) for k in range(4)]
    a = np.radians(20)
    wall, e = plane(2, a, 0.5)
    for along, free in ((0.1, 1), (0.1 + 2.5 * R, 0)):
        bodies.append(disk(2 + along * np.cos(a) + R * e[0], -along * np.sin(a) + R * e[1], free=free))
    folder = scene(bodies, ["contactWallSegment(0, 0, 1, 0);", wall], "-friction", 0.5, "-dt", 0.001, "-tend", 0.2)
    rows, end = read_table(folder / "particles.csv"), last(folder)
    first = rows["t"] == 0
    for name in ("x", "y"):
        assert np.abs(end[name] - rows[name][first])[:9].max() < 1e-7 * R
    assert np.abs(end["theta"][:9]).max() < 1e-7
    assert np.hypot(end["x"][9] - end["x"][10], end["y"][9] - end["y"][10]) == pytest.approx(2 * R, abs=1e-8 * R)
    assert np.abs([end["u"][9], end["v"][9], end["omega"][9] * R]).max() < 1e-7
    assert (end["omega"][10], end["u"][10]) == (0, 0)


def crowd(seed, number=100):
    """Disks that fly at random in a box of 10 by 12 cells, and its walls."""
    rng = np.random.default_rng(seed)
    bodies = [disk(0.025 * (k % 10 + 0.5), 0.025 * (k // 10 + 0.5), rng.uniform(0, 1), rng.standard_normal(3) * [1, 1, 50],
        R * rng.uniform(0.7, 1.2)) for k in range(number)]
    corners = [(0, 0), (0.25, 0), (0.25, 0.3), (0, 0.3), (0, 0)]
    return bodies, [f"contactWallSegment({a}, {b}, {c}, {d});" for (a, b), (c, d) in zip(corners, corners[1:])]


@pytest.mark.parametrize("words", [(), ("-friction-law", "relaxed"), ("-friction-maxit", 20)])
def test_energy_never_rises_in_a_violent_crowd(scene, words):
    """Even where the solution of the law ends early."""
    folder = scene(*crowd(1), "-friction", 0.5, "-friction-tol", 1e-6, "-dt", 0.004, "-tend", 0.2, "-every", 0.004, *words,
        gravity=(0.0, 0.0))
    motion = read_table(folder / "motion.csv")
    energy = motion["kinetic_energy"]
    assert np.diff(energy).max() < 1e-11 * energy[0] and energy[-1] < 0.5 * energy[0]
    assert motion["worst_gap"].min() > -1e-7 * R and motion["momentum_error"].max() < 1e-9
    assert motion["contacts"].max() > 20


def test_a_run_with_friction_goes_on_bit_for_bit(scene, freefem_text):
    words = ["-friction", 0.4, "-friction-tol", 1e-6, "-dt", 0.004, "-every", 0.02, "-checkpoint", 15]
    bodies, walls = crowd(2, 60)
    assert goes_on(scene, freefem_text, bodies, walls, 0.12, *words)


def test_a_coefficient_of_0_leaves_the_tables_as_they_are(scene):
    """Byte for byte, also of walls that are rough where no disk is; a rough disk between smooth ones rubs at nothing (min)."""
    bodies, walls = crowd(3, 40)
    bodies = [line.replace("bodyRough(", "").rsplit(", ", 1)[0] + ";" for line in bodies]
    words = ["-dt", 0.004, "-tend", 0.1, "-every", 0.02]
    without = scene(bodies, walls, *words, name="without")
    zero = scene(bodies, walls, *words, "-friction", 0, "-friction-law", "relaxed", name="zero")
    rough = scene(bodies, walls, *words, "-friction-wall", 0.7, name="rough")
    for name in ("particles.csv", "contacts.csv", "walls.csv"):
        assert filecmp.cmp(without / name, zero / name, shallow=False), name
        assert filecmp.cmp(without / name, rough / name, shallow=False), name


@pytest.mark.parametrize("rule, mu", [("min", 0.1), ("max", 0.4), ("mean", 0.25), ("geometric", 0.2)])
def test_the_rule_for_the_coefficient_of_two_surfaces(scene, rule, mu):
    found = last(scene([disk(0.0, R, 0.1, (1.0, 0.0, 0.0))], ["contactWallRough(contactWallSegment(-1, 0, 9, 0), 0.4);"],
        "-friction-pair", rule, "-dt", 0.001, "-tend", 0.05))
    assert found["u"][0] == pytest.approx(1 - mu * G * 0.05, abs=1e-9)


@pytest.mark.parametrize("line, words", [
    ("bodyRough(bodyDisk(0, 0.01, 0.01, 1000), -0.1);", "particle 0 has the coefficient of friction -0.1"),
    ("bodyRough(3, 0.1);", "bodyRough"),
])
def test_bad_coefficients_are_refused(freefem_text, tmp_path, line, words):
    text = SCENE.format(bodies=line, walls="contactWallSegment(-1, 0, 9, 0);", gravity=(0.0, -G))
    done = freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and len(done.stderr.strip().splitlines()) == 1 and words in done.stderr


@pytest.mark.parametrize("words", [("-friction", -0.1), ("-friction-wall", "x"), ("-friction-law", "dry"), ("-friction-tol", 0.2),
    ("-contact-overlap", 1), ("-contact-tol", 0.1), ("-friction", 0.1, "-contact-form", "ballistic")])
def test_bad_options_are_refused(tmp_path, words):
    done = run_freefem("cases/falling_particles.edp", "-tend", 0.1, "-out", tmp_path / "run", *words, check=False)
    assert done.returncode == 3 and len(done.stderr.strip().splitlines()) == 1 and done.stderr.startswith("error: "), done.stderr


@pytest.mark.parametrize("number", [1, 5, 20])
def test_disks_that_do_not_touch_yet_may_have_friction(number, freefem, tmp_path):
    """Near ones are listed before friction begins, and none of them presses in the first steps."""
    freefem("cases/heap.edp", "-number", number, "-tend", 0.03, "-out", tmp_path / "run")
    assert read_table(tmp_path / "run/motion.csv")["t"][-1] == pytest.approx(0.03)
