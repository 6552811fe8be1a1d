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
from tests.scenes import HELD, case
from tests.tables import broken_off, numbers

CASE = "cases/pipe_obstacles.edp"
SCENE = ["-number", "12", "-first", "0", "-interval", "0.01", "-ramp", "0.05", "-every", "0"]
OFTEN = ["-checkpoint", "20", "-fields", "0.04"]
WHOLE = [*SCENE, "-tend", "0.12", *OFTEN]


@pytest.fixture(scope="module")
def mesh(coarse):
    return ["-mesh", str(coarse)]


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
    while not (folder / "restart_000000040.sha").exists():
        assert run.poll() is None and time.time() < deadline, "the run ended before it could be killed"
        time.sleep(0.02)
    return run


def test_checkpoints_and_the_end_of_a_run_bear_on_its_last_digits_only(freefem, cell, tmp_path):
    """Touching disks in a viscous shear flow: often saved, ended and gone on with, or neither, far below what a step changes."""
    words = ["cases/sheared_suspension.edp", "-mesh", cell, "-tolerance", "1e-11", "-every", "0"]
    freefem(*words, "-tend", "0.8", "-out", tmp_path / "plain")
    freefem(*words, "-tend", "0.8", "-checkpoint", "7", "-out", tmp_path / "saved")
    freefem(*words, "-tend", "0.4", "-checkpoint", "1000", "-out", tmp_path / "half")
    freefem(*words, "-tend", "0.8", "-restart", tmp_path / "half", "-out", tmp_path / "rest")
    plain, saved, rest = (np.genfromtxt(tmp_path / name / "particles.csv", delimiter=",", names=True) for name in ("plain", "saved", "rest"))
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
    """Between two of -checkpoint, after its first step and among twelve disks: what goes on is the unbroken run to rounding."""
    run = run_freefem(CASE, *mesh, *WHOLE, "-out", tmp_path / "run", "-maxwall", "0.001")
    assert "stopped by -maxwall" in run.stdout
    assert len((tmp_path / "run" / "fluid.csv").read_text().splitlines()) == 2
    shutil.copytree(unbroken, tmp_path / "late", ignore=shutil.ignore_patterns(".writer"))
    max((tmp_path / "late").glob("restart_*.sha")).unlink()
    late = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / "late", "-maxwall", "0.001")
    assert "stopped by -maxwall" in late.stdout and "after 61 steps" in late.stdout
    expected = numbers(unbroken, "particles.csv")
    for name in ("run", "late"):
        again = run_freefem(CASE, *mesh, *WHOLE, "-restart", tmp_path / name)
        assert "goes on from t" in again.stdout and "finished" in again.stdout
        got = numbers(tmp_path / name, "particles.csv")
        for column in expected:
            np.testing.assert_allclose(got[column], expected[column], rtol=0, atol=1e-9 * abs(expected[column]).max(), err_msg=column)


def test_what_cannot_go_on_is_refused(mesh, unbroken, tmp_path):
    def refused(*words):
        run = run_freefem(*words, check=False)
        assert run.returncode == 3, run.stdout[-300:] + run.stderr
        return run.stderr

    before = (unbroken / "fluid.csv").read_bytes()
    assert "no complete checkpoint" in refused(CASE, *mesh, *WHOLE, "-restart", tmp_path / "nothing")
    assert "other options (-reynolds=1000)" in refused(CASE, *mesh, *WHOLE, "-reynolds", "500", "-restart", unbroken)
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
    ("cases/cylinder_channel.edp", ["-tend", "0.2", "-forces", "1", "-checkpoint", "20", "-every", "0"], ["forces.csv"], "fluid.csv"),
    ("cases/pipe_jet.edp", ["-tend", "0.1", "-budget", "1", "-checkpoint", "3", "-cfl", "1.5", "-dt", "0.02"], ["budget.csv"], "fluid.csv"),
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


def test_another_interval_of_the_fields_counts_from_the_restart_on(tmp_path):
    words = ["cases/poiseuille.edp", "-dt", "0.02", "-cfl", "0", "-checkpoint", "3"]
    run_freefem(*words, "-tend", "0.06", "-fields", "1", "-out", tmp_path / "run")

    def times(interval, tend):
        run_freefem(*words, "-tend", tend, "-fields", interval, "-restart", tmp_path / "run")
        return [float(word) for word in re.findall(r'timestep="(\S+)"', (tmp_path / "run/fields.pvd").read_text())]

    assert times("0.04", "0.12") == [0, 0.08, 0.12]
    assert times("0.1", "0.24") == [0, 0.08, 0.12, 0.2]
    assert times("0.02", "0.28") == [0, 0.08, 0.12, 0.2, 0.26, 0.28]


