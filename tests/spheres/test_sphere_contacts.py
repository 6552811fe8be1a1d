"""Contacts of spheres: the search against local minima of the distance by brute force, the projection against the conditions of the
minimum, and scripts/project_spheres.edp."""
import numpy as np
import pytest

from tests.conftest import run_freefem

SCRIPT = "scripts/project_spheres.edp"
SEARCH = """
include "lib/core/errors.idp"
include "lib/spheres/sphere_gaps.idp"
int n, walls;
ifstream f("{file}");
f >> n >> walls;
real[int] p(3*n), r(n), range(n), corners(9);
for (int k = 0; k < n; ++k) f >> p[k] >> p[n + k] >> p[2*n + k] >> r[k] >> range[k];
for (int k = 0; k < walls; ++k) {{ for (int c = 0; c < 9; ++c) f >> corners[c]; facetAdd(corners); }}
if (facetReady() >= 0) stopRun(exitBadInput, "flat");
gapFind(p, r, range);
cout.precision(15);
for (int k = 0; k < gapN; ++k) cout << "gap " << gapI[k] << " " << gapJ[k] << " " << gapD[k] << " " << gapEx[k] << " " << gapEy[k]
    << " " << gapEz[k] << endl;
"""


def strip(points, way):
    """Triangles of the squares between polygons: `points` (n, 3) and the same moved by `way`."""
    a, b = points[:-1], points[1:]
    return [t for p, q in zip(a, b) for t in ((p, q, p + way), (q + way, q, p + way))]


