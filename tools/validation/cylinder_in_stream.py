"""A cylinder in a wide stream: as a held body in the mesh steady, shedding, started, started and rotating, moved across; with a
mesh that fits it, started, started and rotating, moved across.

Wu, Shu, Zhao & Zhou (2009) as quoted by PacIFiC (cylinder-unbounded.c); Koumoutsakos & Leonard (1995); Chen, Ou & Pearlstein
(1993); Schneiders et al. (2013), figure 9: the drag at the frequency 0.8 f0 over the displacement, its mean and its range;
Guilmineau & Queutey (2002), figures 13 and 17: vorticity and pressure on the cylinder. The bounds were set before the runs. The
sides of the box, 50 D apart, raise the drag by some one per cent. Runs end before the wake reaches the large elements at the
outlet, where without stabilisation the flow becomes unstable.
"""
import numpy as np

from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation.particles import axes_of, points, reference

CASE, FITTED = "cases/cylinder_in_stream.edp", "cases/started_cylinder.edp"
WU, MOVED, ON_CYLINDER = "Wu et al. 2009", "Schneiders et al. 2013, figure 9", "Guilmineau & Queutey 2002"
FREQUENCY = 0.156  # of the motion across the stream, U/D


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
    fine = "started_cylinder", 4, "--circle-points", "1500", "--growth", "0.06", "--wake-factor", "8"
    yield followed(context, "thin_layer", "started_cylinder_re9500_koumoutsakos1995", "Koumoutsakos & Leonard 1995",
        {"-reynolds": 9500, "-tend": 2}, fine, 0.5, 0.05, case=FITTED, label="fitted mesh")


def held_thin_layer(context):
    """Started at a Reynolds number of 9500 as a held body: drag over time."""
    yield followed(context, "held_thin_layer", "started_cylinder_re9500_koumoutsakos1995", "Koumoutsakos & Leonard 1995",
        {"-reynolds": 9500, "-tend": 2, "-stabilise": 0.1}, ("cylinder_in_stream", 1 / 200, "--stroke", "0.002", "--reach", "0.56",
        "--coarse-factor", "400", "--growth", "0.12", "--wake-factor", "4", "--wake-growth", "4", "--wake-width", "1.6"), 0.5, 0.05)


def over_period(t, along):
    """Phases of the motion and the drag there, the mean of the last three periods of a drag over time."""
    phases, last = np.arange(201) / 200, t[-1] * FREQUENCY
    return phases, np.mean([np.interp((last - back + phases) / FREQUENCY, t, along) for back in (3, 2, 1)], axis=0), last % 1


def off_curve(t, along):
    """Mean distance of the drag from the published one over the displacement, over its mean: at each displacement the published
    points lie on two branches, on the way up and on the way down, and each is compared with the nearer one."""
    phases, mean, begin = over_period(t, along)
    at, target = reference("moved_cylinder_drag_schneiders2013_fig9")
    up = np.arccos(np.clip(-at / 0.2, -1, 1)) / (2 * np.pi)
    branches = [np.interp((way - begin) % 1, phases, mean) for way in (up, 1 - up)]
    return np.min([abs(branch - target) for branch in branches], axis=0).mean() / target.mean()


def moved_rows(context, name, t, along, cpu_s, path, bounds):
    """Mean, range and curve of the drag of a moved cylinder; bounds: of each."""
    mean, reach, curve_off = bounds
    late = t >= t[-1] - 3 / FREQUENCY
    t, along = t[late], along[late]
    yield context.row(f"{name}: mean drag coefficient", MOVED, 1.289, np.trapezoid(along, t) / np.ptp(t), rtol=mean, cpu_s=cpu_s,
        figure=path)
    yield context.row(f"{name}: largest less least drag coefficient", MOVED, 0.121, np.ptp(along), rtol=reach, cpu_s=cpu_s,
        figure=path)
    yield context.row(f"{name}: mean distance from the curve of C_D over the displacement, over its mean", MOVED, 0,
        off_curve(t, along), at_most=curve_off, cpu_s=cpu_s, figure=path)


def draw_over_displacement(axes, t, along, k, label):
    """Three periods of the drag over the displacement."""
    late = t >= t[-1] - 3 / FREQUENCY
    axes.plot(-0.2 * np.cos(2 * np.pi * FREQUENCY * t[late]), along[late], color=curve(k)["color"], linewidth=0.7, label=label)


