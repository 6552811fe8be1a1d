"""The relaxed law of friction against a QP package: CPU time of one projection, on one core.

    python -m tools.peers.friction_packages 5000 20000 [--limit 300]

Random packings with walls (tools/peers/contact_problems.py), coefficients of 0.2 between disks and 0.1 at walls. Both programs
are asked for tighter and tighter tolerances until the residual, recomputed from the impulses by one formula, is at most TOL;
the last solve counts. The rounds alternate and the medians count; where a solve takes more than ONCE seconds there is one
round. The time of the suite holds search, assembly and solution; that of PIQP its set-up and solution. A solve of PIQP that takes
more than the limit (s of CPU) is stopped; then the time and residual of the suite stand alone.
"""
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import numpy as np  # noqa: E402
from scipy import sparse  # noqa: E402

from tools.base.command import BadInput, guarded  # noqa: E402
from tools.base.runner import finished, run_case  # noqa: E402
from tools.base.tables import read_table  # noqa: E402
from tools.peers.contact_problems import FIGURES, SCRIPT, constraints, packing, piqp  # noqa: E402

DT, TOL, DISKS, WALLS, ROUNDS, ONCE = 0.01, 1e-6, 0.2, 0.1, 3, 20
LIMIT = 300  # s of CPU of a solve of PIQP
TIGHTER = {"suite": 1, "PIQP": 1e-3}  # the first tolerance over TOL; PIQP leaves a larger residual than it is asked for


def problem(number, seed=1):
    """(scene, omega in rad/s, rows, mu of the rows, B, d, w, q0): disks with friction, and min 1/2 (q - q0)' w (q - q0) over
    B q + d >= 0, in mean radii, mean masses and dt, with the rows G + mu T and G - mu T one below the other."""
    scene = packing(number, "random", seed)
    length, mean = scene.radius.mean(), scene.mass.mean()
    omega = np.random.default_rng(1000 + seed).standard_normal(number) * 0.25 * length / DT / scene.radius
    rows = constraints(scene, scene.reach(DT))
    pair, k = rows.j >= 0, np.arange(len(rows.i))
    mu = np.where(pair, DISKS, WALLS)
    ex, ey = rows.e.T
    first, second = rows.i, rows.j[pair]
    arm = scene.radius[first] + np.where(pair, 0.5, 1) * rows.gap
    other = scene.radius[second] + 0.5 * rows.gap[pair]
    shape = (len(k), 3 * number)

    def matrix(x, y, own, its):
        """Rows x u_i + y v_i + own omega_i - x u_j - y v_j + its omega_j."""
        values = np.concatenate([x, y, own, -x[pair], -y[pair], its])
        columns = np.concatenate([3 * first, 3 * first + 1, 3 * first + 2, 3 * second, 3 * second + 1, 3 * second + 2])
        return sparse.csr_matrix((values, (np.concatenate([k, k, k, k[pair], k[pair], k[pair]]), columns)), shape)

    gaps = matrix(ex, ey, np.zeros(len(k)), np.zeros(pair.sum()))
    slides = matrix(-ey, ex, -arm / length, -other / length)
    rough = sparse.diags(mu) @ slides
    weight = np.repeat(scene.mass / mean, 3)
    weight[2::3] *= 0.5 * (scene.radius / length) ** 2
    q0 = np.column_stack([scene.velocity * DT / length, omega * DT]).ravel()
    return scene, omega, rows, mu, sparse.vstack([gaps + rough, gaps - rough]).tocsr(), np.tile(rows.gap / length, 2), weight, q0


def judged(multipliers, B, d, w, q0):
    """(residual max |min(A_kk l_k, (B q + d)_k)| in mean radii, q) of multipliers."""
    multipliers = np.maximum(multipliers, 0)
    q = q0 + B.T @ multipliers / w
    return np.abs(np.minimum(B.multiply(B) @ (1 / w) * multipliers, B @ q + d)).max(), q


