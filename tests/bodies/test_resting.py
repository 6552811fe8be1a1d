"""Bodies at rest on the floor: the fluid pushes nothing, and it does not move."""
import numpy as np
import pytest

from tests.scenes import case, filmed
from tools.base.tables import read_table


@pytest.fixture
def freefem_text(freefem_text):
    """Runs a script without films, which would keep bodies from contact."""
    return filmed(freefem_text, 0)


EXCESS = 0.5 * np.pi * 0.12**2  # weight less buoyancy of a disk of density 1.5, N/m
BODIES = {
    "a disk": "bodyDisk(0.5, 0.12 + 1e-9, 0.12, 1.5);",
    "a disk on another": "bodyDisk(0.5, 0.12 + 1e-9, 0.12, 1.5); bodyDisk(0.5, 0.36 + 2e-9, 0.12, 1.5);",
    "a lying ellipse": "bodyEllipse(0.5, 0.09 + 1e-9, 0.16, 0.09, 0., 1.5);",
}


@pytest.mark.parametrize("bodies", BODIES)
def test_the_fluid_leaves_bodies_at_rest_alone(bodies, freefem_text, run_folder):
    """The contacts carry the weight; if the fluid were let fall with the body in each step, its force would be half of it."""
    freefem_text(case(BODIES[bodies]), "-dt", 0.02, "-cfl", 0, "-tend", 1, "-forces", 1, "-out", run_folder)
    forces, fluid, bodies = (read_table(run_folder / f"{name}.csv") for name in ("forces", "fluid", "particles"))
    last = forces["t"] > 0.9
    assert np.abs(forces["fy"][last]).max() < 0.1 * EXCESS
    assert fluid["top_speed"][-1] < 3e-4
    assert np.abs(bodies["v"][-1]) < 1e-8 and fluid["contacts"][-1] == len(set(bodies["id"]))


def test_a_short_last_step_spoils_neither_the_last_row_nor_a_restart(freefem, tmp_path):
    """An end that is no multiple of the step: the last two share what is left."""
    rows = {}
    for end in ("0.05", "0.0500001"):
        words = ["cases/settling_disk.edp", "-dt", 0.0025, "-forces", 1, "-every", 0, "-checkpoint", 1000]
        freefem(*words, "-tend", end, "-out", tmp_path / end)
        rows[end] = {name: read_table(tmp_path / end / f"{name}.csv") for name in ("forces", "fluid")}
        freefem(*words, "-tend", 0.06, "-restart", tmp_path / end)
        rows[end]["particles"] = read_table(tmp_path / end / "particles.csv")
    even, odd = rows.values()
    assert odd["fluid"]["dt"].min() >= 0.5 * even["fluid"]["dt"][-1]
    assert odd["forces"]["fy"][-1] == pytest.approx(even["forces"]["fy"][-1], rel=0.03)
    assert odd["particles"]["v"][-1] == pytest.approx(even["particles"]["v"][-1], rel=1e-3)


@pytest.mark.parametrize("density, number, step", [(0.01, 1, 0.02), (0.01, 6, 0.02), (0.01, 6, 0.005), (0.5, 6, 0.02),
    (1, 6, 0.02)])
def test_light_bodies_in_a_row_across_the_box_come_to_rest(density, number, step, freefem_text, run_folder):
    """No gravity, pushed aside once. The fluid they push adds several times its own mass; with the accelerations of the motions
    before the pressure step
    in the virtual mass, rows of six swung with growing amplitude, to 1000 times their first velocity within 100 steps."""
    row = f"for (int k = 0; k < {number}; ++k) {{ bodyDisk(0.5, 0.92 - 0.155*k, 0.07, {density}); bodyQ[k] = 0.01; }}"
    text = case(row).replace("gravityY = -1", "gravityY = 0")
    freefem_text(text, "-dt", step, "-cfl", 0, "-tend", 100 * step, "-out", run_folder)
    bodies = read_table(run_folder / "particles.csv")
    speed = np.hypot(bodies["u"], bodies["v"])
    late = bodies["t"] > 50 * step
    assert speed.max() < 0.0101 and speed[late].max() < 1e-3


