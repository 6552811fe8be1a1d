"""Bodies after a restart: loads, shapes, pins, contacts, bodies that enter and leave, and the whole state."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tests.scenes import case
from tests.tables import broken_off, numbers


def test_budgets_and_shapes_outlive_a_restart(shaft, tmp_path):
    mesh = make_mesh(tmp_path / "shear.mesh", "ellipse_in_shear", "--size", 0.0125, "--core", 0.13)
    words = ["cases/ellipse_in_shear.edp", "-mesh", mesh, "-major", "0.05", "-tend", "0.1", "-dt", "0.01", "-checkpoint", "5"]
    whole, broken = broken_off(words, tmp_path / "ellipse", 5)
    words = ["cases/settling_disk.edp", *shaft, "-dt", "0.002", "-tend", "0.02", "-budget", "1", "-checkpoint", "5"]
    box = broken_off(words, tmp_path / "box", 5)
    for name, (a, b) in (("shapes.csv", (whole, broken)), ("particles.csv", (whole, broken)), ("budget.csv", box)):
        assert (a / name).read_bytes() == (b / name).read_bytes(), name


def test_ellipses_that_touch_go_on_after_a_restart_bit_for_bit(tmp_path):
    mesh = make_mesh(tmp_path / "low.mesh", "box", "--width", 2, "--height", 3.5, "--size", 0.0625)
    words = ["cases/settling_ellipses.edp", "-mesh", mesh, "-number", "16", "-film", "0", "-tend", "0.3", "-checkpoint", "60"]
    whole, broken = broken_off(words, tmp_path, 120)
    assert numbers(whole, "contacts.csv")["t"].min() < 0.24 and numbers(whole, "contacts.csv")["t"].max() > 0.25
    for name in ("particles.csv", "contacts.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


def test_forces_that_a_case_reads_outlive_a_restart(cell, tmp_path):
    """caseMotion takes its velocities of bodyForce, the force of the last step."""
    text = case("bodyHeld(bodyDisk(0.4, 0.5, 0.15, 1)); bodyDisk(0.7, 0.7, 0.12, 3);",
        more="macro caseMotion(now) givenMotion(0, 0.02*bodyForce[0], 0.02*bodyForce[2], 0.); // EOM")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-tend", "0.1", "-forces", "1", "-checkpoint",
        "4"], tmp_path, 8)
    assert abs(numbers(whole, "forces.csv")["fx"]).max() > 1e-4
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("third", ["queueAt(0.4, 0.7, 0.1, 2, 0.15);", "queueEllipseAt(0.4, 0.7, 0.12, 0.08, 0.5, 2, 0.15);"])
def test_loads_outlive_a_restart_where_bodies_come_and_go(third, cell, tmp_path):
    """One of two has left before it, the other is lighter than the fluid, and a third, pushed as well, enters behind it."""
    bodies = f"bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyDisk(0.5, 0.3, 0.1, 0.5); {third}"
    pushes = "bodyPush(0, 1, 0, 0); bodyPush(1, 0, 1, 0); bodyPush(2, 0, 1, 0.01);"
    text = case(bodies, more=f"macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseLoads(now) {pushes} // EOM",
        walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-cfl", "0", "-tend", "0.2", "-forces", "1",
        "-checkpoint", "5"], tmp_path, 15)
    table = numbers(whole, "particles.csv")
    assert [set(table["id"][abs(table["t"] - t) < 1e-9]) for t in (0.01, 0.15, 0.2)] == [{0, 1}, {1}, {1, 2}]
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


def test_bodies_leave_before_and_after_a_restart(cell, tmp_path):
    """What the scheme keeps of each body is that of the bodies of then, not of the case's."""
    bodies = "bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyAdd(0.91, 0.7, 0.1, 2, 1.5, 0, 0, 1); bodyDisk(0.4, 0.5, 0.1, 0.5);"
    text = case(bodies, more="macro boundaryU() (4*y*(1 - y)) // EOM", walls="labelBottom, labelTop", moving="labelLeft",
        outlet="labelRight")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-cfl", "0", "-tend", "0.2", "-forces", "1",
        "-checkpoint", "5"], tmp_path, 15)
    table = numbers(whole, "particles.csv")
    assert [set(table["id"][abs(table["t"] - t) < 1e-9]) for t in (0.01, 0.15, 0.2)] == [{0, 1, 2}, {1, 2}, {2}]
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_body_on_a_pin_goes_on_turning_after_a_restart(cell, tmp_path):
    (tmp_path / "scene.edp").write_text(case("bodyPinned(bodyDisk(0.5, 0.5, 0.15, 2));", more="macro caseLoads(now) bodyPush(0, "
        "0, 0, 0.3); // EOM"))
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-tend", "0.1", "-checkpoint", "4"], tmp_path,
        8)
    assert abs(numbers(whole, "particles.csv")["omega"][-1]) > 0.01
    assert (broken / "particles.csv").read_bytes() == (whole / "particles.csv").read_bytes()


