"""Steady laminar flow: exact solutions, Newton's method, units, creeping flow, what comes in and goes out."""
import math

import numpy as np
import pytest

from tests.conftest import make_mesh, run_tool
from tests.scenes import write_box
from tests.tables import numeric_records, results, results_of
from tools.base.command import ROOT
from tools.base.mesh_files import read_field, read_mesh
from tools.base.tables import read_table
from tools.peers import step_by_differences


@pytest.mark.parametrize("axisymmetric", [0, 1])
def test_poiseuille_is_exact(freefem, run_folder, axisymmetric):
    found = results_of(freefem, run_folder, "turbulent_channel", "-model", "laminar", "-retau", 20, "-cells", 6,
                "-axisymmetric", axisymmetric)
    assert found["velocity_error"] < 1e-9


@pytest.mark.parametrize("axisymmetric", [0, 1])
def test_poiseuille_flow_through_the_pipe_case_to_its_outlet(freefem, run_folder, tmp_path, axisymmetric):
    # Plane: U_mean = 2/3, drop 12 mu L U_mean/H^2, shear 6 mu U_mean/H. Round: U_mean = 1/2, 8 mu L U_mean/R^2, 4 mu U_mean/R.
    low, mu = (0.0, 998.2 * 1 * 0.2 / 100) if axisymmetric else (-0.1, 998.2 * 1 * 0.2 / 100)
    mesh = write_box(tmp_path / "pipe.mesh", 1.0, low, 0.1, 24, 6, bottom=8 if axisymmetric else 3)
    found = results_of(freefem, run_folder, "pipe_flow", "-mesh", mesh, "-model", "laminar", "-reynolds", 100, "-vmax", 1,
                "-axisymmetric", axisymmetric, "-tolerance", 1e-9)
    flux, slope, shear = ((math.pi * 0.1**2 / 2, 8 * mu * 0.5 / 0.1**2, 4 * mu * 0.5 / 0.1) if axisymmetric
                          else (0.2 * 2 / 3, 12 * mu * 2 / 3 / 0.2**2, 6 * mu * 2 / 3 / 0.2))
    assert found["flux_in"] == pytest.approx(flux, rel=1e-9)
    assert found["pressure_drop"] == pytest.approx(slope * 1.0, rel=1e-8)
    assert found["loss_coefficient"] * 0.5 * 998.2 * found["mean_velocity"]**2 == pytest.approx(slope * 1.0, rel=1e-8)
    wall = numeric_records(run_folder / "wall.csv")
    assert all(r["pressure"] == pytest.approx(slope * (1.0 - r["x"]), abs=1e-8 * slope) for r in wall)
    assert all(abs(r["shear"]) == pytest.approx(shear, rel=1e-6) for r in wall)


def test_newton_cylinder_in_few_factorisations(freefem_text):
    out = freefem_text(r'''
include "lib/mesh/read_mesh.idp"
mesh Th = meshRead("meshes/cylinder_channel.mesh");
int newtonAxis = 0; real newtonNu = 1e-3, newtonSpeed = 0.3, newtonLength = 0.1, newtonForceX = 0;
int[int] newtonInlet = [labelInlet], newtonWalls = [labelWall, labelCylinder], newtonSymmetry = [labelAxis], newtonOutlet = [labelOutlet];
macro inletU() (1.2*y*(0.41 - y)/0.41^2) // EOM
include "lib/steady/laminar.idp"
int reached = newtonSolve(1e-8, 10);
varf mark(a, c) = on(labelCylinder, a = 1.);
real[int] weight = mark(0, NWh, tgv = 1.), alongX = newtonReaction(0:NWh.ndof - 1);
cout.precision(10);
cout << "FOUND " << reached << " " << newtonFactorisations << " " << -2.*(weight'*alongX)/(0.2^2*0.1) << endl;
''').stdout
    reached, factorisations, drag = map(float, out.split("FOUND")[1].split()[:3])
    assert reached == 1 and factorisations <= 10
    assert drag == pytest.approx(5.57953523384, rel=5e-4)  # DFG 2D-1, straight edges


