"""Bodies of any shape for tests: lines of a case, and their areas and distances by other means than those of the suite."""
from itertools import count

import numpy as np

from tools.base.tables import read_table

SCENE = """
include "lib/case.idp"
include "lib/bodies/shapes.idp"
optCase("shapes", "a scene of tests/contact/test_shapes.py");
real gravityX = {gravity[0]:.17g}, gravityY = {gravity[1]:.17g};
{arrays}
macro caseParticles() {bodies} // EOM
macro caseWalls() {walls} // EOM
include "scripts/contacts.edp"
"""
NAMES = count()


def array(values):
    """A FreeFEM array of numbers."""
    return "[" + ", ".join(f"{float(value)!r}" for value in values) + "]"


def put(made, mu, motion):
    """The line of a body with a coefficient of friction and velocities (u, v, omega)."""
    if motion is not None:
        made = f"bodyThrown({made}, {', '.join(f'{float(value)!r}' for value in motion)})"
    return made + ";" if mu is None else f"bodyRough({made}, {float(mu)!r});"


def capsule(x, y, half, radius, angle, mu=None, motion=None, density=1000.0):
    return put("bodyCapsule(" + ", ".join(f"{float(value)!r}" for value in (x, y, half, radius, angle, density)) + ")", mu, motion)


def arrays(kind, columns, rest, mu, motion):
    """The declaration of the arrays and the line of a body, joined by a mark that scene_text() takes apart."""
    names = [f"place{next(NAMES)}" for _ in columns]
    told = " ".join(f"real[int] {name} = {array(column)};" for name, column in zip(names, columns))
    return told + "@" + put(f"{kind}({', '.join(names + rest)})", mu, motion)


def polygon(points, radius=0.01, mu=None, motion=None):
    return arrays("bodyPolygon", np.array(points, float).T, [f"{float(radius)!r}", "1000"], mu, motion)


def clump(points, radii, mu=None, motion=None):
    return arrays("bodyClump", [*np.array(points, float).T, radii], ["1000"], mu, motion)


def scene_text(bodies, walls, gravity):
    """The text of a case of these bodies and walls."""
    told = [line.split("@") for line in bodies]
    return SCENE.format(arrays="\n".join(line[0] for line in told if len(line) > 1), bodies="\n".join(line[-1] for line in told),
        walls="\n".join(walls) or "int none = 0;", gravity=gravity)


def read_bodies(folder):
    """{id: [(closed, radius, vertices (n, 2)), ...]} of outlines.csv."""
    rows, found = read_table(folder / "outlines.csv"), {}
    for part in np.unique(rows["part"]):
        of = rows["part"] == part
        found.setdefault(int(rows["id"][of][0]), []).append((int(rows["closed"][of][0]), rows["radius"][of][0],
            np.column_stack([rows["x"][of], rows["y"][of]])))
    return found


def chords(points, shut, radius, y):
    """Intervals of a part on the lines at the heights y (n,), as a list of [(n,), (n,)], empty ones at 1e9: disks, sides of edges,
    and the polygon. They may overlap."""
    n, found = len(points), []
    for px, py in points:
        half = np.sqrt(np.maximum(radius**2 - (y - py) ** 2, 0))
        found.append(np.where(half > 0, [px - half, px + half], 1e9))
    loops = [list(points)] if shut else []
    for k in range(n if shut else n - 1):
        a, b = points[k], points[(k + 1) % n]
        side = radius * np.array([-(b - a)[1], (b - a)[0]]) / np.hypot(*(b - a))
        loops.append([a + side, a - side, b - side, b + side])
    for loop in loops:
        crossings = np.sort([np.where((y1 > y) != (y2 > y), x1 + (y - y1) * (x2 - x1) / (y2 - y1), 1e9)
            for (x1, y1), (x2, y2) in zip(loop, [*loop[1:], loop[0]])], axis=0)
        found += [crossings[k:k + 2] for k in range(0, len(crossings) - 1, 2)]
    return found


def moments(parts, lines=20000):
    """Area, area times centre and polar moment of a union of parts (closed, vertices, radius): sums over the chords at so many
    heights. No edge may be level."""
    low = min(points[:, 1].min() - radius for _, points, radius in parts)
    high = max(points[:, 1].max() + radius for _, points, radius in parts)
    y = low + (high - low) / lines * (np.arange(lines) + 0.5)
    spans = np.array([span for shut, points, radius in parts for span in chords(points, shut, radius, y)])
    spans = np.take_along_axis(spans, np.argsort(spans[:, :1], axis=0), axis=0)
    ends = np.maximum.accumulate(spans[:, 1], axis=0)
    begin = spans[:, 0]
    begin[1:] = np.maximum(begin[1:], ends[:-1])
    end = np.maximum(spans[:, 1], begin)
    a, b, c = ((end**k - begin**k) * (begin < 1e8) / k for k in (1, 2, 3))
    return np.array([a.sum(), b.sum(), (y * a).sum(), (c + y**2 * a).sum()]) * (high - low) / lines


def disks_area(points, radii):
    """Mass (of density 1000), centre and squared radius of gyration of two equal disks that may overlap, in closed form: the lens is
    taken off once, its moment about its centre being r^4 (a - sin(4 a)/4 ... ) by Gauss's rule over its chords."""
    r, apart = radii[0], np.hypot(*(points[1] - points[0]))
    centre = points.mean(0)
    area, moment = 2 * np.pi * r**2, 2 * (np.pi * r**4 / 2 + np.pi * r**2 * (apart / 2) ** 2)
    if apart < 2 * r:  # chords across the line of centres at the distance s = r sin(t) ... of the lens
        nodes, weights = np.polynomial.legendre.leggauss(60)
        top = np.arcsin(np.sqrt(r**2 - apart**2 / 4) / r)
        t = top * nodes
        s, half = r * np.sin(t), r * np.cos(t) - apart / 2
        jacobian = top * weights * r * np.cos(t)
        area -= (jacobian * 2 * half).sum()
        moment -= (jacobian * (2 * half**3 / 3 + 2 * half * s**2)).sum()
    return 1000 * area, centre, moment / area


def gap_of_capsules(tips):
    """The least distance of the segments of bodies, tips: end (2), component (2), body (n)."""
    n = tips.shape[2]
    i, j = np.triu_indices(n, 1)
    least = np.inf
    for one, two in ((i, j), (j, i)):
        a, t = tips[0][:, two], tips[1][:, two] - tips[0][:, two]
        for end in (0, 1):
            p = tips[end][:, one]
            along = np.clip(((p - a) * t).sum(0) / (t**2).sum(0), 0, 1)
            if n > 1:
                least = min(least, np.sqrt(((p - a - along * t) ** 2).sum(0)).min())
    return least
