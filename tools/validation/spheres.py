"""Verify the transport of particles against exact solutions, and write the table of it.

    python -m tools.validate_transport             everything (some ten minutes)
    python -m tools.validate_transport drag lift   some
    python -m tools.validate_transport --list      what there is

Writes report.html and report.csv (target, measured, pass) into --out (default
results/validation_transport). Status 0: all pass; 1: something does not; 3: bad input.
"""
import math
import re

import numpy as np

from tools.base.command import ROOT
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, freefem, run_command
from tools.base.timed import carried_step
from tools.peers import spheres_exact as exact
from tools.transport import fates as transport_table
from tools.validation.given_flow import given_flow
from tools.validation.two_way import TWO_WAY, unbalanced

SCRIPT = "tests/transport/scripts/analytic.edp"


def last(run):
    """Rows of the last time of particles.csv, by id."""
    table = run.folder.particles
    rows = table["t"] == table["t"].max()
    order = np.argsort(table["id"][rows])
    return {name: column[rows][order] for name, column in table.items()}


def relative(measured, target):
    """Largest |measured/target - 1|."""
    return float(np.max(np.abs(np.asarray(measured) / np.asarray(target) - 1)))


def order(errors, ratio=2.0):
    """Order of the last refinement of a list of errors."""
    return math.log(errors[-2] / errors[-1]) / math.log(ratio)


def drag(context):
    """Coefficients of each law against the figures given with them."""
    done = finished(run_command([freefem(), "-nw", "tests/transport/scripts/drag.edp"], context.limit))
    found = {(law, float(number)): float(cd) for law, number, cd in re.findall(r"row,([\w-]+),([\w.e+-]+),([\w.e+-]+)", done.log)}
    for k, law in enumerate(exact.VECTOR_LAWS):
        worst = relative(*zip(*((found[law, number], row[k]) for number, row in exact.VECTORS.items() if row[k])))
        yield context.row(f"{law}: worst of C_D at Re 0.1 to 1e4, relative", "figures of the laws", 0, worst, at_most=2e-5,
            cpu_s=done.cpu_s)
    for law, formula in exact.LAWS.items():
        pairs = [(cd, formula(number)) for (name, number), cd in found.items() if name == law and number >= 1e-3]
        yield context.row(f"{law}: worst of C_D at Re 1e-3 to 2e6, relative", "formula in Python", 0, relative(*zip(*pairs)),
            at_most=1e-8)


def terminal(context):
    """Terminal velocities of 30 spheres, Re 0.1 to 1e4, with a step far above the response time."""
    for law in exact.LAWS:
        if law == "stokes":
            continue
        run = context.run(SCRIPT, {"-drag": law, "-number": 30, "-radius": 3e-5, "-radius-last": 7e-3, "-tend": 4, "-dt": 0.02,
                                   "-every": 4}, f"terminal_{law}")
        rows = last(run)
        off = [min(abs(-v / one - 1) for one in exact.terminal_velocities(law, r, 2500.0)) for r, v in zip(rows["radius"],
            rows["v"])]
        yield context.row(f"{law}: worst terminal velocity of 30 spheres, relative", "balance of drag and weight", 0, np.max(off),
            at_most=1e-8, cpu_s=run.cpu_s)


def startup(context):
    """Stokes start-up from rest, with and without added mass: exponentials."""
    for added in (0, 1):
        run = context.run(SCRIPT, {"-drag": "stokes", "-radius": 5e-5, "-tend": 0.02, "-dt": 0.001, "-added-mass": added},
            f"startup_{added}")
        table = run.folder.particles
        v = exact.no_history(table["t"], 5e-5, 2500.0, added=0.5 * added)
        yield context.row(f"start-up {'with' if added else 'without'} added mass: worst velocity over the terminal one",
            "exponential",
                          0, float(np.max(np.abs(table["v"] + v)) / v[-1]), at_most=1e-9, cpu_s=run.cpu_s)


