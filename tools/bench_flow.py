"""Error against CPU time of flow benchmarks: this suite, NGSolve and scikit-fem side by side.

    python -m tools.bench_flow --out results/bench_flow
    python -m tools.bench_flow --problems 2d1 cavity --levels 2 --install

Problems: 2d1 and 2d2 (cylinder in a channel; error of the drag, and the largest error of drag,
lift range and Strouhal number), cavity (Reynolds number 1000; largest error of the extrema on the
centrelines); all also by Lefebvre's scheme as published. A small error on one mesh may be luck: of
2d1 each program but the published one runs five meshes, elements 0.92 to 1.08 times as large; the
error is the root of the mean square, unknowns and time the mean. Each program runs each of three resolutions, one program after the other,
level by level, on one core and one thread. CPU time is that of the whole process, user and
system; cpu_own_s leaves out the imports of the Python packages (for FreeFEM: the same as cpu_s).
The figure shows cpu_own_s. NGSolve and scikit-fem are not needed elsewhere: --install puts them
into the environment in use. A program that is not there or fails is a row with its reason.

Writes bench_flow.csv and bench_flow.png. Status 0: all ran; 1: something did not.
"""
import math
import os
import subprocess
import sys
from pathlib import Path

from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from tools.command import ROOT, BadInput, Parser, guarded, positive
from tools.plotting import MARKERS, PAGE_WIDTH, curve, plt, save
from tools.runner import commit, freefem, machine, make_mesh, own_folder, reported, run_case, run_command
from tools.run_folder import RunFolder
from tools.tables import write_table

PEERS = {"NGSolve": ("with_ngsolve", "ngsolve==6.2.2608"), "scikit-fem": ("with_skfem", "scikit-fem==12.0.2")}
OURS, PUBLISHED = "this suite", "as published"
PROBLEMS = {"2d1": (OURS, PUBLISHED, "NGSolve", "scikit-fem"), "2d2": (OURS, PUBLISHED, "NGSolve"), "cavity": (OURS, PUBLISHED, "NGSolve", "scikit-fem")}
TITLES = {"2d1": "DFG 2D-1, drag", "2d2": "DFG 2D-2, worst of three", "cavity": "cavity, Re 1000, extrema"}
REFERENCE = {
    "2d1": {"drag": 5.57953523384},
    "2d2": {"drag_most": 3.227393, "lift_range": 2.007871, "strouhal": 0.301841},
    "cavity": {"u_least": -0.3885698, "v_most": 0.3769447, "v_least": -0.5270771},
}
# Of this suite: words for tools.mesh, options of the case.
LEVELS = {
    "2d1": [(["cylinder_steady", "--size", f"{3.0 / n:.5f}", "--circle-points", str(n), "--growth", f"{4.8 / n:.5f}", "--wake-factor", "3", "--wake-growth", "0.3"], {})
            for n in (28, 40, 64)],
    "2d2": [(["cylinder_channel"], {"-dt": 0.0042}),
            (["cylinder_channel"], {}),
            (["cylinder_channel", "--size", "0.08", "--circle-points", "48", "--growth", "0.07", "--wake-factor", "1.3", "--wake-growth", "0.03"],
             {"-dt": 0.0015, "-tolerance": 1e-5}),
            (["cylinder_channel", "--circle-points", "24"], {})],  # for the scheme as published
    "cavity": [(["cavity", "--size", "0.0417"], {}), (["cavity", "--size", "0.0278"], {}), (["cavity", "--size", "0.0179"], {})],
}
SIZES = {"2d1": (1.0, 0.92, 0.96, 1.04, 1.08)}  # elements of the meshes that are averaged over, against the level's
CASES = {"2d1": "cylinder_steady", "2d2": "cylinder_channel", "cavity": "cavity"}
# The scheme as published on the same meshes: level of the mesh, options. Steady flows are marched until they are.
MARCHED = {
    "2d1": [(0, {"-speed": 0.3, "-dt": 0.05, "-tend": 3, "-sample": 1}), (1, {"-speed": 0.3, "-dt": 0.025, "-tend": 3, "-sample": 1}),
            (2, {"-speed": 0.3, "-dt": 0.025, "-tend": 3, "-sample": 1})],
    "2d2": [(3, {"-dt": 0.02, "-tend": 6, "-sample": 0.02}), (3, {"-dt": 0.01, "-tend": 6}), (1, {"-dt": 0.01, "-tend": 6})],
    "cavity": [(0, {"-dt": 0.1, "-tend": 40}), (0, {"-dt": 0.05, "-tend": 40}), (1, {"-dt": 0.1, "-tend": 40})],
}


def error(problem, found):
    """Largest relative error of the numbers that are judged."""
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
    """(unknowns, numbers, cpu_s, cpu_own_s, reason) of a run of this suite."""
    from tools.peers.common import vortices
    folder = out / "runs" / f"{problem}_{level}_{size:g}"
    done = run_case(f"cases/{CASES[problem]}.edp", {"-mesh": str(mesh_of(problem, level, out, size)), **LEVELS[problem][level][1]}, out=folder, limit=limit)
    if not done.ok:
        return 0, {}, done.cpu_s, done.cpu_s, done.reason
    if problem == "2d2":
        run = RunFolder(folder)
        force = run.table("forces")
        found = vortices(force["t"], 20 * force["force_x"], 20 * force["force_y"], 4.5)
        unknowns = size_of(run)
    else:
        found = RunFolder(folder).results
        found["drag"] = found.get("drag_coefficient", float("nan"))
        unknowns = found["unknowns"]
    return unknowns, found, done.cpu_s, done.cpu_s, ""


