"""Meshes in several pieces are refused by every driver; edges with triangles on both sides are no sides."""
import subprocess
import sys

import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base.mesh_files import read_mesh
from tools.meshing.checks import pieces_of
from tools.base.run_folder import RunFolder

N = 8


def square(x0, y0, n=N):
    """Points (n + 1)^2 and triangles of a unit square with its lower left corner at (x0, y0)."""
    i, j = np.meshgrid(range(n + 1), range(n + 1))
    points = np.column_stack([x0 + i.ravel() / n, y0 + j.ravel() / n])
    a = np.array([row * (n + 1) + k for row in range(n) for k in range(n)])
    return points, np.concatenate([np.column_stack([a, a + 1, a + n + 2]), np.column_stack([a, a + n + 2, a + n + 1])])


def write(file, pieces, inner=(), inner_label=99):
    """A .mesh file of squares, each with its lower left corner there; points in one place are one. Sides: left 1, right 2, others
    3. inner: pairs of points."""
    points, triangles = np.empty((0, 2)), np.empty((0, 3), int)
    for corner in pieces:
        more, faces = square(*corner)
        triangles = np.concatenate([triangles, faces + len(points)])
        points = np.concatenate([points, more])
    points, place = np.unique(points.round(9), axis=0, return_inverse=True)
    triangles = place.ravel()[triangles]
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    _, first, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    edges = sides[first[count == 1]]
    low, high = points[:, 0].min(), points[:, 0].max()
    rows = [(a, b, 1 if (points[[a, b], 0] == low).all() else 2 if (points[[a, b], 0] == high).all() else 3) for a, b in edges]
    for pair in inner:
        a, b = (int(np.argmin(np.hypot(*(points - end).T))) for end in pair)
        rows.append((a, b, inner_label))
    text = ["MeshVersionFormatted 2", "Dimension 2", f"Vertices {len(points)}", *(f"{x:.12g} {y:.12g} 0" for x, y in points)]
    text += [f"Edges {len(rows)}", *(f"{a + 1} {b + 1} {label}" for a, b, label in rows)]
    text += [f"Triangles {len(triangles)}", *(" ".join(str(k + 1) for k in face) + " 0" for face in triangles), "End"]
    file.write_text("\n".join(text).replace("Vertices ", "Vertices\n").replace("Edges ", "Edges\n").replace("Triangles ",
        "Triangles\n") + "\n")
    return file


# its second edge is a diagonal of the grid
LOOP = [((0.25, 0.25), (0.375, 0.25)), ((0.375, 0.25), (0.5, 0.375)), ((0.5, 0.375), (0.5, 0.5))]
HEAD = 'include "lib/case.idp"\noptCase("channel", "a scene of tests/mesh/test_pieces_and_inner_edges.py");\n'
SIDES = """real rhoFluid = 1, mu = 0.05, gravityX = 0, gravityY = 0, flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
int[int] flowNoSlip = [WALLS], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
"""
STEADY = """real rhoFluid = 1, mu = 0.05, speed = 1, size = 1;
int[int] labelsMoving = [labelInlet], labelsStill = [WALLS], labelsFree = [labelOutlet];
macro inletU() (4*y*(1 - y)) // EOM
macro caseResult() resultPut("middle", newtonU(0.5, 0.5), "m/s"); // EOM
"""
SPHERES = """real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = -9.81;
macro caseWallLabels() [WALLS] // EOM
macro caseCarrier() { carrierWh u = 4*y*(1 - y), v = 0*x; carrierFlow(u[], v[]); } // EOM
macro caseParticles() { real[int] one(1), r(1), d(1), o(1); one = 0.5; r = 0.01; d = 2500; o = 0.; transportAppend(one, one, r, d, o, o, o); } // EOM
"""
TIMES = ["-dt", 0.01, "-tend", 0.02, "-every", 0]
DRIVERS = {"flow": (SIDES.replace("gravityX = 0, gravityY = 0, ", ""), TIMES),
    "resolved": (SIDES + "macro caseParticles() bodyDisk(0.5, 0.5, 0.25, 2); // EOM\n", TIMES), "steady_laminar": (STEADY, []),
        "transport": (SPHERES, [*TIMES, "-drag", "schiller-naumann"])}


def text(driver, walls="labelWall"):
    return HEAD + DRIVERS[driver][0].replace("WALLS", walls) + f'include "scripts/{driver}.edp"\n'


def run(freefem_text, driver, mesh, out, walls="labelWall", **more):
    return freefem_text(text(driver, walls), *DRIVERS[driver][1], "-mesh", mesh, "-out", out, **more)


def refused(done):
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 3 and len(lines) == 1 and lines[0].startswith("error: "), (done.returncode, done.stderr)
    return lines[0]


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_mesh_in_two_pieces_is_refused(driver, freefem_text, tmp_path):
    """It ended with status 4, "the pressure solver is wrong", or ran."""
    line = refused(run(freefem_text, driver, write(tmp_path / "two.mesh", [(0, 0), (0, 1.5)]), tmp_path / "run", check=False))
    assert "in pieces that share no side" in line and not (tmp_path / "run").exists()


def test_pieces_that_touch_in_a_vertex_are_refused_too(freefem_text, freefem_refused, tmp_path):
    mesh = write(tmp_path / "touch.mesh", [(0, 0), (1, 1)])
    assert "a common vertex does not join them" in refused(run(freefem_text, "flow", mesh, tmp_path / "run", check=False))
    assert "share no side" in freefem_refused(3, "cases/pipe_flow.edp", "-mesh", mesh, "-model", "laminar", "-out",
        tmp_path / "steady")


