"""A box between plates, periodic in x: sides left and right with matching nodes, plates bottom and top."""
from tools.meshing.options import add_length, add_pattern, add_size, filled_rectangle
from tools.meshing.outline import rectangle


def add_options(parser):
    add_size(parser, 1 / 32, "L")
    add_length(parser, "--length", 1.0, "L", "period along the plates")
    add_length(parser, "--height", 1.0, "L", "distance of the plates")
    add_pattern(parser, "right")


def build(options):
    outline = rectangle(0, options.length, 0, options.height, "bottom", "right", "top", "left")
    return outline, filled_rectangle(outline, options.length, options.height, options, uniform=("left", "right"))
