"""Lefebvre's penalty as published and its limit, the standard scheme, on one settling disk.

Mean velocity over t in [0.225, 0.3] s of the disk of cases/settling_disk.edp; a body-fitted
transient (tests/reference/settling_disk_body_fitted.csv) gives -5.3816 cm/s. The penalty eps runs from 1 to 1e-10 on meshes of 4
and 6 elements
across the disk, and the indicators (which part of an element is particle) at eps = 1e-6;
their errors stand in penalty.csv beside the figure.
As eps -> 0 the published scheme settles on an error of its own, that of its mesh, which falls about as h,
and of its time step of 0.005 s (a fifth of it with 4 elements across).
"""
from tools.base import quantities
from tools.base.tables import write_table
from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed
from tools.validation.settling_disk import fitted_mean

FITTED, DIAMETER, WINDOW = "body-fitted transient", 0.25, (0.225, 0.3)
EXACT = fitted_mean(*WINDOW)
PENALTIES = (1.0, 1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
INDICATORS = ("levelset", "smooth")  # beside "centre", the default


def fall(context, cells, name, **options):
    """(relative error of the mean velocity, CPU time in s)."""
    run = context.run("cases/settling_disk.edp", {"-tend": 0.3, **{f"-{key}": value for key, value in options.items()}},
        f"{name}_{cells}",
                      mesh=context.mesh("settling_disk", DIAMETER / cells))
    return quantities.mean_v(run.folder, *WINDOW) / EXACT - 1, run.cpu_s


def draw(table, standards, path):
    """table: rows (indicator, penalty, cells, error, cpu); standards: {cells: error}."""
    figure, axes = plt.subplots(figsize=(0.7 * PAGE_WIDTH, 3.6), layout="constrained")
    for k, cells in enumerate(sorted(standards)):
        points = [(row[1], abs(row[3])) for row in table if row[0] == "centre" and row[2] == cells]
        axes.loglog(*zip(*points), **curve(k), marker="o", label=f"published, D/h = {cells}")
        axes.axhline(abs(standards[cells]), **curve(k + 2), label=f"standard scheme, D/h = {cells}")
    for marker, indicator in zip("s^", INDICATORS):
        some = [(row[1], abs(row[3])) for row in table if row[0] == indicator]
        if some:
            axes.plot(*zip(*some), marker, color="black", markerfacecolor="white", label=f"published, {indicator}, D/h = 4")
    axes.set_xlabel("penalty eps (cm s/g)")
    axes.set_ylabel("relative error of the mean velocity")
    axes.grid(True)
    figure.legend(loc="outside upper center", ncols=2, fontsize="small")
    return save(figure, path)


def two_methods(context):
    """Error of the fall velocity over the penalty and the mesh, both schemes."""
    rows, table, standards = [], [], {}

    def tried(label, *args, **options):
        try:
            return fall(context, *args, **options)
        except (Failed, ValueError) as problem:
            rows.append(context.failed(label, FITTED, EXACT, problem))
            return None

    for cells in (4, 6):
        label = f"standard scheme, D/h = {cells}"
        standard = tried(label, cells, "standard", dt=0.005 / cells)
        points = [(eps, tried(f"published, eps = {eps:g}, D/h = {cells}", cells, f"eps_{eps:g}", scheme="published", penalty=eps,
            dt=0.005))
                  for eps in PENALTIES]
        points = [(eps, *found) for eps, found in points if found]
        if standard:
            rows.append(context.row(label + ": mean velocity over 0.225 to 0.3 s (cm/s)", FITTED, EXACT, EXACT * (1 + standard[0]),
                rtol=0.01, cpu_s=standard[1]))
            standards[cells] = standard[0]
        small = [error for eps, error, _ in points if eps in (1e-6, 1e-8)]
        if len(small) == 2:
            rows.append(context.row(f"published, D/h = {cells}: change of the error from eps = 1e-6 to 1e-8",
                "limit of the penalty", 0, abs(small[0] - small[1]), at_most=0.005))
        table += [("centre", eps, cells, error, cpu) for eps, error, cpu in points]
    for indicator in INDICATORS:
        found = tried(f"published, indicator {indicator}", 4, indicator, scheme="published", indicator=indicator, dt=0.005)
        if found:
            table.append((indicator, 1e-6, 4, *found))
    write_table(context.figure_path("penalty").with_suffix(".csv"), ["indicator", "penalty", "cells", "error", "cpu_s"], table)
    yield from context.with_figure(rows, draw(table, standards, context.figure_path("penalty")))


VALIDATIONS = [two_methods]
