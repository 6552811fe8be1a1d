"""Collisions of bodies that touch others already: contact forces follow what they carry, and only what is beyond them is a
collision."""
import numpy as np
import pytest

from tests.scenes import case, filmed, ring
from tests.tables import momentum_told
from tools.base.run_folder import RunFolder


@pytest.fixture
def freefem_text(freefem_text):
    """Runs a script without films, which would keep bodies from contact."""
    return filmed(freefem_text, 0)


def calm_impulses(run):
    """Of each step in which no pair touches that did not in the step before: the largest impulse of a contact, N s/m."""
    contacts, before, found = run.table("contacts"), set(), []
    for t in run.fluid["t"]:
        at = np.abs(contacts["t"] - t) < 1e-9
        now = set(zip(contacts["i"][at], contacts["j"][at]))
        if now and now <= before:
            found.append(contacts["impulse"][at].max())
        before = now
    return np.array(found)


@pytest.mark.parametrize("kind, seeds, off_by, mean, most", [("disk", (5, 6, 7, 8), 0.05, 0.22, 0.3), ("ellipse", (5,), 0.2, 0.16,
    0.16)])
def test_a_settling_heap_keeps_its_momentum_in_each_step(kind, seeds, off_by, mean, most, freefem_text, tmp_path):
    """Less the impulses of weight and walls, over that of the weight in a step: 0.04 and 0.10 (1.1 and 0.5 when gentle collisions
    kept the jumps of the projection, 0.17 when contacts could pull, 0.05 to 0.08 when the pressure between disks was rough; 0.053
    when the budget counted lasting contacts of walls at the ends of the steps and all other forces by the trapezoidal
    rule). The largest contact force between collisions varies with the seed of the disks' places:
    0.21, 0.15, 0.25, 0.11 (0.15, 0.40, 0.37, 0.14 with the rough pressure); of ellipses 0.13 (0.15)."""
    calm = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        bodies = ""
        for j in range(4):
            for i in range(5):
                place = f"{0.14 + 0.18 * i + 0.02 * (j % 2) + 0.01 * rng.random():.4f}, {0.12 + 0.18 * j + 0.01 * rng.random():.4f}, {0.07 + 0.012 * rng.random():.4f}"
                bodies += f"bodyDisk({place}, 2); " if kind == "disk" else f"bodyEllipse({place}, {0.045 + 0.01 * rng.random():.4f}, {3 * rng.random():.3f}, 2); "
        freefem_text(case(bodies, mu=0.002, gravity=-10), "-film", 0, "-dt", 0.004, "-tend", 1.2, "-every", 0, "-budget", 1,
            "-out", tmp_path / f"run{seed}")
        run = RunFolder(tmp_path / f"run{seed}")
        budget = run.table("budget")
        weight = abs(np.diff(budget["weight_y"])).max()
        off = np.diff(budget["momentum_y"] - budget["walls_y"] - budget["weight_y"]) / weight
        assert run.fluid["contacts"].max() > 12 and run.fluid["worst_gap"].min() > -1e-8
        assert abs(off[20:]).max() < off_by and abs(off[20:].sum()) < 1.5  # before: impulsive start of all twenty
        forces = calm_impulses(run) / weight
        assert len(forces) > 100
        calm.append(forces.max())
    assert np.mean(calm) < mean and max(calm) < most


@pytest.mark.parametrize("speed", [1.9, 2.1])
def test_two_pairs_in_contact_that_meet_collide_in_one_step(speed, freefem_text, tmp_path):
    """Each is pressed together by loads. As all four were in contact, the collision was taken for a force: it took five steps, and
    up to 6 % of the impulse was missing in them."""
    loads = "macro caseLoads(now) bodyPush(0, 0.5, 0, 0); bodyPush(1, -0.5, 0, 0); bodyPush(2, 0.5, 0, 0); bodyPush(3, -0.5, 0, 0); // EOM\n"
    bodies = f"bodyAdd(0.16, 0.5, 0.08, 2, {speed}, 0, 0, 1); bodyAdd(0.32, 0.5, 0.08, 2, {speed}, 0, 0, 1); bodyDisk(0.54, 0.5, 0.08, 1.5); bodyDisk(0.70, 0.5, 0.08, 1.5);"
    found = momentum_told(freefem_text, tmp_path / "run", bodies, loads)
    run = RunFolder(tmp_path / "run")
    contacts, u = run.table("contacts"), run.particles["u"].reshape(-1, 4)
    middle = np.minimum(contacts["i"], contacts["j"]) + np.maximum(contacts["i"], contacts["j"]) * 4 == 9  # 1 and 2
    hit = int(np.argmin(abs(run.fluid["t"] - contacts["t"][middle][0])))
    off = np.hypot(*(found[hit:hit + 8, :2] - found[hit - 1, :2]).T)
    assert off.max() < 0.002 * found[hit, 2] and found[hit, 2] > 20 * max(found[hit - 1, 2], found[hit + 1, 2])
    assert np.ptp(u[hit - 1]) > 0.5 and np.ptp(u[hit]) < 0.03 and np.ptp(u[hit + 1:hit + 8], axis=1).max() < 0.03


@pytest.mark.parametrize("density", [0.3, 3])
def test_a_load_on_a_weightless_disk_that_touches_the_floor_is_no_collision(density, freefem_text, tmp_path):
    """The floor bears it from the first step on. As a collision its impulse was 2.2 and 1.7 times the load's, and the fluid's force
    0.8 and 0.3 times the load."""
    loads = "macro caseLoads(now) bodyPush(0, 0, (now > 0.0401)*(-0.5), 0); // EOM"
    freefem_text(case(f"bodyDisk(0.5, 0.1, 0.1, {density});", mu=0.005, gravity=0, more=loads), "-dt", 0.004, "-cfl", 0, "-tend",
        0.1, "-every", 0, "-forces", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    contacts = run.table("contacts")
    assert contacts["t"][0] == pytest.approx(0.044) and len(contacts["t"]) == 15
    assert contacts["impulse"] == pytest.approx(0.5 * 0.004, rel=0.02)
    assert abs(run.table("forces")["fy"]).max() < 0.02 * 0.5 and abs(run.particles["y"] - 0.1).max() < 1e-9


def test_a_disk_slides_from_wall_to_wall_without_collisions(freefem_text, tmp_path):
    """Along a ring of 120 chords, over two corners of 3 degrees. A contact with the next wall was a collision: one impulse was 2.7
    times the weight's."""
    mesh = tmp_path / "ring.mesh"
    text = ring(mesh).replace("outer(60)", "outer(120)") + case("bodyDisk(-0.5, -0.716, 0.12, 5);",
        walls="labelWall, labelCylinder", mu=0.005, gravity=-5)
    freefem_text(text, "-film", 0, "-mesh", mesh, "-dt", 0.004, "-cfl", 0, "-tend", 0.4, "-every", 0, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    contacts = run.table("contacts")
    impulse = np.array([contacts["impulse"][abs(contacts["t"] - t) < 1e-9].sum() for t in run.fluid["t"]]) / (np.pi * 0.12**2 * 20
        * 0.004)
    assert len(set(contacts["j"])) == 3 and 0.5 < impulse[20:].min() and impulse[20:].max() < 2
