"""Flows of other programs in several pieces, in other planes, and under other names (python -m tools.flow)."""
import re

import meshio
import numpy as np
import pytest

from tools.base.command import BadInput
from tools.flow.main import main

N = 4
X, Y = (one.ravel() for one in np.meshgrid(np.arange(2 * N + 1) / N, np.arange(N + 1) / N))
FIRST = np.array([row * (2 * N + 1) + k for row in range(N) for k in range(2 * N)])
QUADS = np.column_stack([FIRST, FIRST + 1, FIRST + 2 * N + 2, FIRST + 2 * N + 1])
POINTS, FLOW = np.column_stack([X, Y, 0 * X]), np.column_stack([Y * (1 - Y), 0 * X, 0 * X])
SIDES = ["--label", "inlet=x<1e-6", "--label", "outlet=x>1.9999", "--label", "wall=rest"]
FLUX = 1 / 6  # of y (1 - y)


def part(which):
    """(points, cells, velocities) of the cells `which`, with points of their own."""
    used, cells = np.unique(QUADS[which], return_inverse=True)
    return POINTS[used], cells.reshape(-1, 4), FLOW[used]


def said(tmp_path, capsys, name, *words):
    assert main([str(tmp_path / name), *SIDES, *words, "--out", str(tmp_path / "out")]) == 0
    return capsys.readouterr()


def judged(tmp_path, capsys, name, *words):
    """The whole channel, once, with its flux, and no warning."""
    out, err = said(tmp_path, capsys, name, *words)
    assert f": {len(X)} vertices, {4 * N * N} triangles," in out, out
    assert [float(word) for word in re.search(r"flux in (\S+), out (\S+) ", out).groups()] == pytest.approx([FLUX, FLUX], 1e-4)
    assert not err


def halves():
    left = POINTS[QUADS][:, :, 0].mean(axis=1) < 1
    return part(left), part(~left)


def array(name, values, kind="Float64"):
    many = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return f'<DataArray type="{kind}" Name="{name}"{many} format="ascii">{" ".join(map(str, values.ravel().tolist()))}</DataArray>'


def piece(points, cells, flow, ghosts=None):
    ghost = "" if ghosts is None else f'<CellData>{array("vtkGhostType", ghosts, "UInt8")}</CellData>'
    return (f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}"><Points>{array("Points", points)}</Points><Cells>'
        f'{array("connectivity", cells, "Int64")}{array("offsets", 4 * np.arange(1, len(cells) + 1), "Int64")}'
        f'{array("types", np.full(len(cells), 9), "UInt8")}</Cells><PointData>{array("Velocity", flow)}</PointData>{ghost}</Piece>')


def grid(path, *parts):
    path.write_text('<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
        f'<UnstructuredGrid>{"".join(parts)}</UnstructuredGrid></VTKFile>')


def test_every_piece_of_a_vtu_is_read(tmp_path, capsys):
    """The last one was taken alone, in silence."""
    grid(tmp_path / "flow.vtu", *(piece(*one) for one in halves()))
    judged(tmp_path, capsys, "flow.vtu")


def test_a_pvtu_without_its_ghost_cells(tmp_path, capsys):
    (left, right), row = halves(), POINTS[QUADS][:, :, 0].mean(axis=1)
    wider = row < 1 + 1 / N  # the left half and a column of the right one
    grid(tmp_path / "a.vtu", piece(*part(wider), ghosts=(row[wider] > 1).astype(int)))
    grid(tmp_path / "b.vtu", piece(*right, ghosts=np.zeros(len(right[1]), int)))
    (tmp_path / "flow.pvtu").write_text('<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="1">'
        '<Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid></VTKFile>')
    judged(tmp_path, capsys, "flow.pvtu")
    (tmp_path / "b.vtu").unlink()
    with pytest.raises(BadInput, match="b.vtu, a piece of the flow"):
        said(tmp_path, capsys, "flow.pvtu")


