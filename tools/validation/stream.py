"""A disk that falls while a stream carries it, against the same disk in a fluid at rest (Galileo's principle, exact).

Over the elements per diameter, the element Reynolds number c h/nu of the stream, and the displacement in a step. The
bounds are of this project, set after the runs had been seen: they guard against changes.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of, last

CASE, END, STREAM, DIAMETER = "cases/carried_disk.edp", 0.4, 1.0, 0.24
MOVES = (0.05, 0.1, 0.2, 0.4, 0.7, 1.3)  # of the stream in a step, in elements
# element size, viscosity: bounds on the loss of velocity with moves below 0.4, and from there on
SCENES = {(1 / 32, 0.005): (0.01, 0.01), (1 / 32, 0.002): (0.04, 0.02), (1 / 32, 0.001): (0.07, 0.035), (1 / 16, 0.005): (0.07,
    0.06)}


def loss(context, size, mu, move):
    """(how much more slowly the carried disk falls, of the velocity of the other; CPU time)."""
    dt = END / max(4, round(END / (move * size / STREAM)))
    found, cpu = [], 0
    for stream in (0, STREAM):
        run = context.run(CASE, {"-stream": stream, "-mu": mu, "-dt": dt, "-cfl": 0, "-tend": END, "-every": END,
            "-tolerance": 1e-6},
                          f"{size:g}_{mu:g}_{move:g}_{stream:g}", mesh=("periodic_box", size))
        found.append(last(run, "particles", "v"))
        cpu += run.cpu_s
    return 1 - found[1] / found[0], cpu


def carried_disk(context):
    """Velocity of fall of a disk that a stream carries, against the one in a fluid at rest."""
    figure, axes = axes_of()
    rows = []
    for k, ((size, mu), bounds) in enumerate(SCENES.items()):
        name = f"{DIAMETER / size:.1f} elements per diameter, c h/nu = {STREAM * size / mu:.0f}"
        losses = []
        for move in MOVES:
            quantity = f"{name}, steps of {move:g} elements: falls more slowly by"
            try:
                lost, cpu = loss(context, size, mu, move)
            except Failed as problem:
                rows.append(context.failed(quantity, "in a fluid at rest", 0, problem))
                continue
            losses.append((move, lost))
            rows.append(context.row(quantity, "in a fluid at rest", 0, lost, atol=bounds[move >= 0.4], cpu_s=cpu))
        if losses:
            x, y = np.transpose(losses)
            axes.plot(x, 100 * y, **curve(k), label=name)
    axes.set_xscale("log")
    axes.set_xticks(MOVES, [f"{move:g}" for move in MOVES])
    axes.minorticks_off()
    axes.set_ylim(0, 1.55 * axes.get_ylim()[1])  # room for the legend
    axes.set_xlabel("displacement in a step (elements)")
    axes.set_ylabel("falls more slowly by (%)")
    axes.legend(loc="upper right")
    yield from context.with_figure(rows, save(figure, context.figure_path("carried_disk")))


VALIDATIONS = [carried_disk]
