"""Contacts over the seams of a periodic domain: against a QP package, after travelling far, and with a flow."""
import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tests.tables import rows
from tools.base.command import ROOT, BadInput
from tools.base.run_folder import RunFolder
from tools.peers.contact_problems import Rows, Scene, constraints, project, qp_piqp, scaled

SIDE = np.array([0.30, 0.22])
# a plate along the period, a slanted one up to the seam, spikes that cross it; LONG: slanted, almost as long as the period
WALLS = np.array([[0.0, 0.02, 0.30, 0.02], [0.22, 0.12, 0.30, 0.18], [0.0, 0.18, 0.02, 0.195], [-0.02, 0.06, 0.03, 0.06]])
LONG = np.array([[0.03, 0.19, 0.29, 0.215]])


def images(axes):
    """The shifts to the neighbours of a domain periodic along the axes."""
    steps = [(-1, 0, 1) if axis in axes else (0,) for axis in (0, 1)]
    return [np.array([a, b]) * SIDE for a in steps[0] for b in steps[1]]


def periodic_rows(scene, reach, axes):
    """constraints() of disks and walls, image by image: each pair and wall by its nearest image."""
    found, n = {}, len(scene.x)
    shifts = images(axes)
    everywhere = Scene(np.vstack([scene.x + shift for shift in shifts]), np.tile(scene.radius, len(shifts)),
        np.ones(n * len(shifts)),
                       np.zeros((n * len(shifts), 2)), scene.walls)
    rows = constraints(everywhere, reach)
    for i, j, gap, e in zip(rows.i % n, np.where(rows.j < 0, rows.j, rows.j % n), rows.gap, rows.e):
        if j >= 0 and i > j:
            i, j, e = j, i, -e
        if i != j and gap < found.get((i, j), (np.inf,))[0]:
            found[i, j] = (gap, e)
    keys = sorted(found)
    i, j = np.array(keys).reshape(-1, 2).T
    e = np.array([found[key][1] for key in keys])
    matrix = np.zeros((len(keys), 2 * len(scene.x)))
    for k, (a, b) in enumerate(keys):
        matrix[k, 2 * a:2 * a + 2] = e[k]
        if b >= 0:
            matrix[k, 2 * b:2 * b + 2] = -e[k]
    return Rows(i, j, np.array([found[key][0] for key in keys]), e, csr_matrix(matrix))


def dense(seed, number, axes, ratio, walls):
    """Disks that overlap nothing over the seams, placed at random, with random velocities."""
    rng = np.random.default_rng(seed)
    x, r = [], []
    for _ in range(40000):
        if len(x) == number:
            break
        radius, at = 0.009 * ratio ** -rng.random(), rng.random(2) * SIDE
        if not all(radius <= at[a] <= SIDE[a] - radius for a in (0, 1) if a not in axes):
            continue
        if not overlaps(x, r, at, radius, axes, walls):
            x.append(at)
            r.append(radius)
    x, r = np.array(x), np.array(r)
    return Scene(x, r, r**2 * np.exp(rng.normal(size=len(r))), 0.5 * rng.standard_normal((len(r), 2)), walls)


def overlaps(x, r, at, radius, axes, walls):
    """1 where the newcomer meets a disk or a wall."""
    for shift in images(axes):
        if x and (np.hypot(*(np.array(x) - at - shift).T) < np.array(r) + radius).any():
            return True
        for x1, y1, x2, y2 in walls:
            start, along = np.array([x1, y1]), np.array([x2 - x1, y2 - y1])
            if np.hypot(*(at + shift - start - np.clip((at + shift - start) @ along / (along @ along), 0, 1) * along)) < radius:
                return True
    return False


