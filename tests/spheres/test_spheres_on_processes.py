"""Several processes compute the run of one with spheres: the same tables to rounding, the same restarts, refusals by name."""
import os
import re
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

from tests.cells import scene
from tests.conftest import ROOT, make_mesh, run_freefem
from tests.processes import LIMIT, assert_near, assert_same, compare, ranks
from tests.tables import numbers
from tools.base.ranks import MPI_ENVIRONMENT, launcher

SCENE = """
include "lib/spheres/case.idp"
optCase("scene", "spheres of tests/spheres");
optDefault("-dt", "0.01");
real rhoFluid = 960, mu = 0.058, gravityX = 0, gravityY = 0, gravityZ = -9.81, R = 0.0075;
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {particles} // EOM
{more}
include "scripts/spheres.edp"
"""
CLOSED = "int[int] flowNoSlip = [labelWall], flowSlip(0), flowMoving(0), flowOutlet(0);\n"
LID = "int[int] flowMoving = [labelLid], flowSlip(0), flowNoSlip = [labelWall], flowOutlet(0);\nmacro boundaryU() 0.2 // EOM\n"


def test_a_settling_sphere_with_forces_and_budget(tmp_path):
    """A quarter of the box, with planes of symmetry through the sphere."""
    mesh = make_mesh(tmp_path / "coarse.mesh", "settling_sphere", "--size", 0.005)
    folder = compare(2, tmp_path, "cases/settling_sphere.edp", "-mesh", mesh, "-tend", "0.02", "-every", "0", "-forces",
        "1", "-budget", "1", "-wallforces", "1")
    assert abs(numbers(folder, "particles.csv")["w"]).max() > 0.01


def across(tmp_path, number, *words):
    """Two spheres that collide across a side of a cell that is periodic along x and y, on several processes."""
    case, mesh = tmp_path / "across.edp", make_mesh(tmp_path / "cell.mesh", "sphere_lattice", "--size", 1 / 6, "--octants", "alike")
    case.write_text(scene())
    folder = compare(number, tmp_path, case, "-mesh", mesh, "-x", "0.7", *words)
    met = numbers(folder, "particles.csv")
    first, second = (met["x"][met["id"] == one][-1] for one in (0, 1))
    assert numbers(folder, "fluid.csv")["contacts"].max() == 1 and first - second > 0.5  # the period is 1
    return folder


def test_spheres_that_collide_across_a_periodic_side(tmp_path):
    """The pressure by divided conjugate gradients."""
    across(tmp_path, 2, "-tend", "0.2", "-dt", "0.04", "-every", "0", "-friction", "0.3", "-direct", "0")


@pytest.mark.slow
def test_a_periodic_cell_on_three_processes(tmp_path):
    """Forces, fields, conjugate gradients for the pressure, and a checkpoint that two processes take up."""
    words = ["-tend", "0.24", "-every", "0", "-forces", "1", "-friction", "0.3", "-checkpoint", "8", "-direct", "50",
        "-fields", "0.1"]
    folder = across(tmp_path, 3, *words)
    for name in ("fields_0000005.vtu", "fields_0000010.vtu"):
        assert (folder / name).stat().st_size == (tmp_path / "one" / name).stat().st_size
    words = [str(tmp_path / "across.edp"), "-mesh", str(tmp_path / "cell.mesh"), "-x", "0.7", *words]
    shutil.copytree(folder, tmp_path / "half")
    for path in (tmp_path / "half").glob("restart_000000012*"):
        path.unlink()
    ranks(2, *words, "-restart", tmp_path / "half")
    assert_near(tmp_path / "one", tmp_path / "half")


