"""A mesh and time-step refinement study of a case.

    python -m tools.study cases/settling_disk.edp --meshsize 0.0625 0.0417 0.03125 \\
        --dt 0.002 0.001 --quantity mean_v --reference -5.5073
    python -m tools.study CASE --dt 0.01 0.005 --quantity final_y -- -scheme published -penalty 1e-6
    python -m tools.study cases/cavity.edp --meshsize 0.08 0.04 0.02 --quantity result:u_least
    python -m tools.study cases/diaphragm_loss.edp --cells 6 8 12 --quantity result:loss_coefficient

Runs the case at every pair of element size and time step, over the cores, or one by one
with --timing (the CPU time of a run beside another one is not a measurement). Finished
runs are not repeated unless the sources, the mesh or the options have changed. Everything
after -- is passed to the case.

Writes into --out (default results/study/CASE): study.csv (one row per run and quantity;
a run that failed is a row with its reason), study_QUANTITY.png (error over element size,
over time step and over CPU time) and the runs. Prints observed orders, the extrapolated
value with its uncertainty (grid convergence index) and the Pareto points. Without
--reference errors are taken against the extrapolated value, or where there is none against
the finest run (which then has no error of its own). Meshes are made with whole numbers of
cells: where all are uniform, orders and study.csv are of the true size of their cells, along the
shorter side of the domain. A note says where the sizes do not tell how fine the meshes are (a gmsh script for which --size is
only a bound: add --proportional to its --recipe). Runs whose steps -cfl made smaller than --dt do not count in the order of the
time step; -- -cfl 0 keeps the steps.

Status 0: all runs ended well; 1: some failed; 3: bad input.
"""
import argparse
import hashlib
import itertools
import math
import os
import re
import shlex
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tools.base import quantities, runner
from tools.base.command import ROOT, BadInput, Parser, case_options, number, out_folder, positive, whole
from tools.base.engine import Job, failure, run_all
from tools.base.mesh_files import read_mesh
from tools.base.run_folder import RunFolder
from tools.base.runner import cores, freefem, named_files, side_by_side
from tools.base.space_mesh import SpaceMesh, dimension_of, read_space_mesh
from tools.base.tables import write_table
from tools.compile_errors.run import for_runs, results_of
from tools.study.convergence import LARGEST_ORDER
from tools.study.report import error_of, extrapolated, name_of, report

COLUMNS = ["case", "meshsize", "dt", "options", "quantity", "value", "reference", "error", "relative_error",
           "cpu_s", "wall_s", "steps", "vertices", "memory_mib", "timing", "commit", "status", "reason", "run"]
SAME_LENGTH = 1e-6  # of a length: edges this close are of one length
CELLS = "-cells"  # the option of cases that take a number of cells rather than a size
SAME_PLACE = 1e-9  # of the domain: points this close are one


@dataclass
class Study:
    """What to run. meshsizes in the case's unit of length, dts in s; None in a list stands
    for the case's default. reference: one value per quantity, or None. by: the option of a case
    that makes its mesh itself ("-size", "-cells"), None for -mesh."""
    script: str
    meshsizes: list = field(default_factory=lambda: [None])
    dts: list = field(default_factory=lambda: [None])
    quantities: list = field(default_factory=list)
    references: list = None
    options: dict = field(default_factory=dict)
    out: Path = None
    jobs: int = 1
    timing: bool = False
    repeats: int = 1
    limit: float = None
    retry: bool = False
    recipe: str = None
    by: str = None
    own: list = field(default_factory=list)
    formal_order: float = 2.0

    @property
    def case(self):
        """The case's name."""
        return Path(self.script).stem


