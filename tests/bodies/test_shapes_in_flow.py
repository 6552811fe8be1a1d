"""Bodies of any shape in a flow: their outlines, disks in disguise, rest, restart, the queue, what is refused."""
import numpy as np
import pytest

from tests.scenes import case
from tests.tables import broken_off, numbers, rows

WORDS = 'include "lib/bodies/shapes.idp"\n'
OUTLINES = """
include "lib/case.idp"
include "lib/bodies/shapes.idp"
optCase("outlines", "distances from outlines"); optEnd();
include "lib/bodies/rim.idp"
real[int] ax = [0., 0.4, 0.4, 0.2, 0.], ay = [0., 0., 0.3, 0.1, 0.3], bx = [1., 1.3, 1.3], by = [0., 0.1, 0.4],
    cx = [2., 2.2], cy = [0., 0.05], cr = [0.15, 0.1], gx(64), gy(64);
for (int k = 0; k < 64; ++k) { gx[k] = 3 + 0.2*cos(2*pi*k/64); gy[k] = 0.2*sin(2*pi*k/64); }
bodyPolygon(ax, ay, 0.03, 1); bodyChain(bx, by, 0.05, 1); bodyClump(cx, cy, cr, 1); bodyPolygon(gx, gy, 0.001, 1);
bodyTheta[2] = 0.7;
shapedBegin(); shapedFlow();
int n = 4000;
int[int] owner(n);
real[int] rx(n), ry(n), depth(n), nx(n), ny(n), delta(n), bend(n);
randinit(1);
for (int k = 0; k < n; ++k) { owner[k] = k % 4; rx[k] = 0.8*(randreal1() - 0.5); ry[k] = 0.8*(randreal1() - 0.5); }
delta = 0.05;
rimFoot(owner, rx, ry, depth, nx, ny);
rimBend(owner, nx, ny, delta, bend);
cout.precision(15);
for (int k = 0; k < shapeVN; ++k) cout << "vertex " << shapeVOf[k] << " " << shapeVPart[k] << " " << shapeVX[k] << " "
    << shapeVY[k] << " " << shapeVR[k] << endl;
for (int k = 0; k < 4; ++k) cout << "wide " << bodyAspect[k]*bodyRadius[k] << endl;
for (int k = 0; k < n; ++k) cout << "point " << owner[k] << " " << rx[k] << " " << ry[k] << " " << depth[k] << " " << nx[k] << " "
    << ny[k] << " " << bend[k] << endl;
"""


def signed(points, parts):
    """Signed distance of points (n, 2) to a union of parts (closed, radius, vertices): the sign by counting crossings."""
    least = np.full(len(points), np.inf)
    for closed, radius, vertices in parts:
        m = len(vertices)
        far, inside = np.full(len(points), np.inf), np.zeros(len(points), bool)
        for k in range(m if closed else max(m - 1, 1)):
            a, b = vertices[k], vertices[(k + 1) % m]
            t = b - a
            s = np.clip((points - a) @ t / max(t @ t, 1e-300), 0, 1)
            far = np.minimum(far, np.linalg.norm(points - a - s[:, None] * t, axis=1))
            if closed and a[1] != b[1]:
                across = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
                inside ^= across & (a[0] + (points[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]) > points[:, 0])
        least = np.minimum(least, np.where(inside, -far, far) - radius)
    return least


