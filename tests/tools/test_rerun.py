"""tools.rerun: a run repeated from its folder alone, and what it refuses."""
import json
import os
import shutil
import subprocess
import sys

import pytest

from tests.conftest import ROOT, run_freefem, run_tool
from tests.scenes import case
from tools.base.run_folder import RunFolder
from tools.many.rerun import differences, free_name

@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """The folder of a run whose case, include file, mesh and particles are not there any more, and which was continued."""
    folder = tmp_path_factory.mktemp("done")
    (folder / "own.idp").write_text("real pull = -1.5;\n")
    (folder / "mine.edp").write_text(case("1;", gravity="pull").replace("real rhoFluid", f'include "{folder}/own.idp"\nreal rhoFluid'))
    (folder / "disks.csv").write_text("id,x,y,radius,density\n7,0.5,0.5,0.1,2\n8,0.5,0.3,0.09,3\n")
    shutil.copy(ROOT / "meshes/couette_disk.mesh", folder / "here.mesh")
    words = ["-mesh", folder / "here.mesh", "-particles", folder / "disks.csv", "-checkpoint", 1]
    run_freefem(folder / "mine.edp", *words, "-tend", 0.01, "-out", folder / "run")
    run_freefem(folder / "mine.edp", *words, "-tend", 0.03, "-restart", folder / "run", "-maxwall", 100)
    for name in ("own.idp", "mine.edp", "disks.csv", "here.mesh"):
        (folder / name).unlink()
    return folder / "run"


def test_a_repeat_has_the_same_bytes_from_any_folder(done, tmp_path):
    """From the copies in the folder of the run, in one piece where the run was continued."""
    again = subprocess.run([sys.executable, "-m", "tools.rerun", str(done), "-fields", "0.02", "-out", "again"], cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    for name in ("particles.csv", "contacts.csv", "entries.csv", "case.edp", "particles.given"):
        assert (tmp_path / "again" / name).read_bytes() == (done / name).read_bytes(), name
    said = json.loads((tmp_path / "again/run.json").read_text())
    assert said["status"] == "finished" and said["parameters"]["-fields"] == 0.02 and said["parameters"]["-restart"] == ""
    assert (tmp_path / "again/fields.pvd").is_file() and "FreeFEM is" not in again.stderr


def edit(change):
    """What changes run.json."""
    def apply(folder):
        said = json.loads((folder / "run.json").read_text())
        change(said)
        (folder / "run.json").write_text(json.dumps(said))
    return apply


@pytest.mark.parametrize("change, words, says", [
    (lambda f: (f / "case.edp").unlink(), [], "has no case.edp"),
    (lambda f: (f / "run.json").unlink(), [], "has no run.json"),
    (edit(lambda said: said.pop("command")), [], "records no command"),
    (edit(lambda said: said["command"].append("-dt")), [], "an option without a value"),
    (lambda f: (f / "mesh.mesh").unlink(), [], "has no copy of here.mesh (-mesh)"),
    (lambda f: (f / "particles.given").unlink(), [], "has no copy of disks.csv (-particles)"),
    (lambda f: 1, ["-out"], "come in pairs"),
    (lambda f: 1, ["-out", "RUN"], "the run that is to be repeated"),
])
def test_what_a_repeat_needs_is_told_in_one_line(done, tmp_path, change, words, says):
    shutil.copytree(done, tmp_path / "run")
    change(tmp_path / "run")
    before = sorted(os.listdir(tmp_path))
    told = run_tool("rerun", tmp_path / "run", *[str(tmp_path / "run") if word == "RUN" else word for word in words])
    assert told.returncode == 3 and told.stderr.startswith("error: ") and told.stderr.count("\n") == 1
    assert says in told.stderr.replace(str(done.parent) + "/", "") and sorted(os.listdir(tmp_path)) == before


def test_a_repeat_by_another_commit_is_told(done, tmp_path):
    shutil.copytree(done, tmp_path / "run")
    edit(lambda said: said.update(commit="0123456789abcdef"))(tmp_path / "run")
    told = [line for line in differences(RunFolder(tmp_path / "run")) if "that of the run 0123456789" in line]
    assert len(told) == (ROOT / ".git").exists()
    assert free_name(tmp_path / "run").name == "run_again"
    (tmp_path / "run_again").mkdir()
    assert free_name(f"{tmp_path}/run/").name == "run_again_2"


def test_shape_files_lie_beside_the_file_that_names_them_and_are_kept(tmp_path):
    """A square from a particle file in another folder, and one that the case names itself; the repeat from copies."""
    square = "part,closed,x,y,radius\n" + "".join(f"0,1,{x},{y},0.04\n" for x, y in ((-5, -5), (5, -5), (5, 5), (-5, 5)))
    (tmp_path / "sub").mkdir()
    (tmp_path / "rod.csv").write_text(square.replace("5", "0.05"))
    (tmp_path / "sub/one.csv").write_text(square.replace("5", "0.06"))
    (tmp_path / "sub/bodies.csv").write_text("id,x,y,radius,density,shape,theta\n7,0.7,0.5,0.1,2,one.csv,0.2\n8,0.3,0.7,0.1,2,,0\n")
    text = case('bodyShaped("rod.csv", 0.3, 0.3, 0.1, 2);')
    (tmp_path / "mine.edp").write_text(text.replace('"lib/case.idp"', '"lib/case.idp"\ninclude "lib/bodies/shapes.idp"'))
    run_freefem(tmp_path / "mine.edp", "-particles", tmp_path / "sub/bodies.csv", "-tend", 0.02, "-out", tmp_path / "run")
    shutil.rmtree(tmp_path / "sub")
    (tmp_path / "rod.csv").unlink()
    again = run_tool("rerun", tmp_path / "run", "-out", tmp_path / "again")
    assert again.returncode == 0, again.stderr
    for name in ("outlines.csv", "particles.csv", "particles.given", "shape_1.given"):
        assert (tmp_path / "again" / name).read_bytes() == (tmp_path / "run" / name).read_bytes(), name
    assert (tmp_path / "run/outlines.csv").read_text().count("0.06,") >= 2
