"""One scene in other units, turned or mirrored, in tables of every kind: forces, walls, fluxes, who enters and leaves, contacts,
budgets; and a periodic one counted from another side."""
import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import SCENE, turned, write_moved
from tools.base.run_folder import RunFolder

# what the case calls, centre, semi-axes, angle, density over the fluid's, due at
BODIES = [("body", 0.6, 1.5, 0.2, 0.2, 0, 1.2, 0), ("body", 3.413, 0.7, 0.2, 0.2, 0, 0.9, 0), ("bodyPinned", 1.5, 1.03, 0.35, 0.2,
    0.8, 1.5, 0), ("body", 2.48, 1.5, 0.15, 0.15, 0, 3.0, 0),
          ("bodyHeld", 2.2, 0.45, 0.2, 0.15, -0.6, 1, 0), ("queue", 0.7, 0.5, 0.25, 0.16, 0.4, 2.0, 0.3), ("queue", 0.65, 1.2, 0.2,
              0.2, 0, 1.5, 0.5)]
LIKE = {"body": "body", "bodyPinned": "body", "bodyHeld": "body", "queue": "queue"}


def tables(channel, folder, turn=np.eye(2), unit=1.0, second=1.0, density=1.0):  # noqa: F811
    """Tables of the scene in its own units and axes; unit, second: its units of length and time."""
    turn = np.asarray(turn, float)
    folder.mkdir()
    sense = np.sign(np.linalg.det(turn))
    write_moved(channel, folder / "moved.mesh", turn, unit)
    bodies = []
    for how, x, y, long, short, angle, ratio, due in BODIES:
        centre, axis = turn @ (x, y) * unit, turn @ (np.cos(angle), np.sin(angle))
        sizes = f"{long * unit:.17g}" + (f", {short * unit:.17g}, {np.arctan2(axis[1], axis[0]):.17g}" if long > short else "")
        shape = ("Ellipse" if long > short else "Disk") if how != "queue" else ("Ellipse" if long > short else "") + "At"
        made = f"{LIKE[how]}{shape}({centre[0]:.17g}, {centre[1]:.17g}, {sizes}, {ratio * density:.17g}" + (f", {due * second:.17g})" if how == "queue" else ")")
        bodies.append(f"    {made};" if how in ("body", "queue") else f"    {how}({made});")
    (folder / "scene.edp").write_text(SCENE.format(
        dt=0.04 * second, end=1.6 * second, every=0.08 * second, ramp=0.2 * second, viscosity=0.02 / second,
        unit=unit, density=density, gravity=turn @ (0, -1) * unit / second**2, stream=turn @ (2, 0) * unit / second, origin=(0, 0),
            turn=turn, bodies="\n".join(bodies),
        walls="labelWall, labelTop", slip="(0)"))
    run_freefem(folder / "scene.edp", "-mesh", folder / "moved.mesh", "-film", 0, "-forces", 1, "-wallforces", 1, "-fluxes", 1,
        "-out", folder / "run")
    return plain(RunFolder(folder / "run"), turn, sense, unit, second, density)


# units of the columns by powers of length, time, mass (per metre of depth); (x, y): vectors, the others scalars, those that turn
# with a sign
VECTORS = {("x", "y"): (1, 0, 0), ("u", "v"): (1, -1, 0), ("fx", "fy"): (1, -2, 1), ("nx", "ny"): (0, 0, 0)}
SCALARS = {"t": (0, 1, 0), "omega": (0, -1, 0), "torque": (2, -2, 1), "flux": (2, -1, 0), "radius": (1, 0, 0),
    "impulse": (1, -1, 1), "kinetic_energy": (2, -2, 1), "pressure_drop": (0, -2, 1),
           "top_speed": (1, -1, 0), "flux_in": (2, -1, 0), "flux_out": (2, -1, 0), "dt": (0, 1, 0), "divergence": (1, -1, 0)}
TABLES = ("particles", "forces", "wallforces", "fluxes", "entries", "exits", "contacts", "fluid")
SAME = ("id", "label", "i", "j", "particles", "contacts", "iterations", "unresolved", "major", "minor")


def plain(run, turn, sense, unit, second, density):
    """{table: {column: values}}: vectors and scalars in the scene's own units."""
    mass = density * unit**2  # of an area of its unit

    def size(powers):
        return unit ** powers[0] * second ** powers[1] * mass ** powers[2]

    found = {}
    for name in TABLES:
        table, found[name] = run.table(name), {}
        if name == "contacts":  # those of a step in any order
            order = np.lexsort((table["j"], table["i"], table["t"]))
            table = {column: table[column][order] for column in ("t", "i", "j", "nx", "ny", "impulse")}
        for (a, b), powers in VECTORS.items():
            if a in table and b in table:
                both = np.column_stack([table[a], table[b]]) / size(powers) @ turn
                found[name][a], found[name][b] = both[:, 0], both[:, 1]
        for column, powers in SCALARS.items():
            if column in table:
                found[name][column] = table[column] / size(powers) * (sense if column in ("omega", "torque") else 1)
        for column in SAME:
            if column in table:
                found[name][column] = table[column]
    return found


