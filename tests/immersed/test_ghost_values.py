"""Ghost values at the edge of a body: a NumPy twin, and a boundary layer integrated by SciPy."""
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from tests.scenes import script
from tests.tables import rows

CENTRE, MOTION, SIZE = (0.47, 0.53), (0.3, -0.2, 0.7), 1 / 16
ASK = """
withConvection = CONVECTION; mu = VISCOSITY;
real[int] u = flowY, v = flowX, q = [0.3, -0.2, 0.7], fu(flowNw), fv(flowNw), one(flowNw);
one = 1;
u *= 3; u -= one; u += STRAIN*flowX;
v *= 2; v -= STRAIN*flowY;
fu = 0; fv = 0;
cutSetUp(); cutFind(); ghostFind();
ghostAdd(u, v, q, fu, fv);
for [i, k : ghostAt] cout << "ghost " << rigidX[k] << " " << rigidY[k] << " " << ghostU[rigidNode[k]] << " " << ghostV[rigidNode[k]] << endl;
real[int] ku = flowK*ghostU;
ku *= mu;
ku += fu;
cout << "force " << ku.linfty << endl;
"""


def feet(rx, ry, a, b, turn):
    """Nearest points of an ellipse: depth, normal, curvature and foot (from the centre) of points inside."""
    c, s = np.cos(turn), np.sin(turn)
    px, py = c * rx + s * ry, c * ry - s * rx
    found = []
    for x, y in zip(px, py):
        def off(unknown):
            angle, depth = unknown
            normal = np.array([b * np.cos(angle), a * np.sin(angle)]) / np.hypot(b * np.cos(angle), a * np.sin(angle))
            return np.array([a * np.cos(angle), b * np.sin(angle)]) - depth * normal - [x, y]
        near = np.linspace(-np.pi, np.pi, 2001)
        far = np.hypot(a * np.cos(near) - x, b * np.sin(near) - y)
        angle, depth = fsolve(off, [near[far.argmin()], far.min()], xtol=1e-12)
        long = np.hypot(b * np.cos(angle), a * np.sin(angle))
        n1, n2 = b * np.cos(angle) / long, a * np.sin(angle) / long
        found.append((depth, c * n1 - s * n2, s * n1 + c * n2, a * b / long**3))
    return np.array(found).T


def twin(rx, ry, shape, strain, viscosity, convection):
    """Ghost values of the field u = (3 y - 1 + e x, 2 x - e y), by the formulas of lib/immersed/ghost_values.idp and
    lib/immersed/ghost_profile.idp."""
    depth, nx, ny, curvature = feet(rx, ry, *shape)
    resolved = 2 / curvature > 1.9 * SIZE
    curvature, convection = np.where(resolved, curvature, 0), convection * resolved
    slip, normal = [], []
    for k in (1, 2):
        x, y = rx + (depth + k * SIZE) * nx, ry + (depth + k * SIZE) * ny
        u = 3 * (CENTRE[1] + y) - 1 + strain * (CENTRE[0] + x) - MOTION[0] + MOTION[2] * y
        v = 2 * (CENTRE[0] + x) - strain * (CENTRE[1] + y) - MOTION[1] - MOTION[2] * x
        slip.append(nx * v - ny * u)
        normal.append(nx * u + ny * v)

    def along(n):  # R ln(r/R) to third order
        return n / (1 + n * curvature / 2)
    x = np.array([along(SIZE), along(2 * SIZE)])
    xd, slip = along(-depth), np.array(slip)

    def two(values, power):  # p and q of p x^power + q x^(power + 1) through the values
        q = (values[1] / x[1]**power - values[0] / x[0]**power) / (x[1] - x[0])
        return values[0] / x[0]**power - q * x[0], q
    far = 0
    if np.any(convection):
        (gamma, a), (c, d) = two(slip, 1), two(np.array(normal), 2)

        def added(s):
            return -s**4 / viscosity * (c * gamma / 12 + d * gamma * s / 10 + a * d * s**2 / 30)
        share = convection * abs(slip[1]) / np.hypot(slip[1], added(x[1]))
        slip = slip - share * added(x)
        known = np.maximum(xd, -x[1])
        far = share * added(known) * xd / known
    gamma, a = two(slip, 1)
    return (gamma * xd + a * xd**2 + far) * np.array([-ny, nx])


