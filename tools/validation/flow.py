"""The flow without particles against exact solutions, benchmarks and published lengths.

2D-1, 2D-2, 2D-3: channel with a cylinder of Schaefer & Turek (1996), values of FeatFlow's
reference computations. Cavity: Botella & Peyret, Comput. Fluids 27 (1998). Step: Erturk,
Comput. Fluids 37 (2008). Expansion 1:3: Fearn, Mullin & Cliffe, J. Fluid Mech. 211 (1990).
"""
import numpy as np

from tools.base.command import ROOT
from tools.base.tables import read_table
from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.study.extrema import peak, vortices
from tools.validation import Failed
from tools.validation.turbulence import turbulence

FEAT, REFERENCE = "FeatFlow", ROOT / "tests" / "reference"
STEADY = {"drag_coefficient": (5.57953523384, 1e-4), "lift_coefficient": (0.010618948146, 0.01),
          "pressure_difference": (0.11752016697, 1e-3)}
VORTICES = {"largest drag coefficient": 3.227393, "least drag coefficient": 3.164263,
            "lift coefficient, peak to peak": 2.007871, "Strouhal number": 0.301841}


def coefficients(run, x="force_x", y="force_y"):
    """t, drag and lift coefficient of a run of cylinder_channel at the usual speed; x, y: columns of forces.csv."""
    force = run.folder.table("forces")
    return force["t"], 20 * force[x], 20 * force[y]


def fine_mesh(context):
    """The channel with a cylinder that gives 2D-2 within 0.1 %."""
    return context.mesh("cylinder_channel", 0.08, "--circle-points", "64", "--growth", "0.06", "--wake-factor", "1.3",
        "--wake-growth", "0.02")


def vortices_of(run, since=5.0, **columns):
    """The four numbers of 2D-2 after the time `since` (s), in the order of VORTICES; columns: as coefficients() takes them."""
    return list(vortices(*coefficients(run, **columns), since).values())


def poiseuille(context):
    """Plane Poiseuille flow, which the elements hold exactly."""
    run = context.run("cases/poiseuille.edp", {}, "poiseuille")
    off = run.folder.table("errors")
    for name, values in off.items():
        yield context.row(f"Poiseuille: largest error of {name.replace('_', ' ')}", "exact", 0, values[-1], at_most=1e-9,
            cpu_s=run.cpu_s)


def taylor_green(context):
    """Orders in space and time from moving Taylor-Green vortices."""
    def error(name, size, dt, end):
        run = context.run("cases/taylor_green.edp", {"-dt": dt, "-tend": end}, name, mesh=("taylor_green", size))
        off = run.folder.table("errors")
        return [off["velocity"][-1], off["pressure"][-1]], run.cpu_s
    sizes, steps = [1 / 12, 1 / 24], [0.02, 0.01, 0.005]
    space = [error(f"tg_space_{k}", size, 0.0005, 0.02) for k, size in enumerate(sizes)]
    time = [error(f"tg_time_{k}", 1 / 32, dt, 0.4) for k, dt in enumerate(steps)]
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.0), layout="constrained")
    for one, values, found, label in ((axes[0], sizes, space, "element size"), (axes[1], steps, time, "time step (s)")):
        for k, what in enumerate(("velocity", "pressure")):
            one.loglog(values, [e[k] for e, _ in found], marker="o", **curve(k), label=what)
        one.set_xlabel(label)
        one.set_ylabel("L2 error")
        one.grid(True)
    for one, values, found, order in ((axes[0], sizes, space, 3), (axes[1], steps, time, 2)):
        one.loglog(values, 0.6 * found[-1][0][0] * (np.array(values) / values[-1]) ** order, "k:", linewidth=0.8,
            label=f"order {order}")
        one.legend(loc="best")
    path = save(figure, context.figure_path("orders"))
    order = np.log2(np.divide(space[0][0], space[1][0]))
    cost = {"cpu_s": space[0][1] + space[1][1], "figure": path}
    yield context.row("order of the velocity in space", "exact", 3, order[0], at_least=2.9, **cost)
    order = np.log2(np.divide(time[1][0], time[2][0]))
    cost = {"cpu_s": time[1][1] + time[2][1], "figure": path}
    yield context.row("order of the velocity in time", "exact", 2, order[0], at_least=1.9, **cost)
    yield context.row("order of the pressure in time", "exact", 2, order[1], at_least=1.4, **cost)


