"""A cylinder in a wide stream: as a held body in the mesh steady, shedding, started, started and rotating, moved across; with a mesh
that fits it, started and started and rotating.

Wu, Shu, Zhao & Zhou (2009) as quoted by PacIFiC (cylinder-unbounded.c); Koumoutsakos & Leonard (1995); Chen, Ou & Pearlstein
(1993); Schneiders et al. (2013), figure 9: the drag at the frequency 0.8 f0 and its range. The bounds were set before the runs. The
sides of the box, 50 D apart, raise the drag by some one per cent. Runs end before the wake reaches the large elements at the outlet,
where without stabilisation the flow becomes unstable.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation.particles import axes_of, points, reference

CASE, FITTED = "cases/cylinder_in_stream.edp", "cases/started_cylinder.edp"
WU, MOVED = "Wu et al. 2009", "Schneiders et al. 2013, figure 9"


def drag(run, since=0.0):
    """t, C_D, C_L of a run after a time; of a body's forces, or of those on a boundary."""
    table = run.folder.table("forces")
    late, (along, across) = table["t"] >= since, ("fx", "fy") if "fx" in table else ("force_x", "force_y")
    return table["t"][late], 2 * table[along][late], 2 * table[across][late]


def followed(context, name, file, source, options, mesh, since, allowed, case=CASE, label="held body"):
    """A drag that is compared with a digitised curve over t U/R: the mean distance from it, over its mean.
    (Ten parameters: a run, and what it is compared with.)"""
    run = context.run(case, {"-every": 0, **options}, name, mesh=mesh)
    t, found, _ = drag(run)
    at, target = reference(file)
    figure, axes = axes_of()
    axes.plot(2 * t, found, **curve(0), label=label)
    points(axes, at, target, source)
    axes.set_ylim(0, 1.6 * max(target))
    axes.set_xlim(0, 1.02 * at[-1])
    axes.set_xlabel("t U/R")
    axes.set_ylabel("drag coefficient")
    axes.legend(loc="upper right")
    path = save(figure, context.figure_path(name))
    there = (at >= since) & (at <= 2 * t[-1])
    off = abs(np.interp(at[there], 2 * t, found) - target[there]).mean() / target[there].mean()
    return context.row(f"{name.replace('_', ' ')}: mean distance from the curve of C_D after t U/R = {since:g}, over its mean",
        source, 0, off, at_most=allowed, cpu_s=run.cpu_s, figure=path)


def steady_stream(context):
    """Reynolds number 40: drag and length of the eddy."""
    run = context.run(CASE, {"-reynolds": 40, "-tend": 40}, "re40")
    yield context.row("Reynolds number 40: drag coefficient", WU, 1.565, drag(run)[1][-1], rtol=0.04, cpu_s=run.cpu_s)
    yield context.row("Reynolds number 40: drag coefficient", "Dennis & Chang 1970, as recalled", 1.522, drag(run)[1][-1],
        rtol=0.05, cpu_s=run.cpu_s)


def shedding_stream(context):
    """Reynolds number 100: mean drag and amplitude of the lift."""
    run = context.run(CASE, {"-reynolds": 100, "-kick": 1, "-tend": 45, "-every": 0}, "re100")
    t, along, across = drag(run, 30)
    yield context.row("Reynolds number 100: mean drag coefficient", WU, 1.364, np.trapezoid(along, t) / np.ptp(t), rtol=0.04,
        cpu_s=run.cpu_s)
    yield context.row("Reynolds number 100: amplitude of the lift coefficient", WU, 0.344, np.ptp(across) / 2, rtol=0.06,
        cpu_s=run.cpu_s)


def started_cylinder(context):
    """Started at Reynolds number 1000: drag over time."""
    yield followed(context, "started", "started_cylinder_re1000_koumoutsakos1995", "Koumoutsakos & Leonard 1995",
        {"-reynolds": 1000, "-tend": 2.5}, ("cylinder_in_stream", 1 / 48), 0.5, 0.05)


def started_rotating_cylinder(context):
    """Started into translation and rotation at Reynolds number 200: drag over time."""
    yield followed(context, "started_rotating", "started_rotating_cylinder_chen1993_fig22", "Chen, Ou & Pearlstein 1993, figure 22",
        {"-reynolds": 200, "-spin": 1, "-tend": 12}, ("cylinder_in_stream", 1 / 24), 1.0, 0.05)


def fitted_cylinder(context):
    """Started at Reynolds numbers of 1000 and 9500, and with rotation at 200, on meshes that fit the cylinder: drag over time."""
    fitted = {"case": FITTED, "label": "fitted mesh"}
    yield followed(context, "fitted", "started_cylinder_re1000_koumoutsakos1995", "Koumoutsakos & Leonard 1995",
        {"-reynolds": 1000}, None, 0.5, 0.05, **fitted)
    yield followed(context, "fitted_rotating", "started_rotating_cylinder_chen1993_fig22",
        "Chen, Ou & Pearlstein 1993, figure 22", {"-reynolds": 200, "-spin": 1, "-tend": 12}, None, 1.0, 0.05, **fitted)


def thin_layer(context):
    """Started at a Reynolds number of 9500 on a mesh that fits the cylinder: drag over time. (The longest run of all.)"""
    yield followed(context, "thin_layer", "started_cylinder_re9500_koumoutsakos1995", "Koumoutsakos & Leonard 1995",
        {"-reynolds": 9500, "-tend": 2}, ("started_cylinder", 4, "--circle-points", "1500", "--growth", "0.06", "--wake-factor", "8"),
        0.5, 0.05, case=FITTED, label="fitted mesh")


def moved_across(context):
    """Moved across the stream at Reynolds number 185 and 0.8 of the natural frequency: mean drag and its range, two meshes."""
    figure, axes = axes_of()
    found = []
    for k, (elements, tend) in enumerate(((16, 90), (24, 60))):
        run = context.run(CASE, {"-reynolds": 185, "-amplitude": 0.2, "-frequency": 0.156, "-stabilise": 0.1, "-tend": tend,
            "-every": 0}, f"moved_{elements}", mesh=("cylinder_in_stream", 1 / elements))
        t, along, _ = drag(run, tend - 3 / 0.156)
        track = run.folder.tracks[0]
        axes.plot(np.interp(t, track["t"], track["y"]) - 25, along, color=curve(k)["color"], linewidth=0.7,
            label=f"three periods, {elements} elements per diameter")
        found.append((elements, np.trapezoid(along, t) / np.ptp(t), np.ptp(along), run.cpu_s))
    for level in (1.218, 1.339):
        axes.axhline(level, color="black", linestyle=":", linewidth=0.8, label=f"{MOVED}, range" if level < 1.3 else None)
    axes.set_xlabel("displacement / D")
    axes.set_ylabel("drag coefficient")
    axes.legend(loc="best")
    path = save(figure, context.figure_path("moved"))
    for elements, mean, reach, cpu_s in found:
        name = f"moved across, Reynolds number 185, {elements} elements per diameter"
        yield context.row(f"{name}: mean drag coefficient", MOVED, 1.289, mean, rtol=0.05, cpu_s=cpu_s, figure=path)
        yield context.row(f"{name}: largest less least drag coefficient", MOVED, 0.121, reach, rtol=0.3, cpu_s=cpu_s, figure=path)


VALIDATIONS = [steady_stream, shedding_stream, started_cylinder, started_rotating_cylinder, fitted_cylinder, thin_layer,
    moved_across]
