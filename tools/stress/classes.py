"""Classes of a run, given by checks on what it wrote and not by its exit status alone.

    accurate   finite, bounded, nothing overlaps, and near its reference
    stable     the same, but far from the reference, or there is none
    stopped    ended with status 3, 4 or 5 and one line that says why
    late       not at its end time within its CPU time
    overlap    ended well, but disks overlap, or one has passed through a wall
    blown up   not finite, not bounded, not at the end time, or ended without a reason
    not run    the case refuses its options (given in tools.stress.runs): the map is out of date
"""
import math
from dataclasses import dataclass, field

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.stress.overlap import aspects, crossing, pair_overlap, solid_segments, wall_overlap

LETTERS = {"accurate": "A", "stable": "S", "stopped": "C", "late": "T", "overlap": "O", "blown up": "B",
           "not run": "N"}
WORDS = {"accurate": "stable and accurate", "stable": "stable", "stopped": "stopped cleanly, with a reason",
         "late": "out of time", "overlap": "overlap", "blown up": "blown up", "not run": "not run"}
GOOD, FAILED = ("accurate", "stable"), ("overlap", "blown up", "not run")
TABLES = ("particles", "fluid", "contacts", "motion", "errors", "forces", "budget", "summary", "lines", "wall", "steps", "entries",
    "exits")
KINETIC, LATER, LOSSES = 0.02, 0.2, 0.25  # excesses above which energy counts as created (see excess())
CLOSED = 0.05  # numerical dissipation below minus this part of the whole counts as energy created
LATE = (24, -24, 124)  # statuses: FreeFEM on SIGXCPU, a program that SIGXCPU ended, tools.base.runner at its limit


@dataclass
class Checks:
    """What the outputs of a run are held to.

    bounds: {"table.column": largest absolute value}, units of the case. end: end time, s
    (None: a steady case, which writes results.csv). deepest: overlap allowed, of the smaller
    radius. period: of the domain, 0 for none. within: {"x": (low, high)} for every centre.
    energy: kinetic energy at the start, J/m, for scenes whose budget.csv is held to it (not_created).
    """
    bounds: dict = field(default_factory=dict)
    end: float = None
    deepest: float = 1e-6
    period: tuple = (0.0, 0.0)
    within: dict = field(default_factory=dict)
    energy: float = None


def judge(done, checks, folder, error=None):
    """(class, reason, depth of the deepest overlap in radii) of a run that ended as `done`
    (status, reason, log); error(run) -> (relative error, tolerance) or None where there is no reference."""
    if done.status in LATE:
        return "late", "its CPU time ran out", math.nan
    if done.status in (3, 4, 5) and any(line.startswith("error:") for line in done.log.splitlines()):
        return "stopped", done.reason, math.nan
    if done.status != 0:
        return "blown up", f"ended without a reason of its own: {done.reason}", math.nan
    depth = math.nan
    try:
        run = RunFolder(folder)
        tables = {name: run.table(name) for name in TABLES if run.has(name)}
        if run.has("results"):
            tables["results"] = {name: np.array([value]) for name, value in run.results.items()}
        fault = not_finite(tables) or not_bounded(tables, checks.bounds) or not_at_end(tables, checks.end) or created(tables,
            checks.energy)
        if fault:
            return "blown up", fault, depth
        if "particles" in tables and len(tables["particles"]["t"]):
            depth, fault = overlapping(run, tables["particles"], checks)
            if fault:
                return "overlap", fault, depth
        verdict = error(run) if error else None
    except (BadInput, ValueError, KeyError, IndexError) as problem:
        return "blown up", f"its files cannot be read: {problem}", depth
    if verdict is None:
        return "stable", "", depth
    if not math.isfinite(verdict[0]):
        return "stable", "there is no error to judge by: the reference run did not end well, or the quantity is no number", depth
    near = verdict[0] <= verdict[1]
    return ("accurate" if near else "stable"), f"error {verdict[0]:.2g}, accurate up to {verdict[1]:g}", depth