@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_the_projection_over_seams_is_that_of_a_qp_package(axes):
    scene, dt = dense(len(axes), 110, axes, 3.0, np.vstack([WALLS, LONG]) if axes == (0,) else WALLS), 0.01
    period = {word: SIDE[axis] for axis, word in ((0, "-period-x"), (1, "-period-y")) if axis in axes}
    answer = project(scene, dt, 1e-11, options=period)
    # reach: nobody goes farther
    rows = periodic_rows(scene, 2.2 * dt * np.hypot(*answer.velocity.T).max() + 2.2 * dt * np.hypot(*scene.velocity.T).max(), axes)
    plain = constraints(scene, 1.0)
    across = sum(1 for i, j, gap in zip(rows.i, rows.j, rows.gap) if not np.isclose(plain.gap[(plain.i == i) & (plain.j == j)],
        gap, atol=1e-12).any())
    assert across > 15  # rows that only the period makes
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    press = np.maximum(qp_piqp(scene, rows, dt, 1e-12), 0)
    q = dt / scene.radius.mean() * answer.velocity.ravel()
    np.testing.assert_allclose(q, q0 + matrix.T @ press / weight, atol=1e-6)
    assert (matrix @ q + d).min() > -1e-9
    alone = project(scene, dt, 1e-11)
    assert abs(alone.velocity - answer.velocity).max() > 0.05
    # disks that have travelled some periods are the same
    turns = np.random.default_rng(5).integers(-7, 8, scene.x.shape) * SIDE * [axis in axes for axis in (0, 1)]
    far = project(Scene(scene.x + turns, scene.radius, scene.mass, scene.velocity, scene.walls), dt, 1e-11, options=period)
    np.testing.assert_allclose(far.velocity, answer.velocity, atol=1e-8)
    assert far.figures[0]["constraints"] == answer.figures[0]["constraints"]


@pytest.mark.parametrize("wall", [LONG, [[0.05, 0.19, 0.345, 0.205]]])
def test_seams_and_walls_along_y_are_those_along_x(wall):
    """The image in the line x = y: also of walls that are a period long, or nearly."""
    scene = dense(1, 110, (0,), 3.0, np.vstack([WALLS, wall]))
    swapped = Scene(scene.x[:, ::-1], scene.radius, scene.mass, scene.velocity[:, ::-1], scene.walls[:, [1, 0, 3, 2]])
    along, across = (project(one, 0.01, 1e-11, options={word: SIDE[0]}) for one, word in ((scene, "-period-x"),
        (swapped, "-period-y")))
    np.testing.assert_allclose(across.velocity[:, ::-1], along.velocity, atol=1e-8)
    assert across.figures[0]["constraints"] == along.figures[0]["constraints"]
    assert abs(along.velocity - scene.velocity).max() > 0.05


def test_overlaps_over_a_seam_and_short_periods_are_refused():
    pair = Scene(np.array([[0.01, 0.1], [0.29, 0.1]]), np.array([0.012, 0.012]), np.ones(2), np.zeros((2, 2)))
    project(pair)
    with pytest.raises(BadInput, match="overlap"):
        project(pair, options={"-period-x": 0.3})
    with pytest.raises(BadInput, match="less than half of it"):
        project(pair, options={"-period-x": 0.04})


HEAD = "id,x,y,radius,density,u,v,omega\n"


CASE = (ROOT / "cases" / "couette_disk.edp").read_text()
LONE = "bodyDisk(length/2, startY, radius, rhoSolid);"


@pytest.fixture
def couette(freefem, tmp_path):
    """Runs disks in the shear flow of period 1, without the disk of the case."""
    def run(name, disks, end="0.15"):
        assert CASE.count(LONE) == 1
        script, table = tmp_path / f"{name}.edp", tmp_path / f"{name}.csv"
        script.write_text(CASE.replace(LONE, ""))
        table.write_text(HEAD + "".join(f"{','.join(map(str, row))}\n" for row in disks))
        freefem(script, "-particles", table, "-reynolds", "10", "-dt", "0.005", "-tend", end, "-every", "0", "-film", "0", "-out",
            tmp_path / name)
        done = RunFolder(tmp_path / name)
        return done.table("fluid"), done.table("particles")
    return run


def test_a_pair_that_meets_over_the_seam_moves_as_in_the_middle(couette):
    found = {}
    for name, start, turns in (("middle", 0.5, 0), ("seam", 0.0, 3)):
        fluid, table = couette(name, [(5, start - 0.15, 0.8, 0.08, 50, 2, 0, 0), (6, start + 0.15 + turns, 0.8, 0.08, 50, -2, 0,
            0)])
        assert fluid["worst_gap"].min() > -1e-9 and fluid["contacts"].max() == 1
        found[name] = {(d, c): table[c][table["id"] == d] - (start + turns * (d == 6) if c == "x" else 0) for d in (5, 6)
            for c in "xyuv"}
    for key, values in found["middle"].items():
        np.testing.assert_allclose(found["seam"][key], values, atol=1e-4)