def test_outlines(freefem_text):
    """Concave polygon, bent fibre, turned clump, polygon of many corners: distance, normal, curvature, largest circle."""
    told = freefem_text(OUTLINES).stdout
    points, vertices, wide = rows(told, "point"), rows(told, "vertex"), rows(told, "wide")[:, 0]
    c, s = np.cos(0.7), np.sin(0.7)
    for body in range(4):
        mine = vertices[vertices[:, 0] == body]
        parts = [(part % 2, mine[mine[:, 1] == part][0, 4], mine[mine[:, 1] == part][:, 2:4]) for part in np.unique(mine[:, 1])]
        some = points[points[:, 0] == body]
        turn = np.array([[c, -s], [s, c]]) if body == 2 else np.eye(2)
        xy, depth, normal, bend = some[:, 1:3] @ turn, some[:, 3], some[:, 4:6], some[:, 6]
        assert depth == pytest.approx(-signed(xy, parts), abs=1e-12)
        step = 1e-6
        there = np.abs(-signed(xy + step * normal @ turn, parts) - depth + step) < 1e-9
        assert there.mean() > 0.99  # not where two points of the outline are equally near
        near = np.abs(depth) < 0.02
        if body == 1:
            assert set(np.round(bend[near], 9)) == {0.0, 20.0}
        if body == 2:
            assert set(np.round(bend[near], 6)) == {round(1 / 0.15, 6), 10.0}
        if body == 3:
            assert bend[near] == pytest.approx(1 / 0.201, rel=1e-3)  # its edges are shorter than an element
    assert wide[1:] == pytest.approx([0.05, 0.15, 0.2 * np.cos(np.pi / 64) + 0.001], rel=1e-3)


FALL = dict(more=WORDS + """real[int] gx(96), gy(96);
for (int k = 0; k < 96; ++k) { gx[k] = 0.8 + 0.109*cos(2*pi*k/96); gy[k] = 0.7 + 0.109*sin(2*pi*k/96); }
real[int] onex = [0.5], oney = [0.55];""")


def test_disks_in_disguise(cell, freefem_text, tmp_path):
    """A capsule of no length, a chain of one vertex and a polygon of 96 vertices fall as disks do."""
    kinds = {"disks": "bodyDisk(0.2, 0.7, 0.11, 2); bodyDisk(0.5, 0.55, 0.09, 2); bodyDisk(0.8, 0.7, 0.11, 2);",
        "shapes": "bodyCapsule(0.2, 0.7, 0, 0.11, 0, 2); bodyChain(onex, oney, 0.09, 2); bodyPolygon(gx, gy, 0.001, 2);"}
    last = {}
    for name, bodies in kinds.items():
        freefem_text(case("{ " + bodies + " }", mu=0.02, gravity=-20, **FALL), "-mesh", cell, "-dt", 0.02, "-tend", 0.3,
            "-every", 0.3, "-out", tmp_path / name)
        table = numbers(tmp_path / name, "particles.csv")
        last[name] = np.column_stack([table[key][-3:] for key in ("x", "y", "u", "v")])
    assert np.abs(last["disks"][:, 3]).min() > 0.05
    apart = np.abs(last["shapes"] - last["disks"]) / np.abs(last["disks"][:, 3]).max()
    assert apart.max() < 2e-3  # the polygon has 0.0007 of the area less, and moves the others
    assert len(numbers(tmp_path / "shapes", "outlines.csv")["id"]) == 98


def test_rest_and_budget(cell, freefem_text, tmp_path):
    """A square and a capsule that stand on the floor, farther than two elements from other walls, stay there (beside a wall the
    film leaves 1e-7 m/s in the first steps); their corners carry their weights less the buoyancy. Another pair falls on the floor:
    momentum that walls and weight do not explain stays a small part of the weight's: 0.020, 0.013, 0.008, 0.007 of it with steps
    of 0.02, 0.01, 0.005 (here), 0.0025 s."""
    more = WORDS + "real[int] sx = [0.11, 0.29, 0.29, 0.11], sy = [0.01, 0.01, 0.19, 0.19];"
    bodies = "bodyPolygon(sx, sy, 0.01, 2); bodyCapsule(0.66, 0.09, 0.12, 0.09, 0, 2);"
    freefem_text(case("{ " + bodies + " }", more=more), "-mesh", cell, "-dt", 0.02, "-tend", 0.6, "-budget", 1,
        "-out", tmp_path / "a")
    table, contacts = numbers(tmp_path / "a", "particles.csv"), numbers(tmp_path / "a", "contacts.csv")
    assert np.abs(table["theta"]).max() < 1e-9 and np.abs(table["v"]).max() < 1e-9
    assert np.abs(table["u"]).max() < 1e-3
    areas = [0.2**2 - (4 - np.pi) * 0.01**2, 4 * 0.12 * 0.09 + np.pi * 0.09**2]
    late = contacts["t"] > 0.59
    for body, area in enumerate(areas):
        press = contacts["impulse"][late & (contacts["i"] == body)]
        assert len(press) == 2 and press == pytest.approx([0.5 * area * 0.02] * 2, rel=1e-3)
    higher = bodies.replace("0.66, 0.09,", "0.7, 0.29,").replace("0, 2)", "0.4, 2)")
    more = more.replace("0.01, 0.01, 0.19, 0.19", "0.06, 0.06, 0.24, 0.24")
    freefem_text(case("{ " + higher + " }", more=more, mu=0.005, gravity=-4), "-mesh", cell, "-dt", 0.005, "-tend", 1.6,
        "-budget", 1, "-film", 0, "-out", tmp_path / "b")
    budget, last = numbers(tmp_path / "b", "budget.csv"), numbers(tmp_path / "b", "particles.csv")
    left = budget["momentum_y"] - budget["walls_y"] - budget["weight_y"]
    assert np.abs(left).max() < 0.012 * np.abs(budget["weight_y"][-1])
    assert last["y"][-2:] == pytest.approx([0.1, 0.09], abs=1e-6) and np.abs(last["theta"][-2:]).max() < 1e-6


