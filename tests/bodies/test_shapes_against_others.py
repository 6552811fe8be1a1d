"""Bodies of any shape in a flow against the same bodies computed otherwise: meshes that fit them, ellipses, unions."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tests.scenes import case
from tests.tables import numbers
from tools.validation.shapes import DRAG, SCENE, TURN, VISCOSITY, turn

SHAPES = 'include "lib/bodies/shapes.idp"\n'
ELLIPSE = SHAPES + """real[int] px(150), py(150);
for (int k = 0; k < 150; ++k) { // the ellipse less the radius of the corners, turned by 0.5
    real a = 2*pi*k/150, ex = 0.16*cos(a), ey = 0.08*sin(a), nx = 0.08*cos(a), ny = 0.16*sin(a), size = sqrt(nx*nx + ny*ny);
    ex -= 0.002*nx/size; ey -= 0.002*ny/size;
    px[k] = 0.5 + cos(0.5)*ex - sin(0.5)*ey; py[k] = 0.7 + sin(0.5)*ex + cos(0.5)*ey;
}"""
# Two disks of radius 0.12 whose centres are 0.16 apart; their outline as one polygon with corners of radius 0.002.
UNION = SHAPES + """real[int] cx = [0.42, 0.58], cy = [0.45, 0.45], cr = [0.12, 0.12], px(160), py(160);
real notch = acos(0.08/0.118);
for (int k = 0; k < 160; ++k) {
    int side = k/80;
    real a = side*pi - pi + notch + (2*pi - 2*notch)*(k % 80 + 0.5)/80;
    px[k] = cx[1 - side] + 0.118*cos(a); py[k] = 0.45 + 0.118*sin(a);
}"""
STREAM = dict(walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0, mu=0.1)


def last(folder, name, *columns):
    table = numbers(folder, f"{name}.csv")
    return np.array([table[column][-1] for column in columns])


@pytest.mark.slow
def test_a_polygon_of_many_vertices_falls_as_the_ellipse_does(cell, freefem_text, tmp_path):
    """It turns broadside on its way; 150 vertices, 3 elements across."""
    found = {}
    for name, more, body in (("ellipse", "", "bodyEllipse(0.5, 0.7, 0.16, 0.08, 0.5, 3);"),
            ("polygon", ELLIPSE, "bodyPolygon(px, py, 0.002, 3);")):
        freefem_text(case(body, more=more, mu=0.01, gravity=-2), "-mesh", cell, "-dt", 0.01, "-tend", 0.8, "-out", tmp_path / name)
        found[name] = last(tmp_path / name, "particles", "x", "y", "theta", "u", "v", "omega")
    found["ellipse"][2] -= 0.5
    assert abs(found["ellipse"][2]) > 0.05 and abs(found["ellipse"][4]) > 0.3
    assert found["polygon"][[0, 1]] == pytest.approx(found["ellipse"][[0, 1]], abs=1e-3)
    assert found["polygon"][2] == pytest.approx(found["ellipse"][2], abs=0.01)
    assert found["polygon"][[3, 4]] == pytest.approx(found["ellipse"][[3, 4]], abs=0.01 * abs(found["ellipse"][4]))


@pytest.mark.slow
def test_a_clump_of_two_disks_bears_the_forces_of_its_outline(cell, freefem_text, tmp_path):
    """As two overlapping disks, and as one polygon with two hollows, held in a stream a little above its middle."""
    found = {}
    for name, body in (("clump", "bodyClump(cx, cy, cr, 1)"), ("polygon", "bodyPolygon(px, py, 0.002, 1)")):
        freefem_text(case(f"bodyHeld({body});", more=UNION + "\nmacro boundaryU() (4*y*(1 - y)) // EOM", **STREAM), "-mesh", cell,
            "-dt", 0.02, "-tend", 1, "-forces", 1, "-out", tmp_path / name)
        found[name] = last(tmp_path / name, "forces", "fx", "fy", "torque")
    assert found["clump"][0] > 1
    assert found["polygon"] == pytest.approx(found["clump"], abs=0.003 * found["clump"][0])


@pytest.mark.slow
@pytest.mark.parametrize("radius", DRAG)
def test_a_capsule_in_stokes_flow_bears_the_drag_on_a_mesh_that_fits_it(radius, freefem, tmp_path):
    """16 elements in its length, along and across the stream."""
    mesh = make_mesh(tmp_path / "box.mesh", "box", "--width", 4, "--height", 4, "--size", 1 / 16, "--sides", "named")
    for angle, drag in zip((0.0, np.pi / 2), DRAG[radius]):
        freefem(SCENE, "-mesh", mesh, "-radius", radius, "-angle", angle, "-forces", 1, "-out", tmp_path / f"{angle:.1f}")
        assert last(tmp_path / f"{angle:.1f}", "forces", "fx")[0] / VISCOSITY == pytest.approx(drag, rel=0.01)


@pytest.mark.slow
def test_a_capsule_turns_in_shear_as_on_meshes_that_fit_it(freefem, tmp_path):
    """16 elements in its length, 4 across."""
    mesh = make_mesh(tmp_path / "box.mesh", "box", "--width", 4, "--height", 4, "--size", 1 / 16, "--sides", "named")
    freefem(SCENE, "-mesh", mesh, "-shear", 1, "-angle", 0.3, "-tend", 18, "-out", tmp_path / "turn")
    assert turn(numbers(tmp_path / "turn", "particles.csv")) == pytest.approx(TURN, rel=0.01)
