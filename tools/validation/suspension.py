"""The viscosity of disks in a shear flow between plates.

One free disk in the middle of a periodic cell, Stokes flow: body-fitted P2/P1 (the script stands in
tests/flow/test_wallforces.py). Many disks: no exact value; Einstein's law, 1 + 2 phi in two dimensions
(Brady, Int. J. Multiphase Flow 10 (1984) 113), holds for few of them far from each other and is what more of them exceed. At a
share
of 0.05, two disks that meet again and again, the step is to leave no error: a quarter of it is run beside.
"""
import numpy as np

from tools.base import quantities
from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of

CASE, UPPER = "cases/sheared_suspension.edp", 14
FITTED = {0.1: 1.06529, 0.2: 1.29097}  # radius over the distance of the plates: relative viscosity
SHARES, SEEDS = (0.05, 0.1, 0.2, 0.3), (1, 2, 3)


def viscosity(run, start, end):
    """Relative viscosity by the force on the upper plate; the units are mu and the period."""
    mu = 1 / float(run.folder.info["parameters"]["-reynolds"])
    return -quantities.mean_wall_fx(run.folder, UPPER, start, end) / (mu * run.folder.period[0])


def single(context, radius, cells):
    """Relative viscosity with one disk in the middle, without inertia."""
    path = context.out / f"one_{radius:g}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"id,x,y,radius,density\n0,0.5,0.5,{radius:g},1\n")
    run = context.run(CASE, {"-fraction": 0, "-particles": str(path), "-convection": 0, "-dt": 0.08 / cells, "-tend": 0.4,
        "-every": 0.01, "-tolerance": 1e-7},
                      f"one_{radius:g}_{cells}", mesh=("couette_disk", 1 / cells))
    return viscosity(run, 0.35, 0.4), run.cpu_s


def spread(values):
    """Standard deviation over the seeds; 0 for a single one."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0


def sheared_suspension(context):
    """The viscosity that disks add to a shear flow: one against a body-fitted computation, many against Einstein's law."""
    for radius, exact in FITTED.items():
        for cells in (32, 64):
            name = f"one disk, R/H = {radius:g}, {2 * radius * cells:g} elements per diameter: what it adds to the viscosity"
            try:
                found, cpu = single(context, radius, cells)
                yield context.row(name, "body-fitted P2/P1", exact - 1, found - 1, rtol=0.01 if 2 * radius * cells > 8 else 0.03,
                    cpu_s=cpu)
            except Failed as problem:
                yield context.failed(name, "body-fitted P2/P1", exact - 1, problem)
    found, gaps, cpu = {}, [], 0.0
    for share in SHARES:
        for seed in SEEDS:
            try:
                run = context.run(CASE, {"-fraction": share, "-seed": seed}, f"share_{share:g}_{seed}")
            except Failed as problem:
                yield context.failed(f"share {share:g}, seed {seed}: runs", "", float("nan"), problem)
                continue
            found.setdefault(share, []).append(viscosity(run, 10.0, 20.0))
            gaps.append(run.folder.fluid["worst_gap"].min() / run.folder.particles["radius"].min())
            cpu += run.cpu_s
    figure, axes = axes_of()
    phi = np.linspace(0, max(SHARES), 50)
    axes.plot(phi, 1 + 2 * phi, "k:", linewidth=1, label="Einstein, 1 + 2φ")
    axes.errorbar(list(found), [np.mean(v) for v in found.values()], [spread(v) for v in found.values()], **curve(0), capsize=3,
                  label=f"computed: mean and\nstandard deviation of {len(SEEDS)} seeds")
    axes.set_xlabel("solid fraction φ")
    axes.set_ylabel("relative viscosity")
    axes.legend(loc="upper left")
    path = save(figure, context.figure_path("viscosity"))
    for share, values in found.items():
        yield context.row(f"solid fraction {share:g}: relative viscosity, mean of {len(values)} seeds (standard deviation "
            f"{spread(values):.3f})", "above Einstein's law",
                          1 + 2 * share, np.mean(values), at_least=1 + 2 * share, cpu_s=cpu / len(found), figure=path)
    share, fine, cpu = SHARES[0], [], 0.0
    try:
        for seed in SEEDS:
            run = context.run(CASE, {"-fraction": share, "-seed": seed, "-dt": 0.005}, f"share_{share:g}_{seed}_fine")
            fine.append(viscosity(run, 10.0, 20.0))
            cpu += run.cpu_s
        yield context.row(f"solid fraction {share:g}: relative viscosity", "a quarter of the time step", np.mean(fine),
            np.mean(found[share]), atol=0.01, cpu_s=cpu)
    except (Failed, KeyError) as problem:
        yield context.failed(f"solid fraction {share:g}: relative viscosity", "a quarter of the time step", float("nan"), problem)
    yield context.row("least gap of all runs over the radius", "nothing overlaps, over the seam neither", 0, min(gaps),
        at_least=-1e-6)


VALIDATIONS = [sheared_suspension]
