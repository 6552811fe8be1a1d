"""The default step of contacts alone follows the size of the bodies and their speed."""
import numpy as np
import pytest

from tools.base.run_folder import RunFolder

# two commands of one scene in other units of length and time: words, lengths of the first over the second, times
SIMILAR = [
    ("hopper_clogging", ["-number", 20, "-tend", 0.1], ["-radius", 0.01], ["-radius", 0.0025], 4, 2),
    ("fibres", ["-number", 5, "-tend", 0.1], [], ["-radius", 0.00125], 4, 2),
    ("granular_collapse", ["-number", 70, "-release", 0, "-tend", 0.08], [], ["-gravity", 4*9.81], 1, 2),
    ("falling_particles", ["-number", 20, "-tend", 6], [], ["-gravity", 100*0.02], 1, 10)]


@pytest.mark.parametrize("case, words, mine, other, length, time", SIMILAR, ids=[row[0] for row in SIMILAR])
def test_a_scene_in_other_units_makes_the_same_steps(case, words, mine, other, length, time, freefem, tmp_path):
    """Bound: the tolerances of the projection, 1e-7 radii, for a few hundred steps."""
    places = []
    for name, more, part in (("a", mine, 1), ("b", other, time)):
        own = [value/part if before in ("-tend", "-release") else value for before, value in zip(["", *words], words)]
        freefem(f"cases/{case}.edp", *own, *more, "-every", 0, "-out", tmp_path / name)
        table = RunFolder(tmp_path / name).table("particles")
        last = table["step"] == table["step"].max()
        places.append((table["step"].max(), np.array([table["x"][last], table["y"][last]])))
    assert places[0][0] == places[1][0] > 20
    assert places[1][1]*length == pytest.approx(places[0][1], abs=1e-4*0.005)


@pytest.mark.parametrize("case, words, step", [
    ("hourglass", [], 0.002), ("hourglass", ["-number", 500, "-radius", 0.013, "-neck", 0.12], 0.002),
    ("hourglass", ["-gravity", 4*9.81], 0.001), ("hourglass", ["-radius", 0.013/4, "-neck", 0.12/4], 0.001),
    ("falling_spheres", ["-rmin", 0.01, "-rmax", 0.02], 0.00125),
    ("rotating_drum_dry", ["-radius", 0.004], 0.001), ("heap", ["-radius", 0.02, "-gravity", 0], 0.001)])
def test_a_step_is_never_longer_than_the_case_s_own(case, words, step, freefem):
    line = next(line for line in freefem(f"cases/{case}.edp", *words, "-help").stdout.splitlines() if line.startswith("  -dt "))
    assert float(line.split()[1]) == pytest.approx(step, rel=1e-5)


def test_disks_that_fall_faster_fall_as_well(freefem, tmp_path):
    """Mean height of 20 disks before they land, against free fall; with a step of 0.02 s they were a tenth lower."""
    freefem("cases/falling_particles.edp", "-number", 20, "-gravity", 9.81, "-tend", 0.2, "-every", 0.2, "-out", tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("particles")
    high = [table["y"][table["step"] == step].mean() for step in (0, table["step"].max())]
    assert high[0] - high[1] == pytest.approx(0.5*9.81*0.2**2, rel=0.02)
