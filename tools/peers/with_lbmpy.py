"""The settling disk with lbmpy: lattice Boltzmann, partially saturated cells.

Noble and Torczynski (Int. J. Mod. Phys. C 9, 1998): each cell's collision is a mean of the
fluid's and of one that turns the populations to the disk's velocity, weighted with the share of
the cell that is solid (sampled 8 x 8 at the rim); the momentum exchanged moves the disk, the
fluid inside which is accelerated with the last step's acceleration. Two relaxation times.
Scene of cases/settling_disk.edp, up to 0.4 s. A level is cells across the diameter and the speed
on the lattice that stands for 5.6 cm/s. cpu_s is without the generation and compilation of the
kernels, as it is without every package's imports.
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

WIDTH, HEIGHT, DIAMETER, START = 2.0, 6.0, 0.25, (1.0, 4.0)  # cm
RATIO, NU, GRAVITY, SPEED, END = 1.25, 0.1, 981.0, 5.6, 0.4
LEVELS = [(8, 0.04), (12, 0.04), (16, 0.04), (24, 0.04)]


class Lattice:
    """The box of nx by ny cells, kernels compiled; the fields of the disk are zero."""

    def __init__(self, nx, ny, rate):
        self.data = ps.create_data_handling((nx, ny), periodicity=False, default_target=ps.Target.CPU)
        source, target = (self.data.add_array(name, values_per_cell=9) for name in ("source", "target"))
        solid = self.data.add_array("solid", values_per_cell=1)
        velocity, force = (self.data.add_array(name, values_per_cell=2) for name in ("velocity", "force"))
        for name in ("source", "target", "solid", "velocity", "force"):  # populations are stored less those at rest
            self.data.fill(name, 0.0, ghost_layers=True)
        cells = PSMConfig(fraction_field=solid, object_velocity_field=velocity, solid_collision=1, max_particles_per_cell=1,
                          object_force_field=force)
        config = LBMConfig(stencil=LBStencil(Stencil.D2Q9), method=Method.TRT, relaxation_rate=rate, compressible=False,
                           zero_centered=True, psm_config=cells)
        rule = create_lb_update_rule(lbm_config=config, lbm_optimisation=LBMOptimisation(symbolic_field=source, symbolic_temporary_field=target))
        self.kernel = ps.create_kernel(rule, ps.CreateKernelConfig(target=ps.Target.CPU)).compile()
        self.walls = LatticeBoltzmannBoundaryHandling(rule.method, self.data, "source", name="walls")
        for side in "NSEW":
            self.walls.set_boundary(NoSlip(), slice_from_direction(side, 2))
        self.ghosts = self.data.ghost_layers_of_field("solid")
        arrays = self.data.cpu_arrays
        self.solid, self.velocity, self.force = arrays["solid"], arrays["velocity"], arrays["force"]
        if self.solid.ndim == 3:
            self.solid = self.solid[..., 0]
        self.walls()  # compiles the boundary's kernels
        self.data.run_kernel(self.kernel)
        self.data.fill("source", 0.0, ghost_layers=True)

    def step(self):
        self.walls()
        self.data.run_kernel(self.kernel)
        self.data.swap("source", "target")


def covered(rx, ry, radius):
    """Share of each cell, centre at (rx, ry) from the disk's, that the disk covers."""
    distance = np.hypot(rx, ry)
    share = (distance < radius).astype(float)
    rim = abs(distance - radius) < 1
    offset = (np.arange(8) + 0.5) / 8 - 0.5
    sx, sy = np.meshgrid(offset, offset, indexing="ij")
    share[rim] = ((rx[rim][:, None, None] + sx) ** 2 + (ry[rim][:, None, None] + sy) ** 2 < radius**2).mean((1, 2))
    return share


def fall(level, end=END):
    """Rows (t, y, v) in cm and s, the number of cells and time.process_time() after compilation."""
    cells, speed = LEVELS[level]
    h = DIAMETER / cells
    dt = speed * h / SPEED
    nx, ny = round(WIDTH / h), round(HEIGHT / h)
    relaxation = 3 * NU * dt / h**2 + 0.5
    lattice = Lattice(nx, ny, 1 / relaxation)
    begin = time.process_time()
    # lattice units; cell centres at whole numbers and a half
    radius, x = cells / 2, np.array(START) / h
    v, before, omega = np.zeros(2), np.zeros(2), 0.0
    fluid = np.pi * radius**2
    mass, inertia, weight = RATIO * fluid, 0.5 * RATIO * fluid * radius**2, np.array([0.0, -(RATIO - 1) * fluid * GRAVITY * dt**2 / h])
    reach, window, rows = int(np.ceil(radius)) + 2, None, []
    for step in range(round(end / dt)):
        if window:
            lattice.solid[window] = 0
            lattice.velocity[window] = 0
        corner = x.astype(int) - reach
        axes = [np.arange(c, c + 2 * reach + 1) + 0.5 - centre for c, centre in zip(corner, x)]
        rx, ry = np.meshgrid(*axes, indexing="ij")
        share = covered(rx, ry, radius)
        window = tuple(slice(c + lattice.ghosts, c + 2 * reach + 1 + lattice.ghosts) for c in corner)
        lattice.solid[window] = share * (relaxation - 0.5) / ((1 - share) + (relaxation - 0.5))
        lattice.velocity[window + (0,)] = v[0] - omega * ry
        lattice.velocity[window + (1,)] = v[1] + omega * rx
        lattice.step()
        exchanged = lattice.force[window]
        force = exchanged.sum((0, 1))
        torque = (rx * exchanged[..., 1] - ry * exchanged[..., 0]).sum()
        last, before = v - before, v
        v = v + (force + fluid * last + weight) / mass
        omega += torque / inertia
        x = x + 0.5 * (v + before)
        if not np.isfinite(v).all():
            print("error: no longer finite; a smaller speed of the lattice is needed")
            raise SystemExit(4)
        rows.append(((step + 1) * dt, x[1] * h, v[1] * h / dt))
    return np.array(rows), nx * ny, begin


def settling(level):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rows, cells, begin = fall(level)
    t, _, v = rows.T
    late = np.linspace(0.3, END, 1001)
    report(begin, 9 * cells, mean_v=np.interp(late, t, v).mean(), steps=len(t))


if __name__ == "__main__":
    problem, level = asked({"settling"}, len(LEVELS))
    settling(level)
