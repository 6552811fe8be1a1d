"""Which gaps at walls are films, and how walls go on beside them: corners, curves, free ends."""
import numpy as np
import pytest

from tests.tables import rows

# Disks one by one at these places; a row a film: which disk, gap, normal, angles and distances on both sides, curvature.
TEXT = """include "lib/contact/film_gaps.idp"
{walls}
cout.precision(12);
real[int] xs = {xs}, ys = {ys}, px(1), py(1), turn = [0.3], r = [1], aspect = [{aspect}];
for (int k = 0; k < xs.n; ++k) {{
    px = xs[k]; py = ys[k];
    filmForget();
    filmGaps(px, py, turn, r, aspect, 1.);
    real[int] size(filmN);
    size = {size};
    filmWallSides(size); filmWallCorners(px, py);
    for (int i = 0; i < filmN; ++i) cout << "film " << k << " " << filmGap[i] << " " << filmEx[i] << " " << filmEy[i] << " "
        << filmLeanUp[i] << " " << filmLeanDown[i] << " " << filmFlatUp[i] << " " << filmFlatDown[i] << " " << filmCurve[i] << endl;
}}
"""


def polygon(points):
    return " ".join(f"contactWallSegment({x1:.15g}, {y1:.15g}, {x2:.15g}, {y2:.15g});" for (x1, y1), (x2, y2) in zip(points,
        points[1:]))


@pytest.fixture
def films(freefem_text):
    def run(points, places, aspect=1, size=1e-3):
        places = np.atleast_2d(places)
        listed = [str([float(x) for x in column]) for column in places.T]
        done = freefem_text(TEXT.format(walls=polygon(points), xs=listed[0], ys=listed[1], aspect=aspect, size=size))
        found = rows(done.stdout, "film")
        return [found[found[:, 0] == k][:, 1:] for k in range(len(places))]
    return run


@pytest.mark.parametrize("angle", [90, 60, 150])
def test_a_disk_that_passes_a_corner_has_one_film_all_the_way(angle, films):
    """The corner belongs to both faces. Between 18 and 72 degrees there was no film, beside it that of a whole plane."""
    solid, gap = np.radians(angle), 0.02
    second = np.array([np.cos(solid - np.pi), np.sin(solid - np.pi)])
    normal2 = np.array([-second[1], second[0]])
    turns = np.linspace(np.pi / 2, np.pi / 2 - (np.pi - solid), 13)
    places = [(-s, 1 + gap) for s in (1.5, 0.5, 0.1, 1e-9)] + [(1 + gap) * np.array([np.cos(a), np.sin(a)]) for a in turns] \
        + [s * second + (1 + gap) * normal2 for s in (1e-9, 0.1, 0.5, 1.5)]
    for k, found in enumerate(films([(-5, 0), (0, 0), tuple(5 * second)], places)):
        assert len(found) == 1 and found[0][0] == pytest.approx(gap, abs=1e-9), k
        _, _, _, up, down, flat_up, flat_down, curve = found[0]
        assert curve == 0
        # the angles of both sides add up to that by which the wall turns
        assert up + down == pytest.approx(np.pi - solid, abs=3e-3)
        if 4 <= k < 17:
            assert up == pytest.approx(turns[k - 4] - turns[-1], abs=3e-3) or up == pytest.approx(turns[0] - turns[k - 4], abs=3e-3)
            assert max(flat_up, flat_down) < 1e-8


def test_a_disk_in_a_corner_has_both_films(films):
    """The faces of the corner turn by 90 and by 40 degrees; the second film was left out for less than 60."""
    for turn in (90, 40):
        a = np.radians(turn)
        d = np.array([np.cos(a), np.sin(a)])
        middle = 1.02 * np.array([-np.tan(a / 2), 1])
        (found,) = films([(-5, 0), (0, 0), tuple(5 * d)], [middle])
        assert len(found) == 2 and found[:, 0] == pytest.approx(0.02, abs=1e-9) and (found[:, 3:5] == 0).all()
        (found,) = films([(-5, 0), (0, 0), tuple(5 * d)], [middle - [0.4, 0]])
        assert len(found) == (2 if 0.4 * np.sin(a) < 0.98 else 1)


