"""Bodies of any shape in contacts alone, against closed forms: rest, inclines, tipping, impacts, heaps, inertia.

Several scenes stand side by side in one run, each with walls and coefficients of its own.
"""
import filecmp

import numpy as np
import pytest

from tests.contact.shapes import (array, capsule, clump, disks_area, gap_of_capsules, moments, polygon, read_bodies, scene_text)
from tests.scenes import case
from tools.base.tables import read_table

G, RHO = 9.81, 1000.0


@pytest.fixture
def scene(freefem_text, tmp_path):
    """Runs bodies and walls (lines of a case); returns the folder of the run."""

    def run(bodies, walls, *words, gravity=(0.0, -G), name="run", **options):
        done = freefem_text(scene_text(bodies, walls, gravity), *words, "-out", tmp_path / name, **options)
        return tmp_path / name if options.get("check", True) else done

    return run


def ends(folder, name="particles"):
    """The columns of the rows of the first and of the last time."""
    rows = read_table(folder / f"{name}.csv")
    return [{key: rows[key][rows["t"] == t] for key in rows} for t in (rows["t"].min(), rows["t"].max())]


def square(side, rounding):
    """The vertices of a square of this side with rounded corners, centre at 0."""
    a = 0.5 * side - rounding
    return np.array([[-a, -a], [a, -a], [a, a], [-a, a]])


