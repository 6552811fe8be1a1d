"""tools.run: the sentence on a case that does not compile names what is wrong, and the line of the case."""
import subprocess
from pathlib import Path

import pytest

from tests.conftest import FREEFEM, ROOT
from tests.lint import files
from tests.tools.mistakes import KEPT_APART, MISTAKES, STRANGER, mutated, place
from tools.compile_errors import explain, lexer, message, project
from tools.compile_errors.names import declared



def told(text, tmp_path):
    """The sentence on a script of this text."""
    case = tmp_path / "my.edp"
    case.write_text(text)
    run = subprocess.run([FREEFEM, "-nw", *explain.COMPILE, str(case)], cwd=ROOT, capture_output=True, text=True, errors="replace",
        timeout=60)
    return explain.sentence(case, "my.edp", run.stdout) if run.returncode else explain.before_run(case, "my.edp")


def named(rows):
    """The rows of a table, each a test."""
    return pytest.mark.parametrize("case, old, new, word, where", rows, ids=[f"{row[0]}-{number}" for number,
        row in enumerate(rows)])


@named(KEPT_APART)
def test_a_mistake_is_named(case, old, new, word, where, tmp_path):
    text, changed = mutated((ROOT / f"cases/{case}.edp").read_text(), old, new)
    said, line = told(text, tmp_path), place(text, changed, where)
    assert said and said.startswith("my.edp") and "\n" not in said and word in said, said
    assert line is None or f"line {line}" in said, (line, said)


@pytest.mark.slow
@named(MISTAKES)
def test_a_mistake_that_the_sentences_were_written_for_is_named(case, old, new, word, where, tmp_path):
    test_a_mistake_is_named(case, old, new, word, where, tmp_path)


@pytest.mark.slow
@named(STRANGER)
def test_a_mistake_of_another_language_is_named(case, old, new, word, where, tmp_path):
    test_a_mistake_is_named(case, old, new, word, where, tmp_path)


# A macro of each of these closes the block that it stands in.
@pytest.mark.parametrize("path", [path for path in files(".edp") + files(".idp")
    if path not in ("lib/core/ranks.idp", "lib/flow/parts_mpi.idp", "lib/spheres/parts_mpi.idp")])
def test_nothing_is_amiss_in_the_scripts_of_the_project(path):
    assert not lexer.read((ROOT / path).read_text()).faults


@pytest.mark.parametrize("path", project.cases())
def test_a_case_that_is_right_is_not_refused(path):
    assert explain.before_run(ROOT / path, path) is None


def test_a_mistake_in_a_file_of_the_users_own_is_placed_there(tmp_path):
    (tmp_path / "mine.idp").write_text("real deep = 2;\nreal half = depe/2;\n")
    text = (ROOT / "cases/template.edp").read_text().replace("real diameter", 'include "mine.idp"\nreal diameter')
    assert told(text, tmp_path) == "mine.idp line 2: depe does not exist; is deep (line 1) meant?"


@pytest.mark.parametrize("change, line", [(lambda text: text.replace("\n", "\r\n"), 21), (lambda text: "\ufeff" + text, 1)])
def test_line_ends_and_marks_of_other_systems(change, line, tmp_path):
    text = (ROOT / "cases/template.edp").read_text().replace("real mu = ", "real mu = rhofluid*")
    (tmp_path / "my.edp").write_bytes(change(text).encode())
    run = subprocess.run([FREEFEM, "-nw", *explain.COMPILE, str(tmp_path / "my.edp")], cwd=ROOT, capture_output=True, text=True,
        errors="replace")
    said = explain.sentence(tmp_path / "my.edp", "my.edp", run.stdout)
    assert f"line {line}: " in said and ("rhofluid" in said if line > 1 else "U+FEFF" in said), said


def test_a_macro_is_read_up_to_the_next_two_slashes():
    script = lexer.read('macro one(a, b) (a + "x" + b) // EOM\nreal c = 1; // macro none() 3\nmacro two() {\n    c = 2; /* so '
        '*/\n} // EOM\nc = 3;')
    assert [(macro.name, macro.parameters, macro.line, macro.last) for macro in script.macros] == [("one", ["a", "b"], 1, 1),
        ("two", [], 3, 5)]
    assert [token.text for token in script.tokens] == ["real", "c", "=", "1", ";", "c", "=", "3", ";"] and not script.faults


def test_declarations_are_read_with_their_kinds():
    text = "int[int] a = [1, 2], b(3); func real f(real t, real[int, int] & m) { real inner = 2; } Vh [u, v] = [x, y]; real[int] c; for (int k = 0; ;) {}"
    found = {one.name: (one.kind, one.depth, one.parameters) for one in declared(lexer.read(text).tokens, ["Vh"])}
    assert found["a"] == found["b"] == ("int[int]", 0, None) and found["f"] == ("func real", 0, ("real t", "real[int, int] & m"))
    assert found["inner"] == ("real", 1, None) and found["u"] == found["v"] == ("Vh", 0,
        None) and found["c"][0] == "real[int]" and found["k"][1] == 1


def test_a_message_is_taken_apart():
    said = message.read("error operator (  <c>, <Pd>\n List of choices \n\t (\t  <l> :   <NSt7__cxx1112basic_string>, <P2KNIdE> "
        ")\n\n"
                        " Error line number 36, in file  macro: caseParticles in a b.edp, before  token )\n\n  current line = "
                            "36\nCompile error : \n")
    assert (said.kind, said.name, said.file, said.line, said.token, said.macro) == ("operator", "(", "a b.edp", 36, ")",
        "caseParticles")
    assert said.given == [message.TEXT, message.REAL] and said.choices == [[message.TEXT, "a real[int]"]]


@pytest.mark.parametrize("first, second, away", [("mu", "mu", 0), ("rhofluid", "rhoFluid", 0.5), ("caseParticels", "caseParticles",
    1), ("size", "sizes", 1), ("abc", "xyz", 3)])
def test_distance_of_words(first, second, away):
    assert project.distance(first, second) == project.distance(second, first) == away


def test_what_a_driver_needs_is_read_from_its_cases():
    assert {"rhoFluid", "mu", "flowNoSlip", "boundaryRamp", "caseParticles",
        "motionBound"} <= project.always("scripts/resolved.edp")
    assert {Path(path).stem for path in project.drivers()} == {"contacts", "contact_spheres", "flow", "project_spheres",
        "project_velocities", "resolved", "spheres", "steady", "steady_laminar", "transport"}
