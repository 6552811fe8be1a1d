"""Stability maps: where the schemes are accurate, stable, stop with a reason, or break.

    python -m tools.stress                    all maps (make stress; half an hour of CPU)
    python -m tools.stress --quick            a few cells of each (make stress QUICK=1)
    python -m tools.stress dt_density gap     some maps
    python -m tools.stress --list             what there is

Each cell of a map is a run with a limit on its CPU time, classed by checks on its outputs
(finite, bounded, at its end, no overlap recomputed from particles.csv, error against a stated
reference), not by its exit status alone. Finished cells are not run again unless the sources
or the options have changed, so that an interrupted stress run continues.

Writes into --out (default results/stress, with --quick results/stress_quick): MAP.csv and
MAP.png for each map, stress.png with all, limits.csv and limits.md (each limit with its
remedy). Status 0: nothing blew up or overlapped unnoticed and the defaults lie well inside;
1: something did; 3: bad input.
"""
import datetime
import time

from tools.base.command import ROOT, BadInput, Parser, guarded, out_folder, positive, whole
from tools.base.runner import commit, freefem
from tools.stress import maps_contacts, maps_energy, maps_flow, maps_friction, maps_long, maps_particles
from tools.stress.figure import draw_all, draw_map
from tools.stress.limits import defaults_inside, failures, write_limits
from tools.stress.runs import Progress, run_map

MAPS = {one.name: one for module in (maps_flow, maps_particles, maps_contacts, maps_friction, maps_energy, maps_long)
    for one in module.MAPS}


def parser():
    """The options."""
    options = Parser(prog="python -m tools.stress", description=__doc__)
    options.add_argument("names", nargs="*", metavar="MAP", help="maps (default: all)")
    options.add_argument("--quick", action="store_true", help="a few cells of each map (about 5 minutes)")
    options.add_argument("--list", action="store_true", help="list the maps and their axes")
    options.add_argument("--out", type=out_folder, metavar="DIR", help="where all goes")
    options.add_argument("--jobs", type=whole(1), default=1, metavar="N", help="runs at a time (default 1)")
    options.add_argument("--limit", type=positive, default=60.0, metavar="S", help="CPU time of a cell, s (default 60; reference "
        "runs get four times that)")
    return options


def chosen(names):
    """The maps of these names, all without a name."""
    unknown = [name for name in names if name not in MAPS]
    if unknown:
        raise BadInput(f"there is no map {unknown[0]}; there are {', '.join(MAPS)}")
    return [MAPS[name] for name in dict.fromkeys(names)] or list(MAPS.values())


def main(words=None, say=lambda line: print(line, flush=True)):
    """0 if nothing failed and the defaults lie inside, else 1."""
    given = parser().parse_args(words)
    maps = chosen(given.names)
    if given.list:
        for one in maps:
            grid, extra = one.pairs(given.quick)
            say(f"{one.name:<22}{len(grid):>4} cells, {len(extra)} reference runs: {one.x.label} x {one.y.label}")
        return 0
    freefem()
    out = given.out or out_folder(ROOT / "results" / ("stress_quick" if given.quick else "stress"))
    out.mkdir(parents=True, exist_ok=True)
    progress, done = Progress(sum(sum(map(len, one.pairs(given.quick))) for one in maps), say), []
    for one in maps:
        grid, rows = run_map(one, out, given.quick, given.jobs, given.limit, say, progress)
        done.append((one, grid, rows))
        say(f"figure: {draw_map(one, grid, rows, out)}")
    head = f"{datetime.date.today()}, commit {commit()}, {sum(len(grid) for _, grid, _ in done)} cells, quick form: {'yes' if given.quick else 'no'}."
    for name, kind, where, number, example, remedy in write_limits(done, out, head):
        say(f"{name}: {kind} ({number}): {where}" + (f"; remedy: {remedy}" if remedy else ""))
    say(f"figure: {draw_all(done, out / 'stress.png')}")
    wrong = failures(done)
    for line in wrong:
        say(f"FAILED {line}")
    outside = [f"{name}: {text}" for name, good, text in defaults_inside(done) if not good]
    for line in outside:
        say(f"FAILED the default does not lie well inside: {line}")
    say(f"{progress.done} runs, {progress.fresh} of them made now, in {(time.perf_counter() - progress.begin) / 60:.1f} min; "
        f"limits: {out / 'limits.md'}")
    return 1 if wrong or outside else 0


if __name__ == "__main__":
    guarded(main)
