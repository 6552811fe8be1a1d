"""What goes wrong outside: full disks, folders that cannot be written, damaged files, nonsense.

Each ends with a status of lib/core/errors.idp and one line on the error stream, and nothing that was
there is lost. FAULT_EXAMPLES sets the number of fuzzed command lines a driver (default 4).
"""
import json
import os
import re
import shutil
import subprocess
import time
from functools import lru_cache

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from tests.conftest import FREEFEM, ROOT, make_mesh, run_freefem, run_limited
from tests.tables import assert_refused, assert_whole_rows

SETTLING = ["cases/settling_disk.edp", "-dt", "0.002", "-tolerance", "1e-4"]
FALLING = ["cases/falling_particles.edp", "-number", "10", "-dt", "0.01", "-every", "0"]
EXAMPLES = int(os.environ.get("FAULT_EXAMPLES", "4"))


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A coarse mesh of the settling disk's box: (path, text)."""
    path = make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "settling_disk", "--size", 0.125)
    return path, path.read_text()


def test_a_full_disk_ends_a_run_with_whole_rows(tmp_path):
    done = run_limited(*FALLING, "-tend", "3", "-out", tmp_path / "run", most=60_000)
    assert_refused(done, (4,), "is the disk full?")
    assert "particles.csv" in done.stderr
    for name in ("particles.csv", "motion.csv"):
        assert_whole_rows(tmp_path / "run" / name)
    assert not (tmp_path / "run" / ".writer").exists()
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "failed (4)"
    # the rows that are there are those of a run with room
    run_freefem(*FALLING, "-tend", "3", "-out", tmp_path / "free")
    cut, free = ((tmp_path / name / "particles.csv").read_text() for name in ("run", "free"))
    assert free.startswith(cut) and len(free) > len(cut) > 50_000


def checkpoints(folder):
    return {path.name: path.read_bytes() for path in folder.glob("restart_*") if path.suffix != ".new"}