def require_recipe(recipe):
    """Raises BadInput where tools.mesh has no recipe of this name (its first word), or a quote in it does not close."""
    from tools.meshing import RECIPES
    try:
        name = (shlex.split(recipe) or [""])[0]
    except ValueError as problem:
        raise BadInput(f"--recipe {recipe}: {problem}") from None
    if name not in RECIPES:
        raise BadInput(f"tools.mesh has no recipe {name}, which --meshsize needs: name one with --recipe "
                       f"({', '.join(sorted(RECIPES))}), or leave --meshsize out and study --dt on the case's own mesh")


def mesh_name(recipe, size):
    """The file's name of the mesh of a recipe (its words) and an element size; a short hash tells apart words that differ in signs
    only."""
    plain = re.sub("[^A-Za-z0-9.]+", "_", " ".join(recipe))
    mark = "_" + hashlib.sha256(shlex.join(recipe).encode()).hexdigest()[:8] if len(recipe) > 1 else ""
    return f"{plain}{mark}_{size:.12g}.mesh"


def make_mesh(study, size):
    """The mesh file of an element size, made by tools.mesh unless it is there already.
    Raises BadInput with the reason."""
    recipe = shlex.split(study.recipe or study.case)
    path = Path(study.out) / "meshes" / mesh_name(recipe, size)
    given = [ROOT / word for word in recipe[1:] if (ROOT / word).is_file()]
    makers = [*ROOT.glob("tools/meshing/*.py"), *given]
    for script in given:
        makers += named_files(script) if script.suffix == ".geo" else ()  # what it merges
    if path.is_file() and all(path.stat().st_mtime > maker.stat().st_mtime for maker in makers):
        return path
    return runner.make_mesh([*recipe, "--size", f"{size:.12g}"], path)


def uniform_size(mesh):
    """The true element size of a uniform Mesh (at most three lengths of edges): that of its edges along the shorter
    side of the domain, where a whole number of cells errs most; None of another, and of a SpaceMesh."""
    if isinstance(mesh, SpaceMesh):
        return None
    edges = np.abs(np.concatenate([mesh.points[mesh.triangles[:, k]] - mesh.points[mesh.triangles[:, k - 1]] for k in range(3)]))
    lengths = np.sort(np.hypot(*edges.T))
    if np.count_nonzero(np.diff(lengths) > SAME_LENGTH * lengths[0]) > 2:
        return None
    shorter = np.argmin(np.ptp(mesh.points, axis=0))
    along = edges[edges[:, 1 - shorter] <= SAME_LENGTH * lengths[0], shorter]
    return float(np.min(along if len(along) else lengths))


def same_mesh(one, other):
    """Whether two Meshes are one, to rounding."""
    cells, others = (mesh.tetrahedra if isinstance(mesh, SpaceMesh) else mesh.triangles for mesh in (one, other))
    return np.array_equal(cells, others) and \
        np.allclose(one.points, other.points, rtol=0, atol=SAME_PLACE * np.ptp(one.points, axis=0).max())


def true_sizes(meshes):
    """{size asked for: that of the mesh} of {size: mesh file}, the same where a mesh is not uniform. Raises BadInput
    where two meshes are one, or have cells of one size."""
    found = {}
    for size, path in meshes.items():
        if isinstance(path, Path):
            found[size] = read_space_mesh(path) if dimension_of(path) == 3 else read_mesh(path)
    true = {size: uniform_size(mesh) for size, mesh in found.items()}
    uniform = all(true.values())
    for a, b in itertools.combinations(found, 2):
        if uniform and math.isclose(true[a], true[b], rel_tol=SAME_LENGTH):
            raise BadInput(f"the sizes {a:.12g} and {b:.12g} both make cells of {true[a]:.6g}, for a whole number of them must "
                f"fit: leave one out")
        if same_mesh(found[a], found[b]):
            raise BadInput(f"the sizes {a:.12g} and {b:.12g} make the same mesh: leave one out")
    return {size: true[size] if uniform and size in true and not math.isclose(true[size], size, rel_tol=SAME_LENGTH) else size
        for size in meshes}


