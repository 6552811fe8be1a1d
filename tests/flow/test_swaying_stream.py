"""A stream that sways, seen from a cylinder that is moved across it."""
import numpy as np

from tests.conftest import mesh, run_freefem
from tools.run_folder import RunFolder


def test_far_from_a_moved_cylinder_the_stream_sways_without_a_pressure(meshes, run_folder):
    """The inertia of the frame accelerates all fluid alike; without it the pressure would reach amplitude turn^2 25, that is
    4.8."""
    coarse = mesh(meshes, "started_cylinder", "--circle-points", 24)
    run_freefem("cases/started_cylinder.edp", "-reynolds", 185, "-amplitude", 0.2, "-mesh", coarse, "-dt", 0.05, "-tend", 0.5,
        "-fields", 0.5, "-tolerance", 1e-8, "-every", 0, "-out", run_folder)
    run = RunFolder(run_folder)
    grid, values = run.field(len(run.fields) - 1)
    far = np.hypot(*(grid.points - [16, 25]).T) > 14
    turn = 2 * np.pi * 0.156
    sway = -0.2 * turn * np.sin(turn * 0.5)
    np.testing.assert_allclose(values["velocity"][far][:, :2], np.tile([1, sway], (far.sum(), 1)), atol=0.01)
    assert abs(values["pressure"][far]).max() < 0.05
    surface = run.table("surface")
    assert np.count_nonzero(surface["vorticity"]) == 180 and surface["vorticity"].min() < -10 and surface["vorticity"].max() > 10
    assert 0.9 < surface["pressure"].max() < 1.6  # where the stream stops


def test_a_run_that_goes_on_has_its_surface_once(meshes, run_folder):
    coarse = mesh(meshes, "started_cylinder", "--circle-points", 24)
    words = "cases/started_cylinder.edp", "-amplitude", 0.2, "-mesh", coarse, "-dt", 0.05, "-checkpoint", 1, "-out", run_folder
    run_freefem(*words, "-tend", 0.05)
    run_freefem(*words, "-tend", 0.1, "-restart", run_folder)
    assert len(RunFolder(run_folder).table("surface")["angle"]) == 180
