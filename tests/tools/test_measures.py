"""tools.study.convergence, tools.base.quantities and tools/base/measure.py, number by number."""
import math
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base import quantities
from tools.study import convergence


@pytest.mark.parametrize("p, found", [(0.1, 0.1), (8, 8), (0.02, math.nan), (14, math.nan)])
def test_orders_within_bounds_are_seen(p, found):
    sizes = np.array([1, 1.2, 1.5])
    assert convergence.observed_order(sizes, 3 - sizes**p) == pytest.approx(found, rel=1e-6, nan_ok=True)


def test_an_order_is_that_of_the_finest_three():
    """In whatever order they are given."""
    sizes = [1, 0.25, 4, 0.5, 2]
    assert convergence.observed_order(sizes, [h**2 if h <= 1 else h**5 for h in sizes]) == pytest.approx(2)


def test_errors_that_are_no_numbers_have_no_part_in_a_fitted_order():
    assert convergence.fitted_order([1, 0.5, 0.25], [1, math.nan, 1 / 16]) == pytest.approx(2) == convergence.fitted_order([1, 0.5,
        0.25], [1, 0.25, math.inf])
    for sizes, errors in (([1, 1], [1, 2]), ([1], [1]), ([1, 0.5], [1, 0]), ([], [])):
        assert math.isnan(convergence.fitted_order(sizes, errors))


@pytest.mark.parametrize("values, note", [([0.0, 0.0], "does not depend"), ([0.0, 0.0, 0.0], "does not depend"),
    ([1, 1 + 1e-12, 1 + 2e-12], "does not depend"),
                                          ([1, 1e-13, 0.0], "stand still"), ([1.1, 1 + 1e-10, 1], "any order"),
                                              ([1.0, 1.1, 1.1 + 1e-10], "any order")])
def test_differences_are_rounding_below_eleven_digits_of_the_largest_value(values, note):
    assert note in convergence.estimate([1, 0.5, 0.25][:len(values)], values).note


def test_an_order_is_told_where_it_is_seen():
    assert math.isnan(convergence.estimate([1, 0.5], [5.0, 2.0]).order)  # assumed
    one = convergence.estimate([1, 0.5, 0.25], [8.0, 1.0, 0.125])  # kept to the formal one in the limit only
    assert one.order == pytest.approx(3) and one.limit == pytest.approx(0.125 - 0.875
        / 3) and one.uncertainty == pytest.approx(0.875)
    assert convergence.estimate([1, 0.5, 0.25], [8.0, 1.0, 0.125], formal=3).limit == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_an_uncertainty_is_positive(sign):
    """Of values that rise and fall; also where the last is the least or the largest of the spread."""
    assert convergence.estimate([1, 0.5], [sign, 2.0 * sign]).uncertainty > 0
    assert convergence.estimate([1, 0.5, 0.25], [4.0 * sign, 1.0 * sign, 0.25 * sign]).uncertainty > 0
    assert convergence.estimate([1, 0.5, 0.25], [1.0 * sign, 1.3 * sign, 1.2 * sign]).uncertainty == pytest.approx(0.9)
    assert convergence.estimate([1, 0.5, 0.25], [0.1 * sign, 0.0, 0.0]).uncertainty == pytest.approx(3 * 0.1 / 12)


def test_pareto_points_have_a_cost_and_an_error():
    assert convergence.pareto([math.nan, 2, 3, math.inf, 4, 5], [0.0, -0.5, math.nan, 0.0, 0.5, 0.1]) == [1, 5]
    assert convergence.pareto([1, 1, 1], [0.3, 0.1, 0.1]) == [1]


def drum(**more):
    """A run of 21 rows: particle 3 before particle 7 in number, each column of its own."""
    t = np.linspace(2, 4, 21)
    tracks = {one: {"t": t, "x": one + t % 1, "y": -one - t % 1, "theta": one * t, "u": one * t, "v": -2 * one * t,
        "omega": 3 * one * t} for one in (7, 3)}
    fluid = {"t": t, "kinetic_energy": t**2, "pressure_drop": 5 - t}
    tables = {"wallforces": {"t": np.repeat(t, 3), "label": np.tile([0.0, 4, 5], 21), "fx": np.repeat(t, 3)
        * np.tile([1.0, 10, 100], 21), "fy": np.full(63, -9.0)},
              "forces": {"t": np.repeat(t, 2), "id": np.tile([7.0, 3], 21), "fx": np.tile([1.0, 2], 21), "fy": np.tile([3.0, 4],
                  21), "torque": np.tile([5.0, 6], 21)},
              "fluxes": {"t": np.repeat(t, 2), "label": np.tile([1.0, 2], 21), "flux": np.tile([-8.0, 9], 21)}}
    return SimpleNamespace(case="drum", tracks=tracks, fluid=fluid, table=tables.__getitem__, **more)


