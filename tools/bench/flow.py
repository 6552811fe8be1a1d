"""Error against CPU time of flow benchmarks: this suite, the scheme as published, NGSolve and scikit-fem.

Problems: 2d1 and 2d2 (cylinder in a channel; error of the drag, and the largest error of drag,
lift range and Strouhal number), cavity (Reynolds number 1000; largest error of the extrema on the
centrelines). A small error on one mesh may be luck: of 2d1 each program but the published one, and of
2d2 this suite (the other programs take too long), runs five meshes, elements 0.92 to 1.08 times as
large; the error is the root of the mean square, unknowns and time the mean. cpu_s is that of the
whole process, user and system; own_s leaves out the imports of the Python packages (for FreeFEM: the
same). A program that is not there or fails raises BadInput.
"""
import math
import sys

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, make_mesh, reported, run_case, run_command
from tools.study.extrema import vortices

PEERS = {"NGSolve": ("with_ngsolve", "ngsolve==6.2.2608"), "scikit-fem": ("with_skfem", "scikit-fem==12.0.2")}
OURS, PUBLISHED, TENSORIAL, MULTIPLIERS = "standard", "published", "tensorial", "multipliers"
REFERENCE = {
    "2d1": {"drag": 5.57953523384},
    "2d2": {"drag_most": 3.227393, "lift_range": 2.007871, "strouhal": 0.301841},
    "cavity": {"u_least": -0.3885698, "v_most": 0.3769447, "v_least": -0.5270771},
}
# Of this suite: words for tools.mesh, options of the case.
LEVELS = {
    "2d1": [(["cylinder_steady", "--size", f"{3.0 / n:.5f}", "--circle-points", str(n), "--growth", f"{4.8 / n:.5f}",
        "--wake-factor", "3", "--wake-growth", "0.3"], {})
            for n in (28, 40, 64)],
    "2d2": [(["cylinder_channel", "--size", "0.15", "--circle-points", "30", "--wake-factor", "2.3", "--wake-growth", "0.08"],
        {"-dt": 0.0055, "-cfl": 3}),
            (["cylinder_channel", "--size", "0.12", "--circle-points", "32"], {}),  # the default mesh
            (["cylinder_channel", "--size", "0.08", "--circle-points", "48", "--growth", "0.07", "--wake-factor", "1.3",
                "--wake-growth", "0.03"],
             {"-dt": 0.0015, "-tolerance": 1e-5}),
            (["cylinder_channel", "--circle-points", "24"], {})],  # for the scheme as published
    "cavity": [(["cavity", "--size", "0.0417"], {}), (["cavity", "--size", "0.0278"], {}), (["cavity", "--size", "0.0179"], {})],
}
NEARBY = (1.0, 0.92, 0.96, 1.04, 1.08)  # elements of the meshes that are averaged over, against the level's
SIZES = {("2d1", OURS): NEARBY, ("2d1", "NGSolve"): NEARBY, ("2d1", "scikit-fem"): NEARBY, ("2d2", OURS): NEARBY}
CASES = {"2d1": "cylinder_steady", "2d2": "cylinder_channel", "cavity": "cavity"}
# The scheme as published on the same meshes: level of the mesh, options. Steady flows are marched until they are.
MARCHED = {
    "2d1": [(0, {"-speed": 0.3, "-dt": 0.05, "-tend": 3, "-sample": 1}), (1, {"-speed": 0.3, "-dt": 0.025, "-tend": 3,
        "-sample": 1}),
            (2, {"-speed": 0.3, "-dt": 0.025, "-tend": 3, "-sample": 1})],
    "2d2": [(3, {"-dt": 0.02, "-tend": 6, "-sample": 0.02}), (3, {"-dt": 0.01, "-tend": 6}), (1, {"-dt": 0.01, "-tend": 6})],
    "cavity": [(0, {"-dt": 0.1, "-tend": 40}), (0, {"-dt": 0.05, "-tend": 40}), (1, {"-dt": 0.1, "-tend": 40})],
}


