"""What a run folder says of where the run comes from, and the copies that it keeps of the case and of its input."""
import json
import os
import shutil
import subprocess

import pytest

from tests.conftest import ROOT, run_freefem, run_limited as run
from tests.scenes import case
from tests.tables import assert_refused

WORDS = ["-tend", "0.01", "-mesh", ROOT / "meshes/couette_disk.mesh"]
DISKS = "id,x,y,radius,density\n7,0.5,0.5,0.1,2\n"


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A run of a case with include files of its own, one of which includes the other twice, and with a file of particles."""
    folder = tmp_path_factory.mktemp("kept")
    (folder / "inner.idp").write_text("real[int] inner(2); inner = 7; // \"quoted\"\n")
    (folder / "own.idp").write_text(f'  include "{folder}/inner.idp" // nested\nreal outer = inner[0];\n')
    more = f'include "lib/core/arrays.idp"\ninclude "{folder}/own.idp";\nassert(outer == 7);'
    (folder / "mine.edp").write_text(case("1;", more=more))
    (folder / "disks.csv").write_text(DISKS)
    run_freefem(folder / "mine.edp", *WORDS, "-particles", folder / "disks.csv", "-checkpoint", 1, "-out", folder / "run")
    return folder


def info(folder):
    return json.loads((folder / "run.json").read_text())


def test_the_text_of_the_case_is_kept_with_that_of_its_own_includes(kept):
    text = (kept / "run/case.edp").read_text()
    assert 'real[int] inner(2); inner = 7; // "quoted"\n' in text and "real outer = inner[0];\n" in text
    assert 'include "lib/core/arrays.idp"\n' in text and str(kept) not in text.replace(f"// the text of {kept}", "").replace(
        f"// end of {kept}", "")
    assert (kept / "run/particles.given").read_text() == DISKS
    assert {"case.edp", "particles.given"} <= set((kept / "run/.files").read_text().split())
    assert not list((kept / "run").glob("*.new"))


def test_a_case_without_own_includes_is_kept_as_it_is(tmp_path):
    run_freefem("cases/falling_particles.edp", "-number", 3, "-tend", 0.01, "-out", tmp_path / "run")
    assert (tmp_path / "run/case.edp").read_bytes() == (ROOT / "cases/falling_particles.edp").read_bytes()
    assert "fluid" not in info(tmp_path / "run")


def test_run_json_says_where_the_run_comes_from(kept):
    said = info(kept / "run")
    commit = "unknown"
    if (ROOT / ".git").exists() and shutil.which("git"):
        def git(*words):
            return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True).stdout.strip()
        commit = git("rev-parse", "HEAD") + ("+" if git("status", "--porcelain", "-uno", "--", "lib", "scripts") else "")
    assert said["commit"] == commit and said["versions"]["suite"] in (ROOT / "pyproject.toml").read_text()
    assert said["command"] == [str(kept / "mine.edp"), *map(str, WORDS), "-particles", str(kept / "disks.csv"), "-checkpoint", "1",
        "-out", str(kept / "run")]
    assert said["fluid"] == {"density": 1, "viscosity": 0.05} and said["labels"]["no slip"] == [11, 12, 13, 14]
    assert said["directory"] == str(ROOT) and said["threads"] == 1 and said["host"]
    assert 0 < said["cpu_s"] < 60 and 0 <= said["wall_s"] < 60


def test_nothing_fails_without_git(kept, tmp_path, monkeypatch):
    """A program git that is there and fails, as outside a checkout; the folder of a run that goes on keeps its copies."""
    (tmp_path / "git").write_text("#!/bin/sh\nexit 127\n")
    (tmp_path / "git").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    shutil.copytree(kept / "run", tmp_path / "run")
    words = [0.02 if word == "0.01" else word for word in WORDS]
    before = (tmp_path / "run/case.edp").read_bytes()
    run_freefem(kept / "mine.edp", *words, "-particles", kept / "disks.csv", "-checkpoint", 1, "-restart", tmp_path / "run")
    assert info(tmp_path / "run")["commit"] == "unknown" and info(tmp_path / "run")["status"] == "finished"
    assert (tmp_path / "run/case.edp").read_bytes() == before and not list((tmp_path / "run").glob("*.new"))


def test_a_run_does_not_replace_the_copy_that_it_is_run_from(kept, tmp_path):
    shutil.copytree(kept / "run", tmp_path / "run")
    done = run(tmp_path / "run/case.edp", *WORDS, "-out", tmp_path / "run", "-overwrite", 1)
    assert_refused(done, (3,), "would delete")
    assert (tmp_path / "run/case.edp").read_bytes() == (kept / "run/case.edp").read_bytes()
