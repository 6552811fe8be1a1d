"""Contact projection against QP packages: CPU time at equal residual, on one core.

    python -m tools.bench_contacts --quick
    python -m tools.bench_contacts --out results/bench_contacts

Random packings with walls. For each number of disks: the project's default, its other
solvers where they end in time, and the packages piqp, clarabel, scs, osqp, which are
installed where they are missing. Each package gets the assembled matrices and is asked for
tighter and tighter tolerances until the residual, recomputed for all by one formula
(tools/peers/contact_problems.residual), is low enough; only its last, successful solve counts.
What takes less than half a second is done five times, in rounds, and its median counts.
The project's time holds everything: search, assembly, solution, check of the true gaps; its residual is
recomputed by that formula too, and where it is not low enough there is no time.
Leaves bench_contacts.csv and bench_contacts.png (one for each kind of packing, where there are two). Times are CPU seconds of this
machine;
other work on it makes all of them longer.
"""
import importlib
import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[_name] = "1"

import numpy as np  # noqa: E402
from scipy import sparse  # noqa: E402

from tools.base.command import BadInput, Parser, positive, whole  # noqa: E402
from tools.base.tables import write_table  # noqa: E402
from tools.peers.contact_problems import constraints, packing, piqp, project, residual, scaled  # noqa: E402

PEERS = {"piqp": "0.6.4", "clarabel": "0.11.1", "scs": "3.3.1", "osqp": "1.1.3"}
DT = 0.01
WRITTEN = 1e-11  # mean radii: what the digits of impulses in a file leave of a residual
COLUMNS = ["disks", "kind", "solver", "tolerance", "cpu_s", "residual", "steps", "constraints", "search_s", "warm_s", "memory_mb",
    "note"]


def install(names):
    """The packages that can be imported, after pip has fetched the missing ones."""
    there = []
    for name in names:
        try:
            importlib.import_module(name)
        except ImportError:
            subprocess.run([sys.executable, "-m", "pip", "-q", "install", f"{name}=={PEERS[name]}"], check=False)
            importlib.invalidate_caches()
        try:
            importlib.import_module(name)
            there.append(name)
        except ImportError:
            print(f"{name}: cannot be installed here, left out")
    return there


def clarabel(B, d, w, q0, eps, limit):
    import clarabel as package
    s = package.DefaultSettings()
    s.verbose = False
    s.tol_gap_abs = s.tol_gap_rel = s.tol_feas = eps
    s.time_limit, s.max_iter, s.max_threads = limit, 200, 1
    done = package.DefaultSolver(sparse.diags(w).tocsc(), -w * q0, (-B).tocsc(), d, [package.NonnegativeConeT(len(d))], s).solve()
    return np.array(done.z), done.iterations


def scs(B, d, w, q0, eps, limit):
    import scs as package
    done = package.SCS({"P": sparse.diags(w).tocsc(), "A": (-B).tocsc(), "b": d, "c": -w * q0}, {"l": len(d)},
                       eps_abs=eps, eps_rel=0.0, max_iters=10**7, time_limit_secs=limit, verbose=False).solve()
    return np.array(done["y"]), done["info"]["iter"]


def osqp(B, d, w, q0, eps, limit):
    import osqp as package
    solver = package.OSQP()
    solver.setup(P=sparse.diags(w).tocsc(), q=-w * q0, A=B.tocsc(), l=-d, u=np.full(len(d), np.inf), eps_abs=eps, eps_rel=0.0,
                 max_iter=10**7, time_limit=limit, polishing=True, verbose=False)
    done = solver.solve()
    return -np.array(done.y), done.info.iter


SOLVE = {"piqp": piqp, "clarabel": clarabel, "scs": scs, "osqp": osqp}


def attempt(pipe, name, scene, rows, tol, eps, limit):
    """One solve in a process of its own: (CPU s, residual, steps, fault)."""
    B, d, w, q0 = scaled(rows, scene, DT)
    begin = time.process_time()
    try:
        press, steps = SOLVE[name](B, d, w, q0, max(eps, 1e-15), limit)
        cpu = time.process_time() - begin
        pipe.send((cpu, float(residual(rows, scene, DT, np.nan_to_num(press))), int(steps), ""))
    except Exception as problem:  # a package that gives up is a result
        pipe.send((time.process_time() - begin, np.inf, 0, f"failed: {problem}"[:60]))


