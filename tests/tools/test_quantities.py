"""Quantities of runs: means over windows, ends, extremes."""
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest

from tests.synthetic import write_run
from tools.base import quantities
from tools.base.run_folder import RunFolder


def test_the_quantities_of_a_made_up_run(tmp_path):
    run = RunFolder(write_run(tmp_path / "run"))
    known = quantities.load()
    got = {name: quantities.evaluate(quantities.parse(name, known), run) for name in known
        if name not in ("result", "mean_w", "final_z")}  # of steady flows, of spheres
    assert all(why == "" for _, why in got.values()), got
    assert got["mean_wall_fx"][0] == pytest.approx(3.5) and quantities.mean_wall_fx(run, 4) == pytest.approx(2)
    assert got["mean_fx"][0] == pytest.approx(2) and quantities.mean_fx(run,
        particle=1) == pytest.approx(3) and got["mean_torque"][0] == pytest.approx(0.5)
    assert got["mean_fy"][0] == pytest.approx(0.875 * run.fluid["t"].max())  # the force is the time, over the last quarter
    outlets = [quantities.mean_flux(run, label) for label in (2, 12)]
    assert outlets[0] == pytest.approx(3 * outlets[1]) and got["mean_flux"][0] == outlets[0] > 0 > quantities.mean_flux(run, 1)
    for bad in (lambda: quantities.mean_flux(run, 3), lambda: quantities.mean_fx(run, particle=7)):
        with pytest.raises(ValueError):
            bad()
    assert got["mean_u"][0] == pytest.approx(0.9) and got["mean_v"][0] == 0
    assert got["flux_error"][0] == pytest.approx(1e-4, rel=1e-3)
    assert got["mean_pressure_drop"][0] == pytest.approx(100 * (1 - (math.exp(-3.75) - math.exp(-5)) / 1.25), rel=1e-4)
    with pytest.raises(ValueError, match="no rows of label 0"):
        quantities.mean_wall_fx(run, 0)
    assert got["worst_overlap"][0] == pytest.approx(6e-9 / run.particles["radius"].min())


def test_a_mean_is_over_the_window_whatever_the_rows():
    t = np.array([0, 0.07, 0.2, 0.33, 0.61, 1.0])
    run = type("Run", (), {"case": "x", "tracks": {0: {"t": t, "v": 3 * t}}})()
    assert quantities.mean_v(run, 0.1, 0.5) == pytest.approx(0.9)


def test_windows_of_quantities():
    """The one that is asked for, also between two rows; that of the case's references; else the last quarter."""
    t = np.linspace(0, 1, 11)
    track = {"t": t, "v": 2 * t, "u": np.where(t < 0.95, 0.0, 3.0)}
    run = SimpleNamespace(case="drum", tracks={3: track, 7: {"t": t, "v": -t, "u": 0 * t}}, fluid={"t": t, "flux_in": 1 + 0 * t,
        "flux_out": np.where(t == 0.5, -0.96, -1.0), "worst_gap": 0.1 - t},
                          particles={"radius": np.array([2.0, 0.5])})
    assert quantities.mean_v(run) == pytest.approx(2 * 0.875) and quantities.mean_v(run, 0.23,
        0.47) == pytest.approx(0.7) and quantities.mean_v(run, 0.5) == pytest.approx(1.5)
    assert quantities.mean_v(run, particle=7) == pytest.approx(-0.875) and quantities.mean_u(run) == pytest.approx(0.1 * 3 / 2
        / 0.25)
    assert quantities.mean_v(SimpleNamespace(case="settling_disk", tracks=run.tracks)) == pytest.approx(0.7)
    assert (quantities.peak_speed(run) == pytest.approx(13**0.5) and quantities.flux_error(run) == pytest.approx(0.04)
        and quantities.worst_overlap(run) == pytest.approx(1.8))
    for start, end in ((0.5, 1.1), (-0.1, 0.5), (0.6, 0.6)):
        with pytest.raises(ValueError):
            quantities.mean_v(run, start, end)
    fine = np.linspace(0, 1, 1001)
    noisy = SimpleNamespace(case="", tracks={0: {"t": fine, "v": 5 + 2 * fine - fine**2 + 0.01 * np.sin(200 * np.pi * fine)}})
    assert quantities.noise_v(noisy, 0, 1) == pytest.approx(0.01 / 2**0.5 / (17 / 3), rel=2e-3)
    assert quantities.noise_v(noisy, 0.2, 0.3) == pytest.approx(0.01 / 2**0.5 / np.mean(5 + 2 * fine[200:301]
        - fine[200:301] ** 2), rel=0.02)


