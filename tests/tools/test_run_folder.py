"""Readers of run folders, meshes and fields, and what they say of damaged ones."""
import json
import os
import re

import numpy as np
import pytest

from tests.conftest import run_tool
from tests.synthetic import write_csv, write_run
from tools.base.command import BadInput
from tools.base.mesh_files import chains, read_mesh
from tools.base.run_folder import RunFolder, own
from tools.base.summary import lines_of
from tools.base.tables import read_table
from tools.plot import resolved as plot, contacts as plot_contacts


@pytest.mark.parametrize("binary", [True, False])
def test_fields_of_freefem_are_read_in_both_forms(tmp_path, binary):
    run = RunFolder(write_run(tmp_path / "run", fields=2, n=6, binary=binary))
    assert [t for t, _ in run.fields] == [0, 0.5, 1]
    mesh, values = run.field(2)
    assert values["velocity"].shape == (len(mesh.points), 2) and values["pressure"].shape == (len(mesh.points),)
    assert np.allclose(values["pressure"], 100 * (1 - mesh.points[:, 0]), atol=1e-4)
    assert np.allclose(mesh.points, run.mesh.points, atol=1e-6)
    assert np.array_equal(np.sort(mesh.triangles), np.sort(run.mesh.triangles))


def test_the_mesh_keeps_its_labels(run):
    assert set(run.mesh.labels) == {1, 2, 3, 4, 5}
    ends = run.mesh.points[run.mesh.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    assert lengths[run.mesh.labels == 1].sum() == pytest.approx(0.2)
    corner = run.mesh.points[run.mesh.triangles]
    a, b = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    assert 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() == pytest.approx(0.2 - 0.01 * 0.06 - 0.04 * 0.05)


def test_chains_use_every_edge_once():
    ring = np.array([[0, 1], [2, 1], [2, 3], [3, 0], [5, 6], [7, 6]])
    lines = chains(ring)
    used = sorted(tuple(sorted(pair)) for line in lines for pair in zip(line[:-1].tolist(), line[1:].tolist()))
    assert used == sorted(tuple(sorted(pair)) for pair in ring.tolist())
    assert sorted(len(line) for line in lines) == [3, 5]


def test_without_a_list_of_fields_times_come_from_the_steps(tmp_path):
    folder = write_run(tmp_path / "run", fields=2, n=6)
    (folder / "fields.pvd").unlink()
    run = RunFolder(folder)
    assert [path.name for _, path in run.fields] == ["fields_0.vtu", "fields_10.vtu", "fields_20.vtu"]
    assert [t for t, _ in run.fields] == pytest.approx([0, 0.1, 0.2])


def test_the_summary_of_a_steady_flow_has_its_numbers(tmp_path):
    """They were said to be no table of whole rows."""
    (tmp_path / "run.json").write_text('{"case": "one", "status": "finished"}')
    (tmp_path / "results.csv").write_text("quantity,value,unit\ndrag_coefficient,5.5795,\npressure_difference,0.1174,Pa\n")
    assert "results.csv: drag_coefficient 5.5795, pressure_difference 0.1174 Pa" in list(lines_of(RunFolder(tmp_path)))
    assert "is a steady flow; its numbers stand in results.csv" in run_tool("plot", tmp_path).stderr


def test_a_row_cut_short_is_named(tmp_path):
    (tmp_path / "x.csv").write_text("# made up\nt,u\n0,1\n1\n")
    with pytest.raises(BadInput, match="line 4: 1 values where the header names 2"):
        read_table(tmp_path / "x.csv")


def test_a_table_of_a_run_that_was_cut_off_anywhere_is_refused(tmp_path):
    """Within the last number too, which can be read then; a table of another hand may lack the end of its last line."""
    text, path = "t,x,radius\n0,0,0.0125\n1,0,0.0125\n", tmp_path / "particles.csv"
    for cut in range(1, len(text)):
        path.write_text(text[:cut])
        if text[cut - 1] == "\n":
            assert len(RunFolder(tmp_path).table("particles")["t"]) == text[:cut].count("\n") - 1
        else:
            with pytest.raises(BadInput, match=f"particles.csv, line {text[:cut].count(chr(10)) + 1}: the line has no end"):
                RunFolder(tmp_path).table("particles")
    assert read_table(path)["radius"].tolist() == [0.0125, 0.0125]


def test_a_number_with_a_sharp_in_it_is_none(tmp_path):
    (tmp_path / "x.csv").write_text("t,u\n0,1\n1,0.01#25\n")
    with pytest.raises(BadInput, match="line 3: column u needs a number, not '0.01#25'"):
        read_table(tmp_path / "x.csv")


@pytest.mark.parametrize("break_it,words", [
    (lambda f: (f / "mesh.mesh").write_text("Vertices\n3\n0 0"), "mesh"),
    (lambda f: (f / "mesh.mesh").write_bytes(b"\xff\xfe\x00"), "mesh"),
    (lambda f: (f / "run.json").write_text("{"), "run.json"),
    (lambda f: (f / "fields.pvd").write_text("<VTKFile>"), "fields.pvd"),
    (lambda f: next(f.glob("fields_80.vtu")).write_text("<VTKFile><Unstr"), "fields_80.vtu"),
    (lambda f: (f / "particles.csv").write_text("t,id\n0,1\n"), "no column"),
])
def test_a_damaged_run_ends_with_one_line(folder, tmp_path, break_it, words):
    import shutil
    copy = tmp_path / "run"
    shutil.copytree(folder, copy)
    break_it(copy)
    done = run_tool("plot", copy, "--no-film")
    assert done.returncode == 3, done.stdout + done.stderr
    assert done.stderr.count("\n") == 1 and words in done.stderr


def damaged(path, old, new):
    """The first of these words in a file replaced; old "": the whole file."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1) if old else new)


@pytest.mark.parametrize("name, old, new, words", [
    ("particles.csv", "\n0,0,0,", "\n0,nan,0,", "particles.csv, line 2: t is nan"),
    ("fluid.csv", "\n1,0.05,", "\n1,inf,", "fluid.csv, line 3: t is inf"),
    ("shapes.csv", "", "id,major\n0,1\n", "shapes.csv has no column minor"),
    ("run.json", '"status"', '"period": "wide", "status"', '"period" must be two or three numbers'),
    ("run.json", '"status"', '"period": [1, "a"], "status"', '"period" must be two or three numbers'),
    ("run.json", '"status"', '"low": [1], "status"', '"low" must be two or three numbers'),
    ("run.json", '"status"', '"units": [1], "status"', '"units" must be an object'),
    ("run.json", '"versions"', '"parameters": 3, "versions"', '"parameters" must be an object'),
])
def test_damaged_tables_are_named(tmp_path, name, old, new, words):
    folder = write_run(tmp_path / "run", steps=20)
    write_csv(folder / "shapes.csv", ["id", "major", "minor"], [[0, 0.01, 0.005]])
    damaged(folder / name, old, new)
    with pytest.raises(BadInput, match=re.escape(words)):
        plot.main([str(folder), "--no-film"])


@pytest.mark.parametrize("name, old, new, words", [
    ("particles.csv", "\n0,0,0,", "\n0,0,0,nan,", "columns"),
    ("particles.csv", ",0.9,0,10,", ",nan,0,10,", "particles.csv, line 2: u is nan"),
    ("particles.csv", "theta,u,v", "theta,a,b", "particles.csv has no column u"),
    ("motion.csv", "\n0,0,1,", "\n0,0,nan,", "motion.csv, line 2: kinetic_energy is nan"),
    ("contacts.csv", "0.0001", "nan", "contacts.csv, line 2: impulse is nan"),
    ("contacts.csv", "\n1,0,1", "\n1,0,99", "contacts.csv names particle 99 at t = 1"),
    ("walls.csv", "0,0,1,0", "0,0,1,nan", "walls.csv, line 2: y2 is nan"),
])
def test_damaged_runs_of_contacts_are_named(tmp_path, name, old, new, words):
    folder = write_run(tmp_path / "run", steps=20)
    write_csv(folder / "motion.csv", ["step", "t", "kinetic_energy", "potential_energy", "worst_gap"], [[k, 0.05 * k, 1, 0, 0]
        for k in range(21)])
    write_csv(folder / "walls.csv", ["x1", "y1", "x2", "y2"], [[0, 0, 1, 0]])
    write_csv(folder / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), [[1, 0, 1, 0, 1, 0, 1e-4]])
    assert plot_contacts.main([str(folder), "--only", "energy"]) == 0
    damaged(folder / name, old, new)
    with pytest.raises(BadInput, match=words):
        plot_contacts.main([str(folder), "--only", "chains", "energy"])


def test_the_reference_of_mesh_files_is_read(tmp_path):
    (tmp_path / "t.mesh").write_text("MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 1\n1 0 1\n0 1 1\n"
                                     "Edges\n1\n1 2 7\nTriangles\n1\n1 2 3 0\nEnd\n")
    mesh = read_mesh(tmp_path / "t.mesh")
    assert mesh.labels.tolist() == [7] and mesh.triangles.tolist() == [[0, 1, 2]] and mesh.edges.tolist() == [[0, 1]]


def test_fields_hold_the_velocity_at_all_its_nodes(freefem, tmp_path):
    """Poiseuille's parabola on a mesh of a few elements across: linear functions on the mesh's own triangles miss it between
    vertices."""
    assert freefem("cases/poiseuille.edp", "-tend", "0.05", "-fields", "0.05", "-out", tmp_path / "run").returncode == 0
    run = RunFolder(tmp_path / "run")
    mesh, values = run.field(len(run.fields) - 1)
    assert len(mesh.triangles) == 4 * len(run.mesh.triangles)
    low, high = run.mesh.points[:, 1].min(), run.mesh.points[:, 1].max()
    inlet = abs(mesh.points[:, 0] - run.mesh.points[:, 0].min()) < 1e-9
    y, u = mesh.points[inlet, 1], values["velocity"][inlet, 0]
    assert np.allclose(u, u.max() * 4 * (y - low) * (high - y) / (high - low) ** 2, atol=1e-5 * u.max())


def test_what_a_tool_draws_into_a_run_is_listed_with_it_once(tmp_path):
    """So that -overwrite 1 replaces pictures of the run before, and none of anybody else."""
    assert own(tmp_path / "a.png") == tmp_path / "a.png" and not (tmp_path / ".files").exists()
    (tmp_path / ".files").write_text("run.json\n")
    own(tmp_path / "a.png")
    own(tmp_path / "a.png")
    assert (tmp_path / ".files").read_text() == "run.json\na.png\n"


def test_a_run_whose_process_is_gone_is_told_of(tmp_path, capsys):
    for number, words in ((os.getpid(), "is still running"), (2**22 + 1, "ended without a word")):
        (tmp_path / "run.json").write_text(json.dumps({"status": "running", "pid": number}))
        RunFolder(tmp_path).warn_unfinished()
        assert words in capsys.readouterr().err


def test_an_inlet_that_the_case_makes_a_wall_is_drawn_as_one(tmp_path):
    """Sides called inlet and outlet were open where a run had no open side at all."""
    for info, sides in (({}, (1, 2)), ({"labels": {"no slip": [1, 3], "outlet": []}}, ()), ({"labels": {"wall": [1]}}, ()),
        ({"labels": {"no slip": [3]}, "open": [1, 21]}, (1, 21))):
        (tmp_path / "run.json").write_text(json.dumps(info))
        assert RunFolder(tmp_path).open == sides
