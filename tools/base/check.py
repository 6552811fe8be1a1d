"""Compare the CSVs of a run with those of a reference run or with a reference table.

    python -m tools.check RUN REFERENCE --columns u v:1e-3 y:0:1e-6 --rtol 1e-6 --atol 0

RUN and REFERENCE are run folders or CSV files. A column may bring its own tolerances,
NAME:RTOL or NAME:RTOL:ATOL; a value passes where |got - expected| <= atol + rtol |expected|.
Without --columns every column that the reference has is compared, but for step counts,
dt, iterations, wall-clock times and gaps (of what touches they are rounding).

Rows are aligned by time, for each particle id and each label of the boundary by itself. Where the times differ, the
denser of the two is interpolated linearly at the times of the other, so the tolerance
must allow for the curvature between its rows. Contacts (columns i, j) are not
interpolated: a pair must have rows at the same times. The run must cover the times of
the reference but for less than one row at either end, and hold the same particles (--subset: more of them is
fine, and more times of a pair). A particle of which no value could be compared is a mismatch.

Status 0: all within tolerance; 1: a mismatch, the worst place named in words; 3: bad input.

In pytest:

    from tools.check import compare
    result = compare("results/mine", "tests/reference/mine.csv", ["y", "v:1e-3"])
    assert result, result
"""
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, Parser, non_negative
from tools.base.tables import read_table

TABLES = ("particles", "fluid", "contacts", "forces", "wallforces", "fluxes", "budget", "motion", "steps", "coupling", "entries",
    "exits")
KEYS = ("id", "label", "i", "j")  # columns that tell the rows of one time apart
NOT_COMPARED = ("step", "dt", "iterations", "gap", "worst_gap", "name")
SAME_TIME = 1e-9  # of the length of the run: times this close are one time


@dataclass
class Place:
    """One compared value: where, what came out, what was expected, what was allowed; excess: the
    difference over the tolerance, above 1 for a mismatch (not finite: inf)."""
    file: str
    column: str
    time: float
    who: str
    got: float
    expected: float
    allowed: float
    excess: float

    @property
    def rank(self):
        """What the worst place is chosen by: the excess, then the difference."""
        return self.excess, np.nan_to_num(abs(self.got - self.expected), nan=np.inf, posinf=np.inf)

    def __str__(self):
        who = f", {self.who}" if self.who else ""
        return (f"{self.file}, column {self.column} at t = {self.time:.9g}{who}: got {self.got:.12g}, expected "
                f"{self.expected:.12g}, difference {abs(self.got - self.expected):.3g}, tolerance {self.allowed:.3g}")


@dataclass(repr=False)
class Comparison:
    """The outcome: true if all is within tolerance; its text says the worst place."""
    compared: int = 0
    columns: list = field(default_factory=list)
    failed: int = 0
    worst: Place = None
    missing: list = field(default_factory=list)  # sentences on rows, ids and times that are not there

    def __bool__(self):
        return not self.failed and not self.missing

    def __str__(self):
        if self:
            text = f"match: {self.compared} values of {', '.join(self.columns)} within tolerance"
            if self.worst is not None and self.worst.excess > 0:
                text += f"; nearest to its tolerance ({100 * self.worst.excess:.3g} %) is {self.worst}"
            return text
        lines = ["mismatch: " + sentence for sentence in self.missing[:5]]
        if len(self.missing) > 5:
            lines.append(f"mismatch: and {len(self.missing) - 5} more of this kind")
        if self.failed:
            lines.append(f"mismatch: {self.failed} of {self.compared} values; the worst is {self.worst}")
        return "\n".join(lines)

    __repr__ = __str__  # what pytest shows of a failed assertion

    def take(self, file, column, times, who, got, expected, rtol, atol):
        """Count arrays of values, and keep their worst Place."""
        if not len(got):
            return
        self.columns += [column] if column not in self.columns else []
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            difference, allowed = np.abs(got - expected), atol + rtol * np.abs(expected)
            excess = np.where(difference == 0, 0.0, difference / allowed)
        # Equal infinities are a match no more than anything else that is not finite.
        excess = np.where(np.isfinite(difference), excess, np.inf)
        self.compared += len(got)
        self.failed += int(np.count_nonzero(excess > 1))
        k = np.lexsort((-np.arange(len(got)), np.nan_to_num(difference, nan=np.inf), excess))[-1]  # of equal ones the first
        place = Place(file, column, float(times[k]), who, float(got[k]), float(expected[k]), float(allowed[k]), float(excess[k]))
        if self.worst is None or place.rank > self.worst.rank:
            self.worst = place


