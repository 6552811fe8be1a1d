"""Stability map of the energy: random closed scenes, in which nothing but the weights does work.

A scene is a seed: a box, a funnel whose corner has 20 to 160 degrees, or a heap on a floor; 1 to 40 disks and ellipses, 2 to 10
elements across, with 0.01 to 20 times the fluid's density, at rest, thrown, or spinning. Its budget is held to
kinetic energy <= energy at the start + work, with the dissipation to the same within the order of the scheme, and what all of its
terms leave, the numerical dissipation, to at least 0 within 5 %.
"""
import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from tools.meshing.medit import write
from tools.meshing.outline import Outline
from tools.meshing.unstructured import triangulated
from tools.stress.cells import MAKERS, MAKING, Axis, Cell, Disks, Map, Mesh
from tools.stress.classes import Checks

SCRIPT = "tools/stress/closed_scene.edp"
SIZE = 1 / 16  # elements, m
KINDS = ("box", "funnel", "heap")
STEPS = {0.6: 0.6, 0.3: 0.3, 0.15: 0.15}  # elements that the fastest motion passes in a step
COLUMNS = "id,x,y,radius,density,u,v,omega,aspect,theta"


@dataclass
class Polygon(Mesh):
    """A mesh of a polygon with walls; corners: (x, y), counter-clockwise."""
    corners: tuple = ()

    def make(self, folder):
        """Write it into the folder unless it is there and newer than what makes it; returns the path."""
        path = folder / self.name
        with MAKING:
            if not path.is_file() or path.stat().st_mtime < max(maker.stat().st_mtime for maker in MAKERS):
                write(triangulated(Outline([[(x, y, "wall") for x, y in self.corners]]), SIZE), path)
        return path


@dataclass
class Bodies(Disks):
    """Disks and ellipses: rows with two more columns, aspect and theta."""
    columns: str = field(default=COLUMNS)


@dataclass
class Scene:
    """kind; corners of the domain; rows of particles; viscosity (Pa s); gravity (2), m/s2; start: kinetic energy of the bodies
    (J/m);
    speed: a bound on that of the bodies, m/s; end: s."""
    kind: str
    corners: tuple
    rows: np.ndarray
    mu: float
    gravity: np.ndarray
    start: float
    speed: float
    end: float


def domain(kind, draw):
    """Corners of the domain."""
    if kind == "funnel":
        half = np.radians(draw.uniform(20, 160) / 2)
        wide = min(0.6, 0.9 * np.tan(half))
        tall = wide / np.tan(half)
        return ((0, 0), (wide, tall), (wide, tall + 0.5), (-wide, tall + 0.5), (-wide, tall))
    wide, tall = draw.uniform(0.6, 1.2, 2)
    return ((0, 0), (wide, 0), (wide, tall), (0, tall))


def room(corners, x, y):
    """Distance of a point from the sides of a convex polygon, negative outside."""
    return min(((c - a) * (y - b) - (d - b) * (x - a)) / math.hypot(c - a, d - b) for (a, b), (c, d) in zip(corners,
        (*corners[1:], corners[0])))


def placed(kind, corners, draw):
    """Rows (x, y, radius) of bodies that lie free of each other, in a heap as low as they can."""
    a = np.array(corners, float)
    low, high = a.min(0), a.max(0)
    number, found = int(np.exp(draw.uniform(0, np.log(41)))), []
    mean = SIZE / 2 * draw.uniform(2, 10 if number < 10 else 5)
    for _ in range(number):
        r = min(max(mean * draw.uniform(0.7, 1.4), SIZE), 5 * SIZE)
        best = None
        for _ in range(60):
            x, y = draw.uniform(low, high)
            if room(corners, x, y) < 1.001 * r or any(math.hypot(x - p, y - q) < 1.001 * (r + s) for p, q, s in found):
                continue
            if best is None or (kind == "heap" and y < best[1]):
                best = (x, y, r)
            if kind != "heap":
                break
        if best:
            found.append(best)
    return np.array(found)


@lru_cache(maxsize=None)
def scene(seed):
    """The scene of a seed."""
    draw = np.random.default_rng(seed)
    kind = KINDS[seed % 3]
    corners, at = domain(kind, draw), np.zeros((0, 3))
    while not len(at):
        at = placed(kind, corners, draw)
    n = len(at)
    density = np.exp(draw.uniform(np.log(0.01), np.log(20), n)) if draw.random() < 0.7 else np.full(n,
        np.exp(draw.uniform(np.log(0.01), np.log(20))))
    aspect = np.where(draw.random(n) < 0.4, np.maximum(draw.uniform(0.4, 1, n), SIZE / at[:, 2]), 1.0)
    angle = -np.pi / 2 + draw.normal(0, 0.5)
    gravity = draw.uniform(0.5, 2) * np.array([np.cos(angle), np.sin(angle)])
    fall = np.sqrt(2 * np.hypot(*gravity))
    motion = np.zeros((n, 3))
    how = draw.integers(0, 3)  # at rest, thrown, thrown and spinning
    if how:
        motion[:, :2] = draw.normal(0, 0.4 * fall, (n, 2))
    if how == 2:
        motion[:, 2] = draw.normal(0, 0.4 * fall, n) / at[:, 2]
    area = np.pi * at[:, 2]**2 * aspect
    start = 0.5 * (density * area * ((motion[:, :2]**2).sum(1) + at[:, 2]**2 * (1 + aspect**2) / 4 * motion[:, 2]**2)).sum()
    speed = max(fall, np.abs(motion[:, :2]).max())
    mu = fall * np.median(at[:, 2]) / np.exp(draw.uniform(0, np.log(500)))
    rows = np.column_stack([np.arange(n), at, density, motion, aspect, draw.uniform(0, np.pi, n)])
    return Scene(kind, corners, rows, mu, gravity, start, speed, 2 / fall)


def closed(step, seed):
    """A run of a scene; step: elements that the fastest motion passes."""
    one = scene(int(seed))
    options = {"-mesh": Polygon((one.kind, int(seed)), corners=one.corners), "-particles": Bodies(one.rows), "-mu": one.mu,
        "-gx": one.gravity[0], "-gy": one.gravity[1],
               "-dt": step * SIZE / one.speed, "-tend": one.end, "-every": 0}
    return Cell(SCRIPT, options, Checks({}, one.end, energy=one.start), patience=2)


MAPS = [
    Map("energy", "Closed scenes: the energy that nothing supplies", Axis("step", "elements", list(STEPS), [0.6]),
        Axis("seed", "", list(range(1, 201)), [3, 7, 16, 26, 100, 101]), closed,
        "kinetic energy, and with dissipation, at most the work and the energy at the start; numerical dissipation not negative",
        {"stopped": "a smaller -dt", "blown up": "a smaller -dt"}, (0.3, 1)),
]