@pytest.mark.slow
@pytest.mark.parametrize("number, words", [
    (2, ["cases/sphere_lattice.edp", "-tend", "0.06"]),
    (3, ["cases/sphere_lattice.edp", "-tend", "0.06", "-lattice", "body", "-x", "0.03", "-y", "0.97"]),
    (3, ["cases/settling_sphere.edp", "-tend", "0.2", "-forces", "1", "-budget", "1"]),
    (2, ["cases/held_sphere.edp", "-tend", "0.5"]),
    (3, ["cases/sphere_array.edp", "-tend", "0.05"]),
    (2, ["cases/two_spheres.edp", "-tend", "0.03"]),
    (2, ["cases/settling_sphere.edp", "-z", "0.0085", "-tend", "0.05", "-film", "1", "-budget", "1"]),
    (3, ["cases/settling_sphere.edp", "-tend", "0.1", "-direct", "100", "-budget", "1"]),
    (2, ["cases/held_sphere.edp", "-tend", "0.5", "-direct", "0"]),  # an outlet
    (3, ["cases/sphere_lattice.edp", "-tend", "0.06", "-direct", "0"]),
])
def test_scenes(tmp_path, number, words):
    compare(number, tmp_path, *words)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A closed box of 60 x 60 x 60 mm, 3 elements to the diameter of a sphere of 15 mm."""
    return make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "settling_sphere", "--part", "whole", "--width", 0.06, "--height",
        0.06, "--corridor-top", 0.06, "--corridor", 0.03, "--size", 0.005)


def with_a_lid(box, lid):
    """Writes the mesh of a box to the file `lid`, with the label 7 on the triangles of its top."""
    lines = box.read_text().splitlines()
    first = lines.index("Vertices") + 2
    top = {k + 1 for k, line in enumerate(lines[first : first + int(lines[first - 1])]) if float(line.split()[2]) > 0.0599}
    first = lines.index("Triangles") + 2
    for k in range(first, first + int(lines[first - 1])):
        corners = lines[k].split()[:3]
        if set(map(int, corners)) <= top:
            lines[k] = " ".join([*corners, "7"])
    lid.write_text("\n".join(lines) + "\n")
    return lid


@pytest.mark.slow
def test_a_wall_that_moves_rubs_on_a_sphere(box, tmp_path):
    """The lid of a cavity moves along itself; a light sphere is pressed against it, and a heavy one lies on the floor."""
    case = tmp_path / "lid.edp"
    spheres = "bodySphere(0.01, 0, 0.0524, R, 400); bodySphere(-0.015, 0, 0.0076, R, 2500);"
    case.write_text(SCENE.format(particles=spheres, more=LID))
    folder = compare(2, tmp_path, case, "-mesh", with_a_lid(box, tmp_path / "lid.mesh"), "-tend", "0.1", "-friction", "0.3",
        "-friction-wall", "0.3")
    assert abs(numbers(folder, "contacts.csv")["fx"]).max() > 0


@pytest.mark.slow
def test_a_run_whose_energy_grows_from_nothing_ends_with_one_line(box, tmp_path):
    """The fluid is made faster in an included file, so that the case itself reads nothing of the flow."""
    faster = "macro caseStep() if (driveStep == 9) { spaceU *= 3.; spaceV *= 3.; spaceW *= 3.; } // EOM\n"
    (tmp_path / "kick.idp").write_text(faster)
    case = tmp_path / "grows.edp"
    case.write_text(SCENE.format(particles="bodySphere(0, 0, 0.04, R, 1800);", more=f'{CLOSED}include "{tmp_path}/kick.idp"'))
    words = [case, "-mesh", box, "-tend", "0.2", "-cfl", "0"]
    one = run_freefem(*words, "-out", tmp_path / "one", check=False)
    two = ranks(2, *words, "-out", tmp_path / "two", check=False)
    said = [re.sub(r"\d+\.\d+", lambda number: f"{float(number.group()):.3f}", line) for run in (one, two)
        for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert one.returncode == two.returncode == 4 and len(said) == 2 and said[0] == said[1] and "near sphere 0" in said[0]


@pytest.mark.slow
@pytest.mark.parametrize("more", [
    "macro caseStep() { real[int] row = [timeNow, spaceU[3]]; outRow(\"mine.csv\", row); } // EOM",
    "macro volumeOfAll() int3d(Th)(1.) // EOM\nmacro caseStep() { real[int] row = [timeNow, volumeOfAll]; outRow(\"mine.csv\", row); } // EOM",
    "macro caseStart() { real size = int2d(Th)(1.); } // EOM",
])
def test_a_case_that_reads_the_mesh_or_the_flow_is_refused(box, tmp_path, more):
    case = tmp_path / "own.edp"
    case.write_text(SCENE.format(particles="bodySphere(0, 0, 0.04, R, 1800);", more=CLOSED + more))
    run = ranks(2, case, "-mesh", box, "-out", tmp_path / "run", check=False)
    lines = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert run.returncode == 3 and len(lines) == 1 and "spaceValues" in lines[0], run.stdout[-2000:] + run.stderr


@pytest.mark.slow
def test_what_follows_the_driver_sees_the_whole_flow(box, tmp_path):
    case = tmp_path / "after.edp"
    after = "cout << \"energy \" << int3d(Th)(square(mine)) << \" \" << spaceU.n << \" \" << spaceP.n << endl;"
    case.write_text(SCENE.format(particles="bodySphere(0.005, 0, 0.04, R, 1800);", more=CLOSED)
        + "fespace afterWh(Th, P2);\nafterWh mine;\nmine[] = spaceW;\n" + after)
    said = [re.search(r"energy (\S+) (\d+) (\d+)", run.stdout).groups() for run in (
        run_freefem(case, "-mesh", box, "-tend", "0.03", "-out", tmp_path / "one"),
        ranks(2, case, "-mesh", box, "-tend", "0.03", "-out", tmp_path / "two"))]
    assert said[0][1:] == said[1][1:] and 0 < float(said[0][0]) == pytest.approx(float(said[1][0]), rel=1e-5)


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    """The words of a run in a coarse pipe, in which spheres enter, collide with friction, and one leaves."""
    folder = tmp_path_factory.mktemp("pipe")
    mesh = make_mesh(folder / "pipe.mesh", "pipe_spheres", "--size", 0.12)
    spheres = folder / "spheres.csv"
    spheres.write_text("id,x,y,z,radius,density,u,v,w\n10,2.56,0,0.1,0.1,3,3,0,0\n11,0.5,0.1,-0.38,0.1,1.5,0,0,-0.5\n")
    return ["cases/pipe_spheres.edp", "-mesh", mesh, "-number", "2", "-particles", spheres, "-enter", "3", "-enter-every", "0.05",
        "-dt", "0.02", "-cfl", "0", "-friction", "0.3", "-friction-wall", "0.2", "-forces", "1", "-fields", "0.1", "-checkpoint",
        "4", "-tend", "0.24"]


@pytest.fixture(scope="module")
def on_two(pipe, tmp_path_factory):
    folder = tmp_path_factory.mktemp("two") / "run"
    ranks(2, *pipe, "-out", folder)
    return folder


@pytest.mark.slow
def test_spheres_that_enter_touch_and_leave(pipe, on_two, tmp_path):
    run_freefem(*pipe, "-out", tmp_path / "one")
    assert_near(tmp_path / "one", on_two)
    ranks(3, *pipe, "-out", tmp_path / "three")
    assert_near(tmp_path / "one", tmp_path / "three")
    assert len(set(numbers(on_two, "particles.csv")["id"])) == 7
    for table in ("exits.csv", "contacts.csv", "forces.csv"):
        assert len((on_two / table).read_text().splitlines()) > 1, table
    assert set(np.atleast_1d(numbers(on_two, "exits.csv")["label"])) == {2}  # the outlet
    assert (on_two / "fields_0000010.vtu").stat().st_size == (tmp_path / "one/fields_0000010.vtu").stat().st_size


@pytest.mark.slow
def test_killed_and_restarted_on_two_processes(pipe, on_two, tmp_path):
    """One process is killed, as for want of memory: all end, and the rest gives the same bytes."""
    folder = tmp_path / "run"
    run = subprocess.Popen([launcher(), "-np", "2", *map(str, pipe), "-out", str(folder)], cwd=ROOT,
        env=os.environ | MPI_ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    limit = time.time() + LIMIT
    while not (folder / "restart_000000008.sha").exists():
        assert run.poll() is None and time.time() < limit
        time.sleep(0.02)
    os.kill(int(re.search(r'"pid": (\d+)', (folder / "run.json").read_text()).group(1)), signal.SIGKILL)
    assert run.wait(timeout=60) != 0
    ranks(2, *pipe, "-restart", folder)
    assert_same(folder, on_two)
    for name in ("restart_000000012.txt", "restart_000000012.list", "fields_0000010.vtu"):
        assert (folder / name).read_bytes() == (on_two / name).read_bytes(), name


@pytest.mark.slow
def test_checkpoints_serve_any_number_of_processes(pipe, tmp_path):
    """The wall-clock time ends a run on two processes after a step; one and three go on from it, and one run is whole."""
    folder = tmp_path / "half"
    ranks(2, *pipe, "-maxwall", "0.001", "-out", folder)
    assert "stopped" in (folder / "run.json").read_text()
    for other in ("one", "three"):
        shutil.copytree(folder, tmp_path / other)
    run_freefem(*pipe, "-restart", tmp_path / "one")
    ranks(3, *pipe, "-restart", tmp_path / "three")
    run_freefem(*pipe, "-out", tmp_path / "whole")
    assert_near(tmp_path / "whole", tmp_path / "one")
    assert_near(tmp_path / "whole", tmp_path / "three")
