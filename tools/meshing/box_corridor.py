"""A closed box with a fine vertical corridor, where a body falls, and coarse flanks."""
from tools.meshing.box import add_sides, box_outline
from tools.meshing.options import add_length, add_pattern, add_size, require, require_cells
from tools.meshing.structured import even, gridded, growing, joined
from tools.meshing.unstructured import SizeNear, triangulated


def add_options(parser):
    add_size(parser, 1 / 32, "CM", "element size in the corridor")
    add_length(parser, "--width", 2.0, "CM", "width of the box")
    add_length(parser, "--height", 6.0, "CM", "height of the box")
    add_length(parser, "--corridor-position", 1.0, "CM", "x of the middle of the corridor")
    add_length(parser, "--corridor-width", 0.75, "CM", "width of the corridor")
    add_length(parser, "--coarse-factor", 4.0, "F", "largest size beside it, as a multiple of --size")
    add_length(parser, "--growth", 0.25, "G", "growth of the size per distance")
    add_sides(parser)
    add_pattern(parser, "right")


def build(options):
    o = options
    start, end = o.corridor_position - o.corridor_width / 2, o.corridor_position + o.corridor_width / 2
    require(0 < start and end < o.width, f"the corridor reaches from x = {start:g} to {end:g}, not within the box from 0 to {o.width:g}")
    require(1 <= o.coarse_factor <= 8, "--coarse-factor must be between 1 and 8: cells beyond are too long")
    require_cells(o.size, o.corridor_width, "the corridor")
    outline = box_outline(o.width, o.height, o.sides)
    if o.pattern == "unstructured":
        middle = [((o.corridor_position, 0.0), (o.corridor_position, o.height))]
        near = [SizeNear(middle, o.size, o.corridor_width / 2)]
        return outline, triangulated(outline, o.size * o.coarse_factor, near, o.growth)
    largest = o.size * o.coarse_factor
    xs = joined(
        growing(start, 0.0, o.size, 1 + o.growth, largest),
        even(start, end, o.size),
        growing(end, o.width, o.size, 1 + o.growth, largest),
    )
    return outline, gridded(outline, xs, even(0, o.height, o.size), o.pattern)
