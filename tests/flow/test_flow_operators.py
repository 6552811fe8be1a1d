"""Convection and stabilisation are those that FreeFEM assembles; the dissipation that the mesh does not resolve."""
import numpy as np
import pytest

from tests.conftest import mesh, run_freefem
from tests.scenes import THROUGH
from tools.base.tables import read_table

# An unstructured mesh with an outlet.
OUTLET = """
include "lib/case.idp"
optCase("operator", "test");
optEnd();
include "lib/mesh/labels.idp"
mesh Th = square(5, 4, [x + 0.1*y*y, y*(1 + 0.2*x)]);
int[int] relabel = [1, labelWall, 2, labelOutlet, 3, labelWall, 4, labelInlet];
Th = change(Th, label = relabel);
Th = adaptmesh(Th, SIZE*(2 + x), IsMetric = 1, nbvx = 20000);
real flowPeriodX = 0, flowPeriodY = 0;
int[int] flowNoSlip = [labelWall], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
"""

# The same form by FreeFEM's assembly, on an unstructured mesh with an outlet through which the
# advecting velocity goes both ways.
OPERATOR = OUTLET + """
real rhoFluid = 1, mu = 1;
include "lib/flow/convection.idp"
matrix A = flowM;
convSetUp(A);
Wh a = sin(3*x) - y + 0.2, b = x*y - 0.5*cos(5*y);
a = a + LIFT;
int[int] I(1), J(1);
real[int] C(1);
[I, J, C] = A;
C = 0;
convBase(C);
real[int] carrier(2*flowNw);
carrier(0:flowNw - 1) = a[]; carrier(flowNw:2*flowNw - 1) = b[];
convFill(carrier, 1.7, C);
convWidest = 0; // columns only for what each block reaches
convSetUp(A);
real[int] packed(C.n), apart = C;
packed = 0;
convBase(packed);
convFill(carrier, 1.7, packed);
apart -= packed;
cout << "PACKED " << convPacked << " " << apart.linfty << endl;
A.coef = C;
varf form(u, w) = int2d(Th, qforder = 9)(1.7*0.5*((a*dx(u) + b*dy(u))*w - (a*dx(w) + b*dy(w))*u))
    + int1d(Th, labelOutlet, qforder = 9)(1.7*0.5*max(a*N.x + b*N.y, 0.)*u*w);
matrix B = form(Wh, Wh);
real worst = 0, most = 0;
for (int k = 0; k < 5; ++k) {
    Wh u = cos(k*x + 2*y) + k*x*x;
    real[int] first = A'*u[], second = B*u[];
    most = max(most, second.linfty);
    first -= second;
    worst = max(worst, first.linfty);
}
cout << "TRIANGLES " << Th.nt << endl;
cout << "RESULT " << worst/most << " " << int1d(Th, labelOutlet)(max(a*N.x + b*N.y, 0.)) << " " << int1d(Th, labelOutlet)(max(-a*N.x - b*N.y, 0.)) << endl;
"""


@pytest.mark.parametrize("lift, size, off_most", [(3, 0.1, 1e-11), (3, 0.01, 1e-11), (0, 0.1, 1e-2)])
def test_convection_operator_is_that_of_the_assembly(lift, size, off_most, freefem_text):
    """Exactly where the outlet only lets out, in one block of triangles and in several; where the flow turns on an edge, to the
    quadrature."""
    text = freefem_text(OPERATOR.replace("LIFT", str(lift)).replace("SIZE", str(size))).stdout
    off, leaving, entering = map(float, next(line for line in text.splitlines() if line.startswith("RESULT")).split()[1:])
    assert off < off_most
    assert "PACKED 1 0\n" in text
    triangles = int(next(line for line in text.splitlines() if line.startswith("TRIANGLES")).split()[1])
    assert (triangles > 1400) == (size < 0.1)
    assert leaving > 0 and (entering > 0) == (lift == 0)


STABILISED = OUTLET.replace("SIZE", "0.1") + """
real rhoFluid = 1.3, mu = 0.012, stabilise = 0.07;
include "lib/flow/stabilisation.idp"
stabiliseSetUp(flowM);
Wh a = sin(3*x) - y + 0.2, b = x*y - 0.5*cos(5*y), speed = sqrt(a^2 + b^2);
stabiliseRenew(a[], b[]);
fespace Zh(Th, P0);
varf longest(u, w) = int2d(Th)(w/area*hTriangle);
varf mean(u, w) = int2d(Th)(w/area*speed);
Zh h, U;
h[] = longest(0, Zh); U[] = mean(0, Zh);
Zh s = stabilise*U*max(0., 1 - 10*mu/(rhoFluid*U*h));
varf form(u, w) = int2d(Th)(s*h*(dx(u)*dx(w) + dy(u)*dy(w))) - int2d(Th, qft = qf1pT)(s*h*(dx(u)*dx(w) + dy(u)*dy(w)));
matrix B = form(Wh, Wh), L = flowM;
L.coef = stabiliseC;
real worst = 0, most = 0;
for (int k = 0; k < 4; ++k) {
    Wh u = cos(k*x + 2*y) + k*x*x;
    real[int] first = L*u[], second = B*u[];
    most = max(most, second.linfty);
    first -= second;
    worst = max(worst, first.linfty);
}
int still = 0;
for (int T = 0; T < Th.nt; ++T) if (stabiliseSpeed[T] == 0) still++;
cout << "RESULT " << worst/most << " " << abs(stabiliseSquare(a[], b[])/flowSquare(B, a[], b[]) - 1) << " " << still << " " << Th.nt << endl;
"""


