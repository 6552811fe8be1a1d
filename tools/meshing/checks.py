"""Checks of a mesh before it is written, and the report of its quality."""
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from tools.meshing.labels import NAMES
from tools.meshing.plane_mesh import CORNERS, edges_of, keys_of, signed_areas, smallest_angles

LEAST_ANGLE = 5.0  # degrees; below it a triangle counts as a sliver


def faults(mesh, outline, tolerance=1e-9, least_angle=LEAST_ANGLE):
    """What is wrong with a mesh of this outline (None: unknown): a list of sentences, empty when nothing is. least_angle: degrees."""
    found = []
    if not np.all(np.isfinite(mesh.points)):
        return ["a coordinate is not a finite number"]
    areas = signed_areas(mesh.points, mesh.triangles)
    if areas.min() <= 0:
        found.append(f"{np.sum(areas <= 0)} triangles are inverted or have no area")
    angle = smallest_angles(mesh.points, mesh.triangles).min()
    if angle < least_angle:
        found.append(f"a triangle has an angle of {angle:.3g} degrees (least allowed: {least_angle:g})")
    if outline and not np.isclose(areas.sum(), outline.area(), rtol=tolerance, atol=0):
        found.append(f"the triangles cover {areas.sum():.12g}, the domain is {outline.area():.12g}")
    if len(np.unique(mesh.triangles)) != len(mesh.points):
        found.append("a vertex belongs to no triangle")
    pieces = pieces_of(mesh.triangles)
    if pieces > 1:
        found.append(f"the triangles make {pieces} pieces that share no side (a common vertex does not join them): join the "
            f"surfaces (in gmsh BooleanFragments or Coherence), or mesh one")

    edges, count = edges_of(mesh.triangles)
    over = folded(mesh.triangles)
    if len(over):
        x, y = mesh.points[mesh.triangles[over[0]]].mean(axis=0)
        found.append(f"triangles lie on each other, one of them at ({x:g}, {y:g}): a vertex is misplaced, or a triangle stands "
            "twice")
    elif count.max() > 2:
        found.append("an edge belongs to more than two triangles")
    boundary = np.unique(np.sort(edges[count == 1], axis=1), axis=0)
    labelled = np.unique(np.sort(mesh.edges, axis=1), axis=0)
    if len(labelled) != len(mesh.edges) or not np.array_equal(boundary, labelled):
        found.append("the labelled edges are not the boundary edges of the triangles")
    if np.any(mesh.edge_labels == 0):
        found.append(f"{np.sum(mesh.edge_labels == 0)} boundary edges lie on no side of the domain")
    lengths = np.linalg.norm(np.diff(mesh.points[mesh.edges], axis=1)[:, 0], axis=1)
    for label, expected in (outline.lengths() if outline else {}).items():
        there = lengths[mesh.edge_labels == label].sum()
        if not np.isclose(there, expected, rtol=tolerance, atol=0):
            found.append(f"edges labelled {NAMES[label]} sum to {there:.12g}, its sides to {expected:.12g}")
    return found


def slivers(mesh):
    """How many triangles count as slivers."""
    return int(np.sum(smallest_angles(mesh.points, mesh.triangles) < LEAST_ANGLE))


def folded(triangles):
    """Numbers of the triangles (m, 3), all counter-clockwise, that lie on another: they go along a side in its direction."""
    sides = np.concatenate([triangles[:, pair] for pair in CORNERS]).astype(np.int64)
    _, side, count = np.unique(sides[:, 0] * (sides.max(initial=0) + 1) + sides[:, 1], return_inverse=True, return_counts=True)
    return np.unique(np.flatnonzero(count[side.ravel()] > 1) % len(triangles))


def pieces_of(triangles):
    """How many pieces the triangles (m, 3) make that share no side: no fluid passes through a common vertex."""
    sides = np.concatenate([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    _, side = np.unique(keys_of(sides), return_inverse=True)
    triangle = np.tile(np.arange(len(triangles)), 3)
    order = np.argsort(side.ravel(), kind="stable")
    joined = np.flatnonzero(np.diff(side.ravel()[order]) == 0)
    pair = triangle[order[joined]], triangle[order[joined + 1]]
    number, _ = connected_components(coo_matrix((np.ones(len(joined)), pair), shape=(len(triangles),) * 2), directed=False)
    return number


def summary(mesh):
    """Numbers of a mesh in a few lines: sizes, labels, angles."""
    angles = smallest_angles(mesh.points, mesh.triangles)
    edges, _ = edges_of(mesh.triangles)
    lengths = np.linalg.norm(np.diff(mesh.points[edges], axis=1)[:, 0], axis=1)
    labels = ", ".join(
        f"{mesh.names.get(label) or NAMES.get(label, 'label')} ({label}) {np.sum(mesh.edge_labels == label)}"
        for label in np.unique(mesh.edge_labels)
    )
    return (
        f"{len(mesh.points)} vertices, {len(mesh.triangles)} triangles, edges {lengths.min():.4g} to {lengths.max():.4g}\n"
        f"boundary edges: {labels}\n"
        f"smallest angle: {angles.min():.1f} degrees (mean over the triangles {angles.mean():.1f})"
    )


def histogram(mesh, width=50):
    """The smallest angles of the triangles, in bins of 5 degrees, as lines of text."""
    angles = smallest_angles(mesh.points, mesh.triangles)
    numbers, bounds = np.histogram(angles, bins=np.arange(0, 61, 5))
    lines = ["smallest angle of a triangle, degrees: number of triangles"]
    for number, low in zip(numbers, bounds):
        bar = "#" * int(np.ceil(width * number / numbers.max()))
        lines.append(f"{low:3.0f}-{low + 5:<3.0f}{number:8d} {bar}")
    return "\n".join(lines)
