"""Curved walls made of many short segments (lib/contact/wall_bends.idp): what slides along them keeps its speed, and nothing is
kept off where there is no wall."""
import numpy as np
import pytest

from tests.scenes import write_walls
from tests.tables import distances_to_segments
from tools.base.run_folder import RunFolder

RING = """
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("ring", "a disk slides along a ring of {count} segments");
optDefault("-every", "1"); optDefault("-contact-tol", "1e-12"); optDefault("-contact-overlap", "1e-10");
real gravityX = 0, gravityY = 0;
macro caseParticles() {{ bodyAdd(0, {start:.9g}, 0.1, 1, 1, 0, 0, 1); }} // EOM
macro caseWalls() {{ for (int k = 0; k < {count}; ++k) contactWallSegment(cos(2*pi*k/{count}), sin(2*pi*k/{count}), cos(2*pi*(k + 1)/{count}), sin(2*pi*(k + 1)/{count})); }} // EOM
include "scripts/contacts.edp"
"""


@pytest.mark.parametrize("count, move", [(2000, 0.02), (500, 0.02), pytest.param(500, 0.05, marks=pytest.mark.slow),
    pytest.param(2000, 0.01, marks=pytest.mark.slow)])
def test_a_disk_slides_round_a_ring(count, move, freefem_text, tmp_path):
    """It keeps its speed where the sides are shorter than its moves, and never gains any: (move/R)^2 went in each step, 2.3 % on a
    radius at moves of a fiftieth of it."""
    freefem_text(RING.format(count=count, start=-0.9 + 1e-5 + (np.pi / count) ** 2), "-dt", move, "-tend", 1, "-every", move,
        "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    x, y, speed = last["x"][-1], last["y"][-1], np.hypot(last["u"], last["v"])
    assert 0.999 < speed[-1] <= 1 and (np.diff(speed) <= 1e-12).all()
    assert np.hypot(x, y) * np.cos(np.pi / count) < 0.9 and np.hypot(x, y) > 0.9 - 2e-3


def test_friction_on_a_curved_wall_takes_what_it_should(freefem_text, tmp_path):
    """A disk that slides on a ring without gravity: dv/dt = -mu v^2/R, v = 1/(1 + mu t/R)."""
    freefem_text(RING.format(count=2000, start=-0.9 + 1e-5 + (np.pi / 2000) ** 2), "-dt", 0.02, "-tend", 1, "-friction", 0.3,
        "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx(1 / (1 + 0.3 / 0.9), abs=4e-3)


def test_sides_longer_than_the_moves_take_what_the_corners_do(freefem_text, tmp_path):
    """300 sides, moves of half of one: as before."""
    freefem_text(RING.format(count=300, start=-0.9 + 1e-5 + (np.pi / 300) ** 2), "-dt", 0.01, "-tend", 1, "-out",
        tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx((1 + 2 * 0.01 / 0.9**2) ** -0.5, abs=0.1 * 0.01 / 0.9**2 + 1e-5)


def test_a_polygon_takes_what_its_corners_do(freefem_text, tmp_path):
    """Sides longer than the steps: half a corner where it starts and ten whole ones, at each of which the part of the velocity
    towards the next side goes."""
    freefem_text(RING.format(count=60, start=-0.9 + 1e-5 + (np.pi / 60) ** 2), "-dt", 0.02, "-tend", 1, "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx(np.cos(np.pi / 60) * np.cos(np.pi / 30) ** 10, abs=1e-8)


ELLIPSE_RING = """
include "lib/contact/ellipse_project.idp"
optCase("ring", "an ellipse slides along a ring of {count} segments");
optDefault("-contact-tol", "1e-12"); optDefault("-contact-overlap", "1e-10");
contactDeclare(); optEnd();
for (int k = 0; k < {count}; ++k) contactWallSegment(cos(2*pi*k/{count}), sin(2*pi*k/{count}), cos(2*pi*(k + 1)/{count}), sin(2*pi*(k + 1)/{count}));
real dt = {move}, way = 1 - {minor};
real[int] px = [0.], py = [1e-5 + (pi/{count})^2 - way], turn = [0.], r = [0.1], aspect = [{minor}/0.1], mass = [1.], moment = [(0.1^2 + {minor}^2)/4], u = [1.], v = [0.], w = [1/way];
int[int] id = [0];
for (int k = 0; k < 1/dt - 0.5; ++k) {{
    contactEllipseProject(px, py, turn, r, aspect, id, mass, moment, u, v, w, dt);
    px += dt*u; py += dt*v; turn += dt*w;
}}
cout.precision(12);
cout << "end " << sqrt(u[0]^2 + v[0]^2) << " " << (u[0]^2 + v[0]^2 + moment[0]*w[0]^2)/(1 + moment[0]/way^2) << " " << sqrt(px[0]^2 + py[0]^2) << " " << turn[0] - atan2(px[0], -py[0]) << endl;
"""


@pytest.mark.parametrize("minor", [0.05, 0.1])
@pytest.mark.parametrize("count, move", [(2000, 0.02), (300, 0.01)])
def test_an_ellipse_slides_round_a_ring(count, move, minor, freefem_text, tmp_path):
    """As a disk does (the second is one, in a run with ellipses); it turns with its way. 16 to 32 and 8 to 20 % of the energy went
    before."""
    done = freefem_text(ELLIPSE_RING.format(count=count, move=move, minor=minor))
    speed, energy, place, askew = (float(word) for word in [line for line in done.stdout.splitlines()
        if line.startswith("end")][0].split()[1:])
    slower = (1 + 2 * move / (1 - minor) ** 2) ** -0.5
    assert speed == pytest.approx(slower, abs=0.1 * move + 1e-5) and energy == pytest.approx(slower**2, abs=0.2 * move)
    assert place * np.cos(np.pi / count) < 1 - minor + 1e-9 and place > 1 - minor - 2e-3
    assert minor == 0.1 or abs(askew) < 0.03


GAPS = """
include "lib/contact/contact.idp"
contactWallsFromCsv("{walls}");
int n;
ifstream f("{disks}");
f >> n;
real[int] px(n), py(n), r(n);
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> r[k];
contactSearch(px, py, r, 0, 1.);
contactMeasure(px, py, r);
ofstream g("{gaps}");
g.precision(15);
for (int k = contactNearPairs; k < contactNearN; ++k) g << contactNearI[k] << " " << -1 - contactNearJ[k] << " " << contactNearGap[k] << endl;
cout << "bends " << bendFind() << endl;
"""


def wavy(rng, seed):
    """Segments, in any order and direction, of a wavy line, closed for every third seed."""
    count = int(rng.integers(40, 200))
    phi = np.sort(rng.uniform(0, 2 * np.pi, count)) if seed % 2 else np.linspace(0, 2 * np.pi, count, endpoint=False)
    radius = 1 + sum(a * np.cos(k * phi + rng.uniform(0, 7)) for k, a in ((2, 0.2), (5, 0.1 * rng.random()),
        (9, 0.05 * rng.random())))
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    ends = np.column_stack([x, y, np.roll(x, -1), np.roll(y, -1)])[: count - seed % 3]
    flip = rng.random(len(ends)) < 0.5
    ends[flip] = ends[flip][:, [2, 3, 0, 1]]
    return ends[rng.permutation(len(ends))]


@pytest.mark.parametrize("seed", range(6))
def test_a_disk_that_touches_nothing_has_no_negative_gap(seed, freefem_text, tmp_path):
    """On either side of a wavy closed line with bumps narrower than the disks, and of an open one: gaps are never above the
    distance to the segment, and below 0 only for who overlaps a wall."""
    rng = np.random.default_rng(seed)
    ends = wavy(rng, seed)
    px, py = rng.uniform(-1.6, 1.6, (2, 1500))
    near = distances_to_segments(px, py, ends[:, :2], ends[:, 2:]).min(1)
    r = np.minimum(near, 10 ** rng.uniform(-2, -0.2, 1500)) * (1 - 1e-9)  # many touch, none overlaps
    write_walls(tmp_path / "walls.csv", ends)
    (tmp_path / "disks.txt").write_text(f"{len(px)}\n" + "".join(f"{a:.17g} {b:.17g} {c:.17g}\n" for a, b, c in zip(px, py, r)))
    done = freefem_text(GAPS.format(walls=tmp_path / "walls.csv", disks=tmp_path / "disks.txt", gaps=tmp_path / "gaps.txt"))
    found = np.loadtxt(tmp_path / "gaps.txt")
    disk, wall, gap = found[:, 0].astype(int), found[:, 1].astype(int), found[:, 2]
    true = distances_to_segments(px, py, ends[:, :2], ends[:, 2:])[disk, wall] - r[disk]
    assert len(found) > 10000 and "bends 1" in done.stdout
    assert (gap <= true + 1e-12).all() and (gap < true - 1e-3).sum() > 100  # some gaps are those to lines
    assert gap.min() > -1e-12


ELLIPSE_GAPS = """
include "lib/contact/ellipse_gaps.idp"
contactWallsFromCsv("{walls}");
int n;
ifstream f("{bodies}");
f >> n;
real[int] px(n), py(n), turn(n), r(n), aspect(n);
int[int] id = 0:n - 1;
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> turn[k] >> r[k] >> aspect[k];
contactUpdate(px, py, r, id, 0.3);
contactEllipseMeasure(px, py, turn, r, aspect);
ofstream g("{gaps}");
g.precision(15);
for (int k = contactPairs; k < contactN; ++k) g << contactI[k] << " " << -1 - contactJ[k] << " " << contactEllipseGap[k] << endl;
"""


@pytest.mark.parametrize("seed, n", [(1, 150), pytest.param(2, 1500, marks=pytest.mark.slow)])
def test_an_ellipse_that_touches_nothing_has_no_negative_gap(seed, n, freefem_text, tmp_path):
    """On either side of such lines: below 0 only for who overlaps a wall; never above the distance of the outline to the segment;
    below it where it is that to the line."""
    rng = np.random.default_rng(seed)
    ends = wavy(rng, seed)
    some = n // 10
    px, py = rng.uniform(-1.3, 1.3, (2, n))
    turn, aspect, size, distance = rng.uniform(0, np.pi, n), rng.uniform(0.05, 1, n), np.empty(n), []
    angles = np.linspace(0, 2 * np.pi, 180, endpoint=False)
    for k in range(n):
        c, s = np.cos(turn[k]), np.sin(turn[k])
        own = [np.array([c * (x - px[k]) + s * (y - py[k]), (c * (y - py[k]) - s * (x - px[k])) / aspect[k]]).T for x,
            y in (ends[:, :2].T, ends[:, 2:].T)]
        size[k] = distances_to_segments(np.zeros(1), np.zeros(1), *own).min() * (1 - 1e-9)  # in axes in which it is a circle
        if k < some:
            ox, oy = size[k] * np.cos(angles), size[k] * aspect[k] * np.sin(angles)
            distance.append(distances_to_segments(px[k] + c * ox - s * oy, py[k] + s * ox + c * oy, ends[:, :2],
                ends[:, 2:]).min(0))
    write_walls(tmp_path / "walls.csv", ends)
    (tmp_path / "bodies.txt").write_text(f"{n}\n" + "".join(" ".join(f"{value:.17g}" for value in row) + "\n"
        for row in zip(px, py, turn, size, aspect)))
    freefem_text(ELLIPSE_GAPS.format(walls=tmp_path / "walls.csv", bodies=tmp_path / "bodies.txt", gaps=tmp_path / "gaps.txt"))
    found = np.loadtxt(tmp_path / "gaps.txt")
    body, wall, gap = found[:, 0].astype(int), found[:, 1].astype(int), found[:, 2]
    assert len(found) > 13 * n and gap.min() > -1e-9
    outline = np.array(distance)[body[body < some], wall[body < some]]
    assert (gap[body < some] <= outline + 1e-9).all() and (gap[body < some] < outline - 0.02).sum() > some / 3


def chain(*turns, lengths=(1.0, 0.9, 0.8, 0.7)):
    """Walls end to end from (0, 0), the first along x, which turn left by these angles (rad)."""
    corners, angle = [np.array([0.0, 0.0])], 0.0
    for length, turn in zip(lengths, (0.0, *turns)):
        angle += turn
        corners.append(corners[-1] + length * np.array([np.cos(angle), np.sin(angle)]))
    return np.array([np.concatenate(pair) for pair in zip(corners, corners[1:])])


# (walls, speeds of the walls, centre and radius of a disk, whether its gap is that to the line of the first wall, beyond whose end
# it lies; else it is that to the end)
STILL = [(0, 0)] * 4
BENT = [
    (chain(0.3), STILL, (1.3, 0.5, 0.1), True),
    (chain(0.3), STILL, (1.3, -0.5, 0.1), False),  # on the outer side of both,
    (chain(0.3), STILL, (1.3, 0.05, 0.02), False),  # of the second
    (chain(0.3, 0.3), STILL, (2.0, 0.35, 0.1), False),  # or of the third
    (chain(0.3), [(0, 0), (0.1, 0)], (1.3, 0.5, 0.1), False),  # one goes another way than the other
    (chain(0.3), [(0, 0), (0, 0.1)], (1.3, 0.5, 0.1), False),
    (chain(0.3), [(0.2, 0.1), (0.2, 0.1)], (1.3, 0.5, 0.1), True),
    (chain(0.49), STILL, (1.3, 0.5, 0.1), True),
    (chain(0.51), STILL, (1.3, 0.5, 0.1), False),  # a corner
    (chain(0.3), STILL, (1 + 0.9 * np.cos(0.3) - 1e-3, 0.5, 0.1), True),
    (chain(0.3), STILL, (1 + 0.9 * np.cos(0.3) + 1e-3, 0.5, 0.1), False),  # farther than the bend goes on
    (chain(0.3, 0.3), STILL, (1 + 0.9 * np.cos(0.3) + 0.8 * np.cos(0.6) - 1e-3, 0.9, 0.1), True),
    (chain(0.3, 0.3), STILL, (1 + 0.9 * np.cos(0.3) + 0.8 * np.cos(0.6) + 1e-3, 0.9, 0.1), False),
    (chain(0.3, -0.1), STILL, (1 + 0.9 * np.cos(0.3) + 0.1, 0.9, 0.1), False),  # it goes on the other way
    (chain(0.3, 0.0, 0.3), STILL, (1 + 1.7 * np.cos(0.3) + 0.1, 1.2, 0.1), True),  # straight on for a while
    # more than one radian in all
    (chain(0.4, 0.4, 0.4), STILL, (1 + 0.9 * np.cos(0.4) + 0.8 * np.cos(0.8) + 0.1, 1.4, 0.1), False),
    (chain(0.4, lengths=(0.1, 0.9)), STILL, (0.2, 0.6, 0.48), True),
    (chain(0.4, lengths=(0.1, 0.9)), STILL, (0.2, 0.6, 0.51), False),  # too large for the bend: r tan(0.2) > 0.1
    (chain(0.3) + [[0, 0, 0, 0], [2e-6, 0, 0, 0]], STILL, (1.3, 0.5, 0.1), False),  # a slit
    # a fork
    *((np.vstack([chain(0.3)[:1], *order]), STILL, (1.3, 0.5, 0.1), False) for fork in ([[1, 0, 1.1, -0.5]], [[1.1, -0.5, 1, 0]])
        for order in ((chain(0.3)[1:], fork), (fork, chain(0.3)[1:]))),
    (chain(0.0), STILL, (1.3, 0.5, 0.1), True),  # no bend: one straight wall in two pieces,
    (chain(0.0), [(0, 0), (0, 0.1)], (1.3, 0.5, 0.1), False),  # if they move as one
    (chain(1e-7), STILL, (1.3, 0.5, 0.1), True),
]
TURNS = """
include "lib/contact/contact.idp"
int n, m;
ifstream f("{file}");
f >> m >> n;
real[int] px(n), py(n), r(n);
for (int k = 0; k < m; ++k) {{ real a, b, c, d, e, g; f >> a >> b >> c >> d >> e >> g; contactWallVelocity(contactWallSegment(a, b, c, d), e, g); }}
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> r[k];
cout.precision(17);
contactSearch(px, py, r, 0, 3.);
contactMeasure(px, py, r);
for (int k = contactNearPairs; k < contactNearN; ++k) cout << "gap " << contactNearI[k] << " " << -1 - contactNearJ[k] << " " << contactNearGap[k] << endl;
"""
AGAIN = """
contactWallVelocity(1, 0.1, 0);
contactMeasure(px, py, r);
cout << "moved " << contactNearGap[0] << endl;
contactWallVelocity(1, 0, 0);
contactMeasure(px, py, r);
cout << "still " << contactNearGap[0] << endl;
contactWallsKeep(1); contactWallSegment(1, 0, 1.9, -0.3);
contactSearch(px, py, r, 0, 3.); contactMeasure(px, py, r);
cout << "changed " << contactNearGap[0] << endl;
"""


def turned_walls(freefem_text, file, scenes, more=""):
    """Gaps of disk k and the first wall of scene k, of the scenes side by side."""
    rows, disks, first, count = [], [], [], 0
    for k, (walls, speeds, disk, _) in enumerate(scenes):
        shift = np.array([0, 20.0 * k])
        first.append(count)
        count += len(walls)
        rows += [(*(wall[:2] + shift), *(wall[2:] + shift), *speed) for wall, speed in zip(walls, speeds)]
        disks.append((disk[0], disk[1] + 20.0 * k, disk[2]))
    file.write_text(f"{len(rows)} {len(disks)}\n" + "".join(" ".join(f"{value:.17g}" for value in row) + "\n"
        for row in rows + disks))
    out = freefem_text(TURNS.format(file=file) + more).stdout
    told = [line.split() for line in out.splitlines()]
    gaps = {(int(line[1]), int(line[2])): float(line[3]) for line in told if line[:1] == ["gap"]}
    return np.array([gaps[k, wall] for k, wall in enumerate(first)]), {line[0]: float(line[1]) for line in told if len(line) == 2}


@pytest.mark.parametrize("flip", [0, 1])
@pytest.mark.parametrize("mirror", [0, 1])
def test_where_a_wall_goes_on_round_a_bend_the_gap_is_that_to_its_line(mirror, flip, freefem_text, tmp_path):
    """Whichever end of the wall it is, and on whichever side of it."""
    scenes = []
    for walls, speeds, disk, line in BENT:
        walls = walls * ([1, -1, 1, -1] if mirror else 1)
        scenes.append((walls[:, [2, 3, 0, 1]] if flip else walls, [(u, -v if mirror else v) for u, v in speeds],
            (disk[0], -disk[1] if mirror else disk[1], disk[2]), line))
    found, _ = turned_walls(freefem_text, tmp_path / "walls.txt", scenes)
    for scene, gap in zip(BENT, found):
        (x, y, r), end = scene[2], scene[0][0, 2]
        assert gap == pytest.approx((abs(y) if scene[3] else np.hypot(x - end, y)) - r, abs=1e-9), scene


def test_bends_are_found_again_when_walls_or_their_speeds_change(freefem_text, tmp_path):
    first, later = turned_walls(freefem_text, tmp_path / "walls.txt", BENT[:1], AGAIN)
    end = np.hypot(0.3, 0.5) - 0.1
    assert first[0] == pytest.approx(0.4) and [later[word] for word in ("moved", "still", "changed")] == pytest.approx([end, 0.4,
        end])
