"""A cylinder that moves slowly beside a plane: drag and torque against the exact ones of Jeffrey & Onishi (1981).

The bounds were set after one gap (half a radius) had been computed, before all others. At a gap of a tenth of the radius, less than
an element, the resistance of the film is added (-film 1).
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of, last

CASE, SOURCE = "cases/cylinder_beside_wall.edp", "Jeffrey & Onishi 1981, exact"
GAPS, NARROW = (2.0, 1.0, 0.5, 0.25, 0.1), 0.2
COLUMN = {"along": ("along", "drag along the plane"), "towards": ("away", "drag towards it"), "rotating": ("torque",
    "torque of rotation")}
ALLOWED = {"along": 0.02, "towards": 0.01, "rotating": 0.01}
ALLOWED_NARROW = 0.05


def exact(motion, gap):
    """Force or torque over that of a unit velocity; gap: over the radius, a number or an array."""
    a = np.arccosh(1 + gap)
    return 4 * np.pi / {"along": a, "towards": a - np.tanh(a), "rotating": np.tanh(a)}[motion]


def cylinder_beside_wall(context):
    """Stokes drag and torque on a cylinder beside a plane, over the gap, 16 elements per diameter."""
    figure, axes = axes_of()
    rows = []
    for k, (motion, (column, words)) in enumerate(COLUMN.items()):
        found = []
        for gap in GAPS:
            name, target = f"gap of {gap:g} R: {words}", exact(motion, gap)
            try:
                run = context.run(CASE, {"-gap": gap, "-motion": motion, "-film": int(gap < NARROW)}, f"{motion}_{gap:g}")
            except Failed as problem:
                rows.append(context.failed(name, SOURCE, target, problem))
                continue
            found.append((gap, abs(last(run, "summary", column))))
            rows.append(context.row(name, SOURCE, target, found[-1][1], rtol=ALLOWED_NARROW if gap < NARROW else ALLOWED[motion],
                cpu_s=run.cpu_s))
        if found:
            axes.plot(*np.transpose(found), "osD"[k], color=curve(k)["color"], label=words)
        gaps = np.geomspace(0.07, 3, 100)
        axes.plot(gaps, exact(motion, gaps), color="black", linewidth=0.8, label="exact" if k == 2 else None)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("gap / R")
    axes.set_ylabel("force / ($\\mu$ U), torque / ($\\mu$ $\\omega$ R²)")
    axes.legend(loc="upper right")
    yield from context.with_figure(rows, save(figure, context.figure_path("beside_wall")))


VALIDATIONS = [cylinder_beside_wall]
