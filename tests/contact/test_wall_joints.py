"""A straight wall given in pieces acts as one (lib/contact/wall_joints.idp, lib/contact/mesh_walls.idp)."""
import numpy as np
import pytest

from tests.scenes import CONTACTS, turned, write_walls
from tests.tables import rows
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table

EDGES = np.linspace(0, 8, 41)


def pieces(edges, more=0.0):
    """Walls along x between these edges, each longer by `more` at both ends, (n, 4)."""
    return np.array([[a - more, 0, b + more, 0] for a, b in zip(edges, edges[1:])])


def shaken(walls, share, seed=1):
    """Walls whose ends are off by that share of their length."""
    away = np.random.default_rng(seed).uniform(-1, 1, walls.shape)
    return walls + share * np.hypot(*(walls[:, 2:] - walls[:, :2]).T)[:, None] * away


def scattered(walls, seed=2):
    """In another order, every other one from its second end to its first."""
    walls = walls[np.random.default_rng(seed).permutation(len(walls))]
    walls[::2] = walls[::2][:, [2, 3, 0, 1]]
    return walls


FLOORS = {
    "end to end": pieces(EDGES),
    "of any length": pieces(np.r_[0, np.sort(np.random.default_rng(3).uniform(0, 8, 60)), 8]),
    "overlapping": pieces(EDGES, 0.05),
    "given twice": np.vstack([pieces(EDGES), pieces(EDGES)]),
    "in any order": scattered(pieces(EDGES)),
    "nearly end to end": shaken(scattered(pieces(EDGES)), 1e-9),
    "on a long one": np.vstack([pieces(EDGES[5:30], 0.03), [[8, 0, 0, 0]]]),
    "with points on it": np.vstack([pieces(EDGES), [[2.1, 0, 2.1, 0], [3, 0, 3, 0]]]),
}
SLIDE = """
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
include "lib/contact/periodic.idp"
optCase("slide", "disks slide on floors in pieces");
real gravityX = {gx}, gravityY = {gy};
macro caseWalls() contactWallsFromCsv("{walls}"); {more} // EOM
func int sceneBodies() {{ {bodies} return 0; }}
macro caseParticles() sceneBodies(); // EOM
include "scripts/contacts.edp"
"""


@pytest.mark.parametrize("move", [0.04, 0.02, 0.01])
@pytest.mark.parametrize("angle, far", [(0, 0), (0.37, 0), (0.37, 1e4)])
def test_a_disk_slides_over_a_floor_in_pieces(move, angle, far, freefem_text, tmp_path):
    """It kept 0.13, 0.36, 0.71 of its speed on pieces end to end; far: m from the origin. Floors lie above each other, each with a
    disk, which goes past the last point that lies on one, at 3."""
    turn = turned(angle)
    place = lambda x, y: turn @ (x, y) + far
    walls = np.vstack([np.hstack([(floor[:, :2] + (0, 3 * k)) @ turn.T, (floor[:, 2:] + (0, 3 * k)) @ turn.T]) for k,
        floor in enumerate(FLOORS.values())]) + far
    write_walls(tmp_path / "walls.csv", walls)
    bodies = "".join("bodyAdd({:.17g}, {:.17g}, 0.1, 1000, {:.17g}, {:.17g}, 0, 1); ".format(*place(0.5, 3 * k + 0.1 + 1e-8),
        *turn[:, 0]) for k in range(len(FLOORS)))
    gx, gy = turn @ (0, -9.81)
    freefem_text(SLIDE.format(gx=gx, gy=gy, walls=tmp_path / "walls.csv", bodies=bodies, more=""), "-dt", move, "-tend", 2.6,
        "-every", 4, "-contact-overlap", 1e-6, "-out", tmp_path / "run")
    last = read_table(tmp_path / "run" / "particles.csv")
    last = {name: last[name][-len(FLOORS):] for name in ("u", "v", "x", "y")}
    along = last["u"] * turn[0, 0] + last["v"] * turn[1, 0]
    assert along == pytest.approx(np.ones(len(FLOORS)), abs=1e-6), dict(zip(FLOORS, along))
    assert (turn.T @ (np.array([last["x"], last["y"]]) - far))[0] == pytest.approx(np.full(len(FLOORS), 3.1), abs=1e-5)


