"""Bodies in flows without inertia, where viscosity crosses them many times within a step."""
from tests.test_flow import mesh
from tools.tables import read_table

# A disk of 0.3 of a channel's width, nearer to the lower wall; mu dt/(rho R^2) = 44 with a step of 0.01 s.
CHANNEL = """
include "lib/options.idp"
optCase("channel", "a free disk in a slow flow through a channel");
optDefault("-dt", "0.01"); optDefault("-tend", "1"); optDefault("-every", "0");
real rhoFluid = 1, mu = 100, gravityX = 0, gravityY = 0, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
include "lib/labels.idp"
int[int] flowNoSlip = [labelWall], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
macro caseParticles() { bodyDisk(1., 0.35, 0.15, 1.); } // EOM
include "scripts/resolved.edp"
"""


def test_a_disk_without_inertia_keeps_its_height(freefem_text, tmp_path, run_folder):
    """Stokes flow can be run backwards: no motion across. A pressure that stays behind the disk drives it across by 1.1 % of its speed here."""
    freefem_text(CHANNEL, "-mesh", mesh(tmp_path, "poiseuille", "--size", 0.05), "-out", run_folder)
    disk = read_table(run_folder / "particles.csv")
    late = disk["t"] > 0.3
    assert 0.8 < disk["u"][late].mean() < 0.91  # the undisturbed flow at its centre
    assert abs(disk["v"][late].mean()) < 0.007 * disk["u"][late].mean()
    assert -0.6 < disk["omega"][late].mean() < -0.5  # half the shear rate there, -0.6, less what the near wall holds
