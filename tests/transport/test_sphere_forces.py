"""Each force on a sphere against exact solutions (tools/validation/spheres.py, its short runs)."""
import pytest

from tools.validation import Context
from tools.validation import spheres as validate_transport

ALONE = ["drag", "terminal", "startup", "history", "lift", "magnus", "converging"]


@pytest.mark.parametrize("name", ALONE)
def test_force_alone(name, tmp_path):
    for row in getattr(validate_transport, name)(Context("forces", tmp_path, 300, lambda line: None)):
        assert row.passed, f"{row.quantity}: {row.measured} (target {row.target}, {row.allowed}) {row.reason}"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["history_cost", "mixed"])
def test_force_alone_at_length(name, tmp_path):
    test_force_alone(name, tmp_path)


def run(freefem, folder, *words, **options):
    return freefem("tests/transport/scripts/analytic.edp", "-out", folder, "-overwrite", 1, "-tend", 0.02, "-dt", 0.01, *words,
        **options)


@pytest.mark.parametrize("words, part", [
    (["-drag", "newton"], "must be one of off|stokes|constant"),
    (["-radius", "-1"], "must be above 0"),
    (["-turbulence", "yes"], "must be one of off|fluctuation|paper"),
    (["-history-window", "1"], "must be at least 2"),
    (["-drag-constant", "0"], "must be above 0"),
    (["-lift", "on"], "needs a number"),
    (["-magnsu", "1"], "unknown option -magnsu; the nearest is -magnus"),
])
def test_bad_option_is_one_line_and_status_3(freefem, run_folder, words, part):
    done = run(freefem, run_folder, *words, check=False)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1 and part in done.stderr


def test_a_force_that_is_off_changes_nothing(freefem, run_folder):
    """No force at all: a straight path."""
    run(freefem, run_folder, "-flow", "vortex", "-drag", "off", "-buoyancy", 0, "-added-mass", 0, "-lift", 0, "-start-u", 1,
        "-start-v", 0.5)
    last = (run_folder / "particles.csv").read_text().splitlines()[-1].split(",")
    assert [float(word) for word in last[3:8]] == pytest.approx([0.02, 0.01, 0, 1, 0.5], abs=1e-15)


@pytest.mark.parametrize("one, other, within", [
    (["-added-mass", 0], ["-added-mass-coefficient", 0], 0),
    (["-lift", 0], ["-lift-coefficient", 0], 0),
    (["-lift", 0, "-drag-constant", 0.88, "-radius", 0.002], ["-lift", 0], 1e-9)])
def test_coefficients_are_those_of_their_forces(one, other, within, freefem, tmp_path):
    """0 is none; the constant drag of a sphere twice as large, of twice the coefficient, accelerates it as much."""
    ends = []
    for name, words in (("one", one), ("other", other), ("plain", [])):
        run(freefem, tmp_path / name, "-flow", "vortex", "-fluid-acceleration", 1, "-start-x", 0.5, "-start-y", 0.3, "-start-u", 1,
            "-drag-tolerance", 1e-11, *words)
        ends.append([float(word) for word in (tmp_path / name / "particles.csv").read_text().splitlines()[-1].split(",")[3:8]])
    assert ends[0] == pytest.approx(ends[1], abs=within, rel=0) and abs(ends[1][4] - ends[2][4]) > 1e-5
