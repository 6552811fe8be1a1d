"""Pictures of spheres and contacts alone: seen from the front, from the back to the front."""
import numpy as np

from tests.synthetic import write_csv
from tools.plot import contacts
from tools.plot.sphere_contacts import SphereContactRun

NAMES = "step t id x y z u v w omega_x omega_y omega_z radius".split()


def test_the_view_from_the_front(tmp_path):
    rows = [[k, k, one, one, -2.0 * one, 1 + one, 3, 0, -4 * k, 0, 0, 0, 0.5] for k in (0, 1) for one in (0, 1, 2)]
    write_csv(tmp_path / "particles.csv", NAMES, rows)
    write_csv(tmp_path / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"],
        [[0, 0, 0, 2, 0], [1, 1, 1, 1, 0]])
    walls = [[0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 5, 0, 1, 5, 0, 0, 5, 9], [0, 0, 0, 0, 1, 0, 0, 0, 9]]
    write_csv(tmp_path / "walls.csv", [f"{c}{k}" for k in (1, 2, 3) for c in "xyz"], walls)
    run = SphereContactRun(tmp_path)
    assert run.in_space and run.units_per_depth["energy"] == "J"
    frame = run.frame(1)
    assert list(frame["id"]) == [0, 1, 2] and list(frame["y"]) == [1, 2, 3] and np.allclose(frame["speed"], 5)
    segments = run.walls_at(0)
    assert len(segments) == 6 and segments[:, :, 1].max() == run.view[3] > 3.5  # the back wall faces the viewer
    assert contacts.main([str(tmp_path), "--only", "frames", "energy", "--out", str(tmp_path / "made")]) in (0, None)
    assert (tmp_path / "made/frames.png").stat().st_size > 5000
