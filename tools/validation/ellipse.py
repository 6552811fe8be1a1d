"""Ellipses in a shear flow, and budgets of momentum and energy in a closed box.

Jeffery (Proc. R. Soc. A 102, 1922): without inertia and far from walls an ellipse of aspect ratio r
turns with omega = -G (r^2 sin^2 theta + cos^2 theta)/(r^2 + 1), theta the angle of its major axis to
the flow, so that half a turn takes pi (r + 1/r)/G. Aidun, Lu and Ding (J. Fluid Mech. 373, 1998):
4 G a^2/nu = 1 between near walls, lattice Boltzmann, digitised; the same by tools.peers.with_lbmpy,
whose error falls with the first power of the cell.
"""
import numpy as np

from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed
from tools.validation.particles import axes_of, points, reference


def half_turn(track):
    """Time at which the ellipse has turned by pi from its start. Raises Failed where it has not."""
    turned = track["theta"][0] - track["theta"]
    if not turned[-1] >= np.pi:
        raise Failed(f"it has turned by {turned[-1]:.3g} rad only")
    return float(np.interp(np.pi, turned, track["t"]))


def lateness(track, t, omega):
    """The shift in time that brings the run nearest to the published points about the second
    maximum (which are too far apart to show where it lies), over the time of half a turn."""
    near = (t > 6) & (t < 9.5)
    shifts = np.linspace(-0.5, 0.5, 1001)
    off = [np.square(np.interp(t[near] + shift, track["t"], -track["omega"]) - omega[near]).sum() for shift in shifts]
    return shifts[int(np.argmin(off))] / half_turn(track)


def ellipse_in_shear(context):
    """Jeffery's period at low Reynolds number, and the ellipse of Aidun et al."""
    aspect = 2
    exact = np.pi * (aspect + 1 / aspect)
    for reynolds, size in ((0.1, 0.00625), (0.1, 0.0125)):
        name = f"ellipse, Reynolds number {reynolds:g}, semi-axes H/20 and H/40, {0.05 / size:g} elements per minor axis: half a period times G"
        try:
            run = context.run("cases/ellipse_in_shear.edp", {"-major": 0.05, "-reynolds": reynolds, "-dt": 0.01, "-tend": 9.0},
                f"jeffery_{size:g}",
                              mesh=context.mesh("ellipse_in_shear", size, "--core", "0.13"))
            yield context.row(name, "Jeffery 1922", exact, half_turn(next(iter(run.folder.tracks.values()))), rtol=0.01,
                cpu_s=run.cpu_s)
        except Failed as problem:
            yield context.failed(name, "Jeffery 1922", exact, problem)
    figure, axes = axes_of()
    t, omega = reference("ellipse_in_shear_aidun1998")
    points(axes, t, omega, "Aidun et al. 1998")
    found = {}
    for k, (size, dt) in enumerate(((0.0125, 0.01), (0.00625, 0.005))):
        name = f"ellipse, Reynolds number 1, {0.1 / size:g} elements per minor axis: "
        try:
            run = context.run("cases/ellipse_in_shear.edp", {"-dt": dt}, f"aidun_{size:g}", mesh=context.mesh("ellipse_in_shear",
                size, "--core", "0.3"))
            track = next(iter(run.folder.tracks.values()))
            axes.plot(track["t"], -track["omega"], **curve(k), label=f"{0.1 / size:g} elements per minor axis")
            found[name] = (lateness(track, t, omega), abs(np.interp(t, track["t"], -track["omega"]) - omega).max(),
                half_turn(track), run.cpu_s)
        except Failed as problem:
            yield context.failed(name + "angular velocity", "Aidun et al. 1998", float("nan"), problem)
    axes.set_xlabel("G t")
    axes.set_ylabel("-omega/G")
    axes.legend(loc="best")
    path = save(figure, context.figure_path("aidun"))
    cells, turn = reference("ellipse_in_shear_second_scheme")
    second = np.polyfit(1 / cells, turn, 1)[1]
    for name, (late, distance, time, cpu) in found.items():
        yield context.row(name + "half a period times G", f"lattice Boltzmann, {cells[0]:g} to {cells[-1]:g} cells, extrapolated",
            second, time, rtol=0.01, cpu_s=cpu, figure=path)
        yield context.row(name + "how late it is half a turn on, over the time of that", "Aidun et al. 1998", 0, late, atol=0.02,
            cpu_s=cpu, figure=path)
        yield context.row(name + "largest distance from the curve, over G", "Aidun et al. 1998", 0, distance, at_most=0.05,
            cpu_s=cpu, figure=path)