def tolerances(columns, rtol, atol):
    """{name: (rtol, atol)} of a list such as ["u", "v:1e-3", "y:0:1e-6"] or of a dict
    {name: rtol or (rtol, atol)}; None stays None (every column)."""
    for name, value in (("rtol", rtol), ("atol", atol)):
        if not (np.isfinite(value) and value >= 0):
            raise BadInput(f"{name} must be a number of at least 0, not {value}")
    if columns is None:
        return None
    if isinstance(columns, dict):
        columns = [":".join([name, *map(repr, map(float, np.atleast_1d(value)))]) for name, value in columns.items()]
    wanted = {}
    for text in columns:
        name, *numbers = text.split(":")
        try:
            numbers = [float(number) for number in numbers]
            if not name or len(numbers) > 2 or not all(np.isfinite(n) and n >= 0 for n in numbers):
                raise ValueError
        except ValueError:
            raise BadInput(f"column '{text}' must be NAME, NAME:RTOL or NAME:RTOL:ATOL with numbers of at least 0") from None
        if name in wanted:
            raise BadInput(f"column {name} is given twice")
        wanted[name] = (*numbers, *(rtol, atol)[len(numbers):])
    if not wanted:
        raise BadInput("no column to compare is named")
    return wanted


def time_name(table, given=None):
    """The column of time: the given one, else t, else the first whose name starts with t_."""
    for name in [given] if given else ["t"] + [name for name in table if name.startswith("t_")]:
        if name in table:
            return name
    raise BadInput(f"no column of time ({given or 't'}) among {', '.join(table)}; --time names another")


def pairs_of_tables(run, reference, wanted):
    """[(file name for messages, run table, reference table)] to compare."""
    run, reference = Path(run), Path(reference)
    for path in (run, reference):
        if not path.exists():
            raise BadInput(f"there is no file or folder {path}")
    if reference.is_dir():
        names = [name for name in TABLES if (reference / f"{name}.csv").is_file()]
        if run.is_file():
            names = [run.stem] if run.stem in names else names[:1]
        if not names:
            raise BadInput(f"{reference} holds none of " + ", ".join(f"{name}.csv" for name in TABLES))
        references = {name: read_table(reference / f"{name}.csv", of_run=True) for name in names}
        if wanted is not None:
            references = {name: table for name, table in references.items() if set(wanted) & set(table)}
        pairs = []
        for name, table in references.items():
            path = run if run.is_file() else run / f"{name}.csv"
            if not path.is_file():
                raise BadInput(f"the run {run} has no {name}.csv to compare with the reference")
            pairs.append((path.name, read_table(path, of_run=run.is_dir()), table))
        return pairs
    table = read_table(reference)
    if run.is_file():
        return [(run.name, read_table(run), table)]
    needed = (set(wanted) if wanted is not None else set(table)) | (set(KEYS) & set(table))
    found = [(name, read_table(run / f"{name}.csv", of_run=True)) for name in TABLES if (run / f"{name}.csv").is_file()]
    if not found:
        raise BadInput(f"{run} is not a run folder: it holds none of " + ", ".join(f"{name}.csv" for name in TABLES))
    fits = [(name, one) for name, one in found if needed - set(one) <= {n for n in needed if n.startswith("t_")}]
    fits.sort(key=lambda pair: pair[0] != reference.stem)
    if not fits:
        raise BadInput(f"no CSV of {run} has all the columns {', '.join(sorted(needed))}")
    return [(f"{fits[0][0]}.csv", fits[0][1], table)]


