"""A cylinder on springs in a stream, shaken by its vortices: amplitude and frequency of its swings.

Body-fitted: tools/peers/body_fitted/sprung_cylinder.edp, which shares no code with the suite; a period of its path stands in
tests/reference/sprung_cylinder_body_fitted.csv, with how far it is refined.
"""
from collections import namedtuple

import numpy as np

from tools.base.command import ROOT
from tools.base.tables import read_table
from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed

CASE, SOURCE = "cases/sprung_cylinder.edp", "body-fitted P2/P1"
REST_X, REST_Y = 5.5, 6.0
Swings = namedtuple("Swings", "amplitude frequency shift")
NAMES = Swings("amplitude across the stream (D)", "frequency (U/D)", "mean displacement along the stream (D)")
FITTED = Swings(0.549, 0.1678, 0.4870)  # extrapolated
ALLOWED = {12: Swings(0.06, 0.03, 0.02), 24: Swings(0.03, 0.01, 0.01)}  # elements per diameter: relative errors


def last_periods(t, x, y, number):
    """(first row, row after the last, period) of the last full periods, which begin where y goes up through the middle."""
    off = y - REST_Y
    up = np.flatnonzero((off[:-1] < 0) & (off[1:] >= 0))
    if len(up) <= number:
        raise Failed(f"{max(len(up) - 1, 0)} full periods instead of {number}")
    at = t[up] - off[up] * (t[up + 1] - t[up]) / (off[up + 1] - off[up])
    return up[-1 - number] + 1, up[-1] + 1, (at[-1] - at[-1 - number]) / number


def swings(t, x, y, number=2):
    """Amplitude, frequency and displacement along the stream over the last periods."""
    first, end, period = last_periods(t, x, y, number)
    return Swings(np.ptp(y[first:end]) / 2, 1 / period, x[first:end].mean() - REST_X)


def sprung_cylinder(context):
    """Amplitude, frequency and displacement of a cylinder on springs in a stream at Reynolds number 100."""
    figure, (over_time, path) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.1), layout="constrained", sharey=True)
    rows = []
    for k, (cells, allowed) in enumerate(ALLOWED.items()):
        try:
            run = context.run(CASE, {"-dt": 0.6 / cells, "-tend": 36}, f"cells_{cells}", mesh=("sprung_cylinder", 1 / cells))
            track = next(iter(run.folder.tracks.values()))
            t, x, y = track["t"], track["x"], track["y"]
            found = swings(t, x, y)
        except Failed as problem:
            rows.append(context.failed(f"{cells} elements per diameter: {NAMES.amplitude}", SOURCE, FITTED.amplitude, problem))
            continue
        first, end, _ = last_periods(t, x, y, 1)
        over_time.plot(t[first:end] - t[first], y[first:end] - REST_Y, **curve(k), label=f"{cells} elements per diameter")
        path.plot(x[first:end] - REST_X, y[first:end] - REST_Y, **curve(k))
        rows += [context.row(f"{cells} elements per diameter: {name}", SOURCE, target, value, rtol=rtol, cpu_s=run.cpu_s)
                 for name, target, value, rtol in zip(NAMES, FITTED, found, allowed)]
    table = read_table(ROOT / "tests" / "reference" / "sprung_cylinder_body_fitted.csv")
    dots = {"markersize": 3, "markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 0.7}
    over_time.plot(table["t"][::2], table["y"][::2] - REST_Y, "o", **dots, label="body-fitted")
    path.plot(table["x"] - REST_X, table["y"] - REST_Y, "o", **dots)
    over_time.set_xlabel("t U/D over a period")
    over_time.set_ylabel("displacement across the stream (D)")
    path.set_xlabel("displacement along the stream (D)")
    for axes in (over_time, path):
        axes.grid(True)
    figure.legend(*over_time.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    yield from context.with_figure(rows, save(figure, context.figure_path("swings")))


VALIDATIONS = [sprung_cylinder]
