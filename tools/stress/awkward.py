"""Awkward meshes, made from good ones: renumbered, clockwise, with slivers, graded 100 to 1."""
import numpy as np

from tools.base.command import BadInput
from tools.meshing.plane_mesh import PlaneMesh, signed_areas

KINDS = ("plain", "renumbered", "clockwise", "slivers of 5 degrees", "slivers of 1 degree", "slivers of 0.1 degrees",
    "graded 10:1", "graded 100:1")


def spoiled(mesh, kind, seed=1):
    """A PlaneMesh on a regular grid, spoiled; lengths and labels of the boundary stay."""
    if kind == "renumbered":
        return renumbered_at_random(mesh, seed)
    if kind == "clockwise":
        return PlaneMesh(mesh.points, mesh.triangles[:, [0, 2, 1]], mesh.edges, mesh.edge_labels)
    if kind.startswith("slivers"):
        return with_slivers(mesh, float(kind.split()[2]), seed)
    if kind.startswith("graded"):
        return graded(mesh, float(kind.split()[1].split(":")[0]))
    raise BadInput(f"there is no awkward mesh of the kind {kind}; there are {', '.join(KINDS[1:])}")


def renumbered_at_random(mesh, seed):
    """Vertices, triangles and edges in random order, each triangle from a random corner."""
    draw = np.random.default_rng(seed)
    order = draw.permutation(len(mesh.points))
    place = np.argsort(order)
    triangles = place[mesh.triangles][draw.permutation(len(mesh.triangles))]
    start = draw.integers(0, 3, len(triangles))
    triangles = triangles[np.arange(len(triangles))[:, None], (start[:, None] + np.arange(3)) % 3]
    edges = draw.permutation(len(mesh.edges))
    return PlaneMesh(mesh.points[order], triangles, place[mesh.edges][edges], mesh.edge_labels[edges])


def with_slivers(mesh, degrees, seed, share=0.05):
    """A share of the inner vertices, no two of them neighbours, moved towards the middle of
    an opposite edge until the triangle there has angles of so many degrees."""
    points, triangles = mesh.points.copy(), mesh.triangles
    of = [[] for _ in points]
    for k, triangle in enumerate(triangles):
        for v in triangle:
            of[v].append(k)
    fixed = np.zeros(len(points), bool)
    fixed[mesh.edges.ravel()] = True
    moved = 0
    for v in np.random.default_rng(seed).permutation(len(points)):
        around = np.unique(triangles[of[v]])
        if moved >= share * len(points):
            break
        if fixed[around].any():
            continue
        a, b = (w for w in triangles[of[v][0]] if w != v)
        middle, old = 0.5 * (points[a] + points[b]), points[v].copy()
        height = 0.5 * np.linalg.norm(points[a] - points[b]) * np.tan(np.radians(degrees))
        points[v] = middle + (old - middle) * height / np.linalg.norm(old - middle)
        if signed_areas(points, triangles[of[v]]).min() <= 0:
            points[v] = old
            continue
        fixed[around] = True
        moved += 1
    return PlaneMesh(points, triangles, mesh.edges, mesh.edge_labels)


def graded(mesh, ratio):
    """A regular grid drawn towards its sides: the cells at the sides `ratio` times smaller
    than the largest, in both directions."""
    points = mesh.points.copy()
    for axis in (0, 1):
        low, high = points[:, axis].min(), points[:, axis].max()
        places, index = np.unique(np.round((points[:, axis] - low) / (high - low), 9), return_inverse=True)
        off = np.abs(places[1:] + places[:-1] - 1)  # from the middle of the side
        cells = ratio ** -((off - off.min()) / np.ptp(off)) * np.diff(places)
        points[:, axis] = low + (high - low) * (np.concatenate([[0.0], np.cumsum(cells)]) / cells.sum())[index]
        points[np.isclose(points[:, axis], high), axis] = high
    return PlaneMesh(points, mesh.triangles, mesh.edges, mesh.edge_labels)
