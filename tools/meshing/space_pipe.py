"""A round pipe along x with a diaphragm and a wedge on its wall, of tetrahedra: the pipe of the spheres.

The diaphragm is a ring plate with a round opening, the wedge a triangular prism across the pipe's floor. Labels: inlet (1),
outlet (2), wall (3), diaphragm (4), obstacle (5). Elements are finer near diaphragm and wedge.
"""
import numpy as np

from tools.meshing.labels import LABELS
from tools.meshing.options import add_length, add_size, require
from tools.meshing.space_mesh import SIZES_OF_FIELDS, filled, refuse_too_many
from tools.meshing.unstructured import with_gmsh


def add_options(parser):
    add_size(parser, 0.075, "M")
    add_length(parser, "--length", 2.6, "M", "length of the pipe")
    add_length(parser, "--diameter", 1.0, "M", "diameter of the pipe")
    add_length(parser, "--diaphragm", 0.9, "M", "position of the diaphragm's upstream side")
    add_length(parser, "--thickness", 0.1, "M", "thickness of the diaphragm")
    add_length(parser, "--opening", 0.6, "M", "diameter of its opening")
    add_length(parser, "--wedge", 1.7, "M", "position of the wedge's edge")
    add_length(parser, "--wedge-height", 0.3, "M", "height of the wedge above the floor")


def build(options):
    radius, hole, end = options.diameter / 2, options.opening / 2, options.length
    require(hole < radius, "the opening must be smaller than the pipe")
    require(0 < options.diaphragm and options.diaphragm + options.thickness < end, "the diaphragm must lie within the pipe")
    require(options.wedge_height < options.diameter, "the wedge must be lower than the pipe")
    refuse_too_many((np.pi * radius**2 * end, options.size))

    def label_of(centres):
        x, y, z = centres.T
        away = np.hypot(y, z)
        labels = np.full(len(centres), LABELS["wall"])
        inner = away < radius * 0.985
        plate = (x > options.diaphragm - 1e-6) & (x < options.diaphragm + options.thickness + 1e-6) & inner
        labels[inner & ~plate] = LABELS["obstacle"]
        labels[plate] = LABELS["diaphragm"]
        labels[x < 1e-9 * end] = LABELS["inlet"]
        labels[x > (1 - 1e-9) * end] = LABELS["outlet"]
        return labels

    def mesh(gmsh):
        occ = gmsh.model.occ
        pipe = occ.addCylinder(0, 0, 0, end, 0, 0, radius)
        ring = occ.addCylinder(options.diaphragm, 0, 0, options.thickness, 0, 0, 2 * radius)
        core = occ.addCylinder(options.diaphragm, 0, 0, options.thickness, 0, 0, hole)
        plate, _ = occ.cut([(3, ring)], [(3, core)])
        height, low = options.wedge_height, -radius
        corners = [occ.addPoint(options.wedge + a, -2 * radius, b) for a, b in ((-height, low), (height, low), (0, low + height))]
        lines = [occ.addLine(corners[k], corners[(k + 1) % 3]) for k in range(3)]
        side = occ.addPlaneSurface([occ.addCurveLoop(lines)])
        wedge = [part for part in occ.extrude([(2, side)], 0, 4 * radius, 0) if part[0] == 3]
        occ.cut([(3, pipe)], plate + wedge)
        occ.synchronize()
        field = gmsh.model.mesh.field
        even = field.add("MathEval")
        field.setString(even, "F", f"{options.size!r}")
        field.setAsBackgroundMesh(even)
        return filled(gmsh, label_of)

    return None, with_gmsh(mesh, "gmsh cannot mesh this pipe", SIZES_OF_FIELDS)
