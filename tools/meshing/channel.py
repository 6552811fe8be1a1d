"""A plane channel: inlet at x = 0, outlet at x = length, walls at y = 0 and y = height."""
from tools.meshing.options import add_length, add_pattern, add_size, filled_rectangle
from tools.meshing.outline import rectangle


def add_options(parser):
    add_size(parser, 1 / 16, "L")
    add_length(parser, "--length", 4.0, "L", "length of the channel")
    add_length(parser, "--height", 1.0, "L", "height of the channel")
    add_pattern(parser, "right")


def build(options):
    outline = rectangle(0, options.length, 0, options.height, "wall", "outlet", "wall", "inlet")
    return outline, filled_rectangle(outline, options.length, options.height, options)
