"""The scripts compile, use no forbidden names and are all known; the set-up explains itself."""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cases import CASES
from tests.conftest import FREEFEM, ROOT
from tests.lint import files, needed
from tests.rooms import texts
from tools.compile_errors.names import FORBIDDEN, fespaces, global_names, includes, reached
from tools.meshing.labels import LABELS

SCRIPTS = files(".edp") + files(".idp")
# A script that another one includes (a driver) is compiled there.
INCLUDED = {name for path in SCRIPTS for name in includes(path)}
ENTRIES = [path for path in files(".edp") if path not in INCLUDED]
# A case is compiled where it runs (tests/bodies/test_pipe.py).
RUN_ELSEWHERE = {f"cases/{name}.edp" for name in CASES}
# An include that no script uses yet must compile with what its header needs before it.
USED = reached(ENTRIES)
ALONE = [path for path in files(".idp") if path not in USED]
SPACES = set().union(*(fespaces((ROOT / path).read_text()) for path in SCRIPTS))


def assert_compiles(script):
    command = [FREEFEM, "-nw", "-jc", str(script)]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, errors="replace", timeout=120)
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]


@pytest.mark.parametrize("path", [path for path in ENTRIES if path not in RUN_ELSEWHERE])
def test_script_compiles(path):
    assert_compiles(path)


@pytest.mark.parametrize("path", ALONE)
def test_include_compiles_alone(path, tmp_path):
    script = tmp_path / "script.edp"
    script.write_text("".join(f'include "{name}"\n' for name in [*needed(path), path]))
    assert_compiles(script)


@pytest.mark.parametrize("path", [path for path in SCRIPTS if path.startswith("lib/")])
def test_include_says_what_it_needs_and_defines(path):
    header = (ROOT / path).read_text().split("\nIFMACRO")[0]
    assert re.match(rf"// {Path(path).name}: \S", header), "the first line is // FILE: purpose"
    assert "// Needs:" in header
    assert re.search(r"\b[Dd]efines\b", header)
    for name in needed(path):
        assert (ROOT / name).is_file(), f"{name} does not exist"


@pytest.mark.parametrize("path", sorted(set(SCRIPTS) - set(texts())))
def test_no_global_hides_a_word_of_the_language(path):
    hidden = global_names((ROOT / path).read_text(), SPACES) & FORBIDDEN
    assert not hidden, f"{path} declares {sorted(hidden)}: FreeFEM would use these instead of its own"


def test_cholmod_is_told_that_the_matrix_is_symmetric():
    """FreeFEM 4.9 returns garbage when a form lacks `sym = 1`, FreeFEM 4.15 aborts when `set` does."""
    calls = [(path, call) for path in SCRIPTS for call in re.findall(r'[^;]*"CHOLMOD"[^;]*;', re.sub(r"//[^\n]*", "",
        (ROOT / path).read_text())) if "solver" in call]
    assert len(calls) >= 8
    assert not [(path, call) for path, call in calls if not re.search(r"\bsym ?= ?1\b", call)]


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="not a checkout")
def test_the_repository_holds_plain_files_and_nothing_that_is_made():
    """A link, to an environment elsewhere for one, leads nowhere on another machine."""
    rows = subprocess.run(["git", "ls-files", "--stage", "-z"], cwd=ROOT, check=True, capture_output=True,
        text=True).stdout.split("\0")
    kept = {row.split("\t")[1]: row.split()[0] for row in rows if row}
    assert "README.md" in kept
    assert not [name for name, mode in kept.items() if mode not in ("100644", "100755")]
    assert not [name for name in kept if name.split("/")[0] in (".venv", "results")]


def test_the_lint_finds_what_it_looks_for():
    text = """
    real a = 1, b(3), dx = f(2, c);            // real region;
    func real g(real[int] & N, string q) { real z; for (int label = 0; label < 3; ++label) {} return N; }
    Vh x, lenEdge = [1, y]; Vh [p, P] = [x, y]; int[int] list(2), area = [1, 2];
    macro jump(u) u // EOM
    func real[int] volume(int i) { return list; }
    string words = "real mean; ";
    """
    assert global_names(text, ["Vh"]) & FORBIDDEN == {"dx", "x", "lenEdge", "P", "area", "jump", "volume"}