def cylinder_steady(context):
    """DFG 2D-1: drag, lift and pressure difference by Newton's method."""
    runs, meshes = [], [("cylinder_channel", 0.12), None]
    for k, mesh in enumerate(meshes):
        runs.append(context.run("cases/cylinder_steady.edp", {}, f"2d1_{k}", mesh=mesh))
    found = [run.folder.results for run in runs]
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH / 2, 3.0), layout="constrained")
    for k, (name, (target, _)) in enumerate(STEADY.items()):
        axes.loglog([f["unknowns"] for f in found], [abs(f[name] / target - 1) for f in found], marker="o", **curve(k),
            label=name.replace("_", " "))
    axes.set_xlabel("unknowns")
    axes.set_ylabel("relative error")
    axes.grid(True)
    axes.legend(loc="best")
    cost = {"cpu_s": runs[-1].cpu_s, "figure": save(figure, context.figure_path("2d1"))}
    for name, (target, rtol) in STEADY.items():
        yield context.row(f"2D-1: {name.replace('_', ' ')}", FEAT, target, found[-1][name], rtol=rtol, **cost)
    yield context.row("2D-1: factorisations", "limit", 10, found[-1]["factorisations"], at_most=10, **cost)


def draw_vortices(runs, path):
    """Lift and drag over the last second, the reference's extrema as lines."""
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.0), layout="constrained")
    for k, (name, run) in enumerate(runs.items()):
        t, drag, lift = coefficients(run)
        first = t[(t > 4.9) & (np.roll(lift, 1) < 0) & (lift >= 0)][0]  # phases agree
        for one, values in zip(axes, (drag, lift)):
            one.plot(t - first, values, **curve(k), label=name)
    for one, levels, label in ((axes[0], (3.227393, 3.164263), "drag coefficient"), (axes[1], (0.9866, -1.0213),
        "lift coefficient")):
        for level in levels:
            one.axhline(level, color="black", linewidth=0.7, linestyle=":")
        one.set_xlim(0, 0.75)
        one.set_xlabel("time after a rise of the lift (s)")
        one.set_ylabel(label)
    axes[0].set_ylim(3.1, 3.25)
    axes[1].set_ylim(-1.15, 1.7)
    axes[1].legend(loc="upper right", ncols=2)
    return save(figure, path)


def cylinder_vortices(context):
    """DFG 2D-2 on the default mesh within 0.5 % and 5 s, on a fine one within 0.1 %; stabilised."""
    runs = {"default mesh": context.run("cases/cylinder_channel.edp", {}, "2d2_default"),
            "default, stabilised": context.run("cases/cylinder_channel.edp", {"-stabilise": 0.1}, "2d2_stabilised"),
            "fine mesh": context.run("cases/cylinder_channel.edp", {"-dt": 0.001, "-tolerance": 1e-5, "-every": 0.1}, "2d2_fine",
                mesh=fine_mesh(context))}
    figure = draw_vortices(runs, context.figure_path("2d2"))
    plain = vortices_of(runs["default mesh"])
    for name, rtol in (("default mesh", 0.005), ("fine mesh", 0.001)):
        for (what, target), measured in zip(VORTICES.items(), vortices_of(runs[name])):
            yield context.row(f"2D-2, {name}: {what}", FEAT, target, measured, rtol=rtol, cpu_s=runs[name].cpu_s, figure=figure)
    yield context.row("2D-2, default mesh: CPU time for 6 s (s)", "limit", 5, runs["default mesh"].cpu_s, at_most=5,
                      cpu_s=runs["default mesh"].cpu_s, figure=figure, reason="depends on the machine and its load")
    for (what, _), without, measured in zip(VORTICES.items(), plain, vortices_of(runs["default, stabilised"])):
        yield context.row(f"2D-2: {what}, stabilised", "without stabilisation", without, measured, rtol=0.02,
                          cpu_s=runs["default, stabilised"].cpu_s, figure=figure)


