"""Times and steps that are extreme or do not fit together: a run ends at -tend, or one line says what is wrong."""
import pytest

from tools.base.run_folder import RunFolder

SPHERE = """include "lib/case.idp"
optCase("sphere", "a sphere sinks, a scene of tests/flow/test_extreme_times.py");
optDefault("-mesh", "meshes/poiseuille.mesh"); optDefault("-drag", "schiller-naumann"); optDefault("-dt", "0.01");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = -9.81;
macro caseCarrier() { carrierWh u = 0*x, v = 0*x; carrierFlow(u[], v[]); } // EOM
macro caseParticles() { real[int] one(1), r(1), d(1), o(1); one = 0.5; r = 0.01; d = 2500; o = 0.; transportAppend(one, one, r, d, o, o, o); } // EOM
include "scripts/transport.edp"
"""
DRIVERS = {"resolved": ("cases/template.edp", [], "fluid"), "flow": ("cases/poiseuille.edp", [], "fluid"),
    "contacts": ("cases/falling_particles.edp", ["-number", 3], "motion"), "transport": (None, [], "steps")}


@pytest.fixture(params=DRIVERS)
def driver(request, tmp_path):
    """Script, options and name of the table of one driver."""
    script, words, table = DRIVERS[request.param]
    if script is None:
        script = tmp_path / "sphere.edp"
        script.write_text(SPHERE)
    return script, words, table


@pytest.mark.parametrize("end", ["1e-12", "1e-25"])
def test_a_step_far_above_the_end_is_one_step_to_the_end(end, driver, freefem, tmp_path):
    """Contacts and transport divided by 0, the others went on to the end of the step."""
    script, words, table = driver
    done = freefem(script, *words, "-tend", end, "-every", 0, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").table(table)
    assert rows["t"][-1] == float(end) and rows["step"][-1] == 1
    assert f"s is longer than -tend {float(end):g} s: one step of -tend" in done.stdout


@pytest.mark.parametrize("words, said", [
    (["-tend", "1e-300"], "out of range"), (["-tend", "1e-10", "-dt", "1e-25"], "more than 1e9"),
        (["-tend", "4e-324", "-dt", "4e-324"], "out of range"), (["-tend", "1", "-dt", "1e-300"], "out of range"),
])
def test_times_out_of_range_are_refused(words, said, driver, freefem_refused, tmp_path):
    script, more, _ = driver
    if words == ["-tend", "1e-300"]:
        words = [*words, "-dt", "1e-300"]  # a longer step is warned of too
    assert said in freefem_refused(3, script, *more, *words, "-out", tmp_path / "run")


# The options of time, as every driver declares them.
TIMES = """include "lib/case.idp"
optCase("times", "the options of time");
real timeEnd = optPositive("-tend", 1, "s", "end time"), timeStep = optPositive("-dt", 0.1, "s", "time step");
outDeclareEvery();
optEnd();
"""


@pytest.mark.parametrize("option", ["-tend", "-dt", "-every"])
def test_a_time_that_is_too_large_is_out_of_range(option, freefem_refused, tmp_path):
    (tmp_path / "times.edp").write_text(TIMES)
    assert f"{option} is out of range" in freefem_refused(3, tmp_path / "times.edp", option, "1e300")


@pytest.mark.parametrize("every", ["1e-300", "1e-320"])
def test_rows_of_a_tiny_interval_are_those_of_each_step(every, driver, freefem, tmp_path):
    script, more, table = driver
    freefem(script, *more, "-tend", 0.01, "-dt", 0.005, "-every", every, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").table(table)
    assert rows["t"][-2:] == pytest.approx([0.005, 0.01])


def test_fields_of_a_tiny_interval_are_those_of_each_step(freefem, tmp_path):
    freefem("cases/poiseuille.edp", "-tend", 0.03, "-dt", 0.01, "-fields", "1e-320", "-out", tmp_path / "run")
    assert len(list((tmp_path / "run").glob("fields_*.vtu"))) == 4
