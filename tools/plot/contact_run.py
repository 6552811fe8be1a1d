"""A run of contacts alone as frames: columns, walls and view at each time that was written."""
from functools import cached_property

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.plot.colour import Look

FIGURE_TIMES = [0, 1, 10, 20, 60, 80, 100]  # of the falling particles


class ContactRun(RunFolder):
    """A run folder with its frames: frame(k) is a dict of columns at times[k]."""

    upward = "y"

    @cached_property
    def _moves(self):
        return self.columns("wallmoves") if self.has("wallmoves") else None

    def walls_at(self, t):
        """Segments (S, 2, 2), those that have moved where they are at the time t."""
        walls = self.walls
        if self._moves is not None:
            walls, rows = walls.copy(), self._moves
            last = {int(-1 - rows["wall"][k]): k for k in np.flatnonzero(rows["t"] <= t * (1 + 1e-12))}
            later = max(last, default=-1) + 1 - len(walls)  # that came after the start
            if later > 0:
                walls = np.concatenate([walls, np.full((later, 2, 2), np.nan)])
            for wall, k in last.items():
                walls[wall] = [[rows["x1"][k], rows["y1"][k]], [rows["x2"][k], rows["y2"][k]]]
        return walls

    @cached_property
    def _starts(self):
        if not self.has("particles") or not len(self.columns("particles", "u", "v")["t"]):
            raise BadInput(f"the run {self.folder} has no particles.csv with rows")
        times, first = np.unique(self.particles["t"], return_index=True)
        return times, np.r_[first, len(self.particles["t"])]

    @property
    def times(self):
        """Times of the frames."""
        return self._starts[0]

    def rows(self, k):
        """Columns of particles.csv at the k-th time."""
        part = slice(self._starts[1][k], self._starts[1][k + 1])
        return {name: values[part] for name, values in self.particles.items()}

    def frame(self, k):
        """Columns of particles.csv at the k-th time, and the speed."""
        columns = self.rows(k)
        if any(self.period):
            rows = self.images(np.column_stack([np.arange(len(columns["x"])), *(columns[name] for name in ("x", "y", "theta",
                "radius", "radius"))]))
            columns = {name: values[rows[:, 0].astype(int)] for name, values in columns.items()} | {"x": rows[:, 1],
                "y": rows[:, 2]}
        columns["speed"] = np.hypot(columns["u"], columns["v"])
        return columns

    @cached_property
    def look(self):
        """Which bodies are held."""
        return Look(self)

    @cached_property
    def view(self):
        """(x0, x1, y0, y1) that holds every disk at every time."""
        p = self.particles
        x0, x1 = (p["x"] - p["radius"]).min(), (p["x"] + p["radius"]).max()
        y0, y1 = (p["y"] - p["radius"]).min(), (p["y"] + p["radius"]).max()
        room = 0.02 * max(x1 - x0, y1 - y0)
        sides = [(x0 - room, x1 + room), (y0 - room, y1 + room)]
        (x0, x1), (y0, y1) = [(low, low + period) if period > 0 else side for side, low, period in zip(sides, self.low,
            self.period)]
        return x0, x1, y0, y1

    @cached_property
    def speeds(self):
        """Ends of the colour scale: the greatest speed and a 1e-4 part of it."""
        top = float(np.hypot(self.particles["u"], self.particles["v"]).max())
        return (1e-4 * top, top) if top > 0 else (1e-4, 1.0)


def nearest(run, times):
    """Places of the frames nearest to the times, none twice."""
    return sorted({int(np.abs(run.times - t).argmin()) for t in times})


def chosen(run, number=8):
    """Times to show: those of the figure of falling particles where the run reaches them."""
    end = run.times[-1]
    return FIGURE_TIMES if abs(end - 100) < 1 else np.linspace(run.times[0], end, number)
