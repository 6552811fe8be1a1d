"""tools.sweep: combinations, what is run again, tables, pictures, failures, the script of an array job."""
import csv
import json
import math
import os
import subprocess
from types import SimpleNamespace

import pytest

from tests.conftest import ROOT, run_freefem, run_tool
from tools.base import engine
from tools.base.command import BadInput
from tools.many import figure, plan, sweep as sweep_tool
from tools.plot.captions import with_power
from tools.plot.style import plt

# A stand-in for a case: y falls with a, and depends on the seed; it can fail, and be killed the first time.
SCRIPT = """
include "getARGV.idp"
real a = getARGV("-a", 1.), b = getARGV("-b", 0.);
int seed = getARGV("-seed", 0);
string out = getARGV("-out", "out");
if (a > 5) { cerr << "error: a is too large" << endl; exit(4); }
exec("mkdir -p '" + out + "'; echo run >> " + out + "/../count");
if (getARGV("-kill", 0) > 0) exec("test -e " + out + "/../dead || { touch " + out + "/../dead; kill -9 $PPID; }");
{ ofstream f(out + "/run.json");
f << "{\\"case\\": \\"falling\\", \\"status\\": \\"finished\\", \\"units\\": {\\"-a\\": \\"m/s\\", \\"-b\\": \\"\\"}}" << endl; }
{ ofstream f(out + "/particles.csv"); f.precision(12); f << "t,id,x,y,theta,radius" << endl;
for (int k = 0; k <= 4; ++k) f << 0.1*k << ",0,1," << 2 - a*0.1*k + b + 0.01*seed^2 << ",0,0.1" << endl; }
"""
Y = "particles.csv:y:last"


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "falling.edp"
    path.write_text(SCRIPT)
    return path


