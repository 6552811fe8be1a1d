"""Runs on several processes, and the comparison of their folders with those of other runs; for tests."""
import os
import subprocess
from functools import lru_cache

import numpy as np
import pytest

from tests.conftest import ROOT, run_freefem
from tests.tables import numbers
from tools.base.ranks import MPI_ENVIRONMENT, launcher

LIMIT = 300  # s
NEAR = 1e-9  # of the largest value of a column; sums in another order make 1e-13 to 1e-11 of it
SMALL = 1e-5  # a column below this, in the units of the case, is itself rounding: the flux out of a closed box, a force by symmetry
ROUNDING = 1e-11  # what such a column may differ by: rounding of values of the order of one, in another order of sums


@lru_cache(maxsize=None)
def why_not():
    """One line where FreeFEM cannot run on two processes here, else empty."""
    from tools.setup.doctor import mpi_fault

    return mpi_fault()


def ranks(number, *words, check=True):
    """The CompletedProcess of ff-mpirun -np NUMBER WORDS in the root."""
    if why_not():
        pytest.skip(why_not())
    run = subprocess.run([launcher(), "-np", str(number), *map(str, words)], cwd=ROOT, env=os.environ | MPI_ENVIRONMENT,
        capture_output=True, text=True, errors="replace", timeout=LIMIT)
    assert not check or run.returncode == 0, run.stdout[-3000:] + run.stderr[-3000:]
    return run


def assert_near(one, many, near=NEAR):
    """The CSVs of two folders: the same rows, and values near each other (over the largest of a column); but for times of
    computing."""
    for path in sorted(one.glob("*.csv")):
        expected, got = numbers(one, path.name), numbers(many, path.name)
        assert expected.keys() == got.keys() and not path.name.startswith("times")
        for column, values in expected.items():
            if column.startswith("time_"):
                continue
            values, others = np.atleast_1d(values), np.atleast_1d(got[column])
            assert values.shape == others.shape, (path.name, column)
            largest = abs(values).max(initial=0)
            within = 1 if column == "iterations" else near*largest if largest > SMALL else ROUNDING
            np.testing.assert_allclose(others, values, rtol=0, atol=within, err_msg=f"{path.name} {column}")


def compare(number, folder, *words):
    """Runs on one process and on several, and compares; returns the folder of the latter."""
    run_freefem(*words, "-out", folder / "one")
    ranks(number, *words, "-out", folder / f"on{number}")
    assert_near(folder / "one", folder / f"on{number}")
    return folder / f"on{number}"


def assert_same(folder, other):
    for path in other.glob("*.csv"):
        if path.name != "fluid.csv":
            assert path.read_bytes() == (folder / path.name).read_bytes(), path.name
    got, expected = numbers(folder, "fluid.csv"), numbers(other, "fluid.csv")
    for column in expected:
        if not column.startswith("time_"):
            np.testing.assert_array_equal(got[column], expected[column], err_msg=column)