def test_a_full_disk_at_a_checkpoint_loses_nothing(box, tmp_path):
    scene = [*SETTLING, "-mesh", box[0], "-checkpoint", "10", "-tend", "0.2"]
    run_freefem(*scene, "-out", tmp_path / "unbroken")
    folder = tmp_path / "run"
    killed = subprocess.Popen([FREEFEM, "-nw", *map(str, scene), "-out", str(folder)], cwd=ROOT, stdout=subprocess.DEVNULL,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"})
    deadline = time.time() + 60
    while not (folder / "restart_000000020.sha").exists():
        assert killed.poll() is None and time.time() < deadline, "the run ended before it could be killed"
        time.sleep(0.002)
    killed.kill()
    killed.wait()
    before = checkpoints(folder)
    done = run_limited(*scene, "-restart", folder, most=max(map(len, before.values())) // 2)
    assert_refused(done, (4,), "cannot write the checkpoint")
    assert checkpoints(folder) == before
    assert json.loads((folder / "run.json").read_text())["status"] == "failed (4)" and not (folder / ".writer").exists()
    run_freefem(*scene, "-restart", folder)
    assert (folder / "particles.csv").read_bytes() == (tmp_path / "unbroken" / "particles.csv").read_bytes()


def test_fields_that_do_not_fit_are_not_left_half_written(box, tmp_path):
    done = run_limited(*SETTLING, "-mesh", box[0], "-tend", "0.01", "-fields", "0.002", "-out", tmp_path / "run", most=len(box[1])
        + 1000)
    assert_refused(done, (4,), "fields_0000000.vtu")
    assert not list((tmp_path / "run").glob("*.vtu"))


def test_a_folder_that_cannot_be_made_or_holds_no_room(box, tmp_path):
    (tmp_path / "file").write_text("mine")
    done = run_limited(*SETTLING, "-mesh", box[0], "-out", tmp_path / "file" / "run")
    assert_refused(done, (3,), "cannot write to the folder")
    done = run_limited(*SETTLING, "-mesh", box[0], "-out", tmp_path / "file")
    assert_refused(done, (3,), "cannot write to the folder")
    assert (tmp_path / "file").read_text() == "mine"
    done = run_limited(*SETTLING, "-mesh", box[0], "-out", tmp_path / "run", most=2000)
    assert_refused(done, (3,), "mesh.mesh")
    assert not (tmp_path / "run" / "mesh.mesh").exists()


def swapped(row):
    a, b, c, label = row.split()
    return f"{b} {a} {c} {label}"


# section of the file, a row in it, what is made of it, and words of the refusal
MESH_FAULTS = {
    "vertex index too large": ("Triangles", lambda row: "1 2 99999 0", "names a vertex which is not there"),
    "vertex index 0": ("Triangles", lambda row: "0 2 3 0", "names a vertex which is not there"),
    "edge of no vertex": ("Edges", lambda row: "1 99999 3", "names a vertex which is not there"),
    "index with a fraction": ("Triangles", lambda row: "1.5 2 3 0", "names a vertex which is not there"),
    "flat triangle": ("Triangles", lambda row: "1 1 2 0", "no area"),
    "clockwise triangle": ("Triangles", swapped, "clockwise"),
    "not a number": ("Vertices", lambda row: "nan 0 3", "not a number"),
    "two points": ("Vertices", lambda row: "1.2.3 0 3", "not a number"),
    "too large": ("Vertices", lambda row: "1e400 0 3", "not a number"),
    "a column less": ("Vertices", lambda row: "1 0", "not a number"),
}


def with_row(text, section, change):
    """The mesh with the sixth row of a section changed."""
    lines = text.splitlines()
    at = next(k for k, row in enumerate(lines) if row.strip() == section) + 7
    lines[at] = change(lines[at])
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("fault", MESH_FAULTS)
def test_a_damaged_mesh_is_refused_in_words(box, fault, reading, tmp_path):
    section, change, says = MESH_FAULTS[fault]
    (tmp_path / "bad.mesh").write_text(with_row(box[1], section, change))
    assert_refused(run_limited(reading, "-mesh", tmp_path / "bad.mesh", "-out", tmp_path / "run"), (3,), says)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("make, says", [
    (lambda text: text[:len(text) // 2], "not a number"),
    (lambda text: text[:text.index("Edges")], "ends too early"),
    (lambda text: "", "not a .mesh file"),
    (lambda text: "# a comment\n" + text, "whose first line is MeshVersionFormatted"),
    (lambda text: text.replace("End", "Quadrilaterals\n1\n1 2 3 4 1\nEnd"), "holds quadrilaterals"),
    (lambda text: "\x00\x01\x02\n" * 100, "no plain text"),
    (lambda text: re.sub(r"^(\d+ \d+) \d+$", r"\1 77", text, flags=re.M), "label 77"),
    (lambda text: re.sub(r"^(\d+ \d+) \d+$", r"\1 0", text, flags=re.M), "label 0"),
], ids=["cut", "no edges", "empty", "comment first", "quadrilaterals", "binary", "unknown labels", "no labels"])
def test_a_truncated_or_unlabelled_mesh_is_refused(box, make, says, reading, tmp_path):
    (tmp_path / "bad.mesh").write_text(make(box[1]))
    script = SETTLING if says.startswith("label") else [reading]  # a label needs a condition of the case
    assert_refused(run_limited(*script, "-mesh", tmp_path / "bad.mesh", "-out", tmp_path / "run"), (3,), says)


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(place=st.floats(0, 1, exclude_max=True), what=st.sampled_from(["", " ", "9", "-", "\n", "e", "x", "\x00"]))
def test_any_letter_of_a_mesh_may_be_wrong(box, place, what, tmp_path_factory):
    folder = tmp_path_factory.mktemp("letter")
    at = int(place * len(box[1]))
    (folder / "bad.mesh").write_text(box[1][:at] + what + box[1][at + 1:])
    done = run_limited(*SETTLING, "-mesh", folder / "bad.mesh", "-tend", "0.002", "-out", folder / "run")
    if done.returncode:
        assert_refused(done, (3, 4, 5))


@pytest.mark.parametrize("right, wrong, says", [
    ("\n473 474 491 0\n", "\n473 44 491 0\n", "do not fit together"),
    ("\n1 2 3\n2 3 3\n", "\n1 3 3\n2 3 3\n", "do not fit together"),
    ("\n1 2 3\n2 3 3\n", "\n1 2 3\n2 3 3\n1 40 3\n", "no side of a triangle"),
], ids=["corner", "side without a label", "edge across"])
def test_a_mesh_that_does_not_fit_together_is_refused(box, right, wrong, says, reading, tmp_path):
    text = box[1].replace(right, wrong)
    assert text != box[1]
    if says.startswith("no side"):
        text = text.replace("Edges\n128\n", "Edges\n129\n")
    (tmp_path / "bad.mesh").write_text(text)
    assert_refused(run_limited(reading, "-mesh", tmp_path / "bad.mesh", "-out", tmp_path / "run"), (3,), says)


def test_a_file_name_never_reaches_the_shell_unread(tmp_path):
    for option in ("-bodies", "-walls"):
        assert_refused(run_limited("scripts/project_velocities.edp", option, "'|", "-out", tmp_path / "out.csv"), (3,),
            "contains characters other than")


@pytest.mark.parametrize("text, says", [
    ("id,x,y,radius,density\n0,nan,4,0.125,1.25\n", "missing or bad number"),
    ("id,x,y,radius,density\n0,1,4,inf,1.25\n", "missing or bad number"),
    ("id,x,y,radius,density\n0,1,4,-0.1,1.25\n", "radius"),
    ("id,x,y,radius,density\n0,1,4,0.1,0\n", "density"),
    ("id,x,y,radius,density\n0,1,4,0.1\n", "missing or bad number"),
    ("id,x,y,radius,density\n0.5,0.3,1,0.1,2\n", "whole number"),
    ("id,x,y,radius,density,u,v,omega\n5,0.3,1,0.1,2,1e400,0,0\n", "missing or bad number"),
    ("\x00\x00", "no plain text"),
    ("", "first line"),
], ids=["nan", "inf", "radius", "density", "short row", "id", "velocity", "binary", "empty"])
def test_a_damaged_file_of_particles_is_refused(text, says, reading, tmp_path):
    (tmp_path / "bad.csv").write_text(text)
    assert_refused(run_limited(reading, "-particles", tmp_path / "bad.csv", "-out", tmp_path / "run"), (3,), says)


def test_a_field_that_is_not_finite_stops_the_run(box, tmp_path):
    text = (ROOT / SETTLING[0]).read_text()
    hook = "macro caseStart() flowU[5] = sqrt(-1. - flowNw); // EOM\n"
    script = tmp_path / "nan.edp"
    script.write_text(text.replace('include "scripts/resolved.edp"', hook + 'include "scripts/resolved.edp"'))
    assert_refused(run_limited(script, *SETTLING[1:], "-mesh", box[0], "-out", tmp_path / "run"), (4,))


def test_a_run_whose_checkpoints_are_all_damaged_is_left_alone(box, tmp_path):
    scene, folder = [*SETTLING, "-mesh", box[0], "-checkpoint", "2", "-tend", "0.012"], tmp_path / "run"
    run_freefem(*scene, "-out", folder)
    for path in folder.glob("restart_*.txt"):
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 0x15
        path.write_bytes(bytes(data))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert_refused(run_limited(*scene, "-restart", folder), (3,), "no complete checkpoint")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("driver", ["resolved", "flow", "contacts", "transport"])
def test_more_steps_than_can_be_done_are_refused(box, driver, tmp_path):
    words = [*DRIVERS[driver], *(["-mesh", box[0]] if driver == "resolved" else [])]
    at = words.index("-dt") if "-dt" in words else len(words)
    assert_refused(run_limited(*words[:at], *words[at + 2:], "-dt", "1e-90", "-out", tmp_path / "run"), (3,), "more than 1e9")


# Every option of every driver, with values of the wrong kind and size.
DRIVERS = {
    "resolved": [*SETTLING, "-tend", "0.004", "-maxwall", "5"],
    "flow": ["cases/poiseuille.edp", "-tend", "0.05"],
    "contacts": [*FALLING, "-tend", "0.05"],
    "transport": ["tests/transport/scripts/analytic.edp", "-tend", "0.02"],
    "steady laminar": ["cases/cavity.edp", "-reynolds", "10"],
    "steady": ["cases/pipe_flow.edp", "-model", "laminar", "-reynolds", "5"],
    "projection": ["scripts/project_velocities.edp"],
}
NONSENSE = st.one_of(
    st.sampled_from(["", "abc", "nan", "-inf", "1e", "0", "-1", "0.5", "1e300", "-1e300", "1e-300", "1e99", "9" * 30, "1,5",
        "0x10", "/", "/dev/null",
                     "/nonexistent/x", ".", "a b", "$(id)", "'", ";true", "é", "-dt", "--help", "|", "x" * 5000]),
    st.floats(allow_nan=False, width=32).map(repr), st.integers(-10**6, 10**6).map(str),
        st.text(st.characters(codec="ascii", min_codepoint=32), max_size=8))
ABANDONED = 20  # s; a command line that was accepted and asks for more work than that is no fault


@lru_cache(None)
def options_of(driver):
    """The names that -help lists."""
    text = run_freefem(DRIVERS[driver][0], "-help").stdout
    return re.findall(r"^  (-[A-Za-z][\w-]*) ", text, flags=re.M)


def check_nonsense(driver, data, box, folder):
    names = options_of(driver)
    option, value = data.draw(st.sampled_from([name for name in names if name not in ("-help", "-out",
        "-overwrite")])), data.draw(NONSENSE)
    words = list(DRIVERS[driver])
    if driver == "resolved" and option != "-mesh":
        words += ["-mesh", str(box[0])]
    if option in words:
        at = words.index(option)
        del words[at:at + 2]
    folder.mkdir(exist_ok=True)
    kept = folder / "kept.txt"
    kept.write_text("mine")
    target = ["-out", str(folder / ("projected.csv" if driver == "projection" else "run"))]
    shutil.rmtree(folder / "run", ignore_errors=True)
    try:
        done = run_limited(*words, option, value, *target, timeout=ABANDONED)
    except subprocess.TimeoutExpired as stopped:
        assert b"writing to" in (stopped.stdout or b""), f"{option} {value!r}: neither accepted nor refused"
        return
    assert kept.read_text() == "mine"
    if "named above" in done.stderr:  # disks that overlap are listed, with a line that counts them
        assert done.returncode in (3, 5) and all(line.startswith("error: ") for line in done.stderr.splitlines()), done.stderr
    elif done.returncode:
        assert_refused(done, (3, 4, 5))


def fuzz(examples):
    return lambda test: settings(max_examples=examples, deadline=None, derandomize=examples < 20, database=None,
        suppress_health_check=list(HealthCheck))(
        given(data=st.data())(test))


@pytest.mark.parametrize("driver", DRIVERS)
@fuzz(EXAMPLES)
def test_nonsense_for_any_option_ends_in_one_line(box, driver, tmp_path_factory, data):
    check_nonsense(driver, data, box, tmp_path_factory.getbasetemp() / "nonsense")


@pytest.mark.slow
@pytest.mark.parametrize("driver", DRIVERS)
@fuzz(60)
def test_more_nonsense(box, driver, tmp_path_factory, data):
    check_nonsense(driver, data, box, tmp_path_factory.getbasetemp() / "more_nonsense")
