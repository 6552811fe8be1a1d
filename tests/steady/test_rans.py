"""Steady turbulent flow by the k-epsilon model: its residual, friction, the law of the wall, the step, the diaphragm."""
import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from tests.scenes import write_box
from tests.tables import numeric_records, results, results_of


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
    found = results_of(freefem, run_folder, "turbulent_channel", "-retau", retau, "-cells", cells)
    assert found["residual"] <= 1e-6
    assert abs(found["friction_error_direct"]) < 0.05 and abs(found["friction_error"]) < 0.05
    assert abs(found["friction_error_nearer"]) == min(abs(found["friction_error"]), abs(found["friction_error_karman"]))
    assert found["log_law_worst"] < 0.05


def developed(retau, cells, axis):
    """Friction coefficient and k at the wall of the developed flow (lib/steady/rans_model.idp, cases/turbulent_channel.edp) by a
    solver of ordinary
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
    found = solve_bvp(slopes, ends, r, [np.log(1 + 2.3 * r), 0 * r, np.log((0.2 + r) / (0.41 * (1 - r + 30 * nu))), 0 * r],
        tol=1e-6, max_nodes=100000)
    assert found.success
    r = np.linspace(1e-6, 1, 20001)
    K, _, E, _ = found.sol(r)
    mean = np.log(9 * friction(K[-1]) * away(K[-1]) / nu) / 0.41 / friction(K[-1]) + np.trapezoid(r**(2 + axis)
        / (nu + 0.09 * np.exp(2 * K - E)), r)
    beyond = max(0.5 / cells, 30 / retau)  # the layer between mesh and wall, by the law of the wall
    speed = (1 + beyond)**0.5
    layer = speed * beyond * (np.log(9 * speed * beyond * retau) - 1) / 0.41
    return 2 * speed**2 / ((mean + (1 + axis) * layer) / (1 + beyond)**(1 + axis))**2, np.exp(K[-1]) / speed**2


@pytest.mark.parametrize("retau, axis", [(500, 0), (500, 1), (5000, 0), (5000, 1)])
def test_developed_flow_is_that_of_the_model_along_one_line(freefem, run_folder, retau, axis):
    """At 500 the model itself, whatever the scheme, has 6.5 % less friction than Dean's law; finer meshes come nearer to it (0.2 %
    with 40 cells)."""
    found = results_of(freefem, run_folder, "turbulent_channel", "-retau", retau, "-cells", 20, "-axisymmetric", axis)
    friction, energy = developed(retau, 20, axis)
    assert found["friction_coefficient"] == pytest.approx(friction, rel=0.008)
    assert found["k_wall_plus"] == pytest.approx(energy, rel=0.004)


def test_a_channel_too_slow_for_the_law_of_the_wall_is_refused(freefem, freefem_refused, run_folder, tmp_path):
    line = freefem_refused(3, "cases/turbulent_channel.edp", "-retau", 99, "-out", tmp_path / "none")
    assert "too low for the law of the wall" in line and not (tmp_path / "none").exists()
    assert "warning: at -retau 120" in freefem("cases/turbulent_channel.edp", "-retau", 120, "-cells", 12, "-out",
        run_folder).stdout
    found = results(run_folder)  # Re = 5073: below the range of Dean's law
    assert found["reynolds_bulk"] < 6000 and "friction_law" not in found and "friction_error" not in found


def test_a_periodic_flow_has_no_coarser_mesh(freefem, freefem_refused, tmp_path):
    assert "unknown option -coarse" in freefem_refused(3, "cases/turbulent_channel.edp", "-coarse", 2, "-out", tmp_path / "run")
    assert "-coarse" not in freefem("cases/turbulent_channel.edp", "-help").stdout
    assert "-coarse" in freefem("cases/pipe_flow.edp", "-help").stdout


def test_pipe_friction_is_that_of_prandtl(freefem, run_folder):
    found = results_of(freefem, run_folder, "turbulent_channel", "-retau", 5000, "-cells", 20, "-axisymmetric", 1)
    assert abs(found["friction_error"]) < 0.05


def test_a_turbulent_flow_that_fails_on_the_coarsest_mesh_starts_anew(freefem, run_folder):
    """At four times the Reynolds number the mesh of 16 times fewer triangles has no solution that is found."""
    found = results_of(freefem, run_folder, "turbulent_step", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-tolerance", 0.1,
        "-reynolds", 176000)
    assert found["residual"] <= 0.1 and abs(found["flux_defect"]) < 0.01


TOO_SLOW = "step heights in the mean, whatever the cells; take a higher -reynolds"


def test_a_step_too_slow_for_the_law_of_the_wall_is_told(freefem, run_folder):
    assert TOO_SLOW in freefem("cases/turbulent_step.edp", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-tolerance", 0.1,
        "-reynolds", 5000, "-out", run_folder).stdout


def test_step_reattaches(freefem, run_folder):
    # The range is that of coarse meshes; tools.validate_steady judges the fine one.
    done = freefem("cases/turbulent_step.edp", "-size", 0.25, "-inlet", 5, "-outlet", 12, "-out", run_folder)
    found = results(run_folder)
    assert found["residual"] <= 1e-6 and TOO_SLOW not in done.stdout
    assert 5 < found["reattachment_over_height"] < 7.5
    assert abs(found["flux_defect"]) < 1e-3
    zones = numeric_records(run_folder / "zones.csv")
    assert any(zone["side"] == -1 and zone["separation"] < 1 for zone in zones)


@pytest.mark.slow
@pytest.mark.parametrize("model, least, most", [("k-epsilon", 3.5, 4), ("kato-launder", 3, 3.5)])
def test_turbulent_pipe(freefem, run_folder, model, least, most):
    found = results_of(freefem, run_folder, "pipe_flow", "-model", model)
    assert found["residual"] <= 1e-6
    assert found["cpu_time"] < 180
    # Borda and Carnot for the diaphragm alone: 4.4; here the jet has not mixed when it leaves
    assert least < found["loss_coefficient"] < most


def test_epsilon_at_the_wall_gives_the_mean_over_its_triangle(freefem_text):
    # The mean of 1/y from d to d + H, and that of the exponential that is linear in the logarithm between a/d and 1/(d + H).
    out = freefem_text("""
