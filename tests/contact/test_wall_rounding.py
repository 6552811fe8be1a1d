"""Straight walls in pieces that were written with few digits are straight (lib/contact/wall_rounding.idp)."""
import numpy as np
import pytest

from tests.scenes import CONTACTS, turned, write_walls
from tools.base.tables import read_table

POLYGON = np.array([[0.1372, 0.2], [4.31, 0.7481], [5.1, 3.3009], [2.2456, 4.9], [-0.7, 2.4123]])
BODIES = {
    "disk": ("bodyAdd({x!r}, {y!r}, 0.1, 1000, {u!r}, {v!r}, 0, 1);", 0.1),
    "ellipse": ("bodyEllipse({x!r}, {y!r}, 0.1, 0.06, {angle!r}, 1000);", 0.06),
    "capsule": ("bodyThrown(bodyCapsule({x!r}, {y!r}, 0.1, 0.06, {angle!r}, 1000), {u!r}, {v!r}, 0);", 0.06),
}
SHAPES = 'include "lib/case.idp"\ninclude "lib/bodies/shapes.idp"\n'


def written(walls, form):
    """Coordinates as a table of that format has them; "single": in single precision, "short": its shortest digits; "FORM|FORM",
    "FORM|FORM|FORM": each in one of these, by chance."""
    if form.count("|") == 1:
        first, second = (written(walls, one) for one in form.split("|"))
        return np.where(np.random.default_rng(5).random(np.shape(walls)) < 0.4, first, second)
    if "|" in form:
        return np.choose(np.random.default_rng(5).integers(0, 3, np.shape(walls)), [written(walls, one) for one in form.split("|")])
    if form in ("single", "short"):
        return np.vectorize(lambda value: float(str(np.float32(value)) if form == "short" else np.float32(value)))(walls)
    return np.vectorize(lambda value: float(format(value, form)))(walls)


def side(first, second, count, rng):
    """A straight wall in pieces of random lengths, end to end, (count, 4)."""
    share = np.r_[0, np.sort(rng.uniform(0, 1, count - 1)), 1][:, None]
    points = (1 - share) * first + share * np.asarray(second)
    return np.hstack([points[:-1], points[1:]])


def scattered(walls, rng):
    """In another order, every other one from its second end to its first, a third of them twice."""
    walls = np.vstack([walls, walls[::3]])[rng.permutation(len(walls) + len(walls[::3]))]
    walls[::2] = walls[::2][:, [2, 3, 0, 1]]
    return walls


@pytest.fixture
def joined(freefem_text, tmp_path):
    """Walls as contacts see them, those that take part, (n, 4); the table as it was put straight, (m, 4)."""

    def run(walls):
        write_walls(tmp_path / "walls.csv", walls)
        freefem_text(f'''include "lib/contact/walls.idp"
            contactWallsFromCsv("{tmp_path}/walls.csv");
            contactWallsJoined
            ofstream f("{tmp_path}/joined.csv");
            f.precision(17);
            f << "on,x1,y1,x2,y2,ax,ay,bx,by" << endl;
            for (int k = 0; k < contactSN; ++k) f << contactWOn[k] << "," << contactWX1[k] << "," << contactWY1[k] << ","
                << contactWX2[k] << "," << contactWY2[k] << "," << contactSX1[k] << "," << contactSY1[k] << "," << contactSX2[k]
                << "," << contactSY2[k] << endl;''')
        rows = read_table(tmp_path / "joined.csv")
        return np.column_stack([rows[name][rows["on"] == 1] for name in ("x1", "y1", "x2", "y2")]), np.column_stack(
            [rows[name] for name in ("ax", "ay", "bx", "by")])

    return run


def corners(walls):
    """Ends of walls, each once, in an order."""
    return sorted(set(map(tuple, walls.reshape(-1, 2))))