def groups(table, keys, order_by, what):
    """{key: row numbers in order of time}; one group, key (), where there are no ids."""
    columns = [table[key] for key in keys]
    order = np.lexsort((table[order_by], *columns[::-1]))
    if columns:
        stacked = np.column_stack(columns)[order]
        new = np.flatnonzero(np.any(np.diff(stacked, axis=0) != 0, axis=1)) + 1
        parts = [part for part in np.split(order, new) if len(part)]
    else:
        parts = [order] if len(order) else []
    made = {}
    for rows in parts:
        times = table[order_by][rows]
        if not np.all(np.isfinite(times)):
            raise BadInput(f"{what}: the column {order_by} holds a value that is not finite")
        if np.any(np.diff(times) <= 0):
            at = times[1:][np.diff(times) <= 0][0]
            raise BadInput(f"{what}: two rows{words(keys, [c[rows[0]] for c in columns])} stand at {order_by} = {at:.9g}")
        made[tuple(float(column[rows[0]]) for column in columns)] = rows
    return made


def words(keys, values):
    """' of id 3' for keys and values, empty where there are none."""
    return " of " + ", ".join(f"{k} {v:g}" for k, v in zip(keys, values)) if keys else ""


def aligned(t_run, t_reference, slack, spacing):
    """The times to compare at, and those of the reference that the run does not cover.
    A particle enters and leaves between two rows, so less than one spacing of the run's
    rows may lack at either end."""
    covered = (t_reference >= t_run[0] - slack) & (t_reference <= t_run[-1] + slack)
    near = (t_reference > t_run[0] - spacing + slack) & (t_reference < t_run[-1] + spacing - slack)
    inside = (t_run >= t_reference[0] - slack) & (t_run <= t_reference[-1] + slack)
    coarser = 0 < np.count_nonzero(inside) < np.count_nonzero(covered)
    return (t_run[inside] if coarser else t_reference[covered]), t_reference[~covered & ~near]


def row_spacing(times):
    """The usual time between rows, 0 for a single one."""
    different = np.unique(times)
    return float(np.median(np.diff(different))) if len(different) > 1 else 0.0


def values_at(times, own_times, values, slack):
    """values at times: a row's own where it stands at that time, else linear between rows."""
    nearest = np.clip(np.searchsorted(own_times, times), 0, len(own_times) - 1)
    below = np.clip(nearest - 1, 0, None)
    nearest = np.where(abs(own_times[below] - times) <= abs(own_times[nearest] - times), below, nearest)
    exact = abs(own_times[nearest] - times) <= slack
    return np.where(exact, values[nearest], np.interp(times, own_times, values))


