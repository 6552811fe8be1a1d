"""A disk that falls: against the published velocity and a body-fitted computation, over time steps and sizes, its budgets."""
import numpy as np
import pytest

from tests.conftest import ROOT, make_mesh, standard_alone
from tests.tables import particles_of
from tools.base.tables import read_table


def test_the_fall_hardly_depends_on_the_time_step(freefem, shaft, tmp_path):
    """Mean velocity over 0.3 to 0.4 s with steps of 0.13 and 0.26 elements."""
    fall = []
    for dt in (0.002, 0.004):
        run = particles_of(freefem, tmp_path / f"run{dt}", "settling_disk", *shaft, "-dt", dt, "-tend", "0.4")
        fall.append(np.interp(0.3, run["t"], run["y"]) - run["y"][-1])
    assert fall[0] == pytest.approx(fall[1], rel=0.004)  # 0.002; with the pressure left behind 0.006


def test_a_large_step_is_taken_smaller_by_itself(freefem, tmp_path):
    """-cfl 1.5 is the default, kept within the fifth by which a step may grow, and but for what the flow gains in a step."""
    freefem("cases/settling_disk.edp", "-rhos", "1.5", "-mu", "0.01", "-dt", "0.02", "-tend", "0.25", "-out", tmp_path / "run")
    fluid = read_table(tmp_path / "run" / "fluid.csv")
    crossed = fluid["top_speed"] * fluid["dt"] / (0.25 / 4)  # elements are no smaller than 0.0625 cm
    assert fluid["dt"].min() < 0.01
    late = crossed[len(crossed) // 2:]
    assert np.median(late) < 1.6 and late.max() < 2.2
    chosen = fluid["top_speed"][:-1] * fluid["dt"][1:] / (0.25 / 4)  # by the speed that was known
    assert chosen[1:].max() < 1.6
    assert np.isfinite(fluid["kinetic_energy"]).all()


def test_settling_disk_follows_the_published_velocity(freefem, tmp_path):
    run = particles_of(freefem, tmp_path / "run", "settling_disk", "-tend", "0.1")
    table = read_table(ROOT / "tests" / "reference" / "settling_disk_velocity_koblitz2017_fig6b.csv")
    t, v = table["t_s"], table["v_cm_per_s"]
    now = (t > 0.055) & (t < 0.1)
    assert now.sum() >= 4
    np.testing.assert_allclose(np.interp(t[now], run["t"], run["v"]), v[now], rtol=0.04)
    assert abs(run["x"] - 1).max() < 2e-3


def test_the_body_fitted_reference_is_that_of_its_script(freefem, tmp_path):
    """A coarse run of tools/peers/body_fitted/settling_disk.edp beside the table made by a fine one."""
    freefem(ROOT / "tools" / "peers" / "body_fitted" / "settling_disk.edp", "-dt", "0.01", "-tend", "0.2", "-out",
        tmp_path / "fall.csv")
    coarse, fine = read_table(tmp_path / "fall.csv"), read_table(ROOT / "tests" / "reference" / "settling_disk_body_fitted.csv")
    for t, most in ((0.1, 5e-4), (0.2, 1e-4)):
        found, exact = (np.interp(t, table["t_s"], table["v_cm_per_s"]) for table in (coarse, fine))
        assert found == pytest.approx(exact, rel=most)


def test_a_disk_of_exactly_two_elements_falls_within_a_few_percent(freefem, tmp_path):
    """Against one of 8 elements across; taken for too small to have a curved edge it errs by 23 %."""
    fall = []
    for cells in (8, 32):
        path = make_mesh(tmp_path / f"box{cells}.mesh", "box", "--width", 1, "--height", 1, "--size", 1 / cells)
        run = particles_of(freefem, tmp_path / f"run{cells}", "settling_disk", "-mesh", path, "-x", "0.5", "-y", "0.53",
            "-gravity", "-100", "-dt", "0.002", "-tend", "0.1")
        fall.append(run["v"][-1])
    assert fall[1] < -0.3
    assert fall[0] == pytest.approx(fall[1], rel=0.04)


def test_a_nearly_round_ellipse_falls_as_a_disk(freefem_text, shaft, tmp_path):
    case = (ROOT / "cases" / "settling_disk.edp").read_text()
    place = case[case.index("bodyDisk("):case.index(";", case.index("bodyDisk(")) + 1]
    x, y, radius, density = place[9:-2].split(",")
    falls = []
    for name, body in (("disk", place), ("ellipse", f"bodyEllipse({x}, {y}, {radius}, {radius}*(1 - 1e-9), 0.4, {density});")):
        freefem_text(case.replace(place, body), *shaft, "-tend", 0.05, "-out", tmp_path / name)
        falls.append(read_table(tmp_path / name / "particles.csv"))
    np.testing.assert_allclose(falls[1]["v"], falls[0]["v"], rtol=1e-4)
    np.testing.assert_allclose(falls[1]["y"], falls[0]["y"], rtol=1e-6)


def test_the_look_for_contacts_may_rest(freefem_text, shaft, tmp_path):
    """A step without a look changes nothing: two disks of different weight that meet, and the floor."""
    case = (ROOT / "cases" / "settling_disk.edp").read_text()
    place = case[case.index("bodyDisk("):case.index(";", case.index("bodyDisk(")) + 1]
    two = "bodyDisk(0.5, 1.7, diameter/2, 3.); bodyDisk(0.52, 0.8, diameter/2, 1.2);"
    for name, step in (("rests", ""), ("looks", "motionRest = -1;")):
        freefem_text(standard_alone(case.replace(place, two).replace('include "scripts', f'macro caseStep() {step} // EOM\ninclude "scripts')),
                     *shaft, "-film", 0, "-dt", 0.001, "-tend", 0.2, "-out", tmp_path / name)
    assert (tmp_path / "rests" / "particles.csv").read_bytes() == (tmp_path / "looks" / "particles.csv").read_bytes()
    gaps = [read_table(tmp_path / name / "fluid.csv")["worst_gap"] for name in ("rests", "looks")]
    touched = gaps[1] < 1e-6
    assert touched.any() and not touched.all() and (gaps[0] <= gaps[1] + 1e-15).all() and (gaps[0][~touched] > 0).all()
    assert (gaps[0] < gaps[1] - 1e-6).any()  # it did rest


def test_momentum_and_energy_of_a_falling_disk_balance(freefem, shaft, tmp_path):
    found = []
    for dt in (0.005, 0.0025):
        freefem("cases/settling_disk.edp", *shaft, "-budget", 1, "-dt", dt, "-tend", 0.3, "-out", tmp_path / f"run{dt}")
        b = read_table(tmp_path / f"run{dt}" / "budget.csv")
        found.append(abs(b["momentum_y"] - b["walls_y"] - b["weight_y"]).max() / abs(b["weight_y"][-1]))
        assert b["walls_y"][-1] > 0.05 * abs(b["weight_y"][-1])
        assert abs(b["kinetic_energy"] - b["work"] + b["dissipated"])[-1] < 0.08 * b["work"][-1]
    assert found[0] < 0.004 and found[1] < 0.9 * found[0]  # while the pressure came a step late at the start 0.01, first order
