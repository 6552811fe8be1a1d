"""Seams of a mesh: where the parts of a file meet, each with points of its own, and where every cell has its own points.

Programs write such files for a mesh in several blocks (ParaView's Merge Blocks, a .pvtu), for a mesh around a body that is closed
along a line, and for fields that jump from cell to cell. Two edges of the boundary that lie on each other are one edge within the
fluid, so their ends become one point, with the mean of the values. Only where the fluid is at rest along both at all times they
stay a thin wall.
"""
import sys
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

SAME = 1e-9  # of the size of a domain: closer points are one place
AT_REST = 1e-12  # of the largest speed
APART = 0.01  # of the largest value: where values of one place differ by more, a line says so


def groups(pairs, n):
    """The group of each of n things, of which pairs (k, 2) are in one."""
    return connected_components(coo_matrix((np.ones(len(pairs), bool), pairs.T.reshape(2, -1)), shape=(n, n)), directed=False)[1]


def boundary(polygons):
    """The edges (k, 2) of polygons that are edges of one alone."""
    corners, ends = np.concatenate(polygons), np.cumsum([len(one) for one in polygons])
    after = np.arange(1, len(corners) + 1)
    after[ends - 1] = np.append(0, ends[:-1])  # behind the last corner of each the first one
    edges = np.column_stack([corners, corners[after]])
    _, first, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    return edges[first[count == 1]]


def speeds(flow):
    """The largest speed of each point at all times, m/s; that of values in cells is not known, and counts as 1."""
    if flow.in_cells:
        return np.ones(len(flow.points))
    return np.max([np.hypot(frame["u"], frame["v"]) for frame in flow.frames], axis=0)


def joined(flow, source):
    """A Given whose seams are joined."""
    edges, n = boundary(flow.polygons), len(flow.points)
    ends = np.unique(edges)
    near = cKDTree(flow.points[ends]).query_pairs(SAME * np.ptp(flow.points, axis=0).max(), output_type="ndarray")
    if not len(near):
        return flow
    place = groups(ends[near], n)
    edges = np.where((place[edges[:, 0]] > place[edges[:, 1]])[:, None], edges[:, ::-1], edges)  # ends in the order of their places
    _, which, count = np.unique(place[edges], axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.ravel(), kind="stable")
    twice = order[count[which.ravel()[order]] == 2].reshape(-1, 2)
    speed = speeds(flow)
    moves = speed[edges[twice]].max(axis=(1, 2), initial=0) > AT_REST * speed.max()
    one, other = edges[twice[moves]].transpose(1, 0, 2)
    group = groups(np.column_stack([one.ravel(), other.ravel()]), n)
    members = np.bincount(group)
    points = np.stack([np.bincount(group, axis) / members for axis in flow.points.T], axis=1)
    polygons = [group[one] for one in flow.polygons]
    if flow.in_cells:
        return replace(flow, points=points, polygons=polygons)
    frames = [{name: np.bincount(group, values) / members for name, values in frame.items()} for frame in flow.frames]
    for old, new in zip(flow.frames, frames):
        apart = {name: 2 * np.abs(old[name] - new[name][group]).max() for name in old}
        worst = [name for name in old if apart[name] > APART * np.abs(old[name]).max()]
        if worst:
            print(f"warning: {source}: values of points that stand more than once differ by up to {apart[worst[0]]:.3g} (of "
                f"{worst[0]}); their means are taken", file=sys.stderr)
            break
    return replace(flow, points=points, polygons=polygons, frames=frames)
