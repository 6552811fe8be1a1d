"""The rooms of tools/: which may use which, and a command for each tool."""
import ast

import pytest

from tests.conftest import ROOT, run_tool

# A room uses those on the floors before its own; the modules directly in tools/ and the room mesh are commands, which nothing
# imports.
FLOORS = (["base"], ["plot", "meshing", "setup", "compile_errors", "docs", "watching"], ["study", "transport", "flow", "many"],
    ["peers"], ["validation", "stress"], ["bench"])
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
COMMANDS = sorted([path.stem for path in (ROOT / "tools").glob("*.py") if path.stem != "__init__"] + [path.parent.name
    for path in (ROOT / "tools").glob("*/__main__.py")])


def imported(text):
    """The modules of tools that a module imports, anywhere in it."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("tools."))
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "tools." + "." * node.level  # where it leads to depends on the file: not used here
            elif node.module == "tools":
                yield from (f"tools.{name.name}" for name in node.names)
            elif (node.module or "").startswith("tools."):
                yield node.module


def upward(room, text):
    """What a module of a room imports though it may not."""
    return [name for name in imported(text) if name.split(".")[1] != room and FLOOR.get(name.split(".")[1],
        len(FLOORS)) >= FLOOR[room]]


@pytest.mark.parametrize("text, found", [
    ("from tools.bench.rounds import Job", ["tools.bench.rounds"]),
    ("def late():\n    from tools import stress", ["tools.stress"]),
    ("import tools.validate as door", ["tools.validate"]),
    ("from .. import bench", ["tools..."]),
    ("from tools.validation.main import validate\nfrom tools.base.command import ROOT\nfrom tools import peers\nimport numpy", []),
])
def test_an_arrow_upwards_is_seen(text, found):
    assert upward("validation", text) == found


def test_no_room_of_the_tools_uses_one_of_its_own_floor_or_above():
    found, rooms = {}, set()
    for path in sorted((ROOT / "tools").glob("*/**/*.py")):
        room = path.relative_to(ROOT / "tools").parts[0]
        if room == "mesh":
            continue
        rooms.add(room)
        assert room in FLOOR, f"tools/{room} stands on no floor: FLOORS above says which rooms it may use"
        if names := upward(room, path.read_text()):
            found[str(path.relative_to(ROOT))] = names
    assert found == {} and rooms == set(FLOOR)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_of_the_tools_has_help(name):
    done = run_tool(name, "--help")
    assert done.returncode == 0 and f"python -m tools.{name}" in done.stdout, done.stderr
