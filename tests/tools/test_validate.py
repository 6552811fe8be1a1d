"""tools.validate: the registry, the judging of a row, the report, and failures as rows."""
import csv
import math
import types

import numpy as np
import pytest

from tests.conftest import make_mesh, run_tool
from tests.synthetic import ROOT, write_csv
from tools.peers import spheres_exact as transport_exact
from tools.validation import (
    two_way as transport_two_way, main as validate, turbulence as validate_steady, spheres as validate_transport)
from tools import validation
from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table
from tools.validation import (
    Context, Failed, Run, discover, ellipse, judge, particles, settling_disk, sprung_cylinder, suspension, turbulence)


def read_report(folder):
    text = (folder / "report.csv").read_text()
    head = dict(line[2:].split(": ", 1) for line in text.splitlines() if line.startswith("# "))
    rows = list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
    return head, rows


def good(context):
    """One that passes."""
    figure = context.figure_path("curves")
    figure.write_bytes(b"")
    yield context.row("a number <b>", "exact & known", 2.0, 2.001, rtol=1e-3, cpu_s=1.5, figure=figure)


def bad(context):
    """One that is off, and then breaks."""
    yield context.row("another", "exact", 0.0, 0.5, atol=0.1)
    raise Failed("cells_4: not converged (status 4)", 3.0)


def broken(context):
    """One with a mistake in it."""
    return [1 / 0]


def test_a_report_is_written_with_its_heading_and_failures_as_rows(tmp_path):
    rows = validate.validate([("first", good), ("second", bad), ("third", broken)], tmp_path, say=lambda line: None)
    assert [row.passed for row in rows] == [True, False, False, False]
    head, table = read_report(tmp_path)
    assert {"date", "commit", "host", "versions"} <= set(head)
    assert all(name in head["versions"] for name in ("FreeFEM", "python", "numpy", "gmsh")) and "cores" in head["host"]
    assert [row["pass"] for row in table] == ["yes", "no", "no", "no"]
    assert table[0]["figure"] == "figures/first_curves.png" and float(table[0]["cpu_s"]) == 1.5
    assert table[2]["reason"] == "cells_4: not converged (status 4)" and float(table[2]["cpu_s"]) == 3
    assert table[3]["reason"].startswith("ZeroDivisionError")
    page = (tmp_path / "report.html").read_text()
    assert "a number &lt;b&gt;" in page and "exact &amp; known" in page and "1 of 4 comparisons pass." in page
    assert page.count("<img") == 1 and head["commit"] in page


def test_a_run_that_fails_is_a_row_and_the_rest_goes_on(tmp_path):
    script = tmp_path / "stops.edp"
    script.write_text('cerr << "error: overlap of particles 1 and 2" << endl; exit(5);\n')

    def one(context):
        context.run(str(script), {}, "first")
        yield None
    rows = validate.validate([("stops", one), ("first", good)], tmp_path / "out", say=lambda line: None)
    assert rows[0].reason == "first: overlap of particles 1 and 2 (status 5)" and rows[1].passed


@pytest.mark.parametrize("measured,options,passed", [
    (1.01, {"rtol": 0.011}, True), (1.01, {"rtol": 0.009}, False), (1.01, {"atol": 0.02}, True), (3, {"at_most": 3}, True),
    (3, {"at_most": 2}, False), (3, {"at_least": 2}, True), (math.nan, {"rtol": 1}, False), (math.inf, {"at_most": 1}, False),
    (2, {"between": (2, 3)}, True), (3, {"between": (2, 3)}, True), (1.99, {"between": (2, 3)}, False), (3.01, {"between": (2, 3)},
        False), (math.nan, {"between": (0, 9)}, False),
    (math.nan, {"at_most": 1}, False), (math.nan, {"at_least": 1}, False), (math.inf, {"at_least": 2}, False),
        (-math.inf, {"at_most": 1}, False)])
