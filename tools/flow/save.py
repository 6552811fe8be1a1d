"""Writing the folder of a flow, in the form that lib/transport/carrier_given.idp reads and describes."""
import hashlib
from pathlib import Path

import numpy as np

from tools.base.command import BadInput
from tools.base.tables import write_text
from tools.flow.values import Middles, sides_of
from tools.meshing.medit import write as write_mesh

MARK = "given_flow 1"


def usable(folder):
    """The folder to write a flow into, made where it is not there. Raises BadInput where it holds something else."""
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"'{folder}' is a file; --out names a folder")
    if folder.is_dir() and any(folder.iterdir()):
        head = folder / "flow.txt"
        if not head.is_file() or head.read_bytes()[:len(MARK)] != MARK.encode():
            raise BadInput(f"'{folder}' is there and holds no flow; give another name")
        head.unlink()  # a program that is stopped from here on leaves no flow that looks whole
        for frame in folder.glob("frame_*.txt"):
            frame.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write(folder, mesh, times, frames):
    """Writes a flow: mesh: a PlaneMesh; times (s), ascending; frames: of each time {"u", "v"[, "k", "epsilon"]: values at the
    vertices}. Returns the frames at all nodes, vertices before middles."""
    folder, middles, nodes = usable(folder), Middles(mesh), []
    write_mesh(mesh, folder / "mesh.mesh")
    a, b = middles.sides.T
    for number, frame in enumerate(frames):
        between = middles(np.stack([frame["u"], frame["v"]], axis=1))
        full = {"u": np.append(frame["u"], between[:, 0]), "v": np.append(frame["v"], between[:, 1])}
        full |= {name: np.append(frame[name], 0.5 * (frame[name][a] + frame[name][b])) for name in frame if name not in full}
        lines = [line for name, values in full.items() for line in (name, str(len(values)), *(f"{value:.8g}" for value in values))]
        write_text(folder / f"frame_{number:05d}.txt", "\n".join([*lines, "whole\n"]))
        nodes.append(full)
    digest = hashlib.sha256((folder / "mesh.mesh").read_bytes()).hexdigest()[:16]
    head = [MARK, f"mesh {digest}", f"turbulence {int('k' in frames[0])}", f"times {len(times)}"]
    write_text(folder / "flow.txt", "\n".join([*head, *(f"{time:.15g}" for time in times), "whole\n"]))
    return nodes


def fluxes(mesh, nodes):
    """(flux in, flux out) through the boundary, m2/s, of values at all nodes, and the flux out of each side (edges), by Simpson's
    rule."""
    n, (a, b), (sides, _) = len(mesh.points), mesh.edges.T, sides_of(mesh.triangles)
    place = {tuple(pair): n + k for k, pair in enumerate(sides.tolist())}
    middle = np.array([place[tuple(pair)] for pair in np.sort(mesh.edges, axis=1).tolist()])
    way = mesh.points[b] - mesh.points[a]  # the domain lies to the left
    u, v = ((nodes[name][a] + 4 * nodes[name][middle] + nodes[name][b]) / 6 for name in ("u", "v"))
    out = u * way[:, 1] - v * way[:, 0]
    return abs(out[out < 0].sum()), out[out > 0].sum(), out
