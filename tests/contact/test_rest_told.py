"""What a run of contacts alone prints at its end of bodies that rest from the start."""
import re

import pytest

PLANE = """
include "lib/case.idp"
optCase("rest", "three disks at rest");
real gravityX = 0, gravityY = -10;
macro caseWalls() contactWallSegment(-5, 0, 5, 0); // EOM
macro caseParticles() bodyDisk(-0.1, 0.1, 0.1, 1000); bodyDisk(0.1, 0.1, 0.1, 1000);
    bodyDisk(0, 0.1 + 0.1*sqrt(3.), 0.1, 1000); // EOM
include "scripts/contacts.edp"
"""
SPACE = """
include "lib/spheres/case.idp"
optCase("rest", "a pyramid of spheres at rest");
real gravityX = 0, gravityY = 0, gravityZ = -10, R = 0.1;
func int fill() {
    bodySphere(0, 0, R, R, 1000); bodySphere(2*R, 0, R, R, 1000); bodySphere(R, R*sqrt(3.), R, R, 1000);
    return bodySphere(R, R/sqrt(3.), R + 2*R*sqrt(2./3.), R, 1000);
}
func int floor0() { real[int] o = [-5, -5, 0], a = [10, 0, 0], b = [0, 10, 0]; return sphereWall(o, a, b); }
macro caseParticles() fill(); // EOM
macro caseWalls() floor0(); // EOM
include "scripts/contact_spheres.edp"
"""


@pytest.mark.parametrize("case", [PLANE, SPACE], ids=["plane", "space"])
def test_bodies_at_rest_gain_no_energy_worth_a_word(freefem_text, tmp_path, case):
    """The rise of rounding was told over a peak of rounding: 812. Now over what a step of free fall would give."""
    done = freefem_text(case, "-friction", 0.4, "-dt", 0.001, "-tend", 0.1, "-out", tmp_path / "run")
    rise = float(re.search(r"rise of the energy in a step / peak (\S+),", done.stdout).group(1))
    assert 0 <= rise < 1e-3
