"""Tables of points as other programs and other countries write them, read in the process of the test."""
import numpy as np
import pytest

from tools.base.command import BadInput
from tools.flow import table_forms

ROWS = np.array([[0.5, -0.25, 1.5, 2e-3], [1, 0, -3.5, 4.25], [2, 0.125, 1e6, 0]])
NAMES = ["x", "y", "u", "v"]


def written(by, head="", mark="", point="."):
    """The rows under a header, separated by `by`, behind the lines of `head`; mark: before the header."""
    lines = [mark + by.join(NAMES)] + [by.join(f"{value:g}" for value in row).replace(".", point) for row in ROWS]
    return head + "\n".join(lines) + "\n"


@pytest.mark.parametrize("text", [
    written(","), written(";"), written("\t"), written("   "), written(" "), written(";", point=","), written("\t", point=","),
    written(",", mark="# "), written(",", head="% Model,a.mph\n% Version,6\n", mark="% "), written(",", head="# one\n\n# two\n"),
    written(",", head="\n[Name]\nPlane 1\n\n[Data]\n") + "\n[Faces]\n0, 1, 2\n",
    written(",").replace("\n", ",\n"), written(";").replace("\n", ";\n"), written(";").replace("\n", "\r\n"),
    "\ufeff" + written("\t")])
def test_a_table_is_the_same_whatever_separates_its_columns(tmp_path, text):
    (tmp_path / "a.txt").write_bytes(text.encode())
    found = table_forms.read(tmp_path / "a.txt")
    assert list(found) == NAMES
    np.testing.assert_array_equal(np.column_stack(list(found.values())), ROWS)


@pytest.mark.parametrize("text, says", [
    (written(";").replace("1.5", "1,5"), "commas as well as points"), (written(";").replace("1.5", "a"), "line 2: column u needs"),
    (written("\t").replace("1.5\t", ""), "line 2: 3 values where the header names 4"), ("", "is empty"), ("# x\n", "is empty"),
    ("x;y;u;u\n1;2;3;4\n", "repeated column name"), ("1;2;3;4\n5;6;7;8\n", "a header row with column names is needed"),
    (written(";").replace("1.5", "nan"), "u is nan, not a finite number")])
def test_what_is_no_table_is_refused(tmp_path, text, says):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(BadInput, match=says):
        table_forms.read(tmp_path / "a.csv")
