"""Run a case for all combinations of values, and tabulate and draw what came out.

    python -m tools.sweep cases/settling_disk.edp --vary rhos=1.1,1.25,1.5 mu=0.1,0.2 \\
        --quantity particles.csv:y:last mean_v:0.2:0.3 --jobs 2 -- -tend 0.3
    python -m tools.sweep cases/pipe_transport.edp --vary reynolds=1e4,1e5 seed=1:20 --quantity exits.csv:outlet=1:rows

--vary PARAMETER=VALUES: values of an option of the case, without its dash: a list 100,200,400 of numbers or words, ranges
FIRST:LAST or FIRST:LAST:STEP (both ends included), or both, 1:3,10. Everything after -- is passed to each run.

--quantity: a number of each run, by an expression on one of its tables, or by the name of a quantity (see below):
  TABLE.csv:COLUMN:HOW         HOW is first, last, min, max, mean (of the rows), timemean (in time), sum, std or range
  TABLE.csv:COLUMN:CONDITION:HOW   of the rows that meet the condition: id=3, t>0.5, t=last, x<=0.1; more of them are possible
  TABLE.csv:rows, TABLE.csv:CONDITION:rows   how many rows
  results.csv:NAME             a number of a steady flow
The beginning of a column's name will do where no other column has it: fluid.csv:kinetic:max.

Runs go side by side (--jobs), each with one thread. Finished runs are not run again unless the sources, the case or the options
have changed, so that a sweep can be stopped at any time, repeated with more values, or asked for other quantities. A run that was
killed is continued from its last checkpoint where it has one (-- -checkpoint 100), else run again; one that failed is run again
with --retry.

Writes into --out (default results/sweep/CASE): sweep.csv, one row per run (parameters, status, quantities, times, and for a failed
run its reason in one line); means.csv, mean, standard error and number of values of each quantity over the seeds (--over names
other parameters); sweep.png, each quantity over the first parameter that varies; runs/, the run folders.

--batch slurm FILE writes the script of an array job instead of running; the same command without it then makes the tables.
--collect makes the tables of what is there, and runs nothing.

Status 0: all runs ended well and all quantities have values; 1: some failed; 3: bad input.
"""
import argparse
import math
import os
import sys
from pathlib import Path

from tools.base import quantities
from tools.base.command import ROOT, BadInput, Parser, case_options, out_folder, positive, whole
from tools.base.engine import Job, failure, kept, read_note, run_all, run_job
from tools.base.run_folder import RunFolder
from tools.base.runner import cores
from tools.compile_errors.run import for_runs, results_of
from tools.many import batch
from tools.many.plan import Sweep, folder_name, read_vary, words_of
from tools.many.table import means, state, write_means, write_sweep

SEEDS = ("seed", "turbulence-seed")


def jobs_of(sweep):
    """The Job of each point of a sweep."""
    return [Job(sweep.script, {**sweep.options, **{f"-{name}": value for name, value in point.items()}},
        sweep.out / "runs" / folder_name(point), sweep.limit, retry=sweep.retry, go_on=True) for point in sweep.points]


def measured(record, functions):
    """A record with values {quantity: (number, "") or (nan, reason)}."""
    if record["status"] != 0 or record["reason"]:
        return {**record, "values": {name: (math.nan, "") for name in functions}}
    try:
        run = RunFolder(record["run"])
    except BadInput as problem:
        return {**record, "values": {name: (math.nan, str(problem)) for name in functions}}
    return {**record, "values": {name: quantities.evaluate(one, run) for name, one in functions.items()}}


def collected(jobs):
    """The records of what is there; a row for what is not."""
    return [kept(job) or {**failure(job.folder, "not run yet", -1), **({} if not read_note(job) else
        {"reason": "made of other sources, or cut off"})} for job in jobs]


def run_sweep(sweep, functions, say=print, collect=False):
    """Runs all that is missing and writes the tables; returns the records, in the order of sweep.points."""
    jobs, points = jobs_of(sweep), sweep.points
    sweep.out.mkdir(parents=True, exist_ok=True)
    if collect:
        records = [measured(record, functions) for record in collected(jobs)]
    else:
        records, place = [None] * len(jobs), {job.folder: k for k, job in enumerate(jobs)}

        def ended(job, record):
            k = place[job.folder]
            records[k] = measured(record, functions)
            some = [(point, one) for point, one in zip(points, records) if one]
            write_sweep(sweep, *zip(*some))
            say(progress(points[k], records[k], len(some), len(jobs)))
        run_all(jobs, sweep.jobs, ended)
    write_sweep(sweep, points, records)
    return records


def progress(point, record, number, total):
    """One line on a run that ended."""
    again = "" if record["fresh"] else " (done before)"
    cost = f"{record['cpu_s']:.2f} s CPU, " if math.isfinite(record["cpu_s"]) else ""
    said = ", ".join(f"{name} {value:.6g}" if not why else f"{name}: {why}" for name, (value, why) in record["values"].items())
    if state(record) != "finished":
        said = f"{state(record)}: {record['reason']}"
    return f"[{number}/{total}] {words_of(point)}{again}: {cost}{said}"