def cylinder_pulse(context):
    """DFG 2D-3: an inflow that rises and falls; maxima of drag and lift and when."""
    run = context.run("cases/cylinder_channel.edp", {"-inflow": "sine", "-tend": 8, "-dt": 0.001, "-tolerance": 1e-5,
        "-every": 0.1}, "2d3", mesh=fine_mesh(context))
    t, drag, lift = coefficients(run)
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for one, values, at, label in ((axes[0], drag, (3.93625, 2.950921575), "drag coefficient"),
        (axes[1], lift, (5.693125, 0.47795), "lift coefficient")):
        one.plot(t, values, **curve(0))
        one.plot(*at, "o", markerfacecolor="white", markeredgecolor="black", label=f"{FEAT}, maximum")
        one.set_xlabel("t (s)")
        one.set_ylabel(label)
        one.set_ylim(-0.6 if values is lift else -0.5, 0.6 if values is lift else 3.2)
        one.legend(loc="lower center")
    cost = {"cpu_s": run.cpu_s, "figure": save(figure, context.figure_path("2d3"))}
    when, most = peak(t, drag)
    yield context.row("2D-3: largest drag coefficient", FEAT, 2.950921575, most, rtol=0.005, **cost)
    yield context.row("2D-3: its time (s)", FEAT, 3.93625, when, rtol=0.005, **cost)
    late = t > 1  # the start is no maximum of the vortices
    when, most = peak(t[late], lift[late])
    yield context.row("2D-3: largest lift coefficient", FEAT, 0.47795, most, rtol=0.01, **cost)
    yield context.row("2D-3: its time (s)", FEAT, 5.693125, when, rtol=0.005, **cost)


def cavity(context):
    """Lid-driven cavity at Reynolds number 1000: extrema on the centrelines."""
    run = context.run("cases/cavity.edp", {}, "cavity")
    lines = run.folder.table("lines")
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.0), layout="constrained")
    for one, name, letter in ((axes[0], "u", "y"), (axes[1], "v", "x")):
        given = read_table(REFERENCE / f"cavity_{name}_re1000_botella1998.csv")
        one.plot(lines["along"], lines[name], **curve(0), label=f"{run.folder.title}")
        one.plot(given[letter], given[name], "o", markersize=3.5, markerfacecolor="white", markeredgecolor="black",
            label="Botella & Peyret 1998")
        one.set_xlabel(f"{letter} (m)")
        one.set_ylabel(f"{name} (m/s)")
        one.grid(True)
    axes[0].legend(loc="best")
    found, cost = run.folder.results, {"cpu_s": run.cpu_s, "figure": save(figure, context.figure_path("cavity"))}
    for name, target in (("u_least", -0.3885698), ("v_most", 0.3769447), ("v_least", -0.5270771)):
        yield context.row(f"cavity: {name.replace('_', ' ')} (m/s)", "Botella & Peyret 1998", target, found[name], rtol=0.001,
            **cost)


def backward_step(context):
    """Backward-facing step at Reynolds number 800: three lengths in step heights."""
    given = read_table(REFERENCE / "backward_step_reattachment_erturk2008.csv")
    names = ("x1_lower_reattachment", "x4_upper_separation", "x5_upper_reattachment")
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH / 2, 3.0), layout="constrained")
    mesh = context.mesh("backward_step", 1 / 14, "--longest", "3")
    run = context.run("cases/backward_step.edp", {}, "step_800", mesh=mesh)
    found = run.folder.results
    for k, name in enumerate(names):
        there = given[name] > 0
        axes.plot(given["Re"][there], given[name][there], "o", markersize=3.5, markerfacecolor="white",
            markeredgecolor=curve(k)["color"])
        axes.plot([800], [found.get(name, np.nan)], "x", color=curve(k)["color"], label=name.split("_", 1)[0] + " "
            + name.split("_", 1)[1].replace("_", " "))
    axes.set_xlabel("Reynolds number")
    axes.set_ylabel("x over step height (circles: Erturk 2008)")
    axes.legend(loc="upper left")
    axes.set_ylim(0, 32)
    cost = {"cpu_s": run.cpu_s, "figure": save(figure, context.figure_path("step"))}
    for name in names:
        target = given[name][given["Re"] == 800][0]
        doubt = "two other schemes agree with the value measured: rows below" if name == "x4_upper_separation" else ""
        yield context.row(f"step: {name.replace('_', ' ')} (heights)", "Erturk 2008", target, found.get(name, np.nan), rtol=0.01,
            reason=doubt, **cost)
    others = read_table(REFERENCE / "backward_step_second_schemes.csv")
    for scheme, source in (("ngsolve", "NGSolve, third order"), ("differences", "finite differences, extrapolated")):
        for name, length in zip(names, others[scheme]):
            yield context.row(f"step: {name.replace('_', ' ')} (heights)", source, length, found.get(name, np.nan), rtol=0.002,
                **cost)