def run_peer(name, scene, rows, tol, limit):
    """CPU time of the first tolerance that reaches the residual; a note where none does. Not
    every package has a limit of its own, so that each solve is ended from outside."""
    best, steps, begin = np.inf, 0, time.perf_counter()
    for eps in (10 * tol, tol, 0.1 * tol, 0.01 * tol, 1e-3 * tol, 1e-4 * tol):
        left = limit - (time.perf_counter() - begin)
        mine, theirs = multiprocessing.Pipe(False)
        process = multiprocessing.get_context("fork").Process(target=attempt, args=(theirs, name, scene, rows, tol, eps,
            max(left, 1)))
        process.start()
        theirs.close()
        there = left > 0 and mine.poll(left)
        try:
            cpu, found, steps, fault = mine.recv() if there else (0, np.inf, 0, f"not in {limit:g} s of wall clock")
        except EOFError:
            cpu, found, steps, fault = 0, np.inf, 0, "failed: ended without an answer"
        process.kill()
        process.join()
        best = min(best, found)
        if found <= tol:
            return cpu, found, steps, ""
        if fault:
            return None, best, steps, fault
    return None, best, steps, "residual not reached"


def run_own(solver, scene, tol, limit):
    """The project's solver: cold time, and the time of a warm-started repetition."""
    try:
        answer = project(scene, DT, tol, solver, repeat=2 if solver == "newton" else 1, limit=limit,
            options={"-contact-maxit": 10**7})
    except BadInput as problem:
        return {"note": f"not in {limit:g} s" if "limit" in str(problem) else str(problem)[:60]}
    rows = constraints(scene, scene.reach(DT))
    first, reached = answer.figures[0], residual(rows, scene, DT, answer.multipliers(rows))
    if not reached <= tol + WRITTEN:
        return {"residual": reached, "steps": first["steps"], "note": "residual not reached"}
    return {"cpu_s": first["time"], "residual": reached, "steps": first["steps"],
            "constraints": first["constraints"], "search_s": first["search"], "memory_mb": answer.memory_mb,
            "warm_s": answer.figures[-1]["time"] if len(answer.figures) > 1 else ""}


def attempt_row(solver, scene, rows, tol, limit, late, number, kind):
    """One measurement as a dict; late: who was too slow is not asked again, here or with more disks."""
    row = {"disks": number, "kind": kind, "solver": solver, "tolerance": tol}
    if solver in late or (solver == "uzawa" and number > 5000):
        row["note"] = "left out: too slow"
    elif solver in PEERS:
        cpu, best, steps, note = run_peer(solver, scene, rows, tol, limit)
        row |= {"cpu_s": cpu, "residual": best, "steps": steps, "constraints": len(rows.i), "note": note}
    else:
        row |= run_own(solver, scene, tol, max(limit, 60))
    if "not in" in row.get("note", "") or solver == "uzawa" and "note" in row:
        late.add(solver)
    return row


