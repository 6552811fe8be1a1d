"""Comparisons of the two-way coupling with closed forms, for tools/validation/spheres.py."""
import math

import numpy as np

from tools.base.mesh_files import read_mesh
from tools.meshing.plane_mesh import signed_areas

CLOUD = "tests/transport/scripts/cloud.edp"
RHO, DENSITY, RADIUS = 1000.0, 2500.0, 0.01  # of CLOUD
VOLUME = 4 / 3 * math.pi * RADIUS**3


def cloud(context, name, **options):
    """A run of CLOUD; options with _ for -."""
    return context.run(CLOUD, {"-" + key.replace("_", "-"): value for key, value in options.items()}, name)


def total_momentum(run, different):
    """(times, momentum of fluid and spheres together along x and y), N s."""
    spheres, fluid = run.folder.particles, run.folder.table("coupling")
    mass = DENSITY * VOLUME * (1 + different * (spheres["id"] % 2))
    parts = []
    for axis, velocity in (("x", "u"), ("y", "v")):
        own = [np.sum((mass * spheres[velocity])[np.abs(spheres["t"] - t) < 1e-9]) for t in fluid["t"]]
        parts.append(np.array(own) + fluid[f"momentum_{axis}"])
    return fluid["t"], parts


def changed(*parts):
    """The largest change of one of several quantities since the first row; nan where a row is."""
    return np.max([np.abs(part - part[0]) for part in parts])


def unbalanced(table):
    """The largest sum of source and force, over the largest force downwards; nan where a row is."""
    return np.max([np.abs(table[f"source_{a}"] + table[f"force_{a}"]) for a in "xy"]) / np.max(np.abs(table["force_y"]))


def momentum(context):
    """Fluid and spheres in a periodic box keep their momentum, contacts and all forces included."""
    run = cloud(context, "momentum", coupling_width=0.05, mu=0.01, drag="constant", lift=1, history=1, magnus=1, tend=0.2,
        depth=0.1, contacts=1, converge=10,
                different=3, start_v=0.3)
    _, parts = total_momentum(run, 3)
    touched = len(run.folder.table("contacts")["t"])
    yield context.row("two-way, cloud that collides: rows of contacts", "so that contacts are tested", math.nan, touched,
        at_least=100, cpu_s=run.cpu_s)
    worst = changed(*parts) / np.hypot(parts[0][0], parts[1][0])
    yield context.row("two-way, cloud that collides: change of the momentum of fluid and spheres, relative", "conserved", 0, worst,
        at_most=3e-11)
    gained = run.folder.table("coupling")["momentum_x"][-1] / parts[0][0]
    yield context.row("two-way, cloud that collides: share of the momentum that is the fluid's at the end",
        "so that there is something to conserve", math.nan, gained, at_least=0.1)
    run = cloud(context, "fast", coupling_width=0.1, mu=0.5, start_u=3, tend=0.16, depth=0.02, dt=0.02)
    _, parts = total_momentum(run, 0)
    yield context.row("two-way, fast cloud: factorisations", "so that the matrix is made anew", math.nan,
        run.folder.table("coupling")["factorisations"][-1], at_least=2, cpu_s=run.cpu_s)
    worst = changed(*parts) / parts[0][0]
    yield context.row("two-way, fast cloud: change of the momentum of fluid and spheres, relative", "conserved", 0, worst,
        at_most=3e-11)
    run = cloud(context, "weight", coupling_width=0.05, mu=0.01, drag="constant", lift=1, buoyancy=1, tend=0.2, depth=0.1)
    times, parts = total_momentum(run, 0)
    given = -100 * (DENSITY - RHO) * VOLUME * 9.81 * times
    worst = changed(parts[0], parts[1] - given) / np.max(np.abs(given))
    yield context.row("two-way, cloud that falls: momentum of fluid and spheres less weight times time, relative", "balance", 0,
        worst, at_most=3e-11, cpu_s=run.cpu_s)
    table = run.folder.table("coupling")
    yield context.row("two-way: total of the source against the force on the spheres, relative", "opposite", 0, unbalanced(table),
        at_most=1e-11)