def by_suite(scene, omega, rows, mu, tol):
    """(CPU s, multipliers of the rows, in the units of `problem`) of the suite."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        bodies = np.column_stack([scene.ids, scene.x, scene.radius, scene.mass, 0.5 * scene.mass * scene.radius**2,
            np.full(len(omega), DISKS), scene.velocity, omega])
        np.savetxt(place / "bodies.csv", bodies, fmt=["%d", *["%.17g"] * 9], delimiter=",", comments="",
            header="id,x,y,radius,mass,inertia,friction,u,v,omega")
        np.savetxt(place / "walls.csv", np.column_stack([scene.walls, np.full(len(scene.walls), WALLS)]), fmt="%.17g",
            delimiter=",", header="x1,y1,x2,y2,friction", comments="")
        done = finished(run_case(SCRIPT, {"-bodies": place / "bodies.csv", "-walls": place / "walls.csv", "-dt": DT,
            "-friction": "relaxed", "-tol": tol, "-friction-tol": tol, "-contacts": place / "contacts.csv",
            "-out": place / "out.csv"}))
        table = read_table(place / "contacts.csv")
        known = {(int(i), int(j)): k for k, (i, j) in enumerate(zip(table["i"], table["j"]))}
    unit = scene.mass.mean() * scene.radius.mean() / DT
    n, f = np.zeros(len(rows.i)), np.zeros(len(rows.i))
    for k, (i, j) in enumerate(zip(rows.i, rows.j)):
        at = known.get((int(i), int(j)), known.get((int(j), int(i))))  # turned round, both forces keep their signs
        if at is not None:
            n[k], f[k] = table["n"][at] / unit, table["f"][at] / unit
    return float(FIGURES.findall(done.log)[-1][6]), np.concatenate([n + f / mu, n - f / mu]) / 2


class TooLong(Exception):
    """A solve has reached its limit."""


def solved(rest, tol, limit, pipe):
    """Sends (CPU s, multipliers) of PIQP through a pipe; the process ends at its limit (s of CPU)."""
    begin = time.process_time()
    resource.setrlimit(resource.RLIMIT_CPU, (int(begin + limit) + 1,) * 2)
    pipe.send((0.0, None))
    press = piqp(*rest, tol)[0]
    pipe.send((time.process_time() - begin, press))


def by_piqp(rest, tol, limit):
    """The same of PIQP; rest: B, d, w, q0; limit: s of CPU. Raises TooLong."""
    mine, theirs = multiprocessing.get_context("fork").Pipe(False)
    process = multiprocessing.get_context("fork").Process(target=solved, args=(rest, tol, limit, theirs))
    process.start()
    theirs.close()
    try:
        mine.recv()
        return mine.recv()
    except EOFError:
        raise TooLong(f"PIQP has no solution after {limit:g} s") from None
    finally:
        process.join()


def reached(solve, rest, first):
    """(tolerance, CPU s, residual, q) of the first tolerance, from first on, that reaches TOL."""
    for tol in (first, first / 10, first / 100, first / 1000):
        cpu, press = solve(tol)
        found, q = judged(press, *rest)
        if found <= TOL:
            return tol, cpu, found, q
    raise BadInput(f"the residual {found:.1e} stays above {TOL:.0e}")


def compare(number, limit):
    """The line of this number of disks; limit: s of CPU of a solve of PIQP."""
    scene, omega, rows, mu, *rest = problem(number)
    own, other = (lambda tol: by_suite(scene, omega, rows, mu, tol)), (lambda tol: by_piqp(rest, tol, limit))
    mine = reached(own, rest, TOL * TIGHTER["suite"])
    head = f"{number} disks, {len(mu)} contacts: suite "
    try:
        theirs = reached(other, rest, TOL * TIGHTER["PIQP"])
    except TooLong as problem_met:
        return head + f"{mine[1]:.3g} s (residual {mine[2]:.1e}); {problem_met}"
    more = ROUNDS - 1 if max(mine[1], theirs[1]) < ONCE else 0
    cpu = np.array([[own(mine[0])[0], other(theirs[0])[0]] for _ in range(more)] + [[mine[1], theirs[1]]])
    first, second = np.median(cpu, axis=0)
    return (head + f"{first:.3g} s (residual {mine[2]:.1e}), PIQP {second:.3g} s ({theirs[2]:.1e}), ratio "
        f"{np.median(cpu[:, 0] / cpu[:, 1]):.2f}, largest difference of the velocities {np.abs(mine[3] - theirs[3]).max():.1e} mean "
        "radii a step")


def main():
    """The command; prints a line for each number of disks."""
    words, limit = sys.argv[1:], str(LIMIT)
    if "--limit" in words[:-1]:
        at = words.index("--limit")
        limit, words = words[at + 1], words[:at] + words[at + 2:]
    if not words or not all(word.isdigit() and int(word) > 1 for word in words) or not limit.isdigit() or int(limit) < 1:
        raise BadInput("usage: python -m tools.peers.friction_packages DISKS [DISKS ...] [--limit SECONDS]")
    for word in words:
        print(compare(int(word), int(limit)), flush=True)


if __name__ == "__main__":
    guarded(main)
