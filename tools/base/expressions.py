"""Numbers of a run's tables by expressions: TABLE.csv:COLUMN[:CONDITION...]:HOW, or TABLE.csv[:CONDITION...]:rows.

    particles.csv:y:id=3:last          y of particle 3 in its last row
    particles.csv:u:t=last:mean        mean of u over the rows of the last time
    fluid.csv:kinetic_energy:max       largest value of a column; the beginning of a name will do where no other column has it
    fluid.csv:pressure_drop:t>0.5:timemean
    exits.csv:rows                     how many rows
    results.csv:drag                   a number of a steady flow

CONDITION: COLUMN with one of = < > <= >= and a number, `first` or `last` (the value in the first or last row of the table). Rows
must meet all conditions. HOW: one of HOWS.
"""
import re

import numpy as np

from tools.base.command import BadInput

SAME = 1e-9  # of a value: what = takes for equal


def _time_mean(values, times):
    """Mean in time of the straight lines between rows."""
    if len(values) < 2 or not np.all(np.diff(times) > 0):
        raise ValueError("timemean needs two rows or more, each later than the one before (id=N selects a particle)")
    return float(np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(times)) / (times[-1] - times[0]))


HOWS = {"first": lambda v: v[0], "last": lambda v: v[-1], "min": np.min, "max": np.max, "mean": np.mean, "sum": np.sum,
    "std": lambda v: np.std(v, ddof=1) if len(v) > 1 else 0.0, "range": np.ptp, "timemean": None}
# what a column measures, as a product of powers of the units of length, time and mass
LENGTHS, SPEEDS = ("x", "y", "z", "radius", "gap", "worst_gap"), ("u", "v", "w", "top_speed", "divergence")
POWERS = {**dict.fromkeys(LENGTHS, (1, 0, 0)), **dict.fromkeys(SPEEDS, (1, -1, 0)), "t": (0, 1, 0), "dt": (0, 1, 0),
    **dict.fromkeys(("omega", "omega_x", "omega_y", "omega_z"), (0, -1, 0)), "kinetic_energy": (1, -2, 1),
    "potential_energy": (1, -2, 1), "pressure_drop": (-1, -2, 1), "flux_in": (2, -1, 0), "flux_out": (2, -1, 0), "flux": (2, -1, 0),
    "fx": (0, -2, 1), "fy": (0, -2, 1), "torque": (1, -2, 1), "impulse": (0, -1, 1)}
SI = {"length": "m", "time": "s", "mass": "kg"}
IN_SI = {(-1, -2, 1): "Pa", (1, -2, 1): "J/m", (0, -2, 1): "N/m", (0, -1, 1): "N s/m"}  # per unit of depth
PER_DEPTH = ((1, -2, 1), (0, -2, 1), (0, -1, 1), (2, -1, 0))  # energy, force, impulse, flux: of the whole in three dimensions
CONDITION = re.compile(r"(\w+)(<=|>=|=|<|>)(.+)")


def is_expression(text):
    """Whether the text is meant as an expression of this module."""
    return text.split(":")[0].endswith(".csv")


def parse(text):
    """The function of a RunFolder that an expression stands for. Raises BadInput where it is none; the function raises ValueError
    where a run does not have what it needs."""
    table, *words = text.split(":")
    name = table.removesuffix(".csv")
    if name == "results" and len(words) == 1 and words[0]:
        return lambda run: _result(run, words[0])
    if not re.fullmatch(r"[A-Za-z0-9_-]+", name) or not words:
        raise BadInput(f"'{text}' is no expression: TABLE.csv:COLUMN[:CONDITION...]:HOW, or TABLE.csv[:CONDITION...]:rows")
    how, column, rest = words[-1], None, words[:-1]
    if how != "rows":
        if how not in HOWS:
            raise BadInput(f"'{text}' ends with '{how}'; known are {', '.join(HOWS)} of a column, and rows")
        if not rest or CONDITION.fullmatch(rest[0]):
            raise BadInput(f"'{text}' names no column: TABLE.csv:COLUMN[:CONDITION...]:{how}")
        column, *rest = rest
    conditions = []
    for word in rest:
        found = CONDITION.fullmatch(word)
        try:
            if not found:
                raise ValueError
            value = found[3] if found[3] in ("first", "last") else float(found[3])
        except ValueError:
            raise BadInput(f"'{word}' in '{text}' is no condition such as id=3, t>0.5 or t=last") from None
        conditions.append((found[1], found[2], value))
    return lambda run: _value(run.table(name), table, column, conditions, how)


def _result(run, name):
    if name not in run.results:
        raise ValueError(f"results.csv has no {name}; it has {', '.join(run.results)}")
    return run.results[name]


def _named(columns, table, word):
    """The column of a name, or of the only name that begins so."""
    if word in columns:
        return word
    near = [name for name in columns if name.startswith(word)]
    if len(near) != 1:
        raise ValueError(f"{table} has no column {word}" + (f" (is it {' or '.join(near)}?)" if near else
            f"; it has {', '.join(columns)}"))
    return near[0]


def _value(columns, table, column, conditions, how):
    rows = np.ones(len(next(iter(columns.values()))), dtype=bool)
    for name, sign, value in conditions:
        values = columns[_named(columns, table, name)]
        if isinstance(value, str):
            if not len(values):
                raise ValueError(f"{table} has no rows")
            value = values[0 if value == "first" else -1]
        close = np.abs(values - value) <= SAME * abs(value)
        rows &= {"=": close, "<": (values < value) & ~close, ">": (values > value) & ~close, "<=": (values <= value) | close,
            ">=": (values >= value) | close}[sign]
    if how == "rows":
        return float(np.count_nonzero(rows))
    values = columns[_named(columns, table, column)][rows]
    if not len(values):
        raise ValueError(f"{table} has no rows" + (" that meet the conditions" if conditions else ""))
    if how == "timemean":
        return _time_mean(values, columns[_named(columns, table, "t")][rows])
    return float(HOWS[how](values))


def unit_of(text, run):
    """The unit of an expression's number in a run, empty where it has none or none is known."""
    table, *words = text.split(":")
    if table == "results.csv":
        return run.result_units.get(words[0], "") if words else ""
    if words[-1] == "rows":
        return ""
    near = [name for name in POWERS if name == words[0] or len(words[0]) > 2 and name.startswith(words[0])]
    return unit_in(POWERS[words[0] if words[0] in near else near[0]], run) if near else ""


def unit_in(powers, run):
    """Powers of length, time and mass in names of the units of a RunFolder; of a plane run some are per unit of depth."""
    if not (run.in_space and powers in PER_DEPTH):
        return product(powers, run.units)
    if run.units == SI and powers in IN_SI:
        return IN_SI[powers].removesuffix("/m")
    return product((powers[0] + 1, *powers[1:]), run.units)


def product(powers, units):
    """Powers of length, time and mass in names of units: cm/s, g/(cm s$^2$), Pa."""
    if units == SI and powers in IN_SI:
        return IN_SI[powers]
    pairs = list(zip((units["mass"], units["length"], units["time"]), (powers[2], powers[0], powers[1])))

    def words(some):
        return [name + (f"$^{abs(power)}$" if abs(power) > 1 else "") for name, power in some]
    above, below = words([pair for pair in pairs if pair[1] > 0]), words([pair for pair in pairs if pair[1] < 0])
    under = f"({' '.join(below)})" if len(below) > 1 else "".join(below)
    return (" ".join(above) or ("1" if below else "")) + (f"/{under}" if below else "")
