"""A box between plates, periodic in x: sides left and right with matching nodes, plates bottom and top."""
from tools.base.command import non_negative
from tools.meshing.options import add_length, add_pattern, add_size, filled_rectangle, require, require_cells
from tools.meshing.outline import rectangle
from tools.meshing.structured import even, gridded, growing, joined


def add_options(parser):
    add_size(parser, 1 / 32, "L")
    add_length(parser, "--length", 1.0, "L", "period along the plates")
    add_length(parser, "--height", 1.0, "L", "distance of the plates")
    parser.add_argument("--core", type=non_negative, default=0.0, metavar="L", help="side of the square in the middle that "
        "--size holds for; 0: everywhere (default %(default)g)")
    add_length(parser, "--coarse-factor", 8.0, "F", "largest size beside the core, as a multiple of --size")
    add_length(parser, "--growth", 0.15, "G", "growth of the size from cell to cell beside the core")
    add_pattern(parser, "right")


def around(length, options):
    """Grid points from 0 to length, even in the core, growing towards both ends."""
    start, end, largest = (length - options.core) / 2, (length + options.core) / 2, options.size * options.coarse_factor
    return joined(growing(start, 0.0, options.size, 1 + options.growth, largest), even(start, end, options.size),
                  growing(end, length, options.size, 1 + options.growth, largest))


def build(options):
    o = options
    outline = rectangle(0, o.length, 0, o.height, "bottom", "right", "top", "left")
    if o.core == 0:
        return outline, filled_rectangle(outline, o.length, o.height, o, uniform=("left", "right"))
    require(o.core < min(o.length, o.height), f"the core of {o.core:g} does not fit into {o.length:g} x {o.height:g}")
    require(o.pattern != "unstructured", "a mesh with a core is structured")
    require_cells(o.size, o.core, "the core")
    return outline, gridded(outline, around(o.length, o), around(o.height, o), o.pattern)
