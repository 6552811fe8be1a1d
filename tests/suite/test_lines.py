"""Lines of code are at most 132 columns wide, so that two files can be read side by side."""
import io
import re
import tokenize

import pytest

from tests.conftest import ROOT
from tests.lint import files

WIDEST = 132
PYTHON = sorted(str(path.relative_to(ROOT)) for folder in ("tools", "tests") for path in (ROOT / folder).rglob("*.py"))


def wide(text):
    """The numbers of the lines of a script that are too wide; the header of a table stays in one line, where it can be found."""
    return ([number for number, line in enumerate(text.split("\n"), 1) if len(line) > WIDEST
        and not re.match(r"\s*outHeader\(", line)])


def wide_python(text):
    """The same of a module: a string that holds a line of a script, a file or a message to compare with may go on."""
    lines = text.split("\n")
    inside = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.STRING:
            for number in range(token.start[0], token.end[0] + 1):
                begin = token.start[1] if number == token.start[0] else 0
                end = token.end[1] if number == token.end[0] else len(lines[number - 1])
                if begin < WIDEST <= end:
                    inside.add(number)
    return [number for number, line in enumerate(lines, 1) if len(line) > WIDEST and number not in inside]


@pytest.mark.parametrize("path", files(".idp") + files(".edp"))
def test_lines_of_scripts_are_narrow(path):
    assert wide((ROOT / path).read_text()) == []


@pytest.mark.parametrize("path", PYTHON)
def test_lines_of_modules_are_narrow(path):
    assert wide_python((ROOT / path).read_text()) == []


def test_wide_lines_are_found():
    long = "x" * 120
    assert (wide(f"real {long} = 12345678;\nreal a;\nouter(\"{long}{long}\");\n    outHeader(\"a.csv\", \"{long}{long}\");") == [1,
        3])
    assert wide_python(f'a = "{long}{long}"\n{long} = 1234567890\nb = """\n{long}{long}\n"""\n# {long} {long}\n') == [2, 6]
