"""The turbulent flows of the suite by OpenFOAM: a second scheme for the k-epsilon model.

    python -m tools.peers.with_openfoam step|driver|pipe|slit [CELLS ...] [--opening M] [--most N] [--keep FOLDER]

simpleFoam (finite volumes) with OpenFOAM's kEpsilon, the model of Launder and Spalding with its standard
constants and wall functions (Comput. Methods Appl. Mech. Eng. 3 (1974) 269; kappa 0.41, E 9), velocity
upwinded linearly, k and epsilon by a limited central scheme. Flows, inlets and quantities of
cases/turbulent_step.edp (step: Kim, Kline & Johnston; driver: Driver & Seegmiller), cases/pipe_flow.edp and
cases/diaphragm_loss.edp (slit), all with -model k-epsilon; but the mesh reaches to the wall, where the suite's
ends a distance before it. Prints a CSV row for each mesh, each begun from a coarser one. Where the residual (the
largest at the beginning of the last iteration) stays above 1e-6, as the limiter makes it, the numbers are means of
ten states of the last quarter of N iterations, and spread is the range of the first. CELLS are in a step height,
in the radius of the pipe, in half the slit. From 10 s for a coarse mesh to 2 minutes for a step of 32 cells.
"""
import shutil
import tempfile
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, Parser, guarded, positive
from tools.peers.openfoam_case import CMU, KAPPA, SHARE, Mesh, from_both_ends, graded, joined, middles, solve

LEAST_DISTANCE = 30.0  # wall units: the mixing length at the inlet is at most kappa (distance + this)
CELLS = {"step": [8, 16, 32], "driver": [8, 16], "pipe": [20, 40], "slit": [8, 16]}


class Flow:
    """A flow: speed and scale, m/s, m; k and mixing length of the inlet; walls at bottom and top of it; the shortest zone
    counted."""
    density = speed = scale = 1.0
    mirrored = False

    def inlet(self, y):
        return np.full(y.shape, self.speed)

    def mixing(self, y):
        distance = np.minimum(self.top - y, np.inf if self.mirrored else y - self.bottom)
        return np.minimum(self.length, KAPPA * (distance + LEAST_DISTANCE * self.nu / (CMU**0.25 * self.k**0.5)))

    def zones(self, mesh, u, side):
        """(from, to) of reversed flow along the lower (-1) or upper (1) walls, between the cells where it turns."""
        cell, middle, normal, length, distance = mesh.along("wall")
        on = np.flatnonzero(normal[:, 1] * side > 0.1)
        on = on[np.argsort(middle[on, 0])]
        x, half = middle[on, 0], 0.5 * length[on] * np.abs(normal[on, 1])
        shear = side * (u[cell, 0] * normal[:, 1] - u[cell, 1] * normal[:, 0])[on] / distance[on]
        i = np.flatnonzero((shear[1:] < 0) != (shear[:-1] < 0))
        turns = x[i] + shear[i] / (shear[i] - shear[i + 1]) * (x[i + 1] - x[i])
        ends = [*(x - half)[:1][shear[:1] < 0], *turns, *(x + half)[-1:][shear[-1:] < 0]]
        found = []
        for start, end in zip(ends[::2], ends[1::2]):
            if found and start - found[-1][1] < self.least:
                start = found.pop()[0]
            found.append((start, end))
        return [zone for zone in found if zone[1] - zone[0] >= self.least]

    def losses(self, mesh, u, p, k):
        """What every flow has. p: kinematic, with 2 k/3, 0 at the outlet."""
        (first, place, _, wide, _), (last, _, _, high, _) = mesh.along("inlet"), mesh.along("outlet")
        given = self.inlet(place[:, 1])
        flux, out = given * wide, u[last, 0] * high
        loss = (p[first] + 0.5 * given**2) @ flux / flux.sum() - 0.5 * (u[last] ** 2).sum(axis=1) @ out / out.sum()
        drop = (p[first] - 2 / 3 * self.k) @ wide / wide.sum() + 2 / 3 * k[last] @ high / high.sum()
        cell, _, _, length, distance = mesh.along("wall")
        plus = CMU**0.25 * k[cell] ** 0.5 * distance / self.nu
        return {"pressure_drop": self.density * drop, "head_loss": self.density * loss, "loss_coefficient": loss
            / (0.5 * (flux.sum() / wide.sum()) ** 2),
                "speed_most": (u**2).sum(axis=1).max() ** 0.5, "flux_defect": out.sum() / flux.sum() - 1,
                "y_plus_least": plus.min(), "y_plus_mean": plus @ length / length.sum(), "y_plus_most": plus.max()}


