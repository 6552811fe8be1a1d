"""DFG 2D-1, DFG 2D-2, the cavity and a backward-facing step with NGSolve: curved Taylor-Hood elements.

The step is not in the benchmark: a second opinion on cases/backward_step.edp (level 0: a minute).
Steady: order 3/2, Newton's method with UMFPACK. 2D-2: order 3/2, semi-implicit BDF2: Stokes part
implicit and factored once, convection extrapolated.
"""
import sys
import time

from tools.peers.common import CENTRE, HEIGHT, LENGTH, NU, RADIUS, asked, extrema, parabola, report, towards_walls
from tools.study.extrema import vortices

import numpy as np
from netgen.geom2d import SplineGeometry
from netgen.occ import Circle, OCCGeometry, Rectangle, X as AXIS_X
from ngsolve import (CF, H1, BilinearForm, Grad, GridFunction, InnerProduct, Mesh, SetNumThreads, VectorH1, div, dx, x, y)
from ngsolve.meshes import MakeStructured2DMesh

SetNumThreads(1)
SOLVER = "umfpack"


def channel(bulk, circle, order):
    """The channel, its circle curved to the order."""
    shape = Rectangle(LENGTH, HEIGHT).Face() - Circle(CENTRE, RADIUS).Face()
    shape.edges.name = "wall"
    shape.edges.Min(AXIS_X).name, shape.edges.Max(AXIS_X).name = "inlet", "outlet"
    for edge in shape.edges:
        if 0.1 < edge.center.x < 0.3 and 0.1 < edge.center.y < 0.3:
            edge.name, edge.maxh = "cylinder", circle
    mesh = Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=bulk, grading=0.2))
    mesh.Curve(order)
    return mesh


def spaces(mesh, order, dirichlet, closed=False):
    """Taylor-Hood space, its functions and the Stokes form for the viscosity nu."""
    space = VectorH1(mesh, order=order, dirichlet=dirichlet) * H1(mesh, order=order - 1)
    (u, p), (v, q) = space.TnT()
    slack = 1e-10 * p * q

    def stokes(nu):
        return (nu * InnerProduct(Grad(u), Grad(v)) - div(u) * q - div(v) * p - slack) * dx
    return space, stokes, InnerProduct(Grad(u) * u, v) * dx, InnerProduct(u, v) * dx


def newton(state, space, stokes, convection, viscosities):
    """Newton's method for the viscosities one after the other, from the Stokes flow."""
    residual, change = state.vec.CreateVector(), state.vec.CreateVector()
    first = BilinearForm(stokes(viscosities[0])).Assemble()
    residual.data = -first.mat * state.vec
    state.vec.data += first.mat.Inverse(space.FreeDofs(), inverse=SOLVER) * residual
    for nu in viscosities:
        form = BilinearForm(space)
        form += stokes(nu)
        form += convection
        for _ in range(20):
            form.Apply(state.vec, residual)
            form.AssembleLinearization(state.vec)
            change.data = form.mat.Inverse(space.FreeDofs(), inverse=SOLVER) * residual
            state.vec.data -= change
            if abs(InnerProduct(change, residual)) < 1e-24:
                break
    form.Apply(state.vec, residual)
    return residual


def unit_fields(space, mesh):
    """Fields that are 1 on the cylinder in x and in y: a residual tested with them is a force."""
    fields = []
    for way in ((1, 0), (0, 1)):
        field = GridFunction(space)
        field.components[0].Set(CF(way), definedon=mesh.Boundaries("cylinder"))
        fields.append(field.vec)
    return fields


def steady(level, size=1.0, order=3):
    bulk, circle = [(0.12, 0.02), (0.08, 0.012), (0.05, 0.006)][level]
    if order not in range(2, 9):
        print(f"error: the order is a whole number from 2 to 8, not {order:g}", file=sys.stderr)
        sys.exit(3)
    order = int(order)
    begin = time.process_time()
    mesh = channel(size * bulk, size * circle, order)
    space, stokes, convection, _ = spaces(mesh, order, "wall|cylinder|inlet")
    state = GridFunction(space)
    state.components[0].Set(CF((parabola(y, 0.3), 0)), definedon=mesh.Boundaries("inlet"))
    residual = newton(state, space, stokes, convection, [NU])
    drag, lift = (-InnerProduct(residual, field) * 2 / (0.2**2 * 0.1) for field in unit_fields(space, mesh))
    report(begin, space.ndof, drag=drag, lift=lift)


