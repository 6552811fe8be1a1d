"""Held bodies that are moved as a case says: the force on them, and that their motion can go on for long."""
import numpy as np
import pytest

from tests.scenes import HELD, case
from tests.tables import force
from tools.base.run_folder import RunFolder


def scene(bodies, motion, mu=0.01, **sides):
    """The text of a case without gravity; sides: labels, the four of the unit square by default."""
    text = case(bodies, more=f"macro caseMotion(now) {motion} // EOM", **sides)
    return text.replace("mu = 0.05", f"mu = {mu}").replace("gravityY = -1", "gravityY = 0")


def test_the_force_on_an_oscillating_cylinder(freefem_text, tmp_path):
    """In a container, amplitude a twentieth of the diameter, ten elements across: against the exact force, added mass and
    damping."""
    mesh, steps, speed = tmp_path / "round.mesh", 60, 0.02 * 2 * np.pi
    text = f'border c(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}\nsavemesh(buildmesh(c(160)), "{mesh}");\n'
    text += scene("bodyAdd(0.003, 0.007, 0.2, 1, 0, 0, 0, 0);", f"givenMotion(0, {speed}*cos(2*pi*(now)), 0, 0);", mu=0.02,
        walls="labelWall")
    freefem_text(text, "-mesh", mesh, "-convection", 0, "-forces", 1, "-every", 0, "-dt", 1 / steps, "-cfl", 0, "-tend", 3, "-out",
        tmp_path / "run")
    rows = RunFolder(tmp_path / "run").table("forces")
    last = rows["t"] > 2 + 0.5 / steps
    assert last.sum() == steps
    found = 2 * np.mean(rows["fx"][last] * np.exp(-2j * np.pi * rows["t"][last])) / speed
    exact = force(0.2, 1, 1, 0.02, 2 * np.pi)
    assert abs(found / exact - 1) < 0.03  # 1.0 % of it the elements', 1.0 % the steps', of second order
    assert np.abs(rows["fy"][last]).max() < 0.01 * abs(exact) * speed


