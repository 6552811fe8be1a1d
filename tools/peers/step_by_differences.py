"""Backward-facing step at Reynolds number 800 by finite differences: a second scheme for its lengths.

    python -m tools.peers.step_by_differences [CELLS ...]

Stream function and vorticity on a grid whose cells are twice as long as high near the step, central
differences of second order, Newton's method with continuation in the Reynolds number: the unknowns
of Erturk (Comput. Fluids 37 (2008) 633). Shares nothing with the suite. CELLS: cells in a step
height, each grid a row of lengths in step heights, the last row extrapolated to no spacing from the
two finest with the error as its square (default 20 30 45: 2 minutes).
"""
import numpy as np
import scipy.sparse as sp
from scipy.interpolate import RegularGridInterpolator
from scipy.sparse.linalg import splu

from tools.base.command import BadInput, Parser, guarded, whole

INLET, OUTLET, EVEN = 20.0, 60.0, 26.0  # lengths before and behind the step, and that of the even grid, heights
CONTINUED = (100, 200, 300, 400, 500, 600, 700, 800)
NAMES = ("x1_lower_reattachment", "x4_upper_separation", "x5_upper_reattachment")


def stretched(length, first, ratio, even):
    """Points from 0 to `length`: `first` apart up to `even`, then growing by `ratio`, at most tenfold."""
    points, width = [0.0], first
    while points[-1] < length:
        if points[-1] > even:
            width = min(width * ratio, 10 * first)
        points.append(points[-1] + width)
    return np.array(points) * length / points[-1]


