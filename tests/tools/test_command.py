"""What all command lines of the tools share: an option replaces no earlier one of its name."""
import pytest

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
