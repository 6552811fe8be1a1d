"""Ends of walls that lie behind a wall that a body faces cost it no speed (lib/contact/wall_hidden.idp).

Bodies slide without friction on floors that lie above each other, with the speed 1 in steps of 0.2 radii.
"""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tools.base.tables import read_table

BODIES = {
    "disk": ("bodyAdd(0.5, {high!r}, 0.1, 1000, 1, 0, 0, 1);", 0.1),
    "ellipse": ("bodyEllipse(0.5, {high!r}, 0.1, 0.06, 0, 1000); bodyQ[{k}] = 1;", 0.06),
    "capsule": ("bodyThrown(bodyCapsule(0.5, {high!r}, 0.1, 0.06, 0, 1000), 1, 0, 0);", 0.06),
}
PLAIN = "{}"


@pytest.fixture
def slide(freefem_text, tmp_path):
    """Speeds after 1.5 of bodies of one kind on floors, lists of (x1, y1, x2, y2, form); a form adds words to a wall."""

    def run(kind, floors, *words):
        line, radius = BODIES[kind]
        bodies = [line.format(high=3 * k + radius + 1e-8, k=k) for k in range(len(floors))]
        walls = [form.format(f"contactWallSegment({x1!r}, {y1 + 3 * k!r}, {x2!r}, {y2 + 3 * k!r})") + ";"
            for k, pieces in enumerate(floors) for x1, y1, x2, y2, form in pieces]
        shapes = 'include "lib/case.idp"\ninclude "lib/bodies/shapes.idp"\n' if kind == "capsule" else ""
        freefem_text(shapes + CONTACTS.format(gravity=-9.81, walls="\n".join(walls), bodies="\n".join(bodies), more=""), *words,
            "-dt", 0.02, "-tend", 1.5, "-every", 1.5, "-out", tmp_path / "run")
        rows = read_table(tmp_path / "run" / "particles.csv")
        return rows["u"][rows["t"] > 1]

    return run


@pytest.mark.parametrize("kind", BODIES)
def test_a_slot_that_is_narrow_costs_no_speed(kind, slide):
    """It took 6 % however narrow it was, from 1e-7 on."""
    slots = np.array([1e-10, 1e-7, 1e-5, 1e-3])
    speed = slide(kind, [[(0.0, 0.0, 1.0, 0.0, PLAIN), (1.0 + float(w), 0.0, 4.0, 0.0, PLAIN)] for w in slots])
    assert (np.abs(speed - 1) < 1e-6 + 3 * slots).all()


@pytest.mark.parametrize("kind", BODIES)
def test_a_floor_that_begins_to_fall_costs_no_speed(kind, slide):
    """Energy: u = 1 + g h after it has gone down by h, which is small; it took 6 %."""
    slopes = np.array([1e-7, 1e-5, 1e-4])
    speed = slide(kind, [[(0.0, 0.0, 1.0, 0.0, PLAIN), (1.0, 0.0, 4.0, -3 * float(a), PLAIN)] for a in slopes])
    np.testing.assert_allclose(speed - 1, 9.81 * slopes, rtol=0.05, atol=1e-7)


@pytest.mark.parametrize("kind", BODIES)
def test_pieces_of_a_floor_may_differ_in_friction_rebound_and_speed(kind, slide):
    """Nobody rubs and nobody falls, and so only the walls differ."""
    forms = ["contactWallRough({}, 0.5)", "contactWallBouncy({}, 0.5)", "contactWallGlide({}, 0.5)"]
    floors = [[(0.0, 0.0, 1.0, 0.0, PLAIN), (1.0, 0.0, 2.0, 0.0, form), (1.7, 0.0, 4.0, 0.0, PLAIN)] for form in forms]
    assert slide(kind, floors, "-restitution-wall", 0.7) == pytest.approx(np.ones(3), abs=1e-6)


def test_friction_changes_where_the_floor_does(freefem_text, tmp_path):
    """A disk that slides over a joint keeps what friction leaves of its speed; overlapping pieces too."""
    walls = "contactWallRough(contactWallSegment(-1, 0, 0.1, 0), 0.1); contactWallRough(contactWallSegment(0.05, 0, 5, 0), 0.4);"
    freefem_text(CONTACTS.format(gravity=-9.81, walls=walls, bodies="bodyAdd(0, 0.01, 0.01, 1000, 1, 0, 0, 1);", more=""),
        "-friction", 9, "-dt", 0.0005, "-tend", 0.3, "-every", 0.0005, "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run" / "particles.csv")
    rate = -np.diff(rows["u"]) / np.diff(rows["t"]) / 9.81
    x = rows["x"][:-1]
    np.testing.assert_allclose(rate[(x > 0.01) & (x < 0.04)], 0.1, atol=1e-6)
    np.testing.assert_allclose(rate[(x > 0.11) & (rows["u"][1:] > 0.68)], 0.4, atol=1e-6)
    assert rows["u"][-1] == pytest.approx(2 / 3, abs=1e-6)


def test_what_stands_out_in_front_of_a_floor_still_stops_a_disk(slide):
    """Ends on a step up, or of a wall that rises, are in front of the line."""
    speed = slide("disk", [[(0.0, 0.0, 1.0, 0.0, PLAIN), (1.0, h, 4.0, h, PLAIN)] for h in (1e-3, 0.02)]
        + [[(0.0, 0.0, 1.0, 0.0, PLAIN), (1.001, 0.0, 1.001, 0.3, PLAIN)]])
    assert (speed[:2] < 0.99).all() and abs(speed[2]) < 1e-6
