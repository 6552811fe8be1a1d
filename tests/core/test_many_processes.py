"""Several processes compute the run of one: the same tables to rounding, the same refusals and restarts."""
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest

from tests.conftest import ROOT, make_mesh, run_freefem
from tests.processes import LIMIT, assert_near, assert_same, compare, ranks, why_not
from tests.scenes import case
from tests.tables import numbers
from tools.base.ranks import MPI_ENVIRONMENT, launcher

PIPE = ["cases/pipe_obstacles.edp", "-number", "12", "-first", "0", "-interval", "0.01", "-ramp", "0.05", "-every", "0"]


PROBES = """macro caseStart() outHeader("mine.csv", "t,u,drop,inside,outside,mean"); // EOM
macro caseStep() { real[int] px = [bodyAtX(0), 0.31, -9.], py = [bodyAtY(0), 0.42, 0.], u(0), v(0), p(0);
    flowVelocityAt(px, py, u, v); flowPressureAt(px, py, p);
    real[int] row = [timeNow, u[1], p[1] - p[0], hypot(u[0] - bodyAtU(0), v[0] - bodyAtV(0)), abs(u[2]) + abs(p[2]),
        flowAverageY()];
    outRow("mine.csv", row); } // EOM
"""


def test_free_bodies_with_forces(tmp_path):
    """A disk and ellipses that begin to fall, and the forces on them; the flow at points, within a disk and outside the domain."""
    text = (ROOT / "cases/template.edp").read_text()
    case = tmp_path / "own.edp"
    case.write_text(text.replace('include "scripts/resolved.edp"', PROBES + 'include "scripts/resolved.edp"'))
    folder = compare(2, tmp_path, case, "-tend", "0.01", "-every", "0", "-forces", "1", "-wallforces", "1")
    mine, bodies = numbers(folder, "mine.csv"), numbers(folder, "particles.csv")
    assert abs(mine["u"]).min() > 0 and abs(mine["drop"]).min() > 0 and not mine["outside"].any()
    assert mine["inside"].max() < 1e-6*abs(bodies["v"]).max()


def test_periodic_sides(tmp_path):
    """Disks that meet across the period along x, and one in the four corners of a box that is periodic both ways, on three parts;
    the pressure by a Schur complement."""
    (tmp_path / "disks.csv").write_text("id,x,y,radius,density,u,v,omega\n1,0.9,0.62,0.08,1.5,2,0,0\n2,0.07,0.63,0.08,1.5,0,0,0\n"
        "3,0.01,0.98,0.1,1.5,1,1,3\n")
    folder = compare(3, tmp_path, "cases/carried_disk.edp", "-particles", tmp_path / "disks.csv", "-tend", "0.02", "-every", "0",
        "-fluxes", "1", "-forces", "1", "-pressure-solver", "schur")
    met = numbers(folder, "particles.csv")
    assert met["v"][met["id"] == 2][-1] > 0  # moved by the disk that met it across the period


@pytest.mark.slow
@pytest.mark.parametrize("number, words", [
    (6, ["cases/template.edp", "-tend", "0.01", "-every", "0"]),  # auto: a Schur complement; a process with few nodes of a body
    (5, ["cases/template.edp", "-tend", "0.01", "-every", "0", "-pressure-solver", "factor"]),
    (4, [*PIPE, "-tend", "0.05", "-pressure-solver", "schur"]),  # outlets, and impulses with a pressure of 0 there
    (2, ["cases/cylinder_channel.edp", "-tend", "0.02", "-forces", "1", "-pressure-solver", "schur"]),
])
def test_the_pressure_on_more_processes(tmp_path, number, words):
    compare(number, tmp_path, *words)


def test_disks_that_are_thrown(tmp_path):
    """Fifty and more iterations find the impulse that they share with the fluid, and multiplied rounding by 10^7: velocities were
    another by 1e-6 to 1e-4 on two processes."""
    rows = [f"{3 + k},{0.3 + 0.45*(k % 4)},{0.4 + 0.6*(k // 4)},0.16,{(0.05, 0.9, 4)[k % 3]},{3*(k % 3) - 3},{2 - k % 5},{k - 6}"
        for k in range(12)]
    (tmp_path / "disks.csv").write_text("\n".join(["id,x,y,radius,density,u,v,omega", *rows]) + "\n")
    mesh = make_mesh(tmp_path / "coarse.mesh", "box", "--size", 0.08)
    folder = compare(2, tmp_path, "cases/template.edp", "-particles", tmp_path / "disks.csv", "-mesh", mesh, "-tend", "0.005",
        "-every", "0", "-forces", "1")
    assert abs(numbers(folder, "particles.csv")["u"]).max() > 1


