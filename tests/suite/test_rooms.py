"""The rooms of lib/: none uses a room above it, no files use each other in a circle, and headers say which other files write a
variable."""
from functools import lru_cache

import pytest

from tests.rooms import PAGE, Library, functions, filled, room, rooms, texts, written, written_by, written_line
from tools.compile_errors.names import FORBIDDEN

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


def test_no_global_hides_a_word_of_the_language():
    """FreeFEM would use these instead of its own (tests/suite/test_setup.py: the scripts that stand elsewhere)."""
    assert {path: names & FORBIDDEN for path, names in library().outer.items() if names & FORBIDDEN} == {}


@pytest.mark.parametrize("path", FILES)
def test_a_header_says_which_other_files_write_its_variables(path):
    """"Written by: lib/room/file.idp (names), ..." names them all, and none besides."""
    assert written_by(TEXTS[path]) == writers()[path], "the header needs:\n" + written_line(writers()[path])


def with_line(path, line):
    return with_lines({path: line})


def with_lines(lines):
    """The library with lines put into files, {path: line}, after their guards."""
    given = dict(TEXTS)
    for path, line in lines.items():
        at = given[path].index("// EOM\n") + len("// EOM\n")
        given[path] = given[path][:at] + line + "\n" + given[path][at:]
    return Library(given)


def test_what_points_upwards_is_found():
    """All in one library: to read one takes seconds."""
    given = {
        "lib/core/arrays.idp": ('include "lib/mesh/triangles.idp"', "include"),
        "lib/immersed/bins.idp": ('include "lib/scheme/state.idp"', "include"),
        "lib/flow/convection.idp": ("real[int] old = bodyQ, more = pressurePsi;", "pressurePsi"),
        "lib/mesh/triangles.idp": ("func int triangleStop() { flowMeasure(); return 0; }", "flowMeasure"),
        "lib/contact/search.idp": ("if (bodyRound) contactNearN = 0;", "bodyRound"),
    }
    found = with_lines({path: line for path, (line, _) in given.items()}).upward(FLOORS)
    assert sorted((file, name) for file, name, _ in found) == sorted((path, what) for path, (_, what) in given.items())


def test_names_of_a_file_s_own_are_no_use_of_a_higher_room():
    line = "func int mine(real[int] & pressurePsi) { real flowTop = pressurePsi.max; return flowTop > 0; } // bodyQ\nstring words = \"bodyQ\";"
    assert with_line("lib/core/arrays.idp", line).upward(FLOORS) == []


def test_what_a_file_uses_without_its_include_is_found():
    assert with_line("lib/mesh/quadrature.idp", "cellsSetUp();").unreached() == [("lib/mesh/quadrature.idp", "cellsSetUp")]


def test_a_circle_is_found():
    assert with_line("lib/scheme/poisson.idp", "real again = pressureEnergy;").circles() != []
    assert ("lib/contact/faults.idp", "lib/contact/inside.idp") in with_line("lib/contact/faults.idp",
        "func int again(real[int] & a, int[int] & n) { return contactInside(a, a, n); }").circles()


def test_what_writes_a_variable_is_found():
    lines = {"flowU = 0.;": "flowU", "flowV(list) += 1;": "flowV", "flowX[0]++;": "flowX", "flowP.resize(3) = 1.;": "flowP",
        "bodySort(bodyX, flowNw);": "bodyX", "file >> flowDataU;": "flowDataU", "[I, J, flowH] = A;": "flowH"}
    sort = "func int bodySort(real[int] & a, int n) { for (int k = 0; k < n; ++k) a[k] = k; }\n"
    found = with_line("lib/record/fields.idp", sort + "\n".join(lines)).writers()
    fresh = {file: names for owner, others in found.items() for file, names in others.items() if names - writers()[owner].get(file,
        set())}
    assert set(fresh) == {"lib/record/fields.idp"}
    assert {name for owner, others in found.items() for name in others.get("lib/record/fields.idp", ())} >= set(lines.values())
    assert "flowNw" not in {name for others in found.values() for name in others.get("lib/record/fields.idp", ())}


def test_what_only_reads_a_variable_is_no_writer():
    text = "func int look(real[int] & a, real b) { real c = a[0]; return c == b; } look(flowU, flowP); if (flowU[0] == 1) flowV[1] >= 2; cout << flowX << endl;"
    assert written(text, filled(functions(text))) == {"c"}


def test_the_line_of_a_header_is_read_as_it_is_written():
    others = {f"lib/room{k}/file.idp": {f"someLongName{i}" for i in range(7)} for k in range(3)}
    assert written_by("// Needs: nothing.\n" + written_line(others) + "\n// Exit codes: none.\nIFMACRO(!a)\n") == others
    assert max(map(len, written_line(others).splitlines())) <= 132
