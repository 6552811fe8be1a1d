"""Flows of other programs (python -m tools.flow): what is read of each kind of file, how it comes to the nodes, what is refused."""
import shutil

import meshio
import numpy as np
import pytest

from tests.conftest import ROOT, run_tool
from tools.base.command import BadInput
from tools.base.mesh_files import read_mesh
from tools.flow import cloud, vtk
from tools.flow.given import Given, unused
from tools.flow.plane import split
from tools.flow.values import Middles, at_vertices, sides_of
from tools.meshing.labels import LABELS
from tools.meshing.plane_mesh import PlaneMesh, edges_of, signed_areas
from tools.validation.given_flow import vortex_file

PIPE = ROOT / "tests/data/openfoam_pipe"
WALLS = "--label", "wall=rest"


def made(out, *words):
    """(Mesh, times, frames {name: values at all nodes}) of the folder that tools.flow makes, and what it says."""
    done = run_tool("flow", *words, "--out", out)
    assert done.returncode == 0, done.stderr
    return *read_flow(out), done


def read_flow(folder):
    mesh, times = read_mesh(folder / "mesh.mesh"), [float(line) for line in (folder / "flow.txt").read_text().split("\n")[4:-2]]
    frames = []
    for k in range(len(times)):
        words, frame = (folder / f"frame_{k:05d}.txt").read_text().split(), {}
        while words[0] != "whole":
            end = 2 + int(words[1])
            frame[words[0]], words = np.array(words[2:end], float), words[end:]
        frames.append(frame)
    return mesh, times, frames


def refused(tmp_path, *words):
    done = run_tool("flow", *words, "--out", tmp_path / "refused")
    lines = done.stderr.strip().splitlines()
    assert done.returncode == 3 and len(lines) == 1 and lines[0].startswith("error: "), done.stderr
    assert not (tmp_path / "refused").exists()
    return lines[0]


def test_openfoam_in_time(tmp_path):
    mesh, times, frames, _ = made(tmp_path / "flow", PIPE / "case.foam", "--times", "5.2:")
    assert times == [5.2, 5.25, 5.3, 5.35, 5.4, 5.45, 5.5] and set(mesh.labels) == {1, 2, 3}
    sides, _ = sides_of(mesh.triangles)
    nodes = np.concatenate([mesh.points, mesh.points[sides].mean(axis=1)])
    inlet, rim = nodes[:, 0] < 1e-9, np.abs(nodes[:, 1]) > 0.1 - 1e-9
    for time, frame in zip(times, frames):
        parabola = 2 * (1 + 0.8 * np.sin(4 * np.pi * time)) * (1 - (nodes[inlet, 1] / 0.1) ** 2)
        assert np.abs(frame["u"][inlet] - parabola).max() < 0.03  # of 20 edges of a side
        assert np.abs(frame["u"][rim]).max() == np.abs(frame["v"][rim]).max() == 0


def test_the_flow_of_a_case_is_that_of_its_data(tmp_path):
    """meshes/openfoam_pipe is the steady time of tests/data/openfoam_pipe, also where this is named by its folder."""
    mesh, times, frames, done = made(tmp_path / "flow", PIPE, "--times", "4:4")
    kept, _, there = read_flow(ROOT / "meshes/openfoam_pipe")
    assert times == [4] and "values of the cells, fitted at the vertices" in done.stdout and done.stderr == ""
    np.testing.assert_array_equal(mesh.triangles, kept.triangles)
    for name in "uv":
        np.testing.assert_allclose(frames[0][name], there[0][name], atol=1e-6)


FOAM = """FoamFile {{ version 2.0; format {form}; class {kind}; arch "LSB;label=32;scalar=64"; object x; }}
"""
# two cells side by side, 1 x 1 x 0.1, y across; the patch "in" has a value, "out" has none
CORNERS = np.array([[x, y, z] for y in (0, 0.1) for z in (0, 1) for x in (0, 1, 2)], float)
FACES = [[1, 4, 10, 7], [0, 3, 9, 6], [2, 8, 11, 5], [0, 6, 7, 1], [1, 7, 8, 2], [3, 4, 10, 9], [4, 5, 11, 10], [0, 1, 4, 3],
    [1, 2, 5, 4], [6, 9, 10, 7], [7, 10, 11, 8]]
