"""Several processes: the launcher of FreeFEM's own MPI, and runs whose processes are measured."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tools.base.command import ROOT, BadInput
from tools.base.quick_clock import with_quick_clock
from tools.base.runner import freefem

# One thread each for the BLAS. Open MPI refuses the administrator and more processes than cores unless it is told so; containers
# have no other user. Where a process ends with a status, Open MPI adds ten lines to the one that says why, unless it is quiet. One
# that ends alone waits for the others, which wait for it, unless its end is asynchronous: then its status is that of all.
MPI_ENVIRONMENT = {"OPENBLAS_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_orte_execute_quiet": "1", "OMPI_MCA_async_mpi_finalize": "1"}
# Outside the job of a batch system all processes are on this machine, and Open MPI need not look for networks first (0.2 s).
ELSEWHERE = "SLURM_JOB_ID", "PBS_NODEFILE", "PBS_JOBID", "LSB_HOSTS", "LSB_JOBID", "JOB_ID", "OMPI_MCA_orte_default_hostfile"
if not any(name in os.environ for name in ELSEWHERE):
    MPI_ENVIRONMENT["OMPI_MCA_pml"] = "ob1"
# Runs a command, and appends its peak memory (KiB) and user CPU time (s) to a file.
WRAPPER = ("import resource, subprocess, sys; status = subprocess.call(sys.argv[2:]); "
    "used = resource.getrusage(resource.RUSAGE_CHILDREN); open(sys.argv[1], 'a').write(f'{used.ru_maxrss} {used.ru_utime}\\n'); "
    "sys.exit(status if status >= 0 else 128 - status)")


@dataclass
class Shared:
    """A run on several processes: peak memory of the largest (MiB), user CPU time of each (s), wall clock (s), what it printed."""
    memory_mb: float
    cpu_s: list
    wall_s: float
    log: str


def launcher():
    """The path of ff-mpirun beside FreeFem++, or of the first on the search path. Raises BadInput where there is none."""
    beside = Path(freefem()).with_name("ff-mpirun")
    found = str(beside) if beside.is_file() else shutil.which("ff-mpirun")
    if not found:
        raise BadInput("several processes need ff-mpirun, which comes with FreeFEM where that was built with MPI; python -m "
            "tools.doctor says more")
    return found


def run_on(processes, words, cwd=ROOT, limit=None):
    """The Shared of a run of a script and its options (words) on 1 or more processes: one by plain FreeFem++. limit: most
    seconds. Raises BadInput where it fails."""
    with tempfile.NamedTemporaryFile("r") as notes:
        wrapped = [sys.executable, "-c", WRAPPER, notes.name]
        if processes == 1:
            command = [*wrapped, freefem(), "-nw"]
        else:
            engine = Path(launcher()).with_name("FreeFem++-mpi")
            start = shutil.which("mpiexec") or shutil.which("mpirun")
            if not start:
                raise BadInput("there is no mpiexec on the search path")
            command = [start, "-np", str(processes), *wrapped, str(engine), "-nw"]
        begin = time.perf_counter()
        try:
            done = subprocess.run([*command, *map(str, words)], cwd=cwd, env=with_quick_clock(os.environ | MPI_ENVIRONMENT),
                capture_output=True, text=True, errors="replace", timeout=limit)
        except subprocess.TimeoutExpired:
            raise BadInput(f"the run on {processes} was stopped at its limit of {limit:g} s") from None
        wall = time.perf_counter() - begin
        if done.returncode:
            said = re.findall(r"^error: (.*)", done.stderr + done.stdout, flags=re.M)
            raise BadInput(f"the run on {processes} ended with status {done.returncode}" + (f": {said[0]}" if said else ""))
        rows = [list(map(float, line.split())) for line in notes.read().splitlines()]
    return Shared(max(row[0] for row in rows) / 1024, [row[1] for row in rows], wall, done.stdout)
