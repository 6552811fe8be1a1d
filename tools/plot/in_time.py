"""The fields of a run at any time, the times of a film, and tracks that pass the seams of a period.

Between two snapshots the fields are linear in time, node by node, where both have the same
mesh; else the nearer one is taken. Before the first and after the last they are those.
"""
import numpy as np


class FieldsInTime:
    """The fields of a RunFolder: at(time) -> (mesh, {name: values})."""

    def __init__(self, run):
        self.run, self.read = run, {}
        self.times = np.array([t for t, _ in run.fields])

    def snapshot(self, k):
        """The k-th field file; the last two that were asked for are kept."""
        if k not in self.read:
            while len(self.read) > 1:
                self.read.pop(next(iter(self.read)))
            self.read[k] = self.run.field(k)
        self.read[k] = self.read.pop(k)  # the latest stands last
        return self.read[k]

    def at(self, time):
        """Mesh and values at a time, within 1e-6 of a snapshot those of the file."""
        high = int(np.clip(np.searchsorted(self.times, time), 0, len(self.times) - 1))
        low = max(high - 1, 0) if self.times[high] > time else high
        span = self.times[high] - self.times[low]
        share = float(np.clip((time - self.times[low]) / span, 0, 1)) if span > 0 else 0.0
        if share < 1e-6 or share > 1 - 1e-6:
            return self.snapshot(high if share > 0.5 else low)
        (mesh, before), (other, after) = self.snapshot(low), self.snapshot(high)
        if not np.array_equal(mesh.triangles, other.triangles) or not np.array_equal(mesh.points, other.points):
            return self.snapshot(high if share > 0.5 else low)
        return mesh, {name: (1 - share) * before[name] + share * after[name] for name in before if name in after}


def film_times(run):
    """The times (n,) of the frames of a film: those of the fields, or of the rows of the tables where bodies move and there are
    more rows than fields from the first field to the last one."""
    fields = np.array([t for t, _ in run.frames])
    if not run.fields or not run.has("particles") or not len(run.particles["t"]):
        return fields
    rows = np.unique(np.r_[run.particles["t"], run.fluid["t"] if run.has("fluid") else []])
    slack = 1e-5 * (fields[-1] - fields[0])
    rows = rows[(rows > fields[0] + slack) & (rows <= fields[-1] + slack)]
    rows = np.r_[fields[0], rows[np.r_[True, np.diff(rows) > slack]]] if len(rows) else fields
    return rows if len(rows) > len(fields) else fields


def broken(track, extent, period=(0, 0)):
    """A track as pieces (k, 2) in the domain, cut at its seams. Where the period is known a piece goes on for a
    row beyond the seam at either end, to be clipped there; else it ends where the table jumps over the seam."""
    points, period = np.column_stack([track["x"], track["y"]]), np.asarray(period, dtype=float)
    if not period.any():
        jumps = np.any(abs(np.diff(points, axis=0)) > 0.5 * np.asarray(extent[2:]), axis=1)
        return np.split(points, np.flatnonzero(jumps) + 1)
    cells = np.floor((points - extent[:2]) / np.where(period > 0, period, np.inf))
    cuts = [0, *np.flatnonzero(np.diff(cells, axis=0).any(axis=1)) + 1, len(points)]
    return [points[max(low - 1, 0):high + 1] - cells[low] * period for low, high in zip(cuts, cuts[1:])]