def test_every_case_is_in_the_list():
    on_disk = {Path(path).stem for path in files(".edp") if path.startswith("cases/")}
    assert on_disk <= set(CASES), f"tests/cases.py does not name {sorted(on_disk - set(CASES))}"
    assert set(CASES) <= on_disk, f"tests/cases.py names {sorted(set(CASES) - on_disk)}, which are not in cases/"


def test_labels_of_python_and_freefem_agree(freefem_text):
    names = ["label" + name.capitalize() for name in LABELS]
    lines = "".join(f'cout << "{name} " << {name} << endl << labelName({name}) << endl;\n' for name in names)
    printed = freefem_text('include "lib/mesh/labels.idp"\n' + lines).stdout
    assert dict(re.findall(r"(label\w+) (\d+)", printed)) == dict(zip(names, map(str, LABELS.values())))
    assert re.findall(r"label (\d+) \((\w+)\)", printed) == [(str(number), name) for name, number in LABELS.items()]
    assert set(re.findall(r"\b(label[A-Z]\w*) = \d", (ROOT / "lib/mesh/labels.idp").read_text())) == set(names)


# The set-up, in a copy of what it needs, with stand-ins for the system's programs.
TOOLS = "bash cat cut dirname env flock grep head ldconfig mktemp rm sha256sum tail".split()


@pytest.fixture
def setup(tmp_path):
    """A function (stand-ins, **environment) that runs tools/setup/setup.sh on a bare machine."""
    (tmp_path / "tools" / "setup").mkdir(parents=True)
    for name in ("setup.sh", "requirements.txt"):
        shutil.copy(ROOT / "tools" / "setup" / name, tmp_path / "tools" / "setup")

    def run(stand_ins, *words, **environment):
        folder = tmp_path / "bin"
        folder.mkdir()
        for name in TOOLS:
            found = shutil.which(name, path=os.environ["PATH"] + ":/sbin:/usr/sbin")
            if found and name not in stand_ins:
                (folder / name).symlink_to(found)
        for name, script in stand_ins.items():
            (folder / name).write_text(f"#!/bin/sh\n{script}\n")
            (folder / name).chmod(0o755)
        environment = {"PATH": str(folder), "HOME": str(tmp_path), "PYTHON": sys._base_executable} | environment
        command = [str(tmp_path / "tools" / "setup" / "setup.sh"), *words]
        return subprocess.run(command, env=environment, cwd="/", capture_output=True, text=True, timeout=300,
            stdin=subprocess.DEVNULL)

    return run


def test_setup_without_root_says_what_to_install(setup):
    run = setup({"id": "echo 1000", "apt-get": "echo must not run >&2; exit 1"})
    assert run.returncode != 0
    assert len(run.stderr.splitlines()) == 1
    assert "apt-get install -y freefem++ libfreefem++" in run.stderr and "neither root nor sudo" in run.stderr


def test_setup_without_network_says_what_to_install(setup):
    run = setup({"id": "echo 0", "apt-get": "echo 'E: no network' >&2; exit 100"})
    assert run.returncode != 0
    assert "E: no network" in run.stderr
    assert "the command is: apt-get update && apt-get install -y freefem++" in run.stderr.splitlines()[-1]


def test_setup_without_apt_says_what_is_missing(setup):
    run = setup({"id": "echo 0"})
    assert run.returncode != 0
    assert "missing: freefem++" in run.stderr and len(run.stderr.splitlines()) == 1


def test_setup_elsewhere_than_on_linux_asks_for_no_package_of_debian(setup):
    """It named libglu1-mesa and libopenblas0-pthread, which are nothing there."""
    run = setup({"uname": "echo Darwin"}, "--check")
    missing = run.stdout.splitlines()
    assert run.returncode == 1 and missing == ["missing: FreeFEM (FreeFem++)", "missing: Python packages of "
        "tools/setup/requirements.txt in .venv"]