def own_mesh(name, size):
    """{option: value} by which a case makes its mesh itself: a size, or as many cells as go into 1."""
    return {name: round(1 / size) if name == CELLS else float(size)}


def job_of(study, size, dt, mesh):
    """The Job of one pair of size and step. mesh: the file, None for the case's own."""
    options = dict(study.options)
    if mesh is not None:
        options["-mesh"] = str(mesh)
    if study.by and size is not None:
        options |= own_mesh(study.by, size)
    if dt is not None:
        options["-dt"] = float(dt)
    return Job(study.script, options, Path(study.out) / "runs" / name_of(size, dt), study.limit, study.repeats, study.timing,
        study.retry)


def steps_of(run):
    """(number, time) of the last step, nan if no table tells."""
    for name in ("fluid", "steps", "particles"):
        if run.has(name):
            table = run.table(name)
            if "step" in table and "t" in table and len(table["step"]):
                return float(table["step"].max()), float(table["t"].max())
    return math.nan, math.nan


def made_smaller(steps, time_at_end, dt):
    """The mean step of a run that took more than steps of dt (s) would have been, else 0."""
    return time_at_end / steps if dt and steps > 1.02 * math.ceil(time_at_end / dt * (1 - 1e-9)) + 1 else 0.0


def measure(study, record, functions):
    """Steps, vertices and quantities of a run that ended, added to its record."""
    record["steps"], record["vertices"], record["mean_dt"], record["values"] = math.nan, math.nan, 0.0, {}
    if record["status"] != 0:
        record["values"] = {name: (math.nan, record["reason"]) for name in functions}
        return record
    try:
        run = RunFolder(record["run"])
        record["steps"], until = steps_of(run)
        record["mean_dt"] = made_smaller(record["steps"], until, record["dt"])
        record["vertices"] = len(run.mesh.points) if run.mesh is not None else math.nan
        record["dimension"] = 3 if run.in_space else 2
    except BadInput as problem:
        record["values"] = {name: (math.nan, str(problem)) for name in functions}
        return record
    record["values"] = {name: quantities.evaluate(one, run) for name, one in functions.items()}
    return record


def run_study(study, mesh_maker=make_mesh, say=print):
    """Run all and write study.csv; returns (records, {quantity: reference}).

    mesh_maker(study, size) -> path; say: where progress lines go."""
    known = quantities.load(study.own)
    functions = {text: quantities.parse(text, known) for text in study.quantities}
    if not (ROOT / study.script).is_file():
        raise BadInput(f"there is no script {study.script}")
    if mesh_maker is make_mesh and not study.by and study.meshsizes != [None]:
        require_recipe(study.recipe or study.case)
    freefem()
    study.out = Path(study.out or results_of(study.script) / "study" / study.case).resolve()
    study.out.mkdir(parents=True, exist_ok=True)
    pairs = sorted(itertools.product(study.meshsizes, study.dts), key=lambda pair: -(pair[0] or 1) ** 2 * (pair[1] or 1))
    workers = 1 if study.timing else max(1, study.jobs)
    for old in study.out.glob("study_*.png"):
        old.unlink()  # of a study whose table is replaced
    begin, records, done, weights = time.perf_counter(), [], [], {p: (p[0] or 1) ** -2 / (p[1] or 1) for p in pairs}

    def mesh_of(size):
        try:
            return None if size is None or study.by else Path(mesh_maker(study, size)).resolve()
        except BadInput as problem:
            return problem
    with side_by_side(workers) as pool:
        meshes = dict(zip(study.meshsizes, pool.map(mesh_of, study.meshsizes)))
    true = true_sizes(meshes)
    if list(true.values()) != list(true):
        say("a whole number of cells must fit: " + ", ".join(f"{size:.6g} for {asked:.6g}" for asked, size in true.items())
            + "; orders are of these sizes")

    def ended(pair, record):
        size, dt = pair
        records.append(measure(study, {**record, "asked": size, "meshsize": true[size], "dt": dt}, functions))
        done.append(weights[pair])
        write_study(study, records, references_of(study, records))
        left = (time.perf_counter() - begin) * (sum(weights.values()) / sum(done) - 1)
        say(progress(records[-1], len(records), len(pairs), left))
    jobs = {}
    for pair in pairs:
        mesh = meshes[pair[0]]
        if isinstance(mesh, BadInput):
            ended(pair, failure(study.out / "runs" / name_of(*pair), str(mesh), timing=study.timing))
        else:
            job = job_of(study, *pair, mesh)
            jobs[job.folder] = pair, job
    run_all([job for _, job in jobs.values()], workers, lambda job, record: ended(jobs[job.folder][0], record))
    records.sort(key=lambda r: (-(r["meshsize"] or 0), -(r["dt"] or 0)))
    references = references_of(study, records)
    write_study(study, records, references)
    return records, references


