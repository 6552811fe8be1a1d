"""Steady flows, laminar and of the turbulence model, against exact, measured and published figures: those of tools.validate, by the
name of the run.

    python -m tools.validate_steady [--only WORD] [--out FOLDER]

Writes report.html and report.csv, as python -m tools.validate does, into FOLDER (default
results/validate_steady). Status 0: all pass; 1: something does not; 3: bad input.
"""
import csv
import math
from functools import partial, update_wrapper

from tools.base.command import ROOT, BadInput, Parser, out_folder
from tools.base.runner import freefem
from tools.validation import Failed
from tools.validation.main import validate

KIM = [("reattachment_over_height", "standard k-epsilon, published: 5 to 6.25", 5, 6.25), ("reattachment_over_height",
    "measured: 7 +- 1 (Kim et al. 1980)", 6, 8)]
CHANNEL, STEP, LOSS, PIPE = (f"cases/{name}.edp" for name in ("turbulent_channel", "turbulent_step", "diaphragm_loss", "pipe_flow"))
STANDARD = {"-model": "k-epsilon"}
# What OpenFOAM computes too (tests/reference/turbulence_openfoam.csv).
OPENFOAM = {"step": (STEP, {"-size": 0.03125}), "driver": (STEP, {"-size": 0.0625, "-ratio": 1.125, "-reynolds": 37500}),
    "pipe": (PIPE, {}),
            "slit_0.2": (LOSS, {"-opening": 0.2, "-cells": 16}), "slit_0.5": (LOSS, {"-opening": 0.5, "-cells": 32})}


def openfoam(name):
    """[(quantity, source, low, high)] of a flow."""
    lines = (ROOT / "tests" / "reference" / "turbulence_openfoam.csv").read_text(encoding="utf-8").splitlines()
    rows = [row for row in csv.DictReader(line for line in lines if not line.startswith("#")) if row["run"] == name]
    return [(row["quantity"], f"OpenFOAM; same model; within {100 * float(row['within']):g} %",
        *(float(row["value"]) * (1 + sign * float(row["within"])) for sign in (-1, 1)))
            for row in rows]


# name, script, options, [(quantity of results.csv, source, low, high)]
RUNS = [
    ("poiseuille", CHANNEL, {"-model": "laminar", "-retau": 20, "-cells": 8}, [("velocity_error", "exact", 0, 1e-9)]),
    ("hagen_poiseuille", CHANNEL, {"-model": "laminar", "-retau": 20, "-cells": 8, "-axisymmetric": 1},
        [("velocity_error", "exact", 0, 1e-9)]),
    *[(f"channel_retau_{re}_cells_{n}", CHANNEL, {"-retau": re, "-cells": n},
       [("friction_error_nearer", "Dean or Prandtl and Karman, the nearer", -0.05, 0.05), ("friction_error_direct",
           "direct simulation; Lee & Moser 2015", -0.05, 0.05), ("log_law_worst", "logarithmic law", 0, 0.05)])
      for re in (2000, 5000) for n in (20, 40, 80)],
    *[(f"pipe_retau_{re}", CHANNEL, {"-retau": re, "-cells": 40, "-axisymmetric": 1},
        [("friction_error", "Prandtl's law for smooth pipes", -0.05, 0.05)])
      for re in (1000, 5000, 20000)],
    *[(f"step_kim_1980_size_{size}", STEP, {"-size": size}, KIM) for size in (0.125, 0.0625)],
    ("step_kim_1980_long_inlet", STEP, {"-size": 0.125, "-inlet": 80}, KIM),
    ("step_driver_seegmiller_1985", STEP, {"-size": 0.125, "-ratio": 1.125, "-reynolds": 37500},
     [("reattachment_over_height", "standard k-epsilon, published: 4.9 to 6 (measured: 6.26)", 4.9, 6)]),
    *[(f"diaphragm_{opening}_cells_{n}", LOSS, {"-opening": opening, "-cells": n},
       [("contraction", "von Mises 1917, within 5 %", 0.95 * contraction, 1.05 * contraction), ("loss_over_borda_carnot",
           "Borda and Carnot, within 10 %", 0.9, 1.1)])
      for opening, contraction, n in ((0.2, 0.616, 16), (0.5, 0.644, 10), (0.5, 0.644, 16))],
    *[(f"{name}_as_openfoam", script, STANDARD | options, openfoam(name)) for name, (script, options) in OPENFOAM.items()],
    ("pipe_of_the_paper_laminar", PIPE, {"-model": "laminar", "-reynolds": 100},
     [("residual", "asked for", 0, 1e-6), ("factorisations", "asked for", 0, 10), ("flux_defect", "conservation", -1e-6, 1e-6)]),
    ("pipe_of_the_paper", PIPE, {},
     [("residual", "asked for", 0, 1e-6), ("cpu_time", "asked for", 0, 180), ("flux_defect", "conservation", -1e-3, 1e-3)]),
]


def judged(context, run):
    """The rows of one run."""
    name, script, options, targets = run
    quantities = [(f"{name.replace('_', ' ')}: {quantity.replace('_', ' ')}", *rest) for quantity, *rest in targets]
    try:
        done = context.run(script, options, name)
        found = done.folder.results
    except (Failed, BadInput) as problem:
        for label, source, _, _ in quantities:
            yield context.failed(label, source, math.nan, problem)
        return
    for (label, source, low, high), (quantity, *_) in zip(quantities, targets):
        yield context.row(label, source, math.nan, found.get(quantity, math.nan), between=(low, high), cpu_s=done.cpu_s,
                          reason="" if quantity in found else f"results.csv has no {quantity}")


def turbulence(context):
    """Channel and pipe friction, steps, diaphragms, the pipe of the paper: k-epsilon with wall functions."""
    for run in RUNS:
        yield from judged(context, run)


def comparison(run):
    """One run as a comparison of tools.validate."""
    return update_wrapper(partial(judged, run=run), judged)


def main(words=None):
    """0 if all pass, 1 if not."""
    parser = Parser(prog="python -m tools.validate_steady", description=__doc__)
    parser.add_argument("--only", metavar="WORD", default="", help="runs whose name holds this word")
    parser.add_argument("--out", type=out_folder, metavar="FOLDER", default=str(ROOT / "results" / "validate_steady"),
        help="folder (default results/validate_steady)")
    given = parser.parse_args(words)
    chosen = [run for run in RUNS if given.only in run[0]]
    if not chosen:
        raise BadInput(f"no run has '{given.only}' in its name: " + ", ".join(run[0] for run in RUNS))
    freefem()
    rows = validate([("flow", comparison(run)) for run in chosen], given.out, say=lambda line: print(line, flush=True))
    return 0 if all(row.passed for row in rows) else 1