LANDING = {"a disk": ("bodyDisk(0.513, 0.15, 0.12, 3);", np.pi * 0.12**2, 0.12, 0.004, 2),
    "in short steps": ("bodyDisk(0.513, 0.15, 0.12, 3);", np.pi * 0.12**2, 0.12, 0.001, 1.05),
           "an ellipse": ("bodyEllipse(0.4, 0.15, 0.2, 0.11, 0.3, 3);", np.pi * 0.2 * 0.11, 0.11, 0.004, 6)}


@pytest.mark.parametrize("scene", LANDING)
def test_the_fluid_lets_go_of_bodies_that_have_landed(scene, freefem_text, run_folder):
    """What had been pressed out from under them stayed as a pressure there: it bore all of the weight, and turned the disk."""
    body, area, lowest, step, end = LANDING[scene]
    freefem_text(case(body, gravity=-5), "-film", 0, "-dt", step, "-tend", end, "-forces", 1, "-every", 0.02, "-out", run_folder)
    forces, bodies, contacts = (read_table(run_folder / f"{name}.csv") for name in ("forces", "particles", "contacts"))
    late, weight = forces["t"] > end - 0.2, 5 * 2 * area
    assert np.abs(forces["fy"][late]).max() < 0.02 * weight and abs(contacts["impulse"][-1] / step / weight - 1) < 0.02
    assert abs(bodies["omega"][-1]) < 0.002 and bodies["y"][-1] < lowest + 1e-4


@pytest.mark.parametrize("body, area", [("bodyDisk(0.503, 0.12 + 1e-9, 0.12, 3);", np.pi * 0.12**2),
    ("bodyDisk(0.503, 0.12, 0.12, 100);", np.pi * 0.12**2), ("bodyEllipse(0.503, 0.09 + 1e-9, 0.16, 0.09, 0., 3);",
        np.pi * 0.16 * 0.09)])
def test_a_body_that_lies_on_the_floor_at_the_start_stays_there(body, area, freefem_text, run_folder):
    """From the first row on. Taken for one that falls onto it, it went up by a third to a half of what it falls in a step, and the
    floor bore 1.5 to 3.3 times its weight, then 0.5 of it."""
    step = 0.002
    freefem_text(case(body, mu=0.02, gravity=-10), "-dt", step, "-cfl", 0, "-tend", 20 * step, "-forces", 1, "-every", 0, "-out",
        run_folder)
    bodies, forces, contacts = (read_table(run_folder / f"{name}.csv") for name in ("particles", "forces", "contacts"))
    weight = 10 * area * (float(body.split(",")[-1].strip(" );")) - 1)
    assert len(bodies["t"]) == 20 and np.abs(bodies["v"]).max() < 0.01 * 10 * step
    assert np.abs(forces["fy"]).max() < 0.05 * weight
    # that of the first step is 1.5 times as much: it is to hold the body in the next move
    assert contacts["impulse"][1:] / step == pytest.approx(weight, rel=0.05)


def test_a_body_at_rest_does_not_mind_a_small_one_far_off(freefem_text, run_folder):
    """In steps in which the weight would send the small one farther than a twentieth of its radius the viscous step had a part only
    of all forces of contacts:
    the fluid bore 5 % of the large disk's weight."""
    text = case("bodyDisk(0.31, 0.15 + 1e-9, 0.15, 2); bodyDisk(0.9, 0.03 + 1e-9, 0.03, 50);", mu=0.02, gravity=-10)
    freefem_text(text, "-dt", 0.02, "-cfl", 0, "-tend", 1, "-forces", 1, "-every", 0.1, "-out", run_folder)
    forces = read_table(run_folder / "forces.csv")
    late = (forces["id"] == 0) & (forces["t"] > 0.5)
    assert late.sum() > 3 and np.abs(forces["fy"][late]).max() < 0.005 * 10 * np.pi * 0.15**2
