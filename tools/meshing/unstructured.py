"""Unstructured meshes by gmsh, with element sizes that grow away from given lines."""
import signal
import sys
import threading
from dataclasses import dataclass
from functools import partial
from math import ceil, dist

import numpy as np

from tools.base.command import BadInput
from tools.meshing.plane_mesh import finished, labels_on

MOST_VERTICES = 2_000_000
PATIENCE = 60.0  # s after which a line says that gmsh still works


@dataclass
class SizeNear:
    """Element size along segments (pairs of points; a point is a segment of no length).

    size holds up to the distance `reach`; beyond, it grows to the bulk size.
    """

    segments: list
    size: float
    reach: float = 0.0


def wake(start, end, y, size, growth, reach, coarsest, number=8):
    """Pieces along a wake from x = start to end, each a little coarser than the one before: size at the start, plus growth times
    the
    distance from there, within `reach` of the line. Those that are no finer than `coarsest` are left out."""
    edges = [start + (end - start) * part / number for part in range(number + 1)]
    pieces = [SizeNear([((a, y), (b, y))], size + growth * (a - start), reach) for a, b in zip(edges, edges[1:])]
    return [piece for piece in pieces if piece.size < coarsest]


def triangulated(outline, size, near=(), growth=0.2, uniform=(), single=()):
    """A mesh of the outline: elements of `size`, finer near some lines.

    near: list of SizeNear. growth: change of element size per distance. uniform: labels
    whose sides are divided evenly (periodic sides, so that nodes match). single: labels
    whose sides stay one edge each. Raises BadInput when far too many vertices would come.
    """
    refuse_too_many(outline, size, near)

    def mesh(gmsh):
        surface = add_outline(gmsh, outline, size, uniform, single)
        set_sizes(gmsh, size, near, growth)
        gmsh.model.mesh.generate(2)
        points, triangles, _ = extracted(gmsh, [surface])
        return finished(points[:, :2], triangles, partial(labels_on, outline=outline))

    sizes = {"Mesh.MeshSizeExtendFromBoundary": 0, "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeFromCurvature": 0,
        "Mesh.Smoothing": 5}
    return with_gmsh(mesh, "gmsh cannot mesh this domain", sizes)


def with_gmsh(work, refusal, options=None):
    """work(gmsh) with gmsh set up, quiet and on one core; its exceptions become BadInput with the refusal before them. Where curves
    cross gmsh may search for ever: after PATIENCE seconds a line on the error stream says so."""
    try:
        import gmsh
    except (ImportError, OSError) as problem:
        raise BadInput(f"gmsh cannot be loaded ({problem}); make setup installs it") from None
    done, failed = [], []

    def session():
        """The work, in a thread: Ctrl-C and SIGTERM reach the one that waits for it, at once."""
        try:
            # 6: frontal-Delaunay
            for option, value in ({"General.Terminal": 0, "General.NumThreads": 1, "Mesh.Algorithm": 6} | (options or {})).items():
                gmsh.option.setNumber(option, value)
            done.append(work(gmsh))
        except Exception as problem:  # gmsh raises plain Exception with its last message
            failed.append(problem)
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    if threading.current_thread() is threading.main_thread():  # the only one that may
        for number in (signal.SIGTERM, signal.SIGHUP):  # from which gmsh has taken their answers
            signal.signal(number, signal.getsignal(number))
    thread = threading.Thread(target=session, daemon=True)
    thread.start()
    thread.join(PATIENCE)
    if thread.is_alive():
        print(f"note: gmsh has been at work for {PATIENCE:g} s; where curves cross each other (a hole that reaches over a side) it "
            "never ends: stop it and look at the geometry", file=sys.stderr, flush=True)
        thread.join()
    gmsh.finalize()
    if failed and isinstance(failed[0], BadInput):
        raise failed[0]
    if failed:
        raise BadInput(f"{refusal}: {failed[0]}")
    return done[0]


def refuse_too_many(outline, size, near):
    vertices = outline.area() / (0.87 * size**2)
    for zone in near:
        length = sum(dist(a, b) for a, b in zone.segments)
        vertices += length * max(2 * zone.reach, zone.size) / (0.87 * zone.size**2)
    if vertices > MOST_VERTICES:
        raise BadInput(f"these sizes would make about {vertices:.1e} vertices; at most {MOST_VERTICES:.0e} are made: ask for "
            f"larger elements")


def add_outline(gmsh, outline, size, uniform, single):
    """The outline as a surface of the geo kernel; its tag."""
    geo, loops = gmsh.model.geo, []
    divisions = {}
    for loop in outline.loops:
        points = [geo.addPoint(x, y, 0) for x, y, _ in loop]
        lines = []
        for k, (x, y, name) in enumerate(loop):
            after = (k + 1) % len(loop)
            line = geo.addLine(points[k], points[after])
            lines.append(line)
            if name in single:
                divisions[line] = 1
            elif name in uniform:
                divisions[line] = max(1, round(dist((x, y), loop[after][:2]) / size))
        loops.append(geo.addCurveLoop(lines))
    surface = geo.addPlaneSurface(loops)
    geo.synchronize()
    for line, number in divisions.items():
        gmsh.model.mesh.setTransfiniteCurve(line, number + 1)
    return surface


def set_sizes(gmsh, size, near, growth):
    """The least of the bulk size and the sizes near the given segments as background field."""
    field, fields = gmsh.model.mesh.field, []
    bulk = field.add("MathEval")
    field.setString(bulk, "F", repr(float(size)))
    fields.append(bulk)
    for zone in near:
        points, lines, longest = [], [], 0.0
        for a, b in zone.segments:
            ends = [gmsh.model.geo.addPoint(*end, 0) for end in (a, b)]
            if a == b:
                points.append(ends[0])
            else:
                lines.append(gmsh.model.geo.addLine(*ends))
                longest = max(longest, dist(a, b))
        gmsh.model.geo.synchronize()
        for line in lines:  # only a ruler for distances: it is not divided
            gmsh.model.mesh.setTransfiniteCurve(line, 2)
        distance = field.add("Distance")
        field.setNumbers(distance, "PointsList", points)
        field.setNumbers(distance, "CurvesList", lines)
        field.setNumber(distance, "Sampling", min(20000, max(3, ceil(2 * longest / zone.size))))  # ends do not count
        threshold = field.add("Threshold")
        field.setNumber(threshold, "InField", distance)
        field.setNumber(threshold, "SizeMin", min(zone.size, size))
        field.setNumber(threshold, "SizeMax", size)
        field.setNumber(threshold, "DistMin", zone.reach)
        field.setNumber(threshold, "DistMax", zone.reach + max(size - zone.size, 1e-12 * size) / growth)
        fields.append(threshold)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", fields)
    field.setAsBackgroundMesh(least)


def extracted(gmsh, surfaces):
    """Points (n, 3) and triangles (m, 3) of meshed surfaces ([-1]: of all), numbered from 0, and the number of each node's tag (-1:
    of none of them)."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    corners = np.concatenate([gmsh.model.mesh.getElementsByType(2, surface)[1] for surface in surfaces])
    used, triangles = np.unique(corners.astype(int), return_inverse=True)
    row, number = (np.full(int(tags.max(initial=0)) + 1, -1) for _ in range(2))
    row[tags.astype(int)] = np.arange(len(tags))
    number[used] = np.arange(len(used))
    return coordinates.reshape(-1, 3)[row[used]], triangles.reshape(-1, 3), number
