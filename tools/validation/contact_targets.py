"""Contacts held to their targets: one table of target, measured, pass.

    python -m tools.validate_contacts                      # accuracy, and speed up to 5,000 disks
    python -m tools.validate_contacts --bench results/bench_contacts/bench_contacts.csv
    python -m tools.validate_contacts --full               # runs the whole benchmark first

Accuracy: problems with exact answers, a QP package, the falling particles. Speed: the rows
of a benchmark (tools/peers/contact_packages.py). Leaves validate_contacts.csv. Status 1 if a
target is missed. CPU times are of this machine and of what else it does.
"""
import csv
import tempfile
from pathlib import Path

import numpy as np
from scipy.optimize import isotonic_regression

from tools.base.command import BadInput, Parser
from tools.base.runner import finished, run_case
from tools.base.tables import read_table, write_table
from tools.peers import contact_packages as bench_contacts
from tools.peers.contact_problems import Scene, constraints, packing, project, qp_piqp, read_scene, scaled

DATA = "tests/data/contact/random_{}_{}.csv"


def instances():
    """Greatest error of a velocity on the packings with exact solutions, m/s."""
    for number in (50, 500):
        scene = read_scene(DATA.format(number, "bodies"), DATA.format(number, "walls"))
        exact = np.loadtxt(DATA.format(number, "exact"), delimiter=",", skiprows=1)[:, 1:]
        for solver in ("newton", "accelerated"):
            error = np.abs(project(scene, 0.01, 2e-11, solver).velocity - exact).max()
            yield f"packing of {number} with exact solution, {solver}: velocity error (m/s)", 1e-8, error


def row_of_disks():
    """A row of 1,000 touching disks against the isotonic regression."""
    rng = np.random.default_rng(0)
    masses, velocities = np.exp(rng.normal(size=1000)), rng.normal(size=1000)
    x = np.column_stack([0.02 * np.arange(1000), np.zeros(1000)])
    answer = project(Scene(x, 0.01, masses, np.column_stack([velocities, np.zeros(1000)])), tol=1e-11)
    yield "row of 1,000 disks, isotonic regression: velocity error (m/s)", 1e-8, np.abs(answer.velocity[:, 0]
        - isotonic_regression(velocities, weights=masses).x).max()


def column():
    """Impulses in a resting column against the weight above."""
    r = np.linspace(0.01, 0.04, 12)
    y = np.cumsum(r) + np.r_[0, np.cumsum(r[:-1])]
    mass = 1000 * np.pi * r**2
    answer = project(Scene(np.column_stack([0 * y, y]), r, mass, np.outer(np.ones(12), [0, -0.0981]), [[-1, 0, 1, 0]]), 0.01, 1e-12)
    above = {k: 0.0981 * mass[k:].sum() for k in range(12)}
    found = {int(max(c[1], c[2])): c[6] for c in answer.contacts}
    yield "resting column: impulse error / weight above", 1e-8, np.max([abs(found.get(k, 0.0) / above[k] - 1) for k in above])


def momentum():
    """Momentum of a free packing of unequal disks."""
    scene = packing(300, "random", seed=5, spread=0.6)
    scene.walls = np.zeros((0, 4))
    answer = project(scene, tol=1e-8)
    change = scene.mass @ (answer.velocity - scene.velocity)
    yield "unequal disks: change of momentum / momentum", 1e-12, np.abs(change).max() / (scene.mass @ np.hypot(*scene.velocity.T))


def quadratic_program():
    """Packings of 1,000 against the QP package piqp."""
    for kind in ("random", "gravity"):
        scene = packing(1000, kind, seed=3)
        rows = constraints(scene, scene.reach(0.01))
        _, _, weight, q0 = scaled(rows, scene, 0.01)
        other = q0 + rows.matrix.T @ np.maximum(qp_piqp(scene, rows, 0.01, 1e-12), 0) / weight
        own = 0.01 / scene.radius.mean() * project(scene, 0.01, 1e-10).velocity.ravel()
        yield f"packing of 1,000 ({kind}) against piqp: difference of a step (mean radii)", 1e-6, np.abs(own - other).max()


def falling():
    """The falling particles: rest, overlap, energy, momentum."""
    with tempfile.TemporaryDirectory() as folder:
        finished(run_case("cases/falling_particles.edp", {"-every": 0.02}, out=f"{folder}/run"))
        motion = read_table(f"{folder}/run/motion.csv")
        radius = read_table(f"{folder}/run/particles.csv")["radius"].min()
    kinetic = motion["kinetic_energy"]
    energy = kinetic + motion["potential_energy"]
    yield "falling particles at 100 s: kinetic energy / peak", 1e-8, kinetic[-1] / kinetic.max()
    yield "falling particles: greatest overlap / smallest radius", 1e-10, max(-motion["worst_gap"].min(), 0) / radius
    yield "falling particles: greatest rise of the energy / peak", 1e-10, max(np.diff(energy).max(), 0) / kinetic.max()
    yield "falling particles: momentum error / peak", 1e-12, motion["momentum_error"].max() / np.hypot(motion["momentum_x"],
        motion["momentum_y"]).max()


