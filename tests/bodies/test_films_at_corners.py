"""Films beside corners of walls: the resistance of a disk that passes one, against body-fitted computations."""
import pytest

from tests.tables import numbers
from tools.validation.films_at_corners import (CASE, FITTED, POLYGON, POLYGONS, WITHIN, polygon_resistance, polygon_words,
    resistance, words)


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


@pytest.mark.parametrize("inside, sides, around, corner, gap, sense", [
    (1, 24, 3, 2, 0.01, 0), (1, 24, 3, 2, 0.01, 1), (1, 24, 3, 2.5, 0.01, 0), (0, 16, 1, 2.5, 0.01, 0),
    (0, 16, 1, 2, 0.01, 0)])
def test_a_round_wall_of_few_sides_has_the_film_of_its_sides(inside, sides, around, corner, gap, sense, freefem, tmp_path):
    """In a round box of 24 sides, which counted as an arc, a disk met 0.26 of the resistance at a corner and 1.68 above a side."""
    options = [word for pair in polygon_words(inside, sides, around, corner, gap, sense).items() for word in pair]
    freefem(POLYGON, *options, "-out", tmp_path / "run")
    found = polygon_resistance(numbers(tmp_path / "run", "forces.csv"), inside, sides, corner, gap, sense)
    assert found == pytest.approx(POLYGONS[inside, sides, around, corner, gap][sense], rel=WITHIN)


@pytest.mark.parametrize("past", [0.1, 1e-9])
def test_what_approaches_beside_a_corner_is_pushed_along_the_wall(past, freefem, tmp_path):
    """Force along the wall by an approach, over the geometric mean of both resistances; it was 0.003 and 0.007. Body-fitted
    (corner_stokes.edp): 0.174 and 0.437 at a gap of 0.003 radii."""
    gap, size = 0.003, 0.25
    freefem(CASE, "-solid", 90, "-past", past, "-gap", gap, "-size", size, "-dt", 2 * size**2, "-cfl", 0, "-every", 0, "-forces", 1,
        "-tend", 40 * size**2, "-out", tmp_path / "run")
    forces = numbers(tmp_path / "run", "forces.csv")
    mean = (68443.5 * 154.8) ** 0.5 if past > 0.01 else (18481.8 * 130.7) ** 0.5
    assert resistance(forces, -past, gap, 1) / mean == pytest.approx(0.174 if past > 0.01 else 0.437, abs=0.05)
