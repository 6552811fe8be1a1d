"""The rooms of lib/: none uses a room above it, no files use each other in a circle, and headers say which other files write a
variable."""
from functools import lru_cache

import pytest

from tests.rooms import PAGE, Library, functions, filled, room, rooms, texts, written, written_by, written_line

FLOORS = rooms(PAGE.read_text())
TEXTS = texts()
FILES = [path for path in TEXTS if path.startswith("lib/")]


@lru_cache(maxsize=None)
def library():
    """Read where a test needs it: it takes longer than to collect the tests."""
    return Library(TEXTS)


@lru_cache(maxsize=None)
def writers():
    return library().writers()


def with_line(path, line):
    """The library with a line put into a file, after its guard."""
    text = TEXTS[path]
    at = text.index("// EOM\n") + len("// EOM\n")
    return Library(TEXTS | {path: text[:at] + line + "\n" + text[at:]})


def test_the_table_of_rooms_names_the_folders_of_lib():
    assert FLOORS[0] == "core" and len(FLOORS) == len(set(FLOORS))
    assert set(FLOORS) == {room(path) for path in library().files} - {""}


def test_every_file_of_lib_stands_in_a_room():
    assert [path for path in library().files if room(path) not in FLOORS] == []


def test_no_file_uses_a_room_above_its_own():
    assert library().upward(FLOORS) == []


def test_no_files_use_each_other_in_a_circle():
    assert library().circles() == []


def test_a_file_includes_or_says_that_it_needs_what_it_uses():
    assert library().unreached() == []


@pytest.mark.parametrize("path", FILES)
def test_a_header_says_which_other_files_write_its_variables(path):
    """"Written by: lib/room/file.idp (names), ..." names them all, and none besides."""
    assert written_by(TEXTS[path]) == writers()[path], "the header needs:\n" + written_line(writers()[path])


@pytest.mark.parametrize("path, line, what", [
    ("lib/core/arrays.idp", 'include "lib/mesh/triangles.idp"', "include"),
    ("lib/immersed/bins.idp", 'include "lib/scheme/state.idp"', "include"),
    ("lib/flow/convection.idp", "real[int] old = bodyQ, more = pressurePsi;", "pressurePsi"),
    ("lib/mesh/triangles.idp", "func int triangleStop() { flowMeasure(); return 0; }", "flowMeasure"),
    ("lib/contact/search.idp", "if (bodyRound) contactNearN = 0;", "bodyRound"),
])
def test_what_points_upwards_is_found(path, line, what):
    assert [(file, name) for file, name, _ in with_line(path, line).upward(FLOORS)] == [(path, what)]


def test_names_of_a_file_s_own_are_no_use_of_a_higher_room():
    line = "func int mine(real[int] & pressurePsi) { real flowTop = pressurePsi.max; return flowTop > 0; } // bodyQ\nstring words = \"bodyQ\";"
    assert with_line("lib/core/arrays.idp", line).upward(FLOORS) == []


def test_what_a_file_uses_without_its_include_is_found():
    assert with_line("lib/mesh/quadrature.idp", "cellsSetUp();").unreached() == [("lib/mesh/quadrature.idp", "cellsSetUp")]


def test_a_circle_is_found():
    assert with_line("lib/scheme/poisson.idp", "real again = pressureEnergy;").circles() != []
    assert ("lib/contact/faults.idp", "lib/contact/inside.idp") in with_line("lib/contact/faults.idp",
        "func int again(real[int] & a, int[int] & n) { return contactInside(a, a, n); }").circles()


@pytest.mark.parametrize("line, name", [
    ("flowU = 0.;", "flowU"), ("flowU(list) += 1;", "flowU"), ("flowX[0]++;", "flowX"), ("flowP.resize(3) = 1.;", "flowP"),
    ("bodySort(bodyX, flowNw);", "bodyX"), ("file >> flowDataU;", "flowDataU"), ("[I, J, flowH] = A;", "flowH"),
])
def test_what_writes_a_variable_is_found(line, name):
    found = with_line("lib/record/fields.idp", "func int bodySort(real[int] & a, int n) { for (int k = 0; k < n; ++k) a[k] = k; "
        "}\n" + line).writers()
    fresh = {file: names for owner, others in found.items() for file, names in others.items() if names - writers()[owner].get(file,
        set())}
    assert list(fresh) == ["lib/record/fields.idp"] and name in fresh["lib/record/fields.idp"]


def test_what_only_reads_a_variable_is_no_writer():
    text = "func int look(real[int] & a, real b) { real c = a[0]; return c == b; } look(flowU, flowP); if (flowU[0] == 1) flowV[1] >= 2; cout << flowX << endl;"
    assert written(text, filled(functions(text))) == {"c"}


def test_the_line_of_a_header_is_read_as_it_is_written():
    others = {f"lib/room{k}/file.idp": {f"someLongName{i}" for i in range(7)} for k in range(3)}
    assert written_by("// Needs: nothing.\n" + written_line(others) + "\n// Exit codes: none.\nIFMACRO(!a)\n") == others
    assert max(map(len, written_line(others).splitlines())) <= 132
