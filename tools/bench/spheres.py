"""A settling sphere: error of its peak speed against time, and what a step costs against unknowns.

The fall: the whole box of cases/settling_sphere.edp with its fourth oil, and lbmpy's lattice (tools/peers/with_lbmpy_sphere.py);
the error is that against the experiment, 0.955 of the speed of the unbounded fall. The scaling, 26 thousand to 1.5 million: a
quarter of the box, the mesh of its recipe. Beyond 200,000 vertices the pressure is solved by conjugate gradients; the series
"conjugate gradients" does so on every mesh.
"""
import functools
import sys

import numpy as np

from tools.base.run_folder import RunFolder
from tools.base.runner import finished, reported, run_case, run_command
from tools.base.space_mesh import read_space_mesh
from tools.base.timed import step_time, tree
from tools.bench.rounds import Job
from tools.bench.scenes import OURS, mesh

DIAMETER = 0.015
SETTLING = "cases/settling_sphere.edp"
ITERATED = "conjugate gradients"
UNBOUNDED, PEAK = 0.128, 0.955  # m/s; measured peak over it (ten Cate et al. 2002)


def unknowns_of(path):
    """Three velocities at each vertex and edge, and a pressure at each vertex."""
    tetrahedra = read_space_mesh(path).tetrahedra
    pairs = np.concatenate([np.sort(tetrahedra[:, list(c)], axis=1) for c in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))])
    vertices, edges = len(np.unique(tetrahedra)), len(np.unique(pairs, axis=0))
    return 3 * (vertices + edges) + vertices


def fall(cells, dt, out, limit):
    """Peak speed of the fall in the whole box with `cells` elements across the sphere in a corridor 0.7 diameters to either side,
    and elements of a diameter far from it."""
    path = mesh("settling_sphere", f"whole_{cells:g}", out, "--part", "whole", "--size", f"{DIAMETER / cells:.12g}", "--corridor",
        f"{0.7 * DIAMETER:.12g}", "--coarse", f"{cells:g}")
    folder = out / "runs" / f"fall_{cells:g}_{dt:g}"
    done = finished(run_case(SETTLING, {"-mesh": str(path), "-dt": dt, "-cfl": 0, "-tend": 0.95}, out=folder, limit=limit))
    peak = -RunFolder(folder).columns("particles")["w"].min() / UNBOUNDED
    return {"unknowns": unknowns_of(path), "cpu_s": done.cpu_s, "memory_mb": done.memory_mb, "error": abs(peak / PEAK - 1)}


def fall_lbmpy(level, limit):
    """The same by lbmpy, without the compilation of its kernels."""
    done = finished(run_command([sys.executable, "-m", "tools.peers.with_lbmpy_sphere", "oil4", str(level)], limit))
    found = reported(done)
    return {"unknowns": found["unknowns"], "cpu_s": done.cpu_s, "own_s": found["cpu_s"], "memory_mb": done.memory_mb,
        "error": abs(found["peak"] / PEAK - 1)}


def fall_jobs(out, quick, lattice, limit):
    """Elements across the sphere and steps (s) of the standard scheme; lattice: whether lbmpy is there."""
    ours = [(4, 0.01)] if quick else [(4, 0.01), (6, 0.01), (8, 0.01), (10, 0.01)]
    levels = ([0] if quick else [0, 1, 2]) if lattice else []
    jobs = [Job("particles", "sphere", OURS, level, functools.partial(fall, *case, out, limit)) for level, case in enumerate(ours)]
    return jobs + [Job("particles", "sphere", "lbmpy", level, functools.partial(fall_lbmpy, level, limit)) for level in levels]


def sphere_step(cells, direct, out, steps, warm, limit):
    """A step of the settling sphere with `cells` elements across it, at the same displacement in elements on every mesh; direct:
    vertices up to which the pressure has a Cholesky factor."""
    folder = tree(out / "trees" / "spheres", SETTLING, steps, warm)
    path = mesh("settling_sphere", f"settling_sphere_{cells:g}", out, "--size", f"{DIAMETER / cells:.12g}")
    dt = 0.04 / cells
    options = {"-mesh": str(path), "-dt": dt, "-cfl": 0, "-tend": dt * (steps + 2), "-every": 1000, "-direct": direct}
    cost, memory = step_time(folder, SETTLING, options, out / "runs" / f"spheres_{cells:g}_{direct}", limit)
    return {"unknowns": unknowns_of(path), "step_s": cost, "memory_mb": memory}


# (elements across the sphere, steps, first steps that do not count)
STEPS = {False: {OURS: [(4, 25, 10), (6, 20, 8), (8, 15, 5), (12, 8, 3), (18, 6, 3)],
                 ITERATED: [(4, 25, 10), (8, 15, 5), (12, 8, 3)]},
         True: {OURS: [(4, 15, 5), (6, 8, 3)], ITERATED: [(4, 15, 5)]}}
DIRECT = {OURS: 200000, ITERATED: 0}


def sphere_jobs(out, quick, limit):
    """Both series; quick: on the coarsest meshes."""
    return [Job("scaling", "sphere", name, level, functools.partial(sphere_step, one, DIRECT[name], out, steps, warm, limit))
            for name, those in STEPS[quick].items() for level, (one, steps, warm) in enumerate(those)]
