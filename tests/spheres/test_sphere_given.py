"""Prescribed motions of held spheres and loads on free ones: an oscillating sphere in slow flow, a spring, restarts, refusals."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tools.base.tables import read_table

RADIUS, RHO, MU, PERIOD, SPEED = 0.0075, 960, 0.424, 0.4, 0.01
CASE = """
include "lib/spheres/case.idp"
optCase("given", "a sphere of prescribed motion or under loads");
optDefault("-dt", "0.01"); optDefault("-convection", "0"); optDefault("-cfl", "0");
real rhoFluid = 960, mu = 0.424, gravityX = 0, gravityY = 0, gravityZ = {weight}, R = 0.0075, turn = 5*pi;
int[int] flowNoSlip = [labelWall], flowSlip = [labelLeft, labelFront], flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {particles} // EOM
{more}
include "scripts/spheres.edp"
"""


def case(particles, more, weight=0.0):
    return CASE.format(particles=particles, more=more, weight=weight)


@pytest.fixture(scope="module")
def quarter(tmp_path_factory):
    """A quarter of a closed box of 60 x 60 x 60 mm, 3 elements to the diameter of a sphere of 15 mm."""
    return make_mesh(tmp_path_factory.mktemp("box") / "quarter.mesh", "settling_sphere", "--width", 0.06, "--height", 0.06,
        "--corridor-top", 0.06, "--corridor", 0.015, "--size", 0.005)


def resistance(ratio):
    """Force over velocity of a sphere that oscillates in slow flow, exp(i w t) (Landau and Lifshitz, Fluid Mechanics, section 24),
    kg/s, with the inertia of the sphere itself."""
    w = 2 * np.pi / PERIOD
    layer = np.sqrt(2 * MU / RHO / w)
    own = ratio * RHO * 4 / 3 * np.pi * RADIUS**3
    return 6 * np.pi * MU * RADIUS * (1 + RADIUS / layer) + 1j * w * (
        3 * np.pi * RADIUS**2 * RHO * layer * (1 + 2 * RADIUS / (9 * layer)) + own)


def part(t, value):
    """The part of exp(i w t), by sines and cosines over the last period: value = Im(part exp(i w t))."""
    late, w = t > t.max() - PERIOD + 1e-9, 2 * np.pi / PERIOD
    return 2 * np.mean(value[late] * np.sin(w * t[late])) + 2j * np.mean(value[late] * np.cos(w * t[late]))


@pytest.mark.slow
@pytest.mark.parametrize("moved, ratio", [(True, 1), (True, 8), (False, 1), (False, 8)])
def test_a_sphere_oscillates_as_landau_and_lifshitz_have_it(moved, ratio, freefem_text, tmp_path):
    """A viscous layer as thick as the radius, a box of ten diameters (in one of four the drag is 5 % off), 4 elements to the
    diameter: the force on a sphere of prescribed motion, whatever its density, and the velocity that a periodic load gives it."""
    mesh = make_mesh(tmp_path / "wide.mesh", "settling_sphere", "--width", 0.15, "--height", 0.15, "--corridor-top", 0.105,
        "--corridor", 0.03, "--size", 0.00375)
    sphere = f"bodySphere(0, 0, 0.075, R, {ratio}*rhoFluid)"
    if moved:
        text = case(f"sphereHeld({sphere});", f"macro caseMotion(now) sphereMoves(0, 0, 0, {SPEED}*sin(turn*(now))); // EOM")
    else:
        load = SPEED * abs(resistance(ratio))
        text = case(f"{sphere};", f"macro caseLoads(now) spherePush(0, 0, 0, {load}*sin(turn*(now))); // EOM")
    run = tmp_path / "run"
    freefem_text(text, "-mesh", mesh, "-dt", 0.005, "-tend", 2 if ratio > 1 else 1.2, "-forces", 1, "-out", run)
    if moved:
        force = read_table(run / "forces.csv")
        found, exact = -part(force["t"], force["fz"]) / SPEED, resistance(0)
    else:
        rows = read_table(run / "particles.csv")
        found, exact = SPEED * abs(resistance(ratio)) / part(rows["t"], rows["w"]), resistance(ratio)
    assert abs(found - exact) < 0.05 * abs(exact)


def test_a_spring_carries_the_weight_of_a_sphere_and_brings_it_back(quarter, freefem_text, tmp_path):
    """A sphere on two planes of symmetry, twice as heavy as the fluid, hangs at rest on a spring that has the length of its whole
    weight less buoyancy; pulled 1 mm off, it comes back. A restart goes on byte for byte."""
    pull = RHO * 4 / 3 * np.pi * RADIUS**3 * 9.81
    more = f"macro caseLoads(now) spherePush(0, 0, 0, {pull} - 50*(sphereAtZ(0) - 0.03)); // EOM"
    for start, end in ((0.03, 0.03), (0.031, 0.1)):
        run = tmp_path / f"run{start}"
        text, options = case(f"bodySphere(0, 0, {start}, R, 2*rhoFluid);", more, -9.81), ["-mesh", quarter, "-tend", end]
        freefem_text(text, *options, "-checkpoint", 3, "-out", run)
        rows = read_table(run / "particles.csv")
        if start == 0.03:
            assert abs(rows["w"]).max() < 1e-9
            continue
        assert rows["w"][0] < -1e-3 and abs(rows["z"][-1] - 0.03) < 2e-4
        whole = (run / "particles.csv").read_text().splitlines()
        for file in run.glob("restart_000000010.*"):
            file.unlink()
        freefem_text(text, *options, "-checkpoint", 3, "-restart", run, "-out", tmp_path / "again")
        again = (tmp_path / "again/particles.csv").read_text().splitlines()[1:]
        assert again and again == whole[-len(again):]


@pytest.mark.parametrize("more, words", [
    ("macro caseMotion(now) sphereMoves(1, 0, 0, 1); // EOM", "moves freely"),
    pytest.param("macro caseMotion(now) sphereMoves(0, 0, 0, sqrt(-1.)); // EOM", "must be numbers", marks=pytest.mark.slow),
    pytest.param("macro caseMotion(now) sphereMoves(0, 1, 0, 0); // EOM", "leaves a plane of symmetry", marks=pytest.mark.slow),
    pytest.param("macro caseMotion(now) sphereSpins(7, 0, 0, 1); // EOM", "no such sphere", marks=pytest.mark.slow),
    ("macro caseLoads(now) spherePush(0, 0, 0, 1); // EOM", "is held"),
    pytest.param("macro caseLoads(now) sphereTwist(1, 0, 0, sqrt(-1.)); // EOM", "is not finite", marks=pytest.mark.slow),
    ("macro caseLoads(now) spherePush(5, 0, 0, sphereAtZ(5)); // EOM", "no such sphere"),
])
def test_what_is_no_motion_and_no_load_of_spheres_is_refused(more, words, quarter, freefem_text, tmp_path):
    two = "sphereHeld(bodySphere(0, 0, 0.03, R, rhoFluid)); bodySphere(0.012, 0.012, 0.03, R, rhoFluid);"
    run = freefem_text(case(two, more), "-mesh", quarter, "-tend", 0.02, "-out", tmp_path / "run", check=False)
    assert run.returncode == (5 if "symmetry" in words else 3) and words in run.stderr and run.stderr.count("\n") == 1, run.stderr
