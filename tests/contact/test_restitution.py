"""Collisions of disks that rebound (contacts alone)."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tests.tables import assert_refused
from tools.base.tables import read_table
from tools.peers.event_driven import Disks


def end(freefem_text, folder, bodies, *words, walls="", gravity=0.0):
    """Columns of the last rows of particles.csv, and motion.csv."""
    freefem_text(CONTACTS.format(bodies=bodies, walls=walls, gravity=gravity, more=""), "-out", folder, *words)
    table = read_table(folder / "particles.csv")
    last = table["step"] == table["step"].max()
    return {name: np.asarray(column)[last] for name, column in table.items()}, read_table(folder / "motion.csv"), table


@pytest.mark.parametrize("dt, e", [(0.004, 0.8), (0.001, 0.8), (0.004, 1)])
def test_a_ball_bounces_at_its_exact_times(dt, e, freefem_text, tmp_path):
    """From 1 m: flights of 2 v e^k/g. What is off is the first fall, g dt t/2, which is that of the time scheme. (With e = 1 the
    velocities of the steps gain what gravity adds between the collision and the middle of its step, which counted as energy from
    nothing: e was halved.)"""
    _, _, table = end(freefem_text, tmp_path / "run", "bodyDisk(0, 1.1, 0.1, 1000);", "-restitution", e, "-dt", dt, "-tend", 3,
        "-every", 0.02, "-friction", 0.3 if e == 1 else 0, walls="contactWallSegment(-10, 0, 10, 0);", gravity=-9.81)
    g = 9.81
    fall = np.sqrt(2 / g)
    speed, exact = g * fall, []
    for t in table["t"]:
        left, own = t - fall, e * speed
        while left > 2 * own / g:
            left, own = left - 2 * own / g, e * own
        exact.append(1 - g * t * t / 2 if left < 0 else own * left - g * left * left / 2)
    assert np.abs(np.array(table["y"]) - 0.1 - exact).max() < 0.51 * g * dt * fall + 1e-9


@pytest.mark.parametrize("mu, beside", [(0, ""), (0.3, ""), (0, "bodyEllipse(-69, 3, 0.2, 0.1, 0, 1000);")])
def test_what_gains_energy_far_away_changes_no_bounce(mu, beside, freefem_text, tmp_path):
    """A row of disks of several masses and coefficients is hit, by one disk after the other: its rebounds are reduced, those of a
    ball elsewhere are not. (One factor for all: the ball lost up to 0.16 m of its height within two seconds.)"""
    row = "".join(f"bodyBouncy(bodyAdd({5 + 0.2*k!r}, 0.1, 0.1, {density}, 0, 0, 0, 1), {e});" for k, (density, e)
        in enumerate([(1000, 1), (10, 0.2), (1000, 1), (10, 1), (3000, 1), (10, 0.1)]))
    row += "".join(f"bodyBouncy(bodyAdd({3 - 0.45*k!r}, 0.1, 0.1, 1000, {6 - 0.01*k}, 0, 0, 1), 1);" for k in range(6))
    heights = []
    for name, more in (("alone", ""), ("both", row)):
        _, _, table = end(freefem_text, tmp_path / name, "bodyBouncy(bodyDisk(-60, 1.1, 0.1, 1000), 0.9);" + more + beside,
            "-restitution", 1, "-friction", mu, "-dt", 0.01, "-tend", 2, "-every", 0.02, gravity=-9.81,
            walls="contactWallSegment(-100, 0, 30, 0); contactWallSegment(7, 0, 7, 3);")
        heights.append(np.array(table["y"])[np.array(table["id"]) == min(table["id"])])
    assert np.abs(heights[1] - heights[0]).max() < 1e-7


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("angle", [0.0, 0.4, 1.2])
def test_oblique_impacts_of_two_disks(angle, e, freefem_text, tmp_path):
    """Normal velocities by e and the masses, tangential ones unchanged (no friction), normals as at the start of the step."""
    masses, dt = np.array([1000.0, 2500.0]) * np.pi * 0.01, 1e-4
    n = np.array([np.cos(angle), np.sin(angle)])
    far = (0.2 + 1e-5) * n
    before = np.array([[1.0, 0.2], [-0.3, 0.5]])
    bodies = f"bodyAdd(0, 0, 0.1, 1000, 1, 0.2, 0, 1); bodyAdd({far[0]:.17g}, {far[1]:.17g}, 0.1, 2500, -0.3, 0.5, 0, 1);"
    last, _, _ = end(freefem_text, tmp_path / "run", bodies, "-restitution", e, "-dt", dt, "-tend", dt)
    closing = (before[0] - before[1]) @ n
    impulse = (1 + e) * closing / (1 / masses).sum() if e else (closing - 1e-5 / dt) / (1 / masses).sum()
    after = before + np.array([[-1], [1]]) * impulse / masses[:, None] * n
    np.testing.assert_allclose(np.column_stack([last["u"], last["v"]]), after, atol=1e-9)


@pytest.mark.parametrize("e, beside, more", [(0.4, "", ""), (1, "", ""), (0.4, "bodyEllipse(5, 5, 0.02, 0.01, 0, 1000);", ""),
    (1, "bodyCapsule(5, 5, 0.02, 0.01, 0, 1000);", 'include "lib/case.idp"\ninclude "lib/bodies/shapes.idp"')])
def test_rough_disks_that_rebound_are_hit_where_they_touch(e, beside, more, freefem_text, tmp_path):
    """Four disks that spin hit a wall, and two each other, steps of up to a third of a radius: closed forms, and angular momentum.
    (The friction of a collision acted in the middle of the gap before the step: rotations were off by up to a third.)"""
    r, mu, density = 0.013, 0.3, 1000.0
    walls = np.array([[1.0, -1.3, 0.0], [0.5, -1.3, 20.0], [-2.0, -1.1, 30.0], [0.7, -1.2, -10.0]])
    pair, radii = np.array([[1.0, 0.0, 30.0], [-1.0, 0.0, -20.0]]), np.array([0.01, 0.017])
    places = np.vstack([np.column_stack([np.arange(4.0), np.full(4, r + 0.05)]), [[-2.05, 0.3], [-1.95, 0.3]]])
    before, radius = np.vstack([walls, pair]), np.concatenate([np.full(4, r), radii])
    bodies = "".join(f"bodyAdd({x!r}, {y!r}, {size!r}, {density}, {u!r}, {v!r}, {w!r}, 1);" for (x, y), size, (u, v, w)
        in zip(places.tolist(), radius.tolist(), before.tolist())) + beside

    def run(text, *words):
        return freefem_text(text.replace("optCase", more + "\noptCase", 1), *words)

    last, _, _ = end(run, tmp_path / "run", bodies, "-restitution", e, "-friction", mu, "-dt", 0.0031, "-tend", 0.062,
        walls="contactWallSegment(-10, 0, 10, 0);")
    found, mass = np.column_stack([last["u"], last["v"], last["omega"]])[:6], density * np.pi * radius**2
    exact = before.copy()
    slide, press = walls[:, 0] + r * walls[:, 2], -(1 + e) * walls[:, 1]
    rub = -np.clip(slide / 3, -mu * press, mu * press)
    exact[:4] += np.column_stack([rub, press, 2 * rub / r])
    weights = (1 / mass[4:]).sum()
    press = (1 + e) * 2.0 / weights
    rub = np.clip(radii @ pair[:, 2] / (3 * weights), -mu * press, mu * press)  # at rest across: rims alone slide
    exact[4:] += np.array([[-press, -rub], [press, rub]]) @ np.eye(2, 3) / mass[4:, None]
    exact[4:, 2] -= 2 * rub / (mass[4:] * radii)
    assert np.abs((found - exact) * [1, 1, 0.01]).max() < 1e-9
    spin = [(mass[4:] * (x * q[:, 1] - y * q[:, 0] + radii**2 / 2 * q[:, 2])).sum() for x, y, q in (
        (*places[4:].T, pair), (np.array(last["x"])[4:6], np.array(last["y"])[4:6], found[4:]))]
    assert spin[1] == pytest.approx(spin[0], rel=1e-8)


def test_a_row_of_disks_keeps_its_energy_and_momentum(freefem_text, tmp_path):
    row = "bodyAdd(-1, 0, 0.1, 1000, 1, 0, 0, 1); for (int k = 0; k < 4; ++k) bodyAdd(0.2*k, 0, 0.1, 1000, 0, 0, 0, 1);"
    _, motion, _ = end(freefem_text, tmp_path / "run", row, "-restitution", 1, "-dt", 0.01, "-tend", 1, "-every", 0.1)
    assert motion["kinetic_energy"] == pytest.approx([motion["kinetic_energy"][0]] * len(motion["t"]), rel=1e-8)
    assert motion["momentum_x"] == pytest.approx([motion["momentum_x"][0]] * len(motion["t"]), rel=1e-12)


def scene(x, v, r):
    """The words that add disks of the density 1000."""
    return "{" + "".join(f"bodyAdd({a:.15g}, {b:.15g}, {c:.15g}, 1000, {p:.15g}, {q:.15g}, 0, 1);"
        for (a, b), (p, q), c in zip(x, v, r)) + "}"


def test_a_row_meets_a_wall_as_by_events(freefem_text, tmp_path):
    """Six disks of several masses with gaps of many steps, one behind the other: each collision is exact."""
    r = np.array([0.1, 0.13, 0.09, 0.12, 0.1, 0.11])
    x = np.column_stack([np.cumsum(2 * r) + np.cumsum([0.05, 0.031, 0.043, 0.027, 0.039, 0.033]) - r, np.full(6, 0.5)])
    v = np.column_stack([np.full(6, -1.0), np.zeros(6)])
    e = 0.8
    exact = Disks(x, v, r, e, box=(0.0, 9.0, -9.0, 9.0))
    assert exact.advance(0.2) > 6
    last, _, _ = end(freefem_text, tmp_path / "run", scene(x, v, r), "-restitution", e, "-dt", 5e-4, "-tend", 0.2, "-every", 0.1,
        walls="contactWallSegment(0, -1, 0, 1);")
    np.testing.assert_allclose(last["u"], exact.v[:, 0], atol=1e-9)
    np.testing.assert_allclose(last["x"], exact.x[:, 0], atol=1e-6)


def test_a_crowd_loses_its_energy_as_by_events(freefem_text, tmp_path):
    """A hundred disks that cover half of a box, most of which collide with several others in a step."""
    rng = np.random.default_rng(1)
    r = 0.01 * rng.uniform(0.9, 1.1, 100)
    side = np.sqrt(np.pi * (r**2).sum() / 0.5)
    x = (np.stack(np.meshgrid(np.arange(10), np.arange(10)), -1).reshape(-1, 2) + 0.5) * side / 10
    v = rng.normal(0, 1, (100, 2))
    exact, times = Disks(x, v, r, 0.5, box=(0.0, side, 0.0, side)), (0.01, 0.02, 0.03)
    energies = [exact.energy()]
    for t in times:
        exact.advance(t)
        energies.append(exact.energy())
    walls = "".join("contactWallSegment({:.15g}, {:.15g}, {:.15g}, {:.15g});".format(*(side * np.array(ends)))
        for ends in ((0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0)))
    _, motion, _ = end(freefem_text, tmp_path / "run", scene(x, v, r), "-restitution", 0.5, "-dt", 2.5e-4, "-tend", times[-1],
        "-every", times[0], walls=walls)
    shares = np.array(motion["kinetic_energy"]) / motion["kinetic_energy"][0]
    np.testing.assert_allclose(shares, np.array(energies) / energies[0], rtol=0.05)
    assert shares[-1] < 0.2


@pytest.mark.parametrize("friction", [0, 0.4])
def test_no_energy_is_gained_in_a_crowd(friction, freefem_text, tmp_path):
    """Of disks and walls with coefficients of their own, which Newton's law alone may let gain some."""
    rng = np.random.default_rng(5)
    bodies = "".join(f"bodyBouncy(bodyAdd({x:.4f}, {y:.4f}, 0.1, {rng.uniform(500, 4000):.1f}, {u:.3f}, {v:.3f}, 0, 1), "
        f"{rng.uniform(0, 1):.3f});" for x in np.arange(0.15, 1.9, 0.22) for y in np.arange(0.15, 1.9, 0.22)
        for u, v in [rng.normal(0, 3, 2)])
    walls = "contactWallSegment(0, 0, 2, 0); contactWallSegment(2, 0, 2, 2); contactWallSegment(2, 2, 0, 2);" \
        "contactWallBouncy(contactWallSegment(0, 2, 0, 0), 1);"
    _, motion, _ = end(freefem_text, tmp_path / "run", "{" + bodies + "}", "-restitution", 0.9, "-friction", friction, "-dt", 0.004,
        "-tend", 0.2, "-every", 0.004, walls=walls)
    energy = np.array(motion["kinetic_energy"])
    assert (np.diff(energy) < 1e-9 * energy[0]).all() and energy[-1] > 0.01 * energy[0]
    assert min(motion["worst_gap"]) > -1e-8


