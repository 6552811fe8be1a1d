"""tools.bench: ratios at equal error, rounds, what is cut out of a program, the page, and a tiny run."""
import csv
import math
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base.command import BadInput
from tools.base.runner import Done, own_folder
from tools.base.timed import tree, without_calls, without_guarded
from tools.bench import __main__ as bench
from tools.bench import figure as figures
from tools.bench import flow, scenes, skip
from tools.bench.page import write_page
from tools.bench.rounds import Job, Point, collect, ratio_at_equal_error, run_rounds
from tools.peers import contact_packages as bench_contacts
from tools.plot import style as plotting
from tools.study.convergence import fitted_order
from tools.study.extrema import peak, vortices


def curve(program, costs, errors, problem="2d1"):
    return [Point("flow", problem, program, k, 3, 1000 * 2**k, e, 100.0, c, math.nan, (0.9 * c, 1.1 * c)) for k,
        (c, e) in enumerate(zip(costs, errors))]


def test_the_ratio_at_equal_error_is_that_of_the_curves():
    cost = np.array([1.0, 2, 4, 8])
    mine = curve("standard", cost, 0.1 * cost**-2)
    other = curve("published", 30 * cost, 0.1 * cost**-2)
    ratio, at, bound = ratio_at_equal_error(mine, other)
    assert ratio == pytest.approx(30) and bound == "" and 0.1 / 64 < at < 0.1
    # another slope: error 1/cost against 1/cost^2 at the middle of the common errors
    ratio, at, _ = ratio_at_equal_error(curve("standard", [1, 100], [1, 1e-4]), curve("published", [1, 1e4], [1, 1e-4]))
    assert at == pytest.approx(1e-2) and ratio == pytest.approx(10)


def test_errors_that_do_not_meet_give_bounds_or_nothing():
    mine = curve("standard", [1, 4], [1e-2, 1e-3])
    ratio, at, bound = ratio_at_equal_error(mine, curve("published", [50, 200], [0.2, 0.1]))
    assert (ratio, bound) == (pytest.approx(200), ">") and at == pytest.approx(0.1)
    ratio, at, bound = ratio_at_equal_error(mine, curve("lbmpy", [0.4, 1], [1e-4, 1e-5]))
    assert (ratio, bound) == (pytest.approx(0.1), "<") and at == pytest.approx(1e-3)
    assert ratio_at_equal_error(mine, curve("lbmpy", [0.01, 0.02], [0.5, 0.4])) is None  # cheaper and worse
    assert ratio_at_equal_error(mine, curve("lbmpy", [90, 100], [1e-4, 1e-5])) is None  # dearer and better
    assert ratio_at_equal_error(mine, []) is None


def test_points_that_are_beaten_do_not_count():
    mine = curve("standard", [1, 2, 4], [1e-1, 3e-1, 1e-2])  # the second is dearer and worse than the first
    with_it, without = (ratio_at_equal_error(some, curve("published", [10, 40], [1e-1, 1e-2]))
        for some in (mine, [mine[0], mine[2]]))
    assert with_it == without


def test_exponents_are_fitted():
    assert fitted_order([1, 10, 100], [2.0, 60, 1800]) == pytest.approx(math.log10(30))
    assert math.isnan(fitted_order([5, 5], [1, 2]))


def test_rounds_are_interleaved_and_what_is_long_or_fails_runs_once():
    order, now = [], [0.0]

    def job(name, seconds, fails=False):
        def run():
            order.append(name)
            now[0] += seconds
            if fails:
                raise BadInput("it broke")
            return {"unknowns": 10, "cpu_s": seconds * (1 + len(order)), "error": 0.1}
        return Job("flow", "2d1", name, 0, run)
    samples = run_rounds([job("a", 1), job("long", 9), job("bad", 1, True), job("b", 1)], 3, 5, say=lambda text: None,
        clock=lambda: now[0])
    assert order == ["a", "long", "bad", "b", "a", "b", "a", "b"]
    points = {point.program: point for point in collect(samples)}
    assert points["bad"].note == "it broke" and points["a"].number == 3 and points["long"].number == 1
    costs = sorted(s.own_s for s in samples if s.program == "a")
    assert points["a"].cost == costs[1] and points["a"].spread == (costs[0], costs[2])
    order.clear()
    run_rounds([job("a", 1), job("b", 1)], 5, 5, say=lambda text: None, clock=lambda: now[0], until=now[0] + 2.5)
    assert order == ["a", "b", "a"]


