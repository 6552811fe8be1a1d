"""Error against CPU time of flow, particles, contacts and transport; scaling; what is skipped; several processes.

    python -m tools.bench                  # make bench: 40 to 60 minutes
    python -m tools.bench --quick          # make bench QUICK=1: at most 5 minutes
    python -m tools.bench --parts particles skip --out results/bench_some
    python -m tools.bench --parts processes    # 1, 2, 4, ... processes up to the number of cores; no packages
    python -m tools.bench --keep --parts scaling skip    # the other parts are those of the last run into the folder

The published method, the standard scheme and other packages (NGSolve, scikit-fem, lbmpy, SciPy, LIGGGHTS,
the QP packages piqp, clarabel, scs, osqp) run interleaved, in rounds, on one core and one thread.
Missing packages are installed with pip unless --no-install is given; one that cannot be installed
is noted on the page. LIGGGHTS is a package of Debian; where it is not, a line says so. Writes bench.md (the page), bench.png and bench.csv (every run).
Each job runs once; no further round starts when the time of its part is over.

Status 0: the standard scheme ran everywhere; 1: somewhere it did not, and the page says why.
"""
import importlib.util
import os
import shutil
import subprocess
import sys
import time

from tools.base.command import ROOT, Parser, guarded, out_folder, positive, whole
from tools.base.runner import freefem, machine, own_folder
from tools.bench import flow, skip
from tools.bench.discrete import ELEMENTS, LOOSE, discrete_jobs
from tools.bench.figure import draw
from tools.bench.page import load, write_page
from tools.bench.processes import processes_lines, run_processes
from tools.bench.rounds import collect, earlier, run_rounds
from tools.bench.scaling import scaling_jobs
from tools.bench.flow import MULTIPLIERS, TENSORIAL
from tools.bench.scenes import OURS, PUBLISHED, contact_jobs, flow_jobs, particle_jobs, suspension_jobs
from tools.bench.spheres import fall_jobs, sphere_jobs
from tools.bench.transport import transport_jobs
from tools.peers import contact_packages as bench_contacts
from tools.peers import with_liggghts

PARTS = ("flow", "particles", "contacts", "discrete", "transport", "scaling", "skip", "processes")
PACKAGES = {"ngsolve": flow.PEERS["NGSolve"][1], "skfem": flow.PEERS["scikit-fem"][1], "lbmpy": "lbmpy==2.0",
            **{name: f"{name}=={version}" for name, version in bench_contacts.PEERS.items()}}
PUBLISHED_SETTLING = [(3, 0.005), (4, 0.005), (6, 0.005), (8, 0.0025)]


def peers(install):
    """({packages that can be imported}, lines on those that cannot)."""
    there, missing = set(), []
    for name, pinned in PACKAGES.items():
        if importlib.util.find_spec(name) is None and install:
            subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", pinned], check=False,
                capture_output=True)
            importlib.invalidate_caches()
        if importlib.util.find_spec(name) is None:
            missing.append(f"{pinned} is not installed" + (" and could not be" if install else "") + ": left out")
        else:
            there.add(name)
    return there, missing


def jobs_of(part, there, out, quick, limit):
    """The jobs of a part; small ones for --quick."""
    qp = [name for name in bench_contacts.PEERS if name in there]
    if part == "flow":
        levels = {"2d1": {OURS: (0, 1, 2), PUBLISHED: (0,) if quick else (0, 1, 2), "NGSolve": (0, 1, 2), "scikit-fem": (0, 1, 2)}}
        if not quick:
            levels["2d2"] = {OURS: (0, 1, 2), PUBLISHED: (0, 1, 2), "NGSolve": (0, 1, 2)}
            levels["cavity"] = dict.fromkeys((OURS, PUBLISHED, "NGSolve", "scikit-fem"), (0, 1, 2))
        absent = {name for name, package in (("NGSolve", "ngsolve"), ("scikit-fem", "skfem")) if package not in there}
        return flow_jobs(out, {p: {k: v for k, v in those.items() if k not in absent} for p, those in levels.items()}, limit)
    if part == "particles":
        settle = {OURS: [(n, 0.014 / n) for n in (3, 4, 5, 6)], PUBLISHED: PUBLISHED_SETTLING, TENSORIAL: PUBLISHED_SETTLING,
            MULTIPLIERS: [(n, 0.005 / n) for n in (3, 4, 6, 8)]}
        two = {OURS: [(4, 0.001), (6, 0.0005)], PUBLISHED: [(4, 0.002)], TENSORIAL: [(4, 0.002)], MULTIPLIERS: [(4, 0.0005)]}
        turn = {OURS: [(8, 0.01), (16, 0.0025), (32, 0.000625)], PUBLISHED: [(8, 0.02), (16, 0.02), (32, 0.02)]}
        if quick:
            settle, turn, two = {OURS: settle[OURS][:2], **{name: settle[name][:1] for name in (PUBLISHED, TENSORIAL,
                MULTIPLIERS)}}, {name: those[:2] for name, those in turn.items()}, {}
        lattice = ([0, 1] if quick else [0, 1, 2, 3]) if "lbmpy" in there else []
        return (particle_jobs(out, settle, lattice, turn, limit, two)
                + suspension_jobs(out, {OURS: (20, 5), PUBLISHED: (3, 1)}, limit)
                + fall_jobs(out, quick, "lbmpy" in there, limit))
    if part == "contacts":
        if quick:
            return contact_jobs([500, 2000], 1e-8, 500, [1e-4, 1e-8], qp, 20)
        return contact_jobs([500, 5000, 20000], 1e-8, 2000, [1e-3, 1e-6, 1e-9], qp, 60)
    if part == "discrete":
        short = {OURS: [0, 1, 2], ELEMENTS: [0, 1, 2, 3]}
        discharge = {OURS: [0], LOOSE: [0, 1], ELEMENTS: [0, 2]} if quick else {OURS: [0, 1, 2], LOOSE: [0, 1, 2, 3],
            ELEMENTS: [0, 1, 2, 3]}
        collapse = {} if quick else {"collapse": {OURS: [0, 1, 2], ELEMENTS: [1, 2, 3]}}
        return discrete_jobs(out, {"discharge": discharge, "fall": short, **collapse}, 1 if quick else 3, limit)
    if part == "transport":
        return transport_jobs(out, [100, 10000] if quick else [100, 1000, 10000, 100000], 2 if quick else 3)
    spheres = sphere_jobs(out, quick, limit)
    if quick:
        return spheres + scaling_jobs(out, {OURS: [(4, 20, 5), (8, 10, 4)], PUBLISHED: [(4, 3, 1)]},
                            {OURS: [(0, 20, 5), (1, 20, 5), (50, 15, 5)], "none": [(None, 20, 5)]}, [], [], [], limit)
    return spheres + scaling_jobs(out,
                        {OURS: [(4, 40, 10), (6, 40, 10), (8, 30, 10), (12, 25, 10), (17, 15, 5)], PUBLISHED: [(4, 4, 1),
        (6, 3, 1), (8, 3, 1)]},
                        {OURS: [(0, 40, 10), (1, 40, 10), (50, 40, 10), (500, 20, 5)], "none": [(None, 40, 10)],
                            PUBLISHED: [(1, 3, 1), (50, 3, 1), (500, 3, 1)]},
                        [(number, 200, 160) for number in (0, 1, 50, 500)], [(number, 15, 5) for number in (0, 1, 50, 500)],
                            [(number, 200, 160) for number in (0, 1, 50, 500)], limit)