def walls():
    """A plane of 32 triangles, a ridge, a corner of three planes, a pipe of 24 facets, a tip, and two triangles that cross: 100 m
    apart from each other."""
    def at(k, points):
        return np.array(points, float) + [100.0 * k, 0, 0]
    plane = [t for k in range(4) for t in strip(np.array([[x, k, 0.0] for x in range(5)]), np.array([0.0, 1, 0]))]
    ridge = strip(np.array([[-2.0, 0, -1], [0, 0, 1], [2, 0, -1]]), np.array([0.0, 3, 0]))
    square = np.array([[0.0, 0, 0], [3, 0, 0]])
    corner = [t for turn in range(3) for t in np.roll(strip(square, np.array([0.0, 3, 0])), turn, axis=2)]
    angle = 2 * np.pi * np.arange(25) / 24
    angle[-1] = 0.0
    pipe = strip(2 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), np.array([0.0, 0, 4]))
    a, b, c, top = [1, 0, 0], [-0.5, 0.8, 0], [-0.5, -0.8, 0], [0, 0, 1]
    tip = [[top, a, b], [top, b, c], [top, c, a]]
    cross = [[[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[1, 1, -1], [1.2, 1, 2], [1.5, 2, 1]]]
    return np.concatenate([at(k, part) for k, part in enumerate([plane, ridge, corner, pipe, tip, cross])])


def spheres(rng):
    """Random ones around the walls, and some whose feet lie on an edge or a corner of a plane of triangles."""
    places = []
    for k, (low, high) in enumerate([([0, 0, -1], [4, 4, 1]), ([-2, -0.5, -1], [2, 3.5, 2]), ([0, 0, 0], [2, 2, 2]),
                                     ([-1.9, -1.9, 0], [1.9, 1.9, 4]), ([-1, -1, 0], [1, 1, 2]), ([0, 0, -1], [2, 2, 2])]):
        places.append(np.array(low) + (np.array(high) - low) * rng.random((60, 3)) + [100.0 * k, 0, 0])
    exact = np.array([[1.5, 1.0, 0.4], [2.0, 2.0, 0.4], [1.5, 1.5, -0.4], [100, 1.5, 1.5], [104, 0, 0.5], [400, 0, 1.5]])
    return np.vstack([*places, exact])


def minima(centre, triangles, reach):
    """Distances and directions of the points of a wall, closer than `reach`, at which the distance from the centre has a local
    minimum: no triangle that holds the point has a corner in a direction in which it decreases; the face, edge or corner of a
    triangle nearest to the centre supplies the points."""
    found = []
    near = triangles[((triangles.min(axis=1) < centre + reach) & (triangles.max(axis=1) > centre - reach)).all(axis=1)]
    for t in near:
        bases = [[c] for c in range(3)] + [[0, 1], [0, 2], [1, 2], [0, 1, 2]]
        for base in bases:
            a, along = t[base[0]], t[base[1:]] - t[base[0]]
            part = np.linalg.solve(along @ along.T, along @ (centre - a)) if len(along) else np.zeros(0)
            if (part < -1e-12).any() or part.sum() > 1 + 1e-12:
                continue
            point = a + part @ along
            away = np.linalg.norm(centre - point)
            own_is_least = ((t - point) @ (centre - point) <= 1e-9).all()
            if away < reach and own_is_least and all(np.linalg.norm(point - q) > 1e-7 for _, q, _ in found):
                found.append((away, point, len(base) == 3))
    kept = []
    for away, point, _ in found:
        least = True
        for t in near:
            a, b, c = t
            normal = np.cross(b - a, c - a)
            if abs((point - a) @ normal) > 1e-9 * np.linalg.norm(normal):
                continue
            s, h = np.linalg.lstsq(np.column_stack([b - a, c - a]), point - a, rcond=None)[0]
            if min(s, h, 1 - s - h) > -1e-9 and ((t - point) @ (centre - point) > 1e-9).any():
                least = False
        # two triangles that cross: the foot on either is kept, though the other goes on towards the centre
        if least or crossing(centre, point, near):
            kept.append((away, (centre - point) / away))
    return sorted(kept, key=lambda one: (round(one[0], 9), *np.round(one[1], 6)))


def crossing(centre, point, near):
    """Whether the point is the foot of the perpendicular within a triangle."""
    for a, b, c in near:
        normal = np.cross(b - a, c - a)
        s, h = np.linalg.lstsq(np.column_stack([b - a, c - a]), point - a, rcond=None)[0]
        flat = np.linalg.norm(a + s * (b - a) + h * (c - a) - point) < 1e-9
        upright = np.linalg.norm(np.cross(normal, centre - point)) < 1e-9 * np.linalg.norm(normal)
        if flat and upright and min(s, h, 1 - s - h) > 1e-9:
            return True
    return False


def test_the_search_finds_what_brute_force_finds(freefem_text, tmp_path):
    """Pairs of radii from 1 to 30, and local minima of the distance to walls with ridges, tips, bends and flat joints."""
    rng = np.random.default_rng(3)
    triangles, centre = walls(), spheres(rng)
    radius, reach = rng.choice([0.05, 0.2, 0.3, 1.5], len(centre), p=[0.4, 0.3, 0.25, 0.05]), rng.uniform(0.2, 0.6, len(centre))
    rows = [f"{len(centre)} {len(triangles)}"]
    rows += [" ".join(f"{x:.17g}" for x in (*c, r, e)) for c, r, e in zip(centre, radius, reach)]
    rows += [" ".join(f"{x:.17g}" for x in t.ravel()) for t in triangles]
    (tmp_path / "scene").write_text("\n".join(rows) + "\n")
    text = freefem_text(SEARCH.format(file=tmp_path / "scene")).stdout
    gaps = np.array([line.split()[1:] for line in text.splitlines() if line.startswith("gap")], float)
    pairs = gaps[gaps[:, 1] >= 0]
    far = np.linalg.norm(centre[:, None] - centre, axis=2)
    apart = far - radius[:, None] - radius
    i, j = np.nonzero(np.triu(apart < reach[:, None] + reach, 1))
    assert np.array_equal(pairs[:, :2], np.column_stack([i, j])) and len(i) > 200
    np.testing.assert_allclose(pairs[:, 2], apart[i, j], atol=1e-12)
    np.testing.assert_allclose(pairs[:, 3:], (centre[i] - centre[j]) / far[i, j][:, None], atol=1e-10)
    kinds = 0
    for k, c in enumerate(centre):
        mine = gaps[(gaps[:, 0] == k) & (gaps[:, 1] < 0)]
        mine = sorted(((g[2] + radius[k], g[3:]) for g in mine), key=lambda one: (round(one[0], 9), *np.round(one[1], 6)))
        theirs = minima(c, triangles, radius[k] + reach[k])
        assert len(mine) == len(theirs), (k, c, mine, theirs)
        for (d, e), (distance, direction) in zip(mine, theirs):
            assert d == pytest.approx(distance, abs=1e-9) and np.allclose(e, direction, atol=1e-6)
        kinds += len(mine) > 1
    assert kinds > 30


HEADER, WALLS = "id,x,y,z,radius,mass,u,v,w", "x1,y1,z1,x2,y2,z2,x3,y3,z3"


def table(path, header, rows):
    path.write_text("\n".join([header] + [",".join(f"{x:.17g}" for x in row) for row in rows]) + "\n")
    return path


def project(tmp_path, body_rows, triangles=(), dt=0.1, check=True):
    words = ["-bodies", table(tmp_path / "b.csv", HEADER, body_rows), "-dt", dt, "-out", tmp_path / "o.csv", "-contacts",
        tmp_path / "c.csv"]
    if len(triangles):
        words += ["-walls", table(tmp_path / "w.csv", WALLS, np.reshape(triangles, (-1, 9)))]
    run = run_freefem(SCRIPT, *words, check=check)
    if not check:
        return run
    contacts = np.loadtxt(tmp_path / "c.csv", delimiter=",", skiprows=1, ndmin=2).reshape(-1, 8)
    return np.loadtxt(tmp_path / "o.csv", delimiter=",", skiprows=1, ndmin=2)[:, 1:], contacts


def crowd(side, rng):
    """A loose cubic packing with velocities towards its centre, on a floor of triangles; one sphere is held, one heavy."""
    grid = 2.1 * np.array([[i, j, k] for i in range(side) for j in range(side) for k in range(side)], float)
    place = grid + rng.uniform(-0.03, 0.03, grid.shape)
    n = len(place)
    radius, mass = rng.uniform(0.9, 1.0, n), np.exp(rng.normal(0, 0.7, n))
    velocity = (place.mean(axis=0) - place) + rng.normal(0, 1, (n, 3)) - [0, 0, 9]
    mass[0], mass[1] = 1e30, 50
    velocity[0] = 0
    low, high = -9.0, 2.1 * side + 4
    a, b, c, d = [low, low, -1.04], [high, low, -1.04], [low, high, -1.04], [high, high, -1.04]
    return np.column_stack([10 + np.arange(n), place, radius, mass, velocity]), np.array([[a, b, c], [d, b, c]])


def test_the_conditions_of_the_minimum_hold_in_a_crowd(tmp_path):
    """No overlap; M (u - u^) is the sum of the impulses; they press, and only where the linearised gap closes: together these are
    the minimum. The energy falls."""
    rows, floor = crowd(6, np.random.default_rng(5))
    dt = 0.1
    after, contacts = project(tmp_path, rows, floor, dt)
    place, radius, mass, before = rows[:, 1:4], rows[:, 4], rows[:, 5], rows[:, 6:]
    free = mass < 1e29
    i, j, e, press = contacts[:, 1].astype(int) - 10, contacts[:, 2].astype(int), contacts[:, 4:7], contacts[:, 7]
    pair = j >= 0
    j = np.where(pair, j - 10, 0)
    assert len(press) > 200 and (~pair).sum() > 5 and (press > 0).all()
    assert np.array_equal(after[~free], before[~free])
    impulse = np.zeros_like(before)
    np.add.at(impulse, i, press[:, None] * e)
    np.add.at(impulse, j[pair], -(press[:, None] * e)[pair])
    np.testing.assert_allclose((mass[:, None] * (after - before))[free], impulse[free], atol=1e-7)
    rate = ((after[i] - np.where(pair[:, None], after[j], 0.0)) * e).sum(axis=1)
    assert np.abs(contacts[:, 3] + dt * rate).max() < 1e-8
    end = place + dt * after
    far = np.linalg.norm(end[:, None] - end, axis=2) - radius[:, None] - radius + 9 * np.eye(len(end))
    assert far.min() > -1e-8 and (end[:, 2] - radius + 1.04).min() > -1e-8
    energy = 0.5 * (mass[free, None] * np.array([before, after])[:, free]**2).sum(axis=(1, 2))
    assert energy[1] < energy[0]


def test_a_wall_of_facets_is_not_left(tmp_path):
    """A sphere that slides by many facets in one step, along the inside of a pipe of 96, and one that goes straight at it by 40
    radii: facets that had no row before get one."""
    angle = 2 * np.pi * np.arange(97) / 96
    angle[-1] = 0.0
    pipe = strip(10 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), np.array([0.0, 0, 40]))
    rows = [[0, 8.9, 0, 20, 1, 1, 0, 6.0, 0], [1, 0, 0, 10, 0.5, 1, 100, 200, 0]]
    after, contacts = project(tmp_path, rows, pipe, 1.0)
    end = np.array(rows)[:, 1:4] + after
    for x, r in zip(end, (1.0, 0.5)):
        assert 10 * np.cos(np.pi / 96) - 1e-8 < np.hypot(*x[:2]) + r < 10
        assert min(distance for distance, _ in minima(x, np.array(pipe), 3.0)) > r * (1 - 1e-8)
    assert (contacts[:, 2] < 0).all()


