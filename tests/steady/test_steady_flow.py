"""Steady flow alone: laminar Newton, the k-epsilon model, the state kept in a folder."""
import csv
import math
import shutil

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from tests.conftest import make_mesh, run_freefem, run_tool
from tools.command import ROOT, BadInput
from tools.mesh_files import read_field, read_mesh
from tools.peers import step_by_differences
from tools.tables import read_table


def results(folder):
    """results.csv of a run as {quantity: value}."""
    with open(folder / "results.csv", newline="") as file:
        return {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}


def rows(path):
    """A CSV as a list of {column: number}."""
    with open(path, newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def run(freefem, folder, case, *args):
    freefem(f"cases/{case}.edp", "-out", folder, *args)
    return results(folder)


PIPE_MESH = """MeshVersionFormatted 2
Dimension 2
Vertices
{vertices}
Triangles
{triangles}
Edges
{edges}
End
"""


def write_box(path, length, low, high, nx, ny, bottom):
    """A structured mesh of [0, length] x [low, high]: inlet, outlet, wall above, `bottom` below."""
    lines, triangles, edges = [], [], []
    for j in range(ny + 1):
        for i in range(nx + 1):
            label = 0
            lines.append(f"{length * i / nx:.12g} {low + (high - low) * j / ny:.12g} {label}")
    def at(i, j):
        return j * (nx + 1) + i + 1
    for j in range(ny):
        for i in range(nx):
            triangles.append(f"{at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)} 0")
            triangles.append(f"{at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)} 0")
    for i in range(nx):
        edges.append(f"{at(i, 0)} {at(i + 1, 0)} {bottom}")
        edges.append(f"{at(i + 1, ny)} {at(i, ny)} 3")
    for j in range(ny):
        edges.append(f"{at(nx, j)} {at(nx, j + 1)} 2")
        edges.append(f"{at(0, j + 1)} {at(0, j)} 1")
    path.write_text(PIPE_MESH.format(vertices="\n".join([str(len(lines)), *lines]),
                                     triangles="\n".join([str(len(triangles)), *triangles]),
                                     edges="\n".join([str(len(edges)), *edges])))
    return path


@pytest.mark.parametrize("axisymmetric", [0, 1])
def test_poiseuille_is_exact(freefem, run_folder, axisymmetric):
    found = run(freefem, run_folder, "turbulent_channel", "-model", "laminar", "-retau", 20, "-cells", 6,
                "-axisymmetric", axisymmetric)
    assert found["velocity_error"] < 1e-9


@pytest.mark.parametrize("axisymmetric", [0, 1])
def test_poiseuille_flow_through_the_pipe_case_to_its_outlet(freefem, run_folder, tmp_path, axisymmetric):
    # Plane: U_mean = 2/3, drop 12 mu L U_mean/H^2, shear 6 mu U_mean/H. Round: U_mean = 1/2, 8 mu L U_mean/R^2, 4 mu U_mean/R.
    low, mu = (0.0, 998.2 * 1 * 0.2 / 100) if axisymmetric else (-0.1, 998.2 * 1 * 0.2 / 100)
    mesh = write_box(tmp_path / "pipe.mesh", 1.0, low, 0.1, 24, 6, bottom=8 if axisymmetric else 3)
    found = run(freefem, run_folder, "pipe_flow", "-mesh", mesh, "-model", "laminar", "-reynolds", 100, "-vmax", 1,
                "-axisymmetric", axisymmetric, "-tolerance", 1e-9)
    flux, slope, shear = ((math.pi * 0.1**2 / 2, 8 * mu * 0.5 / 0.1**2, 4 * mu * 0.5 / 0.1) if axisymmetric
                          else (0.2 * 2 / 3, 12 * mu * 2 / 3 / 0.2**2, 6 * mu * 2 / 3 / 0.2))
    assert found["flux_in"] == pytest.approx(flux, rel=1e-9)
    assert found["pressure_drop"] == pytest.approx(slope * 1.0, rel=1e-8)
    assert found["loss_coefficient"] * 0.5 * 998.2 * found["mean_velocity"]**2 == pytest.approx(slope * 1.0, rel=1e-8)
    wall = rows(run_folder / "wall.csv")
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


@pytest.mark.parametrize("excess, says", [(0.01, "0.00666667 m2/s into"), (-0.01, "0.00666667 m2/s out of"), (-1, "0.666667 m2/s into")])
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


@pytest.mark.parametrize("axis, turning", [(0, 0), (0, 1), (1, 1)])
def test_turbulent_residual_is_that_of_the_mixed_form(freefem_text, axis, turning):
    """Dense products against the weak form of lib/steady/rans_forms.idp written out here, at a state that solves nothing."""
    out = freefem_text(r'''
int[int] sides = [1, 2, 1, 3];
mesh Th = square(6, 5, [2.*x + 0.2*y*y, 0.1 + y + 0.1*sin(3.*x)], label = sides);
int ransAxis = AXIS, ransTurning = TURNING;
real ransNu = 1e-4, ransSpeed = 1.5, ransLength = 0.7, ransForceX = 0.3;
int[int] ransInlet = [3], ransOutlet = [2], ransWalls = [1], ransSymmetry(0);
macro inletU() y*(1. - y) // EOM
macro inletK() log(0.01) // EOM
macro inletE() log(0.02) // EOM
include "lib/steady/rans_residual.idp"
[rU, rV, rP, rK, rE] = [0.4*sin(2.*x)*y - 0.1, x*y*y, cos(x + y), -3. + 0.3*sin(x - y), -4. + 0.5*x*y];
ransLocate();
ransSplit();
real[int] mine(Xh.ndof);
ransBalance(mine);
varf mixed([a, b, q, g, h], [c, d, r, l, m])
    = int2d(Th)(ransRadius*(
        (ransAlong(fU, fV, fU) - ransForceX)*c + ransAlong(fU, fV, fV)*d + (ransNu + ransNut)*doubleStrain(fU, fV, c, d)
        - fP*divOf(c, d) - r*divOf(fU, fV) - 1e-8*fP*r/(ransSpeed*ransLength) + ransGradDiv*divOf(fU, fV)*divOf(c, d)
        + ransTauM*(strongX*ransAlong(fU, fV, c) + strongY*ransAlong(fU, fV, d))
        + ransAlong(fU, fV, fK)*l + (ransNu + ransNut/ransSigmaK)*(gradDot(fK, l) - gradDot(fK, fK)*l) + (ransRate - ransCmu*producedOf(fU, fV)/ransRate)*l
        + ransAlong(fU, fV, fE)*m + (ransNu + ransNut/ransSigmaE)*(gradDot(fE, m) - gradDot(fE, fE)*m) + (ransC2*ransRate - ransC1*ransCmu*producedOf(fU, fV)/ransRate)*m
        + ransTauT*(strongK*ransAlong(fU, fV, l) + strongE*ransAlong(fU, fV, m))));
varf scales([a, b, q, g, h], [c, d, r, l, m])
    = int2d(Th)(ransRadius*(ransSpeed^2*(c + d) + ransSpeed*r)/ransLength + ransRadius*ransRate*(l + m));
Zh timeM = 1./sqrt((4.*sqrt(fU^2 + fV^2)/ransSize)^2 + (16.*(ransNu + ransNut)/ransSize^2)^2);
Zh timeT = 1./sqrt((2.*sqrt(fU^2 + fV^2)/ransSize)^2 + (4.*(ransNu + ransNut/ransSigmaE)/ransSize^2)^2 + ransRate^2);
func real weight() { return AXIS*y + 1. - AXIS; }
varf borders([a, b, q, g, h], [c, d, r, l, m]) = int1d(Th, 1)(weight()*(wallFriction(fK)/wallPlus(fK)*(fU*c + fV*d) + 1e7*ransSpeed*(fU*N.x + fV*N.y)*(c*N.x + d*N.y)))
    + int1d(Th, 2)(0.5*weight()*max(-fU*N.x - fV*N.y, 0.)*(fU*c + fV*d)); // what flows in again brings no energy
real[int] exact = mixed(0, Xh), edges = borders(0, Xh), size = scales(0, Xh);
exact += edges;
exact = exact .* ransOpen;
timeM[] -= ransTauM[]; timeT[] -= ransTauT[];
cout << "FOUND " << timeM[].linfty/ransTauM[].max << " " << timeT[].linfty/ransTauT[].max;
for (int i = 0; i < 4; ++i) {
    real[int] own = mine .* ransPart(:, i), other = exact .* ransPart(:, i), scale = size .* ransPart(:, i);
    cout << " " << abs(other.l2/scale.l2/ransLevels[i] - 1.);
    real large = other.linfty;
    own -= other;
    cout << " " << own.linfty/large;
}
cout << endl;
'''.replace("AXIS", str(axis)).replace("TURNING", str(turning))).stdout
    found = list(map(float, out.split("FOUND")[1].split()[:10]))
    assert len(found) == 10 and max(found) < 1e-11


@pytest.mark.parametrize("retau, cells", [(2000, 20), (5000, 40)])
def test_channel_friction_is_that_of_dean_and_direct_simulation(freefem, run_folder, retau, cells):
    found = run(freefem, run_folder, "turbulent_channel", "-retau", retau, "-cells", cells)
    assert found["residual"] <= 1e-6
    assert abs(found["friction_error_direct"]) < 0.05 and abs(found["friction_error"]) < 0.05
    assert abs(found["friction_error_nearer"]) == min(abs(found["friction_error"]), abs(found["friction_error_karman"]))
    assert found["log_law_worst"] < 0.05


def developed(retau, cells, axis):
    """Friction coefficient and k at the wall of the developed flow (lib/steady/rans_model.idp, cases/turbulent_channel.edp) by a solver of ordinary
    differential equations: ln k, ln epsilon and their fluxes over the radius, whose total stress is r."""
    nu = 1 / retau

    def friction(K):
        return 0.09**0.25 * np.exp(K / 2)

    def away(K):
        return max(30 * nu / friction(K), 0.5 / cells)

    def slopes(r, y):
        k, rate, weight = np.exp(y[0]), np.exp(y[2] - y[0]), np.maximum(r, 1e-9)**axis
        eddy = 0.09 * k / rate
        made = eddy * (r / (nu + eddy))**2
        return np.array([y[1] / weight / (nu + eddy) / k, weight * (k * rate - made),
                         y[3] / weight / (nu + eddy / 1.3) / (k * rate), weight * rate * (1.92 * k * rate - 1.44 * made)])

    def ends(a, b):
        return np.array([a[1], a[3], b[1], b[2] - np.log(friction(b[0])**3 / (0.41 * away(b[0])))])

    r = np.append(1 - np.geomspace(1 - 1e-6, 1e-3, 200), 1)
    found = solve_bvp(slopes, ends, r, [np.log(1 + 2.3 * r), 0 * r, np.log((0.2 + r) / (0.41 * (1 - r + 30 * nu))), 0 * r], tol=1e-6, max_nodes=100000)
    assert found.success
    r = np.linspace(1e-6, 1, 20001)
    K, _, E, _ = found.sol(r)
    mean = np.log(9 * friction(K[-1]) * away(K[-1]) / nu) / 0.41 / friction(K[-1]) + np.trapezoid(r**(2 + axis) / (nu + 0.09 * np.exp(2 * K - E)), r)
    beyond = max(0.5 / cells, 30 / retau)  # the layer between mesh and wall, by the law of the wall
    speed = (1 + beyond)**0.5
    layer = speed * beyond * (np.log(9 * speed * beyond * retau) - 1) / 0.41
    return 2 * speed**2 / ((mean + (1 + axis) * layer) / (1 + beyond)**(1 + axis))**2, np.exp(K[-1]) / speed**2


@pytest.mark.parametrize("retau, axis", [(500, 0), (500, 1), (5000, 0), (5000, 1)])
def test_developed_flow_is_that_of_the_model_along_one_line(freefem, run_folder, retau, axis):
    """At 500 the model itself, whatever the scheme, has 6.5 % less friction than Dean's law; finer meshes come nearer to it (0.2 % with 40 cells)."""
    found = run(freefem, run_folder, "turbulent_channel", "-retau", retau, "-cells", 20, "-axisymmetric", axis)
    friction, energy = developed(retau, 20, axis)
    assert found["friction_coefficient"] == pytest.approx(friction, rel=0.008)
    assert found["k_wall_plus"] == pytest.approx(energy, rel=0.004)


def test_a_channel_too_slow_for_the_law_of_the_wall_is_refused(freefem, freefem_refused, run_folder, tmp_path):
    line = freefem_refused(3, "cases/turbulent_channel.edp", "-retau", 99, "-out", tmp_path / "none")
    assert "too low for the law of the wall" in line and not (tmp_path / "none").exists()
    assert "warning: at -retau 120" in freefem("cases/turbulent_channel.edp", "-retau", 120, "-cells", 12, "-out", run_folder).stdout
    found = results(run_folder)  # Re = 5073: below the range of Dean's law
    assert found["reynolds_bulk"] < 6000 and "friction_law" not in found and "friction_error" not in found


def test_a_periodic_flow_has_no_coarser_mesh(freefem, freefem_refused, tmp_path):
    assert "unknown option -coarse" in freefem_refused(3, "cases/turbulent_channel.edp", "-coarse", 2, "-out", tmp_path / "run")
    assert "-coarse" not in freefem("cases/turbulent_channel.edp", "-help").stdout
    assert "-coarse" in freefem("cases/pipe_flow.edp", "-help").stdout


def test_pipe_friction_is_that_of_prandtl(freefem, run_folder):
    found = run(freefem, run_folder, "turbulent_channel", "-retau", 5000, "-cells", 20, "-axisymmetric", 1)
    assert abs(found["friction_error"]) < 0.05


def test_a_turbulent_flow_that_fails_on_the_coarsest_mesh_starts_anew(freefem, run_folder):
    """At four times the Reynolds number the mesh of 16 times fewer triangles has no solution that is found."""
    found = run(freefem, run_folder, "turbulent_step", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-tolerance", 0.1, "-reynolds", 176000)
    assert found["residual"] <= 0.1 and abs(found["flux_defect"]) < 0.01


TOO_SLOW = "step heights in the mean, whatever the cells; take a higher -reynolds"


def test_a_step_too_slow_for_the_law_of_the_wall_is_told(freefem, run_folder):
    assert TOO_SLOW in freefem("cases/turbulent_step.edp", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-tolerance", 0.1, "-reynolds", 5000, "-out", run_folder).stdout


def test_step_reattaches(freefem, run_folder):
    # The range is that of coarse meshes; tools.validate_steady judges the fine one.
    done = freefem("cases/turbulent_step.edp", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-out", run_folder)
    found = results(run_folder)
    assert found["residual"] <= 1e-6 and TOO_SLOW not in done.stdout
    assert 5 < found["reattachment_over_height"] < 7.5
    assert abs(found["flux_defect"]) < 1e-3
    zones = rows(run_folder / "zones.csv")
    assert any(zone["side"] == -1 and zone["separation"] < 1 for zone in zones)


def test_lengths_behind_the_laminar_step_are_those_of_finite_differences(freefem, run_folder, tmp_path, monkeypatch):
    """Two coarse grids of the second scheme, extrapolated, beside the suite in a shorter channel and the table of fine grids."""
    monkeypatch.setattr(step_by_differences, "CONTINUED", (100, 250, 500, 800))  # fewer Reynolds numbers on the way
    coarse = [float(cell) for cell in run_tool("peers.step_by_differences", 15, 20).stdout.splitlines()[-1].split(",")[1:]]
    fine = read_table(ROOT / "tests" / "reference" / "backward_step_second_schemes.csv")["differences"]
    assert coarse == pytest.approx(fine, rel=0.005)
    short = make_mesh(tmp_path / "short.mesh", "backward_step", "--inlet-length", 10, "--outlet-length", 40)
    found = run(freefem, run_folder, "backward_step", "-mesh", short, "-tolerance", 1e-6)
    own = [found[name] for name in ("x1_lower_reattachment", "x4_upper_separation", "x5_upper_reattachment")]
    assert own == pytest.approx(fine, rel=0.01)


SHORT = ["-reynolds", "100", "-model", "laminar"]


@pytest.fixture(scope="module")
def coarse_pipe(tmp_path_factory):
    """A coarse mesh of the pipe with its bodies."""
    return make_mesh(tmp_path_factory.mktemp("pipe") / "pipe.mesh", "pipe_flow", "--size", 0.02)


@pytest.fixture(scope="module")
def pipe_run(tmp_path_factory, coarse_pipe):
    """A run of laminar flow through the coarse pipe, which the tests copy."""
    folder = tmp_path_factory.mktemp("pipe_run") / "run"
    run_freefem("cases/pipe_flow.edp", "-mesh", coarse_pipe, *SHORT, "-out", folder)
    return folder


def test_laminar_pipe_and_its_state(freefem_text, run_folder, pipe_run):
    shutil.copytree(pipe_run, run_folder)
    found = results(run_folder)
    assert found["residual"] <= 1e-6 and found["factorisations"] <= 10
    assert abs(found["flux_defect"]) < 1e-6
    assert found["speed_most_at_the_walls_edge_of_the_mesh"] < 1e-9
    assert found["diaphragm_lower_length"] > 0 and found["obstacle_upper_length"] > 0
    assert found["diaphragm_throat_speed_most"] > 2
    fine, values = read_field(run_folder / "fields.vtu")
    speed = np.hypot(*values["velocity"][:, :2].T)
    fastest = np.hypot(fine.points[:, 0] - found["speed_most_x"], fine.points[:, 1] - found["speed_most_y"])
    assert fastest.min() < 1e-6 and speed[fastest.argmin()] == pytest.approx(found["speed_most"], rel=1e-5) and found["speed_most"] > 0.98 * speed.max()
    text = f'''
include "lib/mesh/read_mesh.idp"
mesh Th = meshRead("{run_folder}/mesh.mesh");
include "lib/steady/saved_flow.idp"
steadyLoad("{run_folder}");
cout.precision(12);
cout << "FOUND " << int1d(Th, labelInlet)(-steadyU*N.x) << " " << steadyDensity << " " << steadyModel
     << " " << steadyMatches("{run_folder}", "another setting") << endl;
'''
    words = freefem_text(text).stdout.split("FOUND")[1].split()
    assert float(words[0]) == pytest.approx(found["flux_in"], rel=1e-9)
    assert words[1:4] == ["998.2", "laminar", "0"]
    # a state whose mesh was changed is refused
    with open(run_folder / "mesh.mesh", "a") as file:
        file.write("\n")
    refused = freefem_text(text, check=False)
    assert refused.returncode == 3 and "does not belong" in refused.stderr


def test_a_state_that_is_saved_is_the_one_that_is_loaded(freefem_text, tmp_path):
    out = freefem_text(f"""
mesh Th = square(3, 3);
savemesh(Th, "{tmp_path}/mesh.mesh");
include "lib/steady/saved_flow.idp"
steadyU = x*y; steadyV = x - y^2; steadyP = 3.*x; steadyK = 1. + y; steadyEpsilon = 2. + x*y; steadyNut = 0.1*x;
steadyDensity = 7; steadyViscosity = 0.5; steadyResidual = 1e-7; steadyModel = "k-epsilon";
real[int] u = steadyU[], v = steadyV[], p = steadyP[], k = steadyK[], e = steadyEpsilon[], n = steadyNut[];
steadySave("{tmp_path}", "one");
steadyU = 0; steadyV = 0; steadyP = 0; steadyK = 0; steadyEpsilon = 0; steadyNut = 0; steadyDensity = 1; steadyViscosity = 1; steadyResidual = 1; steadyModel = "none";
steadyLoad("{tmp_path}");
u -= steadyU[]; v -= steadyV[]; p -= steadyP[]; k -= steadyK[]; e -= steadyEpsilon[]; n -= steadyNut[];
cout << "FOUND " << u.linfty + v.linfty + p.linfty + k.linfty + e.linfty + n.linfty << " " << steadyDensity << " " << steadyViscosity << " " << steadyResidual << " " << steadyModel
    << " " << steadyMatches("{tmp_path}", "one") << steadyMatches("{tmp_path}", "two") << endl;
exec("sed -i '$d' '{tmp_path}/steady_flow.txt'"); // its last line
cout << "BROKEN " << steadyMatches("{tmp_path}", "one") << endl;
""").stdout
    words = out.split("FOUND")[1].split()
    assert float(words[0]) < 1e-14 and words[1:6] == ["7", "0.5", "1e-07", "k-epsilon", "10"] and out.split("BROKEN")[1].split()[0] == "0"


def test_a_flow_that_is_not_converged_is_not_kept(freefem, freefem_refused, run_folder, coarse_pipe, pipe_run):
    words = ["-mesh", coarse_pipe, *SHORT]
    shutil.copytree(pipe_run, run_folder)
    assert (run_folder / "steady_flow.txt").is_file()
    refused = freefem_refused(4, "cases/pipe_flow.edp", *words, "-out", run_folder, "-overwrite", 1, "-steps", 1)
    assert "the residual is" in refused and (run_folder / "fields.vtu").is_file()
    assert not list(run_folder.glob("steady_flow.txt*"))
    taken = freefem("cases/pipe_transport.edp", *words, "-flow", run_folder, "-number", 1, "-tend", 0.004, "-out", run_folder / "carried")
    assert "computing the steady flow" in taken.stdout


@pytest.mark.parametrize("args, says", [
    (["-model", "k-omega"], "must be one of"),
    (["-mesh", "nowhere.mesh"], "nowhere.mesh"),
    (["-axisymmetric", "1"], "axis"),
    (["-intensity", "2"], "between"),
    (["-reynolds", "900"], "give -model laminar"),
    (["-modle", "laminar"], "-model"),
])
def test_bad_input_is_refused(freefem, run_folder, args, says):
    refused = freefem("cases/pipe_flow.edp", "-out", run_folder, *args, check=False)
    assert refused.returncode == 3
    assert says in refused.stderr and refused.stderr.startswith("error: ")
    assert not run_folder.exists()


@pytest.mark.slow
@pytest.mark.parametrize("model, least, most", [("k-epsilon", 3.5, 4), ("kato-launder", 3, 3.5)])
def test_turbulent_pipe(freefem, run_folder, model, least, most):
    found = run(freefem, run_folder, "pipe_flow", "-model", model)
    assert found["residual"] <= 1e-6
    assert found["cpu_time"] < 180
    # Borda and Carnot for the diaphragm alone: 4.4; here the jet has not mixed when it leaves
    assert least < found["loss_coefficient"] < most


def test_what_enters_and_heads_are_those_of_the_fields(freefem, run_folder, tmp_path):
    """A turbulent channel: k and eddy viscosity at the inlet by their formulas; pressure and loss from the fields, p + 2/3 rho k + rho u^2/2 weighted by the flux."""
    box = write_box(tmp_path / "box.mesh", 0.5, -0.1, 0.1, 20, 16, 3)
    found = run(freefem, run_folder, "pipe_flow", "-mesh", box, "-model", "k-epsilon", "-pressure", 50000, "-intensity", 0.1, "-profile", "parabola")
    mesh, data = read_field(run_folder / "fields.vtu")
    points = mesh.points
    ends = []
    for x in (0, 0.5):
        side = np.flatnonzero(np.abs(points[:, 0] - x) < 1e-9)
        y, order = np.unique(points[side, 1].round(9), return_index=True)
        ends.append((y, {name: np.asarray(values)[side[order]] for name, values in data.items()}))
    (y, inlet), (_, outlet) = ends
    energy = 1.5 * (0.1 * 2 * 2 / 3) ** 2
    assert inlet["k"] == pytest.approx(energy, rel=1e-6)
    away = 0.1 - np.abs(y[::2]) + 30 * 2 * 0.2 / found["reynolds"] / (0.09**0.25 * energy**0.5)  # from the wall, of which the mesh leaves out 30 wall units at least
    assert inlet["epsilon"][::2] == pytest.approx(0.09**0.75 * energy**1.5 / np.minimum(0.07 * 0.2, 0.41 * away), rel=1e-5)
    assert data["nu_t"].max() == pytest.approx(found["turbulent_viscosity_over_molecular_most"] * 2 * 0.2 / found["reynolds"], rel=1e-6)

    def mean(weight, values):  # the nodes are ends and middles of edges: Simpson's rule
        rule = np.resize([2.0, 4.0], len(y))
        rule[[0, -1]] = 1
        return rule @ (weight * values) / (rule @ weight)

    heads = [mean(side["velocity"][:, 0], side["pressure"] + 2 / 3 * 1000 * side["k"] + 500 * (side["velocity"] ** 2).sum(axis=1)) for side in (inlet, outlet)]
    assert abs(mean(np.ones(len(y)), outlet["pressure"] + 2 / 3 * 1000 * outlet["k"])) < 5  # an outlet free of traction: the pressure is without 2/3 rho k, here 40 Pa
    assert found["head_loss"] == pytest.approx(heads[0] - heads[1], rel=0.01)  # without 2/3 rho k a quarter less
    walls, length = rows(run_folder / "wall.csv"), 0.2
    borne = sum(row["shear"] * row["length"] for row in walls)
    push = [length * mean(np.ones(len(y)), side["pressure"] + 2 / 3 * 1000 * side["k"] + 1000 * side["velocity"][:, 0] ** 2) for side in (inlet, outlet)]
    assert len(walls) == 40 and borne == pytest.approx(push[0] - push[1], rel=0.05)  # pressure and momentum that go in and do not come out
    assert found["pressure_inlet"] == pytest.approx(50000 + mean(np.ones(len(y)), inlet["pressure"]), abs=0.1)
    assert found["loss_coefficient"] == pytest.approx(found["head_loss"] / (500 * (4 / 3) ** 2), rel=5e-3)


def test_the_jet_of_a_narrow_slit_contracts(freefem, run_folder):
    # The standard production makes turbulence where the stream is only accelerated: 0.72 (within 20 %).
    found = run(freefem, run_folder, "diaphragm_loss", "-opening", 0.2, "-cells", 6, "-outlet", 8, "-tolerance", 1e-3)
    assert found["contraction"] == pytest.approx(found["contraction_mises"], rel=0.05)
    assert found["loss_over_borda_carnot"] == pytest.approx(1, abs=0.1)
    assert found["factorisations"] < 10  # 12 where old factors serve only a residual that falls to six tenths (to a tolerance of 1e-6: 34 for 7)


def test_epsilon_at_the_wall_gives_the_mean_over_its_triangle(freefem_text):
    # The mean of 1/y from d to d + H, and that of the exponential that is linear in the logarithm between a/d and 1/(d + H).
    out = freefem_text("""
include "lib/core/errors.idp"
real lenEdge = 1, area = 0, ransNu = 1e-3, ransTurning = 0, ransTiny = 1, ransAxis = 0, y = 1;
include "lib/steady/rans_model.idp"
for (int k = 0; k < 5; ++k) {
    real K = 2. + k, height = 0.1 + 0.1*k;
    area = 0.5*height;
    cout << "FOUND " << height << " " << wallUnits(K)*ransNu/wallFriction(K) << " " << wallFriction(K) << " " << exp(wallRate(K)) << endl;
}
""").stdout
    for line in out.split("FOUND")[1:]:
        height, distance, friction, rate = map(float, line.split()[:4])
        a, b = rate * 0.41 / friction**3, 1 / (distance + height)
        assert height * (a - b) / math.log(a / b) == pytest.approx(math.log(1 + height / distance), rel=5e-4)  # Carlson's rule for the logarithmic mean


@pytest.mark.slow
@pytest.mark.parametrize("opening", [0.5])
def test_diaphragm_loss_is_that_of_borda_and_carnot(freefem, run_folder, opening):
    found = run(freefem, run_folder, "diaphragm_loss", "-opening", opening)
    assert found["loss_over_borda_carnot"] == pytest.approx(1, abs=0.1)
    assert found["contraction"] == pytest.approx(found["contraction_mises"], rel=0.06)


def test_the_pictures_are_drawn(run_folder, pipe_run):
    from tools import plot_steady
    shutil.copytree(pipe_run, run_folder)
    assert plot_steady.main([str(run_folder)]) == 0
    mesh, (fine, values) = read_mesh(run_folder / "mesh.mesh"), read_field(run_folder / "fields.vtu")
    assert len(fine.triangles) == 4 * len(mesh.triangles) and len(values["velocity"]) == len(fine.points)
    for name in ("streamlines", "speed", "pressure", "walls"):
        assert (run_folder / f"{name}.png").stat().st_size > 5000
    assert not (run_folder / "k.png").exists()
    for name, old, new, words in (("wall.csv", ",-0.1,-1,", ",nan,-1,", "wall.csv, line 2: y is nan"), ("run.json", '"-reynolds": ', '"-reynolds": "abc", "-was": ', '-reynolds must be a number, not "abc"'),
                                  ("zones.csv", "separation", "parting", "zones.csv has no column separation")):
        whole = (run_folder / name).read_text()
        assert old in whole
        (run_folder / name).write_text(whole.replace(old, new, 1))
        with pytest.raises(BadInput, match=words):
            plot_steady.main([str(run_folder), "--out", str(run_folder / "none")])
        (run_folder / name).write_text(whole)
    (run_folder / "zones.csv").unlink()
    with pytest.raises(BadInput, match="has no zones.csv"):
        plot_steady.main([str(run_folder), "--out", str(run_folder / "none")])
    assert not (run_folder / "none").exists()


def test_a_tall_narrow_flow_is_drawn(freefem, run_folder, monkeypatch):
    """A strip 27 times as high as long: as many lines as the page holds, on a page of that shape."""
    from tools import plot_steady
    from tools.plotting import plt
    run(freefem, run_folder, "turbulent_channel", "-cells", 40, "-model", "laminar", "-retau", 20)
    drawn, asked = plt.Axes.streamplot, []
    labels = []
    monkeypatch.setattr(plt, "close", lambda figure: labels.extend(word for one in figure.axes for word in (one.get_xlabel(), one.get_ylabel())))
    monkeypatch.setattr(plt.Axes, "streamplot", lambda *given, density, **more: asked.append(density) or drawn(*given, density=np.minimum(density, 7), **more))
    assert plot_steady.main([str(run_folder)]) == 0
    assert np.max(asked) < 7
    assert {"x (L)", "y (L)", "speed (L/T)", "gauge pressure (M/(L T$^2$))"} <= set(labels) and not [word for word in labels if "m" in word.partition(" (")[2] or "Pa)" in word]
    high, wide = plt.imread(run_folder / "speed.png").shape[:2]
    assert high > 1.5 * wide
    file = run_folder / "wall.csv"  # as it is between planes of symmetry
    file.write_text(file.read_text().splitlines()[0] + "\n")
    assert plot_steady.main([str(run_folder), "--out", str(run_folder / "none")]) == 0
    assert {one.name for one in (run_folder / "none").iterdir()} == {"streamlines.png", "speed.png", "pressure.png"}


def test_the_steady_flow_does_not_hang_on_units(freefem, tmp_path):
    """Reynolds number 20 in any units: the same drag coefficient."""
    coarse = make_mesh(tmp_path / "coarse.mesh", "cylinder_channel", "--circle-points", 16, "--size", 0.1)
    drags = [run(freefem, tmp_path / str(k), "cylinder_steady", "-mesh", coarse, "-mu", mu, "-speed", speed)["drag_coefficient"] for k, (mu, speed) in enumerate(((1e-3, 0.3), (1e-9, 3e-7), (1e3, 3e5)))]
    assert drags[1:] == pytest.approx([drags[0]] * 2, rel=1e-9)


def test_a_turbulent_flow_does_not_hang_on_units(freefem, tmp_path):
    """Reynolds number 4e5 at 2e-9 and 2e-15 m/s: the factors ran out of room there, and the run ended in the middle with status 0."""
    box = write_box(tmp_path / "box.mesh", 0.5, -0.1, 0.1, 20, 16, 3)
    losses = [run(freefem, tmp_path / str(speed), "pipe_flow", "-mesh", box, "-vmax", speed, "-reynolds", 4e5)["loss_coefficient"] for speed in (2, 2e-9, 2e-15)]
    assert losses[1:] == pytest.approx([losses[0]] * 2, rel=1e-6)


def test_a_creeping_flow_has_the_viscosity_that_was_asked_for(freefem, run_folder):
    """Rounding stops the residual above the tolerance there; a thinner fluid was solved instead."""
    done = freefem("cases/cylinder_steady.edp", "-mu", 1e3, "-out", run_folder)
    assert results(run_folder)["drag_coefficient"] / 1e3 == pytest.approx(3142.56, rel=1e-4)
    assert "viscosity 0.99" not in done.stdout and "rounding keeps the residual at 1." in done.stdout


def test_a_flow_that_is_not_found_says_so(freefem_refused, tmp_path):
    line = freefem_refused(4, "cases/cavity.edp", "-reynolds", 1e6, "-steps", 5, "-out", tmp_path / "run")
    assert "lower Reynolds number" in line and "(at 7071.07 times the viscosity a flow was found)" in line
    assert '"status": "failed (4)"' in (tmp_path / "run/run.json").read_text() and not (tmp_path / "run/.writer").exists()


def test_half_a_pipe_needs_its_axis(freefem_refused, tmp_path):
    mesh = write_box(tmp_path / "pipe.mesh", 1.0, 0.0, 0.1, 24, 6, bottom=8)
    assert "-axisymmetric 1" in freefem_refused(3, "cases/pipe_flow.edp", "-mesh", mesh, "-model", "laminar", "-reynolds", 100, "-out", tmp_path / "run")


def sides(prefix, *corners):
    """FreeFEM borders round corners (x, y, label of the side from there on, edges)."""
    lines, calls = [], []
    for k, (x, y, label, edges) in enumerate(corners):
        to = corners[(k + 1) % len(corners)]
        name = f"{prefix}{k}"
        lines.append(f"border {name}(t = 0, 1) {{ x = {x} + t*({to[0] - x}); y = {y} + t*({to[1] - y}); label = {label}; }}")
        calls.append(f"{name}({edges})")
    return "\n".join(lines), " + ".join(calls)


def test_walls_of_a_body_in_the_stream(freefem, freefem_text, run_folder, tmp_path):
    """A long block in mid-channel leaves two gaps: in the middle of them both walls have the shear of a plane Poiseuille flow, and nothing flows back."""
    outer, pipe = sides("outer", (0, -0.1, 3, 60), (1, -0.1, 2, 16), (1, 0.1, 3, 60), (0, 0.1, 1, 16))
    inner, block = sides("inner", (0.25, -0.05, 5, 12), (0.25, 0.05, 5, 50), (0.75, 0.05, 5, 12), (0.75, -0.05, 5, 50))
    freefem_text(f'{outer}\n{inner}\nmesh Th = buildmesh({pipe} + {block});\nsavemesh(Th, "{tmp_path}/block.mesh");\n')
    found = run(freefem, run_folder, "pipe_flow", "-mesh", tmp_path / "block.mesh", "-model", "laminar", "-reynolds", 1, "-vmax", 1)
    mu = 998.2 * 0.2
    exact = 6 * mu * found["flux_in"] / 2 / 0.05**2
    middle = [r for r in rows(run_folder / "wall.csv") if 0.45 < r["x"] < 0.55]
    assert len({(r["wall"], r["side"]) for r in middle}) == 4
    for r in middle:
        assert r["shear"] == pytest.approx(exact, rel=0.02)
    assert rows(run_folder / "zones.csv") == []


def test_the_profile_is_that_of_a_narrow_inlet(freefem, freefem_text, run_folder, tmp_path):
    outer, calls = sides("outer", (0, 0, 8, 50), (1, 0, 2, 12), (1, 0.1, 3, 40), (0.3, 0.1, 3, 8), (0.3, 0.05, 3, 20), (0, 0.05, 1, 8))
    freefem_text(f'{outer}\nmesh Th = buildmesh({calls});\nsavemesh(Th, "{tmp_path}/wider.mesh");\n')
    found = run(freefem, run_folder, "pipe_flow", "-mesh", tmp_path / "wider.mesh", "-model", "laminar", "-reynolds", 20, "-vmax", 2, "-axisymmetric", 1)
    assert found["flux_in"] == pytest.approx(math.pi * 0.05**2, rel=1e-9) and found["mean_velocity"] == pytest.approx(1, rel=1e-9)


def test_a_creeping_flow_keeps_its_mass(freefem, run_folder, coarse_pipe):
    """2 % were lost at a Reynolds number of 1e-6."""
    found = run(freefem, run_folder, "pipe_flow", "-mesh", coarse_pipe, "-reynolds", "1e-6", "-model", "laminar")
    assert abs(found["flux_defect"]) < 1e-6


def test_pipe_flow_refuses_an_inlet_on_the_right(tmp_path, run_folder, coarse_pipe):
    script, mesh = tmp_path / "mirror.edp", tmp_path / "mirror.mesh"
    script.write_text(f'mesh Th = readmesh("{coarse_pipe}");\nTh = movemesh(Th, [1 - x, y]);\nsavemesh(Th, "{mesh}");\n')
    run_freefem(script)
    done = run_freefem("cases/pipe_flow.edp", "-mesh", mesh, *SHORT, "-out", run_folder, check=False)
    assert done.returncode == 3 and "one upright inlet" in done.stderr


def test_pipe_flow_tells_what_large_elements_at_the_walls_do(freefem, run_folder, tmp_path):
    """A straight round pipe: the stream of the inlet's profile, and the friction of the law of the wall that stands far off the wall."""
    coarse = write_box(tmp_path / "pipe.mesh", 1.0, 0.0, 0.1, 20, 8, bottom=8)
    out = freefem("cases/pipe_flow.edp", "-mesh", coarse, "-axisymmetric", 1, "-profile", "power", "-out", run_folder).stdout
    found = results(run_folder)
    assert f"its mean is {found['mean_velocity']:.6g} m/s, not 1.63333" in out
    assert f"at a mean distance of {100 * found['wall_distance_mean'] / 0.1:.0f} % of the pipe's radius" in out and "take smaller elements at the walls" in out
    out = freefem("cases/pipe_flow.edp", "-mesh", coarse, "-axisymmetric", 1, "-reynolds", 5000, "-out", run_folder, "-overwrite", 1).stdout
    found = results(run_folder)
    assert found["wall_distance_least"] == pytest.approx(30, rel=1e-9) and found["wall_distance_most"] == 30 and f"here {100 * found['wall_distance_mean'] / 0.1:.0f} %, whatever the elements: take a higher Reynolds number" in out


def test_zones_of_slanted_walls_end_where_the_walls_do(freefem, freefem_text, tmp_path):
    """Behind a body whose sides are slanted by 63 degrees, to its very end."""
    mesh = tmp_path / "body.mesh"
    freefem_text(f"""
border low(s = 0, 1) {{ x = s; y = -0.1; label = 3; }}
border right(s = -0.1, 0.1) {{ x = 1; y = s; label = 2; }}
border top(s = 1, 0) {{ x = s; y = 0.1; label = 3; }}
border left(s = 0.1, -0.1) {{ x = 0; y = s; label = 1; }}
border b1(s = 0, 1) {{ x = 0.3 + 0.02*s; y = 0.04*s; label = 5; }}
border b2(s = 0, 1) {{ x = 0.32 + 0.02*s; y = 0.04*(1 - s); label = 5; }}
border b3(s = 0, 1) {{ x = 0.34 - 0.02*s; y = -0.04*s; label = 5; }}
border b4(s = 0, 1) {{ x = 0.32 - 0.02*s; y = -0.04*(1 - s); label = 5; }}
savemesh(buildmesh(low(50) + right(10) + top(50) + left(10) + b1(4) + b2(4) + b3(4) + b4(4)), "{mesh}");
""")
    freefem("cases/pipe_flow.edp", "-mesh", mesh, "-model", "laminar", "-reynolds", 60, "-out", tmp_path / "run")
    zones = read_table(tmp_path / "run" / "zones.csv")
    behind = (zones["separation"] > 0.3) & (zones["separation"] < 0.34)
    assert behind.any() and zones["reattachment"][behind].max() == pytest.approx(0.34, abs=1e-6)


ZONES = """
mesh Th = square(2, 2);
int measureAxis = 0;
int[int] measureWalls = [1];
include "lib/steady/measures.idp"
real[int] shear = [-3, -1, 1, 2, -5, 2, 2, 1, -1, -4, -1, 1, 1, -1, -5], side = [-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 1, 1, 1], piece = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 1];
wallX.resize(15); wallAlong.resize(15); wallShear.resize(15) = shear; wallSide.resize(15) = side; wallPiece.resize(15) = piece;
wallAlong = 0.1;
for (int i = 0; i < 15; ++i) wallX[i] = 0.05 + 0.1*(i < 10 ? i : i - 10);
wallX[12] = 0.05; wallX[13] = 0.15; wallX[14] = 0.65;
for (int k = 0; k < 2; ++k) {
    int number = measureZones((k ? 0.19 : 0.05));
    cout.precision(15);
    for (int i = 0; i < number; ++i) cout << "ZONE " << k << " " << zones(i, 0) << " " << zones(i, 1) << " " << zones(i, 2) << " " << zones(i, 3) << " " << zones(i, 4) << " " << zones(i, 5) << endl;
}
"""


def test_zones_are_what_the_shear_along_each_wall_says(freefem_text):
    """From the beginning of a wall or where a straight line between two edges passes 0; no zone goes over to another wall or side. Short ones and short parts between two are left out."""
    found = [list(map(float, line.split()[1:])) for line in freefem_text(ZONES).stdout.splitlines() if line.startswith("ZONE")]
    whole = [[-1, 0, 0.2, 0.2, -3, 0], [-1, 0.35 + 0.2 / 7, 0.45 + 0.5 / 7, 0.1 + 0.3 / 7, -5, 0], [-1, 0.8, 1, 0.2, -4, 0], [-1, 0, 0.1, 0.1, -1, 1], [1, 0.1, 0.2, 0.1, -1, 0], [1, 0.6, 0.7, 0.1, -5, 1]]
    long = [[-1, 0, 0.45 + 0.5 / 7, 0.45 + 0.5 / 7, -5, 0], [-1, 0.8, 1, 0.2, -4, 0]]
    np.testing.assert_allclose(found, [[0, *zone] for zone in whole] + [[1, *zone] for zone in long], atol=1e-12)


MEANS = """
mesh Th = square(4, 4, [x, 2.*y]);
int measureAxis = AXIS;
int[int] measureWalls = [1], right = [2];
include "lib/steady/measures.idp"
steadyDensity = 3; steadyU = 1. + y; steadyV = 2.*y; steadyP = 5.*y; steadyK = 0.3 + 0.*x;
cout.precision(12);
cout << "FOUND " << measureFlux(right) << " " << measureMeanPressure(right) << " " << measureHead(right) << endl;
"""


@pytest.mark.parametrize("axis", [0, 1])
def test_means_over_a_section_are_those_of_the_plane_or_round_one(axis, freefem_text):
    y, rule = np.polynomial.legendre.leggauss(8)
    y, weight = 1 + y, rule * (2 * np.pi * (1 + y) if axis else 1)
    u, p, speed2 = 1 + y, 5 * y, (1 + y) ** 2 + 4 * y**2
    flux = weight @ u
    expected = [flux, weight @ p / weight.sum(), weight @ ((p + 2 / 3 * 3 * 0.3 + 1.5 * speed2) * u) / flux]
    assert list(map(float, freefem_text(MEANS.replace("AXIS", str(axis))).stdout.split("FOUND")[1].split()[:3])) == pytest.approx(expected, rel=1e-9)


# A case of one's own in a box; SIDES: labels below, on the right, above, on the left.
OWN = """
include "lib/core/output.idp"
include "lib/mesh/read_mesh.idp"
optCase("own", "a box");
optDefault("-model", "laminar");
string meshFile = "";
int[int] sides = [SIDES];
mesh Th = square(4, 4, [x, y - LOW], label = sides);
real densityFluid = 1, viscosityFluid = 1, steadySpeed = 1, steadyLength = 1, steadyForce = 0, outletPressure = 0, steadyZoneLeast = 0.1, inletEnergy = 1, inletLength = 1;
int steadyAxis = AXIS;
string steadySetting = "own";
macro inletU() 1. // EOM
include "scripts/steady.edp"
"""


@pytest.mark.parametrize("sides, low, axis, says", [
    ("3, 8, 2, 1", 0, 0, "must be horizontal"),  # let the fluid through, in silence
    ("3, 2, 3, 1", 0.5, 1, "begins at y = -0.5"),  # "give more -steps, a larger -tolerance, a finer mesh"
])
def test_an_axis_that_is_none_is_refused(sides, low, axis, says, freefem_text, run_folder):
    done = freefem_text(OWN.replace("SIDES", sides).replace("LOW", str(low)).replace("AXIS", str(axis)), "-out", run_folder, check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not run_folder.exists()


@pytest.mark.parametrize("model", ["laminar", "k-epsilon"])
def test_a_stream_may_enter_aslant(model, freefem_text, run_folder):
    """What a case gives at the inlet stands there, whether the flow is found or not."""
    text = OWN.replace("SIDES", "3, 2, 3, 1").replace("LOW", "0").replace("AXIS", "0").replace("macro inletU() 1. // EOM", "macro inletU() y // EOM\nmacro inletV() 0.5*y*(1. - y) // EOM")
    freefem_text(text.replace("viscosityFluid = 1,", "viscosityFluid = 1e-4,"), "-model", model, "-steps", 1, "-out", run_folder, check=False)
    fine, values = read_field(run_folder / "fields.vtu")
    y = fine.points[np.abs(fine.points[:, 0]) < 1e-12, 1]
    inside = (y > 1e-9) & (y < 1 - 1e-9)
    at = values["velocity"][np.abs(fine.points[:, 0]) < 1e-12]
    assert len(y) == 9 and at[inside, 0] == pytest.approx(y[inside], abs=1e-6) and at[inside, 1] == pytest.approx(0.5 * (y * (1 - y))[inside], abs=1e-6)


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
        freefem_text(KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", str(turned)), "-cells", cells, "-out", tmp_path / f"run{turned}{cells}")
        found = results(tmp_path / f"run{turned}{cells}")
        errors.append(found["error"])
        assert found["pull"] == pytest.approx(4 / 40 * (math.exp(-rate / 2) - math.exp(rate)), rel=1e-3)  # 2 mu dv/dy, which has two signs; the pressure is the same
        assert found["left_over"] < 1e-12  # all that acts along the planes is borne at the inlet, corners included
    assert errors[1] < 3e-4 and np.log2(errors[0] / errors[1]) > 2.8
    assert errors[2] == pytest.approx(errors[1], rel=1e-5)


# Half of Poiseuille's flow; TURNED 1: along y.
HALF = r"""
include "lib/case.idp"
optCase("half", "half a channel"); optDefault("-mesh", "FOLDER/half.mesh");
real rhoFluid = 2, mu = 0.3, speed = 1, size = 1;
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall], labelsMoving = [labelInlet], labelsFree = [labelOutlet], sides = [labelAxis, labelOutlet, labelWall, labelInlet];
int turned = TURNED;
{
    mesh box = square(12, 5, [2*x, 0.5*y + SLANT*x], label = sides);
    if (turned) box = movemesh(box, [-y, x]);
    savemesh(box, "FOLDER/half.mesh");
}
macro inletU() (turned ? 0. : 1 - 4*y^2) // EOM
macro inletV() (turned ? 1 - 4*x^2 : 0.) // EOM
macro caseSymmetry() [PLANES] // EOM
macro caseResult() {
    real[int] pull(2);
    steadyForceOn(labelWall, pull);
    resultPut("wall_along", pull[turned], ""); resultPut("wall_across", (turned ? -pull[0] : pull[1]), "");
    steadyForceOn(labelAxis, pull);
    resultPut("plane_along", pull[turned], ""); resultPut("plane_across", (turned ? -pull[0] : pull[1]), "");
} // EOM
include "scripts/steady_laminar.edp"
"""


@pytest.mark.parametrize("turned", [0, 1])
def test_force_on_a_plane_of_symmetry_and_on_a_wall_that_ends_where_it_begins(freefem_text, run_folder, tmp_path, turned):
    """Shear 4 mu U/H over a length of 2, mean pressure 8 mu U/H2; no shear on the plane."""
    freefem_text(HALF.replace("FOLDER", str(tmp_path)).replace("TURNED", str(turned)).replace("SLANT", "0").replace("PLANES", "labelAxis"), "-fields", 1, "-out", run_folder)
    found = results(run_folder)
    fine, values = read_field(run_folder / "fields.vtu")
    assert found["reynolds"] == pytest.approx(2 / 0.3) and values["pressure"] == pytest.approx(2.4 * (2 - fine.points[:, turned]), abs=1e-6)
    assert [found[name] for name in ("wall_along", "wall_across", "plane_across")] == pytest.approx([2.4, 4.8, -4.8], rel=1e-8) and abs(found["plane_along"]) < 1e-8


@pytest.mark.parametrize("planes, slant, says", [("labelAxis", "0.1", "must be horizontal or upright"), ("labelAxis, labelWall", "0", "label 3 (wall) is listed twice"), ("labelAxis, labelLeft", "0", "no edge with label 11 (left)")])
def test_planes_of_symmetry_that_cannot_be_are_refused(freefem_text, run_folder, tmp_path, planes, slant, says):
    done = freefem_text(HALF.replace("FOLDER", str(tmp_path)).replace("TURNED", "0").replace("SLANT", slant).replace("PLANES", planes), "-out", run_folder, check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_more_let_in_than_out_across_horizontal_sides_is_refused(freefem_text, run_folder, tmp_path):
    text = KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", "1").replace("streamAt(y, -x) : c", "1.1*streamAt(y, -x)*(y < 0 ? 1. : 0.99) : c")
    done = freefem_text(text, "-out", run_folder, check=False)
    assert done.returncode == 3 and "into the domain, and there is no outlet" in done.stderr


def test_a_misspelt_velocity_at_the_inlet_is_told(freefem_text, run_folder, tmp_path):
    text = KOVASZNAY.replace("FOLDER", str(tmp_path)).replace("TURNED", "0").replace("macro inletV()", "macro inletW()").replace("(newtonV - (inletV))", "newtonV")
    assert "warning: the macro inletW is used nowhere" in freefem_text(text, "-out", run_folder).stdout