def test_a_disk_carried_along_a_plate_over_the_seam_stays_on_it(couette):
    fluid, table = couette("along", [(5, 0.8, 0.88, 0.08, 500, 1, 0.2, 0)], "0.5")
    touching = table["x"][1 - 0.08 - table["y"] < 1e-6]
    assert 1 < touching.min() < 1.1 and fluid["contacts"].max() == 1 and fluid["worst_gap"].min() > -1e-9
    assert (1 - 0.08 - table["y"]).min() > -1e-9


def test_a_plate_holds_a_disk_that_has_travelled_some_periods(couette):
    fluid, table = couette("far", [(5, 3.6, 0.8, 0.08, 50, 0, 2, 0)])
    assert fluid["contacts"].max() == 1
    assert (1 - 0.08 - table["y"]).min() > -1e-9 and table["y"].max() == pytest.approx(0.92, abs=1e-6)


def test_a_plate_holds_an_ellipse_over_the_seam(freefem, tmp_path):
    """The plate has no end there: ellipses that lay across the seam went through it."""
    lowest, ends = [], []
    for name, x in (("middle", 0.5), ("seam", 0.0), ("beside", 0.1)):
        script, table = tmp_path / f"{name}.edp", tmp_path / f"{name}.csv"
        script.write_text(CASE.replace(LONE, ""))
        table.write_text(f"id,x,y,radius,density,u,v,omega,aspect,theta\n0,{x},0.7,0.2,500,0,2,0,0.4,-0.6\n")
        freefem(script, "-particles", table, "-reynolds", "10", "-dt", "0.0025", "-tend", "0.3", "-every", "0", "-film", "0",
            "-out", tmp_path / name)
        rows = RunFolder(tmp_path / name).table("particles")
        height = 0.2 * np.hypot(np.sin(rows["theta"]), 0.4 * np.cos(rows["theta"]))
        lowest.append((1 - rows["y"] - height).min())
        ends.append((rows["y"][-1], rows["theta"][-1]))
    assert min(lowest) > -1e-6 and max(lowest) < 1e-3
    # at three places within the mesh
    assert ends[1] == pytest.approx(ends[0], abs=5e-3) and ends[2] == pytest.approx(ends[0], abs=5e-3)


def test_a_large_disk_and_a_small_one_may_move_fast_in_a_short_period():
    """0.22 and 0.1 in a period of 1: they cannot meet over both sides, however near to a quarter of it the large one is."""
    pair = Scene(np.array([[0.3, 0.5], [0.8, 0.3]]), np.array([0.22, 0.1]), np.ones(2), np.array([[1.0, 0.5], [-0.5, 0.2]]))
    answer = project(pair, 0.05, 1e-11, options={"-period-x": 1.0, "-period-y": 1.0})
    np.testing.assert_allclose(answer.velocity, pair.velocity, atol=1e-12)
    with pytest.raises(BadInput, match="in a step"):
        project(pair, 1.0, 1e-11, options={"-period-x": 1.0, "-period-y": 1.0})


SEARCH = """
include "lib/contact/contact.idp"
{walls}
contactPeriodic({low[0]}, {low[1]}, {period[0]}, {period[1]});
int n;
ifstream f("{file}");
f >> n;
real[int] px(n), py(n), r(n);
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> r[k];
contactSearch(px, py, r, {reach}, {reach});
if (contactNearN > 0) contactMeasure(px, py, r);
cout.precision(17);
for (int k = 0; k < contactNearPairs; ++k) cout << "pair " << contactNearI[k] << " " << contactNearJ[k] << " " << contactShiftX[k] << " " << contactShiftY[k] << " " << contactNearGap[k] << endl;
cout << "sizes " << contactNearI.n << " " << contactNearJ.n << " " << contactNearN << " " << contactShiftX.n << " " << contactShiftY.n << " " << contactNearPairs << endl;
"""


def searched(freefem_text, tmp_path, disks, low, period, reach=0.0, walls=""):
    (tmp_path / "disks.txt").write_text(f"{len(disks)}\n" + "".join(" ".join(f"{value:.17g}" for value in row) + "\n"
        for row in disks))
    out = freefem_text(SEARCH.format(walls=walls, low=low, period=period, reach=reach, file=tmp_path / "disks.txt")).stdout
    return rows(out, "pair"), rows(out, "sizes")[0].astype(int)


