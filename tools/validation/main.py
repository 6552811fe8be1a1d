"""Compare runs with published and exact figures, and write one report of it.

    python -m tools.validate                   everything
    python -m tools.validate settling_disk     one case (also --case settling_disk; several: a b c)
    python -m tools.validate --list            what there is

Writes report.html and report.csv, headed by date, commit, host and versions, into --out
(default results/validation): case, quantity, source, target, measured, pass, CPU time,
figure. The runs go one by one, so that CPU times are measurements. A run that fails is a
row with its reason. The report is whole after each row, also if the rest is stopped.

Status 0: all pass; 1: something does not; 3: bad input.
"""
import inspect
from pathlib import Path

from tools.base.command import ROOT, BadInput, Parser, out_folder, positive
from tools.base.runner import freefem
from tools.validation import Context, discover
from tools.validation.report import heading, write_report


def chosen(found, names):
    """[(case, function)] of the modules and functions named, everything without a name."""
    known = [(module, one) for module, functions in found.items() for one in functions]
    if not names:
        return known
    picked = []
    for name in names:
        fits = [(module, one) for module, one in known if name in (module, one.__name__)]
        if not fits:
            raise BadInput(f"there is no comparison {name}; there are "
                           + ", ".join(dict.fromkeys(w for module, one in known for w in (module, one.__name__))))
        picked += [pair for pair in fits if pair not in picked]
    return picked


def rows_of(case, function, out, limit, say):
    """The rows of one comparison; what it raises becomes a row."""
    context = Context(case, out, limit, say)
    try:
        yield from function(context) or ()
    except Exception as problem:
        yield context.failed(function.__name__, "", float("nan"), f"{type(problem).__name__}: {problem}"
                             if not str(problem) or type(problem).__name__ != "Failed" else problem)


def validate(pairs, out, limit=None, say=print):
    """Run comparisons [(case, function)] and write the report; returns the rows."""
    out = Path(out).resolve()
    out.mkdir(parents=True, exist_ok=True)
    head, rows = heading(), []
    write_report(rows, head, out, whole=False)
    for case, function in pairs:
        for row in rows_of(case, function, out, limit, say):
            rows.append(row)
            outcome = "pass" if row.passed else "FAIL"
            got = f"{row.measured:.6g} (target {row.target:.6g}, {row.allowed})" if row.measured == row.measured else row.reason
            say(f"{row.case}: {outcome}  {row.quantity}: {got}")
            write_report(rows, head, out, whole=False)
    say(f"report: {write_report(rows, head, out)}")
    return rows


def parser(prog="python -m tools.validate", description=__doc__, folder="validation"):
    """The options; folder: the usual one, in results."""
    options = Parser(prog=prog, description=description)
    options.add_argument("names", nargs="*", metavar="CASE", help="comparisons (default: all)")
    options.add_argument("--case", action="append", default=[], metavar="NAME", help="a comparison by name")
    options.add_argument("--list", action="store_true", help="list the comparisons")
    options.add_argument("--out", type=out_folder, default=str(ROOT / "results" / folder), metavar="DIR",
        help=f"where the report goes (default results/{folder})")
    options.add_argument("--limit", type=positive, default=3600.0, metavar="S", help="most seconds of one run (default 3600)")
    return options


def main(words=None, found=None, **how):
    """0 if all pass, 1 if not. how: as parser() takes it."""
    given = parser(**how).parse_args(words)
    found = discover() if found is None else found
    pairs = chosen(found, given.names + given.case)
    if given.list:
        for case, one in pairs:
            print(f"{case:<24}{one.__name__:<28}{(inspect.getdoc(one) or '').splitlines()[0] if one.__doc__ else ''}")
        return 0
    freefem()
    rows = validate(pairs, given.out, given.limit, say=lambda line: print(line, flush=True))
    return 0 if rows and all(row.passed for row in rows) else 1
