"""tools.study: runs and their reuse, reports, recipes of meshes, failures."""
import csv
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import FREEFEM, eventually, run_tool
from tests.synthetic import ROOT, write_run
from tools.base import quantities
from tools.base.command import BadInput
from tools.base.mesh_files import read_mesh
from tools.base.run_folder import RunFolder
from tools.base.runner import fingerprint, run_command
from tools.study import study, figure as study_figure, report as study_report

# A stand-in for a case: its disk falls at -5.5 (1 + 0.3 h^2 + 2 dt^2), and it can fail.
SCRIPT = """
include "getARGV.idp"
real dt = getARGV("-dt", 0.01), tEnd = getARGV("-tend", 0.5);
string out = getARGV("-out", "out"), meshFile = getARGV("-mesh", "");
mesh Th = readmesh(meshFile);
real hh = 1./sqrt(real(Th.nt)/2.);
if (getARGV("-fail", 0.) > dt) { cerr << "error: not converged; take a smaller -dt" << endl; exit(4); }
exec("mkdir -p '" + out + "'");
{ ofstream f(out + "/particles.csv"); f.precision(12); f << "step,t,id,x,y,theta,u,v,omega,radius" << endl;
int n = int(tEnd/dt + 0.5);
for (int k = 0; k <= n; ++k) f << k << "," << k*dt << ",0,1,2,0,0," << -5.5*(1 + 0.3*hh^2 + 2*dt^2) << ",0,0.1" << endl; }
"""


def square_mesh(which, size):
    """The mesh of an element size, for run_study."""
    path = which.out / f"mesh_{size:g}.mesh"
    if path.is_file():  # made again it would differ: FreeFEM writes the date into it
        return path
    n = round(1 / size)
    script = path.with_suffix(".edp")
    script.write_text(f'savemesh(square({n}, {n}), "{path}");\n')
    subprocess.run([FREEFEM, "-nw", str(script)], check=True, capture_output=True)
    return path


