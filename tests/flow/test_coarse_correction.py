"""The coarse correction of the velocity solver: exact for linear functions, symmetric, and without effect on what a run gives."""
import csv

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.scenes import script
from tests.tables import rows

ASK = """
include "lib/scheme/coarse_correction.idp"
mu = 3; rhoFluid = 2;
viscousFrom = FROM;
viscousFactor(5.);
cout << "on " << viscousOn << " " << viscousReach(5.) << endl;
real[int] a(2*flowNw), b(2*flowNw), x1(2*flowNw), x2(2*flowNw), w(flowNq), p(flowNw);
if (viscousOn) {
    for (int i = 0; i < flowNq; ++i) w[i] = sin(7.3*i + 1);
    w = w .* viscousFreeU;
    p = viscousToWh'*w;
    x1 = 0; x2 = 0;
    a(0:flowNw - 1) = flowM'*p; a(0:flowNw - 1) *= 10.; w = 0; b(0:flowNw - 1) = flowK'*p; a(0:flowNw - 1) += 3*b(0:flowNw - 1);
    a(flowNw:2*flowNw - 1) = 0; // a plane of symmetry holds one of them alone
    a(0:flowNw - 1) .*= flowFreeU;
    viscousCorrect(a, x1);
    for (int i = 0; i < flowNw; ++i) cout << "exact " << p[i] << " " << x1[i] << " " << x1[flowNw + i] << endl;
    for (int i = 0; i < 2*flowNw; ++i) a[i] = sin(3.1*i);
    for (int i = 0; i < 2*flowNw; ++i) b[i] = sin(1.7*i + 2);
    x1 = 0;
    viscousCorrect(a, x1); viscousCorrect(b, x2);
    cout << "symmetric " << b'*x1 << " " << a'*x2 << " " << a'*x1 << " " << b'*x2 << endl;
    for (int k = 0; k < rigidCount; ++k) cout << "held " << x1[rigidNode[k]] << " " << x1[flowNw + rigidNode[k]] << endl;
}
"""


LEVEL, UPRIGHT = "1, 3", "2, 4"  # labels of the sides


def run(freefem_text, disks, periodic=False, slip=None, start=0):
    text = script(disks, periodic, ASK.replace("FROM", str(start)))
    if slip:
        text = text.replace("flowNoSlip = [1, 2, 3, 4]",
            f"flowNoSlip = [{UPRIGHT if slip == LEVEL else LEVEL}]").replace("flowSlip(0)", f"flowSlip = [{slip}]")
    return freefem_text(text).stdout


@pytest.mark.parametrize("periodic, slip", [(False, None), (True, None), (False, LEVEL), (False, UPRIGHT)])
def test_linear_functions_are_given_back(freefem_text, periodic, slip):
    """The load of a linear velocity is answered by a fifth of it: the linear functions are among the quadratic ones."""
    out = run(freefem_text, [], periodic, slip)
    exact = rows(out, "exact")
    assert abs(exact[:, 0]).max() > 0.5
    assert exact[:, 1] == pytest.approx(0.2 * exact[:, 0], abs=1e-8) and not exact[:, 2].any()


@pytest.mark.parametrize("periodic, slip", [(False, None), (True, None), (False, LEVEL), (False, UPRIGHT)])
def test_it_is_symmetric_positive_and_leaves_bodies_alone(freefem_text, periodic, slip):
    out = run(freefem_text, [(0.31, 0.42, 0.127), (0.62, 0.71, 0.09)], periodic, slip)
    ab, ba, aa, bb = rows(out, "symmetric")[0]
    assert ab == pytest.approx(ba, rel=1e-8) and min(aa, bb) > 0
    held = rows(out, "held")
    assert len(held) > 20 and not held.any()


def test_it_is_made_only_where_viscosity_reaches_far(freefem_text):
    """The mean of viscous over inertial diagonal, from entries of a triangle: h^2 times the ratio is 24 to 80 for right isosceles
    ones."""
    on, reach = rows(run(freefem_text, [], start=1e9), "on")[0]
    assert on == 0 and 16**2 * 3 / 10 * 24 < reach < 16**2 * 3 / 10 * 80
    assert rows(run(freefem_text, [], start=reach * 0.99), "on")[0][0] == 1


def test_a_suspension_moves_as_without_it_in_half_the_applications(freefem, tmp_path):
    """Twenty per cent of disks in a shear flow, viscosity over many elements a step, to a tolerance of 1e-8."""
    text = (ROOT / "cases/sheared_suspension.edp").read_text()
    off = tmp_path / "off.edp"
    off.write_text(text.replace("macro caseStart() {", "macro caseStart() { IFMACRO(viscousCoarseIncluded) viscousFrom = 1e30; "
        "ENDIFMACRO"))
    tables = []
    for name, case in (("with", ROOT / "cases/sheared_suspension.edp"), ("without", off)):
        freefem(case, "-tend", "0.1", "-every", "0", "-tolerance", "1e-8", "-out", tmp_path / name)
        with open(tmp_path / name / "particles.csv") as file:
            motion = np.array([[float(row[k]) for k in ("x", "y", "u", "v", "omega")] for row in csv.DictReader(file)])
        with open(tmp_path / name / "fluid.csv") as file:
            tables.append((motion, sum(float(row["iterations"]) for row in csv.DictReader(file))))
    assert tables[0][0] == pytest.approx(tables[1][0], abs=1e-6)
    assert tables[0][1] < 0.5 * tables[1][1]