@pytest.mark.parametrize("text, expected", [
    ("mean_u", 3 * 3.75), ("mean_v", -6 * 3.75), ("mean_omega", 9 * 3.75), ("mean_u:2:3:7", 7 * 2.5),
        ("peak_speed", math.hypot(3, 6) * 4), ("final_x", 3), ("final_y:7", -7), ("final_theta", 12),
    ("mean_pressure_drop:2:4", 2), ("mean_kinetic_energy:2:3", 6.335),  ("mean_wall_fx:-1:2:4", 333), ("mean_wall_fx:0:2:4", 3),
        ("mean_wall_fx:4:2:4", 30), ("mean_fx", 2), ("mean_fy", 4), ("mean_torque", 6), ("mean_torque:2:4:7", 5),
    ("mean_flux", 9), ("mean_flux:1:2:4", -8)])
def test_quantities_take_their_own_column_particle_and_label(text, expected):
    assert quantities.evaluate(quantities.parse(text, quantities.load()), drum()) == (pytest.approx(expected, rel=1e-12,
        abs=1e-12), "")


@pytest.mark.parametrize("text, says", [("mean_fx:2:4:5", "there is no particle 5"), ("mean_fx:2:4:0", "there is no particle 0"),
    ("mean_wall_fx:7", "no rows of label 7"), ("mean_flux:3", "no rows of label 3"), ("mean_u:1.9:3", "not over 1.9 to 3"),
                                        ("mean_u:3:4.1", "not over 3 to 4.1"), ("mean_u:3:3", "is empty"),
                                            ("noise_v:2:2.3", "only 4 rows in the window")])
def test_quantities_say_what_is_not_there(text, says):
    value, why = quantities.evaluate(quantities.parse(text, quantities.load()), drum())
    assert math.isnan(value) and says in why


def test_forces_of_a_flow_without_particles_are_not_those_of_one():
    run = drum()
    run.table = lambda name: {"t": np.arange(3.0), "force_x": np.ones(3)}
    assert quantities.evaluate(quantities.mean_fx, run)[1] == "forces.csv is that of a flow without particles"


def test_a_window_may_miss_the_rows_by_rounding():
    """Of six digits, not more."""
    assert quantities.mean_u(drum(), 2 - 1e-6, 4 + 1e-6) == pytest.approx(9, rel=1e-5)
    with pytest.raises(ValueError, match="not over"):
        quantities.mean_u(drum(), 2, 4 + 1e-4)


@pytest.mark.parametrize("window, given", [((2.31, 2.39), True), ((2.0, 2.21), True), ((2.11, 2.19), True)])
def test_rows_are_dense_below_a_tenth_of_their_time(window, given):
    """0.1 apart in 2; where the first half has no more than its ends the window must hold a row."""
    assert quantities.mean_u(drum(), *window) == pytest.approx(3 * np.mean(window))
    sparse = drum()
    for track in sparse.tracks.values():
        for name, values in track.items():
            track[name] = values[[0, 3, 6, *range(7, 21)]]  # the first three are 0.3 apart
    with pytest.raises(ValueError, match="lie 0.3 apart"):
        quantities.mean_u(sparse, 2.1, 2.25)
    assert quantities.mean_u(sparse, 2.0, 2.3) == pytest.approx(3 * 2.15)  # as long as the rows are apart
    assert quantities.mean_u(sparse, 2.61, 2.69) == pytest.approx(3 * 2.65)  # sparse elsewhere


def test_noise_is_about_a_parabola_over_the_whole_window():
    """Of its 5 rows the last one is off."""
    t = np.linspace(0, 1, 5)
    run = SimpleNamespace(case="", tracks={0: {"t": t, "v": 2 + t - 3 * t**2}})
    assert quantities.noise_v(run, 0, 1) < 1e-12
    run.tracks[0]["v"] = np.array([1.0, 1, 1, 1, 1.5])
    rest = run.tracks[0]["v"] - np.polyval(np.polyfit(t, run.tracks[0]["v"], 2), t)
    assert quantities.noise_v(run, 0, 1) == pytest.approx(np.sqrt(np.mean(rest**2)) / 1.1) and quantities.noise_v(run, 0, 1) > 0.01