def history(context):
    """Start-up with the Basset force: the closed solution with erfc; order; long memory."""
    errors = []
    for dt in (2e-4, 1e-4):
        run = context.run(SCRIPT, {"-drag": "stokes", "-radius": 5e-5, "-tend": 0.02, "-dt": dt, "-history": 1,
            "-history-window": 60}, f"history_{dt:g}")
        table = run.folder.particles
        v = exact.basset_velocity(table["t"], 5e-5, 2500.0)
        errors.append(float(np.max(np.abs(table["v"] + v)) / v[-1]))
    yield context.row("history: worst velocity over the last, dt = 1e-4 s (response time 1.7e-3 s)", "erfc solution", 0,
        errors[-1], at_most=1e-3, cpu_s=run.cpu_s)
    yield context.row("history: order in time", "erfc solution", 2, order(errors), at_least=1.6)
    run = context.run(SCRIPT, {"-drag": "stokes", "-radius": 5e-5, "-tend": 1, "-dt": 2e-4, "-history": 1, "-history-window": 20,
        "-every": 0.01}, "history_long")
    table = run.folder.particles
    v = exact.basset_velocity(table["t"], 5e-5, 2500.0)
    yield context.row("history: worst velocity over the last after up to 5000 steps, window of 20", "erfc solution", 0,
                      float(np.max(np.abs(table["v"] + v)[1:]) / v[-1]), at_most=1e-3, cpu_s=run.cpu_s)
    without = exact.no_history(table["t"], 5e-5, 2500.0)
    yield context.row("history: what it changes there, for comparison", "", math.nan, float(np.max(np.abs(table["v"] + without))
        / v[-1]), at_least=0.05)


def history_cost(context):
    """Cost a step of the history after many steps: constant."""
    run = context.run(SCRIPT, {"-drag": "stokes", "-radius": 5e-5, "-number": 20000, "-tend": 0.04, "-dt": 1e-4, "-history": 1,
        "-every": 0.01}, "history_cost")
    spent = run.folder.table("steps")["time_forces"]
    yield context.row("history: cost of the steps 300 to 400 over that of 100 to 200", "constant cost", 1,
        float(spent[4] / spent[2]), at_most=1.3, cpu_s=run.cpu_s)


def compared(context, name, flow, options, law="stokes", start=(0.5, 0.3, 0.2, -0.1, 3.0), end=1.5, rate=2.0, steps=(0.025, 0.0125),
    **forces):
    """Errors of position for the steps: distance to the accurate path; and the CPU time."""
    target = exact.path(flow, start, end, forces.pop("radius"), forces.pop("density", 2500.0), law=law, rate=rate, **forces)
    errors = []
    for dt in steps:
        x, y, u, v, omega = start
        run = context.run(SCRIPT, {"-flow": flow, "-drag": law or "off", "-rate": rate, "-start-x": x, "-start-y": y,
            "-start-u": u, "-start-v": v,
                                   "-start-omega": omega, "-tend": end, "-dt": dt, "-every": end, **options}, f"{name}_{dt:g}")
        rows = last(run)
        errors.append(float(np.hypot(rows["x"][0] - target[0], rows["y"][0] - target[1])))
    return errors, run.cpu_s


def lift(context):
    """A sphere lagging in a linear shear, alone under lift: it goes towards the faster fluid."""
    errors, cpu = compared(context, "lift", "shear", {"-radius": 0.001, "-buoyancy": 0}, start=(0, 0.5, 0.0, 0, 0), end=0.5,
                           radius=0.001, buoyancy=0)
    yield context.row("lift in a linear shear: distance to the accurate path, dt = 0.0125 s", "order 8 integrator", 0, errors[-1],
        at_most=2e-4, cpu_s=cpu)
    yield context.row("lift in a linear shear: order", "order 8 integrator", 2, order(errors), at_least=1.9)
    run = context.run(SCRIPT, {"-flow": "shear", "-rate": 2, "-drag": "off", "-added-mass": 0, "-buoyancy": 0, "-radius": 0.001,
        "-start-y": 0.5,
                               "-tend": 0.001, "-dt": 0.001}, "lift_start")
    want = 0.5 * 1000 / 2500 * 2.0 * 1.0 * 0.001  # C_L rho_f/rho_p G (u - U) t
    yield context.row("lift in a linear shear: velocity gained at the start (m/s)", "C_L rho_f/rho_p G (u - U) t", want,
        last(run)["v"][0], rtol=2e-3, cpu_s=run.cpu_s)


