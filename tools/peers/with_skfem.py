"""DFG 2D-1 and the cavity with scikit-fem: Taylor-Hood P2/P1, Newton's method, SuperLU of SciPy.

The channel has isoparametric triangles of second order.
"""
import tempfile
import time

from tools.peers.common import CENTRE, HEIGHT, LENGTH, NU, RADIUS, asked, extrema, parabola, report, towards_walls

import gmsh
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP1, ElementTriP2, ElementVector, LinearForm, MeshTri, MeshTri2
from skfem.helpers import ddot, div, dot, grad, mul


def channel(bulk, circle):
    """The channel by gmsh, with triangles of second order."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    box, disk = gmsh.model.occ.addRectangle(0, 0, 0, LENGTH, HEIGHT), gmsh.model.occ.addDisk(*CENTRE, 0, RADIUS, RADIUS)
    gmsh.model.occ.cut([(2, box)], [(2, disk)])
    gmsh.model.occ.synchronize()
    curves = [tag for _, tag in gmsh.model.getEntities(1)]
    round_ones = [tag for tag in curves if abs(np.array(gmsh.model.occ.getCenterOfMass(1, tag))[:2] - CENTRE).max() < 0.02]
    gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], 1)
    field = gmsh.model.mesh.field
    near, size = field.add("Distance"), field.add("Threshold")
    field.setNumbers(near, "CurvesList", round_ones)
    for name, value in (("InField", near), ("SizeMin", circle), ("SizeMax", bulk), ("DistMin", 0), ("DistMax", 0.3)):
        field.setNumber(size, name, value)
    field.setAsBackgroundMesh(size)
    for name in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{name}", 0)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)
    with tempfile.NamedTemporaryFile(suffix=".msh") as file:
        gmsh.write(file.name)
        gmsh.finalize()
        mesh = MeshTri2.load(file.name)
    return mesh.with_boundaries({
        "inlet": lambda x: x[0] < 1e-9, "wall": lambda x: (x[1] < 1e-9) | (x[1] > HEIGHT - 1e-9),
        "cylinder": lambda x: np.hypot(x[0] - CENTRE[0], x[1] - CENTRE[1]) < 1.2 * RADIUS})


@BilinearForm
def derivative(u, v, w):
    return w["nu"] * ddot(grad(u), grad(v)) + dot(mul(grad(w["flow"]), u) + mul(grad(u), w["flow"]), v)


@LinearForm
def momentum(v, w):
    return w["nu"] * ddot(grad(w["flow"]), grad(v)) + dot(mul(grad(w["flow"]), w["flow"]), v)


@BilinearForm
def divergence(u, q, w):
    return -div(u) * q


def newton(mesh, fixed, given, viscosities):
    """(velocity basis, velocity, residual of the momentum equation, number of unknowns); given(basis, state) sets
    the boundary values on `fixed`."""
    velocity = Basis(mesh, ElementVector(ElementTriP2()), intorder=5)
    pressure = velocity.with_element(ElementTriP1())
    n, m = velocity.N, pressure.N
    B = divergence.assemble(velocity, pressure).tocsr()
    state, p = np.zeros(n), np.zeros(m)
    held = velocity.get_dofs(fixed).all()
    given(velocity, state)
    free = np.setdiff1d(np.arange(n + m - (0 if "cylinder" in fixed else 1)), held)  # a closed box: one pressure is 0
    for number, nu in enumerate(viscosities):
        for step in range(15):
            still = number == 0 and step == 0  # the Stokes flow first
            flow = velocity.interpolate(state * (0 if still else 1))
            J = derivative.assemble(velocity, flow=flow, nu=nu)
            force = (J @ state if still else momentum.assemble(velocity, flow=flow, nu=nu)) + B.T @ p
            residual = np.concatenate([force, B @ state])
            if not still and abs(residual[free]).max() < 1e-12:
                break
            K = sp.bmat([[J, B.T], [B, None]], format="csc")[free][:, free]
            change = np.zeros(n + m)
            change[free] = splu(K).solve(-residual[free])
            state, p = state + change[:n], p + change[n:]
    return velocity, state, force, n + m


def steady(level, size=1.0):
    bulk, circle = (size * width for width in [(0.1, 0.016), (0.06, 0.008), (0.04, 0.005)][level])
    begin = time.process_time()
    mesh = channel(bulk, circle)

    def inlet(basis, state):
        at = basis.get_dofs("inlet").all("u^1")
        state[at] = parabola(basis.doflocs[1, at], 0.3)
    velocity, state, force, unknowns = newton(mesh, ["inlet", "wall", "cylinder"], inlet, [NU])
    at = velocity.get_dofs("cylinder")
    drag, lift = (-force[at.all(name)].sum() * 2 / (0.2**2 * 0.1) for name in ("u^1", "u^2"))
    report(begin, unknowns, drag=drag, lift=lift)


def cavity(level):
    number = [24, 36, 56][level]
    begin = time.process_time()
    grid = towards_walls(np.linspace(0, 1, number + 1))
    mesh = MeshTri.init_tensor(grid, grid).with_boundaries({
        "lid": lambda x: x[1] > 1 - 1e-9, "wall": lambda x: (x[0] < 1e-9) | (x[0] > 1 - 1e-9) | (x[1] < 1e-9)})

    def lid(basis, state):
        state[basis.get_dofs("lid").all("u^1")] = 1
        state[basis.get_dofs("wall").all()] = 0
    velocity, state, _, unknowns = newton(mesh, ["lid", "wall"], lid, [1e-2, 4e-3, 2e-3, 1e-3])
    along = np.linspace(0, 1, 1001)[1:-1]
    middle = np.full_like(along, 0.5)

    def sampled(x, y):
        return (velocity.probes(np.array([x, y])) @ state).reshape(2, -1)
    report(begin, unknowns, **extrema(sampled(middle, along)[0], sampled(along, middle)[1]))


PROBLEMS = {"2d1": steady, "cavity": cavity}
if __name__ == "__main__":
    problem, *further = asked(dict.fromkeys(PROBLEMS, 3), {"2d1": ["SIZE of the elements over the level's"]})
    PROBLEMS[problem](*further)
