"""Disks and ellipses turn in a shear flow."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tools.base.tables import read_table


def test_an_ellipse_turns_as_jeffery_says(freefem, coarse_shear, tmp_path):
    freefem("cases/ellipse_in_shear.edp", "-mesh", coarse_shear, "-major", 0.05, "-reynolds", 0.2, "-dt", 0.02, "-tend", 2, "-out",
        tmp_path / "run")
    table = read_table(tmp_path / "run" / "particles.csv")
    late = table["t"] > 0.3  # it starts at rest
    exact = -(4 * np.sin(table["theta"]) ** 2 + np.cos(table["theta"]) ** 2) / 5
    assert abs(table["omega"] - exact)[late].max() < 0.02
    assert abs(table["y"] - 0.5).max() < 1e-3
    shapes = read_table(tmp_path / "run" / "shapes.csv")
    assert shapes["major"][0] == 0.05 and shapes["minor"][0] == 0.025


@pytest.fixture(scope="module")
def coarse_shear(tmp_path_factory):
    return make_mesh(tmp_path_factory.mktemp("shear") / "shear.mesh", "ellipse_in_shear", "--size", 0.00625, "--core", 0.13)


@pytest.mark.parametrize("across, reach, centre", [(4, 4.0, (0.5, 0.5)), (6, 5.0, (0.0, 0.0)), (3, 5.0, (0.5, 0.5))])
def test_a_disk_turns_with_a_slow_shear_flow_at_long_steps(freefem, run_folder, across, reach, centre):
    """nu dt/h^2 = 4 and 5: half the shear rate, less what the plates take off, at every step. (With rates extrapolated in full
    these disks turned with swings
    up to 17, 1 and 15 times the shear rate, of the other sign at each step.)"""
    size = 0.05
    where = [0.5 + size * c for c in centre]
    disks = run_folder.parent / "disk.csv"
    disks.write_text(f"id,x,y,radius,density,u,v,omega\n0,{where[0]},{where[1]},{across * size / 2},1,0,0,0\n")
    box = make_mesh(run_folder.parent / "box.mesh", "couette_disk", "--size", size)
    freefem("cases/sheared_suspension.edp", "-fraction", "0", "-mesh", box, "-convection", "0", "-cfl", "0",
            "-dt", str(reach * size**2), "-tend", str(60 * reach * size**2), "-every", "0", "-particles", disks, "-out", run_folder)
    omega = read_table(run_folder / "particles.csv")["omega"]
    assert len(omega) > 55 and omega[20:].min() > -0.52 and omega[20:].max() < -0.45
