"""A closed box turned or mirrored, its run broken off and gone on with: the same budgets and forces."""
import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import case, write_moved
from tests.tables import broken_off
from tools.base.mesh_files import read_mesh
from tools.base.run_folder import RunFolder

# A mesh without symmetry; a wall on three sides, a plane of symmetry on the fourth.
BOX = """
border below(s = 0, 1.2) {{ x = s; y = 0; label = 13; }}
border right(s = 0, 1) {{ x = 1.2; y = s; label = 12; }}
border above(s = 1.2, 0) {{ x = s; y = 1; label = 14; }}
border left(s = 1, 0) {{ x = 0; y = s; label = 11; }}
savemesh(buildmesh(below(20) + right(17) + above(21) + left(16)), "{file}");
"""
# centre, semi-axes, angle, density: one falls on the floor, one on the first, a light one is pushed. All at rest at the start: the
# flow that velocities at the start set in
# motion is solved for to a tolerance (1e-5 of their speed) within which rounding decides
BODIES = [(0.5, 0.143, 0.14, 0.14, 0, 3), (0.62, 0.404, 0.17, 0.11, 0.5, 6), (0.85, 0.7, 0.13, 0.13, 0, 0.4)]
PUSH, TORQUE = (0.05, -0.02), 0.01
VECTORS = {"particles": [("x", "y"), ("u", "v")], "forces": [("fx", "fy")], "wallforces": [("fx", "fy")],
    "budget": [("momentum_x", "momentum_y"), ("walls_x", "walls_y"), ("weight_x", "weight_y")]}
SCALARS = {"particles": ["omega"], "forces": ["torque"], "wallforces": [], "budget": ["kinetic_energy", "work", "dissipated",
    "pressure", "contacts", "numerical"]}


def runs(box, folder, turn):
    """The tables of a whole run and those of one that was broken off, both in the axes of the scene; they are the same bytes."""
    turn = np.array(turn, float)
    folder.mkdir()
    sense = round(np.linalg.det(turn))
    write_moved(box, folder / "box.mesh", turn)
    words = []
    for x, y, long, short, angle, density in BODIES:
        centre, axis = turn @ (x, y), turn @ (np.cos(angle), np.sin(angle))
        axes = f"{long}, {short}, {np.arctan2(axis[1], axis[0]):.17g}" if short < long else f"{long}"
        words.append(f"{'bodyEllipse' if short < long else 'bodyDisk'}({centre[0]:.17g}, {centre[1]:.17g}, {axes}, {density});")
    push, gravity = turn @ PUSH, turn @ (0, -4)
    text = case("{ " + " ".join(words) + " }", walls="labelRight, labelBottom, labelTop", slip="labelLeft",
        more=f"macro caseLoads(now) bodyPush(2, {push[0]:.17g}, {push[1]:.17g}, {sense * TORQUE}); // EOM")
    (folder / "scene.edp").write_text(text.replace("gravityX = 0, gravityY = -1", f"gravityX = {gravity[0]:.17g}, gravityY = "
        f"{gravity[1]:.17g}"))
    command = [folder / "scene.edp", "-mesh", folder / "box.mesh", "-every", "0", "-film", "0", "-tend", "0.3", "-forces", "1",
        "-wallforces", "1", "-budget", "1", "-checkpoint", "20"]
    whole, broken = broken_off(command, folder, 20)
    found = {}
    for name in VECTORS:
        assert (broken / f"{name}.csv").read_bytes() == (whole / f"{name}.csv").read_bytes(), name
        table = RunFolder(broken).table(name)
        found[name] = [np.column_stack([table[a], table[b]]) @ turn for a, b in VECTORS[name]] + [table[column] * (sense
            if column in ("omega", "torque") else 1) for column in SCALARS[name]]
    contacts = RunFolder(broken).table("contacts")
    assert (contacts["t"] < 0.2).any() and contacts["t"].max() > 0.22  # before the break and behind it
    return found


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    folder = tmp_path_factory.mktemp("box")
    (folder / "mesh.edp").write_text(BOX.format(file=folder / "box.mesh"))
    run_freefem(folder / "mesh.edp")
    return read_mesh(folder / "box.mesh")


@pytest.fixture(scope="module")
def as_it_is(box, tmp_path_factory):
    return runs(box, tmp_path_factory.mktemp("base") / "run", np.eye(2))


@pytest.mark.parametrize("turn", [[[0, -1], [1, 0]], [[-1, 0], [0, 1]], [[0, 1], [1, 0]]], ids=["a quarter turn", "mirrored",
    "across"])
def test_budgets_do_not_hang_on_the_axes_nor_on_a_break(turn, as_it_is, box, tmp_path):
    found = runs(box, tmp_path / "moved", turn)
    for name, tables in as_it_is.items():
        for one, other in zip(tables, found[name], strict=True):
            assert abs(one).max() > 0 and abs(one - other).max() < 1e-8 * max(1, abs(one).max()), name
