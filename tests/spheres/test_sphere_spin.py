"""Light spheres that spin: their kinetic energy, and how a viscous fluid stops them."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tools.base.tables import read_table

SPIN = """
include "lib/spheres/case.idp"
optCase("spin", "a sphere that spins in a box of fluid at rest");
real rhoFluid = 960, mu = optReal("-mu", 0.58, "Pa s", "viscosity"), s = optReal("-ratio", 0.5, "", "density over the fluid's");
real gravityX = 0, gravityY = 0, gravityZ = 0;
int[int] flowNoSlip = [labelWall], flowSlip(0), flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() sphereSpins(bodySphere(0.001, 0, 0.031, 0.0075, s*rhoFluid), 0, 10/sqrt(2.), 10/sqrt(2.)); // EOM
include "scripts/spheres.edp"
"""


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A closed box of 60 x 60 x 60 mm, 3 elements to the diameter of a sphere of 15 mm."""
    return make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "settling_sphere", "--part", "whole", "--width", 0.06, "--height",
        0.06, "--corridor-top", 0.06, "--corridor", 0.03, "--size", 0.005)


@pytest.mark.parametrize("ratio, within", [(0.05, 0.1), (0.5, 0.02)])
def test_the_energy_of_a_light_sphere_that_spins_is_its_own(ratio, within, box, freefem_text, tmp_path):
    """J omega^2/2 as long as hardly any fluid turns with it. It was negative: the nodes' fluid was subtracted with more than they
    have, because the velocity relative to a surface that turns was taken for that of a viscous layer."""
    freefem_text(SPIN, "-mesh", box, "-ratio", ratio, "-mu", 1e-4, "-dt", 1e-4, "-cfl", 0, "-tend", 5e-4, "-budget", 1, "-out",
        tmp_path / "run")
    own = 0.5 * 0.4 * ratio * 960 * 4 / 3 * np.pi * 0.0075**5 * 10**2
    assert read_table(tmp_path / "run/budget.csv")["kinetic_energy"] == pytest.approx(own, rel=within)


def spin_down(ratio, tau):
    """omega over that at the start of a sphere in an unbounded viscous fluid, slow flow; tau = nu t/R^2. The torque is
    8 pi mu R^3 omega (1 + p/(3 (1 + sqrt(p)))) for omega ~ exp(p tau) (Landau and Lifshitz, Fluid Mechanics, section 24); the
    inverse Laplace transform by Talbot's contour."""
    many = 40
    theta = np.arange(1, many) * np.pi / many
    cot, r = 1 / np.tan(theta), 0.4 * many / tau
    p = np.append(r + 0j, r * theta * (cot + 1j))
    weight = np.append(0.5 + 0j, 1 + 1j * (theta + (theta * cot - 1) * cot))
    image = ratio / 15 / (ratio / 15 * p + 1 + p / (3 * (1 + np.sqrt(p))))
    return r / many * np.sum(np.exp(tau * p) * image * weight).real


def test_a_light_sphere_that_spins_stops_as_fast_as_its_moment_of_inertia_says(box, freefem_text, tmp_path):
    """Half the density of the fluid, once the viscous layer has the thickness of an element; spheres lighter than the fluid had
    the moment of 1.1 times its density, and turned twice as fast here, and three times at the end."""
    run = tmp_path / "run"
    freefem_text(SPIN, "-mesh", box, "-dt", 5e-4, "-cfl", 0, "-tend", 0.02, "-out", run)
    rows = read_table(run / "particles.csv")
    omega = np.sqrt(rows["omega_x"]**2 + rows["omega_y"]**2 + rows["omega_z"]**2) / 10
    late = rows["t"] > 0.0035
    exact = np.array([spin_down(0.5, t * 0.58 / 960 / 0.0075**2) for t in rows["t"][late]])
    assert spin_down(0.5, 1e-6) == pytest.approx(1, abs=0.02)
    assert omega[late] == pytest.approx(exact, rel=0.2)
