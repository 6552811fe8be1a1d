"""The page of the benchmark: bench.md and bench.csv."""
import dataclasses
import math
import os
from importlib import metadata

from tools.base.runner import commit, versions
from tools.base.tables import write_table
from tools.bench.rounds import Sample, cost_at, ratio_at_equal_error
from tools.study.convergence import fitted_order

TITLES = {
    ("flow", "2d1"): "DFG 2D-1: steady flow past a cylinder, error of the drag",
    ("flow", "2d2"): "DFG 2D-2: vortex shedding, largest error of drag, lift range and Strouhal number",
    ("flow", "cavity"): "Lid-driven cavity at Reynolds number 1000: largest error of the extrema on the centrelines",
    ("particles", "settling"): "Settling disk: mean velocity over 0.3 to 0.4 s",
    ("particles", "pair"): "Two settling disks: heights at 0.15 s",
    ("particles", "sphere"): "Settling sphere in the whole box: peak speed, against the experiment",
    ("particles", "turning"): "Disk turning between sheared plates, R/H = 0.25",
    ("particles", "suspension"): "A step with 50 disks in the pipe",
    ("discrete", "discharge"): "500 disks leave an hourglass: time of half of them, against the common limit",
    ("discrete", "fall"): "50 falling disks: mean height at 8 s, against the limit of each series",
    ("discrete", "fall, common limit"): "50 falling disks, against the common limit",
    ("discrete", "fall, without the start"): "50 falling disks, against the limit of each series, without the time of starts",
    ("discrete", "collapse"): "1,000 loose disks with friction collapse: mean distance at 0.4 s, against the stiffest elements",
    ("discrete", "collapse, without the start"): "1,000 loose disks with friction collapse, without the time of starts",
    ("discrete", "discharge, without the start"): "500 disks leave an hourglass, without the time of starts",
    ("transport", "spheres"): "1,000 spheres in a cellular flow: mean distance from the exact paths",
    ("transport", "step"): "A step of carried spheres",
    ("contacts", "number"): "Contact projection against the number of disks",
    ("scaling", "unknowns"): "A step of the settling disk against unknowns",
    ("scaling", "particles"): "A step of the pipe against disks in it",
    ("scaling", "sphere"): "A step of the settling sphere against unknowns",
}
OTHERS = ("ngsolve", "scikit-fem", "lbmpy", "pystencils", "piqp", "clarabel", "scs", "osqp", "scipy")


def title(section, problem):
    """Words for a problem."""
    return TITLES.get((section, problem), f"Contact projection of {problem}, residual in mean radii")


def equipment():
    """Versions of everything that is timed, in words."""
    found = versions()
    for name in OTHERS:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return ", ".join(f"{name} {version}" for name, version in found.items())


def seconds(value):
    """A time with three figures and its unit."""
    if not math.isfinite(value):
        return "-"
    for factor, unit in ((1, "s"), (1e3, "ms"), (1e6, "us")):
        if value * factor >= 1:
            return f"{value * factor:.3g} {unit}"
    return f"{value:.2g} s"


def groups(points):
    """{(section, problem): points} in order."""
    found = {}
    for point in points:
        found.setdefault((point.section, point.problem), []).append(point)
    return found


def programs(points):
    """{program: its points}."""
    found = {}
    for point in points:
        found.setdefault(point.program, []).append(point)
    return found


def with_error(points):
    """True if the problem has errors to hold against time."""
    return any(math.isfinite(p.error) for p in points) and points[0].problem != "number"


def table(points):
    """The lines of one problem's table."""
    error, sized = with_error(points), any(math.isfinite(p.memory_mb) for p in points)
    head = ["program", "size", *(["error"] if error else []), "median", "least to largest", "runs", *(["MiB"] if sized else [])]
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    for p in points:
        if p.note:
            lines.append(f"| {p.program} |" + " |" * (len(head) - 2) + f" {p.note.replace('|', '/')} |")
            continue
        cells = [p.program, f"{p.unknowns:,.0f}", *([f"{p.error:.2e}"] if error else []), seconds(p.cost),
                 f"{seconds(p.spread[0])} to {seconds(p.spread[1])}", str(p.number),
                 *([f"{p.memory_mb:.0f}" if math.isfinite(p.memory_mb) else "-"] if sized else [])]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def ratios(points):
    """What each program costs at the error that the standard scheme reaches too."""
    mine, lines = [p for p in points if p.program == "standard"], []
    for name, theirs in programs(points).items():
        if name == "standard":
            continue
        found = ratio_at_equal_error(mine, theirs)
        if found:
            ratio, at, bound = found
            words = {"": f"{ratio:.3g} times the time of the standard scheme",
                     ">": f"more than {ratio:.3g} times (its best error needs more time than the standard scheme's cheapest, "
                         f"better one)",
                     "<": f"less than {ratio:.3g} times (its cheapest run is better than the standard scheme's best)"}[bound]
            lines.append(f"- {name}, at an error of {at:.2g}: {words}")
        elif any(not p.note for p in theirs):
            lines.append(f"- {name}: no error that both reach; nothing to compare")
    return lines