@pytest.mark.parametrize("kind", ["points", "cells"])
def test_blocks_and_cells_with_points_of_their_own_are_joined(tmp_path, capsys, kind):
    """Merge Blocks of ParaView leaves the points of each block; such a file was refused."""
    for parts in (halves(), [part([k]) for k in range(len(QUADS))]):
        before = np.cumsum([0] + [len(points) for points, *_ in parts])
        cells = np.concatenate([cells + by for (_, cells, _), by in zip(parts, before)])
        points, flow = np.concatenate([points for points, *_ in parts]), np.concatenate([flow for *_, flow in parts])
        uniform = np.repeat([[1.0, 0, 0]], len(cells), axis=0)
        there = {"point_data": {"U": flow}} if kind == "points" else {"cell_data": {"U": [uniform]}}
        meshio.Mesh(points, [("quad", cells)], **there).write(tmp_path / "flow.vtu")
        if kind == "points":
            judged(tmp_path, capsys, "flow.vtu")
        else:
            assert "inlet (1) 4, outlet (2) 4, wall (3) 16\n" in said(tmp_path, capsys, "flow.vtu").out


def test_values_that_jump_between_cells_are_told(tmp_path, capsys):
    left, right = halves()
    meshio.Mesh(np.concatenate([left[0], right[0]]), [("quad", np.concatenate([left[1], right[1] + len(left[0])]))],
        point_data={"U": np.concatenate([left[2], 1.2 * right[2]])}).write(tmp_path / "flow.vtu")
    assert "differ by up to 0.05 (of u); their means are taken" in said(tmp_path, capsys, "flow.vtu").err


def test_a_thin_wall_at_rest_on_both_sides_stays_one(tmp_path, capsys):
    """Two channels on each other, with points of their own along the wall between them, and one end where the wall is open."""
    upper, bottom = POINTS + [0, 1, 0], FLOW.copy()
    open_end = np.flatnonzero((Y == 0) & (X > 1.7))  # of the upper channel; the same points as at y = 1 below
    number = np.arange(len(X)) + len(X)
    number[open_end] = [np.flatnonzero((Y == 1) & (X == X[k]))[0] for k in open_end]
    meshio.Mesh(np.concatenate([POINTS, upper]), [("quad", np.concatenate([QUADS, number[QUADS]]))],
        point_data={"U": np.concatenate([bottom, FLOW])}).write(tmp_path / "flow.vtu")
    assert "inlet (1) 8, outlet (2) 8, wall (3) 30\n" in said(tmp_path, capsys, "flow.vtu").out  # 16 outside, 7 on each side


@pytest.mark.parametrize("names", ["U_x U_y U_z", "Velocity[i] Velocity[j] Velocity[k]", "u (m/s)|v (m/s)|w (m/s)",
    "Velocity:X Velocity:Y Velocity:Z", "x-velocity y-velocity z-velocity"])
def test_components_by_name_in_another_plane(tmp_path, capsys, names):
    """Those of x and y were taken whatever the plane, and the third one was then called a third dimension."""
    names = names.split("|") if "|" in names else names.split()
    turned = dict(zip(names, (FLOW[:, 0], FLOW[:, 1], FLOW[:, 1])))
    for k, points in enumerate(((X, 0 * X, Y), (0 * X, X, Y))):
        given = turned if k == 0 else dict(zip(names, (FLOW[:, 1], FLOW[:, 0], FLOW[:, 1])))
        meshio.Mesh(np.column_stack(points), [("quad", QUADS)], point_data=given).write(tmp_path / "flow.vtu")
        judged(tmp_path, capsys, "flow.vtu")
    judged(tmp_path, capsys, "flow.vtu", "--velocity", ",".join(names[1:]))


