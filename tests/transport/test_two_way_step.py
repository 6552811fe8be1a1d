"""A step of the flow that spheres change, against its equation written in another form: convection as derivatives, nothing
integrated by parts."""
import pytest

# U is linear and slips over two open sides; two sides are held. The unknowns before the step are whatever they are: the equation
# holds all the same.
STEP = """
int[int] sides = [1, 2, 2, 1];
mesh Th = square(5, 4, label = sides);
include "lib/core/output.idp"
real rhoFluid = 2, mu = 0.3, gravityX = 0, gravityY = 0, dt = 0.05;
macro twoWayViscosity() (0.15 + 0.1*x) // EOM
include "lib/transport/two_way.idp"
reactionSolver = "umfpack";
carrierWh U1 = 1 + 0.3*x - 0.2*y, U2 = 0.4 + 0.5*x - 0.3*y;
carrierFlow(U1[], U2[]);
twoWayHeld.resize(1); twoWayHeld = 1; twoWayInlet.resize(1); twoWayInlet = 1; twoWayOutlet.resize(1); twoWayOutlet = 2;
twoWayBegin(dt);
carrierWh k1 = {known} + 0.1*(x - 2*y), k2 = {known} - 0.2*(x + y), s1, s2;
twoXh [a1, a2, aq] = [{w[0]}, {w[1]}, 0], [b1, b2, bq] = [{w[2]}, {w[3]}, 0], [w1, w2, q];
twoWayW = a1[]; twoWayW1 = b1[]; twoWayKU = k1[]; twoWayKV = k2[];
twoWayResume(5);
twoWayStep();
w1[] = twoWayW;
s1 = 2*a1 - b1; s2 = 2*a2 - b2; // w in the matrix's place, extrapolated
if (twoWayFactorisations > 5) {{ k1 = s1; k2 = s2; }}
carrierWh f11 = (s1 - k1)^2 - k1^2, f12 = (s1 - k1)*(s2 - k2) - k1*k2, f22 = (s2 - k2)^2 - k2^2, B1 = U1 + k1, B2 = U2 + k2;
macro carried(f) (B1*dx(f) + B2*dy(f) + f*(dx(B1) + dy(B2))) // EOM
varf convection([u, v, p], [c, d, r]) = int2d(Th)((carried(w1) + w1*dx(B1) + w2*dy(B1) + B1*(dx(w1) + dy(w2)) + dx(f11) + dy(f12))*c
    + (carried(w2) + w1*dx(B2) + w2*dy(B2) + B2*(dx(w1) + dy(w2)) + dx(f12) + dy(f22))*d);
varf other([u, v, p], [c, d, r]) = int2d(Th)(((1.5*w1 - 2*a1 + 0.5*b1)*c + (1.5*w2 - 2*a2 + 0.5*b2)*d)/dt
    + twoWayViscosity*(2*dx(w1)*dx(c) + 2*dy(w2)*dy(d) + (dy(w1) + dx(w2))*(dy(c) + dx(d))) - q*(dx(c) + dy(d)));
real[int] carry = convection(0, twoXh), rest = other(0, twoXh), own = twoWayFree;
carry .*= own; rest .*= own; rest += carry;
real[int] cu = carry(twoWayAtU), cv = carry(twoWayAtV), ru = rest(twoWayAtU), rv = rest(twoWayAtV);
cout << "STEP " << twoWayFactorisations << " " << cu.linfty << " " << cv.linfty << " " << ru.linfty << " " << rv.linfty << endl;
"""
SLOW = ["0.3*sin(3*x + y)", "0.2*cos(x - 4*y)", "0.25*sin(3*x + 2*y)", "0.3*cos(x - 4*y)"]
FAST = ["4 + 3*x - y", "-3 + 2*x + 5*y", "2 + 3*x", "-2 + x + 4*y"]


@pytest.mark.parametrize("known, w, factored", [(0.2, SLOW, 5), (-0.1, SLOW, 5), (0.2, FAST, 6)],
    ids=["near what the matrix knows", "near it, the other way", "far from it"])
def test_a_step_satisfies_the_equation_of_the_flow(known, w, factored, freefem_text):
    found = list(map(float, freefem_text(STEP.format(known=known, w=w)).stdout.split("STEP")[1].split()[:5]))
    assert found[0] == factored and min(found[1:3]) > 1e-3
    assert found[3] < 1e-9 * found[1] and found[4] < 1e-9 * found[2]
