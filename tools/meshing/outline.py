"""The outline of a plane domain: closed polygons whose sides carry labels."""
from dataclasses import dataclass

import numpy as np

from tools.base.command import BadInput
from tools.meshing.labels import LABELS


@dataclass
class Outline:
    """Polygons that bound a domain: the first from outside, the others are holes.

    loops: one list per polygon of (x, y, name), in order along the polygon; name is the
        label (tools.meshing.labels) of the side that goes from this corner to the next.
        Consecutive equal corners are dropped. Lengths in the unit of the case.
    """

    loops: list

    def __post_init__(self):
        self.loops = [without_repeats(loop) for loop in self.loops]
        if any(len(loop) < 3 for loop in self.loops):
            raise BadInput("a body or the domain is so small beside its place that its corners are one point: ask for other "
                "dimensions")

    def sides(self):
        """All sides: starts (n, 2), ends (n, 2), labels (n,)."""
        starts, ends, labels = [], [], []
        for loop in self.loops:
            for (x, y, name), (x1, y1, _) in zip(loop, loop[1:] + loop[:1]):
                starts.append((x, y))
                ends.append((x1, y1))
                labels.append(LABELS[name])
        return np.array(starts, float), np.array(ends, float), np.array(labels)

    def lengths(self):
        """Total length of the sides of each label: {label: length}."""
        starts, ends, labels = self.sides()
        lengths = np.linalg.norm(ends - starts, axis=1)
        return {int(label): float(lengths[labels == label].sum()) for label in np.unique(labels)}

    def area(self):
        """Area inside the first polygon and outside the others."""
        areas = [abs(shoelace(loop)) for loop in self.loops]
        return areas[0] - sum(areas[1:])

    def segments(self, *names):
        """The sides with one of these labels, as pairs of points."""
        starts, ends, labels = self.sides()
        wanted = [LABELS[name] for name in names]
        return [(tuple(a), tuple(b)) for a, b, label in zip(starts, ends, labels) if label in wanted]


def without_repeats(loop):
    """The corners of a polygon without those that fall on the next one."""
    following = loop[1:] + loop[:1]
    return [corner for corner, after in zip(loop, following) if corner[:2] != after[:2]]


def shoelace(loop):
    """Signed area of a polygon, positive when it runs counter-clockwise."""
    x, y = np.array([corner[:2] for corner in loop], float).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def rectangle(x0, x1, y0, y1, bottom, right, top, left):
    """A rectangle [x0, x1] x [y0, y1] with the names of its four sides."""
    return Outline([[(x0, y0, bottom), (x1, y0, right), (x1, y1, top), (x0, y1, left)]])
