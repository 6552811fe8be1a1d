"""tools.new: a case in a folder of one's own runs there with its test; a case of the project is registered; what is refused."""
import re
import runpy
import shutil
import subprocess
import sys

import pytest

from tests.cases import CASES
from tests.conftest import ROOT, run_tool
from tools import new
from tools.compile_errors.run import surroundings


def test_a_case_in_ones_own_folder_runs_there_and_its_test_judges(tmp_path, monkeypatch):
    """From a mesh beside it, into results/ beside it; a disk that lies elsewhere fails its test."""
    done = run_tool("new", "my_case", "--like", "settling_disk", "--folder", tmp_path)
    assert done.returncode == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"my_case.edp", "test_my_case.py", "my_case.md"}
    page = (tmp_path / "my_case.md").read_text()
    assert page.startswith("# My case\n") and "python -m tools.run my_case.edp -rhos 1.5" in page
    assert "python -m tools.plot RUN" in page
    again = run_tool("new", "my_case", "--like", "template", "--folder", tmp_path)
    assert again.returncode == 3 and again.stderr.count("\n") == 1 and "my_case.edp is there already" in again.stderr
    text = (tmp_path / "my_case.edp").read_text()
    shutil.copy(ROOT / "meshes/settling_disk.mesh", tmp_path / "own.mesh")
    (tmp_path / "my_case.edp").write_text(text.replace("meshes/settling_disk.mesh", "own.mesh"))
    words = [sys.executable, ROOT / "tools/run.py", "my_case.edp", "-tend", "0.00125"]
    run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0 and f'"mesh": "{tmp_path}/own.mesh"' in (tmp_path / "results/my_case/run_001/run.json").read_text()
    monkeypatch.chdir(ROOT)
    assert surroundings(tmp_path / "my_case.edp")["PARTICLES_RESULTS"] == str(tmp_path / "results")
    assert "PARTICLES_RESULTS" not in surroundings(ROOT / "cases/template.edp")
    test = runpy.run_path(tmp_path / "test_my_case.py")["test_a_few_steps_of_my_case"]
    (tmp_path / "good").mkdir()
    test(tmp_path / "good")
    (tmp_path / "my_case.edp").write_text(text.replace("bodyDisk(startX", "bodyHeld(startX - 3"))
    with pytest.raises(AssertionError):
        test(tmp_path)


def test_a_case_of_the_project_is_registered(tmp_path, monkeypatch):
    """In a copy of what the lists need."""
    for name in ("cases", "docs/gallery", "tests"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("pictures", "*.csv.gz", "reference", "data",
            "__pycache__"))
    from tools.docs import gallery, headers, options

    for module in (new, gallery, headers, options):
        monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(options, "ask", lambda path: [options.Option("-diameter", "0.25", "cm", "diameter of the disk")])
    done = run_tool("new", "my_case", "--like", "settling_disk")
    assert done.returncode == 0, done.stderr
    listed = {}
    exec((tmp_path / "tests/cases.py").read_text(), listed)
    assert listed["CASES"] == CASES | {"my_case": CASES["settling_disk"]}
    assert gallery.entries()["my_case"]["group"] == "particles"
    assert "`cases/my_case.edp`" in (tmp_path / "docs/gallery/my_case.md").read_text()
    assert "[`my_case`](my_case.md)" in (tmp_path / "docs/gallery/index.md").read_text()
    test = (tmp_path / "tests/bodies/test_my_case.py").read_text()
    assert '"cases/my_case.edp", "-tend", "0.01"' in test and "def test_" in test
    compile(test, "test", "exec")
    again = run_tool("new", "my_case", "--like", "settling_disk")
    assert again.returncode == 3 and "already" in again.stderr and again.stderr.count("\n") == 1


@pytest.mark.parametrize("like", sorted(CASES))
def test_every_case_can_be_begun_from(like):
    text = (ROOT / f"cases/{like}.edp").read_text()
    for inside in (True, False):
        case = new.adapted(text, "my_case", like, inside)
        assert 'optCase("my_case"' in case and f"began as a copy of cases/{like}.edp" in case
        assert not re.search(rf"FreeFem\+\+ -nw cases/{like}.edp|results/{like}/", case)
        judged, imports = new.judged("my_case", like)
        compile(f"{imports}def test():\n{judged}", "test", "exec")
        assert re.sub("(?m)^//.*\n", "", case).replace("my_case", like) == re.sub("(?m)^//.*\n", "", text)


@pytest.mark.parametrize("like, picture", [("settling_disk", "fields"), ("two_spheres", "fields"), ("given_flow", "transport"),
    ("diaphragm_loss", "streamlines"), ("heap", "frames"), ("falling_spheres", "frames")])
def test_a_page_names_the_picture_that_its_tool_draws(like, picture):
    assert f"results/my_case/run_001/{picture}.png" in new.page("my_case", like, "// My case: nothing.\n")


@pytest.mark.parametrize("words, said", [
    (["1st", "--like", "template"], "'1st' cannot be the name"), (["my case", "--like", "template"], "cannot be the name"),
    (["class", "--like", "template"], "cannot be the name"), (["../x", "--like", "template"], "cannot be the name"),
    (["cavity", "--like", "template"], "there is a case cavity"), (["mine", "--like", "settling_dsk"], "is settling_disk meant?"),
    (["mesh", "--like", "template"], "test_mesh.py is there already"), (["mine"], "--like"),
    (["mine", "--like", "template", "--folder", "cases"], "lies in the project"),
    (["mine", "--like", "template", "--folder", "/tmp/a b"], "holds signs"),
    (["mine", "--like", "template", "--folder", "/dev/null"], "is a file")])
def test_what_is_refused(words, said):
    done = run_tool("new", *words)
    assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1 and said in done.stderr
    assert done.stdout == ""