@pytest.mark.parametrize("convection, viscosity", [(0, 1), (1, 0.05), (1, 0.002)])
@pytest.mark.parametrize("shape", [(0.21, 0.21, 0.0), (0.24, 0.14, 0.6)])
def test_ghost_values_are_those_of_a_numpy_twin(freefem_text, shape, convection, viscosity):
    """A linear field, which P2 holds exactly: the velocities at the outer points are known."""
    body = f"bodyEllipse({CENTRE[0]}, {CENTRE[1]}, {shape[0]}, {shape[1]}, {shape[2]}, 1.);" if shape[0] != shape[1] else f"bodyDisk({CENTRE[0]}, {CENTRE[1]}, {shape[0]}, 1.);"
    text = script([], more=ASK).replace("rigidSetUp();", body + "\nrigidSetUp();", 1)
    text = text.replace("CONVECTION", str(convection)).replace("VISCOSITY", str(viscosity)).replace("STRAIN", "0.8")
    out = freefem_text(text).stdout
    rx, ry, gu, gv = rows(out, "ghost").T
    expected = twin(rx, ry, shape, 0.8, viscosity, convection)
    assert len(gu) > 50
    np.testing.assert_allclose([gu, gv], expected, atol=1e-8)
    if convection:
        assert abs(expected - twin(rx, ry, shape, 0.8, viscosity, 0)).max() > 1e-3
    assert rows(out, "force")[0, 0] < 1e-12  # the force is -mu K g


ALONE = """
include "lib/case.idp"
optCase("alone", "one function"); optEnd();
real rhoFluid = 1.25, mu = 0.1;
include "lib/immersed/ghost_profile.idp"
real[int] x1 = X1, x2 = X2, xd = XD, n1 = N1, n2 = N2, on = ON, g1 = G1, g2 = G2, f(x1.n);
ghostConvection(x1, x2, xd, n1, n2, on, g1, g2, f);
cout.precision(16);
for (int k = 0; k < x1.n; ++k) cout << "slopes " << g1[k] << " " << g2[k] << " " << f[k] << endl;
"""


def test_the_rows_near_bodies_give_what_the_whole_matrix_gives(freefem_text):
    ask = """
mu = 0.3;
real[int] u = flowY .* flowY, v = flowX .* flowY, q = [0.3, -0.1, -0.2, 0.4, 0.7, 1.1], fu(flowNw), fv(flowNw), gu(flowNw), gv(flowNw);
rowsShare = 0;
fu = 1; fv = 2; cutSetUp(); cutFind(); ghostFind(); ghostAdd(u, v, q, fu, fv);
rowsShare = 1;
for (int k = 0; k < 2; ++k) {
    bodyX[0] += k*2*rigidSkin; rigidFind(); cutFind(); ghostFind(); // the second time the nodes near bodies are others
    rowsShare = 0; fu = 1; fv = 2; ghostAdd(u, v, q, fu, fv);
    rowsShare = 1; gu = 1; gv = 2; ghostAdd(u, v, q, gu, gv);
    real most = fu.linfty + fv.linfty;
    gu -= fu; gv -= fv;
    cout << "apart " << gu.linfty + gv.linfty << " " << most << " " << rigidRefreshed << endl;
}
"""
    found = rows(freefem_text(script([(0.31, 0.42, 0.127), (0.66, 0.62, 0.16)], more=ask)).stdout, "apart")
    assert (found[:, 0] < 1e-13).all() and (found[:, 1] > 3.1).all() and list(found[:, 2]) == [1, 2]