def published(problem, level, out, limit):
    """The same of the scheme as published."""
    from tools.peers.common import vortices
    on, options = MARCHED[problem][level]
    folder = out / "runs" / f"published_{problem}_{level}"
    done = run_case(f"tools/bench/published_{'cavity' if problem == 'cavity' else 'channel'}.edp", {"-mesh": str(mesh_of(problem, on, out)), **options}, out=folder, limit=limit)
    if not done.ok:
        return 0, {}, done.cpu_s, done.cpu_s, done.reason
    run = RunFolder(folder)
    if problem == "cavity":
        return size_of(run, holes=0), run.results, done.cpu_s, done.cpu_s, ""
    force = run.table("forces")
    if problem == "2d1":
        found = {"drag": 500 * force["force_x"][-1]}
    else:
        found = vortices(force["t"], 20 * force["force_x"], 20 * force["force_y"], 4.5)
    return size_of(run), found, done.cpu_s, done.cpu_s, ""


def run_program(program, problem, level, out, limit, size=1.0):
    """(unknowns, numbers, cpu_s, cpu_own_s, reason) of any of the programs."""
    if program == OURS:
        return ours(problem, level, out, limit, size)
    return published(problem, level, out, limit) if program == PUBLISHED else peer(program, problem, level, limit, size)


def peer(program, problem, level, limit, size):
    """The same of another package."""
    done = run_command([sys.executable, "-m", f"tools.peers.{PEERS[program][0]}", problem, str(level), *([str(size)] if size != 1 else [])], limit)
    try:
        found = reported(done)
    except BadInput as problem:
        return 0, {}, done.cpu_s, done.cpu_s, str(problem)
    return found["unknowns"], found, done.cpu_s, found["cpu_s"], ""


def over_neighbours(runs):
    """[(number, ..., error)] of runs on meshes, or with steps, of nearly the same size: the means, and of the errors
    the root of the mean square, because one run may be right by chance."""
    *numbers, errors = zip(*runs)
    return [*(sum(values) / len(values) for values in numbers), math.sqrt(sum(e * e for e in errors) / len(errors))]


def judged(program, problem, level, out, limit):
    """(unknowns, numbers, cpu_s, cpu_own_s, error, reason) over the meshes of SIZES; the numbers are the first one's."""
    runs = []
    for size in SIZES.get(problem, (1.0,)) if program != PUBLISHED else (1.0,):
        *numbers, reason = run_program(program, problem, level, out, limit, size)
        if reason:
            return (*numbers, float("nan"), reason)
        runs.append((*numbers, error(problem, numbers[1])))
    unknowns, cpu, own, off = over_neighbours([(size, *rest) for size, _, *rest in runs])
    return unknowns, runs[0][1], cpu, own, off, ""


def draw(rows, problems, path):
    """Error against CPU time, one panel a problem."""
    figure, panels = plt.subplots(1, len(problems), figsize=(PAGE_WIDTH, 2.9), layout="constrained", squeeze=False)
    for axes, problem in zip(panels[0], problems):
        for k, program in enumerate((OURS, PUBLISHED, *PEERS)):
            mine = [row for row in rows if row[0] == problem and row[1] == program and not row[-1]]
            if mine:
                axes.loglog([row[5] for row in mine], [row[6] for row in mine], marker=MARKERS[k], markersize=4, **curve(k), label=program)
        axes.set_title(TITLES[problem])
        axes.set_xlabel("CPU time (s)")
        axes.grid(True)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_visible(axes.has_data())
        for axis in (axes.xaxis, axes.yaxis) if axes.has_data() else ():
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    panels[0][0].set_ylabel("relative error")
    named = {label: handle for axes in panels[0] for handle, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(named.values(), named, loc="outside upper center", ncols=4)
    return save(figure, path)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.bench_flow", description=__doc__)
    options.add_argument("--out", default=str(ROOT / "results" / "bench_flow"), metavar="DIR", help="where tables and figure go")
    options.add_argument("--problems", nargs="+", choices=list(PROBLEMS), default=list(PROBLEMS), help="default: all")
    options.add_argument("--levels", type=int, choices=(1, 2, 3), default=3, help="resolutions (default 3)")
    options.add_argument("--limit", type=positive, default=3600.0, metavar="S", help="most seconds of one run")
    options.add_argument("--install", action="store_true", help="install the other packages with pip first")
    return options


def main(words=None):
    """0 if everything ran."""
    given = parser().parse_args(words)
    freefem()
    if given.install:
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", *(name for _, name in PEERS.values())])
        if done.returncode:
            raise BadInput("pip could not install " + " and ".join(name for _, name in PEERS.values()))
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # inherited by all runs
    out = Path(given.out).resolve()
    own_folder(out, "bench_flow", ("runs", "meshes"))
    rows = []
    for problem in given.problems:
        for level in range(given.levels):
            for program in PROBLEMS[problem]:
                unknowns, found, cpu, own, off, reason = judged(program, problem, level, out, given.limit)
                rows.append([problem, program, level, int(unknowns), cpu, own, off, *[found.get(n, float("nan")) for n in list(REFERENCE[problem])[:3]],
                             *[float("nan")] * (3 - len(REFERENCE[problem])), reason])
                print(f"{problem} level {level}, {program}: " + (reason or f"{int(unknowns)} unknowns, {own:.2f} s, error {off:.2e}"), flush=True)
                head = ["problem", "program", "level", "unknowns", "cpu_s", "cpu_own_s", "error", "first", "second", "third", "reason"]
                load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
                write_table(out / "bench_flow.csv", head, rows, [f"{machine()}; commit {commit()}; load average {load:.1f}"])
                figure = draw(rows, given.problems, out / "bench_flow.png")
    print(f"figure: {figure}")
    return 0 if not any(row[-1] for row in rows) else 1


if __name__ == "__main__":
    guarded(main)