def test_contacts_alone_stop_at_maxwall_and_go_on(tmp_path):
    words = ["cases/falling_particles.edp", "-tend", "10"]
    assert "stopped by -maxwall" in run_freefem(*words, "-out", tmp_path / "run", "-maxwall", "0.05").stdout
    assert "finished at t = 10 s" in run_freefem(*words, "-restart", tmp_path / "run").stdout
    moved = run_freefem("cases/falling_particles.edp", "-tend", "10", "-number", "20", "-restart", tmp_path / "run", check=False)
    assert moved.returncode == 3 and "other options" in moved.stderr


def test_disks_leave_and_feel_forces_after_a_restart(mesh, tmp_path):
    disks = tmp_path / "disks.csv"
    disks.write_text("id,x,y,radius,density,u,v,omega\n4,0.85,0.02,0.01,1200,0.5,0,0\n7,0.94,0,0.01,1200,1.5,0,0\n8,0.05,0,0.01,1200,0,0,0\n")
    words = [CASE, *mesh, "-number", "0", "-particles", disks, "-ramp", "0.01", "-dt", "0.002", "-cfl", "0", "-every", "0", "-tend", "0.06", "-forces", "1", "-checkpoint", "10"]
    whole, broken = broken_off(words, tmp_path, 20)
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name
    assert [numbers(whole, "fluid.csv")["particles"][k] for k in (20, -1)] == [3, 2]  # one leaves after the restart


def test_budgets_and_shapes_outlive_a_restart(shaft, tmp_path):
    mesh = make_mesh(tmp_path / "shear.mesh", "ellipse_in_shear", "--size", 0.00625, "--core", 0.13)
    words = ["cases/ellipse_in_shear.edp", "-mesh", mesh, "-major", "0.05", "-tend", "0.1", "-dt", "0.01", "-checkpoint", "5"]
    whole, broken = broken_off(words, tmp_path / "ellipse", 5)
    words = ["cases/settling_disk.edp", *shaft, "-dt", "0.002", "-tend", "0.02", "-budget", "1", "-checkpoint", "5"]
    box = broken_off(words, tmp_path / "box", 5)
    for name, (a, b) in (("shapes.csv", (whole, broken)), ("particles.csv", (whole, broken)), ("budget.csv", box)):
        assert (a / name).read_bytes() == (b / name).read_bytes(), name


