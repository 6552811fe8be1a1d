"""A free sphere in a closed box with lbmpy: lattice Boltzmann, partially saturated cells.

    python -m tools.peers.with_lbmpy_sphere oil4 LEVEL [FACTOR]

cases/settling_sphere.edp with its fourth oil, in the whole box: the method of tools/peers/with_lbmpy.py on 19 velocities, two
relaxation times, cells at the rim sampled 5 x 5 x 5. The report has the peak speed of the fall over 0.128 m/s, the measured speed
of the unbounded fall, of velocities averaged over 21 steps: sound waves in the box make single steps waver.
A level is cells across the diameter and the speed on the lattice that stands for the peak, times FACTOR (1).
cpu_s is without the generation and compilation of the kernels.
"""
import time

from tools.peers.common import asked, report

import warnings

import numpy as np
import pystencils as ps
from lbmpy import LBMConfig, LBMOptimisation, LBStencil, Method, Stencil, create_lb_update_rule
from lbmpy.boundaries import LatticeBoltzmannBoundaryHandling, NoSlip
from lbmpy.partially_saturated_cells import PSMConfig
from pystencils.slicing import slice_from_direction

LEVELS = ((6, 0.05), (8, 0.05), (12, 0.05), (16, 0.05))
BOX, DIAMETER, START, END = (0.1, 0.1, 0.16), 0.015, 0.1275, 0.95  # m, s
SOLID, FLUID, VISCOSITY, GRAVITY = 1120, 960, 0.058, 9.81
UNBOUNDED, PEAK = 0.128, 0.955  # m/s; measured peak over it
SAMPLES, MEAN = 5, 21


class Lattice:
    """A closed box of cells, kernels compiled; fluid at rest and no solid."""

    def __init__(self, shape, rate):
        self.data = ps.create_data_handling(shape, periodicity=False, default_target=ps.Target.CPU)
        source, target = (self.data.add_array(name, values_per_cell=19) for name in ("source", "target"))
        solid = self.data.add_array("solid", values_per_cell=1)
        velocity, force = (self.data.add_array(name, values_per_cell=3) for name in ("velocity", "force"))
        for name in ("source", "target", "solid", "velocity", "force"):  # populations are stored less those at rest
            self.data.fill(name, 0.0, ghost_layers=True)
        cells = PSMConfig(fraction_field=solid, object_velocity_field=velocity, solid_collision=1, max_particles_per_cell=1,
            object_force_field=force)
        config = LBMConfig(stencil=LBStencil(Stencil.D3Q19), method=Method.TRT, relaxation_rate=rate, compressible=False,
            zero_centered=True, psm_config=cells)
        rule = create_lb_update_rule(lbm_config=config, lbm_optimisation=LBMOptimisation(symbolic_field=source,
            symbolic_temporary_field=target))
        self.kernel = ps.create_kernel(rule, ps.CreateKernelConfig(target=ps.Target.CPU)).compile()
        self.walls = LatticeBoltzmannBoundaryHandling(rule.method, self.data, "source", name="walls")
        for side in "NSEWTB":
            self.walls.set_boundary(NoSlip(), slice_from_direction(side, 3))
        self.ghosts = self.data.ghost_layers_of_field("solid")
        arrays = self.data.cpu_arrays
        self.solid, self.velocity, self.force = arrays["solid"], arrays["velocity"], arrays["force"]
        if self.solid.ndim == 4:
            self.solid = self.solid[..., 0]
        self.walls()  # compiles the boundary's kernels
        self.data.run_kernel(self.kernel)
        self.data.fill("source", 0.0, ghost_layers=True)

    def step(self):
        self.walls()
        self.data.run_kernel(self.kernel)
        self.data.swap("source", "target")


def covered(away, radius):
    """Share of each cell, centre at `away` (n, n, n, 3) from the sphere's, that a sphere of this radius (cells) covers."""
    distance = np.linalg.norm(away, axis=-1)
    share = (distance < radius).astype(float)
    rim = abs(distance - radius) < 1
    offset = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    inner = np.stack(np.meshgrid(offset, offset, offset, indexing="ij"), axis=-1).reshape(-1, 3)
    share[rim] = (((away[rim][:, None] + inner) ** 2).sum(-1) < radius**2).mean(1)
    return share


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
        lattice.solid[window] = share * (relaxation - 0.5) / ((1 - share) + (relaxation - 0.5))
        lattice.velocity[window] = v
        lattice.step()
        exchanged = lattice.force[window].reshape(-1, 3).sum(0)
        last, before = v - before, v
        v = v + (exchanged + fluid * last + weight) / mass  # the fluid inside has the acceleration of the last step
        x = x + 0.5 * (v + before)
        found.append(-v[2] * h / dt / UNBOUNDED)
        if not np.isfinite(v).all():
            print("error: no longer finite; a smaller speed of the lattice is needed")
            raise SystemExit(4)
    return np.array(found), int(np.prod(shape)), begin


if __name__ == "__main__":
    _, level, *factor = asked({"oil4": len(LEVELS)}, {"oil4": ["FACTOR of the speed on the lattice"]})
    across, speed = LEVELS[level]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        speeds, number, begin = fall(across, speed * (factor[0] if factor else 1.0))
    report(begin, 19 * number, steps=len(speeds), peak=np.convolve(speeds, np.ones(MEAN) / MEAN, "valid").max())
