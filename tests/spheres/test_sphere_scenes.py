"""Scenes of spheres in a flow: entering spheres, rolling with friction, budgets of momentum and energy, the guard of the energy."""
import numpy as np
import pytest

from tests.conftest import ROOT, make_mesh
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table

SCENE = """
include "lib/spheres/case.idp"
optCase("scene", "spheres of tests/spheres");
optDefault("-dt", "0.01");
real rhoFluid = 960, mu = 0.058, gravityX = {slope}, gravityY = 0, gravityZ = -9.81, R = 0.0075;
int[int] flowNoSlip = [labelWall], flowSlip(0), flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {particles} // EOM
{more}
include "scripts/spheres.edp"
"""


def scene(particles, slope=0.0, more=""):
    return SCENE.format(particles=particles, slope=slope, more=more)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A closed box of 60 x 60 x 60 mm, 3 elements to the diameter of a sphere of 15 mm."""
    return make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "settling_sphere", "--part", "whole", "--width", 0.06, "--height",
        0.06, "--corridor-top", 0.06, "--corridor", 0.03, "--size", 0.005)


@pytest.fixture(scope="module")
def coarse_box(tmp_path_factory):
    """The same with 2 elements to the diameter."""
    return make_mesh(tmp_path_factory.mktemp("box") / "coarse.mesh", "settling_sphere", "--part", "whole", "--width", 0.06,
        "--height", 0.06, "--corridor-top", 0.06, "--corridor", 0.03, "--size", 0.0075)


def test_waiting_spheres_enter_when_due_and_when_there_is_room(coarse_box, freefem_text, tmp_path):
    """One is due at 0.02 s, one at once where another falls out of its way, one where a held sphere stays; they come with the
    motion of the fluid, and a restart between two entries continues byte for byte."""
    fill = "bodySphere(0, 0, 0.036, R, 2500); sphereHeld(bodySphere(-0.02, 0, 0.01, R, 1000));" \
        " sphereWaits(0.02, 0, 0.04, R, 1000, 0.02); sphereWaits(0, 0, 0.046, R, 1000, 0); sphereWaits(-0.02, 0, 0.02, R, 1000, 0);"
    options, run = ["-mesh", coarse_box, "-cfl", 0, "-tend", 0.09, "-checkpoint", 5], tmp_path / "run"
    done = freefem_text(scene(fill), *options, "-out", run)
    said = done.stdout + done.stderr
    assert "1 of the waiting spheres was due, but had no room" in said and "(-0.02, 0, 0.02)" in said
    rows = read_table(run / "particles.csv")
    first = {int(k): rows["t"][rows["id"] == k].min() for k in np.unique(rows["id"])}
    assert set(first) == {0, 1, 2, 3} and first[2] == pytest.approx(0.02) and 0.045 < first[3] < 0.09
    came = read_table(run / "entries.csv")
    assert came["id"].tolist() == [0, 1, 2, 3] and came["t"].tolist() == [0, 0, first[2], first[3]]
    t = rows["t"] == first[3]
    falling, entered = (rows["id"] == 0) & t, (rows["id"] == 3) & t
    assert rows["z"][entered][0] - rows["z"][falling][0] > 2.05 * 0.0075 * (1 - 1e-3)
    assert rows["w"][falling][0] < rows["w"][entered][0] < 0  # it is in the wake
    assert read_table(run / "fluid.csv")["worst_gap"].min() > -1e-6 * 0.0075
    whole = (run / "particles.csv").read_text().splitlines()
    for file in run.glob("restart_000000009.*"):
        file.unlink()
    freefem_text(scene(fill), *options, "-restart", run, "-out", tmp_path / "again")
    again = (tmp_path / "again/particles.csv").read_text().splitlines()[1:]
    assert len(again) > 10 and again == whole[-len(again):]


def test_a_whole_box_of_mirror_images_is_its_quarter(freefem, tmp_path):
    """A sphere that falls on the axis, with three motions between planes of symmetry and with six in the four images of that mesh:
    the same velocity, none aside, no spin. What is left comes from the tolerances of the solvers."""
    size = ["--width", 0.06, "--height", 0.06, "--corridor-top", 0.06, "--corridor", 0.015, "--size", 0.005]
    fall = []
    for part in ("quarter", "mirrored"):
        mesh = make_mesh(tmp_path / f"{part}.mesh", "settling_sphere", "--part", part, *size)
        freefem(ROOT / "cases/settling_sphere.edp", "-mesh", mesh, "-z", 0.035, "-tend", 0.1, "-out", tmp_path / part)
        fall.append(read_table(tmp_path / part / "particles.csv"))
    assert fall[1]["w"] == pytest.approx(fall[0]["w"], rel=2e-3) and fall[0]["w"][-1] < -0.03
    for aside in ("x", "y", "u", "v"):
        assert abs(fall[1][aside]).max() < 1e-9
    assert max(abs(fall[1][spin]).max() for spin in ("omega_x", "omega_y", "omega_z")) < 1e-7


@pytest.mark.slow
def test_spheres_cannot_enter_a_wall(box, freefem_text, tmp_path):
    run = freefem_text(scene("sphereWaits(0, 0, 0.004, R, 1000, 0);"), "-mesh", box, "-out", tmp_path / "run", check=False)
    assert run.returncode == 5 and "enters into a wall" in run.stderr and run.stderr.count("\n") == 1


def test_a_sphere_rolls_down_the_floor_and_the_budget_closes(box, freefem_text, tmp_path):
    """With friction, U = omega x R e on a floor with gravity aslant, and the contact carries a tangential force towards uphill; one
    with a coefficient that is too small slides with the force mu n. Momentum: what walls, contacts and weights give, within 1 % of
    the weight's impulse."""
    text, run = scene("bodySphere(-0.015, 0.013, R, R, 1800); sphereRough(bodySphere(-0.015, -0.013, R, R, 1800), 0.05);",
        slope=4.0), tmp_path / "run"
    freefem_text(text, "-mesh", box, "-tend", 0.12, "-dt", 0.005, "-friction", 0.3, "-budget", 1, "-out", run)
    rows, touch, budget = (read_table(run / f"{name}.csv") for name in ("particles", "contacts", "budget"))
    last = rows["t"] == rows["t"].max()
    slip = (rows["u"] - 0.0075 * rows["omega_y"])[last]
    rolls, slides = touch["i"][-2:] == 0, touch["i"][-2:] == 1
    press, pull, sliding = (touch[name][-2:] for name in ("impulse", "fx", "sliding"))
    assert (rows["u"][last] > 0.03).all() and rows["z"][last] == pytest.approx(0.0075, abs=1e-9)
    assert abs(slip[0]) < 1e-6 * rows["u"][last][0] and sliding[rolls] == 0 and -0.3 * press[rolls] < pull[rolls] < 0
    assert slip[1] > 0.005 and sliding[slides] == 1 and pull[slides] == pytest.approx(-0.05 * press[slides], rel=1e-2)
    for axis in "xz":
        missing = budget[f"momentum_{axis}"][-1] - budget[f"walls_{axis}"][-1] - budget[f"weight_{axis}"][-1]
        assert abs(missing) < 0.01 * abs(budget[f"weight_{axis}"][-1])


