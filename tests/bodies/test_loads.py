"""Forces on free bodies that a case says (caseLoads): against weight, exact motions, and what is refused."""
import shutil

import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import case
from tests.tables import force
from tools.base.run_folder import RunFolder


def scene(bodies, loads, mu=0.05, gravity=0, **sides):
    """The text of a case with loads; sides: labels, the four of the unit square by default."""
    text = case(bodies, more=f"macro caseLoads(now) {loads} // EOM", **sides)
    return text.replace("mu = 0.05", f"mu = {mu}").replace("gravityY = -1", f"gravityY = {gravity}")


def test_a_load_of_the_weight_moves_a_disk_as_the_weight_does(freefem_text, tmp_path):
    """Less the buoyancy; the fall is as far from zero as the gap to rounding is not."""
    body, load = "bodyDisk(0.4, 0.6, 0.12, 2.5); bodyEllipse(0.7, 0.3, 0.1, 0.06, 0.4, 0.5);", []
    for number, (area, excess) in enumerate(((np.pi * 0.12**2, 1.5), (np.pi * 0.1 * 0.06, -0.5))):
        load.append(f"bodyPush({number}, 0, {float(-area * excess)!r}, 0);")
    runs = []
    for name, text in (("weight", scene(body, "", gravity=-1)), ("load", scene(body, " ".join(load)))):
        freefem_text(text, "-dt", 0.01, "-cfl", 0, "-every", 0.05, "-tend", 0.3, "-out", tmp_path / name, "-forces", 1)
        runs.append(RunFolder(tmp_path / name))
    first, second = (run.particles for run in runs)
    assert abs(first["v"]).max() > 0.02
    for column in ("x", "y", "theta", "u", "v", "omega"):
        np.testing.assert_allclose(second[column], first[column], atol=1e-9)
    for column in ("fx", "fy", "torque"):
        np.testing.assert_allclose(runs[1].table("forces")[column], runs[0].table("forces")[column], atol=1e-9)


