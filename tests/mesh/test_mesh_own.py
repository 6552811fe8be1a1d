"""Domains of one's own: gmsh scripts and meshes with named sides, and what is refused of them."""
import re
import signal
import subprocess
import sys
import time
from functools import lru_cache

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.starter import Starter
from tests.tables import read_medit
from tools.base.run_folder import RunFolder
from tools.meshing import unstructured
from tools.meshing.checks import faults
from tools.meshing.plane_mesh import edges_of, signed_areas

# A channel of 3 by 1 with a round hole, and a second surface behind it.
SCRIPT = """
h = 0.2;
Point(1) = {0, 0, 0, h}; Point(2) = {3, 0, 0, h}; Point(3) = {3, 1, 0, h}; Point(4) = {0, 1, 0, h};
Point(5) = {1.5, 0.4, 0, h}; Point(6) = {1.7, 0.4, 0, h}; Point(7) = {1.3, 0.4, 0, h}; Point(10) = {1.5, 0.6, 0, h}; Point(11) = {1.5, 0.2, 0, h}; Point(8) = {4, 0, 0, h}; Point(9) = {4, 1, 0, h};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Circle(5) = {6, 5, 10}; Circle(6) = {10, 5, 7}; Circle(10) = {7, 5, 11}; Circle(11) = {11, 5, 6};
Line(7) = {2, 8}; Line(8) = {8, 9}; Line(9) = {9, 3};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {5, 6, 10, 11}; Curve Loop(3) = {7, 8, 9, -2};
Plane Surface(1) = {1, 2}; Plane Surface(2) = {3};
Physical Surface("fluid") = {1, 2};
Physical Curve(2) = {8}; Physical Curve("wall") = {1, 3, 7, 9}; Physical Curve("inlet") = {4}; Physical Curve("cylinder") = {5, 6, 10, 11};
Physical Curve("lid") = {2}; // within the domain: no side of it
"""


@lru_cache(maxsize=None)
def starter():
    return Starter(ROOT)


@pytest.fixture(scope="module", autouse=True)
def the_starter_ends():
    yield
    if starter.cache_info().currsize:
        starter().end()
        starter.cache_clear()


def command(*words):
    """python -m tools.mesh in a process of its own: gmsh keeps what a script has set."""
    return starter().run(*words)


def test_a_command_of_its_own_does_the_same(tmp_path):
    (tmp_path / "my.geo").write_text(SCRIPT)
    words = ["own", "--from", str(tmp_path / "my.geo"), "--size", "0.2", "--out"]
    done = subprocess.run([sys.executable, "-m", "tools.mesh", *words, tmp_path / "a.mesh"], cwd=ROOT, capture_output=True,
        text=True, timeout=120)
    again = command(*words, tmp_path / "b.mesh")
    assert done.returncode == again.returncode == 0 and done.stderr == again.stderr and done.stderr.startswith("warning: ")
    assert done.stdout.replace("a.mesh", "b.mesh") == again.stdout
    assert (tmp_path / "a.mesh").read_bytes() == (tmp_path / "b.mesh").read_bytes()