def test_stabilisation_is_that_of_the_assembly(freefem_text):
    """The form, filled from a speed for each triangle, and its square; some triangles resolve the flow and have none of it."""
    text = freefem_text(STABILISED).stdout
    off, square, still, triangles = map(float, next(line for line in text.splitlines() if line.startswith("RESULT")).split()[1:])
    assert off < 1e-13 and square < 1e-13
    assert 0 < still < 0.5 * triangles


DIAGONAL = """
macro caseStep()
    real[int] off = momentumAT.diag;
    off = off .* momentumInverse;
    off -= 1.;
    for (int i = 0; i < flowNw; ++i) if (flowX[i] > 0.9) off[i] = 0;
    cout << "OFF " << off.linfty << " " << stabiliseVersion << endl;
// EOM
include "cases/pipe_jet.edp"
"""


def test_the_solver_s_diagonal_is_that_of_the_stabilised_matrix(freefem_text, meshes, tmp_path):
    """Convection is skew-symmetric and adds nothing to it, but at the outlet (x = 1)."""
    coarse = mesh(meshes, "pipe_obstacles", "--size", 0.02)
    text = freefem_text(DIAGONAL, "-mesh", coarse, "-reynolds", 1e4, "-ramp", 0.005, "-cfl", 0, "-dt", 0.001, "-tend", 0.015,
        "-out", tmp_path / "run").stdout
    rows = [line.split()[1:] for line in text.splitlines() if line.startswith("OFF")]
    assert int(rows[0][1]) == 0 < int(rows[-1][1])
    assert max(float(off) for off, version in rows) < 1e-13


@pytest.mark.parametrize("reynolds, warned", [(1e4, True), (200, False)])
def test_a_flow_that_the_mesh_does_not_resolve_is_told(reynolds, warned, meshes, run_folder):
    """The share of the stabilisation in fluid.csv is that of the terms of budget.csv, and what warns at the end."""
    coarse = mesh(meshes, "pipe_obstacles", "--size", 0.02)
    run = run_freefem("cases/pipe_jet.edp", "-mesh", coarse, "-reynolds", reynolds, "-tend", 0.3, "-every", 0, "-budget", 1,
        "-out", run_folder)
    fluid, budget = read_table(run_folder / "fluid.csv"), read_table(run_folder / "budget.csv")
    damped, viscous = np.diff(budget["smoothed"]), np.diff(budget["dissipated"])
    assert fluid["unresolved"][1:] == pytest.approx(damped / (damped + viscous), abs=1e-6)
    if warned:
        assert 0.2 < fluid["unresolved"][-1] < 0.9
        assert "% of the dissipation" in run.stdout and "does not resolve" in run.stdout
    else:
        assert fluid["unresolved"].max() < 0.1 and "dissipation" not in run.stdout


def test_a_uniform_stream_has_no_dissipation_to_resolve(freefem_text, run_folder):
    """Through planes of symmetry; of what rounding leaves the stabilisation took more than all ("267 %")."""
    stream = THROUGH.replace("flowNoSlip = [labelBottom, labelTop]", "flowNoSlip(0)").replace("flowSlip(0)",
        "flowSlip = [labelBottom, labelTop]").replace("4*y*(1 - y)", "1.").replace("mu = 0.1", "mu = 1e-5")
    run = freefem_text(stream, "-dt", 0.02, "-tend", 1, "-out", run_folder)
    assert abs(read_table(run_folder / "fluid.csv")["unresolved"]).max() == 0 and "dissipation" not in run.stdout


def test_the_dissipation_before_the_first_stabilisation_counts(freefem_text, run_folder):
    """In the sums of the run, of which the warning is; the stream speeds up from rest."""
    text = """
macro caseStep()
    if (stabiliseVersion == 0) dissipated += mu*flowSquare(flowK, flowU, flowV);
    cout << "SUMS " << stabiliseVersion << " " << dissipated << " " << resolutionViscous << endl;
// EOM
real dissipated = 0;
include "cases/poiseuille.edp"
"""
    out = freefem_text(text, "-dt", 0.01, "-every", 0, "-tend", 0.05, "-out", run_folder).stdout
    rows = [line.split()[1:] for line in out.splitlines() if line.startswith("SUMS")]
    assert len(rows) >= 5 and int(rows[-1][0]) == 0 < float(rows[-1][1])
    assert float(rows[-1][2]) == pytest.approx(float(rows[-1][1]), rel=1e-4)