@pytest.mark.parametrize("inlet, outlet, extent, expected", [
    ([0, 0], [0, 0], 1, 0), ([1e-12, -1e-12], [0, 0], 1, 0), ([1e-6, 0], [0, 0], 1, 1), ([1e-9, 0], [0, 0], 1, 1),
        ([1e-9, 0], [0, 0], 100, 0),
    ([2, 2], [-2, -1], 1, 0.5), ([2, 1], [2, 1], 1, 0), ([0, 0], [0, -3], 1, 1), ([1, 1], [-2, -1], 1, 0.5)])
def test_the_error_of_the_flux_is_over_the_largest_flux(inlet, outlet, extent, expected):
    """Rounding is below 1e-10 of the top speed (1) times the longer side."""
    run = SimpleNamespace(mesh="one", extent=(0, 0, 0.5, extent), fluid={"t": np.arange(2.0), "flux_in": np.array(inlet, float),
        "flux_out": np.array(outlet, float), "top_speed": np.array([0.5, 1])})
    assert quantities.flux_error(run) == pytest.approx(expected)
    run.fluid |= {name: np.zeros(2) for name in ("flux_in", "flux_out", "top_speed")}
    assert quantities.flux_error(run) == 0  # at rest


@pytest.mark.parametrize("gaps, expected", [([0.1, 0.2], 0), ([0.1, -0.2], 0.4), ([-0.3, 0.2], 0.6)])
def test_overlap_is_over_the_smallest_radius(gaps, expected):
    run = SimpleNamespace(fluid={"t": np.arange(2.0), "worst_gap": np.array(gaps)}, particles={"radius": np.array([2, 0.5])})
    assert quantities.worst_overlap(run) == pytest.approx(expected)


def test_what_a_quantity_of_ones_own_gives_is_judged(tmp_path):
    """One of the same name comes before the tool's; a nan and an error are reasons."""
    (tmp_path / "own.py").write_text("def mean_v(run):\n    return 5\ndef none(run):\n    return float('nan')\ndef bare(run):\n  "
        "  raise KeyError\n")
    known = quantities.load([tmp_path / "own.py"])
    found = {name: quantities.evaluate(quantities.parse(name, known), None) for name in ("mean_v", "none", "bare")}
    assert found["mean_v"] == (5,
        "") and found["none"][1] == "the quantity is nan" and found["bare"][1] == "KeyError" and math.isnan(found["none"][0])


def measured(folder, *command, environment=None):
    """(status of measure.py, status, CPU s, wall s, MiB) of a command."""
    done = subprocess.run([sys.executable, "-I", "-S", ROOT / "tools" / "base" / "measure.py", folder / "cost", *command],
        capture_output=True, env=environment)
    return done.returncode, *map(float, (folder / "cost").read_text().split())


def test_the_cost_of_a_command_is_its_own(tmp_path):
    """100 MB filled, some time asleep."""
    work = "import time, os; a = b'1' * 100_000_000; time.sleep(0.4); os._exit(3)"
    ended, status, cpu, wall, memory = measured(tmp_path, sys.executable, "-I", "-S", "-c", work)
    assert ended == status == 3 and 0.4 < wall < 60 and 95 < memory < 130
    assert 0 < cpu < wall - 0.3


def test_the_system_s_time_counts(tmp_path):
    copy = f"import resource; data = b'1' * 1_000_000; f = open({str(tmp_path / 'big')!r}, 'wb', 0); [(f.seek(0), f.write(data)) for _ in range(300)]; u = resource.getrusage(resource.RUSAGE_SELF); print(u.ru_stime)"
    done = subprocess.run([sys.executable, "-I", "-S", ROOT / "tools" / "base" / "measure.py", tmp_path / "cost", sys.executable,
        "-I", "-S", "-c", copy], capture_output=True, text=True)
    system, cpu = float(done.stdout), float((tmp_path / "cost").read_text().split()[1])
    assert cpu >= system > 0


def test_a_command_that_a_signal_ends_is_told_by_its_number(tmp_path):
    assert measured(tmp_path, "sh", "-c", "kill -9 $$")[:2] == (137, -9)
    assert not (tmp_path / "cost.new").exists()


def test_the_command_has_the_environment_and_its_words_are_needed(tmp_path):
    assert measured(tmp_path, "sh", "-c", "exit $MEASURED", environment={**os.environ, "MEASURED": "7"})[:2] == (7, 7)
    done = subprocess.run([sys.executable, "-I", "-S", ROOT / "tools" / "base" / "measure.py", tmp_path / "cost"],
        capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("usage: ") and done.stderr.count("\n") == 1
