"""Restitution of spheres, in contacts alone and in a fluid: bounces at their exact times, oblique collisions, friction, crowds."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tools.base.tables import read_table

CASE = """
include "lib/spheres/case.idp"
optCase("bounce", "spheres that rebound");
optDefault("-friction", "0");
real gravityX = 0, gravityY = 0, gravityZ = optReal("-g", -9.81, "m/s2", "gravity");
real[int] corner = [-5, -5, 0], side = [10, 0, 0], other = [0, 10, 0];
macro caseWalls() sphereWall(corner, side, other); // EOM
macro caseParticles() SPHERES // EOM
include "scripts/contact_spheres.edp"
"""


def test_a_sphere_bounces_at_its_exact_times(freefem_text, tmp_path):
    """Dropped from 1 m with a coefficient of 0.8: apices of 0.64 and 0.41 m after t1 (1 + 2 * 0.8 ...), t1 the time of the fall; a
    step is 0.002 s."""
    freefem_text(CASE.replace("SPHERES", "bodySphere(0, 0, 1.1, 0.1, 1000);"), "-restitution", 0.8, "-dt", 0.002, "-tend", 1.7,
        "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run/particles.csv")
    t, z, fall = rows["t"], rows["z"] - 0.1, np.sqrt(2 / 9.81)
    top = [k for k in range(1, len(z) - 1) if z[k - 1] < z[k] >= z[k + 1]]
    assert t[top] == pytest.approx([fall * (1 + 0.8), fall * (1 + 1.6 + 0.64)], abs=0.006)
    assert z[top] == pytest.approx([0.64, 0.4096], rel=0.015) and z.min() > -1e-9


@pytest.mark.parametrize("bounce", [0.5, pytest.param(1, marks=pytest.mark.slow)])
def test_spheres_that_meet_aslant_part_with_their_coefficient(bounce, freefem_text, tmp_path):
    """Unequal ones: the normal velocity turns round with the coefficient, the tangential one stays, and so does the momentum."""
    two = "sphereMoves(bodySphere(0, 0, 1, 0.1, 1000), 3, 0, 0); sphereMoves(bodySphere(0.5, 0.1, 1, 0.15, 3000), -1, 0, 0);"
    freefem_text(CASE.replace("SPHERES", two), "-g", 0, "-restitution", bounce, "-tend", 0.2, "-out", tmp_path / "run")
    rows, touch = read_table(tmp_path / "run/particles.csv"), read_table(tmp_path / "run/contacts.csv")
    mass = np.array([1000 * 0.1**3, 3000 * 0.15**3]) * 4 / 3 * np.pi
    n = np.array([touch["nx"][0], touch["ny"][0], touch["nz"][0]])
    last = np.array([rows[name][-2:] for name in "uvw"]).T
    assert last[0] @ n - last[1] @ n == pytest.approx(-bounce * (4 * n[0]), rel=1e-9)
    assert last[0] - last[1] - n * (last[0] @ n - last[1] @ n) == pytest.approx([4, 0, 0] - 4 * n[0] * n, abs=1e-9)
    assert mass @ last == pytest.approx([3 * mass[0] - mass[1], 0, 0], abs=1e-9)
    assert touch["impulse"] == pytest.approx([-(1 + bounce) * 4 * n[0] / (1 / mass).sum()], rel=1e-9)


def test_a_crowd_that_rebounds_gains_no_energy_and_does_not_overlap(freefem, tmp_path):
    kept = []
    for bounce in (0.5, 1):
        freefem("cases/falling_spheres.edp", "-number", 40, "-friction", 0, "-restitution", bounce, "-tend", 0.4, "-out",
            tmp_path / f"run{bounce}")
        rows = read_table(tmp_path / f"run{bounce}/motion.csv")
        energy = rows["kinetic_energy"] + rows["potential_energy"]
        assert energy.max() < energy[0] + 0.01 * rows["kinetic_energy"].max() and rows["worst_gap"].min() > -1e-9
        kept.append(energy[-1] / energy[0])
    assert kept[0] < 0.98 * kept[1]


def velocities(rows, number, row=-1):
    """Velocities and angular velocities (number x 3 each) in one row of particles.csv."""
    names = ("u", "v", "w"), ("omega_x", "omega_y", "omega_z")
    return [np.array([rows[name].reshape(-1, number)[row] for name in three]).T for three in names]


def parted(mass, radius, velocity, spin, n, bounce, rough):
    """Velocities, angular velocities and friction behind one impact of two spheres (the second may be a wall, of infinite mass)
    with the normal n at the first: Newton's coefficient, Coulomb's law, moments of 2/5 m R^2."""
    reduced, arms = 1 / (1 / mass).sum(), radius @ spin
    slip = velocity[0] - velocity[1] + np.cross(n, arms)
    normal = slip @ n
    slip = slip - normal * n
    press = -(1 + bounce) * normal * reduced
    rub = -slip * min(2 / 7 * reduced, rough * press / np.linalg.norm(slip))
    after = velocity + np.outer([1, -1], press * n + rub) / mass[:, None]
    turned = spin - np.outer(radius, np.cross(n, rub)) / (0.4 * mass * np.maximum(radius, 1e-30) ** 2)[:, None]
    return after, turned, rub


@pytest.mark.parametrize("bounce, rough, speed, spin", [(0.7, 0.1, (1.5, -0.8, -1.3), (4, -9, 12)), (0.7, 0.8, (1.5, -0.8, -1.3),
    (4, -9, 12)), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((1, 0.3, (-1, 0.2, -2), (-15, 20, 5)),
        (0.3, 0.1, (0.5, 2, -0.6), (0, 18, -3)), (1, 0.05, (0.1, 0, -1), (0, -20, 0))))])
def test_a_spinning_sphere_that_hits_a_floor_aslant_has_its_exact_velocities(bounce, rough, speed, spin, freefem_text, tmp_path):
    """Sliding and sticking ones, also with topspin, that is, backwards."""
    text = CASE.replace("SPHERES", "sphereSpins(sphereMoves(bodySphere(0, 0, 0.15, 0.1, 1000), "
        f"{speed[0]}, {speed[1]}, {speed[2]}), {spin[0]}, {spin[1]}, {spin[2]});")
    freefem_text(text, "-g", 0, "-restitution", bounce, "-friction", rough, "-dt", 0.003, "-tend", 0.12, "-out", tmp_path / "run")
    mass = np.array([1000 * 4 / 3 * np.pi * 0.1**3, 1e30])
    after, turned, rub = parted(mass, np.array([0.1, 0]), np.array([speed, (0, 0, 0)]), np.array([spin, (0, 0, 0)]),
        np.array([0, 0, 1]), bounce, rough)
    found, touch = velocities(read_table(tmp_path / "run/particles.csv"), 1), read_table(tmp_path / "run/contacts.csv")
    assert found[0][0] == pytest.approx(after[0], abs=1e-7) and found[1][0] == pytest.approx(turned[0], abs=1e-6)
    assert [touch[name][0] for name in ("fx", "fy", "fz")] == pytest.approx(rub, abs=1e-7 * mass[0])


def test_spheres_that_rub_and_rebound_have_their_exact_velocities(freefem_text, tmp_path):
    two = ("sphereSpins(sphereMoves(bodySphere(0, 0, 1, 0.1, 1000), 3, 0, 0), 5, 8, 20);"
        "sphereSpins(sphereMoves(bodySphere(0.5, 0.1, 1, 0.15, 3000), -1, 0, 0.5), 0, -10, 4);")
    freefem_text(CASE.replace("SPHERES", two), "-g", 0, "-restitution", 0.6, "-friction", 0.4, "-tend", 0.2, "-out",
        tmp_path / "run")
    rows, touch = read_table(tmp_path / "run/particles.csv"), read_table(tmp_path / "run/contacts.csv")
    radius = np.array([0.1, 0.15])
    mass, n = np.array([1000, 3000]) * 4 / 3 * np.pi * radius**3, np.array([touch[name][0] for name in ("nx", "ny", "nz")])
    after, turned, _ = parted(mass, radius, *velocities(rows, 2, 0), n, 0.6, 0.4)
    found = velocities(rows, 2)
    assert found[0] == pytest.approx(after, abs=1e-7) and found[1] == pytest.approx(turned, abs=1e-6)


def test_a_sphere_without_loss_keeps_its_height_at_a_long_step(freefem_text, tmp_path):
    """Six bounces with a coefficient of 1 from 1 m, at steps of 0.01 s: apices of 1 m."""
    freefem_text(CASE.replace("SPHERES", "bodySphere(0, 0, 1.1, 0.1, 1000);"), "-restitution", 1, "-dt", 0.01, "-tend", 6, "-out",
        tmp_path / "run")
    z = read_table(tmp_path / "run/particles.csv")["z"] - 0.1
    top = [z[k] for k in range(1, len(z) - 1) if z[k - 1] < z[k] >= z[k + 1]]
    assert len(top) == 6 and top == pytest.approx([1] * 6, abs=1e-3)


@pytest.mark.slow
def test_a_ball_that_bounces_and_spins_rolls_away(freefem_text, tmp_path):
    """Whatever the bounces, the angular momentum about the floor stays: it rolls with 5/7 of the velocity and 2/7 of the spin."""
    text = CASE.replace("SPHERES", "sphereSpins(sphereMoves(bodySphere(-4, 0, 0.6, 0.1, 1000), 1, 0.5, 0), 0, -10, 3);")
    freefem_text(text, "-restitution", 0.7, "-friction", 0.3, "-dt", 0.004, "-tend", 5, "-out", tmp_path / "run")
    (found,), (spin,) = velocities(read_table(tmp_path / "run/particles.csv"), 1)
    exact = 5 / 7 * np.array([1, 0.5, 0]) + 2 / 7 * 0.1 * np.array([-10, 0, 0])
    assert found == pytest.approx(exact, abs=1e-5) and spin == pytest.approx([-exact[1] / 0.1, exact[0] / 0.1, 3], abs=1e-4)


def test_a_sphere_that_is_moved_sends_another_off(freefem_text, tmp_path):
    """A sphere of prescribed velocity 1 m/s meets one at rest: 1 + e times its velocity, for any e."""
    two = "sphereHeld(sphereMoves(bodySphere(0, 0, 1, 0.1, 1000), 1, 0, 0)); bodySphere(0.25, 0, 1, 0.1, 1000);"
    freefem_text(CASE.replace("SPHERES", two), "-g", 0, "-restitution", 0.5, "-tend", 0.1, "-out", tmp_path / "run")
    assert velocities(read_table(tmp_path / "run/particles.csv"), 2)[0][1] == pytest.approx([1.5, 0, 0], abs=1e-9)


BOX = """{ real[int] o = [0, 0, 0], p = [1, 1, 1], a = [1, 0, 0], b = [0, 1, 0], c = [0, 0, 1]; sphereWall(o, a, b);
sphereWall(o, a, c); sphereWall(o, b, c); a *= -1.; b *= -1.; c *= -1.; sphereWall(p, a, b); sphereWall(p, a, c);
sphereWall(p, b, c); }"""


def crowd(number, radius, seed):
    draw, side, text = np.random.default_rng(seed), int(np.ceil(number ** (1 / 3))), ""
    for k in range(number):
        at = (np.array([k % side, k // side % side, k // side**2]) + 0.5) / side
        at += (0.5 / side - 1.001 * radius) * draw.uniform(-1, 1, 3)
        words = [", ".join(f"{value:.9f}" for value in row) for row in (at, draw.normal(size=3), 5 * draw.normal(size=3))]
        size = radius * draw.uniform(0.5, 1)
        text += f"sphereSpins(sphereMoves(bodySphere({words[0]}, {size:.9f}, 1000), {words[1]}), {words[2]});"
    return text


@pytest.mark.parametrize("number, bounce, rough, step, end", [(20, 1, 0.3, 0.01, 0.2), *(pytest.param(50, bounce, rough, step, 0.8,
    marks=pytest.mark.slow) for bounce, rough, step in ((1, 0, 0.004), (1, 0.3, 0.02), (1, 1, 0.004), (0.6, 0.3, 0.004)))])
def test_the_energy_of_a_crowd_that_rubs_and_rebounds_never_rises(number, bounce, rough, step, end, freefem_text, tmp_path):
    """Without weight, of motion and rotation together; half of the frictionless one's is there at the end at least."""
    text = CASE.replace("sphereWall(corner, side, other);", BOX.replace("\n", " ")).replace("SPHERES", crowd(number, 0.125, 1))
    freefem_text(text, "-g", 0, "-restitution", bounce, "-friction", rough, "-dt", step, "-tend", end, "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run/motion.csv")
    energy = rows["kinetic_energy"]
    assert np.diff(energy).max() <= 1e-9 * energy[0] and rows["worst_gap"].min() > -1e-9
    assert energy[-1] > 0.5 * energy[0] if bounce == 1 and rough == 0 else energy[-1] < 0.9 * energy[0]