def test_a_run_whose_energy_grows_from_nothing_is_stopped(coarse_box, freefem_text, tmp_path):
    more = "macro caseStep() if (driveStep == 9) { spaceU *= 3.; spaceV *= 3.; spaceW *= 3.; } // EOM"
    run = freefem_text(scene("bodySphere(0, 0, 0.04, R, 1800);", more=more), "-mesh", coarse_box, "-tend", 0.2, "-cfl", 0, "-out",
        tmp_path / "run", check=False)
    assert run.returncode == 4 and "kinetic energy is" in run.stderr and "near sphere 0" in run.stderr and "t = 0.1" in run.stderr


THROAT = """
load "msh3"
mesh3 T = cube(4, 4, 8, [x - 0.5, y - 0.5, 2*z]);
int[int] sides = [1, 3, 2, 3, 3, 3, 4, 3, 5, 1, 6, 2];
T = change(T, label = sides);
savemesh(trunc(T, !(z > 1 && z < 1.2 && (abs(x) > 0.25 || abs(y) > 0.25)), label = 4), "FILE");
"""
STREAM = """
include "lib/spheres/case.idp"
optCase("throat", "a stream carries a sphere to a throat");
optDefault("-dt", "0.05");
real rhoFluid = 1, mu = 0.1, gravityX = 0, gravityY = 0, gravityZ = 0, R = optReal("-radius", 0.4, "", "radius");
int[int] flowNoSlip = [labelWall, labelDiaphragm], flowSlip(0), flowMoving = [labelInlet], flowOutlet = [labelOutlet];
macro boundaryW() 16*(0.25 - x^2)*(0.25 - y^2) // EOM
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodySphere(0, 0, 0.65, R, 1); // EOM
include "scripts/spheres.edp"
"""


