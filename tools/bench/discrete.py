"""The jobs of contacts alone: the projection against the discrete element method (LIGGGHTS), error against CPU time.

Three scenes from the same start: the time in which half of 500 disks leave an hourglass, a mean over seeds; the mean height of
50 falling disks; and the mean distance from the middle of a loose column of 1,000 disks with friction that collapses. A run is made
once and judged by the limit of its own series (dt -> 0, or stiffness -> infinity), and by
the common one where they differ. Numbers of the limits: docs/limits/contacts_alone.md. The times are those of the whole processes,
and, in a problem of its own, those less the time of one step: FreeFEM starts and compiles for longer than LIGGGHTS computes a fall. Both
write a row every 0.02 s (fall, collapse: 0.1 s).
"""
import functools

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, run_case
from tools.bench.rounds import Job
from tools.bench.scenes import OURS
from tools.peers import with_liggghts

ELEMENTS, LOOSE = "LIGGGHTS", "standard, loose"
LOOSER = {"-contact-solver": "accelerated", "-contact-tol": 3e-3, "-contact-overlap": 3e-2}
STEPS = [0.004, 0.002, 0.001, 0.0005]  # s, of the discharge
MODULI = [1e7, 1e8, 6e8, 6e9]  # Pa
FALL_STEPS, FALL_MODULI = [0.64, 0.32, 0.16, 0.08], [1e3, 1e4, 1e5, 1e6]
FALL_TIME = 8.0  # s, at which the mean height is taken
COLLAPSE_STEPS, COLLAPSE_MODULI = [0.004, 0.002, 0.001, 0.0005], [1e6, 1e7, 1e8, 1e9]
COLLAPSE_TIME, HALF = 0.4, 0.2180  # s, at which the mean distance is taken; half width of the column, m
# s, within 0.01 (1.354 in 20 runs with steps of 0.002 s and less, 1.334 in 16 with moduli of 6e9 and 6e10 Pa: seeds hide the
# difference); and the mean height over that at the start (where a disk of LIGGGHTS still rebounds with 0.06 of its speed);
# collapse: that of LIGGGHTS, within 0.01 (0.855, 0.880, 0.896), as smaller steps of the suite take minutes
LIMITS = {"discharge": {"own": {OURS: 1.34, ELEMENTS: 1.34}, "common": 1.34},
          "collapse": {"own": {OURS: 0.90, ELEMENTS: 0.90}, "common": 0.90},
          "fall": {"own": {OURS: 0.3388, ELEMENTS: 0.3405}, "common": 0.3397}}


def discharge_time(times, heights):
    """Time in which half of the disks have passed the height 0, s; times (T), heights (T x N)."""
    passed = (np.asarray(heights) < 0).sum(axis=1)
    half = 0.5 * np.shape(heights)[1]
    if passed[-1] < half:
        raise BadInput(f"{passed[-1]} of {np.shape(heights)[1]} disks had passed at {times[-1]:g} s: too few to tell the time of half")
    at = int(np.argmax(passed >= half))
    return float(times[0] if at == 0 else np.interp(half, passed[at - 1:at + 1], times[at - 1:at + 1]))


def mean_height(times, heights, masses):
    """Mean height at FALL_TIME over that at the start."""
    mean = heights @ masses / masses.sum()
    return float(np.interp(FALL_TIME, times, mean) / mean[0])


def mean_distance(times, places, masses):
    """Mean distance from the middle at COLLAPSE_TIME over the half width of the column; places (T x N): along the plane, m."""
    return float(np.interp(COLLAPSE_TIME, times, np.abs(places) @ masses / masses.sum()) / HALF)


def suite_rows(run, name="y"):
    """(times, heights T x N or the column of that name, masses up to a factor) of a run of the suite."""
    table = RunFolder(run).particles
    times = np.unique(table["t"])
    values = table[name].reshape(len(times), -1)
    return times, values, table["radius"][:values.shape[1]] ** 2


def options_of(problem, seed):
    """The case of a problem and its options but the step."""
    if problem == "fall":
        return "cases/falling_particles.edp", {"-seed": seed, "-tend": FALL_TIME, "-every": 0.1, "-contact-form": "ballistic"}
    if problem == "collapse":
        return "cases/granular_collapse.edp", {"-number": 1000, "-aspect": 1, "-release": 0, "-seed": seed, "-tend": COLLAPSE_TIME,
            "-every": 0.1, "-friction-tol": 1e-3, "-friction-maxit": 1000}
    return "cases/hourglass.edp", {"-number": 500, "-radius": 0.013, "-neck": 0.12, "-seed": seed, "-tend": 1.7, "-every": 0.02}


