"""Files of VTK in several pieces: of a .vtu each <Piece>, of a .pvtu each file that it lists.

The reader (meshio) takes the last <Piece> of a .vtu alone, so each is read from a copy of the file without the others.
"""
import re
import tempfile
import xml.etree.ElementTree
from pathlib import Path

import meshio
import numpy as np
from meshio._common import num_nodes_per_cell
from meshio._mesh import topological_dimension
from meshio._vtk_common import vtk_to_meshio_type
from meshio.vtk import _vtk_42
from meshio.vtu._vtu import _parse_raw_binary

from tools.base.command import BadInput

PADDED = re.compile(rb"offset=([\"'])\s*(\d+)\s*\1")  # numbers in a field of blanks, which the reader does not find
# Cells of an image or a rectilinear grid, and what they are with their corners in the usual order; the reader knows neither.
STRAIGHT = {"pixel": ("quad", [0, 1, 3, 2]), "voxel": ("hexahedron", [0, 1, 3, 2, 4, 5, 7, 6])}
vtk_to_meshio_type.update({8: "pixel", 11: "voxel"})
_vtk_42.vtk_type_to_numnodes[[8, 11]] = 4, 8
num_nodes_per_cell.update(pixel=4, voxel=8)
topological_dimension.update(pixel=2, voxel=3)
GHOST = "vtkghosttype"  # of a cell: not 0 where another piece has it too, or where it is hidden


def read(path):
    """The meshio.Mesh of a .vtu, .vtk or .pvtu, all of its pieces in one, each cell once. Raises BadInput, and what meshio
    raises."""
    if Path(path).suffix.lower() == ".pvtu":
        files = listed(path)
        return cleaned(together([read(file) for file in files], path))
    if Path(path).suffix.lower() == ".vtk":
        return cleaned(meshio.read(path, file_format="vtk"))
    head, mark, rest = Path(path).read_bytes().partition(b"<AppendedData")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "piece.vtu"
        copy.write_bytes(PADDED.sub(rb'offset="\2"', head) + mark + rest)
        try:
            root = xml.etree.ElementTree.parse(copy).getroot()
        except xml.etree.ElementTree.ParseError:
            root = _parse_raw_binary(str(copy))
        grid, found = root.find("UnstructuredGrid"), []
        parts = [] if grid is None else grid.findall("Piece")
        if len(parts) < 2:
            return cleaned(meshio.read(copy, file_format="vtu"))
        for part in parts:
            grid.remove(part)
        for part in parts:
            if part.get("NumberOfCells") != "0":
                grid.append(part)
                xml.etree.ElementTree.ElementTree(root).write(copy)
                found.append(meshio.read(copy, file_format="vtu"))
                grid.remove(part)
        return cleaned(together(found, path))


def listed(path):
    """The files of a .pvtu. Raises BadInput."""
    try:
        root = xml.etree.ElementTree.parse(path).getroot()
    except (OSError, xml.etree.ElementTree.ParseError) as problem:
        raise BadInput(f"cannot read {path}: {problem}") from None
    files = [Path(path).parent / one.get("Source", "") for one in root.iter("Piece")]
    for file in files:
        if file.suffix.lower() != ".vtu" or not file.is_file():
            raise BadInput(f"cannot read {file}, a piece of the flow {path}: it is no .vtu, or not there")
    if not files:
        raise BadInput(f"{path} lists no files")
    return files


def shifted(block, by):
    """A block of cells whose numbers of points are larger by `by`."""
    data = [[np.asarray(face) + by for face in cell] for cell in block.data] if block.type.startswith("polyhedron") \
        else np.asarray(block.data) + by
    return meshio.CellBlock(block.type, data)


def together(meshes, path):
    """One meshio.Mesh of several. Raises BadInput where they have other arrays."""
    meshes = [mesh for mesh in meshes if mesh.cells]
    if not meshes:
        raise BadInput(f"{path} has no cells")
    for kind in ("point_data", "cell_data"):
        if any(set(getattr(mesh, kind)) != set(getattr(meshes[0], kind)) for mesh in meshes):
            raise BadInput(f"{path}: its pieces do not have the same arrays")
    before = np.cumsum([0] + [len(mesh.points) for mesh in meshes])
    return meshio.Mesh(np.concatenate([mesh.points for mesh in meshes]),
        [shifted(block, by) for mesh, by in zip(meshes, before) for block in mesh.cells],
        {name: np.concatenate([mesh.point_data[name] for mesh in meshes]) for name in meshes[0].point_data},
        {name: [part for mesh in meshes for part in mesh.cell_data[name]] for name in meshes[0].cell_data})


def cleaned(mesh):
    """The mesh without cells that are marked as another piece's, or as hidden, and with usual cells for those of images."""
    for block in mesh.cells:
        if block.type in STRAIGHT:
            block.type, order = STRAIGHT[block.type]
            block.data = np.asarray(block.data)[:, order]
    name = next((name for name in mesh.cell_data if name.lower() == GHOST), None)
    if name is None:
        return mesh
    keep = [np.ravel(part) == 0 for part in mesh.cell_data[name]]
    blocks = [meshio.CellBlock(block.type, [cell for cell, kept in zip(block.data, mask) if kept]
        if block.type.startswith("polyhedron") else np.asarray(block.data)[mask]) for block, mask in zip(mesh.cells, keep)]
    some = [k for k, mask in enumerate(keep) if mask.any()]
    return meshio.Mesh(mesh.points, [blocks[k] for k in some], mesh.point_data,
        {other: [np.asarray(parts[k])[keep[k]] for k in some] for other, parts in mesh.cell_data.items()})
