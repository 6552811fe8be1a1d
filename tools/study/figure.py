"""The figure of a refinement study: error over element size, time step and CPU time."""
import math
import re
import textwrap

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullFormatter, NullLocator

from tools.base.expressions import is_expression
from tools.base.run_folder import RunFolder
from tools.plot.style import MARKERS, PAGE_WIDTH, curve, plt, save
from tools.study.convergence import pareto
from tools.study.report import against, assumed, error_of


def units_of(records):
    """Unit names of the first run that ended."""
    for record in records:
        if record["status"] == 0:
            return dict(RunFolder(record["run"]).units)
    return {"length": "m", "time": "s"}


def words_of(quantity):
    """A quantity's name in words, without its numbers."""
    if is_expression(quantity):
        table, *words = quantity.split(":")
        return " ".join([*words, f"({table})"]).replace("_", " ")
    return quantity.removeprefix("result:").split(":")[0].replace("_", " ")


def plain(axis, values=None):
    """A log axis with plain numbers: the values themselves if they are few, else 1, 2, 5
    of each decade, else the decades."""
    low, high = axis.get_view_interval()
    values = sorted(set(values or ()))
    if values and len(values) <= 6 and all(b > 1.15 * a for a, b in zip(values, values[1:])):
        axis.set_major_locator(FixedLocator(values))
        axis.set_minor_locator(NullLocator())
    elif high < 2 * low:
        axis.set_major_locator(MaxNLocator(4))
    elif high < 1000 * low:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high > 8 * low else (1, 1.5, 2, 3, 5, 7)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.4g}"))
    axis.set_minor_formatter(NullFormatter())


def slopes(axes, sizes, top):
    """Grey lines of order 1 and 2, a little above the largest error at the largest size, where no data lie on them."""
    h = np.array([min(sizes), max(sizes)])
    for order, dash in ((1, (0, (1, 1.5))), (2, (0, (4, 2)))):
        axes.plot(h, 1.4 * top * (h / h[1]) ** order, color="#808080", linewidth=0.9, linestyle=dash, zorder=1,
                  label=f"order {order}")


def draw_cost(axes, rows, error, length):
    """The errors, by the id of a record, over the CPU time; a line joins the runs that no cheaper one beats. length: its unit."""
    timed = [r for r in rows if math.isfinite(r["cpu_s"]) and r["cpu_s"] > 0]
    for k, size in enumerate(sorted({r["meshsize"] for r in timed}, key=lambda v: -(v or 0))):
        some = [r for r in timed if r["meshsize"] == size]
        axes.plot([r["cpu_s"] for r in some], [error[id(r)] for r in some], linestyle="none",
                  marker=MARKERS[k % len(MARKERS)], markersize=6, color=curve(k)["color"],
                  label=f"element size {size:.4g} {length}".rstrip() if size is not None else "runs")
    front = [timed[k] for k in pareto([r["cpu_s"] for r in timed], [error[id(r)] for r in timed])]
    if len(front) > 1:
        axes.plot([r["cpu_s"] for r in front], [error[id(r)] for r in front], color="#808080", linewidth=1, zorder=1,
                  label="no cheaper run is better")
    axes.set_xlabel("CPU time (s)")


def draw_study(study, records, quantity, reference, uncertainty):
    """Write study_QUANTITY.png; returns its path, None if no run has a finite error."""
    percent = 100 / abs(reference) if reference else 1.0
    error = {id(r): percent * abs(error_of(study, records, quantity, r, reference)) for r in records}
    rows = [r for r in records if 0 < error[id(r)] < math.inf]
    if not rows:
        return None
    units = units_of(records)
    size_unit = {None: units["length"], "-cells": "1/cells"}.get(study.by, f"that of {study.by}")
    units["length"] = units["length"] if study.by is None else ""  # behind a number: whatever the case's own option takes
    what = against(study, records, quantity)
    kind, of = ("difference", "the finest run") if what == "the finest run" else ("error", "the limit")
    label = "\n".join(textwrap.wrap(f"{kind} of {words_of(quantity)}" + (" (%)" if reference else ""), 30))
    axes_of = [(key, other, name) for key, other, name in (
        ("meshsize", "dt", f"element size ({size_unit})"), ("dt", "meshsize", f"time step ({units['time']})"))
        if len({r[key] for r in rows if r[key] is not None}) > 1]
    number = len(axes_of) + 1
    figure, panels = plt.subplots(1, number, figsize=(min(PAGE_WIDTH * 1.25, 3.1 * number + 0.4), 3.3), sharey=True,
                                  layout="constrained", squeeze=False)
    panels = panels[0]
    for axes, (key, other, name) in zip(panels, axes_of):
        for k, fixed in enumerate(sorted({r[other] for r in rows}, key=lambda v: -(v or 0))):
            line = sorted((r[key], error[id(r)]) for r in rows if r[other] == fixed and r[key] is not None)
            word = {"dt": "time step", "meshsize": "element size"}[other]
            axes.plot(*zip(*line), marker=MARKERS[k % len(MARKERS)], markersize=5, **curve(k),
                      label=f"{word} {fixed:.4g} {units['time' if other == 'dt' else 'length']}".rstrip() if fixed is not None
                          else f"error over {name.split(' (')[0]}")
        slopes(axes, [r[key] for r in rows if r[key] is not None], max(error[id(r)] for r in rows))
        axes.set_xlabel(name)
    draw_cost(panels[-1], rows, error, units["length"])
    for axes in panels:
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.margins(x=0.12)
        axes.grid(True)
        if math.isfinite(uncertainty) and uncertainty > 0 and not study.references:
            axes.axhspan(0, percent * uncertainty, color="#dddddd", zorder=0, label=f"uncertainty of {of}")
    values = [error[id(r)] for r in rows]
    panels[0].set_ylim(0.5 * min(values), 2.0 * max(values))
    for axes, (key, _, _) in zip(panels, axes_of):
        plain(axes.xaxis, [r[key] for r in rows if r[key] is not None])
    plain(panels[-1].xaxis)
    for axes in panels:
        axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=1)
    plain(panels[0].yaxis)
    panels[0].set_ylabel(label)
    guess = f"\n(order {study.formal_order:g} assumed, none observed: the slopes of the lines show nothing)" if assumed(study,
        records, quantity) else ""
    figure.suptitle(f"{study.case.replace('_', ' ')}: {quantity} against {what} {reference:.6g}{guess}", fontsize=10)
    return save(figure, study.out / f"study_{re.sub('[^A-Za-z0-9_.-]+', '_', quantity)}.png")
