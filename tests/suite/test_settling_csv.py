"""A settling disk against a CSV of its own past: the pattern for a test of one's own case.

tests/data/settling_disk_short/particles.csv was written by
    FreeFem++ -nw cases/settling_disk.edp -tolerance 1e-5 -tend 0.1 -every 0.01 -out tests/data/settling_disk_short
and judged then by tools.validate (velocities within 0.4 % of a body-fitted computation).
"""
from tests.conftest import ROOT
from tools.check import compare

REFERENCE = ROOT / "tests" / "data" / "settling_disk_short" / "particles.csv"


def test_the_settling_disk_still_falls_as_it_did(freefem, run_folder):
    freefem("cases/settling_disk.edp", "-tolerance", "1e-5", "-tend", "0.1", "-every", "0.01", "-out", run_folder)
    result = compare(run_folder / "particles.csv", REFERENCE, columns={"y": 1e-6, "v": 1e-4})
    assert result, result


def test_the_comparison_sees_another_fluid(freefem, run_folder):
    freefem("cases/settling_disk.edp", "-tolerance", "1e-5", "-tend", "0.1", "-every", "0.01", "-mu", "0.101", "-out", run_folder)
    assert not compare(run_folder / "particles.csv", REFERENCE, columns={"y": 1e-6, "v": 1e-4})


def test_a_disk_at_rest_on_the_floor_presses_with_its_weight(freefem, run_folder):
    """Exact: impulse of a step = (rho_s - rho_f) pi r^2 g dt, within 2 %; velocity and overlap vanish."""
    import numpy as np

    freefem("cases/settling_disk.edp", "-y", "0.1250001", "-tend", "0.1", "-out", run_folder)
    contacts = np.genfromtxt(run_folder / "contacts.csv", delimiter=",", names=True)
    particles = np.genfromtxt(run_folder / "particles.csv", delimiter=",", names=True)
    weight = 0.25 * np.pi * 0.125**2 * 981
    late = contacts["t"] > 0.05
    assert late.sum() > 30
    np.testing.assert_allclose(contacts["impulse"][late], weight * 0.00125, rtol=0.02)
    assert np.abs(particles["v"][-1]) < 1e-6 and particles["y"].min() > 0.125 * (1 - 1e-8)
