"""The tables of a sweep: a row per run, and means with standard errors."""
import math
import os

import numpy as np

from tools.base.tables import write_table
from tools.many.plan import value_of

COST = ["cpu_s", "wall_s", "memory_mib"]


def state(record):
    """finished, killed (by a signal), stopped (before its end), failed, or missing."""
    status = record["status"]
    if status == 0:
        return "stopped" if record["reason"] else "finished"
    if not record.get("key"):
        return "failed" if status > 0 else "missing"
    return "killed" if status < 0 else "failed"


def reason(record):
    """One line on why a run, or a quantity of it, has no value."""
    return record["reason"] or "; ".join(f"{name}: {why}" for name, (_, why) in record["values"].items() if why)


def write_sweep(sweep, points, records):
    """sweep.csv, whole at any time."""
    names = [*sweep.vary, "status", "exit_status", *sweep.quantities, *COST, "reason", "commit", "run"]
    write_table(sweep.out / "sweep.csv", names, [[*point.values(), state(one), one["status"],
        *(one["values"][name][0] for name in sweep.quantities), *(one[name] for name in COST), reason(one), one["commit"],
        os.path.relpath(one["run"], sweep.out)] for point, one in zip(points, records)])


def means(sweep, records):
    """[(point without the parameters of sweep.over, {quantity: values that there are}, number of runs)], in order."""
    found = {}
    for point, record in zip(sweep.points, records):
        rest = {name: value for name, value in point.items() if name not in sweep.over}
        _, values, number = found.setdefault(tuple(rest.values()), (rest, {name: [] for name in sweep.quantities}, []))
        number.append(1)
        for name in sweep.quantities:
            if math.isfinite(record["values"][name][0]):
                values[name].append(record["values"][name][0])
    return [(rest, values, len(number)) for rest, values, number in found.values()]


def mean_and_error(values):
    """(mean, standard error of it), nan where there are too few values."""
    mean = float(np.mean(values)) if values else math.nan
    return mean, float(np.std(values, ddof=1) / math.sqrt(len(values))) if len(values) > 1 else math.nan


def write_means(sweep, records):
    """means.csv: of each point mean, standard error and number of values of each quantity."""
    kept = [name for name in sweep.vary if name not in sweep.over]
    names = [*kept, "runs", *(f"{name} {what}" for name in sweep.quantities for what in ("mean", "standard error", "number"))]
    rows = [[*rest.values(), number, *(cell for name in sweep.quantities for cell in (*mean_and_error(values[name]),
        len(values[name])))] for rest, values, number in means(sweep, records)]
    write_table(sweep.out / "means.csv", names, rows)


def is_number(texts):
    """Whether all of the texts are numbers."""
    return all(isinstance(value_of(text), float) for text in texts)