def test_the_fields_keep_all_nodes_of_the_velocity(freefem_text, run_folder):
    freefem_text(CLOSED.replace("EXCESS", "0"), "-fields", 1, "-out", run_folder)
    fine, values = read_field(run_folder / "fields.vtu")
    assert len(fine.triangles) == 4 * len(read_mesh(run_folder / "mesh.mesh").triangles)
    y = fine.points[:, 1]
    assert abs(values["velocity"][:, 0] - 4 * y * (1 - y)).max() < 1e-6


CLOSED = r'''
include "lib/case.idp"
optCase("closed", "steady, the velocity given all round"); optDefault("-mesh", "meshes/poiseuille.mesh");
real rhoFluid = 1, mu = 0.1, speed = 1, size = 1, excess = EXCESS;
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall, labelOutlet], labelsMoving = [labelInlet, labelOutlet], labelsFree(0);
if (excess > -1) labelsStill.resize(1); else labelsMoving.resize(1);
macro inletU() (4*y*(1 - y)*(x > 1 ? 1 - excess : 1.)) // EOM
macro caseResult() { resultPut("p_in", int1d(Th, labelInlet)(newtonP), "Pa"); resultPut("p_mean", int2d(Th)(newtonP), "Pa m2"); } // EOM
include "scripts/steady_laminar.edp"
'''


@pytest.mark.parametrize("excess", [0, 1e-6, -1e-3])
def test_what_is_let_in_more_than_out_by_rounding_does_no_harm(freefem_text, run_folder, excess):
    freefem_text(CLOSED.replace("EXCESS", str(excess)), "-out", run_folder)
    found = results(run_folder)
    assert found["p_in"] == pytest.approx(1.6, abs=1e-7 + 2 * abs(excess))  # half of 8 mu L, the mean is 0
    assert abs(found["p_mean"]) < 1e-9


@pytest.mark.parametrize("excess, says", [(0.01, "0.00666667 m2/s into"), (-0.01, "0.00666667 m2/s out of"),
    (-1, "0.666667 m2/s into")])
def test_more_let_in_than_out_without_an_outlet_is_refused(freefem_text, excess, says):
    done = freefem_text(CLOSED.replace("EXCESS", str(excess)), check=False)
    assert done.returncode == 3 and f"a net flux of {says} the domain" in done.stderr and "there is no outlet" in done.stderr


@pytest.mark.parametrize("axis", [0, 1])
def test_newton_residual_and_derivative_are_those_of_the_mixed_form(freefem_text, axis):
    """Blocks and dense products against forms of [P2, P2, P1] written here, and a chord against both."""
    out = freefem_text(r'''
int[int] sides = [1, 2, 1, 3];
mesh Th = square(5, 4, [2.*x + 0.2*y*y, y + 0.1*sin(3.*x)], label = sides);
int newtonAxis = AXIS; real newtonNu = 0.5, newtonSpeed = 1., newtonLength = 1., newtonForceX = 0.3;
int[int] newtonInlet = [3], newtonWalls = [1], newtonOutlet = [2], newtonSymmetry(0);
macro inletU() (y*(1. - y)) // EOM
include "lib/steady/laminar.idp"
fespace Xh(Th, [P2, P2, P1]);
Xh [u, v, p];
real radius0 = 1. - AXIS;
func real weight() { return radius0 + AXIS*y; }
func real hoop() { return AXIS/weight(); }
varf mixed([a, b, q], [c, d, r]) = int2d(Th)(weight()*(
    newtonNu*(2.*dx(u)*dx(c) + 2.*dy(v)*dy(d) + (dy(u) + dx(v))*(dy(c) + dx(d)) + 2.*hoop()^2*v*d) - p*(dx(c) + dy(d) + hoop()*d)
    - r*(dx(u) + dy(v) + hoop()*v) - newtonTiny*p*r + (u*dx(u) + v*dy(u) - newtonForceX)*c + (u*dx(v) + v*dy(v))*d))
    - int1d(Th, 2)(weight()*newtonNu*((dx(u)*N.x + dx(v)*N.y)*c + (dy(u)*N.x + dy(v)*N.y)*d));
newtonU = 0.4*sin(2.*x)*y; newtonV = x*y*y; newtonP = cos(x + y);
// The order of [P2, P2, P1] is found by numbering the unknowns.
NWh names; NQh namesP; Xh [nu, nv, np];
names[] = 0:NWh.ndof - 1;
NWh names2; names2[] = names[]; names2[] += 1.*NWh.ndof;
namesP[] = 0:NQh.ndof - 1; namesP[] += 2.*NWh.ndof;
[nu, nv, np] = [names, names2, namesP];
int[int] at(Xh.ndof);
at = lround(nu[]);
newtonState(0:NWh.ndof - 1) = newtonU[];
newtonState(NWh.ndof:2*NWh.ndof - 1) = newtonV[];
newtonP[] /= newtonSpeed;
newtonState(2*NWh.ndof:newtonState.n - 1) = newtonP[];
func real apart() {
    newtonShow();
    [u, v, p] = [newtonU, newtonV, newtonP];
    real[int] exact = mixed(0, Xh), mine = newtonReaction(at);
    mine -= exact;
    return mine.linfty/exact.linfty;
}
matrix A;
newtonDerive(A);
real byBlocks = apart();
real[int] from = newtonState, reaction = newtonReaction;
newtonStep(A, from, reaction);
newtonStep(A, from, reaction);
real byStep = apart();
newtonMeasure();
cout << "FOUND " << byBlocks << " " << byStep << " " << apart() << endl;
int reached = newtonSolve(1e-12, 20);
newtonDerive(A);
cout << "SOLVED " << reached << " " << newtonFactorisations << " " << newtonLevel << " " << apart() << endl;
'''.replace("AXIS", str(axis))).stdout
    assert max(map(float, out.split("FOUND")[1].split()[:3])) < 1e-12
    reached, factorisations, level, apart = map(float, out.split("SOLVED")[1].split()[:4])
    assert reached == 1 and factorisations < 12 and level < 1e-12 and apart < 1e-11


