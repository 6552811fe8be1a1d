"""The pressure near bodies that moved, and its gradient in the velocity step."""
import numpy as np
import pytest

from tests.scenes import script
from tests.tables import rows


@pytest.mark.parametrize("way", ["rowsShare = 0", "rowsShare = 1; pressureFew = 0", "rowsShare = 1; pressureFew = 1"])
def test_a_linear_pressure_goes_with_the_disks_that_moved(way, freefem_text):
    """p = 2 x - y: its gradient is exact, so the vertices round a disk change by -d.grad p, the others not. And no wave grows that
    goes to and fro by 1.5 elements."""
    disks, moved = [(0.3, 0.4, 0.127), (0.7, 0.65, 0.11)], [(0.01, -0.004), (-0.006, 0.003)]
    text = script(disks, more=f"""
bodyMoved = [{moved[0][0]}, {moved[1][0]}, {moved[0][1]}, {moved[1][1]}, 0.3, -0.2];
pressureSetUp(1);
timeDt = 1e-6; // viscosity reaches less than an element
{way};
Qh px = x, py = y, p = 2*x - y;
flowP = p[];
pressureCarry();
for (int k = 0; k < flowNq; ++k) cout << "vertex " << px[][k] << " " << py[][k] << " " << flowP[k] - p[][k] << endl;
for (int k = 0; k < flowNq; ++k) flowP[k] = cos(1.*k*k);
bodyMoved = [1.5/16, 0, 0, 1.5/16, 0, 0];
for (int k = 0; k < 60; ++k) {{ pressureCarry(); bodyMoved *= -1.; }}
cout << "kept " << flowP.linfty << endl;
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp\"""")
    out = freefem_text(text).stdout
    assert rows(out, "kept")[0, 0] < 30  # without the third term 1e11
    x, y, change = rows(out, "vertex").T
    far = np.array([np.hypot(x - a, y - b) / r for a, b, r in disks])
    for k, (d, (_, _, r)) in enumerate(zip(moved, disks)):
        near = far[k] < 1 + 1.5 / 16 / r
        shift = -(2 * d[0] - d[1])
        np.testing.assert_allclose(change[far[k] < 1], shift, atol=1e-12)
        assert (np.isclose(change[near], shift, atol=1e-12) | (change[near] == 0)).all()
    assert (change[(far * np.array([[0.127], [0.11]]) > np.array([[0.127], [0.11]]) + 1.5 / 16).all(axis=0)] == 0).all()


@pytest.mark.parametrize("share", [0, 1])
def test_in_slow_flow_the_pressure_of_a_disk_goes_with_it_and_that_of_the_flow_stays(share, freefem_text):
    """p = 2 x - y, linear, stays; on it a bump round a disk, exp(-(r/R)^2), goes along with the disk."""
    disks, moved = [(0.3, 0.4, 0.127), (0.7, 0.65, 0.11)], [(0.01, -0.004), (-0.006, 0.003)]
    look = "flowP = p[]; windowCarry(); for (int k = 0; k < flowNq; ++k) cout << NAME << px[][k] << \" \" << py[][k] << \" \" << flowP[k] - p[][k] << endl;"
    text = script(disks, more=f"""
bodyMoved = [{moved[0][0]}, {moved[1][0]}, {moved[0][1]}, {moved[1][1]}, 0.3, -0.2];
pressureSetUp(1);
timeDt = 1e-6; // viscosity reaches less than an element
rowsShare = {share};
Qh px = x, py = y, p = 2*x - y;
{look.replace("NAME", '"linear "')}
p = 2*x - y + exp(-((x - 0.7)^2 + (y - 0.65)^2)/0.11^2);
{look.replace("NAME", '"bump "')}
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp\"""")
    out = freefem_text(text).stdout
    assert abs(rows(out, "linear")[:, 2]).max() < 1e-12
    x, y, change = rows(out, "bump").T
    x, y = x - 0.7, y - 0.65
    wanted = np.exp(-((x + 0.006) ** 2 + (y - 0.003) ** 2) / 0.11**2) - np.exp(-(x**2 + y**2) / 0.11**2)
    near = np.hypot(x, y) < 0.18
    assert abs(change - wanted)[near].max() < 0.25 * abs(wanted).max()  # 3.5 elements across


def test_the_gradient_in_the_advecting_velocity_is_that_of_a_linear_field(freefem_text):
    """At the middles of the edges inside the mesh: - dx, - dy of 2 x - y; its mean over a triangle is theirs."""
    text = script([(0.3, 0.4, 0.127)], more="""
Qh p = 2*x - y;
real[int] u = flowBX'*p[], v = flowBY'*p[];
u .*= pressureLump; v .*= pressureLump;
for (int T = 0; T < Th.nt; ++T) for (int k = 3; k < 6; ++k) { int i = Wh(T, k); if (flowX[i] > 0.01 && flowX[i] < 0.99 && flowY[i] > 0.01 && flowY[i] < 0.99) cout << "middle " << u[i] << " " << v[i] << endl; }
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp\"""")
    u, v = rows(freefem_text(text).stdout, "middle").T
    assert len(u) > 1000
    np.testing.assert_allclose(u, -2, atol=1e-12)
    np.testing.assert_allclose(v, 1, atol=1e-12)


def test_a_body_that_holds_a_vertex_only_takes_no_lag_from_it(freefem_text):
    """P2 functions of vertices have the integral 0, by rounding 1e-19: quotients of them sent disks off that left through an
    outlet."""
    bend = "[x + 0.013*sin(3*y + x), y + 0.011*cos(2*x + 5*y)]"
    at = [(a, b) for a in (3 / 16, 5 / 16, 9 / 16) for b in (4 / 16, 11 / 16)]
    tiny = [(float(a + 0.013 * np.sin(3 * b + a)), float(b + 0.011 * np.cos(2 * a + 5 * b)), 0.012) for a, b in at]
    text = script([*tiny, (0.8, 0.5, 0.127)], more="""
Qh p = 2*x - y;
pressureCorrU = flowBX'*p[]; pressureCorrV = flowBY'*p[];
timeDt = 1;
pressureLag();
real[int] du(flowNw), dv(flowNw), dq(3*bodyNumber), div(flowNq);
pressureInertia();
pressureAnswer(p[], 0., du, dv, dq, div);
for (int d = 0; d < bodyNumber; ++d) cout << "start " << dq[d] << " " << dq[bodyNumber + d] << " " << dq[2*bodyNumber + d] << endl;
for (int d = 0; d < bodyNumber; ++d) { int n = 0; for (int k = 0; k < rigidCount; ++k) if (rigidOwner[k] == d) n++; cout << "lag " << n << " " << bodyLag[d] << " " << bodyLag[bodyNumber + d] << " " << bodyLag[2*bodyNumber + d] << endl; }
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp"
include "lib/scheme/compatible_start.idp\"""").replace("square(16, 16, flags = 3)", f"movemesh(square(16, 16, flags = 3), {bend})")
    out = freefem_text(text).stdout
    lag = rows(out, "lag")
    assert (lag[:-1, 0] == 1).all() and abs(lag[:-1, 1:]).max() < 1e-12
    np.testing.assert_allclose(lag[-1, 1:3], [2, -1], atol=1e-10)
    start = rows(out, "start")  # of their density the fluid's, so without inertia of their own
    assert abs(start[:-1]).max() < 1e-3
    np.testing.assert_allclose(start[-1, :2], [-2, 1], rtol=1e-6)
