"""Values at points (lib/flow/point_values.idp): quadratic functions are taken exactly, also by nodes that a period shares, and are
0 outside."""
import numpy as np
import pytest

from tests.tables import rows

SCENE = """
include "lib/mesh/labels.idp"
mesh Th = square(12, 9, [2*x + SKEW*y*(1 - y), y + SKEW*x*(1 - x)*y]);
SIDES
real rhoFluid = 1, mu = 1;
include "lib/flow/spaces.idp"
include "lib/flow/point_values.idp"
ifstream in("POINTS");
int n;
in >> n;
real[int] px(n), py(n), now(n), value(0), inside(n);
in >> px >> py;
int[int] of(0);
cellsMany = MANY;
locatePoints(px, py, of, value, inside);
Wh f = FUNCTION;
locateTake(f[], of, value, now);
cout.precision(17);
for [i, a : now] cout << "value " << a << endl;
"""
PLAIN = "int[int] flowNoSlip = [1, 2, 3, 4], flowMoving(0), flowOutlet(0), flowSlip(0); real flowPeriodX = 0, flowPeriodY = 0;"
SEAMS = """
int[int] flowNoSlip = [1, 3], flowMoving(0), flowOutlet(0), flowSlip(0); real flowPeriodX = 2, flowPeriodY = 0;
macro flowPeriodicLabels() [2, 4] // EOM
macro flowSpaces() fespace Wh(Th, P2, periodic = [[2, y], [4, y]]); fespace Qh(Th, P1, periodic = [[2, y], [4, y]]); // EOM
"""


@pytest.mark.parametrize("many", (1, 10000))  # by the table of cells (lib/flow/point_search.idp), by FreeFEM
@pytest.mark.parametrize("periodic", (0, 1))
def test_values_at_points(periodic, many, freefem_text, tmp_path):
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-0.1, 2.1, 400), rng.uniform(-0.1, 1.1, 400)
    x[:60], y[:60] = rng.integers(0, 13, 60) / 6, rng.integers(0, 10, 60) / 9  # vertices and sides of the mesh
    file = tmp_path / "points.txt"
    file.write_text("\n".join([f"{x.size}", f"{x.size}", *map(repr, x.tolist()), f"{x.size}", *map(repr, y.tolist()), ""]))
    function = "3*y^2 - y + 1" if periodic else "x^2 - 3*x*y + 2*y^2 + y - 4"
    scene = SCENE.replace("SIDES", SEAMS if periodic else PLAIN).replace("POINTS", str(file)).replace("FUNCTION",
        function).replace("MANY", str(many))
    value = rows(freefem_text(scene.replace("SKEW", "0")).stdout, "value")[:, 0]
    exact = 3 * y**2 - y + 1 if periodic else x**2 - 3 * x * y + 2 * y**2 + y - 4
    outside = (x < 0) | (x > 2) | (y < 0) | (y > 1)
    assert outside.sum() > 50
    np.testing.assert_allclose(value, np.where(outside, 0, exact), atol=1e-12)


@pytest.mark.parametrize("many", (1, 10000))
def test_values_are_those_that_freefem_finds(many, freefem_text, tmp_path):
    """On skew triangles of many sizes: a second way."""
    rng = np.random.default_rng(4)
    x, y = rng.uniform(0, 2, 300), rng.uniform(0, 1, 300)
    file = tmp_path / "points.txt"
    file.write_text("\n".join([f"{x.size}", f"{x.size}", *map(repr, x.tolist()), f"{x.size}", *map(repr, y.tolist()), ""]))
    more = 'matrix P = interpolate(Wh, px, py, t = true); now = P*f[]; for [i, a : now] cout << "second " << a << endl;'
    scene = SCENE.replace("SIDES", PLAIN).replace("POINTS", str(file)).replace("FUNCTION", "sin(7*x*y)").replace("SKEW",
        "0.4").replace("MANY", str(many)) + more
    text = freefem_text(scene).stdout
    first, second = rows(text, "value")[:, 0], rows(text, "second")[:, 0]
    assert (second == 0).sum() < 60  # the skew mesh does not fill the box
    np.testing.assert_allclose(first, second, atol=1e-12)


def test_the_table_finds_its_triangles_without_freefem(freefem_text, tmp_path):
    """In a mesh whose triangles differ in size by a factor of 40, most points are found by the table and the walk from there."""
    rng = np.random.default_rng(5)
    x, y = rng.uniform(0, 2, 4000), rng.uniform(0, 1, 4000)
    file = tmp_path / "points.txt"
    file.write_text("\n".join([f"{x.size}", f"{x.size}", *map(repr, x.tolist()), f"{x.size}", *map(repr, y.tolist()), ""]))
    scene = SCENE.replace("[2*x + SKEW*y*(1 - y), y + SKEW*x*(1 - x)*y]", "[2*x^3, y^2]").replace("SIDES", PLAIN).replace("POINTS",
        str(file))
    scene = scene.replace("FUNCTION", "x^2 - 3*x*y + 2*y^2 + y - 4").replace("MANY",
        "1000").replace('include "lib/flow/point_values.idp"', 'include "lib/flow/point_values.idp"\nint asked = 0;')
    text = freefem_text(scene + 'cout << "asked " << cellsAsked << endl;').stdout
    np.testing.assert_allclose(rows(text, "value")[:, 0], x**2 - 3 * x * y + 2 * y**2 + y - 4, atol=1e-12)
    assert rows(text, "asked")[0, 0] < 0.05 * x.size