def test_quantities_of_the_end_and_of_extremes():
    t = np.arange(3.0)
    run = SimpleNamespace(case="drum", mesh=None, tracks={0: {"t": t, "x": np.array([1.0, 5, 3]), "y": np.array([2.0, 7, 4]),
        "theta": np.array([0.0, 9, 6]), "v": t}}, particles={"radius": np.array([0.5])},
                          fluid={"t": t, "flux_in": np.array([0.5, 0.5, 0.5]), "flux_out": np.array([-0.5, -1.0, -0.5]),
                              "worst_gap": t + 0.1})
    assert (quantities.final_x(run), quantities.final_y(run), quantities.final_theta(run)) == (3, 4, 6)
    assert quantities.flux_error(run) == pytest.approx(0.5) and quantities.worst_overlap(run) == 0
    with pytest.raises(ValueError, match="only 3 rows"):
        quantities.noise_v(run, 0, 2)


@pytest.mark.parametrize("times, window", [((0, 1), ()), ((0, 0.5, 1), ()), ((0, 0.01, 0.02, 0.3, 0.6, 0.9, 1), ()),
    ((0, 0.5, 1), (0.6, 0.7))])
def test_a_mean_of_too_few_rows_is_refused(times, window):
    """It would be one of the straight line from the start to the end."""
    t = np.array(times)
    run = SimpleNamespace(case="drum", tracks={0: {"t": t, "v": np.exp(-9 * t)}})
    with pytest.raises(ValueError, match="only [012] rows in the window from"):
        quantities.mean_v(run, *window)


def test_a_mean_of_a_window_narrower_than_dense_rows_is_given():
    t = np.linspace(0, 1, 21)
    run = SimpleNamespace(case="drum", tracks={0: {"t": t, "v": 2 * t}})
    assert quantities.mean_v(run, 0.31, 0.34) == pytest.approx(0.65)


def test_a_closed_flow_has_no_error_of_its_flux(tmp_path):
    run = RunFolder(write_run(tmp_path / "run", fields=1))
    run.fluid["flux_in"], run.fluid["flux_out"] = 1e-16 * run.fluid["flux_in"], 0 * run.fluid["flux_out"]
    run.fluid["top_speed"] = np.ones(len(run.fluid["t"]))
    assert quantities.flux_error(run) == 0
    run.fluid["flux_in"] = 1e12 * run.fluid["flux_in"]
    assert quantities.flux_error(run) == 1


def test_the_help_names_the_arguments_of_a_quantity():
    assert any(line.startswith("  mean_flux:LABEL:START:END ") for line in quantities.summary(quantities.load()).splitlines())


def test_every_quantity_has_a_whole_sentence_in_the_help():
    lines = quantities.summary(quantities.load()).splitlines()
    assert len(lines) > 10 and not [line for line in lines if not re.search(r"\S {2,}\S.*[.]$", line)]


@pytest.mark.parametrize("text, says", [("final_y:0.5", "there is no particle 0.5"), ("final_y:2", "there is no particle 2"),
    ("final_y:nan", "there is no particle nan"),
                                        ("mean_v:0:inf", "the window from 0 to inf has no end"),
                                            ("mean_v:-inf:1", "the window from -inf to 1 has no end"),
                                                ("mean_v:1:0.5", "the window from 1 to 0.5 is empty")])
def test_a_particle_or_a_window_that_there_is_not_is_told(text, says):
    """A half of a particle was the one before, an endless window a nan without a reason."""
    t = np.linspace(0, 2, 21)
    run = SimpleNamespace(case="drum", tracks={one: {"t": t, "v": t, "y": one + t} for one in (0, 1)})
    value, why = quantities.evaluate(quantities.parse(text, quantities.load()), run)
    assert math.isnan(value) and why == says
    assert quantities.evaluate(quantities.parse("final_y:1", quantities.load()), run) == (3, "")