def drag_axes(axes):
    """The published drag over the displacement, and what belongs to its axes."""
    points(axes, *reference("moved_cylinder_drag_schneiders2013_fig9"), MOVED)
    axes.set_xlabel("displacement / D")
    axes.set_xticks([-0.2, -0.1, 0, 0.1, 0.2])
    axes.set_ylabel("drag coefficient")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
    axes.legend(loc="upper center")


def moved_across(context):
    """Moved across the stream at Reynolds number 185 and 0.8 of the natural frequency, as a body in the mesh: drag, two meshes."""
    figure, axes = axes_of()
    found = []
    for k, (elements, tend) in enumerate(((16, 90), (24, 60))):
        run = context.run(CASE, {"-reynolds": 185, "-amplitude": 0.2, "-frequency": FREQUENCY, "-stabilise": 0.1, "-tend": tend,
            "-every": 0}, f"moved_{elements}", mesh=("cylinder_in_stream", 1 / elements))
        t, along, _ = drag(run)
        draw_over_displacement(axes, t, along, k, f"three periods, {elements} elements per diameter")
        found.append((elements, t, along, run.cpu_s))
    drag_axes(axes)
    path = save(figure, context.figure_path("moved"))
    for elements, t, along, cpu_s in found:
        yield from moved_rows(context, f"moved across, Reynolds number 185, {elements} elements per diameter", t, along, cpu_s,
            path, (0.05, 0.3, 0.05))


def of_surface(pressure, vorticity):
    """C_D at a Reynolds number of 185 of pressure coefficient and vorticity (angles in degrees, values) on the cylinder."""
    angle = np.radians(np.arange(0, 360.5, 0.5))
    p, w = (np.interp(np.degrees(angle), *one, period=360) for one in (pressure, vorticity))
    return np.trapezoid(p * np.cos(angle) / 2 - w * np.sin(angle) / 185, angle)


def fitted_across(context):
    """The same with a mesh that fits the cylinder, seen from it: drag, and vorticity and pressure on it at the upper extreme."""
    run = context.run(FITTED, {"-reynolds": 185, "-amplitude": 0.2, "-frequency": FREQUENCY, "-dt": 0.02, "-tend": 11.5 / FREQUENCY,
        "-every": 5, "-tolerance": 1e-7}, "fitted_moved", mesh=("started_cylinder", 4, "--circle-points", "160"))
    t, along, _ = drag(run)
    surface = run.folder.table("surface")
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.1), layout="constrained")
    draw_over_displacement(left, t, along, 0, "three periods, fitted mesh")
    drag_axes(left)
    right.plot(surface["angle"], surface["vorticity"], **curve(0), label="fitted mesh")
    points(right, *reference("moved_cylinder_vorticity_guilmineau2002_fig13"), ON_CYLINDER)
    right.set_xlabel("angle from the front (degrees)")
    right.set_ylabel("vorticity on the cylinder (U/D)")
    right.legend(loc="best")
    for axes in (left, right):
        axes.grid(True)
    path = save(figure, context.figure_path("fitted_moved"))
    name = "moved across, Reynolds number 185, fitted mesh"
    yield from moved_rows(context, name, t, along, run.cpu_s, path, (0.03, 0.15, 0.02))
    kept = {"vorticity": reference("moved_cylinder_vorticity_guilmineau2002_fig13"),
        "pressure": reference("moved_cylinder_pressure_guilmineau2002_fig17")}
    for column, bound in (("vorticity", 0.03), ("pressure", 0.05)):
        at, target = kept[column]
        off = abs(np.interp(at, surface["angle"], surface[column]) - target).mean()
        yield context.row(f"{name}: mean distance from the curve of the {column} on the cylinder, over its largest", ON_CYLINDER, 0,
            off / abs(target).max(), at_most=bound, cpu_s=run.cpu_s, figure=path)
    yield context.row(f"{name}: drag coefficient at the upper extreme, of pressure and vorticity on the cylinder", ON_CYLINDER,
        of_surface(kept["pressure"], kept["vorticity"]), of_surface(*((surface["angle"], surface[column]) for column in ("pressure",
        "vorticity"))), rtol=0.03, cpu_s=run.cpu_s, figure=path)


VALIDATIONS = [steady_stream, shedding_stream, started_cylinder, started_rotating_cylinder, fitted_cylinder, thin_layer,
    held_thin_layer, moved_across, fitted_across]
