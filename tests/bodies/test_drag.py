"""Drag and torque on held bodies and in periodic arrays."""
import numpy as np
import pytest

from tools.base.tables import read_table


def test_drag_in_a_periodic_array_is_the_same_everywhere(freefem, cell, tmp_path):
    """Sangani & Acrivos: 51.53 at solid fraction 0.2; a cylinder across the seams is not another one."""
    found = []
    for name, centre in (("middle", "0.5"), ("corner", "0")):
        freefem("cases/cylinder_array.edp", "-fraction", "0.2", "-x", centre, "-y", centre, "-mesh", cell, "-dt", "0.004", "-out",
            tmp_path / name)
        summary = read_table(tmp_path / name / "summary.csv")
        found.append(float(summary["drag"][0]))
        assert summary["drag_by_balance"][0] == pytest.approx(found[-1], rel=1e-3)
    assert found[0] == pytest.approx(51.53, rel=0.02)
    assert found[1] == pytest.approx(found[0], rel=1e-4)


ARRAY = """include "lib/case.idp"
optCase("array", "an array of free disks that settle");
real rhoFluid = 1, mu = 1, gravityX = 0.6, gravityY = -0.8, radius = sqrt(0.2/pi), density = 2;
include "lib/mesh/labels.idp"
int[int] flowNoSlip(0), flowMoving(0), flowOutlet(0), flowSlip(0);
macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]);
    fespace Qh(Th, P1, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight, labelBottom, labelTop] // EOM
macro flowForceX() (-0.2*(density - rhoFluid)*gravityX) // EOM
macro flowForceY() (-0.2*(density - rhoFluid)*gravityY) // EOM
real flowPeriodX = 1, flowPeriodY = 1, motionBound = 1e30;
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodyDisk(0.503, 0.507, radius, density); // EOM
real[int] mean(2);
macro caseStep() {
    real[int] u = flowM'*flowU, v = flowM'*flowV;
    mean = [u.sum/Th.measure, v.sum/Th.measure];
} // EOM
include "scripts/resolved.edp"
cout << "slip " << bodyAtU(0) - mean[0] << " " << bodyAtV(0) - mean[1] << endl;
"""


def test_an_array_of_free_disks_settles_by_its_drag(freefem_text, cell, tmp_path):
    """Sangani & Acrivos, as above: their weight less buoyancy is 51.53 mu times their velocity over the mean, whatever its
    direction."""
    done = freefem_text(ARRAY, "-mesh", cell, "-dt", 0.004, "-tend", 0.4, "-every", 0, "-convection", 0, "-tolerance", 1e-8,
        "-out", tmp_path / "run")
    slip = [float(word) for word in next(line for line in done.stdout.splitlines() if line.startswith("slip")).split()[1:]]
    assert np.hypot(*slip) == pytest.approx(0.2 / 51.53, rel=0.005)
    assert slip[0] / slip[1] == pytest.approx(-0.75, rel=1e-3)


def test_the_torque_on_a_turning_cylinder_is_the_exact_one(freefem, tmp_path):
    """4 pi mu omega R^2, at 8 elements across."""
    out = freefem("cases/rotating_cylinder.edp", "-out", tmp_path / "run").stdout
    ratio = float(next(line for line in out.splitlines() if line.startswith("torque")).split(":")[1])
    assert ratio == pytest.approx(1, abs=0.005)


@pytest.mark.parametrize("case, words", [("rotating_cylinder", ["-omega", 0]), ("rotating_cylinder", ["-forces", 0]),
    ("cylinder_array", ["-forces", 0]),
                                         ("cylinder_between_plates", ["-forces", 0]), ("oscillating_cylinder", ["-forces", 0]),
                                             ("oscillating_cylinder", ["-kc", 0.01, "-dt", 0.01])])
def test_cases_say_nothing_of_forces_that_they_do_not_have(case, words, freefem, tmp_path):
    """A torque over none ended with status 8, drags that were not computed were 0."""
    said = freefem(f"cases/{case}.edp", "-tend", 0.01, *words, "-out", tmp_path / "run").stdout
    assert "exact one" not in said and "over the last period:" not in said and not (tmp_path / "run" / "summary.csv").exists()