def test_films_and_a_start_from_another_run(tmp_path):
    """A disk close to a floor, with the film below it, that another run on a coarser mesh has brought there."""
    words = ["cases/sinking_disk.edp", "-gap", "0.03", "-every", "0"]
    mesh = make_mesh(tmp_path / "coarse.mesh", "box", "--size", 0.09)
    run_freefem(*words, "-mesh", mesh, "-tend", "0.0075", "-checkpoint", "100", "-out", tmp_path / "begun")
    folder = compare(2, tmp_path, *words, "-start", tmp_path / "begun", "-tend", "0.0225")
    assert abs(numbers(folder, "sinking.csv")["ratio"][-1] - 1) < 0.1  # 40 without the film


def test_the_pressure_of_films_does_not_depend_on_the_parts(tmp_path):
    """Films between disks and towards plates: which vertices at the corners of a gap took part depended on the bins of a part of
    the mesh, which changed velocities by 1e-7 on two processes and 1e-4 on three."""
    compare(3, tmp_path, "cases/sheared_suspension.edp", "-radius", "0.14", "-tend", "0.03", "-every", "0")


@pytest.mark.slow
def test_a_wall_that_moves_along_itself_rubs_alike(tmp_path):
    """A disk under a lid. Each process took the lid's speed from the nearest node of its own part, so that after a collision the
    bodies had other velocities, and the run ended with a message of MPI."""
    (tmp_path / "lid.edp").write_text(case("{ bodyAdd(0.3, 0.88, 0.1, 3, 0, 2, 0, 1); }", moving="labelTop",
        walls="labelLeft, labelRight, labelBottom", more="macro boundaryU() (24*x^2*(1 - x)^2) // EOM"))
    for number in (2, 3):
        folder = compare(number, tmp_path / str(number), tmp_path / "lid.edp", "-film", "0", "-friction", "0.5", "-tend", "0.1",
            "-every", "0")
        assert abs(numbers(folder, "contacts.csv")["tangential"]).max() > 0


def test_one_line_and_its_status_end_all_processes(tmp_path):
    """And nothing keeps the folder of the run: for 8 s after that another run was told to write there."""
    if why_not():
        pytest.skip(why_not())
    run = subprocess.run([sys.executable, "-m", "tools.run", "-n", "2", "cases/settling_disk.edp", "-restart", str(tmp_path)],
        cwd=ROOT, capture_output=True, text=True, timeout=LIMIT)
    lines = run.stderr.splitlines()  # no other line, of Open MPI for one
    assert run.returncode == 3 and len(lines) == 1 and "no complete checkpoint" in lines[0], run.stdout[-2000:] + run.stderr
    assert subprocess.run(["flock", "-w", "1.5", str(tmp_path), "true"]).returncode == 0


def test_what_one_process_alone_finds_ends_all_with_its_status(tmp_path):
    """The first waits for a sum of both. Its end was a signal, 8 s later, and the status 137."""
    (tmp_path / "alone.edp").write_text('include "lib/case.idp"\noptCase("alone", "one process stops");\n'
        'if (!ranksFirst) stopRun(exitInadmissible, "one process alone has found this");\ncout << ranksSum(1.) << endl;\n'
        'IFMACRO(neverDefined)\ninclude "scripts/flow.edp"\nENDIFMACRO\n')
    run = ranks(2, tmp_path / "alone.edp", check=False)
    assert run.returncode == 5 and run.stderr.splitlines() == ["error: one process alone has found this"], run.stderr


@pytest.mark.slow
@pytest.mark.parametrize("words, said", [
    (["cases/cavity.edp"], "steady flows"),
    (["cases/heap.edp"], "contacts without a flow"),
    (["cases/falling_spheres.edp"], "contacts without a flow"),
    (["cases/settling_disk.edp", "-scheme", "published"], "-scheme published"),
    (["cases/settling_disk.edp", "-scheme", "multipliers"], "-scheme multipliers"),
    (["cases/settling_disk.edp", "-bogus", "1"], "unknown option"),
    (["cases/settling_disk.edp", "-out", "/proc/none"], "cannot write"),
])
def test_refusals(words, said):
    run = ranks(2, *words, check=False)
    lines = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert run.returncode == 3 and len(lines) == 1 and said in lines[0], run.stdout[-2000:] + run.stderr


