"""A run that is killed, stopped or damaged goes on and gives the CSVs of an unbroken one."""
import os
import random
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

from tests.conftest import FREEFEM, ROOT, make_mesh, run_freefem
from tests.scenes import case
from tests.tables import broken_off, numbers

CASE = "cases/pipe_obstacles.edp"
SCENE = ["-number", "12", "-first", "0", "-interval", "0.01", "-ramp", "0.05", "-every", "0"]
OFTEN = ["-checkpoint", "15", "-fields", "0.04"]
WHOLE = [*SCENE, "-tend", "0.12", *OFTEN]


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    """A mesh of the pipe on which a step takes little, though longer than the wait for a checkpoint."""
    return ["-mesh", str(make_mesh(tmp_path_factory.mktemp("mesh") / "pipe.mesh", "pipe_obstacles", "--size", 0.018))]


@pytest.fixture(scope="module")
def unbroken(mesh, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unbroken") / "run"
    run_freefem(CASE, *mesh, *WHOLE, "-out", folder)
    return folder


def assert_same(folder, unbroken):
    for name in ("particles.csv", "contacts.csv", "entries.csv", "exits.csv"):
        assert (folder / name).read_bytes() == (unbroken / name).read_bytes(), name
    got, expected = numbers(folder, "fluid.csv"), numbers(unbroken, "fluid.csv")
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)


def start(folder, mesh, words=WHOLE):
    """The run in the background, and a wait until its second checkpoint is there."""
    command = [FREEFEM, "-nw", CASE, *mesh, *words, "-out", str(folder)]
    run = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"})
    deadline = time.time() + 200
    while not (folder / "restart_000000030.sha").exists():
        assert run.poll() is None and time.time() < deadline, "the run ended before it could be killed"
        time.sleep(0.02)
    return run


def test_checkpoints_and_the_end_of_a_run_bear_on_its_last_digits_only(freefem, cell, tmp_path):
    """Touching disks in a viscous shear flow: often saved, ended and gone on with, or neither, far below what a step changes."""
    words = ["cases/sheared_suspension.edp", "-mesh", cell, "-fraction", "0.4", "-seed", "2", "-film", "0", "-tolerance", "1e-11",
        "-every", "0"]
    freefem(*words, "-tend", "0.36", "-out", tmp_path / "plain")
    freefem(*words, "-tend", "0.36", "-checkpoint", "7", "-out", tmp_path / "saved")
    freefem(*words, "-tend", "0.32", "-checkpoint", "1000", "-out", tmp_path / "half")
    freefem(*words, "-tend", "0.36", "-restart", tmp_path / "half", "-out", tmp_path / "rest")
    assert {"0.32", "0.36"} <= {row.split(",")[0] for row in (tmp_path / "plain" / "contacts.csv").read_text().splitlines()}
    plain, saved, rest = (np.genfromtxt(tmp_path / name / "particles.csv", delimiter=",", names=True) for name in ("plain",
        "saved", "rest"))
    for name in ("x", "y", "u", "v", "omega"):
        np.testing.assert_allclose(saved[name], plain[name], rtol=0, atol=1e-9, err_msg=name)
        np.testing.assert_allclose(rest[name], plain[name][-len(rest):], rtol=0, atol=1e-9, err_msg=name)


def test_a_killed_run_goes_on_to_the_same_result(mesh, unbroken, tmp_path):
    run = start(tmp_path / "run", mesh)
    time.sleep(random.Random(os.getpid()).uniform(0, 0.1))
    run.send_signal(signal.SIGKILL)
    run.wait()
    for name in ("particles.csv", "fluid.csv"):
        lines = (tmp_path / "run" / name).read_text().splitlines()
        assert all(line.count(",") == lines[0].count(",") for line in lines[:-1]), f"{name} holds whole rows"
    run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / "run")
    assert_same(tmp_path / "run", unbroken)
    text = (tmp_path / "run" / "fields.pvd").read_text()
    assert text.count("<DataSet") == (unbroken / "fields.pvd").read_text().count("<DataSet")


