"""Values of a flow at the nodes of a quadratic element: at the vertices and in the middles of the sides of triangles.

From cells to vertices: a linear function is fitted to the values in the cells around a vertex, at their centres, by least squares
with weights 1/distance^2. It is exact for linear fields on any mesh, so second order, as the values of finite volumes are, at the
boundary too. On a side whose values the file gives, a vertex takes those instead, linear along the boundary.

From vertices to the middles: with the gradients g of a quadratic fitted around each vertex,

    u(middle) = (u_a + u_b)/2 + (g_a - g_b).(x_b - x_a)/8,

exact for quadratics: third order in the velocity, second in its gradient, where the values at the vertices are that good. It is
kept within the values around by an eighth of their range, so that layers which the mesh does not resolve make no oscillations;
between two vertices at rest on the boundary it is 0. Quantities that must not be negative (k, epsilon) take the mean.
"""
import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

LEAST = {1: 4, 2: 8}  # samples of a linear fit, of a quadratic one: with fewer, those beyond the nearest count too
BEYOND = 0.125  # of the range of the values around
NEAREST = 8  # points of a cloud for a point outside it
CHUNK = 100_000  # fits at once


def pairs_of(rows, columns, shape):
    """A sparse matrix of ones."""
    return coo_matrix((np.ones(len(rows), bool), (rows, columns)), shape=shape).tocsr()


def around(near, wider, least):
    """(rows, columns) of the samples of each row: those of `near`, where these are fewer than least those of `wider` (sparse)."""
    few = np.diff(near.indptr) < least
    near, wider = near.tocoo(), wider.tocoo()
    keep, more = ~few[near.row], few[wider.row]
    return np.concatenate([near.row[keep], wider.row[more]]), np.concatenate([near.col[keep], wider.col[more]])


def summed(rows, weight, values, count):
    """Sums of weight (n,) times values (n, columns) over the samples of each of `count` fits."""
    return np.stack([np.bincount(rows, weight * column, count) for column in values.T], axis=1)


def slopes(terms, rows, weight, values, count):
    """Coefficients (count, terms, columns), of least norm where they are not determined, of the terms (n, terms) that fit values
    (n, columns) best."""
    left, right = np.zeros((count, *2 * (terms.shape[1],))), np.zeros((count, terms.shape[1], values.shape[1]))
    for i, term in enumerate(terms.T):
        left[:, i] = summed(rows, weight * term, terms, count)
        right[:, i] = summed(rows, weight * term, values, count)
    return np.concatenate([np.linalg.pinv(left[k:k + CHUNK], rcond=1e-10, hermitian=True) @ right[k:k + CHUNK]
        for k in range(0, count, CHUNK)])


def sizes(way, rows, count):
    """Root mean square distance of the samples of each fit, m."""
    found = np.sqrt(np.bincount(rows, (way**2).sum(axis=1), count) / np.maximum(np.bincount(rows, minlength=count), 1))
    return np.where(found > 0, found, 1)


def linear_at(way, rows, values, count):
    """Values (count, columns) at the centres of linear fits to samples (n, columns), at way (n, 2) from the centre of the fit of
    each, rows (n,); weights 1/distance^2. Where the samples stand in a line it does not vary across it."""
    way = way / sizes(way, rows, count)[rows][:, None]
    weight = 1 / np.maximum((way**2).sum(axis=1), 1e-12)
    total = np.bincount(rows, weight, count)[:, None]
    middle, mean = summed(rows, weight, way, count) / total, summed(rows, weight, values, count) / total
    found = slopes(way - middle[rows], rows, weight, values - mean[rows], count)
    return mean - np.einsum("kic,ki->kc", found, middle)


def gradients(way, rows, change, count):
    """Gradients (count, 2, columns) at the centres of quadratics through 0 there, fitted to changes (n, columns); weights
    1/distance."""
    size = sizes(way, rows, count)
    x, y = (way / size[rows][:, None]).T
    terms = np.stack([x, y, x * x, x * y, y * y], axis=1)
    return slopes(terms, rows, 1 / np.maximum(np.hypot(x, y), 1e-6), change, count)[:, :2] / size[:, None, None]


def centres(points, polygons):
    """The centroids of polygons (m, 2)."""
    counts = np.array([len(one) for one in polygons])
    found = np.empty((len(polygons), 2))
    for count in np.unique(counts):
        which = np.flatnonzero(counts == count)
        corners = points[np.array([polygons[k] for k in which])]
        base = corners[:, :1]
        (x, y), (x1, y1) = (corners - base).transpose(2, 0, 1), np.roll(corners - base, -1, axis=1).transpose(2, 0, 1)
        cross = x * y1 - x1 * y
        found[which] = base[:, 0] + np.stack([((x + x1) * cross).sum(axis=1), ((y + y1) * cross).sum(axis=1)], axis=1) / (3
            * cross.sum(axis=1))[:, None]
    return found


