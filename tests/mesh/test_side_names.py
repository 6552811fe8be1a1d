"""Names of one's own for sides: from gmsh into the mesh, in a case, in the tables and in messages."""
import json
import re

import numpy as np
import pytest

from tests.conftest import ROOT, run_freefem, run_tool
from tests.tables import read_medit
from tools.base.check import compare
from tools.base.run_folder import RunFolder
from tools.meshing.labels import FIRST_OWN, LABELS, own_labels

SIDES = 20  # of a polygon, each with a name of its own
DOMAIN = """size = 1/6;
Point(1) = {0, 0, 0, size}; Point(2) = {2, 0, 0, size}; Point(3) = {2, -1, 0, size}; Point(4) = {2.6, -1, 0, size};
Point(5) = {2.6, 0, 0, size}; Point(6) = {4, 0, 0, size}; Point(7) = {4, 1, 0, size}; Point(8) = {0, 1, 0, size};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 1};
Curve Loop(1) = {1 : 8}; Plane Surface(1) = {1}; Physical Surface("fluid") = {1};
Physical Curve("left arm") = {8}; Physical Curve("right arm") = {6}; Physical Curve("drain") = {3};
Physical Curve("floor") = {1, 5}; Physical Curve("wall") = {2, 4}; Physical Curve("mirror") = {7};
"""
CASE = """include "lib/case.idp"
optCase("arms", "sides with names of their own");
optDefault("-mesh", "arms.mesh");
optDefault("-dt", "0.02");
optDefault("-cfl", "0");
optDefault("-tend", "0.1");
optDefault("-fluxes", "1");
optDefault("-wallforces", "1");
real rhoFluid = 1, mu = 1, gravityX = 0, gravityY = 0;
int[int] flowNoSlip = labelsOf("floor, wall"), flowMoving = labelsOf("left arm, right arm"), flowOutlet = labelsOf("drain");
int[int] flowSlip = labelsOf("mirror");
int leftArm = optLabel("left arm");
macro boundaryU() ((label == leftArm ? 2. : -1.)*y*(2 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
macro caseParticles() { bodyDisk(2.3, -0.88, 0.1, 1.05, 0, -8); bodyDisk(2.3, 0.3, 0.1, 1.05); } // EOM
include "scripts/resolved.edp"
"""


@pytest.fixture(scope="module")
def arms(tmp_path_factory):
    """A folder with the mesh of DOMAIN and the case."""
    folder = tmp_path_factory.mktemp("arms")
    (folder / "arms.geo").write_text(DOMAIN)
    done = run_tool("mesh", "own", "--from", folder / "arms.geo", "--out", folder / "arms.mesh")
    assert done.returncode == 0 and "left arm (21) 6" in done.stdout and "wall (3)" in done.stdout, done.stderr + done.stdout
    (folder / "arms.edp").write_text(CASE.replace("bodyDisk(2.3, -0.88, 0.1, 1.05, 0, -8)",
        "bodyAdd(2.3, -0.88, 0.1, 1.05, 0, -8, 0, 1)"))
    return folder


@pytest.fixture(scope="module")
def run(arms):
    run_freefem(arms / "arms.edp", "-out", arms / "run", "-checkpoint", 2)
    return RunFolder(arms / "run")


def test_names_of_sides_are_in_the_tables(run):
    """Fluxes are those that the case gives by name: 4/3 in on the left, 2/3 on the right, their sum out through the drain."""
    assert run.sides == {21: "left arm", 22: "right arm", 23: "drain", 24: "floor", 25: "mirror"}
    fluxes = run.table("fluxes", finite=True)
    last = {name: flux for name, flux in zip(fluxes["name"][-3:], fluxes["flux"][-3:])}
    assert last["left arm"] == pytest.approx(-4 / 3, rel=1e-9) and last["right arm"] == pytest.approx(-2 / 3, rel=1e-9)
    assert last["drain"] == pytest.approx(2, rel=0.02)
    assert all(run.sides[label] == name for label, name in zip(fluxes["label"], fluxes["name"]))
    assert set(run.table("wallforces")["name"]) == {"left arm", "right arm", "floor", "wall"}
    assert list(run.table("exits")["name"]) == ["drain"]
    assert json.loads((run.folder / "run.json").read_text())["sides"]["23"] == "drain"


