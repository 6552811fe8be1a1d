"""A disk that is full when who leaves and who touches is written: status 4, one line, and whole rows."""
import json
import os
import signal
import subprocess

import pytest

from tests.conftest import FREEFEM, ROOT, eventually, run_freefem, run_limited
from tests.scenes import case
from tests.tables import assert_refused, assert_whole_rows

# A crowd that a stream carries out of the box; in the third step, when the mesh has long been written, there is no more room.
CROWD = "for (int k = 0; k < 54; ++k) bodyAdd(0.93 - 0.1*(k/9), 0.1 + 0.1*(k % 9), 0.035, 1, 1, 0, 0, 1);"
# A lattice of disks that press on the floor, on a wall and on each other: more contacts than disks.
LATTICE = """include "lib/case.idp"
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("lattice", "a scene of tests/core/test_disk_full.py");
optDefault("-dt", "0.01");
real gravityX = -0.5, gravityY = -1;
macro caseParticles() for (int k = 0; k < 25; ++k) bodyDisk(0.1 + 0.2*(k % 5), 0.1 + 0.2*(k/5), 0.1, 1); // EOM
macro caseWalls() contactWallSegment(0, 0, 1, 0); contactWallSegment(0, 0, 0, 1); // EOM
include "scripts/contacts.edp"
"""


def leaves(folder, where, full):
    """Runs the crowd in where/run; full: the shell command that takes the room. A file that may not grow is told by an error, not
    by a signal."""
    text = case("{ " + CROWD + " }", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
        more=f'macro boundaryU() (y*(1 - y))^0.25 // EOM\nmacro caseStep() if (driveStep == 3) exec("{full}"); // EOM')
    (folder / "scene.edp").write_text(text)
    words = ["-dt", 0.02, "-every", 9, "-tend", 2, "-out", where / "run"]
    return subprocess.run([FREEFEM, "-nw", *map(str, [folder / "scene.edp", *words])], cwd=ROOT,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"}, capture_output=True, text=True, errors="replace",
                          timeout=120, preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN))


def assert_ended(done, folder, name, rows):
    """With the reason, after so many rows of the file at least."""
    assert_refused(done, (4,), f"/{name}.csv (is the disk full?)")
    assert_whole_rows(folder / f"{name}.csv")
    assert len((folder / f"{name}.csv").read_text().splitlines()) > rows
    assert json.loads((folder / "run.json").read_text())["status"] == "failed (4)" and not (folder / ".writer").exists()


def test_who_leaves_when_a_file_may_not_grow(tmp_path):
    assert_ended(leaves(tmp_path, tmp_path, "prlimit --pid $PPID --fsize=3400"), tmp_path / "run", "exits", 20)


def test_who_leaves_when_the_disk_is_full(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", disk], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    try:
        done = leaves(tmp_path, disk, f"cat /dev/zero > {disk}/filler 2>/dev/null")
        assert_ended(done, disk / "run", "exits", 30)
    finally:
        # the watcher of the run may still look after its folder
        assert eventually(lambda: subprocess.run(["umount", disk], capture_output=True) and not disk.is_mount())


def test_who_touches_when_a_file_may_not_grow(tmp_path):
    """Rows of contacts.csv were lost without a word, the last one cut."""
    (tmp_path / "scene.edp").write_text(LATTICE)
    words = [tmp_path / "scene.edp", "-tend", 0.3, "-every", 0, "-out"]
    done = run_limited(*words, tmp_path / "run", most=30_000)
    assert_ended(done, tmp_path / "run", "contacts", 300)
    run_freefem(*words, tmp_path / "free")
    cut, free = ((tmp_path / name / "contacts.csv").read_text() for name in ("run", "free"))
    assert free.startswith(cut) and len(free) > len(cut) > 25_000


@pytest.mark.parametrize("more", [["-out", "{0}/out.csv"], ["-out", "/dev/null", "-contacts", "{0}/contacts.csv"]])
def test_projected_velocities_that_do_not_fit_are_told(more, tmp_path):
    """The script ended with status 0."""
    bodies = tmp_path / "bodies.csv"
    bodies.write_text("id,x,y,radius,mass,u,v\n" + "".join(f"{k},{0.2 * k:.3g},0,0.1,{1 + k % 7},{-k},0.{k}\n" for k in range(90)))
    done = run_limited("scripts/project_velocities.edp", "-bodies", bodies, *[word.format(tmp_path) for word in more], most=2600)
    assert_refused(done, (3,), f"cannot write {more[-1].format(tmp_path)} (is the disk full?)")


def test_results_of_a_steady_flow_that_do_not_fit_are_told(tmp_path):
    """The run ended as finished, without its numbers."""
    scene = (ROOT / "cases/cylinder_steady.edp").read_text().replace("macro caseResult() {", 'macro caseResult() {\n    '
        'exec("prlimit --pid $PPID --fsize=150");')
    assert "prlimit" in scene
    (tmp_path / "scene.edp").write_text(scene)
    done = subprocess.run([FREEFEM, "-nw", tmp_path / "scene.edp", "-out", tmp_path / "run"], cwd=ROOT,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"}, capture_output=True, text=True,
                          timeout=120, preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN))
    assert done.returncode == 4 and "results.csv (is the disk full?)" in done.stderr
    assert_whole_rows(tmp_path / "run/results.csv")