@pytest.mark.parametrize("form", [".5g", ".6g", ".5f", ".4e", "single", "short"])
def test_a_polygon_in_pieces_has_its_sides(form, joined):
    rng = np.random.default_rng(4)
    walls = np.vstack([side(a, b, 40, rng) for a, b in zip(POLYGON, np.roll(POLYGON, -1, 0))])
    found, _ = joined(written(scattered(walls, rng), form))
    assert len(found) == 5 and corners(found) == corners(written(POLYGON, form))


@pytest.mark.parametrize("form", [".5g|.6g", ".4f|.5f", ".6g|.8g", ".6g|.7g|.8g", ".6g|short", ".5e|.6f"])
@pytest.mark.parametrize("spread", ["even", "random", "graded"])
def test_numbers_of_digits_that_differ_by_one_or_two_make_one_floor(spread, form, joined):
    """Of 40 pieces, coordinates from 0.001 to 100: up to 39 walls were left, as all counted as having the greater number."""
    rng = np.random.default_rng(1)
    share = {"even": np.linspace(0, 1, 41), "random": np.r_[0, np.sort(rng.uniform(0, 1, 39)), 1],
        "graded": (np.geomspace(1e-3, 100, 41) - 1e-3) / (100 - 1e-3)}[spread]
    points = np.column_stack([1e-3 + share * (100 - 1e-3), 5e-4 + 0.3 * (1e-3 + share * (100 - 1e-3))])
    found, straight = joined(written(np.hstack([points[:-1], points[1:]]), form))
    assert len(found) == 1 and np.abs(straight - np.hstack([points[:-1], points[1:]])).max() < 2e-3


@pytest.mark.parametrize("form", [".6g", ".17g"])
def test_curves_and_kinks_keep_their_corners(form, joined):
    """A circle of 500 sides keeps every bit; a kink of 0.1 degrees in long pieces stays where it is, in short ones nearly."""
    angle = 2 * np.pi * np.arange(501) / 500
    points = np.column_stack([3 + np.cos(angle), 2 + np.sin(angle)])
    circle = written(np.hstack([points[:-1], points[1:]]), form)
    found, straight = joined(circle)
    assert (found == circle).all() and (straight == circle).all()
    a, rng = np.arctan2(0.7, 2.9) + np.radians(0.1), np.random.default_rng(8)
    far = (3 + 3 * np.cos(a), 1 + 3 * np.sin(a))
    for pieces in (5, 100):
        walls = written(np.vstack([side((0.1, 0.3), (3, 1), pieces, rng), side((3, 1), far, pieces, rng)]), form)
        found, straight = joined(walls)
        kink = [end for end in corners(found) if 1 < end[0] < 5]
        assert len(found) == 2 and len(kink) == 1 and kink[0] == pytest.approx((3, 1), abs=1e-9 if pieces == 5 else 0.02)
        assert np.abs(straight - walls).max() <= (1e-5 if form == ".6g" else 1e-15)


def test_a_finely_curved_wall_bends_as_before(joined):
    """Sides whose bends are less than what rounding may do to them: no end moves by more than four roundings, and the walls that
    are left follow each other round the circle."""
    angle = 2 * np.pi * np.arange(1201) / 1200
    points = written(np.column_stack([3 + np.cos(angle), 2 + np.sin(angle)]), ".6g")
    walls = np.hstack([points[:-1], points[1:]])
    found, straight = joined(walls)
    assert np.abs(straight - walls).max() <= 2e-5 and np.abs(np.hypot(*(straight.reshape(-1, 2) - (3, 2)).T) - 1).max() < 4e-5
    turns = np.sort(np.arctan2(found[:, 3] - found[:, 1], found[:, 2] - found[:, 0]) % np.pi)
    assert 500 < len(found) < 1200 and np.diff(turns).max() < 0.02 and len(corners(found)) == len(found)


