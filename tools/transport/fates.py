"""What becomes of the particles, by class of diameter, with the spread over seeds.

    python -m tools.transport_table [--seeds 20] [--out DIR] [--jobs 1] [OPTION VALUE ...]
    python -m tools.transport_table --runs RUN RUN ...

Runs cases/pipe_transport.edp once per seed (further options are passed to it; finished runs
of the same sources, mesh and options are kept) and writes table.csv and table.png into
DIR (default results/transport_table). Per class, in per cent of its particles, mean and
standard deviation over the seeds:
  carried through   left by the outlet before the end of the run
  trapped           at the end before the first obstacle (the diaphragm), a second or more after entering
  behind            at the end still in the pipe behind the diaphragm
  recirculation     was carried upstream (u < 0) behind the diaphragm for at least 0.05 s in all
  bottom            less than 1 cm above the lower wall for more than half of its time in the pipe

Places and classes are those of the paper's pipe (-radius 0.1, -length 1, diameters of 1 to 3 cm): runs of another pipe
are refused, other diameters get rows of their own. Runs that have not finished are refused, and runs that differ in
more than their seeds and where and how often they write.
"""
import os
from pathlib import Path

import numpy as np

from tools.base.command import ROOT, BadInput, Parser, case_options, out_folder, whole
from tools.base.engine import Job, run_all
from tools.base.run_folder import RunFolder
from tools.base.tables import write_table
from tools.compile_errors.run import for_runs
from tools.plot.style import PAGE_WIDTH, CURVES, plt, save

CASE = "cases/pipe_transport.edp"
FATES = ("carried through", "trapped", "behind", "recirculation", "bottom")
CLASSES = np.array([0.010, 0.015, 0.020, 0.025, 0.030001])
SEEDS = ("-seed", "-turbulence-seed")
# in which runs of a table may differ
FREE = {*SEEDS, "-out", "-overwrite", "-every", "-fields", "-flow", "-restart", "-checkpoint", "-maxwall", "-contact-trace"}
PIPE = {"-radius": 0.1, "-length": 1.0}  # m


def fates(run, front=0.295, low=-0.1, near=0.01):
    """(diameters, {fate: 0/1 of each particle}) of a run."""
    tracks, end = run.tracks, run.particles["t"].max()
    exits = run.columns("exits")
    through = set(exits["id"][exits["outlet"] > 0.5].astype(int))
    sizes, found = [], {name: [] for name in FATES}
    for one, track in tracks.items():
        t, x, y, u = (track[name] for name in ("t", "x", "y", "u"))
        step = np.diff(t, append=t[-1])
        inside = t[-1] > end - 1e-9 and one not in through
        backward = float(np.sum(step[(u < 0) & (x > front)]))
        low_time = float(np.sum(step[y - track["radius"] < low + near]))
        sizes.append(2 * track["radius"][0])
        for name, what in zip(FATES, (one in through, inside and x[-1] < front and t[-1] - t[0] >= 1.0, inside and x[-1] >= front,
                                      backward >= 0.05, low_time > 0.5 * max(t[-1] - t[0], 1e-12))):
            found[name].append(bool(what))
    return np.array(sizes), {name: np.array(values) for name, values in found.items()}


def usable(run):
    """The run, or BadInput where it holds nothing that this table can judge."""
    if not run.has("exits"):
        raise BadInput(f"{run.folder} is no run of a transport case (it has no exits.csv)")
    if run.in_space:
        raise BadInput(f"{run.folder} is a run in three dimensions; this table is of plane runs")
    if run.status not in ("", "finished"):
        raise BadInput(f"the run {run.folder} has not come to its end (its status is '{run.status}')")
    if not len(run.columns("particles", "u")["t"]):
        raise BadInput(f"the run {run.folder} holds no particles")
    for name, value in PIPE.items():
        if not abs(run.parameter(name, value) - value) < 1e-9:
            raise BadInput(f"the run {run.folder} has {name} {run.parameter(name, value):g}; the places of this table are those "
                f"of {name} {value:g}")
    return run


def alike(runs):
    """BadInput where two runs differ in an option that is not in FREE, or are of the same seeds."""
    first, *others = [run.info.get("parameters") or {} for run in runs]
    for run, given in zip(runs[1:], others):
        for name in sorted({*first, *given} - FREE):
            if first.get(name) != given.get(name):
                raise BadInput(f"the runs {runs[0].folder} and {run.folder} differ in {name} ({first.get(name)} and "
                    f"{given.get(name)}): a table is of seeds of one scene")
    known = {}
    for run, given in zip(runs, (first, *others)):
        seeds = tuple(given.get(name) for name in SEEDS)
        if "-seed" in given and seeds in known:
            raise BadInput(f"the runs {known[seeds].folder} and {run.folder} are both of -seed {given['-seed']}: each seed "
                f"counts once in mean and deviation")
        known[seeds] = run


