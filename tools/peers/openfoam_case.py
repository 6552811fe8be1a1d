"""A steady turbulent flow for OpenFOAM: a mesh of quadrilaterals, the files of a case, and simpleFoam.

Finite volumes, k-epsilon with wall functions (kappa 0.41, E 9); linear upwinding of the velocity, a limited
central scheme for k and epsilon. A flow (tools/peers/with_openfoam.py) has speed, scale (m/s, m), nu (m2/s),
and at the inlet inlet(y) (m/s), k (m2/s2), mixing(y) (m).
"""
import os
import re
import subprocess

import numpy as np
from scipy.interpolate import NearestNDInterpolator

from tools.base.command import BadInput

CMU, KAPPA, ROUGH = 0.09, 0.41, 9.0
TOLERANCE, KEPT, SHARE = 1e-6, 10, 40  # largest residual; states kept, and how many there are in all
FIELDS = ("U", "p", "k", "epsilon")
SYSTEM = {
    "controlDict": """application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {most}; deltaT 1; timeFormat general;
writeControl timeStep; writeInterval {every}; purgeWrite {kept}; writeFormat ascii; writePrecision 10; runTimeModifiable false;""",
    "fvSchemes": """ddtSchemes {{ default steadyState; }} gradSchemes {{ default Gauss linear; }} interpolationSchemes {{ default linear; }}
divSchemes {{ default none; div(phi,U) bounded Gauss linearUpwind grad(U); div(phi,k) bounded Gauss limitedLinear 1;
    div(phi,epsilon) bounded Gauss limitedLinear 1; div((nuEff*dev2(T(grad(U))))) Gauss linear; }}
laplacianSchemes {{ default Gauss linear corrected; }} snGradSchemes {{ default corrected; }} wallDist {{ method meshWave; }}""",
    "fvSolution": """solvers {{ p {{ solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0.05; }}
    "(U|k|epsilon)" {{ solver smoothSolver; smoother symGaussSeidel; tolerance 1e-12; relTol 0.1; }} }}
SIMPLE {{ consistent yes; residualControl {{ ".*" {tolerance}; }} }} relaxationFactors {{ equations {{ ".*" 0.7; }} }}""",
}
# type and further entries of a field at the patches
NONE, FREE, SET = "calculated; value uniform 0", "zeroGradient", "fixedValue; value uniform 0"
BOUNDARY = {
    "U": {"outlet": FREE, "wall": "fixedValue; value uniform (0 0 0)"},
    "p": {"inlet": FREE, "outlet": SET, "wall": FREE},
    "k": {"outlet": FREE, "wall": "kqRWallFunction; value uniform 1"},
    "epsilon": {"outlet": FREE, "wall": f"epsilonWallFunction; Cmu {CMU}; kappa {KAPPA}; E {ROUGH}; value uniform 1"},
    "nut": {"inlet": NONE, "outlet": NONE, "wall": f"nutkWallFunction; Cmu {CMU}; kappa {KAPPA}; E {ROUGH}; value uniform 0"},
}
DIMENSIONS = {"U": "0 1 -1", "p": "0 2 -2", "k": "0 2 -2", "epsilon": "0 2 -3", "nut": "0 2 -1"}


def graded(length, first, growth=1.0, most=np.inf):
    """Points from 0 to `length`: widths from about `first` on, growing by `growth` up to `most`."""
    points, width = [0.0], first
    while points[-1] < length - 0.5 * width:
        points.append(points[-1] + width)
        width = min(width * growth, most)
    return np.array(points) * length / points[-1]


def from_both_ends(length, *widths):
    half = graded(0.5 * length, *widths)
    return joined(half, length - half[::-1])


def joined(*parts):
    return np.concatenate([parts[0], *[part[1:] for part in parts[1:]]])


def middles(points):
    return 0.5 * (points[1:] + points[:-1])