def error(problem, found):
    """Largest relative error of the numbers that are judged. Raises BadInput where one is missing or no number."""
    for name in REFERENCE[problem]:
        if not math.isfinite(found.get(name, math.nan)):
            raise BadInput(f"{problem}: no value of {name}")
    return max(abs(found[name] / target - 1) for name, target in REFERENCE[problem].items())


def mesh_of(problem, level, out, size=1.0):
    """The mesh file of a level, its elements `size` times as large, made once."""
    mesh = out / "meshes" / f"{problem}_{level}_{size:g}.mesh"
    if not mesh.is_file():
        words = list(LEVELS[problem][level][0])
        if size != 1:
            size_at, points_at = words.index("--size") + 1, words.index("--circle-points") + 1
            points = round(int(words[points_at]) / size)
            words[size_at] = f"{float(words[size_at]) * int(words[points_at]) / points:.5f}"
            words[points_at] = str(points)
        make_mesh(words, mesh)
    return mesh


def size_of(run, holes=1):
    """Unknowns of P2/P1 on the run's mesh (edges: vertices + triangles - 1 + holes, Euler)."""
    vertices, triangles = run.mesh.points.shape[0], run.mesh.triangles.shape[0]
    return 2 * (2 * vertices + triangles - 1 + holes) + vertices


def ours(problem, level, out, limit, size):
    """(unknowns, numbers, cpu_s, own_s) of a run of this suite."""
    folder = out / "runs" / f"{problem}_{level}_{size:g}"
    done = finished(run_case(f"cases/{CASES[problem]}.edp", {"-mesh": str(mesh_of(problem, level, out, size)),
        **LEVELS[problem][level][1]}, out=folder, limit=limit))
    run = RunFolder(folder)
    if problem == "2d2":
        return size_of(run), vortices_of(run), done.cpu_s, done.cpu_s
    found = {**run.results, "drag": run.results.get("drag_coefficient", float("nan"))}
    return found["unknowns"], found, done.cpu_s, done.cpu_s


def published(problem, level, out, limit):
    """The same of the scheme as published."""
    on, options = MARCHED[problem][level]
    folder = out / "runs" / f"published_{problem}_{level}"
    done = finished(run_case(f"tools/bench/published_{'cavity' if problem == 'cavity' else 'channel'}.edp",
        {"-mesh": str(mesh_of(problem, on, out)), **options}, out=folder, limit=limit))
    run = RunFolder(folder)
    if problem == "cavity":
        return size_of(run, holes=0), run.results, done.cpu_s, done.cpu_s
    found = {"drag": 500 * run.table("forces")["force_x"][-1]} if problem == "2d1" else vortices_of(run)
    return size_of(run), found, done.cpu_s, done.cpu_s


def vortices_of(run):
    """The numbers of 2d2 of a run."""
    force = run.table("forces")
    return vortices(force["t"], 20 * force["force_x"], 20 * force["force_y"], 4.5)


def peer(program, problem, level, limit, size):
    """The same of another package."""
    done = run_command([sys.executable, "-m", f"tools.peers.{PEERS[program][0]}", problem, str(level),
        *([str(size)] if size != 1 else [])], limit)
    found = reported(done)
    return found["unknowns"], found, done.cpu_s, found["cpu_s"]


def over_neighbours(runs):
    """[(number, ..., error)] of runs on meshes, or with steps, of nearly the same size: the means, and of the errors
    the root of the mean square, because one run may be right by chance."""
    *numbers, errors = zip(*runs)
    return [*(sum(values) / len(values) for values in numbers), math.sqrt(sum(e * e for e in errors) / len(errors))]


def judged(program, problem, level, out, limit):
    """{unknowns, cpu_s, own_s, error} of a program over the meshes of SIZES."""
    runs = []
    for size in SIZES.get((problem, program), (1.0,)):
        unknowns, found, cpu, own = (ours(problem, level, out, limit, size) if program == OURS else published(problem, level, out,
            limit) if program == PUBLISHED
                                     else peer(program, problem, level, limit, size))
        runs.append((float(unknowns), cpu, own, error(problem, found)))
    return dict(zip(("unknowns", "cpu_s", "own_s", "error"), over_neighbours(runs)))