def made(folder, text, *words, name="my.geo"):
    (folder / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return command("own", "--from", folder / name, "--out", folder / "my.mesh", *words)


def test_a_script_becomes_a_mesh_with_the_labels_of_its_names(tmp_path, freefem_text):
    done = made(tmp_path, SCRIPT, "--size", 0.1)
    assert done.returncode == 0, done.stderr
    assert re.match(r"warning: 10 edges of physical curves of .* lie within the domain, one from \(3, ", done.stderr)  # the lid
    mesh = read_medit(tmp_path / "my.mesh")
    assert faults(mesh, None) == []
    lengths = np.linalg.norm(np.diff(mesh.points[mesh.edges], axis=1)[:, 0], axis=1)
    sums = {int(label): lengths[mesh.edge_labels == label].sum() for label in np.unique(mesh.edge_labels)}
    assert sums[3] == pytest.approx(8) and sums[1] == pytest.approx(1) and sums[2] == pytest.approx(1) and set(sums) == {1, 2, 3, 6}
    around = np.sum(mesh.edge_labels == 6)
    assert sums[6] == pytest.approx(0.4 * around * np.sin(np.pi / around)) and around >= 12
    polygon = around / 2 * np.sin(2 * np.pi / around) * 0.04
    assert signed_areas(mesh.points, mesh.triangles).sum() == pytest.approx(4 - polygon)
    assert lengths.max() < 0.15
    text = """include "lib/mesh/read_mesh.idp"
mesh Th = meshRead("FILE");
cout << "AREA " << Th.measure << " " << int1d(Th, labelCylinder)(1.) << endl;"""
    words = freefem_text(text.replace("FILE", str(tmp_path / "my.mesh"))).stdout.split("AREA")[1].split()
    assert float(words[0]) == pytest.approx(4 - polygon, rel=1e-5) and float(words[1]) == pytest.approx(sums[6], rel=1e-5)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_a_mesh_by_gmsh_gives_the_same(version, tmp_path):
    gmsh = pytest.importorskip("gmsh")
    (tmp_path / "my.geo").write_text(SCRIPT)
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.open(str(tmp_path / "my.geo"))
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "my.msh"))
    finally:
        gmsh.finalize()
    assert command("own", "--from", tmp_path / "my.msh", "--out", tmp_path / "a.mesh").returncode == 0
    mesh = read_medit(tmp_path / "a.mesh")
    assert faults(mesh, None) == [] and set(mesh.edge_labels) == {1, 2, 3, 6}
    done = command("own", "--from", tmp_path / "my.msh", "--size", 0.1, "--out", tmp_path / "b.mesh")
    assert done.returncode == 3 and "meshed already" in done.stderr
    (tmp_path / "merged.geo").write_text('Merge "my.msh";\n')
    for words, status, what in (((), 0, ""), (("--size", 0.1), 3, "of a mesh that a script merges\n")):
        done = command("own", "--from", tmp_path / "merged.geo", *words, "--out", tmp_path / "c.mesh")
        assert done.returncode == status and done.stderr.endswith(what)


@pytest.mark.parametrize("text, name, words", [
    (SCRIPT.replace('"inlet"', '"en,try"'), "my.geo", "'en,try' cannot be the name of a side"),
    (SCRIPT.replace('"inlet"', '"' + 61*"n" + '"'), "my.geo", "cannot be the name of a side"),
    (SCRIPT.replace('Physical Curve("inlet")', 'Physical Curve("")'), "my.geo", "a side whose name is empty"),  # became an outlet
    (SCRIPT.replace('Physical Curve("inlet") = {4};', ""), "my.geo", "belong to no physical curve"),
    (SCRIPT.replace("Plane Surface(1)", "Plain Surface(1)"), "my.geo", "gmsh"),
    (SCRIPT.replace("Point(3) = {3, 1, 0, h}", "Point(3) = {3, 1, 1, h}"), "my.geo", "gmsh|not plane"),
    ("", "my.geo", "no triangles"),
    ("nonsense", "my.msh", "gmsh|no triangles"),
    ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n1 3 \"wall\"\n$EndPhysicalNames\n$Nodes\n2\n1 0 0 0\n2 1 0 "
        "0\n$EndNodes\n$Elements\n1\n1 1 2 3 1 1 2\n$EndElements\n",
     "my.msh", "add a Physical Surface"),
    (SCRIPT, "my.step", "takes a gmsh script"),
    (SCRIPT.rstrip("\n"), "my.geo", "ends without a newline"),
    (SCRIPT.replace('"inlet"', '"entr\xe9e"').encode("latin-1"), "my.geo", "no UTF-8 text"),
    (SCRIPT.encode("utf-16"), "my.geo", "no plain text"),
    (SCRIPT + "Mesh.ScalingFactor = 0;\n", "my.geo", "must be above 0"),
    (SCRIPT + "Transfinite Surface {2}; Recombine Surface {2};\n", "my.geo", "only triangles of three nodes are taken: leave out "
        "Recombine"),
    (SCRIPT + "Recombine Surface {1, 2};\n", "my.geo", "quadrilaterals of 4 nodes"),
    (SCRIPT + "Mesh.ElementOrder = 2;\n", "my.geo", "triangles of 6 nodes; only triangles of three nodes are taken: leave out "
        "Mesh.ElementOrder"),
])
def test_what_is_no_domain_is_refused_in_one_line(text, name, words, tmp_path):
    done = made(tmp_path, text, name=name)
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 3 and len(lines) == 1 and lines[0].startswith("error: "), (done.returncode, done.stderr, done.stdout)
    assert any(word in lines[0] for word in words.split("|")) and not (tmp_path / "my.mesh").exists()


