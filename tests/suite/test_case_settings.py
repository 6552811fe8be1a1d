"""What a case sets is asked for before anything is computed: labels, periods, inlets, ramps, particles that cannot stand where they
are put."""
import re

import pytest

from tests.conftest import ROOT
from tests.lint import files, seen_by_hooks
from tests.scenes import PERIODIC, SEAM, case, square


@pytest.mark.parametrize("body", ["bodyHeld(bodyDisk(0.5, {y}, 0.12, 3));", "bodyPinned(bodyEllipse(0.5, {y}, 0.12, 0.1, 0, 3));",
    "bodyDisk(0.5, {y}, 0.12, 3);"])
def test_a_body_cut_by_a_plane_of_symmetry_is_told_so(body, freefem_text, tmp_path):
    for y, said in ((0, "particle 0 is cut by the plane of symmetry, which no body may be, from ("),
        (1, "particle 0 overlaps the wall from (")):
        text = case(body.format(y=y), walls="labelLeft, labelRight, labelTop", slip="labelBottom")
        done = freefem_text(text, "-out", tmp_path / "run", check=False)
        assert done.returncode == 5 and said in done.stderr and ("plane" in done.stderr) == (y == 0), done.stderr


@pytest.mark.parametrize("period", [0, 1, -2])
def test_a_waiting_particle_is_asked_for_its_size_wherever_its_period_is_counted_from(period, freefem_text, tmp_path):
    """The elements of the mesh are 1/32 wide; half of one is asked for."""
    text = case(f"queueAt(0.5, {0.5 + period}, 0.004, 1, 0.);", walls="", moving="labelLeft", outlet="labelRight", more=SEAM,
        period=1)
    done = freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-out", tmp_path / "run", check=False)
    assert (done.returncode == 5 and "elements per diameter" in done.stderr
        and len(done.stderr.strip().splitlines()) == 1), done.stderr
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("upper, words", [(dict(edges=10), "lower and upper sides have 12 and 10 edges"), (dict(above="1 - s^1.1"),
    "lower and upper sides have their vertices at different places")])
def test_sides_of_a_period_that_do_not_match_are_refused(upper, words, freefem_text, tmp_path):
    """FreeFEM itself dies of them."""
    mesh = tmp_path / "square.mesh"
    done = freefem_text(square(mesh, **upper) + case("", walls="labelLeft, labelRight", more=PERIODIC, period=1), "-mesh", mesh,
        "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("queue, status, words", [
    ("queueAdd(0.95, 0.12, 1, 0.);", 5, "would overlap a wall by"), ("queueAdd(0.5, 0.6, 1, 0.);", 5, "would overlap a wall by"),
    ("queueAdd(0.5, 0.12, -1, 0.);", 3, "has density -1"), ("queueAdd(0.5, -0.1, 1, 0.);", 3, "no radius above 0"),
    ("queueAt(0.5, 0.95, 0.12, 1, 0.);", 5, "the waiting particle 0 (the first is 0; at (0.5, 0.95), radius 0.12) would overlap "
        "a wall by 0.07 where it enters"),
    ("queueAt(0.5, 1.3, 0.12, 1, 0.);", 5, "the waiting particle 0 (the first is 0) enters at (0.5, 1.3), outside the mesh"),
    ("queueAt(sqrt(-1.), 0.5, 0.12, 1, 0.);", 3, "a place, an angle or a time that is not finite"),
        ("queueEllipse(0.5, 0.12, 0.06, sqrt(-1.), 1, 0.);", 3, "an angle"),
    ("queueEllipse(0.5, 0.1, 0.12, 0, 1, 0.);", 3, "is an ellipse of semi-axes 0.1 and 0.12;"),
        ("queueEllipse(0.5, 0.1, 0, 0, 1, 0.);", 3, "semi-axes 0.1 and 0;"),
    ("queueEllipseAt(0.5, 0.95, 0.12, 0.06, 0, 1, 0.);", 5, "would overlap a wall by")])
