"""Order of the scheme at the edge of a body: drag on a fixed cylinder, averaged over offsets.

Square array of cylinders, Stokes flow, solid fraction 0.1: F/(mu U) = 24.83 (Sangani and
Acrivos, Int. J. Multiphase Flow 8, 1982). The cylinder stands at several places relative to the
elements, on meshes of equal triangles and without structure.
"""
import numpy as np

from tools.plotting import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed

FRACTION, EXACT, SOURCE = 0.1, 24.83, "Sangani & Acrivos 1982"
CELLS = (11, 22, 44)                                                # elements a side: D/h = 3.9, 7.9, 15.7
OFFSETS = ((0, 0), (0.25, 0.1), (0.5, 0.37), (0.1, 0.6))            # of an element
ALLOWED = {11: None, 22: 0.005, 44: 0.005}                          # relative error of the mean


def errors(context, pattern, cells):
    """Relative errors of the drag at the offsets, and the CPU time of the runs (s)."""
    size, found, cpu = 1 / cells, [], 0.0
    mesh = context.mesh("cylinder_array", size, "--pattern", pattern)
    for k, (x, y) in enumerate(OFFSETS):
        options = {"-fraction": FRACTION, "-dt": 0.64 * size**2, "-tend": 0.6, "-x": 0.5 + x * size, "-y": 0.5 + y * size}
        run = context.run("cases/cylinder_array.edp", options, f"{pattern}_{cells}_{k}", mesh=mesh)
        found.append(float(run.folder.table("summary")["drag_by_balance"][-1]) / EXACT - 1)
        cpu += run.cpu_s
    return np.array(found), cpu


def interface_order(context):
    """Drag on a fixed cylinder over the size of the elements, on two families of meshes."""
    diameter = 2 * np.sqrt(FRACTION / np.pi)
    figure, axes = plt.subplots(figsize=(0.55 * PAGE_WIDTH, 3.1), layout="constrained")
    rows = []
    for k, pattern in enumerate(("right", "unstructured")):
        mean = {}
        for cells in CELLS:
            name = f"fixed cylinder, {pattern} mesh, D/h = {diameter * cells:.1f}: "
            try:
                found, cpu = errors(context, pattern, cells)
            except Failed as problem:
                rows.append(context.failed(name + "drag", SOURCE, EXACT, problem))
                continue
            mean[cells] = abs(found.mean())
            scatter = f"from {100 * found.min():.2f} to {100 * found.max():.2f} % over the offsets"
            axes.errorbar(diameter * cells, mean[cells], yerr=[[0], [found.std()]], color=curve(k)["color"], capsize=3)
            if ALLOWED[cells]:
                rows.append(context.row(name + "mean drag F/(mu U)", SOURCE, EXACT, EXACT * (1 + found.mean()), rtol=ALLOWED[cells], cpu_s=cpu, reason=scatter))
        if len(mean) == len(CELLS):
            axes.loglog(diameter * np.array(CELLS), list(mean.values()), **curve(k), marker="o", label=pattern)
            order = -np.polyfit(np.log(CELLS), np.log(list(mean.values())), 1)[0]
            rows.append(context.row(f"fixed cylinder, {pattern} meshes: order of the mean drag", "second order", 2, order, at_least=1.8))
    axes.loglog(diameter * np.array(CELLS), 0.02 * (CELLS[0] / np.array(CELLS)) ** 2, "k:", label="second order")
    axes.set_xscale("log")
    axes.set_xticks(diameter * np.array(CELLS), [f"{diameter * c:.1f}" for c in CELLS])
    axes.minorticks_off()
    axes.set_xlabel("elements across the cylinder")
    axes.set_ylabel("relative error of the mean drag")
    axes.legend(loc="best")
    path = save(figure, context.figure_path("drag"))
    for row in rows:
        row.figure = str(path)
    yield from rows


VALIDATIONS = [interface_order]
