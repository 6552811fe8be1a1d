"""Clumps of overlapping disks, stars and tilted faces against a second computation that shares no code with the suite: contacts
are the local minima of the distance, found by shifting points along both outlines, and the velocities are those of Lawson and
Hanson's least distance programme (scipy's nnls). Many scenes stand side by side in one run of one step.
"""
import itertools

import numpy as np
import pytest
from scipy.optimize import nnls

from tests.contact.shapes import clump, moments, polygon, scene_text
from tools.base.tables import read_table

APART, DT = 3.0, 1e-5  # m between scenes; s, so short that the angles of a step do not matter
CLOSE = 1e-3  # velocities agree to this part of the greatest one: ten times what angles of 1e-4 in a step may change
SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.09
STAR = np.where(np.arange(8) % 2, 0.06, 0.15)[:, None] * np.column_stack([np.cos(np.pi / 4 * np.arange(8)),
    np.sin(np.pi / 4 * np.arange(8))])
THREE = np.array([[0, 0], [0.1, 0.01], [0.04, 0.09]])


class Body:
    """Parts (closed, vertices (n, 2), radius), the line of a case, velocities (u, v, omega), mass, centre and inertia."""

    def __init__(self, kind, place, angle, motion, mu=None):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        self.motion, self.kind, self.mu = np.array(motion, float), kind, mu
        corners = {"square": SQUARE, "star": STAR, "clump": THREE}[kind] @ turn + place
        if kind == "clump":
            radii = [0.08, 0.06, 0.07]
            self.parts = [(0, corners[k:k + 1], radii[k]) for k in range(3)]
        else:
            self.parts = [(1, corners, 0.01)]
        area, ax, ay, polar = moments([(shut, points + [0, 1e-3], radius) for shut, points, radius in self.parts], 4000)
        self.centre = np.array([ax, ay]) / area - [0, 1e-3]
        self.mass = 1000 * area
        self.inertia = 1000 * (polar - area * ((self.centre + [0, 1e-3]) ** 2).sum())

    def line(self):
        """The line of a case."""
        if self.kind == "clump":
            return clump(np.array([points[0] for _, points, _ in self.parts]), [radius for *_, radius in self.parts], self.mu,
                self.motion)
        return polygon(self.parts[0][1], self.parts[0][2], self.mu, self.motion)

    def moved(self, way):
        """Shifted by `way`."""
        self.parts = [(shut, points + way, radius) for shut, points, radius in self.parts]
        self.centre = self.centre + way
        return self

    def after(self, z, dt):
        """Parts after a step with the velocities z."""
        c, s = np.cos(z[2] * dt), np.sin(z[2] * dt)
        turn = np.array([[c, s], [-s, c]])
        return [(shut, (points - self.centre) @ turn + self.centre + dt * z[:2], radius) for shut, points, radius in self.parts]


def outline(part):
    """Edges (begin, end) of a part; a disk has one of no length."""
    shut, points, _ = part
    return [(points[k], points[(k + 1) % len(points)]) for k in range(len(points))] if shut else [(points[0], points[0])]


def nearest(point, edge):
    """The nearest point of an edge."""
    way = edge[1] - edge[0]
    return edge[0] + np.clip((point - edge[0]) @ way / max(way @ way, 1e-300), 0, 1) * way


def cross(edge, point):
    """Twice the area of the triangle of an edge and a point."""
    way, far = edge[1] - edge[0], point - edge[0]
    return way[0] * far[1] - way[1] * far[0]


def neighbours(point, part, far):
    """Points of the outline within about `far` of a point on it."""
    found = [point]
    for begin, end in outline(part):
        if np.hypot(*(nearest(point, (begin, end)) - point)) < 1e-12:
            for tip in (begin, end):
                long = np.hypot(*(tip - point))
                if long > 1e-9:
                    found.append(point + (tip - point) * min(far / long, 1))
    return found


def inside(point, part):
    """Whether a point lies in a closed polygon (crossings of a ray)."""
    if not part[0]:
        return False
    cut = [(a[1] > point[1]) != (b[1] > point[1]) and point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        for a, b in outline(part)]
    return sum(cut) % 2 == 1


def touching(one, two, reach):
    """[(gap, direction from two to one, middle of the gap), ...] of two parts: vertices and their nearest points, where these are
    local minima of the distance along the outline; two vertices, where they are local minima along both outlines."""
    pairs = [(p, nearest(p, edge), edge) for p in one[1] for edge in outline(two)]
    pairs += [(nearest(p, edge), p, edge) for p in two[1] for edge in outline(one)]
    found = []
    for k, (a, b, edge) in enumerate(pairs):
        far, first = np.hypot(*(a - b)), k < len(one[1]) * len(outline(two))
        if far - one[2] - two[2] > reach or far < 1e-12 or inside(0.5 * (a + b), one) or inside(0.5 * (a + b), two):
            continue
        foot = b if first else a
        tips = min(np.hypot(*(foot - tip)) for tip in edge) < 1e-12
        around = [neighbours(a, one, 1e-4) if tips or not first else [a], neighbours(b, two, 1e-4) if tips or first else [b]]
        if min(np.hypot(*(x - y)) for x, y in itertools.product(*around)) > far * (1 - 1e-9):
            normal = (a - b) / far
            found.append((far - one[2] - two[2], normal, 0.5 * (a - one[2] * normal + b + two[2] * normal)))
    return found


