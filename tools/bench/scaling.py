"""What a step costs, and how much memory a run takes: against unknowns and against particles.

Unknowns: the settling disk, from 4 elements across it. Particles: the pipe on one mesh, without
particles in the program (scripts/flow.edp) and with 0, 1, 50 and 500 disks, in small steps while the
inflow starts; and in the steps of the case, when the jet behind the diaphragm stands (0.23 to 0.28 s). On that mesh
the disks have 1.7 elements across; with elements of 3 mm they have 3.3, and the flow round them is resolved: in small steps while
the inflow starts, and when the stream carries them (0.08 to 0.1 s).
"""
import functools

from tools.base.timed import step_time, tree
from tools.bench.rounds import Job
from tools.bench.scenes import OURS, mesh, pipe_step

IN_JET, FINE, CARRIED, FINE_SIZE = "standard, in the jet", "standard, 3 mm", "standard, 3 mm, carried", 0.003
DIAMETER = 0.25
SETTLING = "cases/settling_disk.edp"


def disk_step(scheme, cells, out, steps, warm, limit):
    """A step of the settling disk with `cells` elements across it; the disk falls the same part
    of an element a step on every mesh."""
    folder = tree(out / "trees" / f"scaling_{scheme}", SETTLING, steps, warm)
    dt = 0.005 / cells
    options = {"-mesh": str(mesh("settling_disk", f"settling_{cells:g}", out, "--size", f"{DIAMETER / cells:.12g}")),
        "-scheme": scheme,
               "-dt": dt, "-tend": dt * (steps + 2), "-every": 1000}
    cost, memory = step_time(folder, SETTLING, options, out / "runs" / f"scaling_{scheme}_{cells:g}", limit)
    columns, rows = round(2 * cells / DIAMETER), round(6 * cells / DIAMETER)
    return {"unknowns": 2 * (2 * columns + 1) * (2 * rows + 1) + (columns + 1) * (rows + 1), "step_s": cost, "memory_mb": memory}


def scaling_jobs(out, cells, disks, jet, fine, carried, limit, size=None):
    """cells: {program: [(elements across the disk, steps, first steps that do not count)]};
    disks: {program: [(number or None, steps, the same)]}; jet: such a list, of the standard scheme in the case's own steps; fine,
    carried: two in
    smaller elements."""
    jobs = [Job("scaling", "unknowns", program, level, functools.partial(disk_step, program, one, out, steps, warm, limit))
            for program, those in cells.items() for level, (one, steps, warm) in enumerate(those)]
    for program, those in disks.items():
        for level, (number, steps, warm) in enumerate(those):
            name = "no particles in the program" if number is None else program
            jobs.append(Job("scaling", "particles", name, level, functools.partial(pipe_step, program, number, out, steps, warm,
                limit, size)))
    for name, those in ((FINE, fine), (CARRIED, carried)):
        jobs += [Job("scaling", "particles", name, level, functools.partial(pipe_step, OURS, number, out, steps, warm, limit,
            FINE_SIZE)) for level, (number, steps, warm) in enumerate(those)]
    return jobs + [Job("scaling", "particles", IN_JET, level, functools.partial(pipe_step, OURS, number, out, steps, warm, limit,
        size, own=True))
                   for level, (number, steps, warm) in enumerate(jet)]