def test_slow_contacts_do_not_rebound(freefem_text, tmp_path):
    """Below -restitution-speed; by default twice what gravity adds in a step, so that disks come to rest."""
    last, motion, _ = end(freefem_text, tmp_path / "run", "bodyDisk(0, 0.3, 0.1, 1000);", "-restitution", 0.5, "-dt", 0.002,
        "-tend", 2,
        "-every", 0.1, walls="contactWallSegment(-10, 0, 10, 0);", gravity=-9.81)
    assert motion["kinetic_energy"][-1] < 1e-12 and last["y"][0] == pytest.approx(0.1, abs=1e-8)
    last, _, _ = end(freefem_text, tmp_path / "slow", "bodyAdd(0, 0.11, 0.1, 1000, 0, -0.5, 0, 1);", "-restitution", 0.5, "-dt",
        0.002,
        "-tend", 0.1, "-restitution-speed", 0.6, walls="contactWallSegment(-10, 0, 10, 0);")
    assert last["v"][0] == pytest.approx(0, abs=1e-8)


@pytest.mark.parametrize("words, says", [
    (["-restitution", 1.1], "restitution"), (["-restitution", -0.1], "restitution"),
    (["-restitution", 0.5, "-contact-form", "ballistic"], "restitution takes -contact-form linear"),
    (["-friction", 0.5, "-contact-form", "ballistic"], "friction takes -contact-form linear"),
    (["-friction", -0.5], "friction"), (["-friction", "nan"], "friction"),
])
def test_what_makes_no_law_is_refused(words, says, freefem_text, tmp_path):
    done = freefem_text(CONTACTS.format(bodies="bodyDisk(0, 1, 0.1, 1000);", walls="contactWallSegment(-1, 0, 1, 0);", gravity=-1,
        more=""),
        "-out", tmp_path / "run", *words, check=False)
    assert_refused(done, [3], says)