def test_a_case_runs_on_such_a_mesh(tmp_path, freefem):
    text = re.sub(r"Physical Curve.*;", "", SCRIPT) + 'Physical Curve("wall") = {1, 3, 7, 9, 4, 8, 5, 6, 10, 11};\n'
    assert made(tmp_path, text, "--size", 0.1).returncode == 0
    script = tmp_path / "case.edp"
    case = (ROOT / "cases" / "template.edp").read_text()
    script.write_text(re.sub(r"bodyDisk\(0.*?\*/", "bodyDisk(2.5, 0.5, 0.3, 2.);", case, flags=re.DOTALL))
    freefem(script, "-mesh", tmp_path / "my.mesh", "-tend", 0.02, "-out", tmp_path / "run")
    v = RunFolder(tmp_path / "run").particles["v"]
    assert len(v) >= 2 and v[-1] < 0


def edge_lengths(mesh):
    edges, _ = edges_of(mesh.triangles)
    return np.linalg.norm(np.diff(mesh.points[edges], axis=1)[:, 0], axis=1)


@pytest.mark.parametrize("line, size, largest", [("Mesh.MeshSizeMax = 0.06;", 0.2, 0.09), ("Mesh.MeshSizeFactor = 2;", 0.1, 0.15),
    ("Mesh.MeshSizeMin = 0.2;", 0.1, 0.15)])
def test_a_size_bounds_the_elements_and_makes_none_coarser(line, size, largest, tmp_path):
    assert made(tmp_path, SCRIPT + line + "\n", "--size", size).returncode == 0
    assert edge_lengths(read_medit(tmp_path / "my.mesh")).max() < largest


@pytest.mark.parametrize("words", [(), ("--proportional",)])
@pytest.mark.parametrize("commands", ["Mesh 1;", "Mesh 2;", "Mesh 2; RefineMesh;"])
def test_a_script_that_meshes_itself_is_meshed_anew_with_a_size(commands, words, tmp_path):
    counts = []
    for text in (SCRIPT, SCRIPT + commands + "\n"):
        assert made(tmp_path, text, "--size", 0.06, *words).returncode == 0
        counts.append(len(read_medit(tmp_path / "my.mesh").points))
    assert counts[0] == counts[1]


def test_a_script_is_scaled_by_its_own_factor(tmp_path):
    assert made(tmp_path, SCRIPT + "Mesh.ScalingFactor = 1000;\n", "--size", 100).returncode == 0
    mesh = read_medit(tmp_path / "my.mesh")
    assert np.allclose(np.ptp(mesh.points, axis=0)[:2], [4000, 1000]) and 100 < edge_lengths(mesh).max() < 150


@pytest.mark.parametrize("line, area", [("", 4 - 0.04 * np.pi), ("Mesh.SaveAll = 1;", 4)])
def test_the_domain_is_the_physical_surfaces_of_a_script(line, area, tmp_path):
    """A meshed solid within the fluid is none of it, as in the file that gmsh writes; nor is what lies beside it."""
    solid = "Plane Surface(3) = {2}; Point(20) = {3.9, 0.5, 0, h}; Line(20) = {8, 20}; Line(21) = {20, 9};"
    text = SCRIPT.replace("Plane Surface(2)", solid + "Curve Loop(4) = {20, 21, -8}; Plane Surface(4) = {4}; Plane Surface(2)")
    text = text.replace('("inlet") = {4}', '("inlet") = {4, 20, 21}').replace("{7, 8, 9, -2}", "{7, 20, 21, 9, -2}"
        if line else "{7, 8, 9, -2}")
    done = made(tmp_path, text + line + "\n", "--size", 0.1)
    assert done.returncode == 0, done.stderr
    mesh = read_medit(tmp_path / "my.mesh")
    assert signed_areas(mesh.points, mesh.triangles).sum() == pytest.approx(area, rel=5e-3)
    assert (6 in mesh.edge_labels) == (not line) == ("lie outside the domain" in done.stderr)