@pytest.mark.parametrize("period", [(0.3, 0), (0, 0.22), (0.3, 0.22)])
@pytest.mark.parametrize("reach", [0.0, 0.02])
def test_each_pair_over_a_seam_is_found_once_with_its_shift(reach, period, freefem_text, tmp_path):
    """Against all images of all pairs, of disks of many sizes that overlap, some periods apart; the largest reach nearly over half
    a period."""
    rng = np.random.default_rng(7)
    low, number = np.array([-0.04, 0.9]), 250
    disks = np.column_stack([low + rng.uniform(-2, 3, (number, 2)) * SIDE, np.where(rng.random(number) < 0.2, 0.043,
        0.043 * 10 ** -rng.uniform(0, 1.5, number))])
    found, sizes = searched(freefem_text, tmp_path, disks, low, period, reach)
    off = [disks[:, None, axis] - disks[:, axis] for axis in (0, 1)]
    shift = [-length * np.round(a / length) if length else 0 * a for a, length in zip(off, period)]
    gap = np.hypot(off[0] + shift[0], off[1] + shift[1]) - disks[:, None, 2] - disks[:, 2]
    i, j = np.nonzero(np.triu(gap < reach, 1))
    assert len(i) > 300 and (sizes == len(i)).all()
    order = np.lexsort(found[:, 1::-1].T)
    assert (found[order, :2] == np.column_stack([i, j])).all()
    np.testing.assert_allclose(found[order, 2:], np.column_stack([shift[0][i, j], shift[1][i, j], gap[i, j]]), atol=1e-12)


@pytest.mark.parametrize("period", [(1, 0), (0, 1), (1, 1)])
def test_a_disk_is_no_pair_with_its_own_image(period, freefem_text, tmp_path):
    """Alone, before a wall, and in a step longer than the period."""
    wall = "contactWallSegment(0.2, 0.05, 0.4, 0.05);"
    assert searched(freefem_text, tmp_path, [(0.1, 0.9, 0.51)], (0, 0), period)[1].tolist() == [0] * 6
    assert searched(freefem_text, tmp_path, [(0.3, 0.3, 0.51)], (0, 0), period, walls=wall)[1].tolist() == [1, 1, 1, 0, 0, 0]
    alone = Scene(np.array([[0.4, 0.3]]), np.array([0.1]), np.ones(1), np.array([[3.0, -2.0]]))
    answer = project(alone, 0.5, 1e-11, options={word: 1.0 for word, length in zip(("-period-x", "-period-y"), period) if length})
    np.testing.assert_allclose(answer.velocity, alone.velocity, atol=0)


@pytest.mark.parametrize("turned", [0, 1])
def test_the_shorter_of_two_periods_bounds_what_disks_may_be(turned):
    """Radii of 0.2 and 0.06 fit into a period of 0.6 beside one of 2; in one of 0.4 the large one overlaps its image, in one of 0.5
    they could meet over both sides."""
    pair = Scene(np.array([[0.3, 0.3], [0.31, 0.02]])[:, ::1 - 2 * turned], np.array([0.2, 0.06]), np.ones(2),
        np.array([[0.1, 0.0], [0.0, 0.05]])[:, ::1 - 2 * turned])
    for short, says in ((0.6, None), (0.5, "less than half of it"), (0.39, "overlaps its own image")):
        options = {"-period-x": 2.0 if turned else short, "-period-y": short if turned else 2.0}
        if says:
            with pytest.raises(BadInput, match=says):
                project(pair, 0.01, 1e-11, options=options)
        else:
            np.testing.assert_allclose(project(pair, 0.01, 1e-11, options=options).velocity, pair.velocity, atol=1e-12)


def test_no_pair_is_listed_over_both_sides_however_wide_the_skin(freefem_text):
    """In a row round a period of 1, which they fill to four fifths; all would be within three radii over either side."""
    out = freefem_text("""
include "lib/contact/contact.idp"
contactPeriodic(0, 0, 1, 0);
contactSkin = 8;
real[int] px = [0.1, 0.35, 0.6, 0.85], py = [0.1, 0.2, 0.15, 0.12], r = [0.1, 0.09, 0.1, 0.1];
int[int] id = 0:3;
contactUpdate(px, py, r, id, 0.02);
for (int k = 0; k < contactNearPairs; ++k) cout << "pair " << contactNearI[k] << " " << contactNearJ[k] << endl;
""").stdout
    assert sorted(map(tuple, rows(out, "pair").tolist())) == [(0, 1), (0, 3), (1, 2), (2, 3)]
