"""Plane triangle meshes and P1 fields on them, as FreeFEM writes them.

Reads the medit form (.mesh) with boundary labels, and .vtu files of savevtk, binary or
ascii. Errors: BadInput naming the file.
"""
import contextlib
import io
import re
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from tools.base.command import BadInput

# Numbers of tools/meshing/labels.py.
SIDES = {1: "inlet", 2: "outlet", 11: "left", 12: "right", 13: "bottom", 14: "top"}  # names of sides that fluid may pass
OPEN = (1, 2)  # labels through which fluid passes
AXIS = 8  # label of an axis or a plane of symmetry
SOLID = (4, 5, 6)  # labels of bodies that stand in the flow


@dataclass
class Mesh:
    """points (n, 2) in the case's length unit, triangles (m, 3), edges (k, 2) with labels (k,)."""
    points: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    labels: np.ndarray


def read_mesh(path):
    """The Mesh of a plane medit file, of FreeFEM's savemesh or of meshio. Edges with triangles on both sides are no sides and are
    left out."""
    words = words_of(path)
    try:
        vertices, _ = section(words, "Vertices", 2, float)
        triangles, _ = section(words, "Triangles", 3, int)
        edges, labels = section(words, "Edges", 2, int)
        if words[words.index("Dimension") + 1] != "2" or not len(triangles):
            raise ValueError
        if not np.isfinite(vertices).all():
            raise ValueError
        if min(triangles.min(), edges.min(initial=1)) < 1 or max(triangles.max(), edges.max(initial=1)) > len(vertices):
            raise ValueError
    except (ValueError, IndexError):
        raise BadInput(f"{path} is not a whole plane medit mesh with Vertices, Edges and Triangles") from None
    sides, count = np.unique(np.sort(np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1), axis=0,
        return_counts=True)
    inner = set(map(tuple, sides[count > 1]))
    outer = np.array([tuple(edge) not in inner for edge in np.sort(edges, axis=1)], bool)
    return Mesh(vertices, triangles - 1, edges[outer] - 1, labels[outer])


def words_of(path):
    """The words of a medit file, without comments and quoted texts."""
    try:
        return re.sub(r'"[^"]*"', " ", re.sub(r"#.*", " ", Path(path).read_text(encoding="utf-8"))).split()
    except (OSError, UnicodeDecodeError) as problem:
        raise BadInput(f"cannot read the mesh {path}: {problem}") from None


def section(words, keyword, width, kind):
    """A section's (count, width) entries and their labels. Raises ValueError or IndexError where it is not whole."""
    if keyword not in words:
        return np.empty((0, width), kind), np.empty(0, int)
    at = words.index(keyword) + 1
    count = int(words[at])
    rows = np.array(words[at + 1:at + 1 + count * (width + 1)], dtype=object).reshape(count, width + 1)
    return rows[:, :width].astype(kind), rows[:, width].astype(float).astype(int)


def read_vtu(path):
    """The meshio.Mesh of a .vtu file."""
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return meshio.read(path)
    except (Exception, SystemExit):  # meshio ends the process on some bad files
        raise BadInput(f"cannot read the field {path}: it is not a whole .vtu file") from None


def read_field(path):
    """(Mesh without edges, {"velocity": (n, 2), ...}) of a .vtu; scalars have shape (n,)."""
    data = read_vtu(path)
    triangles = [block.data for block in data.cells if block.type == "triangle"]
    if not triangles:
        raise BadInput(f"{path} holds no triangles")
    mesh = Mesh(np.asarray(data.points[:, :2], float), np.concatenate(triangles),
                np.empty((0, 2), int), np.empty(0, int))
    values = {}
    for name, array in data.point_data.items():
        array = np.asarray(array, float)
        if array.ndim == 2:
            array = array[:, 0] if array.shape[1] == 1 else array[:, :2]
        values[name] = array
    return mesh, values


def chains(edges):
    """The edges joined to polylines of vertex numbers (closed ones end where they began),
    so that a dashed or thick line is drawn whole."""
    ends = {}
    for k, (a, b) in enumerate(edges):
        ends.setdefault(int(a), []).append(k)
        ends.setdefault(int(b), []).append(k)
    unused = np.ones(len(edges), bool)
    lines = []
    starts = [v for v, touching in ends.items() if len(touching) != 2] + list(ends)
    for start in starts:
        for k in ends[start]:
            if not unused[k]:
                continue
            line, at = [start], start
            while k is not None:
                unused[k] = False
                a, b = edges[k]
                at = int(b) if int(a) == at else int(a)
                line.append(at)
                following = [m for m in ends[at] if unused[m]]
                k = following[0] if following and len(ends[at]) == 2 else None
            lines.append(np.array(line))
    return lines
