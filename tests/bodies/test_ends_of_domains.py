"""Where a domain ends: plates that move along themselves, inlets, the sides of a period."""
import pytest

from tests.scenes import particles
from tools.base.run_folder import RunFolder


def test_a_moving_plate_stops_a_disk(freefem, tmp_path):
    disks = particles(tmp_path, (5, 0.6, 0.8, 0.08, 50, 0, 2, 0))
    words = ["cases/couette_disk.edp", "-particles", disks, "-reynolds", "10", "-film", "0", "-dt", "0.005", "-tend", "0.15"]
    freefem(*words, "-every", "0", "-out", tmp_path / "all")
    run = RunFolder(tmp_path / "all")
    fluid, disk = run.table("fluid"), run.table("particles")
    thrown = disk["id"] == 5
    assert fluid["contacts"].max() == 1
    assert (1 - 0.08 - disk["y"][thrown]).min() > -1e-9 and disk["v"][thrown].max() > 1
    freefem(*words, "-every", "0.07", "-out", tmp_path / "few")
    few = RunFolder(tmp_path / "few").table("fluid")
    assert len(few["t"]) < 5 and few["worst_gap"].min() == fluid["worst_gap"].min()


def test_a_disk_beyond_a_plate_of_a_periodic_domain_is_refused(freefem_refused, tmp_path):
    out = particles(tmp_path, (5, 0.5, 1.6, 0.08, 1, 0, 0, 0))
    assert "outside the mesh" in freefem_refused(5, "cases/couette_disk.edp", "-particles", out, "-tend", "0.01", "-out",
        tmp_path / "run")


def test_a_disk_that_leaves_by_the_inlet_is_taken_out(freefem, coarse, tmp_path):
    disks = particles(tmp_path, (5, 0.03, 0, 0.01, 5000, -6, 0, 0))
    freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", "0", "-particles", disks, "-tend", "0.05", "-every", "0",
        "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.table("fluid")["particles"][-1] == 0
    assert run.table("particles")["x"].min() > -0.03  # out of the fluid nothing moves it on


@pytest.mark.parametrize("x, warned", [(0.02, True), (0.3, False)])
def test_a_disk_that_reaches_into_an_inlet_is_warned_of(x, warned, freefem, coarse, tmp_path):
    disks = particles(tmp_path, (7, x, 0, 0.05, 1200, 0, 0, 0))
    done = freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", 0, "-particles", disks, "-tend", 0.001, "-dt", 0.001,
        "-out", tmp_path / "run")
    assert ("particle 7 overlaps an inlet" in done.stdout + done.stderr) == warned
