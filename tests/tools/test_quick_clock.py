"""The clock that is loaded before FreeFEM: it counts CPU time, changes no result, and is left out where it cannot be made."""
import os
import resource
import shutil
import subprocess

import pytest

from tests.conftest import FREEFEM, ROOT
from tools.base import quick_clock

needs_compiler = pytest.mark.skipif(not shutil.which("cc"), reason="there is no C compiler")
COUNTS = """real begin = clock();
int turns = 0;
real[int] a(2000);
a = 1.;
while (clock() - begin < 0.4) { a = a + 1e-3*a; turns++; }
exec("sleep 0.3");
cout << "waited " << clock() - begin << endl;
"""


def spent():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@needs_compiler
def test_it_counts_cpu_time_and_not_what_passes(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "counts.edp").write_text(COUNTS)
    surroundings = quick_clock.with_quick_clock({"PATH": "/usr/bin:/bin"})
    assert "quick_clock" in surroundings["LD_PRELOAD"]
    before = spent()
    done = subprocess.run([FREEFEM, "-nw", tmp_path / "counts.edp"], env=surroundings, capture_output=True, text=True)
    own = float(done.stdout.split("waited")[-1].split()[0])
    assert 0.4 <= own < 0.5, "waiting is no CPU time"
    assert spent() - before >= own - 0.01


@needs_compiler
def test_results_are_the_same_bytes(tmp_path, monkeypatch):
    tables = []
    for name in ("system", ""):
        monkeypatch.setenv("PARTICLES_CLOCK", name)
        out = tmp_path / f"run{name}"
        words = ["cases/settling_disk.edp", "-tend", "0.02", "-every", "0", "-out", out]
        surroundings = quick_clock.with_quick_clock(dict(os.environ))
        subprocess.run([FREEFEM, "-nw", *words], cwd=ROOT, env=surroundings, check=True, capture_output=True)
        tables.append((out / "particles.csv").read_bytes())
    assert tables[0] == tables[1]


def test_without_a_compiler_or_on_request_all_stays_as_it_is(tmp_path, monkeypatch):
    given = {"A": "1"}
    monkeypatch.setenv("PARTICLES_CLOCK", "system")
    assert quick_clock.with_quick_clock(given) == given
    monkeypatch.delenv("PARTICLES_CLOCK")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert quick_clock.with_quick_clock(given) == given
    cc = tmp_path / "cc"
    cc.write_text("#!/bin/sh\nexit 1\n")
    cc.chmod(0o755)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "none"))
    assert quick_clock.with_quick_clock(given) == given


@needs_compiler
def test_other_libraries_to_load_first_stay(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    once = quick_clock.with_quick_clock({"LD_PRELOAD": "/lib/other.so"})
    assert once["LD_PRELOAD"].endswith(".so:/lib/other.so")
    assert quick_clock.with_quick_clock(once) == once
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "with a blank"))
    assert quick_clock.with_quick_clock({"A": "1"}) == {"A": "1"}