def compare_tables(result, name, run, reference, wanted, time=None, subset=False, rtol=1e-6, atol=0.0):
    """Compare two tables, adding to a Comparison."""
    t_run, t_ref = time_name(run, time), time_name(reference, time)
    keys = [key for key in KEYS if key in reference]
    pairwise = "i" in keys and "j" in keys
    if wanted is None:
        skip = {t_run, t_ref, *keys, *NOT_COMPARED}
        wanted = {column: (rtol, atol) for column in reference if column not in skip and not column.startswith("time_")}
    wanted = {column: both for column, both in wanted.items() if column in reference}
    for column in [*keys, *wanted]:
        if column not in run:
            raise BadInput(f"{name} of the run has no column {column}; it has {', '.join(run)}")
    got, expected = groups(run, keys, t_run, f"the run's {name}"), groups(reference, keys, t_ref, f"the reference of {name}")
    if not expected:
        if got and not subset:
            result.missing.append(f"{name}: the reference has no rows, the run has {len(run[t_run])}")
        return
    every = reference[t_ref]
    slack = SAME_TIME * max(np.ptp(every), abs(every).max(), 1e-300)
    spacing = row_spacing(run[t_run])
    for key, rows in expected.items():
        who = ", ".join(f"{k} {v:g}" for k, v in zip(keys, key))
        if key not in got:
            result.missing.append(f"{name}: the run has no row{words(keys, key)}" if keys else f"{name}: the run has no rows")
            continue
        mine = got[key]
        tr, te = run[t_run][mine], reference[t_ref][rows]
        if pairwise:
            covered = np.array([np.min(abs(tr - one)) <= slack for one in te])
            times, absent = te[covered], te[~covered]
            more = np.array([one for one in tr if np.min(abs(te - one)) > slack])
            if len(more) and not subset:
                result.missing.append(f"{name}: the run has rows{words(keys, key)} at t = {more[0]:.9g}"
                                      + (f" and {len(more) - 1} other times" if len(more) > 1 else "")
                                      + ", the reference has none there (--subset allows it)")
        else:
            times, absent = aligned(tr, te, slack, spacing)
        if len(absent):
            result.missing.append(f"{name}: the run{words(keys, key)} has nothing at t = {absent[0]:.9g}"
                                  + (f" and {len(absent) - 1} other times" if len(absent) > 1 else "")
                                  + f" of the reference (its rows go from {tr[0]:.9g} to {tr[-1]:.9g})")
        elif not len(times):
            result.missing.append(f"{name}: no value{words(keys, key)} could be compared: its rows in the run go from "
                f"{tr[0]:.9g} to "
                                  f"{tr[-1]:.9g}, in the reference from {te[0]:.9g} to {te[-1]:.9g}")
        for column, (relative, absolute) in wanted.items():
            is_ = values_at(times, tr, run[column][mine], slack)
            should = values_at(times, te, reference[column][rows], slack)
            result.take(name, column, times, who, is_, should, relative, absolute)
    if not subset:
        for key in got:
            if key not in expected:
                result.missing.append(f"{name}: the run has rows{words(keys, key)}, the reference has none (--subset allows it)")


def compare(run, reference, columns=None, rtol=1e-6, atol=0.0, time=None, subset=False):
    """Compare run folders or CSV files; returns a Comparison (true if all is within tolerance).

    columns: ["u", "v:1e-3", "y:0:1e-6"], or {"v": 1e-3, "y": (0, 1e-6)}, or None for all.
    rtol, atol: the tolerances of columns that bring none. Raises BadInput."""
    wanted = tolerances(columns, rtol, atol)
    result = Comparison()
    lost = set(wanted or ())
    for name, mine, other in pairs_of_tables(run, reference, wanted):
        compare_tables(result, name, mine, other, wanted, time, subset, rtol, atol)
        lost -= set(other)
    if lost:
        raise BadInput(f"the reference {reference} has no column {sorted(lost)[0]}")
    if not result.compared and not result.missing:
        raise BadInput(f"nothing to compare: {run} and {reference} share no values")
    return result


def parser():
    """The options."""
    options = Parser(prog="python -m tools.check", description=__doc__)
    options.add_argument("run", help="run folder or CSV file to judge")
    options.add_argument("reference", help="run folder or CSV file to judge it by")
    options.add_argument("--columns", nargs="+", metavar="NAME[:RTOL[:ATOL]]", help="columns (default: all of the reference)")
    options.add_argument("--rtol", type=non_negative, default=1e-6, help="relative tolerance (default 1e-6)")
    options.add_argument("--atol", type=non_negative, default=0.0, help="absolute tolerance, in the column's unit (default 0)")
    options.add_argument("--time", metavar="NAME", help="the column to align by (default t, else the first t_...)")
    options.add_argument("--subset", action="store_true", help="the run may hold particles, and times of a pair, that the "
        "reference has not")
    return options


def main(words=None):
    """0 on a match, 1 on a mismatch."""
    given = parser().parse_args(words)
    result = compare(given.run, given.reference, given.columns, given.rtol, given.atol, given.time, given.subset)
    print(result)
    return 0 if result else 1
