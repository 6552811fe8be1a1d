"""A circular cylinder in a channel (the DFG benchmark), graded to the cylinder and its wake.

The circle is the regular polygon that the fluid cannot tell from it. A polygon of the circle's
own area has a mean distance r from the centre and waves of amplitude a_m = 2 r/(m n)^2 at the wave
numbers k_m = m n/r round it; a slow flow across waves on a wall, no slip on it, is that over a
smooth wall k a^2 above their mean (Stokes flow to second order in the amplitude). The sum over m
makes the polygon seem larger than it is by 4 zeta(3)/n^3 of r, which is taken off; no constant is
fitted. The drag of DFG 2D-1 on elements a fifth of a side errs by 2.2e-4 for 16 sides and 4.3e-5
for 24, where the polygon of equal area errs by 1.6e-3 and 4.4e-4.
Lift and frequency of the vortices depend on the elements within a diameter of the cylinder
more than on the polygon: --growth first.
"""
from math import cos, pi, sin, sqrt

from tools.base.command import number, positive, whole
from tools.meshing.options import add_length, require
from tools.meshing.outline import Outline, rectangle
from tools.meshing.unstructured import SizeNear, triangulated, wake


ZETA_3 = 1.2020569031595942  # sum of 1/m^3


def polygon_radius(radius, sides):
    """Distance of the corners from the centre, for a circle of this radius."""
    return radius * (1 - 4 * ZETA_3 / sides**3) * sqrt(2 * pi / (sides * sin(2 * pi / sides)))


def add_options(parser):
    parser.add_argument("--size", type=positive, default=0.12, metavar="M", help="largest element size (default %(default)g)")
    add_length(parser, "--length", 2.2, "M", "length of the channel")
    add_length(parser, "--height", 0.41, "M", "height of the channel")
    add_length(parser, "--radius", 0.05, "M", "radius of the cylinder")
    parser.add_argument("--centre", type=number, nargs=2, default=[0.2, 0.2], metavar=("X", "Y"),
        help="its centre (default 0.2 0.2)")
    parser.add_argument("--circle-points", type=whole(8), default=32, metavar="N", help="sides of the polygon (default "
        "%(default)d)")
    add_length(parser, "--growth", 0.15, "G", "growth of the size per distance from the cylinder and the wake")
    add_length(parser, "--wake-factor", 1.6, "F", "size at the start of the wake, as a multiple of a side of the polygon")
    add_length(parser, "--wake-growth", 0.06, "G", "growth of the size per distance along the wake")


def build(options):
    o, (x, y) = options, options.centre
    rp = polygon_radius(o.radius, o.circle_points)
    gap = min(x, o.length - x, y, o.height - y) - rp
    require(gap > 0, f"the cylinder of radius {o.radius:g} at ({x:g}, {y:g}) is not within the channel {o.length:g} x {o.height:g}")
    side = 2 * pi * o.radius / o.circle_points
    require(side <= gap, f"a side of the cylinder's polygon, {side:g}, is larger than its gap to the wall, {gap:g}: ask for more "
        f"--circle-points")
    require(o.size <= o.height / 2, f"the element size {o.size:g} is larger than half the height of the channel, {o.height / 2:g}")
    angles = [2 * pi * k / o.circle_points for k in range(o.circle_points)]
    circle = [(x + rp * cos(angle), y + rp * sin(angle), "cylinder") for angle in angles]
    outline = Outline(rectangle(0, o.length, 0, o.height, "wall", "outlet", "wall", "inlet").loops + [circle])
    near = [SizeNear(outline.segments("cylinder"), side)] + wake(x + rp, o.length, y, side * o.wake_factor, o.wake_growth,
        1.4 * o.radius, o.size)
    return outline, triangulated(outline, o.size, near, o.growth, single=["cylinder"])
