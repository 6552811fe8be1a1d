"""A closed box [0, width] x [0, height]: the settling disk's."""
from tools.meshing.options import add_length, add_pattern, add_size, filled_rectangle
from tools.meshing.outline import rectangle


def add_options(parser):
    add_size(parser, 1 / 16, "CM")
    add_length(parser, "--width", 2.0, "CM", "width of the box")
    add_length(parser, "--height", 6.0, "CM", "height of the box")
    add_sides(parser)
    add_pattern(parser, "right")


def add_sides(parser):
    parser.add_argument(
        "--sides",
        choices=["wall", "named"],
        default="wall",
        help="label of the sides: wall (3) on all four, or left, right, bottom, top (11 to 14) (default %(default)s)",
    )


def box_outline(width, height, sides):
    names = ["wall"] * 4 if sides == "wall" else ["bottom", "right", "top", "left"]
    return rectangle(0, width, 0, height, *names)


def build(options):
    outline = box_outline(options.width, options.height, options.sides)
    return outline, filled_rectangle(outline, options.width, options.height, options)
