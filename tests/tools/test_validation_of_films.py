"""tools.validation.films: what it takes for exact, and how it judges runs."""
import types

import numpy as np
import pytest

from tools.validation import Context, Run, films


def test_resistances_are_those_known():
    """Exact at a wall; two disks: the computed ones, and their leading term with the next between them."""
    assert films.at_wall([0.5, 0.01]) == pytest.approx([57.89, 13469], rel=1e-4)
    assert films.of_pair([0.5, 0.05]) == pytest.approx([49.72, 914.9]) and films.of_pair(0.03) == pytest.approx(1906, rel=2e-3)


def sunk(factor, least):
    """near.csv of a disk without inertia at `factor` times the exact resistance, down to the gap `least`."""
    gap = np.geomspace(0.95, least, 3000)
    slow = factor * films.at_wall(gap) / films.PUSH
    t = films.RADIUS * np.append(0, np.cumsum(0.5 * (slow[1:] + slow[:-1]) * -np.diff(gap)))
    even = np.linspace(0, t[-1], 3000)
    return {"t": even, "gap": np.interp(even, t, gap), "closing": np.interp(even, t, 1 / slow)}


@pytest.mark.parametrize("factor, least, missed", [(1, 0.009, 0), (1.1, 0.009, 1), (1.3, 0.009, len(films.GAPS) + 1), (1, 0.02, 1)])
def test_a_disk_is_judged_by_its_resistance_and_its_time(factor, least, missed, monkeypatch, tmp_path):
    """Slower by 10 % only the time is missed; a disk that has not arrived misses the time."""
    run = Run(types.SimpleNamespace(table=lambda name: sunk(factor, least)), 1.0, 1.0)
    monkeypatch.setattr(films, "DENSITY", 0)
    monkeypatch.setattr(Context, "run", lambda *given: run)
    runs = [(0.0625, 2, {"-x": 1.0})]
    rows = list(films.pushed(Context("films", tmp_path), films.at_wall, False, runs, ("box",), 0.15, "a disk"))
    assert len(rows) == len(films.GAPS) + 2 and sum(not row.passed for row in rows) == missed