def at_errors(points, errors=(0.01, 0.02, 0.05)):
    """What each program costs at given errors, read between measured points."""
    lines = []
    for name, some in programs(points).items():
        found = [f"{seconds(cost_at(some, error))} at {100 * error:g} %" for error in errors if math.isfinite(cost_at(some, error))]
        if any(not p.note for p in some):
            lines.append(f"- {name}: " + (", ".join(found) if found else "none of the errors "
                + ", ".join(f"{100 * error:g}" for error in errors) + " % is between measured points"))
    return lines


def exponents(points):
    """Ratios at equal size, over size 0, and fitted exponents of a problem whose sizes vary."""
    mine, lines = {p.unknowns: p.cost for p in points if p.program == "standard" and not p.note}, []
    for name, theirs in programs(points).items():
        both = [p for p in theirs if name != "standard" and not p.note and p.unknowns in mine]
        if both:
            lines.append(f"- {name} over standard: " + ", ".join(f"{p.cost / mine[p.unknowns]:.3g} at size {p.unknowns:,.0f}"
                for p in both))
    for name, theirs in programs(points).items():
        none, some = ([p for p in theirs if not p.note and (p.unknowns == 0) == empty] for empty in (True, False))
        if none and some:
            lines.append(f"- {name}, over size 0: " + ", ".join(f"{p.cost / none[0].cost:.3g} at size {p.unknowns:,.0f}"
                for p in some))
    for name, theirs in programs(points).items():
        sizes = [p.unknowns for p in theirs if not p.note and p.unknowns > 0]
        if len(set(sizes)) > 1:
            good = [p for p in theirs if not p.note and p.unknowns > 0]
            memory = fitted_order(sizes, [p.memory_mb for p in good])
            more = f", memory as size^{memory:.2f}" if math.isfinite(memory) else ""
            lines.append(f"- {name}: time as size^{fitted_order(sizes, [p.cost for p in good]):.2f}{more}")
    return lines


def skipped_table(skipped):
    """The lines on features that a scene does not use."""
    lines = ["| feature | what is compared | a step | without | difference, median (quartiles) | pairs | at most 1 % |",
        "|" + " --- |" * 7]
    for s in skipped:
        if s.note:
            lines.append(f"| {s.name} | {s.about} | | | {s.note.replace('|', '/')} | 0 | not measured |")
            continue
        verdict = ("noise of the machine" if s.name == "none" else "yes" if s.percent <= 1 else "within the quartiles"
            if s.quartiles[0] <= 1 else "NO")
        lines.append(f"| {s.name} | {s.about} | {seconds(s.used_s)} | {seconds(s.without_s)} | {s.percent:+.2f} % "
            f"({s.quartiles[0]:+.2f} to {s.quartiles[1]:+.2f}) "
                     f"| {s.pairs} | {verdict} |")
    return lines


def write_page(points, samples, skipped, missing, out, quick, minutes, loads, computer, more=()):
    """bench.md and bench.csv; missing: lines on peers that are not there; loads: load averages;
    computer: the machine in words; more: further lines of the page."""
    names = [field.name for field in dataclasses.fields(Sample)]
    write_table(out / "bench.csv", names, [[getattr(s, name) for name in names] for s in samples])
    lines = ["# Benchmark", "", f"`python -m tools.bench{' --quick' if quick else ''}` took {minutes:.1f} minutes on {computer}, "
        f"on one core of it; "
             f"commit {commit()}; load average {loads[0]:.1f} at the start, {loads[1]:.1f} at the end"
             + (" (other work ran beside it: the times are too long)." if max(loads) > 1.5 else "."), "",
             f"Versions: {equipment()}.", "",
             "Times are CPU seconds of one thread. All programs of a part ran one after the other, in rounds; a run above the "
                 "limit for repeats ran once. "
             "Packages are timed without their imports and code generation, FreeFEM with its start (about 0.1 s), but in the "
                 "parts that give the cost of a step. "
             "Ratios are read at an error that both programs reach, by straight lines between measured points in logarithms; "
                 "nothing is extrapolated. "
             "\"published\" is Lefebvre's scheme (in the contact parts, plain Uzawa), \"tensorial\" and \"multipliers\" "
                 "the other two of first order.", ""]
    lines += ["![Error against CPU time, scaling, and what is skipped](bench.png)", ""] if points or skipped else []
    lines += [f"- {line}" for line in missing] + ([""] if missing else [])
    for (section, problem), some in groups(points).items():
        lines += [f"## {title(section, problem)}", "", *table(some), ""]
        beside = ratios(some) if with_error(some) else exponents(some)
        beside += at_errors(some) if section == "discrete" else []
        lines += [*beside, ""] if beside else []
    if skipped:
        lines += ["## What a scene does not use", "", *skipped_table(skipped), ""]
    lines += more
    (out / "bench.md").write_text("\n".join(lines))
    return out / "bench.md"


def load():
    """Load average of the last minute, nan where the system has none."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
