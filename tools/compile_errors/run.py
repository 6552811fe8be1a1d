"""Run a case from any folder, and say in one sentence why one does not compile.

    python -m tools.run [-n PROCESSES] CASE.edp [options of the case]

FreeFEM reads the case first without running it. Where it does not compile, nothing runs: the
last line, on the error stream, is "error: ...", which names the missing or misspelt name and the
line of the case, and the status is 3. The same holds for a few mistakes that compile, but compute
something else: a variable called x, y, N, label or the like, which hides FreeFEM's own.

A case that compiles runs in the folder of this project, as by FreeFem++ -nw, and the status is
FreeFEM's (128 + signal where a signal ended it). Its output passes through; a line "error: ..." is
held back until FreeFEM has ended, so that it is the last one. Files that options name (-mesh,
-particles, -restart, -out, ...) are taken from the folder where you are; what is not there, but in
the folder of the project, as meshes/cavity.mesh, is taken from there. Files that the text of the
case names by optDefault or optNear, and its includes, are looked for beside the case, then in the
project. Without -out the run lies in results/ of the folder where you are; if that is the
project's and the case lies elsewhere, in results/ beside the case. Ctrl-C, SIGTERM and SIGHUP
reach FreeFEM and what it has started; nothing is left running.

With -n 2 or more the run is shared among processes (ff-mpirun), one thread each. Outside the job of
a batch system there may be 16 for each core of the machine.

Where the machine has a C compiler, runs take less time than by FreeFem++ itself, with the same
results (tools/base/quick_clock.py; PARTICLES_CLOCK=system in the environment: without that).

From another folder: python FOLDER_OF_THE_PROJECT/tools/run.py CASE.edp, or set PYTHONPATH to it.
FREEFEM in the environment names another FreeFem++.
"""

import argparse
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from tools.base.command import ROOT, BadInput, Ended, Parser
from tools.base.quick_clock import with_quick_clock
from tools.base.ranks import ELSEWHERE, MPI_ENVIRONMENT, launcher
from tools.base.runner import freefem
from tools.base.text_files import text_of

COMPILE_LIMIT = 120  # s
GRACE = 3  # s, from a signal to SIGKILL
CROWD = 16  # processes on a core: more would only stop the machine


def main():
    """The tool. Returns the status."""
    parser = Parser(prog="python -m tools.run", description=__doc__)
    parser.add_argument("-n", type=int, default=1, dest="processes", metavar="PROCESSES",
        help="number of processes, by FreeFEM's own MPI (docs/guide/many_processes.md); 1: plain FreeFem++")
    parser.add_argument("case", help="the case, a script of FreeFEM")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="options of the case, as -tend 1; -help lists them")
    words = parser.parse_args()
    case = found(words.case)
    environment = surroundings(case)
    if words.processes < 1:
        raise BadInput(f"-n is a number of processes, at least 1, not {words.processes}")
    if "-n" in words.options and '"-n"' not in case.read_text(encoding="utf-8", errors="replace"):
        raise BadInput(f"the number of processes stands before the case: python -m tools.run -n NUMBER {words.case}")
    cores = os.cpu_count() or 1
    if words.processes > CROWD * cores and not any(name in os.environ for name in ELSEWHERE):
        raise BadInput(f"-n {words.processes}: this machine has {cores} cores, and more processes than cores are slower; "
            f"{CROWD * cores} is the most")
    begin = [freefem(), "-nw"]
    if words.processes > 1:
        begin = [launcher(), "-np", str(words.processes)]
        environment = {**MPI_ENVIRONMENT, **environment}
    refuse_what_does_not_compile(case, words.case, environment)
    return run([*begin, str(case), *from_here(case, words.options)], environment)


def found(name):
    """The whole path of the case. Raises BadInput where it cannot be read."""
    path = Path(name)
    for folder in (Path.cwd(), ROOT):
        if (folder / path).is_file():
            path = Path(os.path.abspath(folder / path))
            break
    else:
        from tools.compile_errors.project import nearest

        cases = sorted(file.stem for file in (ROOT / "cases").glob("*.edp"))
        best = path.stem if path.stem in cases else nearest(path.stem, cases)
        raise BadInput(f"there is no script {name}" + (f"; is cases/{best}.edp meant?" if best else ""))
    if path.suffix != ".edp":
        raise BadInput(f"{name} is no script of FreeFEM: its name must end with .edp")
    if not text_of(path, name, "replace").strip():
        raise BadInput(f"{name} is empty")
    return path