# A steady case that makes its mesh itself, and writes a drag of 5 (1 + 0.3 h^2) on it.
STEADY = """
include "getARGV.idp"
real size = getARGV("-size", 0.); int cells = getARGV("-cells", 0);
string out = getARGV("-out", "out");
if (cells > 0) size = 1./cells;
exec("mkdir -p '" + out + "'");
{ ofstream f(out + "/run.json"); f << "{}" << endl; }
{ ofstream f(out + "/results.csv"); f.precision(12); f << "quantity,value,unit" << endl << "drag," << 5*(1 + 0.3*size^2) << "," << endl << "cpu_time,1,s" << endl; }
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "falling.edp"
    path.write_text(SCRIPT)
    return path


def rows_of(folder):
    with open(folder / "study.csv", newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_study_finds_order_and_limit_and_resumes(case, tmp_path, capsys):
    words = [str(case), "--meshsize", "0.1", "0.05", "0.025", "--dt", "0.02", "0.01", "--quantity", "mean_v:0.3:0.4",
             "--reference", "-5.5", "--out", str(tmp_path / "out"), "--jobs", "2"]
    assert study.main(words, square_mesh) == 0
    said = capsys.readouterr().out
    assert "observed order 2.00" in said and "Pareto" in said and "extrapolated -5.5 " in said
    rows = rows_of(tmp_path / "out")
    assert len(rows) == 6 and {row["status"] for row in rows} == {"0"}
    assert float(rows[0]["value"]) == pytest.approx(-5.5 * (1 + 0.3 * 0.01 + 2 * 4e-4), rel=1e-6)
    assert int(rows[0]["steps"]) == 25 and float(rows[0]["cpu_s"]) > 0 and 5 < float(rows[0]["memory_mib"]) < 500
    assert (tmp_path / "out" / "study_mean_v_0.3_0.4.png").stat().st_size > 10_000
    # The second time nothing runs, and another quantity costs nothing.
    words[words.index("mean_v:0.3:0.4")] = "final_y"
    assert study.main(words, square_mesh) == 0
    assert capsys.readouterr().out.count("(done before)") == 6
    # Another script is another study.
    case.write_text(SCRIPT + "\n")
    study.main(words, square_mesh)
    assert "(done before)" not in capsys.readouterr().out


@pytest.mark.parametrize("words, sizes", [(["--cells", "4", "8", "12"], [1 / 4, 1 / 8, 1 / 12]),
    (["--meshsize", "0.3", "0.2", "0.1", "--by", "size"], [0.3, 0.2, 0.1])])
def test_a_study_of_a_steady_flow_takes_numbers_of_its_results(tmp_path, capsys, words, sizes):
    """On meshes that the case makes itself, by its cells or its size."""
    script = tmp_path / "steady.edp"
    script.write_text(STEADY)
    assert study.main([str(script), *words, "--quantity", "result:drag", "--out", str(tmp_path / "out"), "--jobs", "1"]) == 0
    said = capsys.readouterr().out
    assert "observed order 2.00, limit 5 " in said
    assert [float(row["meshsize"]) for row in rows_of(tmp_path / "out")] == pytest.approx(sizes)
    assert (tmp_path / "out" / "study_result_drag.png").is_file()


@pytest.mark.parametrize("by, unit", [(None, "m"), ("-cells", "1/cells"), ("-size", "that of -size")])
def test_the_figure_of_a_study_names_the_unit_of_its_sizes(tmp_path, monkeypatch, by, unit):
    one = study.Study("cases/made_up.edp", [1, 0.5, 0.25], [None], ["q"], out=tmp_path, by=by)
    figures = []
    monkeypatch.setattr(study_figure, "save", lambda figure, path: figures.append(figure))
    study_figure.draw_study(one, made_up_records((1.4, 1.2, 1.15), write_run(tmp_path / "run")), "q", 1.1, 0.1)
    sizes, times = figures[0].axes
    names = [text.get_text() for text in times.get_legend().get_texts()]
    assert sizes.get_xlabel() == f"element size ({unit})" and ("element size 0.25 m" if by is None
        else "element size 0.25") in names


def test_a_number_that_a_steady_flow_has_not_is_told_with_those_it_has(tmp_path):
    (tmp_path / "run.json").write_text("{}")
    one = quantities.parse("result:lift", quantities.load())
    for text, says in (("quantity,value,unit\ndrag,5.5,\nloss,2,Pa\n", "has no lift; it has drag, loss"),
        ("quantity,value,unit\nlift,5.5", "no end"), ("quantity,value,unit\nlift,nan,\n", "is nan"),
                       ("", "cannot read"), ("quantity,value\nlift,five\n", "five")):
        (tmp_path / "results.csv").write_text(text)
        value, why = quantities.evaluate(one, RunFolder(tmp_path))
        assert math.isnan(value) and says in why
    (tmp_path / "results.csv").write_text("quantity,value,unit\ndrag,5.5,\nlift,-2.25e-3,Pa\n")
    assert quantities.evaluate(one, RunFolder(tmp_path)) == (-2.25e-3, "")


def test_what_a_run_depends_on_holds_the_contents_of_its_inputs(case, tmp_path):
    """A file of particles that was edited makes the run another one; what is no file counts by its name."""
    file = tmp_path / "disks.csv"
    keys = []
    for text in ("id,x,y\n1,0,0\n", "id,x,y\n1,0,1\n"):
        file.write_text(text)
        keys.append(fingerprint(str(case), {"-particles": str(file), "-model": "laminar"}))
    assert keys[0] != keys[1] == fingerprint(str(case), {"-particles": str(file), "-model": "laminar"})


@pytest.mark.parametrize("line", ['optDefault("-mesh", "{}");', 'string meshFile = optFile("-mesh", "{}", "mesh");',
    'macro caseCarrier() steadyCarrier(flowFolder, "{}", flowWords) // EOM'])
def test_what_a_run_depends_on_holds_the_files_that_its_case_names(case, tmp_path, line):
    """Its mesh of default, the case that computes the flow it takes over."""
    named, keys = tmp_path / ("flow.edp" if "steady" in line else "own.mesh"), []
    case.write_text(line.format(named) + SCRIPT)
    for text in ("1", "2", "2"):
        named.write_text(text)
        keys.append(fingerprint(str(case), {"-dt": 0.1}))
    assert keys[0] != keys[1] == keys[2]


@pytest.mark.parametrize("name", ["deep.idp", "walls.txt", "own.msh"])
def test_what_a_run_depends_on_holds_what_its_includes_include(case, tmp_path, name):
    """Also where two include each other, and one stands beside its script."""
    (tmp_path / "a.idp").write_text(f'include "{tmp_path}/b.idp"\n')
    (tmp_path / "b.idp").write_text(f'include "../{tmp_path.name}/a.idp"\n"{tmp_path / name}"\n')
    case.write_text('include "a.idp"\n' + SCRIPT)
    keys = []
    for text in ("1", "2", "2"):
        (tmp_path / name).write_text(text)
        keys.append(fingerprint(str(case), {"-dt": 0.1}))
    assert keys[0] != keys[1] == keys[2]


def test_a_failed_run_is_a_row_with_its_reason(case, tmp_path, capsys):
    words = [str(case), "--meshsize", "0.1", "0.05", "--dt", "0.02", "0.01", "--quantity", "mean_v:0.3:0.4",
             "--out", str(tmp_path / "out"), "--", "-fail", "0.015"]
    assert study.main(words, square_mesh) == 1
    rows = rows_of(tmp_path / "out")
    failed = [row for row in rows if row["status"] == "4"]
    assert len(rows) == 4 and len(failed) == 2
    assert all("not converged; take a smaller -dt" in row["reason"] and row["value"] == "nan" for row in failed)
    assert "failed: h0.1 dt0.01" in capsys.readouterr().out


def test_a_mesh_or_a_quantity_that_fails_is_a_row_too(case, tmp_path):
    def no_fine_mesh(which, size):
        if size < 0.1:
            raise BadInput("no mesh of size 0.05: too fine")
        return square_mesh(which, size)
    out = tmp_path / "out"
    assert study.main([str(case), "--meshsize", "0.1", "0.05", "--quantity", "mean_v:0.3:0.9", "final_y",
                       "--out", str(out)], no_fine_mesh) == 1
    reasons = {(row["meshsize"], row["quantity"]): row["reason"] for row in rows_of(out)}
    assert "too fine" in reasons["0.05", "final_y"] and reasons["0.1", "final_y"] == ""
    assert "not over 0.3 to 0.9" in reasons["0.1", "mean_v:0.3:0.9"]


def test_a_run_is_stopped_at_its_limit_with_its_children(tmp_path):
    begin = os.times().elapsed
    done = run_command(["sh", "-c", "sleep 61 & sleep 60"], limit=0.3)
    assert not done.ok and "limit" in done.reason and os.times().elapsed - begin < 5


def test_the_cost_is_that_of_the_run_alone():
    """An empty run costs next to nothing however large the calling process is."""
    ballast = np.ones(30_000_000)
    done = run_command(["sh", "-c", ":"])
    assert done.ok and done.memory_mb < 60 and done.cpu_s < 1 and ballast[0] == 1


def test_quantities_of_ones_own(case, tmp_path):
    own = tmp_path / "mine.py"
    own.write_text('import numpy as np\ndef rows(run, factor=1):\n    """Number of rows."""\n'
                   '    return factor * len(run.particles["t"])\ndef broken(run):\n    return 1 / 0\n')
    known = quantities.load([own])
    run = RunFolder(write_run(tmp_path / "run"))
    assert quantities.evaluate(quantities.parse("rows:2", known), run) == (2 * len(run.particles["t"]), "")
    value, why = quantities.evaluate(quantities.parse("broken", known), run)
    assert math.isnan(value) and "division" in why
    own.rename(tmp_path / "mine.txt")
    with pytest.raises(BadInput, match="must be Python"):
        quantities.load([tmp_path / "mine.txt"])
    for text in ("nothing", "rows:x", "rows:1:2", "result", "result:drag:2"):
        with pytest.raises(BadInput):
            quantities.parse(text, known)


def made_up_records(values, folder):
    return [{"asked": h, "meshsize": h, "dt": None, "cpu_s": 1 / h, "status": 0, "reason": "", "run": str(folder),
        "values": {"q": (value, "")}}
            for h, value in zip((1, 0.5, 0.25), values)]


@pytest.mark.parametrize("values, words, drawn", [((1.0, 1.15, 1.1), "the finest run", 2),
    ((1.4, 1.2, 1.15), "the extrapolated value", 3)])
def test_without_extrapolation_errors_are_differences_to_the_finest_run(tmp_path, monkeypatch, values, words, drawn):
    """Its own is not 0 but unknown: it stands neither in the lines, nor in the table, nor in the figure."""
    one = study.Study("cases/made_up.edp", [1, 0.5, 0.25], [None], ["q"], out=tmp_path)
    records = made_up_records(values, write_run(tmp_path / "run"))
    references = study.references_of(one, records)
    said = "\n".join(study_report.report(one, records, references))
    assert ("extrapolated 1." in said) == (drawn == 3) == ("to the finest run" not in said) and said.count("Pareto") == drawn
    assert ("h0.25" in said) == (drawn == 3)
    for record in records:
        record.update(wall_s=1, steps=1, memory_mib=1, timing=False, commit="")
    study.write_study(one, records, references)
    assert [row["error"] == "nan" for row in rows_of(tmp_path)] == [False, False, drawn == 2]
    figures = []
    monkeypatch.setattr(study_figure, "save", lambda figure, path: figures.append(figure))
    study_figure.draw_study(one, records, "q", references["q"], 0.6)
    assert words in figures[0].get_suptitle() and len(figures[0].axes[0].lines[0].get_xdata()) == drawn
    assert ("uncertainty of the finest run" in [text.get_text()
        for text in figures[0].axes[0].get_legend().get_texts()]) == (drawn == 2)


def test_steps_that_cfl_made_smaller_have_no_order(tmp_path):
    assert study.made_smaller(13, 0.5, 0.04) == 0 == study.made_smaller(9, 0.5, None) and study.made_smaller(51, 0.5,
        0.04) == pytest.approx(0.5 / 51)
    one = study.Study("cases/made_up.edp", [None], [0.04, 0.02, 0.01], ["q"], out=tmp_path)
    records = [{"asked": None, "meshsize": None, "dt": dt, "mean_dt": mean, "vertices": 100, "cpu_s": 1, "status": 0, "reason": "",
        "run": "", "values": {"q": (1 + dt**2, "")}}
               for dt, mean in ((0.04, 0.011), (0.02, 0.0), (0.01, 0.0))]
    said = "\n".join(study_report.report(one, records, study.references_of(one, records)))
    assert "0.011 s in the mean instead of 0.04" in said and "two sizes" in said and "observed order 2" not in said
    for record in records:
        record["mean_dt"] = 0.0
    assert "observed order 2.00" in "\n".join(study_report.report(one, records, study.references_of(one, records)))


@pytest.mark.parametrize("counts, told", [((100, 390, 1500), 0), ((100, 390, 700), 1)])
def test_meshes_that_do_not_grow_as_their_sizes_say_are_told(counts, told):
    records = [{"meshsize": size, "dt": None, "vertices": number} for size, number in zip((0.4, 0.2, 0.1), counts)]
    lines = study_report.doubts(records)
    assert len(lines) == told and all("390 and 700 vertices" in line for line in lines)


def test_sizes_of_uniform_meshes_are_those_of_their_cells(case, tmp_path, capsys):
    """11, 17 and 22 cells along the side of the box: 1/0.06 is none."""
    words = [str(case), "--quantity", "mean_v:0.3:0.4", "--dt", "0.1", "--recipe", "box --width 1 --height 1", "--out",
        str(tmp_path / "out")]
    assert study.main([*words, "--meshsize", "0.09", "0.06", "0.045"]) == 0
    said = capsys.readouterr().out
    assert "0.0588235 for 0.06" in said and "observed order 2.00, limit -5.61 " in said
    assert [float(row["meshsize"]) for row in rows_of(tmp_path / "out")] == pytest.approx([1 / 11, 1 / 17, 1 / 22])
    with pytest.raises(BadInput, match="0.26 and 0.25 both make cells of 0.25"):
        study.main([*words, "--meshsize", "0.26", "0.25"])


def test_a_mesh_that_is_not_uniform_keeps_the_size_asked_for(tmp_path):
    assert study.uniform_size(read_mesh(ROOT / "meshes" / "poiseuille.mesh")) == pytest.approx(1 / 8)
    graded = ROOT / "meshes" / "cavity.mesh"
    assert study.uniform_size(read_mesh(graded)) is None
    assert study.true_sizes({0.1: graded, 0.3: ROOT / "meshes" / "poiseuille.mesh", 0.2: BadInput("none"),
        0.4: graded.with_name("box.mesh")}) == {size: size for size in (0.1, 0.3, 0.2, 0.4)}
    with pytest.raises(BadInput, match="0.1 and 0.2 make the same mesh"):
        study.true_sizes({0.1: graded, 0.2: graded})


def test_steps_that_differ_in_the_seventh_digit_have_runs_of_their_own():
    assert study.name_of(0.0625, 0.0025) == "h0.0625_dt0.0025" != study.name_of(0.0625, 0.002500001)


@pytest.mark.parametrize("words", [
    ["cases/nothing.edp", "--quantity", "mean_v"], ["CASE"], ["CASE", "--quantity", "nothing"],
    ["CASE", "--quantity", "mean_v", "--meshsize", "-1"], *(["CASE", "--quantity", "mean_v", option, value]
        for option in ("--meshsize", "--dt") for value in ("0", "nan", "1e300", "1e-300")),
    ["CASE", "--quantity", "mean_v", "--cells", "4", "--meshsize", "1"], ["CASE", "--quantity", "mean_v", "--by", "size"],
        ["CASE", "--quantity", "mean_v", "--cells", "0"], ["CASE", "--quantity", "mean_v", "--order", "1e3"],
    ["CASE", "--quantity", "result"], ["CASE", "--quantity", "mean_v", "--cells", "4", "8", "--", "-cells", "6"],
        ["CASE", "--quantity", "mean_v", "--dt", "fast"],
    ["CASE", "--quantity", "mean_v", "--reference", "1", "2"], ["CASE", "--quantity", "mean_v", "--dt", "0.1", "0.1"],
        ["CASE", "--quantity", "mean_v", "--dt", "0.1", "0.1000000000000001"],
    ["CASE", "--quantity", "mean_v", "--", "-dt", "0.1"], ["CASE", "--quantity", "mean_v", "--", "mu"],
    ["CASE", "--quantity", "mean_v", "--quantities", "nothing.py"],
    ["CASE", "--quantity", "mean_v", "--meshsize", "0.1", "--recipe", "box --width '1"]])
def test_bad_input_is_one_line_and_status_3(case, tmp_path, words):
    words = [str(case) if word == "CASE" else word for word in words]
    words[1:1] = ["--out", str(tmp_path / "out")] if len(words) > 1 else []
    done = run_tool("study", *words)
    assert done.returncode == 3, done.stderr
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1


@pytest.mark.parametrize("more, name", [([], "falling"), (["--recipe", "boks"], "boks")])
def test_a_case_without_a_recipe_is_told_so_before_anything_runs(case, tmp_path, more, name):
    with pytest.raises(BadInput, match=f"no recipe {name}, .* --recipe .*settling_disk"):
        study.main([str(case), "--meshsize", "0.1", "--quantity", "final_y", "--out", str(tmp_path / "out"), *more])
    assert not (tmp_path / "out").exists()


def test_a_recipe_may_have_options_and_a_study_of_steps_a_mesh_of_its_own(case, tmp_path):
    words = [str(case), "--quantity", "mean_v", "--out", str(tmp_path / "out"), "--dt", "0.1", "0.05"]
    assert study.main([*words, "--meshsize", "0.5", "--recipe", "box --sides named --width 1 --height 1"]) == 0
    made, = (tmp_path / "out" / "meshes").glob("*.mesh")
    assert re.fullmatch("box_sides_named_width_1_height_1_[0-9a-f]{8}_0.5.mesh", made.name) and set(read_mesh(made).labels) == {11,
        12, 13, 14}
    before = rows_of(tmp_path / "out")
    assert study.main([*words, "--", "-mesh", str(made)]) == 0
    assert [row["value"] for row in rows_of(tmp_path / "out")] == [row["value"] for row in before]
    with pytest.raises(BadInput, match="-mesh is set by this tool"):
        study.main([*words, "--meshsize", "0.5", "--", "-mesh", str(made)])


def test_meshes_of_recipes_that_differ_in_a_sign_have_files_of_their_own():
    names = {study.mesh_name(["own", "--from", file], 0.1) for file in ("my-1.geo", "my_1.geo", "my 1.geo")}
    assert len(names) == 3 and all(name.startswith("own_from_my_1.geo_") for name in names)
    assert study.mesh_name(["settling_disk"], 0.05) == "settling_disk_0.05.mesh"


def test_a_mesh_is_made_anew_when_what_its_script_includes_has_changed(tmp_path):
    (tmp_path / "my.geo").write_text('Include "width.geo";\nSetFactory("OpenCASCADE");\nRectangle(1) = {0, 0, 0, w, 1};\n'
                                     'Physical Curve("wall") = {1:4};\nPhysical Surface("fluid") = {1};\n')
    one = SimpleNamespace(case="none", recipe=f"own --from {tmp_path / 'my.geo'}", out=tmp_path)
    widths = []
    for width in (1, 2, 2):
        if width not in widths:
            (tmp_path / "width.geo").write_text(f"w = {width};\n")
        made = study.make_mesh(one, 0.5)
        widths.append(float(np.ptp(read_mesh(made).points[:, 0])))
    when = made.stat().st_mtime_ns
    assert widths == [1, 2, 2] and study.make_mesh(one, 0.5).stat().st_mtime_ns == when


def test_what_has_no_value_is_named_and_old_figures_go(case, tmp_path, capsys):
    words = [str(case), "--meshsize", "0.5", "0.25", "--out", str(tmp_path / "out"), "--quantity"]
    assert study.main([*words, "mean_v:0.3:0.4"], square_mesh) == 0
    assert [path.name for path in (tmp_path / "out").glob("*.png")] == ["study_mean_v_0.3_0.4.png"]
    capsys.readouterr()
    assert study.main([*words, "peak_speed", "mean_v:7:8"], square_mesh) == 1
    assert "error: no value of mean_v:7:8 in 2 of 2 runs" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "out").glob("*.png")] == ["study_peak_speed.png"]


def ended_by(number, words, folder):
    """Starts a tool whose case writes its process number to folder/pid, ends it by a signal;
    returns its status, what it said, and whether the case is still there."""
    process = subprocess.Popen([sys.executable, *words], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               # tests in the background would have it ignored
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    # the file is there before its text
    written, until = folder / "pid", time.monotonic() + 20
    while not (written.is_file() and written.read_text().endswith("\n")) and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(number)
    said = process.communicate(timeout=10)[1]
    case = int(written.read_text())
    return process.returncode, said, not eventually(lambda: has_ended(case))  # all are told at once, and take a moment each


def has_ended(number):
    """Whether a process is gone, or has ended and nobody has asked how."""
    try:
        return Path(f"/proc/{number}/cmdline").read_bytes() == b""
    except OSError:
        return True


@pytest.mark.parametrize("number, status, line", [(signal.SIGINT, 130, "stopped by the keyboard\n"), (signal.SIGTERM, 143,
    "stopped by SIGTERM\n")])
def test_a_stopped_study_ends_its_runs_and_goes_on_later(case, tmp_path, number, status, line):
    """A signal stops a study at once; the run under way leaves no record and no process."""
    case.write_text(f'exec("cd {tmp_path} && echo $PPID > new && mv new pid; sleep 47"); exit(0);\n')
    words = ["-m", "tools.study", str(case), "--dt", "0.1", "0.2", "--quantity", "final_y", "--jobs", "1", "--out",
        str(tmp_path / "out")]
    assert ended_by(number, words, tmp_path) == (status, line, False)
    assert not list((tmp_path / "out" / "runs").glob("*.json"))


def test_a_tool_that_waits_for_one_run_ends_it_when_it_is_ended(tmp_path):
    """As the study does; here no thread stands between the tool and the run."""
    tool = ("from tools.base.command import guarded; from tools.base.runner import run_command; "
            f"guarded(lambda: run_command(['sh', '-c', 'echo $$ > {tmp_path}/pid; sleep 47']).status)")
    assert ended_by(signal.SIGTERM, ["-c", tool], tmp_path) == (143, "stopped by SIGTERM\n", False)


def test_a_run_that_is_ended_while_it_starts_does_not_go_on(monkeypatch):
    from tools.base import runner
    make = runner.subprocess.Popen

    def made_as_all_is_ended(*words, **options):
        process = make(*words, **options)
        runner.end_all()
        return process
    monkeypatch.setattr(runner.subprocess, "Popen", made_as_all_is_ended)
    begin = time.perf_counter()
    with pytest.raises(runner.Stopped):
        runner.run_command(["sleep", "60"])
    assert time.perf_counter() - begin < 20 and not runner.LIVE


def test_a_folder_that_freefem_takes_no_runs_in_is_refused_before_meshes_are_made(case, tmp_path):
    with pytest.raises(BadInput, match="holds signs other than"):
        study.main([str(case), "--meshsize", "0.1", "--quantity", "final_y", "--out", str(tmp_path / "a b")],
            lambda *_: pytest.fail("made a mesh"))