def test_judging(measured, options, passed):
    assert judge(1.0, measured, **options)[0] is passed


def test_steady_flows_have_one_judge(tmp_path, monkeypatch):
    """A number below its range (a negative residual) passed one of two, and one that a run lacks ended all that came after it."""
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "run.json").write_text("{}")
    (folder / "results.csv").write_text("quantity,value,unit\nresidual,-1,\nloss,2,\n")

    def run(context, script, options, name, mesh=None):
        if name == "fails":
            raise Failed("fails: not converged (status 4)", 3.0)
        return Run(RunFolder(folder), 1.5, 0.0)
    monkeypatch.setattr(Context, "run", run)
    monkeypatch.setattr(validate_steady, "RUNS", [
        ("a", "a.edp", {}, [("residual", "asked for", 0, 1e-6), ("loss", "measured", 1.9, 2), ("drag", "measured", 1, 2)]),
        ("fails", "b.edp", {}, [("loss", "measured", 1, 2)]), ("c", "c.edp", {}, [("loss", "measured", 2.1, 3)])])
    monkeypatch.setattr(turbulence, "RUNS", validate_steady.RUNS)
    expected = [False, True, False, False, False]
    assert [row.passed for row in turbulence.turbulence(Context("flow", tmp_path))] == expected
    assert validate_steady.main(["--out", str(tmp_path)]) == 1
    _, rows = read_report(tmp_path)
    assert [row["pass"] == "yes" for row in rows] == expected
    assert [row["quantity"] for row in rows] == ["a: residual", "a: loss", "a: drag", "fails: loss", "c: loss"]
    assert rows[2]["reason"] == "results.csv has no drag" and "not converged" in rows[3]["reason"] and rows[4]["allowed"] == "2.1 to 3"
    validate_steady.RUNS.pop(0), validate_steady.RUNS.pop(0), validate_steady.RUNS.append(("d", "d.edp", {},
        [("loss", "measured", 1.9, 2)]))
    assert validate_steady.main(["--out", str(tmp_path), "--only", "d"]) == 0
    with pytest.raises(BadInput, match="no run has 'x' in its name: c, d"):
        validate_steady.main(["--only", "x"])


def test_every_registered_comparison_has_a_line_on_itself():
    found = discover()
    assert "settling_disk" in found
    assert validate.chosen(found, ["two_spheres"]) == [pair for pair in validate.chosen(found, ["spheres"])
        if pair[1].__name__ == "two_spheres"]
    for functions in found.values():
        assert functions and all(one.__doc__ for one in functions)


def test_names_of_modules_and_of_functions_pick():
    found = {"first": [good], "second": [bad, broken]}
    assert validate.chosen(found, ["second"]) == [("second", bad), ("second", broken)]
    assert validate.chosen(found, ["bad", "first", "second"]) == [("second", bad), ("first", good), ("second", broken)]
    assert len(validate.chosen(found, [])) == 3
    with pytest.raises(BadInput, match="no comparison third"):
        validate.chosen(found, ["third"])


def test_the_command(tmp_path, capsys):
    assert validate.main(["--out", str(tmp_path), "good"], {"first": [good, bad]}) == 0
    assert validate.main(["--out", str(tmp_path), "--case", "bad"], {"first": [good, bad]}) == 1
    assert "FAIL" in capsys.readouterr().out
    done = run_tool("validate", "nothing")
    assert done.returncode == 3 and done.stderr.count("\n") == 1 and "settling_disk" in done.stderr


def disk_like_published(folder, factor=1.0):
    """A run folder whose disk follows the digitised curves."""
    (t_y, y), (t_v, v) = settling_disk.published()
    import numpy as np
    t = np.linspace(0.02, 0.8, 400)
    folder.mkdir(parents=True)
    write_csv(folder / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","),
              [[k, s, 0, 1, np.interp(s, t_y, y), 0, 0, factor * np.interp(s, t_v, v), 0, 0.125] for k, s in enumerate(t)])
    return Run(RunFolder(folder), 1.0, 50.0)


