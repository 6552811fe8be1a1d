"""A free sphere in a closed box with lbmpy: lattice Boltzmann, partially saturated cells.

    python -m tools.peers.with_lbmpy_sphere oil4 LEVEL [FACTOR]

cases/settling_sphere.edp with its fourth oil, in the whole box, on the lattice of tools/peers/saturated_lattice.py
with 19 velocities, cells at the rim sampled 5 x 5 x 5. The report has the peak speed of the fall over 0.128 m/s, the
measured speed of the unbounded fall, of velocities averaged over 21 steps: sound waves in the box make single steps
waver.
A level is cells across the diameter and the speed on the lattice that stands for the peak, times FACTOR (1).
cpu_s is without the generation and compilation of the kernels.
"""
import time

from tools.peers.common import asked, report

import warnings

import numpy as np

from tools.peers.saturated_lattice import Lattice, finite, saturation, shares

LEVELS = ((6, 0.05), (8, 0.05), (12, 0.05), (16, 0.05))
BOX, DIAMETER, START, END = (0.1, 0.1, 0.16), 0.015, 0.1275, 0.95  # m, s
SOLID, FLUID, VISCOSITY, GRAVITY = 1120, 960, 0.058, 9.81
UNBOUNDED, PEAK = 0.128, 0.955  # m/s; measured peak over it
SAMPLES, MEAN = 5, 21


def covered(away, radius):
    """Share of each cell, centre at `away` (n, n, n, 3) from the sphere's, that a sphere of this radius (cells) covers."""
    return shares(lambda point: (point**2).sum(-1) < radius**2, away, abs(np.linalg.norm(away, axis=-1) - radius) < 1, SAMPLES)


def fall(cells, speed):
    """Speeds (n,) of the fall over that of the unbounded one, the number of cells, and time.process_time() after compilation."""
    h = DIAMETER / cells
    dt = speed * h / (PEAK * UNBOUNDED)
    shape = tuple(round(side / h) for side in BOX)
    relaxation = 3 * VISCOSITY / FLUID * dt / h**2 + 0.5
    lattice = Lattice(shape, 1 / relaxation)
    begin = time.process_time()
    radius, reach, fluid = cells / 2, int(np.ceil(cells / 2)) + 2, np.pi / 6 * cells**3
    mass, weight = SOLID / FLUID * fluid, np.array([0, 0, -(SOLID / FLUID - 1) * fluid * GRAVITY * dt**2 / h])
    x, v, before, window, found = np.array([shape[0] / 2, shape[1] / 2, START / h]), np.zeros(3), np.zeros(3), None, []
    for _ in range(round(END / dt)):
        if window:
            lattice.solid[window] = 0
            lattice.velocity[window] = 0
        ranges = [np.arange(first, first + 2 * reach + 1) for first in np.floor(x).astype(int) - reach]
        window = tuple(slice(one[0] + lattice.ghosts, one[-1] + 1 + lattice.ghosts) for one in ranges)
        share = covered(np.stack(np.meshgrid(*(one + 0.5 - c for one, c in zip(ranges, x)), indexing="ij"), axis=-1), radius)
        lattice.solid[window] = saturation(share, relaxation)
        lattice.velocity[window] = v
        lattice.step()
        exchanged = lattice.force[window].reshape(-1, 3).sum(0)
        last, before = v - before, v
        v = v + (exchanged + fluid * last + weight) / mass  # the fluid inside has the acceleration of the last step
        x = x + 0.5 * (v + before)
        found.append(-v[2] * h / dt / UNBOUNDED)
        finite(v)
    return np.array(found), int(np.prod(shape)), begin


if __name__ == "__main__":
    _, level, *factor = asked({"oil4": len(LEVELS)}, {"oil4": ["FACTOR of the speed on the lattice"]})
    across, speed = LEVELS[level]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        speeds, number, begin = fall(across, speed * (factor[0] if factor else 1.0))
    report(begin, 19 * number, steps=len(speeds), peak=np.convolve(speeds, np.ones(MEAN) / MEAN, "valid").max())