def approach(context):
    """A uniform source: fluid and spheres approach each other exponentially."""
    for added in (0, 1):
        errors = []
        mass, extra, fluid, beta = (100 * DENSITY * VOLUME, 100 * added * 0.5 * RHO * VOLUME, RHO * 0.001,
            100 * 6 * math.pi * 0.5 * RADIUS)
        q = 1 + mass / fluid
        rate, end = beta * q / (mass + extra * q), mass / (mass + fluid)
        target = end + (1 - end) * math.exp(-0.1 * rate)
        for dt in (0.005, 0.0025):
            run = cloud(context, f"approach_{added}_{dt:g}", coupling_width=10, added_mass=added, dt=dt)
            errors.append(abs(run.folder.particles["u"][-1] - target))
        what = "with" if added else "without"
        yield context.row(f"two-way, uniform source, {what} added mass: error of the spheres' velocity, dt = 0.0025 s (m/s)",
            "exponential", 0, errors[-1],
                          at_most=5e-4 if added else 5e-5, cpu_s=run.cpu_s)
        yield context.row(f"two-way, uniform source, {what} added mass: order", "exponential", 1 if added else 2,
            math.log2(errors[-2] / errors[-1]),
                          at_least=0.8 if added else 1.9)


def settled(context):
    """A sphere that settles steadily: weight less buoyancy goes to the fluid."""
    run = cloud(context, "settled", number=1, drag="clift", buoyancy=1, depth=1e6, tend=1, coupling_width=0.05, mu=1, start_u=0,
        start_v=0)
    yield context.row("two-way: force of the fluid on a sphere that settles steadily, by the reaction (N)", "(m_p - m_f) g",
        (DENSITY - RHO) * VOLUME * 9.81,
                      run.folder.table("coupling")["force_y"][-1], rtol=1e-6, cpu_s=run.cpu_s)


def sheet(context):
    """A column of settling spheres is a sheet of force: its momentum spreads by viscosity, in a stream too."""
    nu, length, time = 0.1, 0.05, 0.5
    rate = 100 * (DENSITY - RHO) * VOLUME * 9.81 / (RHO * 1e4)
    waves = 2 * math.pi * np.arange(1, 400)
    target = rate * (time + np.sum(2 * (1 + (length * waves) ** 2) ** -2.0 * (1 - np.exp(-nu * waves**2 * time)) / (nu * waves**2)))
    for stream in (0, 1):
        run = cloud(context, f"sheet_{stream}", column=1, stream=stream, start_u=stream, start_v=0, depth=1e4, buoyancy=1, mu=100,
            tend=0.5, coupling_width=0.1)
        where = "in a stream that carries it (Galilean)" if stream else "in fluid at rest"
        yield context.row(f"two-way, sheet of settling spheres {where}: largest velocity of the fluid (m/s)",
            "Fourier series of viscous spread and kernel", target,
                          run.folder.table("coupling")["change_most"][-1], rtol=5e-3, cpu_s=run.cpu_s)


PIPE = {"-model": "laminar", "-reynolds": 50, "-tend": 0.05, "-every": 0}


def pipe(context):
    """The pipe, laminar: nothing drifts without particles; a uniform push changes the pressure only."""
    mesh = context.mesh("pipe_transport", 0.014)
    flow = context.out / "flow_laminar_50"
    run = context.run("cases/pipe_transport.edp", {**PIPE, "-coupling": "two-way", "-number": 0, "-flow": flow}, "drift", mesh)
    yield context.row("two-way, pipe without particles: largest change of the steady flow (m/s)", "none", 0,
        np.max(run.folder.table("coupling")["change_most"]),
                      at_most=1e-9, cpu_s=run.cpu_s)
    run = context.run("cases/pipe_transport.edp", {**PIPE, "-coupling": "two-way", "-number": 5, "-interval": 0,
        "-coupling-width": 5, "-depth": 0.157, "-flow": flow}, "push", mesh)
    table, grid = run.folder.table("coupling"), read_mesh(mesh)
    size = np.abs(signed_areas(grid.points, grid.triangles)).sum()
    force = 1.5 * table["force_x"][1:] - 0.5 * table["force_x"][:-1]  # as the source is extrapolated
    yield context.row("two-way, pipe, uniform source: change of the pressure drop at the last step (Pa)",
        "force over volume, times length",
                      force[-1] / (size * 0.157), table["pressure_drop_change"][-1], rtol=5e-3, cpu_s=run.cpu_s)


TWO_WAY = [momentum, approach, settled, sheet, pipe]