OWNER = [0, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1]
PATCHES = "4\n(in {type patch; nFaces 1; startFace 1;} out {type patch; nFaces 1; startFace 2;}\n" \
    "sides {type wall; nFaces 4; startFace 3;} flat {type empty; inGroups 1(empty); nFaces 4; startFace 7;})\n"


def foam_list(values, binary):
    """A list of numbers or vectors as OpenFOAM writes it."""
    values = np.asarray(values)
    if binary:
        return f"{len(values)}\n(".encode() + values.astype("<i4" if values.dtype.kind == "i" else "<f8").tobytes() + b")\n"
    rows = ["(" + " ".join(map(repr, row.tolist())) + ")" if values.ndim == 2 else repr(row.item()) for row in values]
    return (f"{len(values)}\n(\n" + "\n".join(rows) + "\n)\n").encode()


def foam_case(folder, binary=False, patches=PATCHES, velocity=((1, 0, 2), (3, 0, 4)), boundary="uniform (5 0 6)"):
    """A case of two cells, with k and omega."""
    form = "binary" if binary else "ascii"
    faces = foam_list(np.cumsum([0] + [len(face) for face in FACES]), True) + foam_list(np.concatenate(FACES), True) if binary \
        else f"{len(FACES)}\n(\n".encode() + b"".join(b"4(%d %d %d %d)\n" % tuple(face) for face in FACES) + b")\n"
    files = (("points", "vectorField", foam_list(CORNERS, binary)), ("faces", "faceCompactList" if binary else "faceList", faces),
        ("owner", "labelList", foam_list(OWNER, binary)), ("boundary", "polyBoundaryMesh", patches.encode()))
    for name, kind, data in files:
        write(folder / "constant/polyMesh" / name, FOAM.format(form=form, kind=kind).encode() + data)
    for name, kind, inside, value in (("U", "vector", np.array(velocity, float), boundary), ("k", "scalar", np.array([0.5, 1.5]),
            "uniform 0.25"), ("omega", "scalar", np.array([4.0, 2.0]), "uniform 8")):
        text = f"dimensions [0 0 0 0 0 0 0];\ninternalField nonuniform List<{kind}> ".encode() + foam_list(inside, binary) + b";\n"
        text += f"boundaryField {{ in {{ type fixedValue; value {value}; }} ".encode()
        text += b'"(out|flat)" { type calculated; } sides { type slip; } }\n'
        write(folder / "7" / name, FOAM.format(form=form, kind="vol").encode() + text)
    return folder


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


@pytest.mark.parametrize("binary", [False, True])
def test_openfoam_across_y_with_k_and_omega(binary, tmp_path):
    names = "--label", "inlet=in", "--label", "outlet=out"
    mesh, times, (frame,), _ = made(tmp_path / "flow", foam_case(tmp_path / "case", binary), *names)
    assert times == [7] and len(mesh.triangles) == 4
    assert sorted(mesh.labels) == [LABELS[name] for name in ("inlet", "outlet", *["wall"] * 4)]
    at = {tuple(point): k for k, point in enumerate(mesh.points.tolist())}
    assert [frame[name][at[0.0, 1.0]] for name in ("u", "v", "k")] == [5, 6, 0.25]  # of the patch
    np.testing.assert_allclose([frame[name][at[1.0, 0.0]] for name in ("u", "v", "k", "epsilon")], [2, 3, 1, 0.09 * 2.5])
    assert frame["k"].min() >= 0.25