def test_what_a_feature_guards_is_cut_out():
    text = "a(); if (f > 0 && g) { b(); { c(); } } else d(); if (h) e(); if (f || h) i(); for (;;) if (f) { j(); } k();"
    cut, count = without_guarded(text, ["f"])
    assert count == 2
    assert cut == "a(); d(); if (h) e(); if (f || h) i(); for (;;) 1; k();"  # the loop does not take the next statement
    for kept in ("if (!f) a(); if (fg) b();", "if (g && !f) a();", "if (f == 0) a();", "if (f == 0 || g) a();",
        "if (!(f && g)) a();"):
        assert without_guarded(kept, ["f"]) == (kept, 0)
    assert without_guarded("if (f == 1 && !g) a();", ["f"]) == ("1;", 1)
    cut, count = without_calls("func int look(int n) { return 1; }\nlook(2);\nx = look(3);\n", ["look"])
    assert count == 1 and "x = look(3);" in cut and "func int look(int n)" in cut and "\nlook(2);" not in cut


@pytest.mark.parametrize("feature", skip.FEATURES, ids=lambda feature: feature.name)
def test_the_features_still_stand_in_the_sources(feature, tmp_path):
    for one in (feature.unused, feature.without):
        tree(tmp_path / "tree", one.script, 10, 2, one.guards, one.calls, one.files)  # raises where nothing can be cut
    if feature.without.files:
        changed = [name for name in feature.without.files if (tmp_path / "tree" / name).read_text() != (ROOT / name).read_text()]
        assert changed


def test_the_page_tells_all(tmp_path):
    cost = np.array([1.0, 2, 4])
    points = curve("standard", cost, 0.1 * cost**-2) + curve("published", 20 * cost, 0.1 * cost**-2)
    points.append(Point("flow", "2d1", "NGSolve", 0, 0, *[math.nan] * 5, note="could not be started"))
    sizes = [Point("scaling", "unknowns", "standard", k, 2, 10.0**k, math.nan, 50.0 * k, math.nan, 0.001 * 10**k, (0.001 * 10**k,)
        * 2) for k in (1, 2)]
    skipped = [skip.Skipped("fields", "no fields", 0.01, 0.01, 0.4, (-0.1, 0.9), 7), skip.Skipped("contacts", "far", 0.02, 0.01,
        100.0, (99.0, 101.0), 7),
               skip.Skipped("rotation", "none", note="no longer there")]
    text = write_page(points + sizes, [], skipped, ["osqp==1.1.3 is not installed: left out"], tmp_path, True, 3.0, (0.1, 2.5),
        "a machine").read_text()
    for part in ("published, at an error of", "20 times the time of the standard scheme", "could not be started",
        "osqp==1.1.3 is not installed", "a machine",
                 "time as size^1.00", "+0.40 % (-0.10 to +0.90) | 7 | yes", "| NO |", "no longer there",
                     "other work ran beside it", "FreeFEM 4"):
        assert part in text, part
    assert figures.draw(points + sizes, skipped, tmp_path / "bench.png").stat().st_size > 10_000


def test_a_tiny_run(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "jobs_of", lambda part, there, out, quick, limit: bench.transport_jobs(out, [50, 200], 1, 3))
    monkeypatch.setattr(bench, "peers", lambda install: (set(), ["lbmpy==2.0 is not installed: left out"]))
    monkeypatch.setattr(skip, "FEATURES", [skip.Feature("rotation", "spheres that do not turn", skip.CARRIED,
                        skip.Variant(skip.SPHERES, {**skip.ALONE, "-number": 20}, ("forceMagnus",), (), skip.CARRIED_FILES), 20)])
    affinity = bench.os.sched_getaffinity(0)
    try:
        assert bench.main(["--quick", "--parts", "transport", "skip", "--repeats", "1", "--out", str(tmp_path)]) == 0
    finally:
        bench.os.sched_setaffinity(0, affinity)
    rows = list(csv.DictReader(open(tmp_path / "bench.csv")))
    assert [row["program"] for row in rows] == ["standard", "SciPy", "standard", "standard"]
    errors = [float(row["error"]) for row in rows[:2]]
    assert 0 < errors[0] < 0.01 and 0 < errors[1] < 0.01
    assert float(rows[3]["step_s"]) > 0 and (tmp_path / "bench.png").is_file()
    assert "rotation" in (tmp_path / "bench.md").read_text()
    # another part later keeps these runs
    again = run_rounds([Job("contacts", "number", "standard", 0, lambda: {"unknowns": 5.0, "cpu_s": 0.5})], 1, 1, print)
    monkeypatch.setattr(bench, "run_rounds", lambda *words, **more: again)
    try:
        assert bench.main(["--keep", "--parts", "contacts", "--out", str(tmp_path)]) == 0
        with pytest.raises(BadInput, match="none can be kept"):
            bench.main(["--keep", "--parts", "contacts", "--out", str(tmp_path / "none")])
        assert not (tmp_path / "none").exists()
    finally:
        bench.os.sched_setaffinity(0, affinity)
    assert list(csv.DictReader(open(tmp_path / "bench.csv")))[:4] == rows and "transport: of an earlier run" in (tmp_path
        / "bench.md").read_text()


