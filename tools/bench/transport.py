"""The jobs of one-way transport: a thousand spheres in a cellular flow, and the cost of a step.

The error is the mean distance from the positions of an eighth-order method with tolerance 1e-12,
over the length of the mean path. own_s of the suite is what its steps take, that of SciPy what
its integrator takes: neither reads nor writes files in it.
"""
import functools
import sys

import numpy as np

from tools.base.run_folder import RunFolder
from tools.base.runner import finished, reported, run_case, run_command
from tools.base.timed import carried_step
from tools.bench.rounds import Job
from tools.bench.scenes import OURS
from tools.peers.with_scipy import DENSITY, END, NUMBER, RADIUS, SPREAD, START_X, start

STEPS = [0.02, 0.005, 0.00125]  # s


def peer(problem, level, path):
    """Final state by SciPy: (array 4 x N, Done)."""
    path.parent.mkdir(parents=True, exist_ok=True)
    done = finished(run_command([sys.executable, "-m", "tools.peers.with_scipy", problem, str(level), str(path)]))
    return np.load(path), done


@functools.lru_cache(1)
def reference(out):
    """Positions 2 x N at the end, all digits."""
    return peer("reference", 0, out / "runs" / "spheres_reference.npy")[0][:2]


def distance(positions, out):
    """Mean distance from the reference over the mean path."""
    exact = reference(out)
    return float(np.hypot(*(positions - exact)).mean() / np.hypot(*(exact - start().reshape(4, -1)[:2])).mean())


def by_scipy(level, out):
    found, done = peer("vortex", level, out / "runs" / f"spheres_scipy_{level}.npy")
    return {"unknowns": NUMBER, "cpu_s": done.cpu_s, "own_s": reported(done)["cpu_s"], "error": distance(found[:2], out),
        "memory_mb": done.memory_mb}


def by_suite(level, out):
    folder = out / "runs" / f"spheres_{level}"
    done = finished(run_case("tests/transport/scripts/analytic.edp", {
        "-flow": "vortex", "-number": NUMBER, "-radius": RADIUS, "-density": DENSITY, "-start-x": START_X, "-spread": SPREAD,
            "-tend": END, "-dt": STEPS[level],
        "-drag": "brown-lawler", "-fluid-acceleration": 1, "-lift": 1, "-every": END}, out=folder))
    run = RunFolder(folder)
    table, steps = run.particles, run.table("steps")
    last = table["t"] > END * (1 - 1e-9)
    order = np.argsort(table["id"][last])
    positions = np.array([table["x"][last][order], table["y"][last][order]])
    own = float(sum(steps[name].sum() for name in ("time_flow", "time_forces")))
    return {"unknowns": NUMBER, "cpu_s": done.cpu_s, "own_s": own, "error": distance(positions, out), "memory_mb": done.memory_mb}


def step_cost(number, steps, out):
    flow, forces, memory = carried_step(number, steps, 0, out)
    return {"unknowns": number, "step_s": flow + forces, "memory_mb": memory}


def transport_jobs(out, numbers, levels, steps=20):
    """Error against time of a thousand spheres, and the cost of a step of `numbers` of them."""
    jobs = [Job("transport", "spheres", name, level, functools.partial(function, level, out))
            for level in range(levels) for name, function in ((OURS, by_suite), ("SciPy", by_scipy))]
    return jobs + [Job("transport", "step", OURS, level, functools.partial(step_cost, number, steps, out)) for level,
        number in enumerate(numbers)]
