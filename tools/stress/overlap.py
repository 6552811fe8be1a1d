"""Overlap of disks with each other and with walls, from particles.csv alone.

Written apart from lib/: what a run says of its own gaps is not asked. Depths are in radii
of the smaller disk; times in s.
"""
from pathlib import Path

import numpy as np

from tools.mesh_files import OPEN
from tools.meshing.labels import LABELS
from tools.tables import read_table

PAIRED = {0: (LABELS["left"], LABELS["right"]), 1: (LABELS["bottom"], LABELS["top"])}
CHUNK = 2_000_000  # entries of an array at a time


def solid_segments(run, period=(0.0, 0.0)):
    """(S, 4) walls of a run folder: walls.csv, else the edges of mesh.mesh that are neither
    open ends nor sides with an image."""
    walls = Path(run.folder) / "walls.csv"
    if walls.is_file():
        table = read_table(walls)
        return np.column_stack([table[name] for name in ("x1", "y1", "x2", "y2")])
    if not (Path(run.folder) / "mesh.mesh").is_file():
        return np.zeros((0, 4))
    mesh = run.mesh
    gone = set(OPEN) | {label for axis in (0, 1) if period[axis] > 0 for label in PAIRED[axis]}
    kept = mesh.edges[~np.isin(mesh.labels, list(gone))]
    return np.hstack([mesh.points[kept[:, 0]], mesh.points[kept[:, 1]]])


def distance_to(points, segments):
    """(R, S) distances of points (R, 2) to segments (S, 4)."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    length = np.maximum((along**2).sum(1), 1e-300)
    offset = points[:, None, :] - start
    share = np.clip((offset * along).sum(2) / length, 0, 1)
    return np.sqrt(((offset - share[:, :, None] * along)**2).sum(2))


def wall_overlap(table, segments, period=(0.0, 0.0)):
    """(depth in radii, row) of the deepest overlap of a disk and a wall; (0, -1) if none."""
    x, r = wrapped(table, segments, period), table["radius"]
    worst, where = 0.0, -1
    step = max(1, CHUNK // max(len(segments), 1))
    for k in range(0, len(x) if len(segments) else 0, step):
        depth = (r[k:k + step] - distance_to(x[k:k + step], segments).min(axis=1)) / r[k:k + step]
        best = int(np.argmax(depth))
        if depth[best] > worst:
            worst, where = float(depth[best]), k + best
    return worst, where


def wrapped(table, segments, period):
    """Centres (R, 2), brought back into the periodic box."""
    x = np.column_stack([table["x"], table["y"]])
    for axis in (0, 1):
        if period[axis] > 0:
            low = min(segments[:, axis].min(), segments[:, axis + 2].min()) if len(segments) else 0.0
            x[:, axis] = low + np.mod(x[:, axis] - low, period[axis])
    return x


def pair_overlap(table, period=(0.0, 0.0)):
    """(depth in radii, row, id, id) of the deepest overlap of two disks; (0, -1, -1, -1) if none."""
    found = (0.0, -1, -1, -1)
    order = np.argsort(table["t"], kind="stable")
    _, first = np.unique(table["t"][order], return_index=True)
    for rows in np.split(order, first[1:]):
        if len(rows) < 2:
            continue
        r = table["radius"][rows]
        apart = []
        for axis, name in enumerate("xy"):
            d = table[name][rows][:, None] - table[name][rows]
            apart.append(d - period[axis] * np.round(d / period[axis]) if period[axis] > 0 else d)
        depth = (r[:, None] + r - np.hypot(*apart)) / np.minimum(r[:, None], r)
        np.fill_diagonal(depth, -np.inf)
        i, j = np.unravel_index(np.argmax(depth), depth.shape)
        if depth[i, j] > found[0]:
            found = (float(depth[i, j]), int(rows[i]), int(table["id"][rows[i]]), int(table["id"][rows[j]]))
    return found


def crossing(table, segments):
    """(t, id) of the first centre whose way from row to row crosses a wall; None if none does."""
    if not len(segments):
        return None
    for one in np.unique(table["id"]):
        rows = np.flatnonzero(table["id"] == one)
        rows = rows[np.argsort(table["t"][rows], kind="stable")]
        x = np.column_stack([table["x"][rows], table["y"][rows]])
        a, b, c, d = x[:-1, None], x[1:, None], segments[None, :, :2], segments[None, :, 2:]
        cut = (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)
        hit = np.flatnonzero(cut.any(axis=1))
        if len(hit):
            return float(table["t"][rows[hit[0] + 1]]), int(one)
    return None


def side(p, q, at):
    """Which side of the line p q a point lies on: > 0 left, < 0 right."""
    return (q[..., 0] - p[..., 0]) * (at[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (at[..., 0] - p[..., 0])
