"""Runs the cells of a map, each once, within its CPU time; what is done is read, not run again."""
import concurrent.futures
import json
import math
import os
import re
import shutil
import time

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import Done, commit, fingerprint, freefem, option_words, run_command, side_by_side
from tools.stress.cells import Disks, Mesh
from tools.stress.classes import GOOD, LATE, WORDS, judge
from tools.base.tables import write_table, write_text

NICE = 10  # wall-clock seconds a CPU second may take before a cell counts as hanging
COLUMNS = ["map", "x", "y", "part", "class", "reason", "error", "tolerance", "overlap_radii", "status", "cpu_s",
           "memory_mib", "commit", "run"]


def name_of(one, x, y):
    """The file name of a cell."""
    text = f"{one.x.key(x)}__{one.y.key(y)}"
    return re.sub(r"[^A-Za-z0-9_.+-]+", "-", text)


def run_cell(one, x, y, out, limit):
    """Run a cell, or read what an earlier run of the same sources and options left; returns
    its record: status, reason, log, cost, folder, fresh."""
    cell = one.build(x, y)
    limit *= cell.patience
    (out / "inputs").mkdir(parents=True, exist_ok=True)
    files = {name: value.make(out / "inputs") for name, value in cell.options.items() if isinstance(value, (Mesh, Disks))}
    folder = out / one.name / "runs" / name_of(one, x, y)
    note = folder.with_name(folder.name + ".json")
    options = {**cell.options, **files}
    key = fingerprint(cell.script, options)
    try:
        old = json.loads(note.read_text())
    except (OSError, ValueError):
        old = {}
    # a cell that ran out of time is tried again when it is given more
    if old.get("key") == key and (old["status"] not in LATE or old["limit"] >= limit):
        return {**old, "fresh": False}
    note.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    command = ["sh", "-c", 'ulimit -S -t "$0"; exec "$@"', str(max(1, math.ceil(limit))), freefem(), "-nw", cell.script,
               *option_words(options), "-out", str(folder)]
    done = run_command(command, NICE * limit + 60)
    record = {"map": one.name, "x": x, "y": y, "key": key, "limit": limit, "status": done.status, "reason": done.reason,
              "log": done.log[-4000:], "cpu_s": done.cpu_s, "memory_mib": done.memory_mb, "commit": commit(), "run": str(folder)}
    write_text(note, json.dumps(record, indent=1))
    return {**record, "fresh": True}


def measured(cell, record):
    """The cell's quantity, nan where the run or its files do not give it."""
    if record is None or record["status"] != 0:
        return np.array([math.nan])
    try:
        return np.atleast_1d(np.asarray(cell.quantity(RunFolder(record["run"])), float))
    except (BadInput, ValueError, KeyError, IndexError, TypeError):
        return np.array([math.nan])


def error_of(one, cell, record, records):
    """A function of the run folder for classes.judge, or None where there is no reference."""
    if cell.quantity is None or cell.reference is None:
        return None

    def error(_):
        got = measured(cell, record)
        if cell.reference == "own":
            return float(np.abs(got).max()), cell.tolerance
        expected = measured(one.build(*cell.reference), records.get(cell.reference))
        if expected.shape != got.shape or not np.all(np.isfinite(expected)) or not np.all(np.isfinite(got)):
            return math.nan, cell.tolerance
        scale = max(float(np.abs(expected).max()), cell.floor, 1e-300)
        return float(np.abs(got - expected).max()) / scale, cell.tolerance
    return error


def classed(one, pair, record, records):
    """The row of a cell: its class, the reason, the error, what it cost."""
    cell = one.build(*pair)
    done = Done(record["status"], record["reason"], record["cpu_s"], math.nan, record["memory_mib"], record["log"])
    error = error_of(one, cell, record, records)
    kind, reason, depth = judge(done, cell.checks, record["run"], error)
    if kind == "stopped" and done.status == 3 and not cell.may_refuse:
        kind, reason = "not run", f"the case refuses its options: {done.reason}"
    less = records.get(cell.memory_of)
    if kind == "accurate" and less and done.memory_mb > 1.1 * less["memory_mib"]:
        kind, reason = "stable", f"memory grows: {done.memory_mb:.0f} MiB, {less['memory_mib']:.0f} in the short run"
    value = error(None)[0] if error and kind in ("accurate", "stable") else math.nan
    return {**record, "class": kind, "reason": reason, "error": value, "tolerance": cell.tolerance if error else math.nan,
            "overlap_radii": depth}


class Progress:
    """Counts the runs of all maps and guesses the time left from those that were not done before."""

    def __init__(self, total, say):
        self.total, self.say, self.done, self.fresh, self.begin = total, say, 0, 0, time.perf_counter()

    def line(self, one, pair, row, word):
        """Says how a run ended."""
        self.done += 1
        self.fresh += row["fresh"]
        cost = f"{row['cpu_s']:.1f} s of CPU" if math.isfinite(row["cpu_s"]) else "stopped from outside"
        left = (time.perf_counter() - self.begin) / max(self.fresh, 1) * (self.total - self.done) if self.fresh else 0
        self.say(f"[{self.done}/{self.total}] {one.name}: {one.x.name} {one.x.text(pair[0])}, {one.y.name} {one.y.text(pair[1])}: "
                 f"{word}{': ' + row['reason'] if row['class'] not in GOOD else ''} ({cost}{'' if row['fresh'] else ', done before'})"
                 + (f", about {left / 60:.0f} min left" if left > 90 else ""))


def run_map(one, out, quick=False, jobs=1, limit=60.0, say=print, progress=None):
    """Run and class all cells of a map; returns (grid, {(x, y): row}), and leaves MAP.csv."""
    grid, extra = one.pairs(quick)
    pairs, records = extra + grid, {}
    progress = progress or Progress(len(pairs), say)
    with side_by_side(jobs) as pool:
        waiting = {pool.submit(run_cell, one, *pair, out, 4 * limit if pair in extra else limit): pair for pair in pairs}
        for future in concurrent.futures.as_completed(waiting):
            pair = waiting[future]
            records[pair] = future.result()
            row = classed(one, pair, records[pair], records)
            reference = one.build(*pair).reference
            early = pair in extra or (isinstance(reference, tuple) and reference not in records)
            progress.line(one, pair, row, ("ended" if row["class"] in GOOD else row["class"]) if early else WORDS[row["class"]])
    rows = {pair: classed(one, pair, records[pair], records) for pair in pairs}
    write_map(one, grid, rows, out)
    return grid, rows


def write_map(one, grid, rows, out):
    """MAP.csv: one row a cell, those of reference runs at the end."""
    table = [[one.name, pair[0], pair[1], "grid" if pair in grid else "reference", row["class"], row["reason"], row["error"],
              row["tolerance"], row["overlap_radii"], row["status"], row["cpu_s"], row["memory_mib"], row["commit"],
              os.path.relpath(row["run"], out)] for pair, row in sorted(rows.items(), key=lambda item: item[0] not in grid)]
    write_table(out / f"{one.name}.csv", COLUMNS, table)