@pytest.mark.parametrize("sides", [0, 200])
def test_numbers_typed_by_hand_are_no_rounding(sides, joined):
    """A bend of half a unit of the last place, which only one number has; beside a circle of all digits too."""
    angle = 2 * np.pi * np.arange(sides + 1) / 200
    circle = np.column_stack([9 + np.cos(angle), 2 + np.sin(angle)])
    walls = np.array([[0, 0, 1, 3], [1, 3, 4, 12.00001], [4, 12.00001, 4, 0], [4, 0, 0, 0]])
    walls = np.vstack([walls, np.hstack([circle[:-1], circle[1:]])])
    found, straight = joined(walls)
    assert len(found) == 4 + sides and (straight == walls).all()


def test_a_circle_of_few_digits_among_full_ones_keeps_its_corners(joined):
    """Ends move by no more than two roundings: the one that both sides of a corner have, and that of a neighbour."""
    angle = 2 * np.pi * np.arange(501) / 500
    points = np.column_stack([3 + np.cos(angle), 2 + np.sin(angle)])
    circle = written(np.hstack([points[:-1], points[1:]]), ".6g|.17g")
    found, straight = joined(circle)
    assert len(found) == 500 and np.abs(straight - circle).max() <= 1.3e-5


def outermost(ends, direction):
    """The end farthest in that direction; where one has more digits, that."""
    along = ends @ direction
    return max(ends[along > along.max() - 1e-3], key=lambda end: (len(repr(end.tolist())), end @ direction))


def sliding(kind, floors, turn, origin, lift):
    """A body over each floor, which lie 3 above each other before they are turned, and what they start with."""
    line, radius = BODIES[kind]
    starts = [turn @ (0.5, 3 * k + radius + lift) + origin for k in range(len(floors))]
    angle = float(np.arctan2(turn[1, 0], turn[0, 0]))
    lines = [line.format(x=float(x), y=float(y), u=float(turn[0, 0]), v=float(turn[1, 0]), angle=angle) for x, y in starts]
    if kind == "ellipse":
        lines += [f"bodyQ[{k}] = {turn[0, 0]}; bodyQ[{len(floors) + k}] = {turn[1, 0]};" for k in range(len(floors))]
    return starts, "".join(lines)


@pytest.mark.parametrize("kind, count, form, slope", [("disk", 50, ".6g", 0.3), ("ellipse", 50, ".6g", -0.7), ("capsule", 50,
    ".6g", 0.3), ("disk", 50, ".5g", 1.2), ("disk", 200, ".6g", 1.2), ("ellipse", 200, ".5g", 0.3), ("capsule", 200, ".5g", -0.7),
    ("disk", 50, ".6g|.17g", 0.3), ("capsule", 50, ".5g|.9g", -0.7), ("ellipse", 200, ".5f|.17g", 0.3), ("disk", 50, ".5g|.6g",
    0.3), ("ellipse", 50, ".4f|.5f", -0.7), ("capsule", 200, ".6g|.7g|single", 0.3)])
def test_bodies_slide_over_random_pieces(kind, count, form, slope, freefem_text, tmp_path):
    """Disks lost 0.44 of their speed on 200 pieces and 0.78 where these overlap, and ellipses stopped the run; 0.3 to 0.5 where
    numbers of few digits stand among full ones. Expected from the energy on the straight floor, v^2 = 1 + 2 g.s."""
    rng, turn, origin = np.random.default_rng(7), turned(slope), np.array([0, 12])
    floors = [side((0, 0), (6, 0), count, rng), side((0, 0), (6, 0), count, rng) + (-0.05, 0, 0.05, 0)]
    floors = [floors[0], scattered(floors[0], rng), floors[1], scattered(floors[1], rng)]
    walls = [written(np.hstack([(floor[:, :2] + (0, 3 * k)) @ turn.T + origin, (floor[:, 2:] + (0, 3 * k)) @ turn.T + origin]),
        form) for k, floor in enumerate(floors)]
    write_walls(tmp_path / "walls.csv", np.vstack(walls))
    starts, bodies = sliding(kind, floors, turn, origin, 2e-3)
    gx, gy = turn @ (0, -9.81)
    text = (SHAPES if kind == "capsule" else "") + CONTACTS.replace("gravityX = 0", f"gravityX = {gx}").format(gravity=gy,
        walls=f'contactWallsFromCsv("{tmp_path}/walls.csv");', bodies=bodies, more="")
    freefem_text(text, "-dt", 0.02, "-tend", 2, "-every", 2, "-out", tmp_path / "run")
    last = read_table(tmp_path / "run" / "particles.csv")
    for k, floor in enumerate(walls):
        ends = floor.reshape(-1, 2)
        t = outermost(ends, turn[:, 0]) - outermost(ends, -turn[:, 0])
        t /= np.hypot(*t)
        way = t @ (np.array([last["x"], last["y"]])[:, k - len(walls)] - starts[k])
        speed = t @ np.array([last["u"], last["v"]])[:, k - len(walls)]
        assert way > 1.9 and speed == pytest.approx(np.sqrt(1 + 2 * way * (t @ (gx, gy))), abs=1e-6)


