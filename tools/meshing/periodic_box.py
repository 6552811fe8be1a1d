"""A box [0, width] x [0, height] periodic both ways: sides left, right, bottom, top with matching nodes."""
from tools.meshing.options import add_length, add_pattern, add_size, filled_rectangle
from tools.meshing.outline import rectangle

SIDES = ("bottom", "right", "top", "left")


def add_options(parser):
    add_size(parser, 1 / 32, "L")
    add_length(parser, "--width", 1.0, "L", "width of the box")
    add_length(parser, "--height", 1.0, "L", "height of the box")
    add_pattern(parser, "right")


def build(options):
    outline = rectangle(0, options.width, 0, options.height, *SIDES)
    return outline, filled_rectangle(outline, options.width, options.height, options, uniform=SIDES)