@pytest.mark.slow
def test_each_overlap_at_the_start_is_told_once(tmp_path):
    text = (ROOT / "cases/template.edp").read_text()
    (tmp_path / "own.edp").write_text(text.replace("bodyDisk(1.4, 2.5,", "bodyDisk(0.8, 4.5,"))
    run = ranks(2, tmp_path / "own.edp", check=False)
    lines = run.stderr.splitlines()
    assert run.returncode == 5 and len(lines) == 2 and "particles 0 and 1 overlap" in lines[0], run.stderr


@pytest.mark.slow
def test_a_case_that_reads_the_flow_in_each_step_is_refused(tmp_path):
    text = (ROOT / "cases/template.edp").read_text()
    step = 'macro caseStep() { real[int] row = [timeNow, flowU[3]]; outRow("mine.csv", row); } // EOM\n'
    (tmp_path / "own.edp").write_text(text.replace('include "scripts/resolved.edp"', step + 'include "scripts/resolved.edp"'))
    run = ranks(2, tmp_path / "own.edp", check=False)
    assert run.returncode == 3 and "caseStep" in run.stderr


@pytest.mark.slow
@pytest.mark.parametrize("words", [
    ["cases/cylinder_channel.edp", "-tend", "0.02", "-forces", "1", "-wallforces", "1", "-fluxes", "1", "-budget", "1"],
    ["cases/taylor_green.edp", "-tend", "0.03"],
    ["cases/poiseuille.edp", "-tend", "0.2"],
])
def test_a_flow_alone(tmp_path, words):
    compare(2, tmp_path, *words)


@pytest.mark.slow
@pytest.mark.parametrize("words", [
    ["cases/held_cylinder.edp", "-tend", "0.03"],
    ["cases/sprung_cylinder.edp", "-tend", "0.2"],
    ["cases/rolling_disk.edp", "-tend", "0.02", "-every", "0"],
    ["cases/settling_disk.edp", "-tend", "0.0125", "-budget", "1"],
    ["cases/drafting_kissing_tumbling.edp", "-tend", "0.005"],
    ["cases/sheared_suspension.edp", "-tend", "0.1", "-every", "0", "-radius", "0.14", "-fluxes", "1"],
    ["cases/ellipse_in_shear.edp", "-tend", "0.1"],
    ["cases/cylinder_array.edp", "-tend", "0.01"],  # means of the flow in caseStep
    ["cases/sheared_suspension.edp", "-tend", "0.1", "-every", "0", "-radius", "0.14", "-fraction", "0.35", "-film", "1"],
    # slow flow: coarse correction, pressure around bodies; what is rounding at the start is not at the end of many iterations
    ["cases/template.edp", "-tend", "0.0025", "-mu", "1000", "-tolerance", "1e-10"],
])
def test_bodies(tmp_path, words):
    compare(2, tmp_path, *words)


@pytest.mark.slow
def test_a_flow_that_starts_from_another_run(tmp_path):
    mesh = make_mesh(tmp_path / "coarse.mesh", "cylinder_channel", "--size", 0.06)
    run_freefem("cases/cylinder_channel.edp", "-mesh", mesh, "-tend", "0.1", "-checkpoint", "1000", "-out", tmp_path / "begun")
    compare(2, tmp_path, "cases/cylinder_channel.edp", "-start", tmp_path / "begun", "-tend", "0.12", "-every", "0")


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    """A coarse mesh of the pipe, and the words of a run in which particles enter and collide."""
    mesh = make_mesh(tmp_path_factory.mktemp("mesh") / "pipe.mesh", "pipe_obstacles", "--size", 0.018)
    return [*PIPE, "-mesh", mesh, "-checkpoint", "15", "-fields", "0.04", "-fluxes", "1", "-wallforces", "1", "-forces", "1"]


