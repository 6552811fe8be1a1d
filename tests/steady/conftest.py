"""What the tests of steady flows share: the coarse pipe and a laminar flow through it."""
import pytest

from tests.conftest import make_mesh, run_freefem

SHORT = ["-reynolds", "100", "-model", "laminar"]


@pytest.fixture(scope="session")
def coarse_pipe(tmp_path_factory):
    """A coarse mesh of the pipe with its bodies."""
    return make_mesh(tmp_path_factory.mktemp("pipe") / "pipe.mesh", "pipe_flow", "--size", 0.02)


@pytest.fixture(scope="session")
def pipe_run(tmp_path_factory, coarse_pipe):
    """A run of laminar flow through the coarse pipe, which the tests copy."""
    folder = tmp_path_factory.mktemp("pipe_run") / "run"
    run_freefem("cases/pipe_flow.edp", "-mesh", coarse_pipe, *SHORT, "-out", folder)
    return folder
