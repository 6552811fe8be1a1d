"""Paths of carried particles and their drag: orders, angles, history, ranges of the laws."""
import numpy as np
import pytest

from tests.scenes import ANALYTIC
from tests.tables import in_formula, records
from tools.base.tables import read_table
from tools.validation import Context
from tools.validation import spheres as validate_transport


@pytest.mark.parametrize("name", ["tracer", "together", "unsteady", "dispersion", "pair"])
def test_paths(name, tmp_path):
    for row in getattr(validate_transport, name)(Context("transport", tmp_path, 300, lambda line: None)):
        assert row.passed, f"{row.quantity}: {row.measured} (target {row.target}, {row.allowed}) {row.reason}"


@pytest.mark.parametrize("dt, steps", [(0.003, 4), (1, 1), (0.0025, 4)])
def test_the_last_step_ends_at_the_end(dt, steps, freefem, run_folder):
    freefem(ANALYTIC, "-out", run_folder, "-tend", 0.01, "-dt", dt)
    last = records(run_folder / "steps.csv")[-1]
    assert float(last["t"]) == pytest.approx(0.01, rel=1e-12) and int(last["step"]) == steps


def test_the_angle_is_the_integral_of_the_rotation(freefem, tmp_path):
    """Omega relaxes to half the vorticity, -1, at the rate 15 mu/(rho_p R2) = 15 /s, exactly at any step; its integral is the
    angle."""
    words = ["-flow", "shear", "-rate", 2, "-start-omega", 3, "-radius", 0.02, "-mu", 1, "-magnus", 1, "-gravity", 0, "-tend", 0.4]
    for dt in (0.04, 0.00125):
        freefem(ANALYTIC, "-out", tmp_path / str(dt), *words, "-dt", dt)
        last = records(tmp_path / str(dt) / "particles.csv")[-1]
        assert float(last["theta"]) == pytest.approx(-0.4 + 4 / 15 * (1 - np.exp(-6)),
            rel=1e-9) and float(last["omega"]) == pytest.approx(-1 + 4 * np.exp(-6), rel=1e-9)


def test_the_drag_of_a_hundred_thousand_spheres_is_found(freefem, run_folder):
    """One of them, whose slip falls to a tenth within a step: the secant went below 0, and its velocity was nan from there on."""
    freefem("tests/transport/scripts/bench.edp", "-number", 100000, "-tend", 0.008, "-every", 0.008, "-out", run_folder)
    table = read_table(run_folder / "particles.csv")
    assert len(table["u"]) == 200000 and np.isfinite(table["u"]).all()


FLAT = "carrierUX = 0.; carrierUY = 0.; carrierVX = 0.; carrierVY = 0.;"


def test_an_unsteady_flow_along_y_moves_a_sphere_as_one_along_x(freefem_text, tmp_path):
    sphere = "real[int] x0 = [0.], y0 = [0.], r = [0.01], d = [2500.], z = [0.]; transportAppend(x0, y0, r, d, z, z, z);"
    words = ["-fluid-acceleration", 1, "-history", 1, "-drag", "schiller-naumann", "-dt", 0.001, "-tend", 0.1, "-every", 0.01]
    along = in_formula(freefem_text, tmp_path / "x", f"carrierU = cos(30*t); carrierV = 0.; {FLAT} carrierUT = -30*sin(30*t); "
        f"carrierVT = 0.;", sphere, *words)
    up = in_formula(freefem_text, tmp_path / "y", f"carrierV = cos(30*t); carrierU = 0.; {FLAT} carrierVT = -30*sin(30*t); "
        f"carrierUT = 0.;", sphere, *words)
    assert abs(along["u"]).max() > 0.1
    np.testing.assert_allclose(up["v"], along["u"], rtol=1e-12, atol=1e-14)


