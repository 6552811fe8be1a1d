"""Cells of a plane flow as triangles, with names on their sides."""
import re

import numpy as np

from tools.base.command import BadInput
from tools.meshing.labels import LABELS, NAMES
from tools.meshing.plane_mesh import PlaneMesh, edges_of, signed_areas, smallest_angles

CONDITION = re.compile(r"\s*([xy])\s*(<=|>=|<|>)\s*([-+.\deE]+)\s*$")
REST = "rest"


def split(points, polygons):
    """(triangles (m, 3) counter-clockwise, the polygon of each (m,)): quadrilaterals by the diagonal whose smallest angle is the
    largest, others by cutting off the corner of the best triangle again and again."""
    counts = np.array([len(one) for one in polygons])
    triangles, owner = [np.empty((0, 3), int)], [np.empty(0, int)]
    for count in np.unique(counts):
        which = np.flatnonzero(counts == count)
        corners = np.array([polygons[k] for k in which])
        corners[turn(points, corners) < 0] = corners[turn(points, corners) < 0][:, ::-1]
        if count == 3:
            parts = [corners]
        elif count == 4:
            first = [corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], [corners[:, [0, 1, 3]], corners[:, [1, 2, 3]]]
            worth = [np.minimum(*(quality(points, part) for part in pair)) for pair in first]
            better = (worth[1] > worth[0] + 1e-9)[:, None]
            parts = [np.where(better, b, a) for a, b in zip(*first)]
        else:
            cut = np.array([ears(points, one) for one in corners])
            parts = [cut[:, k] for k in range(count - 2)]
        triangles += parts
        owner += [which] * len(parts)
    return np.concatenate(triangles), np.concatenate(owner)


def turn(points, corners):
    """Twice the signed areas of polygons of as many corners each."""
    x, y = points[corners].transpose(2, 0, 1)
    return (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


def quality(points, triangles):
    """The smallest angle of each triangle, degrees; below 0 for those that run clockwise."""
    return np.where(signed_areas(points, triangles) > 0, smallest_angles(points, triangles), -1)


def ears(points, polygon):
    """The triangles of one polygon, whose corners run counter-clockwise."""
    left, found = list(polygon), []
    while len(left) > 3:
        n = len(left)
        every = np.array([[left[k - 1], left[k], left[(k + 1) % n]] for k in range(n)])
        worth = quality(points, every)
        for k, ear in enumerate(every):  # no other vertex may lie in it, or on its sides
            if worth[k] > 0 and any(inside(points[ear], points[vertex]) for vertex in left if vertex not in ear):
                worth[k] = -2
        best = int(np.argmax(worth))
        found.append(every[best])
        left.pop(best)
    return [*found, np.array(left)]


def inside(corners, point):
    a, b = corners, np.roll(corners, -1, axis=0)
    way, to = b - a, point - a
    return bool((way[:, 0] * to[:, 1] - way[:, 1] * to[:, 0] >= 0).all())


def rules(words):
    """[(label, what)] of the options --label NAME=WHAT; what: a name of a patch, "rest", or a list of conditions (axis 0 or 1,
    sign, value). Raises BadInput."""
    found = []
    for word in words:
        name, equals, what = (part.strip() for part in word.partition("="))
        if not equals or name not in LABELS or not what:
            raise BadInput(f"--label takes NAME=CONDITION, as inlet=x<1e-6, NAME={REST} or NAME=PATCH, not '{word}'; names are "
                f"{', '.join(LABELS)}")
        parts = [CONDITION.match(part) for part in what.split("&")]
        if any(sign in what for sign in "<>="):
            try:
                what = [("xy".index(part[1]), part[2], float(part[3])) for part in parts]
            except (TypeError, ValueError):
                raise BadInput(f"--label {word}: conditions are as x<1e-6 or x>0.2&y>=0.1, with x and y in m") from None
        found.append((LABELS[name], what))
    return found


def holds(conditions, points):
    """Where all the conditions hold, of points (n, 2)."""
    signs = {"<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal}
    return np.all([signs[sign](points[:, axis], value) for axis, sign, value in conditions], axis=0)


def labelled(points, edges, sides, kinds, given, source):
    """The labels of boundary edges (k, 2): by the first rule of `given` that fits, then by the name of their patch (sides, kinds:
    tools/flow/given.py), then by its kind. Raises BadInput where one has none, and where a rule fits no edge."""
    patch = {}
    for name, pairs in sides.items():
        patch |= {tuple(pair): name for pair in np.sort(pairs, axis=1).tolist()}
    names = [patch.get(tuple(pair)) for pair in np.sort(edges, axis=1).tolist()]
    labels = np.zeros(len(edges), int)
    for label, what in given:
        if what == REST:
            fits = labels == 0
            if sides:  # what no other rule and no name has
                fits &= np.array([by_name(name, kinds) == 0 for name in names])
        elif isinstance(what, list):
            fits = holds(what, points[edges[:, 0]]) & holds(what, points[edges[:, 1]])
        else:
            fits = np.array([name == what for name in names])
            if what not in sides:
                raise BadInput(f"--label {NAMES[label]}={what}: {source} has no patch {what}"
                    + (f"; its patches: {', '.join(sides)}" if sides else ", its sides have no names; give a condition, as x<1e-6"))
        if not fits.any():
            raise BadInput(f"--label {NAMES[label]}: no side of {source} fits; it lies within x from {points[:, 0].min():g} to "
                f"{points[:, 0].max():g}, y from {points[:, 1].min():g} to {points[:, 1].max():g} m")
        labels[fits & (labels == 0)] = label
    for k in np.flatnonzero(labels == 0):
        labels[k] = by_name(names[k], kinds)
    if (labels == 0).any():
        k = np.flatnonzero(labels == 0)[0]
        a, b = points[edges[k]]
        patch, remedy = (f", those of the patch {names[k]}", f", or --label wall={names[k]}") if names[k] else ("", "")
        raise BadInput(f"{np.sum(labels == 0)} sides of {source} have no name{patch}, the first from ({a[0]:g}, {a[1]:g}) to "
            f"({b[0]:g}, {b[1]:g}) m: give one, as --label inlet=x<1e-6 --label outlet=x>0.999 --label wall={REST}{remedy}")
    return labels


def by_name(name, kinds):
    """The label of a patch by its name or kind, 0 where it has none."""
    if name in LABELS:
        return LABELS[name]
    return {"wall": LABELS["wall"], "symmetry": LABELS["axis"]}.get(kinds.get(name, ""), 0)


def mesh_of(flow, given, source):
    """(PlaneMesh, cell of each triangle) of a Given; given: rules(). Raises BadInput."""
    triangles, owner = split(flow.points, flow.polygons)
    if signed_areas(flow.points, triangles).min() <= 0:
        bad = owner[np.argmin(signed_areas(flow.points, triangles))]
        x, y = flow.points[flow.polygons[bad]].mean(axis=0)
        raise BadInput(f"{source} has a cell without area or that crosses itself, near ({x:g}, {y:g}) m")
    edges, count = edges_of(triangles)
    edges = edges[count == 1]
    labels = labelled(flow.points, edges, flow.sides, flow.kinds, given, source)
    order = np.lexsort((edges[:, 0], labels))
    return PlaneMesh(flow.points, triangles, edges[order], labels[order]), owner
