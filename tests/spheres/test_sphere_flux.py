"""Continuity and inertia in tetrahedra cut by a sphere (lib/spheres/sphere_flux.idp, sphere_inertia.idp), and starts."""
import pytest

from tests.conftest import ROOT
from tools.base.tables import read_table
from tools.validation.flow_of_spheres import released

# Stokes flow past a sphere at rest, exact outside, 0 at the nodes within; the sphere does not sit on the mesh symmetrically.
STOKES = """
include "lib/core/errors.idp"
load "msh3"
int[int] flowNoSlip = [1, 2, 3, 4, 5, 6], flowMoving(0), flowOutlet(0), flowSlip(0);
real R = 0.42;
mesh3 Th = cube(12, 12, 12, [2*x - 1, 2*y - 1, 2*z - 1]);
include "lib/spheres/sphere_inertia.idp"
bodySphere(0.03, -0.02, 0.05, R, 1);
solidFind();
spaceWh far = sqrt((x - 0.03)^2 + (y + 0.02)^2 + (z - 0.05)^2), open = far > R,
    part = 0.75*R/far*(1 - R^2/far^2)/far^2*(x - 0.03), u = open*(1 - 0.75*R/far - 0.25*R^3/far^3 - part*(x - 0.03)),
    v = -open*part*(y + 0.02), w = -open*part*(z - 0.05);
real[int] r(spaceNq), q(6), no(spaceNw), q0(6);
spaceU = u[]; spaceV = v[]; spaceW = w[];
fluxFind(); slipFind();
cout << "resolved " << crossSlip[0] << " entries " << slipN << endl;
// of the vertices near the sphere
spaceQh near = abs(far - R) < 0.34;
real[int] mask = near[];
r = spaceBX*u[]; r += spaceBY*v[]; r += spaceBZ*w[]; r *= -1.;
real[int] cut = r .* mask;
cout << "without " << cut.l2 << endl;
q0 = 0.;
real before = r.sum;
fluxAdd(u[], v[], w[], q0, r);
cut = r .* mask;
cout << "with " << cut.l2 << endl;
cout << "leak " << abs(r.sum - before) << endl;
// a rigid motion of everything misses nothing
q = [0.3, -0.2, 0.5, 1.1, -0.7, 0.4];
spaceWh a = 0.3 - 0.7*(z - 0.05) - 0.4*(y + 0.02), b = -0.2 + 0.4*(x - 0.03) - 1.1*(z - 0.05),
    c = 0.5 + 1.1*(y + 0.02) + 0.7*(x - 0.03);
r = 0.;
fluxAdd(a[], b[], c[], q, r);
cout << "rigid " << r.linfty << endl;
cout << "pairs " << crossN << endl;
// a uniform stream that slips past the sphere: nothing is resolved. The missing mass and flux are those of the jump.
int n = spaceNw;
u = open; v = 0; w = 0; spaceU = u[]; spaceV = v[]; spaceW = w[];
fluxFind(); slipFind();
cout << "slips " << crossSlip[0] << endl;
real[int] s(3*n + 6), t(3*n + 6), more(3*n + 6);
func real energy(real[int] & state, int with) { // twice the kinetic energy over the density
    real sum = 0;
    real[int] whole = state, rest(3*n + 6), q1 = state(3*n:3*n + 5), inside = solidMotion'*q1;
    rest = 0.;
    slipAdd(1., state, rest);
    if (with) sum += state'*rest;
    whole(solidAll) = inside;
    for (int k = 0; k < 3; ++k) { real[int] f = whole(k*n:(k + 1)*n - 1), Mf = spaceM*f; sum += f'*Mf; }
    return sum;
}
real volume = 4./3*pi*R^3, moment = 0.4*volume*R^2;
spaceWh one = 1;
s = 0.; s(0:n - 1) = one[];
cout << "stream " << energy(s, 0)/(8 - volume) - 1 << " to " << energy(s, 1)/(8 - volume) - 1 << endl;
s = 0.; s[3*n + 1] = 1;
cout << "moves " << energy(s, 0)/volume - 1 << " to " << energy(s, 1)/volume - 1 << endl;
s = 0.; s[3*n + 5] = 1;
cout << "turns " << energy(s, 0)/moment - 1 << " to " << energy(s, 1)/moment - 1 << endl;
s = 0.; s(0:n - 1) = a[]; s(n:2*n - 1) = b[]; s(2*n:3*n - 1) = c[]; s(3*n:3*n + 5) = q;
cout << "together " << energy(s, 1) - energy(s, 0) << endl;
// symmetric; the push of a pressure is the transpose of the flux
for (int k = 0; k < s.n; ++k) { s[k] = sin(1.7*k + 1); t[k] = cos(0.3*k); }
more = 0.; slipAdd(1., s, more);
real left = t'*more;
more = 0.; slipAdd(1., t, more);
cout << "transposed " << left/(s'*more) - 1 << endl;
real[int] p(spaceNq), fu(n), fv(n), fw(n), s0 = s(0:n - 1), s1 = s(n:2*n - 1), s2 = s(2*n:3*n - 1);
for (int k = 0; k < spaceNq; ++k) p[k] = sin(0.7*k);
r = 0.; fu = 0.; fv = 0.; fw = 0.; q0 = 0.; q = s(3*n:3*n + 5);
fluxAdd(s0, s1, s2, q, r); slipPush(p, fu, fv, fw, q0);
cout << "pushes " << -(fu'*s0 + fv'*s1 + fw'*s2 + q0'*q)/(crossSlip[0]*(r'*p)) - 1 << endl;
"""


