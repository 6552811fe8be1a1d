"""A quarter of a wide stream along x around a sphere at the origin, of tetrahedra, finer around the sphere and in its wake.

Lengths in diameters of the sphere. Labels: left (11, inflow), right (12, outflow), front (15) and bottom (13): planes of symmetry
through the sphere; back (16) and top (14): the far sides.
"""
import numpy as np

from tools.base.command import positive
from tools.meshing.labels import LABELS
from tools.meshing.options import add_length, add_size
from tools.meshing.space_mesh import SIZES_OF_FIELDS, filled, refuse_too_many
from tools.meshing.unstructured import with_gmsh


def add_options(parser):
    add_size(parser, 1 / 6, "D")
    add_length(parser, "--upstream", 5.0, "D", "length before the sphere")
    add_length(parser, "--downstream", 10.0, "D", "length behind it")
    add_length(parser, "--half-width", 5.0, "D", "distance of the far sides")
    add_length(parser, "--wake", 2.5, "D", "length of the fine wake")
    parser.add_argument("--coarse", type=positive, default=8.0, help="size of the coarse elements over --size (default "
        "%(default)s)")


def build(options):
    low, high, wide, size = -options.upstream, options.downstream, options.half_width, options.size
    refuse_too_many(((high - low) * wide**2, options.coarse * size), (0.9 * 0.75**2 + options.wake * 0.8**2, 1.5 * size))

    def label_of(centres):
        labels = np.zeros(len(centres), dtype=int)
        for name, axis, place in (("left", 0, low), ("right", 0, high), ("front", 1, 0.0), ("back", 1, wide), ("bottom", 2, 0.0),
                                  ("top", 2, wide)):
            labels[np.abs(centres[:, axis] - place) < 1e-9 * wide] = LABELS[name]
        return labels

    def mesh(gmsh):
        gmsh.model.occ.addBox(low, 0, 0, high - low, wide, wide)
        gmsh.model.occ.synchronize()
        field, parts = gmsh.model.mesh.field, []
        for sides in ({"VIn": size, "XMin": -0.75, "XMax": 0.9, "YMin": -1, "YMax": 0.75, "ZMin": -1, "ZMax": 0.75,
            "Thickness": 3.0},
                      {"VIn": 1.5 * size, "XMin": 0, "XMax": options.wake, "YMin": -1, "YMax": 0.8, "ZMin": -1, "ZMax": 0.8,
                       "Thickness": 3.0}):
            parts.append(field.add("Box"))
            for name, value in (sides | {"VOut": options.coarse * size}).items():
                field.setNumber(parts[-1], name, value)
        least = field.add("Min")
        field.setNumbers(least, "FieldsList", parts)
        field.setAsBackgroundMesh(least)
        return filled(gmsh, label_of)

    return None, with_gmsh(mesh, "gmsh cannot mesh this stream", SIZES_OF_FIELDS)
