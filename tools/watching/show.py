"""How far a run is: progress, time left, speed, contacts, and the course of some columns.

    python -m tools.watch RUN [--once] [--every S] [--columns kinetic_energy contacts]

Reads run.json and the table that grows (fluid.csv, motion.csv or steps.csv) until the run ends.
In a terminal the picture is drawn anew every second; in a pipe each look that finds something
new is a plain line. Time left is that of the wall clock, at the speed of the last minute; a
first look takes the mean speed since the run began. A steady flow has no table that grows:
only its status is shown. The run itself is not touched; stopping this leaves it running.

Exit status: 0 for a run that finished, and with --once for one that runs; N for one that
failed (N), 128 + N for one killed by signal N, 4 for one that did not converge, 1 for one that
ended without a word; 3 for bad input.
"""
import re
import sys
import time

import numpy as np

from tools.base.command import BadInput, Parser, positive
from tools.watching.progress import Progress

MARKS = "▁▂▃▄▅▆▇█"
WIDTH = 40  # marks of a line
SHOWN = ("kinetic_energy", "particles", "inside", "contacts", "pressure_drop", "top_speed", "potential_energy", "worst_gap")
MOST = 5  # columns


def marks(times, values, width=WIDTH):
    """The course of a column as `width` signs: the means over equal spans of time, from the least to the greatest. Spans
    without a row lie between their neighbours; a column that does not change is a low line."""
    times, values = np.asarray(times, float), np.asarray(values, float)
    good = np.isfinite(values)
    times, values = times[good], values[good]
    if not len(times):
        return ""
    spans = np.minimum((width * (times - times[0]) / max(times[-1] - times[0], 1e-300)).astype(int), width - 1)
    number = np.bincount(spans, minlength=width)
    there = np.flatnonzero(number)
    means = np.interp(np.arange(width), there, np.bincount(spans, values, minlength=width)[there] / number[there])
    low, high = means.min(), means.max()
    levels = np.zeros(width, int) if high <= low else np.minimum(((means - low) / (high - low) * len(MARKS)).astype(int),
        len(MARKS) - 1)
    return "".join(MARKS[level] for level in levels)


def chosen(rows, wanted=None):
    """Names of the columns to show: those wanted, else the first of SHOWN that change. Raises BadInput for one that is not there."""
    if wanted:
        for name in wanted:
            if rows and name not in rows:
                raise BadInput(f"--columns: there is no column {name}; there are {' '.join(rows)}")
        return [name for name in wanted if name in rows]
    changing = [name for name in SHOWN if name in rows and len(set(rows[name][-1:] + rows[name][:1] + rows[name][::7])) > 1]
    return changing[:MOST]


def duration(seconds):
    """Seconds as words: 42 s, 3 min 05 s, 2 h 10 min, 3 d 4 h."""
    if seconds is None:
        return "not known"
    whole = int(seconds + 0.5)
    for unit, small, size, part in (("d", "h", 86400, 3600), ("h", "min", 3600, 60), ("min", "s", 60, 1)):
        if whole >= size:
            rest = whole % size // part
            return f"{whole // size} {unit} {rest:0{1 if unit == 'd' else 2}d} {small}"
    return f"{whole} s"


def facts(progress, seen):
    """[(name, words)] of what is known of a run."""
    found = [("status", seen.status)]
    if seen.time is not None:
        share = "" if not seen.end else f" of {seen.end:g} {progress.unit} ({100 * min(1, seen.time / seen.end):.1f} %)"
        found.append(("t", f"{seen.time:.4g}" + (share or f" {progress.unit}")))
    if seen.step is not None:
        speed = "" if seen.steps_per_second is None else f", {seen.steps_per_second:.3g} a second"
        found.append(("step", f"{seen.step}{speed}"))
    if progress.rows.get("contacts"):
        found.append(("contacts", f"{progress.rows['contacts'][-1]:g}"))
    if seen.since is not None:
        found.append(("took" if seen.over else "since the start", duration(seen.since)))
    if not seen.over and progress.rows:
        found.append(("left", duration(seen.left)))
    if not seen.over and seen.quiet is not None and seen.quiet > 60:
        found.append(("no new row for", duration(seen.quiet)))
    return found


def line(progress, seen):
    """A look as one plain line."""
    return f"{progress.name}: " + "; ".join(words if name == "status" else f"{name} = {words}" if name == "t"
        else f"{name} {words}" for name, words in facts(progress, seen))


def picture(progress, seen, wanted=None):
    """A look as a panel of rich."""
    from rich import box
    from rich.console import Group
    from rich.panel import Panel
    from rich.progress_bar import ProgressBar
    from rich.table import Table
    table = Table.grid(padding=(0, 2))
    for name, words in facts(progress, seen):
        table.add_row(name, words)
    parts = [table]
    if seen.share is not None:
        bar = Table.grid(expand=True)  # a bar alone does not end its line
        bar.add_row(ProgressBar(total=1.0, completed=seen.share))
        parts.insert(0, bar)
    courses = Table.grid(padding=(0, 2))
    for name in chosen(progress.rows, wanted):
        values = progress.rows[name]
        courses.add_row(name, marks(progress.rows["t"], values), f"{values[-1]:.4g}")
    if courses.row_count:
        parts += ["", courses]
    colour = "red" if seen.over and seen.status != "finished" else "green" if seen.over else "blue"
    return Panel(Group(*parts), title=f"{progress.name} ({progress.folder})", border_style=colour, box=box.ROUNDED, expand=False,
        width=92)


def verdict(status):
    """The exit status that tells how a run ended."""
    if status == "finished":
        return 0
    failed, killed = re.match(r"failed \((\d+)", status), re.match(r"killed \(signal (\d+)", status)
    if failed:
        return int(failed.group(1))
    if killed:
        return 128 + int(killed.group(1))
    return 4 if status == "not converged" else 1


def watch_plain(progress, every, wanted):
    """Lines, until the run ends; its status."""
    told = None
    while True:
        seen = progress.look()
        chosen(progress.rows, wanted)
        if seen.over or told != (seen.status, seen.time):
            print(line(progress, seen), flush=True)
        told = seen.status, seen.time
        if seen.over:
            return seen.status
        time.sleep(every)


def watch_drawn(progress, every, wanted):
    """A picture that is drawn anew, until the run ends; its status."""
    from rich.live import Live
    with Live(auto_refresh=False) as live:
        while True:
            seen = progress.look()
            live.update(picture(progress, seen, wanted), refresh=True)
            if seen.over:
                return seen.status
            time.sleep(every)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.watch", description=__doc__)
    options.add_argument("run", help="run folder, such as results/pipe_obstacles/run_001")
    options.add_argument("--once", action="store_true", help="one look, then the end")
    options.add_argument("--every", type=positive, metavar="S", help="seconds between looks (default 1; in a pipe 10)")
    options.add_argument("--columns", nargs="+", metavar="NAME", help="columns whose course is shown (default: up to five)")
    return options


def main(words=None):
    """Watch a run; the exit status above."""
    given = parser().parse_args(words)
    progress, drawn = Progress(given.run), sys.stdout.isatty()
    if given.once:
        seen = progress.look()
        if drawn:
            from rich.console import Console
            Console().print(picture(progress, seen, given.columns))
        else:
            chosen(progress.rows, given.columns)
            print(line(progress, seen))
        return 0 if not seen.over else verdict(seen.status)
    watch = watch_drawn if drawn else watch_plain
    return verdict(watch(progress, given.every or (1.0 if drawn else 10.0), given.columns))