@pytest.mark.parametrize("text, status, said", [
    ("id,x,y,radius,mass,u,v\n0,0,0,1,1,0,0\n", 3, "the first row must be"),
    (HEADER + "\n0,0,0,0,1,1,0,0,nan\n", 3, "is not a finite number"),
    (HEADER + "\n0,0,0,0,0,1,0,0,0\n", 3, "radius that is not above 0"),
    (HEADER + "\n0,0,0,0,1,1,0,0,0\n0,5,0,0,1,1,0,0,0\n", 3, "given twice"),
    (HEADER + "\n3,0,0,0,1,1,0,0,0\n4,1.5,0,0,1,1,0,0,0\n", 5, "spheres 3 and 4 overlap by 0.5"),
])
def test_bad_files_are_refused(text, status, said, tmp_path):
    (tmp_path / "b.csv").write_text(text)
    run = run_freefem(SCRIPT, "-bodies", tmp_path / "b.csv", "-out", tmp_path / "o.csv", check=False)
    assert run.returncode == status and said in run.stderr and not (tmp_path / "o.csv").exists()


def test_columns_come_in_any_order(freefem, tmp_path):
    """Those of spheres, of their walls, and of disks, in a file of Windows too: the same velocities."""
    files = {"s": ("scripts/project_spheres.edp", [HEADER, "7,0,0,1.02,1,1,1,0,-1", "9,4.05,0,5,3,27,-1,0,0"], [WALLS,
        "-9,-9,0,9,-9,0,0,9,0"]), "d": ("scripts/project_velocities.edp", ["id,x,y,radius,mass,u,v", "7,0,1.02,1,1,1,-1",
        "9,2.1,1.5,1,3,-1,0"], ["x1,y1,x2,y2", "-9,0,9,0"])}
    for kind, (script, *tables) in files.items():
        for turned, end in ((False, "\n"), (True, "\r\n")):
            for name, rows in zip("bw", tables):
                cells = [row.split(",") for row in rows]
                (tmp_path / name).write_text("".join(",".join(row[::-1] if turned else row) + end for row in cells), newline="")
            freefem(script, "-bodies", tmp_path / "b", "-walls", tmp_path / "w", "-dt", 0.1, "-out", tmp_path / f"{kind}{turned}")
        found = (tmp_path / f"{kind}True").read_text()
        assert found == (tmp_path / f"{kind}False").read_text() and float(found.splitlines()[1].split(",")[-1]) > -0.3


