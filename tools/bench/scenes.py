"""The jobs of flow, particles, contacts and transport: one a program and resolution.

References: DFG 2D-1 and 2D-2 (FeatFlow); settling disk: body-fitted transient, mean velocity over
0.3 to 0.4 s; disk turning in a shear flow between plates: body-fitted, R/H = 0.25.
"""
import functools
import sys

import numpy as np

from tools.base import quantities
from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, make_mesh, reported, run_case, run_command
from tools.base.timed import step_time, tree
from tools.bench import flow
from tools.bench.flow import OURS, PUBLISHED, over_neighbours
from tools.bench.rounds import Job
from tools.bench.skip import PIPE_STEP
from tools.peers import contact_packages as bench_contacts
from tools.validation.settling_disk import fitted_mean

FALL, TURN = fitted_mean(), 0.8392
PAIR = (3.1336, 3.5257)  # heights at 0.15 s, cm: tests/reference/two_disks_second_scheme.csv
PIPE = "cases/pipe_obstacles.edp"
NEARBY = (1.0, 0.95, 1.05)  # sizes of elements, or time steps of a lattice, over one's own
# fine where the disk falls in 0.4 s
PATH = "--pattern unstructured --corridor-width 0.5 --corridor-bottom 1.8 --corridor-top 4.3 --coarse-factor 8 --growth 0.4".split()


def mesh(recipe, name, out, *words):
    """A mesh file made by tools.mesh, once."""
    path = out / "meshes" / f"{name}.mesh"
    return path if path.is_file() else make_mesh([recipe, *words], path)


def unknowns(folder):
    """Unknowns of P2/P1 on the mesh of a run of a domain without holes."""
    return flow.size_of(RunFolder(folder), holes=0)


def flow_jobs(out, levels, limit):
    """DFG 2D-1, DFG 2D-2 and the cavity by tools/bench/flow.py. levels: {problem: {program: levels}}."""
    return [Job("flow", problem, program, level, functools.partial(flow.judged, program, problem, level, out, limit))
            for problem, programs in levels.items() for level in range(3)
            for program, those in programs.items() if level in those]


def settling(scheme, cells, dt, out, limit):
    """Mean fall velocity over 0.3 to 0.4 s with `cells` elements across the disk, larger ones away from its path; the slow
    published scheme once."""
    def run(factor):
        across, step = cells / factor, dt * factor
        folder = out / "runs" / f"settling_{scheme}_{across:.4g}_{step:.4g}"
        done = finished(run_case("cases/settling_disk.edp", {
            "-mesh": str(mesh("box_corridor", f"corridor_{across:.4g}", out, "--size", f"{0.25 / across:.12g}", *PATH)),
                "-scheme": scheme, "-dt": step, "-tend": 0.4,
            "-every": 0.005, "-tolerance": 1e-4}, out=folder, limit=limit))
        value, why = quantities.evaluate(quantities.parse("mean_v:0.3:0.4", quantities.load()), RunFolder(folder))
        if why:
            raise BadInput(why)
        return unknowns(folder), done.cpu_s, done.memory_mb, abs(value / FALL - 1)
    runs = [run(factor) for factor in (NEARBY if scheme == OURS else NEARBY[:1])]
    return dict(zip(("unknowns", "cpu_s", "memory_mb", "error"), over_neighbours(runs)))


def pair(scheme, cells, dt, out, limit):
    """Two settling disks: how far the worse of the two is from its height at 0.15 s (cm) by a lattice Boltzmann computation, over
    the height of its fall."""
    folder = out / "runs" / f"pair_{scheme}_{cells}_{dt:g}"
    done = finished(run_case("cases/drafting_kissing_tumbling.edp", {
        "-mesh": str(mesh("drafting_kissing_tumbling", f"pair_{cells}", out, "--size", f"{0.25 / cells:.12g}")),
            "-scheme": scheme, "-dt": dt, "-tend": 0.15, "-every": 0.05}, out=folder, limit=limit))
    tracks = RunFolder(folder).tracks
    error = max(abs(tracks[k]["y"][-1] - height) / (start - height) for k, (height, start) in enumerate(zip(PAIR, (4.5, 5.0))))
    return {"unknowns": unknowns(folder), "cpu_s": done.cpu_s, "error": float(error), "memory_mb": done.memory_mb}


def settling_lbmpy(level, limit):
    """The same by lbmpy with steps of nearly the same size: its error changes with the phase of the sound in the box."""
    def run(factor):
        done = finished(run_command([sys.executable, "-m", "tools.peers.with_lbmpy", "settling", str(level), str(factor)], limit))
        found = reported(done)
        return found["unknowns"], done.cpu_s, found["cpu_s"], done.memory_mb, abs(found["mean_v"] / FALL - 1)
    return dict(zip(("unknowns", "cpu_s", "own_s", "memory_mb", "error"), over_neighbours([run(factor) for factor in NEARBY])))