def missing(run):
    """(momentum that is missing over the weight's impulse, energy over the work), at the worst time."""
    b = run.folder.table("budget")
    weight = np.hypot(b["weight_x"][-1], b["weight_y"][-1])
    momentum = np.max(np.hypot(b["momentum_x"] - b["walls_x"] - b["weight_x"], b["momentum_y"] - b["walls_y"]
        - b["weight_y"])) / weight
    return momentum, np.max(abs(b["kinetic_energy"] - b["work"] + b["dissipated"])) / b["work"][-1]


def budgets(context):
    """Momentum and energy of a disk that falls in a closed box, over element size and time step."""
    figure, panels = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    found = {}
    for cells, dt in ((4, 0.005), (4, 0.0025), (4, 0.00125), (8, 0.0025), (8, 0.00125), (16, 0.00125)):
        try:
            run = context.run("cases/settling_disk.edp", {"-budget": 1, "-dt": dt, "-tend": 0.3, "-every": 0.01},
                f"budget_{cells}_{dt:g}", mesh=("settling_disk", 0.25 / cells))
            found[cells, dt] = (*missing(run), run.cpu_s)
        except Failed as problem:
            yield context.failed(f"budgets, D/h = {cells}, dt = {dt:g}", "conservation", 0, problem)
    steps = [key for key in found if key[0] == 4]
    sizes = [key for key in found if key[1] == 0.00125]
    panels[0].loglog([dt for _, dt in steps], [found[key][0] for key in steps], **curve(0), marker="o", label="D/h = 4")
    finer = [key for key in found if key[0] == 8]
    panels[0].loglog([dt for _, dt in finer], [found[key][0] for key in finer], **curve(2), marker="s", label="D/h = 8")
    panels[0].legend(loc="best")
    panels[0].set_xlabel("time step (s)")
    panels[0].set_ylabel("momentum missing\n(of the weight's impulse)")
    panels[0].set_xticks([dt for _, dt in steps], [f"{dt:g}" for _, dt in steps])
    panels[1].loglog([1 / cells for cells, _ in sizes], [found[key][1] for key in sizes], **curve(1), marker="s")
    panels[1].set_xlabel("element size / D, dt = 0.00125 s")
    panels[1].set_ylabel("energy missing\n(of the weight's work)")
    panels[1].set_xticks([1 / cells for cells, _ in sizes], [f"1/{cells}" for cells, _ in sizes])
    for axes in panels:
        axes.minorticks_off()
        axes.grid(True)
    path = save(figure, context.figure_path("budgets"))
    for (cells, dt), (momentum, energy, cpu) in found.items():
        where = f"closed box, D/h = {cells}, dt = {dt:g} s: "
        yield context.row(where + "momentum missing over the weight's impulse", "conservation", 0, momentum,
            at_most=0.0125 / cells, cpu_s=cpu, figure=path)
        yield context.row(where + "energy missing over the work", "conservation", 0, energy, at_most=0.04 / cells, cpu_s=cpu,
            figure=path)
    if (4, 0.005) in found and (8, 0.0025) in found and (16, 0.00125) in found:
        order = np.log2(found[4, 0.005][0] / found[16, 0.00125][0]) / 2
        yield context.row("closed box: order of the missing momentum, mesh and step refined together", "scheme: 1 and more", 1,
            order, at_least=1, figure=path)


VALIDATIONS = [ellipse_in_shear, budgets]
