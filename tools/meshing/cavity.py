"""A square cavity with a lid on top, the cells smaller towards the walls."""
from tools.meshing.options import add_length, add_pattern_structured, add_size, require, require_cells
from tools.meshing.outline import rectangle
from tools.meshing.structured import counted, gridded, towards_ends


def add_options(parser):
    add_size(parser, 1 / 48, "L", "mean size of the cells")
    add_length(parser, "--side", 1.0, "L", "side of the cavity")
    add_length(parser, "--grading", 4.0, "R", "cells in the middle over cells at the walls")
    add_pattern_structured(parser, "alternating")


def build(options):
    o = options
    require_cells(o.size, o.side, "the cavity", least=4)
    require(1 <= o.grading <= 20, "--grading must be between 1 and 20")
    number = 2 * counted(o.side / o.size / 2)  # even: the pattern is symmetric and leaves the corners free
    points = towards_ends(0.0, o.side, number, o.grading)
    outline = rectangle(0, o.side, 0, o.side, "wall", "wall", "lid", "wall")
    return outline, gridded(outline, points, points, o.pattern)