def test_ellipses_that_touch_go_on_after_a_restart_bit_for_bit(tmp_path):
    mesh = make_mesh(tmp_path / "low.mesh", "box", "--width", 2, "--height", 3.5, "--size", 0.0625)
    words = ["cases/settling_ellipses.edp", "-mesh", mesh, "-number", "16", "-tend", "0.3", "-checkpoint", "60"]
    whole, broken = broken_off(words, tmp_path, 120)
    assert numbers(whole, "contacts.csv")["t"].min() < 0.24 and numbers(whole, "contacts.csv")["t"].max() > 0.25
    for name in ("particles.csv", "contacts.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


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
    other = run_freefem(CASE, "-mesh", tmp_path / "stretched.mesh", *WHOLE, "-restart", unbroken, "-out", tmp_path / "other", check=False)
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


def test_a_checkpoint_of_another_mesh_replaces_nothing(freefem, coarse, tmp_path):
    """Neither the run in -out nor the rows behind the checkpoint are gone when it is refused."""
    words = ["cases/pipe_obstacles.edp", "-number", 0, "-cfl", 0, "-dt", 0.002, "-checkpoint", 1, "-tend"]
    for name in ("one", "two"):
        freefem(*words, 0.006, "-mesh", coarse, "-out", tmp_path / name)
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
    on = run_freefem(case, "-dt", "0.005", "-checkpoint", "2", "-tend", "0.03", "-restart", tmp_path / "run", "-out", tmp_path / "on")
    assert "has changed since the checkpoint" in on.stdout
    assert np.genfromtxt(tmp_path / "on" / "particles.csv", delimiter=",", names=True)["id"][-1] == 0


def test_forces_that_a_case_reads_outlive_a_restart(tmp_path):
    """caseMotion takes its velocities of bodyForce, the force of the last step."""
    text = case("bodyHeld(bodyDisk(0.4, 0.5, 0.15, 1)); bodyDisk(0.7, 0.7, 0.12, 3);", more="macro caseMotion(now) givenMotion(0, 0.02*bodyForce[0], 0.02*bodyForce[2], 0.); // EOM")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-tend", "0.1", "-forces", "1", "-checkpoint", "4"], tmp_path, 8)
    assert abs(numbers(whole, "forces.csv")["fx"]).max() > 1e-4
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


SWINGING = """macro flowForceX() 1. // EOM
macro caseStart() { caseFX.resize(flowFX.n); caseFX = flowFX; } // EOM
macro caseStep() flowFX = cos(20*(timeNow + timeDt))*caseFX; // EOM
real[int] caseFX(0);
"""


@pytest.mark.parametrize("driver, along", [("resolved", "X"), ("flow", "X"), ("resolved", "Y"), ("flow", "Y")])
def test_a_force_on_the_fluid_that_a_case_changes_outlives_a_restart(driver, along, tmp_path):
    """caseStep has scaled it for the next step when the checkpoint is written."""
    text = HELD.replace("macro flowForceX() 1. // EOM\n", SWINGING.replace("flowForceX", "flowForce" + along).replace("flowFX", "flowF" + along)).replace("0, 0, 0, 0)", "0, 0, 0, 1)")
    if driver == "flow":
        lines = [line for line in text.splitlines() if "caseParticles" not in line]
        text = "\n".join(lines).replace("lib/bodies/bodies.idp", "lib/case.idp").replace(", gravityX = 0, gravityY = 0", "").replace(", motionBound = 1e30", "").replace("resolved.edp", "flow.edp") + "\n"
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-dt", "0.02", "-every", "0", "-tend", "0.2", "-checkpoint", "4"], tmp_path, 8)
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    assert np.ptp(expected["kinetic_energy"]) > 0
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)
    if driver == "resolved":
        assert (broken / "particles.csv").read_bytes() == (whole / "particles.csv").read_bytes()


VORTEX = """
include "lib/case.idp"
optCase("vortex", "a vortex dies down in a box");
optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1, mu = 0.05, flowPeriodX = 0, flowPeriodY = 0;
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelLeft, labelRight, labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) { return 1; }
macro caseStart() {
    Wh u = 14*sin(pi*x)^2*sin(2*pi*y), v = -14*sin(2*pi*x)*sin(pi*y)^2;
    flowU = u[]; flowV = v[]; flowU1 = flowU; flowV1 = flowV;
} // EOM
include "scripts/flow.edp"
"""


@pytest.mark.parametrize("tend, every, keep", [(0.2, 5, 35), (0.05, 7, 7)])
def test_a_stabilisation_that_has_fallen_to_0_is_on_after_a_restart(tend, every, keep, tmp_path):
    """With it the diagonal of the velocity's matrix is summed otherwise: to the last digit. Where it is not 0 yet it is that of the speeds of some steps before."""
    (tmp_path / "scene.edp").write_text(VORTEX)
    words = [tmp_path / "scene.edp", "-dt", "0.005", "-cfl", "0", "-every", "0", "-tend", tend, "-checkpoint", every]
    whole, broken = broken_off(words, tmp_path, keep)
    share = numbers(whole, "fluid.csv")["unresolved"]
    assert share.max() > 0 and (share[keep - 1:].max() == 0) == (keep == 35)
    last = max(whole.glob("restart_*.sha")).stem
    for end in ("txt", "scheme"):  # the flow and what the scheme keeps, among it the sums of the shares
        assert (broken / f"{last}.{end}").read_bytes() == (whole / f"{last}.{end}").read_bytes(), end