# the light one was 3.3 % off while its virtual mass lagged by a step
@pytest.mark.parametrize("density, within", [(2, 0.015), (0.1, 0.015)])
def test_a_disk_that_is_pushed_to_and_fro_moves_as_it_must(density, within, freefem_text, tmp_path):
    """In a container, amplitude some hundredths of its radius: m dU/dt = load + fluid, the fluid's share exact
    (tests/bodies/test_given_motion.py)."""
    steps, push = 60, 0.1
    text = f'border c(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}\nsavemesh(buildmesh(c(160)), "{tmp_path / "round.mesh"}");\n'
    text += scene(f"bodyDisk(0.003, 0.007, 0.2, {density});", f"bodyPush(0, {push}*cos(2*pi*(now)), 0, 0);", mu=0.02,
        walls="labelWall")
    freefem_text(text, "-mesh", tmp_path / "round.mesh", "-convection", 0, "-every", 0, "-dt", 1 / steps, "-cfl", 0, "-tend", 4,
        "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    last = rows["t"] > 3 + 0.5 / steps
    assert last.sum() == steps
    found = 2 * np.mean(rows["u"][last] * np.exp(-2j * np.pi * rows["t"][last]))
    rate = 2 * np.pi
    exact = push / (1j * rate * density * np.pi * 0.2**2 - force(0.2, 1, 1, 0.02, rate))
    assert abs(found / exact - 1) < within, found / exact


def test_a_light_disk_on_a_spring_comes_to_rest(freefem_text, tmp_path):
    """A tenth of the fluid's density, 27 steps a period: its swings as long as with 104 steps. The lag of its virtual mass made
    them die down half as fast as they must."""
    left = {}
    for steps in (27, 104):
        text = scene("bodyAdd(0.53, 0.5, 0.1, 0.1, 0, 0, 0, 1);", "bodyPush(0, 1.364*(0.5 - bodyAtX(0)), 0, 0);", mu=5e-4)
        freefem_text(text, "-dt", 1 / steps, "-cfl", 0, "-every", 0, "-tend", 4, "-out", tmp_path / f"run_{steps}")
        rows = RunFolder(tmp_path / f"run_{steps}").particles
        left[steps] = abs(rows["x"][rows["t"] > 3] - 0.5).max()
    assert left[104] < 0.005
    assert left[27] == pytest.approx(left[104], rel=0.25)


def test_a_heavy_disk_on_a_spring_swings_with_its_own_period(freefem_text, tmp_path):
    """A thousand times as dense as the fluid, which bears on the period by its added mass, 1e-3 of it, alone."""
    mass = 1000 * np.pi * 0.1**2
    text = scene("bodyAdd(0.45, 0.5, 0.1, 1000, 0, 0, 0, 1);", f"bodyPush(0, {float(mass * (2 * np.pi)**2)!r}*(0.5 - "
        f"bodyAtX(0)), 0, 0);", mu=0.001)
    freefem_text(text, "-dt", 0.01, "-cfl", 0, "-every", 0, "-tend", 2, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    away, t = rows["x"] - 0.5, rows["t"]
    assert abs(away).max() < 0.0505
    crossing = np.flatnonzero(np.diff(np.sign(away)))
    times = t[crossing] - away[crossing] * (t[crossing + 1] - t[crossing]) / (away[crossing + 1] - away[crossing])
    assert len(times) == 4
    assert np.diff(times).mean() == pytest.approx(0.5, rel=0.003)


def test_steps_of_any_sizes_are_of_second_order(freefem_text, tmp_path):
    """A disk a million times as dense as the fluid, pushed by a force and a torque that grow evenly, while it falls: velocities
    quadratic in time are exact in
    steps that -cfl makes longer and shorter, but for the first one, and so are places where velocities are linear. What is left is
    the fluid, 1e-6."""
    mass, moment = 1e6 * np.pi * 0.1**2, 1e6 * np.pi * 0.1**4 / 2
    text = scene("bodyDisk(0.3, 0.3, 0.1, 1e6);", f"bodyPush(0, {30 * mass}*now, 0, {40 * moment}*now);", mu=0.001, gravity=2)
    freefem_text(text, "-dt", 0.02, "-cfl", 0.4, "-tend", 0.4, "-every", 0, "-tolerance", 1e-10, "-convection", 0, "-out",
        tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    rows, step = run.particles, run.fluid["dt"]
    ratio = step[13:] / step[12:-1]
    assert ratio.min() < 0.6 and ratio.max() > 1.15 and (step[1:] * run.fluid["top_speed"][:-1]).max() < 0.4 / 32  # of elements
    for found, exact, within in (("u", 15 * rows["t"] ** 2, 2e-6), ("omega", 20 * rows["t"] ** 2, 5e-6), ("v", 2 * rows["t"],
        2e-6), ("y", rows["t"] ** 2, 1e-6)):
        assert abs(np.diff(rows[found] - exact)[11:]).max() < within, found


def test_a_force_that_changes_its_sign_again_and_again_does_not_stir_the_fluid(freefem_text, tmp_path):
    """Every other step, on a light disk: only the first is an onset. With the accelerations of each made fit the fluid had twenty
    times the speed that the force gives."""
    step, ratio = 0.005, 0.1
    text = scene(f"bodyDisk(0.4, 0.6, 0.12, {ratio});", f"bodyPush(0, 0.1*(lround(now/{step} - 1)/2 % 2 ? -1. : 1.), 0, 0);",
        mu=0.001)
    freefem_text(text, "-dt", step, "-cfl", 0, "-tend", 0.3, "-every", 0.1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    speed = 2 * step * 0.1 / (np.pi * 0.12**2 * (ratio + 1))
    assert abs(run.particles["u"]).max() < 1.2 * speed and run.fluid["top_speed"][-1] < 2 * speed


def test_a_spring_goes_on_when_another_particle_has_left(freefem_text, tmp_path):
    """Particle 0 leaves; 1 swings on about x = 0.4, damped by nothing but the fluid, a thousandth of its density."""
    rate = 4 * np.pi
    stiff = float(1000 * np.pi * 0.1**2 * rate**2)
    text = scene("bodyAdd(0.5, 0.8, 0.1, 1000, 3, 0, 0, 1); bodyDisk(0.3, 0.3, 0.1, 1000);",
                 f"bodyPush(0, 1e-6*(bodyAtY(0) + bodyAtTheta(0) + bodyAtU(0) + bodyAtV(0) + bodyAtOmega(0)), 0, 0); bodyPush(1, "
                     f"{stiff!r}*(0.4 - bodyAtX(1)), 0, 0);", mu=0.001)
    freefem_text(text.replace("motionBound = 1e30", "motionBound = 0.6"), "-dt", 0.005, "-cfl", 0, "-every", 0, "-tend", 0.5,
        "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.tracks[0]["t"][-1] < 0.1 and run.tracks[1]["t"][-1] == 0.5
    np.testing.assert_allclose(run.tracks[1]["x"], 0.4 - 0.1 * np.cos(rate * run.tracks[1]["t"]), atol=0.006)


@pytest.mark.parametrize("bodies, loads, complaint", [
    ("bodyDisk(0.4, 0.6, 0.12, 2);", "bodyPush(0, bodyAtV(3), 0, 0);", "the case asks for particle 3, which does not exist"),
    ("bodyHeld(77);", "bodyPush(0, 1, 0, 0);", "bodyHeld(77): there is no such particle"),
    ("bodyDisk(0.4, 0.6, 0.12, 2); bodyPinned(77);", "bodyPush(0, 1, 0, 0);", "bodyPinned(77): there is no such particle"),
    ("bodyHeld(bodyDisk(0.4, 0.6, 0.12, 2));", "bodyPush(0, 1, 0, 0);", "particle 0 is fixed"),
    ("bodyDisk(0.4, 0.6, 0.12, 2);", "bodyPush(7, 1, 0, 0);", "caseLoads pushes particle 7, which does not exist"),
    ("bodyDisk(0.4, 0.6, 0.12, 2);", "bodyPush(0, 1e301, 0, sqrt(-1.));", "is not finite"),
])
def test_what_loads_cannot_push_is_refused(freefem_text, tmp_path, bodies, loads, complaint):
    done = freefem_text(scene(bodies, loads), "-tend", 0.1, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and complaint in done.stderr


STREAM = dict(walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight")


def test_a_body_that_is_still_to_come_is_pushed_from_its_entry_on(freefem_text, tmp_path):
    """Of the two that wait the second enters first and is particle 1; it is pushed up."""
    text = scene("bodyDisk(0.7, 0.3, 0.1, 2); queueAdd(0.75, 0.1, 2, 9); queueAdd(0.25, 0.1, 2, 0.05);",
        "bodyPush(1, 0, 1, 0); bodyPush(2, 0, 1, 0);", **STREAM)
    text = text.replace("int[int] flowNoSlip", "macro boundaryU() (4*y*(1 - y)) // EOM\nint[int] flowNoSlip")
    freefem_text(text, "-tend", 0.2, "-every", 0, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    late = rows["id"] == 1
    assert set(rows["id"]) == {0, 1} and 0.03 < rows["t"][late][0] < 0.08
    assert rows["v"][late][-1] > 0.2 and abs(rows["v"][~late]).max() < 0.1


@pytest.mark.parametrize("more, complaint", [
    ("macro caseLoads(now) bodyPush(2, 0, 1, 0); // EOM", "caseLoads pushes particle 2, which does not exist"),
    ("macro caseMotion(now) givenMotion(1, 0, 1, 0); // EOM", "particle 1 has not entered yet and will move freely"),
    ("macro caseMotion(now) givenMotion(2, 0, 1, 0); // EOM", "caseMotion moves particle 2, which does not exist"),
])
def test_a_body_that_never_comes_or_moves_freely_then_is_refused(more, complaint, freefem_text, tmp_path):
    text = case("bodyDisk(0.7, 0.3, 0.1, 2); queueAdd(0.5, 0.1, 2, 9);", more=f"macro boundaryU() (4*y*(1 - y)) // EOM\n{more}",
        **STREAM)
    done = freefem_text(text, "-tend", 0.1, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and complaint in done.stderr and len(done.stderr.strip().splitlines()) == 1


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """A run of two particles of a file, of which 3 has left and 10 stays; 11 is still to come: (text of the scene without its load,
    words, folder of the run)."""
    folder = tmp_path_factory.mktemp("left")
    (folder / "disks.csv").write_text("id,x,y,radius,density,u\n10,0.4,0.3,0.1,2,0\n3,0.99,0.3,0.1,2,9\n")
    text = scene("queueAdd(0.75, 0.1, 2, 9);", "LOAD", **STREAM)
    text = text.replace("int[int] flowNoSlip", "macro boundaryU() (4*y*(1 - y)) // EOM\nint[int] flowNoSlip")
    (folder / "scene.edp").write_text(text.replace("LOAD", "bodyPush(10, 0, 0, 0);"))
    words = ["-particles", folder / "disks.csv", "-cfl", 0, "-every", 0, "-checkpoint", 4, "-tend"]
    run_freefem(folder / "scene.edp", *words, 0.04, "-out", folder / "run")
    assert RunFolder(folder / "run").fluid["particles"][-1] == 1
    return text, words, folder / "run"


@pytest.mark.parametrize("asked, there", [(10, True), (3, True), (11, True), (5, False), (0, False), (12, False)])
def test_ids_of_a_file_may_leave_gaps_where_nobody_is(asked, there, left, freefem_text, tmp_path):
    """A restart knows them, too."""
    text, words, run = left
    shutil.copytree(run, tmp_path / "run", ignore=shutil.ignore_patterns(".writer"))
    done = freefem_text(text.replace("LOAD", f"bodyPush({asked}, 0, 0, 0);"), *words, 0.05, "-restart", tmp_path / "run",
        check=False)
    assert done.returncode == (0 if there else 3) and (there
        or f"caseLoads pushes particle {asked}, which does not exist" in done.stderr)
    assert "goes on from t" in done.stdout or not there


def test_the_published_scheme_refuses_loads(freefem_text, tmp_path):
    done = freefem_text(scene("bodyDisk(0.4, 0.6, 0.12, 2);", "bodyPush(0, 1, 0, 0);"), "-scheme", "published", "-tend", 0.1,
        "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "caseLoads" in done.stderr and not (tmp_path / "run").exists()


def test_an_ellipse_on_a_pin_turns_as_one_that_is_free(freefem_text, tmp_path):
    """Where a free one keeps its place, in the middle between plates that move apart; the pin bears no force then."""
    turn, forces = [], []
    for name, body in (("free", "bodyEllipse(0.5, 0.5, 0.16, 0.1, 0.3, 1);"), ("pinned", "bodyPinned(bodyEllipse(0.5, 0.5, 0.16, "
        "0.1, 0.3, 1));")):
        text = case(body, walls="labelLeft, labelRight", moving="labelBottom, labelTop", more="macro boundaryU() (2*y - 1) // EOM")
        text = text.replace("gravityY = -1", "gravityY = 0")
        freefem_text(text, "-dt", 0.02, "-every", 0, "-tend", 0.8, "-forces", 1, "-out", tmp_path / name)
        run = RunFolder(tmp_path / name)
        turn.append(run.particles)
        forces.append(run.table("forces"))
    free, pinned = turn
    assert abs(pinned["x"] - 0.5).max() == 0 and abs(pinned["u"]).max() == 0 and abs(pinned["v"]).max() == 0
    assert abs(free["theta"][-1] - 0.3) > 0.1
    np.testing.assert_allclose(pinned["theta"], free["theta"], atol=0.01 * abs(free["theta"][-1] - 0.3))
    first, second = (table["torque"][10:] for table in forces)  # behind the start
    assert abs(second - first).max() < 0.05 * abs(first).max()


def test_a_motor_turns_a_disk_on_a_pin(freefem_text, tmp_path):
    """In a drum, concentric: torque 4 pi mu omega/(1/r^2 - 1/R^2) once the spin is steady; the centre bears no force."""
    radius, mu, torque = 0.4, 0.5, 0.3
    text = f'border c(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}\nsavemesh(buildmesh(c(120)), "{tmp_path / "round.mesh"}");\n'
    text += scene(f"bodyPinned(bodyDisk(0, 0, {radius}, 2));", f"bodyPush(0, 5, 0, {torque});", mu=mu, walls="labelWall")
    freefem_text(text, "-mesh", tmp_path / "round.mesh", "-dt", 0.02, "-every", 0, "-tend", 3, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    assert abs(rows["x"]).max() == 0 and abs(rows["y"]).max() == 0
    assert rows["omega"][-1] == pytest.approx(torque * (1 / radius**2 - 1) / (4 * np.pi * mu), rel=0.01)


def test_a_motor_on_a_pin_turns_against_the_torque_of_the_fluid(freefem_text, tmp_path):
    """At rest relative to a steady spin the two are in balance."""
    text = f'border c(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}\nsavemesh(buildmesh(c(60)), "{tmp_path / "round.mesh"}");\n'
    text += scene("bodyPinned(bodyDisk(0, 0, 0.4, 2));", "bodyPush(0, 0, 0, 0.3);", mu=0.5, walls="labelWall")
    freefem_text(text, "-mesh", tmp_path / "round.mesh", "-dt", 0.02, "-every", 0, "-tend", 2, "-forces", 1, "-out",
        tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.table("forces")["torque"][-1] == pytest.approx(-0.3, rel=0.01)
    # between cylinders of radii 0.4 and 1: torque = 4 pi mu omega R1^2 R2^2/(R2^2 - R1^2)
    assert run.particles["omega"][-1] == pytest.approx(0.3 * 0.84 / (4 * np.pi * 0.5 * 0.16), rel=0.03)


def test_velocities_by_id_are_those_of_the_body(freefem_text, tmp_path):
    loads = 'cout << "AT " << bodyAtU(0) - bodyQ[0] << " " << bodyAtV(0) - bodyQ[1] << " " << bodyAtOmega(0) - bodyQ[2] << endl;'
    out = freefem_text(scene("bodyAdd(0.5, 0.5, 0.12, 2, 0.1, 0.2, 3, 1);", loads), "-dt", 0.01, "-tend", 0.03, "-out",
        tmp_path / "run").stdout
    found = [line for line in out.splitlines() if line.startswith("AT")]
    assert found and set(found) == {"AT 0 0 0"}


def test_the_work_of_a_torque_is_in_the_budget(freefem_text, tmp_path):
    freefem_text(scene("bodyDisk(0.5, 0.5, 0.2, 3);", "bodyPush(0, 0, 0, 0.3);"), "-budget", 1, "-cfl", 0, "-dt", 0.005, "-every",
        0, "-tend", 0.2, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    budget, work = run.table("budget"), 0.3 * run.particles["theta"][-1]
    assert budget["work"][-1] == pytest.approx(work, rel=0.02)
    assert abs(budget["kinetic_energy"][-1] + budget["dissipated"][-1] - budget["work"][-1]) < 0.1 * work