include "lib/core/errors.idp"
real lenEdge = 1, area = 0, ransNu = 1e-3, ransTurning = 0, ransAxis = 0, y = 1;
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
        # Carlson's rule for the logarithmic mean
        assert height * (a - b) / math.log(a / b) == pytest.approx(math.log(1 + height / distance), rel=5e-4)


def test_a_narrow_orifice_has_the_discharge_of_iso_5167(freefem, run_folder):
    """ln k at the back of the plate jumped by up to 40 in every other step, and no number of steps led to a solution."""
    found = results_of(freefem, run_folder, "orifice_plate", "-opening", 0.3)
    assert found["residual"] <= 1e-6
    assert found["discharge"] == pytest.approx(found["discharge_iso5167"], rel=0.02)
    assert found["loss_share"] == pytest.approx(found["loss_share_iso5167"], abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("opening", [0.5])
def test_diaphragm_loss_is_that_of_borda_and_carnot(freefem, run_folder, opening):
    found = results_of(freefem, run_folder, "diaphragm_loss", "-opening", opening)
    assert found["loss_over_borda_carnot"] == pytest.approx(1, abs=0.1)
    assert found["contraction"] == pytest.approx(found["contraction_mises"], rel=0.06)


def test_a_turbulent_flow_does_not_hang_on_units(freefem, tmp_path):
    """Reynolds number 4e5 at 2e-9 and 2e-15 m/s: the factors ran out of room there, and the run ended in the middle with status
    0."""
    box = write_box(tmp_path / "box.mesh", 0.5, -0.1, 0.1, 20, 16, 3)
    losses = [results_of(freefem, tmp_path / str(speed), "pipe_flow", "-mesh", box, "-vmax", speed, "-reynolds",
        4e5)["loss_coefficient"] for speed in (2, 2e-9, 2e-15)]
    assert losses[1:] == pytest.approx([losses[0]] * 2, rel=1e-6)
