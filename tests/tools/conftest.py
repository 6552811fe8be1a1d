"""What the tests of the pictures share: a made-up run with fields."""
import pytest

from tests.synthetic import write_run
from tools.base.run_folder import RunFolder


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A made-up run with fields written by FreeFEM."""
    return write_run(tmp_path_factory.mktemp("plot") / "run", fields=8, n=8)


@pytest.fixture
def run(folder):
    """The made-up run, as tools read it."""
    return RunFolder(folder)