@pytest.mark.parametrize("chords", [40, 200])
def test_a_bump_of_many_segments_is_one_curve(chords, films):
    """A half of a disk of the radius 1.5 that stands on a floor: its curvature, one film, no corners."""
    s = np.linspace(np.pi, 0, chords + 1)
    bump = [(-5, 0)] + [(1.5 * np.cos(a), 1.5 * np.sin(a)) for a in s] + [(5, 0)]
    for a in np.linspace(0.7, 2.4, 7):
        (found,) = films(bump, [(2.52 * np.cos(a), 2.52 * np.sin(a))])
        found = found[found[:, 0] < 0.1]  # the other one is at the floor
        assert len(found) == 1 and found[0][0] == pytest.approx(0.02, abs=0.002)
        assert found[0][7] == pytest.approx(-1 / 1.5, rel=0.02) and found[0][3] == found[0][4] == 0


def test_an_ellipse_and_a_free_end(films):
    """An ellipse beside the edge of a face, and a disk round the end of a plate, whose other face leads back."""
    (found,) = films([(-5, 0), (0, 0), (0, -5)], [(0.6, 0.8)], aspect=0.5)
    assert len(found) == 1 and found[0][3] + found[0][4] == pytest.approx(np.pi / 2, abs=3e-3)
    for turn in (80, 0, -80):
        a = np.radians(turn)
        (found,) = films([(-5, 0), (0, 0)], [(1.02 * np.cos(a), 1.02 * np.sin(a))])
        assert len(found) == 1 and sorted(found[0][3:5]) == pytest.approx(sorted((np.pi / 2 - a, np.pi / 2 + a)), abs=3e-3)


def test_joints_of_a_straight_wall_are_none(films):
    (found,) = films([(-5, 0), (-1, 0), (0, 0), (0.3, 0), (5, 0)], [(0.01, 1.02)])
    assert len(found) == 1 and (found[0][3:] == 0).all()


def test_sides_of_a_round_box_are_seen_in_narrow_gaps(films):
    """A box of 3 radii: of 24 sides, whose corners lean towards the disk; of 400, which are an arc; of 16, which are longer than
    the disk's radius and no curve, but one film."""
    for sides, gap in ((24, 0.02), (400, 0.02), (16, 0.02)):
        s = 2 * np.pi * np.arange(sides + 1) / sides
        box = [(3 * np.cos(a), 3 * np.sin(a)) for a in s]
        half = 3 * np.sin(np.pi / sides)
        (found,) = films(box, [(3 * np.cos(np.pi / sides) - 1 - gap) * np.array([np.cos(s[1] / 2), np.sin(s[1] / 2)])])
        assert len(found) == 1 and found[0][0] == pytest.approx(gap, abs=1e-9)
        assert found[0][7] == pytest.approx(0 if sides == 16 else 1 / 3, rel=0.02)
        if sides == 400:
            assert (found[0][3:7] == 0).all()
        else:
            assert found[0][3:5] == pytest.approx([-s[1]] * 2) and found[0][5:7] == pytest.approx([half] * 2, abs=1e-6)


def test_sides_as_long_as_elements_are_chords_of_an_arc(films):
    """A mesh has a circle as chords as long as its elements. (A disk above a corner of 24 sides.)"""
    s = 2 * np.pi * np.arange(25) / 24
    box, place = [(3 * np.cos(a), 3 * np.sin(a)) for a in s], [(2 - 0.02) * np.array([np.cos(s[2]), np.sin(s[2])])]
    for elements, seen in ((1, False), (2, True)):
        (found,) = films(box, place, size=6 * np.sin(np.pi / 24) / elements)
        assert len(found) == 1 and found[0][7] == pytest.approx(1 / 3, rel=0.02) and (found[0][3:5] != 0).any() == seen