def test_a_table_in_another_plane(tmp_path, capsys):
    meshio.Mesh(POINTS, [("quad", QUADS)], point_data={"U": FLOW}).write(tmp_path / "flow.vtu")
    said(tmp_path, capsys, "flow.vtu")
    rows = "".join(f"{u},0,0,{x},0.3,{y}\n" for (u, *_), x, y in zip(FLOW, X, Y))
    (tmp_path / "flow.csv").write_text('"U:0","U:1","U:2","Points:0","Points:1","Points:2"\n' + rows)
    (tmp_path / "out").rename(tmp_path / "made")
    judged(tmp_path, capsys, "flow.csv", "--mesh", str(tmp_path / "made/mesh.mesh"))
    (tmp_path / "flow.csv").write_text("x,y,u,v\n")
    with pytest.raises(BadInput, match="a header row and no others"):
        said(tmp_path, capsys, "flow.csv", "--mesh", str(tmp_path / "made/mesh.mesh"))


def test_units_and_values_that_no_cell_has(tmp_path, capsys):
    """A velocity in cm/s was taken for one in m/s."""
    meshio.Mesh(POINTS, [("quad", QUADS)], point_data={"velocity [cm/s]": 100 * FLOW}).write(tmp_path / "flow.vtu")
    with pytest.raises(BadInput, match="is not in m/s"):
        said(tmp_path, capsys, "flow.vtu")
    meshio.Mesh(np.concatenate([POINTS, [[9, 9, 0]]]), [("quad", QUADS)], point_data={"velocity": np.concatenate([FLOW,
        [[np.nan] * 3]])}).write(tmp_path / "flow.vtu")
    judged(tmp_path, capsys, "flow.vtu")


def test_what_the_reader_does_not_know_is_named(tmp_path, capsys):
    grid(tmp_path / "flow.vtu", piece(POINTS, QUADS, FLOW))
    text = (tmp_path / "flow.vtu").read_text()
    (tmp_path / "flow.vtu").write_text(text.replace(" version", ' compressor="vtkLZ4DataCompressor" version'))
    with pytest.raises(BadInput, match="compressed by LZ4"):
        said(tmp_path, capsys, "flow.vtu")
    (tmp_path / "flow.vtk").write_text("# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n")
    with pytest.raises(BadInput, match="of the kind POLYDATA"):
        said(tmp_path, capsys, "flow.vtk")
    (tmp_path / "flow.pvd").write_text('<VTKFile><Collection><DataSet timestep="nan" file="flow.vtu"/></Collection></VTKFile>')
    with pytest.raises(BadInput, match="a time is no finite number"):
        said(tmp_path, capsys, "flow.pvd")


@pytest.mark.parametrize("name", ["a.vtu", "a.vtk"])
@pytest.mark.parametrize("deep", [False, True])
def test_cells_of_an_image_are_quadrilaterals(tmp_path, capsys, name, deep):
    """Pixels and voxels of VTK, whose corners go row by row."""
    if deep:
        above = np.column_stack([QUADS, QUADS + len(X)])[:, [0, 1, 3, 2, 4, 5, 7, 6]]
        cells, points = ("hexahedron", above), np.concatenate([POINTS, POINTS + [0, 0, 1]])
        flow, kinds = np.tile(FLOW, (2, 1)), "12"
    else:
        cells, points, flow, kinds = ("quad", QUADS[:, [0, 1, 3, 2]]), POINTS, FLOW, "9"
    form = {"file_format": "vtk42"} if name.endswith("vtk") else {}
    meshio.Mesh(points, [cells], {"U": flow}).write(tmp_path / name, binary=False, **form)
    text, image = (tmp_path / name).read_text(), {"9": "8", "12": "11"}[kinds]
    begin = re.search(r"CELL_TYPES \d+|<DataArray [^>]*Name=.types.[^>]*>", text).end()
    end = begin + re.search(r"[A-Za-z<]", text[begin:]).start()
    (tmp_path / name).write_text(text[:begin] + re.sub(rf"\b{kinds}\b", image, text[begin:end]) + text[end:])
    capsys.readouterr()  # a warning of meshio, which wrote the file
    judged(tmp_path, capsys, name)