def not_finite(tables):
    """The first column with a value that is no number, in words; empty if there is none."""
    for name, table in tables.items():
        for column, values in table.items():
            bad = np.flatnonzero(~np.isfinite(values))
            if len(bad):
                return f"{name}.csv: {column} is {values[bad[0]]} in row {bad[0] + 1}"
    return ""


def not_bounded(tables, bounds):
    """The first value beyond its bound, in words."""
    for name, most in bounds.items():
        table, column = name.split(".")
        if column not in tables.get(table, {}):
            return f"{table}.csv has no {column}"
        values = np.abs(tables[table][column])
        if len(values) and values.max() > most:
            k = int(np.argmax(values > most))
            when = f" at t = {tables[table]['t'][k]:.4g}" if "t" in tables[table] else ""
            return f"{table}.csv: |{column}| is {values[k]:.3g}{when}, above the bound {most:.3g}"
    return ""


def not_at_end(tables, end):
    """Why the tables do not show a run to the end time, in words."""
    if end is None:
        return "" if any(len(next(iter(t.values()))) for t in tables.values() if t) else "it wrote no rows"
    last = [t["t"].max() for name, t in tables.items() if name in ("fluid", "motion", "particles") and len(t["t"])]
    if not last:
        return "it wrote no rows"
    return "" if max(last) >= end * (1 - 1e-6) else f"its rows end at t = {max(last):.6g} of {end:g}"


def scale_of(budget, start):
    """The largest sum of start and work, J/m."""
    return max((start + budget["work"]).max(), start, 1e-300)


def excess(budget, start):
    """Largest excess of the kinetic energy, and of it with the dissipation, over the energy at the start and the work; and of the
    kinetic energy over that of any earlier row and the work since: each over the largest sum of start and work."""
    kinetic, given, spent = budget["kinetic_energy"], start + budget["work"], budget["dissipated"]
    scale = scale_of(budget, start)
    since = kinetic - given
    gains = since - np.minimum.accumulate(since)
    return since.max() / scale, (since + spent).max() / scale, gains.max() / scale


def created(tables, start):
    """Energy that nothing supplied, in words."""
    if start is None:
        return ""
    whole, with_losses, later = excess(tables["budget"], start)
    if whole > KINETIC:
        return f"budget.csv: the kinetic energy exceeds work and energy at the start by {whole:.2g} of them"
    if later > LATER:
        return f"budget.csv: the kinetic energy gains {later:.2g} of work and energy at the start that the work since does not cover"
    if with_losses > LOSSES:
        return f"budget.csv: kinetic energy and dissipation exceed work and energy at the start by {with_losses:.2g} of them"
    rest = tables["budget"]["numerical"].min() / scale_of(tables["budget"], start)
    return f"budget.csv: the numerical dissipation is {rest:.2g} of work and energy at the start" if rest < -CLOSED else ""


def overlapping(run, table, checks):
    """(deepest overlap in radii, what is wrong in words)."""
    segments = solid_segments(run, checks.period)
    shapes = aspects(run, table)
    pair, at, i, j = pair_overlap(table, checks.period, shapes)
    wall, row = wall_overlap(table, segments, checks.period, shapes)
    depth = max(pair, wall)
    for name, (low, high) in checks.within.items():
        out = np.flatnonzero((table[name] < low) | (table[name] > high))
        if len(out):
            return depth, f"particle {table['id'][out[0]]:.0f} is at {name} = {table[name][out[0]]:.4g} at t = {table['t'][out[0]]:.4g}, beyond where it can go"
    through = crossing(table, segments) if not any(checks.period) else None
    if through:
        return depth, f"particle {through[1]} has passed through a wall by t = {through[0]:.4g}"
    if depth <= checks.deepest:
        return depth, ""
    if pair >= wall:
        return depth, f"particles {i} and {j} overlap by {pair:.2g} radii at t = {table['t'][at]:.4g}"
    return depth, f"particle {table['id'][row]:.0f} overlaps a wall by {wall:.2g} radii at t = {table['t'][row]:.4g}"
