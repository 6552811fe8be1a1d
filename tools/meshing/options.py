"""Options that recipes share, and the refusals they have in common."""
from tools.base.command import BadInput, positive
from tools.meshing.structured import PATTERNS, even, gridded
from tools.meshing.unstructured import triangulated


def add_size(parser, size, unit, about="element size"):
    parser.add_argument("--size", type=positive, default=size, metavar=unit, help=f"{about} (default %(default)g)")


def add_length(parser, name, default, unit, about):
    parser.add_argument(name, type=positive, default=default, metavar=unit, help=f"{about} (default %(default)g)")


def add_pattern(parser, default):
    parser.add_argument(
        "--pattern",
        choices=[*PATTERNS, "unstructured"],
        default=default,
        help="right triangles with diagonals all alike or alternating, or no structure (default %(default)s)",
    )


def add_pattern_structured(parser, default):
    parser.add_argument(
        "--pattern", choices=PATTERNS, default=default, help="diagonals of the cells all alike or alternating (default %(default)s)"
    )


def require(true, message):
    """Refuses the options with this line when the statement is not true."""
    if not true:
        raise BadInput(message)


def require_cells(size, gap, what, least=2):
    """Refuses an element size of which fewer than `least` go into a gap."""
    require(size <= gap / least * (1 + 1e-9),
        f"the element size {size:g} is too large for {what} of {gap:g}: at most {gap / least:g}")


def require_stretch(ratio):
    """Refuses a ratio of neighbouring cells by which they would shrink away from the step."""
    require(ratio >= 1, f"--stretch {ratio:g} must be at least 1: cells grow away from the step")


def filled_rectangle(outline, length, height, options, uniform=()):
    """A mesh of [0, length] x [0, height] in the pattern of the options."""
    require_cells(options.size, min(length, height), "a side")
    if options.pattern == "unstructured":
        return triangulated(outline, options.size, uniform=uniform)
    return gridded(outline, even(0, length, options.size), even(0, height, options.size), options.pattern)
