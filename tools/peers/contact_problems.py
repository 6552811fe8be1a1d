"""Contact problems outside FreeFEM: packings, constraints, judges, and the project's answer.

    scene = packing(500, "random", seed=1)             # disks in a box, velocities
    answer = project(scene, dt=0.01)                   # scripts/project_velocities.edp
    rows = constraints(scene, scene.reach(0.01))       # NumPy, written apart from lib/
    residual(rows, scene, 0.01, answer.multipliers(rows))

The projection: min 1/2 sum m_i |u_i - u^_i|^2 with gap_k + dt G_k.u >= 0 (Maury 2006;
Lefebvre 2007). Units SI, masses and impulses per metre of depth. A mass below 0 marks a
disk whose motion is prescribed.
"""
import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from tools.base.command import BadInput
from tools.base.runner import finished, run_case

SCRIPT = "scripts/project_velocities.edp"


@dataclass
class Scene:
    """N disks: x (N, 2), radius (N), mass (N), velocity (N, 2), ids (N); walls (S, 4)."""
    x: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    velocity: np.ndarray
    walls: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    ids: np.ndarray | None = None

    def __post_init__(self):
        self.x, self.velocity = (np.asarray(a, float).reshape(-1, 2) for a in (self.x, self.velocity))
        self.radius, self.mass = (np.broadcast_to(np.asarray(a, float), len(self.x)).copy() for a in (self.radius, self.mass))
        self.walls = np.asarray(self.walls, float).reshape(-1, 4)
        self.ids = np.arange(len(self.x)) if self.ids is None else np.asarray(self.ids)

    def reach(self, dt):
        """Gap below which a pair can meet in a step, m."""
        return 2.0 * dt * np.sqrt((self.velocity**2).sum(1)).max()

    def write(self, folder):
        """bodies.csv and walls.csv in the folder, all digits."""
        folder = Path(folder)
        bodies = np.column_stack([self.ids, self.x, self.radius, self.mass, self.velocity])
        np.savetxt(folder / "bodies.csv", bodies, fmt=["%d", *["%.17g"] * 6], delimiter=",", header="id,x,y,radius,mass,u,v",
            comments="")
        np.savetxt(folder / "walls.csv", self.walls, fmt="%.17g", delimiter=",", header="x1,y1,x2,y2", comments="")


def read_scene(bodies, walls):
    """A Scene from two CSVs."""
    data = np.loadtxt(bodies, delimiter=",", skiprows=1, ndmin=2)
    return Scene(data[:, 1:3], data[:, 3], data[:, 4], data[:, 5:7], np.loadtxt(walls, delimiter=",", skiprows=1, ndmin=2),
                 data[:, 0].astype(int))


def box(width, height):
    """Four walls."""
    return np.array([[0, 0, width, 0], [width, 0, width, height], [width, height, 0, height], [0, height, 0, 0]], float)


def packing(number, kind="random", seed=0, radius=0.01, dt=0.01, density=1.0, filled=0.8, spread=0.2, most=1200):
    """A dense random packing in a box, moved apart until it just touches.

    kind: random (Gaussian velocities of a quarter radius a step, drawn inwards) or gravity
    (falling on the floor by a quarter radius a step, 20 % noise: long chains of force).
    """
    rng = np.random.default_rng(seed)
    r = radius * (1 + spread * (2 * rng.random(number) - 1))
    side = np.sqrt(np.pi * (r**2).sum() / filled) + radius
    x = r[:, None] + (side - 2 * r[:, None]) * rng.random((number, 2))
    step = 0
    while step < most:
        pairs = cKDTree(x).query_pairs(2 * r.max() + 0.3 * radius, output_type="ndarray")
        i, j = pairs.T
        worst = 0.0
        for _ in range(10):
            apart = x[j] - x[i]
            distance = np.maximum(np.hypot(*apart.T), 1e-12)
            overlap = r[i] + r[j] - distance
            push = np.where(overlap > 0, 0.42 * overlap / distance, 0.0)[:, None] * apart
            move = np.column_stack([np.bincount(j, push[:, c], number) - np.bincount(i, push[:, c], number) for c in (0, 1)])
            x = np.clip(x + move, r[:, None], side - r[:, None])
            worst = overlap.max(initial=0.0)
            step += 1
        if worst < 2e-4 * radius:
            break
    i, j = cKDTree(x).query_pairs(2 * r.max(), output_type="ndarray").T
    shrink = min(1.0, (np.hypot(*(x[i] - x[j]).T) / (r[i] + r[j])).min(initial=1.0)) * (1 - 1e-12)
    r = r * shrink
    speed = 0.25 * radius / dt
    if kind == "random":
        velocity = speed * rng.standard_normal((number, 2)) - 0.5 * speed * (x - side / 2) / (side / 2)
    elif kind == "gravity":
        velocity = np.array([0.0, -speed]) + 0.2 * speed * rng.standard_normal((number, 2))
    else:
        raise BadInput(f"there is no packing of the kind {kind}; random and gravity are known")
    return Scene(x, r, density * np.pi * r**2, velocity, box(side, side))