@pytest.mark.parametrize("start, bent", [(0, 0), (0.13, 0), (0, 1)])
def test_a_floor_in_pieces_goes_on_across_a_periodic_side(start, bent, freefem_text, tmp_path):
    """A disk goes three times round a period; bent: on a slope over two thirds of the period, level beyond, in pieces both, on
    which it slides by one piece."""
    floor = pieces(np.linspace(start, start + 1, 8))
    if bent:
        slope = np.array([[0.4 + 0.1 * k, 0.1 * k, 0.5 + 0.1 * k, 0.1 * k + 0.1] for k in range(6)])  # across the side x = 1
        floor = slope
    write_walls(tmp_path / "walls.csv", floor)
    body = "bodyAdd(0.5 - 0.1*sqrt(.5), 0.1 + 0.1*sqrt(.5) + 1e-9, 0.1, 1000, sqrt(.5), sqrt(.5), 0, 1);" if bent else "bodyAdd(0.5, 0.1 + 1e-9, 0.1, 1000, 1, 0, 0, 1);"
    gx, gy = (5, -5) if bent else (0, -10)
    freefem_text(SLIDE.format(gx=gx, gy=gy, walls=tmp_path / "walls.csv", bodies=body, more="contactPeriodic(0, -1, 1, 0);"),
        "-dt", 0.01, "-tend", 0.6 if bent else 3, "-every", 4, "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx(1, abs=1e-6)


ELLIPSES = """
include "lib/contact/ellipse_project.idp"
include "lib/contact/periodic.idp"
optCase("slide", "ellipses slide on floors in pieces");
optDefault("-contact-tol", "1e-12"); optDefault("-contact-overlap", "1e-10");
contactDeclare(); optEnd();
contactWallsFromCsv("{walls}");
{more}
int n = {count};
real dt = 0.02;
real[int] px(n), py(n), turn(n), r(n), aspect(n), mass(n), moment(n), u(n), v(n), w(n);
int[int] id = 0:n - 1;
px = 0.5; r = 0.1; aspect = 0.6; mass = 1.; moment = 0.0034; u = 1.; w = 0.; turn = 0.;
for (int k = 0; k < n; ++k) py[k] = 3*k + 0.06 + 1e-9;
for (int k = 0; k < {steps}; ++k) {{
    v -= 0.1*dt;
    contactEllipseProject(px, py, turn, r, aspect, id, mass, moment, u, v, w, dt);
    px += dt*u; py += dt*v; turn += dt*w;
}}
cout.precision(12);
for (int k = 0; k < n; ++k) cout << "end " << u[k] << " " << px[k] << " " << turn[k] << endl;
"""


@pytest.mark.parametrize("periodic", [0, 1])
def test_ellipses_slide_over_floors_in_pieces(periodic, freefem_text, tmp_path):
    """In a period also on a wall of 0.8 of it, which is cut."""
    floors = [pieces(np.linspace(0, 2.5, 9)), np.array([[0.2, 0, 2.2, 0]])] if periodic else [*FLOORS.values()]
    write_walls(tmp_path / "walls.csv", np.vstack([floor + (0, 3 * k, 0, 3 * k) for k, floor in enumerate(floors)]))
    text = ELLIPSES.format(walls=tmp_path / "walls.csv", count=len(floors), steps=70 if periodic else 150,
        more="contactPeriodic(0, 0, 2.5, 0);" if periodic else "")
    ends = rows(freefem_text(text).stdout, "end")
    way = 1.4 if periodic else 3
    assert ends == pytest.approx(np.tile([1, 0.5 + way, 0], (len(floors), 1)), abs=2e-6)


def test_a_floor_in_pieces_projects_velocities_as_one(freefem, tmp_path):
    """A disk above the middle of a piece flies along the floor over three others."""
    (tmp_path / "bodies.csv").write_text("id,x,y,radius,mass,u,v\n"
        + "".join(f"{k},{0.9 + 0.4 * k},{0.1 + 1e-9},0.1,1,{0.7 + 0.1 * k},-0.5\n" for k in range(5)))
    write_walls(tmp_path / "pieces.csv", scattered(FLOORS["nearly end to end"]))
    write_walls(tmp_path / "one.csv", [[0, 0, 8, 0]])
    for name in ("pieces", "one"):
        freefem("scripts/project_velocities.edp", "-bodies", tmp_path / "bodies.csv", "-walls", tmp_path / f"{name}.csv", "-dt",
            0.9, "-contact-overlap", 1e-6, "-out", tmp_path / f"{name}_projected.csv")
    found, right = (read_table(tmp_path / f"{name}_projected.csv") for name in ("pieces", "one"))
    assert found["u"] == pytest.approx(right["u"], abs=1e-7) and found["v"] == pytest.approx(right["v"], abs=1e-7)


def test_a_contact_is_written_with_the_piece_that_it_is_on(freefem_text, tmp_path):
    write_walls(tmp_path / "walls.csv", np.vstack([pieces([0, 1, 2, 3]), [[0, 0, 0, 1]]]))
    bodies = " ".join(f"bodyDisk({x}, 0.1, 0.1, 1000);" for x in (0.5, 1.5, 2.5))
    freefem_text(SLIDE.format(gx=0, gy=-1, walls=tmp_path / "walls.csv", bodies=bodies, more=""), "-dt", 0.01, "-tend", 0.02,
        "-every", 0, "-out", tmp_path / "run")
    contacts, walls = read_table(tmp_path / "run" / "contacts.csv"), read_table(tmp_path / "run" / "walls.csv")
    assert contacts["i"].tolist() == [0, 1, 2] * 2 and contacts["j"].tolist() == [-1, -2, -3] * 2
    assert walls["x1"].tolist() == [0, 1, 2, 0]


GATE = """
macro caseStep() {{
    if (driveStep == 11) contactWallVelocity(1, 0, -1);
    if (driveStep == 21) contactWallVelocity(1, 0, 1);
    if (driveStep == 31) contactWallVelocity(1, 0, 0);
}} // EOM
"""
SCENE = CONTACTS.replace("{more}", GATE.replace("{{", "{").replace("}}", "}").replace("{", "{{").replace("}", "}}"))


def test_a_piece_that_moves_is_a_wall_of_its_own(freefem_text, tmp_path):
    """The second of three pieces of a floor goes down and comes back with its disk; then two disks slide over all three, after a
    restart too."""
    bodies = "bodyDisk(1.5, 0.1, 0.1, 1000); bodyAdd(-5, 0.1, 0.1, 1000, 10, 0, 0, 1); bodyDisk(8, 0.1, 0.1, 1000);"
    text = SCENE.format(bodies=bodies, walls="contactWallSegment(-6, 0, 1, 0); contactWallSegment(1, 0, 2, 0); "
        "contactWallSegment(2, 0, 9, 0);", gravity=-10)
    text = text.replace("caseStep() {", "caseStep() { if (driveStep == 32) driveU[0] = 10;")
    words = ("-dt", 0.01, "-every", 0, "-contact-tol", 1e-12)
    freefem_text(text, *words, "-tend", 0.75, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run").particles
    first, second = [{name: run[name][run["id"] == k] for name in ("x", "y", "u")} for k in (0, 1)]
    # in free fall, and carried
    assert first["y"][20] == pytest.approx(0.045, abs=1e-6) and first["y"][30] == pytest.approx(0.1, abs=1e-6)
    assert first["y"][-1] == pytest.approx(0.1, abs=1e-6) and first["u"][-1] == pytest.approx(10,
        abs=1e-6) and second["u"][-1] == pytest.approx(10, abs=1e-6)
    assert first["x"][-1] > 5 and second["x"][-1] > 2.4  # over both joints
    freefem_text(text, *words, "-tend", 0.75, "-checkpoint", 25, "-maxwall", 1e-3, "-out", tmp_path / "half")
    for _ in range(40):
        if "finished" in freefem_text(text, *words, "-tend", 0.75, "-checkpoint", 25, "-restart", tmp_path / "half").stdout:
            break
    assert (tmp_path / "half" / "particles.csv").read_text() == (tmp_path / "run" / "particles.csv").read_text()


STRIP = """
include "lib/contact/walls.idp"
mesh Th = readmesh("{file}");
int[int] all = [1, 2, 3, 4];
int made = contactWallsFromMesh(Th, all);
contactWallsWrite("{walls}");
cout << "made " << made << endl;
"""


def write_strip(file, along, across, turn, figures, origin=(0.0, 0.0), bend=0.0):
    """A strip of so many squares along and across, from (0, 0) to (along/10, across/10), turned; coordinates with so many
    significant digits; bend: slope of its second half."""
    x, y = np.meshgrid(np.arange(along + 1) / 10, np.arange(across + 1) / 10)
    points = np.c_[x.ravel(), (y + bend * np.maximum(x - along / 20, 0)).ravel()] @ turned(turn).T + origin
    at = lambda i, j: j * (along + 1) + i + 1
    triangles = [(*t, 0) for i in range(along) for j in range(across) for t in ((at(i, j), at(i + 1, j), at(i + 1, j + 1)),
        (at(i, j), at(i + 1, j + 1), at(i, j + 1)))]
    edges = [(at(i, j), at(i + 1, j), 1 + 2 * (j > 0)) for i in range(along) for j in (0, across)] + [(at(i, j), at(i, j + 1),
        4 - 2 * (i > 0)) for j in range(across) for i in (0, along)]
    block = lambda name, lines: f"{name}\n{len(lines)}\n" + "".join(" ".join(map(str, line)) + "\n" for line in lines)
    file.write_text("MeshVersionFormatted 2\nDimension 2\n" + block("Vertices", [(f"{a:.{figures}g}", f"{b:.{figures}g}", 0) for a,
        b in points]) + block("Edges", edges) + block("Triangles", triangles) + "End\n")


@pytest.mark.parametrize("figures", [5, 6, 9, 16])
@pytest.mark.parametrize("turn, origin", [(0.37, (0, 0)), (1.2, (3, 0.7)), (-0.04, (0, 0))])
def test_walls_of_a_mesh_with_few_digits_are_straight(turn, origin, figures, freefem_text, tmp_path):
    """And a disk keeps its speed along one of them."""
    write_strip(tmp_path / "strip.mesh", 60, 4, turn, figures, origin)
    assert "made 4\n" in freefem_text(STRIP.format(file=tmp_path / "strip.mesh", walls=tmp_path / "walls.csv")).stdout
    walls = read_table(tmp_path / "walls.csv")
    ends = np.array([[walls["x1"], walls["y1"]], [walls["x2"], walls["y2"]]]) - np.reshape(origin, (1, 2, 1))
    floor = np.abs((turned(turn).T @ ends)[:, 1]).max(0).argmin()
    first, second = sorted(ends[:, :, floor] + origin, key=lambda end: (end - origin) @ turned(turn)[:, 0])
    t = (second - first) / np.hypot(*(second - first))
    at = lambda x, y: first + np.array([t, (-t[1], t[0])]).T @ (x, y)
    body = "bodyAdd({:.17g}, {:.17g}, 0.1, 1000, {:.17g}, {:.17g}, 0, 1);".format(*at(0.5, 0.1 + 1e-8), *t)
    freefem_text(SLIDE.format(gx=9.81 * t[1], gy=-9.81 * t[0], walls=tmp_path / "walls.csv", bodies=body, more=""), "-dt", 0.02,
        "-tend", 5, "-every", 5, "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    assert t @ (last["x"][-1] - first[0], last["y"][-1] - first[1]) == pytest.approx(5.5, abs=5e-6) and t @ (last["u"][-1],
        last["v"][-1]) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("figures, bend", [(5, 3e-4), (6, 3e-4), (5, 2e-3), (16, 3e-4)])
def test_a_side_of_a_mesh_that_bends_a_little_is_two_walls(figures, bend, freefem_text, tmp_path):
    """It was a hundred, as the whole side was not straight."""
    write_strip(tmp_path / "strip.mesh", 60, 4, 0.37, figures, bend=bend)
    assert "made 6\n" in freefem_text(STRIP.format(file=tmp_path / "strip.mesh", walls=tmp_path / "walls.csv")).stdout
    walls = read_table(tmp_path / "walls.csv")
    ends = np.array([np.r_[walls["x1"], walls["x2"]], np.r_[walls["y1"], walls["y2"]]]).T @ turned(0.37)
    inner = ends[(ends[:, 0] > 1) & (ends[:, 0] < 5)]
    assert inner[:, 0] == pytest.approx(np.full(4, 3), abs=2 * 10.0 ** (1 - figures) / bend + 1e-6)


@pytest.mark.parametrize("figures", [5, 6, 16])
def test_curved_walls_of_a_mesh_with_few_digits_keep_their_corners(figures, freefem_text, tmp_path):
    """A ring of 400 edges, and a bump of 1 % of a side's length."""
    angle = 2 * np.pi * np.arange(400) / 400
    points = np.vstack([np.c_[np.cos(angle), np.sin(angle)], 0.5 * np.c_[np.cos(angle), np.sin(angle)]])
    triangles = [(*t, 0) for k in range(400) for t in ((k + 1, (k + 1) % 400 + 1, k + 401), ((k + 1) % 400 + 1,
        (k + 1) % 400 + 401, k + 401))]
    edges = [(k + 1, (k + 1) % 400 + 1, 1) for k in range(400)] + [(k + 401, (k + 1) % 400 + 401, 2) for k in range(400)]
    block = lambda name, lines: f"{name}\n{len(lines)}\n" + "".join(" ".join(map(str, line)) + "\n" for line in lines)
    (tmp_path / "ring.mesh").write_text("MeshVersionFormatted 2\nDimension 2\n" + block("Vertices",
        [(f"{a:.{figures}g}", f"{b:.{figures}g}", 0) for a, b in points]) + block("Edges", edges) + block("Triangles", triangles)
            + "End\n")
    assert "made 800\n" in freefem_text(STRIP.format(file=tmp_path / "ring.mesh", walls=tmp_path / "walls.csv")).stdout


CAPSULE = 'include "lib/case.idp"\ninclude "lib/bodies/shapes.idp"\n' + SLIDE


def test_pieces_given_twice_with_few_digits_are_given_once(freefem_text, tmp_path):
    """Joints lie up to 1e-4 beside the floor, 1.7e-3 radii. A capsule that moves by a third of its radius in a step lost 15 % of
    its speed on pieces given twice, whose ends were free ends: the neighbour that each found was its own copy."""
    turn = turned(0.3)
    place = lambda x, y: turn @ (x, y) + (0, 12)
    floor = pieces(np.r_[0, np.sort(np.random.default_rng(7).uniform(0, 6, 14)), 6])
    floors = [floor, np.vstack([floor, floor[3:9], floor[5:6]]), scattered(np.vstack([floor, floor]))]
    walls = np.vstack([np.array([[*place(x1, 3 * k), *place(x2, 3 * k)] for x1, _, x2, _ in one]) for k, one in enumerate(floors)])
    write_walls(tmp_path / "walls.csv", np.vectorize(lambda value: float(f"{value:.6g}"))(walls))
    bodies = "".join("bodyThrown(bodyCapsule({:.17g}, {:.17g}, 0.1, 0.06, 0.3, 1000), {:.17g}, {:.17g}, 0); ".format(
        *place(0.5, 3 * k + 0.0602), *turn[:, 0]) for k in range(len(floors)))
    gx, gy = turn @ (0, -9.81)
    freefem_text(CAPSULE.format(gx=gx, gy=gy, walls=tmp_path / "walls.csv", bodies=bodies, more=""), "-dt", 0.02, "-tend", 4,
        "-every", 4, "-out", tmp_path / "run")
    last = read_table(tmp_path / "run" / "particles.csv")
    along = last["u"][-3:] * turn[0, 0] + last["v"][-3:] * turn[1, 0]
    assert (along > 0.998).all(), along


def test_contacts_of_a_capsule_are_written_with_their_pieces(freefem_text, tmp_path):
    """Both ends press, each on its own piece of one floor."""
    write_walls(tmp_path / "walls.csv", scattered(pieces([0, 0.5, 1, 2])))
    freefem_text(CAPSULE.format(gx=0, gy=-1, walls=tmp_path / "walls.csv", bodies="bodyCapsule(0.5, 0.06, 0.4, 0.06, 0, 1000);",
        more=""), "-dt", 0.01, "-tend", 0.01, "-every", 0, "-out", tmp_path / "run")
    contacts, walls = read_table(tmp_path / "run" / "contacts.csv"), read_table(tmp_path / "run" / "walls.csv")
    assert len(contacts["x"]) == 2
    for x, j in zip(contacts["x"], contacts["j"]):
        ends = sorted([walls["x1"][int(-1 - j)], walls["x2"][int(-1 - j)]])
        assert ends[0] <= x <= ends[1]
