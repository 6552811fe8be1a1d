"""Steady flows against exact, measured and published figures: those of tools.validate, by the name of the run.

    python -m tools.validate_steady [--only WORD] [--out FOLDER]

Writes report.html and report.csv, as python -m tools.validate does, into FOLDER (default
results/validate_steady). Status 0: all pass; 1: something does not; 3: bad input.
"""
from functools import partial, update_wrapper

from tools.command import ROOT, BadInput, Parser, guarded, out_folder
from tools.runner import freefem
from tools.validate import validate
from tools.validation.turbulence import RUNS, judged


def comparison(run):
    """One run as a comparison of tools.validate."""
    return update_wrapper(partial(judged, run=run), judged)


def main(words=None):
    """0 if all pass, 1 if not."""
    parser = Parser(prog="python -m tools.validate_steady", description=__doc__)
    parser.add_argument("--only", metavar="WORD", default="", help="runs whose name holds this word")
    parser.add_argument("--out", type=out_folder, metavar="FOLDER", default=str(ROOT / "results" / "validate_steady"), help="folder (default results/validate_steady)")
    given = parser.parse_args(words)
    chosen = [run for run in RUNS if given.only in run[0]]
    if not chosen:
        raise BadInput(f"no run has '{given.only}' in its name: " + ", ".join(run[0] for run in RUNS))
    freefem()
    rows = validate([("flow", comparison(run)) for run in chosen], given.out, say=lambda line: print(line, flush=True))
    return 0 if all(row.passed for row in rows) else 1


if __name__ == "__main__":
    guarded(main)