def test_openfoam_refusals(tmp_path):
    assert "no OpenFOAM case" in refused(tmp_path, tmp_path)
    case = foam_case(tmp_path / "case")
    assert "the patch in" in refused(tmp_path, case) and "--label wall=in" in refused(tmp_path, case)
    assert "has no patch exit; its patches: in, out, sides" in refused(tmp_path, case, "--label", "inlet=exit")
    assert "no time from 8 to 9 s; it has 7" in refused(tmp_path, case, "--times", "8:9")
    assert "last, all or FROM:TO" in refused(tmp_path, case, "--times", "1,2")
    assert "no velocities" in refused(tmp_path, case, "--velocity", "UMean")
    for patches, what in ((PATCHES.replace("empty;", "patch;"), "3-D flow: its mesh has no patches of type empty"),
            (PATCHES.replace("empty;", "wedge;"), "is a wedge"), ("4\n(in {type patch;})", "not a whole file")):
        assert what in refused(tmp_path, foam_case(tmp_path / what[:4], patches=patches), *WALLS)
    for changes, what in (({"velocity": ((1, 0, 2), (np.nan, 0, 4))}, "u has 1 values that are no finite numbers"),
            ({"velocity": ((1, 1, 2), (3, 1, 4))}, "the flow is 3-D, its third component reaches 1"),
            ({"velocity": ((1, 0, 2),)}, "no vectors of its 2 cells")):
        assert what in refused(tmp_path, foam_case(tmp_path / what[:9], **changes), *WALLS)
    (case / "constant/polyMesh/points").write_bytes((case / "constant/polyMesh/points").read_bytes()[:-40])
    assert "points is not a whole file" in refused(tmp_path, case, *WALLS)


POLYGONS = [[0, 1, 2, 8, 3, 5, 4], [2, 6, 7, 3, 8]]  # (1, 0.5) hangs on a side, (0.5, 0) and (0.5, 1) within sides
PLACES = np.array([[0, 0], [0.5, 0], [1, 0], [1, 1], [0, 1], [0.5, 1], [2, 0], [2, 1], [1, 0.5]])


def test_polygons_are_split_whole():
    bent = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2.0]])
    for points, polygons, areas in ((PLACES, [np.array(one) for one in POLYGONS], [1, 1]), (bent, [np.arange(6)[::-1]], [3])):
        triangles, owner = split(points, polygons)
        assert signed_areas(points, triangles).min() > 0.1
        np.testing.assert_allclose(np.bincount(owner, signed_areas(points, triangles)), areas)
        _, count = edges_of(triangles)
        assert count.max() <= 2 and len(triangles) == sum(len(one) - 2 for one in polygons)


def shaken(tmp_path, kind, where="points", cells=6):
    data = meshio.read(vortex_file(tmp_path / "shaken.vtu", cells, kind, where))
    return data.points[:, :2], data.cells[0].data


def test_from_cells_to_vertices_is_exact_for_a_linear_flow(tmp_path):
    """At the boundary and in corners too, where the cells around stand to one side."""
    points, quads = shaken(tmp_path, "quad")
    flow = Given(points, list(quads), [0], [], True)
    corners = points[quads]
    cross = np.roll(corners, -1, axis=1)[..., 1] * corners[..., 0] - np.roll(corners, -1, axis=1)[..., 0] * corners[..., 1]
    centre = ((corners + np.roll(corners, -1, axis=1)) * cross[..., None]).sum(axis=1) / (3 * cross.sum(axis=1))[:, None]
    found = at_vertices(flow, {"u": 1 + 2 * centre[:, 0] - 3 * centre[:, 1]}, {})
    np.testing.assert_allclose(found["u"], 1 + 2 * points[:, 0] - 3 * points[:, 1], atol=1e-11)


