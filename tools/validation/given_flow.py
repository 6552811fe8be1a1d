"""Flows that come as files (python -m tools.flow): tracers in a row of vortices against their exact paths, for
tools/validation/spheres.py."""
import contextlib
import io
import math

import meshio
import numpy as np
from scipy.integrate import solve_ivp

from tools.flow.main import main as convert

SCRIPT = "tests/transport/scripts/given.edp"
END = 1.0  # s; the fastest tracer then has gone once round
START = 0.5, np.linspace(0.1, 0.35, 6)  # x; y of the tracers, m


def vortex(x, y, t=0.0, swell=0.0):
    """Velocity (m/s) of a vortex in the unit square, times 1 + swell sin(2 pi t)."""
    factor = 1 + swell * np.sin(2 * np.pi * t)
    return factor * np.sin(np.pi * x) * np.cos(np.pi * y), -factor * np.cos(np.pi * x) * np.sin(np.pi * y)


def vortex_file(path, cells, kind="triangle", where="points", t=0.0, swell=0.0, shaken=0.2):
    """Writes the vortex as .vtu on cells x cells quadrilaterals, or twice as many triangles, whose inner corners are moved by up to
    `shaken` of a cell along each axis; where: points or cells."""
    random = np.random.default_rng(1)
    along = np.linspace(0, 1, cells + 1)
    x, y = np.meshgrid(along, along, indexing="ij")
    inner = np.zeros_like(x)
    inner[1:-1, 1:-1] = shaken / cells
    x, y = x + inner * random.uniform(-1, 1, x.shape), y + inner * random.uniform(-1, 1, x.shape)
    number = np.arange(x.size).reshape(x.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    blocks = [("quad", quads)] if kind == "quad" else [("triangle", np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))]
    points = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    at = points if where == "points" else points[blocks[0][1]].mean(axis=1)
    u, v = vortex(at[:, 0], at[:, 1], t, swell)
    velocity = np.column_stack([u, v, 0 * u])
    data = {"point_data": {"U": velocity}} if where == "points" else {"cell_data": {"U": [velocity]}}
    meshio.Mesh(points, blocks, **data).write(path)
    return path


def made(folder, name, files, *words):
    """The folder of the flow that tools.flow makes of the files, all of whose sides are walls."""
    with contextlib.redirect_stdout(io.StringIO()):
        convert([*map(str, files), "--out", str(folder / name), "--label", "wall=rest", *words])
    return folder / name


def astray(particles, swell=0.0):
    """The largest distance (m) of the tracers of a table of particles from the paths of the vortex, at its times."""
    x, (times, number) = START, (np.unique(particles["t"]), len(START[1]))
    exact = solve_ivp(lambda t, at: np.concatenate(vortex(at[:number], at[number:], t, swell)), (0, times[-1]),
        np.concatenate([np.full(number, x[0]), x[1]]), t_eval=times, rtol=1e-11, atol=1e-12).y
    order = np.lexsort((particles["id"], particles["t"]))
    found = [particles[axis][order].reshape(len(times), number).T for axis in "xy"]
    return float(np.hypot(found[0] - exact[:number], found[1] - exact[number:]).max())


def given_flow(context):
    """Tracers in a vortex from files: refined in space, from values at points and in cells, and in time. (Coarse ones need to be
    within a cell, or a twentieth of the square.)"""
    folder = context.out / "flows"
    folder.mkdir(parents=True, exist_ok=True)
    options = {"-tend": END, "-dt": 0.0025, "-every": 0.1}
    for where, kind, least, most in (("points", "triangle", 2.7, 5e-5), ("cells", "quad", 1.8, 4e-3)):
        errors = []
        for cells in (8, 16, 32):
            file = vortex_file(folder / f"{where}_{cells}.vtu", cells, kind, where)
            run = context.run(SCRIPT, {"-flow": made(folder, f"{where}_{cells}", [file]), **options}, f"given_{where}_{cells}")
            errors.append(astray(run.folder.particles))
            yield context.row(f"vortex of {cells} x {cells} {kind}s, values {'at' if where == 'points' else 'in'} {where}: "
                "distance of tracers to their paths (m)", "order 8 integrator", 0, errors[-1],
                at_most=most if cells == 32 else 1 / cells, cpu_s=run.cpu_s)
        yield context.row(f"the same: order of the last refinement, values {'at' if where == 'points' else 'in'} {where}",
            "of the interpolation", math.nan, math.log2(errors[-2] / errors[-1]), at_least=least)
    errors = []
    for intervals in (5, 10, 20):
        files = [vortex_file(folder / f"t{intervals}_{k}.vtu", 48, t=END * k / intervals, swell=0.5) for k in range(intervals + 1)]
        flow = made(folder, f"t{intervals}", files, "--times", ",".join(f"{END * k / intervals:g}" for k in range(intervals + 1)))
        run = context.run(SCRIPT, {"-flow": flow, **options}, f"given_times_{intervals}")
        errors.append(astray(run.folder.particles, 0.5))
        yield context.row(f"vortex that swells, {intervals} intervals of a period: distance of tracers to their paths (m)",
            "order 8 integrator", 0, errors[-1], at_most=2e-3 if intervals == 20 else 0.05, cpu_s=run.cpu_s)
    yield context.row("the same: order of the last refinement in time", "linear in between", 2, math.log2(errors[-2] / errors[-1]),
        at_least=1.8)
