"""Structured meshes of right triangles on grids whose spacing may vary."""
from functools import partial

import numpy as np

from tools.base.command import BadInput
from tools.meshing.plane_mesh import finished, labels_on

MOST_VERTICES = 2_000_000
PATTERNS = ("right", "alternating")


def gridded(outline, xs, ys, pattern="right", keep=None):
    """A mesh of the cells of the grid xs (increasing), ys (increasing), two triangles a cell.

    pattern: "right", all diagonals alike (FreeFEM's square(flags=3)), or "alternating"
    (a union jack on every four cells, symmetric on even numbers of cells). keep: which
    cells are there, keep(x, y) of the arrays of their centres; all when not given.
    """
    nx, ny = len(xs) - 1, len(ys) - 1
    if (nx + 1) * (ny + 1) > MOST_VERTICES:
        raise too_many(f"{nx} x {ny} cells")
    x, y = np.meshgrid(xs, ys, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel()])
    i, j = (index.ravel() for index in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    if keep is not None:
        there = keep(0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1]))
        i, j = i[there], j[there]
    a, b = i * (ny + 1) + j, (i + 1) * (ny + 1) + j
    c, d = b + 1, a + 1  # a, b, c, d counter-clockwise from the lower left
    rising = np.column_stack([a, b, c, a, c, d]).reshape(-1, 3)
    falling = np.column_stack([a, b, d, b, c, d]).reshape(-1, 3)
    falls = np.zeros(len(a), dtype=bool) if pattern == "right" else (i + j) % 2 == 1
    triangles = np.where(np.repeat(falls, 2)[:, None], falling, rising)
    used, triangles = np.unique(triangles, return_inverse=True)
    return finished(points[used], triangles.reshape(-1, 3), partial(labels_on, outline=outline))


def too_many(cells):
    """What to raise for a grid of so many cells, in words."""
    return BadInput(f"this grid of {cells} has more than {MOST_VERTICES:.0e} vertices: ask for larger cells")


def counted(number):
    """A number of cells along one side, refused before it becomes an array where it is too large by itself."""
    if number > MOST_VERTICES:
        raise too_many(f"{number:.7g} cells along a side")
    return max(1, round(number))


def even(start, end, size):
    """Points from start to end, evenly spaced, about `size` apart."""
    return np.linspace(start, end, counted((end - start) / size) + 1)


def growing(start, end, first, ratio, largest):
    """Points from start to end (either way): spacing `first` at start, growing by `ratio`, at most `largest`."""
    length = abs(end - start)
    steps, total = [], 0.0
    while total < length * (1 - 1e-9):
        steps.append(largest if steps and steps[-1] >= largest else min(first * ratio ** len(steps), largest))
        total += steps[-1]
        counted(len(steps))
    way = np.concatenate([[0.0], np.cumsum(steps)]) * (length / total)
    way[-1] = length
    return start + np.sign(end - start) * way


def towards_ends(start, end, number, ratio):
    """number + 1 points from start to end, cells in the middle `ratio` times those at the ends."""
    half = np.abs(np.arange(number) - (number - 1) / 2)
    cells = ratio ** (-half / max(half.max(), 1))
    points = start + (end - start) * np.concatenate([[0.0], np.cumsum(cells)]) / cells.sum()
    points[-1] = end
    return points


def joined(*pieces):
    """One increasing array of grid points from pieces that share their ends."""
    points = np.concatenate(pieces)
    decimals = 14 - min(0, int(np.floor(np.log10(np.ptp(points)))))  # of a domain of less than 1 as many digits as of one of 1
    return np.unique(np.round(points, decimals))