def test_middles_are_exact_for_a_quadratic_flow_and_rest_at_walls(tmp_path):
    points, triangles = shaken(tmp_path, "triangle")
    edges, count = edges_of(triangles)
    middles = Middles(PlaneMesh(points, triangles, edges[count == 1], np.ones(np.sum(count == 1), int)))

    def quadratic(x, y):
        return np.stack([1 + x - 2 * y + 3 * x * x - x * y, y * y + x * y], axis=1)

    at = points[middles.sides].mean(axis=1)
    np.testing.assert_allclose(middles(quadratic(*points.T)), quadratic(*at.T), atol=1e-11)
    still = points[:, 1] == 0
    velocity = np.where(still[:, None], 0, quadratic(*points.T))
    assert np.abs(middles(velocity)[at[:, 1] == 0]).max() == 0
    # a layer that the mesh does not resolve: no values far beyond those around
    jump = np.where(points[:, :1] > 0.5, [1.0, 2.0], [0.0, 0.0])
    assert middles(jump).min() >= -0.25 and (middles(jump) <= [1.125, 2.25]).all()


def test_cells_one_deep_across_any_axis_are_the_plane(tmp_path):
    points, quads = shaken(tmp_path, "quad")
    plane = meshio.read(tmp_path / "shaken.vtu").point_data["U"]
    wanted = made(tmp_path / "plane", tmp_path / "shaken.vtu", *WALLS)
    for axis in range(3):
        order = np.insert([0, 1], axis, 2)  # of the plane's two coordinates and the depth
        sheets = [np.column_stack([points, np.full(len(points), depth)])[:, order] for depth in (0.3, 0.4)]
        velocity = np.tile(plane, (2, 1))[:, order]
        hexes = np.column_stack([quads, quads + len(points)])
        hexes[::2] = hexes[::2][:, [0, 4, 5, 1, 3, 7, 6, 2]]  # lies on its side
        meshio.Mesh(np.concatenate(sheets), [("hexahedron", hexes)], point_data={"U": velocity}).write(tmp_path / "deep.vtu")
        mesh, _, (frame,), _ = made(tmp_path / "deep", tmp_path / "deep.vtu", *WALLS)
        assert len(mesh.triangles) == 72 and np.allclose(mesh.points, wanted[0].points)
        for name in "uv":
            np.testing.assert_allclose(frame[name][:49], wanted[2][0][name][:49], atol=1e-7)


def test_several_files_a_pvd_and_values_in_cells(tmp_path):
    files = [vortex_file(tmp_path / f"{k}.vtu", 6, "quad", t=0.1 * k, swell=0.5) for k in range(3)]
    _, times, frames, _ = made(tmp_path / "flow", *files, *WALLS, "--times", "0,0.1,0.2")
    assert times == [0, 0.1, 0.2] and frames[1]["u"].max() == pytest.approx((1 + 0.5 * np.sin(0.2 * np.pi)) * frames[0]["u"].max())
    (tmp_path / "all.pvd").write_text("<VTKFile><Collection>" + "".join(f'<DataSet timestep="{0.1 * k}" file="{k}.vtu"/>'
        for k in range(3)) + "</Collection></VTKFile>")
    _, times, again, _ = made(tmp_path / "listed", tmp_path / "all.pvd", *WALLS, "--times", "0.1:")
    assert times == [0.1, 0.2] and (again[1]["v"] == frames[2]["v"]).all()
    (tmp_path / "parts.pvd").write_text((tmp_path / "all.pvd").read_text().replace('"0.2"', '"0.1" part="1"'))
    with pytest.raises(BadInput, match="several files of one time"):  # the others were left out in silence
        vtk.listed(tmp_path / "parts.pvd", "all")
    assert unused(["U", "k"], ["omega"]) == ["k", "omega"] and unused(["U", "k", "omega"], ["k"]) == unused(["U"]) == []
    assert "gives 2 times for 3 files" in refused(tmp_path, *files, *WALLS, "--times", "0,1")
    other = vortex_file(tmp_path / "other.vtu", 5, "quad")
    assert "another mesh" in refused(tmp_path, files[0], other, *WALLS, "--times", "0,1")
    cells = vortex_file(tmp_path / "cells.vtu", 6, "quad", "cells")
    assert "values of the cells" in made(tmp_path / "cells", cells, *WALLS)[3].stdout
    _, _, (held,), _ = made(tmp_path / "held", cells, "--label", "cylinder=rest", "--no-slip", "--scale", "0.1")
    mesh = read_mesh(tmp_path / "held/mesh.mesh")
    assert mesh.points.max() == pytest.approx(0.1) and np.abs(held["u"][np.unique(mesh.edges)]).max() == 0