def test_lengths_behind_the_laminar_step_are_those_of_finite_differences(freefem, run_folder, tmp_path, monkeypatch):
    """Two coarse grids of the second scheme, extrapolated, beside the suite in a shorter channel and the table of fine grids."""
    monkeypatch.setattr(step_by_differences, "CONTINUED", (100, 250, 500, 800))  # fewer Reynolds numbers on the way
    coarse = [float(cell) for cell in run_tool("peers.step_by_differences", 15, 20).stdout.splitlines()[-1].split(",")[1:]]
    fine = read_table(ROOT / "tests" / "reference" / "backward_step_second_schemes.csv")["differences"]
    assert coarse == pytest.approx(fine, rel=0.005)
    short = make_mesh(tmp_path / "short.mesh", "backward_step", "--inlet-length", 10, "--outlet-length", 40)
    found = results_of(freefem, run_folder, "backward_step", "-mesh", short, "-tolerance", 1e-6)
    own = [found[name] for name in ("x1_lower_reattachment", "x4_upper_separation", "x5_upper_reattachment")]
    assert own == pytest.approx(fine, rel=0.01)


def test_the_steady_flow_does_not_hang_on_units(freefem, tmp_path):
    """Reynolds number 20 in any units: the same drag coefficient."""
    coarse = make_mesh(tmp_path / "coarse.mesh", "cylinder_channel", "--circle-points", 16, "--size", 0.1)
    drags = [results_of(freefem, tmp_path / str(k), "cylinder_steady", "-mesh", coarse, "-mu", mu, "-speed",
        speed)["drag_coefficient"] for k, (mu, speed) in enumerate(((1e-3, 0.3), (1e-9, 3e-7), (1e3, 3e5)))]
    assert drags[1:] == pytest.approx([drags[0]] * 2, rel=1e-9)


def test_a_creeping_flow_has_the_viscosity_that_was_asked_for(freefem, run_folder):
    """Rounding stops the residual above the tolerance there; a thinner fluid was solved instead."""
    done = freefem("cases/cylinder_steady.edp", "-mu", 1e3, "-out", run_folder)
    assert results(run_folder)["drag_coefficient"] / 1e3 == pytest.approx(3142.56, rel=1e-4)
    assert "viscosity 0.99" not in done.stdout and "rounding keeps the residual at 1." in done.stdout


def test_a_flow_that_is_not_found_says_so(freefem_refused, tmp_path):
    line = freefem_refused(4, "cases/cavity.edp", "-reynolds", 1e6, "-steps", 5, "-out", tmp_path / "run")
    assert "lower Reynolds number" in line and "(at 7071.07 times the viscosity a flow was found)" in line
    assert '"status": "failed (4)"' in (tmp_path / "run/run.json").read_text() and not (tmp_path / "run/.writer").exists()