SHAPE = "part,closed,x,y,radius\n0,1,0,0,0.01\n0,1,0.2,0,0.01\n0,1,0.1,0.15,0.01\n"


def test_restart_with_files_and_the_queue(cell, tmp_path):
    """A triangle of a shape file hits the floor and a held capsule; another one enters, and all rub; a restart in the midst changes no
    bit."""
    (tmp_path / "shape.csv").write_text(SHAPE)
    (tmp_path / "particles.csv").write_text("id,x,y,radius,density,theta,v,shape\n"
        f"4,0.3,0.1,1,2,0.3,-0.5,{tmp_path / 'shape.csv'}\n7,0.3,0.5,0.08,2,0,0,\n")
    bodies = f"""{{ bodyHeld(bodyCapsule(0.6, 0.12, 0.1, 0.05, 0.5, 2));
        queueShape(bodyShaped("{tmp_path / 'shape.csv'}", 0.7, 0.7, 0.2, 3), 0.05); }}"""
    (tmp_path / "scene.edp").write_text(case(bodies, more=WORDS, mu=0.02, gravity=-10))
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-tend", "0.2", "-forces", "1", "-particles",
        tmp_path / "particles.csv", "-checkpoint", "5", "-friction", "0.3", "-film", "0"], tmp_path, 15)
    table = numbers(whole, "particles.csv")
    assert set(table["id"]) == {0, 4, 7, 8} and table["t"][table["id"] == 8].min() > 0.04
    assert numbers(whole, "contacts.csv")["t"].min() < 0.15 and set(numbers(whole, "outlines.csv")["id"]) == {0, 4, 7, 8}
    for name in ("particles.csv", "contacts.csv", "forces.csv", "outlines.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("words, scene, word", [
    pytest.param(["-scheme", "published"], {}, "published", marks=pytest.mark.slow),
    ([], {"walls": "labelLeft, labelRight, labelBottom", "slip": "labelTop"}, "symmetry")])
def test_what_shapes_do_not_take_is_refused(words, scene, word, cell, freefem_text):
    done = freefem_text(case("bodyCapsule(0.5, 0.5, 0.1, 0.1, 0, 2);", more=WORDS, **scene), "-mesh", cell, *words, check=False)
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 3 and len(lines) == 1 and lines[0].startswith("error: bodies of any shape") and word in lines[0]


def test_a_body_whose_parts_lie_outside_is_refused(cell, freefem_text):
    """Two disks on either side of the box, with their centre in it: they fell as if there were nothing."""
    clump = "{ real[int] cx = [-1., 2.], cy = [0.5, 0.5], cr = [0.1, 0.1]; bodyClump(cx, cy, cr, 2); }"
    done = freefem_text(case(clump, more=WORDS), "-mesh", cell, check=False)
    assert done.returncode == 5 and "in the mesh, but no vertex" in done.stderr and done.stderr.count("\n") == 1, done.stderr
    done = freefem_text(case(clump.replace("2.]", "0.5]"), more=WORDS), "-mesh", cell, check=False)
    assert done.returncode == 5 and "error:" in done.stderr, done.stderr