def least_gap(one, two):
    """The least gap of two lists of parts; negative where outlines cross."""
    gap = np.inf
    for a, b in itertools.product(one, two):
        gap = min([gap] + [np.hypot(*(p - nearest(p, edge))) - a[2] - b[2] for p in a[1] for edge in outline(b)]
            + [np.hypot(*(p - nearest(p, edge))) - a[2] - b[2] for p in b[1] for edge in outline(a)])
        if any(inside(p, b) for p in a[1]) or any(inside(p, a) for p in b[1]) or any(
                cross(e, f[0]) * cross(e, f[1]) < 0 and cross(f, e[0]) * cross(f, e[1]) < 0
                for e, f in itertools.product(outline(a), outline(b))):
            gap = min(gap, -1.0)
    return gap


def expected(bodies, walls, dt, mu):
    """Velocities (n, 3) of the projection; walls: parts that do not move; mu: rows G + mu T and G - mu T."""
    root = np.array([[b.mass, b.mass, b.inertia] for b in bodies]).ravel() ** -0.5
    free = np.array([b.motion for b in bodies]).ravel()
    rows, gaps = [], []
    reach = 4 * dt * max(np.abs(b.motion[:2]).max() + 0.3 * abs(b.motion[2]) for b in bodies) + 1e-9
    for i, one in enumerate(bodies):
        others = [(j, part) for j in range(i + 1, len(bodies)) for part in bodies[j].parts] + [(-1, wall) for wall in walls]
        for part, (j, other) in itertools.product(one.parts, others):
            for gap, e, at in touching(part, other, reach):
                for way in (e,) if mu == 0 else (e + mu * np.array([-e[1], e[0]]), e - mu * np.array([-e[1], e[0]])):
                    row = np.zeros(3 * len(bodies))
                    for k, sign in ((i, 1), (j, -1)):
                        if k >= 0:
                            arm = at - bodies[k].centre
                            row[3 * k:3 * k + 3] = sign * np.array([*way, arm[0] * way[1] - arm[1] * way[0]])
                    rows.append(row), gaps.append(gap / dt)
    if not rows:
        return free.reshape(-1, 3)
    rows, gaps = np.array(rows), np.array(gaps)
    b, h = rows * root, -(gaps + rows @ free)  # least distance programme: min |q| over B q >= h
    scale = np.linalg.norm(b, axis=1)
    b, h = b / scale[:, None], h / scale
    matrix, right = np.vstack([b.T, h]), np.append(np.zeros(b.shape[1]), 1.0)
    rest = matrix @ nnls(matrix, right, maxiter=10000)[0] - right
    return (free - root * rest[:-1] / rest[-1]).reshape(-1, 3)


def against(one, other, gap, direction):
    """`one` moved along the direction until its gap to the parts `other` is `gap`, from far away."""
    one.moved(direction)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        trial = [(shut, points - middle * direction, radius) for shut, points, radius in one.parts]
        low, high = (middle, high) if least_gap(trial, other) > gap else (low, middle)
    return one.moved(-low * direction)


def run(freefem_text, folder, scenes, walls, *words):
    """Velocities (n, 3) of each scene after one step."""
    lines = [body.line() for scene in scenes for body in scene]
    rows_of = np.cumsum([0] + [len(scene) for scene in scenes])
    freefem_text(scene_text(lines, walls, (0.0, 0.0)), "-dt", DT, "-tend", DT, "-every", DT, "-contact-tol", 1e-12, *words, "-out",
        folder)
    rows = read_table(folder / "particles.csv")
    begin, end = (np.column_stack([rows[key][rows["t"] == t] for key in ("x", "y", "u", "v", "omega")])
        for t in (rows["t"].min(), rows["t"].max()))
    centres = np.array([body.centre for scene in scenes for body in scene])
    assert np.abs(begin[:, :2] - centres).max() < 1e-6  # centres of mass
    return [end[a:b, 2:] for a, b in itertools.pairwise(rows_of)]


def judge(scenes, found, walls, mu):
    """No overlap, no energy gained, the velocities of the second computation."""
    for scene, z, wall in zip(scenes, found, walls):
        speed = max(np.abs(body.motion).max() for body in scene)
        after = [body.after(own, DT) for body, own in zip(scene, z)]
        for one, two in itertools.combinations([*after, *([wall] if wall else [])], 2):
            assert least_gap(one, two) > -1e-8
        energy = [sum(b.mass * (v[0]**2 + v[1]**2) + b.inertia * v[2]**2 for b, v in zip(scene, way))
            for way in ([b.motion for b in scene], z)]
        assert energy[1] <= energy[0] * (1 + 1e-9)
        error = np.abs(z - expected(scene, wall, DT, mu)).max()
        assert error < CLOSE * speed, (scene[0].kind, error / speed)


