"""Ellipses and bodies of any shape that rebound in contacts alone, by Poisson's law."""
import numpy as np
import pytest

from tests.contact.shapes import moments, polygon, scene_text
from tests.friction import SCENE, poisson
from tools.base.tables import read_table

FLOOR, COUNT = "contactWallSegment(-10, 0, 50, 0);", 12


def cases(seed):
    """Rows (angle, u, v, omega, mu, e) of oblique impacts."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(0.1, 1.4, COUNT), rng.uniform(-2, 2, COUNT), rng.uniform(-3, -2, COUNT),
        rng.uniform(-4, 4, COUNT), rng.choice([0, 0.2, 1], COUNT), rng.choice([0.3, 0.7, 1], COUNT)])


def judged(folder, one, arms, masses, arm2, tol):
    """Velocities in closed form, and none that gains energy."""
    rows = read_table(folder / "particles.csv")
    last = rows["step"] == rows["step"].max()
    found = np.column_stack([rows[key][last] for key in ("u", "v", "omega")])
    for k, (angle, u, v, omega, mu, e) in enumerate(one):
        after, share = poisson(masses[k], masses[k] * arm2[k], arms[k], np.array([u, v, omega]), mu, e)
        assert found[k] == pytest.approx(after, abs=tol) and share < 1 + 1e-12
        energy = masses[k] * np.array([1, 1, arm2[k]]) @ (found[k] ** 2 - [u**2, v**2, omega**2])
        assert energy < 1e-7 * masses[k] * (u**2 + v**2)


WORDS = ["-restitution-wall", 1, "-friction-wall", 1, "-friction-tol", 1e-12, "-contact-tol", 1e-12, "-dt", 1e-5, "-tend", 1e-5]


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_oblique_impacts_of_ellipses(seed, freefem_text, tmp_path):
    """Twelve far from each other, with coefficients of their own."""
    a, b, one = 0.1, 0.05, cases(seed)
    height = np.hypot(a * np.sin(one[:, 0]), b * np.cos(one[:, 0]))
    lever = -(a**2 - b**2) * np.sin(one[:, 0]) * np.cos(one[:, 0]) / height
    bodies = "".join(f"bodyBouncy(bodyRough(bodyEllipse({k}, {height[k] + 1e-8:.17g}, {a}, {b}, {row[0]:.17g}, 1000), {row[4]}), "
        f"{row[5]});" for k, row in enumerate(one))
    motion = ", ".join(f"{value:.17g}" for value in one[:, 1:4].T.ravel())
    text = SCENE.format(bodies=bodies + f"bodyQ = [{motion}];", walls=FLOOR, gravity=(0.0, 0.0))
    freefem_text(text.replace('optDefault("-friction-tol", "1e-12"); optDefault("-contact-tol", "1e-12");', ""), *WORDS, "-out",
        tmp_path / "run")
    mass = np.full(COUNT, 1000 * np.pi * a * b)
    judged(tmp_path / "run", one, np.column_stack([lever, -height]), mass, np.full(COUNT, (a**2 + b**2) / 4), 1e-4)


@pytest.mark.parametrize("seed", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_oblique_impacts_of_polygons(seed, freefem_text, tmp_path):
    one, radius = cases(seed), 0.02
    bodies, arms, masses, arm2 = [], [], [], []
    for k, (angle, u, v, omega, mu, e) in enumerate(one):
        around = angle + 2 * np.pi / (3 + k % 3) * np.arange(3 + k % 3)
        corners = 0.13 * np.column_stack([np.cos(around), np.sin(around)])
        area, _, _, moment = moments([(1, corners, radius)])
        put = polygon(corners + [k, 1e-8 + radius - corners[:, 1].min()], radius, mu=mu, motion=(u, v, omega))
        bodies.append(put.replace("bodyRough(", "bodyBouncy(bodyRough(").rstrip(";") + f", {e});")
        arms.append(corners[corners[:, 1].argmin()] - [0, radius])
        masses.append(1000 * area)
        arm2.append(moment / area)
    freefem_text(scene_text(bodies, [FLOOR], (0.0, 0.0)), *WORDS, "-out", tmp_path / "run")
    judged(tmp_path / "run", one, arms, masses, arm2, 1e-4)


@pytest.mark.parametrize("mu", [0.5, pytest.param(0, marks=pytest.mark.slow)])
def test_no_energy_is_gained_in_a_crowd_of_ellipses(mu, freefem_text, tmp_path):
    """Sixteen in a box, with coefficients of 0.3 and 0.95 at random."""
    rng, bodies = np.random.default_rng(7), ""
    for k in range(16):
        bodies += (f"bodyBouncy(bodyEllipse({k % 4 * 1.1 + 0.55}, {k // 4 * 1.1 + 0.55}, 0.4, {rng.uniform(0.15, 0.4)}, "
            f"{rng.uniform(0, 3)}, {rng.uniform(500, 3000)}), {rng.choice([0.3, 0.95])});")
    bodies += f"bodyQ = [{', '.join(f'{value:.17g}' for value in rng.normal(0, 5, 48))}];"
    walls = "".join(f"contactWallSegment({a}, {b}, {c}, {d});" for a, b, c, d in ((0, 0, 4.4, 0), (4.4, 0, 4.4, 4.4), (4.4, 4.4, 0,
        4.4), (0, 4.4, 0, 0)))
    freefem_text(SCENE.format(bodies=bodies, walls=walls, gravity=(0.0, 0.0)), "-restitution", 1, "-friction", mu, "-dt", 0.004,
        "-tend", 0.3, "-every", 0.004, "-out", tmp_path / "run")
    motion = read_table(tmp_path / "run" / "motion.csv")
    energy = motion["kinetic_energy"]
    assert np.diff(energy).max() < 1e-6 * energy[0] and 0.1 * energy[0] < energy[-1] < 0.8 * energy[0]
    assert motion["worst_gap"].min() > -1e-7 and motion["contacts"].sum() > 20
    assert motion["momentum_error"].max() < 1e-10 * np.hypot(motion["momentum_x"], motion["momentum_y"]).max()


def test_a_square_bounces_on_its_face_at_its_exact_times(freefem_text, tmp_path):
    """With e = 0.8, as a ball (tests/contact/test_restitution.py), and hardly turning; then it rests on its face. (What rounding
    turns grows from bounce to bounce, to 2e-4 in the last ones.) The floor's impulses are all of the momentum that its weight does
    not give."""
    dt, g, e, fall = 0.01, 9.81, 0.8, np.sqrt(2 / 9.81)
    text = scene_text([polygon([[0, 1.01], [0.2, 1.01], [0.2, 1.2], [0, 1.2]], 0.01)], [FLOOR], (0.0, -g))
    freefem_text(text, "-restitution", e, "-dt", dt, "-tend", 4.4, "-every", 0.02, "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run" / "particles.csv")
    exact, early = [], rows["t"] < 3
    for t in rows["t"][early]:
        left, own = t - fall, e * g * fall
        while left > 2 * own / g:
            left, own = left - 2 * own / g, e * own
        exact.append(1 - g * t * t / 2 if left < 0 else own * left - g * left * left / 2)
    assert np.abs(rows["y"][early] - rows["y"][0] + 1 - exact).max() < 0.51 * g * dt * fall + 1e-9
    assert np.abs(rows["theta"][early]).max() < 1e-6 and np.abs(rows["theta"]).max() < 1e-3
    assert np.abs(rows["theta"][-10:]).max() < 1e-9 and np.abs(rows["v"][-10:]).max() < 1e-9
    motion = read_table(tmp_path / "run" / "motion.csv")
    assert motion["momentum_error"].max() < 1e-10 * np.abs(motion["momentum_y"]).max()