def test_walls_and_the_plane_script_refuse(freefem_refused, tmp_path):
    """A triangle without an area; a sphere that overlaps a wall; prescribed motions that leave no room; the script for disks."""
    one = [[7, 0, 0, 0.5, 1, 1, 0, 0, 0]]
    bodies = table(tmp_path / "b.csv", HEADER, one)
    flat = table(tmp_path / "w.csv", WALLS, [[0, 0, 0, 1, 0, 0, 2, 0, 0]])
    assert "triangle 1 has no area" in freefem_refused(3, SCRIPT, "-bodies", bodies, "-walls", flat, "-out", tmp_path / "o.csv")
    done = project(tmp_path, one, [[[-9, -9, 0], [9, -9, 0], [0, 9, 0]]], check=False)
    assert done.returncode == 5 and "sphere 7 overlaps triangle 1 of the walls by 0.5" in done.stderr
    pressed = [[0, 0, 0, 0, 1, -1, 3, 0, 0], [1, 2.1, 0, 0, 1, 1, 0, 0, 0], [2, 4.2, 0, 0, 1, -1, -3, 0, 0]]
    done = project(tmp_path, pressed, dt=0.3, check=False)
    assert done.returncode == 4 and "no room" in done.stderr and "sphere 1" in done.stderr
    assert "project_spheres.edp" in freefem_refused(3, "scripts/project_velocities.edp", "-bodies", bodies, "-out",
        tmp_path / "o.csv")