def test_the_least_gap_since_the_last_row_outlives_a_restart(cell, tmp_path):
    """A disk lands between two rows, before the checkpoint."""
    (tmp_path / "scene.edp").write_text(case("bodyAdd(0.5, 0.15, 0.1, 3, 0, 1, 0, 1);"))
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0.05", "-cfl", "0", "-dt", "0.01", "-tend", "0.2",
        "-checkpoint", "4"], tmp_path, 16)
    np.testing.assert_array_equal(numbers(broken, "fluid.csv")["worst_gap"], numbers(whole, "fluid.csv")["worst_gap"])


@pytest.mark.parametrize("last, keep", [(0.0601, 6), (0.0601, 7)])
def test_a_motion_that_ends_beside_a_checkpoint(last, keep, cell, tmp_path):
    """Given until then, at a constant speed from there on, with a free disk beside it."""
    text = case("bodyHeld(bodyDisk(0.4, 0.5, 0.12, 1)); bodyDisk(0.7, 0.5, 0.1, 1.5);", more=f"macro caseMotion(now) if (now < "
        f"{last}) givenMotion(0, 20*(now), -10*(now), 0); // EOM")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.12",
        "-forces", "1", "-checkpoint", keep], tmp_path, keep)
    for name in ("particles.csv", "forces.csv"):
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


def test_the_axes_of_who_enters_behind_a_checkpoint_stand_once_in_shapes(cell, tmp_path):
    text = case("bodyEllipse(0.4, 0.3, 0.12, 0.08, 0.3, 2); queueEllipseAt(0.5, 0.7, 0.12, 0.08, 0.5, 2, 0.05);")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.08",
        "-checkpoint", "4"], tmp_path, 4)
    assert (broken / "shapes.csv").read_bytes() == (whole / "shapes.csv").read_bytes() and len(numbers(whole,
        "shapes.csv")["id"]) == 2


# One leaves before the checkpoint and one behind it, a light one is pushed, one turns on a pin, one enters before and one behind
# it; the inlet changes until a step before it; a body lands, one falls
# on it and one is turned from a time behind it; the only one has left, and the solver's first guess is quadratic in time;
# a stream stops beside the checkpoint, and with it the frame of the body that it carried.
WHOLE_STATE = {
    "open": (case("{ bodyAdd(0.99, 0.3, 0.1, 2, 1.5, 0, 0, 1); bodyAdd(0.93, 0.75, 0.1, 2, 1.2, 0, 0, 1); bodyDisk(0.5, 0.3, "
        "0.1, 0.5); bodyPinned(bodyEllipse(0.3, 0.8, 0.12, 0.08, 0.3, 2)); "
                  "queueAt(0.12, 0.22, 0.08, 2, 0.15); queueEllipseAt(0.2, 0.5, 0.1, 0.07, 0.5, 2, 0.06); }",
                      walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", mu=0.004,
                  more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseLoads(now) bodyPush(2, 0, 1, 0); bodyPush(4, 0, 1, "
                      "0.01); // EOM\nmacro caseBoundary(now) if (now < 0.0951) inflowScale(labelLeft, 1 + 2*(now)); // EOM"),
             ["-tend", "0.2", "-every", "0.015", "-wallforces", "1", "-fluxes", "1", "-fields", "0.03"], 10),
    "closed": (case("{ bodyAdd(0.5, 0.15, 0.1, 3, 0, 0.5, 0, 1); bodyEllipse(0.5, 0.42, 0.14, 0.1, 0.4, 5); bodyDisk(0.8, 0.7, "
        "0.1, 0.4); }", gravity=-4,
                    more="macro caseLoads(now) bodyPush(2, 0.02, 0, 0.01*(now > 0.125)); // EOM"), ["-tend", "0.22", "-every",
                        "0.03", "-budget", "1"], 11),
    "empty": (case("bodyAdd(0.99, 0.5, 0.1, 2, 2, 0, 0, 1);", walls="labelBottom, labelTop", moving="labelLeft",
        outlet="labelRight", gravity=0,
                   more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) inflowScale(labelLeft, 1 + "
                       "sin(20*(now))); // EOM"), ["-cfl", "0", "-tend", "0.24", "-every", "0"], 12),
    "frame": (case("bodyDisk(0.3, 0.5, 0.1, 1);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
                   more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) inflowScale(labelLeft, (now < 0.145 ? "
                       "1. : 0.)); // EOM"), ["-cfl", "0", "-tend", "0.3", "-every", "0"], 15),
}


@pytest.mark.parametrize("scene", WHOLE_STATE)
def test_the_whole_state_outlives_a_restart(scene, cell, tmp_path):
    """All tables, and the last checkpoint: what is kept for later steps is in it, whether these tables show it or not."""
    text, words, keep = WHOLE_STATE[scene]
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", cell, "-forces", "1", "-checkpoint", keep, *words], tmp_path, keep)
    if scene == "open":
        for name, times in (("entries", [0, 0, 0, 0, 0.07, 0.16]), ("exits", [0.09, 0.14])):
            assert numbers(whole, f"{name}.csv")["t"] == pytest.approx(times, abs=0.011)
    names = [f"{name}.csv" for name in ("particles", "forces", "wallforces", "fluxes", "budget", "entries", "exits", "contacts",
        "shapes")] + ["fields.pvd"]
    for name in [name for name in names if (whole / name).exists()] + [f"restart_{2 * keep:09d}.{end}" for end in ("txt", "scheme",
        "contacts")]:
        assert (broken / name).read_bytes() == (whole / name).read_bytes(), name
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)