@pytest.mark.parametrize("period", [0, 1])
def test_supports_behind_a_floor_do_not_stand_out(period, freefem_text, tmp_path):
    """Walls that begin on it, at its joints and between: their ends stood out by the rounding, and took up to 0.2 of the speed."""
    rng, slope = np.random.default_rng(11), -0.3
    at = lambda x: np.column_stack([x, 1.9 + np.tan(slope) * (x - 0.1)])
    floor = side(at(np.array([0.1]))[0], at(np.array([6.3]))[0], 60, rng)
    tops = np.vstack([at(np.linspace(0.5, 6, 14)), written(floor, ".6g")[10:20, 2:]])
    walls = written(np.vstack([scattered(floor, rng), np.hstack([tops, tops - (0.2, 0.7)])]), ".6g")
    write_walls(tmp_path / "walls.csv", walls)
    turn = turned(slope)
    start = at(np.array([0.6]))[0] + turn @ (0, 0.102)
    text = CONTACTS.replace('walls.idp"', 'walls.idp"\ninclude "lib/contact/periodic.idp"').format(gravity=-9.81, more="",
        walls=f'contactWallsFromCsv("{tmp_path}/walls.csv");' + period * " contactPeriodic(0, -2, 8, 0);",
        bodies=BODIES["disk"][0].format(x=float(start[0]), y=float(start[1]), u=float(turn[0, 0]), v=float(turn[1, 0])))
    freefem_text(text, "-dt", 0.02, "-tend", 1, "-every", 1, "-out", tmp_path / "run")
    last = read_table(tmp_path / "run" / "particles.csv")
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx(1 + 9.81 * np.sin(-slope), abs=2e-5)


@pytest.mark.parametrize("form", [".6g", ".5g|.6g"])
def test_a_floor_of_few_digits_projects_velocities_as_one(form, freefem, tmp_path):
    """Disks on a slope that move over some of its pieces in a step."""
    rng, turn = np.random.default_rng(3), turned(-0.3)
    floor = side(turn @ (0, 0), turn @ (6, 0), 60, rng) + (0.1, 1.9, 0.1, 1.9)
    floor = written(floor, form)
    (tmp_path / "bodies.csv").write_text("id,x,y,radius,mass,u,v\n" + "".join("{},{},{},0.1,1,{},{}\n".format(k,
        *(turn @ (0.5 + 0.6 * k, 0.1001) + (0.1, 1.9)), *(turn @ (1 + 0.2 * k, -0.5))) for k in range(6)))
    write_walls(tmp_path / "pieces.csv", scattered(floor, rng))
    write_walls(tmp_path / "one.csv", [[*floor[0, :2], *floor[-1, 2:]]])
    for name in ("pieces", "one"):
        freefem("scripts/project_velocities.edp", "-bodies", tmp_path / "bodies.csv", "-walls", tmp_path / f"{name}.csv", "-dt",
            0.5, "-out", tmp_path / f"{name}_projected.csv")
    found, right = (read_table(tmp_path / f"{name}_projected.csv") for name in ("pieces", "one"))
    assert found["u"] == pytest.approx(right["u"], abs=1e-9) and found["v"] == pytest.approx(right["v"], abs=1e-9)
