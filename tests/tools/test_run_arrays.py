"""A run as arrays, frames and grids; the page that shows them, executed; what a folder holds, in lines."""
import json
import re
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest

from tests.conftest import ROOT, run_freefem, run_tool
from tests.synthetic import write_csv
from tools.base import run_arrays
from tools.base.command import BadInput
from tools.docs import notebook
from tools.run_folder import RunFolder

BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "docs/guide/python.md").read_text(), flags=re.S)


def needs_more(block):
    """Whether a block of the page needs pandas or pyvista."""
    return ".frame(" in block or ".grid(" in block


@pytest.fixture(scope="module")
def fallen(tmp_path_factory):
    """The run of the page, shorter."""
    folder = tmp_path_factory.mktemp("fallen") / "run"
    run_freefem("cases/settling_disk.edp", "-tend", 0.01, "-fields", 0.005, "-out", folder)
    return folder


def test_the_page_on_python_runs(fallen, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = "\n".join(block for block in BLOCKS if not needs_more(block))
    assert len(BLOCKS) > 5 and '"results/falling"' in text
    names = {}
    exec(compile(text.replace("results/falling", str(fallen)), "docs/guide/python.md", "exec"), names)
    said = capsys.readouterr().out
    assert "finished {'density': 1, 'viscosity': 0.1} {'length': 'cm', 'time': 's', 'mass': 'g'}" in said
    assert "1.25 is the density" in said and (tmp_path / "falling.png").stat().st_size > 10_000
    run, bodies = RunFolder(fallen), names["bodies"]
    assert np.array_equal(bodies.y[:, 0], run.particles["y"]) and bodies.of(0)["v"][-1] == run.particles["v"][-1] < 0
    assert names["velocity"].shape == (3, len(run.field(0)[0].points), 2) and names["times"][-1] == pytest.approx(0.01)
    assert names["fastest"] == pytest.approx(np.hypot(*run.field(2)[1]["velocity"].T).max())


def test_the_notebook_has_the_cells_of_the_page_and_runs(fallen, tmp_path, monkeypatch, capsys):
    """Its code, cell by cell in one namespace, as Jupyter runs it."""
    book = json.loads((ROOT / notebook.NOTEBOOK).read_text())
    assert (book["nbformat"], book["nbformat_minor"]) == (4, 5)
    assert len({cell["id"] for cell in book["cells"]}) == len(book["cells"])
    code = ["".join(cell["source"]) for cell in book["cells"] if cell["cell_type"] == "code"]
    assert code[1:] == [block.strip() for block in BLOCKS] and notebook.FIRST == code[0]
    monkeypatch.chdir(ROOT / "docs/guide")
    monkeypatch.setattr(sys, "path", list(sys.path))
    names = {}
    exec(compile(code[0], "the first cell", "exec"), names)
    assert Path.cwd() == ROOT and sys.path[0] == str(ROOT)
    for k, cell in enumerate(code[1:], 1):
        if not needs_more(cell):
            cell = cell.replace("results/falling", str(fallen)).replace("falling.png", str(tmp_path / "falling.png"))
            exec(compile(cell, f"cell {k}", "exec"), names)
    assert "largest speed at the end" in capsys.readouterr().out and (tmp_path / "falling.png").is_file()


def test_the_page_runs_with_pandas_and_pyvista(fallen, capsys):
    pytest.importorskip("pandas")
    pytest.importorskip("pyvista")
    run = RunFolder(fallen)
    for block in filter(needs_more, BLOCKS):
        exec(compile(block, "docs/guide/python.md", "exec"), {"run": run})
    assert "velocity" in capsys.readouterr().out
    assert run.frame("particles")["y"].tolist() == run.particles["y"].tolist()
    assert run.grid(0).n_points == len(run.field(0)[0].points)


def test_what_is_not_installed_is_told(fallen, monkeypatch):
    def none(name):
        raise ImportError(name)
    monkeypatch.setattr(run_arrays.importlib, "import_module", none)
    for read in (lambda run: run.frame("particles"), lambda run: run.grid()):
        with pytest.raises(BadInput, match="needs the package (pandas|pyvista): .* pip install"):
            read(RunFolder(fallen))


def test_bodies_that_enter_and_leave_are_nan_elsewhere(tmp_path):
    rows = [[k, 0.1 * k, one, one + k, 0, 0, 0.1] for k in range(4) for one in (2, 5, 9) if (one, k) not in ((5, 0), (2, 3))]
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,radius".split(","), rows)
    bodies = RunFolder(tmp_path).bodies
    assert bodies.t == pytest.approx([0, 0.1, 0.2, 0.3]) and list(bodies.id) == [2, 5, 9]
    assert np.isnan(bodies.x).tolist() == [[False, True, False], [False] * 3, [False] * 3, [True, False, False]]
    assert bodies.of(9)["x"].tolist() == [9, 10, 11, 12]
    for wrong, says in ((lambda: bodies.of(3), "no particle 3"), (lambda: RunFolder(tmp_path).over_time("velocity"),
        "has no fields"), (lambda: RunFolder(tmp_path).grid(), "has no fields"),
        (lambda: RunFolder(tmp_path).field(9), "has no fields")):
        with pytest.raises(BadInput, match=says):
            wrong()
    with pytest.raises(AttributeError, match="no column mass; it has x, y"):
        bodies.mass


@pytest.mark.parametrize("name", ["fields.vtu", "fields_0000000.vtu"])
def test_a_steady_flow_has_one_field(tmp_path, name):
    """That of a steady run, and that of point particles, which has no row of fluid.csv."""
    (tmp_path / "run.json").write_text('{"case": "made_up"}')
    meshio.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [("triangle", [[0, 1, 2]])], point_data={"velocity": [[1.0, 2, 0]] * 3}).write(
        tmp_path / name)
    run = RunFolder(tmp_path)
    assert run.field(0)[1]["velocity"].tolist() == [[1, 2]] * 3 and run.fields == []
    with pytest.raises(BadInput, match="have no times"):
        run.over_time("velocity")


def test_a_run_without_particles_has_no_bodies(tmp_path):
    write_csv(tmp_path / "particles.csv", "step,t,id,x,y,theta,radius".split(","), [])
    bodies = RunFolder(tmp_path).bodies
    assert bodies.t.shape == (0,) and bodies.x.shape == (0, 0)


def test_what_a_folder_holds_is_said_in_lines(fallen):
    said = run_tool("run_folder", fallen).stdout
    for line in ("case: settling_disk (a rigid disk", "status: finished", "command: cases/settling_disk.edp -tend 0.01",
        "units: length cm", "particles: 1\n", "fields: 3, t = 0 to 0.01 s", "exits.csv: 0 rows of t, id"):
        assert line in said, said
    done = run_tool("run_folder", fallen.parent)
    assert done.returncode == 3 and "is not a run folder" in done.stderr


def test_what_a_run_does_not_have_is_told(fallen):
    """A field beyond the last one was a bare IndexError, an option of another case "must be a number, not null"."""
    run = RunFolder(fallen)
    for read, words in ((lambda: run.field(3), "has 3 field files, 0 to 2; there is no 3"),
        (lambda: run.grid(-4), "there is no -4"), (lambda: run.results, "has no results.csv; steady flows write it"),
        (lambda: run.parameter("-scheme", 0), "must be a number")):
        with pytest.raises(BadInput, match=words):
            read()
    assert run.parameter("-nothing", None) is None and run.parameter("-nothing", 2) == 2 and run.parameter("-tend", None) == 0.01
