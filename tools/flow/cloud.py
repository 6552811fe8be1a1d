"""A plane flow from tables of points (CSV: x, y, u, v, and k, epsilon), interpolated on a mesh.

Linear on the triangles of Delaunay between the points (scipy), so second order. A vertex of the mesh outside them takes the linear
function fitted to the nearest points.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay, QhullError, cKDTree

from tools.base.command import BadInput
from tools.base.mesh_files import read_mesh
from tools.flow import table_forms
from tools.flow.given import PLACES, Given, named, plain, require_si, unused
from tools.flow.values import nearest
from tools.meshing import own
from tools.meshing.plane_mesh import PlaneMesh, oriented
from tools.meshing.unstructured import with_gmsh

OUTSIDE_MOST = 0.5  # share of the vertices that may lie outside the points
INSIDE_LEAST = 10  # points in the box around the mesh, or a tenth of all where that is less; fewer tell nothing of its flow
SAME = 1e-9  # of the extent of the points: closer ones are one
APART = 0.01  # of the largest value of a column: by more the values of one point contradict each other
FLAT = 1e-6  # of the extent of the points: below it a direction has none


def mesh_from(path):
    """The PlaneMesh of a .mesh or gmsh's .msh with named curves. Raises BadInput."""
    if not Path(path).is_file():
        raise BadInput(f"cannot read the mesh {path}: it is not there")
    if Path(path).suffix == ".msh":
        return with_gmsh(lambda gmsh: own.read(gmsh, Path(path), None), f"gmsh cannot read '{path}'")
    if Path(path).suffix != ".mesh":
        raise BadInput(f"--mesh takes a .mesh, or a .msh by gmsh, not '{path}'")
    mesh = read_mesh(path)
    return PlaneMesh(mesh.points, oriented(mesh.points, mesh.triangles), mesh.edges, mesh.labels)


def single(points, values, names, file):
    """(points, values) with each point once. Raises BadInput where values of one point contradict each other."""
    pairs = cKDTree(points).query_pairs(SAME * np.ptp(points, axis=0).max(initial=0), output_type="ndarray")
    if not len(pairs):
        return points, values
    apart = np.abs(values[pairs[:, 0]] - values[pairs[:, 1]]) > APART * np.abs(values).max(axis=0)
    if apart.any():
        at = np.flatnonzero(apart.any(axis=1))[0]
        (x, y), name = points[pairs[at, 0]], names[int(np.argmax(apart[at]))]
        many = len(np.unique(pairs[apart.any(axis=1)].min(axis=1)))
        one, other = values[pairs[at], names.index(name)]
        raise BadInput(f"{file}: {many} points stand more than once, with values that contradict each other, one at "
            f"({x:g}, {y:g}) m: {name} is {one:g} and {other:g}; write one plane, at one time")
    keep = np.ones(len(points), bool)
    keep[pairs.max(axis=1)] = False
    return points[keep], values[keep]


def places(low, file):
    """(names of the two places in the plane, its axes) among columns {name in lower case: values}: across it, places do not vary,
    or the points of several planes are the same. Raises BadInput."""
    found = next((names for names in PLACES if sum(name in low for name in names) > 1), None)
    if not found:
        raise BadInput(f"{file} lacks the columns x and y; it has {', '.join(low)}")
    there = [axis for axis in range(3) if found[axis] in low]
    if len(there) == 3:
        extent = [np.ptp(low[name]) for name in found]
        across = next((axis for axis in (2, 1, 0) if extent[axis] <= FLAT * max(extent)), 2)
        there.remove(across)
        if extent[across] > FLAT * max(extent):
            points = np.column_stack([low[found[axis]] for axis in there])
            rounded = np.round(points / (SAME * np.ptp(points, axis=0).max() + 1e-300))
            if len(np.unique(rounded, axis=0)) > 0.5 * len(points):
                raise BadInput(f"{file} is a 3-D flow: its points lie in no plane, {found[across]} goes from "
                    f"{low[found[across]].min():g} to {low[found[across]].max():g}; write a slice of it")
    return [found[axis] for axis in there], there


def require_there(points, mesh, file):
    """Raises BadInput where hardly any of the points lie where the mesh is."""
    low, high = mesh.points.min(axis=0), mesh.points.max(axis=0)
    margin = SAME * (high - low).max()
    inside = int(((points >= low - margin) & (points <= high + margin)).all(axis=1).sum())
    if inside < min(INSIDE_LEAST, len(points) / 10):
        (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
        raise BadInput(f"{file}: {inside} of its {len(points)} points lie where the mesh is, which reaches from x = {low[0]:g} to "
            f"{high[0]:g} and y = {low[1]:g} to {high[1]:g} m, the points from x = {x0:g} to {x1:g} and y = {y0:g} to {y1:g} m; "
            f"are both in the same unit (--scale)?")


def read(files, velocity, mesh, scale):
    """The Given, with values at the vertices of a PlaneMesh, of [(time, file)]; scale: metres in a unit of the tables' places.
    Raises BadInput."""
    flow, names = Given(mesh.points, list(mesh.triangles), [], [], False), None
    warned = False
    for time, file in files:
        if not Path(file).is_file():
            raise BadInput(f"cannot read the flow {file}: it is not there")
        table = table_forms.read(file)
        require_si(table, scale != 1, str(file))
        low = {plain(name): values for name, values in table.items()}
        if not len(next(iter(table.values()))):
            raise BadInput(f"{file} has a header row and no others")
        where, axes = places(low, file)
        points = scale * np.column_stack([low[name] for name in where])
        rest = {name: values for name, values in table.items() if plain(name) not in where}
        frame = named(rest, velocity, str(file), axes)
        names, flow.unused = names or list(frame), unused(rest)
        if list(frame) != names:
            raise BadInput(f"{file} has {', '.join(frame)}, {files[0][1]} has {', '.join(names)}; all times need the same")
        values = np.stack([frame[name] for name in names], axis=1)
        points, values = single(points, values, names, file)
        try:
            found = LinearNDInterpolator(Delaunay(points), values)(mesh.points)
        except (QhullError, ValueError):
            raise BadInput(f"{file} has {len(points)} points, which span no area") from None
        outside = np.isnan(found[:, 0])
        if not outside.all():
            require_there(points, mesh, file)
        if outside.any():
            found[outside], away = nearest(points, values, mesh.points[outside])
            where = f"{outside.sum()} of {len(outside)} vertices of the mesh lie outside the points of {file}, up to " \
                f"{away.max():.3g} m"
            if outside.mean() > OUTSIDE_MOST:
                raise BadInput(f"{where}: the points do not cover the mesh; are both in the same unit (--scale)?")
            if not warned:
                print(f"warning: {where}; they take the linear function of the nearest points", file=sys.stderr)
            warned = True
        for k, name in enumerate(names):
            if name in ("k", "epsilon"):
                found[:, k] = np.maximum(found[:, k], values[:, k].min())
        flow.times.append(time)
        flow.frames.append({name: found[:, k] for k, name in enumerate(names)})
    return flow