def test_such_a_run_continues_and_compares(arms, run, tmp_path):
    """Continued from the middle, bit for bit; tools.check takes the tables."""
    for path in run.folder.iterdir():
        if not (path.name.startswith("restart_") and path.name.split(".")[0] > "restart_000000004"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
    run_freefem(arms / "arms.edp", "-restart", tmp_path, "-out", tmp_path)
    for name in ("fluxes", "wallforces", "exits", "particles"):
        assert (tmp_path / f"{name}.csv").read_bytes() == (run.folder / f"{name}.csv").read_bytes(), name
    assert compare(run.folder, tmp_path)


def test_names_do_not_change_a_flow(arms, run, tmp_path):
    """The same scene by labels alone: the mesh without names, the labels declared by the case, or written as numbers."""
    lines = (arms / "arms.mesh").read_text().splitlines(keepends=True)
    (tmp_path / "arms.mesh").write_text("".join(line for line in lines if not line.startswith("#")))
    text = (arms / "arms.edp").read_text()
    declared = "".join(f'labelDeclare({label}, "{name}");\n' for label, name in run.sides.items())
    numbers = re.sub(r'labelsOf\("(.*?)"\)', lambda found: "[" + ", ".join(str({name: label for label,
        name in (run.sides | {3: "wall"}).items()}[name]) for name in found.group(1).split(", ")) + "]", text)
    for name, case in (("declared", text.replace('real rhoFluid', declared + 'real rhoFluid')),
        ("numbers", numbers.replace('optLabel("left arm")', "21"))):
        (tmp_path / f"{name}.edp").write_text(case)
        run_freefem(tmp_path / f"{name}.edp", "-out", tmp_path / name)
        for table in ("fluxes", "wallforces", "particles", "exits"):
            mine, other = RunFolder(tmp_path / name).table(table), run.table(table)
            assert ("name" in mine) == ("name" in other and name == "declared")
            assert all(np.array_equal(mine[column], other[column]) for column in mine), (name, table)


@pytest.mark.parametrize("old, new, said", [
    ('"drain")', '"drian")', "no side is called 'drian'; is 'drain' meant?; the mesh and the case name left arm, right arm"),
    (', flowOutlet = labelsOf("drain")', ', flowOutlet(0)', "edges with label 23 (drain), for which this case has no condition"),
    ("real rhoFluid", 'labelDeclare(30, "drain");\nreal rhoFluid', "the side 'drain' has the labels"),
    ("real rhoFluid", 'labelDeclare(3, "pipe");\nreal rhoFluid', "label 3 has the names 'wall' and 'pipe'"),
    ("real rhoFluid", 'labelDeclare(31, "a,b");\nreal rhoFluid', "'a,b' cannot be the name of a side"),
    ("floor, wall", "floor,, wall", "no side is called ''")])
def test_what_is_wrong_with_a_name_is_one_line(arms, freefem_refused, old, new, said):
    script = arms / "wrong.edp"
    script.write_text((arms / "arms.edp").read_text().replace(old, new, 1))
    assert said in freefem_refused(3, script, "-out", arms / "wrong")


def test_any_number_of_sides(tmp_path, freefem_text):
    """More than the project has names for: each of twenty has its own, in the mesh and for FreeFEM."""
    corners = np.array([[np.cos(2 * np.pi * k / SIDES), np.sin(2 * np.pi * k / SIDES)] for k in range(SIDES)])
    text = "".join(f"Point({k + 1}) = {{{x}, {y}, 0, 0.3}};\n" for k, (x, y) in enumerate(corners))
    text += "".join(f"Line({k + 1}) = {{{k + 1}, {(k + 1) % SIDES + 1}}};\n" for k in range(SIDES))
    text += f"Curve Loop(1) = {{1 : {SIDES}}}; Plane Surface(1) = {{1}};\n"
    text += "".join(f'Physical Curve("side no. {k}") = {{{k + 1}}};\n' for k in range(SIDES)) + 'Physical Surface("a") = {1};\n'
    (tmp_path / "ring.geo").write_text(text)
    assert run_tool("mesh", "own", "--from", tmp_path / "ring.geo", "--out", tmp_path / "ring.mesh").returncode == 0
    mesh = read_medit(tmp_path / "ring.mesh")
    assert sorted(set(mesh.edge_labels)) == list(range(FIRST_OWN, FIRST_OWN + SIDES))
    said = freefem_text('include "lib/mesh/read_mesh.idp"\nmesh Th = meshRead("' + f'{tmp_path}/ring.mesh");\n'
        f'for (int k = 0; k < {SIDES}; ++k) cout << "at " << k << " " << int1d(Th, optLabel("side no. " + k))(x) << " " '
        f'<< int1d(Th, optLabel("side no. " + k))(1.) << endl;\n').stdout
    rows = np.array([line.split()[1:] for line in said.splitlines() if line.startswith("at ")], float)
    middles, lengths = (corners + np.roll(corners, -1, axis=0)) / 2, np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    assert rows[:, 1] == pytest.approx(middles[:, 0] * lengths, abs=1e-5) and rows[:, 2] == pytest.approx(lengths, rel=1e-5)


def test_own_names_keep_clear_of_taken_labels():
    assert own_labels(["wall", "a", "b", "a"], {22}) == {"a": 21, "b": 23}
    assert FIRST_OWN > max(LABELS.values())
    assert not re.search("own_labels|# side", (ROOT / "tools/meshing/defaults.py").read_text())
