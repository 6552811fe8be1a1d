"""An orifice plate in a round pipe: coefficient of discharge and lasting loss against ISO 5167-2.

The standard's equation of Reader-Harris and Gallagher has an uncertainty of half a per cent; the k-epsilon model is the larger
error. The bounds were set before the runs, except that of an opening of 0.5 at a Reynolds number of 1e5, whose result was known.
"""
import math

from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed

CASE, SOURCE = "cases/orifice_plate.edp", "ISO 5167-2:2003, equation (4)"
POINTS = ((0.3, 1e5), (0.5, 1e5), (0.7, 1e5), (0.6, 1e6))  # opening, Reynolds number
DISCHARGE, LOSS = 0.02, 0.03  # relative; of the pressure drop


def discharge_of(opening, reynolds):
    """C of Reader-Harris and Gallagher for corner taps in a pipe wider than 71.12 mm."""
    reduced = (19000 * opening / reynolds) ** 0.8
    return (0.5961 + 0.0261 * opening**2 - 0.216 * opening**8 + 0.000521 * (1e6 * opening / reynolds) ** 0.7
            + (0.0188 + 0.0063 * reduced) * opening**3.5 * (1e6 / reynolds) ** 0.3)


def loss_of(opening, discharge):
    """The lasting part of the pressure drop between the taps (the same standard, equation (8))."""
    root = math.sqrt(1 - opening**4 * (1 - discharge**2))
    return (root - discharge * opening**2) / (root + discharge * opening**2)


def draw(found, path):
    """C and the lasting loss over the opening: the standard as lines."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.1), layout="constrained")
    openings = [0.25 + 0.01 * k for k in range(49)]
    for k, reynolds in enumerate((1e5, 1e6)):
        standard = [discharge_of(b, reynolds) for b in openings]
        mine = [(b, run.folder.results) for (b, re), run in found.items() if re == reynolds]
        for axes, line, name in ((left, standard, "discharge"), (right, [loss_of(b, c) for b, c in zip(openings, standard)],
            "loss_share")):
            axes.plot(openings, line, color=curve(k)["color"], linestyle=curve(k)["linestyle"],
                label=f"ISO 5167-2, Re {reynolds:.0e}")
            axes.plot([b for b, _ in mine], [r[name] for _, r in mine], "os"[k], color=curve(k)["color"],
                label=f"computed, Re {reynolds:.0e}")
    left.set_ylim(0.58, 0.63)
    left.set_ylabel("coefficient of discharge C")
    right.set_ylabel("lasting loss over pressure drop")
    for axes in (left, right):
        axes.set_xlabel("d/D")
        axes.grid(True)
    left.legend(loc="lower left", fontsize="small")
    return save(figure, path)


def orifice_plate(context):
    """Coefficient of discharge and lasting loss of an orifice plate over opening and Reynolds number."""
    found = {}
    for opening, reynolds in POINTS:
        try:
            found[opening, reynolds] = context.run(CASE, {"-opening": opening, "-reynolds": reynolds},
                f"{opening:g}_{reynolds:.0e}")
        except Failed as problem:
            yield context.failed(f"d/D = {opening:g}, Re {reynolds:.0e}: C", SOURCE, discharge_of(opening, reynolds), problem)
    path = draw(found, context.figure_path("discharge"))
    for (opening, reynolds), run in found.items():
        name, standard, cost = f"d/D = {opening:g}, Re {reynolds:.0e}", discharge_of(opening, reynolds), {"cpu_s": run.cpu_s,
            "figure": path}
        yield context.row(f"{name}: C", SOURCE, standard, run.folder.results["discharge"], rtol=DISCHARGE, **cost)
        yield context.row(f"{name}: lasting loss over the pressure drop", "ISO 5167-2:2003, equation (8)",
            loss_of(opening, standard), run.folder.results["loss_share"], atol=LOSS, **cost)


VALIDATIONS = [orifice_plate]
