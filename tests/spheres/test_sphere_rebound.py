"""Restitution of spheres, in contacts alone and in a fluid: bounces at their exact times, oblique collisions, a crowd, refusals."""
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


def test_restitution_with_friction_is_refused(freefem, tmp_path):
    run = freefem("cases/falling_spheres.edp", "-restitution", 0.5, "-out", tmp_path / "run", check=False)
    assert run.returncode == 3 and "without friction" in run.stderr and run.stderr.count("\n") == 1


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


@pytest.mark.parametrize("words, said", [(["-film", 1], "without films"), pytest.param(["-budget", 1], "do not rebound",
    marks=pytest.mark.slow), pytest.param(["-friction", 0.2], "without friction", marks=pytest.mark.slow)])
def test_what_does_not_go_with_rebounds_in_a_fluid_is_refused(words, said, box, freefem_text, tmp_path):
    run = freefem_text(FLUID.replace("SPHERES", PAIR), "-mesh", box, "-restitution", 0.5, *words, "-out", tmp_path / "run",
        check=False)
    assert run.returncode == 3 and said in run.stderr and run.stderr.count("\n") == 1, run.stderr