def at_vertices(flow, frame, given):
    """{name: (n,)} at the points of a Given, of a frame {name: values in the cells}; given: {patch: {name: values at the middles of
    its edges}}, {} where there are none."""
    n, cells = len(flow.points), len(flow.polygons)
    rows = np.concatenate(flow.polygons)
    columns = np.repeat(np.arange(cells), [len(one) for one in flow.polygons])
    near = pairs_of(rows, columns, (n, cells))
    wider = near @ (near.T @ near)
    at = centres(flow.points, flow.polygons)
    row, column = around(near, wider.astype(bool), LEAST[1])
    names = list(frame)
    values = np.stack([frame[name] for name in names], axis=1)
    found = linear_at(at[column] - flow.points[row], row, values[column], n)
    found = {name: found[:, k] for k, name in enumerate(names)}
    for name in names:
        if name in ("k", "epsilon"):
            found[name] = np.maximum(found[name], frame[name].min())
        on_boundary(flow, name, found[name], given)
    return found


def on_boundary(flow, name, values, given):
    """Puts into values (n,) those of the patches that give `name`: of two sides at a vertex linear along them; a wall's alone where
    it meets a patch of another kind."""
    for walls in (False, True):
        total, weight = np.zeros(len(values)), np.zeros(len(values))
        for patch, edges in flow.sides.items():
            if (flow.kinds.get(patch) == "wall") == walls and name in given.get(patch, {}):
                near = 1 / np.linalg.norm(flow.points[edges[:, 0]] - flow.points[edges[:, 1]], axis=1)
                for end in range(2):
                    np.add.at(total, edges[:, end], near * given[patch][name])
                    np.add.at(weight, edges[:, end], near)
        there = weight > 0
        values[there] = total[there] / weight[there]


def sides_of(triangles):
    """(sides (k, 2), number of the side opposite to each corner (m, 3)), numbered as the triangles first name them."""
    pairs = np.sort(triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
    sides, first, which = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    place = np.empty(len(sides), int)
    place[order] = np.arange(len(sides))
    return sides[order], place[which.ravel()].reshape(-1, 3)


class Middles:
    """From values at the vertices of a PlaneMesh to those in the middles of its sides."""

    def __init__(self, mesh):
        n = len(mesh.points)
        self.points, (self.sides, _) = mesh.points, sides_of(mesh.triangles)
        a, b = self.sides.T
        near = pairs_of(np.concatenate([a, b]), np.concatenate([b, a]), (n, n))
        wider = (near @ near).astype(bool)
        wider.setdiag(False)
        wider.eliminate_zeros()
        self.near = near
        self.row, self.column = around(near, (wider + near).astype(bool), LEAST[2])
        self.boundary = np.isin(a * n + b, np.sort(mesh.edges, axis=1) @ [n, 1])

    def __call__(self, velocity):
        """(k, 2) of the velocity (n, 2)."""
        n, (a, b) = len(self.points), self.sides.T
        way = self.points[self.column] - self.points[self.row]
        slope = gradients(way, self.row, velocity[self.column] - velocity[self.row], n)
        along = self.points[b] - self.points[a]
        found = 0.5 * (velocity[a] + velocity[b]) + np.einsum("kic,ki->kc", slope[a] - slope[b], along) / 8
        neighbours = self.near.tocoo()
        for component in range(2):
            low, high = velocity[:, component].copy(), velocity[:, component].copy()
            np.minimum.at(low, neighbours.row, velocity[neighbours.col, component])
            np.maximum.at(high, neighbours.row, velocity[neighbours.col, component])
            low, high = np.minimum(low[a], low[b]), np.maximum(high[a], high[b])
            found[:, component] = np.clip(found[:, component], low - BEYOND * (high - low), high + BEYOND * (high - low))
        found[self.boundary & (velocity[a] == 0).all(axis=1) & (velocity[b] == 0).all(axis=1)] = 0
        return found


def nearest(cloud, values, points):
    """Values (n, columns) at points (n, 2) outside a cloud (m, 2), by linear functions fitted to the nearest points; distances."""
    count = min(NEAREST, len(cloud))
    distance, which = cKDTree(cloud).query(points, count)
    distance, which = distance.reshape(-1, count), which.reshape(-1, count)
    rows = np.repeat(np.arange(len(points)), count)
    way = cloud[which.ravel()] - points[rows]
    return linear_at(way, rows, values[which.ravel()], len(points)), distance[:, 0]
