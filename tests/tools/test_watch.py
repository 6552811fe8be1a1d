"""python -m tools.watch: what it reads while a run writes, what it says, and when it ends."""
import io
import json
import os
import threading
import time

import pytest

from tests.conftest import run_tool
from tests.synthetic import write_csv
from tools.base.command import BadInput
from tools.watching import show
from tools.watching.progress import ENDED, Growing, Progress

BEGUN = 1_700_000_000.0


def stamp(seconds):
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds))


def info(folder, status="running", **more):
    """Writes run.json of a run to t = 10 that began at BEGUN."""
    parameters = {"-tend": 10, "-restart": more.pop("restart", "")}
    (folder / "run.json").write_text(json.dumps({"case": "made_up", "status": status, "parameters": parameters,
        "units": {"-tend": "s", "-length": "m"}, "start": stamp(BEGUN), "written": stamp(BEGUN), "pid": os.getpid()} | more))


def rows(folder, number, at):
    """fluid.csv with rows at t = 0.1, 0.2, ..., of which the last one was written at BEGUN + at."""
    write_csv(folder / "fluid.csv", ["step", "t", "contacts", "kinetic_energy"], [[10 * k, 0.1 * k, k % 4, k * k] for k in
        range(1, number + 1)])
    os.utime(folder / "fluid.csv", (BEGUN + at, BEGUN + at))


def test_a_table_is_read_as_it_grows(tmp_path):
    table = Growing(tmp_path / "a.csv")
    table.path.write_text("step,t\n1,0.5\n2,0.7")  # the last line is being written
    assert table.read() == 1 and table.rows == {"step": [1], "t": [0.5]}
    with open(table.path, "a") as stream:
        stream.write("5\n3,1\n")
    assert table.read() == 3 and table.rows["t"] == [0.5, 0.75, 1]
    table.path.write_text("step,t\n1,0.5\n")  # cut back: the run goes on from a checkpoint
    assert table.read() == 1 and table.rows["t"] == [0.5]
    with open(table.path, "a") as stream:
        stream.write("1,x\n")
    with pytest.raises(BadInput, match="is no row of 2 numbers"):
        table.read()


def test_a_copy_of_a_finished_run_took_as_long_as_the_run(tmp_path):
    """Times of its files are those of the copy; run.json says when the run ended."""
    info(tmp_path, "finished", wall_s=50.0, written=stamp(BEGUN + 50)), rows(tmp_path, 100, at=1e6)
    seen = Progress(tmp_path).look(now=BEGUN + 2e6)
    assert seen.over and seen.since == pytest.approx(50) and seen.steps_per_second == pytest.approx(1000 / 50)


def test_speed_and_time_left_are_those_of_the_wall_clock(tmp_path):
    info(tmp_path), rows(tmp_path, 20, at=40)
    run = Progress(tmp_path)
    seen = run.look(now=BEGUN + 42)  # 2 of 10 in 40 s: 160 s from the last row on, which is 2 s old
    assert (seen.time, seen.step, seen.over, seen.share) == (2, 200, False, 0.2)
    assert seen.steps_per_second == pytest.approx(5) and seen.left == pytest.approx(158) and seen.since == pytest.approx(42)
    rows(tmp_path, 30, at=50)  # faster since: 1 in 10 s
    seen = run.look(now=BEGUN + 50)
    assert seen.steps_per_second == pytest.approx(10) and seen.left == pytest.approx(70)
    assert Progress(tmp_path).look(now=BEGUN + 50).steps_per_second == pytest.approx(6)


def test_the_speed_of_a_continued_run_is_not_known_from_one_look(tmp_path):
    info(tmp_path, restart="there"), rows(tmp_path, 20, at=40)
    run = Progress(tmp_path)
    assert run.look(now=BEGUN + 40).left is None
    rows(tmp_path, 22, at=44)
    assert run.look(now=BEGUN + 44).left == pytest.approx(156)


