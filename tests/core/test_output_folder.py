"""The folder of a run: one run at a time, only its own files, and how it ended, whatever ended it."""
import json
import os
import re
import shutil
import signal
import subprocess
import time

import pytest

from tests.conftest import FREEFEM, ROOT, eventually, run_freefem, run_limited as run
from tests.tables import assert_refused, assert_whole_rows

FALLING = ["cases/falling_particles.edp", "-number", 5, "-every", 0]
PAIRS = int(os.environ.get("RUN_PAIRS", "4"))
KILLS = int(os.environ.get("RUN_KILLS", "4"))


def status(folder):
    return json.loads((folder / "run.json").read_text())["status"]


@pytest.mark.parametrize("pair", range(PAIRS))
def test_of_two_runs_that_start_at_once_one_has_the_folder(pair, tmp_path, monkeypatch):
    """Both wrote, in 8 of 36 pairs: rows stood twice, run.json was broken. RUN_PAIRS sets the number of pairs."""
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    command = [FREEFEM, "-nw", *map(str, FALLING), "-tend", "0.4", "-out", str(tmp_path / "run"), *(["-overwrite", "1"]
        if pair % 2 else [])]
    started = []
    for _ in range(2):
        started.append(subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        time.sleep(0.005 * (pair % 5))
    ended = [(one.communicate(timeout=60)[1], one.returncode) for one in started]
    won = [code for _, code in ended if code == 0]
    if pair % 2 == 0 or len(won) == 1:  # with -overwrite 1 the second may begin when the first has ended
        assert len(won) == 1, ended
        assert [line for line, code in ended if code][0].startswith("error: ") and sorted(code for _, code in ended) == [0, 3]
    assert status(tmp_path / "run") == "finished"
    times = [row.split(",")[0] for row in (tmp_path / "run/motion.csv").read_text().splitlines()]
    assert len(times) == len(set(times)) and times[0] in ("t", "step")


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A run with checkpoints that has ended."""
    folder = tmp_path_factory.mktemp("ended") / "run"
    run_freefem(*FALLING, "-tend", 0.2, "-checkpoint", 3, "-out", folder)
    return folder


@pytest.mark.parametrize("how", ["-restart", "-overwrite"])
def test_files_of_others_in_the_folder_stay_as_they_are(how, ended, tmp_path):
    """Rows of a user's own table were dropped, and every *.csv deleted."""
    folder = tmp_path / "run"
    shutil.copytree(ended, folder)
    mine = {"measured.csv": "t,a\n0.1,1\n99,2\n5\n", "fields.png": "mine", "film.mp4": "mine", "results.csv": "name,value\nx,99\n",
        "fields_0000001.vtu": "mine",
            "notes.txt": "99\n", "motion.csv.old": "1", "summary.csv": "t\n99\n"}
    for name, text in mine.items():
        (folder / name).write_text(text)
    words = ["-restart", folder, "-tend", 0.3, "-checkpoint", 3] if how == "-restart" else ["-out", folder, "-overwrite", 1,
        "-tend", 0.1]
    run_freefem(*FALLING, *words)
    assert {name: (folder / name).read_text() for name in mine} == mine
    listed = (folder / ".files").read_text().split()
    there = {path.name for path in folder.iterdir()} - set(mine) - {".files", ".start"}
    assert there <= set(listed)


def test_a_continued_run_is_as_one_without_a_break(ended, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(ended, folder)
    run_freefem(*FALLING, "-tend", 0.4, "-checkpoint", 3, "-restart", folder)
    run_freefem(*FALLING, "-tend", 0.4, "-checkpoint", 3, "-out", tmp_path / "whole")
    assert (folder / "particles.csv").read_bytes() == (tmp_path / "whole/particles.csv").read_bytes()


def test_a_run_does_not_go_on_in_a_table_of_other_columns(ended, tmp_path):
    """As one that an earlier version wrote: rows of two widths stood under one header."""
    folder = tmp_path / "run"
    shutil.copytree(ended, folder)
    text = (folder / "motion.csv").read_text()
    (folder / "motion.csv").write_text(text.replace("step,t,", "step,t,mine,", 1))
    assert_refused(run(*FALLING, "-tend", 0.4, "-restart", folder), (3,), "motion.csv has other columns than this run writes")
    run_freefem(*FALLING, "-tend", 0.3, "-restart", folder, "-out", tmp_path / "new")


def test_a_run_without_a_list_of_its_files_is_not_replaced(ended, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(ended, folder)
    (folder / ".files").unlink()
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert_refused(run(*FALLING, "-tend", 0.1, "-out", folder, "-overwrite", 1), (3,), "keeps no list of its files")
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def started(folder, *words):
    """A run under way that has written a checkpoint. What is started in the background of a script ignores SIGINT; the run
    does not."""
    process = subprocess.Popen([FREEFEM, "-nw", *map(str, words), "-out", str(folder)], cwd=ROOT, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, start_new_session=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert eventually(lambda: list(folder.glob("restart_*.sha")), 30)
    return process


LONG = ["cases/falling_particles.edp", "-number", 20, "-every", 0, "-tend", 2000, "-checkpoint", 5]


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGHUP", "SIGXCPU", "SIGKILL", "SIGSEGV"])
def test_a_signal_is_told(name, tmp_path):
    """The status was "running" for ever. Where the parent asks first for the exit status, the signal's name is lost, not that the
    run was ended."""
    process = started(tmp_path / "run", *LONG)
    # Ctrl-C goes to all that the terminal runs; in the instant in which a command is started FreeFEM does not hear it: once more
    for _ in range(5 if name == "SIGINT" else 1):
        (os.killpg if name == "SIGINT" else os.kill)(process.pid, getattr(signal, name))
        if eventually(lambda: process.poll() is not None, 4 if name == "SIGINT" else 20):
            break
    process.wait(timeout=1)
    assert eventually(lambda: status(tmp_path / "run") != "running")
    assert re.fullmatch(rf"killed \(signal ({int(getattr(signal, name))}, {name[3:]}|15, TERM).*\)|ended without a word "
        rf"\(killed, out of memory or crashed\)", status(tmp_path / "run"))


@pytest.mark.parametrize("kill", range(KILLS))
def test_a_killed_run_continues(kill, tmp_path):
    """Killed at any moment, with its whole group or alone. RUN_KILLS sets the number of kills."""
    process = started(tmp_path / "run", *LONG)
    time.sleep(0.37 * kill % 0.5)
    (os.killpg if kill % 2 else os.kill)(process.pid, signal.SIGKILL if kill % 3 else signal.SIGTERM)
    process.wait(timeout=20)
    assert eventually(lambda: status(tmp_path / "run") != "running")
    last = max(int(path.stem.split("_")[1]) for path in (tmp_path / "run").glob("restart_*.sha"))
    step = json.loads((tmp_path / "run/run.json").read_text())["parameters"]["-dt"]
    words = [(last + 5) * step if word == 2000 else word for word in LONG]
    run_freefem(*words, "-restart", tmp_path / "run")
    assert status(tmp_path / "run") == "finished"
    for path in (tmp_path / "run").glob("*.csv"):
        if len(path.read_text().splitlines()) > 1:
            assert_whole_rows(path)


def test_a_run_whose_watcher_was_killed_too_is_told_of(ended, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(ended, folder)
    (folder / "run.json").write_text((folder / "run.json").read_text().replace('"finished"', '"running"'))
    assert_refused(run(*FALLING, "-tend", 0.1, "-out", folder), (3,), "already contains a run, which ended without a word")
    assert "warning: the run in" in run_freefem(*FALLING, "-tend", 0.3, "-checkpoint", 3, "-restart", folder).stdout


def test_no_scratch_folder_is_left(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path / "scratch"))
    (tmp_path / "scratch").mkdir()
    run_freefem(*FALLING, "-tend", 0.1, "-out", tmp_path / "run")
    run_freefem(*FALLING, "-help")
    assert run(*FALLING, "-tend", "x").returncode == 3
    process = started(tmp_path / "killed", *LONG)
    process.kill()
    process.wait()
    assert eventually(lambda: not list((tmp_path / "scratch").iterdir()))