def test_sides_are_named_by_the_first_label_that_fits(tmp_path):
    file = vortex_file(tmp_path / "one.vtu", 6)
    mesh, *_ = made(tmp_path / "flow", file, "--label", "inlet=x<1e-6&y>=0.5", "--label", "left=x<1e-6", "--label", "outlet=x>0.99",
        "--label", "wall=rest")
    assert [int(np.sum(mesh.labels == LABELS[name])) for name in ("inlet", "left", "outlet", "wall")] == [3, 3, 6, 12]
    assert "24 sides of" in (line := refused(tmp_path, file)) and "give one, as --label inlet=x<1e-6" in line
    for word, what in (("door=x<1", "names are inlet, outlet"), ("inlet=x<y", "conditions are as x<1e-6"), ("inlet=x<-1", "no side "
            "of"), ("inlet=entry", "its sides have no names"), ("inlet", "takes NAME=CONDITION")):
        assert what in refused(tmp_path, file, "--label", word, *WALLS), word


def table(path, header, places, *columns):
    np.savetxt(path, np.column_stack([places, *columns]), delimiter=", ", header=header, comments="", fmt="%.15g")
    return path


def test_a_table_of_points_as_fluent_writes_it(tmp_path):
    """Linear in between; outside the points too, with one line."""
    vortex_file(tmp_path / "mesh.vtu", 6)
    made(tmp_path / "base", tmp_path / "mesh.vtu", *WALLS)
    mesh = tmp_path / "base/mesh.mesh"
    random = np.random.default_rng(3)
    places = np.concatenate([random.uniform(-0.1, 1.1, (400, 2)), [[-1, -1], [2, -1], [-1, 2], [2, 2]]])
    x, y = places.T
    columns = 1 + x - y, 2 * x - y, 0.1 + 0.01 * x, 0.2 + 0.1 * y
    header = "nodenumber, x-coordinate, y-coordinate, x-velocity, y-velocity, turb-kinetic-energy, turb-diss-rate"
    file = table(tmp_path / "fluent.csv", header, np.arange(len(x)), places, *columns)
    got, _, (frame,), done = made(tmp_path / "flow", file, "--mesh", mesh)
    assert "fluid passes sides that are named walls" in done.stderr and done.stderr.count("\n") == 1
    assert set(got.labels) == {3} and "with k and epsilon" in done.stdout
    sides, _ = sides_of(got.triangles)
    nodes = np.concatenate([got.points, got.points[sides].mean(axis=1)])
    exact = {"u": 1 + nodes[:, 0] - nodes[:, 1], "v": 2 * nodes[:, 0] - nodes[:, 1], "k": 0.1 + 0.01 * nodes[:, 0],
        "epsilon": 0.2 + 0.1 * nodes[:, 1]}
    for name, values in exact.items():
        np.testing.assert_allclose(frame[name], values, atol=1e-7)
    within = (np.abs(places - 0.5) < 0.45).all(axis=1)
    file = table(tmp_path / "inner.csv", "X [ m ], Y [ m ], Velocity u [ m s^-1 ], Velocity v [ m s^-1 ]", places[within],
        columns[0][within], columns[1][within])
    _, _, (frame,), done = made(tmp_path / "inner", file, "--mesh", mesh)
    assert len(done.stderr.splitlines()) == 2 and "of 49 vertices of the mesh lie outside the points" in done.stderr
    np.testing.assert_allclose(frame["u"], exact["u"], atol=1e-7)
    assert "do not cover the mesh" in refused(tmp_path, file, "--mesh", mesh, "--scale", "0.001")