@pytest.mark.parametrize("radius", [0.4, pytest.param(0.2, marks=pytest.mark.slow)])
def test_a_sphere_that_shuts_a_throat_ends_the_run_in_words(freefem_text, tmp_path, radius):
    """An opening of 0.5 is too narrow for a sphere of 0.8: status 4, with its number; one of 0.4 passes, and the run goes on."""
    freefem_text(THROAT.replace("FILE", str(tmp_path / "throat.mesh")))
    words = ["-mesh", tmp_path / "throat.mesh", "-radius", radius, "-tend", 8, "-out", tmp_path / "run"]
    run = freefem_text(STREAM, *words, check=False)
    if radius == 0.2:
        assert run.returncode == 0 and read_table(tmp_path / "run/exits.csv")["id"].tolist() == [0]
        return
    assert run.returncode == 4 and run.stderr.count("\n") == 1
    assert "label 1 (inlet) cannot reach an outlet: sphere 0 leaves" in run.stderr


@pytest.mark.parametrize("fill, step, words, status, said", [
    ("sphereMoves(bodySphere(0, 0, 0.03, R, 1000), 0, sqrt(-1.), 0);", "", [], 3, "the velocities must be numbers"),
    ("sphereSpins(bodySphere(0, 0, 0.03, R, 1000), 1e40, 0, 0);", "", [], 3, "sphereSpins(0, 1e+40, 0, 0): the velocities"),
    ("bodySphere(0, 0, 0.03, R, 1000);", "sphereForce[2] = sqrt(-1.)", [], 3, "caseStep has given sphere 0 a force"),
    ("bodySphere(0, 0, 0.03, R, 1000);", "sphereQ[3] = 1e200", [], 3, "caseStep has given sphere 0 a velocity"),
    ("bodySphere(0, 0, 0.03, R, 1000); sphereWallRough(labelTop, 0.3);", "", ["-friction", 1], 3, "the mesh has no wall with"),
    ("sphereMoves(bodySphere(0, 0, 0.03, R, 1000), 1e20, 0, 0);", "", [], 4, "-cfl allows no more than steps of"),
])
def test_what_makes_no_flow_ends_in_one_line(fill, step, words, status, said, coarse_box, freefem_text, tmp_path):
    """Numbers that are none, walls that are not there, and a sphere that is too fast for any step."""
    more = f"macro caseStep() {step}; // EOM" if step else ""
    run = freefem_text(scene(fill, more=more), "-mesh", coarse_box, "-tend", 0.05, *words, "-out", tmp_path / "run", check=False)
    assert run.returncode == status and said in run.stderr and run.stderr.count("\n") == 1, run.stderr


DRY = """
include "lib/spheres/case.idp"
optCase("dry", "a sphere and a floor");
real gravityX = 0, gravityY = 0, gravityZ = -9.81;
func int floors() {{ real[int] o = [-1, -1, 0], a = [2, 0, 0], b = {side}; return sphereWall(o, a, b); }}
macro caseWalls() floors(); // EOM
macro caseParticles() bodySphere(0, 0, 0.2, 0.1, 1000); {more} // EOM
{macros}
include "scripts/contact_spheres.edp"
"""


@pytest.mark.parametrize("side, more, macros, said", [
    ("[0, 2]", "", "", "three coordinates each, not 3, 3 and 2"),
    ("[0, sqrt(-1.), 0]", "", "", "triangle 1 of the walls has a corner that is not finite"),
    ("[0, 2, 0]", "sphereSpins(0, sqrt(-1.), 0, 0);", "", "the velocities must be numbers"),
    ("[0, 2, 0]", "sphereWallRough(1, 0.3);", "", "walls of contacts alone have no labels"),
    ("[0, 2, 0]", "sphereWaits(0, 0, 1, 0.1, 1000, 1);", "", "are for flows; contacts alone have"),
    ("[0, 2, 0]", "", "macro flowPeriodicLabels() [1, 2] // EOM", "flowPeriodicLabels is for flows"),
])
def test_what_makes_no_scene_of_contacts_alone_is_refused(side, more, macros, said, freefem_text, tmp_path):
    """A spin that is no number went through all steps to tables of nan with status 0, and what is for flows was passed over."""
    text = DRY.format(side=side, more=more, macros=macros)
    run = freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert run.returncode == 3 and said in run.stderr and run.stderr.count("\n") == 1, run.stderr