def progress(record, number, total, left):
    """One line on a run that ended."""
    what = name_of(record["asked"], record["dt"]).replace("_", " ")
    cost = f"{record['cpu_s']:.2f} s CPU" if math.isfinite(record["cpu_s"]) else "no CPU time"
    result = ", ".join(f"{name} {value:.6g}" if not why else f"{name}: {why}" for name, (value, why) in record["values"].items())
    if record["status"] != 0:
        result = f"failed: {record['reason']}"
    again = "" if record["fresh"] else " (done before)"
    rest = f", about {left:.0f} s left" if number < total else ""
    return f"[{number}/{total}] {what}{again}: {cost}, {result}{rest}"


def references_of(study, records):
    """{quantity: value that errors are taken against}."""
    if study.references:
        return dict(zip(study.quantities, study.references))
    return {name: extrapolated(study, records, name)[0] for name in study.quantities}


def write_study(study, records, references):
    """study.csv, whole at any time."""
    rows = []
    for record in records:
        for name, (value, why) in record["values"].items():
            reference = references[name]
            error = error_of(study, records, name, record, reference)
            size = abs(reference)
            rows.append([study.case, record["meshsize"], record["dt"],
                         " ".join(f"{k} {v}" for k, v in study.options.items()), name, value, reference, error,
                         error / size if size > 0 else math.nan, record["cpu_s"], record["wall_s"], record["steps"],
                             record.get("vertices", math.nan),
                         record["memory_mib"], int(bool(record["timing"])), record["commit"], record["status"], why,
                         os.path.relpath(record["run"], study.out)])
    write_table(study.out / "study.csv", COLUMNS, rows)


def order(text):
    """An argument type: an order of convergence."""
    value = positive(text)
    if value > LARGEST_ORDER:
        raise argparse.ArgumentTypeError(f"an order of {text} is none of a scheme: at most {LARGEST_ORDER:g}")
    return value


