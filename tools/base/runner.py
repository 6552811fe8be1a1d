"""Run a FreeFEM script from a tool: its status, its cost, and why it failed in one line.

    done = run_case("cases/settling_disk.edp", {"-dt": 0.001}, out="results/x", limit=600)
    done.ok, done.reason, done.cpu_s, done.wall_s, done.memory_mb, done.log

Each run uses one thread, and the clock of tools/base/quick_clock.py. FREEFEM in the environment names another FreeFem++. Errors:
BadInput where FreeFEM or the script is not there; a run that fails is not an error.
"""
import concurrent.futures
import contextlib
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tools.base.command import ROOT, BadInput
from tools.base.quick_clock import with_quick_clock

MEASURE = Path(__file__).with_name("measure.py")
LIVE = set()  # the runs under way, for end_all
SOURCES = ("lib/**/*.idp", "scripts/*.edp", "scripts/*.idp")
NAMED = re.compile(r'"([^"\n]+\.(edp|idp|mesh|csv|msh|geo|step|stp|brep|txt|dat))"')  # files that a script speaks of
STATUSES = {1: "syntax error", 2: "a plug-in cannot be loaded", 3: "bad option or input file", 4: "solver failure",
            5: "inadmissible scene", 6: "assertion inside FreeFEM", 8: "error at run time"}


class Started:
    """A run under way; its process, once there is one."""
    process = None


class Stopped(Exception):
    """The run was ended by end_all; it says nothing of the case."""


@dataclass
class Done:
    """How a run ended. cpu_s: user and system time; memory_mb: peak resident size in MiB."""
    status: int
    reason: str
    cpu_s: float
    wall_s: float
    memory_mb: float
    log: str

    @property
    def ok(self):
        """True if the run ended with status 0."""
        return self.status == 0


def freefem():
    """The program that runs scripts."""
    name = os.environ.get("FREEFEM")
    found = shutil.which(name) if name else shutil.which("FreeFem++") or shutil.which("FreeFem++-nw")
    if not found:
        name = name or "FreeFem++"
        raise BadInput(f"the program {name} is not there: install FreeFEM (make setup) or name it in FREEFEM")
    return found


def option_words(options):
    """{"-dt": 0.001} as words of a command line; reals with all their digits."""
    words = []
    for name, value in options.items():
        words += [name, f"{value:.17g}" if isinstance(value, float) and value != float(f"{value:.12g}")
                  else f"{value:.12g}" if isinstance(value, float) else str(value)]
    return words


def named_files(script):
    """The files that a script, of FreeFEM or gmsh, names in quotes, from the root or beside it, and those that its includes name,
    however deep."""
    found, waiting = set(), [script]
    while waiting:
        path = waiting.pop()
        for name, kind in NAMED.findall(path.read_text(encoding="utf-8", errors="replace")):
            new = {file.resolve() for file in (ROOT / name, path.parent / name) if file.is_file()} - found
            found |= new
            waiting += new if kind in ("edp", "idp", "geo") else ()
    return found


def fingerprint(script, options):
    """What a run depends on, as a short hash: script, libraries, options, the contents of files that options and script name
    (its includes and theirs, its default mesh, the case that computes the flow it takes over), program."""
    files = {name: ROOT / str(value) for name, value in options.items() if (ROOT / str(value)).is_file()}
    words = [script, [(name, "" if name in files else str(value)) for name, value in sorted(options.items())], freefem()]
    sources = {path for pattern in SOURCES for path in ROOT.glob(pattern)}
    total = hashlib.sha256(json.dumps(words).encode())
    for path in [ROOT / script, *sorted(sources | named_files(ROOT / script)), *(files[name] for name in sorted(files))]:
        total.update(path.read_bytes())
    return total.hexdigest()[:20]


def run_case(script, options, out=None, limit=None, cwd=ROOT):
    """Run a script with options; `out`: its run folder, emptied of an earlier run first.
    limit: most wall-clock seconds, None for no end."""
    path = Path(cwd) / script
    if not path.is_file():
        raise BadInput(f"there is no script {script}")
    command = [freefem(), "-nw", str(script), *option_words(options)]
    if out is not None:
        shutil.rmtree(out, ignore_errors=True)
        Path(out).parent.mkdir(parents=True, exist_ok=True)
        command += ["-out", str(out)]
    return run_command(command, limit, cwd)