def test_a_damaged_checkpoint_is_passed_over(mesh, unbroken, tmp_path):
    run = start(tmp_path / "run", mesh)
    run.send_signal(signal.SIGKILL)
    os.waitid(os.P_PID, run.pid, os.WEXITED | os.WNOWAIT)  # dead, and a zombie until the test ends: it writes no more
    newest = sorted((tmp_path / "run").glob("restart_*.sha"))[-1].with_suffix(".txt")
    newest.write_bytes(newest.read_bytes()[:-1000])
    again = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / "run")
    assert "1 newer, damaged" in again.stdout
    assert_same(tmp_path / "run", unbroken)
    run.wait()


def test_maxwall_ends_with_a_checkpoint(mesh, unbroken, tmp_path):
    """Between two of -checkpoint, after its first step and among eight disks or more: what goes on is the unbroken run to rounding."""
    run = run_freefem(CASE, *mesh, *WHOLE, "-out", tmp_path / "run", "-maxwall", "0.001")
    assert "stopped by -maxwall" in run.stdout
    assert len((tmp_path / "run" / "fluid.csv").read_text().splitlines()) == 2
    shutil.copytree(unbroken, tmp_path / "late", ignore=shutil.ignore_patterns(".writer"))
    max((tmp_path / "late").glob("restart_*.sha")).unlink()
    begin = int(max((tmp_path / "late").glob("restart_*.sha")).stem[-9:])
    assert numbers(unbroken, "fluid.csv")["particles"][begin] >= 8
    late = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / "late", "-maxwall", "0.001")
    assert "stopped by -maxwall" in late.stdout and f"after {begin + 1} steps" in late.stdout
    expected = numbers(unbroken, "particles.csv")
    for name in ("run", "late"):
        again = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / name)
        assert "goes on from t" in again.stdout and "finished" in again.stdout
        got = numbers(tmp_path / name, "particles.csv")
        for column in expected:
            np.testing.assert_allclose(got[column], expected[column], rtol=0, atol=1e-9 * abs(expected[column]).max(),
                err_msg=column)


def test_what_cannot_go_on_is_refused(mesh, unbroken, tmp_path):
    def refused(*words):
        run = run_freefem(*words, check=False)
        assert run.returncode == 3, run.stdout[-300:] + run.stderr
        return run.stderr

    before = (unbroken / "fluid.csv").read_bytes()
    assert "no complete checkpoint" in refused(CASE, *mesh, *WHOLE, "-restart", tmp_path / "nothing")
    assert "other options (-reynolds 1000)" in refused(CASE, *mesh, *WHOLE, "-reynolds", "500", "-restart", unbroken)
    assert "past -tend" in refused(CASE, *mesh, *SCENE, "-tend", "0.02", *OFTEN, "-restart", unbroken)
    assert "is of the case" in refused("cases/settling_disk.edp", "-restart", unbroken)
    assert "another mesh" in refused(CASE, *WHOLE, "-restart", unbroken, "-out", tmp_path / "other")
    assert (unbroken / "fluid.csv").read_bytes() == before


def test_two_runs_do_not_share_a_folder(mesh, tmp_path):
    run = start(tmp_path / "run", mesh, [*SCENE, "-tend", "20", *OFTEN])  # longer than the second takes to start
    try:
        second = run_freefem(CASE, *mesh, *WHOLE, "-out", tmp_path / "run", "-overwrite", "1", check=False)
        assert second.returncode == 3 and "another run is writing" in second.stderr
    finally:
        run.kill()
        run.wait()