def test_a_creeping_flow_keeps_its_mass(freefem, run_folder, coarse_pipe):
    """2 % were lost at a Reynolds number of 1e-6."""
    found = results_of(freefem, run_folder, "pipe_flow", "-mesh", coarse_pipe, "-reynolds", "1e-6", "-model", "laminar")
    assert abs(found["flux_defect"]) < 1e-6


# Kovasznay's flow behind a grid, exact, between two of its planes of symmetry; TURNED 1: along y.
KOVASZNAY = r"""
include "lib/case.idp"
optCase("kovasznay", "flow behind a grid"); optDefault("-mesh", "FOLDER/grid.mesh");
int cells = optInt("-cells", 8, 2, "cells across"), turned = TURNED;
real rhoFluid = 1, mu = 1./40, speed = 1, size = 1, rate = 20 - sqrt(400 + 4*pi^2);
include "lib/mesh/labels.idp"
int[int] labelsStill(0), labelsMoving = [labelInlet], labelsFree(0), sides = [labelAxis, labelInlet, labelAxis, labelInlet];
{
    mesh box = square(3*cells, cells, [-0.5 + 1.5*x, 0.5*y], label = sides);
    if (turned) box = movemesh(box, [-y, x]);
    savemesh(box, "FOLDER/grid.mesh");
}
func real streamAt(real s, real r) { return 1 - exp(rate*s)*cos(2*pi*r); }
func real crossAt(real s, real r) { return rate/(2*pi)*exp(rate*s)*sin(2*pi*r); }
macro inletU() (turned ? -crossAt(y, -x) : streamAt(x, y)) // EOM
macro inletV() (turned ? streamAt(y, -x) : crossAt(x, y)) // EOM
macro caseSymmetry() [labelAxis] // EOM
macro caseResult() {
    real[int] pull(2), push(2), along = newtonReaction(turned*newtonNw:(turned + 1)*newtonNw - 1);
    resultPut("error", sqrt(int2d(Th)((newtonU - (inletU))^2 + (newtonV - (inletV))^2)), "m2/s");
    steadyForceOn(labelAxis, pull);
    steadyForceOn(labelInlet, push);
    resultPut("pull", abs(pull[1 - turned]), "N/m");
    resultPut("left_over", abs(push[turned] + rhoFluid*along.sum) + abs(pull[turned]), "N/m");
} // EOM
include "scripts/steady_laminar.edp"
"""


def test_kovasznay_flow_between_planes_of_symmetry(freefem_text, tmp_path):
    errors, rate = [], 20 - (400 + 4 * math.pi**2)**0.5
    for turned, cells in ((0, 8), (0, 16), (1, 16)):
        freefem_text(KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", str(turned)), "-cells", cells, "-out",
            tmp_path / f"run{turned}{cells}")
        found = results(tmp_path / f"run{turned}{cells}")
        errors.append(found["error"])
        # 2 mu dv/dy, which has two signs; the pressure is the same
        assert found["pull"] == pytest.approx(4 / 40 * (math.exp(-rate / 2) - math.exp(rate)), rel=1e-3)
        assert found["left_over"] < 1e-12  # all that acts along the planes is borne at the inlet, corners included
    assert errors[1] < 3e-4 and np.log2(errors[0] / errors[1]) > 2.8
    assert errors[2] == pytest.approx(errors[1], rel=1e-5)


def test_more_let_in_than_out_across_horizontal_sides_is_refused(freefem_text, run_folder, tmp_path):
    text = KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", "1").replace("streamAt(y, -x) : c",
        "1.1*streamAt(y, -x)*(y < 0 ? 1. : 0.99) : c")
    done = freefem_text(text, "-out", run_folder, check=False)
    assert done.returncode == 3 and "into the domain, and there is no outlet" in done.stderr


def test_a_misspelt_velocity_at_the_inlet_is_told(freefem_text, run_folder, tmp_path):
    text = KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", "0").replace("macro inletV()",
        "macro inletW()").replace("(newtonV - (inletV))", "newtonV")
    assert "warning: the macro inletW is used nowhere" in freefem_text(text, "-out", run_folder).stdout