@dataclass
class Rows:
    """Constraints: i (K), j (K; -1 - s for segment s), gap (K), e (K, 2) from the second to the
    first; matrix G (K, 2N), columns x0 y0 x1 y1 ..., so that gap + dt G u >= 0."""
    i: np.ndarray
    j: np.ndarray
    gap: np.ndarray
    e: np.ndarray
    matrix: sparse.csr_matrix


def constraints(scene, reach):
    """All pairs and walls with a gap up to reach, found by a k-d tree."""
    x, r, number = scene.x, scene.radius, len(scene.x)
    near = cKDTree(x).query_pairs(2 * r.max() + reach, output_type="ndarray").reshape(-1, 2)
    i, j = near.T
    apart = x[i] - x[j]
    gap = np.hypot(*apart.T) - r[i] - r[j]
    keep = gap <= reach
    parts = [(i[keep], j[keep], gap[keep], apart[keep])]
    for s, (x1, y1, x2, y2) in enumerate(scene.walls):
        start, along = np.array([x1, y1]), np.array([x2 - x1, y2 - y1])
        share = np.clip((x - start) @ along / max(along @ along, 1e-300), 0, 1)
        apart = x - start - share[:, None] * along
        gap = np.hypot(*apart.T) - r
        k = np.flatnonzero(gap <= reach)
        parts.append((k, np.full(len(k), -1 - s), gap[k], apart[k]))
    i, j, gap = (np.concatenate([p[c] for p in parts]) for c in (0, 1, 2))
    e = np.concatenate([p[3] for p in parts])
    e = e / np.hypot(*e.T)[:, None]
    k, pair = np.arange(len(i)), j >= 0
    values = np.concatenate([e[:, 0], e[:, 1], -e[pair, 0], -e[pair, 1]])
    columns = np.concatenate([2 * i, 2 * i + 1, 2 * j[pair], 2 * j[pair] + 1])
    matrix = sparse.csr_matrix((values, (np.concatenate([k, k, k[pair], k[pair]]), columns)), (len(i), 2 * number))
    return Rows(i, j, gap, e, matrix)


def scaled(rows, scene, dt):
    """The problem in mean radii and mean masses: B, d, w (masses), q0 with
    min 1/2 (q - q0)' w (q - q0), B q + d >= 0; a prescribed disk has an infinite mass."""
    length, free = scene.radius.mean(), (scene.mass > 0) & (scene.mass < 1e29)
    mean = scene.mass[free].mean() if free.any() else 1.0
    weight = np.repeat(np.where(free, scene.mass / mean, np.inf), 2)
    return rows.matrix, rows.gap / length, weight, dt / length * scene.velocity.ravel()


