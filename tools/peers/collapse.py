"""A granular collapse by the discrete element method, from the column that a run of the suite has released.

    FreeFem++ -nw cases/granular_collapse.edp -number 160 -tend 1.2 -out RUN
    python -m tools.peers.collapse RUN 1e7 OUT          1e7: Young's modulus, Pa; OUT: a folder

Prints the run-out over the half width by both programs, of the disks that hang together and of 95 % of all disks, and the
CPU time of LIGGGHTS.
"""
import sys

import numpy as np
from scipy.sparse.csgraph import connected_components

from tools.base.command import BadInput, guarded
from tools.base.run_folder import RunFolder
from tools.peers import with_liggghts

ROWS = 5
HEAD = "time (s)   hang together: suite, LIGGGHTS   95 % of all: suite, LIGGGHTS"


def extent(x, y, r):
    """Width of the disks that hang together, the largest group with gaps below 0.05 mean radii, m; x, y, r (N)."""
    near = np.hypot(x[:, None] - x, y[:, None] - y) - r[:, None] - r < 0.05 * r.mean()
    part = connected_components(near)[1]
    main = part == np.bincount(part).argmax()
    return (x + r)[main].max() - (x - r)[main].min()


def column(x, y, r):
    """(half width, height) of a column, m."""
    half = ((x + r).max() - (x - r).min()) / 2
    return half, np.sort(y + r)[-max(2, int(half / r.mean()) // 2):].mean()


def run_outs(x, y, radius, half):
    """(run-out of the disks that hang together, that of 95 % of all), over the half width."""
    return extent(x, y, radius) / 2 / half - 1, np.quantile(np.abs(x), 0.95) / half - 1


def compare(run, young, folder):
    """(aspect ratio at the release, rows of (time after the release, suite's two run-outs, LIGGGHTS's two), CPU s of LIGGGHTS)."""
    release, ending = (RunFolder(run).parameter(name, np.nan) for name in ("-release", "-tend"))
    if not ending > release:
        raise BadInput(f"{run} is no collapse, or it ends before the release")
    (x, y), radius, _ = with_liggghts.start(run, release, [0])
    half, top = column(x, y, radius)
    times, places, _, done = with_liggghts.compute(run, young, folder, (ending - release) / ROWS, ending - release, at=release,
        kept=[0])
    table = RunFolder(run).particles
    rows = []
    for time, centres in zip(times[1:], places[1:]):
        now = table["t"][np.abs(table["t"] - release - time).argmin()]
        own = table["t"] == now
        rows.append([now - release, *run_outs(table["x"][own], table["y"][own], radius, half), *run_outs(*centres.T, radius, half)])
    return top / half, rows, done.cpu_s


def main():
    """The command."""
    try:
        run, young, folder = sys.argv[1], float(sys.argv[2]), sys.argv[3]
    except (IndexError, ValueError):
        raise BadInput("usage: python -m tools.peers.collapse RUN YOUNG OUT") from None
    ratio, rows, cpu = compare(run, young, folder)
    print(f"aspect ratio {ratio:.2f}; LIGGGHTS: {cpu:.3g} s of CPU\n{HEAD}")
    for time, own, own95, other, other95 in rows:
        print(f"{time:8.2f} {own:20.2f} {other:10.2f} {own95:19.2f} {other95:10.2f}")


if __name__ == "__main__":
    guarded(main)
