"""Bodies in flows without inertia, where viscosity crosses them many times within a step."""
import numpy as np

from tests.conftest import mesh
from tests.scenes import case
from tools.base.tables import read_table

# A disk of 0.3 of a channel's width, nearer to the lower wall; mu dt/(rho R^2) = 44 with a step of 0.01 s.
CHANNEL = """
include "lib/case.idp"
optCase("channel", "a free disk in a slow flow through a channel");
optDefault("-dt", "0.01"); optDefault("-tend", "1"); optDefault("-every", "0");
real rhoFluid = 1, mu = 100, gravityX = 0, gravityY = 0, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelWall], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
macro caseParticles() { bodyDisk(1., 0.35, 0.15, 1.); } // EOM
include "scripts/resolved.edp"
"""


def test_a_disk_without_inertia_keeps_its_height(freefem_text, tmp_path, run_folder):
    """Stokes flow can be run backwards: no motion across. A pressure that stays behind the disk drives it across by 1.1 % of its
    speed here, one that goes along at its edge only by 0.55 %."""
    freefem_text(CHANNEL, "-mesh", mesh(tmp_path, "poiseuille", "--size", 0.05), "-out", run_folder)
    disk = read_table(run_folder / "particles.csv")
    late = disk["t"] > 0.3
    assert 0.8 < disk["u"][late].mean() < 0.91  # the undisturbed flow at its centre
    assert abs(disk["v"][late].mean()) < 0.0035 * disk["u"][late].mean()
    assert -0.6 < disk["omega"][late].mean() < -0.5  # half the shear rate there, -0.6, less what the near wall holds


# A cylinder drawn along a wall, through the middle of a box that is the same to both sides of it: gap of 2 elements, 16 across,
# mu dt/(rho h^2) = 128.
TOWED = """
include "lib/case.idp"
optCase("towed", "a cylinder towed along a wall");
optDefault("-dt", "0.02"); optDefault("-tend", "0.4"); optDefault("-every", "0.02"); optDefault("-forces", "1");
real rhoFluid = 1, mu = 16, gravityX = 0, gravityY = 0, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelWall], flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodyHeld(bodyDisk(1.7, 0.5, 0.4, 1)); // EOM
macro caseMotion(now) givenMotion(0, 1, 0, 0); // EOM
include "scripts/resolved.edp"
"""


def test_a_cylinder_towed_along_a_wall_has_no_lift(freefem_text, tmp_path, run_folder):
    """Stokes flow can be run backwards. A pressure that stays behind in the gap lifts the cylinder by 7 % of its drag here."""
    freefem_text(TOWED, "-mesh", mesh(tmp_path, "box", "--width", 4, "--height", 2, "--size", 0.05), "-out", run_folder)
    force = read_table(run_folder / "forces.csv")
    late = (force["t"] > 0.19) & (force["t"] < 0.41)  # from 1.9 to 2.1
    assert abs(force["fy"][late].mean()) < 0.03 * abs(force["fx"][late].mean())


def test_thin_ellipses_leave_a_slow_flow_at_rest(freefem, tmp_path, run_folder):
    """Their tips are sharper than the elements: a ghost profile with the tip's curvature made the fluid swing at 8 cm/s, 20 times
    the speed of fall."""
    bodies = tmp_path / "thin.csv"
    bodies.write_text("id,x,y,radius,density,aspect,theta\n10,1.0,1.2,0.7,1.2,0.2,0.4\n11,1.0,5.3,0.65,1.2,0.2,0.3\n")
    freefem("cases/template.edp", "-particles", bodies, "-mu", "10", "-tend", "0.05", "-every", "0.0025", "-out", run_folder)
    assert read_table(run_folder / "fluid.csv")["top_speed"].max() < 0.6


# A stirrer whose nodes lie deeper under its tips, measured along xi, than the points where velocities are known.
STIRRER = """
include "lib/case.idp"
optCase("stirrer", "an ellipse turning in a box");
optDefault("-dt", "0.01"); optDefault("-tend", "0.2"); optDefault("-every", "0.01");
real rhoFluid = 1, mu = 0.002, gravityX = 0, gravityY = 0, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelWall], flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodyHeld(bodyEllipse(0.5, 0.5, 0.3, 0.09, 0, 1)); // EOM
macro caseMotion(now) givenMotion(0, 0, 0, 6); // EOM
include "scripts/resolved.edp"
"""


def test_a_stirrer_drives_the_fluid_about_as_fast_as_its_tips(freefem_text, tmp_path, run_folder):
    freefem_text(STIRRER, "-mesh", mesh(tmp_path, "box", "--width", 1, "--height", 1, "--size", 1 / 38, "--pattern",
        "unstructured"), "-out", run_folder)
    assert read_table(run_folder / "fluid.csv")["top_speed"].max() < 3.5  # the tips: 1.8


def test_a_disk_that_turns_in_a_drum_soon_bears_what_wannier_says(freefem_text, tmp_path):
    """Off its middle, gaps of 3 and 9 elements, mu dt/(rho R^2) = 20, R the drum's. Without the drag of the drum on the pressure
    0.2, 0.6, 0.8 of the force were there after 10, 30, 50 steps."""
    inner, outer, off, mu = 0.5, 1, 0.25, 1000
    drum = f'border big(s = 0, 2*pi) {{ x = {outer}*cos(s); y = {outer}*sin(s); label = 3; }}\nsavemesh(buildmesh(big(80)), "{tmp_path}/drum.mesh");\n'
    text = drum + case(f"bodyAdd({off}, 0, {inner}, 1, 0, 0, 1, 0);", walls="labelWall", mu=mu, gravity=0)
    freefem_text(text, "-mesh", tmp_path / "drum.mesh", "-forces", 1, "-dt", 0.02, "-tend", 1, "-every", 0, "-tolerance", 1e-7,
        "-out", tmp_path / "run")
    force = read_table(tmp_path / "run" / "forces.csv")
    # bipolar coordinates of the two cylinders: Quart. Appl. Math. 8 (1950) 1
    pole = np.sqrt(((outer + inner) ** 2 - off**2) * ((outer - inner) ** 2 - off**2)) / (2 * off)
    a, b = np.arcsinh(pole / inner), np.arcsinh(pole / outer)
    across = 4 * np.pi * mu * inner * np.sinh(b) * np.sinh(a - b) / ((a - b) * (np.sinh(a) ** 2 + np.sinh(b) ** 2) - 2
        * np.sinh(a) * np.sinh(b) * np.sinh(a - b))
    share = force["fy"] / across
    assert share[9] > 0.38 and share[29] > 0.8 and 0.93 < share[49] < 1.01 and abs(force["fx"][-1]) < 0.005 * across
