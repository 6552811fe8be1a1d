"""Spheres that start from the flow of another run (-start): on the same and on another mesh, with others that enter, refusals."""
import numpy as np
import pytest

from tests.conftest import make_mesh, run_freefem
from tools.base.tables import read_table

CASE = "cases/settling_sphere.edp"


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Quarters of a box of 60 mm, with 3 and 4 elements to the diameter of a sphere of 15 mm."""
    folder = tmp_path_factory.mktemp("boxes")
    return [make_mesh(folder / f"{size}.mesh", "settling_sphere", "--width", 0.06, "--height", 0.1, "--corridor-top", 0.1, "--size",
        size) for size in (0.005, 0.00375)]


@pytest.fixture(scope="module")
def coarse(meshes, tmp_path_factory):
    """The words of a run on the coarse mesh, and a run that has ended at 0.15 s."""
    words = [CASE, "-z", 0.08, "-oil", 2]
    run = tmp_path_factory.mktemp("coarse") / "run"
    run_freefem(*words, "-mesh", meshes[0], "-tend", 0.15, "-checkpoint", 10000, "-out", run)
    return words, run


def both(coarse, mesh, freefem, tmp_path):
    """Rows of particles.csv after 0.15 s: of a run on this mesh, and of one that starts from the coarse one then."""
    words, run = coarse
    words = [*words, "-mesh", mesh, "-tend", 0.3]
    freefem(*words, "-out", tmp_path / "whole")
    freefem(*words, "-start", run, "-out", tmp_path / "started")
    tables = [read_table(tmp_path / name / "particles.csv") for name in ("whole", "started")]
    return [{key: table[key][table["t"] > 0.1501] for key in ("t", "w")} for table in tables]


def test_a_start_on_the_same_mesh_goes_on_as_the_run(coarse, meshes, freefem, tmp_path):
    """The velocity within 2 % of the run that goes on, in each step; the first one is of first order. The time goes on."""
    whole, started = both(coarse, meshes[0], freefem, tmp_path)
    assert started["t"] == pytest.approx(whole["t"])
    assert np.abs(started["w"] / whole["w"] - 1).max() < 0.02
    assert started["w"][-1] == pytest.approx(whole["w"][-1], rel=2e-3)


@pytest.mark.slow
def test_a_start_on_a_finer_mesh_becomes_a_run_of_that_mesh(coarse, meshes, freefem, tmp_path):
    """The velocity within 3 % in each step, and 0.5 % after fifteen."""
    whole, started = both(coarse, meshes[1], freefem, tmp_path)
    assert np.abs(started["w"] / whole["w"] - 1).max() < 0.03
    assert started["w"][-1] == pytest.approx(whole["w"][-1], rel=5e-3)


@pytest.mark.parametrize("more, fault", [
    (["-diameter", 0.014], "sphere 0 has the radius 0.0075 in the run"),
    (["-mesh", "meshes/settling_sphere.mesh"], "of another domain"),
    (["-tend", 0.1], "-tend is 0.1"),
    (["-restart", "RUN"], "give one of them"),
])
def test_what_cannot_start_from_another_run_is_refused(more, fault, coarse, meshes, freefem_refused, tmp_path):
    words, run = coarse
    words = [*words, "-start", run, "-out", tmp_path / "started", *(run if word == "RUN" else word for word in more)]
    if "-mesh" not in more:
        words += ["-mesh", meshes[0]]
    assert fault in freefem_refused(3, *words)
    assert not (tmp_path / "started").exists()
