"""Bodies of any shape in a flow against the same bodies computed otherwise: meshes that fit them, ellipses, unions."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tests.scenes import SIDES, STREAM, case
from tests.tables import numbers
from tools.validation.shapes import DRAG, SCENE, TURN, VISCOSITY, turn

SHAPES = 'include "lib/bodies/shapes.idp"\n'
ELLIPSE = SHAPES + """real[int] px(150), py(150);
for (int k = 0; k < 150; ++k) { // the ellipse less the radius of the corners, turned by 0.5
    real a = 2*pi*k/150, ex = 0.16*cos(a), ey = 0.08*sin(a), nx = 0.08*cos(a), ny = 0.16*sin(a), size = sqrt(nx*nx + ny*ny);
    ex -= 0.002*nx/size; ey -= 0.002*ny/size;
    px[k] = 0.5 + cos(0.5)*ex - sin(0.5)*ey; py[k] = 0.7 + sin(0.5)*ex + cos(0.5)*ey;
}"""
# Two disks of radius 0.15 whose centres are 0.2 apart, held in a channel of 4 by 1; and their outline as a hole of a mesh.
UNION = "bodyHeld(bodyClump(cx, cy, cr, 1));"
PLACES = SHAPES + "real[int] cx = [1., 1.2], cy = [0.45, 0.45], cr = [0.15, 0.15];\n"
ARCS = """real notch = acos(0.1/0.15);
border right(s = -pi + notch, pi - notch) { x = 1.2 + 0.15*cos(s); y = 0.45 + 0.15*sin(s); label = 5; }
border left(s = notch, 2*pi - notch) { x = 1 + 0.15*cos(s); y = 0.45 + 0.15*sin(s); label = 5; }
"""
FITTED = """
include "lib/case.idp"
optCase("fitted", "two disks as one in a channel");
real rhoFluid = 1, speed = 1, size = 0.3, mu = 0.02;
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall, labelObstacle], labelsMoving = [labelInlet], labelsFree = [labelOutlet];
macro inletU() (4*y*(1 - y)) // EOM
macro caseResult() {
    real[int] force(2);
    steadyForceOn(labelObstacle, force); resultPut("fx", force[0], "N/m"); resultPut("fy", force[1], "N/m");
} // EOM
include "scripts/steady_laminar.edp"
"""

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
def test_a_clump_of_two_disks_bears_the_forces_on_a_mesh_that_fits_their_union(freefem_text, tmp_path):
    """Reynolds number 15; 9 elements across each disk."""
    mesh = f'savemesh(buildmesh(below(128) + out(32) + above(128) + into(32) + right(-60) + left(-60)), "{tmp_path}/fitted.mesh");\n'
    freefem_text(SIDES + ARCS + mesh + FITTED, "-mesh", tmp_path / "fitted.mesh", "-out", tmp_path / "fitted")
    known = dict(line.split(",")[:2] for line in (tmp_path / "fitted/results.csv").read_text().splitlines()[1:])
    text = case(UNION, walls="labelWall", moving="labelInlet", outlet="labelOutlet", mu=0.02, gravity=0, more=PLACES + STREAM)
    mesh = f'savemesh(buildmesh(below(128) + out(32) + above(128) + into(32)), "{tmp_path}/plain.mesh");\n'
    freefem_text(SIDES + mesh + text, "-mesh", tmp_path / "plain.mesh", "-dt", 0.04, "-every", 2, "-tend", 2, "-forces", 1, "-out",
        tmp_path / "run")
    for part, force in zip(("fx", "fy"), last(tmp_path / "run", "forces", "fx", "fy")):
        assert force == pytest.approx(float(known[part]), abs=0.01 * float(known["fx"]))


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
    freefem(SCENE, "-mesh", mesh, "-shear", 1, "-angle", 0.3, "-dt", 0.1, "-tend", 18, "-out", tmp_path / "turn")
    assert turn(numbers(tmp_path / "turn", "particles.csv")) == pytest.approx(TURN, rel=0.01)