def test_each_body_s_ghosts_follow_by_its_own_rate(freefem_text):
    """Those of the states extrapolated by it, whatever the rate of the other body is."""
    ask = """
withConvection = 1; mu = 0.05;
real[int] u = flowY .* flowY, v = flowX .* flowY, u1 = flowX .* flowY, v1 = flowX, rates = [0.7, -0.3], fu(flowNw), fv(flowNw);
bodyQ = [0.3, -0.1, -0.2, 0.4, 0.7, 1.1]; bodyQ1 = [0.1, 0.2, -0.3, 0.2, -0.4, 0.6];
rowsShare = 0; fu = 0; fv = 0; cutSetUp(); cutFind(); ghostFind();
ghostAddBy(u, v, u1, v1, rates, fu, fv);
real[int] gu = ghostU, gv = ghostV;
for (int d = 0; d < 2; ++d) {
    real s = rates[d], off = 0;
    real[int] ue = (1 + s)*u - s*u1, ve = (1 + s)*v - s*v1, qe = (1 + s)*bodyQ - s*bodyQ1;
    ghostAdd(ue, ve, qe, fu, fv);
    for (int k = 0; k < rigidCount; ++k) if (rigidOwner[k] == d) off = max(off, abs(ghostU[rigidNode[k]] - gu[rigidNode[k]]) + abs(ghostV[rigidNode[k]] - gv[rigidNode[k]]));
    cout << "off " << off << " " << ghostU.linfty << endl;
}
"""
    found = rows(freefem_text(script([(0.31, 0.42, 0.127), (0.66, 0.62, 0.16)], more=ask)).stdout, "off")
    assert len(found) == 2 and (found[:, 0] < 1e-13).all() and (found[:, 1] > 0.05).all()


def test_outer_points_in_another_body_or_in_a_wall_do_not_count(freefem_text):
    """Where the first one lies there g is 0, where only the second does it is along the straight line to the first: of a slip s
    there, - s times depth over distance in xi."""
    disks = [(0.16, 0.5, 0.127), (0.44, 0.52, 0.13)]
    ask = """
real[int] u(flowNw), v(flowNw), q(6), fu(flowNw), fv(flowNw);
u = 1; v = 0; q = 0; fu = 0; fv = 0; withConvection = 0; rowsShare = 0;
cutSetUp(); cutFind(); ghostFind(); ghostAdd(u, v, q, fu, fv);
for [i, k : ghostAt] cout << "at " << rigidOwner[k] << " " << rigidX[k] << " " << rigidY[k] << " " << flowH[rigidNode[k]] << " " << ghostWet1[i] << " " << ghostWet2[i] << " " << ghostU[rigidNode[k]] << " " << ghostV[rigidNode[k]] << endl;
"""
    owner, rx, ry, size, first, second, gu, gv = rows(freefem_text(script(disks, more=ask)).stdout, "at").T
    own = np.array(disks)[owner.astype(int)].T
    other = np.array(disks)[1 - owner.astype(int)].T
    nx, ny = np.array([rx, ry]) / np.hypot(rx, ry)
    room = []  # of each outer point, to the other disk and to the walls
    for far in (size, 2 * size):
        x, y = own[0] + nx * (own[2] + far), own[1] + ny * (own[2] + far)
        room.append(np.min([np.hypot(x - other[0], y - other[1]) - other[2], x, 1 - x, y, 1 - y], axis=0))
    for wet, clear in ((first, room[0]), (second, np.minimum(*room))):
        sure = abs(clear) > 0.25 * size
        assert (wet[sure] == (clear > 0)[sure]).all() and 5 < (wet == 0).sum() < 0.8 * len(wet)
    depth, bend = own[2] - np.hypot(rx, ry), 0.5 / own[2]
    line = ny * depth / (1 - bend * depth) / (size / (1 + bend * size))  # of the slip (1, 0) along (-ny, nx), which is - ny
    dry, straight = first == 0, (first == 1) & (second == 0)
    assert dry.sum() > 5 and straight.sum() > 5 and np.hypot(gu, gv)[dry].max() == 0
    np.testing.assert_allclose([gu[straight], gv[straight]], [-line[straight] * ny[straight], line[straight] * nx[straight]],
        atol=1e-9)


