"""A disk nearly as wide as the channel in which it moves: Stokes drag, which the two gaps decide.

Body-fitted: tools/peers/body_fitted/cylinder_between_plates.edp, -fine 2, where -fine 1 differs by 0.02 % at most; the leading
term of lubrication theory, 9 sqrt(2) pi (R/g)^(5/2) mu U for the gaps g, is 5 to 22 % below. The bounds were set before the runs.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import FITTED, axes_of, last, steps

DRAG = {0.4: 1629.7, 0.45: 10814.4, 0.475: 66172.7}  # over mu U, by R/H
RUNS = ((0.4, 32, 0.02), (0.4, 64, 0.02), (0.45, 32, 0.05), (0.45, 64, 0.02), (0.475, 64, 0.05))  # R/H, H/h, bound


def lubrication(ratio):
    """The leading term for R/H near 1/2."""
    return 9 * np.sqrt(2) * np.pi * (ratio / (0.5 - ratio)) ** 2.5


def wide_disk(context):
    """Stokes drag on a disk nearly as wide as the channel, 1.6 to 6.4 elements in each gap."""
    figure, axes = axes_of()
    rows = []
    for ratio, cells, bound in RUNS:
        name = f"R/H = {ratio:g}, {cells * (0.5 - ratio):.1f} elements in each gap: F/(mu U)"
        try:
            run = context.run("cases/cylinder_between_plates.edp", {"-radius": ratio, "-x": 2.0, "-dt": 4 * steps(1 / cells),
                "-tend": 0.6 if cells == 32 else 0.3, "-every": 0.05}, f"{ratio:g}_{cells}",
                mesh=context.mesh("cylinder_between_plates", 1 / cells, "--length", "4"))
        except Failed as problem:
            rows.append(context.failed(name, FITTED, DRAG[ratio], problem))
            continue
        drag = last(run, "summary", "drag")
        axes.plot([0.5 - ratio], [drag], "os"[cells == 64], color=curve(cells == 64)["color"],
            label=f"{cells} elements from plate to plate" if ratio < 0.42 else None)
        rows.append(context.row(name, FITTED, DRAG[ratio], drag, rtol=bound, cpu_s=run.cpu_s))
    axes.plot([0.5 - r for r in DRAG], list(DRAG.values()), "k+", markersize=9, label=FITTED)
    gaps = np.geomspace(0.02, 0.12, 50)
    axes.plot(gaps, lubrication(0.5 - gaps), color="black", linewidth=0.8, label="lubrication, leading term")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks([0.5 - r for r in DRAG], [f"{0.5 - r:.3g}" for r in DRAG])
    axes.minorticks_off()
    axes.set_xlabel("gap / H")
    axes.set_ylabel("drag / ($\\mu$ U)")
    axes.legend(loc="upper right")
    yield from context.with_figure(rows, save(figure, context.figure_path("drag")))


VALIDATIONS = [wide_disk]