class Mesh:
    """Quadrilaterals between x[i] and y[i, j], where `there`; inlet and outlet are its ends, `middle` its lowest line if
    mirrored."""

    def __init__(self, x, y, there, mirrored=False):
        nx, ny = there.shape
        cell, point = np.full((nx + 2, ny + 2), -1), np.full(y.shape, -1)
        cell[1:-1, 1:-1][there] = np.arange(there.sum())
        corners = [np.s_[i:nx + i, j:ny + j] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
        for corner in corners:
            point[corner][there] = 0
        used = point == 0
        point[used] = np.arange(used.sum())
        self.points = np.column_stack([np.broadcast_to(x[:, None], y.shape)[used], y[used]])
        self.corners = np.column_stack([point[corner][there] for corner in corners])
        self.centre = self.points[self.corners].mean(axis=1)
        # edges as (from, to, cell, other cell): the normal, to the right of the edge, points to the other cell
        upright, level = (point[:, :-1], point[:, 1:], cell[:-1, 1:-1], cell[1:, 1:-1]), (point[1:], point[:-1], cell[1:-1, :-1],
            cell[1:-1, 1:])
        edges = np.hstack([[part.ravel() for part in parts] for parts in (upright, level)]).T
        turned = edges[:, 2] < 0
        edges[turned] = edges[turned][:, [1, 0, 3, 2]]
        edges = edges[edges[:, 2] >= 0]
        inner, outer = edges[edges[:, 3] >= 0], edges[edges[:, 3] < 0]
        self.inner = inner[np.lexsort((inner[:, 3], inner[:, 2]))]
        at, height = self.points[outer[:, :2]].mean(axis=1).T
        which = np.select([at == x[0], at == x[-1], mirrored & (height == y.min())], ["inlet", "outlet", "middle"], "wall")
        self.patches = {name: outer[which == name] for name in ("inlet", "outlet", "wall", "middle") if name in which}

    def along(self, patch):
        """Cells, middles, outward normals and lengths of a patch's edges, distances of the cells' centres from them."""
        a, b, cell, _ = self.patches[patch].T
        (dx, dy), middle = (self.points[b] - self.points[a]).T, 0.5 * (self.points[a] + self.points[b])
        length = np.hypot(dx, dy)
        normal = np.column_stack([dy, -dx]) / length[:, None]
        return cell, middle, normal, length, ((middle - self.centre[cell]) * normal).sum(axis=1)

    def write(self, folder, depth):
        """OpenFOAM's mesh, one cell deep."""
        n, edges = len(self.points), np.concatenate([self.inner, *self.patches.values()])
        sheets = np.concatenate([self.corners[:, ::-1], self.corners + n])
        faces = np.concatenate([np.column_stack([edges[:, 0], edges[:, 1], edges[:, 1] + n, edges[:, 0] + n]), sheets])
        owner = np.concatenate([edges[:, 2], np.tile(np.arange(len(self.corners)), 2)])
        start, patches, kinds = len(self.inner), [], {"wall": "wall", "middle": "symmetryPlane", "sides": "empty"}
        for name, own in {**self.patches, "sides": sheets}.items():
            patches.append(f"{name} {{ type {kinds.get(name, 'patch')}; nFaces {len(own)}; startFace {start}; }}")
            start += len(own)
        points = np.column_stack([np.tile(self.points, (2, 1)), np.repeat([0.0, depth], n)])
        for name, kind, rows in (("points", "vectorField", points), ("faces", "faceList", [f"4({a} {b} {c} {d})" for a, b, c,
            d in faces]),
                                 ("owner", "labelList", owner), ("neighbour", "labelList", self.inner[:, 3]),
                                     ("boundary", "polyBoundaryMesh", patches)):
            dictionary(folder / name, kind, listed(rows))


def listed(rows):
    """A list of numbers, vectors or texts as OpenFOAM has it."""
    lines = ["(" + " ".join(f"{value:.12g}" for value in row) + ")" if np.ndim(row) else str(row) for row in rows]
    return f"{len(lines)}\n(\n" + "\n".join(lines) + "\n)"


def field(values):
    kind, rows = ("scalar", values) if values.ndim == 1 else ("vector", np.column_stack([values, 0 * values[:, 0]]))
    return f"nonuniform List<{kind}> {listed(rows)}"


def dictionary(path, kind, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"FoamFile {{ version 2.0; format ascii; class {kind}; object {path.name}; }}\n{text}\n", encoding="utf-8")


def read_field(path):
    """Values in the cells, (cells,) or (cells, 2)."""
    kind, numbers = re.search(r"internalField\s+nonuniform List<(\w+)>\s*\d+\s*\((.*?)\n\)", path.read_text(encoding="utf-8"),
        re.DOTALL).groups()
    values = np.array(re.sub(r"[()]", " ", numbers).split(), float)
    return values if kind == "scalar" else values.reshape(-1, 3)[:, :2]


def solve(flow, mesh, before, folder, most):
    """States of FIELDS in the cells, the last or several of the last iterations; iterations, residual, CPU seconds."""
    if before:
        at = NearestNDInterpolator(before[0].centre, np.arange(len(before[0].centre)))(mesh.centre).astype(int)
        start = [values[at] for values in before[1]]
    else:  # a uniform stream, nu_t = 0.01 U L
        k, one = 0.01 * flow.speed**2, np.ones(len(mesh.centre))
        start = [flow.speed * np.column_stack([one, 0 * one]), 0 * one, k * one, CMU * k**2 / (0.01 * flow.speed * flow.scale)
            * one]
    y = mesh.along("inlet")[1][:, 1]
    inlet = {"U": np.column_stack([flow.inlet(y), 0 * y]), "k": 0 * y + flow.k, "epsilon": CMU**0.75 * flow.k**1.5 / flow.mixing(y)}
    mesh.write(folder / "constant" / "polyMesh", 0.1 * flow.scale)
    inside = {**{name: field(values) for name, values in zip(FIELDS, start)}, "nut": "uniform 0"}
    for name, kinds in BOUNDARY.items():
        kinds = {"inlet": f"fixedValue; value {field(inlet[name])}" if name in inlet else "", "middle": "symmetryPlane",
            "sides": "empty", **kinds}
        patches = "\n".join(f"{patch} {{ type {kinds[patch]}; }}" for patch in [*mesh.patches, "sides"])
        dictionary(folder / "0" / name, "volVectorField" if name == "U" else "volScalarField",
                   f"dimensions [{DIMENSIONS[name]} 0 0 0 0];\ninternalField {inside[name]};\nboundaryField {{\n{patches}\n}}")
    dictionary(folder / "constant" / "transportProperties", "dictionary", f"transportModel Newtonian; nu {flow.nu:.12g};")
    dictionary(folder / "constant" / "turbulenceProperties", "dictionary", "simulationType RAS; RAS { RASModel kEpsilon; "
        "turbulence on; printCoeffs on; }")
    for name, text in SYSTEM.items():
        dictionary(folder / "system" / name, "dictionary", text.format(most=most, every=most // SHARE, kept=KEPT,
            tolerance=TOLERANCE))
    # where Debian's package has its settings
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ, "PWD": str(folder)}
    done = subprocess.run(["simpleFoam"], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        check=False)
    (folder / "log").write_text(done.stdout, encoding="utf-8")
    if done.returncode:
        raise BadInput(f"simpleFoam ended with status {done.returncode}, its last words: {done.stdout[-300:]}")
    residual = max(float(value) for value in re.findall(r"Initial residual = (\S+?),", done.stdout.rsplit("\nTime = ", 1)[1]))
    times = sorted(int(path.name) for path in folder.iterdir() if path.name.isdigit() and path.name != "0")
    states = [[read_field(folder / str(time) / name) for name in FIELDS] for time in (times if residual > TOLERANCE
        else times[-1:])]
    return states, times[-1], residual, float(re.findall(r"ExecutionTime = (\S+)", done.stdout)[-1])