def magnus(context):
    """A spinning sphere in a fluid at rest: a spiral in closed form."""
    radius, density, mu, rho = 0.001, 2500.0, 0.001, 1000.0
    mass = 4 / 3 * np.pi * radius**3 * (density + 0.5 * rho)
    decay = 6 * np.pi * mu * radius / mass
    spin = 8 * np.pi * mu * radius**3 / (0.4 * 4 / 3 * np.pi * radius**5 * density)
    turn = np.pi * radius**3 * rho / mass
    errors = []
    for dt in (0.01, 0.005):
        run = context.run(SCRIPT, {"-drag": "stokes", "-buoyancy": 0, "-lift": 0, "-magnus": 1, "-radius": radius, "-start-u": 1,
            "-start-omega": 30,
                                   "-tend": 0.4, "-dt": dt, "-every": 0.4}, f"magnus_{dt:g}")
        rows = last(run)
        w = np.exp(-decay * 0.4 + 1j * turn * 30 * (1 - np.exp(-spin * 0.4)) / spin)
        errors.append(abs(rows["u"][0] + 1j * rows["v"][0] - w))
    yield context.row("Magnus: error of the velocity of a spinning sphere, dt = 0.005 s (m/s)", "closed solution", 0,
        float(errors[-1]), at_most=1e-4, cpu_s=run.cpu_s)
    yield context.row("Magnus: order", "closed solution", 2, order(errors), at_least=1.9)
    yield context.row("Magnus: rotation left (rad/s)", "viscous torque", 30 * np.exp(-spin * 0.4), float(rows["omega"][0]),
        rtol=1e-9)


def tracer(context):
    """A neutrally buoyant small sphere follows the fluid in a Taylor-Green vortex."""
    start = (0.5, 0.3, math.sin(0.5) * math.cos(0.3), -math.cos(0.5) * math.sin(0.3), 0.0)
    target = exact.path("vortex", start, 4.0, 1e-5, 1000.0, law=None, buoyancy=0, fluid=1, lift=0)
    errors = []
    for dt in (0.05, 0.025):
        run = context.run(SCRIPT, {"-flow": "vortex", "-density": 1000, "-radius": 1e-5, "-fluid-acceleration": 1,
            "-start-x": start[0], "-start-y": start[1],
                                   "-start-u": start[2], "-start-v": start[3], "-drag": "schiller-naumann", "-tend": 4, "-dt": dt,
                                       "-every": 4}, f"tracer_{dt:g}")
        rows = last(run)
        errors.append(float(np.hypot(rows["x"][0] - target[0], rows["y"][0] - target[1])))
    yield context.row("tracer in a vortex: distance to the path of the fluid, dt = 0.025 s (m)", "order 8 integrator", 0,
        errors[-1], at_most=5e-4, cpu_s=run.cpu_s)
    yield context.row("tracer in a vortex: order", "order 8 integrator", 2, order(errors), at_least=1.9)


def converging(context):
    """Fluid acceleration in a straining flow, with and without."""
    errors, cpu = compared(context, "converging", "straining", {"-radius": 0.001, "-fluid-acceleration": 1, "-lift": 0},
        radius=0.001, fluid=1, lift=0)
    yield context.row("fluid acceleration in a converging flow: distance to the accurate path, dt = 0.0125 s (m)",
        "order 8 integrator", 0, errors[-1], at_most=1e-3, cpu_s=cpu)
    yield context.row("fluid acceleration in a converging flow: order", "order 8 integrator", 2, order(errors), at_least=1.9)
    run = context.run(SCRIPT, {"-flow": "straining", "-rate": 2, "-radius": 0.001, "-drag": "off", "-buoyancy": 0, "-lift": 0,
        "-added-mass": 0, "-fluid-acceleration": 1,
                               "-start-x": 0.5, "-tend": 0.001, "-dt": 0.001}, "converging_start")
    yield context.row("fluid acceleration: velocity gained at the start (m/s)", "rho_f/rho_p G^2 x t", 0.4 * 4 * 0.5 * 0.001,
        float(last(run)["u"][0]), rtol=2e-3)


