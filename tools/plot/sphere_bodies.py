"""Spheres and their contacts for ParaView: what tools/plot/bodies.py writes of a run in three dimensions.

spheres(run, time, forces) is a meshio.Mesh of triangulated spheres, contact_lines(run, time) its pressing contacts.
"""
from functools import cache

import numpy as np
import meshio

from tools.plot.colour import known
from tools.plot.contact_rows import rows_of, step_length

HALVINGS = 2  # of the edges of an icosahedron: 162 corners and 320 triangles a sphere


@cache
def unit_sphere():
    """Corners (162, 3) on the unit sphere and triangles (320, 3), counterclockwise from outside."""
    g = 0.5 * (1 + np.sqrt(5))
    points = [np.array(p, float) for p in ((-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
        (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1))]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
        (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(HALVINGS):
        middles, finer = {}, []

        def between(a, b):
            key = min(a, b), max(a, b)
            if key not in middles:
                middles[key] = len(points)
                points.append(points[a] + points[b])
            return middles[key]
        for a, b, c in triangles:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = finer
        points = [p / np.linalg.norm(p) for p in points]
    return np.array(points), np.array(triangles)


def contact_lines(run, time):
    """The pressing contacts at a time: (lines (m, 2, 3), {name: (m,)}, {id: force (3,)}). Without rows of particles.csv at that
    time, the lines are none and the forces None."""
    names = "i", "j", "gap", "impulse", "force"
    lines, kept = [], []
    if rows_of(run.particles, time) is None:
        return np.zeros((0, 2, 3)), {name: np.zeros(0) for name in names}, None
    place, periods = {}, np.array(run.period)
    for one, x, y, z, radius in zip(*run.particles_at(time)):  # the first of several images
        place.setdefault(int(one), (np.array([x, y, z]), radius))
    forces = {one: np.zeros(3) for one in place}
    rows = rows_of(run.contacts, time) if run.has("contacts") else None
    if rows is not None:
        length = step_length(run, time)
        for i, j, gap, *n, impulse in zip(*(rows[name] for name in ("i", "j", "gap", "nx", "ny", "nz", "impulse"))):
            i, j, n, force = int(i), int(j), np.array(n), impulse / length
            for one, sign in ((i, 1), (j, -1)):
                if one in forces:
                    forces[one] += sign * force * n
            if i not in place:
                continue
            begin, radius = place[i]
            step = place[j][0] - begin if j in place else -(radius + gap) * n
            if j in place:  # to the nearest image
                step = step - periods * np.round(step / np.where(periods > 0, periods, np.inf))
            lines.append([begin, begin + step])
            kept.append((i, j, gap, impulse, force))
    return np.array(lines).reshape(-1, 2, 3), dict(zip(names, np.array(kept, float).reshape(-1, 5).T)), forces


def spheres(run, time, forces):
    """The spheres at a time as a meshio.Mesh of triangles, with id, velocity, omega, radius, density and free
    (where entries.csv tells them) and contact_force."""
    ids, x, y, z, radius = run.particles_at(time)
    corners, triangles = unit_sphere()
    points = np.column_stack([x, y, z])[:, None] + radius[:, None, None] * corners
    cells = np.arange(len(ids))[:, None, None] * len(corners) + triangles

    def vector(*names):
        tracks = [run.tracks[int(one)] for one in ids]
        return np.array([[np.interp(time, track["t"], track[name]) for name in names] for track in tracks]).reshape(-1, 3)
    pushed = np.full((len(ids), 3), np.nan) if forces is None else np.array([forces[int(one)] for one in ids]).reshape(-1, 3)
    values = {"id": ids.astype(int), "velocity": vector("u", "v", "w"), "omega": vector("omega_x", "omega_y", "omega_z"),
        "radius": radius, **known(run, ids), "contact_force": pushed}
    return meshio.Mesh(points.reshape(-1, 3), [("triangle", cells.reshape(-1, 3))],
        cell_data={name: [np.repeat(value, len(triangles), axis=0)] for name, value in values.items()})