def parser():
    """The options."""
    options = Parser(prog="python -m tools.study", epilog="quantities (mean_v:0.2:0.5 gives numbers to the first arguments; -1 "
        "of a particle: that of the least id; nan of a time: as without; expressions on tables, such as particles.csv:y:last, are "
        "those of tools.sweep):\n"
                     + quantities.summary(quantities.load()), description=__doc__)
    options.add_argument("script", help="the case, such as cases/settling_disk.edp")
    options.add_argument("--meshsize", nargs="+", type=positive, metavar="H", help="element sizes (default: the case's mesh)")
    options.add_argument("--by", choices=["mesh", "size"], default="mesh", help="how the case takes them: a mesh of tools.mesh "
        "(default), or its own option -size (turbulent_step)")
    options.add_argument("--cells", nargs="+", type=whole(1), metavar="N", help="instead of sizes: numbers for the case's own "
        "option -cells (diaphragm_loss, turbulent_channel); sizes are then 1/N")
    options.add_argument("--dt", nargs="+", type=positive, metavar="DT", help="time steps, s (default: the case's)")
    options.add_argument("--quantity", nargs="+", required=True, metavar="NAME", help="what to measure, see below")
    options.add_argument("--reference", nargs="+", type=number, metavar="VALUE", help="exact values, one per quantity")
    options.add_argument("--quantities", nargs="+", default=[], metavar="FILE", help="Python files with quantities of your own")
    options.add_argument("--order", type=order, default=2.0, help="formal order of the scheme (default 2)")
    options.add_argument("--out", type=out_folder, metavar="DIR", help="where all goes (default results/study/CASE)")
    options.add_argument("--jobs", type=whole(1), default=cores(), metavar="N", help=f"runs at a time (default {cores()}: the "
        f"cores)")
    options.add_argument("--timing", action="store_true", help="one run at a time, so that CPU times are measurements")
    options.add_argument("--repeat", type=whole(1), default=1, metavar="N", help="runs of each, the median time counts (default 1)")
    options.add_argument("--limit", type=positive, metavar="S", help="stop a run after so many seconds: a row with that reason")
    options.add_argument("--retry", action="store_true", help="run again what failed before")
    options.add_argument("--recipe", metavar="WORDS", help="recipe of tools.mesh, with options of its own in the same quotes "
        "(default: the case's name)")
    return options


def main(words=None, mesh_maker=make_mesh):
    """0 if all runs ended well, 1 if some failed."""
    words = list(sys.argv[1:] if words is None else words)
    cut = words.index("--") if "--" in words else len(words)
    given = parser().parse_args(words[:cut])
    if given.reference and len(given.reference) != len(given.quantity):
        raise BadInput(f"{len(given.reference)} references for {len(given.quantity)} quantities: give one each")
    for name, values in (("--meshsize", given.meshsize), ("--cells", given.cells), ("--dt", given.dt),
        ("--quantity", given.quantity)):
        if values and len({name_of(value, None) if name != "--quantity" else value for value in values}) < len(values):
            raise BadInput(f"{name} names one value twice")
    if given.cells and (given.meshsize or given.by != "mesh"):
        raise BadInput("--cells takes the place of --meshsize and --by: leave one out")
    if given.by != "mesh" and not given.meshsize:
        raise BadInput(f"--by {given.by} needs --meshsize")
    if given.cells:  # -cells n makes elements of the size 1/n
        sizes, by = [1 / n for n in given.cells], CELLS
    else:  # the option of the case that sets the element size; None: a mesh is made for each size
        sizes, by = given.meshsize, None if given.by == "mesh" else f"-{given.by}"
    script = os.path.relpath(Path(given.script).resolve(), ROOT) if Path(given.script).is_file() else given.script
    study = Study(script, sizes or [None], given.dt or [None], given.quantity, given.reference,
                  case_options(for_runs(script, words[cut + 1:]), ["-dt", "-out", *([by or "-mesh"] if sizes else [])]), given.out,
                      given.jobs, given.timing, given.repeat,
                  given.limit, given.retry, given.recipe, by, given.quantities, given.order)
    records, references = run_study(study, mesh_maker, say=lambda line: print(line, flush=True))
    for line in report(study, records, references):
        print(line)
    from tools.study.figure import draw_study
    for name in study.quantities:
        path = draw_study(study, records, name, references[name], extrapolated(study, records, name)[1])
        print(f"figure: {path}" if path else f"figure of {name}: left out, no finite error")
    print(f"table: {study.out / 'study.csv'}")
    failed = sum(r["status"] != 0 or any(why for _, why in r["values"].values()) for r in records)
    if failed:
        missing = {name: sum(bool(r["values"][name][1]) for r in records) for name in study.quantities}
        print("error: no value of " + ", ".join(f"{name} in {n} of {len(records)} runs" for name, n in missing.items() if n)
              + "; the reasons stand above and in the table", file=sys.stderr)
    return 1 if failed else 0
