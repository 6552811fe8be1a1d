"""A block of tetrahedra [0, length] x [0, width] x [0, height] whose sides have names: cells of arrays, ducts, channels.

The cells of a grid cut into six tetrahedra, all alike or as the mirror images of those in the lowest octant. Opposite sides match.
Labels: left, right (x), front, back (y), bottom, top (z).
"""
import numpy as np

from tools.meshing.labels import LABELS
from tools.meshing.options import add_length, add_size
from tools.meshing.space_mesh import boxes, finished, with_image
from tools.meshing.structured import even


def add_options(parser):
    add_size(parser, 1 / 16, "M")
    add_length(parser, "--length", 0.5, "M", "length along x")
    add_length(parser, "--width", 0.5, "M", "length along y")
    add_length(parser, "--height", 0.5, "M", "length along z")
    parser.add_argument("--octants", choices=["alike", "mirrored"], default="alike",
        help="cells of the grid all alike, or mirrored at the middle planes (default %(default)s)")


def build(options):
    lengths = (options.length, options.width, options.height)

    def label_of(centres):
        labels = np.zeros(len(centres), dtype=int)
        for axis, names in enumerate((("left", "right"), ("front", "back"), ("bottom", "top"))):
            labels[centres[:, axis] < 1e-9 * lengths[axis]] = LABELS[names[0]]
            labels[centres[:, axis] > (1 - 1e-9) * lengths[axis]] = LABELS[names[1]]
        return labels

    if options.octants == "alike":
        return None, boxes(*(even(0, length, options.size) for length in lengths), label_of)
    octant = boxes(*(even(0, length / 2, options.size) for length in lengths), lambda centres: np.ones(len(centres), dtype=int))
    points, tetrahedra = octant.points, octant.tetrahedra
    for axis in range(3):
        points, tetrahedra = with_image(points, tetrahedra, axis, lengths[axis] / 2)
    return None, finished(points, tetrahedra, label_of)