def test_squares_round_a_hole_that_touch_in_a_vertex_are_one_piece(freefem_text, tmp_path):
    """Two holes that touch in a vertex: fluid passes round them."""
    ring = [(i, j) for i in range(4) for j in range(4) if (i, j) not in ((1, 1), (2, 2))]
    mesh = write(tmp_path / "holes.mesh", ring)
    assert pieces_of(read_mesh(mesh).triangles) == 1
    freefem_text(text("flow").replace("4*y*(1 - y)", "y*(4 - y)"), *TIMES, "-mesh", mesh, "-out", tmp_path / "run")


def test_pieces_are_counted_by_sides(tmp_path):
    for corners, number in (([(0, 0)], 1), ([(0, 0), (1, 0)], 1), ([(0, 0), (1, 1)], 2), ([(0, 0), (0, 3), (5, 5)], 3)):
        assert pieces_of(read_mesh(write(tmp_path / "some.mesh", corners)).triangles) == number


def test_a_script_of_two_surfaces_that_touch_in_a_point_is_refused(tmp_path):
    square = "Point({0}1) = {{{1}, {1}, 0, 1}}; Point({0}2) = {{{1} + 1, {1}, 0, 1}}; Point({0}4) = {{{1}, {1} + 1, 0, 1}};\n"
    script = square.format(1, 0) + "Point(13) = {1, 1, 0, 1};\n" + square.format(2, 1).replace("Point(21) = {1, 1, 0, 1};",
        "") + "Point(23) = {2, 2, 0, 1};\n"
    for number, corners in ((1, (11, 12, 13, 14)), (2, (13, 22, 23, 24))):
        for k in range(4):
            script += f"Line({number}{k + 1}) = {{{corners[k]}, {corners[(k + 1) % 4]}}};\n"
        script += f"Curve Loop({number}) = {{{number}1, {number}2, {number}3, {number}4}}; Plane Surface({number}) = {{{number}}};\n"
    script += 'Physical Curve("wall") = {11, 12, 13, 14, 21, 22, 23, 24}; Physical Surface("fluid") = {1, 2};\n'
    (tmp_path / "touch.geo").write_text(script)
    words = [sys.executable, "-m", "tools.mesh", "own", "--from", tmp_path / "touch.geo", "--size", 0.2, "--out",
        tmp_path / "touch.mesh"]
    done = subprocess.run(list(map(str, words)), cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 4 and "2 pieces that share no side" in done.stderr and not (tmp_path / "touch.mesh").exists()


@pytest.mark.parametrize("driver", DRIVERS)
def test_a_line_within_the_fluid_is_no_side(driver, freefem_text, tmp_path):
    """As on the same mesh without it, bit for bit; it was asked to be a wall, or its open ends were refused as a boundary that is
    not closed."""
    table = {"flow": "fluid", "resolved": "particles", "steady_laminar": "results", "transport": "particles"}[driver]
    for name, inner in (("plain", ()), ("line", LOOP)):
        run(freefem_text, driver, write(tmp_path / f"{name}.mesh", [(0, 0)], inner), tmp_path / name)
    plain, line = ((tmp_path / name / f"{table}.csv").read_text().splitlines() for name in ("plain", "line"))
    if driver == "steady_laminar":
        plain, line = ([row for row in rows if "cpu_time" not in row] for rows in (plain, line))
    if driver == "flow":  # the last columns are times
        plain, line = ([row.split(",")[:10] for row in rows] for rows in (plain, line))
    assert len(plain) > 2 and plain == line


def test_a_run_goes_on_from_its_own_copy_of_such_a_mesh(freefem_text, tmp_path):
    mesh = write(tmp_path / "line.mesh", [(0, 0)], LOOP)
    run(freefem_text, "resolved", mesh, tmp_path / "run")
    run(freefem_text, "resolved", tmp_path / "run" / "mesh.mesh", tmp_path / "again")
    read = [RunFolder(tmp_path / name).particles for name in ("run", "again")]
    assert all((read[0][name] == read[1][name]).all() for name in ("x", "y", "u", "v"))


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("label, walls", [(5, "labelWall, labelObstacle"), (3, "labelWall")])
def test_a_baffle_is_refused_in_one_line(driver, label, walls, freefem_text, tmp_path):
    """A wall of two sides has two pressures; a line of the mesh has one. With its own label, and with that of the walls."""
    mesh = write(tmp_path / "baffle.mesh", [(0, 0)], LOOP, label)
    line = refused(run(freefem_text, driver, mesh, tmp_path / "run", walls, check=False))
    assert f"label {label}" in line and "triangles on both sides, one of them at (0.3125, 0.25)" in line and "thin hole" in line


def test_an_inlet_that_lies_within_the_fluid_is_refused_for_that(freefem_text, tmp_path):
    mesh = write(tmp_path / "inlet.mesh", [(0, 0)], LOOP, 7)
    done = freefem_text(text("flow").replace("flowMoving = [labelInlet]", "flowMoving = [labelInlet, labelLid]"), *TIMES, "-mesh",
        mesh, "-out", tmp_path / "run", check=False)
    assert "label 7 (lid)" in refused(done) and "triangles on both sides" in done.stderr


def test_pictures_show_no_line_within_the_fluid(tmp_path):
    mesh = read_mesh(write(tmp_path / "line.mesh", [(0, 0)], LOOP))
    assert set(mesh.labels) == {1, 2, 3} and len(mesh.edges) == len(mesh.labels) == 4 * N
