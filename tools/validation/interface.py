"""Order of the scheme at the edge of a body: drag and torque on a held cylinder, over offsets; vortices behind one.

The targets of drag and torque are for the mean over the offsets; the order is that of the root mean square, in which
errors of either sign do not cancel.

Drag: square array of cylinders, Stokes flow, solid fraction 0.1: F/(mu U) = 24.83 (Sangani and
Acrivos, Int. J. Multiphase Flow 8, 1982). Torque: a cylinder that turns in a flow in circles,
4 pi mu omega R^2 (Lamb, Hydrodynamics, art. 333). The cylinder stands at several places relative to
the elements, on meshes of equal triangles and without structure.
Vortices: DFG 2D-2 with the cylinder as a held body (held_cylinder).
"""
from collections import namedtuple

import numpy as np

from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed
from tools.validation.flow import FEAT, VORTICES, vortices_of

FRACTION, RADIUS = 0.1, 0.18
CELLS = (11, 22, 44)                                                # elements a side: D/h = 3.9, 7.9, 15.7
OFFSETS = ((0, 0), (0.25, 0.1), (0.5, 0.37), (0.1, 0.6))            # of an element
ALLOWED = {11: None, 22: 0.005, 44: 0.005}                          # relative error of the mean
ACROSS = (12, 16, 24)                                               # elements per diameter of the cylinder that sheds vortices
Quantity = namedtuple("Quantity", "name unit case options exact source diameter read")
DRAG = Quantity("drag", "F/(mu U)", "cylinder_array", {"-fraction": FRACTION, "-tend": 0.6}, 24.83, "Sangani & Acrivos 1982",
    2 * np.sqrt(FRACTION / np.pi),
                lambda run: float(run.folder.table("summary")["drag_by_balance"][-1]))
TORQUE = Quantity("torque", "T/(mu omega R^2)", "rotating_cylinder", {"-radius": RADIUS, "-tend": 0.4}, 4 * np.pi, "Lamb",
    2 * RADIUS,
                  lambda run: -float(run.folder.table("forces")["torque"][-1]) / RADIUS**2)


def errors(context, quantity, pattern, cells):
    """Relative errors at the offsets, and the CPU time of the runs (s)."""
    size, found, cpu = 1 / cells, [], 0.0
    mesh = context.mesh(quantity.case, size, "--pattern", pattern)
    for k, (x, y) in enumerate(OFFSETS):
        options = {**quantity.options, "-dt": 0.64 * size**2, "-x": 0.5 + x * size, "-y": 0.5 + y * size}
        run = context.run(f"cases/{quantity.case}.edp", options, f"{quantity.name}_{pattern}_{cells}_{k}", mesh=mesh)
        found.append(quantity.read(run) / quantity.exact - 1)
        cpu += run.cpu_s
    return np.array(found), cpu


def family(context, quantity, pattern, axes, k):
    """The rows of one quantity on one family of meshes, and its curve."""
    size_of, rows = {}, []
    for cells in CELLS:
        across = quantity.diameter * cells
        name = f"held cylinder, {pattern} mesh, D/h = {across:.1f}: {quantity.name}"
        try:
            found, cpu = errors(context, quantity, pattern, cells)
        except Failed as problem:
            rows.append(context.failed(name, quantity.source, quantity.exact, problem))
            continue
        size_of[cells] = float(np.sqrt((found**2).mean()))
        scatter = f"from {100 * found.min():.2f} to {100 * found.max():.2f} % over the offsets"
        axes.errorbar(across, size_of[cells], yerr=[[0], [max(0.0, abs(found).max() - size_of[cells])]], color=curve(k)["color"],
            capsize=3)
        if ALLOWED[cells]:
            rows.append(context.row(f"{name}, mean {quantity.unit}", quantity.source, quantity.exact,
                quantity.exact * (1 + found.mean()), rtol=ALLOWED[cells],
                                    cpu_s=cpu, reason=scatter))
    if len(size_of) == len(CELLS):
        axes.loglog(quantity.diameter * np.array(CELLS), list(size_of.values()), **curve(k), marker="o", label=pattern)
        order = -np.polyfit(np.log(CELLS), np.log(list(size_of.values())), 1)[0]
        rows.append(context.row(f"held cylinder, {pattern} meshes: order of the root mean square error of the {quantity.name}",
            "second order", 2, order, at_least=1.8))
    return rows


def elements_along(axes, across, digits):
    """The elements per diameter, which the x axis is to show, as its only ticks."""
    axes.set_xticks(across, [format(a, digits) for a in across])
    axes.minorticks_off()
    axes.set_xlabel("elements per diameter")


def interface_order(context):
    """Drag and torque on a held cylinder over the size of the elements, on two families of meshes."""
    figure, panels = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.1), layout="constrained", sharey=True)
    rows = []
    for axes, quantity in zip(panels, (DRAG, TORQUE)):
        for k, pattern in enumerate(("right", "unstructured")):
            rows += family(context, quantity, pattern, axes, k)
        across = quantity.diameter * np.array(CELLS)
        axes.loglog(across, 0.02 * (CELLS[0] / np.array(CELLS)) ** 2, "k:", label="second order")
        elements_along(axes, across, ".1f")
        axes.set_title(quantity.name)
    panels[0].set_ylabel("relative error over the offsets (rms, bar: largest)")
    panels[0].legend(loc="best")
    yield from context.with_figure(rows, save(figure, context.figure_path("order")))


def held_vortices(context):
    """DFG 2D-2 with the cylinder as a held body, over the elements per diameter."""
    found, cost = {}, {}
    for across in ACROSS:
        run = context.run("cases/held_cylinder.edp", {}, f"vortices_{across}", mesh=("held_cylinder", 0.1 / across))
        found[across], cost[across] = vortices_of(run, 4.5, x="fx", y="fy"), run.cpu_s
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH, 3.1), layout="constrained")
    off = np.abs(np.array([found[across] for across in ACROSS]) / np.array(list(VORTICES.values())) - 1)
    for k, name in enumerate(VORTICES):
        axes.loglog(ACROSS, off[:, k], marker="o", **curve(k), label=name)
    axes.loglog(ACROSS, 0.02 * (ACROSS[0] / np.array(ACROSS)) ** 2, color="0.6", label="second order")
    elements_along(axes, ACROSS, "d")
    axes.set_ylabel(f"error relative to {FEAT}")
    figure.legend(loc="outside right upper")
    path = save(figure, context.figure_path("vortices"))
    for name, target, measured in zip(VORTICES, VORTICES.values(), found[ACROSS[-1]]):
        yield context.row(f"2D-2, held body, {ACROSS[-1]} elements per diameter: {name}", FEAT, target, measured, rtol=0.01,
            cpu_s=cost[ACROSS[-1]], figure=path)
    orders = -np.polyfit(np.log(ACROSS), np.log(off), 1)[0]
    for name, order in list(zip(VORTICES, orders))[:3]:
        yield context.row(f"2D-2, held body: order of the {name}", "second order", 2, order, at_least=1.8,
            cpu_s=sum(cost.values()), figure=path)


VALIDATIONS = [interface_order, held_vortices]