def test_the_relaxed_law_does_not_go_with_rebounds(freefem, tmp_path):
    run = freefem("cases/falling_spheres.edp", "-restitution", 0.5, "-friction-law", "relaxed", "-out", tmp_path / "run",
        check=False)
    assert run.returncode == 3 and "coulomb" in run.stderr and run.stderr.count("\n") == 1


FLUID = """
include "lib/spheres/case.idp"
optCase("hit", "spheres that rebound in a fluid");
optDefault("-dt", "0.001"); optDefault("-cfl", "0");
real rhoFluid = optReal("-rhof", 960, "kg/m3", "density"), mu = optReal("-mu", 0.058, "Pa s", "viscosity"), R = 0.0075;
real gravityX = 0, gravityY = 0, gravityZ = optReal("-g", 0, "m/s2", "gravity");
int[int] flowNoSlip = [labelWall], flowSlip(0), flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() SPHERES // EOM
include "scripts/spheres.edp"
"""
PAIR = "sphereMoves(bodySphere(-0.009, 0.001, 0.03, R, 2500), 0.3, 0, 0); bodySphere(0.009, -0.001, 0.03, R, 2500);"


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A closed box of 60 x 60 x 60 mm, 3 elements to the diameter of a sphere of 15 mm."""
    return make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "settling_sphere", "--part", "whole", "--width", 0.06, "--height",
        0.06, "--corridor-top", 0.06, "--corridor", 0.0135, "--coarse", 3, "--size", 0.005)


def test_spheres_that_meet_in_a_fluid_part_with_their_coefficient(box, freefem_text, tmp_path):
    """In a liquid the normal velocity turns round in one step, and stays so in the next: with e = 0.8 and 0.4 it differs by 0.4
    times the speed of approach. What two alike have together does not jump. A restart goes on byte for byte."""
    text, parting = FLUID.replace("SPHERES", PAIR), []
    options = ["-mesh", box, "-tend", 0.016, "-checkpoint", 5]
    for bounce in (0.4, 0.8):
        run = tmp_path / f"run{bounce}"
        freefem_text(text, *options, "-restitution", bounce, "-out", run)
        rows, touch = read_table(run / "particles.csv"), read_table(run / "contacts.csv")
        assert len(touch["t"]) == 1
        n = np.array([touch["nx"][0], touch["ny"][0], touch["nz"][0]])
        velocity = np.array([rows[name] for name in "uvw"]).T.reshape(-1, 2, 3)
        apart, both = (velocity[:, 0] - velocity[:, 1]) @ n, velocity[:, :, 0].sum(axis=1)
        hit = np.flatnonzero(rows["t"][::2] == touch["t"][0])[0]
        assert apart[hit + 2] == pytest.approx(apart[hit], rel=0.05) and both[hit] == pytest.approx(both[hit - 1], rel=0.02)
        parting.append(apart[hit])
    speed = (parting[1] - parting[0]) / 0.4
    assert speed == pytest.approx(-apart[hit - 1], rel=0.05) and parting[1] == pytest.approx(0.8 * speed, rel=0.03)
    whole = (run / "particles.csv").read_text().splitlines()
    for part in run.glob(sorted(run.glob("restart_*.sha"))[-1].stem + ".*"):
        part.unlink()
    freefem_text(text, *options, "-restitution", 0.8, "-restart", run, "-out", tmp_path / "again")
    again = (tmp_path / "again/particles.csv").read_text().splitlines()[1:]
    assert again and again == whole[-len(again):]


@pytest.mark.slow
def test_a_sphere_bounces_in_a_thin_gas_as_without_one(box, freefem_text, tmp_path):
    """A coefficient of 0.8 from 22.5 mm: apices of 0.64 and 0.41 of it, at steps that gravity makes 0.01 m/s faster."""
    freefem_text(FLUID.replace("SPHERES", "bodySphere(0.001, 0, 0.03, R, 2500);"), "-mesh", box, "-rhof", 1.2, "-mu", 1.8e-5, "-g",
        -9.81, "-restitution", 0.8, "-tend", 0.25, "-out", tmp_path / "run")
    z = read_table(tmp_path / "run/particles.csv")["z"] - 0.0075
    top = [z[k] for k in range(1, len(z) - 1) if z[k - 1] < z[k] >= z[k + 1]]
    assert top == pytest.approx([0.64 * 0.0225, 0.4096 * 0.0225], rel=0.04) and z.min() > -1e-9


@pytest.mark.parametrize("rough, place", [(0.5, 0.003), *(pytest.param(*row, marks=pytest.mark.slow) for row in ((0.1, 0.003),
    (0.5, 0), (0.1, 0.0015)))])
def test_a_spinning_sphere_rubs_in_a_thin_gas_as_without_one(rough, place, box, freefem_text, tmp_path):
    """Also where sphere and floor enclose a vertex of the mesh, whose equation held the sphere before: it went off sideways."""
    speed, spin = (0.3, 0.1, -0.3), (5, 10, 20)
    text = FLUID.replace("SPHERES", f"sphereSpins(sphereMoves(bodySphere({place}, {place / 3}, 0.008, R, 2500), 0.3, 0.1, -0.3), "
        "5, 10, 20);")
    freefem_text(text, "-mesh", box, "-rhof", 1.2, "-mu", 1.8e-5, "-restitution", 0.8, "-friction", rough, "-tend", 0.004, "-out",
        tmp_path / "run")
    mass = np.array([2500 * 4 / 3 * np.pi * 0.0075**3, 1e30])
    after, turned, rub = parted(mass, np.array([0.0075, 0]), np.array([speed, (0, 0, 0)]), np.array([spin, (0, 0, 0)]), np.array([0,
        0, 1]), 0.8, rough)
    found, touch = velocities(read_table(tmp_path / "run/particles.csv"), 1), read_table(tmp_path / "run/contacts.csv")
    assert found[0][0] == pytest.approx(after[0], abs=5e-4) and found[1][0] == pytest.approx(turned[0], abs=0.03)
    assert [touch[name][0] for name in ("fx", "fy", "fz")] == pytest.approx(rub, abs=2e-3 * np.linalg.norm(rub))
    assert touch["sliding"][0] == (rough < 0.2)


@pytest.mark.slow
def test_the_budget_of_spheres_that_rub_and_rebound_closes(box, freefem_text, tmp_path):
    """Energy and what it has turned into; the momentum is off by no more in the step of the collision than in others."""
    text = FLUID.replace("SPHERES", PAIR + " sphereSpins(0, 0, 0, 60);")
    freefem_text(text, "-mesh", box, "-restitution", 0.8, "-friction", 0.3, "-budget", 1, "-tend", 0.016, "-out", tmp_path / "run")
    rows, touch = read_table(tmp_path / "run/budget.csv"), read_table(tmp_path / "run/contacts.csv")
    whole = rows["kinetic_energy"] - rows["work"] + sum(rows[name] for name in ("dissipated", "pressure", "virtual", "steps"))
    assert len(touch["t"]) == 1 and whole == pytest.approx(whole[0], rel=2e-3)
    off = np.array([rows[f"momentum_{axis}"] - rows[f"walls_{axis}"] - rows[f"weight_{axis}"] for axis in "xyz"])
    jumps, hit = abs(np.diff(off)).max(axis=0), np.flatnonzero(rows["t"] == touch["t"][0])[0] - 1
    assert jumps[hit] <= np.delete(jumps, hit).max() and jumps[hit] < 0.1 * touch["impulse"][0]


def test_films_do_not_go_with_rebounds_in_a_fluid(box, freefem_text, tmp_path):
    run = freefem_text(FLUID.replace("SPHERES", PAIR), "-mesh", box, "-restitution", 0.5, "-film", 1, "-out", tmp_path / "run",
        check=False)
    assert run.returncode == 3 and "without films" in run.stderr and run.stderr.count("\n") == 1, run.stderr
