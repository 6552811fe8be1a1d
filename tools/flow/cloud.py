"""A plane flow from tables of points (CSV: x, y, u, v, and k, epsilon), interpolated on a mesh.

Linear on the triangles of Delaunay between the points (scipy), so second order. A vertex of the mesh outside them takes the linear
function fitted to the nearest points.
"""
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay, QhullError

from tools.base.command import BadInput
from tools.base.mesh_files import read_mesh
from tools.base.tables import read_table
from tools.flow.given import PLACE, Given, named, plain
from tools.flow.values import nearest
from tools.meshing import own
from tools.meshing.plane_mesh import PlaneMesh, oriented
from tools.meshing.unstructured import with_gmsh

OUTSIDE_MOST = 0.5  # share of the vertices that may lie outside the points


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


def read(files, velocity, mesh, scale):
    """The Given, with values at the vertices of a PlaneMesh, of [(time, file)]; scale: metres in a unit of the tables' places.
    Raises BadInput."""
    flow, names = Given(mesh.points, list(mesh.triangles), [], [], False), None
    warned = False
    for time, file in files:
        if not Path(file).is_file():
            raise BadInput(f"cannot read the flow {file}: it is not there")
        table = read_table(file, finite=True)
        low = {plain(name): values for name, values in table.items()}
        places = next((pair for pair in PLACE if set(pair) <= set(low)), None)
        if not places:
            raise BadInput(f"{file} lacks the columns x and y; it has {', '.join(table)}")
        points = scale * np.column_stack([low[name] for name in places])
        rest = {name: values for name, values in table.items() if plain(name) not in places}
        frame = named(rest, velocity, str(file))
        names = names or list(frame)
        if list(frame) != names:
            raise BadInput(f"{file} has {', '.join(frame)}, {files[0][1]} has {', '.join(names)}; all times need the same")
        values = np.stack([frame[name] for name in names], axis=1)
        try:
            found = LinearNDInterpolator(Delaunay(points), values)(mesh.points)
        except (QhullError, ValueError):
            raise BadInput(f"{file} has {len(points)} points, which span no area") from None
        outside = np.isnan(found[:, 0])
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
