"""Repeat a run from its folder.

    python -m tools.rerun RUN [-out FOLDER] [OPTION VALUE ...]

Runs the text of the case that RUN keeps (case.edp) with the words of the command that run.json records, the mesh of RUN and the
files that options named, as RUN keeps them, with as many processes and threads as RUN had. Options behind RUN take the place of
recorded ones, or are added. Without -out the repeat goes into RUN_again, or the next free RUN_again_2, ...; RUN itself
is never written to. Repeated by the same version of the project on the same machine, the tables of a run have the same
bytes but for columns of CPU time.

A run that was continued in its own folder is repeated in one piece, from its beginning, without -restart and -maxwall. Other
folders that options name (-flow, another run in -restart) must still be there. A warning tells where the commit, or the version
of FreeFEM, is another one than that of RUN.

Status: that of FreeFEM; 3 with one line where RUN lacks what is needed.
"""
import argparse
import filecmp
import os
import sys
from pathlib import Path

from tools.base.command import BadInput, Parser
from tools.base.ranks import MPI_ENVIRONMENT, launcher
from tools.base.run_folder import RunFolder
from tools.base.runner import commit, freefem, freefem_version
from tools.compile_errors.run import file_options, found, from_here, run, surroundings

CASE, GIVEN = "case.edp", ".given"
NOT_REPEATED = ("-out", "-overwrite")


def recorded(folder):
    """(RunFolder, the words of its command, the folder where it was given). Raises BadInput where the run does not keep what a
    repeat needs."""
    one = RunFolder(folder)
    if not one.info:
        raise BadInput(f"{folder} has no run.json: nothing says how the run was made")
    command, directory = one.info.get("command"), one.info.get("directory")
    if not (isinstance(command, list) and command and all(isinstance(word, str) for word in command)
            and isinstance(directory, str)):
        raise BadInput(f"{folder}/run.json records no command: the run is of an earlier version, or its script has no name")
    if not (one.folder / CASE).is_file():
        raise BadInput(f"{folder} has no {CASE}, the copy of the case: it cannot be repeated from its folder")
    words = command[1:]
    if len(words) % 2:
        raise BadInput(f"{folder}/run.json: the command has an option without a value")
    return one, dict(zip(words[::2], words[1::2])), Path(directory)


def inputs(one, options, directory, files):
    """The recorded options of a run with files of its folder in place of those they named, and with whole paths. files: {option of
    the case that names a file}. Raises BadInput for what is not there any more."""
    again = {name: value for name, value in options.items() if name not in NOT_REPEATED}
    if same(directory / again.get("-restart", ""), one.folder) and "-restart" in again:
        again = {name: value for name, value in again.items() if name not in ("-restart", "-maxwall")}
    parameters = one.info.get("parameters") or {}
    for name in files:
        value = again.get(name, parameters.get(name) if name == "-mesh" or kept(one, name) else None)
        if not value or name in NOT_REPEATED:
            continue
        copy, own = one.folder / "mesh.mesh" if name == "-mesh" else kept(one, name), directory / str(value)
        if copy and copy.is_file() and not (own.is_file() and filecmp.cmp(copy, own, shallow=False)):
            own = copy
        if not own.exists():
            raise BadInput(f"{one.folder} has no copy of {value} ({name}), and {own} is not there any more")
        again[name] = str(own.resolve())
    return again


def kept(one, name):
    """The copy of the file that an option named, None where the run keeps none."""
    path = one.folder / f"{name.lstrip('-')}{GIVEN}"
    return path if path.is_file() else None


def same(path, other):
    """Whether both are one folder."""
    try:
        return os.path.samefile(path, other)
    except OSError:
        return False


def free_name(folder):
    """FOLDER_again, or the next name of that kind that is free."""
    path = Path(f"{os.path.normpath(folder)}_again")
    k = 1
    while path.exists():
        k += 1
        path = Path(f"{os.path.normpath(folder)}_again_{k}")
    return path


def differences(one):
    """What is not as it was, in words."""
    info = one.info
    now, then = commit(("lib", "scripts")), str(info.get("commit", "unknown"))
    if "unknown" not in (now, then):
        if not then.startswith(now.rstrip("+")):
            yield f"the commit is {now.rstrip('+')}, that of the run {then[:10]}"
        if "+" in then + now:
            yield ("files of lib/ or scripts/ " + " and ".join(word for word, one in (("differed from the commit in the run", then),
                ("differ from it now", now)) if "+" in one))
    version = str((info.get("versions") or {}).get("freefem", ""))
    if version and version != freefem_version():
        yield f"FreeFEM is {freefem_version()}, that of the run {version}"


def main():
    """The tool. Returns the status."""
    parser = Parser(prog="python -m tools.rerun", description=__doc__)
    parser.add_argument("run", metavar="RUN", help="the folder of a run")
    parser.add_argument("options", nargs=argparse.REMAINDER, help="-out FOLDER, and options of the case")
    words = parser.parse_args()
    if len(words.options) % 2:
        raise BadInput(f"options of the case come in pairs, -name value; not {' '.join(words.options)}")
    one, options, directory = recorded(words.run)
    case = found(str(one.folder.resolve() / CASE))
    more = dict(zip(words.options[::2], from_here(case, words.options)[1::2]))
    again = inputs(one, options, directory, file_options(case)) | more
    out = Path(again.pop("-out", None) or free_name(one.folder)).resolve()
    if same(out, one.folder):
        raise BadInput(f"-out {out} is the run that is to be repeated: give another folder")
    for line in differences(one):
        print(f"warning: {line}", file=sys.stderr)
    threads = {"OPENBLAS_NUM_THREADS": str(one.info["threads"])} if isinstance(one.info.get("threads"), int) else {}
    processes = one.info.get("processes")
    begin = [freefem(), "-nw"]
    if isinstance(processes, int) and processes > 1:
        begin, threads = [launcher(), "-np", str(processes)], MPI_ENVIRONMENT | threads
    return run([*begin, str(case), *(word for pair in again.items() for word in pair), "-out", str(out)],
        surroundings(case) | threads)