class Step(Flow):
    bottom, least, k = 0.0, 0.05, 1.5 * 0.01**2

    def __init__(self, ratio, reynolds):
        self.top, self.nu = 1 / (ratio - 1), 1 / reynolds
        self.length = 0.07 * self.top

    def mesh(self, n):
        x = joined(-graded(20, 1 / n, 1 + 0.3 / n)[::-1], graded(25, 1 / n, 1 + 0.15 / n))
        y = joined(np.linspace(-1, 0, n + 1), from_both_ends(self.top, 1 / n, 1 + 0.3 / n) if self.top > 4 else graded(self.top,
            1 / n))
        return Mesh(x, np.tile(y, (len(x), 1)), (middles(x)[:, None] > 0) | (middles(y) > 0))

    def results(self, mesh, u, p, k):
        zone = max((zone for zone in self.zones(mesh, u, -1) if zone[1] > 0), key=lambda zone: zone[1] - zone[0],
            default=(np.nan, np.nan))
        away = np.abs(mesh.centre[:, 0] + 1)
        at = np.flatnonzero(away == away.min())  # a column of cells, upwards
        half = 0.5 * self.top
        profile = np.interp(np.append((np.arange(200) + 0.5) / 200, 1) * half, mesh.centre[at, 1], u[at, 0])
        return {"reattachment_over_height": zone[1], "corner_eddy_over_height": zone[0],
                "displacement_thickness_over_height": half * (1 - profile[:-1] / profile[-1]).mean()}


class Pipe(Flow):
    speed, scale, density, nu, bottom, top, least = 2.0, 0.2, 998.2, 1.0016e-3 / 998.2, -0.1, 0.1, 0.002
    k, length = 1.5 * (0.05 * 2 / 3 * 2.0) ** 2, 0.07 * 0.2
    bodies = (("diaphragm", 0.295, 0.305, 0.05), ("obstacle", 0.55, 0.65, 0.04))  # from, to, height

    def inlet(self, y):
        return self.speed * (1 - (y / self.top) ** 2)

    def mesh(self, n):
        size, (_, a, b, tall), (_, c, d, high) = self.top / n, *self.bodies
        x = joined(a - graded(a, size, 1.02, 2 * size)[::-1], a + graded(b - a, size), b + from_both_ends(c - b, size, 1.02,
            1.5 * size),
                   c + from_both_ends(d - c, size), d + graded(1 - d, size, 1.02, 2 * size))
        level, radius = np.linspace(-1, 1, 2 * n + 1), self.top - high * np.clip(1 - np.abs(2 * x - c - d) / (d - c), 0, 1)
        closed = (np.abs(middles(x) - 0.5 * (a + b)) < 0.5 * (b - a))[:, None] & (np.abs(middles(level)) > 1 - tall / self.top)
        return Mesh(x, radius[:, None] * level, ~closed)

    def results(self, mesh, u, p, k):
        found = {}
        for (body, start, to, tall), limit in zip(self.bodies, (self.bodies[1][1], np.inf)):
            for side, name in ((-1, "lower"), (1, "upper")):
                behind = [zone for zone in self.zones(mesh, u, side) if start - 0.1 * tall < zone[0] < min(to + 2 * tall, limit)
                    and zone[1] > to]
                found[f"{body}_{name}_length"] = max(behind, key=lambda zone: zone[1] - zone[0], default=(0, np.nan))[1] - to
        return found