def table(numbers, tolerances, kinds, peers, limit, seed=0, most=1200):
    """All measurements as dicts; each is printed as it comes."""
    found = []
    for kind in kinds:
        late = set()
        for number in sorted(numbers):
            scene = packing(number, kind, seed, most=most)
            rows = constraints(scene, scene.reach(DT))
            print(f"{number} disks, {kind}: {len(rows.i)} constraints within reach of the packages", flush=True)
            for tol in tolerances:
                solvers = ["newton", "accelerated", "uzawa", *peers]
                rows_of = {solver: [attempt_row(solver, scene, rows, tol, limit, late, number, kind)] for solver in solvers}
                for _ in range(4):  # what is quick, again and again in rounds
                    for solver in solvers:
                        if (rows_of[solver][0].get("cpu_s") or 1) < 0.5:
                            rows_of[solver].append(attempt_row(solver, scene, rows, tol, limit, late, number, kind))
                for solver in solvers:
                    tries = [row for row in rows_of[solver] if row.get("cpu_s") is not None]
                    row = sorted(tries, key=lambda row: row["cpu_s"])[len(tries) // 2] if tries else rows_of[solver][0]
                    found.append(row)
                    cost = f"{row['cpu_s']:9.3f} s" if row.get("cpu_s") is not None else "        - "
                    print(f"  {solver:12s} {tol:7.0e} {cost}  residual {row.get('residual', float('nan')):.1e}  {row.get('note', '')}", flush=True)
    return found


def write(found, folder):
    """The CSV."""
    folder.mkdir(parents=True, exist_ok=True)
    write_table(folder / "bench_contacts.csv", COLUMNS, [[row.get(name, "") for name in COLUMNS] for row in found])
    return folder / "bench_contacts.csv"


def pictures(found, folder):
    """A picture for each kind of packing."""
    kinds = list(dict.fromkeys(row["kind"] for row in found))
    return [picture([row for row in found if row["kind"] == kind], folder, "bench_contacts" + (f"_{kind}" if len(kinds) > 1
        else "")) for kind in kinds]


def picture(found, folder, name="bench_contacts"):
    """CPU time against the number of disks of packings of one kind, one panel for each tolerance."""
    from tools.plot.style import MARKERS, PAGE_WIDTH, curve, plt, save
    tolerances = sorted({row["tolerance"] for row in found}, reverse=True)
    names = {"newton": "default (Newton finish)", "accelerated": "accelerated", "uzawa": "plain Uzawa"}
    figure, panels = plt.subplots(1, len(tolerances), figsize=(PAGE_WIDTH, 4.2), sharey=True, squeeze=False, layout="constrained")
    for axes, tol in zip(panels[0], tolerances):
        for k, solver in enumerate(dict.fromkeys(row["solver"] for row in found)):
            points = [(row["disks"], row["cpu_s"]) for row in found if row["solver"] == solver and row["tolerance"] == tol
                and row.get("cpu_s") is not None]
            if points:
                style = curve(k) if k < 6 else {"color": "#56b4e9", "linestyle": (0, (3, 3))}
                axes.loglog(*zip(*points), marker=(MARKERS + "X")[k % 7], markersize=4, label=names.get(solver, solver), **style)
        axes.set(xlabel="disks", title=f"residual {tol:.0e} of a mean radius")
        numbers = sorted({row["disks"] for row in found})
        axes.set_xticks(numbers, [f"{n:,}" for n in numbers])
        axes.xaxis.minorticks_off()
        axes.grid(True)
    panels[0][0].set_ylabel("CPU time on one core (s)")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return save(figure, folder / f"{name}.png")


def main(words=None):
    """Run the benchmark."""
    options = Parser(prog="python -m tools.bench_contacts", description=__doc__)
    options.add_argument("--quick", action="store_true", help="500 and 5,000 disks only")
    options.add_argument("--numbers", type=whole(1), nargs="+", metavar="N", help="numbers of disks (default 500 5000 20000 "
        "100000)")
    options.add_argument("--kinds", nargs="+", default=["random"], choices=["random", "gravity"], help="packings")
    options.add_argument("--peers", nargs="*", default=list(PEERS), choices=list(PEERS), help="packages to compare with")
    options.add_argument("--limit", type=positive, default=120, help="most seconds of wall clock for a package and a residual "
        "(default 120)")
    options.add_argument("--tolerances", type=positive, nargs="+", default=[1e-8, 1e-10])
    options.add_argument("--out", metavar="DIR", default="results/bench_contacts", help="folder of CSV and figure")
    given = options.parse_args(words)
    numbers = given.numbers or ([500, 5000] if given.quick else [500, 5000, 20000, 100000])
    found = table(numbers, given.tolerances, given.kinds, install(given.peers), given.limit)
    folder = Path(given.out)
    print(write(found, folder))
    print("\n".join(map(str, pictures(found, folder))))
    return 0
