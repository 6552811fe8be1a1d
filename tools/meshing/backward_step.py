"""A backward-facing step of expansion ratio 2 (Erturk 2008), lengths in step heights.

The step's edge stands at (0, 1); the channel behind it is 0 <= y <= 2, the inlet channel
1 <= y <= 2. Erturk places the inlet 20 step heights upstream.
"""
import numpy as np

from tools.base.command import non_negative
from tools.meshing.options import add_length, add_pattern_structured, add_size, require_cells, require_stretch
from tools.meshing.outline import Outline
from tools.meshing.structured import even, gridded, growing, joined


def add_options(parser):
    add_size(parser, 1 / 12, "H", "height of the cells, and their length at the step")
    parser.add_argument("--inlet-length", type=non_negative, default=20.0, metavar="H", help="length of the inlet channel, 0 for "
        "none (default %(default)g)")
    add_length(parser, "--outlet-length", 60.0, "H", "length behind the step")
    add_length(parser, "--stretch", 1.04, "R", "ratio of the lengths of neighbouring cells away from the step")
    add_length(parser, "--longest", 6.0, "F", "length of the longest cells over their height")
    add_pattern_structured(parser, "alternating")


def build(options):
    o = options
    require_stretch(o.stretch)
    require_cells(o.size, 1.0, "the inlet channel")
    outline = step_outline(o.inlet_length, o.outlet_length)
    pieces = [growing(0.0, o.outlet_length, o.size, o.stretch, o.longest * o.size)]
    if o.inlet_length > 0:
        pieces.append(growing(0.0, -o.inlet_length, o.size, o.stretch, o.longest * o.size)[::-1])
    ys = joined(even(0.0, 1.0, o.size), even(1.0, 2.0, o.size))
    return outline, gridded(outline, joined(*pieces), ys, o.pattern, keep=lambda x, y: np.logical_or(x > 0, y > 1))


def step_outline(inlet, outlet):
    return Outline([[
        (-inlet, 1.0, "wall" if inlet > 0 else "inlet"),
        (0.0, 1.0, "wall"),
        (0.0, 0.0, "wall"),
        (outlet, 0.0, "outlet"),
        (outlet, 2.0, "wall"),
        (-inlet, 2.0, "inlet"),
    ]])
