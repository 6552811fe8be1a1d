"""How much the reaction of the particles on the flow matters in the pipe.

    python -m tools.coupling_effect [--seeds 5] [--out DIR] [--jobs 1] [OPTION VALUE ...]

Runs cases/pipe_transport.edp once per seed one-way and once two-way (further options are passed
to both; finished runs of the same sources, mesh and options are kept) and writes
coupling_effect.csv and coupling_effect.png into DIR (default results/coupling_effect). Of the flow:
change of the pressure drop (mean and extremes of the run), of its largest velocity, largest
change of the velocity anywhere. Of the particles: how many leave, when (those that leave in
both), how far the same particle is from its one-way place at the end, and the shares of
tools/transport/fates.py. Single paths are sensitive to everything, so the shares are set against
the standard deviation over the seeds.
"""
import os

import numpy as np

from tools.base.command import ROOT, BadInput, Parser, case_options, out_folder, whole
from tools.base.run_folder import RunFolder
from tools.base.tables import write_table
from tools.compile_errors.run import for_runs
from tools.plot.style import CURVES, PAGE_WIDTH, plt, save
from tools.transport.fates import CASE, FATES, compute, fates, shown

COLUMNS = ["seed", "pressure_drop_change_mean_Pa", "pressure_drop_change_least_Pa", "pressure_drop_change_most_Pa",
    "speed_most_change_m_s", "velocity_change_most_m_s",
           "volume_fraction_most", "left_one_way", "left_two_way", "exit_time_mean_change_s", "exit_time_median_difference_s",
               "distance_median_m"]


def exits(run):
    """{id: time} of those that left by the outlet."""
    table = run.columns("exits")
    return {int(i): t for i, t, outlet in zip(table["id"], table["t"], table["outlet"]) if outlet > 0.5}


def distances(one, two):
    """How far each particle is from its place in the other run, at the last time both have it."""
    found = []
    tracks = two.tracks
    for name, track in one.tracks.items():
        if name in tracks:
            t = min(track["t"][-1], tracks[name]["t"][-1])
            a, b = (np.array([np.interp(t, own["t"], own[axis]) for axis in "xy"]) for own in (track, tracks[name]))
            found.append(float(np.hypot(*(a - b))))
    return np.array(found)


def compare(seed, one, two):
    """A row of COLUMNS."""
    flow, left_one, left_two = two.columns("coupling", "pressure_drop_change", "speed_most", "change_most",
        "volume_fraction_most"), exits(one), exits(two)
    both = sorted(set(left_one) & set(left_two))
    late = np.array([left_two[i] - left_one[i] for i in both]) if both else np.array([np.nan])
    drop, speed = flow["pressure_drop_change"], flow["speed_most"][1:]
    steady = speed[np.argmin(flow["change_most"][1:])]  # before the particles are felt
    return [seed, drop.mean(), drop.min(), drop.max(), speed[np.argmax(np.abs(speed - steady))] - steady,
        flow["change_most"].max(), flow["volume_fraction_most"].max(),
            len(left_one), len(left_two), late.mean(), np.median(np.abs(late)), np.median(distances(one, two))]


def shares(run):
    """Per cent of the particles in each of FATES."""
    _, found = fates(run)
    return [100 * found[name].mean() for name in FATES]


def plot(pairs, path):
    """Pressure drop over time, and the shares one-way and two-way."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 2.8), layout="constrained", width_ratios=[1.1, 1])
    for k, (_, two) in enumerate(pairs):
        table = two.columns("coupling")
        left.plot(table["t"], table["pressure_drop_change"], linewidth=0.7, color=CURVES[k % len(CURVES)][0])
    left.set_xlabel("t (s)")
    left.set_ylabel("change of the pressure drop (Pa)")
    left.set_title(f"two-way, {len(pairs)} seeds" if len(pairs) > 1 else "two-way, one seed")
    left.grid(True)
    for way, label in ((0, "one-way"), (1, "two-way")):
        values = np.array([shares(pair[way]) for pair in pairs])
        spread = values.std(axis=0, ddof=1) if len(pairs) > 1 else np.zeros(len(FATES))
        places = np.arange(len(FATES)) + 0.4 * (way - 0.5)
        right.bar(places, values.mean(axis=0), 0.36, color=CURVES[way][0], label=label)
        right.errorbar(places, values.mean(axis=0), yerr=[np.minimum(spread, values.mean(axis=0)), spread], fmt="none",
            ecolor="black", elinewidth=0.7, capsize=2)
    right.set_xticks(range(len(FATES)), [name.replace(" ", "\n") for name in FATES], fontsize=7)
    right.set_ylabel("particles (%)")
    right.set_title("lines: standard deviation over seeds" if len(pairs) > 1 else "one seed")
    right.grid(True, axis="y")
    right.set_axisbelow(True)
    right.legend()
    return save(figure, path)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.coupling_effect", description=__doc__)
    options.add_argument("--seeds", type=whole(1), default=5, metavar="N", help="number of seeds (default 5)")
    options.add_argument("--jobs", type=whole(1), default=1, metavar="N", help="runs at a time (default 1)")
    options.add_argument("--out", type=out_folder, default=str(ROOT / "results" / "coupling_effect"), metavar="DIR",
        help="where runs and results go")
    return options


def main(words=None):
    """Write table and picture; 0."""
    given, rest = parser().parse_known_args(words)
    out, more = given.out, case_options(for_runs(CASE, rest), ["-coupling", "-seed", "-out"])
    runs = [[RunFolder(folder) for folder in compute(given.seeds, out / way.replace("-", "_"), {**more, "-coupling": way},
        given.jobs)] for way in ("one-way", "two-way")]
    if not all(len(run.particles["t"]) for way in runs for run in way):
        raise BadInput("there is a run without particles: nothing to compare")
    pairs = list(zip(*runs))
    rows = [compare(seed, *pair) for seed, pair in enumerate(pairs, 1)]
    os.makedirs(out, exist_ok=True)
    write_table(out / "coupling_effect.csv", COLUMNS, rows)
    values = np.array(rows, dtype=float)
    for k, name in enumerate(COLUMNS[1:], 1):
        some = values[np.isfinite(values[:, k]), k]  # a seed of which nobody leaves has no time of it
        print(f"{name:<34} mean {some.mean():10.4g}   least {some.min():10.4g}   most {some.max():10.4g}"
            if len(some) else f"{name:<34} none")
    one, two = (np.array([shares(pair[way]) for pair in pairs]) for way in (0, 1))
    for k, name in enumerate(FATES):
        spread = one[:, k].std(ddof=1) if given.seeds > 1 else np.nan
        print(f"{name:<20} one-way {one[:, k].mean():5.1f} %, two-way {two[:, k].mean():5.1f} %, standard deviation over seeds "
            f"{shown(spread, '', 4)}{' %' if given.seeds > 1 else ''}")
    print(out / "coupling_effect.csv")
    print(plot(pairs, out / "coupling_effect.png"))
    return 0