def value_of(problem, times, places, masses):
    """What a problem is judged by; places (T x N): the coordinates along() of the disks, m."""
    if problem == "collapse":
        return mean_distance(times, places, masses)
    return mean_height(times, places, masses) if problem == "fall" else discharge_time(times, places)


def along(problem):
    """The coordinate that matters: 0 is x, 1 is y."""
    return 0 if problem == "collapse" else 1


def by_suite(problem, level, seed, out, more, limit):
    """(value, CPU s, MiB, CPU s less that of one step) of the suite."""
    script, options = options_of(problem, seed)
    step = {"fall": FALL_STEPS, "collapse": COLLAPSE_STEPS}.get(problem, STEPS)[level]
    folder = out / "runs" / f"{problem}_{level}_{seed}"
    done = finished(run_case(script, {**options, **more, "-dt": step}, out=folder, limit=limit))
    one = finished(run_case(script, {**options, **more, "-dt": step, "-tend": step}, out=folder.with_name(f"{folder.name}_one"),
        limit=limit))
    return value_of(problem, *suite_rows(folder, "xy"[along(problem)])), done.cpu_s, done.memory_mb, done.cpu_s - one.cpu_s


def by_elements(problem, level, seed, out, limit):
    """The same of LIGGGHTS, from the first row of a short run of the suite, which is not timed. It goes on for another row, because
    its rows do not end at the end time."""
    if not with_liggghts.program():
        raise BadInput(with_liggghts.MISSING)
    script, options = options_of(problem, seed)
    first = out / "runs" / f"{problem}_start_{seed}"
    if not (first / "particles.csv").is_file():
        finished(run_case(script, {**options, "-dt": 0.02, "-tend": 0.02}, out=first, limit=limit))
    young = {"fall": FALL_MODULI, "collapse": COLLAPSE_MODULI}.get(problem, MODULI)[level]
    kept = [0] if problem == "collapse" else None  # the gates are gone
    one = with_liggghts.compute(first, young, out / "runs" / f"{problem}_elements_one", 1e-9, 1e-9, limit, at=0, kept=kept)[3]
    times, places, masses, done = with_liggghts.compute(first, young, out / "runs" / f"{problem}_elements_{level}_{seed}",
        options["-every"], options["-tend"] + options["-every"], limit, at=0, kept=kept)
    return value_of(problem, times, places[:, :, along(problem)], masses), done.cpu_s, done.memory_mb, done.cpu_s - one.cpu_s


def measured(problem, program, level, seeds, out, limit, kept):
    """The job judged by the program's own limit: mean over seeds. kept: {key: result}, for the job that follows."""
    more = LOOSER if program == LOOSE else {}
    runs = [by_elements(problem, level, seed, out, limit) if program == ELEMENTS else
            by_suite(problem, level, seed, out, more, limit) for seed in range(1, seeds + 1)]
    values, cpu, memory, steps = (np.array(column) for column in zip(*runs))
    kept[problem, program, level] = {"unknowns": {"fall": 50, "collapse": 1000}.get(problem, 500), "cpu_s": float(cpu.mean()),
        "memory_mb": float(memory.max())}, float(values.mean()), max(float(steps.mean()), 1e-3)
    return judged(problem, program, level, "own", kept)


def judged(problem, program, level, by, kept):
    """A result that is kept, against a limit: "own", "common", or "steps", the own one with the time without the start."""
    if (problem, program, level) not in kept:
        raise BadInput(with_liggghts.MISSING if program == ELEMENTS and not with_liggghts.program() else "its run gave no value")
    costs, value, steps = kept[problem, program, level]
    if by == "steps":
        costs = {**costs, "cpu_s": steps}
    limit = LIMITS[problem]["common"] if by == "common" else LIMITS[problem]["own"][ELEMENTS if program == ELEMENTS else OURS]
    return {**costs, "error": abs(value / limit - 1)}


def discrete_jobs(out, levels, seeds, limit):
    """levels: {problem: {program: levels}}. Without LIGGGHTS one job says so for each of its curves."""
    jobs, kept = [], {}
    for problem, programs in levels.items():
        for level in range(4):
            for program, those in programs.items():
                if level not in those or program == ELEMENTS and not with_liggghts.program() and level != min(those):
                    continue
                jobs.append(Job("discrete", problem, program, level, functools.partial(measured, problem, program, level,
                    seeds if problem == "discharge" else 1, out, limit, kept)))
                if len({LIMITS[problem]["common"], *LIMITS[problem]["own"].values()}) > 1:
                    jobs.append(Job("discrete", f"{problem}, common limit", program, level, functools.partial(judged, problem,
                        program, level, "common", kept)))
                jobs.append(Job("discrete", f"{problem}, without the start", program, level, functools.partial(judged, problem,
                    program, level, "steps", kept)))
    return jobs
