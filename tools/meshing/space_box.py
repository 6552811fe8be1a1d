"""A box of tetrahedra with a fine corridor along z, a quarter of it between planes of symmetry, or that quarter with its images.

The sides of the box are walls (3). In a quarter, the planes x = 0 (left, 11) and y = 0 (front, 15) are planes of symmetry.
"""
import numpy as np

from tools.base.command import positive
from tools.meshing.labels import LABELS
from tools.meshing.options import add_length, add_size
from tools.meshing.space_mesh import SIZES_OF_FIELDS, boxes, filled, finished, refuse_too_many, with_image
from tools.meshing.structured import even, growing, joined
from tools.meshing.unstructured import with_gmsh


def add_options(parser):
    add_size(parser, 0.00375, "M")
    add_length(parser, "--width", 0.1, "M", "width of the box along x and y")
    add_length(parser, "--height", 0.16, "M", "height of the box")
    add_length(parser, "--corridor", 0.015, "M", "half width of the fine corridor")
    add_length(parser, "--corridor-top", 0.14, "M", "height of the fine corridor")
    add_length(parser, "--growth", 0.03, "M", "distance over which the elements grow from the corridor to the coarse ones")
    parser.add_argument("--coarse", type=positive, default=4.0, help="size of the coarse elements over --size (default "
        "%(default)s)")
    parser.add_argument("--part", choices=["quarter", "whole", "mirrored"], default="quarter",
        help="of the box; mirrored: whole, of the images of the quarter (default %(default)s)")
    parser.add_argument("--pattern", choices=["unstructured", "grid"], default="unstructured",
        help="gmsh's tetrahedra, or the cells of a grid cut into six (default %(default)s)")


def build(options):
    half = options.width / 2
    low = -half if options.part == "whole" else 0.0
    across, up = min(options.corridor, half) - max(low, -options.corridor), min(options.corridor_top, options.height)
    refuse_too_many(((half - low) ** 2 * options.height, options.coarse * options.size), (across**2 * up, options.size))

    def label_of(centres):
        labels = np.full(len(centres), LABELS["wall"])
        if options.part == "quarter":
            labels[np.abs(centres[:, 0]) < 1e-9 * half] = LABELS["left"]
            labels[np.abs(centres[:, 1]) < 1e-9 * half] = LABELS["front"]
        return labels

    if options.pattern == "grid":
        return None, whole(grid(options, label_of), options, label_of)

    def mesh(gmsh):
        gmsh.model.occ.addBox(low, low, 0, half - low, half - low, options.height)
        gmsh.model.occ.synchronize()
        field = gmsh.model.mesh.field
        corridor = field.add("Box")
        sides = {"VIn": options.size, "VOut": options.coarse * options.size, "XMin": -options.corridor, "XMax": options.corridor,
            "YMin": -options.corridor, "YMax": options.corridor, "ZMin": -options.height, "ZMax": options.corridor_top,
            "Thickness": options.growth}
        for name, value in sides.items():
            field.setNumber(corridor, name, value)
        field.setAsBackgroundMesh(corridor)
        return filled(gmsh, label_of)

    return None, whole(with_gmsh(mesh, "gmsh cannot mesh this box", SIZES_OF_FIELDS), options, label_of)


def whole(mesh, options, label_of):
    """The SpaceMesh itself, or with the images of a quarter where the box is asked for "mirrored"."""
    points, tetrahedra = mesh.points, mesh.tetrahedra
    if options.part != "mirrored":
        return mesh
    for axis in (0, 1):
        points, tetrahedra = with_image(points, tetrahedra, axis, 0.0)
    return finished(points, tetrahedra, label_of)


def grid(options, label_of):
    half, size = options.width / 2, options.size
    wide, top, coarse = min(options.corridor, half), min(options.corridor_top, options.height), options.coarse * options.size
    across, up = even(0, wide, size), even(0, top, size)
    if wide < half:
        across = joined(across, growing(wide, half, size, 1.35, coarse))
    if top < options.height:
        up = joined(up, growing(top, options.height, size, 1.35, coarse))
    if options.part == "whole":
        across = np.concatenate([-across[:0:-1], across])
    return boxes(across, across, up, label_of)