class Grid:
    """Nodes and difference operators; psi and omega stand at the nodes of the channel, walls included."""

    def __init__(self, cells):
        step = 1 / cells
        self.x = np.concatenate([-stretched(INLET, 2 * step, 1.03, 1.0)[:0:-1], stretched(OUTLET, 2 * step, 1.02, EVEN)])
        self.y = np.arange(2 * cells + 1) * step
        self.edge = edge = np.flatnonzero(self.x == 0)[0]
        i, j = np.meshgrid(np.arange(len(self.x)), np.arange(len(self.y)), indexing="ij")
        there = (i >= edge) | (j >= cells)
        self.number = np.full(there.shape, -1)
        self.number[there] = np.arange(there.sum())
        self.size, self.i, self.j = there.sum(), i[there], j[there]
        i, j = self.i, self.j
        self.upper = j == 2 * cells
        self.lower = ((i > edge) & (j == 0)) | ((i == edge) & (j <= cells)) | ((i < edge) & (j == cells))
        wall = self.upper | self.lower
        self.inlet, self.outlet = (i == 0) & ~wall, (i == len(self.x) - 1) & ~wall
        inner = ~(wall | self.inlet | self.outlet)
        self.inner, self.fixed = sp.diags(inner.astype(float)), sp.diags((wall | self.inlet).astype(float))
        here, a, b = self.at(i[inner], j[inner]), i[inner], j[inner]
        west, east, south, north = self.at(a - 1, b), self.at(a + 1, b), self.at(a, b - 1), self.at(a, b + 1)
        back, ahead = self.x[a] - self.x[a - 1], self.x[a + 1] - self.x[a]
        both = back + ahead
        self.along = self.matrix((here, west, -ahead / (back * both)), (here, here, (ahead - back) / (back * ahead)),
            (here, east, back / (ahead * both)))
        self.across = self.matrix((here, south, -0.5 / step), (here, north, 0.5 / step))
        self.laplace = self.matrix((here, west, 2 / (back * both)), (here, east, 2 / (ahead * both)),
            (here, here, -2 / (back * ahead) - 2 / step**2),
                                   (here, south, 1 / step**2), (here, north, 1 / step**2))
        free, before = self.at(i[self.outlet], j[self.outlet]), self.at(i[self.outlet] - 1, j[self.outlet])
        self.free = self.matrix((free, free, 1.0), (free, before, -1.0))  # nothing changes along x there
        # vorticity at the walls (Thom): omega = -2 (psi inside - psi on the wall)/distance^2; the step's edge has two faces
        faces = [(self.upper, 0, -1, step), (self.lower & (j == 0), 0, 1, step), (self.lower & (j == cells), 0, 1, step),
            (self.lower & (i == edge), 1, 0, self.x[edge + 1])]
        shares = sum(face.astype(float) for face, *_ in faces)
        entries = []
        for face, right, up, distance in faces:
            node, within = self.at(i[face], j[face]), self.at(i[face] + right, j[face] + up)
            weight = 2 / distance**2 / shares[face]
            entries += [(node, within, weight), (node, node, -weight)]
        self.slip = self.matrix(*entries)
        s = np.clip(self.y[j] - 1, 0, 1)  # the parabola of mean velocity 1 at the inlet
        self.psi = np.where(self.upper, 1.0, np.where(self.inlet, 3 * s**2 - 2 * s**3, 0.0))
        self.omega = np.where(self.inlet, 12 * s - 6, 0.0)

    def at(self, i, j):
        return self.number[i, j]

    def matrix(self, *entries):
        """Sparse matrix of (rows, columns, values), summed."""
        rows, columns = (np.concatenate([entry[k] for entry in entries]) for k in (0, 1))
        values = np.concatenate([np.broadcast_to(entry[2], len(entry[0])) for entry in entries])
        return sp.csr_matrix((values, (rows, columns)), (self.size, self.size))

    def solve(self, reynolds, state=None, tolerance=1e-9):
        """psi and omega, (2 size,); Reynolds number on twice the step height."""
        viscosity, n = 2 / reynolds, self.size
        poisson, held = self.laplace + self.fixed + self.free, self.fixed + self.free
        if state is None:  # slow flow
            state = splu(sp.bmat([[poisson, self.inner],
                [self.slip, self.laplace + held]]).tocsc()).solve(np.concatenate([self.psi, self.omega]))
        for _ in range(40):
            psi, omega = state[:n], state[n:]
            u, v, ox, oy = self.across @ psi, -(self.along @ psi), self.along @ omega, self.across @ omega
            carried = viscosity * self.laplace - sp.diags(u) @ self.along - sp.diags(v) @ self.across
            residual = np.concatenate([poisson @ psi + self.inner @ omega - self.psi, carried @ omega + held @ omega + self.slip
                @ psi - self.omega])
            pulled = sp.diags(oy) @ self.along - sp.diags(ox) @ self.across + self.slip
            change = splu(sp.bmat([[poisson, self.inner], [pulled, carried + held]]).tocsc()).solve(residual)
            largest = np.abs(change[:n]).max()
            state = state - min(1.0, 0.3 / max(largest, 1e-30)) * change
            if not np.isfinite(largest):
                break
            if largest < tolerance:
                return state
        raise BadInput(f"no solution at Reynolds number {reynolds} on this grid; take more cells")

    def over(self, other, state):
        """A state of another grid, linearly on this one."""
        def moved(values):
            table = np.zeros(other.number.shape)
            table[other.i, other.j] = values
            return RegularGridInterpolator((other.x, other.y), table)(np.column_stack([self.x[self.i], self.y[self.j]]))
        return np.concatenate([moved(state[:other.size]), moved(state[other.size:])])

    def lengths(self, state):
        """Where the vorticity changes sign on the lower wall (the last place) and on the upper one, heights."""
        found = []
        for wall in (self.lower & (self.j == 0), self.upper & (self.i > self.edge)):
            x, omega = self.x[self.i[wall]], state[self.size:][wall]
            k = np.flatnonzero(omega[:-1] * omega[1:] < 0)
            found.append(x[k] + (x[k + 1] - x[k]) * omega[k] / (omega[k] - omega[k + 1]))
        return found[0][-1:].tolist() + found[1][:2].tolist()


def main():
    parser = Parser(prog="python -m tools.peers.step_by_differences", description=__doc__)
    parser.add_argument("cells", metavar="CELLS", type=whole(15), nargs="*", default=[20, 30, 45],
        help="cells in a step height, at least 15 (default 20 30 45)")
    cells = sorted(parser.parse_args().cells)
    if len(set(cells)) < len(cells):
        raise BadInput("CELLS are different numbers")
    print("cells," + ",".join(NAMES))
    rows, last = [], None
    for count in cells:
        grid, state = Grid(count), None
        if last is not None:
            state = grid.solve(CONTINUED[-1], grid.over(*last))
        else:
            for reynolds in CONTINUED:
                state = grid.solve(reynolds, state)
        last = grid, state
        rows.append(grid.lengths(state))
        print(f"{count}," + ",".join(f"{value:.4f}" for value in rows[-1]), flush=True)
    if len(rows) > 1:
        ratio = (cells[-1] / cells[-2]) ** 2
        print("extrapolated," + ",".join(f"{b + (b - a) / (ratio - 1):.4f}" for a, b in zip(rows[-2], rows[-1])))


if __name__ == "__main__":
    guarded(main)