@pytest.mark.parametrize("words", [[], ["vortex", "9"], ["vortex", "0", "1", "2"], ["vortex", "0", "--help"]])
def test_a_peer_that_is_called_wrongly_says_how(words):
    done = subprocess.run([sys.executable, "-m", "tools.peers.with_scipy", *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 3 and done.stderr.startswith("error: usage: python -m tools.peers.with_scipy PROBLEM LEVEL, which "
        "are reference 0 to 0; vortex 0 to 2") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("words, found", [("a 0", ("a", 0)), ("a 2 0.9", ("a", 2, 0.9)), ("b 1", ("b", 1)), ("a", None),
    ("c 0", None), ("a 3", None), ("b 2", None), ("b -1", None), ("a one", None),
                                          ("b 0 1", None), ("a 0 1 1", None), ("a 0 0", None), ("a 0 -1", None), ("a 0 nan", None),
                                              ("a 0 inf", None)])
def test_the_problems_of_a_peer_have_levels_and_numbers_of_their_own(words, found, monkeypatch, capsys):
    """One number too many, a third level of two and a size of 0 were tracebacks."""
    monkeypatch.setattr(sys, "excepthook", sys.excepthook)  # the import replaces it
    from tools.peers.common import asked
    monkeypatch.setattr(sys, "argv", ["with_some.py", *words.split()])
    if found:
        assert asked({"a": 3, "b": 2}, {"a": ["SIZE"]}) == found
        return
    with pytest.raises(SystemExit) as caught:
        asked({"a": 3, "b": 2}, {"a": ["SIZE"]})
    assert caught.value.code == 3 and capsys.readouterr().err == "error: usage: python -m tools.peers.with_some PROBLEM LEVEL, which are a 0 to 2 [SIZE]; b 0 to 1\n"


def test_a_folder_that_is_not_the_tools_own_is_left_as_it_is(tmp_path):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "mine.mesh").write_text("")
    with pytest.raises(BadInput, match="holds other things than those of tools.bench"):
        own_folder(tmp_path, "bench", ("meshes",))
    assert (tmp_path / "meshes" / "mine.mesh").is_file()
    for _ in range(2):  # its own is emptied
        own_folder(tmp_path / "new", "bench", ("meshes",))
        assert not (tmp_path / "new" / "meshes").exists()
        (tmp_path / "new" / "meshes").mkdir()


def test_there_is_no_figure_of_nothing(tmp_path):
    assert figures.draw([], [], tmp_path / "none.png") is None


def test_labels_of_an_axis_do_not_lie_on_each_other(tmp_path, monkeypatch):
    """Sizes from 27404 to 76973 had the labels of six digits times 10^4 side by side."""
    drawn = []
    monkeypatch.setattr(figures, "save", lambda figure, path: drawn.append(figure))
    figures.draw([Point(section, "sphere", "standard", k, 1, unknowns, math.nan, 1.0, 1.0, 0.02 * 2**k)
        for section in ("scaling", "other", "more") for k, unknowns in enumerate((27404, 76973))], [], tmp_path)
    drawn[0].canvas.draw()
    axes = drawn[0].axes[0]
    ends = np.array([(box.x0, box.x1) for box in (tick.label1.get_window_extent() for tick in axes.xaxis.get_major_ticks())])
    assert len(ends) > 1 and (ends[1:, 0] > ends[:-1, 1]).all()
    plotting.plt.close(drawn[0])


def test_a_limit_that_is_no_time_is_refused():
    for word in ("nan", "0", "soon"):
        with pytest.raises(SystemExit) as caught:
            bench.parser().parse_args(["--limit", word])
        assert caught.value.code == 3


def test_times_of_contacts_within_a_decade_have_numbers_at_their_axis(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(plotting, "save", lambda figure, path: drawn.append(figure))
    bench_contacts.picture([{"disks": 50, "kind": "random", "solver": solver, "tolerance": 1e-8, "cpu_s": cpu} for solver,
        cpu in (("newton", 0.002), ("uzawa", 0.004))], tmp_path)
    drawn[0].canvas.draw()
    axes, = drawn[0].axes
    low, high = axes.get_ylim()
    assert sum(bool(tick.get_text()) and low <= tick.get_position()[1] <= high for tick in axes.get_yticklabels(which="both")) > 1
    plotting.plt.close(drawn[0])


@pytest.mark.parametrize("name", ["drag_most", "lift_range", "strouhal"])
def test_a_number_of_a_benchmark_that_is_none_gives_no_error(name):
    """Where vortices had no period the error was that of the drag alone."""
    found = {"drag_most": 3.3, "lift_range": 2.1, "strouhal": 0.3}
    assert flow.error("2d2", found) == pytest.approx(2.1 / 2.007871 - 1)
    for broken in ({**found, name: math.nan}, {key: value for key, value in found.items() if key != name}):
        with pytest.raises(BadInput, match=f"2d2: no value of {name}"):
            flow.error("2d2", broken)


def test_a_fall_that_ends_early_is_a_line_of_the_page(monkeypatch, tmp_path):
    """It ended the benchmark."""
    def short(script, options, out, limit):
        out.mkdir(parents=True)
        (out / "particles.csv").write_text("step,t,id,x,y,theta,u,v,omega,radius\n0,0,0,1,4,0,0,0,0,0.1\n1,0.2,0,1,3,0,0,-5,0,0.1\n")
        return Done(0, "", 1.0, 1.0, 1.0, "")
    monkeypatch.setattr(scenes, "run_case", short)
    monkeypatch.setattr(scenes, "mesh", lambda *words: tmp_path / "some.mesh")
    sample, = run_rounds([job for job in scenes.particle_jobs(tmp_path, {"published": [(3, 0.005)]}, [], {}, 9)], 1, 9,
        say=lambda text: None)
    assert sample.note == "the rows go from t = 0 to 0.2, not over 0.3 to 0.4"


def test_a_time_of_our_own_that_missed_the_residual_is_none(monkeypatch):
    """It stood beside times of packages that had to reach it."""
    project, scene = bench_contacts.project, bench_contacts.packing(30, seed=2)
    found = bench_contacts.run_own("newton", scene, 1e-8, 60)
    assert found["cpu_s"] > 0 and found["residual"] < 1e-8

    def loose(*words, **options):
        answer = project(*words, **options)
        answer.contacts = answer.contacts[1:]
        return answer
    monkeypatch.setattr(bench_contacts, "project", loose)
    found = bench_contacts.run_own("newton", scene, 1e-8, 60)
    assert found["note"] == "residual not reached" and "cpu_s" not in found and found["residual"] > 1e-8


def test_the_numbers_of_a_vortex_street_are_those_of_its_waves():
    """Of 20 samples a period; waves that do not rise twice, or are not there, have no frequency."""
    t = np.arange(0, 3, 0.05 / 3)
    found = vortices(t, 3 + 0.1 * np.sin(12 * np.pi * t + 1), 0.02 + np.where(t > 1, 1.0, 9.0) * np.sin(6 * np.pi * t), 1)
    assert found == pytest.approx({"drag_most": 3.1, "drag_least": 2.9, "lift_range": 2, "strouhal": 0.3}, rel=1e-3)
    for some, values in ((t < 1.3, np.sin(6 * np.pi * t)), (t > 0, 0 * t)):
        assert math.isnan(vortices(t[some], t[some], values[some], 1)["strouhal"])
    assert all(math.isnan(value) for value in vortices(t, t, t, 2.98).values())
    assert peak(np.array([0.0, 1, 3]), np.array([1.0, 1, 1])) == (1, 1)


def test_each_kind_of_packing_has_a_picture(tmp_path, monkeypatch):
    """Only the first had one."""
    rows = [{"disks": number, "kind": kind, "solver": "newton", "tolerance": 1e-8, "cpu_s": 1e-5 * number} for kind in ("random",
        "gravity") for number in (50, 500)]
    monkeypatch.setattr(bench_contacts, "table", lambda *words, **more: rows)
    assert bench_contacts.main(["--kinds", "random", "gravity", "--peers", "--out", str(tmp_path / "two")]) == 0
    assert sorted(path.name for path in (tmp_path / "two").iterdir()) == ["bench_contacts.csv", "bench_contacts_gravity.png",
        "bench_contacts_random.png"]
    del rows[2:]
    assert bench_contacts.main(["--peers", "--out", str(tmp_path / "one")]) == 0
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == ["bench_contacts.csv", "bench_contacts.png"]
