"""What the scripts of this folder share: the clock, the grading of the cavity, the report."""
import json
import os
import sys
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NGS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

from tools.study.extrema import top  # noqa: E402  (NumPy reads the environment)


def explained(kind, problem, trace):
    """A missing package in one line, other faults as they come."""
    if issubclass(kind, ModuleNotFoundError):
        print(f"error: the package {problem.name} is not there; make bench installs what it compares with", file=sys.stderr)
    else:
        sys.__excepthook__(kind, problem, trace)


sys.excepthook = explained
HEIGHT, LENGTH, CENTRE, RADIUS, NU = 0.41, 2.2, (0.2, 0.2), 0.05, 1e-3


def asked(levels, numbers=None):
    """(problem, level, ...) of the command line. levels: {problem: how many it has}; numbers: {problem: names of the
    positive numbers that may follow}. Ends with one line and status 3 where it is none of these."""
    words, numbers = sys.argv[1:], numbers or {}
    try:
        problem, level, *further = words[0], int(words[1]), *map(float, words[2:])
        if 0 <= level < levels[problem] and len(further) <= len(numbers.get(problem, ())) and all(1e-3 <= value <= 1e3
            for value in further):
            return problem, level, *further
    except (IndexError, KeyError, ValueError):
        pass
    name = os.path.splitext(os.path.basename(sys.argv[0]))[0]
    forms = "; ".join(" ".join([problem, f"0 to {levels[problem] - 1}", *(f"[{word}]" for word in numbers.get(problem, ()))])
        for problem in sorted(levels))
    print(f"error: usage: python -m tools.peers.{name} PROBLEM LEVEL, which are {forms}", file=sys.stderr)
    sys.exit(3)


def report(begin, unknowns, **numbers):
    """The line for tools.bench; begin: time.process_time() after the imports."""
    print(json.dumps({"unknowns": int(unknowns), "cpu_s": time.process_time() - begin, **{k: float(v) for k,
        v in numbers.items()}}))


def parabola(y, top):
    """Velocity at the inlet of the channel."""
    return 4 * top * y * (HEIGHT - y) / HEIGHT**2


def towards_walls(s, ratio=4.0, samples=2000):
    """s in [0, 1] mapped so that cells in the middle are `ratio` times those at the ends."""
    import numpy as np
    grid = (np.arange(samples) + 0.5) / samples
    width = ratio ** -abs(2 * grid - 1)
    return np.interp(s, np.linspace(0, 1, samples + 1), np.concatenate([[0], np.cumsum(width)]) / width.sum())


def extrema(u, v):
    """u_least, v_most, v_least of samples u(y), v(x) on the centrelines of the cavity."""
    return {"u_least": -top(-u), "v_most": top(v), "v_least": -top(-v)}
