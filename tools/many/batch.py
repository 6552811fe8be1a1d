"""The script of an array job, each task of which makes one run of a sweep."""
import os
import shlex
import sys
from pathlib import Path

from tools.base.command import ROOT, BadInput
from tools.base.tables import write_text

SLURM = """#!/bin/sh
# Runs a sweep as an array job: sbatch {file}
# After it, the same command without --batch makes the tables and the picture (with --collect: of what is there by then):
#   cd {root} && {again}
#SBATCH --job-name={name}
#SBATCH --array=1-{number}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --output={out}/slurm_%a.log
# Add what your cluster asks for, as --time, --mem, --partition and --account, and modules that FreeFEM needs.
cd {root} || exit
{freefem}exec {command} --task "$SLURM_ARRAY_TASK_ID"{rest}
"""


def write(sweep, system, file):
    """Writes the script; returns a line on it. Raises BadInput for another system."""
    if system != "slurm":
        raise BadInput(f"--batch knows slurm, not {system}")
    path = Path(file).resolve()
    own = [str(ROOT / sweep.script), "--vary", *(f"{name}={','.join(texts)}" for name, texts in sweep.vary.items()), "--quantity",
        *sweep.quantities]
    for option, values in (("--over", sweep.over), ("--quantities", [str(Path(one).resolve()) for one in sweep.own]),
        ("--limit", [f"{sweep.limit:.12g}"] if sweep.limit else [])):
        own += [option, *values] if values else []
    command = [sys.executable, "-m", "tools.sweep", *own, *(["--retry"] if sweep.retry else []), "--out", str(sweep.out)]
    rest = ["--", *(word for pair in sweep.options.items() for word in pair)] if sweep.options else []
    sweep.out.mkdir(parents=True, exist_ok=True)
    freefem = os.environ.get("FREEFEM")
    write_text(path, SLURM.format(file=shlex.quote(str(path)), root=shlex.quote(str(ROOT)), again=shlex.join([*command, *rest]),
        name=f"sweep_{sweep.case}", number=len(sweep.points), out=sweep.out, command=shlex.join(command),
        rest=f" {shlex.join(rest)}" if rest else "", freefem=f"export FREEFEM={shlex.quote(freefem)}\n" if freefem else ""))
    return f"{path}: {len(sweep.points)} runs; submit it with sbatch, then run the same command without --batch for the tables"