@pytest.mark.parametrize("case, words, tables, sums", [
    ("cases/cylinder_channel.edp", ["-tend", "0.2", "-forces", "1", "-checkpoint", "20", "-every", "0"], ["forces.csv"],
        "fluid.csv"),
    ("cases/pipe_jet.edp", ["-tend", "0.1", "-budget", "1", "-checkpoint", "3", "-cfl", "1.5", "-dt", "0.02"], ["budget.csv"],
        "fluid.csv"),
    ("cases/falling_particles.edp", ["-tend", "20", "-checkpoint", "250"], ["particles.csv", "contacts.csv"], "motion.csv"),
])
def test_drivers_without_resolved_particles_go_on_as_well(case, words, tables, sums, coarse, tmp_path):
    mesh = ["-mesh", coarse] if "jet" in case else []
    run_freefem(case, *mesh, *words, "-out", tmp_path / "whole")
    shutil.copytree(tmp_path / "whole", tmp_path / "broken", ignore=shutil.ignore_patterns(".writer"))
    max((tmp_path / "broken").glob("restart_*.sha")).unlink()  # as if killed before it was written
    again = run_freefem(case, *mesh, *words, "-restart", tmp_path / "broken")
    assert "goes on from t" in again.stdout
    for name in tables:
        assert (tmp_path / "broken" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
    got, expected = numbers(tmp_path / "broken", sums), numbers(tmp_path / "whole", sums)
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)


def test_disks_leave_and_feel_forces_after_a_restart(mesh, tmp_path):
    disks = tmp_path / "disks.csv"
    disks.write_text("id,x,y,radius,density,u,v,omega\n4,0.85,0.02,0.01,1200,0.5,0,0\n7,0.94,0,0.01,1200,1.5,0,0\n8,0.05,0,0.01,1200,0,0,0\n")
    words = [CASE, *mesh, "-number", "0", "-particles", disks, "-ramp", "0.01", "-dt", "0.002", "-cfl", "0", "-every", "0",
        "-tend", "0.06", "-forces", "1", "-checkpoint", "10"]
    whole, broken = broken_off(words, tmp_path, 20)
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name
    assert [numbers(whole, "fluid.csv")["particles"][k] for k in (20, -1)] == [3, 2]  # one leaves after the restart


def test_a_restart_beside_the_run_itself_is_refused_and_takes_nothing(mesh, tmp_path):
    run = start(tmp_path / "run", mesh, [*SCENE, "-tend", "20", *OFTEN])
    try:
        time.sleep(0.1)
        run.send_signal(signal.SIGSTOP)  # some steps behind its last checkpoint
        before = (tmp_path / "run" / "fluid.csv").read_bytes()
        second = run_freefem(CASE, *mesh, *SCENE, "-tend", "20", *OFTEN, "-restart", tmp_path / "run", check=False)
        assert second.returncode == 3 and "another run is writing" in second.stderr
        assert (tmp_path / "run" / "fluid.csv").read_bytes() == before
    finally:
        run.kill()
        run.wait()


def test_a_restart_knows_its_folder_and_its_mesh(mesh, unbroken, tmp_path):
    shutil.copytree(unbroken, tmp_path / "run")
    again = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / "run", "-out", f"{tmp_path}/run/", "-overwrite", "1")
    assert "goes on from t" in again.stdout
    assert_same(tmp_path / "run", unbroken)
    lines = open(mesh[1]).read().splitlines()
    at = lines.index("Vertices") + 2
    number = int(lines[at - 1])
    for k in range(at, at + number):
        x, y, label = lines[k].split()
        lines[k] = f"{float(x) + 0.02 * float(x) * (1 - float(x))!r} {y} {label}"
    (tmp_path / "stretched.mesh").write_text("\n".join(lines) + "\n")
    other = run_freefem(CASE, "-mesh", tmp_path / "stretched.mesh", *WHOLE, "-restart", unbroken, "-out", tmp_path / "other",
        check=False)
    assert other.returncode == 3 and "another mesh" in other.stderr


