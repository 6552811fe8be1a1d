"""Particles and contacts of a run for ParaView, from its tables.

    python -m tools.bodies RUN [--out DIR] [--most N]

Writes bodies.pvd and contacts.pvd, with a .vtu file each per time, at the times of the
fields (fields.pvd), else of the rows of particles.csv; open the three together.

bodies: a polygon per particle, whose corners lie on the rim and of which the first lies at
theta (bodies of any shape: a few polygons that overlap), with id, theta (rad), velocity, omega,
radius, density and free (where entries.csv tells them) and contact_force, the sum of its
contacts. contacts: a line per pressing contact, from centre to centre or to the wall, with i,
j, gap, impulse and force. A force is the impulse of the step over its length. Impulses belong
to a step: at a time without rows in the tables contacts.pvd is empty and contact_force is nan.
In a periodic domain what crosses a seam is drawn on both sides. Units are those of the case.
Exit statuses: 0 done, 3 bad input.

In three dimensions bodies are triangulated spheres, of 320 triangles each, with id, velocity,
omega, radius and contact_force; their angles are not recorded.
"""
from pathlib import Path

import meshio
import numpy as np

from tools.base.command import BadInput, Parser, whole
from tools.base.outlines import placed
from tools.base.run_folder import RunFolder, own
from tools.base.tables import write_text
from tools.plot import sphere_bodies
from tools.plot.colour import known
from tools.plot.contact_rows import rows_of, step_length
from tools.plot.film import thinned

