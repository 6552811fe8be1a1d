"""What the tests share: running FreeFEM scripts from the root of the project."""
import contextlib
import importlib
import io
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.scenes import CHANNEL, READING
from tools.base.command import guarded
from tools.base.mesh_files import read_mesh

ROOT = Path(__file__).resolve().parent.parent
FREEFEM = os.environ.get("FREEFEM", "FreeFem++")
SLOW_ROWS = {line for line in (Path(__file__).parent / "slow_rows.txt").read_text().splitlines() if not line.startswith("#")}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Marks the rows of tests/slow_rows.txt as slow."""
    for item in items:
        if item.nodeid in SLOW_ROWS:
            item.add_marker(pytest.mark.slow)


def standard_alone(text):
    """A resolved case's text with the standard scheme's part of the driver only: what a test asks of that scheme the published one
    does not have."""
    driver = (ROOT / "scripts/resolved.edp").read_text().split('if (scheme == "published" || ')[0]
    return text.replace('include "scripts/resolved.edp"', driver)


def run_freefem(script, *args, check=True, timeout=300):
    """Runs FreeFem++ -nw SCRIPT ARGS in the root, with one BLAS thread.

    script: a path, absolute or from the root. Returns the CompletedProcess, its output as
    text. check: fail the test, with the output, when the exit status is not 0. timeout: s.
    """
    command = [FREEFEM, "-nw", str(script), *map(str, args)]
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, errors="replace", timeout=timeout
    )
    if check and run.returncode != 0:
        pytest.fail(f"{' '.join(command)}\nended with status {run.returncode}\n{run.stdout[-3000:]}\n{run.stderr[-3000:]}")
    return run


def eventually(question, limit=5):
    """Whether it becomes true within so many seconds."""
    end = time.monotonic() + limit
    while not question() and time.monotonic() < end:
        time.sleep(0.01)
    return question()


def run_tool(name, *words):
    """What python -m tools.NAME WORDS does in the root, in this process: the interpreter and its imports take a second. Returns a
    CompletedProcess."""
    module = importlib.import_module(f"tools.{name}")
    if hasattr(module, "__path__"):  # a package
        module = importlib.import_module(f"tools.{name}.__main__")
    said, errors, status = io.StringIO(), io.StringIO(), 0
    before = os.getcwd(), sys.argv, {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    os.chdir(ROOT)
    sys.argv = [name, *map(str, words)]
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(errors):
            guarded(module.main)
    except SystemExit as end:
        status = end.code or 0
    finally:
        os.chdir(before[0])
        sys.argv = before[1]
        for number, answer in before[2].items():
            signal.signal(number, answer)
    return subprocess.CompletedProcess([name, *words], status, said.getvalue(), errors.getvalue())


def make_mesh(file, recipe, *words):
    """The mesh that python -m tools.mesh RECIPE WORDS --out FILE makes; returns the file."""
    done = run_tool("mesh", recipe, *words, "--out", file)
    assert done.returncode == 0, done.stderr
    return file


@pytest.fixture(scope="session")
def coarse(tmp_path_factory):
    """A coarse mesh of the pipe with obstacles (a file)."""
    return make_mesh(tmp_path_factory.mktemp("mesh") / "coarse.mesh", "pipe_obstacles", "--size", 0.014)


@pytest.fixture(scope="session")
def cell(tmp_path_factory):
    """A coarse mesh of the unit square, 20 elements along each side (a file)."""
    return make_mesh(tmp_path_factory.mktemp("cell") / "cell.mesh", "couette_disk", "--size", 0.05)


@pytest.fixture(scope="session")
def shaft(tmp_path_factory):
    """Options that let the settling disk fall in a box half as wide, on elements of the size of the default mesh."""
    return "-mesh", make_mesh(tmp_path_factory.mktemp("shaft") / "shaft.mesh", "box", "--width", 1, "--height", 2.5, "--size",
        0.0625), "-x", 0.5, "-y", 2


@pytest.fixture(scope="session")
def long_box(tmp_path_factory):
    """A mesh of a box of 3 by 0.8, elements of 0.05, with a name for each side (a file)."""
    return make_mesh(tmp_path_factory.mktemp("long_box") / "box.mesh", "box", "--width", 3, "--height", 0.8, "--size", 0.05, "--sides",
        "named")


@pytest.fixture
def freefem():
    """The function run_freefem(script, *args, check=True, timeout=300)."""
    return run_freefem


@pytest.fixture
def freefem_refused():
    """A function (status, script, *args) that runs a script which must end with that status and one line; returns the line."""

    def run(status, script, *args):
        done = run_freefem(script, *args, check=False)
        lines = done.stderr.strip().splitlines()
        assert done.returncode == status and len(lines) == 1 and lines[0].startswith("error: "), (done.returncode, done.stderr)
        return lines[0]

    return run


@pytest.fixture
def freefem_text(tmp_path):
    """A function (text of a script, *args, check, timeout) that runs it as run_freefem does."""

    def run(text, *args, **options):
        script = tmp_path / "script.edp"
        script.write_text(text)
        return run_freefem(script, *args, **options)

    return run


@pytest.fixture(scope="session")
def reading(tmp_path_factory):
    """A script that reads words, a mesh and particles as a case does, and computes nothing (a file)."""
    script = tmp_path_factory.mktemp("reading") / "reading.edp"
    script.write_text(READING)
    return script


@pytest.fixture
def run_folder(tmp_path):
    """The path of a folder for one run; the run makes it."""
    return tmp_path / "run"


@pytest.fixture(scope="session")
def channel(tmp_path_factory):
    """A coarse mesh of a channel of 4 by 2, the one of tests.scenes.SCENE (read)."""
    folder = tmp_path_factory.mktemp("channel")
    (folder / "mesh.edp").write_text(CHANNEL.format(file=folder / "channel.mesh"))
    run_freefem(folder / "mesh.edp")
    return read_mesh(folder / "channel.mesh")


def run_limited(*words, most=None, timeout=120):
    """FreeFem++ on the words; most: bytes a file may hold, as on a disk that is full beyond."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    return subprocess.run([FREEFEM, "-nw", *map(str, words)], cwd=ROOT, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        capture_output=True, text=True,
                          errors="replace", timeout=timeout, preexec_fn=limit if most else None)


def mesh(folder, case, *words):
    """A mesh made by tools.mesh for this test."""
    return make_mesh(folder / f"{case}{len(list(folder.iterdir()))}.mesh", case, *words)


@pytest.fixture(scope="session")
def meshes(tmp_path_factory):
    """A folder for meshes."""
    return tmp_path_factory.mktemp("meshes")