def test_the_history_of_a_particle_does_not_hang_on_who_comes_and_goes(freefem_text, tmp_path):
    """In an unsteady shear flow, with all that a particle has (by one pass the drag is that of the slip before): one of three
    leaves when the tails of the history have begun, another enters later. Those who stay,
    and who enters, move as they do alone, bit for bit."""
    flow = "carrierU = 2.*py; carrierU += cos(30*t); carrierV = 0.; carrierUX = 0.; carrierUY = 2.; carrierVX = 0.; carrierVY = 0.; carrierUT = -30*sin(30*t); carrierVT = 0.;"
    sphere = "{{ real[int] x0 = [{}], y0 = [{}], r = [{}], d = [{}], u0 = [{}], z = [0.]; transportAppend(x0, y0, r, d, u0, z, z); }} "
    first, goes, last = (sphere.format(*values) for values in ((0., 0.1, 0.01, 2500., 0.5), (0.5, 0.2, 0.012, 4000., 2.),
        (0.1, -0.1, 0.008, 1500., -1.)))
    enters = "queueAt(0.2, 0.05, 0.009, 3000, 0.082);"
    words = ["-history", 1, "-history-window", 6, "-magnus", 1, "-drag", "schiller-naumann", "-drag-passes", 1, "-contacts", 0,
        "-dt", 0.002, "-tend", 0.12, "-every", 0.002]

    def moves(name, bodies):
        records = in_formula(freefem_text, tmp_path / name, flow + " // EOM\nmacro caseBound() 0.62", bodies, *words)
        return {number: np.column_stack([records[word][records["id"] == number] for word in ("t", "x", "y", "theta", "u", "v",
            "omega")]) for number in set(records["id"])}

    together, pair, alone = moves("together", first + goes + last + enters), moves("pair", first + last), moves("alone", enters)
    assert 20 < len(together[1]) < 40 and 15 < len(together[3]) < 25
    for one, other in ((together[0], pair[0]), (together[2], pair[1]), (together[3], alone[0])):
        np.testing.assert_array_equal(one, other)


def test_drag_that_has_not_settled_is_told_of_once(freefem, tmp_path):
    words = ("-flow", "shear", "-rate", 20, "-tend", 2)
    large = freefem(ANALYTIC, "-out", tmp_path / "large", *words, "-dt", 1).stdout
    assert large.count("has not settled after 12 passes") == 1 and "had not settled in 2 of 2 steps" in large
    assert "settled after 12 passes" not in freefem(ANALYTIC, "-out", tmp_path / "small", *words, "-dt", 0.01).stdout


def test_a_drag_law_beyond_its_range_is_told_of_once(freefem, tmp_path):
    """Flemmer and Banks's has no drag at all above a Reynolds number of a million."""
    words = ("-drag", "flemmer-banks", "-tend", 0.01, "-start-u")
    fast = freefem(ANALYTIC, "-out", tmp_path / "fast", *words, 1000, "-number", 2, "-spread", 0.1, "-radius-last", 1e-7).stdout
    assert fast.count("the drag law flemmer-banks is valid up to 300000") == 1
    assert "is valid up to 300000" not in freefem(ANALYTIC, "-out", tmp_path / "slow", *words, 10).stdout


def test_a_constant_drag_far_below_its_range_is_told(freefem, tmp_path):
    """Grains of 20 micrometres fell ninety times faster than Stokes's law says, without a word."""
    words = ("-radius", 1e-5, "-dt", 0.01, "-tend", 0.05)
    assert freefem(ANALYTIC, "-out", tmp_path / "constant", *words).stdout.count("use -drag schiller-naumann") == 1
    assert "use -drag" not in freefem(ANALYTIC, "-out", tmp_path / "fitted", *words, "-drag", "schiller-naumann").stdout
    assert "use -drag" not in freefem(ANALYTIC, "-out", tmp_path / "large", "-radius", 0.01, *words[2:]).stdout
    # from a Reynolds number of 2000 to 59
    assert "use -drag" not in freefem(ANALYTIC, "-out", tmp_path / "slowed", "-start-u", 1, "-gravity", 0, "-tend", 0.6, "-dt",
        0.01).stdout
    # 400
    assert "use -drag" not in freefem(ANALYTIC, "-out", tmp_path / "near", "-start-u", 0.2, "-gravity", 0, "-tend", 0.02, "-dt",
        0.01).stdout
