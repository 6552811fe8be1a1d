"""Hard disks without friction that collide in pairs, one event after the other, to which contacts alone tend in short steps.

    FreeFem++ -nw cases/granular_collapse.edp -number 150 -release 0 -tend 0.4 -restitution 0.5 -friction 0 -every 0.08 -out RUN
    python -m tools.peers.event_driven RUN 1e-5

Prints the mean distance from the middle over the half width at the times of RUN, by both programs, from the first row of RUN on a
floor at y = 0. The last word is the time (s) within which a second collision of a disk keeps its energy: without it the
collisions of a crowd with a coefficient below 1 never end (Luding & McNamara, Granular Matter 1 (1998) 113). The limit is 0.
"""
import sys

import numpy as np

from tools.base.command import BadInput, guarded
from tools.base.run_folder import RunFolder


class Disks:
    """N disks with centres x, velocities v (N x 2, m, m/s), radii r (N, m) and masses of r^2; e: coefficient of restitution;
    gravity: m/s2, downwards; box: (left, right, floor, top), m; short: s, see above."""

    def __init__(self, x, v, r, e, gravity=0.0, box=(-np.inf, np.inf, -np.inf, np.inf), short=1e-6):
        self.x, self.v, self.r = np.array(x, float), np.array(v, float), r
        self.e, self.g, self.box, self.short = e, gravity, box, short
        self.mass, self.t, self.last = r * r, 0.0, np.full(len(r), -1.0)
        self.pairs, self.walls = np.full((len(r), len(r)), np.inf), np.full((len(r), 4), np.inf)
        for i in range(len(r)):
            self.predict(i)

    def predict(self, i):
        """The times of the next collisions of disk i. Disks fall alike, so that pairs move on straight lines."""
        d, w, gap = self.x - self.x[i], self.v - self.v[i], self.r + self.r[i]
        b, speed, c = (d * w).sum(1), (w * w).sum(1), (d * d).sum(1) - gap * gap
        root = b * b - speed * c
        meets = (b < 0) & (root > 0)
        meets[i] = False
        time = np.full(len(b), np.inf)
        time[meets] = np.maximum(0, c[meets]) / (np.sqrt(root[meets]) - b[meets])
        self.pairs[i] = self.pairs[:, i] = self.t + time
        for wall, (axis, sign) in enumerate(((0, -1), (0, 1), (1, -1), (1, 1))):
            way, speed = max(0.0, sign * (self.box[wall] - self.x[i, axis]) - self.r[i]), sign * self.v[i, axis]
            pull = -sign * self.g if axis else 0.0  # way = speed t + pull t^2/2
            root = speed * speed + 2 * pull * way if np.isfinite(way) else -1.0
            time = np.inf
            if pull > 0 and root >= 0:
                time = (np.sqrt(root) - speed) / pull
            elif speed > 0 and root >= 0:
                time = 2 * way / (speed + np.sqrt(root))
            self.walls[i, wall] = self.t + time

    def fly(self, t):
        """Moves all disks freely to the time t, s."""
        dt = t - self.t
        self.x += self.v * dt
        self.x[:, 1] -= 0.5 * self.g * dt * dt
        self.v[:, 1] -= self.g * dt
        self.t = t

    def advance(self, end):
        """Collisions until the time `end`, s; returns their number."""
        hits = 0
        while True:
            pair, wall = self.pairs.argmin(), self.walls.argmin()
            t = min(self.pairs.flat[pair], self.walls.flat[wall])
            if t > end:
                self.fly(end)
                return hits
            self.fly(t)
            hits += 1
            if self.pairs.flat[pair] <= self.walls.flat[wall]:
                touched = divmod(pair, len(self.r))
                i, j = touched
                normal = self.x[i] - self.x[j]
                normal /= np.hypot(*normal)
                e = 1.0 if t - self.last[[i, j]].max() < self.short else self.e
                impulse = -(1 + e) * (self.v[i] - self.v[j]) @ normal / (1 / self.mass[i] + 1 / self.mass[j])
                self.v[i] += impulse / self.mass[i] * normal
                self.v[j] -= impulse / self.mass[j] * normal
            else:
                i, wall = divmod(wall, 4)
                touched = (i,)
                self.v[i, wall // 2] *= -1.0 if t - self.last[i] < self.short else -self.e
            for one in touched:
                self.last[one] = t
                self.predict(one)

    def energy(self):
        """Kinetic energy, kg m2/s2 for the masses r^2."""
        return 0.5 * (self.mass[:, None] * self.v**2).sum()


def by_events(run, short):
    """Rows of (time in s, mean distance from the middle over the half width in the run, by events, collisions) of a run of contacts
    alone without friction on a floor at y = 0; short: s, see above. Raises BadInput where the run has friction."""
    folder = RunFolder(run)
    table = folder.particles
    gravity, e, friction = (folder.parameter(name, 0.0) for name in ("-gravity", "-restitution", "-friction"))
    if friction > 0:
        raise BadInput(f"{run} has friction")
    times = np.unique(table["t"])
    rows = [{name: table[name][table["t"] == t] for name in ("x", "y", "u", "v", "radius")} for t in times]
    first, radius = rows[0], rows[0]["radius"]
    half = ((first["x"] + radius).max() - (first["x"] - radius).min()) / 2
    disks = Disks(np.column_stack([first["x"], first["y"]]), np.column_stack([first["u"], first["v"]]), radius, e, gravity,
        (-np.inf, np.inf, 0.0, np.inf), short)
    for t, row in zip(times[1:], rows[1:]):
        hits = disks.advance(t)
        yield t, *(np.average(np.abs(x), weights=radius**2) / half for x in (row["x"], disks.x[:, 0])), hits


def main():
    """The command."""
    try:
        run, short = sys.argv[1], float(sys.argv[2])
    except (IndexError, ValueError):
        raise BadInput("usage: python -m tools.peers.event_driven RUN TIME") from None
    print("time (s)   mean distance: suite, by events   collisions")
    for t, suite, exact, hits in by_events(run, short):
        print(f"{t:8.3f}{suite:16.3f}{exact:16.3f}{hits:16d}", flush=True)


if __name__ == "__main__":
    guarded(main)