def run_command(command, limit=None, cwd=ROOT):
    """Run a command under measure.py, in a process group of its own that ends with it."""
    threads = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")}
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        report, log = Path(folder) / "cost", Path(folder) / "log"
        run = Started()
        LIVE.add(run)
        with open(log, "w") as stream:
            run.process = process = subprocess.Popen([sys.executable, "-I", "-S", str(MEASURE), str(report), *map(str, command)],
                                       cwd=cwd, stdout=stream, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                       env=with_quick_clock({**os.environ, **threads}), start_new_session=True)
            try:
                if run not in LIVE:  # end_all came while the process was being made
                    end_group(process)
                process.wait(limit)
                stopped = False
            except BaseException as problem:
                stopped = True
                end_group(process)
                if not isinstance(problem, subprocess.TimeoutExpired):
                    raise
            finally:
                ended_from_outside = run not in LIVE
                LIVE.discard(run)
            if ended_from_outside:
                raise Stopped
        text = log.read_text(errors="replace")
        if stopped:
            wall = time.perf_counter() - begin
            return Done(124, f"stopped at its limit of {limit:g} s", float("nan"), wall, float("nan"), text)
        if not report.is_file():
            last = (text.strip().splitlines() or ["no output"])[-1]
            return Done(process.returncode or 1, f"could not be started: {last}", float("nan"), float("nan"), float("nan"), text)
        status, cpu, wall, memory = report.read_text().split()
    status = int(status)
    return Done(status, why(status, text) if status else "", float(cpu), float(wall), float(memory), text)


def run_text(text, limit=120):
    """Run the text of a script in the root of the project."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "script.edp"
        script.write_text(text)
        return run_command([freefem(), "-nw", script], limit)


def make_mesh(words, path, limit=None):
    """The mesh file `path` of a recipe and its options (words), by tools.mesh. Raises BadInput with the reason."""
    path.parent.mkdir(parents=True, exist_ok=True)
    done = run_command([sys.executable, "-m", "tools.mesh", *words, "--out", path], limit)
    if not done.ok:
        raise BadInput(f"no mesh by tools.mesh {' '.join(map(str, words))}: {done.reason}")
    return path


def finished(done):
    """A run that ended well; BadInput with the reason of another."""
    if not done.ok:
        raise BadInput(done.reason)
    return done


def reported(done):
    """What a script of tools/peers reports: the last line in braces of its output. Raises BadInput where there is none."""
    lines = [line for line in finished(done).log.splitlines() if line.startswith("{")]
    if not lines:
        raise BadInput("no result")
    return json.loads(lines[-1])


def end_all():
    """End the runs that are under way in any thread of this process; they raise Stopped there."""
    for run in list(LIVE):
        LIVE.discard(run)
        if run.process:
            end_group(run.process)


@contextlib.contextmanager
def side_by_side(workers):
    """A pool of threads for runs. Whatever breaks in (an error, Ctrl-C) drops what waits and ends what runs; what has ended
    stays."""
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            end_all()
            raise


def end_group(process):
    """End the process that was started here, and its children."""
    for how in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(process.pid, how)
            process.wait(3)
        except (ProcessLookupError, subprocess.TimeoutExpired):
            continue


def why(status, text):
    """One line on a failed run: what the script says of itself, else what the status means."""
    lines = [" ".join(line.split()) for line in text.splitlines()]
    own = [line.removeprefix("error:").strip() for line in lines if line.startswith("error:")]
    of_freefem = [line for line in lines if re.search("error opening|(exec|compile) error ?:|assertion", line, re.IGNORECASE)]
    for said in own + of_freefem:
        return f"{said[:300]} (status {status})"
    if status < 0:
        return f"ended by signal {-status}"
    return f"{STATUSES.get(status, 'failed')} (status {status})"


def commit(folders=("cases", "lib", "scripts", "tools")):
    """Short name of the commit, with + if files of these folders differ from it; "unknown" outside a checkout."""
    try:
        def git(*words):
            return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
        changed = git("status", "--porcelain", "--untracked-files=no", "--", *folders)
        return git("rev-parse", "--short=10", "HEAD") + ("+" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def machine():
    """The kind of machine and its number of cores, in words."""
    import platform
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.lower().startswith(("model name", "cpu model")):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{model} ({platform.machine()}), {cores()} cores, {platform.system()}"


def cores():
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def versions():
    """{program or package: version}."""
    from importlib import metadata
    found = {"python": sys.version.split()[0]}
    for name in ("numpy", "scipy", "matplotlib", "gmsh", "meshio"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            pass
    try:
        found["FreeFEM"] = freefem_version() or "unknown"
    except BadInput:
        found["FreeFEM"] = "unknown"
    return found


def freefem_version():
    """FreeFEM's version, None where it does not run. Raises BadInput where it is not there."""
    said = re.search(r"^version (\S+)", run_text('cout << "version " << version << endl;\n').log, re.MULTILINE)
    return said and said.group(1)


def own_folder(folder, tool, names):
    """Makes the folder of a tool, and empties its subfolders of these names. Raises BadInput for one that holds files, but none of
    the tool's."""
    mark = folder / f".{tool}"
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()) and not mark.is_file() and not (folder / f"{tool}.csv").is_file():
        raise BadInput(f"the folder {folder} holds other things than those of tools.{tool}, which removes {', '.join(names)} in "
            f"it: --out takes a folder of its own")
    mark.write_text("")
    for name in names:
        shutil.rmtree(folder / name, ignore_errors=True)
