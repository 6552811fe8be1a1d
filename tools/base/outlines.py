"""Outlines of bodies of any shape: loops of points whose union is the body.

    parts = read_outlines(run.columns("outlines"))  # {id: [loop (n, 2), ...]}, in the frames of the bodies
    placed(parts[3], x, y, theta)                   # the loops of body 3 where it stands

A convex part (disk, capsule, convex polygon with rounded corners) is one loop. Any other part is the union of a capsule per edge
and, if it is closed, of the polygon of its vertices. Lengths are those of outlines.csv.
"""
import numpy as np

CORNERS = 72  # points of a whole turn


def loop_of(points, radius):
    """The outline of all points closer than `radius` to a convex polygon (n, 2) in the positive sense; one or two points are a
    disk and a capsule. An array (m, 2)."""
    n = len(points)
    if n == 1:
        angle = 2 * np.pi * np.arange(CORNERS) / CORNERS
        return points[0] + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    found = []
    for k in range(n):
        before, after = points[k] - points[k - 1], points[(k + 1) % n] - points[k]
        begin, end = np.arctan2(-before[0], before[1]), np.arctan2(-after[0], after[1])
        end += 2 * np.pi * (end < begin)
        angle = np.linspace(begin, end, max(2, int(np.ceil((end - begin) / (2 * np.pi) * CORNERS)) + 1))
        found.append(points[k] + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.concatenate(found)


def is_convex(points):
    """Whether a polygon (n, 2) in the positive sense turns left at every vertex."""
    sides = np.roll(points, -1, axis=0) - points
    ahead = np.roll(sides, -1, axis=0)
    return bool((sides[:, 0] * ahead[:, 1] - sides[:, 1] * ahead[:, 0] >= 0).all())


def loops_of(points, closed, radius):
    """The loops of a part: its vertices (n, 2), whether it is a closed polygon, and its radius."""
    n = len(points)
    if n < 3 or closed and is_convex(points):
        return [loop_of(points, radius)]
    edges = range(n if closed else n - 1)
    return [loop_of(points[[k, (k + 1) % n]], radius) for k in edges] + ([points] if closed else [])


def read_outlines(table):
    """{id: loops} from the columns of outlines.csv."""
    found = {}
    for one, part in np.unique(np.column_stack([table["id"], table["part"]]), axis=0):
        rows = (table["id"] == one) & (table["part"] == part)
        points = np.column_stack([table["x"][rows], table["y"][rows]])
        found.setdefault(int(one), []).extend(loops_of(points, bool(table["closed"][rows][0]),
            table["radius"][rows][0]))
    return found


def placed(loops, x, y, theta):
    """Loops of a body with its centre at (x, y), turned by theta (rad)."""
    c, s = np.cos(theta), np.sin(theta)
    return [loop @ np.array([[c, s], [-s, c]]) + [x, y] for loop in loops]