def on_incline(corners, k, angle, below):
    """Corners (n, 2) turned by -angle and put on the plane k, which sinks to the right; the lowest is `below` over it."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([k + 0.45 * c + below * s, -0.45 * s + below * c]) + corners @ np.array([[c, -s], [s, c]])


def incline(k, angle, mu):
    """Plane k, which sinks to the right, with a coefficient of friction."""
    return f"contactWallRough(contactWallSegment({k}, 0, {k + 0.9 * float(np.cos(angle))!r}, {-0.9 * float(np.sin(angle))!r}), {mu!r});"


def test_squares_and_capsules_stay_at_rest(scene):
    """A square, a capsule and a stack of a square, a capsule and a clump of three disks, for 500 steps; with friction and
    without."""
    bodies = []
    for x, mu in ((0, 0.5), (3, 0)):
        bodies += [polygon(square(0.2, 0.01) + [x, 0.1], mu=mu), capsule(x + 0.5, 0.05, 0.1, 0.05, 0, mu)]
        bodies += [polygon(square(0.2, 0.01) + [x + 1, 0.1], mu=mu), capsule(x + 1, 0.25, 0.08, 0.05, 0, mu)]
        bodies += [clump(np.array([[0.94, 0.34], [1, 0.34], [1.06, 0.34]]) + [x, 0], [0.04, 0.04, 0.04], mu)]
    first, last = ends(scene(bodies, ["contactWallSegment(-1, 0, 5, 0);"], "-friction", 1, "-friction-tol", 1e-12, "-dt", 0.005,
        "-tend", 2.5, "-every", 2.5))
    assert np.abs(np.array([last[name] - first[name] for name in ("x", "y", "theta")])).max() < 1e-9
    assert np.abs(np.array([last[name] for name in ("u", "v", "omega")])).max() < 1e-9


def test_blocks_tip_slide_or_stay_on_an_incline(scene):
    """A block of half-width a and half-height h tips where tan alpha > a/h, if friction holds it; without friction it slides with
    g sin alpha and does not turn; with less friction, a block and a rigid block of disks slide with g (sin alpha - mu cos alpha),
    or stay."""
    a, h, r = 0.05, 0.1, 1e-3
    corners = np.array([[-a, r], [a, r], [a, 2 * h - r], [-a, 2 * h - r]])  # it stands on the points below the lower two
    tip = np.arctan(a / h)
    plan = [(tip - 0.002, 2.0), (tip + 0.002, 2.0), (0.4, 0.0), (0.4, 0.2), (0.2, 0.3), (0.3, 0.2), (0.15, 0.2)]
    bodies, walls = [], []
    for k, (angle, mu) in enumerate(plan):
        walls.append(incline(k, angle, mu))
        if k < 5:
            bodies.append(polygon(on_incline(corners, k, angle, 0.0), r, mu))
        else: # a block of 2 x 2 disks
            centres = on_incline(0.03 * np.array([[-1.0, 1], [1, 1], [1, 3], [-1, 3]]), k, angle, 0.0)
            bodies.append(clump(centres, [0.03] * 4, mu))
    steps, dt = 50, 0.002
    first, last = ends(scene(bodies, walls, "-friction", 5, "-friction-tol", 1e-12, "-contact-tol", 1e-12, "-dt", dt, "-tend",
        steps * dt, "-every", 1))
    angles, mus = np.array(plan).T
    turned = last["theta"] - first["theta"]
    way = (last["x"] - first["x"]) * np.cos(angles) - (last["y"] - first["y"]) * np.sin(angles)
    speed = last["u"] * np.cos(angles) - last["v"] * np.sin(angles)
    lever = np.hypot(a, h)
    rate = np.sqrt(G * lever / (lever**2 + ((a + r) ** 2 + h**2) / 3))
    np.testing.assert_allclose(turned[1], -0.002 * (np.cosh(rate * np.sqrt(steps * (steps + 1)) * dt) - 1), rtol=0.01)
    np.testing.assert_allclose(np.delete(turned, 1), 0, atol=1e-9)
    np.testing.assert_allclose(way[[0, 4, 6]], 0, atol=1e-9)
    slides = [2, 3, 5]
    exact = G * (np.sin(angles) - mus * np.cos(angles))
    np.testing.assert_allclose(speed[slides], exact[slides] * steps * dt, rtol=1e-7)


def falling(points, radii, rough, down=(0.3, -1.0), omega=0.7):
    """The motion of a rigid body of RHO after it has hit the plane y = 0 in the lowest of its disks: (u, v, omega), in closed form.
    rough: the point of contact stops; else only its approach does."""
    area, centre, arm = disks_area(points, radii)
    lowest = int(np.argmin(points[:, 1] - radii))
    rx, ry = points[lowest][0] - centre[0], -centre[1]
    normal, tangent = np.array([0, 1, rx]), np.array([1, 0, -ry])
    rows = np.array([normal, tangent] if rough else [normal])
    inverse, z = np.diag([1 / area, 1 / area, 1 / (area * arm)]), np.array([*down, omega])
    return z - inverse @ rows.T @ np.linalg.solve(rows @ inverse @ rows.T, rows @ z)


def test_a_clump_of_two_disks_is_the_union_of_them(scene):
    """Two disks that touch, or overlap: mass and inertia in closed form, oblique impact onto a plane, smooth and rough, and free
    spinning."""
    bodies, exact, walls = [], [], ["contactWallSegment(-9, 0, 9, 0);"]
    for k, (apart, rough) in enumerate([(0.2, 0), (0.2, 1), (0.13, 0), (0.13, 1)]):
        angle = 0.6
        points = np.array([[0, 0], [np.cos(angle), np.sin(angle)]]) * apart + [k, 0.1]
        radii = np.array([0.1, 0.1])
        bodies.append(clump(points, radii, 50.0 * rough, motion=(0.3, -1, 0.7)))
        exact.append(falling(points, radii, rough))
    spin = [[4, 3.0], [4.15, 3.0]]
    bodies.append(clump(spin, [0.1, 0.1], motion=(0.2, 0.1, 2.0)))
    folder = scene(bodies, walls, "-friction", 60, "-friction-tol", 1e-13, "-contact-tol", 1e-13, "-dt", 1e-6, "-tend", 2e-6,
        "-every", 1e-6, gravity=(0.0, 0.0))
    first, last = ends(folder)
    found = np.array([last[name] for name in ("u", "v", "omega")]).T
    np.testing.assert_allclose(found[:4], exact, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(found[4], (0.2, 0.1, 2.0), rtol=1e-12)
    np.testing.assert_allclose(last["theta"][4], 2.0 * 2e-6, rtol=1e-9)
    np.testing.assert_allclose([first["x"][4], first["y"][4]], [4.075, 3.0], rtol=1e-12)


def test_a_disk_that_falls_onto_a_pinned_or_a_held_capsule(scene):
    """The pinned one turns with m d v/(J + m d^2) about its centre, the held one turns on as given and pushes the disk."""
    h, r, d, v, small = 0.5, 0.05, 0.3, -1.0, 0.04
    bodies = []
    for x, kind, omega in ((0, "bodyPinned", 0.0), (3, "bodyHeld", 0.4)):
        bodies.append(f"{kind}({capsule(x, 0, h, r, 0, motion=(0, 0, omega))[:-1]});")
        bodies.append(f"bodyAdd({x + d}, {r + small}, {small}, 1000, 0, {v}, 0, 1);")
    last = ends(scene(bodies, [], "-dt", 1e-6, "-tend", 1e-6, gravity=(0, 0)))[1]
    moment = RHO * (4 * h * r * (h**2 + r**2) / 3 + np.pi * r**4 / 2 + np.pi * r**2 * h**2 + 8 / 3 * h * r**3)
    mass = RHO * np.pi * small**2
    turns = mass * d * v / (moment + mass * d**2)
    np.testing.assert_allclose([last["omega"][0], last["v"][1]], [turns, turns * d], rtol=1e-6)
    np.testing.assert_allclose([last["omega"][2], last["v"][3], last["theta"][2]], [0.4, 0.4 * d, 0.4e-6], rtol=1e-6)
    assert (last["u"][[0, 2]] == 0).all() and (last["v"][[0, 2]] == 0).all()


@pytest.mark.parametrize("friction", [0, 0.4])
def test_a_collision_of_two_capsules_keeps_momentum_and_angular_momentum(friction, scene):
    plan = [(0.0, 0.0, 0.2, 0.05, 0.3, 1000.0, (1.0, 0.2, -3.0)), (0.35, 0.16, 0.1, 0.06, 1.8, 500.0, (-1.0, -0.5, 2.0))]
    bodies = [capsule(*one[:5], density=one[5], motion=one[6]) for one in plan]
    folder = scene(bodies, [], "-friction", friction, "-dt", 0.002, "-tend", 0.3, "-every", 0.002, gravity=(0.0, 0.0))
    rows = read_table(folder / "particles.csv")
    half, radius, density = (np.array([one[k] for one in plan]) for k in (2, 3, 5))
    area = 4 * half * radius + np.pi * radius**2
    moment = (4 * half * radius * (half**2 + radius**2) / 3 + np.pi * radius**4 / 2 + np.pi * radius**2 * half**2
        + 8 / 3 * half * radius**3) * density
    mass = area * density
    x, y, u, v, omega = (rows[name].reshape(-1, 2) for name in ("x", "y", "u", "v", "omega"))
    assert (read_table(folder / "contacts.csv")["impulse"] > 0).any() and np.ptp(omega) > 1
    for sum_of in (mass * u, mass * v, mass * (x * v - y * u) + moment * omega):
        total = sum_of.sum(1)
        np.testing.assert_allclose(total, total[0], atol=1e-11 * np.abs(sum_of).max())
    energy = (0.5 * mass * (u**2 + v**2) + 0.5 * moment * omega**2).sum(1)
    assert np.diff(energy).max() <= 1e-12 * energy[0] and energy[-1] < 0.95 * energy[0]


def heap(number):
    """Lines of a case: capsules of half-length 12 mm and radius 5 mm at random angles over a floor between two walls."""
    rng = np.random.default_rng(3)
    return [capsule((k % 5 - 2) * 0.045, 0.03 + 0.045 * (k // 5), 0.012, 0.005, angle)
        for k, angle in enumerate(rng.uniform(0, np.pi, number))]


BIN = ["contactWallSegment(-0.12, 0, 0.12, 0);", "contactWallSegment(-0.12, 0, -0.12, 1);", "contactWallSegment(0.12, 0, 0.12, 1);"]


def overlap(rows, radius):
    """The deepest overlap of capsules with each other and with the bin, over their radius, by distances of segments."""
    along = 0.012 * np.array([np.cos(rows["theta"]), np.sin(rows["theta"])])
    centre = np.array([rows["x"], rows["y"]])
    tips = np.array([centre - along, centre + along])  # end, component, body
    walls = min(tips[:, 1].min(), 0.12 - np.abs(tips[:, 0]).max()) - radius
    return min(walls, gap_of_capsules(tips) - 2 * radius) / radius


@pytest.mark.parametrize("number, end, friction", [(20, 0.16, 0), (10, 0.14, 0.5), pytest.param(50, 0.8, 0,
    marks=pytest.mark.slow), pytest.param(50, 0.8, 0.5, marks=pytest.mark.slow)])
def test_a_heap_of_capsules_has_no_overlap_and_gains_no_energy(number, end, friction, scene):
    """With friction the energy may rise by what -friction-tol leaves (docs/theory/friction.md)."""
    folder = scene(heap(number), BIN, "-friction", friction, "-friction-tol", 1e-6, "-dt", 0.002, "-tend", end, "-every", 0.02)
    rows = read_table(folder / "particles.csv")
    for t in np.unique(rows["t"]):
        assert overlap({name: rows[name][rows["t"] == t] for name in rows}, 0.005) > -1e-6
    motion = read_table(folder / "motion.csv")
    total = motion["kinetic_energy"] + motion["potential_energy"]
    assert np.diff(total).max() <= (1e-6 if friction else 1e-9) * motion["kinetic_energy"].max()
    assert (motion["contacts"] > number / 4).any()


SHAPES = {
    "capsule": [(0, [[-1, 0.3], [1.2, 0.5]], 0.4)], "square": [(1, [[0, 0], [2, 0], [2, 2], [0, 2]], 0.1)],
    "clockwise": [(1, [[0, 0], [0.4, 1], [2, 0]], 0.3)], "bent": [(0, [[0, 0], [1, 0], [1.7, 1], [2, 1.5]], 0.2)],
    "hook": [(1, [[0, 0], [1, 0], [1, 1], [2, 1], [2, 2], [0, 2]], 0.2)], "disks": [(0, [[0, 0]], 1.0), (0, [[1, 0.2]], 0.7)],
    "inside": [(0, [[0, 0]], 1.0), (0, [[0.1, 0.2]], 0.3)], "twice": [(0, [[0, 0]], 0.5), (0, [[0, 0]], 0.5)],
    "cross": [(0, [[-1, 0], [1, 0]], 0.2), (0, [[0, -1], [0, 1.5]], 0.3), (0, [[0.6, 0.4]], 0.5)],
    "plate on rod": [(1, [[0, 0], [2, 0], [2, 1], [0, 1]], 0.1), (0, [[-1, 0.5], [3, 0.7]], 0.3)],
}


def test_inertia_agrees_with_a_quadrature_over_lines(freefem_text):
    """Area, centre and moment of each shape; an independent quadrature over the chords at 20,000 heights. And the same at a place
    10,000 lengths away, to what the digits of its vertices leave."""
    away, lines = np.array([1e4, -7e3]), ['include "lib/bodies/shape_moments.idp"', "real[int] found(4); cout.precision(17);"]
    c, s = np.cos(0.3), np.sin(0.3)  # so that no edge is level
    shapes = {name: [(shut, np.array(points, float) @ np.array([[c, s], [-s, c]]), radius) for shut, points, radius in parts]
        for name, parts in SHAPES.items()}
    for parts in shapes.values():
        for place in (0, away):
            lines.append("formBegin();")
            for shut, points, radius in parts:
                px, py = (points + place).T
                lines.append(f"{{ real[int] px = {array(px)}, py = {array(py)}; formPart({shut}, px, py, {radius}); }}")
            lines.append("formMoments(found); cout << \"moments \" << found[0] << \" \" << found[1] << \" \" << found[2] << \" \" "
                "<< found[3] << endl;")
    text = freefem_text("\n".join(lines)).stdout
    found = [np.array(line.split()[1:], float) for line in text.splitlines() if line.startswith("moments")]
    assert len(found) == 2 * len(SHAPES)
    for (name, parts), one, far in zip(shapes.items(), found[::2], found[1::2]):
        exact = moments(parts)
        exact[3] -= (exact[1] ** 2 + exact[2] ** 2) / exact[0]  # about the centre
        np.testing.assert_allclose(one, exact, atol=3e-6 * exact[3], err_msg=name)
        np.testing.assert_allclose(far[[0, 3]], one[[0, 3]], rtol=1e-10, err_msg=name)
        np.testing.assert_allclose(far[1:3] / far[0] - away, one[1:3] / one[0], atol=1e-10, err_msg=name)


def test_capsules_have_the_inertia_of_closed_form(scene):
    """Energy of spinning bodies, in motion.csv."""
    h, r, omega = 0.2, 0.05, 3.0
    folder = scene([capsule(0, 1, h, r, 0.4, motion=(0, 0, omega))], [], "-dt", 0.01, "-tend", 0.01, gravity=(0, 0))
    moment = RHO * (4 * h * r * (h**2 + r**2) / 3 + np.pi * r**4 / 2 + np.pi * r**2 * h**2 + 8 / 3 * h * r**3)
    np.testing.assert_allclose(read_table(folder / "motion.csv")["kinetic_energy"], 0.5 * moment * omega**2, rtol=1e-10)


def test_a_disk_among_shapes_moves_as_a_disk(scene):
    """A disk that rolls and slips down an incline: the same as without shapes (tests/contact/test_friction_scenes.py)."""
    angles, mu = np.radians([10, 50]), 0.3
    walls, bodies = [], []
    for k, angle in enumerate(angles):
        walls.append(incline(k, angle, mu))
        centre = on_incline(np.array([[0.0, 0.02]]), k, angle, 0.0)[0]
        bodies.append(f"bodyRough(bodyDisk({float(centre[0])!r}, {float(centre[1])!r}, 0.02, 1000), {mu});")
    bodies.append(capsule(8, 8, 0.1, 0.1, 0))
    first, last = ends(scene(bodies, walls, "-friction", 1, "-friction-tol", 1e-12, "-contact-tol", 1e-12, "-dt", 0.001, "-tend",
        0.1, "-every", 1))
    speed = last["u"][:2] * np.cos(angles) - last["v"][:2] * np.sin(angles)
    np.testing.assert_allclose(speed / 0.1, [2 / 3 * G * np.sin(angles[0]), G * (np.sin(angles[1]) - mu * np.cos(angles[1]))],
        rtol=1e-6)
    np.testing.assert_allclose(last["v"][2], -G * 0.1, rtol=1e-9)


def test_a_body_that_slides_over_joints_and_past_corners_keeps_its_speed(scene):
    """A square on a floor of six pieces, without friction; a second one under which a corner of a step lies."""
    walls = [f"contactWallSegment({k / 4}, 0, {(k + 1) / 4}, 0);" for k in range(6)]
    folder = scene([polygon(square(0.2, 0.005) + [0.2, 0.1], 0.005, motion=(1.0, 0, 0))], walls, "-dt", 0.004, "-tend", 1, "-every",
        1)
    last = ends(folder)[1]
    np.testing.assert_allclose([last["u"][0], last["y"][0], last["theta"][0]], [1, 0.1, 0], atol=1e-9)


def test_a_run_goes_on_bit_for_bit(scene, tmp_path):
    words = ["-friction", 0.4, "-dt", 0.002, "-every", 0.02]
    whole = scene(heap(6), BIN, *words, "-tend", 0.12, "-checkpoint", 40, name="whole")
    part = scene(heap(6), BIN, *words, "-tend", 0.08, "-checkpoint", 40, name="part")
    scene(heap(6), BIN, *words, "-tend", 0.12, "-checkpoint", 40, "-restart", part, name="part")
    for name in ("particles.csv", "contacts.csv", "outlines.csv"):
        assert filecmp.cmp(whole / name, part / name, shallow=False), name


def test_shapes_from_files(scene, tmp_path):
    """A particle file that names shape files, whose radius does not count."""
    (tmp_path / "rod.csv").write_text("part,closed,x,y,radius\n0,0,1,1,0.05\n0,0,1.4,1,0.05\n")
    (tmp_path / "tee.csv").write_text("part,closed,x,y,radius\n0,1,0,0,0.01\n0,1,0.4,0,0.01\n0,1,0.4,0.1,0.01\n0,1,0,0.1,0.01\n"
        "1,0,0.2,0.1,0.03\n1,0,0.2,0.3,0.03\n")
    rows = [f"1,0,1,0,1000,0.3,{tmp_path}/rod.csv", f"5,1,1,1,1000,0,{tmp_path}/tee.csv", "7,2,1,0.2,500,0,",
        f"8,3,1,1,800,-0.2,{tmp_path}/rod.csv"]
    file = tmp_path / "particles_in.csv"
    file.write_text("id,x,y,radius,density,theta,shape\n" + "\n".join(rows) + "\n")
    folder = scene([f'bodyRead("{file}");'], [], "-dt", 0.01, "-tend", 0.02)
    first = ends(folder)[0]
    assert list(first["id"]) == [1, 5, 7, 8]
    np.testing.assert_allclose(first["radius"][[0, 2, 3]], [0.25, 0.2, 0.25], rtol=1e-12)
    np.testing.assert_allclose([first["x"], first["y"]], [[0, 1, 2, 3], [1, 1, 1, 1]])
    shapes = read_bodies(folder)
    np.testing.assert_allclose(shapes[8][0][2], [[-0.2, 0], [0.2, 0]], atol=1e-12)
    assert [part[0] for part in shapes[5]] == [1, 0] and len(shapes[7]) == 1


@pytest.mark.parametrize("bodies, status, words", [
    ([polygon(square(0.2, 0.01) + [0, 0.1], 0.0)], 3, "has the radius 0; it must be above 0"),
    ([polygon(np.array([[0, 0], [1, 1], [1, 0], [0, 1]]))], 3, "is a polygon whose edges cross"),
    ([clump([[0, 1], [1, 1]], [0.1])], 3, "as many of each"),
    ([capsule(0, 0.5, 0.2, 0.1, 0), capsule(0.1, 0.5, 0.2, 0.1, 1.5)], 5, "particle 0 and particle 1 lie across each other"),
    ([polygon(square(0.6, 0.01) + [0, 0.5]), capsule(0.1, 0.5, 0.02, 0.01, 1.5)], 5, "particle 0 and particle 1 lie across"),
    ([capsule(0, 0.05, 0.2, 0.1, 0)], 5, "particle 0 overlaps the wall from (-1, 0) to (1, 0) by 0.05"),
    (['bodyShaped("nowhere.csv", 0, 0, 0, 1);'], 3, "cannot read the file 'nowhere.csv'"),
    (["queueShape(bodyCapsule(0, 1, 0.1, 0.1, 0, 1), 1);"], 3, "particles that enter later (queueAt, queueShape) are for flows"),
    (["bodyEllipse(0, 1, 0.2, 0.1, 0, 1);"], 3, "ellipses do not stand beside bodies of other shapes"),
])
def test_what_makes_no_scene_is_refused(bodies, status, words, scene):
    done = scene(bodies, ["contactWallSegment(-1, 0, 1, 0);"], "-dt", 0.01, "-tend", 0.02, check=False)
    assert done.returncode == status and words in done.stderr, done.stderr


@pytest.mark.parametrize("other, status", [((0, 2.5), 5), ((0.3, 0.5), 0)])
def test_separate_parts_of_a_body_stand_on_one_side_of_a_box(other, status, scene):
    """A part beyond the lid was not seen: the body fell as if there were no walls."""
    corners = ((-1, 0), (1, 0), (1, 1.5), (-1, 1.5))
    walls = [f"contactWallSegment({a[0]}, {a[1]}, {b[0]}, {b[1]});" for a, b in zip(corners, corners[1:] + corners[:1])]
    done = scene([clump([[0, 0.5], other], [0.05, 0.05])], walls, "-dt", 0.01, "-tend", 0.02, check=False)
    assert done.returncode == status and ("particle 0 has parts on both sides of a wall" in done.stderr) == (status == 5)


@pytest.mark.parametrize("rows, words", [
    ("0,0.5,0,0,0.1\n0,0.5,1,0,0.1\n0,0.5,1,1,0.1\n", "row 2: part 0, closed 0.5"),
    ("0,0,0,0,0.1\n1,0,1,0,0.1\n0,0,1,1,0.1\n", "row 4: part 0 again"),
    ("0,1,0,0,0.1\n1,0,1,0,0.1\n", "of 1 vertex, is given as a closed polygon"),
])
def test_a_bad_shape_file_is_refused(rows, words, scene, tmp_path):
    (tmp_path / "shape.csv").write_text("part,closed,x,y,radius\n" + rows)
    done = scene([f'bodyShaped("{tmp_path}/shape.csv", 0, 2, 0, 1);'], [], "-dt", 0.01, "-tend", 0.02, check=False)
    assert done.returncode == 3 and words in done.stderr and done.stderr.count("\n") == 1, done.stderr


@pytest.mark.parametrize("option", [("-cohesion", 0.5)])
def test_options_that_shapes_do_not_take_are_refused(option, scene):
    done = scene([capsule(0, 1, 0.1, 0.1, 0)], [], "-dt", 0.01, "-tend", 0.02, *option, check=False)
    assert done.returncode == 3 and "bodies of any shape take neither" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_files_name_shapes_only_in_cases_that_know_them(freefem_text, tmp_path):
    file = tmp_path / "bodies.csv"
    file.write_text("id,x,y,radius,density,shape\n0,0.5,0.5,0.1,3,rod.csv\n")
    done = freefem_text(case(""), "-particles", file, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "has particles with a shape" in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_overlaps_at_the_start_can_be_pushed_apart(scene):
    bodies = [capsule(0, 0.1, 0.2, 0.1, 0), capsule(0.1, 0.27, 0.2, 0.1, 0.1)]
    folder = scene(bodies, ["contactWallSegment(-1, 0, 1, 0);"], "-contact-initial", "push", "-dt", 0.01, "-tend", 0.01)
    first = ends(folder)[0]
    along = 0.2 * np.array([np.cos(first["theta"]), np.sin(first["theta"])])
    centre = np.array([first["x"], first["y"]])
    tips = np.array([centre - along, centre + along])
    assert gap_of_capsules(tips) > 0.2 - 1e-7 and tips[:, 1].min() > 0.1 - 1e-7
