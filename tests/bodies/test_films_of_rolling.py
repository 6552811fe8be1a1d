"""Films of bodies that rotate beside a wall or each other, against body-fitted torques."""
import pytest

from tests.conftest import make_mesh
from tests.scenes import case
from tests.tables import numbers


@pytest.mark.parametrize("bodies, motions, whole", [
    ("bodyHeld(bodyEllipse(3.95, 1.04, 3, 1, 0, 1));", "givenMotion(0, 0, 0, 1e-6);", 8843.5),
    ("bodyHeld(bodyDisk(2.97, 4.02, 1, 1)); bodyHeld(bodyDisk(5.02, 4.02, 1, 1));",
        "givenMotion(0, 0, 0, 1e-6); givenMotion(1, 0, 0, -1e-6);", 34.72)])
def test_what_rotates_beside_another_has_the_resistance_there(bodies, motions, whole, freefem_text, tmp_path):
    """An ellipse parallel to the floor, and two disks against each other, at gaps of 0.04 and 0.05. Where the film was that of the
    parabola, and of its shear alone, they met 1.8 and 1.2 of the torque."""
    box = make_mesh(tmp_path / "box.mesh", "box", "--width", 8, "--height", 8, "--size", 0.25)
    more = f"macro caseMotion(now) {motions} // EOM"
    text = case(bodies, walls="labelLeft, labelRight, labelBottom, labelTop, labelWall", more=more, mu=1, gravity=0)
    freefem_text(text, "-mesh", box, "-dt", 0.0625, "-cfl", 0, "-stabilise", 0, "-tend", 0.75, "-every", 0, "-forces", 1,
        "-film", 1, "-out", tmp_path / "run")
    forces = numbers(tmp_path / "run", "forces.csv")
    assert -forces["torque"][forces["id"] == 0][-1] / 1e-6 == pytest.approx(whole, rel=0.15)