@pytest.fixture(scope="module")
def on_two(pipe, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two") / "run"
    ranks(2, *pipe, "-tend", "0.12", "-out", folder)
    return folder


@pytest.mark.slow
def test_particles_that_enter_and_collide(pipe, on_two, tmp_path):
    """Films that enclose fluid multiply rounding of the fluxes by the resistance of the narrowest gap (2e-12 without films)."""
    run_freefem(*pipe, "-tend", "0.12", "-out", tmp_path / "one")
    assert_near(tmp_path / "one", on_two, 1e-8)
    ranks(3, *pipe, "-tend", "0.12", "-out", tmp_path / "three")
    assert_near(tmp_path / "one", tmp_path / "three", 1e-8)


@pytest.mark.slow
def test_killed_and_restarted_on_two_processes(pipe, on_two, tmp_path):
    """One process is killed, as for want of memory: all end, run.json says how, and the rest gives the same bytes."""
    folder = tmp_path / "run"
    command = [launcher(), "-np", "2", *map(str, pipe), "-tend", "0.12", "-out", str(folder)]
    run = subprocess.Popen(command, cwd=ROOT, env=os.environ | MPI_ENVIRONMENT, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL)
    limit = time.time() + LIMIT
    while not (folder / "restart_000000030.sha").exists():
        assert run.poll() is None and time.time() < limit
        time.sleep(0.05)
    os.kill(int(re.search(r'"pid": (\d+)', (folder / "run.json").read_text()).group(1)), signal.SIGKILL)
    assert run.wait(timeout=60) != 0
    assert '"status": "killed (signal 9' in (folder / "run.json").read_text()
    ranks(2, *pipe, "-tend", "0.12", "-restart", folder)
    assert_same(folder, on_two)
    assert (folder / "restart_000000060.scheme").read_bytes() == (on_two / "restart_000000060.scheme").read_bytes()
    assert (folder / "fields_0000060.vtu").read_bytes() == (on_two / "fields_0000060.vtu").read_bytes()


@pytest.mark.slow
def test_checkpoints_serve_any_number_of_processes(pipe, on_two, tmp_path):
    run_freefem(*pipe, "-tend", "0.06", "-out", tmp_path / "half")
    shutil.copytree(tmp_path / "half", tmp_path / "other")
    run_freefem(*pipe, "-tend", "0.12", "-restart", tmp_path / "half")
    ranks(2, *pipe, "-tend", "0.12", "-restart", tmp_path / "other")
    assert_near(tmp_path / "half", tmp_path / "other")


@pytest.mark.slow
def test_a_full_disk_of_process_0_ends_all(tmp_path):
    """Process 0 alone finds that a table cannot be written: the folder is gone."""
    folder = tmp_path / "run"
    command = [launcher(), "-np", "2", "cases/template.edp", "-tend", "0.4", "-every", "0", "-out", str(folder)]
    run = subprocess.Popen(command, cwd=ROOT, env=os.environ | MPI_ENVIRONMENT, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True)
    limit = time.time() + LIMIT
    while not (folder / "fluid.csv").exists() or len((folder / "fluid.csv").read_text().splitlines()) < 3:
        assert run.poll() is None and time.time() < limit
        time.sleep(0.05)
    shutil.rmtree(folder)
    _, errors = run.communicate(timeout=60)
    lines = [line for line in errors.splitlines() if line.startswith("error: ")]
    assert run.returncode == 4 and len(lines) == 1 and "cannot write" in lines[0], errors


def parent(pid):
    """The parent of a process that runs; else 0."""
    try:
        state, number = open(f"/proc/{pid}/stat").read().rsplit(")", 1)[1].split()[:2]
    except (FileNotFoundError, ProcessLookupError):
        return 0
    return 0 if state == "Z" else int(number)


@pytest.mark.parametrize("way", ["ff-mpirun", "tools.run"])
def test_a_signal_to_what_was_started_ends_all(tmp_path, way):
    """ff-mpirun, a script, ended alone, and its processes went on to the end of the run."""
    if why_not():
        pytest.skip(why_not())
    folder = tmp_path / "run"
    start = [launcher(), "-np", "2"] if way == "ff-mpirun" else [sys.executable, "-m", "tools.run", "-n", "2"]
    with open(tmp_path / "said", "w") as said:
        run = subprocess.Popen([*start, "cases/template.edp", "-tend", "1000", "-every", "0", "-out", str(folder)], cwd=ROOT,
            env=os.environ | MPI_ENVIRONMENT, stdout=said, stderr=said)
    limit = time.time() + LIMIT
    while not (folder / "fluid.csv").exists() or len((folder / "fluid.csv").read_text().splitlines()) < 3:
        assert run.poll() is None and time.time() < limit
        time.sleep(0.05)
    first = int(re.search(r'"pid": (\d+)', (folder / "run.json").read_text()).group(1))
    own = [int(pid) for pid in os.listdir("/proc") if pid.isdigit() and parent(pid) == parent(first)]
    assert len(own) == 2 and first in own
    run.terminate()
    assert run.wait(timeout=30) != 0
    while any(map(parent, own)):
        assert time.time() < limit
        time.sleep(0.1)
    time.sleep(0.5)
    assert '"status": "killed (signal 15' in (folder / "run.json").read_text(), (tmp_path / "said").read_text()