def turning(scheme, cells, dt, out, limit):
    """Angular velocity of the free disk in a shear flow over half the shear rate, Stokes flow."""
    folder = out / "runs" / f"turning_{scheme}_{cells}_{dt:g}"
    done = finished(run_case("cases/couette_disk.edp", {
        "-mesh": str(mesh("couette_disk", f"couette_{cells}", out, "--size", f"{1 / cells:.12g}", "--length", "4")),
            "-scheme": scheme, "-reynolds": 0.0,
        "-radius": 0.25, "-y": 0.5, "-length": 4.0, "-dt": dt, "-tend": 0.4, "-tolerance": 1e-7}, out=folder, limit=limit))
    omega = RunFolder(folder).table("particles")["omega"][-1]
    return {"unknowns": unknowns(folder), "cpu_s": done.cpu_s, "error": abs(-2 * float(omega) / TURN - 1),
        "memory_mb": done.memory_mb}


def particle_jobs(out, settle, lattice, turn, limit, two=None):
    """settle, turn, two (two settling disks): {program: [(elements, dt)]}; lattice: levels of lbmpy or []."""
    jobs = []
    for name, function, cases in (("settling", settling, settle), ("turning", turning, turn), ("pair", pair, two or {})):
        jobs += [Job("particles", name, program, level, functools.partial(function, program, *case, out, limit))
                 for program, those in cases.items() for level, case in enumerate(those)]
    jobs += [Job("particles", "settling", "lbmpy", level, functools.partial(settling_lbmpy, level, limit)) for level in lattice]
    return sorted(jobs, key=lambda job: (job.problem, job.level))


def lattice_of_disks(number, path):
    """A file of `number` disks of 1 cm in the pipe, apart from each other and the obstacles."""
    x, y = [], []
    for left, right in ((0.015, 0.27), (0.35, 0.54), (0.76, 0.985)):
        columns = np.arange(left, right, 0.0163)
        rows = np.linspace(-0.088, 0.088, 12)
        for a in columns:
            x += [a] * len(rows)
            y += list(rows)
    if number > len(x):
        raise BadInput(f"the pipe takes {len(x)} disks, not {number}")
    take = np.linspace(0, len(x) - 1, number).round().astype(int)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("id,x,y,radius,density\n" + "".join(f"{k},{x[i]:.6f},{y[i]:.6f},0.005,2500\n" for k, i in enumerate(take)))
    return path


def pipe_step(scheme, number, out, steps, warm, limit, size=None, own=False):
    """Cost of a step of the pipe with `number` disks in it; None: no particles in the program either. own: in the case's own time
    steps
    (at most 0.32 s of them), not small ones at the start."""
    script = PIPE if number is not None else "cases/pipe_jet.edp"
    folder = tree(out / "trees" / f"pipe_{scheme}_{number}", script, steps, warm)
    options = {"-every": 1000, "-tend": 0.32} if own else {**PIPE_STEP, "-tend": PIPE_STEP["-dt"] * (steps + 2)}
    if size:
        options["-mesh"] = str(mesh("pipe_obstacles", f"pipe_{size:g}", out, "--size", f"{size:g}"))
    if number is None:
        options["-budget"] = 0
    else:
        options |= {"-number": 0, "-scheme": scheme}
        if number:
            options["-particles"] = str(lattice_of_disks(number, out / "meshes" / f"disks_{number}.csv"))
    cost, memory = step_time(folder, script, options, out / "runs" / f"pipe_{scheme}_{number}", limit)
    return {"unknowns": number or 0, "step_s": cost, "memory_mb": memory}


def suspension_jobs(out, steps, limit):
    """A step of 50 disks in the pipe. steps: {program: (steps, of which the first do not count)}."""
    return [Job("particles", "suspension", program, 0, functools.partial(pipe_step, program, 50, out, *those, limit)) for program,
        those in steps.items()]


@functools.lru_cache(4)
def contact_scene(number):
    """(packing, its constraints); made once, not timed."""
    scene = bench_contacts.packing(number, "random", 0)
    return scene, bench_contacts.constraints(scene, scene.reach(bench_contacts.DT))


def contact_run(solver, number, tolerance, limit):
    """CPU time of one solver, by tools.bench_contacts."""
    scene, rows = contact_scene(number)
    if solver in bench_contacts.PEERS:
        cpu, best, _, note = bench_contacts.run_peer(solver, scene, rows, tolerance, limit)
        if note:
            raise BadInput(note)
        return {"unknowns": number, "cpu_s": cpu, "error": best}
    found = bench_contacts.run_own(solver, scene, tolerance, limit)
    if found.get("note"):
        raise BadInput(found["note"])
    return {"unknowns": number, "cpu_s": found["cpu_s"], "error": found["residual"], "memory_mb": found["memory_mb"]}


def contact_jobs(numbers, tolerance, of, tolerances, peers, limit):
    """Time against the number of disks at one residual, and against the residual for `of` disks."""
    solvers = {"newton": OURS, "uzawa": PUBLISHED, "accelerated": "accelerated", **{name: name for name in peers}}
    jobs = [Job("contacts", f"{of} disks", name, level, functools.partial(contact_run, solver, of, tol, limit))
            for level, tol in enumerate(tolerances) for solver, name in solvers.items()]
    return jobs + [Job("contacts", "number", name, level, functools.partial(contact_run, solver, number, tolerance, limit))
                   for level, number in enumerate(numbers) for solver, name in solvers.items()
                   if solver != "uzawa" or number <= 5000]
