"""lib/core/options.idp: what the command line gives, and how nonsense is refused."""
import json
import math
from pathlib import Path

import pytest

from tests.conftest import ROOT

SCRIPT = """
include "lib/case.idp"
optCase("trial", "a script that only reads its options");
optDefault("-dt", "0.02");
real tEnd = optReal("-tend", 1./3, "s", "end time");
int number = optInt("-number", 5, 0, "how many");
real dt = optPositive("-dt", 0.1, "s", "time step");
real share = optWithin("-share", 0.5, 0, 1, "", "a share");
string scheme = optChoice("-scheme", "standard", "standard|published", "scheme");
string file = optFile("-mesh", "a.mesh", "mesh file");
int lift = optFlag("-lift", 1, "1: lift force");
optEnd();
cout.precision(17);
cout << "values " << tEnd << " " << number << " " << dt << " " << share << " " << scheme << " " << file << " " << lift << endl;
"""


def values(run):
    line = next(line for line in run.stdout.splitlines() if line.startswith("values "))
    return line.split()[1:]


def test_a_default_has_fifteen_digits_in_words_too(freefem_text):
    """run.json and checkpoints hold the words; a run that is given them is the same one."""
    out = freefem_text(SCRIPT + 'cout << "words " << optValues[0] << endl;' + 'cout << "digits " << optDigits(-2.*pi/7e5) << " " '
        '<< optDigits(0.1) << " " << optDigits(0.) << endl;').stdout
    assert float(out.split("words")[1].split()[0]) == pytest.approx(1 / 3, rel=2e-15)
    found = out.split("digits")[1].split()[:3]
    assert float(found[0]) == pytest.approx(-2 * math.pi / 7e5, rel=2e-15) and found[1:] == ["0.1", "0"]


def test_defaults_keep_all_their_digits_and_the_case_overrides_the_driver(freefem_text):
    tend, number, dt, share, scheme, file, lift = values(freefem_text(SCRIPT))
    assert float(tend) == 1 / 3
    assert (number, float(dt), float(share), scheme, file, lift) == ("5", 0.02, 0.5, "standard", "a.mesh", "1")


@pytest.mark.parametrize(
    "words, place, expected",
    [
        (["-tend", "2e-1"], 0, 0.2),
        (["-tend", "-1.5e-3"], 0, -1.5e-3),
        (["-tend", "+.5"], 0, 0.5),
        (["-number", "1e3"], 1, 1000),
        (["-v", "0", "-number", "7", "-nw"], 1, 7),
        (["-share", "1"], 3, 1),
        (["-lift", "0"], 6, 0),
    ],
)
def test_numbers_are_read(freefem_text, words, place, expected):
    assert float(values(freefem_text(SCRIPT, *words))[place]) == expected


@pytest.mark.parametrize(
    "words, says",
    [
        (["-tned", "1"], "unknown option -tned; the nearest is -tend"),
        (["-Number", "1"], "the nearest is -number"),
        (["-DT", "0.1"], "unknown option -DT; the nearest is -dt (time step)"),
        (["dt", "0.1"], "unknown option dt; the nearest is -dt"),
        (["-share", "0.1", "-dt=0.1"], "unknown option -dt=0.1; option and value are two words: -dt VALUE; -help"),
        (["--nmber=1", "-dt", "0.1"], "unknown option --nmber=1; option and value are two words: -number VALUE; -help"),
        (["-=1"], "unknown option -=1; option and value are two words; -help"),
        (["stray"], "unknown option stray"),
        (["-tend"], "-tend needs a value"),
        (["-tend", "1", "-tend", "2"], "given twice"),
        (["-tend", "abc"], "needs a number"),
        (["-tend", "1e"], "needs a number"),
        (["-tend", "1-2"], "needs a number"),
        (["-tend", "--1"], "needs a number"),
        (["-tend", "0x10"], "needs a number"),
        (["-tend", "nan"], "needs a number"),
        (["-tend", "inf"], "needs a number"),
        (["-tend", "1e999"], "out of range"),
        (["-tend", ""], "needs a number"),
        (["-number", "2.5"], "whole number"),
        (["-number", "-1"], "at least 0"),
        (["-number", "1e12"], "whole number"),
        (["-dt", "0"], "above 0"),
        (["-share", "1.5"], "between 0 and 1"),
        (["-lift", "2"], "must be 0 or 1, not 2"),
        (["-lift", "0.5"], "must be 0 or 1"),
        (["-lift", "yes"], "needs a number"),
        (["-scheme", "other"], "one of standard|published"),
        (["-scheme", ""], "one of standard|published"),
        (["-mesh", "a;b"], "characters other than"),
        (["-mesh", "'; true; '"], "characters other than"),
    ],
)
def test_nonsense_ends_with_status_3_and_one_line(freefem_text, words, says):
    run = freefem_text(SCRIPT, *words, check=False)
    assert run.returncode == 3
    lines = run.stderr.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and says in lines[0], run.stderr
    assert "values " not in run.stdout


def test_help_lists_every_option_with_its_default_and_unit(freefem_text):
    run = freefem_text(SCRIPT, "-help")
    for part in ("trial: a script", "-tend 0.333333 s", "-number 5", "-dt 0.02 s", "end time", "standard|published",
        "lift force (0|1)"):
        assert part in run.stdout
    assert "values " not in run.stdout