def together(context):
    """All forces but history together: orders, from a response time far above to far below the step."""
    for radius, what in ((0.02, "heavy inertia"), (0.001, "between"), (1e-5, "response time far below the step")):
        errors, cpu = compared(context, f"together_{radius:g}", "vortex", {"-radius": radius, "-fluid-acceleration": 1,
            "-magnus": 1}, law="brown-lawler",
                               radius=radius, fluid=1, magnus=1)
        yield context.row(f"all forces in a vortex, {what}: distance to the accurate path, dt = 0.0125 s (m)",
            "order 8 integrator", 0, errors[-1], at_most=2e-4, cpu_s=cpu)
        yield context.row(f"all forces in a vortex, {what}: order", "order 8 integrator", 2, order(errors), at_least=1.75)


def unsteady(context):
    """A stream that oscillates: drag, added mass and fluid acceleration with the flow's change in time."""
    errors, cpu = compared(context, "unsteady", "oscillating", {"-radius": 0.001, "-fluid-acceleration": 1}, law="brown-lawler",
        radius=0.001, fluid=1)
    yield context.row("oscillating stream: distance to the accurate path, dt = 0.0125 s (m)", "order 8 integrator", 0, errors[-1],
        at_most=2e-4, cpu_s=cpu)
    yield context.row("oscillating stream: order", "order 8 integrator", 2, order(errors), at_least=1.9)


def dispersion(context):
    """Spread of 20,000 tracers in homogeneous turbulence, short and long times."""
    sigma, lagrangian = 0.1, 0.3
    run = context.run(SCRIPT, {"-turbulence": "fluctuation", "-sigma": sigma, "-decay": 1, "-density": 1000, "-radius": 1e-5,
        "-drag": "stokes", "-number": 20000,
                               "-buoyancy": 0, "-lift": 0, "-tend": 3, "-dt": 0.03, "-every": 0.3}, "dispersion")
    table = run.folder.particles
    for time in (0.3, 1.5, 3.0):
        rows = np.abs(table["t"] - time) < 1e-9
        for axis in "xy":
            yield context.row(f"dispersion: variance of {axis} after {time / lagrangian:g} Lagrangian times (m2)", "Taylor 1921",
                exact.dispersion(time, sigma, lagrangian),
                              float(np.var(table[axis][rows])), rtol=0.05, cpu_s=run.cpu_s)
    rows = np.abs(table["t"] - 3.0) < 1e-9
    yield context.row("dispersion: correlation of x and y", "independent", 0,
        float(np.corrcoef(table["x"][rows], table["y"][rows])[0, 1]), atol=0.03)


def mixed(context):
    """Well mixed tracers stay so where sigma varies by a factor of 4; without the drift they do not."""
    options = {"-turbulence": "fluctuation", "-sigma": 0.5, "-sigma-slope": 0.6, "-decay": 3, "-density": 1000, "-radius": 1e-5,
        "-drag": "stokes", "-number": 20000,
               "-buoyancy": 0, "-lift": 0, "-spread": 2 * math.pi * (1 - 1 / 20000), "-tend": 15, "-dt": 0.02, "-every": 15}
    for drift in (1, 0):
        run = context.run(SCRIPT, {**options, "-turbulence-drift": drift}, f"mixed_{drift}")
        share = np.histogram(np.mod(last(run)["y"], 2 * math.pi), bins=8, range=(0, 2 * math.pi))[0] / 20000 * 8
        worst = float(np.max(np.abs(share - 1)))
        if drift:
            yield context.row("well mixed tracers, sigma 0.2 to 0.8 m/s: worst density of 8 strips, off 1", "uniform", 0, worst,
                at_most=0.08, cpu_s=run.cpu_s)
        else:
            yield context.row("the same without the drift, for comparison", "", math.nan, worst, at_least=0.1, cpu_s=run.cpu_s)