@pytest.mark.parametrize("mu", [0, 0.3])
def test_clumps_stars_and_squares_in_touch(mu, freefem_text, tmp_path):
    """Three bodies, of which two are thrown at the first from random sides, at gaps of up to a step's move; with friction under the
    relaxed law, whose velocities are unique."""
    rng, scenes = np.random.default_rng(3), []
    for k in range(12):
        kinds = [["clump"] * 3, ["star"] * 3, ["star", "clump", "square"]][k % 3]
        scene = []
        for kind in kinds:
            side = np.array([np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)])
            motion = [*rng.uniform(-0.5, 0.5, 2), rng.uniform(-5, 5)]
            if scene:
                motion[:2] -= 2 * side
            body = Body(kind, np.array([APART * k, 0.0]), rng.uniform(0, 2 * np.pi), motion, mu or None)
            others = [part for other in scene for part in other.parts]
            scene.append(against(body, others, rng.uniform(0, 1e-5), side) if scene else body)
        scenes.append(scene)
    words = ["-friction", mu, "-friction-law", "relaxed"] if mu else []
    found = run(freefem_text, tmp_path / "run", scenes, [], *words)
    assert sum(np.abs(z - [b.motion for b in scene]).max() > 0.1 for scene, z in zip(scenes, found)) > 8  # they do collide
    judge(scenes, found, [[]] * len(scenes), mu)


@pytest.mark.parametrize("mu", [0, 0.3])
def test_tilted_faces(mu, freefem_text, tmp_path):
    """A square thrown at an inclined wall, or at another square, its face tilted by 0 to 0.01: the second corner comes to bear, or
    does not, with no jump in between."""
    scenes, walls, lines = [], [], []
    tilts = [0, *10.0 ** np.arange(-6, -1.9, 0.5)]
    for k, (tilt, kind) in enumerate(itertools.product(tilts, ("wall", "face"))):
        angle, place = 0.3 + 0.5 * (k % 5), np.array([APART * k, 0.0])
        c, s = np.cos(angle), np.sin(angle)
        along, normal = np.array([c, s]), np.array([-s, c])
        body = Body("square", place + 0.013 * along, angle + tilt, [*(-normal + 0.2 * along), 0.7], mu or None)
        if kind == "wall":
            wall = (1, np.array([place - 0.6 * along, place + 0.6 * along]), 0.0)
            ends = ", ".join(repr(float(x)) for x in wall[1].ravel())
            lines.append(f"contactWallRough(contactWallSegment({ends}), {float(mu)!r});")
            scenes.append([against(body, [wall], 3e-6, normal)])
            walls.append([wall])
        else:
            other = Body("square", place, angle, [*(0.3 * normal), -0.4], mu or None)
            scenes.append([other, against(body, other.parts, 3e-6, normal)])
            walls.append([])
    words = ["-friction", mu or 1e-300, "-friction-law", "relaxed"] if mu else []
    found = run(freefem_text, tmp_path / "run", scenes, lines, *words)
    judge(scenes, found, walls, mu)
    for kind in range(2):  # a face tilted by 1e-6 comes flat in the step: each turns by that much more at most
        first, second = (found[kind + 2 * k] for k in (0, 1))
        assert np.abs(first[:, 2] - second[:, 2]).max() < 2 * tilts[1] / DT


def test_the_order_of_squares_does_not_matter(freefem_text, tmp_path):
    """Three squares that press each other, given in all orders: without friction velocities are unique, with friction all orders
    find the same solution here."""
    scenes, orders = [], list(itertools.permutations(range(3)))
    for k, (mu, order) in enumerate(itertools.product((None, 0.5), orders)):
        place = np.array([APART * k, 0.0])
        made = [Body("square", place, 0.4, [0.3, 0.1, 2], mu)]
        for side, motion in ((0.4, [-1.5, -0.6, -3]), (0.4 + np.pi / 2, [0.4, -1.2, 1])):
            way = np.array([np.cos(side), np.sin(side)])
            others = [part for body in made for part in body.parts]
            made.append(against(Body("square", place + 0.02 * way[::-1], 0.4, motion, mu), others, 1e-9, way))
        scenes.append([made[j] for j in order])
    found = run(freefem_text, tmp_path / "run", scenes, [], "-friction", 0, "-friction-tol", 1e-11)
    back = np.array([z[np.argsort(order)] for z, order in zip(found, orders * 2)])
    for of in (back[:6], back[6:]):
        assert np.abs(of - of[0]).max() < 1e-6
    assert np.abs(back[0] - back[6]).max() > 0.01