@pytest.mark.parametrize("third", ["queueAt(0.4, 0.7, 0.1, 2, 0.15);", "queueEllipseAt(0.4, 0.7, 0.12, 0.08, 0.5, 2, 0.15);"])
def test_loads_outlive_a_restart_where_bodies_come_and_go(third, tmp_path):
    """One of two has left before it, the other is lighter than the fluid, and a third, pushed as well, enters behind it."""
    bodies = f"bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyDisk(0.5, 0.3, 0.1, 0.5); {third}"
    pushes = "bodyPush(0, 1, 0, 0); bodyPush(1, 0, 1, 0); bodyPush(2, 0, 1, 0.01);"
    text = case(bodies, more=f"macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseLoads(now) {pushes} // EOM", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-tend", "0.2", "-forces", "1", "-checkpoint", "5"], tmp_path, 15)
    table = numbers(whole, "particles.csv")
    assert [set(table["id"][abs(table["t"] - t) < 1e-9]) for t in (0.01, 0.15, 0.2)] == [{0, 1}, {1}, {1, 2}]
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


def test_bodies_leave_before_and_after_a_restart(tmp_path):
    """What the scheme keeps of each body is that of the bodies of then, not of the case's."""
    bodies = "bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyAdd(0.91, 0.7, 0.1, 2, 1.5, 0, 0, 1); bodyDisk(0.4, 0.5, 0.1, 0.5);"
    text = case(bodies, more="macro boundaryU() (4*y*(1 - y)) // EOM", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-tend", "0.2", "-forces", "1", "-checkpoint", "5"], tmp_path, 15)
    table = numbers(whole, "particles.csv")
    assert [set(table["id"][abs(table["t"] - t) < 1e-9]) for t in (0.01, 0.15, 0.2)] == [{0, 1, 2}, {1, 2}, {2}]
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("flags", [3, 4])
def test_other_diagonals_are_another_mesh(flags, tmp_path):
    scene = tmp_path / "scene.edp"
    scene.write_text(case("bodyDisk(0.4, 0.5, 0.12, 3);"))
    meshes = tmp_path / "meshes.edp"
    meshes.write_text("int[int] sides = [13, 12, 14, 11];\n" + "".join(f'savemesh(square(16, 16, label = sides, flags = {k}), "{tmp_path}/{k}.mesh");\n' for k in (0, flags)))
    run_freefem(meshes)
    run_freefem(scene, "-mesh", tmp_path / "0.mesh", "-tend", "0.04", "-checkpoint", "2", "-out", tmp_path / "run")
    other = run_freefem(scene, "-mesh", tmp_path / f"{flags}.mesh", "-tend", "0.08", "-restart", tmp_path / "run", "-out", tmp_path / "on", check=False)
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


def test_a_force_on_the_fluid_that_was_edited_counts_after_a_restart(tmp_path):
    """It stands in checkpoints only where the case has changed it in the run."""
    case, speeds = tmp_path / "scene.edp", []
    case.write_text(HELD)
    words = ["-dt", "0.02", "-every", "0", "-checkpoint", "4"]
    run_freefem(case, *words, "-tend", "0.1", "-out", tmp_path / "run")
    for push in (1, -5):
        case.write_text(HELD.replace("flowForceX() 1.", f"flowForceX() {push}."))
        run_freefem(case, *words, "-tend", "0.2", "-restart", tmp_path / "run", "-out", tmp_path / f"on{push}")
        speeds.append(numbers(tmp_path / f"on{push}", "fluid.csv")["top_speed"][-1])
    assert abs(speeds[0] - speeds[1]) > 0.1 * speeds[0]


def test_a_body_on_a_pin_goes_on_turning_after_a_restart(tmp_path):
    (tmp_path / "scene.edp").write_text(case("bodyPinned(bodyDisk(0.5, 0.5, 0.15, 2));", more="macro caseLoads(now) bodyPush(0, 0, 0, 0.3); // EOM"))
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-tend", "0.1", "-checkpoint", "4"], tmp_path, 8)
    assert abs(numbers(whole, "particles.csv")["omega"][-1]) > 0.01
    assert (broken / "particles.csv").read_bytes() == (whole / "particles.csv").read_bytes()


def test_the_least_gap_since_the_last_row_outlives_a_restart(tmp_path):
    """A disk lands between two rows, before the checkpoint."""
    (tmp_path / "scene.edp").write_text(case("bodyAdd(0.5, 0.15, 0.1, 3, 0, 1, 0, 1);"))
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0.05", "-cfl", "0", "-dt", "0.01", "-tend", "0.2", "-checkpoint", "4"], tmp_path, 16)
    np.testing.assert_array_equal(numbers(broken, "fluid.csv")["worst_gap"], numbers(whole, "fluid.csv")["worst_gap"])


def test_carried_particles_go_on_in_the_midst_of_their_history(freefem, coarse, tmp_path):
    """A checkpoint whose step is no multiple of the window of the history force."""
    words = ["-mesh", coarse, "-checkpoint", 15, "-turbulence", "fluctuation", "-tend"]
    freefem("tests/transport/scripts/queue.edp", *words, 0.12, "-out", tmp_path / "whole")
    freefem("tests/transport/scripts/queue.edp", *words, 0.1, "-out", tmp_path / "broken")
    for file in (tmp_path / "broken").glob("restart_000000050*"):
        file.unlink()
    freefem("tests/transport/scripts/queue.edp", *words, 0.12, "-restart", tmp_path / "broken")
    assert (tmp_path / "whole" / "particles.csv").read_bytes() == (tmp_path / "broken" / "particles.csv").read_bytes()


@pytest.mark.parametrize("last, keep", [(0.0601, 6), (0.0601, 7)])
def test_a_motion_that_ends_beside_a_checkpoint(last, keep, tmp_path):
    """Given until then, at a constant speed from there on, with a free disk beside it."""
    text = case("bodyHeld(bodyDisk(0.4, 0.5, 0.12, 1)); bodyDisk(0.7, 0.5, 0.1, 1.5);", more=f"macro caseMotion(now) if (now < {last}) givenMotion(0, 20*(now), -10*(now), 0); // EOM")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.12", "-forces", "1", "-checkpoint", keep], tmp_path, keep)
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("course, flux", [("10*(now)", 1 / 3), ("((now) < 0.0301 ? 0.5 : 1.)", 2 / 3)], ids=["half", "as at first"])
@pytest.mark.parametrize("driver", ["resolved", "flow"])
def test_an_inlet_that_a_case_sets_no_more_is_as_it_was_after_a_restart(driver, course, flux, tmp_path):
    """caseBoundary scales it until 0.05 s, and says nothing of it from then on. At t = 0 it has another factor than then, in a run that goes on too."""
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
                more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) if (now < 0.0501) inflowScale(labelLeft, COURSE); // EOM".replace("COURSE", course))
    if driver == "flow":
        lines = [line for line in text.splitlines() if "caseParticles" not in line]
        text = "\n".join(lines).replace(", gravityX = 0, gravityY = 0", "").replace(", motionBound = 1e30", "").replace("resolved.edp", "flow.edp") + "\n"
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.12", "-checkpoint", "4"], tmp_path, 8)
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    assert expected["flux_in"][-1] == pytest.approx(flux, rel=1e-3)
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)


