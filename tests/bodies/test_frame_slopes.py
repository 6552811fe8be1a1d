"""Derivatives near moving bodies, by rows of some nodes and by whole matrices, against FreeFEM's integrals."""
import numpy as np
import pytest

SLOPES = """
include "lib/case.idp"
optCase("slopes", "test");
optEnd();
include "lib/mesh/labels.idp"
mesh Th = square(14, 12, [x + 0.1*y*y, y*(1 + 0.2*x)]);
real flowPeriodX = 0, flowPeriodY = 0;
int[int] flowNoSlip = [1, 2, 3, 4], flowMoving(0), flowOutlet(0), flowSlip(0);
real rhoFluid = 1, mu = 1;
include "lib/scheme/frame_slopes.idp"
rowsShare = SHARE;
// a field that vanishes outside a disk within the mesh, and the list of the nodes where it does not
Wh near = max(0., 1 - ((x - 0.5)^2 + (y - 0.5)^2)/0.09), a = near*(1 + x*y), b = near*(y - 2*x*x), u = cos(3*x) + x*y*y,
    cx = near > 0;
int[int] list(0);
arrayPick(cx[], list);
slopeList(list);
varf all(p, q) = int2d(Th, qforder = 5)((dx(a) + dy(b))*q);
varf alongX(p, q) = int2d(Th, qforder = 5)(dx(u)*q);
varf alongY(p, q) = int2d(Th, qforder = 5)(dy(u)*q);
real[int] given = all(0, Wh), gx = alongX(0, Wh), gy = alongY(0, Wh), found(flowNw), gain(0), sum(0), part(0);
slopeDivergence(a[], b[], found);
found -= given;
gx .*= a[]; gy .*= b[]; gx += gy;
part.resize(list.n) = gx(list);
slopeAlong(a[], b[], u[], gain);
gain -= part;
real rows = 0;
if (slopeFew) {
    part = given(list);
    slopeRows(a[], b[], sum);
    sum -= part;
    rows = sum.linfty;
}
cout << "RESULT " << list.n << " " << flowNw << " " << slopeFew << " " << found.linfty/given.linfty << " " << gain.linfty/gx.linfty
    << " " << rows/given.linfty << endl;
"""


@pytest.mark.parametrize("share, few", [(1, 1), (0, 0)])
def test_derivatives_at_some_nodes_are_those_of_the_integrals(share, few, freefem_text):
    """Whether the rows of these nodes are summed or whole matrices multiplied."""
    text = freefem_text(SLOPES.replace("SHARE", str(share))).stdout
    nodes, every, chosen, *errors = map(float, next(line for line in text.splitlines() if line.startswith("RESULT")).split()[1:])
    assert chosen == few and 50 < nodes < every/2
    assert np.max(errors) < 1e-12