PIECES = """
Point(1) = {0, 0, 0, 0.3}; Point(2) = {1, 0, 0, 0.3}; Point(3) = {1, 1, 0, 0.3}; Point(4) = {0, 1, 0, 0.3};
Point(5) = {2, 0, 0, 0.3}; Point(6) = {3, 0, 0, 0.3}; Point(7) = {3, 1, 0, 0.3}; Point(8) = {2, 1, 0, 0.3};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(1) = {1, 2, 3, 4}; Curve Loop(2) = {5, 6, 7, 8};
Plane Surface(1) = {1}; Plane Surface(2) = {2};
Physical Curve("wall") = {1, 2, 3, 4, 5, 6, 7, 8};
"""


@pytest.mark.parametrize("text, words, status, what", [
    (PIECES, [], 4, "2 pieces"), (SCRIPT + "Exit;\n", [], 3, "the command Exit"), (SCRIPT, ["--size", 1e-5], 3, "makes more than"),
    (SCRIPT + 'Physical Curve("outlet", 99) = {1};\n', [], 3, "in two physical curves")])
def test_domains_that_are_none_are_refused(text, words, status, what, tmp_path):
    done = made(tmp_path, text, *words)
    assert done.returncode == status and what in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "my.mesh").exists()


def test_all_sizes_of_a_script_shrink_alike(tmp_path):
    """--size alone leaves the fine places as they are."""
    text = re.sub(r"(Point\((?:5|6|7|10|11)\) = [^h]*)h", r"\1h/10", SCRIPT)
    grown = {}
    for words in ((), ("--proportional",)):
        counts = []
        for size in (0.12, 0.06, 0.03):
            assert made(tmp_path, text, "--size", size, *words).returncode == 0
            counts.append(len(read_medit(tmp_path / "my.mesh").points))
        grown[bool(words)] = [b / a for a, b in zip(counts, counts[1:])]
    assert grown[True] == pytest.approx([4, 4], rel=0.15) and grown[False][0] < 3
    mesh = read_medit(tmp_path / "my.mesh")  # the last one: elements of 0.03
    areas = signed_areas(mesh.points, mesh.triangles)
    assert np.quantile((4 / 3**0.5 * areas) ** 0.5, 0.95) == pytest.approx(0.03, rel=0.1)
    assert made(tmp_path, text, "--proportional").returncode == 3


def test_the_mesh_of_a_run_is_not_written_over(tmp_path):
    (tmp_path / "my.geo").write_text(SCRIPT)
    (tmp_path / "run.json").write_text("{}")
    (tmp_path / "mesh.mesh").write_text("MeshVersionFormatted 2")
    done = command("own", "--from", tmp_path / "my.geo", "--out", tmp_path / "mesh.mesh")
    assert done.returncode == 3 and "is the mesh of a run" in done.stderr and done.stderr.count("\n") == 1
    assert (tmp_path / "mesh.mesh").read_text() == "MeshVersionFormatted 2"


def test_a_gmsh_that_does_not_end_is_told(monkeypatch, capsys):
    monkeypatch.setattr(unstructured, "PATIENCE", 0.05)
    assert unstructured.with_gmsh(lambda gmsh: time.sleep(0.3) or 7, "no") == 7
    assert "note: gmsh has been at work for 0.05 s" in capsys.readouterr().err
    monkeypatch.setattr(unstructured, "PATIENCE", 60.0)
    assert unstructured.with_gmsh(lambda gmsh: 8, "no") == 8 and capsys.readouterr().err == ""


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_gmsh_at_work_is_stopped_at_once(tmp_path, number, status):
    """Before: it ended when gmsh did, here after minutes, and a session of gmsh made SIGTERM end without a line."""
    work = f"""
import pathlib
from tools.base.command import guarded
from tools.meshing.unstructured import with_gmsh
def work(gmsh):
    gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 3e-4)
    pathlib.Path({str(tmp_path / "begun")!r}).touch()
    gmsh.model.mesh.generate(2)
guarded(lambda: with_gmsh(work, "no mesh"))
"""
    tool = subprocess.Popen([sys.executable, "-c", work], cwd=ROOT, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    end = time.monotonic() + 60
    while not (tmp_path / "begun").is_file() and time.monotonic() < end:
        time.sleep(0.05)
    time.sleep(0.5)
    tool.send_signal(number)
    said = tool.communicate(timeout=20)[1]
    assert tool.returncode == status and said.startswith("stopped by ") and said.count("\n") == 1