def test_run_json_can_be_read_whatever_the_texts_hold(freefem_text, run_folder):
    freefem_text(r'''include "lib/core/output.idp"
optCase("trial", "a \"round\" disk\tin C:\\flows\\");
real density = optReal("-rho", 1, "\"kg\"\\m3", "density");
outDeclare();
optEnd();
outBegin("");
outEnd(1, 1, "finished");
''', "-out", run_folder)
    run = json.loads((run_folder / "run.json").read_text())
    assert run["about"] == 'a "round" disk in C:\\flows\\' and run["units"]["-rho"] == '"kg"\\m3' and run["parameters"]["-rho"] == 1


@pytest.mark.parametrize("case", ["taylor_green", "settling_disk", "cylinder_steady", "pipe_flow"])  # a case of each driver
def test_a_tolerance_that_leaves_a_solver_nothing_to_do_is_refused(freefem_refused, tmp_path, case):
    assert "must be below 1, not 10" in freefem_refused(3, f"cases/{case}.edp", "-tolerance", 10, "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("case, flag", [("taylor_green", "-convection"), ("pipe_transport", "-lift"), ("cylinder_steady",
    "-fields"), ("pipe_flow", "-axisymmetric")])
def test_a_flag_of_a_driver_is_0_or_1(freefem_refused, tmp_path, case, flag):
    assert "must be 0 or 1, not 2" in freefem_refused(3, f"cases/{case}.edp", flag, "2", "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_default_of_no_option_is_refused(freefem_text, tmp_path):
    text = Path("cases/template.edp").read_text().replace('optDefault("-dt"', 'optDefault("-dtt"')
    assert "-dtt" in text
    done = freefem_text(text, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "default of -dtt" in done.stderr and not (tmp_path / "run").exists()


@pytest.mark.parametrize("name, says", [("-tolerance", "declared twice"), ("-stabilise", "declared twice"),
    *((name, "FreeFEM's own") for name in ("-v", "-log", "-f", "-ns", "-wait", "-jc", "-?", "-help"))])
def test_an_option_of_a_name_that_is_taken_is_refused(name, says, freefem_text, tmp_path):
    text = Path("cases/template.edp").read_text().replace('"-diameter"', f'"{name}"')
    done = freefem_text(text, "-out", tmp_path / "run", check=False)
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 3 and len(lines) == 1 and f"the option {name} " in lines[0] and says in lines[0] and not (tmp_path
        / "run").exists()


def test_an_option_begins_with_a_dash(freefem_text):
    """One without was taken, and stood in -help."""
    done = freefem_text(SCRIPT.replace('"-number"', '"number"'), check=False)
    assert done.returncode == 3 and "the option 'number' does not begin with -" in done.stderr


def test_the_name_of_a_case_names_a_folder(freefem_text):
    done = freefem_text(SCRIPT.replace('"trial"', '"my/trial"'), check=False)
    assert done.returncode == 3 and "holds a /" in done.stderr


def test_a_macro_of_another_driver_is_refused(freefem_text):
    """A force or a motion that a driver does not know was left out with a warning only."""
    text = """
    include "lib/case.idp"
    optCase("trial", "macros");
    macro caseLoads(now) bodyPush(0, 1, 0, 0); // EOM
    optEnd();
    optMacros("caseWalls caseParticles");
    """
    done = freefem_text(text, check=False)
    assert done.returncode == 3 and "the macro caseLoads of the case is for other drivers" in done.stderr
    assert done.stderr.count("\n") == 1 and freefem_text(text.replace("Particles", "Loads")).returncode == 0


def test_all_drivers_take_the_units_of_the_case(freefem_refused):
    """That of spheres named centimetres m."""
    for driver in (ROOT / "scripts").glob("*.edp"):
        assert "optDriver();" in driver.read_text() or driver.name.startswith("project_"), driver.name
    assert "by 0.126632 cm at the start" in freefem_refused(5, "cases/two_spheres.edp", "-trailing", 3.2)


def test_a_case_declares_its_units_once(freefem_text, tmp_path):
    text = """
    include "lib/case.idp"
    optCase("trial", "units");
    optUnits("mm", "mg", "ms");
    real own = optPositive("-own", 1, "s", "an option of the case"), other = optPositive("-other", 1, "mm", "another");
    optDriver();
    real tEnd = optPositive("-tend", 1, "s", "end"), speed = optPositive("-speed", 1, "m/s", "a speed");
    real most = optPositive("-maxwall", 1, "s", "of the wall clock"), length = optPositive("-width", 1, "m", "a length");
    outDeclare();
    optEnd();
    outBegin("");
    cout << "told " << optNamed("m/s") << " " << optNamed("m2/s") << endl;
    """
    assert "told mm/ms mm2/ms" in freefem_text(text, "-out", tmp_path / "run").stdout  # what warnings name
    info = json.loads((tmp_path / "run" / "run.json").read_text())
    assert info["base_units"] == {"length": "mm", "mass": "mg", "time": "ms"}
    assert {name: info["units"][name] for name in ("-own", "-other", "-tend", "-speed", "-maxwall", "-width")} == {"-own": "s",
        "-other": "mm", "-tend": "ms", "-speed": "mm/ms", "-maxwall": "s", "-width": "mm"}
    # a case that declares none: those of its own options
    shown = freefem_text(text.replace('optUnits("mm", "mg", "ms");', ""), "-help").stdout
    assert "-speed 1 mm/s " in shown and "-width 1 mm " in shown and "-tend 1 s " in shown
    for words, says in (('optUnits("mm", "mg/mm", "s");', "each a word of letters"),
        ('optDriver(); optUnits("mm", "mg", "s");', "before the driver is included")):
        done = freefem_text(text.replace('optUnits("mm", "mg", "ms");', words), check=False)
        assert done.returncode == 3 and says in done.stderr and done.stderr.count("\n") == 1