def test_a_large_cylinder_can_be_moved_for_long(freefem_text, tmp_path):
    """Ten elements across, half an element a step, for twelve periods: each is like the one before."""
    period, amplitude, steps = 1.0, 0.1, 40
    speed = 2 * np.pi * amplitude / period
    text = scene("bodyAdd(0.4, 0.5, 0.16, 1, 0, 0, 0, 0);", f"givenMotion(0, {speed}*sin(2*pi*(now)), 0, 0);")
    freefem_text(text, "-dt", period / steps, "-cfl", 0, "-every", 0, "-tend", 12 * period, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    for name in ("kinetic_energy", "divergence", "top_speed"):
        values = run.fluid[name][-2 * steps:]
        assert np.abs(values[steps:] - values[:steps]).max() < 0.01 * values.max(), name
    x = run.particles["x"]
    # the first step, of Euler, is off by 0.012
    assert x.min() > 0.4 - 0.02 * amplitude and x.max() == pytest.approx(0.4 + 2 * amplitude, abs=0.02 * amplitude)


def test_a_held_body_keeps_its_velocity_when_the_case_stops_moving_it(freefem_text, tmp_path):
    """Sped up and turned for a fifth of a second, with the last velocities from then on."""
    text = scene("bodyAdd(0.4, 0.5, 0.16, 1, 0, 0, 0, 0);", "if (now < 0.2001) givenMotion(0, now, -2*(now), 10*(now));")
    freefem_text(text, "-dt", 0.02, "-cfl", 0, "-every", 0, "-tend", 0.4, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    behind = rows["t"] > 0.19
    assert behind.sum() == 11
    for name, last in (("u", 0.2), ("v", -0.4), ("omega", 2)):
        assert rows[name][behind] == pytest.approx(last, abs=1e-12), name


@pytest.mark.parametrize("bodies, steps, overlap", [
    ("bodyAdd(0.3, 0.5, 0.1, 1, 0, 0, 0, 0); bodyAdd(0.53, 0.5, 0.1, 1, 0, 0, 0, 0);", 5, 0.03),
    ("bodyAdd(0.85, 0.5, 0.1, 1, 0, 0, 0, 0);", 6, 0.02),
    ("bodyAdd(0.3, 0.5, 0.1, 1, 0, 0, 0, 0); bodyAdd(0.53, 0.5, 0.1, 1, 0, 0, 0, 0); bodyEllipse(0.15, 0.85, 0.09, 0.06, 0.3, 1);",
        5, 0.03),
    ("bodyAdd(0.85, 0.5, 0.1, 1, 0, 0, 0, 0); bodyEllipse(0.15, 0.85, 0.09, 0.06, 0.3, 1);", 6, 0.02),
])
def test_held_bodies_moved_into_each_other_or_a_wall_are_warned_of(bodies, steps, overlap, freefem_text, tmp_path):
    """By 0.01 a step: once said, and the least gap is the overlap after the next move."""
    text = scene(bodies, "givenMotion(0, 1, 0, 0);")
    done = freefem_text(text, "-dt", 0.01, "-cfl", 0, "-every", 0, "-tend", 0.01 * steps, "-out", tmp_path / "run")
    assert (done.stdout + done.stderr).count("make bodies overlap each other or walls by") == 1
    assert RunFolder(tmp_path / "run").fluid["worst_gap"].min() == pytest.approx(-overlap, abs=1e-9)


@pytest.mark.parametrize("bodies, complaint", [
    ("bodyAdd(0.6, 0.15, 0.1, 1, 0, 0, 0, 0); bodyDisk(0.85, 0.11, 0.1, 1);", "contacts of 2 bodies"),
    ("bodyHeld(bodyEllipse(0.6, 0.15, 0.1, 0.07, pi/2, 1)); bodyEllipse(0.85, 0.08, 0.1, 0.07, 0, 1);", "linearisations"),
])
def test_a_body_that_is_squeezed_against_a_wall_ends_the_run_with_the_reason(bodies, complaint, freefem_text, tmp_path):
    done = freefem_text(scene(bodies, "givenMotion(0, 1, 0, 0);"), "-dt", 0.01, "-cfl", 0, "-contact-maxit", 5000, "-film", 0,
        "-every", 0, "-tend", 0.4, "-out", tmp_path / "run", check=False)
    assert done.returncode == 4 and len(done.stderr.strip().splitlines()) == 1
    assert complaint in done.stderr and "leave a body no room" in done.stderr


def test_a_held_ellipse_in_a_wall_leaves_the_contacts_of_others_alone(freefem_text, tmp_path):
    """A disk rests on the floor while the ellipse is moved into the right wall; nothing that cannot move presses."""
    text = scene("bodyHeld(bodyEllipse(0.84, 0.7, 0.1, 0.06, 0, 1)); bodyDisk(0.3, 0.1001, 0.1, 20);",
        "givenMotion(0, 0.5, 0, 0);").replace("gravityY = 0", "gravityY = -1")
    done = freefem_text(text, "-film", 0, "-dt", 0.01, "-cfl", 0, "-every", 0, "-tend", 0.2, "-out", tmp_path / "run")
    assert (done.stdout + done.stderr).count("make bodies overlap each other or walls by") == 1
    contacts = RunFolder(tmp_path / "run").table("contacts")
    assert set(contacts["i"]) == {1}
    weight = 19 * np.pi * 0.1**2 * 0.01  # in a step
    assert contacts["impulse"][contacts["t"] > 0.1] == pytest.approx(weight, rel=0.1)


def test_a_body_that_moves_freely_cannot_be_given_a_motion(freefem_text, tmp_path):
    text = scene("bodyDisk(0.5, 0.5, 0.16, 1);", "givenMotion(0, 1, 0, 0);")
    done = freefem_text(text, "-tend", 0.1, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "particle 0 moves freely" in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_a_body_that_is_not_there_cannot_be_given_a_motion(freefem_text, tmp_path):
    done = freefem_text(scene("bodyAdd(0.5, 0.5, 0.16, 1, 0, 0, 0, 0);", "givenMotion(1, 1, 0, 0);"), "-tend", 0.1, "-out",
        tmp_path / "run", check=False)
    assert done.returncode == 3 and "particle 1, which does not exist" in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_a_motion_that_is_no_number_is_refused(freefem_text, tmp_path):
    text = scene("bodyAdd(0.5, 0.5, 0.16, 1, 0, 0, 0, 0);", "givenMotion(0, (now > 0.015 ? log(-1.) : 0.1), 0, 0);")
    done = freefem_text(text, "-tend", 0.05, "-dt", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "gives particle 0 is not finite" in done.stderr and len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("density, free", [(1, 0), (1e6, 0), (1e6, 1)])
def test_the_flow_round_a_held_disk_does_not_swing_by_itself(density, free, freefem_text, tmp_path):
    """At mu dt/(rho h^2) = 15, where it did: steady, slower than without the disk, and its force and the walls' take the push. A
    heavy one is as good as held."""
    freefem_text(HELD.replace("0.2, 1, 0, 0, 0, 0)", f"0.2, {density}, 0, 0, 0, {free})"), "-dt", 0.05, "-tend", 12, "-every", 1,
        "-forces", 1, "-wallforces", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    drag = run.table("forces")["fx"]
    assert abs(drag[-1] - drag[-2]) < 1e-3 * drag[-1]
    assert run.fluid["top_speed"].max() < 1 / (8 * 0.3)
    walls = run.table("wallforces")
    assert drag[-1] + walls["fx"][walls["t"] == walls["t"][-1]].sum() == pytest.approx(1, rel=0.01)


def test_a_disk_centred_on_a_node_beside_an_ellipse(freefem_text, tmp_path):
    """The foot of a circle's centre on its edge is any point: it was 0/0."""
    freefem_text(case("bodyDisk(0.3125, 0.5, 0.07, 2); bodyEllipse(0.7, 0.5, 0.09, 0.06, 0.3, 2);"), "-dt", 0.005, "-tend", 0.02,
        "-out", tmp_path / "run")
    assert np.isfinite(RunFolder(tmp_path / "run").particles["v"]).all()