def test_the_axes_of_who_enters_behind_a_checkpoint_stand_once_in_shapes(tmp_path):
    text = case("bodyEllipse(0.4, 0.3, 0.12, 0.08, 0.3, 2); queueEllipseAt(0.5, 0.7, 0.12, 0.08, 0.5, 2, 0.05);")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.08", "-checkpoint", "4"], tmp_path, 4)
    assert (broken / "shapes.csv").read_bytes() == (whole / "shapes.csv").read_bytes() and len(numbers(whole, "shapes.csv")["id"]) == 2


def test_carried_particles_make_a_step_at_least_before_maxwall(freefem, coarse, tmp_path):
    """However long a run takes to begin: one that is begun again and again comes to its end."""
    words = ["tests/transport/scripts/queue.edp", "-mesh", coarse, "-tend", 0.006, "-maxwall", 1e-6]
    for step in (1, 2):
        done = freefem(*words, *(["-out"] if step == 1 else ["-restart"]), tmp_path / "run")
        assert f"stopped by -maxwall at t = {0.002 * step:g} s" in done.stdout, done.stdout
    assert "finished at t = 0.006 s" in freefem(*words, "-restart", tmp_path / "run").stdout
    freefem(*words[:-2], "-out", tmp_path / "whole")
    assert (tmp_path / "run" / "particles.csv").read_bytes() == (tmp_path / "whole" / "particles.csv").read_bytes()


def test_what_a_case_writes_at_its_end_stands_once_in_a_run_that_goes_on(tmp_path):
    """A second row stood below the first."""
    words = ["cases/poiseuille.edp", "-dt", "0.02", "-checkpoint", "3"]
    run_freefem(*words, "-tend", "0.06", "-out", tmp_path / "run")
    first = (tmp_path / "run" / "errors.csv").read_text().splitlines()
    run_freefem(*words, "-tend", "0.12", "-restart", tmp_path / "run")
    second = (tmp_path / "run" / "errors.csv").read_text().splitlines()
    assert len(first) == len(second) == 2 and first[0] == second[0] and first[1] != second[1]


