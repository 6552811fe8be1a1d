"""Gaps open as surfaces curve away from each other; the overlap allowed covers this (contactCurve in lib/contact/pass.idp)."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tools.base.tables import read_table

ALLOWED = ("-contact-overlap", 0.05)


@pytest.fixture
def rows(freefem_text, tmp_path):
    """Table of the run of a scene, in steps of 0.02 up to the time 1.2: motion or particles."""

    def run(table, walls, bodies, *words):
        freefem_text(CONTACTS.format(gravity=0, walls=walls, bodies=bodies, more=""), *words, "-dt", 0.02, "-tend", 1.2, "-every",
            0.02, "-overwrite", 1, "-out", tmp_path / "run")
        return read_table(tmp_path / "run" / f"{table}.csv")

    return run


@pytest.mark.parametrize(("walls", "bodies"), [
    ("", "bodyAdd(0, 0, 0.1, 1000, 0, 0, 0, 0); bodyAdd(-0.6, 0.2005, 0.1, 1000, 1, 0, 0, 1);"),
    ("contactWallSegment(0, -1, 0, 0);", "bodyAdd(-0.6, 0.1005, 0.1, 1000, 1, 0, 0, 1);")], ids=["disk", "end of a wall"])
def test_who_passes_closely_is_not_deflected(walls, bodies, rows):
    """A disk passes a held one, or an end, at 0.005 radii, in steps of 0.2 radii. Without an overlap allowed it is deflected."""
    for words, deflected in ((), 1), (ALLOWED, 0):
        table = rows("particles", walls, bodies, *words)
        last = table["v"][table["id"] == table["id"].max()][-1]
        assert last > 0.01 if deflected else abs(last) < 1e-12


def test_a_crowd_gains_no_energy(rows):
    """40 disks, thrown about in a box; moves of 0.1 to 0.5 radii."""
    rng = np.random.default_rng(5)
    box = "".join(f"contactWallSegment({a}, {b}, {c}, {d}); " for a, b, c, d in [(0, 0, 2, 0), (2, 0, 2, 1.3), (2, 1.3, 0, 1.3),
        (0, 1.3, 0, 0)])
    bodies = "".join(f"bodyAdd({0.15 + 0.24 * (k % 8)!r}, {0.15 + 0.24 * (k // 8)!r}, 0.1, 1000, {u!r}, {v!r}, 0, 1);\n"
        for k, (u, v) in enumerate(rng.normal(0, 1, (40, 2)).tolist()))
    table = rows("motion", box, bodies, *ALLOWED)
    energy = table["kinetic_energy"]
    assert (np.diff(energy) <= 1e-3 * energy[:-1]).all() and energy[-1] < 0.2 * energy[0]
    assert table["worst_gap"].min() > -0.05 * 0.1