def number(text, name):
    return float(text.split(name + " ")[1].split()[0])


def test_flux_and_inertia_of_cut_tetrahedra(freefem_text):
    """Five elements to the diameter. With the exact velocities of a Stokes flow at the outer nodes, int q div u near the sphere is
    about half of what the interpolation between them and the sphere's nodes gives; nothing leaks; a rigid motion has none; the
    layer is resolved, and no inertia is added. In a stream that slips, fluid and sphere have the mass of their volumes."""
    text = freefem_text(STOKES).stdout
    assert number(text, "pairs") > 300
    assert number(text, "with") < 0.6 * number(text, "without")
    assert number(text, "leak") < 1e-15 and number(text, "rigid") < 1e-15
    assert number(text, "resolved") == 0 and number(text, "entries") == 0 and number(text, "slips") > 0.99
    for name, least, most in (("stream", 0.002, 0.0005), ("moves", 0.04, 0.005), ("turns", 0.09, 0.03)):
        before, after = (float(word) for word in text.split(name + " ")[1].split("\n")[0].split(" to "))
        assert abs(before) > least and abs(after) < most
    assert abs(number(text, "together")) < 1e-13
    assert abs(number(text, "transposed")) < 1e-9 and abs(number(text, "pushes")) < 1e-9


@pytest.mark.parametrize("ratio, within", [(2, 0.05), pytest.param(0.01, 0.15, marks=pytest.mark.slow),
    pytest.param(0.5, 0.08, marks=pytest.mark.slow)])
def test_spheres_that_are_let_go_have_added_mass_from_the_first_step_on(ratio, within, freefem, tmp_path):
    """Four elements to the diameter, in water, whose layer is a fiftieth of an element: velocity over that with added mass and
    history force in each of the first steps."""
    freefem(ROOT / "cases/settling_sphere.edp", "-mu", 0.001, "-rhos", 960 * ratio, "-z", 0.1275 if ratio > 1 else 0.03, "-dt",
        0.001, "-tend", 0.002 if ratio > 1 else 0.01, "-tolerance", 1e-6, "-every", 0, "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run/particles.csv")
    for t, w in zip(rows["t"], rows["w"]):
        if t > 0:
            assert w == pytest.approx(-released(ratio, t, 0.001 / 960), rel=within)