def sudden_expansion(context):
    """Sudden expansion 1:3: symmetric below, asymmetric above, and the critical Reynolds number."""
    runs = {reynolds: context.run("cases/sudden_expansion.edp", {"-reynolds": float(reynolds), "-search": int(reynolds == 40)},
        f"expansion_{reynolds}")
            for reynolds in (35, 40, 50, 60)}
    found = {reynolds: run.folder.results for reynolds, run in runs.items()}
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for one, name, label in ((axes[0], "growth", "growth rate (1/s)"), (axes[1], "asymmetry", "largest |v| on the axis over the "
        "speed")):
        one.plot(list(found), [f[name] for f in found.values()], marker="o", **curve(0))
        one.axvline(40.45, color="black", linestyle=":", linewidth=0.8, label="Fearn et al. 1990")
        one.axhline(0, color="black", linewidth=0.5)
        one.set_xlabel("Reynolds number")
        one.set_ylabel(label)
    axes[0].legend(loc="best")
    path = save(figure, context.figure_path("expansion"))
    yield context.row("expansion: critical Reynolds number", "Fearn, Mullin & Cliffe 1990", 40.45, found[40]["critical_reynolds"],
        rtol=0.01,
                      cpu_s=runs[40].cpu_s, figure=path)
    yield context.row("expansion: asymmetry at 35", "symmetric", 0, found[35]["asymmetry"], at_most=1e-4, cpu_s=runs[35].cpu_s,
        figure=path)
    for reynolds in (50, 60):
        yield context.row(f"expansion: asymmetry at {reynolds}", "asymmetric", np.nan, found[reynolds]["asymmetry"], at_least=0.01,
                          cpu_s=runs[reynolds].cpu_s, figure=path)


def stable_jet(context):
    """The jet behind the diaphragm at Reynolds numbers 1e3, 1e4, 1e5, and particles crossing it."""
    runs = {}
    for reynolds in (1e3, 1e4, 1e5):
        try:
            runs[reynolds] = context.run("cases/pipe_jet.edp", {"-reynolds": reynolds, "-tend": 1.0}, f"jet_{reynolds:g}")
        except Failed as problem:
            yield context.failed(f"jet at {reynolds:g}: largest speed (m/s)", "bounded", np.nan, problem)
    figure, axes = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for k, (reynolds, run) in enumerate(runs.items()):
        fluid = run.folder.table("fluid")
        axes[0].plot(fluid["t"], fluid["top_speed"], **curve(k), label=f"Re {reynolds:g}")
        axes[1].plot(fluid["t"], fluid["kinetic_energy"], **curve(k))
    for one, label in zip(axes, ("largest speed (m/s)", "kinetic energy (J/m)")):
        one.set_xlabel("t (s)")
        one.set_ylabel(label)
        one.set_ylim(bottom=0)
        one.grid(True)
    axes[0].legend(loc="best")
    path = save(figure, context.figure_path("jet"))
    for reynolds, run in runs.items():
        fluid, budget = run.folder.table("fluid"), run.folder.table("budget")
        last, cost = {name: values[-1] for name, values in budget.items()}, {"cpu_s": run.cpu_s, "figure": path}
        yield context.row(f"jet at {reynolds:g}: largest speed (m/s)", "bounded", np.nan, fluid["top_speed"].max(), at_most=12,
            **cost)
        yield context.row(f"jet at {reynolds:g}: energy not accounted for over that supplied", "energy budget", 0,
                          abs(last["rest"]) / last["supplied"], at_most=1e-3, **cost)
        shares = ", ".join(f"{name} {100 * last[name] / last['supplied']:.2g} %" for name in ("gained", "damped", "dissipated",
            "smoothed", "left", "split"))
        yield context.row(f"jet at {reynolds:g}: energy taken by time stepping and splitting over that supplied", "energy budget",
            0,
                          abs(last["damped"] + last["split"]) / last["supplied"], at_most=0.05, reason=shares, **cost)
    run = context.run("cases/pipe_obstacles.edp", {"-reynolds": 1e4, "-number": 5, "-first": 0.1, "-tend": 1.0}, "particles_1e4")
    fluid = run.folder.table("fluid")
    yield context.row("5 particles through the jet at 1e4: largest speed (m/s)", "bounded", np.nan, fluid["top_speed"].max(),
        at_most=12, cpu_s=run.cpu_s)


VALIDATIONS = [poiseuille, taylor_green, cylinder_steady, cylinder_vortices, cylinder_pulse, cavity, backward_step,
    sudden_expansion, stable_jet, turbulence]
