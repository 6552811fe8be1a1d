"""What a refinement study says: order, limit and uncertainty of each quantity, in lines.

records: dicts of tools.study with asked (the size asked for), meshsize, dt, mean_dt (where -cfl made the steps
smaller, else 0), vertices, dimension (of the domain), cpu_s, status, reason and values {quantity: (value, reason)}.
"""
import math

from tools.study import convergence


def name_of(size, dt):
    """The name of a run's folder: sizes of 12 digits are told apart."""
    parts = [f"{letter}{value:.12g}" for letter, value in (("h", size), ("dt", dt)) if value is not None]
    return "_".join(parts) or "default"


def family(records, quantity, key):
    """(sizes, values) along one size, the other one fixed: the finest other one that has
    most runs with a value (three count as most)."""
    other = {"meshsize": "dt", "dt": "meshsize"}[key]
    best = ([], [])
    for fixed in sorted({r[other] for r in records}, key=lambda v: -(v or 0)):
        rows = sorted((r[key], r["values"][quantity][0]) for r in records
                      if r[other] == fixed and r[key] is not None and math.isfinite(r["values"][quantity][0])
                      and not (key == "dt" and r.get("mean_dt")))
        if rows and min(len(rows), 3) >= min(len(best[0]), 3):
            best = tuple(map(list, zip(*rows)))
    return best


def limits(study, records, quantity):
    """{"meshsize": (Estimate, finest value of the family), "dt": ...}; a size with fewer
    than two values is left out."""
    found = {}
    for key in ("meshsize", "dt"):
        sizes, values = family(records, quantity, key)
        if len(values) >= 2:
            found[key] = convergence.estimate(sizes, values, study.formal_order), values[0]
    return found


def finest_run(records, quantity):
    """The record of the smallest element size and step that has a value, None if none has."""
    good = [r for r in records if math.isfinite(r["values"][quantity][0])]
    return min(good, key=lambda r: ((r["meshsize"] or 0), (r["dt"] or 0)), default=None)


def finest(records, quantity):
    """Its value, nan if none has one."""
    run = finest_run(records, quantity)
    return run["values"][quantity][0] if run else math.nan


def extrapolated(study, records, quantity):
    """(limit, uncertainty) in both sizes, where no size extrapolates the finest value; nan where nothing can be said."""
    found = limits(study, records, quantity)
    if not found:
        return math.nan, math.nan
    return (finest(records, quantity) + sum(one.limit - value for one, value in found.values()),
            sum(one.uncertainty for one, _ in found.values()))


def extrapolates(study, records, quantity):
    """Whether the limit in some size is more than the finest value."""
    return any(one.extrapolated for one, _ in limits(study, records, quantity).values())


def assumed(study, records, quantity):
    """Whether a limit that errors are taken against was extrapolated with an order that no values show."""
    return not study.references and any(one.extrapolated and math.isnan(one.order) for one, _ in limits(study, records,
        quantity).values())


def against(study, records, quantity):
    """What errors are taken against, in words."""
    if study.references:
        return "the reference"
    return "the extrapolated value" if extrapolates(study, records, quantity) else "the finest run"


def error_of(study, records, quantity, record, reference):
    """The error of a run; nan for the finest where errors are taken against it: it is not known there."""
    if against(study, records, quantity) == "the finest run" and record is finest_run(records, quantity):
        return math.nan
    return record["values"][quantity][0] - reference


def doubts(records):
    """What the sizes that were asked for do not say, in lines."""
    lines, counts = [], {r["meshsize"]: r["vertices"] for r in records if r["meshsize"] and r.get("vertices", math.nan) > 0}
    smaller = sorted({(r["dt"], r["mean_dt"]) for r in records if r.get("mean_dt")}, reverse=True)
    if smaller:
        lines.append("note: -cfl made steps smaller: " + ", ".join(f"{mean:.3g} s in the mean instead of {dt:.3g}" for dt,
            mean in smaller)
                     + "; these runs have no part in an order of the time step (-- -cfl 0 keeps the steps)")
    power = max((r.get("dimension", 2) for r in records), default=2)
    for fine, coarse in zip(sorted(counts), sorted(counts)[1:]):
        if not 0.75 < counts[fine] / counts[coarse] * (fine / coarse) ** power < 1.33:
            lines.append(f"note: sizes {coarse:.6g} and {fine:.6g} make {counts[coarse]} and {counts[fine]} vertices, "
                f"{counts[fine] / counts[coarse]:.3g} times as many where "
                         f"{(coarse / fine) ** power:.3g} would be refined everywhere: the orders are not those of the scheme (a "
                             f"gmsh script: --proportional)")
    return lines


def report(study, records, references):
    """What the study says of each quantity, in lines."""
    lines = doubts(records)
    for name in study.quantities:
        lines.append(f"{name}:")
        for key, (one, _) in limits(study, records, name).items():
            word = {"meshsize": "element size", "dt": "time step"}[key]
            order = f"observed order {one.order:.2f}" if math.isfinite(one.order) else "no observed order"
            what = "limit" if one.extrapolated else "finest value"
            lines.append(f"  {word}: {order}, {what} {one.limit:.6g} +- {one.uncertainty:.2g} ({one.note})")
            if study.references:
                sizes, values = family(records, name, key)
                fit = convergence.fitted_order(sizes, [v - references[name] for v in values])
                if math.isfinite(fit):
                    lines.append(f"    order of the error against the reference: {fit:.2f}")
        limit, uncertainty = extrapolated(study, records, name)
        if math.isfinite(limit):
            some = extrapolates(study, records, name)
            lines.append(f"  finest {finest(records, name):.6g}" + (f", extrapolated {limit:.6g}" if some else "")
                + f" +- {uncertainty:.2g}"
                         + ("" if some else ", nothing extrapolated" + ("" if study.references else ": errors are differences to "
                             "the finest run"))
                         + (f", reference {references[name]:.6g}" if study.references else ""))
        else:
            lines.append("  nothing to extrapolate from")
        good = [r for r in records if math.isfinite(r["values"][name][0])]
        errors = [error_of(study, records, name, r, references[name]) for r in good]
        for k in convergence.pareto([r["cpu_s"] for r in good], errors):
            share = f" ({100 * errors[k] / abs(references[name]):+.3g} %)" if references[name] else ""
            lines.append(f"  Pareto: {good[k]['cpu_s']:8.2f} s CPU, error {errors[k]:+.3g}{share}, "
                         f"{name_of(good[k]['asked'], good[k]['dt']).replace('_', ' ')}")
    failed = [r for r in records if r["status"] != 0]
    for r in failed:
        lines.append(f"failed: {name_of(r['asked'], r['dt']).replace('_', ' ')}: {r['reason']}")
    if not study.timing and study.jobs > 1:
        lines.append("CPU times are of runs beside one another; --timing measures them one by one")
    return lines