def test_contacts_without_a_disk_have_their_checkpoint(freefem_text, tmp_path):
    text = """include "lib/case.idp"
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("empty", "a scene of tests/suite/test_restart.py");
optDefault("-dt", "0.01");
real gravityX = 0, gravityY = -1;
macro caseParticles() // EOM
macro caseWalls() contactWallSegment(-1, -1, 1, -1); // EOM
include "scripts/contacts.edp"
"""
    freefem_text(text, "-tend", 0.1, "-checkpoint", 5, "-out", tmp_path / "run")
    assert "goes on from t = 0.1 s, step 10" in freefem_text(text, "-tend", 0.2, "-restart", tmp_path / "run").stdout


# One leaves before the checkpoint and one behind it, a light one is pushed, one turns on a pin, one enters before and one behind it; the inlet changes until a step before it; a body lands, one falls
# on it and one is turned from a time behind it; the only one has left, and the solver's first guess is quadratic in time;
# a stream stops beside the checkpoint, and with it the frame of the body that it carried.
WHOLE_STATE = {
    "open": (case("{ bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyAdd(0.93, 0.75, 0.1, 2, 1.2, 0, 0, 1); bodyDisk(0.5, 0.3, 0.1, 0.5); bodyPinned(bodyEllipse(0.3, 0.8, 0.12, 0.08, 0.3, 2)); "
                  "queueAt(0.12, 0.22, 0.08, 2, 0.15); queueEllipseAt(0.2, 0.5, 0.1, 0.07, 0.5, 2, 0.06); }", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", mu=0.004,
                  more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseLoads(now) bodyPush(2, 0, 1, 0); bodyPush(4, 0, 1, 0.01); // EOM\nmacro caseBoundary(now) if (now < 0.0951) inflowScale(labelLeft, 1 + 2*(now)); // EOM"),
             ["-tend", "0.2", "-every", "0.015", "-wallforces", "1", "-fluxes", "1", "-fields", "0.03"], 10),
    "closed": (case("{ bodyAdd(0.5, 0.15, 0.1, 3, 0, 0.5, 0, 1); bodyEllipse(0.5, 0.42, 0.14, 0.1, 0.4, 5); bodyDisk(0.8, 0.7, 0.1, 0.4); }", gravity=-4,
                    more="macro caseLoads(now) bodyPush(2, 0.02, 0, 0.01*(now > 0.125)); // EOM"), ["-tend", "0.22", "-every", "0.03", "-budget", "1"], 11),
    "empty": (case("bodyAdd(0.99, 0.5, 0.1, 2, 2, 0, 0, 1);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
                   more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) inflowScale(labelLeft, 1 + sin(20*(now))); // EOM"), ["-cfl", "0", "-tend", "0.24", "-every", "0"], 12),
    "frame": (case("bodyDisk(0.3, 0.5, 0.1, 1);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
                   more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) inflowScale(labelLeft, (now < 0.145 ? 1. : 0.)); // EOM"), ["-cfl", "0", "-tend", "0.3", "-every", "0"], 15),
}


@pytest.mark.parametrize("scene", WHOLE_STATE)
def test_the_whole_state_outlives_a_restart(scene, tmp_path):
    """All tables, and the last checkpoint: what is kept for later steps is in it, whether these tables show it or not."""
    text, words, keep = WHOLE_STATE[scene]
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-forces", "1", "-checkpoint", keep, *words], tmp_path, keep)
    if scene == "open":
        for name, times in (("entries", [0, 0, 0, 0, 0.07, 0.16]), ("exits", [0.09, 0.14])):
            assert numbers(whole, f"{name}.csv")["t"] == pytest.approx(times, abs=0.011)
    names = [f"{name}.csv" for name in ("particles", "forces", "wallforces", "fluxes", "budget", "entries", "exits", "contacts", "shapes")] + ["fields.pvd"]
    for name in [name for name in names if (whole / name).exists()] + [f"restart_{2 * keep:09d}.{end}" for end in ("txt", "scheme", "contacts")]:
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)
