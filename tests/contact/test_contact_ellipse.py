"""Contacts of ellipses: gaps and levers against points on the outlines, the projection against SciPy, rest on a floor."""
import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial import cKDTree

from tests.conftest import make_mesh
from tests.scenes import ELLIPSES as SCENE, MEASURE_ELLIPSES as MEASURE, PROJECT_ELLIPSES as PROJECT, case
from tests.tables import outline, rows
from tools.base.run_folder import RunFolder

# x, y, angle, semi-major axis, minor over major
BODIES = [(0.0, 0.0, 0.4, 1.0, 0.4), (1.5, 0.9, -0.7, 0.8, 0.5), (-1.1, 1.3, 1.9, 0.9, 0.3), (0.6, -1.3, 0.0, 0.5, 1.0),
    (-1.6, -0.7, 2.6, 0.7, 0.15)]
WALLS = [(-3.0, -2.0, 3.0, -2.0), (2.3, 0.2, 3.0, 2.0), (-0.1, 2.3, 0.2, 3.0)]
MASS, MOMENT = [1.0, 2.0, 1.5, -1.0, 0.7], [0.3, 0.5, 0.35, 1.0, 0.1]
SPEED = [(0.5, 0.2, 1.0), (-1.0, -0.8, -2.0), (1.0, -1.5, 0.5), (0.0, 0.3, 0.0), (1.0, 0.5, -3.0)]


def scene(bodies=BODIES, walls=WALLS, mass=MASS, moment=MOMENT, speed=SPEED, period=0.0, more=""):
    """A FreeFEM script with these bodies."""
    text = SCENE
    for name, values in zip(("X", "Y", "TURN", "RADIUS", "ASPECT"), zip(*bodies)):
        text = text.replace(f" = {name},", f" = {list(map(float, values))},")
    for name, values in (("MASS", mass), ("MOMENT", moment), ("U", [s[0] for s in speed]), ("V", [s[1] for s in speed])):
        text = text.replace(f" = {name},", f" = {list(map(float, values))},")
    text = text.replace(" = W;", f" = {[float(s[2]) for s in speed]};").replace("PERIOD", str(period))
    return text.replace("WALLS", "\n".join(f"contactWallSegment({a}, {b}, {c}, {d});" for a, b, c, d in walls)) + more


def apart(one, two):
    """(distance, direction) of two outlines (functions of an angle or a place along a wall) that do not meet."""
    def off(t):
        return np.hypot(*(one(t[0]) - two(t[1])))
    first, second = np.linspace(0, 2 * np.pi, 400), np.linspace(0, two.span, 400)
    all_off = np.hypot(*(one(first)[:, :, None] - two(second)[:, None, :]))
    i, j = np.unravel_index(all_off.argmin(), all_off.shape)
    best = minimize(off, [first[i], second[j]], bounds=[(None, None), (0, 1) if two.span == 1 else (None, None)], method="L-BFGS-B",
                    options={"ftol": 1e-16, "gtol": 1e-12})
    away = one(best.x[0]) - two(best.x[1])
    return np.hypot(*away), away / np.hypot(*away)


def edge(body):
    def points(angles):
        return outline(*body, angles)
    points.span = 2 * np.pi
    return points


def side(wall):
    def points(along):
        return np.array([wall[0] + along * (wall[2] - wall[0]), wall[1] + along * (wall[3] - wall[1])])
    points.span = 1
    return points


def turned(body, angle):
    return (*body[:2], body[2] + angle, *body[3:])


def test_gaps_and_levers_are_those_of_the_outlines(freefem_text):
    found = rows(freefem_text(scene(more=MEASURE)).stdout, "gap")
    assert len(found) == 10 + 15
    for i, j, gap, ex, ey, arm_i, arm_j in found:
        one = BODIES[int(i)]
        two = edge(BODIES[int(j)]) if j >= 0 else side(WALLS[int(-1 - j)])
        distance, direction = apart(edge(one), two)
        assert gap == pytest.approx(distance, abs=1e-7) and (ex, ey) == pytest.approx(tuple(direction), abs=1e-3)
        step = 1e-3  # levers by central differences of the distance
        change = [apart(edge(turned(one, s * step)), two)[0] for s in (1, -1)]
        assert arm_i == pytest.approx((change[0] - change[1]) / (2 * step), abs=1e-4)
        if j >= 0:
            change = [apart(edge(one), edge(turned(BODIES[int(j)], s * step)))[0] for s in (1, -1)]
            assert arm_j == pytest.approx((change[0] - change[1]) / (2 * step), abs=1e-4)
        else:
            assert arm_j == 0


