"""A granular collapse by the discrete element method, from the column that a run of the suite has released.

    FreeFem++ -nw cases/granular_collapse.edp -number 160 -tend 1.2 -out RUN
    python -m tools.peers.collapse RUN 1e7 OUT          1e7: Young's modulus, Pa; OUT: a folder
    python -m tools.peers.collapse RUN 1e7 OUT 1.25     so many seconds after the release, which RUN need not reach

Prints the mean distance from the middle and the run-out over the half width by both programs, of the disks that hang together and
of 95 % of all disks, and the CPU time of LIGGGHTS; nan where RUN has no row at the time. The aspect ratio of a loose column
(-release 0) is that of the same disks at a solid fraction of 0.82.
"""
import sys

import numpy as np
from scipy.sparse.csgraph import connected_components

from tools.base.command import BadInput, guarded
from tools.base.run_folder import RunFolder
from tools.peers import with_liggghts

ROWS, DENSE = 5, 0.82
HEAD = "time (s)   mean distance: suite, LIGGGHTS   hang together: suite, LIGGGHTS   95 % of all: suite, LIGGGHTS"


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
    """(mean distance from the middle, run-out of the disks that hang together, that of 95 % of all), over the half width."""
    mean = np.average(np.abs(x), weights=radius**2) / half
    return mean, extent(x, y, radius) / 2 / half - 1, np.quantile(np.abs(x), 0.95) / half - 1


def compare(run, young, folder, span=None):
    """(aspect ratio at the release, rows of (time after the release, the suite's three run_outs, LIGGGHTS's three), CPU s of
    LIGGGHTS); span: s after the release."""
    release, ending = (RunFolder(run).parameter(name, np.nan) for name in ("-release", "-tend"))
    span = span or ending - release
    if not span > 0:
        raise BadInput(f"{run} is no collapse, or it ends before the release")
    (x, y), radius, _ = with_liggghts.start(run, release, [0])
    half, top = column(x, y, radius)
    if release == 0:
        top = np.pi * (radius**2).sum() / (2 * DENSE * half)
    times, places, _, done = with_liggghts.compute(run, young, folder, span / ROWS, span, at=release, kept=[0])
    table = RunFolder(run).particles
    rows = []
    for time, centres in zip(times[1:], places[1:]):
        now = table["t"][np.abs(table["t"] - release - time).argmin()]
        own = table["t"] == now
        known = abs(now - release - time) < 0.02 * span
        suite = run_outs(table["x"][own], table["y"][own], radius, half) if known else [np.nan] * 3
        rows.append([time, *suite, *run_outs(*centres.T, radius, half)])
    return top / half, rows, done.cpu_s


def main():
    """The command."""
    try:
        run, young, folder, *span = sys.argv[1:5]
        young, span = float(young), float(span[0]) if span else None
    except ValueError:
        raise BadInput("usage: python -m tools.peers.collapse RUN YOUNG OUT [TIME]") from None
    ratio, rows, cpu = compare(run, young, folder, span)
    print(f"aspect ratio {ratio:.2f}; LIGGGHTS: {cpu:.3g} s of CPU\n{HEAD}")
    for time, *values in rows:
        print(f"{time:8.2f}" + "".join(f"{own:18.3f} {other:10.3f}  " for own, other in zip(values[:3], values[3:])))


if __name__ == "__main__":
    guarded(main)