def test_tables_that_are_refused(tmp_path):
    vortex_file(tmp_path / "mesh.vtu", 4)
    made(tmp_path / "base", tmp_path / "mesh.vtu", *WALLS)
    mesh, places = ("--mesh", tmp_path / "base/mesh.mesh"), np.random.default_rng(3).uniform(0, 1, (20, 2))
    one = np.ones(20)
    good = table(tmp_path / "good.csv", "x,y,u,v", places, one, one)
    assert "--mesh names the mesh" in refused(tmp_path, good)
    assert "there" in refused(tmp_path, tmp_path / "none.csv", *mesh)
    assert "there" in refused(tmp_path, good, "--mesh", tmp_path / "none.msh")
    (tmp_path / "wide.csv").write_bytes(good.read_text().encode("utf-16"))
    assert "no plain text (UTF-16" in refused(tmp_path, tmp_path / "wide.csv", *mesh)
    bad = table(tmp_path / "a.csv", "a,y,u,v", places, one, one)
    assert "lacks the columns x and y; it has a, y, u, v" in refused(tmp_path, bad, *mesh)
    assert "no velocities" in refused(tmp_path, table(tmp_path / "b.csv", "x,y,p,v", places, one, one), *mesh)
    bad = table(tmp_path / "c.csv", "x,y,u,v", places, np.nan * one, one)
    assert "u is nan, not a finite number" in refused(tmp_path, bad, *mesh)
    assert "3-D, its third component" in refused(tmp_path, table(tmp_path / "d.csv", "x,y,u,v,w", places, one, one, one), *mesh)
    assert "span no area" in refused(tmp_path, table(tmp_path / "e.csv", "x,y,u,v", places[:, [0, 0]], one, one), *mesh)
    assert "no velocity 'a,b'; its arrays: u, v" in refused(tmp_path, good, *mesh, "--velocity", "a,b")


def test_tables_that_contradict_themselves_or_the_mesh(tmp_path):
    """Read in the process of the test: points twice, in space, in another unit; k below 0."""
    unit = np.linspace(0, 1, 12)
    places = np.stack(np.meshgrid(unit, unit), axis=-1).reshape(-1, 2)
    u, base = 1 + places[:, 0], PlaneMesh(places[:0], np.empty((0, 3), int), np.empty((0, 2), int), np.empty(0, int))
    base.points = np.array([[0, 0], [1, 0], [0.3, 0.6], [1, 1]])

    def read(header, places, *columns, scale=1.0):
        return cloud.read([(0.0, table(tmp_path / "table.csv", header, places, *columns))], None, base, scale).frames[0]

    both = np.concatenate([places, places])
    same = read("x,y,u,v", both, np.tile(u, 2), np.tile(u, 2))["u"]
    np.testing.assert_allclose(same, 1 + base.points[:, 0])
    with pytest.raises(BadInput, match="144 points stand more than once, with values that contradict"):
        read("x,y,u,v", both, np.append(u, 2 * u), np.tile(u, 2))
    deep = np.repeat([0, 0.1], len(places))
    read("x,y,z,u,v", both, deep, np.tile(u, 2), np.tile(u, 2))  # two planes of one cell
    with pytest.raises(BadInput, match="lie in no plane, z goes from 0 to 1"):
        read("x,y,z,u,v", places, np.linspace(0, 1, len(places)), u, u)
    for scale in (1000, 0.02):
        with pytest.raises(BadInput, match=r"1 of its 144 points lie where the mesh is|do not cover the mesh"):
            read("x,y,u,v", places, u, u, scale=scale)
    with pytest.raises(BadInput, match=r"column X \[ mm \] is not in m: write the table in SI units, or give --scale"):
        read("X [ mm ],Y [ mm ],Velocity u [ m s^-1 ],Velocity v [ m s^-1 ]", places, u, u)
    with pytest.raises(BadInput, match=r"column u \[mm/s\] is not in m/s"):
        read("x [km],y [km],u [mm/s],v [mm/s]", places, u, u, scale=1.01)
    with pytest.raises(BadInput, match="4 values where the header names 1 column"):
        read("xyuv", places, u, u)
    with pytest.raises(BadInput, match="k is negative, down to -0.1"):
        read("x,y,u,v,k,epsilon", places, u, u, np.where(u > 1.5, -0.1, 0.2), u)
    assert read("x,y,u,v,k,epsilon", places, u, u, np.where(u > 1.5, -1e-9, 0.2), u)["k"].min() == 0