def parser():
    """The options."""
    options = Parser(prog="python -m tools.sweep", description=__doc__, epilog="quantities by name (mean_v:0.2:0.5 gives numbers to "
        "the first arguments):\n" + quantities.summary(quantities.load()))
    options.add_argument("script", help="the case, such as cases/settling_disk.edp")
    options.add_argument("--vary", nargs="+", required=True, metavar="PARAMETER=VALUES", help="what varies, see above")
    options.add_argument("--quantity", nargs="+", required=True, metavar="WHAT", help="what to measure, see above")
    options.add_argument("--quantities", nargs="+", default=[], metavar="FILE", help="Python files with quantities of your own")
    options.add_argument("--over", nargs="+", metavar="PARAMETER", help="parameters that means are taken over (default: the seeds)")
    options.add_argument("--out", type=out_folder, metavar="DIR", help="where all goes (default results/sweep/CASE)")
    options.add_argument("--jobs", type=whole(1), default=cores(), metavar="N", help=f"runs at a time (default {cores()}: the cores)")
    options.add_argument("--limit", type=positive, metavar="S", help="stop a run after so many seconds: a row with that reason")
    options.add_argument("--retry", action="store_true", help="run again what failed before")
    options.add_argument("--collect", action="store_true", help="tables of the runs that are there; runs nothing")
    options.add_argument("--batch", nargs=2, metavar=("SYSTEM", "FILE"), help="write the script of an array job (SYSTEM: slurm)")
    options.add_argument("--task", type=whole(1), help=argparse.SUPPRESS)  # of an array job: this run alone, no tables
    return options


def read(words):
    """(Sweep, {quantity: function}, the options of the tool) of a command's words. Raises BadInput."""
    cut = words.index("--") if "--" in words else len(words)
    given = parser().parse_args(words[:cut])
    script = os.path.relpath(Path(given.script).resolve(), ROOT) if Path(given.script).is_file() else given.script
    if not (ROOT / script).is_file():
        raise BadInput(f"there is no script {given.script}")
    vary = read_vary(given.vary, Path.cwd())
    for name in ("out", "overwrite", "restart"):
        if name in vary:
            raise BadInput(f"-{name} is set by this tool, and cannot vary")
    over = given.over if given.over is not None else [name for name in SEEDS if name in vary]
    for name in over:
        if name not in vary:
            raise BadInput(f"--over {name}: that parameter does not vary")
    if len(set(given.quantity)) < len(given.quantity):
        raise BadInput("--quantity names one quantity twice")
    known = quantities.load(given.quantities)
    functions = {text: quantities.parse(text, known) for text in given.quantity}
    options = case_options(for_runs(script, words[cut + 1:]), ["-out", "-overwrite", *(f"-{name}" for name in vary)])
    out = given.out or out_folder(str(results_of(script) / "sweep" / Path(script).stem))
    return Sweep(script, vary, given.quantity, over, options, out, given.jobs, given.limit, given.retry,
        given.quantities), functions, given


def main(words=None):
    """0 if all runs ended well, 1 if some failed."""
    words = list(sys.argv[1:] if words is None else words)
    sweep, functions, given = read(words)
    if given.batch:
        print(batch.write(sweep, *given.batch))
        return 0
    if given.task:
        jobs = jobs_of(sweep)
        if given.task > len(jobs):
            raise BadInput(f"there is no run {given.task} among {len(jobs)}")
        record = run_job(jobs[given.task - 1])
        print(progress(sweep.points[given.task - 1], measured(record, functions), given.task, len(jobs)))
        return int(state(record) != "finished")
    records = run_sweep(sweep, functions, lambda line: print(line, flush=True), given.collect)
    print(f"table: {sweep.out / 'sweep.csv'}")
    if sweep.over:
        write_means(sweep, records)
        print(f"means over {', '.join(sweep.over)}: {sweep.out / 'means.csv'}")
    else:
        (sweep.out / "means.csv").unlink(missing_ok=True)
    from tools.many.figure import draw
    path = draw(sweep, records, means(sweep, records))
    print(f"figure: {path}" if path else "no figure: no quantity has a value")
    failed = [record for record in records if state(record) != "finished"]
    missing = sum(any(why for _, why in record["values"].values()) for record in records)
    if failed or missing:
        what = [f"{len(failed)} of {len(records)} runs did not finish"] * bool(failed)
        of_all = "" if failed else f"of {len(records)} runs "
        what += [f"{missing} {of_all}lack a value"] * bool(missing)
        print(f"error: {', and '.join(what)}"
              + "; the reasons stand above and in the table", file=sys.stderr)
    return int(bool(failed or missing))
