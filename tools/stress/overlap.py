"""Overlap of disks and ellipses with each other and with walls, from particles.csv and shapes.csv alone.

Written apart from lib/: what a run says of its own gaps is not asked. Depths are in radii
of the smaller disk, semi-minor axes of the slimmer ellipse; times in s. Of ellipses points on the outlines are
looked for in other bodies; a body is brought to a unit circle, and what may lie in it with it.
"""
from pathlib import Path

import numpy as np

from tools.base.mesh_files import OPEN
from tools.meshing.labels import LABELS

PAIRED = {0: (LABELS["left"], LABELS["right"]), 1: (LABELS["bottom"], LABELS["top"])}
CHUNK = 2_000_000  # entries of an array at a time
OUTLINE = np.linspace(0, 2 * np.pi, 361)[:-1]


def aspects(run, table):
    """Minor over major axis of each row, by shapes.csv; None if all are round."""
    found = np.array([run.aspect(one) for one in table["id"]])
    return found if len(found) and found.min() < 1 else None


def to_circle(table, row, aspect, points):
    """Points (..., 2) where the body of a row is the unit circle."""
    c, s = np.cos(table["theta"][row]), np.sin(table["theta"][row])
    x, y = points[..., 0] - table["x"][row], points[..., 1] - table["y"][row]
    return np.stack([c * x + s * y, (c * y - s * x) / aspect[row]], axis=-1) / table["radius"][row]


def outline(table, row, aspect):
    """Points on the edge of the body of a row."""
    c, s, r = np.cos(table["theta"][row]), np.sin(table["theta"][row]), table["radius"][row]
    x, y = r * np.cos(OUTLINE), r * aspect[row] * np.sin(OUTLINE)
    return np.stack([table["x"][row] + c * x - s * y, table["y"][row] + s * x + c * y], axis=-1)


def ellipse_pair(table, i, j, aspect, shift):
    """Depth in semi-minor axes of the slimmer of two bodies in each other; shift (2) brings the first to the image near the
    second."""
    minor = table["radius"] * aspect
    deep = [depth_in(table, a, aspect, outline(table, b, aspect) + s).max() for a, b, s in ((i, j, -shift), (j, i, shift))]
    return max(deep) / min(minor[i], minor[j])


def depth_in(table, row, aspect, points):
    """Depths of points (n, 2) in the body of a row, below 0 outside: to first order in them, by the level set and its gradient."""
    z = to_circle(table, row, aspect, points)
    r = np.maximum(np.hypot(z[:, 0], z[:, 1]), 1e-300)
    slope = np.hypot(z[:, 0], z[:, 1] / aspect[row]) / (r * table["radius"][row])  # |grad r|
    return (1 - r) / slope


def solid_segments(run, period=(0.0, 0.0)):
    """(S, 4) walls of a run folder: walls.csv, else the edges of mesh.mesh that are neither
    open ends nor sides with an image."""
    if run.has("walls"):
        return run.walls.reshape(-1, 4)
    if not (Path(run.folder) / "mesh.mesh").is_file():
        return np.zeros((0, 4))
    mesh = run.mesh
    gone = set(OPEN) | {label for axis in (0, 1) if period[axis] > 0 for label in PAIRED[axis]}
    kept = mesh.edges[~np.isin(mesh.labels, list(gone))]
    return np.hstack([mesh.points[kept[:, 0]], mesh.points[kept[:, 1]]])


def nearest_on(points, segments):
    """(R, S) shares of the way along segments (S, 4) at which they come nearest to points (R, 2)."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    length = np.maximum((along**2).sum(1), 1e-300)
    return np.clip(((points[:, None, :] - start) * along).sum(2) / length, 0, 1)


def distance_to(points, segments):
    """(R, S) distances of points (R, 2) to segments (S, 4)."""
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    return np.sqrt(((points[:, None, :] - start - nearest_on(points, segments)[:, :, None] * along)**2).sum(2))


def wall_overlap(table, segments, period=(0.0, 0.0), aspect=None):
    """(depth in radii, row) of the deepest overlap of a disk and a wall; (0, -1) if none. aspect: those of the rows, for
    ellipses."""
    if aspect is not None:
        return ellipse_walls(table, segments, period, aspect)
    x, r = wrapped(table, segments, period), table["radius"]
    worst, where = 0.0, -1
    step = max(1, CHUNK // max(len(segments), 1))
    for k in range(0, len(x) if len(segments) else 0, step):
        depth = (r[k:k + step] - distance_to(x[k:k + step], segments).min(axis=1)) / r[k:k + step]
        best = int(np.argmax(depth))
        if depth[best] > worst:
            worst, where = float(depth[best]), k + best
    return worst, where


def ellipse_walls(table, segments, period, aspect):
    """wall_overlap of ellipses."""
    worst, where = 0.0, -1
    x = wrapped(table, segments, period)
    here = {**table, "x": x[:, 0], "y": x[:, 1]}
    for k in range(len(x) if len(segments) else 0):
        ends = to_circle(here, k, aspect, segments.reshape(-1, 2, 2)).reshape(-1, 4)
        share = nearest_on(np.zeros((1, 2)), ends)[0, :, None]
        near = segments[:, :2] + share * (segments[:, 2:] - segments[:, :2])  # of each wall the point deepest in the ellipse
        depth = depth_in(here, k, aspect, near).max() / (here["radius"][k] * aspect[k])
        if depth > worst:
            worst, where = float(depth), k
    return worst, where


def wrapped(table, segments, period):
    """Centres (R, 2), brought back into the periodic box."""
    x = np.column_stack([table["x"], table["y"]])
    for axis in (0, 1):
        if period[axis] > 0:
            low = min(segments[:, axis].min(), segments[:, axis + 2].min()) if len(segments) else 0.0
            x[:, axis] = low + np.mod(x[:, axis] - low, period[axis])
    return x


def pair_overlap(table, period=(0.0, 0.0), aspect=None):
    """(depth in radii, row, id, id) of the deepest overlap of two disks; (0, -1, -1, -1) if none. aspect: those of the rows, for
    ellipses."""
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
        if aspect is not None:
            for i, j in zip(*np.nonzero(depth > 0)):
                shift = np.array([d[i, j] for d in apart]) - [table[name][rows[i]] - table[name][rows[j]] for name in "xy"]
                depth[i, j] = ellipse_pair(table, rows[i], rows[j], aspect, shift) if i < j else -np.inf
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