def test_slender_ellipses_at_all_angles_have_their_gap(freefem_text):
    """Two of aspect 0.05 side by side, crossed and end to end: the least of all distances of points on the outlines."""
    kinds = np.random.default_rng(3)
    for _ in range(3):
        bodies = []
        for k in range(12):
            bodies.append((2.3 * (k % 4), 2.3 * (k // 4), float(kinds.uniform(0, 2 * np.pi)), 1.0,
                float(kinds.choice([0.05, 0.2, 1.0]))))
        number = len(bodies)
        text = scene(bodies, [], [1.0] * number, [1.0] * number, [(0, 0, 0)] * number, more=MEASURE)
        angles = np.linspace(0, 2 * np.pi, 3001)
        outlines = [outline(*body, angles) for body in bodies]
        trees = [cKDTree(points.T) for points in outlines]
        for i, j, gap, *_ in rows(freefem_text(text).stdout, "gap"):
            nearest = trees[int(i)].query(outlines[int(j)].T)[0].min()
            assert gap <= nearest + 1e-9 and gap == pytest.approx(nearest, abs=2e-3)


@pytest.mark.parametrize("aspect", [0.3, 0.6])
def test_ellipses_anywhere_round_a_wall_have_their_gap(freefem_text, aspect):
    """Also those whose line cuts them beyond its end: the largest s(n) over all directions, of the segment's own support
    function."""
    places, number = np.random.default_rng(5), 300
    bodies = [(20.0 * k + places.uniform(-0.5, 1.5), places.uniform(-0.4, 0.4), places.uniform(-3, 3), 0.4, aspect)
        for k in range(number)]
    walls = [(20.0 * k, 0.0, 20.0 * k + 1, 0.0) for k in range(number)]
    found = rows(freefem_text(scene(bodies, walls, [1.0] * number, [1.0] * number, [(0, 0, 0)] * number,
        more=MEASURE.replace("10.", "1."))).stdout, "gap")
    to, apart_ones = np.linspace(0, 2 * np.pi, 20001), 0
    for i, _, gap, ex, ey, *_ in found:
        x, y, turn, a, _ = bodies[int(i)]
        s = np.cos(to) * (x - 20 * i) + np.sin(to) * y - a * np.hypot(np.cos(to - turn),
            aspect * np.sin(to - turn)) - np.maximum(0, np.cos(to))
        best = int(s.argmax())
        if s[best] > 1e-3:
            apart_ones += 1
            assert gap == pytest.approx(s[best], abs=1e-6) and (ex, ey) == pytest.approx((np.cos(to[best]), np.sin(to[best])),
                abs=5e-3)
    assert apart_ones > 80


def test_over_a_seam_the_nearest_image_counts(freefem_text):
    bodies = [(0.3, 0.0, 0.4, 0.5, 0.4), (7.6, 0.2, 1.0, 0.6, 0.5)]
    found = rows(freefem_text(scene(bodies, [], [1, 1], [1, 1], [(0, 0, 0)] * 2, 8.0, MEASURE.replace("10.", "0.5"))).stdout, "gap")
    distance, direction = apart(edge((8.3, *bodies[0][1:])), edge(bodies[1]))
    assert len(found) == 1 and found[0, 2] == pytest.approx(distance, abs=1e-8) and found[0, 3] == pytest.approx(direction[0],
        abs=1e-4)


def weights(free, aside):
    """The masses as a matrix: MASS along the long axes, `aside` times as much along the short ones, MOMENT."""
    whole = np.zeros((3 * len(free), 3 * len(free)))
    for at, k in enumerate(free):
        turn = BODIES[k][2]
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        whole[3 * at:3 * at + 2, 3 * at:3 * at + 2] = axes.T @ np.diag([MASS[k], MASS[k] * aside[k]]) @ axes
        whole[3 * at + 2, 3 * at + 2] = MOMENT[k]
    return whole


def nearest_motion(gaps, about, dt, aside):
    """SciPy's least weighted change of SPEED for which no gap, linearised about the velocities `about`, turns negative."""
    free = [k for k, m in enumerate(MASS) if m > 0]
    weight = weights(free, aside)
    given = np.array(SPEED)[free].ravel()

    def whole(x):
        full = np.array(SPEED, float)
        full[free] = np.reshape(x, (-1, 3))
        return full

    def room(x):
        change = dt * (whole(x) - about)
        return [gap + change[int(i)] @ [ex, ey, arm_i] + (change[int(j)] @ [-ex, -ey, arm_j] if j >= 0 else 0) for i, j, gap, ex,
            ey, arm_i, arm_j in gaps]
    best = minimize(lambda x: 0.5 * (x - given) @ weight @ (x - given), given, jac=lambda x: weight @ (x - given),
        constraints={"type": "ineq", "fun": room},
                    method="SLSQP", options={"ftol": 1e-15, "maxiter": 1000})
    assert best.success
    return whole(best.x)


@pytest.mark.parametrize("aside", [[1.0] * 5, [4.0, 2.5, 3.0, 1.0, 6.0]])
@pytest.mark.parametrize("dt, pressing", [(0.25, 1), (0.35, 2), (0.5, 2)])
def test_the_projection_is_the_nearest_motion_without_overlap(freefem_text, dt, pressing, aside):
    """Body 3 is held; `aside`: masses across over those along. The gaps are linearised at the start, and again at the end while
    that leaves an overlap."""
    def measured(speed):
        after = [(b[0] + dt * s[0], b[1] + dt * s[1], b[2] + dt * s[2], *b[3:]) for b, s in zip(BODIES, speed)]
        return rows(freefem_text(scene(after, more=MEASURE)).stdout, "gap")
    uneven = f"contactEllipseAside.resize(5); contactEllipseAside = {aside};"
    out = freefem_text(scene(more=MEASURE + uneven + PROJECT.replace("DT", str(dt)))).stdout
    speed, press, used = rows(out, "speed"), rows(out, "press"), int(rows(out, "passes")[0, 0])
    assert rows(out, "worst")[0, 0] >= -1.06e-9 and (press[:, 2] > 1e-6).sum() >= pressing and (speed[3] == SPEED[3]).all()
    assert measured(speed)[:, 2].min() >= -1.06e-9
    assert used <= 6
    expected, gaps = np.zeros((5, 3)), rows(out, "gap")
    for k in range(min(used, 4)): # what comes after pushes apart what is left
        expected, gaps = nearest_motion(gaps, expected, dt, aside), None
        if k + 1 < used:
            gaps = measured(expected)
    assert speed == pytest.approx(expected, abs=2e-5 if used <= 4 else 0.02)


def test_disks_are_projected_as_disks(freefem_text, tmp_path):
    """All round: the motions of lib/contact/project.idp, and nobody turns."""
    bodies = [(*b[:2], b[2], 0.5, 1.0) for b in BODIES]
    both = scene(bodies, more=PROJECT.replace("DT", "0.9") + """
real[int] u2 = U, v2 = V;
contactNearLoad = 0.; contactListRange = -1;
contactProject(px, py, r, id, mass, u2, v2, 0.9);
for (int k = 0; k < px.n; ++k) cout << "disk " << u2[k] << " " << v2[k] << endl;
""".replace("U,", f"{[s[0] for s in SPEED]},").replace("= V;", f"= {[s[1] for s in SPEED]};"))
    out = freefem_text(both).stdout
    speed, disk = rows(out, "speed"), rows(out, "disk")
    assert (speed[:, 2] == [s[2] for s in SPEED]).all()
    assert speed[:, :2] == pytest.approx(disk, abs=1e-7) and abs(disk - np.array(SPEED)[:, :2]).max() > 0.1


FLOOR = ("-mesh", "meshes/settling_disk.mesh", "-dt", 0.0025)


def on_floor(particles):
    """The text of a case in a closed box of 2 x 6 cm, its options FLOOR."""
    return case(particles, walls="labelWall").replace("mu = 0.05", "mu = 0.1").replace("gravityY = -1", "gravityY = -981")


def test_ellipses_in_a_fluid_come_to_lie_flat_and_never_overlap(freefem_text, tmp_path):
    """One stands on its end on the floor at the start, one falls on it, a disk on both: outlines are followed from row to row."""
    particles = "bodyEllipse(1., 0.45, 0.4, 0.2, 1.45, 1.5); bodyEllipse(0.6, 1.1, 0.4, 0.2, 0.3, 1.3); bodyDisk(1.5, 0.9, 0.2, 1.3);"
    low = make_mesh(tmp_path / "low.mesh", "box", "--width", 2, "--height", 2, "--size", 0.0625)
    freefem_text(on_floor("{ " + particles + " }"), "-mesh", low, "-dt", 0.005, "-tend", 0.8, "-every", 0.02, "-out",
        tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    table = run.particles
    minor = 0.2  # of all three
    angles = np.linspace(0, 2 * np.pi, 721)
    nearest = np.inf
    for t in np.unique(table["t"]):
        now = np.flatnonzero(table["t"] == t)
        outlines = [outline(table["x"][k], table["y"][k], table["theta"][k], table["radius"][k], minor / table["radius"][k],
            angles) for k in now]
        for k, points in enumerate(outlines):
            assert points[0].min() > -1e-5 and points[0].max() < 2 + 1e-5 and points[1].min() > -1e-5
            for other in now[k + 1:]:  # no point of one lies in another
                c, s = np.cos(table["theta"][other]), np.sin(table["theta"][other])
                x, y = points[0] - table["x"][other], points[1] - table["y"][other]
                level = np.hypot((c * x + s * y) / table["radius"][other], (c * y - s * x) / minor)
                assert level.min() > 1 - 1e-4
                nearest = min(nearest, level.min())
    assert nearest < 1.01  # they did touch
    last = table["t"] == table["t"].max()
    assert table["y"][last & (table["id"] == 0)] < 0.3 and abs(np.sin(table["theta"][last & (table["id"] == 0)])) < 0.3
    assert run.table("contacts")["gap"].min() > -1e-7 and run.table("fluid")["worst_gap"].min() > -1e-8


def test_ellipses_that_overlap_are_refused_with_a_list_or_pushed_apart(freefem_text, tmp_path):
    standing = on_floor("{ bodyEllipse(1., 0.3, 0.4, 0.2, pi/2, 1.5); bodyEllipse(1., 0.8, 0.4, 0.2, 0, 1.5); bodyDisk(1.5, 3, "
        "0.2, 1.3); }")
    done = freefem_text(standing, *FLOOR, "-tend", 0.005, "-out", tmp_path / "no", check=False)
    assert (done.returncode == 5 and "2 overlaps at the start" in done.stderr
        and "particle 0 overlaps the wall from (" in done.stderr and "particles 0 and 1 overlap by 0.1" in done.stderr)
    freefem_text(standing, *FLOOR, "-tend", 0.005, "-out", tmp_path / "yes", "-contact-initial", "push")
    table = RunFolder(tmp_path / "yes").particles
    first = table["t"] == table["t"].min()
    assert table["y"][first][0] >= 0.399 and table["y"][first][1] - table["y"][first][0] >= 0.599
    flat = on_floor("bodyEllipse(1., 0.21, 0.4, 0.2, 0, 1.5);")  # the disk round it would not fit
    freefem_text(flat, *FLOOR, "-tend", 0.005, "-out", tmp_path / "flat")


@pytest.mark.parametrize("seed, which, wall", [(1, 7, 2), (7, 3, 3), (7, 3, 5)])
def test_the_gap_to_a_wall_whose_end_has_pierced_an_ellipse(freefem_text, seed, which, wall):
    """The end that was looked at was the other one: -0.44 in place of -0.096."""
    rng = np.random.default_rng(seed)
    bodies = [(*rng.uniform(-2, 2, 2), rng.uniform(-10, 10), np.exp(rng.uniform(-3, 0.3)), rng.choice([0.02, 0.05, 0.2, 0.6, 0.95,
        1.0])) for _ in range(12)]
    walls = []
    for _ in range(6):
        start, length, turn = rng.uniform(-2, 2, 2), np.exp(rng.uniform(-4, 1)), rng.uniform(0, 2 * np.pi)
        walls.append((*start, start[0] + length * np.cos(turn), start[1] + length * np.sin(turn)))
    (x, y, theta, a, aspect), (x1, y1, x2, y2) = bodies[which], walls[wall]
    n = np.linspace(0, 2 * np.pi, 200001)
    ends = np.minimum(np.cos(n) * (x - x1) + np.sin(n) * (y - y1), np.cos(n) * (x - x2) + np.sin(n) * (y - y2))
    true = (ends - a * np.hypot(np.cos(n - theta), aspect * np.sin(n - theta))).max()
    text = freefem_text(scene([bodies[which]], [walls[wall]], [1.0], [1.0], [(0.0, 0.0, 0.0)], more=MEASURE)).stdout
    assert float(next(line for line in text.splitlines() if line.startswith("gap ")).split()[3]) == pytest.approx(true, abs=1e-6)


def lattice(across, aspect, rough, far=0.0, seed=0):
    """Rows of equal ellipses that touch all their neighbours but for a share `rough`, thrown down into a box they fill: what
    scene() takes."""
    rng = np.random.default_rng(seed)
    x = np.array([(2 * k + j % 2, 3**0.5 * j) for j in range(across)
        for k in range(across)]) + rough * rng.standard_normal((across**2, 2))
    a = 0.5 * min(np.hypot(*(x[k + 1:] - x[k]).T).min() for k in range(len(x) - 1)) * (1 - 1e-12)
    low, high = far + (x.min(0) - a) * [1, aspect], far + (x.max(0) + a) * [1, aspect]
    walls = [(low[0] - 9, low[1], high[0] + 9, low[1]), (low[0], low[1] - 9, low[0], high[1] + 99), (high[0], low[1] - 9, high[0],
        high[1] + 99)]
    speed = 0.05 * rng.standard_normal((len(x), 3)) - [0, 0.25 * aspect, 0]
    return [(*(far + p * [1, aspect]), 0.0, a, aspect) for p in x], walls, [1.0] * len(x), [0.25 * (1 + aspect**2)] * len(x), speed


@pytest.mark.parametrize("across, rough", [(5, 0.0), (5, 1e-10), (8, 1e-6), (8, 1e-3), (12, 1e-4)])
def test_a_lattice_of_ellipses_that_are_nearly_disks_is_solved(freefem_text, across, rough):
    """Redundant contacts: active sets turn in circles, and gradients needed more than 200,000 steps or ended with status 4."""
    bodies = lattice(across, 0.999999, rough)
    speed, disk = (rows(freefem_text(scene([(*b[:4], aspect) for b in bodies[0]], *bodies[1:], more=PROJECT.replace("DT",
        "1"))).stdout, "speed") for aspect in (0.999999, 1.0))
    assert speed == pytest.approx(disk, abs=1e-4)


def test_ellipses_far_from_the_origin_are_held_apart_as_far_as_rounding_lets_them(freefem_text):
    out = freefem_text(scene(*lattice(4, 0.1, 1e-3, 1e7), more=PROJECT.replace("DT", "0.3"))).stdout
    assert rows(out, "worst")[0, 0] > -2e-8


def test_an_ellipse_squeezed_by_two_held_ones_ends_the_run_with_the_reason(freefem_text):
    bodies = [(-1.0, 0.0, 0.0, 0.5, 0.4), (0.0, 0.0, 0.0, 0.499, 0.4), (1.0, 0.0, 0.0, 0.5, 0.4)]
    text = scene(bodies, [], [-1.0, 1.0, -1.0], [1.0] * 3, [(1, 0, 0), (0, 0, 0), (-1, 0, 0)], more=PROJECT.replace("DT", "0.1"))
    done = freefem_text(text, check=False)
    assert done.returncode == 4 and "leave a body no room" in done.stderr and "no motion" in done.stderr


def test_a_light_thin_ellipse_that_a_heavy_one_strikes_into_a_corner_finds_its_place(freefem_text):
    """It turns by more than a linearised gap is good for: corrections that let it turn freely went to and fro, with overlaps of
    0.07 to 0.7 after each of 12."""
    bodies = [(0.0, 0.0, 4.79, 1.0, 0.9), (2.05, 0.0, 4.5, 1.0, 1.0), (0.0, 2.05, 2.93, 1.0, 0.3)]
    walls = [(-1.05, -1.05, 3.1, -1.05), (3.1, -1.05, 3.1, 3.1), (3.1, 3.1, -1.05, 3.1), (-1.05, 3.1, -1.05, -1.05)]
    speed, mass = [(1.1, 8.2, -0.3), (-1.5, 1.0, -6.4), (-1.9, 5.1, 0.6)], [0.09, 0.41, 5e-4]
    out = freefem_text(scene(bodies, walls, mass, [0.041, 0.2, 1.4e-4], speed, more=PROJECT.replace("DT", "0.2"))).stdout
    found, press = rows(out, "speed"), rows(out, "press")
    assert rows(out, "worst")[0, 0] > -1e-8
    after = [(b[0] + 0.2 * s[0], b[1] + 0.2 * s[1], b[2] + 0.2 * s[2], *b[3:]) for b, s in zip(bodies, found)]
    outlines = [outline(*body, np.linspace(0, 2 * np.pi, 2001)) for body in after]
    assert max(abs(points - 1.025).max() for points in outlines) < 2.075 + 1e-7
    c, s = np.cos(after[2][2]), np.sin(after[2][2])
    x, y = outlines[0] - np.array(after[2][:2])[:, None]
    assert np.hypot(c * x + s * y, (c * y - s * x) / 0.3).min() > 1 - 1e-6
    energy = [sum(m * (v[0]**2 + v[1]**2) for m, v in zip(mass, motion)) for motion in (speed, found)]
    assert energy[1] < energy[0] and (press[:, 2] >= 0).all()


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("turn, height, fall, spin", [(0.3, 0.4, -1.7, 0.2), (3.0, 0.7, -2.0, -1.3), (0.4, 0.6, -1.4, -1.4),
    (2.7, 1.0, -1.7, -0.7)])
def test_a_thin_ellipse_does_not_go_through_a_wall_or_a_body_in_one_step(freefem_text, turn, height, fall, spin, held):
    """Gaps were linearised again where it had come to, beyond the wall, from where the wall pushed it on: the run went on without a
    word."""
    bodies, mass, speed = [(0.0, height, turn, 1.0, 0.1)], [1.0], [(0.0, fall, spin)]
    if held:  # instead of the wall a held ellipse, whose upper side lies there
        bodies, mass, speed = [*bodies, (0.0, -0.3, 0.0, 3.0, 0.1)], [1.0, -1.0], [*speed, (0.0, 0.0, 0.0)]
    out = freefem_text(scene(bodies, [] if held else [(-9.0, 0.0, 9.0, 0.0)], mass, [0.2525, 1.0][:len(mass)], speed,
        more=PROJECT.replace("DT", "1"))).stdout
    u, v, w = rows(out, "speed")[0]
    points = outline(u, height + v, turn + w, 1.0, 0.1, np.linspace(0, 2 * np.pi, 2001))
    floor = np.where(np.abs(points[0]) < 3, 0.3 * np.sqrt(np.maximum(0, 1 - (points[0] / 3)**2)) - 0.3, -np.inf) if held else 0
    assert (points[1] - floor).min() > -1e-7


NEAR = [*WALLS, (-1.4, 0.42, -0.6, 0.42)]  # one under body 2
STAY = "\nfor (int k = 0; k < contactSN; ++k) cout << \"wall \" << contactSX1[k] << \" \" << contactSY1[k] << \" \" << contactSX2[k] << \" \" << contactSY2[k] << endl;\n"


@pytest.mark.parametrize("dt", [0.25, 0.5])
def test_bodies_and_walls_that_move_along_together_are_projected_as_at_rest(freefem_text, dt):
    """The velocities of all but for that one, the same impulses, and walls that are where they were."""
    u, v = 1.7, -2.3
    found = []
    for fast in (0, 1):
        speed = [(s[0] + fast * u, s[1] + fast * v, s[2]) for s in SPEED]
        drive = "".join(f"contactWallVelocity({k}, {u}, {v});\n" for k in range(len(NEAR))) if fast else ""
        out = freefem_text(scene(walls=NEAR, speed=speed, more=drive + PROJECT.replace("DT", str(dt)) + STAY)).stdout
        np.testing.assert_allclose(rows(out, "wall"), NEAR, atol=1e-14)
        found.append((rows(out, "speed") - [fast * u, fast * v, 0], {(i, j): p for i, j, p in rows(out, "press") if p > 1e-7}))
    assert abs(found[0][0] - SPEED).max() > 0.1 and min(j for _, j in found[0][1]) < 0 < max(j for _, j in found[0][1])
    np.testing.assert_allclose(found[1][0], found[0][0], atol=1e-6)
    assert found[1][1] == pytest.approx(found[0][1], abs=1e-6)


@pytest.mark.parametrize("angle, mirror", [(0.7, 1), (-2.0, -1)])
def test_a_scene_that_is_turned_or_mirrored_is_projected_turned_or_mirrored(freefem_text, angle, mirror):
    """With masses across other than along the axes."""
    turn = np.array([[np.cos(angle), -mirror * np.sin(angle)], [np.sin(angle), mirror * np.cos(angle)]])
    uneven = f"contactEllipseAside.resize(5); contactEllipseAside = {[4.0, 2.5, 0.3, 1.0, 6.0]};"
    bodies = [(*(turn @ b[:2]), angle + mirror * b[2], *b[3:]) for b in BODIES]
    walls = [(*(turn @ w[:2]), *(turn @ w[2:])) for w in NEAR]
    speed = [(*(turn @ s[:2]), mirror * s[2]) for s in SPEED]
    plain, other = (rows(freefem_text(scene(*what, more=uneven + PROJECT.replace("DT", "0.3"))).stdout, "speed")
        for what in ((BODIES, NEAR, MASS, MOMENT, SPEED), (bodies, walls, MASS, MOMENT, speed)))
    assert abs(plain - SPEED).max() > 0.1
    np.testing.assert_allclose(other, np.column_stack([plain[:, :2] @ turn.T, mirror * plain[:, 2]]), atol=1e-6)


def test_the_axis_across_a_disk_may_be_called_the_one_along_it(freefem_text):
    """Masses m along and s m across are s m along and m across, of a disk a quarter turn on: all s above 1, and all below."""
    bodies = [(*b[:3], 0.5, 1.0) for b in BODIES]
    share = np.array([4.0, 2.5, 1.0, 1.0, 6.0])
    swapped = [(*b[:2], b[2] + np.pi / 2 * (s != 1), *b[3:]) for b, s in zip(bodies, share)]
    found = []
    for those, mass, aside in ((bodies, MASS, share), (swapped, list(np.array(MASS) * share), 1 / share)):
        uneven = f"contactEllipseAside.resize(5); contactEllipseAside = {[float(s) for s in aside]};"
        found.append(rows(freefem_text(scene(those, WALLS, mass, MOMENT, SPEED, more=uneven + PROJECT.replace("DT",
            "0.9"))).stdout, "speed"))
    plain = rows(freefem_text(scene(bodies, WALLS, MASS, MOMENT, SPEED, more=PROJECT.replace("DT", "0.9"))).stdout, "speed")
    np.testing.assert_allclose(found[1], found[0], atol=1e-7)
    assert abs(plain - found[0]).max() > 0.05


def test_each_impulse_is_the_change_of_momentum_that_it_makes(freefem_text):
    """Of a move short enough for one linearisation: forces along the normals, torques by the lever arms."""
    told = "for (int k = 0; k < contactN; ++k) cout << \"row \" << contactI[k] << \" \" << contactJ[k] << \" \" << contactImpulse[k] << \" \" << contactEx[k] << \" \" << contactEy[k] << endl;"
    out = freefem_text(scene(walls=NEAR, speed=[(3 * a, 3 * b, 0.1 * c) for a, b, c in SPEED],
        more=MEASURE + "contactOverlap = 0.05;" + PROJECT.replace("DT", "0.08") + told)).stdout
    change = rows(out, "speed") - np.array(SPEED) * [3, 3, 0.1]
    push, table = np.zeros((5, 3)), rows(out, "row")
    assert rows(out, "passes")[0, 0] == 1 and (table[:, 2] > 1e-3).sum() >= 2 and table[table[:, 1] < 0, 2].max() > 1e-3
    arms = {(i, j): (arm_i, arm_j) for i, j, _, _, _, arm_i, arm_j in rows(out, "gap")}  # before the move
    for i, j, press, ex, ey in table:
        arm_i, arm_j = arms[i, j]
        push[int(i)] += press * np.array([ex, ey, arm_i])
        if j >= 0:
            push[int(j)] += press * np.array([-ex, -ey, arm_j])
    free = np.array(MASS) > 0
    np.testing.assert_allclose((change * np.column_stack([MASS, MASS, MOMENT]))[free], push[free], atol=1e-8)


def test_a_projection_does_not_depend_on_the_ones_before_it(freefem_text):
    """A scene of fewer bodies first, in which some press; then one in which all are held."""
    before = """
{ real[int] px2 = [0., 0.9], py2 = [0., 0.1], turn2 = [0.3, 1.], r2 = [0.5, 0.4], a2 = [0.5, 0.7], m2 = [1., 2.], j2 = [0.2, 0.3], u2 = [1., -1.], v2 = [0., 0.2], w2 = [0.5, 0.]; int[int] id2 = [3, 4];
  contactEllipseProject(px2, py2, turn2, r2, a2, id2, m2, j2, u2, v2, w2, 0.3); cout << "first " << contactWorstGap << " " << contactImpulse.max << endl; }
"""
    held = "mass = -1.;\nreal[int] u0 = u, v0 = v, w0 = w;\ncontactEllipseProject(px, py, turn, r, aspect, id, mass, moment, u, v, w, 0.5); u -= u0; v -= v0; w -= w0;\ncout << \"held \" << u.linfty + v.linfty + w.linfty << \" \" << contactHeldGap << endl;"
    alone, after = (freefem_text(scene(more=first + PROJECT.replace("DT", "0.3") + held)).stdout for first in ("", before))
    assert rows(after, "first")[0, 1] > 0.1
    np.testing.assert_allclose(rows(after, "speed"), rows(alone, "speed"), atol=1e-9)
    for out in (alone, after):
        same, gap = rows(out, "held")[0]
        assert same == 0 and gap < -0.1


def test_who_has_been_projected_may_change_places(freefem_text):
    """The directions of the move before are those of its step only: a gap measured later does not depend on them."""
    swap = "{ real a = px[0], b = py[0]; px[0] = px[1]; py[0] = py[1]; px[1] = a; py[1] = b; }\n" + MEASURE
    pair = ([(0.0, 0.0, 0.3, 0.5, 0.5), (1.2, 0.1, 1.0, 0.4, 0.7)], [], [1.0, 2.0], [0.2, 0.3], [(2.0, 0.0, 0.0), (-2.0, 0.0, 0.0)])
    after, fresh = (freefem_text(scene(*pair, more=first + swap)).stdout for first in (PROJECT.replace("DT", "0.3"), ""))
    assert rows(after, "press")[0, 2] > 0.1 and len(rows(fresh, "gap")) == 1
    np.testing.assert_allclose(rows(after, "gap"), rows(fresh, "gap"), atol=1e-12)


@pytest.mark.parametrize("upright", [0, 1])
def test_a_wall_along_a_whole_period_has_no_end_for_an_ellipse_over_its_seam(freefem_text, upright):
    """The foot of the ellipse lies beyond one end or the other: its height less the support function, whichever axis is
    periodic."""
    for along, turn in ((0.05, 0.6), (7.95, 0.6), (0.05, -0.6), (7.95, -0.6), (4.0, 0.6)):
        body, wall, angle = (along, 0.8, turn, 1.0, 0.3), (0.0, 0.0, 8.0, 0.0), turn
        if upright:
            body, wall = (body[1], body[0], np.pi / 2 - turn, *body[3:]), (0.0, 0.0, 0.0, 8.0)
        text = scene([body], [wall], [1.0], [1.0], [(0, 0, 0)], 8.0, MEASURE.replace("10.", "1."))
        if upright:
            text = text.replace("contactPeriodic(0, -5, 8.0, 0);", "contactPeriodic(-5, 0, 0, 8.0);")
        found = rows(freefem_text(text).stdout, "gap")
        assert len(found) == 1 and found[0, 2] == pytest.approx(0.8 - np.hypot(np.sin(angle), 0.3 * np.cos(angle)), abs=1e-9)
        assert abs(found[0, 3:5]) == pytest.approx([1, 0] if upright else [0, 1], abs=1e-9)


def test_behind_a_wall_or_a_body_the_direction_before_counts(freefem_text):
    """Where that of the largest s is more than a right angle from it: s of the one before, its lever arms by differences; elsewhere
    what is measured without it."""
    bodies, walls = [(0.0, 0.0, 0.3, 0.5, 0.5), (1.2, 0.1, 1.0, 0.4, 0.7), (0.3, 1.3, -0.5, 0.3, 0.4)], [(-1.0, -0.8, 1.5, -0.9)]
    text = scene(bodies, walls, [1.0] * 3, [1.0] * 3, [(0, 0, 0)] * 3, more="contactUpdate(px, py, r, id, 10.);\nSIDE"
        + MEASURE.split("\n", 2)[2])
    fresh = rows(freefem_text(text.replace("SIDE", "")).stdout, "gap")
    # every other one from the other side
    angles = [0.2 + np.arctan2(row[4], row[3]) + (np.pi if k % 2 else 0) for k, row in enumerate(fresh)]
    side = "".join(f"contactEllipseSide{axis}.resize({len(fresh)}) = {[float(f(a)) for a in angles]};\n" for axis,
        f in (("X", np.cos), ("Y", np.sin)))
    found = rows(freefem_text(text.replace("SIDE", side)).stdout, "gap")
    assert len(fresh) == 6 and (fresh[1::2, 1] < 0).any() and (fresh[1::2, 1] >= 0).any()

    def support(body, angle, more=0.0):
        return body[3] * np.hypot(np.cos(angle - body[2] - more), body[4] * np.sin(angle - body[2] - more))
    for k, (angle, row) in enumerate(zip(angles, found)):
        if k % 2 == 0:
            assert row == pytest.approx(fresh[k], abs=1e-12)
            continue
        n, one, step = np.array([np.cos(angle), np.sin(angle)]), bodies[int(row[0])], 1e-5
        slope = [(support(b, angle, -step) - support(b, angle, step)) / (2 * step) for b in (one, bodies[int(row[1])]
            if row[1] >= 0 else (0, 0, 0, 0, 0))]
        if row[1] >= 0:
            other = bodies[int(row[1])]
            gap = n @ np.subtract(one[:2], other[:2]) - support(one, angle) - support(other, angle)
        else:
            gap = min(n @ np.subtract(one[:2], end) for end in (walls[0][:2], walls[0][2:])) - support(one, angle)
        assert row[2:] == pytest.approx([gap, *n, *slope], abs=1e-8)


def test_over_a_seam_along_y_the_nearest_image_counts_too(freefem_text):
    bodies = [(0.0, 0.3, 0.4, 0.5, 0.4), (0.2, 7.6, 1.0, 0.6, 0.5)]
    text = scene(bodies, [], [1, 1], [1, 1], [(0, 0, 0)] * 2, 8.0, MEASURE.replace("10.",
        "0.5")).replace("contactPeriodic(0, -5, 8.0, 0);", "contactPeriodic(-5, 0, 0, 8.0);")
    found = rows(freefem_text(text).stdout, "gap")
    distance, direction = apart(edge((0.0, 8.3, *bodies[0][2:])), edge(bodies[1]))
    assert len(found) == 1 and found[0, 2] == pytest.approx(distance, abs=1e-8) and found[0, 4] == pytest.approx(direction[1],
        abs=1e-4)
