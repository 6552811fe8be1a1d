"""Parts of a mesh by Metis, what they exchange, and a model of a step on more processes than a machine has.

The model adds up what was measured on one and two processes (Cost, Net) over the actual parts of the mesh (Share). It is no
measurement: memory that cores share, a network and processes that wait for each other are not in it.
"""
import math
import re
from dataclasses import dataclass

import numpy as np

from tools.base.command import ROOT
from tools.base.mesh_files import read_mesh
from tools.base.runner import finished, freefem, run_command
from tools.base.space_mesh import read_space_mesh


@dataclass
class Share:
    """What the largest part holds and exchanges: nodes of the velocity with the layers around the part; neighbours; entries that it
    sends and receives when the owners' values of a nodal array, of a vertex array, go to the copies. whole: nodes of the mesh."""
    parts: int
    whole: int
    nodes: int
    neighbours: int
    entries: int
    vertices: int


@dataclass
class Net:
    """Seconds of a message between two processes and of each byte in it; of a sum over two processes."""
    message_s: float
    byte_s: float
    sum_s: float


@dataclass
class Cost:
    """Seconds of a step: of each node that a process holds, of what all processes do alike (fixed_s), of the linear systems of the
    whole mesh, which each process solves (solve_s). Counts of a step: passes to neighbours, arrays of nodes and of vertices in
    them; sums over all processes, numbers in them."""
    node_s: float
    fixed_s: float
    solve_s: float
    passes: float
    arrays: float
    vertex_arrays: float
    sums: float
    numbers: float


def layers():
    """Layers of triangles around a part, as lib/flow/parts_mpi.idp has them."""
    return int(re.search(r"\bpartLayers = (\d+)", (ROOT / "lib/flow/parts_mpi.idp").read_text()).group(1))


def largest_share(elements, piece, around):
    """The Share of a mesh: elements (m, 3) or (m, 4), corners of triangles or tetrahedra; piece (m,): the part of each; around:
    layers of elements around a part. An unknown belongs to the lowest part around it."""
    corners = elements.shape[1]
    pairs = [(a, b) for a in range(corners) for b in range(a)]
    edges = np.sort(np.concatenate([elements[:, pair] for pair in pairs]), axis=1)
    _, number = np.unique(edges[:, 0].astype(np.int64) * (elements.max() + 1) + edges[:, 1], return_inverse=True)
    vertices = elements.max() + 1
    tables = [np.hstack([elements, vertices + number.reshape(len(pairs), -1).T]), elements]
    totals, parts = [vertices + number.max() + 1, vertices], piece.max() + 1
    owners = [np.zeros(total, int) for total in totals]
    for part in range(parts - 1, -1, -1):
        for table, owner in zip(tables, owners):
            owner[table[piece == part]] = part
    nodes, traffic = np.zeros(parts, int), np.zeros((2, parts, parts), int)  # traffic: from owner to part
    for part in range(parts):
        inside = piece == part
        for _ in range(around):
            near = np.zeros(vertices, bool)
            near[elements[inside]] = True
            inside = near[elements].any(axis=1)
        for space, (table, owner) in enumerate(zip(tables, owners)):
            own = owner[np.unique(table[inside])]
            if space == 0:
                nodes[part] = len(own)
            traffic[space, :, part] = np.bincount(own[own != part], minlength=parts)
    both = traffic.sum(axis=1) + traffic.sum(axis=2)
    return Share(parts, totals[0], nodes.max(), (traffic[0] + traffic[0].T > 0).sum(axis=0).max(), both[0].max(), both[1].max())


def shares(path, counts, out):
    """{number of parts: Share} of a mesh file, divided by Metis as a run divides it. out: where the parts are written."""
    head = path.read_text()[:2000]
    dimension = int(re.search(r"Dimension\s+(\d)", head).group(1))
    elements = read_mesh(path).triangles if dimension == 2 else read_space_mesh(path).tetrahedra
    finished(run_command([freefem(), "-nw", "tools/bench/metis_parts.edp", path, dimension, out, *counts], 120))
    around = layers() if dimension == 2 else 1
    return {parts: largest_share(elements, np.loadtxt(f"{out}_{parts}.txt", dtype=int), around) for parts in counts}


def model(cost, share, net):
    """Seconds of a step on as many processes as the Share has parts, by what they go into: {"nodes", "fixed", "systems",
    "messages", "sums", "whole"}. A sum takes log2(processes) rounds; a long one moves its numbers twice, in pieces."""
    parts = share.parts
    rounds = math.ceil(math.log2(parts))
    found = {"nodes": cost.node_s * share.nodes, "fixed": cost.fixed_s, "systems": cost.solve_s, "messages": 0.0, "sums": 0.0}
    if parts > 1:
        found["messages"] = cost.passes * share.neighbours * net.message_s + 8 * net.byte_s * (
            cost.arrays * share.entries + cost.vertex_arrays * share.vertices)
        found["sums"] = cost.sums * rounds * net.sum_s + 8 * net.byte_s * cost.numbers * 2 * (parts - 1) / parts
    return {**found, "whole": sum(found.values())}


def line_through(sizes, times):
    """(seconds of one, seconds of none) of the straight line through two times; where it would start below 0, through 0 and the
    longer time."""
    slope = (times[1] - times[0]) / (sizes[1] - sizes[0])
    fixed = times[0] - slope * sizes[0]
    return (slope, fixed) if fixed > 0 else (times[1] / sizes[1], 0.0)


def net_of(log):
    """The Net of the output of ping_pong.edp: the shortest message, and what a long one takes more for each byte."""
    messages = [(float(size), float(time)) for size, time in re.findall(r"^message (\S+) (\S+)$", log, flags=re.M)]
    size, time = max(messages)
    first = min(time for _, time in messages)
    return Net(first, (time - first) / size, float(re.search(r"^sum (\S+)$", log, flags=re.M).group(1)))
