"""The tests themselves: what several files share stands in modules that are no tests, and a file has one topic."""
import ast
import re
from pathlib import Path

import pytest

from tests.conftest import ROOT

FILES = sorted((ROOT / "tests").rglob("test_*.py"))
LONGEST = 500  # lines


def imported_tests(text):
    """Names of the test modules that a module imports, anywhere in it."""
    names = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names += [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            names += [node.module or ""] + [f"{node.module}.{name.name}" for name in node.names]
    return [name for name in names if any(part.startswith("test_") for part in name.split("."))]


@pytest.mark.parametrize("text, found", [
    ("from tests.bodies.test_pipe import read", 2), ("def late():\n    from tests.bodies import test_pipe", 1),
        ("import tests.bodies.test_pipe as pipe", 1),
    ("from tests.scenes import case, write_test_box\nimport pytest", 0),
])
def test_an_import_of_a_test_file_is_seen(text, found):
    assert len(imported_tests(text)) == found


def test_no_test_file_imports_another():
    """What several test files share stands in tests/scenes.py, tests/tables.py or a conftest.py."""
    assert {str(file.relative_to(ROOT)): names for file in FILES if (names := imported_tests(file.read_text()))} == {}


def test_no_test_file_is_long():
    """One topic a file."""
    assert [str(file.relative_to(ROOT)) for file in FILES if len(file.read_text().splitlines()) > LONGEST] == []


def test_names_of_test_files_differ():
    """pytest takes files of one name for the same module."""
    names = [Path(file).name for file in FILES]
    assert len(names) == len(set(names)) > 60


def test_rows_that_are_called_slow_are_there():
    rows = [line for line in (ROOT / "tests/slow_rows.txt").read_text().splitlines() if not line.startswith("#")]
    for file, name in (re.match(r"([\w/]+\.py)::(\w+)", row).groups() for row in rows):
        assert f"def {name}(" in (ROOT / file).read_text(), (file, name)
    assert len(rows) == len(set(rows))
