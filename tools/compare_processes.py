"""python -m tools.compare_processes [-n 2] CASE.edp [options of the case]: one run on one process and on several, compared.

Prints a row of a table: the largest difference of the CSVs, each column's over its largest value (without columns of computing
times, and of values below 1e-5, which are rounding); memory of the largest process and the user CPU time of each, of both runs.
Processes that wait for each other compute meanwhile, so that CPU times of a busy machine are too long.

Exit statuses: 0; 1 where the tables differ in their rows or by more than 1e-6; 3 bad input, or a run that does not end well.
"""
import argparse
import csv
import tempfile
from pathlib import Path

from tools.base.command import BadInput, Parser, guarded
from tools.base.ranks import run_on

SMALL = 1e-5  # a column below this, in the units of the case, is itself rounding
MOST = 1e-6


def difference(one, many):
    """Largest difference of the CSVs of two run folders, each column's over its largest value; inf where tables, their columns or
    their rows differ."""
    most = 0.0
    if {path.name for path in Path(one).glob("*.csv")} != {path.name for path in Path(many).glob("*.csv")}:
        return float("inf")
    for path in sorted(Path(one).glob("*.csv")):
        tables = [list(csv.DictReader(open(folder / path.name))) for folder in (Path(one), Path(many))]
        if len(tables[0]) != len(tables[1]) or tables[0] and list(tables[0][0]) != list(tables[1][0]):
            return float("inf")
        for column in tables[0][0] if tables[0] else ():
            if column.startswith("time_"):
                continue
            try:
                first, second = ([float(row[column]) for row in table] for table in tables)
            except ValueError:  # words
                if any(a[column] != b[column] for a, b in zip(*tables)):
                    return float("inf")
                continue
            largest = max(map(abs, first))
            if largest > SMALL:
                most = max(most, max(abs(a - b) for a, b in zip(first, second)) / largest)
    return most


def main():
    parser = Parser(prog="python -m tools.compare_processes", description=__doc__)
    parser.add_argument("-n", type=int, default=2, dest="processes", metavar="PROCESSES", help="number of processes (default: 2)")
    parser.add_argument("case", help="the case, a script of FreeFEM")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="options of the case, without -out")
    words = parser.parse_args()
    if words.processes < 2:
        raise BadInput(f"-n is a number of processes, at least 2, not {words.processes}")
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