def test_the_settling_disk_passes_on_its_own_reference_and_not_beside_it(tmp_path, monkeypatch):
    for factor, expected in ((1.0, True), (1.03, False)):
        context = Context("settling_disk", tmp_path / str(factor))
        monkeypatch.setattr(context, "run", lambda script, options, name, mesh: disk_like_published(
            tmp_path / f"{factor}_{name}", factor))
        rows = list(settling_disk.settling_disk(context))
        assert len(rows) == 16 and not rows[-1].passed  # one curve for all meshes: no order
        means = [row for row in rows if "mean velocity" in row.quantity]
        # The published curve itself lies 0.2 % beside the body-fitted mean, more than is allowed at D/h = 8.
        assert means[0].passed is expected
        assert all(row.passed is expected for row in rows if "peak" in row.quantity)
        assert (tmp_path / str(factor) / "figures" / "settling_disk_curves.png").stat().st_size > 10_000


def test_the_settling_disk_says_which_run_failed(tmp_path, monkeypatch):
    context = Context("settling_disk", tmp_path)

    def fails(script, options, name, mesh):
        raise Failed(f"{name}: no room", 2.0)
    monkeypatch.setattr(context, "run", fails)
    rows = list(settling_disk.settling_disk(context))
    assert [row.reason for row in rows] == ["cells_4: no room", "cells_6: no room", "cells_8: no room"]
    assert not any(row.passed for row in rows)


def test_discover_leaves_out_modules_without_a_list():
    assert discover(types.SimpleNamespace(__path__=[], __name__="tools.validation")) == {}


