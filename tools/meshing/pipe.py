"""A pipe in plane section, |y| <= R, 0 <= x <= L, with a diaphragm and triangular obstacles on both walls."""
import numpy as np

from tools.base.command import non_negative, number, positive
from tools.meshing.options import add_length, require
from tools.meshing.outline import Outline
from tools.meshing.unstructured import SizeNear, triangulated


def add_options(parser):
    parser.add_argument("--size", type=positive, default=0.006, metavar="M", help="element size in the bulk (default %(default)g)")
    add_length(parser, "--radius", 0.1, "M", "half the height R of the pipe")
    add_length(parser, "--length", 1.0, "M", "length L of the pipe")
    parser.add_argument("--diaphragm-position", type=number, default=0.3, metavar="M", help="x of the middle of its plates "
        "(default %(default)g)")
    add_length(parser, "--diaphragm-thickness", 0.01, "M", "thickness of its plates")
    parser.add_argument("--diaphragm-opening", type=number, default=0.1, metavar="M", help="free height between its plates "
        "(default %(default)g)")
    parser.add_argument("--no-diaphragm", action="store_true", help="leave it away")
    parser.add_argument("--obstacle-position", type=number, default=0.6, metavar="M", help="x of the tips of the triangles "
        "(default %(default)g)")
    add_length(parser, "--obstacle-base", 0.1, "M", "their base on the wall")
    add_length(parser, "--obstacle-height", 0.04, "M", "their height")
    parser.add_argument("--no-obstacle", action="store_true", help="leave them away")
    grading = parser.add_argument_group("grading", "sizes as fractions of --size")
    add_length(grading, "--wall-factor", 0.67, "F", "size at walls, plates and triangles")
    grading.add_argument("--wall-band", type=non_negative, default=0.0, metavar="M", help="distance from the wall over which "
        "that size holds (default %(default)g)")
    add_length(grading, "--throat-factor", 0.6, "F", "size in the throats")
    add_length(grading, "--layer-factor", 0.67, "F", "size in the shear layers behind the throats")
    grading.add_argument("--layer-length", type=non_negative, default=0.25, metavar="M", help="length of these zones (default "
        "%(default)g)")
    add_length(grading, "--growth", 0.15, "G", "growth of the size per distance")


def build(options):
    """The outline and the mesh. Raises BadInput for impossible dimensions."""
    refuse_impossible(options)
    outline = pipe_outline(options)
    size = options.size
    starts, ends, _ = outline.sides()
    shortest, least = min(np.linalg.norm(ends - starts, axis=1)), 0.25 * size * options.wall_factor
    require(shortest >= least, f"a side of the outline is {shortest:.3g} long, far shorter than the elements: ask for a --size "
        f"below {4 * shortest / options.wall_factor:.2g} or leave more room")
    near = [
        SizeNear(outline.segments("wall", "diaphragm", "obstacle"), size * options.wall_factor, options.wall_band),
        *throats_and_layers(options),
    ]
    return outline, triangulated(outline, size, near, options.growth)


def refuse_impossible(o):
    for name in ("wall", "throat", "layer"):
        require(getattr(o, f"{name}_factor") <= 1, f"--{name}-factor must be at most 1: it refines")
    require(o.size <= o.radius, f"the element size {o.size:g} is larger than half the height of the pipe, {o.radius:g}")
    zones = []
    if not o.no_diaphragm:
        require(o.diaphragm_opening > 0, f"the diaphragm is closed: its opening is {o.diaphragm_opening:g}")
        require(o.diaphragm_opening < 2 * o.radius, f"the opening of the diaphragm, {o.diaphragm_opening:g}, must be smaller "
            f"than the pipe, {2 * o.radius:g} (--no-diaphragm leaves it away)")
        require(o.size <= o.diaphragm_opening, f"the element size {o.size:g} is larger than the throat of the diaphragm, "
            f"{o.diaphragm_opening:g}")
        half = o.diaphragm_thickness / 2
        zones.append(("diaphragm", o.diaphragm_position - half, o.diaphragm_position + half))
    if not o.no_obstacle:
        throat = 2 * (o.radius - o.obstacle_height)
        require(throat > 0, f"the obstacles meet: their height {o.obstacle_height:g} is not below half the pipe, {o.radius:g}")
        require(o.size <= throat, f"the element size {o.size:g} is larger than the throat between the obstacles, {throat:g}")
        least = 0.25 * o.size * o.wall_factor
        require(o.obstacle_base >= least, f"the base of the obstacles, {o.obstacle_base:g}, is far shorter than the elements: at "
            f"least {least:.2g}")
        half = o.obstacle_base / 2
        zones.append(("obstacle", o.obstacle_position - half, o.obstacle_position + half))
    for name, start, end in zones:
        require(0 < start and end < o.length, f"the {name} reaches from x = {start:g} to {end:g}, not within the pipe from 0 to "
            f"{o.length:g}")
    if len(zones) == 2:
        (_, start1, end1), (_, start2, end2) = sorted(zones, key=lambda zone: zone[1])
        require(end1 < start2, f"diaphragm and obstacle overlap between x = {start2:g} and {min(end1, end2):g}")


def pipe_outline(o):
    """Inlet at the left, outlet at the right; plates and triangles cut out of the pipe."""
    R, bodies = o.radius, []
    if not o.no_diaphragm:
        x, half, y = o.diaphragm_position, o.diaphragm_thickness / 2, -o.diaphragm_opening / 2
        bodies.append([(x - half, -R, "diaphragm"), (x - half, y, "diaphragm"), (x + half, y, "diaphragm"), (x + half, -R, "wall")])
    if not o.no_obstacle:
        x, half, y = o.obstacle_position, o.obstacle_base / 2, -R + o.obstacle_height
        bodies.append([(x - half, -R, "obstacle"), (x, y, "obstacle"), (x + half, -R, "wall")])
    bodies.sort(key=lambda body: body[0][0])
    lower = [(0.0, -R, "wall")] + [corner for body in bodies for corner in body] + [(o.length, -R, "outlet")]
    # The upper wall is the lower one mirrored and run through backwards: the side that
    # leaves a corner is the one that came to it.
    came = ["inlet"] + [name for _, _, name in lower[:-1]]
    upper = [(x, -y, name) for (x, y, _), name in zip(lower, came)][::-1]
    return Outline([lower + upper])


def throats_and_layers(o):
    """Finer zones across each throat and along the two shear layers that leave it."""
    zones = []
    if not o.no_diaphragm:
        half, y = o.diaphragm_thickness / 2, o.diaphragm_opening / 2
        zones.append((o.diaphragm_position, o.diaphragm_position + half, y, half))
    if not o.no_obstacle:
        y = o.radius - o.obstacle_height
        zones.append((o.obstacle_position, o.obstacle_position, y, 0.1 * o.obstacle_base))
    near = []
    for x, behind, y, reach in zones:
        near.append(SizeNear([((x, -y), (x, y))], o.size * o.throat_factor, reach))
        end = min(o.length, behind + o.layer_length)
        if end > behind:
            layers = [((behind, -y), (end, -y)), ((behind, y), (end, y))]
            near.append(SizeNear(layers, o.size * o.layer_factor, 0.1 * o.radius))
    return near
