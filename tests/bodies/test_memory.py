"""Memory does not grow with the steps of a run, or with bodies that enter and leave."""
import re

from tests.conftest import make_mesh

SCENE = """include "lib/case.idp"
optCase("memory", "bodies that enter and leave");
optDefault("-dt", "0.05"); optDefault("-tend", "45"); optDefault("-every", "0.5"); optDefault("-cfl", "0");
real rhoFluid = 1, mu = 0.05, gravityX = 0, gravityY = -0.2, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
int[int] flowNoSlip = [labelWall], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
macro caseParticles() { for (int k = 0; k < 100; ++k) { if (k % 3) queueAdd(0.3 + 0.2*(k % 3), 0.12, 1.1, 0.6*k); else queueEllipse(0.5, 0.15, 0.09, 0.3, 0.9, 0.6*k); } } // EOM
macro caseStep() if (driveStep % 5 == 0) { cout << "STORED " << driveStep << " " << storageused() << endl; if (driveStep % 300 == 0) exec("grep VmRSS /proc/$PPID/status"); cout.flush; } // EOM
include "scripts/resolved.edp"
"""


def test_memory_stays_as_bodies_enter_and_leave(freefem_text, tmp_path):
    """900 steps, 70 entries and as many exits. 20,000 steps with 660 entries kept the same 42.7 MB to 4 kB; 0.5 kB a step would be
    150 kB between the windows."""
    mesh = make_mesh(tmp_path / "channel.mesh", "poiseuille", "--length", 1, "--height", 1, "--size", 0.1)
    text = freefem_text(SCENE, "-mesh", mesh, "-out", tmp_path / "run").stdout
    stored = [(int(step), int(used)) for step, used in re.findall(r"STORED (\d+) (\d+)", text)]
    resident = [int(kilobytes) for kilobytes in re.findall(r"VmRSS:\s+(\d+) kB", text)]
    windows = [max(used for step, used in stored if low < step <= low + 300) for low in (300, 600)]
    left = len((tmp_path / "run" / "exits.csv").read_text().splitlines()) - 1
    assert left > 50 and len(resident) == 3
    assert windows[1] - windows[0] < 40e3 and resident[2] - resident[1] < 100, (windows, resident)
