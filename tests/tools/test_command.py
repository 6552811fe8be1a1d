"""What all command lines of the tools share: an option replaces no earlier one of its name."""
import os
import signal
import subprocess
import sys
import time

import pytest

from tests.conftest import ROOT
from tools.base.command import Parser


def parser():
    one = Parser(prog="one")
    one.add_argument("names", nargs="*")
    one.add_argument("--vary", nargs="+")
    one.add_argument("--only", nargs="*", default=["all"])
    one.add_argument("--label", action="append", default=[])
    one.add_argument_group("more").add_argument("--out", default="here")
    one.add_argument("--pair", nargs=2)
    return one


@pytest.mark.parametrize("words, name, found", [
    ("--vary a b --vary c", "vary", ["a", "b", "c"]), ("--only a --only b", "only", ["a", "b"]), ("", "only", ["all"]),
    ("--label a --label b", "label", ["a", "b"]), ("a b --out there", "names", ["a", "b"]), ("--out there", "out", "there")])
def test_lists_are_those_of_all_times_that_they_are_given(words, name, found):
    """The second --vary of a sweep took the place of the first, in silence."""
    one = parser()
    for _ in range(2):  # a parser may read more than once
        assert getattr(one.parse_args(words.split()), name) == found


@pytest.mark.parametrize("words", ["--out a --out b", "--out a --out a", "--pair a b --pair c d"])
def test_one_value_is_given_once(words, capsys):
    with pytest.raises(SystemExit) as ended:
        parser().parse_args(words.split())
    assert ended.value.code == 3 and capsys.readouterr().err.startswith(f"error: argument {words.split()[0]}: given twice")


def test_subcommands_do_so_too(capsys):
    top = Parser(prog="top")
    one = top.add_subparsers(dest="what").add_parser("one")
    one.add_argument("--size", type=float)
    assert top.parse_args(["one", "--size", "2"]).size == 2
    with pytest.raises(SystemExit):
        top.parse_args(["one", "--size", "2", "--size", "3"])
    assert "given twice" in capsys.readouterr().err


def test_the_keyboard_stops_a_tool_that_reads_its_packages(tmp_path):
    """Large packages take a second or two; before, that ended with a traceback."""
    (tmp_path / "matplotlib.py").write_text(
        f"import pathlib, time\npathlib.Path({str(tmp_path / 'begun')!r}).touch()\ntime.sleep(60)\n")
    tool = subprocess.Popen([sys.executable, "-m", "tools.plot", "run"], cwd=ROOT, stderr=subprocess.PIPE, text=True, env=os.environ
        | {"PYTHONPATH": str(tmp_path)}, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    end = time.monotonic() + 60
    while not (tmp_path / "begun").is_file() and time.monotonic() < end:
        time.sleep(0.05)
    time.sleep(0.2)
    tool.send_signal(signal.SIGINT)
    said = tool.communicate(timeout=20)[1]
    assert said == "stopped by the keyboard\n" and tool.returncode in (-signal.SIGINT, 130)