def unsteady(level):
    bulk, circle, step = [(0.1, 0.02, 1e-3), (0.08, 0.012, 5e-4), (0.06, 0.008, 4e-4)][level]
    begin = time.process_time()
    mesh = channel(bulk, circle, 3)
    space, stokes, convection, inertia = spaces(mesh, 3, "wall|cylinder|inlet")
    state = GridFunction(space)
    state.components[0].Set(CF((parabola(y, 1.5), 0)), definedon=mesh.Boundaries("inlet"))
    A, M = BilinearForm(stokes(NU)).Assemble().mat, BilinearForm(inertia).Assemble().mat
    C = BilinearForm(space, nonassemble=True)
    C += convection
    now, last, c, c1, load, rate = (state.vec.CreateVector() for _ in range(6))
    load.data = -A * state.vec
    state.vec.data += A.Inverse(space.FreeDofs(), inverse=SOLVER) * load
    inverse = []
    for a0 in (1.0, 1.5):
        S = M.CreateMatrix()
        S.AsVector().data = a0 * M.AsVector() + step * A.AsVector()
        inverse.append(S.Inverse(space.FreeDofs(), inverse=SOLVER))
    tests = [(f, M.CreateColVector(), A.CreateColVector()) for f in unit_fields(space, mesh)]
    for field, tested, pulled in tests:
        tested.data, pulled.data = M * field, A * field
    now.data, last.data = state.vec, state.vec
    C.Apply(now, c)
    c1.data = c
    rows = []
    for n in range(round(6 / step)):
        later = int(n > 0)
        # in terms of the change of the state, so that boundary values stay
        rate.data = later * 0.5 * (now - last)
        load.data = M * rate
        rate.data = A * now
        rate.data += (1 + later) * c
        rate.data -= later * c1
        load.data -= step * rate
        state.vec.data = now + inverse[later] * load
        rate.data = (1 + 0.5 * later) / step * state.vec - (1 + later) / step * now + 0.5 * later / step * last
        last.data, now.data, c1.data = now, state.vec, c
        C.Apply(now, c)
        rows.append([(n + 1) * step] + [-20 * (InnerProduct(m, rate) + InnerProduct(a, now) + InnerProduct(f, c)) for f, m,
            a in tests])
        if not np.isfinite(rows[-1][1]):
            print("error: no longer finite; a smaller step is needed")
            raise SystemExit(4)
    t, drag, lift = np.array(rows).T
    report(begin, space.ndof, **vortices(t, drag, lift, 4.5))


def cavity(level):
    number = [12, 20, 32][level]
    begin = time.process_time()
    mesh = MakeStructured2DMesh(quads=False, nx=number, ny=number, mapping=lambda a, b: (float(towards_walls(a)),
        float(towards_walls(b))))
    space, stokes, convection, _ = spaces(mesh, 3, "left|right|bottom|top")
    state = GridFunction(space)
    flow = state.components[0]
    flow.Set(CF((1, 0)), definedon=mesh.Boundaries("top"))
    for vertex in mesh.vertices:  # in the upper corners the walls hold, else the cavity leaks
        if vertex.point[1] > 1 - 1e-9 and min(vertex.point[0], 1 - vertex.point[0]) < 1e-9:
            flow.vec[vertex.nr] = 0
    newton(state, space, stokes, convection, [1e-2, 4e-3, 2e-3, 1e-3])
    along = np.linspace(0, 1, 1001)
    middle = np.full_like(along, 0.5)
    report(begin, space.ndof, **extrema(flow(mesh(middle, along))[:, 0], flow(mesh(along, middle))[:, 1]))


def step(level):
    """Reynolds number 800: where the shear changes sign on the lower wall, and on the upper one, in step heights."""
    near, far = [(0.15, 0.3), (0.1, 0.2)][level]
    begin = time.process_time()
    outline = SplineGeometry()
    corners = [outline.AppendPoint(*at) for at in ((-20, 1), (0, 1), (0, 0), (30, 0), (80, 0), (80, 2), (30, 2), (0, 2), (-20, 2))]
    for k, (name, size) in enumerate((("wall", far), ("wall", near), ("wall", near), ("wall", far), ("outlet", far),
                                      ("wall", far), ("wall", near), ("wall", far), ("inlet", far))):
        outline.Append(["line", corners[k], corners[(k + 1) % len(corners)]], bc=name, maxh=size)
    mesh = Mesh(outline.GenerateMesh(maxh=far, grading=0.08))
    space, stokes, convection, _ = spaces(mesh, 3, "wall|inlet")
    state = GridFunction(space)
    state.components[0].Set(CF((6 * (y - 1) * (2 - y), 0)), definedon=mesh.Boundaries("inlet"))
    newton(state, space, stokes, convection, [2 / number for number in (50, 150, 300, *range(400, 801, 50))])
    along, shear = np.linspace(5, 29.9, 20001), Grad(state.components[0])[0, 1]
    found = []
    for height in (1e-9, 2 - 1e-9):
        values = shear(mesh(along, np.full_like(along, height))).ravel()
        k = np.flatnonzero(values[:-1] * values[1:] < 0)
        found += list(along[k] - values[k] * (along[k + 1] - along[k]) / (values[k + 1] - values[k]))
    report(begin, space.ndof, **{f"x{n}": at for n, at in zip((1, 4, 5), found)})


PROBLEMS = {"2d1": steady, "2d2": unsteady, "cavity": cavity, "step": step}
if __name__ == "__main__":
    problem, *further = asked({"2d1": 3, "2d2": 3, "cavity": 3, "step": 2}, {"2d1": ["SIZE of the elements over the level's",
        "ORDER of the velocity, 2 to 8"]})
    PROBLEMS[problem](*further)
