"""A closed box with a fine vertical corridor, where a body falls, and coarse flanks."""
from tools.base.command import non_negative, positive
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
    parser.add_argument("--corridor-bottom", type=non_negative, default=0.0, metavar="CM", help="lower end of the corridor "
        "(default %(default)g)")
    parser.add_argument("--corridor-top", type=positive, metavar="CM", help="upper end of the corridor (default: the height)")
    add_length(parser, "--coarse-factor", 4.0, "F", "largest size beside it, as a multiple of --size")
    add_length(parser, "--growth", 0.25, "G", "growth of the size per distance")
    add_sides(parser)
    add_pattern(parser, "right")


def build(options):
    o = options
    start, end = o.corridor_position - o.corridor_width / 2, o.corridor_position + o.corridor_width / 2
    require(0 < start and end < o.width, f"the corridor reaches from x = {start:g} to {end:g}, not within the box from 0 to "
        f"{o.width:g}")
    bottom, top = o.corridor_bottom, o.corridor_top or o.height
    require(bottom < top <= o.height, f"the corridor reaches from y = {bottom:g} to {top:g}, not upwards within the box from 0 "
        f"to {o.height:g}")
    require(1 <= o.coarse_factor <= 8, "--coarse-factor must be between 1 and 8: cells beyond are too long")
    require_cells(o.size, o.corridor_width, "the corridor")
    require_cells(o.size, o.height, "the height of the box")
    outline = box_outline(o.width, o.height, o.sides)
    if o.pattern == "unstructured":
        middle = [((o.corridor_position, bottom), (o.corridor_position, top))]
        near = [SizeNear(middle, o.size, o.corridor_width / 2)]
        return outline, triangulated(outline, o.size * o.coarse_factor, near, o.growth)
    largest = o.size * o.coarse_factor
    xs, ys = (graded(0.0, low, high, far, o.size, 1 + o.growth, largest) for low, high, far in ((start, end, o.width),
        (bottom, top, o.height)))
    return outline, gridded(outline, xs, ys, o.pattern)


def graded(near, low, high, far, size, ratio, largest):
    """Points from near to far: `size` apart from low to high, growing towards both ends."""
    return joined(even(low, high, size), *(growing(end, beyond, size, ratio, largest) for end, beyond in ((low, near),
        (high, far)) if beyond != end))