def settled():
    """A step of a heap at rest, started from its impulses and from none: CPU times."""
    dt, weight = 0.002, 9.81
    heap = {"-number": 500, "-rmin": 0.008, "-rmax": 0.012, "-gravity": weight, "-dt": dt, "-tend": 4, "-every": 1}
    with tempfile.TemporaryDirectory() as folder:
        finished(run_case("cases/falling_particles.edp", heap, out=f"{folder}/run"))
        rows, walls = (read_table(f"{folder}/run/{name}.csv") for name in ("particles", "walls"))
    last = rows["t"] == rows["t"].max()
    x, y, radius, u, v = (rows[name][last] for name in ("x", "y", "radius", "u", "v"))
    scene = Scene(np.column_stack([x, y]), radius, 100 * np.pi * radius**2, np.column_stack([u, v - weight * dt]),
                  np.column_stack([walls[name] for name in ("x1", "y1", "x2", "y2")]))
    for tol in (1e-8, 1e-10):
        cold, *warm = project(scene, dt, tol, repeat=6).figures
        yield f"heap of 500 at rest, to {tol:.0e}: time of a warm-started step / cold", 0.1, np.median([step["time"]
            for step in warm]) / cold["time"]


def benchmark(path):
    """The rows of a benchmark that were timed, packings at random."""
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = [row for row in csv.DictReader(stream) if row["cpu_s"] and row["kind"] == "random"]
        own = [row for row in rows if row["solver"] == "newton"]
        for names, some in ((("disks", "tolerance", "cpu_s"), rows), (("search_s", "memory_mb"), own)):
            for row in some:
                row.update({name: float(row[name]) for name in names})
    except KeyError as problem:
        raise BadInput(f"{path} is no table of tools.bench_contacts: it has no column {problem.args[0]}") from None
    except (ValueError, TypeError, csv.Error, OSError) as problem:
        raise BadInput(f"cannot read the benchmark {path}: {problem}") from None
    if not own:
        raise BadInput(f"{path} has no row of the solver newton on a random packing that was timed")
    return rows


def speed(rows):
    """Targets on the rows of a benchmark."""
    cost = {(int(r["disks"]), r["solver"], r["tolerance"]): r["cpu_s"] for r in rows}
    own = [r for r in rows if r["solver"] == "newton"]
    numbers = sorted({key[0] for key in cost})
    tolerances = sorted({key[2] for key in cost}, reverse=True)
    peers = set(bench_contacts.PEERS)
    for tol in tolerances:
        for number in numbers:
            best = min(((c, name) for (n, name, t), c in cost.items() if n == number and t == tol and name in peers), default=None)
            if best and (number, "newton", tol) in cost:
                yield f"{number} disks to {tol:.0e}: CPU time / that of the best package ({best[1]})", 1.0, cost[number, "newton",
                    tol] / best[0]
        if (20000, "newton", tol) in cost:
            yield f"20,000 disks to {tol:.0e}: CPU time (s)", 3.0, cost[20000, "newton", tol]
        large = [n for n in numbers if n >= 5000 and (n, "newton", tol) in cost]
        if len(large) > 1:
            slope = np.polyfit(np.log(large), np.log([cost[n, "newton", tol] for n in large]), 1)[0]
            yield f"growth with the number of disks, {large[0]} to {large[-1]}, to {tol:.0e}: exponent", 1.3, slope
    last = max(own, key=lambda r: r["disks"])
    yield f"{int(last['disks'])} disks: search (s of CPU)", 5.0, last["search_s"]
    yield f"{int(last['disks'])} disks: memory (MiB)", 2048.0, last["memory_mb"]


def tried(parts):
    """(name, target, measured, "") of each number of the parts; what a part raises is a row without a number, with the reason."""
    for part in parts:
        try:
            yield from ((*row, "") for row in part())
        except Exception as problem:  # of a run, or a package that is not there
            yield part.__name__.replace("_", " "), np.nan, np.nan, " ".join(f"{type(problem).__name__}: {problem}".split())


def main(words=None):
    """Write and print the table."""
    options = Parser(prog="python -m tools.validate_contacts", description=__doc__)
    options.add_argument("--bench", metavar="CSV", help="rows of an earlier benchmark")
    options.add_argument("--full", action="store_true", help="run the benchmark up to 100,000 disks")
    options.add_argument("--out", metavar="DIR", default="results/validate_contacts", help="folder of the table")
    given = options.parse_args(words)
    if given.bench and given.full:
        raise BadInput("--bench takes an earlier benchmark, --full makes one: leave one out")
    if given.bench:
        bench = benchmark(given.bench)
    folder = Path(given.out)
    folder.mkdir(parents=True, exist_ok=True)
    if not given.bench:
        bench_contacts.main(["--out", str(folder)] + ([] if given.full else ["--quick"]))
        bench = benchmark(folder / "bench_contacts.csv")
    found = []

    def speed_of_bench():
        return speed(bench)
    print(f"{'quantity':88s} {'target':>9s} {'measured':>10s}")
    for name, target, measured, reason in tried((instances, row_of_disks, column, momentum, quadratic_program, falling, settled,
        speed_of_bench)):
        good = bool(measured <= target)
        found.append([name, target, f"{measured:.4g}", "pass" if good else "MISSED" + (f" ({reason})" if reason else "")])
        print(f"{name:88s} {'<= ' + format(target, 'g'):>9s} {measured:10.3g} {found[-1][3]}", flush=True)
    write_table(folder / "validate_contacts.csv", ["quantity", "target_at_most", "measured", "verdict"], found)
    missed = sum(row[3] != "pass" for row in found)
    print(f"{len(found) - missed} of {len(found)} targets met; table in {folder}/validate_contacts.csv")
    return 1 if missed else 0