def surroundings(case):
    """The environment of FreeFEM: it looks for includes in the project, then in the folders of the case and of the user; runs
    without -out go to the folder PARTICLES_RESULTS; its statements take less time (tools/base/quick_clock.py)."""
    before = os.environ.get("FF_INCLUDEPATH", "")
    folders = [*([before] if before else []), str(case.parent), str(Path.cwd())]
    inside = Path.cwd().is_relative_to(ROOT)
    home = ROOT if inside and case.is_relative_to(ROOT) else case.parent if inside else Path.cwd()
    runs = {} if home == ROOT or "PARTICLES_RESULTS" in os.environ else {"PARTICLES_RESULTS": str(home / "results")}
    return with_quick_clock({**os.environ, "FF_INCLUDEPATH": ";".join(folders), **runs})


def refuse_what_does_not_compile(case, shown, environment):
    """Raises BadInput with the sentence where FreeFEM does not take the case."""
    from tools.compile_errors import explain

    try:
        done = subprocess.run(
            [freefem(), "-nw", *explain.COMPILE, str(case)],
            cwd=ROOT,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=COMPILE_LIMIT,
        )
    except subprocess.TimeoutExpired:
        raise BadInput(f"FreeFEM has not read {shown} to its end after {COMPILE_LIMIT} s: does a file include itself?") from None
    said = explain.sentence(case, shown, done.stdout) if done.returncode else explain.before_run(case, shown)
    if said:
        raise BadInput(said)


def from_here(case, options):
    """The options of a case: files among them as whole paths from the user's folder, unless only the project has them."""
    if Path.cwd() == ROOT:
        return options
    files, words = file_options(case), list(options)
    for place, name in enumerate(words[:-1]):
        value = words[place + 1]
        if name not in files or not value or (files[name] and not (Path.cwd() / value).exists() and (ROOT / value).exists()):
            continue
        words[place + 1] = str(Path.cwd() / value)
    return words


def for_runs(script, options):
    """The options of a script (from the root) for a tool that runs it again and again: files among them as by from_here; and
    this process finds its includes beside it."""
    case = (ROOT / script).resolve()
    if not case.is_file():
        return options
    os.environ["FF_INCLUDEPATH"] = surroundings(case)["FF_INCLUDEPATH"]
    return from_here(case, options)


def results_of(script):
    """The folder of the results of a script (from the root) that are told no other place: that of its runs."""
    return Path(surroundings((ROOT / script).resolve()).get("PARTICLES_RESULTS") or ROOT / "results")


def file_options(case):
    """{option: whether the case only reads it} of the options that name a file or folder."""
    from tools.compile_errors.names import included

    texts, waiting, seen = [], [case], set()
    while waiting:
        path = waiting.pop()
        if path in seen or not path.is_file():
            continue
        seen.add(path)
        texts.append(path.read_text(encoding="utf-8", errors="replace"))
        waiting += [folder / name for name in included(texts[-1]) for folder in (ROOT, path.parent)]
    found = re.findall(r'optFile\("(-[\w-]+)",[^,]*,\s*"([^"]*)', "\n".join(texts))
    return {name: name != "-out" and "to write" not in about for name, about in found}


def run(command, environment):
    """Run FreeFEM; lines "error: ..." of its error stream come last. Returns its status, or 128 + the signal that ended it."""
    sys.stdout.flush()
    process, reader, held = None, None, []
    try:
        process = subprocess.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE, start_new_session=True)
        reader = threading.Thread(target=pass_on, args=(process.stderr, held), daemon=True)
        reader.start()
        status = process.wait()
    except KeyboardInterrupt as problem:
        if process:
            end(process, problem.args[0] if isinstance(problem, Ended) else signal.SIGINT)
        raise
    finally:
        if reader:
            reader.join(1)  # what FreeFEM has started may hold the stream open
        write(b"".join(held))
    if status > 128 and command[1] == "-np":  # the launcher is told to be quiet
        write(f"error: one of the processes was ended by signal {status - 128}\n".encode())
    return status if status >= 0 else 128 - status


def pass_on(stream, held):
    """Write the lines of a stream to our error stream, but for those that begin with "error: ", which are held."""
    for line in stream:
        if line.startswith(b"error: "):
            held.append(line)
        else:
            write(line)


def write(data):
    """Bytes to the error stream, at once."""
    sys.stderr.flush()
    stream = getattr(sys.stderr, "buffer", None)
    if stream:
        stream.write(data)
        stream.flush()
    else:
        sys.stderr.write(data.decode(errors="replace"))


def end(process, number):
    """Pass a signal on to FreeFEM and all that it has started; what is left after GRACE seconds is killed.

    Further signals are not heard meanwhile.
    """
    for other in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(other, signal.SIG_IGN)
    try:
        for how in (number, signal.SIGKILL):
            os.killpg(process.pid, how)
            limit = time.monotonic() + GRACE
            while time.monotonic() < limit:
                process.poll()
                os.killpg(process.pid, 0)
                time.sleep(0.02)
    except ProcessLookupError:
        process.wait()

