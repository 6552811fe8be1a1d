"""python -m tools.compare_processes [-n 2] CASE.edp [options of the case]: one run on one process and on several, compared.

Prints a row of a table: the largest difference of the CSVs, each column's over its largest value (without columns of computing
times); memory of the largest process and the user CPU time of each, of both runs. A column that hardly differs from 0, as the flux
through a closed box, counts over 1e-5 of what its unit is in the run: of the domain's length, the largest speed and kinetic energy.
Processes that wait for each other compute meanwhile, so that CPU times of a busy machine are too long.

Exit statuses: 0; 1 where the tables differ in their rows or by more than 1e-6; 3 bad input, or a run that does not end well.
"""
import argparse
import csv
import tempfile
from pathlib import Path

import numpy as np

from tools.base.command import ROOT, BadInput, Parser, guarded, whole
from tools.base.expressions import PER_DEPTH, POWERS
from tools.base.ranks import run_on
from tools.base.run_folder import RunFolder

SMALL = 1e-5  # a column below this part of its unit in the run is itself rounding
MOST = 1e-6
SPEED, ENERGY = (1, -1, 0), (1, -2, 1)
DIRECTIONS = "nx", "ny", "nz"  # components of unit vectors


def tables_of(folder):
    """{name: {column: texts}} of the CSVs of a run folder."""
    found = {}
    for path in sorted(Path(folder).glob("*.csv")):
        head, *rows = csv.reader(open(path))
        found[path.name] = {column: [row[k] for row in rows] for k, column in enumerate(head)}
    return found


def units_of(folder, tables):
    """{column: what its unit is in the run}, where the unit is known: of powers of the length of the domain, of the largest
    speed and of the kinetic energy. Empty where nothing moves."""
    run, largest = RunFolder(folder), {SPEED: 0.0, ENERGY: 0.0}
    for columns in tables.values():
        for column, texts in columns.items():
            if (powers := POWERS.get(column)) in largest:
                largest[powers] = max(largest[powers], *map(abs, map(float, texts)), 0.0)
    if not largest[SPEED] > 0:
        return {}
    length, in_space = max(run.extent[len(run.extent) // 2:]), run.in_space
    time = length / largest[SPEED]

    def of(powers, mass=1.0):
        """A product of powers of length, time and mass."""
        return length**(powers[0] + (in_space and powers in PER_DEPTH)) * time**powers[1] * mass**powers[2]
    mass = largest[ENERGY] / of(ENERGY)
    return {column: of(powers, mass) for column, powers in POWERS.items()} | dict.fromkeys(DIRECTIONS, 1.0)


def difference(one, many):
    """Largest difference of the CSVs of two run folders, each column's over its largest value or SMALL of its unit; inf where
    tables, their columns or their rows differ."""
    here, there = tables_of(one), tables_of(many)
    if {name: list(table) for name, table in here.items()} != {name: list(table) for name, table in there.items()}:
        return float("inf")
    most, units = 0.0, units_of(one, here)
    for name, table in here.items():
        for column, texts in table.items():
            if column.startswith("time_"):
                continue
            others = there[name][column]
            if len(texts) != len(others):
                return float("inf")
            try:
                first, second = np.array(texts, float), np.array(others, float)
            except ValueError:  # words
                if texts != others:
                    return float("inf")
                continue
            number = np.isfinite(first)
            if not np.array_equal(first[~number], second[~number], equal_nan=True) or not np.isfinite(second[number]).all():
                return float("inf")
            if (apart := abs(first - second)[number].max(initial=0)) > 0:
                most = max(most, float(apart / max(abs(first[number]).max(), SMALL * units.get(column, 0.0), 1e-300)))
    return most


def main():
    parser = Parser(prog="python -m tools.compare_processes", description=__doc__)
    parser.add_argument("-n", type=whole(2), default=2, dest="processes", metavar="PROCESSES", help="number of processes (default "
        "2)")
    parser.add_argument("case", help="the case, a script of FreeFEM")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="options of the case, without -out")
    words = parser.parse_args()
    if not (ROOT / words.case).is_file():
        raise BadInput(f"there is no script {words.case}")
    with tempfile.TemporaryDirectory() as folder:
        one, many = Path(folder) / "one", Path(folder) / "many"
        alone = run_on(1, [words.case, *words.options, "-out", one])
        shared = run_on(words.processes, [words.case, *words.options, "-out", many])
        apart = difference(one, many)
    times = " and ".join(f"{time:.1f}" for time in shared.cpu_s)
    print(f"| {Path(words.case).stem} | {apart:.0e} | {alone.memory_mb:.0f} | {shared.memory_mb:.0f} | {alone.cpu_s[0]:.1f} | "
        f"{times} |")
    return 0 if apart <= MOST else 1


if __name__ == "__main__":
    guarded(main)
