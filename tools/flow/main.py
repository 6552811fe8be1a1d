"""python -m tools.flow FILE ... --out FOLDER: a flow that another program has computed, for point particles.

Makes a folder with the mesh of triangles and the velocities (and k, epsilon) at its nodes, which a case with the macro
caseGiven follows: FreeFem++ -nw cases/given_flow.edp -flow FOLDER. Steady, or at several times, linear in between.

FILE is
  - an OpenFOAM case: its folder or a file in it (NAME.foam); the mesh is one cell deep between empty patches
  - a .vtu, .pvtu or .vtk of plane cells, or of 3-D cells one cell deep (ParaView, foamToVTK, this project); several, one for each
    of --times; or a .pvd, which lists them with their times
  - a table (.csv, .txt, .tsv) with the columns x, y, u, v and perhaps k, epsilon (names of Fluent and ParaView are known too): a
    cloud of points, which is interpolated on the mesh of --mesh; several, one for each of --times. In a plane across y or x its
    columns are x, z, u, w or y, z, v, w. Commas, semicolons, tabs or blanks separate them; of CFD-Post the section [Data] counts

Boundaries are named as in every mesh of the project: inlet, outlet, wall, diaphragm, obstacle, cylinder, lid, axis, left,
right, bottom, top. Patches of OpenFOAM keep such a name, other walls become wall; --label names the rest:
  --label inlet=x<1e-6           sides both of whose ends fulfil it; several conditions: "x>0.2&x<0.3&y<0.1" (m)
  --label outlet=exit1           a patch of OpenFOAM
  --label wall=rest              all sides that have no name yet
The first label that fits a side counts.

A flow with k and omega gets epsilon = 0.09 k omega. Files are in SI units but for lengths, which --scale converts.

Exit statuses: 0 written; 3 a file or option that cannot be used, in one line: missing files or columns, values that are
not finite, no velocities, a 3-D flow, sides without a name.
"""
import argparse
import sys
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, Parser, number, positive
from tools.flow import cloud, openfoam, plane, table_forms, vtk
from tools.flow.save import fluxes, write
from tools.flow.values import at_vertices
from tools.meshing.checks import faults, summary
from tools.meshing.labels import LABELS

# A line warns where the fluxes in and out differ by more than UNBALANCED of the larger, or of LITTLE of the largest speed times the
# length of the boundary, where that is more: hardly anything flows through the walls of a closed vessel. Another line warns where
# fluid passes a wall at THROUGH_WALLS of the largest speed; values in coarse cells, continued to a wall, reach a tenth.
UNBALANCED, LITTLE, THROUGH_WALLS = 0.02, 0.05, 0.25
LEAST_ANGLE = 1e-3  # degrees: cells of a boundary layer are thin
AT_REST = "wall", "diaphragm", "obstacle", "cylinder"
KINDS = ".vtu", ".vtk", ".pvtu"


def parser():
    found = Parser(prog="python -m tools.flow", description=__doc__)
    found.add_argument("files", metavar="FILE", nargs="+", help="the flow")
    found.add_argument("--out", metavar="FOLDER", required=True, help="folder to make; a flow that it holds is replaced")
    found.add_argument("--label", metavar="NAME=WHAT", action="append", default=[], help="names a part of the boundary (see above)")
    found.add_argument("--times", metavar="LIST", help="of a case or .pvd: last (default), all, or FROM:TO; of several files: "
        "their times, as 0,0.1,0.2 (s)")
    found.add_argument("--mesh", metavar="FILE", help="for tables: the mesh to interpolate on, .mesh or gmsh's .msh with named "
        "curves")
    found.add_argument("--velocity", metavar="NAME", help="array of the velocity, or those of its components as U,V (default: U, "
        "velocity, u and v, x-velocity and y-velocity ...)")
    found.add_argument("--values", choices=["points", "cells"], help="of a .vtu that has both: which are taken (default points)")
    found.add_argument("--no-slip", action="store_true", help="the velocity is 0 at the sides named wall, diaphragm, obstacle and "
        "cylinder; for values in cells that come without those at the boundary")
    found.add_argument("--scale", metavar="L", type=positive, default=1.0, help="metres in the file's unit of length (default 1; "
        "--mesh is in metres)")
    return found


def timed(files, words):
    """[(time, file)] of several files, by --times, which ascend. Raises BadInput."""
    if len(files) == 1 and not words:
        return [(0.0, files[0])]
    try:
        times = [number(word) for word in (words or "").split(",")]
    except argparse.ArgumentTypeError:
        raise BadInput(f"--times of {len(files)} files are their times, as 0,0.1,0.2, not '{words or ''}'") from None
    if len(times) != len(files) or any(b <= a for a, b in zip(times, times[1:])):
        raise BadInput(f"--times gives {len(times)} times for {len(files)} files; one each, ascending")
    return list(zip(times, files))


