"""Films beside corners of walls: the resistance of a disk that passes one, against body-fitted computations."""
import pytest

from tests.tables import numbers
from tools.validation.films_at_corners import CASE, FITTED, WITHIN, resistance, words


@pytest.mark.parametrize("solid, where, gap, sense, tilt", [
    (90, 80, 0.02, 0, 10), (90, -0.1, 0.02, 0, 0), (90, -0.1, 0.003, 1, 0),
    (90, 45, 0.003, 0, 30), (60, 70, 0.003, 0, 0)])
def test_a_disk_beside_a_corner_meets_the_resistance_there(solid, where, gap, sense, tilt, freefem, tmp_path):
    """At 80 degrees, where there was no film, it met 0.17 of the resistance; a tenth of the radius before the corner 1.76, with the
    film of a whole plane. Along the wall 1.23."""
    options = [word for pair in words(solid, where, gap, sense).items() for word in pair]
    freefem(CASE, *options, "-tilt", tilt, "-out", tmp_path / "run")
    found = resistance(numbers(tmp_path / "run", "forces.csv"), where, gap, sense, tilt)
    assert found == pytest.approx(FITTED[solid, where, gap][sense], rel=WITHIN)