class Slit(Flow):
    nu, k, length, least, bottom, top, mirrored = 1 / 2e5, 1.5 * 0.02**2, 0.07, 0.02, 0.0, 0.5, True

    def __init__(self, opening):
        self.opening, self.half, self.plate = opening, 0.5 * opening, 0.02 * opening

    def mesh(self, n):
        widths = 0.35 * self.half / n, 1 + 0.8 / n, 1.6 / n
        x = joined(-graded(2, *widths)[::-1], graded(self.plate, self.plate / max(2, n // 8)), self.plate + graded(12, *widths))
        y = joined(self.half - graded(self.half, *widths)[::-1], self.half + graded(self.top - self.half, *widths))
        closed = (np.abs(middles(x) - 0.5 * self.plate) < 0.5 * self.plate)[:, None] & (middles(y) > self.half)
        return Mesh(x, np.tile(y, (len(x), 1)), ~closed, mirrored=True)

    def results(self, mesh, u, p, k):
        cell, place, *_ = mesh.along("middle")
        fastest = u[cell[(place[:, 0] > 0) & (place[:, 0] < 2)], 0].max()
        mises = np.interp(self.opening, np.arange(9) / 10, (0.611, 0.612, 0.616, 0.622, 0.631, 0.644, 0.662, 0.687, 0.722))
        ends = [zone[1] for zone in self.zones(mesh, u, 1) if zone[0] > 0]
        return {"contraction": 1 / (self.opening * fastest), "reattachment_over_step": (ends[-1] - self.plate)
            / (self.top - self.half) if ends else np.nan,
                "loss_over_borda_carnot": self.losses(mesh, u, p, k)["loss_coefficient"] / (1 / (mises * self.opening) - 1) ** 2}


def main():
    parser = Parser(prog="python -m tools.peers.with_openfoam", description=__doc__)
    parser.add_argument("flow", choices=list(CELLS), help="which flow")
    parser.add_argument("cells", metavar="CELLS", type=int, nargs="*", help="cells in a step height, the radius or half the slit "
        "(default: two or three)")
    parser.add_argument("--opening", type=positive, default=0.5, metavar="M", help="height of the slit over that of the channel "
        "(default %(default)g)")
    parser.add_argument("--most", type=int, default=2000, metavar="N", help="most iterations (default %(default)d)")
    parser.add_argument("--keep", metavar="FOLDER", type=Path, help="keep OpenFOAM's input and output there")
    given = parser.parse_args()
    cells = sorted(given.cells or CELLS[given.flow])
    if not shutil.which("simpleFoam"):
        raise BadInput("simpleFoam is not there; Debian's package openfoam has it")
    if cells[0] < 4 or len(set(cells)) < len(cells) or given.flow == "pipe" and any(n % 2 for n in cells):
        raise BadInput("CELLS are different whole numbers from 4 on, even ones in the pipe")
    if not 0.15 <= given.opening <= 0.8 or given.most < SHARE:
        raise BadInput(f"--opening lies within 0.15 and 0.8, --most is at least {SHARE}")
    flow = {"step": lambda: Step(1.5, 44000), "driver": lambda: Step(1.125, 37500), "pipe": Pipe,
        "slit": lambda: Slit(given.opening)}[given.flow]()
    before, chain = None, list(cells)
    while chain[0] >= 12:  # a uniform stream is a start for a coarse mesh only
        chain.insert(0, chain[0] // 4 * 2)
    with tempfile.TemporaryDirectory() as scratch:
        for n in chain:
            folder, mesh = (given.keep or Path(scratch)) / f"{given.flow}_{n}", flow.mesh(n)
            if folder.exists():
                raise BadInput(f"{folder} is there already; name another folder to --keep")
            states, iterations, residual, seconds = solve(flow, mesh, before, folder, given.most)
            before = mesh, states[-1]
            if n not in cells:
                continue
            found = [{**flow.results(mesh, *state[:3]), **flow.losses(mesh, *state[:3])} for state in states]
            first = [next(iter(each.values())) for each in found]
            row = {"cells": n, "cells_in_all": len(mesh.centre), "iterations": iterations, "residual": residual,
                "spread": max(first) - min(first),
                   **{name: np.mean([each[name] for each in found]) for name in found[0]}, "cpu_s": seconds}
            if n == cells[0]:
                print(",".join(row))
            print(",".join(f"{value:.6g}" for value in row.values()), flush=True)


if __name__ == "__main__":
    guarded(main)