def read(options):
    """(Given, PlaneMesh, cell of each triangle) of the options. Raises BadInput."""
    files, ends = options.files, {Path(file).suffix.lower() for file in options.files}
    rules = plane.rules(options.label)
    if ends <= set(table_forms.KINDS):
        if not options.mesh:
            raise BadInput("a table is a cloud of points; --mesh names the mesh to interpolate it on (python -m tools.mesh own)")
        mesh = cloud.mesh_from(options.mesh)
        if rules:
            mesh.edge_labels = plane.labelled(mesh.points, mesh.edges, {}, {}, rules, options.mesh)
        return cloud.read(timed(files, options.times), options.velocity, mesh, options.scale), mesh, None
    if options.mesh:
        raise BadInput("--mesh is for tables (.csv, .txt, .tsv); other files have their own mesh")
    if ends <= set(KINDS):
        flow = vtk.read(timed(files, options.times), options.velocity, options.values)
    elif len(files) > 1:
        raise BadInput("several files are all .vtu or .vtk, or all tables; of a .pvd or an OpenFOAM case one is given")
    elif ends == {".pvd"}:
        flow = vtk.read(vtk.listed(files[0], options.times), options.velocity, options.values)
    elif ends == {".foam"} or Path(files[0]).is_dir():
        if not Path(files[0]).is_dir() and not Path(files[0]).parent.is_dir():
            raise BadInput(f"cannot read the flow {files[0]}: it is not there")
        flow = openfoam.read(files[0], options.times, options.velocity)
    else:
        raise BadInput(f"{files[0]} is no folder of an OpenFOAM case, .foam, {', '.join(KINDS)}, .pvd, .csv, .txt or .tsv"
            + ("" if Path(files[0]).exists() else ", and is not there"))
    flow.points = flow.points * options.scale
    mesh, owner = plane.mesh_of(flow, rules, files[0])
    return flow, mesh, owner


def main(words=None):
    """Makes the flow of the words (default: those of the command line); returns the exit status. Raises BadInput."""
    options = parser().parse_args(words)
    flow, mesh, owner = read(options)
    if found := faults(mesh, None, least_angle=LEAST_ANGLE):
        raise BadInput(f"the mesh of {options.files[0]}: {found[0]}")
    frames = flow.frames
    if flow.in_cells:
        sides = flow.on_sides or [{}] * len(frames)
        frames = [at_vertices(flow, frame, given) for frame, given in zip(frames, sides)]
    if options.no_slip:
        still = np.unique(mesh.edges[np.isin(mesh.edge_labels, [LABELS[name] for name in AT_REST])])
        for frame in frames:
            frame["u"][still] = frame["v"][still] = 0
    if any(list(frame) != list(frames[0]) for frame in frames):
        raise BadInput(f"{options.files[0]}: some times have k and epsilon, others have none")
    nodes = write(options.out, mesh, flow.times, frames)
    speed = max(np.hypot(frame["u"], frame["v"]).max() for frame in frames)
    into, out, across = fluxes(mesh, nodes[-1])
    span = f"steady (t = {flow.times[0]:g} s)" if len(frames) == 1 else f"{len(frames)} times from {flow.times[0]:g} to " \
        f"{flow.times[-1]:g} s"
    print(f"{options.out}: {summary(mesh)}\n{span}, largest speed {speed:.4g} m/s, {'with' if 'k' in frames[0] else 'no'} k and "
        f"epsilon; values {'of the cells, fitted' if flow.in_cells else 'as given'} at the vertices\n"
        f"flux in {into:.5g}, out {out:.5g} m2/s")
    if flow.unused:
        print(f"warning: {' and '.join(flow.unused)} left out: turbulence needs k, and epsilon or omega, where the velocities are, "
            f"at points or in cells", file=sys.stderr)
    length = np.linalg.norm(np.diff(mesh.points[mesh.edges], axis=1), axis=2).sum()
    if abs(into - out) > UNBALANCED * max(into, out, LITTLE * speed * length):
        print(f"warning: {into:.4g} m2/s flow in, {out:.4g} out; are fields and mesh of one flow, and the fluid incompressible?",
            file=sys.stderr)
    walls = np.isin(mesh.edge_labels, [LABELS[name] for name in AT_REST])
    sides = np.linalg.norm(np.diff(mesh.points[mesh.edges[walls]], axis=1)[:, 0], axis=1)
    fastest = np.max(np.abs(across[walls]) / sides, initial=0)
    if fastest > THROUGH_WALLS * speed:
        print(f"warning: fluid passes sides that are named walls, where particles stop, at up to {fastest:.3g} m/s; name inlets "
            f"and outlets by --label, or set the velocity at walls to 0 by --no-slip", file=sys.stderr)
    return 0