def test_a_waiting_particle_that_cannot_enter_is_refused(queue, status, words, freefem_text, tmp_path):
    text = case(queue, walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() 1. // EOM")
    done = freefem_text(text, "-out", tmp_path / "run", check=False)
    assert done.returncode == status and words in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("lists", [dict(outlet="labelTop"), dict(moving="labelTop"), dict(slip="labelTop")])
def test_a_label_has_one_condition(lists, freefem_text, tmp_path):
    done = freefem_text(case("", **lists), "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "is listed twice" in done.stderr and not (tmp_path / "run").exists()


@pytest.mark.parametrize("more, period, words", [
    (SEAM, 0, "flowPeriodY is 0,"), (SEAM, 0.9, "but the period along y is 0.9"), ("", 1, "flowPeriodY is 1,"),
    ("macro flowPeriodicLabels() [labelBottom, labelTop] // EOM", 1, "are not periodic")])
def test_the_settings_of_a_period_belong_together(more, period, words, freefem_text, tmp_path):
    walls = "" if "Labels" in more else "labelBottom, labelTop"
    text = case("", walls=walls, moving="labelLeft", outlet="labelRight", more=more, period=period)
    done = freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stderr and not (tmp_path / "run").exists()


def test_fluxes_of_a_closed_box_are_refused(freefem_text, tmp_path):
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 3);"), "-fluxes", 1, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "-fluxes 1 is for flows with an inlet" in done.stderr and not (tmp_path / "run").exists()


def test_an_inlet_without_an_outlet_is_refused(freefem_text, tmp_path):
    """What flows in has no way out; 2/3 m2/s by the parabola."""
    text = case("bodyDisk(0.5, 0.5, 0.12, 3);", walls="labelRight, labelBottom, labelTop", moving="labelLeft",
        more="macro boundaryU() (4*y*(1 - y)) // EOM")
    done = freefem_text(text, "-out", tmp_path / "run", check=False)
    assert (done.returncode == 3 and "have a net flux of 0.666667, and there is no outlet" in done.stderr
        and len(done.stderr.strip().splitlines()) == 1)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("old, new, says", [
    ("return 1;", "return acos(2 + t);", "boundaryRamp(0), the factor on the velocities at the boundary, is "),
    ("boundaryU() 1.", "boundaryU() acos(2 + y)", "boundaryU or boundaryV is not finite somewhere on label 11 (left)"),
    ("gravityY = -1", "gravityY = acos(2.)", "gravityX is 0 and gravityY "),
    ("include \"scripts", "macro flowForceX() log(-1. - y) // EOM\ninclude \"scripts", "flowForceX or flowForceY, the force on "
        "the fluid, is not finite"),
    ("optCase(", "// (", "the case has no name"), ("optDefault(\"-mesh\"", "// (", "no mesh is given")])
def test_what_a_case_sets_is_asked_for_before_anything_is_computed(old, new, says, freefem_text, tmp_path):
    text = case("", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() 1. // EOM")
    assert old in text
    done = freefem_text(text.replace(old, new), "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1, done.stderr


@pytest.mark.parametrize("more", ["bodyQ[0] = sqrt(-1.);", "bodyX[0] = 1e200;"])
def test_what_a_step_of_the_case_makes_no_number_is_told(more, freefem_text, tmp_path):
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.15, 1.5);", more=f"macro caseStep() {more} // EOM"), "-tend", 0.05, "-out",
        tmp_path / "run", check=False)
    assert done.returncode == 3 and "caseStep has given a particle" in done.stderr and done.stderr.count("\n") == 1, done.stderr


def test_a_budget_with_particles_that_wait_is_refused(freefem_text, tmp_path):
    done = freefem_text(case("queueAt(0.5, 0.5, 0.12, 1, 0.);"), "-budget", 1, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "present from the start" in done.stderr and not (tmp_path / "run").exists()


@pytest.mark.parametrize("body, words", [("bodyPinned(bodyDisk(0.05, 0.5, 0.12, 1));",
    "whose given velocity differs from its own"), ("bodyDisk(0.05, 0.5, 0.12, 1);", "whose given velocity holds it there")])
def test_a_body_that_reaches_into_an_inlet_is_told(body, words, freefem_text, tmp_path):
    text = case(body, walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() (4*y*(1 - "
        "y)) // EOM")
    assert "particle 0 overlaps an inlet, " + words in freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run").stdout


@pytest.mark.parametrize("more, warned", [("macro boundryU() 1. // EOM", 1), ("macro boundaryU() 1. // EOM", 0)])
def test_an_inlet_that_lets_in_nothing_is_told(more, warned, freefem_text, tmp_path):
    text = case("", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more=more, gravity=0)
    done = freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run")
    assert ("warning: boundaryU and boundaryV are 0 all along label 11 (left)" in done.stdout) == warned


@pytest.mark.parametrize("more, told", [("macro casemotion(now) givenMotion(0, 1, 0, 0); // EOM", "casemotion"),
    ("macro caseLoad(now) bodyPush(0, 1, 0, 0); // EOM", "caseLoad"),
                                        ("macro boundaryW() 1. // EOM", "boundaryW"), ("// macro caseSteps() of old", None),
                                        ("macro caseRadius() 0.1 // EOM\nmacro caseStep() if (caseRadius > 1) exit(7); // EOM",
                                            None)])
def test_a_macro_that_nobody_asks_for_is_told(more, told, freefem_text, tmp_path):
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 2);", more=more), "-tend", 0.01, "-out", tmp_path / "run")
    assert re.findall(r"warning: the macro (\w+) is used nowhere", done.stdout) == [told] * (told is not None)


@pytest.mark.parametrize("more, name", [("real flowForceX = 5;", "flowForceX"),
    ("real push = 2,\n    flowForceY = push;", "flowForceY"),
    ("int[int] flowPeriodicLabels = [labelLeft, labelRight];", "flowPeriodicLabels"), ("func real boundaryU(real s) { return 1; }",
        "boundaryU"), ("func boundaryU = 4*y*(1 - y);", "boundaryU"), ("func int caseStep() { return 1; }", "caseStep"),
    ("real flowForceX = 5;\nmacro flowForceX() 1. // EOM", None), ("real push = max(0., 1.); // real flowForceX = 5;", None),
    ("macro flowForceX() 1. // EOM\nreal push = flowForceX, twice = 2*flowForceX;", None)])
def test_a_variable_or_function_for_a_macro_is_refused(more, name, freefem_text, tmp_path):
    """It was passed over: the macro of that name took its place, with 0, nothing, or no labels."""
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 2);", more=more), "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == (3 if name else 0), done.stderr
    assert not name or (f"the case declares {name} as a variable or a function" in done.stderr
        and len(done.stderr.strip().splitlines()) == 1)


def test_spaces_of_a_period_need_its_labels(freefem_text, tmp_path):
    """Sides that did not match ended with status 139 where flowPeriodicLabels was no macro."""
    done = freefem_text(case("", more=SEAM.replace("macro flowPeriodicLabels", "macro someLabels")), "-out", tmp_path / "run",
        check=False)
    assert done.returncode == 3 and "but no macro flowPeriodicLabels()" in done.stderr, done.stderr


# Names that drivers and forms have had for their own: a case's macros found those instead, in silence or with a riddle of the
# compiler.
OWN_NAMES = """real {u} = 1, {w} = 0.3, {rate} = 4, {c0} = 0.25, {step} = 7, {entered} = 0.5;
macro boundaryU() ({u}*4*y*(1 - y)) // EOM
macro flowForceX() ({w}*{u}) // EOM
macro caseMotion(now) givenMotion(0, 0, 0, {rate}*now/{c0}); // EOM
macro caseLoads(now) bodyPush(1, {entered}*now, 0, 0); // EOM
macro caseBoundary(now) inflowScale(labelLeft, 1 - {step}*now); // EOM
macro caseStep() cout << "own " << {c0} + {step} + {entered} << " " << bodyAtX(1) - bodyX[1] << endl; // EOM"""
NAMES = "u w rate c0 step entered".split()


def test_a_case_may_call_its_own_numbers_as_it_likes(freefem_text, tmp_path):
    out = []
    for k, names in enumerate((NAMES, [f"mine{k}" for k in range(len(NAMES))])):
        text = case("bodyHeld(bodyDisk(0.4, 0.4, 0.12, 2)); bodyDisk(0.6, 0.7, 0.12, 2);", walls="labelBottom, labelTop",
            moving="labelLeft", outlet="labelRight",
                    more=OWN_NAMES.format(**dict(zip(NAMES, names))))
        done = freefem_text(text, "-tend", 0.03, "-every", 0, "-out", tmp_path / str(k))
        assert done.stdout.count("own 7.75 0\n") == 3
        out.append((tmp_path / str(k) / "particles.csv").read_bytes())
    assert out[0] == out[1]


def test_names_that_a_macro_of_a_case_meets_in_a_driver_are_those_of_the_library():
    for path in files(".edp") + files(".idp"):
        if path.startswith("scripts/"):
            met = seen_by_hooks(path, inner=path.endswith(".idp"))
            assert all(re.match(r"(drive|pub|published|mul)[A-Z]|timeNow$", name) for name in met), (path, met)


def test_no_macro_of_the_library_is_a_single_word():
    """It would be put in place of a case's own name. (That of lib/core/ranks.idp ends with its block.)"""
    for path in files(".idp"):
        if path.startswith("lib/") and path != "lib/core/ranks.idp":
            assert not re.findall(r"^\s*macro ([a-z]+[0-9]*)\(", (ROOT / path).read_text(), flags=re.M), path


@pytest.mark.parametrize("words, told", [(("-penalty", 1e-5, "-indicator", "smooth"), ["-penalty", "-indicator"]),
    (("-scheme", "published", "-stabilise", 0.2, "-cfl", 0), ["-stabilise"]),
                                         (("-scheme", "published", "-penalty", 1e-5), []),
                                             (("-stabilise", 0.2, "-tolerance", 1e-6), [])])
def test_an_option_of_the_scheme_that_is_not_run_is_told(words, told, freefem_text, tmp_path):
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 2);"), "-tend", 0.01, *words, "-out", tmp_path / "run")
    other = "standard" if "published" in words else "published"
    assert re.findall(rf"warning: (-\w+) is for -scheme {other}[a-z ]* and does nothing here", done.stdout) == told


@pytest.mark.parametrize("more", ["real area = 3;", "real top = max(1., 2.), y = 0.5;", "func x = 2.;", "int pi = 3;",
    "real lenEdge = 0.1;", "int nuTriangle = 5;", ""])
def test_a_variable_that_hides_a_word_of_the_language_is_refused(more, freefem_text, tmp_path):
    """With area = 3 the elements were said to be too large, with y = 0.5 all of it was wrong in silence."""
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 2);", more=more), "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == (3 if more else 0) and ("which are names of FreeFEM" in done.stderr) == bool(more), done.stdout


@pytest.mark.parametrize("radius, asked", [(0.0005, True), (0.006, False)])
def test_particles_far_below_an_element_are_asked_for_their_unit(radius, asked, freefem_text, tmp_path):
    done = freefem_text(case(f"bodyDisk(0.51, 0.52, {radius}, 2);"), "-out", tmp_path / "run", check=False)
    assert (done.returncode == 5 and "elements per diameter" in done.stderr
        and ("different units" in done.stderr) == asked), done.stderr