def assert_same(found, base, within):
    for name, table in base.items():
        assert len(table["t"]) > 0 and table.keys() == found[name].keys(), name
        for column, values in table.items():
            assert found[name][column].shape == values.shape, (name, column)
            assert np.abs(found[name][column] - values).max() < within * max(1, np.abs(values).max()), (name, column)


@pytest.fixture(scope="module")
def as_it_is(channel, tmp_path_factory):  # noqa: F811
    return tables(channel, tmp_path_factory.mktemp("base") / "run")


MOVES = {"centimetres, grams and milliseconds": dict(unit=100.0, density=1e-3, second=1000.0),
    "a quarter turn": dict(turn=[[0, -1], [1, 0]]), "mirrored": dict(turn=[[-1, 0], [0, 1]]),
         "a turn of 0.4 rad": dict(turn=turned(0.4))}


@pytest.mark.parametrize("move", MOVES)
def test_the_tables_do_not_hang_on_units_and_axes(move, as_it_is, channel, tmp_path):  # noqa: F811
    """With bodies held, pinned, waiting, that touch, leave: rounding is 1e-10 to 1e-9. A waiting disk's spin was that of points
    along the axes, 2e-4 off where they do not turn by 30 degrees."""
    assert set(as_it_is["entries"]["id"]) == set(range(7)) and len(as_it_is["exits"]["t"]) == 2
    assert_same(tables(channel, tmp_path / "moved", **MOVES[move]), as_it_is, 1e-8)


PERIODIC = """
savemesh(square(32, 32), "{file}");
include "lib/case.idp"
optCase("shifted", "a periodic scene counted from another side");
real rhoFluid = 1, mu = 0.02, gravityX = 0.3, gravityY = -1;
int[int] flowNoSlip(0), flowMoving(0), flowOutlet(0), flowSlip(0);
macro flowSpaces() fespace Wh(Th, P2, periodic = [[2, y], [4, y], [1, x], [3, x]]); fespace Qh(Th, P1, periodic = [[2, y], [4, y], [1, x], [3, x]]); // EOM
macro flowPeriodicLabels() [1, 2, 3, 4] // EOM
real flowPeriodX = 1, flowPeriodY = 1, motionBound = 1e30;
macro flowForceX() (0.2 + 0.1*cos(2*pi*(y - ({by[1]})))) // EOM
macro flowForceY() (0.05 + 0.1*sin(2*pi*(x - ({by[0]})))) // EOM
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {{
    bodyAdd({at[0]}, 0.1, 2, 0, 0, 0, 1); bodyEllipse({at[1]}, 0.14, 0.08, 0.7, 1.5); bodyHeld(bodyDisk({at[2]}, 0.097, 1));
    bodyPinned(bodyEllipse({at[3]}, 0.13, 0.08, 0.2, 1)); bodyDisk({at[4]}, 0.08, 5);
    queueAt({at[5]}, 0.09, 1.4, 0.1); queueEllipseAt({at[6]}, 0.12, 0.07, 1.2, 1.2, 0.2);
}} // EOM
include "scripts/resolved.edp"
"""
PLACES = np.array([(0.2, 0.85), (0.52, 0.95), (0.85, 0.5), (0.45, 0.4), (0.84, 0.69), (0.2, 0.6), (0.98, 0.13)])


def shifted(folder, by):
    folder.mkdir()
    at = [f"{x:.17g}, {y:.17g}" for x, y in (PLACES + by) % 1]
    (folder / "scene.edp").write_text(PERIODIC.format(file=folder / "square.mesh", by=by, at=at))
    run_freefem(folder / "scene.edp", "-mesh", folder / "square.mesh", "-film", 0, "-dt", 0.01, "-tend", 0.4, "-every", 0.02,
        "-tolerance", 1e-10, "-forces", 1, "-fluxes", 1, "-out", folder / "run")
    run = RunFolder(folder / "run")
    found = {name: dict(run.table(name).items()) for name in ("particles", "forces", "entries", "contacts")}
    for name in ("particles", "entries"):
        found[name]["x"], found[name]["y"] = np.exp(2j * np.pi * (run.table(name)["x"] - by[0])), np.exp(2j * np.pi
            * (run.table(name)["y"] - by[1]))
    return found


@pytest.fixture(scope="module")
def unshifted(tmp_path_factory):
    return shifted(tmp_path_factory.mktemp("periodic") / "base", (0, 0))


@pytest.mark.parametrize("by", [(0.5, 0.5), (5 / 32, 0.25)], ids=["half a period", "a contact on the seam"])
def test_a_periodic_scene_may_be_counted_from_any_side(by, unshifted, tmp_path):
    base = unshifted
    assert len(base["contacts"]["t"]) > 3 and base["particles"]["id"].max() == 6
    assert_same(shifted(tmp_path / "shifted", by), base, 1e-8)