def test_checkpoints_of_another_version_are_refused(mesh, unbroken, tmp_path):
    """FreeFEM's words before ("incompatible length in read array"), after the tables had been begun."""
    shutil.copytree(unbroken, tmp_path / "old")
    for sums in (tmp_path / "old").glob("restart_*.sha"):
        sums.write_text(re.sub("^# form[0-9]+", "# case", sums.read_text(), flags=re.M))
    before = (tmp_path / "old" / "particles.csv").read_bytes()
    done = run_freefem(CASE, *mesh, *SCENE, "-tend", "0.14", *OFTEN, "-restart", tmp_path / "old", check=False)
    assert done.returncode == 3 and "another version" in done.stderr and len(done.stderr.splitlines()) == 1
    assert (tmp_path / "old" / "particles.csv").read_bytes() == before


def test_a_case_that_was_edited_goes_on_with_a_warning(tmp_path):
    text = (ROOT / "cases/template.edp").read_text()
    mesh = make_mesh(tmp_path / "box.mesh", "box", "--width", 2, "--height", 6, "--size", 0.1)
    case, words = tmp_path / "mine.edp", ["-dt", "0.01", "-checkpoint", "1", "-mesh", mesh]
    case.write_text(text)
    run_freefem(case, *words, "-tend", "0.01", "-out", tmp_path / "run")
    same = run_freefem(case, *words, "-tend", "0.02", "-restart", tmp_path / "run")
    case.write_text(text.replace("diameter/2, 1.2", "diameter/2, 1.3"))
    edited = run_freefem(case, *words, "-tend", "0.03", "-restart", tmp_path / "run")
    again = run_freefem(case, *words, "-tend", "0.04", "-restart", tmp_path / "run")
    assert ["mine.edp has changed since the checkpoint" in run.stdout for run in (same, edited, again)] == [False, True, False]
    assert all("goes on from t" in run.stdout for run in (same, edited, again))


def test_a_checkpoint_of_another_mesh_replaces_nothing(freefem, mesh, tmp_path):
    """Neither the run in -out nor the rows behind the checkpoint are gone when it is refused."""
    words = ["cases/pipe_obstacles.edp", "-number", 0, "-cfl", 0, "-dt", 0.002, "-checkpoint", 1, "-tend"]
    for name in ("one", "two"):
        freefem(*words, 0.006, *mesh, "-out", tmp_path / name)
    kept = {name: (tmp_path / name / "fluid.csv").read_bytes() for name in ("one", "two")}
    newest = sorted((tmp_path / "one").glob("restart_*.sha"))[-1].stem
    for file in (tmp_path / "one").glob(f"{newest}.*"):
        file.unlink()
    for more in (["-out", tmp_path / "two", "-overwrite", 1], []):
        done = freefem(*words, 0.04, "-restart", tmp_path / "one", *more, check=False)
        assert done.returncode == 3 and "another mesh" in done.stderr
        assert all((tmp_path / name / "fluid.csv").read_bytes() == text for name, text in kept.items())


def test_bodies_of_a_checkpoint_that_the_edited_case_no_longer_adds_go_on(tmp_path):
    case = tmp_path / "mine.edp"
    text = (ROOT / "cases/settling_disk.edp").read_text()
    case.write_text(text)
    run_freefem(case, "-dt", "0.005", "-checkpoint", "2", "-tend", "0.02", "-out", tmp_path / "run")
    lines = [line for line in text.splitlines() if "caseParticles" in line]
    case.write_text(text.replace(lines[0], "macro caseParticles() // EOM"))
    on = run_freefem(case, "-dt", "0.005", "-checkpoint", "2", "-tend", "0.03", "-restart", tmp_path / "run", "-out",
        tmp_path / "on")
    assert "has changed since the checkpoint" in on.stdout
    assert np.genfromtxt(tmp_path / "on" / "particles.csv", delimiter=",", names=True)["id"][-1] == 0


