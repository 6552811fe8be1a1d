"""Meshes of tetrahedra, P1 fields on them, and their sections by a plane.

Reads the medit form (.mesh, Dimension 3) with boundary labels, and .vtu files of savevtk. Errors: BadInput naming the file.
"""
import re
from dataclasses import dataclass, field

import numpy as np

from tools.base.command import BadInput
from tools.base.mesh_files import Mesh, read_vtu, section, words_of

SNAP = 1e-9  # of the domain's size: vertices this close to a plane lie on it
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])  # of a tetrahedron, by the numbers of its corners


@dataclass
class SpaceMesh:
    """points (n, 3) in the case's length unit, tetrahedra (m, 4), triangles (k, 3) of the boundary with labels (k,); names
    {label: name} of sides with names of one's own."""
    points: np.ndarray
    tetrahedra: np.ndarray
    triangles: np.ndarray
    labels: np.ndarray
    names: dict = field(default_factory=dict)


def dimension_of(path):
    """The dimension that the head of a medit file names, 0 where it names none or there is no such file."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            found = re.search(r"^\s*Dimension\s+(\d+)", stream.read(2000), flags=re.M)
    except OSError:
        return 0
    return int(found.group(1)) if found else 0


def read_space_mesh(path):
    """The SpaceMesh of a three-dimensional medit file."""
    words = words_of(path)
    try:
        points, _ = section(words, "Vertices", 3, float)
        tetrahedra, _ = section(words, "Tetrahedra", 4, int)
        triangles, labels = section(words, "Triangles", 3, int)
        if not len(tetrahedra) or not np.isfinite(points).all():
            raise ValueError
        if min(tetrahedra.min(), triangles.min(initial=1)) < 1 or max(tetrahedra.max(), triangles.max(initial=1)) > len(points):
            raise ValueError
    except (ValueError, IndexError):
        raise BadInput(f"{path} is not a whole three-dimensional medit mesh with Vertices, Tetrahedra and Triangles") from None
    return SpaceMesh(points, tetrahedra - 1, triangles - 1, labels)


def read_space_field(path):
    """(SpaceMesh without triangles, {"velocity": (n, 3), ...}) of a .vtu; scalars have shape (n,)."""
    data = read_vtu(path)
    tetrahedra = [block.data for block in data.cells if block.type == "tetra"]
    if not tetrahedra:
        raise BadInput(f"{path} holds no tetrahedra")
    mesh = SpaceMesh(np.asarray(data.points, float), np.concatenate(tetrahedra), np.empty((0, 3), int), np.empty(0, int))
    values = {}
    for name, array in data.point_data.items():
        array = np.asarray(array, float)
        values[name] = array[:, 0] if array.ndim == 2 and array.shape[1] == 1 else array
    return mesh, values


class Section:
    """The section of a SpaceMesh by the plane x, y or z (axis 0, 1, 2) = at: `mesh`, a plane Mesh in the other two coordinates,
    and of(values), nodal values of the SpaceMesh in its points. A plane that is a side of the domain cuts that side out. Raises
    BadInput where the plane meets no tetrahedron.

    Marching tetrahedra: an edge whose ends lie on either side of the plane has a point of the section at
    (1 - w) a + w b, w = d_a/(d_a - d_b), d the distance of an end; a tetrahedron with one corner on its side gives a triangle,
    with two a quadrangle, which is halved. The triangles stand in order of their area: a picture draws each a little wider than it
    is, so that the larger ones hide slivers.
    """

    def __init__(self, space, axis, at):
        self.axis, self.at = axis, float(at)
        distance = space.points[:, axis] - self.at
        distance[abs(distance) < SNAP * np.ptp(space.points, axis=0).max()] = 0
        # vertices on the plane belong to the side that is nearer, so that a side of the domain is found by its neighbours
        low, high = distance.min(), distance.max()
        above = distance > 0 if low + high > 0 else distance >= 0
        # the edges that the plane cuts, each once; one with an end on the plane stands for this end
        sides = np.concatenate([np.sort(space.tetrahedra[:, pair], axis=1) for pair in EDGES])
        sides = np.unique(sides[above[sides[:, 0]] != above[sides[:, 1]]], axis=0)
        if not len(sides):
            raise BadInput(f"the plane {'xyz'[axis]} = {at:g} does not meet the mesh, which lies between "
                f"{space.points[:, axis].min():g} and {space.points[:, axis].max():g}")
        ends = sides.copy()
        for k in (0, 1):
            on = distance[sides[:, k]] == 0
            ends[on] = sides[on, k][:, None]
        points, place = np.unique(ends, axis=0, return_inverse=True)
        number = len(space.points)
        keys, place = sides[:, 0] * number + sides[:, 1], place.ravel()

        def point_of(a, b):
            """The numbers of the points on edges (a, b)."""
            return place[np.searchsorted(keys, np.minimum(a, b) * number + np.maximum(a, b))]
        self._a, self._b = points.T
        with np.errstate(invalid="ignore", divide="ignore"):
            w = distance[self._a] / (distance[self._a] - distance[self._b])
        self._w = np.where(self._a == self._b, 0.0, w)
        triangles = np.concatenate(list(self._triangles(space.tetrahedra, above, point_of)))
        lines, labels = self._lines(space.triangles, space.labels, above, point_of)
        self.across = [k for k in range(3) if k != axis]
        self.mesh = by_area(Mesh(self.of(space.points)[:, self.across], distinct(triangles), lines, labels))

    def of(self, values):
        """Nodal values (n, ...) of the SpaceMesh, linear on the edges, in the points of the section."""
        w = self._w.reshape(-1, *[1] * (np.ndim(values) - 1))
        return (1 - w) * values[self._a] + w * values[self._b]

    @staticmethod
    def _triangles(tetrahedra, above, point_of):
        """The triangles in which the plane cuts tetrahedra."""
        up = above[tetrahedra]
        for count in (1, 3):  # the corner that is alone, and the other three
            cut = up.sum(axis=1) == count
            order = np.argsort(up[cut] if count == 3 else ~up[cut], axis=1, kind="stable")
            one = np.take_along_axis(tetrahedra[cut], order, axis=1)
            yield np.column_stack([point_of(one[:, 0], one[:, k]) for k in (1, 2, 3)])
        cut = up.sum(axis=1) == 2
        a, b, c, d = np.take_along_axis(tetrahedra[cut], np.argsort(up[cut], axis=1, kind="stable"), axis=1).T
        ring = [point_of(a, c), point_of(a, d), point_of(b, d), point_of(b, c)]
        yield np.column_stack(ring[:3])
        yield np.column_stack([ring[0], *ring[2:]])

    @staticmethod
    def _lines(triangles, labels, above, point_of):
        """The edges in which the plane cuts triangles of the boundary, and their labels."""
        up = above[triangles]
        cut = (up.sum(axis=1) == 1) | (up.sum(axis=1) == 2)
        up, one = up[cut], triangles[cut]
        alone = np.argmax(up == (up.sum(axis=1) == 1)[:, None], axis=1)
        a, b, c = (one[np.arange(len(one)), (alone + k) % 3] for k in range(3))
        lines = np.column_stack([point_of(a, b), point_of(a, c)]).reshape(-1, 2)
        long = lines[:, 0] != lines[:, 1]
        return lines[long], labels[cut][long]


def distinct(triangles):
    """The triangles with three different corners."""
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def by_area(mesh):
    """A plane Mesh with its triangles in order of their area."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    (u, v), (p, q) = (b - a).T, (c - a).T
    return Mesh(mesh.points, mesh.triangles[np.argsort(abs(u * q - v * p))], mesh.edges, mesh.labels)