def test_setup_elsewhere_than_on_linux_says_where_it_runs(setup):
    run = setup({"uname": "echo Darwin", "apt-get": "echo must not run >&2; exit 1"})
    assert run.returncode != 0 and len(run.stderr.splitlines()) == 1
    assert "on Darwin" in run.stderr and "docs/guide/other_machines.md" in run.stderr and "lib" not in run.stderr


def test_libraries_of_a_conda_environment_count(setup, tmp_path):
    (tmp_path / "conda" / "lib").mkdir(parents=True)
    (tmp_path / "conda" / "lib" / "libGLU.so.1").write_text("")
    run = setup({"ldconfig": "exit 0", "FreeFem++": "exit 0"}, "--check", CONDA_PREFIX=str(tmp_path / "conda"))
    assert "libglu1-mesa" not in run.stdout and "libgl1" in run.stdout


def test_what_runs_elsewhere_names_files_that_are_there():
    """The container file, the workflow and the environment are not run by the tests."""
    container = (ROOT / "Containerfile").read_text()
    copied = [word for line in re.findall(r"^COPY (.*) \S+$", container, flags=re.M) for word in line.split()]
    assert "tools/setup/setup.sh" in copied and all((ROOT / word).exists() for word in copied)
    assert re.search(r"^RUN tools/setup/setup.sh", container, flags=re.M) and 'CMD ["make", "run"]' in container
    ignored = (ROOT / ".dockerignore").read_text().split()
    assert {".venv", "results"} <= set(ignored) and not {"cases", "lib", "meshes", "tools"} & set(ignored)
    workflow = (ROOT / ".github" / "workflows" / "test.yml").read_text()
    assert "run: bash .ci/run" in workflow and (ROOT / ".ci" / "run").is_file()
    needed = set(re.findall(r"lib([\w-]+)\.so", (ROOT / "tools" / "setup" / "setup.sh").read_text()))
    listed = (ROOT / "environment.yml").read_text().lower()
    assert {"GLU", "Xft", "fontconfig"} <= needed and not [name for name in needed if name.lower() not in listed]


def test_setup_without_python_packages_says_what_to_install(setup):
    # As root with an apt-get that does nothing, in an environment where pip cannot run (without pip it is made in a moment).
    python = f'test "$2" != venv || set -- "$@" --without-pip\nexec "{sys._base_executable}" "$@"'
    run = setup({"id": "echo 0", "apt-get": "exit 0", "FreeFem++": "exit 0", "python3": python}, PYTHON="python3")
    assert run.returncode != 0
    assert "pip install -r tools/setup/requirements.txt" in run.stderr.splitlines()[-1]


def test_a_second_setup_installs_nothing():
    stamp = ROOT / ".venv/complete"
    if not stamp.is_file():
        pytest.skip("the environment of this run was not made by make setup")
    when = stamp.stat().st_mtime_ns
    said = subprocess.run([ROOT / "tools/setup/setup.sh"], check=True, env=os.environ | {"FREEFEM": FREEFEM}, timeout=60,
        capture_output=True, text=True)
    assert said.stdout == said.stderr == "" and stamp.stat().st_mtime_ns == when
    named = [path.read_text().strip() for path in (ROOT / ".venv").glob("lib/python3*/site-packages/project.pth")]
    assert named == [str(ROOT.resolve())]  # python -m tools.NAME from any folder


def test_setup_in_the_activated_environment_leaves_it_alone():
    if not (ROOT / ".venv/complete").is_file():
        pytest.skip("the environment of this run was not made by make setup")
    path = f"{ROOT}/.venv/bin:{os.environ['PATH']}"
    run = subprocess.run([ROOT / "tools/setup/setup.sh", "--check"], env=os.environ | {"FREEFEM": FREEFEM, "PATH": path},
        capture_output=True, text=True, timeout=60)
    assert run.returncode == 0 and run.stdout == ""


def test_make_help_names_every_target():
    text = (ROOT / "Makefile").read_text()
    targets = re.search(r"^\.PHONY:(.*)$", text, flags=re.M).group(1).split()
    printed = subprocess.run(["make", "-s", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert {target for target in targets if f"make {target} " not in printed} == {"help"}
