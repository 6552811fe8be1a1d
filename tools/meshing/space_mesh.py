"""Meshes of tetrahedra: their checks, their order, and the medit form that FreeFEM's readmesh3 reads with labels."""
from pathlib import Path

import meshio
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from tools.base.command import BadInput
from tools.base.space_mesh import SpaceMesh
from tools.meshing.labels import NAMES
from tools.meshing.medit import store

# The six tetrahedra of a cell whose corners are numbered x + 2 y + 4 z: each path along the axes from corner 0 to corner 7 (Kuhn).
MOST_CELLS = 2_000_000  # cubes of the element size, some six tetrahedra each
KUHN = np.array([[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]])


def volumes(points, tetrahedra):
    a, b, c, d = (points[tetrahedra[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6


def outer_faces(tetrahedra):
    """The faces (k, 3) that belong to one tetrahedron only."""
    faces = np.concatenate([tetrahedra[:, list(c)] for c in ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def spread(bits):
    """The bits of whole numbers below 2^20, two zeros after each (for a Morton curve)."""
    out = np.zeros_like(bits)
    for k in range(20):
        out |= ((bits >> np.uint64(k)) & np.uint64(1)) << np.uint64(3 * k)
    return out


def ordered(points, tetrahedra):
    """Points and tetrahedra sorted along a Morton curve, in which neighbours are close in memory; positive volumes."""
    centres = points[tetrahedra].mean(axis=1)
    scaled = ((centres - points.min(axis=0)) / np.ptp(points, axis=0).max() * 1023).astype(np.uint64)
    key = spread(scaled[:, 0]) | spread(scaled[:, 1]) << np.uint64(1) | spread(scaled[:, 2]) << np.uint64(2)
    tetrahedra = tetrahedra[np.argsort(key, kind="stable")]
    used, first = np.unique(tetrahedra.ravel(), return_index=True)
    used = used[np.argsort(first)]
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points, tetrahedra = points[used], number[tetrahedra]
    turned = volumes(points, tetrahedra) < 0
    tetrahedra[turned] = tetrahedra[turned][:, [1, 0, 2, 3]]
    return points, tetrahedra


def finished(points, tetrahedra, label_of):
    """The SpaceMesh; label_of(centres (k, 3), normals) gives the labels of the outer faces."""
    points, tetrahedra = ordered(np.asarray(points, dtype=float), np.asarray(tetrahedra))
    triangles = outer_faces(tetrahedra)
    return SpaceMesh(points, tetrahedra, triangles, np.asarray(label_of(points[triangles].mean(axis=1))))


# The sizes of elements come from fields alone; the algorithm HXT.
SIZES_OF_FIELDS = {"Mesh.MeshSizeExtendFromBoundary": 0, "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.Algorithm3D": 10}


def refuse_too_many(*parts):
    """Raises BadInput where the parts of a domain, each (volume, size of its elements), would make far too many tetrahedra."""
    cells = sum(volume / size**3 for volume, size in parts)
    if cells > MOST_CELLS:
        raise BadInput(f"these sizes would make about {6 * cells:.1e} tetrahedra; at most {6 * MOST_CELLS:.1e} are made: ask for "
            "larger elements")


def filled(gmsh, label_of):
    """The SpaceMesh of the volumes of gmsh's model, whose size field is set; label_of as in finished()."""
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("Netgen")
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, corners = gmsh.model.mesh.getElementsByType(4)
    place = np.zeros(int(tags.max()) + 1, dtype=int)
    place[tags.astype(int)] = np.arange(len(tags))
    return finished(coordinates.reshape(-1, 3), place[corners.astype(int)].reshape(-1, 4), label_of)


def with_image(points, tetrahedra, axis, at):
    """Points (n, 3) and tetrahedra (m, 4) with their mirror image at the plane `axis` = at, on which points are taken once."""
    image = points.copy()
    image[:, axis] = 2 * at - image[:, axis]
    new = np.abs(points[:, axis] - at) > 1e-9 * np.ptp(points[:, axis])
    number = np.where(new, len(points) + np.cumsum(new) - 1, np.arange(len(points)))
    return np.concatenate([points, image[new]]), np.concatenate([tetrahedra, number[tetrahedra]])


def boxes(xs, ys, zs, label_of, keep=None):
    """A mesh of the cells of a grid (increasing coordinates), six tetrahedra a cell; keep(centres): which cells are there."""
    shape = (len(xs), len(ys), len(zs))
    refuse_too_many((np.prod(shape, dtype=float), 1.0))
    points = np.stack(np.meshgrid(xs, ys, zs, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(shape)
    corners = np.stack([number[i:shape[0] - 1 + i, j:shape[1] - 1 + j, k:shape[2] - 1 + k].ravel()
        for k in (0, 1) for j in (0, 1) for i in (0, 1)], axis=1)
    if keep is not None:
        corners = corners[keep(points[corners].mean(axis=1))]
    return finished(points, corners[:, KUHN].reshape(-1, 4), label_of)


def faults(mesh):
    """What is wrong with a mesh, as a list of sentences; empty for a good one."""
    found = []
    size = volumes(mesh.points, mesh.tetrahedra)
    if not size.min() > 1e-9 * size.max():
        found.append("it has flat or inverted tetrahedra")
    if (np.asarray(mesh.labels) <= 0).any():
        found.append("sides of it have no label")
    pieces = pieces_of(mesh.tetrahedra)
    if pieces > 1:
        found.append(f"the tetrahedra make {pieces} pieces that share no side: join the volumes (in gmsh BooleanFragments or "
            f"Coherence), or mesh one")
    return found


def pieces_of(tetrahedra):
    """Number of parts of a mesh between which no face is shared."""
    n = len(tetrahedra)
    faces = np.sort(np.concatenate([tetrahedra[:, list(c)] for c in ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))]), axis=1)
    _, side = np.unique(faces, axis=0, return_inverse=True)
    sides = side.max() + 1
    joins = coo_matrix((np.ones(4 * n, bool), (np.tile(np.arange(n), 4), n + side.ravel())), shape=(n + sides, n + sides))
    return connected_components(joins, directed=False)[0]


def quality(mesh):
    """Radius of the inscribed sphere over that of the circumscribed one, times 3, of each tetrahedron: 1 where it is regular."""
    a, b, c, d = (mesh.points[mesh.tetrahedra[:, k]] for k in range(4))
    length = [np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (c, d), (a, c), (b, d), (a, d), (b, c))]
    products = [length[0] * length[1], length[2] * length[3], length[4] * length[5]]
    half = sum(products) / 2
    volume = np.abs(volumes(mesh.points, mesh.tetrahedra))
    around = np.sqrt(np.maximum(half * (half - products[0]) * (half - products[1]) * (half - products[2]), 0)) / (6 * volume)
    area = sum(np.linalg.norm(np.cross(q - p, r - p), axis=1) / 2 for p, q, r in ((a, b, c), (a, b, d), (a, c, d), (b, c, d)))
    return 9 * volume / area / around


def summary(mesh):
    names = NAMES | mesh.names
    kinds = ", ".join(f"{names.get(label, label)} ({label}) {np.sum(mesh.labels == label)}" for label in np.unique(mesh.labels))
    return (f"{len(mesh.points)} vertices, {len(mesh.tetrahedra)} tetrahedra, triangles of the boundary: {kinds}; "
            f"least quality {quality(mesh).min():.2f}")


def write(mesh, file):
    """Writes a SpaceMesh to a .mesh file, whole or not at all; folders are made. Raises BadInput when that fails."""
    file = Path(file)
    content = meshio.Mesh(
        mesh.points,
        [("triangle", mesh.triangles), ("tetra", mesh.tetrahedra)],
        point_data={"medit:ref": np.zeros(len(mesh.points), dtype=int)},
        cell_data={"medit:ref": [mesh.labels.astype(int), np.zeros(len(mesh.tetrahedra), dtype=int)]},
    )
    store(content, file, mesh.names, "Dimension 3\n", ".10g")
