"""A stream through a rectangle, graded to the place where a body stands or moves up and down, and to its wake."""
from tools.base.command import non_negative, number
from tools.meshing.options import add_length, add_size, require, require_cells
from tools.meshing.outline import rectangle
from tools.meshing.unstructured import SizeNear, triangulated, wake


def add_options(parser):
    add_size(parser, 1 / 12, "L", "element size where the body moves; the others follow it")
    add_length(parser, "--length", 20.0, "L", "length of the rectangle")
    add_length(parser, "--height", 12.0, "L", "height of the rectangle")
    parser.add_argument("--centre", type=number, nargs=2, default=[6.0, 6.0], metavar=("X", "Y"),
        help="middle of the place (default 6 6)")
    add_length(parser, "--stroke", 0.6, "L", "how far the body's centre goes up and down from there")
    add_length(parser, "--reach", 0.8, "L", "distance from its path up to which the elements are of that size")
    add_length(parser, "--coarse-factor", 8.0, "F", "largest size, as a multiple of --size")
    add_length(parser, "--growth", 0.12, "G", "growth of the size per distance")
    add_length(parser, "--wake-factor", 2.0, "F", "size at the start of the wake, as a multiple of --size")
    parser.add_argument("--wake-growth", type=non_negative, default=0.3, metavar="G", help="growth of the size per distance "
        "along the wake, as a multiple of --size (default %(default)g)")
    add_length(parser, "--wake-width", 3.0, "L", "width of the wake")


def build(options):
    o, (x, y) = options, options.centre
    gap = min(x, o.length - x, y - o.stroke, o.height - y - o.stroke) - o.reach
    require(gap > 0, f"the place of the body, {o.reach:g} about ({x:g}, {y - o.stroke:g} to {y + o.stroke:g}), is not within "
        f"{o.length:g} x {o.height:g}")
    require_cells(o.size, o.reach, "the place of the body")
    require(o.coarse_factor >= 1, "--coarse-factor must be at least 1")
    require_cells(o.size * o.coarse_factor, min(o.length, o.height), "a side (--size times --coarse-factor)")
    outline = rectangle(0, o.length, 0, o.height, "bottom", "outlet", "top", "inlet")
    near = [SizeNear([((x, y - o.stroke), (x, y + o.stroke))], o.size, o.reach)]
    near += wake(x, o.length, y, o.size * o.wake_factor, o.size * o.wake_growth, o.wake_width / 2, o.size * o.coarse_factor)
    return outline, triangulated(outline, o.size * o.coarse_factor, near, o.growth)