def rows_of(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def made(out):
    """How many runs there were in all."""
    return len((out / "runs/count").read_text().split())


def test_files_and_results_are_those_of_ones_own_folder(tmp_path, monkeypatch):
    """A mesh beside the case was looked for in the project, and so were its includes."""
    (tmp_path / "own.edp").write_text('include "lib/core/options.idp"\nstring mesh = optFile("-mesh", "", "the mesh");\n')
    (tmp_path / "own.mesh").write_text("")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FF_INCLUDEPATH", "")
    sweep, _, _ = sweep_tool.read(["own.edp", "--vary", "a=1", "--quantity", Y, "--", "-mesh", "own.mesh", "-tend", "1"])
    assert sweep.options == {"-mesh": str(tmp_path / "own.mesh"), "-tend": "1"} and sweep.out == tmp_path / "results/sweep/own"
    assert str(tmp_path) in os.environ["FF_INCLUDEPATH"].split(";")


def test_a_sweep_makes_all_combinations_with_means_and_resumes(case, tmp_path, capsys, monkeypatch):
    figures = []
    monkeypatch.setattr(figure, "save", lambda drawn, path: figures.append(drawn) or path)
    out = tmp_path / "out"
    words = [str(case), "--vary", "a=1,2", "seed=1:3", "--quantity", Y, "particles.csv:rows", "--jobs", "2", "--out", str(out)]
    assert sweep_tool.main(words) == 0 and made(out) == 6
    rows = rows_of(out / "sweep.csv")
    assert [(row["a"], row["seed"]) for row in rows] == [(a, seed) for a in "12" for seed in "123"]
    for row in rows:
        assert float(row[Y]) == pytest.approx(2 - 0.4 * float(row["a"]) + 0.01 * float(row["seed"]) ** 2)
        assert row["status"] == "finished" and row["particles.csv:rows"] == "5" and float(row["cpu_s"]) > 0 and row["reason"] == ""
        assert (out / row["run"] / "run.json").is_file()
    means = rows_of(out / "means.csv")
    assert [row["a"] for row in means] == ["1", "2"] and means[0][f"{Y} number"] == "3"
    assert float(means[1][f"{Y} mean"]) == pytest.approx(1.2 + 0.14 / 3)  # of 0.01, 0.04, 0.09
    assert float(means[1][f"{Y} standard error"]) == pytest.approx(math.sqrt((0.0326667e-1) / 2 / 3), rel=1e-4)
    axes = figures[0].axes
    assert axes[-1].get_xlabel() == "a (m/s)" and axes[0].get_ylabel() == "particles.csv y last (m)"
    # nothing runs the second time; a value more is one run a seed, and another quantity is free
    capsys.readouterr()
    assert sweep_tool.main([word.replace("a=1,2", "a=1,2,3").replace("rows", "y:first") for word in words]) == 0
    assert made(out) == 9 and capsys.readouterr().out.count("(done before)") == 6
    case.write_text(SCRIPT + "\n")  # another case is another sweep
    assert sweep_tool.main(words) == 0 and made(out) == 15


def test_failures_are_rows_with_their_reason(case, tmp_path, capsys):
    out = tmp_path / "out"
    words = [str(case), "--vary", "a=6,1", "--quantity", Y, "particles.csv:z:last", "--out", str(out), "--", "-b", "1"]
    assert sweep_tool.main(words) == 1
    bad, good = rows_of(out / "sweep.csv")
    assert (bad["status"], bad["exit_status"], bad["reason"], bad[Y]) == ("failed", "4", "a is too large (status 4)", "nan")
    assert good["status"] == "finished" and float(good[Y]) == pytest.approx(2.6) and "has no column z" in good["reason"]
    assert not (out / "means.csv").exists() and (out / "sweep.png").stat().st_size > 10_000
    said = capsys.readouterr()
    assert "a 6: " in said.out and said.err == ("error: 1 of 2 runs did not finish, and 1 lack a value; the reasons stand above "
        "and in the table\n")
    assert sweep_tool.main(words) == 1 and "failed: a is too large" in capsys.readouterr().out and made(out) == 1
    assert json.loads((out / "runs/a=6.json").read_text())["status"] == 4


def test_a_second_sweep_in_the_same_folder_is_refused_while_the_first_one_runs(case, tmp_path):
    """The runs of each failed where the other one wrote, and the table was that of whoever ended last."""
    words = [str(case), "--vary", "a=1,2", "--quantity", Y, "--out", str(tmp_path / "out")]
    with engine.claimed({tmp_path / "out/runs"}):
        with pytest.raises(BadInput, match="another sweep or study makes runs in .*out/runs; wait"):
            sweep_tool.main(words)
        assert not (tmp_path / "out/sweep.csv").exists() and not list((tmp_path / "out/runs").iterdir())
    assert sweep_tool.main(words) == 0 and made(tmp_path / "out") == 2


def test_a_killed_run_is_made_again_the_next_time(case, tmp_path):
    out = tmp_path / "out"
    words = [str(case), "--vary", "b=1", "--quantity", Y, "--out", str(out), "--", "-kill", "1"]
    assert sweep_tool.main(words) == 1
    row, = rows_of(out / "sweep.csv")
    assert (row["status"], row["exit_status"], row["reason"]) == ("killed", "-9", "ended by signal 9")
    assert sweep_tool.main(words) == 0 and rows_of(out / "sweep.csv")[0]["status"] == "finished"


def test_a_run_that_was_cut_off_goes_on_from_its_checkpoint(tmp_path):
    """Each time -maxwall lets it make a step or two; the end is that of a run in one piece."""
    out, options = tmp_path / "out", ["-tend", "0.06", "-checkpoint", "1"]
    words = ["cases/falling_particles.edp", "--vary", "number=3", "--quantity", "motion.csv:t:last", "--out", str(out), "--",
        *options, "-maxwall", "1e-9"]
    ended = []
    while "finished" not in ended and len(ended) < 6:
        sweep_tool.run_sweep(*sweep_tool.read(words)[:2], say=lambda line: None)
        ended.append(rows_of(out / "sweep.csv")[0]["status"])
    assert ended == ["stopped"] * (len(ended) - 1) + ["finished"] and len(ended) > 1
    assert json.loads((out / "runs/number=3/run.json").read_text())["command"][-2:] == ["-restart", str(out / "runs/number=3")]
    run_freefem("cases/falling_particles.edp", "-number", 3, *options, "-out", tmp_path / "whole")
    assert (out / "runs/number=3/particles.csv").read_bytes() == (tmp_path / "whole/particles.csv").read_bytes()


def test_what_is_under_way_when_the_sweep_dies_goes_on_from_its_checkpoint(case, tmp_path, monkeypatch):
    """Its folder then has a checkpoint, and beside it stands the key of what was begun; of another key it is begun again."""
    job = engine.Job(str(case), {"-a": 1.0}, tmp_path / "runs/a", go_on=True)
    job.folder.mkdir(parents=True)
    assert engine.kept(job) is None and not engine.can_go_on(job)
    (job.folder / "restart_000000003.sha").write_text("")
    assert not engine.can_go_on(job)
    job.beside("begun").write_text(job.key)
    commands = []

    def no_whole_checkpoint(command, limit):
        commands.append(command)
        return SimpleNamespace(status=3)
    monkeypatch.setattr(engine, "run_command", no_whole_checkpoint)
    record = engine.run_job(job)  # from the beginning where no checkpoint is whole
    assert commands[0][-2:] == ["-restart", str(job.folder)] and record["status"] == 0 and record["fresh"]
    assert not job.beside("begun").exists() and not engine.can_go_on(job) and not engine.run_job(job)["fresh"]


def test_an_array_job_makes_a_run_a_task(case, tmp_path, capsys):
    out, file = tmp_path / "out", tmp_path / "job.sh"
    words = [str(case), "--vary", "a=1:3", "seed=4", "--quantity", Y, "--over", "a", "--out", str(out)]
    assert sweep_tool.main([*words, "--batch", "slurm", str(file), "--", "-b", "2"]) == 0
    text = file.read_text()
    assert "#SBATCH --array=1-3\n" in text and f"{file}: 3 runs" in capsys.readouterr().out and not (out / "runs").exists()
    done = subprocess.run(["sh", str(file)], env=os.environ | {"SLURM_ARRAY_TASK_ID": "2"}, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("[2/3] a 2, seed 4: "), done.stderr
    assert made(out) == 1 and not (out / "sweep.csv").exists()
    assert sweep_tool.main([*words, "--collect", "--", "-b", "2"]) == 1 and made(out) == 1
    assert [row["status"] for row in rows_of(out / "sweep.csv")] == ["missing", "finished", "missing"]
    assert rows_of(out / "sweep.csv")[0]["reason"] == "not run yet"
    mean, = rows_of(out / "means.csv")
    assert (mean["seed"], mean["runs"], mean[f"{Y} number"], mean[f"{Y} standard error"]) == ("4", "3", "1", "nan")


@pytest.mark.parametrize("quantity, unit", [("motion.csv:kinetic_energy:max", "mg mm/s2"), ("mean_v", "m/s"),
    ("wallforces.csv:fy:label=21:t>0.5:timemean", "mg/s2"), ("fluid.csv:pressure_drop:timemean", "kg/(m s2)")])
def test_a_label_is_as_long_as_its_panel(quantity, unit):
    """With a power of ten, which an axis may get, too."""
    drawn, axes = plt.subplots(figsize=(4, 2.4), layout="constrained")
    axes.set_ylabel(with_power(figure.words_of(quantity, unit), 7))
    drawn.draw_without_rendering()
    box = axes.yaxis.label.get_window_extent()
    assert 0 < box.y0 and box.y1 < drawn.bbox.height and "($10^{7}$ " in axes.get_ylabel()
    plt.close(drawn)


@pytest.mark.parametrize("words, found", [
    (["reynolds=100,200", "seed=1:4"], {"reynolds": ["100", "200"], "seed": ["1", "2", "3", "4"]}),
    (["dt=0.1:0.3:0.1,1"], {"dt": ["0.1", "0.2", "0.3", "1"]}), (["-scheme=standard,published"], {"scheme": ["standard",
        "published"]}), (["mu = 0.1, 0.2 ,0.3"], {"mu": ["0.1", "0.2", "0.3"]}),
])
def test_values_are_lists_and_ranges(words, found):
    assert plan.read_vary(words, ROOT) == found


def test_folders_of_runs_have_plain_names_of_their_own(tmp_path):
    names = {plan.folder_name({"mesh": f"{tmp_path}/{sign}.mesh"}) for sign in ("a", "b", "a b", "a_b")}
    assert len(names) == 4 and all("/" not in name and " " not in name for name in names)
    (tmp_path / "my.mesh").write_text("")
    assert plan.read_vary(["mesh=my.mesh,other.mesh"], tmp_path) == {"mesh": [str(tmp_path / "my.mesh"), "other.mesh"]}


@pytest.mark.parametrize("words, says", [
    (["nothing.edp", "--vary", "a=1", "--quantity", Y], "no script"), (["CASE", "--vary", "a", "--quantity", Y], "must be PARAM"),
    (["CASE", "--vary", "a=1,1.0", "--quantity", Y], "one value twice"), (["CASE", "--vary", "a=1", "a=2", "--quantity", Y],
        "a twice"), (["CASE", "--vary", "a=3:1", "--quantity", Y], "no range"), (["CASE", "--vary", "a=0.1:0.3", "--quantity", Y],
        "does not reach 0.3 in steps of 1"),
    (["CASE", "--vary", "a=0:1:0.3", "--quantity", Y], "does not reach 1 in steps of 0.3"),
    (["CASE", "--vary", "a=1:1e9", "--quantity", Y], "more than"), (["CASE", "--vary", "a=1,", "--quantity", Y], "empty value"),
    (["CASE", "--vary", "a=1", "--quantity", "particles.csv:y"], "known are"), (["CASE", "--vary", "a=1", "--quantity", "no_such"],
        "no quantity no_such"), (["CASE", "--vary", "a=1", "--quantity", Y, Y], "one quantity twice"),
    (["CASE", "--vary", "a=1", "--quantity", Y, "--over", "seed"], "does not vary"), (["CASE", "--vary", "out=1", "--quantity", Y],
        "-out is set by this tool"), (["CASE", "--vary", "a=1", "--quantity", Y, "--", "-a", "2"], "-a is set by this tool"),
    (["CASE", "--vary", "a=1", "--quantity", Y, "--batch", "cron", "file"], "knows slurm"), (["CASE", "--vary", "a=1", "--quantity",
        Y, "--task", "2"], "no run 2"), (["CASE", "--quantity", Y], "--vary"),
])
def test_bad_input_is_one_line_and_nothing_runs(case, tmp_path, words, says):
    done = run_tool("sweep", *[str(case) if word == "CASE" else word for word in words], *([] if "--" in words else
        ["--out", str(tmp_path / "out")]))
    assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1 and says in done.stderr
    assert not (tmp_path / "out").exists()


def test_more_runs_than_anyone_means_are_refused():
    with pytest.raises(BadInput, match="more than 100000 runs"):
        plan.read_vary(["a=1:1000", "b=1:1000"], ROOT)
