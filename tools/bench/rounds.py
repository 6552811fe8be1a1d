"""Jobs run in rounds, so that what disturbs a machine for a while disturbs all alike.

    samples = run_rounds(jobs, repeats=3, once_above=20)
    points = collect(samples)
    ratio_at_equal_error(points_of_one, points_of_another)
"""
import csv
import math
import statistics
import time
from dataclasses import dataclass, field
from typing import Callable

import numpy as np

from tools.base.command import BadInput
from tools.study.convergence import pareto


@dataclass
class Job:
    """One thing to time. run() gives a dict with any of unknowns, cpu_s, own_s, step_s, error,
    memory_mb (see Sample); what it raises as BadInput, or a key "note", is why it has no numbers."""
    section: str
    problem: str
    program: str
    level: int
    run: Callable


@dataclass
class Sample:
    """One run. unknowns: unknowns, disks or particles; cpu_s: user and system time of the whole
    process; own_s: without the start of the program's packages; step_s: CPU seconds of a time
    step; error: relative; memory_mb: peak MiB; note: why numbers are missing."""
    section: str
    problem: str
    program: str
    level: int
    repeat: int
    unknowns: float = math.nan
    cpu_s: float = math.nan
    own_s: float = math.nan
    step_s: float = math.nan
    error: float = math.nan
    memory_mb: float = math.nan
    note: str = ""


@dataclass
class Point:
    """The runs of one job: medians, and the least and the largest of what was repeated."""
    section: str
    problem: str
    program: str
    level: int
    number: int
    unknowns: float
    error: float
    memory_mb: float
    own_s: float
    step_s: float
    spread: tuple = field(default=(math.nan, math.nan))
    note: str = ""

    @property
    def cost(self):
        """Seconds of a step where the job gives them, else of the run."""
        return self.step_s if math.isfinite(self.step_s) else self.own_s


def run_rounds(jobs, repeats, once_above, say=print, clock=time.perf_counter, until=math.inf):
    """Every job once, then again and again; a job that took more than once_above seconds of wall
    clock, or failed, is not repeated. No round begins a job after the time `until` (of clock),
    but each job has been tried in the first round."""
    samples, done = [], set()
    for repeat in range(repeats):
        for number, job in enumerate(jobs):
            if number in done:
                continue
            begin = clock()
            if begin > until and repeat:
                return samples
            sample = Sample(job.section, job.problem, job.program, job.level, repeat)
            try:
                found = job.run()
            except BadInput as problem:
                found = {"note": str(problem)}
            for name, value in found.items():
                setattr(sample, name, value)
            if not math.isfinite(sample.own_s):
                sample.own_s = sample.cpu_s
            samples.append(sample)
            if sample.note or clock() - begin > once_above:
                done.add(number)
            say(line(sample))
    return samples


def line(sample):
    """One line of progress."""
    parts = [f"{sample.section} {sample.problem}, {sample.program}, level {sample.level}, run {sample.repeat + 1}:"]
    if sample.note:
        return " ".join([*parts, sample.note])
    if math.isfinite(sample.unknowns):
        parts.append(f"size {sample.unknowns:.0f},")
    if math.isfinite(sample.step_s):
        parts.append(f"{1e3 * sample.step_s:.3f} ms a step")
    else:
        parts.append(f"{sample.own_s:.3f} s")
    if math.isfinite(sample.error):
        parts.append(f"error {sample.error:.2e}")
    return " ".join(parts)


def earlier(path, parts):
    """The samples of a bench.csv but those of these parts."""
    try:
        with open(path, newline="", encoding="utf-8") as stream:
            rows = [row for row in csv.DictReader(stream) if row["section"] not in parts]
        return [Sample(**{name: kind(row[name]) for name, kind in Sample.__annotations__.items()}) for row in rows]
    except (OSError, KeyError, TypeError, ValueError):
        raise BadInput(f"{path} does not hold the runs of a benchmark: none can be kept") from None


def collect(samples):
    """Points in the order of their first sample."""
    groups = {}
    for sample in samples:
        groups.setdefault((sample.section, sample.problem, sample.program, sample.level), []).append(sample)
    points = []
    for key, some in groups.items():
        good = [s for s in some if not s.note]
        if not good:
            points.append(Point(*key, 0, *[math.nan] * 5, note=some[0].note))
            continue
        middle = {name: statistics.median(getattr(s, name) for s in good) for name in ("unknowns", "memory_mb", "own_s", "step_s")}
        point = Point(*key, len(good), middle["unknowns"], good[0].error, middle["memory_mb"], middle["own_s"], middle["step_s"])
        name = "step_s" if math.isfinite(point.step_s) else "own_s"
        costs = [getattr(s, name) for s in good]
        point.spread = (min(costs), max(costs))
        points.append(point)
    return points


def front(points):
    """(log cost, log error) of the points that no cheaper one of the same program beats, by rising cost."""
    both = np.array([(p.cost, p.error) for p in points if p.cost > 0 and p.error > 0
        and math.isfinite(p.cost * p.error)]).reshape(-1, 2)
    return np.log(both[pareto(*both.T)])


def cost_at(points, error):
    """Cost at which a program reaches this error, by straight lines between its best points in logarithms; nan beyond them."""
    curve = front(points)
    if not len(curve) or not curve[-1, 1] <= math.log(error) <= curve[0, 1]:
        return math.nan
    return math.exp(np.interp(math.log(error), curve[::-1, 1], curve[::-1, 0]))


def ratio_at_equal_error(mine, other):
    """(cost of other over cost of mine, the error it is read at, bound) by straight lines between
    the best points of each in logarithms, at the middle of the errors that both reach. Where the
    errors do not overlap the ratio is only bounded, and `bound` says so: ">" where other is dearer
    and less accurate than the cheapest point of mine, "<" the other way round; None where nothing
    can be said. No curve is extended beyond its points."""
    a, b = front(mine), front(other)
    if not len(a) or not len(b):
        return None

    def cost(curve, error):
        return np.interp(error, curve[::-1, 1], curve[::-1, 0])
    low, high = max(a[-1, 1], b[-1, 1]), min(a[0, 1], b[0, 1])
    if low <= high:
        at = 0.5 * (low + high)
        return math.exp(cost(b, at) - cost(a, at)), math.exp(at), ""
    if b[-1, 1] > a[0, 1]:  # the other's best is worse than the worst of mine: mine reaches it for less than its cheapest
        ratio, at, bound = math.exp(b[-1, 0] - a[0, 0]), b[-1, 1], ">"
        return (ratio, math.exp(at), bound) if ratio > 1 else None
    ratio, at, bound = math.exp(b[0, 0] - a[-1, 0]), a[-1, 1], "<"
    return (ratio, math.exp(at), bound) if ratio < 1 else None