def residual(rows, scene, dt, multipliers):
    """max_k |min(A_kk l_k, w_k)|, in mean radii: q is recomputed from the clipped multipliers,
    so that one formula judges every solver. Multipliers in the units of `scaled`."""
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    with np.errstate(divide="ignore"):
        inverse = 1 / weight
    multipliers = np.maximum(multipliers, 0)
    q = q0 + inverse * (matrix.T @ multipliers)
    diagonal = matrix.multiply(matrix) @ inverse
    with np.errstate(invalid="ignore"):
        both = np.minimum(diagonal * multipliers, matrix @ q + d)[diagonal > 0]
    return np.abs(both).max(initial=0.0)


@dataclass
class Answer:
    """What the script gave: velocity (N, 2) in the scene's order, contacts as a list of rows
    (t, i, j, gap, nx, ny, impulse), figures: disks, constraints, steps, factorisations,
    residual, gap (m), time and search (s of CPU); one dict a repetition."""
    velocity: np.ndarray
    contacts: np.ndarray
    figures: list
    scene: Scene
    dt: float
    memory_mb: float = 0.0

    def multipliers(self, rows):
        """The impulses on the constraints of `rows`, in the units of `scaled`."""
        free = (self.scene.mass > 0) & (self.scene.mass < 1e29)
        unit = self.scene.mass[free].mean() * self.scene.radius.mean() / self.dt
        known = {}
        for _, i, j, *_, impulse in self.contacts:
            known[frozenset((int(i), int(j)))] = impulse / unit
        name = lambda k: int(self.scene.ids[k]) if k >= 0 else int(k)  # noqa: E731
        return np.array([known.get(frozenset((name(a), name(b))), 0.0) for a, b in zip(rows.i, rows.j)])


def read_contacts(path):
    """The rows of a contacts.csv, none if it holds only its header."""
    with open(path, encoding="utf-8") as stream:
        return np.array([line.split(",") for line in stream.read().splitlines()[1:]], float).reshape(-1, 7)


FIGURES = re.compile(r"disks (\d+), constraints (\d+), steps (\d+), factorisations (\d+), residual (\S+), least gap (\S+) m, "
    r"time (\S+) s, search (\S+) s")


def project(scene, dt=0.01, tol=1e-10, solver="newton", repeat=1, options=None, limit=None):
    """Run scripts/project_velocities.edp; BadInput with its words if it refuses."""
    with tempfile.TemporaryDirectory() as folder:
        scene.write(folder)
        files = {"-bodies": f"{folder}/bodies.csv", "-contacts": f"{folder}/contacts.csv"}
        if len(scene.walls):
            files["-walls"] = f"{folder}/walls.csv"
        words = {**files, "-dt": dt, "-tol": tol, "-solver": solver, "-repeat": repeat, **(options or {})}
        words["-out"] = f"{folder}/projected.csv"
        done = finished(run_case(SCRIPT, words, limit=limit))
        velocity = np.loadtxt(f"{folder}/projected.csv", delimiter=",", skiprows=1, ndmin=2)[:, 1:3]
        contacts = read_contacts(f"{folder}/contacts.csv")
    names = "disks constraints steps factorisations residual gap time search".split()
    figures = [dict(zip(names, map(float, match))) for match in FIGURES.findall(done.log)]
    return Answer(velocity, contacts, figures, scene, dt, done.memory_mb)


def piqp(B, d, w, q0, eps, limit=None):
    """(multipliers, iterations) of a problem in the form of `scaled` by the interior-point QP package piqp, which knows no limit of
    time."""
    import piqp as package
    solver = package.SparseSolver()
    s = solver.settings
    s.eps_abs = s.eps_duality_gap_abs = eps
    s.eps_rel = s.eps_duality_gap_rel = 0.0
    s.max_iter = 300
    solver.setup(sparse.diags(w).tocsc(), -w * q0, None, None, (-B).tocsc(), None, d, None, None)
    solver.solve()
    return np.array(solver.result.z_u), solver.result.info.iter


def qp_piqp(scene, rows, dt, eps=1e-11):
    """Multipliers of a scene by piqp (free disks only)."""
    return piqp(*scaled(rows, scene, dt), eps)[0]