def test_other_files_that_are_refused(tmp_path):
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.0]])

    def file(name, cells, **data):
        meshio.Mesh(points, cells, **data).write(tmp_path / name)
        return tmp_path / name

    velocity = {"U": np.ones((5, 3)) * [1, 1, 0]}
    for found, what in (
            (tmp_path / "none.vtu", "it is not there"), (tmp_path / "none.foam", "is no OpenFOAM case"),
            (tmp_path / "none.dat", "is no folder of an OpenFOAM case"),
            (file("a.vtu", [("tetra", np.array([[0, 1, 2, 3]]))], point_data=velocity), "3-D flow: it has cells of the kind tetra"),
            (file("b.vtu", [("triangle", np.array([[0, 1, 2], [1, 2, 4]]))], point_data=velocity), "lie in no plane"),
            (file("c.vtu", [("triangle", np.array([[0, 1, 2]]))], point_data={"p": np.ones(5)}), "no velocities"),
            (file("d.vtu", [("triangle", np.array([[0, 1, 2]]))]), "no velocities"),
            (file("e.vtu", [("triangle", np.array([[0, 1, 2]]))], point_data={"U": np.ones((5, 3))}), "the flow is 3-D"),
            (file("f.vtu", [("triangle", np.array([[0, 1, 2]]))], point_data={"U": np.full((5, 3), np.inf)}), "no finite numbers"),
            (file("g.vtu", [("line", np.array([[0, 1]]))], point_data=velocity), "no plane cells")):
        assert what in refused(tmp_path, found, *WALLS), what
    (tmp_path / "h.vtu").write_text("<VTKFile>")
    assert "no whole file" in refused(tmp_path, tmp_path / "h.vtu", *WALLS)
    good = file("i.vtu", [("triangle", np.array([[0, 1, 2]]))], point_data=velocity)
    assert "--mesh is for tables" in refused(tmp_path, good, *WALLS, "--mesh", good)


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    file = vortex_file(tmp_path / "one.vtu", 4)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine/notes.txt").write_text("mine")
    done = run_tool("flow", file, *WALLS, "--out", tmp_path / "mine")
    assert done.returncode == 3 and "holds no flow" in done.stderr and len(list((tmp_path / "mine").iterdir())) == 1
    shutil.rmtree(tmp_path / "mine")
    made(tmp_path / "mine", file, file, *WALLS, "--times", "0,1")
    made(tmp_path / "mine", file, *WALLS)  # a flow is replaced, with all its times
    assert sorted(path.name for path in (tmp_path / "mine").iterdir()) == ["flow.txt", "frame_00000.txt", "mesh.mesh"]


def test_a_flow_that_does_not_balance_is_told(tmp_path):
    points, quads = shaken(tmp_path, "quad")
    meshio.Mesh(points, [("quad", quads)], point_data={"u": points[:, 0], "v": 0 * points[:, 0]}).write(tmp_path / "source.vtu")
    done = made(tmp_path / "flow", tmp_path / "source.vtu", *WALLS)[3]
    assert len(done.stderr.splitlines()) == 2 and "0 m2/s flow in, 1 out" in done.stderr
    closed = vortex_file(tmp_path / "closed.vtu", 8, "quad", "cells")
    assert made(tmp_path / "closed", closed, *WALLS)[3].stderr == ""
