"""A plane flow from a .vtu or .vtk file, or from the files that a .pvd lists.

Taken are plane cells (triangles, quadrilaterals, polygons; of second-order ones the corners), or 3-D cells that are one cell deep
between two planes across x, y or z, of which the face in the lower plane counts. Values at points are taken before those in cells.
Pieces of a file are one mesh (tools/flow/pieces.py), joined where they meet (tools/flow/seams.py).
"""
import contextlib
import io
import itertools
import math
import re
import xml.etree.ElementTree
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from tools.base.command import BadInput
from tools.flow import pieces
from tools.flow.given import THIRD_MOST, Given, chosen_times, named, require_finite, unused
from tools.flow.seams import joined

CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
# the faces of 3-D cells, in VTK's order of corners
FACES = {"hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
         "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))}
SOLID = (*FACES, "tetra", "pyramid", "hexahedron20", "hexahedron27", "wedge15", "tetra10", "pyramid13", "polyhedron")
FLAT = 1e-6  # of the size of a domain: below it a direction has no extent


def listed(path, times):
    """[(time, file)] that --times picks of a .pvd. Raises BadInput."""
    try:
        root = xml.etree.ElementTree.parse(path).getroot()
        rows = sorted((float(one.get("timestep") or 0), one.get("file")) for one in root.iter("DataSet"))
    except (OSError, xml.etree.ElementTree.ParseError, ValueError) as problem:
        raise BadInput(f"cannot read {path}: {problem}") from None
    if not rows:
        raise BadInput(f"{path} lists no files")
    if any(not math.isfinite(time) for time, _ in rows):
        raise BadInput(f"cannot read {path}: a time is no finite number")
    if any(time == later for (time, _), (later, _) in itertools.pairwise(rows)):
        raise BadInput(f"{path} lists several files of one time, parts of a mesh perhaps; one file for each time is taken "
            f"(in ParaView the filter Merge Blocks, then save as .vtu)")
    return [(rows[k][0], Path(path).parent / rows[k][1]) for k in chosen_times([time for time, _ in rows], times, str(path))]


def read(files, velocity, values):
    """The Given of [(time, file)]; velocity: --velocity; values: points, cells, or None (points where there are any). Raises
    BadInput."""
    flow = None
    for time, file in files:
        points, polygons, arrays, in_cells, rest = one_file(file, velocity, values)
        if flow is None:
            flow = Given(points, polygons, [], [], in_cells, unused=rest)
        elif (in_cells != flow.in_cells or points.shape != flow.points.shape or len(polygons) != len(flow.polygons)
                or not np.allclose(points, flow.points, rtol=0, atol=FLAT * np.ptp(points, axis=0).max())):
            raise BadInput(f"{file} has another mesh than {files[0][1]}; all times need the same")
        flow.times.append(time)
        flow.frames.append(arrays)
    return joined(flow, files[0][1])


def one_file(file, velocity, values):
    """(points (n, 2), polygons, {"u", "v", ...}, whether these are in the cells, what is unused) of a file. Raises BadInput."""
    if not Path(file).is_file():
        raise BadInput(f"cannot read the flow {file}: it is not there")
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            data = pieces.read(file)
    except BadInput:
        raise
    except (Exception, SystemExit) as problem:  # meshio ends the process on some bad files
        raise BadInput(f"cannot read the flow {file}: {why_not(file, problem)}") from None
    points = np.asarray(data.points, float)
    points = points if points.shape[1] == 3 else np.column_stack([points, 0 * points[:, 0]])
    require_finite({"the place of a point": points.ravel()}, str(file))
    every = corners_of(data.cells)
    solid = any(block.type.startswith(SOLID) for block in data.cells)
    polygons, kept, axes = sliced(points, data.cells, file) if solid else flat(points, data.cells, file)
    try:
        there = {name: np.asarray(array, float)[every] for name, array in turned(data.point_data, axes).items()}
        at_points = named(there, velocity, str(file), axes) if values != "cells" and there else None
    except BadInput:
        if values == "points" or not data.cell_data:
            raise
        at_points = None
    if at_points is None and not data.cell_data:
        raise BadInput(f"{file} has no {'velocities' if values is None else f'values in {values}'}")
    used = np.unique(np.concatenate(polygons))
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    polygons = [number[one] for one in polygons]
    at_points = at_points and {name: spread(array, every, len(points)) for name, array in at_points.items()}
    if solid and at_points is not None:
        require_plane(points[:, axes], used, at_points, file)
    if at_points is not None:
        return (points[used][:, axes], polygons, {name: array[used] for name, array in at_points.items()}, False,
            unused(data.point_data, data.cell_data))
    cells = {name: np.concatenate([np.asarray(part, float) for part in parts])[kept] for name, parts in data.cell_data.items()
        if all(np.ndim(part) == np.ndim(parts[0]) for part in parts)}
    return (points[used][:, axes], polygons, named(turned(cells, axes), velocity, str(file), axes), True,
        unused(data.cell_data, data.point_data))


def corners_of(blocks):
    """The points that cells have."""
    return np.unique(np.concatenate([np.concatenate([np.ravel(face) for cell in block.data for face in cell])
        if block.type.startswith("polyhedron") else np.ravel(block.data) for block in blocks] or [np.empty(0, int)]).astype(int))


def spread(values, places, n):
    """An array (n,) with values at places, 0 elsewhere."""
    found = np.zeros(n)
    found[places] = values
    return found


def why_not(file, problem):
    """What is wrong with a file that its reader does not take."""
    head = Path(file).read_bytes()[:2000]
    if b"vtkLZ4DataCompressor" in head:
        return "it is compressed by LZ4; write it with the compressor ZLib, or with none"
    other = re.search(rb"^DATASET\s+(\w+)|VTKFile\s+type=.(\w+)", head, re.MULTILINE)
    kind = (other[1] or other[2]).decode() if other else ""
    if kind and kind not in ("UNSTRUCTURED_GRID", "UnstructuredGrid"):
        return f"its grid is of the kind {kind}; write an unstructured one (in ParaView the filter Append Datasets makes it)"
    return f"it is no whole file of its kind ({type(problem).__name__})"


def require_plane(points, used, arrays, file):
    """Raises BadInput where velocities at points of the lower plane (used, of points (n, 2)) and above them differ."""
    above = np.setdiff1d(np.arange(len(points)), used)
    if not len(above):
        return
    tree = cKDTree(points[above])
    off, near = tree.query(points[used])
    pairs = off < FLAT * np.ptp(points, axis=0).max()
    speed = max(np.abs(arrays[name]).max() for name in "uv")
    apart = max(np.abs(arrays[name][used] - arrays[name][above[near]])[pairs].max(initial=0) for name in "uv")
    if apart > THIRD_MOST * speed:
        raise BadInput(f"{file} is a 3-D flow: between the two planes of its cells the velocity differs by up to {apart:.3g} m/s; "
            f"write a slice of it (in ParaView the filter Slice)")


def turned(arrays, axes):
    """The arrays with the components of vectors in the order of the plane: along it, along it, across."""
    order = [*axes, *({0, 1, 2} - set(axes))]
    return {name: array[:, order] if np.ndim(array) == 2 and np.shape(array)[1] == 3 else array for name, array in arrays.items()}


def flat(points, blocks, file):
    """(polygons, their places among all cells, axes of the plane) of plane cells."""
    polygons, kept, before = [], [], 0
    for block in blocks:
        count = CORNERS.get(block.type) or (np.shape(block.data)[1] if block.type.startswith("polygon") else 0)
        if count:
            polygons += list(np.asarray(block.data)[:, :count])
            kept.append(np.arange(before, before + len(block.data)))
        before += len(block.data)
    if not polygons:
        raise BadInput(f"{file} has no plane cells (triangles, quadrilaterals, polygons): "
            f"{', '.join(sorted({block.type for block in blocks})) or 'none at all'}")
    extent = np.ptp(points[np.concatenate(polygons)], axis=0)
    across = int(np.argmin(extent))
    if extent[across] > FLAT * extent.max():
        raise BadInput(f"{file} is a 3-D flow: its cells are plane, but lie in no plane across x, y or z")
    return polygons, np.concatenate(kept), [axis for axis in range(3) if axis != across]


def sliced(points, blocks, file):
    """The same of 3-D cells, one cell deep."""
    used = corners_of([block for block in blocks if block.type.startswith(SOLID)])
    size = np.ptp(points[used], axis=0).max()
    levels = [np.unique(np.round(points[used, axis] / (FLAT * size))) for axis in range(3)]
    across = next((axis for axis in (2, 1, 0) if len(levels[axis]) == 2), None)
    if across is None:
        raise BadInput(f"{file} is a 3-D flow: its cells are not one cell deep across x, y or z; write a slice of it (in ParaView "
            f"the filter Slice)")
    low = points[:, across] < 0.5 * (points[used, across].min() + points[used, across].max())
    polygons, kept, before = [], [], 0
    for block in blocks:
        if block.type.startswith("polyhedron"):
            cells = [[np.asarray(face) for face in cell] for cell in block.data]
        elif block.type in FACES:
            cells = [[cell[list(face)] for face in FACES[block.type]] for cell in np.asarray(block.data)]
        elif block.type.startswith(SOLID):
            raise BadInput(f"{file} is a 3-D flow: it has cells of the kind {block.type}, which are none of a mesh one cell deep")
        else:
            cells = []
        for place, cell in enumerate(cells):
            below = [face for face in cell if low[face].all()]
            if len(below) != 1:
                raise BadInput(f"{file} is a 3-D flow: a cell has {len(below)} faces in the lower of two planes")
            polygons.append(below[0])
            kept.append(before + place)
        before += len(block.data)
    return polygons, np.array(kept), [axis for axis in range(3) if axis != across]
