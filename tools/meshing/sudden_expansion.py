"""A plane channel that widens at x = 0, symmetric about y = 0; lengths in inlet heights.

The inlet channel is |y| <= 1/2, the one behind |y| <= ratio/2. The mesh is symmetric too,
so that only the flow breaks the symmetry.
"""
import numpy as np

from tools.meshing.options import add_length, add_pattern_structured, add_size, require, require_cells, require_stretch
from tools.meshing.outline import Outline
from tools.meshing.structured import even, gridded, growing, joined


def add_options(parser):
    add_size(parser, 1 / 12, "H", "height of the cells, and their length at the expansion")
    add_length(parser, "--ratio", 3.0, "R", "height behind over height before")
    add_length(parser, "--inlet-length", 3.0, "H", "length of the inlet channel")
    add_length(parser, "--outlet-length", 40.0, "H", "length behind the expansion")
    add_length(parser, "--stretch", 1.04, "R", "ratio of the lengths of neighbouring cells away from the expansion")
    add_length(parser, "--longest", 5.0, "F", "length of the longest cells over their height")
    parser.add_argument("--half", action="store_true", help="only y >= 0, with the label axis on y = 0")
    add_pattern_structured(parser, "alternating")


def build(options):
    o, upper = options, options.ratio / 2
    require(o.ratio > 1, f"--ratio {o.ratio:g} must be larger than 1: the channel widens")
    require_stretch(o.stretch)
    require_cells(o.size, min(0.5, upper - 0.5), "half the inlet or the step")
    xs = joined(
        growing(0.0, -o.inlet_length, o.size, o.stretch, o.longest * o.size)[::-1],
        growing(0.0, o.outlet_length, o.size, o.stretch, o.longest * o.size),
    )
    ys = joined(even(0.0, 0.5, o.size), even(0.5, upper, o.size))
    if not o.half:
        ys = joined(-ys[::-1], ys)
    outline = expansion_outline(o.inlet_length, o.outlet_length, upper, o.half)
    return outline, gridded(outline, xs, ys, o.pattern, keep=lambda x, y: np.logical_or(x > 0, np.abs(y) < 0.5))


def expansion_outline(inlet, outlet, upper, half):
    above = [(outlet, upper, "wall"), (0.0, upper, "wall"), (0.0, 0.5, "wall"), (-inlet, 0.5, "inlet")]
    if half:
        return Outline([[(-inlet, 0.0, "axis"), (outlet, 0.0, "outlet"), *above]])
    below = [(-inlet, -0.5, "wall"), (0.0, -0.5, "wall"), (0.0, -upper, "wall"), (outlet, -upper, "outlet")]
    return Outline([below + above])