def pair(context):
    """A pair that falls in contact: one body."""
    radii = np.array([0.001, 0.002])
    inside, face = (4 / 3 * np.pi * radii**3).sum(), (np.pi * radii**2).sum()
    final = math.sqrt(1500 * 9.81 * inside / (0.5 * 1000 * 0.44 * face))
    target = -final * math.tanh(0.08 * 0.5 * 1000 * 0.44 * face * final / (3000 * inside))
    run = context.run(SCRIPT, {"-number": 2, "-radius": 0.001, "-radius-last": 0.002, "-spread": 0.003, "-contacts": 1, "-lift": 0,
        "-tend": 0.08, "-dt": 0.001}, "pair")
    for k, v in enumerate(last(run)["v"]):
        yield context.row(f"pair in contact, {'upper' if k else 'lower'} sphere: velocity (m/s)", "one body, closed form", target,
            v, rtol=1e-3, cpu_s=run.cpu_s)


def speed(context):
    """Cost of a step: 100,000 particles, and its growth."""
    cost = {}
    for number in (10000, 100000):
        flow, forces, _ = carried_step(number, 20, 0, context.out / "bench")
        cost[number] = flow + forces
    yield context.row("one-way, all forces but history, 100,000 particles: steps a second of CPU", "target", 5, 1 / cost[100000],
        at_least=5)
    yield context.row("the same: exponent of the cost's growth from 10,000 to 100,000 particles", "linear", 1,
        math.log10(cost[100000] / cost[10000]), at_most=1.15)


def application(context):
    """50 particles through the pipe: time, nobody lost, no overlap; the flow is there or is computed."""
    context.run("cases/pipe_transport.edp", {"-tend": 0.002}, "flow")
    for forces in ("paper", "all"):
        run = context.run("cases/pipe_transport.edp", {"-forces": forces}, f"application_{forces}")
        steps = run.folder.table("steps")
        yield context.row(f"50 particles, 5 s, forces {forces}: seconds of CPU after the flow is there", "target", 30, run.cpu_s,
            at_most=30, cpu_s=run.cpu_s)
        yield context.row("the same: particles that are neither inside nor left by the outlet", "none", 0,
                          50 - steps["waiting"][-1] - steps["particles"][-1] - steps["left"][-1], atol=0)
        yield context.row("the same: worst gap over the smallest radius", "no overlap", 0, steps["worst_gap"].min() / 0.005,
            at_least=-1e-8)
    run = context.run("cases/pipe_transport.edp", {"-coupling": "two-way", "-tend": 0.5}, "application_two_way")
    table = run.folder.table("coupling")
    yield context.row("two-way in the turbulent pipe: total of the source against the forces, relative", "opposite", 0,
        unbalanced(table), at_most=1e-11, cpu_s=run.cpu_s)


def seeds(context):
    """The table by diameter class over 20 seeds (runs of tools.transport_table are used if they are there): its fates account for
    everyone."""
    rows = transport_table.table_of([RunFolder(folder) for folder in transport_table.compute(20, ROOT / "results"
        / "transport_table", {}, 1)])
    whole = dict(zip(transport_table.FATES, rows[-1][3::2]))
    yield context.row("20 seeds: carried through, trapped and behind together, % of the particles", "everyone, but who entered "
        "in the last second", 100,
                      whole["carried through"] + whole["trapped"] + whole["behind"], atol=1)
    yield context.row("20 seeds: standard deviation of what is carried through, all classes, %", "seeds differ", math.nan,
        rows[-1][4], at_least=0.1)


SPHERES = [drag, terminal, startup, history, history_cost, lift, magnus, tracer, converging, together, unsteady, dispersion, mixed,
    pair, given_flow, *TWO_WAY, speed, application, seeds]


def main(words=None):
    """As tools.validate, with these comparisons and a folder of their own."""
    from tools.validation import main as validate
    return validate.main(words, {"transport": SPHERES}, prog="python -m tools.validate_transport", description=__doc__,
        folder="validation_transport")
