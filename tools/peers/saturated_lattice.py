"""A box of cells with lbmpy: lattice Boltzmann with two relaxation times, partially saturated cells, in two or three dimensions.

Noble and Torczynski (Int. J. Mod. Phys. C 9, 1998): each cell's collision is a mean of the fluid's and of one that turns the
populations to the body's velocity, weighted with the share of the cell that is solid. All quantities are in cells and steps.
"""
import numpy as np
import pystencils as ps
from lbmpy import LBMConfig, LBMOptimisation, LBStencil, Method, Stencil, create_lb_update_rule
from lbmpy.boundaries import UBB, LatticeBoltzmannBoundaryHandling, NoSlip
from lbmpy.partially_saturated_cells import PSMConfig
from pystencils.slicing import slice_from_direction

STENCILS = {2: Stencil.D2Q9, 3: Stencil.D3Q19}
SIDES = {2: "NSEW", 3: "NSEWTB"}


class Lattice:
    """A box of `shape` cells, two or three numbers, with compiled kernels; `rate`: relaxation rate of the viscosity.

    The fluid is at rest in a closed box; with a `shear` (a cell and step; in the plane only) it lies between plates that move
    against each other, periodic along them. solid, velocity, force: arrays over the cells with `ghosts` layers around them.
    """

    def __init__(self, shape, rate, shear=0.0):
        self.shape = tuple(shape)
        dim = len(self.shape)
        stencil = LBStencil(STENCILS[dim])
        self.data = ps.create_data_handling(self.shape, periodicity=(shear != 0, False) if dim == 2 else False,
            default_target=ps.Target.CPU)
        sizes = {"source": len(stencil), "target": len(stencil), "solid": 1, "velocity": dim, "force": dim}
        fields = {name: self.data.add_array(name, values_per_cell=size) for name, size in sizes.items()}
        for name in sizes:  # populations are stored less those at rest
            self.data.fill(name, 0.0, ghost_layers=True)
        cells = PSMConfig(fraction_field=fields["solid"], object_velocity_field=fields["velocity"], solid_collision=1,
            max_particles_per_cell=1, object_force_field=fields["force"])
        config = LBMConfig(stencil=stencil, method=Method.TRT, relaxation_rate=rate, compressible=False, zero_centered=True,
            psm_config=cells)
        rule = create_lb_update_rule(lbm_config=config, lbm_optimisation=LBMOptimisation(symbolic_field=fields["source"],
            symbolic_temporary_field=fields["target"]))
        self.kernel = ps.create_kernel(rule, ps.CreateKernelConfig(target=ps.Target.CPU)).compile()
        self.walls = LatticeBoltzmannBoundaryHandling(rule.method, self.data, "source", name="walls")
        if shear:
            for side, sign in (("N", 1), ("S", -1)):
                self.walls.set_boundary(UBB((sign * shear * self.shape[1] / 2, 0)), slice_from_direction(side, 2))
        else:
            for side in SIDES[dim]:
                self.walls.set_boundary(NoSlip(), slice_from_direction(side, dim))
        self.seams = self.data.synchronization_function(["source"]) if shear else lambda: None
        self.ghosts = self.data.ghost_layers_of_field("solid")
        arrays = self.data.cpu_arrays
        self.solid, self.velocity, self.force = arrays["solid"], arrays["velocity"], arrays["force"]
        if self.solid.ndim == dim + 1:
            self.solid = self.solid[..., 0]
        self.walls()  # compiles the boundary's kernels
        self.data.run_kernel(self.kernel)
        self.data.fill("source", 0.0, ghost_layers=True)
        if shear:
            self.start_sheared(rule.method, shear, arrays["source"])

    def start_sheared(self, method, shear, source):
        """Populations of the linear flow between the plates."""
        ny = self.shape[1]
        u = shear * (np.arange(ny) + 0.5 - ny / 2)
        for k, ((cx, _), weight) in enumerate(zip(method.stencil, method.weights)):
            source[:, self.ghosts:ny + self.ghosts, k] = float(weight) * (3 * cx * u + 4.5 * (cx * u) ** 2 - 1.5 * u**2)

    def step(self):
        self.seams()
        self.walls()
        self.data.run_kernel(self.kernel)
        self.data.swap("source", "target")


def saturation(share, relaxation):
    """Weight of the solid's collision in cells of which the `share` is solid; `relaxation`: time of the viscosity."""
    return share * (relaxation - 0.5) / ((1 - share) + (relaxation - 0.5))


def shares(inside, centres, rim, samples):
    """Share of each cell that a body covers. centres (..., d): of the cells; inside(points): whether each is in the body;
    rim (...): cells to sample by `samples` points along each axis, the others are judged by their centres."""
    share = inside(centres).astype(float)
    offset = (np.arange(samples) + 0.5) / samples - 0.5
    inner = np.stack(np.meshgrid(*[offset] * centres.shape[-1], indexing="ij"), axis=-1).reshape(-1, centres.shape[-1])
    share[rim] = inside(centres[rim][:, None] + inner).mean(1)
    return share


def finite(velocities):
    """Ends the program where a velocity is none."""
    if not np.isfinite(velocities).all():
        print("error: no longer finite; a smaller speed of the lattice is needed")
        raise SystemExit(4)