STEP = """
load "msh3"
mesh3 T = cube(8, 4, 8, [2*x, y, 2*z]);
int[int] sides = [1, 3, 2, 3, 3, 3, 4, 3, 5, 3, 6, 1];
T = change(T, label = sides);
T = trunc(T, !(x > 1 && z < 1), label = 2);
savemesh(change(T, flabel = (label == 2 && abs(x - 1) < 1e-6) ? 3 : label), "FILE");
"""
LEAVES = """
include "lib/spheres/case.idp"
optCase("step", "a sphere falls out of a box; others are moved");
real rhoFluid = 1, mu = 0.1, gravityX = 0, gravityY = 0, gravityZ = -40;
int[int] flowNoSlip = [labelWall], flowSlip(0), flowMoving(0), flowOutlet = [labelInlet, labelOutlet];
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodySphere(1.5, 0.5, 1.1, 0.3, 8); sphereHeld(bodySphere(0.5, 0.5, 1.5, 0.3, 1));
    sphereHeld(bodySphere(0.5, 0.5, 0.5, 0.3, 1)); // EOM
int[int] place(3);
macro caseStep() sphereMoves(1, 0, 0, timeNow); sphereMoves(2, 0, 20.*(timeNow > 0.43), 0);
    if (timeNow > 0.43) sphereMoves(0, 9, 9, 9);
    for (int k = 0; k < 3; ++k) place[k] = sphereAt(k); // EOM
include "scripts/spheres.edp"
cout << "places " << place[0] << " " << place[1] << " " << place[2] << endl;
"""


def test_spheres_keep_their_numbers_when_one_leaves_by_an_outlet_within_the_box(freefem_text, tmp_path):
    """The outlet lies in the middle of the box around the mesh: the sphere was kept in the void below it, and then `caseStep` moved
    another sphere than it named. One that is moved out of the mesh was kept too."""
    freefem_text(STEP.replace("FILE", str(tmp_path / "step.mesh")))
    done = freefem_text(LEAVES, "-mesh", tmp_path / "step.mesh", "-dt", 0.025, "-cfl", 0,
        "-tend", 0.5, "-out", tmp_path / "run")
    assert "places -1 0 -1" in done.stdout and "moved sphere 2 has left the mesh" in done.stdout + done.stderr
    gone, rows = read_table(tmp_path / "run/exits.csv"), read_table(tmp_path / "run/particles.csv")
    assert gone["id"].tolist() == [0, 2] and gone["label"][0] == 2 and 0.4 < gone["z"][0] < 0.7
    run = RunFolder(tmp_path / "run")
    came = run.table("entries")
    assert came["id"].tolist() == [0, 1, 2] and came["free"].tolist() == [1, 0, 0] and not came["t"].any() and run.held == {1, 2}
    assert run.fluid["particles"][0] == 1 and run.fluid["particles"][-1] == 0  # held ones do not count
    first, second = rows["id"] == 1, rows["id"] == 2
    assert rows["w"][first][1:] == pytest.approx(rows["t"][first][1:] - 0.025, abs=1e-9) and not rows["v"][first].any()
    assert not rows["w"][second].any() and rows["y"][second][-1] < 1


THROWN = """
include "lib/spheres/case.idp"
optCase("thrown", "a sphere that is thrown in a box of fluid at rest");
optDefault("-mesh", "meshes/settling_sphere.mesh");
real rhoFluid = 960, mu = 0.0058, gravityX = 0, gravityY = 0, gravityZ = 0;
int[int] flowNoSlip = [labelWall], flowSlip = [labelLeft, labelFront], flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {{ bodySphere(0, 0, 0.08, 0.0075, {density}); sphereMoves(0, 0, 0, -0.1); }} // EOM
include "scripts/spheres.edp"
"""


@pytest.mark.parametrize("ratio, within", [(0.06, 0.2), (1, 0.05), (5, 0.02)])
def test_a_thrown_sphere_keeps_the_share_of_its_velocity_that_its_added_mass_leaves_it(ratio, within, freefem_text, tmp_path):
    """s/(s + 1/2) in a wide fluid; four elements per diameter, steps so short that viscosity hardly acts. Continued from the first
    step the rest is the same, byte for byte."""
    run, rest = tmp_path / "run", tmp_path / "rest"
    text = THROWN.format(density=960 * ratio)
    freefem_text(text, "-dt", 0.0005, "-cfl", 0, "-tend", 0.002, "-checkpoint", 1, "-out", run)
    speed = -read_table(run / "particles.csv")["w"]
    assert speed[:5] / 0.1 == pytest.approx(ratio / (ratio + 0.5), rel=within)
    if ratio == 1:
        freefem_text(text, "-dt", 0.0005, "-cfl", 0, "-tend", 0.001, "-checkpoint", 1, "-out", rest)
        freefem_text(text, "-dt", 0.0005, "-cfl", 0, "-tend", 0.002, "-restart", rest)
        assert (rest / "particles.csv").read_bytes() == (run / "particles.csv").read_bytes()