CORNERS = 72  # of a polygon: its area is 0.13 % below that of the particle
PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{}</Collection></VTKFile>
"""


def reach(n, theta, radius, minor):
    """From the centre of an ellipse to the point of its rim whose outward normal is n (2,): an array (2,)."""
    along, across = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    a, b = radius**2 * (n @ along), minor**2 * (n @ across)
    return (a * along + b * across) / max(np.hypot(radius * (n @ along), minor * (n @ across)), 1e-300)


def contact_lines(run, time, bodies):
    """The pressing contacts at a time: (lines (m, 2, 2), {name: (m,)}, {id: force (2,)}). bodies: particles_at(time). Without rows
    of particles.csv at that time, the lines are none and the forces None."""
    none = np.zeros((0, 2, 2)), {name: np.zeros(0) for name in ("i", "j", "gap", "impulse", "force")}, None
    if rows_of(run.particles, time) is None:
        return none
    place = {}
    for one, x, y, theta, radius, minor in zip(*bodies):
        place.setdefault(int(one), (np.array([x, y]), theta, radius, minor))
    forces, lines, kept = {one: np.zeros(2) for one in place}, [], []
    rows = rows_of(run.contacts, time) if run.has("contacts") else None
    if rows is None:
        return none[0], none[1], forces
    length, periods = step_length(run, time), np.array(run.period)
    for at, (i, j, gap, nx, ny, impulse) in enumerate(zip(*(rows[name] for name in ("i", "j", "gap", "nx", "ny", "impulse")))):
        i, j, n, force = int(i), int(j), np.array([nx, ny]), impulse / length
        if i in place:
            forces[i] += force * n
        if j in place:
            forces[j] -= force * n
        first, second, towards = (i, j, -n) if i in place else (j, i, n)
        if first not in place:
            continue
        begin, *shape = place[first]
        if second in place:
            step = place[second][0] - begin
            step -= np.where(periods > 0, periods * np.round(step / np.where(periods > 0, periods, 1)), 0)
        elif "x" in rows:
            step = np.array([rows["x"][at], rows["y"][at]]) - begin
        else:
            step = reach(towards, *shape) + gap * towards
        lines.append([begin, begin + step])
        kept.append((i, j, gap, impulse, force))
    if not lines:
        return none[0], none[1], forces
    return np.array(lines), dict(zip(none[1], np.array(kept, float).T)), forces


def polygons(run, time, bodies, forces):
    """The particles at a time as a meshio.Mesh of polygons of CORNERS corners."""
    ids, x, y, theta, radius, minor = bodies
    number, angle = len(ids), 2 * np.pi * np.arange(CORNERS) / CORNERS
    a, b = radius[:, None] * np.cos(angle), minor[:, None] * np.sin(angle)
    c, s = np.cos(theta)[:, None], np.sin(theta)[:, None]
    points = np.stack([x[:, None] + c * a - s * b, y[:, None] + s * a + c * b, np.zeros((number, CORNERS))], axis=2)

    def at(name):
        return np.array([np.interp(time, run.tracks[int(one)]["t"], run.tracks[int(one)][name]) for one in ids], float)
    values = {"id": ids.astype(int), "theta": theta, "velocity": np.column_stack([at("u"), at("v"), np.zeros(number)]),
        "omega": at("omega"), "radius": radius, **known(run, ids)}
    pushed = np.zeros((number, 3))
    pushed[:, :2] = np.nan if forces is None else np.array([forces[int(one)] for one in ids]).reshape(-1, 2)
    values["contact_force"] = pushed
    if run.outlines and number:
        return shaped(run, bodies, values)
    cells = np.arange(number * CORNERS).reshape(number, CORNERS)
    return meshio.Mesh(points.reshape(-1, 3), [("polygon", cells)], cell_data={name: [value] for name, value in values.items()})


def shaped(run, bodies, values):
    """Bodies of any shape as a meshio.Mesh: a polygon for each loop of a body (tools/base/outlines.py), with its values; loops of
    as many points stand in a block."""
    blocks, points, count = {}, [], 0
    for k, (one, x, y, theta) in enumerate(zip(*bodies[:4])):
        for loop in placed(run.outlines[int(one)], x, y, theta):
            cells, owners = blocks.setdefault(len(loop), ([], []))
            cells.append(count + np.arange(len(loop)))
            owners.append(k)
            points.append(np.column_stack([loop, np.zeros(len(loop))]))
            count += len(loop)
    return meshio.Mesh(np.concatenate(points), [("polygon", np.array(cells)) for cells, _ in blocks.values()],
        cell_data={name: [value[owners] for _, owners in blocks.values()] for name, value in values.items()})


def write_series(folder, name, meshes):
    """Writes NAME.pvd and NAME_<number>.vtu of (time, mesh) pairs into a folder, in place of those of an earlier call; returns the
    path of the .pvd."""
    for old in folder.glob(f"{name}_*.vtu"):
        if old.stem.removeprefix(f"{name}_").isdigit() and not old.is_symlink():
            old.unlink()
    listed = []
    for k, (time, mesh) in enumerate(meshes):
        path = folder / f"{name}_{k:06d}.vtu"
        meshio.write(path, mesh, compression="zlib")
        own(path)
        listed.append(f'<DataSet timestep="{time:.12g}" file="{path.name}"/>\n')
    path = folder / f"{name}.pvd"
    write_text(path, PVD.format("".join(listed)))
    return own(path)


def write_bodies(run, out, most=1000):
    """Writes both series of a RunFolder into the folder `out`, at `most` times at most; returns their paths. Raises BadInput where
    the run has no particles."""
    run.columns("particles", *(("u", "v", "w", "omega_x", "omega_y", "omega_z") if run.in_space else ("u", "v", "omega")))
    if not len(run.particles["t"]):
        raise BadInput(f"{run.folder / 'particles.csv'} has no rows: no particle to show")
    frames = run.frames
    if len(frames) > most:
        frames = thinned(run, frames, most)
        print(f"warning: {len(run.frames)} times are more than {most}: every {len(run.frames) / most:.3g}th is written (--most)")
    bodies, contacts = [], []
    for time, _ in frames:
        if run.in_space:
            lines, values, forces = sphere_bodies.contact_lines(run, time)
            bodies.append((time, sphere_bodies.spheres(run, time, forces)))
        else:
            here = run.particles_at(time)
            lines, values, forces = contact_lines(run, time, here)
            bodies.append((time, polygons(run, time, here, forces)))
            lines = np.dstack([lines, np.zeros(lines.shape[:2])])
        points = lines.reshape(-1, 3)
        contacts.append((time, meshio.Mesh(points, [("line", np.arange(len(points)).reshape(-1, 2))],
            cell_data={name: [value] for name, value in values.items()})))
    return [write_series(Path(out), "bodies", bodies), write_series(Path(out), "contacts", contacts)]


def parser():
    """The options."""
    options = Parser(prog="python -m tools.bodies", description=__doc__)
    options.add_argument("run", help="run folder, such as results/pipe_obstacles/default")
    options.add_argument("--out", metavar="DIR", help="where the files go (default: the run folder, beside fields.pvd)")
    options.add_argument("--most", type=whole(2), default=1000, metavar="N", help="most times (default 1000)")
    return options


def main(words=None):
    """Write the files and print where they are; 0."""
    given = parser().parse_args(words)
    run = RunFolder(given.run)
    run.warn_unfinished()
    out = Path(given.out or given.run)
    if not run.has("particles"):
        raise BadInput(f"the run {given.run} has no particles.csv: no particle to show")
    out.mkdir(parents=True, exist_ok=True)
    for path in write_bodies(run, out, given.most):
        print(f"{path.stem}: {path}")
    return 0
