"""Rows of the tables of a run at one time, and the step that a row belongs to."""
import numpy as np

NEAR = 1e-6  # of a time: rows this close are rows of that time


def step_length(run, time):
    """The length of the step that ended at a time, nan where the tables do not tell: column dt of fluid.csv, else -dt."""
    if run.has("fluid") and "dt" in run.fluid and len(run.fluid["t"]):
        k = int(np.argmin(abs(run.fluid["t"] - time)))
        return float(run.fluid["dt"][k]) if abs(run.fluid["t"][k] - time) <= NEAR * abs(time) else np.nan
    return run.parameter("-dt", np.nan)


def rows_of(table, time):
    """The rows of a table at a time, {column: values}; None where the table has none."""
    there = abs(table["t"] - time) <= NEAR * abs(time)
    return {name: column[there] for name, column in table.items()} if there.any() else None
