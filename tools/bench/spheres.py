"""What a step of a settling sphere costs, and its memory, against unknowns: 26 thousand to 1.5 million.

A quarter of the box of cases/settling_sphere.edp, the mesh of its recipe. Beyond 200,000 vertices the pressure is solved by
conjugate gradients; the series "conjugate gradients" does so on every mesh.
"""
import functools

import numpy as np

from tools.base.space_mesh import read_space_mesh
from tools.base.timed import step_time, tree
from tools.bench.rounds import Job
from tools.bench.scenes import OURS, mesh

DIAMETER = 0.015
SETTLING = "cases/settling_sphere.edp"
ITERATED = "conjugate gradients"


def unknowns_of(path):
    """Three velocities at each vertex and edge, and a pressure at each vertex."""
    tetrahedra = read_space_mesh(path).tetrahedra
    pairs = np.concatenate([np.sort(tetrahedra[:, list(c)], axis=1) for c in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))])
    vertices, edges = len(np.unique(tetrahedra)), len(np.unique(pairs, axis=0))
    return 3 * (vertices + edges) + vertices


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