@pytest.mark.parametrize("flags", [3, 4])
def test_other_diagonals_are_another_mesh(flags, tmp_path):
    scene = tmp_path / "scene.edp"
    scene.write_text(case("bodyDisk(0.4, 0.5, 0.12, 3);"))
    meshes = tmp_path / "meshes.edp"
    meshes.write_text("int[int] sides = [13, 12, 14, 11];\n" + "".join(f'savemesh(square(16, 16, label = sides, flags = {k}), '
        f'"{tmp_path}/{k}.mesh");\n' for k in (0, flags)))
    run_freefem(meshes)
    run_freefem(scene, "-mesh", tmp_path / "0.mesh", "-tend", "0.04", "-checkpoint", "2", "-out", tmp_path / "run")
    other = run_freefem(scene, "-mesh", tmp_path / f"{flags}.mesh", "-tend", "0.08", "-restart", tmp_path / "run", "-out",
        tmp_path / "on", check=False)
    assert other.returncode == 3 and "another mesh" in other.stderr and not (tmp_path / "on").exists()


def test_a_file_of_particles_that_was_edited_is_told(tmp_path):
    scene, file = tmp_path / "scene.edp", tmp_path / "disks.csv"
    scene.write_text(case(""))
    words = [scene, "-particles", file, "-checkpoint", "1", "-restart", tmp_path / "run", "-tend"]
    file.write_text("id,x,y,radius,density\n0,0.4,0.5,0.12,3\n")
    run_freefem(*words[:5], "-tend", "0.01", "-out", tmp_path / "run")
    same = run_freefem(*words, "0.02")
    file.write_text("id,x,y,radius,density\n0,0.4,0.5,0.12,4\n")
    edited = run_freefem(*words, "0.03")
    assert ["disks.csv has changed since the checkpoint" in run.stdout for run in (same, edited)] == [False, True]
    assert "are those of the checkpoint" in edited.stdout


SLOW = ["-dt", "0.05", "-every", "0"]


@pytest.fixture(scope="module")
def slow(tmp_path_factory):
    """The script of two disks in a slow flow, whose first steps are repeated, and a run of it with checkpoints."""
    folder = tmp_path_factory.mktemp("slow")
    (folder / "slow.edp").write_text(case("bodyDisk(0.5, 0.2, 0.12, 5); bodyDisk(0.4, 0.5, 0.12, 0.5);", mu=2, gravity=-20))
    run_freefem(folder / "slow.edp", *SLOW, "-tend", "0.2", "-checkpoint", "2", "-out", folder / "run")
    return folder


def test_the_state_has_a_word_for_the_repeated_steps_and_one_for_the_frames(slow):
    for file in (slow / "run").glob("restart_*.scheme"):
        words = file.read_text().split("\n")[0].split()
        assert len(words) == 9 and words[7] in ("0", "1") and 0 < int(words[8]) <= 12, file


def test_a_run_goes_on_within_its_repeated_first_steps(slow, tmp_path):
    """Steps that may still be repeated are part of the state."""
    part = tmp_path / "part"
    run_freefem(slow / "slow.edp", *SLOW, "-tend", "0.1", "-checkpoint", "2", "-out", part)
    run_freefem(slow / "slow.edp", *SLOW, "-tend", "0.2", "-checkpoint", "2", "-restart", part, "-out", part)
    assert (part / "particles.csv").read_bytes() == (slow / "run" / "particles.csv").read_bytes()


def test_a_checkpoint_of_an_earlier_form_is_refused_in_a_line(slow, tmp_path):
    folder = tmp_path / "old"
    shutil.copytree(slow / "run", folder)
    for sums in folder.glob("restart_*.sha"):
        text = sums.read_text()
        form = re.search(r"^# form(\d+) ", text, flags=re.M).group(1)
        sums.write_text(text.replace(f"# form{form} ", f"# form{int(form) - 1} "))
    done = run_freefem(slow / "slow.edp", *SLOW, "-tend", "0.3", "-restart", folder, "-out", tmp_path / "new", check=False)
    assert done.returncode == 3
    assert len([line for line in done.stderr.splitlines() if line.startswith("error:")]) == 1
    assert "written by another version of these scripts" in done.stderr
