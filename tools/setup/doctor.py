"""python -m tools.doctor: versions, FreeFEM's plug-ins, and a check of each linear solver.

Every plug-in that a script of the project loads is tried, and one small system is solved
with each solver the project uses (tools/setup/doctor.edp); its residual must be below 1e-8. FreeFEM takes
another solver without a word for one that it lacks: its own messages must name the solver asked for.
The last line says whether FreeFEM runs on several processes (ff-mpirun).
Environment: FREEFEM names the program (default FreeFem++).

Exit statuses: 0 all is well, 1 something is missing or a residual is too large, 3 bad
option.
"""
import os
import platform
import re
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

from tools.base.command import ROOT, BadInput, Parser
from tools.base.ranks import MPI_ENVIRONMENT, launcher
from tools.base.runner import freefem, freefem_version, run_text

SOLVERS = ["UMFPACK", "CHOLMOD", "CG", "MUMPS"]
LARGEST_RESIDUAL = 1e-8
USUAL_PLUGINS = {"MUMPS_seq", "iovtk"}
MPI_LIMIT = 60  # s


def plugins_loaded():
    """Names in the load statements of the project's scripts."""
    names = set(USUAL_PLUGINS)
    for folder in ("cases", "scripts", "lib", "tools", "tests"):
        for file in (ROOT / folder).rglob("*.[ei]d[p]"):
            names |= set(re.findall(r'^\s*load\s+"([^"]+)"', file.read_text(), flags=re.M))
    return sorted(names)


def blas_of(program):
    """The BLAS library that a program is linked to, links followed; '?' if that cannot be told."""
    try:
        lines = subprocess.run(["ldd", program], capture_output=True, text=True).stdout
    except OSError:
        return "?"
    found = re.search(r"libblas\S* => (\S+)", lines) or re.search(r"libopenblas\S* => (\S+)", lines)
    return os.path.realpath(found.group(1)) if found else "?"


def pinned_packages():
    """(name, pinned version, installed version or None) of tools/setup/requirements.txt for this Python."""
    modern = sys.version_info >= (3, 11)
    for line in (ROOT / "tools" / "setup" / "requirements.txt").read_text().splitlines():
        pin = re.match(r"([A-Za-z0-9_-]+)==([^;\s]+)", line)
        if not pin or ("<" in line and modern) or (">=" in line and not modern):
            continue
        try:
            installed = metadata.version(pin.group(1))
        except metadata.PackageNotFoundError:
            installed = None
        yield pin.group(1), pin.group(2), installed


def check_freefem(tell):
    try:
        program, version = freefem(), freefem_version()
    except BadInput as problem:
        return tell(False, str(problem))
    if not version:
        return tell(False, f"{program} does not run")
    tell(float(version[:3]) >= 4.0, f"FreeFEM {version} ({program}); BLAS {blas_of(program)}")
    there = run_text('include "getARGV.idp"').ok
    return tell(there, "FreeFEM's own includes (getARGV.idp)" + ("" if there else " are not found: see freefem++.pref"))


def check_plugins(tell):
    for name in plugins_loaded():
        there = run_text(f'load "{name}"').ok
        tell(there, f"plug-in {name}" + ("" if there else " is not found: see freefem++.pref and the package libfreefem++"))


def answers(log):
    """{solver asked for: (solver that FreeFEM found, empty where it says nothing; residual)} of the output of
    tools/setup/doctor.edp."""
    parts = re.findall(r"^asked (\S+)$(.*?)^residual \S+ (\S+)$", log, flags=re.M | re.S)
    return {name: ((re.findall(r"Find solver (\S+)", said) or [""])[-1], float(residual)) for name, said, residual in parts}


def check_solvers(tell):
    mumps = run_text('load "MUMPS_seq"').ok
    done = run_text(("macro doctorMumps()1// EOM\n" if mumps else "") + 'include "tools/setup/doctor.edp"')
    found = answers(done.log)
    for name in SOLVERS:
        if name not in found:
            tell(False, f"solver {name}: no answer (FreeFem++ ended with status {done.status})")
            continue
        used, residual = found[name]
        if used.startswith(name) or not used:
            tell(residual < LARGEST_RESIDUAL, f"solver {name}: relative residual {residual:g}")
        else:
            tell(False, f"solver {name}: FreeFEM has none, and takes {used} for it")


def mpi_fault():
    """One line where FreeFEM cannot run on two processes here, else empty: ff-mpirun must start them, and their sum be right."""
    try:
        program = launcher()
    except BadInput as problem:
        return str(problem)
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "two.edp"
        script.write_text('load "metis"\nreal own = mpirank + 1, all = 0;\nmpiAllReduce(own, all, mpiCommWorld, mpiSUM);\n'
            'if (mpirank == 0) cout << "sum of " << mpisize << ": " << all << endl;\n')
        try:
            done = subprocess.run([program, "-np", "2", str(script)], cwd=ROOT, env=os.environ | MPI_ENVIRONMENT,
                capture_output=True, text=True, errors="replace", timeout=MPI_LIMIT)
        except (OSError, subprocess.TimeoutExpired) as problem:
            return f"ff-mpirun does not run: {type(problem).__name__}"
    if done.returncode or "sum of 2: 3" not in done.stdout:
        return f"ff-mpirun -np 2 ended with status {done.returncode} and without the sum of two processes"
    return ""


def check_mpi(tell):
    """Several processes are an offer, not a need: what is missing is said, and is no failure."""
    fault = mpi_fault()
    tell(True, f"several processes: {'not here: ' + fault if fault else 'ff-mpirun -np 2 works'}")


def check_python(tell):
    tell(sys.version_info >= (3, 10), f"Python {platform.python_version()} on {platform.platform()}, {os.cpu_count()} cores")
    for name, pinned, installed in pinned_packages():
        same = installed == pinned
        tell(same, f"{name} {installed or 'is missing'}" + ("" if same else f" (pinned: {pinned}): make setup installs it"))


def main():
    Parser(prog="python -m tools.doctor", description=__doc__).parse_args()
    verdicts = []

    def tell(good, words):
        verdicts.append(bool(good))
        print(f"{'ok     ' if good else 'FAILED '} {words}", flush=True)
        return good

    check_python(tell)
    if check_freefem(tell) is not False:
        check_plugins(tell)
        check_solvers(tell)
        check_mpi(tell)
    bad = verdicts.count(False)
    print("all is well" if not bad else f"{bad} of {len(verdicts)} checks failed")
    return 1 if bad else 0