def table_of(runs):
    """Rows [class low, class high, particles a run, mean and deviation of each fate in %]; the last row is all of them."""
    alike(runs)
    judged = [fates(usable(run)) for run in runs]
    sizes = np.concatenate([one for one, _ in judged])
    classes = list(zip(CLASSES[:-1], CLASSES[1:]))
    if sizes.min() < CLASSES[0] - 1e-9:
        classes.insert(0, (sizes.min(), CLASSES[0]))
    if sizes.max() >= CLASSES[-1]:
        classes.append((CLASSES[-1], 1.001 * sizes.max()))
    rows = []
    for low, high in [*classes, (classes[0][0], classes[-1][1])]:
        parts, numbers = {name: [] for name in FATES}, []
        for sizes, found in judged:
            mine = (sizes >= low) & (sizes < high)
            numbers.append(int(mine.sum()))
            for name in FATES:
                if mine.any():
                    parts[name].append(100 * found[name][mine].mean())
        row = [low, round(high, 3), float(np.mean(numbers))]
        for name in FATES:
            values = np.array(parts[name])
            row += [values.mean() if len(values) else np.nan, values.std(ddof=1) if len(values) > 1 else np.nan]
        rows.append(row)
    return rows


def shown(value, sign, width):
    """A number with one decimal behind a sign; a dash where there is none: the deviation of a single seed, the mean of no
    particle."""
    return f"{sign}{value:{width}.1f}" if np.isfinite(value) else f"{'-':>{len(sign) + width}}"


def plot_table(rows, path, seeds):
    """Bars by class with the standard deviation over the seeds."""
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
    width = 0.8 / len(FATES)
    for k, name in enumerate(FATES):
        heights, spread = [row[3 + 2 * k] for row in rows], [row[4 + 2 * k] for row in rows]
        places = np.arange(len(rows)) + (k - len(FATES) / 2 + 0.5) * width
        axes.bar(places, heights, 0.9 * width, color=CURVES[k][0], label=name)
        low = [min(s, h) for s, h in zip(spread, heights)]
        axes.errorbar(places, heights, yerr=[low, spread], fmt="none", ecolor="black", elinewidth=0.7, capsize=1.5)
    axes.set_xticks(range(len(rows)), [f"{100 * row[0]:g} to {100 * row[1]:g} cm" for row in rows[:-1]] + ["all"])
    axes.set_ylabel("particles of the class (%)")
    axes.set_ylim(0, 105)
    axes.grid(True, axis="y")
    axes.legend(ncols=len(FATES), loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.2, handlelength=1.2)
    axes.set_xlabel(f"diameter (bars: mean, lines: standard deviation over {seeds} seeds)" if seeds > 1 else "diameter (one seed)")
    axes.set_axisbelow(True)
    return save(figure, path)


def compute(seeds, out, options, jobs):
    """The run folders, one a seed; those that are missing are made."""
    made = [Job(CASE, {**options, "-seed": seed}, out / f"seed_{seed:03d}", retry=True) for seed in range(1, seeds + 1)]

    def ended(job, record):
        if record["status"]:
            raise BadInput(f"seed {job.options['-seed']}: {record['reason']}")
        if record["fresh"]:
            print(f"seed {job.options['-seed']}: {record['cpu_s']:.1f} s of CPU", flush=True)
    run_all(made[:1], 1, ended)  # the steady flow is made once
    run_all(made[1:], jobs, ended)
    return [job.folder for job in made]


def parser():
    """The options."""
    options = Parser(prog="python -m tools.transport_table", description=__doc__)
    options.add_argument("--seeds", type=whole(1), default=20, metavar="N", help="number of seeds (default 20)")
    options.add_argument("--jobs", type=whole(1), default=1, metavar="N", help="runs at a time (default 1)")
    options.add_argument("--out", type=out_folder, default=str(ROOT / "results" / "transport_table"), metavar="DIR",
        help="where the runs and the table go")
    options.add_argument("--runs", nargs="+", metavar="RUN", help="run folders to judge instead of running")
    return options


def main(words=None):
    """Write the table; 0."""
    given, rest = parser().parse_known_args(words)
    options = case_options(for_runs(CASE, rest), ["-seed", "-out"])
    places = [Path(run).resolve() for run in given.runs or ()]
    again = [str(run) for k, run in enumerate(given.runs or ()) if places[k] in places[:k]]
    if again:
        raise BadInput(f"{again[0]} is given twice: each run counts once in mean and deviation")
    if given.runs and options:
        raise BadInput(f"{next(iter(options))} is for runs that are made: leave it or --runs out")
    out = given.out
    folders = given.runs or compute(given.seeds, out, options, given.jobs)
    rows = table_of([RunFolder(folder) for folder in folders])
    os.makedirs(out, exist_ok=True)
    names = ["diameter_from_m", "diameter_to_m", "particles"] + [f"{name.replace(' ', '_')}_{what}" for name in FATES
        for what in ("percent", "deviation")]
    write_table(out / "table.csv", names, rows)
    print("diameter (cm)   number  " + "  ".join(f"{name:>16}" for name in FATES))
    for row in rows:
        cells = "  ".join(f"{shown(row[3 + 2 * k], '', 9)} {shown(row[4 + 2 * k], '+-', 5)}" for k in range(len(FATES)))
        print(f"{100 * row[0]:4.1f} to {100 * row[1]:4.1f}   {row[2]:6.1f}  {cells}")
    print(out / "table.csv")
    print(plot_table(rows, out / "table.png", len(folders)))
    return 0
