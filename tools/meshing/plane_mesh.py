"""A plane triangle mesh with labelled boundary edges: orientation, labels, numbering."""
import heapq
from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

CORNERS = ((0, 1), (1, 2), (2, 0))


@dataclass
class PlaneMesh:
    """points (n, 2), triangles (m, 3) counter-clockwise, edges (k, 2) and their labels (k,); names: {label: a name of one's own}."""

    points: np.ndarray
    triangles: np.ndarray
    edges: np.ndarray
    edge_labels: np.ndarray
    names: dict = field(default_factory=dict)


def finished(points, triangles, labels_of):
    """A mesh made of points and triangles: oriented, corners freed, numbered, labelled by labels_of(points, boundary edges)."""
    triangles = oriented(points, triangles)
    triangles = with_free_corners(points, triangles)
    points, triangles = renumbered(points, triangles)
    edges, count = edges_of(triangles)
    edges = edges[count == 1]
    labels = labels_of(points, edges)
    order = np.lexsort((edges[:, 0], labels))
    return PlaneMesh(points, triangles, edges[order], labels[order])


def signed_areas(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def smallest_angles(points, triangles):
    """The smallest angle of each triangle, degrees."""
    corner = [points[triangles[:, k]] for k in range(3)]
    angles = []
    for k in range(3):
        u, v = corner[(k + 1) % 3] - corner[k], corner[(k + 2) % 3] - corner[k]
        cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
        angles.append(np.degrees(np.arctan2(np.abs(cross), np.sum(u * v, axis=1))))
    return np.min(angles, axis=0)


def oriented(points, triangles):
    """The triangles counter-clockwise."""
    triangles = np.array(triangles, dtype=int)
    clockwise = signed_areas(points, triangles) < 0
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    return triangles


def edges_of(triangles):
    """The edges, (n, 2) with the direction of a triangle they bound, and in how many triangles each is."""
    edges = np.concatenate([triangles[:, pair] for pair in CORNERS])
    _, first, count = np.unique(keys_of(edges), return_index=True, return_counts=True)
    return edges[first], count


def keys_of(edges):
    """A number for each edge (n, 2), whatever its direction; they are in order as the vertices of the edges, the smaller one
    first."""
    edges = np.asarray(edges, dtype=np.int64)
    return edges.min(axis=1) * (edges.max(initial=0) + 1) + edges.max(axis=1)


def on_two_sides(triangles):
    """Numbers of the triangles that have two edges on the boundary and one that another triangle shares, in ascending order."""
    edges = np.concatenate([triangles[:, pair] for pair in CORNERS])
    _, inverse, count = np.unique(keys_of(edges), return_inverse=True, return_counts=True)
    shared = count[inverse.reshape(-1)].reshape(3, -1) == 2
    return np.flatnonzero(shared.sum(axis=0) == 1)


def with_free_corners(points, triangles, least_angle=20.0):
    """Turns the inner edge of triangles that have two edges on the boundary.

    The velocity of such a triangle has hardly a free node, which the pressure of a P2/P1
    pair does not stand. An edge is turned only where no angle falls below least_angle
    (degrees) by it, or below what it was.
    """
    triangles = triangles.copy()
    ahead, before, owners = on_two_sides(triangles).tolist(), -1, {}  # a heap of those that may be turned
    for pair in CORNERS:
        for k, (i, j) in enumerate(triangles[:, pair].tolist()) if ahead else ():
            owners.setdefault(edge(i, j), []).append(k)
    while ahead:
        k = heapq.heappop(ahead)
        if k == before:
            continue
        before, own = k, triangles[k].tolist()
        inner = [pair for pair in CORNERS if len(owners[edge(own[pair[0]], own[pair[1]])]) == 2]
        if len(inner) != 1:
            continue
        i, j = (own[corner] for corner in inner[0])
        other = next(o for o in owners[edge(i, j)] if o != k)
        tip = next(v for v in own if v not in (i, j))
        far = next(v for v in triangles[other].tolist() if v not in (i, j))
        pair = np.array([[tip, i, far], [tip, far, j]])
        least = min(least_angle, smallest_angles(points, triangles[[k, other]]).min() - 1e-6)
        if np.any(signed_areas(points, pair) <= 0) or smallest_angles(points, pair).min() < least:
            continue
        triangles[k], triangles[other] = pair
        owners[edge(tip, far)] = [k, other]
        del owners[edge(i, j)]
        swap(owners, edge(tip, j), k, other)
        swap(owners, edge(i, far), other, k)
        if other > k:
            heapq.heappush(ahead, other)  # it may have two edges on the boundary now
    return triangles


def edge(i, j):
    """An edge as a key."""
    return (i, j) if i < j else (j, i)


def swap(owners, at, old, new):
    owners[at] = [new if k == old else k for k in owners[at]]


def renumbered(points, triangles):
    """Vertices by reverse Cuthill-McKee, triangles after their vertices: near in space, near in memory.

    FreeFEM numbers its unknowns itself, so the matrices are the same for any numbering of
    the mesh; assembly and characteristics run a quarter faster than on a random one.
    """
    n = len(points)
    rows = triangles[:, [0, 1, 2]].ravel()
    columns = triangles[:, [1, 2, 0]].ravel()
    ones = np.ones(len(rows), dtype=np.int8)
    graph = coo_matrix((ones, (rows, columns)), shape=(n, n)).tocsr()
    order = reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True)
    place = np.empty(n, dtype=int)
    place[order] = np.arange(n)
    triangles = place[triangles]
    # Each triangle starts with its smallest vertex; the sense of rotation stays.
    start = np.argmin(triangles, axis=1)
    triangles = triangles[np.arange(len(triangles))[:, None], (start[:, None] + np.arange(3)) % 3]
    triangles = triangles[np.lexsort((triangles.max(axis=1), triangles.sum(axis=1), triangles[:, 0]))]
    return points[order], triangles


def labels_on(points, edges, outline, tolerance=1e-9):
    """The label of the side of the outline on which each edge lies; 0 where there is none."""
    starts, ends, side_labels = outline.sides()
    size = np.ptp(starts, axis=0).max()
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    labels = np.zeros(len(edges), dtype=int)
    for start, end, label in zip(starts, ends, side_labels):
        on_side = on_segment(a, start, end, tolerance * size) & on_segment(b, start, end, tolerance * size)
        labels[on_side] = label
    return labels


def on_segment(points, start, end, tolerance):
    along = (end - start) / np.linalg.norm(end - start)
    way = (points - start) @ along
    off = np.abs((points - start) @ np.array([-along[1], along[0]]))
    return (off <= tolerance) & (way >= -tolerance) & (way <= np.linalg.norm(end - start) + tolerance)