def test_the_nodes_left_out_are_no_force_on_anything(freefem_text):
    """K g of any g at the rigid nodes that are not asked: 0 at the nodes outside and in each body's sums. The two disks share
    elements."""
    ask = """
bodyEllipse(0.27, 0.3, 0.2, 0.13, 0.6, 1.); rigidStale = 1; rigidFind();
ghostFew = 0; cutSetUp(); cutFind(); ghostFind();
real[int] g(flowNw), gu(rigidCount), none(ghostAt.n), k(flowNw), l(flowNw), q(3*bodyNumber);
int[int] near = rigidNode(ghostAt);
for (int i = 0; i < rigidCount; ++i) gu[i] = sin(1. + 7*i*i);
g = 0; g(rigidNode) = gu; g(near) = (none = 0.);
k = flowK*g; l = -1.3*k;
rigidGather(k, l, q);
real inside = k.linfty;
k = k .* rigidMaskU;
cout << "sums " << inside << " " << k.linfty << " " << q.linfty << endl << "nodes " << rigidCount << " " << ghostAt.n << endl;
g(near) = (none = 1.); // and those that are asked are
k = flowK*g; k = k .* rigidMaskU;
cout << "sums " << k.linfty << " 0 0" << endl;
"""
    out = freefem_text(script([(0.66, 0.3, 0.14), (0.68, 0.62, 0.172)], more=ask)).stdout
    (most, outside, sums), (asked, *_) = rows(out, "sums")
    assert most > 1 and outside < 1e-14 * most and sums < 1e-14 * most and asked > 0.1, out
    rigid, kept = rows(out, "nodes")[0]
    assert 0.3 * rigid < kept < 0.9 * rigid


def test_a_boundary_layer_is_met_to_higher_order(freefem_text):
    """nu s'' = kappa + v s' - s v' integrated by SciPy from the edge to both sides; the value at x = -0.4 h from those at h and
    2 h. A parabola errs by h^4, with the effect of convection by more than h^5.5."""
    nu, gamma, kappa, c, d = 0.08, 40.0, 12.0, -9.0, 6.0

    def right(x, y):
        v, slope = c * x**2 + d * x**3, 2 * c * x + 3 * d * x**2
        return [y[1], (kappa + v * y[1] - y[0] * slope) / nu]

    def profile(x):
        return solve_ivp(right, (0, x), [0, gamma], rtol=1e-12, atol=1e-14, method="DOP853").y[0, -1]
    h = 0.2 / 2.0 ** np.arange(4)
    s1, s2, exact = (np.array([profile(k * x) for x in h]) for k in (1, 2, -0.4))

    def array(values):
        return "[" + ", ".join(f"{v:.17g}" for v in values) + "]"

    def value(g1, g2, f):
        return -0.4 * h * (g1 - 1.4 * (g2 - g1) + f)
    text = ALONE
    for name, values in {"X1": h, "X2": 2 * h, "XD": 0.4 * h, "N1": c * h**2 + d * h**3, "N2": 4 * c * h**2 + 8 * d * h**3,
                         "ON": np.ones(4), "G1": s1 / h, "G2": s2 / (2 * h)}.items():
        text = text.replace(f"= {name}", f"= {array(values)}")
    found = abs(value(*rows(freefem_text(text).stdout, "slopes").T) - exact)
    plain = abs(value(s1 / h, s2 / (2 * h), 0) - exact)
    orders = [np.polyfit(np.log(h), np.log(error), 1)[0] for error in (plain, found)]
    assert 3.5 < orders[0] < 4.5 and orders[1] > 5.5, (orders, plain, found)
    assert (found < 0.35 * plain).all(), (plain, found)
    # where it does not count, nothing changes
    still = rows(freefem_text(text.replace("on = [1, 1, 1, 1]", "on = [0, 0, 0, 0]")).stdout, "slopes").T
    np.testing.assert_allclose(still, [s1 / h, s2 / (2 * h), 0 * h], rtol=1e-14)