def test_light_spheres_thrown_aslant_and_at_each_other_lose_energy_and_share_momentum(box, freefem_text, tmp_path):
    """A sphere of 0.06 times the density, thrown aslant between the axes of the mesh, keeps s/(s + 1/2) of its velocity. Four that
    touch each other and share elements leave less energy than was thrown, and what momentum is left they have with the fluid."""
    R, density, words = 0.0075, 0.06 * 960, ["-mesh", box, "-dt", 0.0005, "-cfl", 0, "-tend", 0.001, "-budget", 1]
    thrown = 0.1 * np.array([1, 2, -0.5]) / np.sqrt(5.25)
    def still(fill):
        return scene(fill).replace("gravityZ = -9.81", "gravityZ = 0")
    freefem_text(still(f"sphereMoves(bodySphere(0.001, 0, 0.031, R, {density}), {', '.join(map(str, thrown))});"), *words,
        "-out", tmp_path / "one")
    row = read_table(tmp_path / "one/particles.csv")
    velocity = np.array([row["u"][0], row["v"][0], row["w"][0]])
    assert velocity @ thrown / 0.01 == pytest.approx(0.06 / 0.56, rel=0.2)
    assert np.linalg.norm(velocity - velocity @ thrown * thrown / 0.01) < 0.01 * 0.1
    at = 1.001 * R * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(2) + [0, 0, 0.03]
    speed = 0.1 * np.array([[1, 0.3, 0], [-0.5, 1, 0.2], [0.4, -1, 1], [-1, 0, -0.6]])
    fill = "".join(f"sphereMoves(bodySphere({', '.join(map(str, a))}, R, {density}), {', '.join(map(str, v))});"
        for a, v in zip(at, speed))
    freefem_text(still(fill), *words, "-out", tmp_path / "four")
    mass = 4 / 3 * np.pi * R**3 * density
    assert 0 < read_table(tmp_path / "four/budget.csv")["kinetic_energy"][0] < 0.3 * mass / 2 * (speed**2).sum()


SHORT = """
load "msh3"
mesh3 T0 = cube(10, 10, 12, [3*x - 1.5, 3*y - 1.5, 3.6*z]);
int[int] sides = [1, 3, 2, 4, 3, 5, 4, 6, 5, 1, 6, 2];
mesh3 T = change(T0, label = sides);
savemesh(T, "FILE");
"""
CARRIED = """
include "lib/spheres/case.idp"
optCase("carried", "a sphere is let go in a uniform stream");
real given = optReal("-given", 1, "m/s", "its velocity");
real rhoFluid = 1, mu = 0.001, gravityX = 0, gravityY = 0, gravityZ = 0;
int[int] flowNoSlip(0), flowSlip = [3, 4, 5, 6], flowMoving = [labelInlet], flowOutlet = [labelOutlet];
macro boundaryW() 1 // EOM
func real boundaryRamp(real t) { return 1; }
macro caseStart() spaceW = 1.; // EOM
macro caseParticles() sphereMoves(bodySphere(0, 0, 1.8, 0.5, 0.06), 0, 0, given); // EOM
include "scripts/spheres.edp"
"""


def test_a_light_sphere_let_go_in_a_stream_shares_its_momentum_with_it(freefem_text, tmp_path):
    """With the velocity of a stream a sphere feels nothing. With another one it keeps s/(s + 1/2) of the difference, as in a fluid
    at rest."""
    freefem_text(SHORT.replace("FILE", str(tmp_path / "box.mesh")))
    words = ["-mesh", tmp_path / "box.mesh", "-dt", 0.002, "-cfl", 0, "-tend", 0.006]
    freefem_text(CARRIED, *words, "-out", tmp_path / "same")
    rows = read_table(tmp_path / "same/particles.csv")
    assert rows["w"] == pytest.approx(1, abs=1e-6) and np.abs(rows["u"]).max() < 1e-6
    freefem_text(CARRIED, *words, "-given", 0, "-out", tmp_path / "rest")
    assert 1 - read_table(tmp_path / "rest/particles.csv")["w"] == pytest.approx(0.06 / 0.56, rel=0.2)
