"""The continuity equation in tetrahedra cut by a sphere (lib/spheres/sphere_flux.idp)."""
# Stokes flow past a sphere at rest, exact outside, 0 at the nodes within; the sphere does not sit on the mesh symmetrically.
STOKES = """
include "lib/core/errors.idp"
load "msh3"
int[int] flowNoSlip = [1, 2, 3, 4, 5, 6], flowMoving(0), flowOutlet(0), flowSlip(0);
real R = 0.42;
mesh3 Th = cube(12, 12, 12, [2*x - 1, 2*y - 1, 2*z - 1]);
include "lib/spheres/sphere_flux.idp"
bodySphere(0.03, -0.02, 0.05, R, 1);
solidFind();
fluxFind();
spaceWh far = sqrt((x - 0.03)^2 + (y + 0.02)^2 + (z - 0.05)^2), open = far > R,
    part = 0.75*R/far*(1 - R^2/far^2)/far^2*(x - 0.03), u = open*(1 - 0.75*R/far - 0.25*R^3/far^3 - part*(x - 0.03)),
    v = -open*part*(y + 0.02), w = -open*part*(z - 0.05);
real[int] r(spaceNq), q(6), no(spaceNw), q0(6);
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
"""


def number(text, name):
    return float(text.split(name + " ")[1].split()[0])


def test_flux_of_a_stokes_flow_through_cut_tetrahedra(freefem_text):
    """Five elements to the diameter: with the exact velocities of a Stokes flow at the outer nodes, int q div u near the sphere is
    about half of what the interpolation between them and the sphere's nodes gives; nothing leaks; a rigid motion has none."""
    text = freefem_text(STOKES).stdout
    assert number(text, "pairs") > 300
    assert number(text, "with") < 0.6 * number(text, "without")
    assert number(text, "leak") < 1e-15 and number(text, "rigid") < 1e-15