@pytest.mark.parametrize("text, says", [
    ("a,b\n1,2\n", "it has no column cpu_s"),
    ("disks,kind,solver,tolerance,cpu_s,search_s,memory_mb\n500,random,newton,tight,1,1,1\n", "could not convert string to "
        "float: 'tight'"),
    ("disks,kind,solver,tolerance,cpu_s,search_s,memory_mb\n500,random,piqp,1e-8,1,,\n", "no row of the solver newton"),
])
def test_the_benchmark_of_contacts_is_read_before_anything_is_computed(tmp_path, text, says):
    from tools.validation import contact_targets as validate_contacts
    (tmp_path / "other.csv").write_text(text)
    with pytest.raises(BadInput, match=says):
        validate_contacts.main(["--bench", str(tmp_path / "other.csv"), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_the_benchmark_of_contacts_is_judged(tmp_path):
    from tools.validation import contact_targets as validate_contacts
    (tmp_path / "bench.csv").write_text("disks,kind,solver,tolerance,cpu_s,search_s,memory_mb\n500,random,newton,1e-8,1,0.1,90\n500,random,piqp,1e-8,2,,\n500,gravity,newton,1e-8,,,\n")
    found = list(validate_contacts.speed(validate_contacts.benchmark(tmp_path / "bench.csv")))
    assert [row[2] for row in found] == [0.5, 0.1, 90]


def test_the_viscosity_of_one_disk_is_found(tmp_path):
    """The rows of its run were too far apart for the window of its mean."""
    assert suspension.spread([1.25]) == 0 and suspension.spread([1.0, 2.0]) == pytest.approx(0.5**0.5)
    found, _ = suspension.single(Context("suspension", tmp_path), 0.2, 8)
    assert found == pytest.approx(suspension.FITTED[0.2], rel=0.1)  # 3 elements across


def test_swings_are_measured_over_whole_periods():
    """A sine with an offset that grows in before, and one too short; the period kept of the body-fitted computation lies near its
    limit."""
    t = np.linspace(0, 20, 801)
    found = sprung_cylinder.swings(t, 6 + 0.02 * np.sin(4 * np.pi * t / 6), 6 + 0.5 * np.minimum(1, t / 5)
        * np.sin(2 * np.pi * (t - 1) / 6))
    assert found == pytest.approx((0.5, 1 / 6, 0.5), rel=2e-3)
    with pytest.raises(Failed, match="1 full periods instead of 2"):
        sprung_cylinder.swings(t[:400], t[:400], 6 + np.sin(2 * np.pi * t[:400] / 6 - 1))
    kept = read_table(ROOT / "tests" / "reference" / "sprung_cylinder_body_fitted.csv")
    assert sprung_cylinder.swings(kept["t"], kept["x"], kept["y"], 1) == pytest.approx(sprung_cylinder.FITTED, rel=0.01)


def test_the_body_fitted_cylinder_on_springs_goes_on_where_it_was_saved(freefem, tmp_path):
    """Its path in one run and in two, a step of first order apart."""
    script = ROOT / "tools" / "peers" / "body_fitted" / "sprung_cylinder.edp"
    mesh = make_mesh(tmp_path / "coarse.mesh", "cylinder_channel",
        *"--length 20 --height 12 --radius 0.5 --centre 6 6 --size 1.5 --growth 0.5 --circle-points 16".split())
    freefem(script, "-mesh", mesh, "-tend", 2.4, "-out", tmp_path / "whole.csv")
    freefem(script, "-mesh", mesh, "-tend", 1.2, "-save", tmp_path / "state")
    freefem(script, "-mesh", mesh, "-tend", 2.4, "-start", tmp_path / "state", "-out", tmp_path / "rest.csv")
    whole, rest = read_table(tmp_path / "whole.csv"), read_table(tmp_path / "rest.csv")
    assert rest["t"][0] == pytest.approx(1.2) and len(rest["t"]) == 17
    assert whole["y"][0] == 6.4 and whole["y"][-1] < 6
    for name in "xy":
        np.testing.assert_allclose(rest[name], whole[name][16:], atol=2e-3)


@pytest.mark.parametrize("at", [0, 1, 2])
def test_what_is_no_number_passes_in_no_row(at, tmp_path):
    """Python's max leaves out a nan that does not come first: momentum that was nan was kept to 1e-12."""
    def spoiled(steps=3):
        values = np.linspace(1, 2, steps)
        values[at] = math.nan
        return values
    level = np.ones(3)
    for parts in ((level, spoiled()), (spoiled(), level)):
        assert not judge(0, transport_two_way.changed(*parts), at_most=1)[0]
        table = {"source_x": level, "force_x": -level, "source_y": parts[0], "force_y": -parts[1]}
        assert not judge(0, transport_two_way.unbalanced(table), at_most=10)[0]
    names = "momentum_x momentum_y walls_x walls_y weight_x weight_y kinetic_energy work dissipated".split()
    for name, row in (("momentum_x", 0), ("kinetic_energy", 1)):
        write_csv(tmp_path / "budget.csv", names, np.column_stack([spoiled() if one == name else level for one in names]))
        (tmp_path / "run.json").write_text("{}")
        assert not judge(0, ellipse.missing(Run(RunFolder(tmp_path), 1.0, 0.0))[row], at_most=10)[0]


def test_what_history_changes_is_that_of_the_run(monkeypatch, tmp_path):
    """Two exact solutions were compared with each other: the row passed whatever the run gave."""
    def without_history(context, script, options, name, mesh=None):
        t = np.linspace(0, options["-tend"], 6)
        folder = types.SimpleNamespace(particles={"t": t, "v": -transport_exact.no_history(t, 5e-5, 2500.0)})
        return types.SimpleNamespace(folder=folder, cpu_s=1.0)
    monkeypatch.setattr(Context, "run", without_history)
    last = list(validate_transport.history(Context("transport", tmp_path)))[-1]
    assert last.quantity.startswith("history: what it changes") and last.measured < 1e-12 and not last.passed


def test_a_contact_that_is_missing_is_a_miss(monkeypatch):
    from tools.validation import contact_targets as validate_contacts
    project = validate_contacts.project

    def one_lost(*words):
        answer = project(*words)
        answer.contacts = answer.contacts[1:]
        return answer
    monkeypatch.setattr(validate_contacts, "project", one_lost)
    (_, target, measured), = validate_contacts.column()
    assert not measured <= target


def test_a_part_of_the_contacts_that_breaks_is_a_row_and_the_rest_goes_on(tmp_path, monkeypatch):
    """A package that is not there was a traceback, and no table of what had been done."""
    from tools.validation import contact_targets as validate_contacts
    from tools.validation import contacts

    def quadratic_program():
        raise ModuleNotFoundError("No module named 'piqp'")
    (tmp_path / "bench.csv").write_text("disks,kind,solver,tolerance,cpu_s,search_s,memory_mb\n500,random,newton,1e-8,1,0.1,90\n")
    monkeypatch.setattr(validate_contacts, "quadratic_program", quadratic_program)
    monkeypatch.setattr(contacts, "SOURCES", [(quadratic_program, "QP package piqp"), (validate_contacts.column, "weight above")])
    for name in ("instances", "row_of_disks", "momentum", "falling", "settled"):
        monkeypatch.setattr(validate_contacts, name, lambda: [])
    assert validate_contacts.main(["--bench", str(tmp_path / "bench.csv"), "--out", str(tmp_path / "out")]) == 1
    with open(tmp_path / "out" / "validate_contacts.csv", newline="") as stream:
        verdicts = [row["verdict"] for row in csv.DictReader(stream)]
    assert verdicts == ["pass", "MISSED (ModuleNotFoundError: No module named 'piqp')", "pass", "pass"]
    rows = list(contacts.contact_accuracy(Context("contacts", tmp_path)))
    assert [row.passed for row in rows] == [False, True] and "piqp" in rows[0].reason
    with pytest.raises(BadInput, match="leave one out"):
        validate_contacts.main(["--bench", str(tmp_path / "bench.csv"), "--full"])


def test_meshes_that_differ_in_an_option_have_files_of_their_own(tmp_path, monkeypatch):
    """run.json of the first of three runs named the mesh of the last."""
    monkeypatch.setattr(validation, "make_mesh", lambda words, path, limit: path)
    context = Context("particles", tmp_path)
    made = [context.mesh("couette_disk", 0.03125, "--length", length) for length in ("1", "4",
        "8")] + [context.mesh("couette_disk", 0.03125)]
    assert len(set(made)) == 4 and made[-1] == tmp_path / "meshes" / "couette_disk_0.03125.mesh"


def test_an_ellipse_that_has_not_turned_has_no_half_turn():
    """The end of its run was taken for it."""
    t = np.linspace(0, 9, 91)
    assert ellipse.half_turn({"t": t, "theta": np.pi / 2 - 0.4 * t}) == pytest.approx(np.pi / 0.4)
    with pytest.raises(Failed, match="turned by 2.7 rad only"):
        ellipse.half_turn({"t": t, "theta": np.pi / 2 - 0.3 * t})


def test_the_coarse_fall_of_two_disks_is_not_held_to_the_second_scheme(tmp_path, monkeypatch):
    """It was, where the fine one had failed."""
    t = np.linspace(0, 0.3, 31)
    low, high = ({"t": t, "x": 1 + x * t, "y": y - 10 * t} for x, y in ((0, 4.5), (0.1, 5.0)))

    def run(context, script, options, name, mesh=None):
        if name == "two_12":
            raise Failed("two_12: not converged (status 4)")
        return Run(types.SimpleNamespace(tracks={0: low, 1: high}, contacts={"t": np.array([0.16])}), 1.0, 1.0)
    monkeypatch.setattr(Context, "run", run)
    rows = list(particles.drafting_kissing_tumbling(Context("particles", tmp_path)))
    assert "not converged" in rows[0].reason and len(rows) > 4 and not [row for row in rows if "lattice" in row.source]