# Minutes of a part after which no further round begins; what is skipped takes 7 and 1, several processes 5 and 1.
SHARES = {False: {"flow": 16, "particles": 12, "contacts": 6, "discrete": 6, "transport": 1, "scaling": 6},
          True: {"flow": 0.6, "particles": 1, "contacts": 0.6, "discrete": 0.5, "transport": 0.2, "scaling": 0.7}}


def parser():
    """The options."""
    options = Parser(prog="python -m tools.bench", description=__doc__)
    options.add_argument("--quick", action="store_true", help="coarse runs only, at most 5 minutes")
    options.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), help="default: all")
    options.add_argument("--keep", action="store_true", help="take the runs of the other parts from the bench.csv of DIR (what "
        "is skipped is not in it)")
    options.add_argument("--out", type=out_folder, default=str(ROOT / "results" / "bench"), metavar="DIR",
        help="where page, figure and table go (default results/bench)")
    options.add_argument("--repeats", type=whole(1), default=3, metavar="N", help="most runs of each (default 3; a long one runs "
        "once)")
    options.add_argument("--limit", type=positive, default=900, metavar="S", help="most seconds of one run (default 900)")
    options.add_argument("--no-install", action="store_true", help="do not install packages that are missing")
    return options


def run_skip(out, quick, limit, say):
    """The Skipped of every feature."""
    return [skip.compare(feature, out, 3 if quick else 7, 2 if quick else 1, limit, say) for feature in skip.FEATURES]


def main(words=None):
    """0 if everything of the standard scheme ran."""
    given = parser().parse_args(words)
    freefem()
    samples = earlier(given.out / "bench.csv", given.parts) if given.keep else []
    computer, cores = machine(), {0}
    if hasattr(os, "sched_setaffinity"):
        cores = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # inherited by all runs
    out = given.out
    own_folder(out, "bench", ("runs", "trees", "meshes"))
    there, missing = peers(not given.no_install) if set(given.parts) - {"scaling", "skip", "processes"} else (set(), [])
    begin, before = time.perf_counter(), load()

    def say(text):
        print(f"[{(time.perf_counter() - begin) / 60:5.1f} min] {text}", flush=True)
    skipped, shared, kept = [], [], sorted({s.section for s in samples}, key=PARTS.index)
    if "discrete" in given.parts and not with_liggghts.program():
        missing.append(with_liggghts.MISSING)
    missing += [f"{', '.join(kept)}: of an earlier run into this folder"] if kept else []
    for part in given.parts:
        if part == "skip":
            skipped = run_skip(out, given.quick, given.limit, say)
        elif part == "processes":
            shared = run_processes(out, given.quick, given.limit, cores, say)
        else:
            until = time.perf_counter() + 60 * SHARES[given.quick][part]
            often = 3 if part == "scaling" else 1  # the cost of a step is short to measure and wavers
            samples += run_rounds(jobs_of(part, there, out, given.quick, given.limit), often * given.repeats,
                (5 if given.quick else 25) / often, say, until=until)
        points = collect(sorted(samples, key=lambda s: PARTS.index(s.section)))
        page = write_page(points, samples, skipped, missing, out, given.quick, (time.perf_counter() - begin) / 60,
            (before, load()), computer, processes_lines(shared) if shared else [])
        if points or skipped:
            draw(points, skipped, out / "bench.png")
    for name in ("runs", "trees"):
        shutil.rmtree(out / name, ignore_errors=True)
    print("\n".join(str(path) for path in (page, out / "bench.png", out / "bench.csv") if path.is_file()))
    ours = [s for s in samples if s.program not in (PUBLISHED, TENSORIAL, MULTIPLIERS, *bench_contacts.PEERS, "NGSolve", "scikit-fem",
        "lbmpy", "SciPy", ELEMENTS)]
    return 0 if not any(s.note for s in (*ours, *skipped, *shared)) else 1


if __name__ == "__main__":
    guarded(main)
