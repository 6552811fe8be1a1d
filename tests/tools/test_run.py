"""tools.run: from any folder, with FreeFEM's output and status; a sentence comes last; signals leave nothing running."""
import os
import signal
import subprocess
import sys
import time

import pytest

from tests.conftest import FREEFEM, ROOT
from tools.base.ranks import ELSEWHERE

TEMPLATE = (ROOT / "cases/template.edp").read_text()


def tool(*words, cwd=ROOT, **options):
    """tools/run.py in another process."""
    options.setdefault("capture_output", True)
    return subprocess.run([sys.executable, str(ROOT / "tools/run.py"), *map(str, words)], cwd=cwd, text=True, timeout=120,
        **options)


def test_what_does_not_compile_ends_in_one_line_and_nothing_runs(tmp_path):
    (tmp_path / "my case.edp").write_text(TEMPLATE.replace("real mu = ", "real nu = "))
    done = tool("my case.edp", "-out", "here", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (3, "") and not (tmp_path / "here").exists()
    assert done.stderr.startswith("error: my case.edp line 21: nu ") and "mu" in done.stderr and done.stderr.count("\n") == 1


def test_output_and_status_are_freefems(tmp_path):
    plain = subprocess.run([FREEFEM, "-nw", "cases/template.edp", "-help"], cwd=ROOT, capture_output=True, text=True)
    done = tool("cases/template.edp", "-help")
    assert (done.returncode, done.stdout, done.stderr) == (0, plain.stdout, plain.stderr)
    (tmp_path / "seven.edp").write_text('cout << "seven" << endl;\nexec("echo noise >&2");\nexit(7);\n')
    done = tool("seven.edp", cwd=tmp_path)
    assert done.returncode == 7 and done.stdout.startswith("seven\n") and done.stderr == "noise\n"


@pytest.mark.parametrize("text, words, said", [
    (TEMPLATE, ["-tennd", 1], "unknown option -tennd"), (TEMPLATE.replace('include "scripts/resolved.edp"', ""), [],
        "includes no driver")])
def test_the_error_of_a_run_is_the_last_line(text, words, said, tmp_path):
    (tmp_path / "my.edp").write_text(text)
    done = tool("my.edp", *words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, capture_output=False)
    lines = done.stdout.strip().splitlines()
    assert (done.returncode == 3 and lines[-1].startswith("error: ") and said in lines[-1]
        and done.stdout.count("error: ") == 1), done.stdout


def test_files_are_those_of_the_folder_where_the_user_is(tmp_path):
    """-mesh from there, or from the project where only that has it; -out always from there."""
    (tmp_path / "my.edp").write_text(TEMPLATE)
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/mine.mesh").write_bytes((ROOT / "meshes/settling_disk.mesh").read_bytes())
    for mesh in ("meshes/mine.mesh", "meshes/settling_disk.mesh"):
        done = tool("my.edp", "-tend", 0.0025, "-mesh", mesh, "-out", "run", "-overwrite", 1, cwd=tmp_path)
        assert done.returncode == 0 and (tmp_path / "run/run.json").is_file(), done.stderr
        assert f'"mesh": "{tmp_path / mesh if "mine" in mesh else mesh}"' in (tmp_path / "run/run.json").read_text()
    done = tool("my.edp", "-mesh", "mine.mesh", cwd=tmp_path)
    assert done.returncode == 3 and f"{tmp_path}/mine.mesh" in done.stderr


@pytest.mark.parametrize("name, content, said", [
    ("tempate.edp", None, "is cases/template.edp meant?"), ("template", None, "is cases/template.edp meant?"),
    ("nocase.edp", None, "there is no script nocase.edp\n"), ("cases/nothing_like_it.edp", None, "there is no script"),
    ("my.edp", b"\n", "my.edp is empty"), ("my.idp", b"", "must end with .edp"),
    ("my.edp", TEMPLATE.encode("utf-16"), "no plain text")])
def test_what_is_no_script_is_refused(name, content, said, tmp_path):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    done = tool(name, cwd=tmp_path)
    assert done.returncode == 3 and done.stderr.startswith("error: ") and said in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("number, said", [("0", "at least 1"), ("100000", "this machine has")])
def test_a_number_of_processes_that_cannot_be_is_refused(number, said):
    done = tool("-n", number, "cases/template.edp", "-help", env={name: value for name, value in os.environ.items()
        if name not in ELSEWHERE})
    assert done.returncode == 3 and said in done.stderr and done.stderr.count("\n") == 1 and done.stdout == ""


def test_a_number_of_processes_behind_the_case_is_told():
    """The case said that it knows no option -n."""
    done = tool("cases/template.edp", "-n", "2", "-tend", "0.01")
    assert done.returncode == 3 and "before the case: python -m tools.run -n NUMBER cases/template.edp" in done.stderr


def test_help_tells_of_folders_and_signals():
    done = subprocess.run([sys.executable, "-m", "tools.run", "--help"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and all(word in done.stdout for word in ("Ctrl-C", "-out", "status is 3", "FREEFEM"))


@pytest.mark.parametrize("number, deaf", [(signal.SIGINT, False), (signal.SIGTERM, False), (signal.SIGHUP, False),
    (signal.SIGTERM, True)])
def test_a_signal_leaves_nothing_running(number, deaf, tmp_path):
    """FreeFEM, and what it has started: a child that ignores the signal too. (A background job would ignore SIGINT.)"""
    trap = "trap '' INT TERM HUP; " if deaf else ""
    (tmp_path / "long.edp").write_text(f'exec("{trap}echo $PPID $$ > pids; sleep 60; sleep 60");\n'.replace("pids",
        str(tmp_path / "pids")))
    run = subprocess.Popen([sys.executable, str(ROOT / "tools/run.py"), "long.edp"], cwd=tmp_path, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    until(lambda: (tmp_path / "pids").is_file() and (tmp_path / "pids").read_text().endswith("\n"))
    pids = [int(word) for word in (tmp_path / "pids").read_text().split()]
    assert all(map(alive, pids))
    run.send_signal(number)
    _, errors = run.communicate(timeout=30)
    assert run.returncode == 128 + number and errors.startswith("stopped by "), errors
    until(lambda: not any(map(alive, pids)), limit=2)


def until(true, limit=30):
    """Wait until a condition holds; fail after limit seconds."""
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def alive(pid):
    """Whether a process runs; a zombie does not."""
    try:
        os.kill(pid, 0)
        return " Z " not in open(f"/proc/{pid}/stat").read()
    except (ProcessLookupError, FileNotFoundError):
        return False