def test_a_run_whose_process_is_gone_has_ended(tmp_path):
    rows(tmp_path, 20, at=40)
    info(tmp_path, pid=2**22 + 1)  # more than the numbers of processes go
    os.utime(tmp_path / "run.json", (BEGUN, BEGUN))
    assert not Progress(tmp_path).look(now=BEGUN + 70).over  # what its parent still writes
    seen = Progress(tmp_path).look(now=BEGUN + 101)
    assert (seen.over, seen.status) == (True, ENDED)
    info(tmp_path, pid=2**22 + 1, host="another machine")
    assert not Progress(tmp_path).look(now=BEGUN + 101).over


@pytest.mark.parametrize("status, ends", [("finished", 0), ("failed (4)", 4), ("failed (134)", 134),
    ("killed (signal 9, KILL: by hand)", 137), ("not converged", 4), (ENDED, 1)])
def test_the_exit_status_tells_how_the_run_ended(tmp_path, status, ends):
    info(tmp_path, status), rows(tmp_path, 20, at=40)
    done = run_tool("watch", tmp_path)
    assert done.returncode == ends and done.stdout.startswith(f"made_up: {status}; t = 2 of 10 s (20.0 %); step 200")
    assert "left" not in done.stdout


def test_lines_are_written_until_the_run_ends(tmp_path):
    info(tmp_path), rows(tmp_path, 20, at=40)

    def go_on():
        rows(tmp_path, 100, at=200)
        info(tmp_path, "finished")
    later = threading.Timer(0.3, go_on)
    later.start()
    done = run_tool("watch", tmp_path, "--every", "0.05")
    later.join()
    said = done.stdout.splitlines()
    assert done.returncode == 0 and len(said) in (2, 3) and "\x1b" not in done.stdout
    assert said[0].startswith("made_up: running; t = 2 of") and "contacts 0" in said[0]
    assert said[-1].startswith("made_up: finished; t = 10 of 10 s (100.0 %)")


def test_a_steady_flow_has_a_status_alone(tmp_path):
    info(tmp_path, parameters={"-tolerance": 1e-6})
    done = run_tool("watch", tmp_path, "--once")
    assert done.returncode == 0 and done.stdout.startswith("made_up: running; since the start ")


def test_the_picture_has_progress_and_courses(tmp_path):
    from rich.console import Console
    info(tmp_path), rows(tmp_path, 80, at=40)
    run, text = Progress(tmp_path), io.StringIO()
    seen = run.look(now=BEGUN + 40)
    Console(file=text, width=100).print(show.picture(run, seen))
    said = text.getvalue()
    assert "t = 8" not in said and "8 of 10 s (80.0 %)" in said and "left" in said and "10 s" in said
    assert "kinetic_energy  " + show.marks(run.rows["t"], run.rows["kinetic_energy"]) + "  6400" in said
    text = io.StringIO()
    Console(file=text, width=100).print(show.picture(run, seen, ["step"]))
    assert "step  ▁" in text.getvalue() and "kinetic_energy" not in text.getvalue()


def test_marks_follow_time_and_not_rows():
    assert show.marks([0, 1, 2, 3], [0, 1, 2, 3], 4) == "▁▃▆█"
    assert show.marks([0, 0.1, 0.2, 0.3, 4], [0, 0, 0, 0, 4], 5) == "▁▃▅▇█"  # no rows between
    assert show.marks([0, 1], [2, 2], 3) == "▁▁▁" and show.marks([], [], 3) == "" and show.marks([0, 1], [2, float("nan")], 2) == "▁▁"


def test_durations_are_words():
    assert [show.duration(seconds) for seconds in (None, 0.4, 59.7, 185, 7800, 273600)] == ["not known", "0 s", "1 min 00 s",
        "3 min 05 s", "2 h 10 min", "3 d 4 h"]


@pytest.mark.parametrize("make, said", [(None, "is not a run folder"), ("particles.csv", "has no run.json"),
    ("run.json", "cannot read"), ("columns", "there is no column speed; there are step t contacts kinetic_energy")])
def test_what_cannot_be_watched_is_refused_in_one_line(tmp_path, make, said):
    if make == "columns":
        info(tmp_path), rows(tmp_path, 3, at=4)
    elif make:
        (tmp_path / make).write_text("{")
    done = run_tool("watch", tmp_path, "--once", "--columns", "speed")
    assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1 and said in done.stderr
