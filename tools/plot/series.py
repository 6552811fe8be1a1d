"""Time series of a run: fluid.csv over time, and the flux through each outlet."""
from textwrap import fill

import numpy as np
from matplotlib.ticker import MaxNLocator, NullFormatter

from tools.base.command import BadInput
from tools.base.mesh_files import SIDES
from tools.base.quantities import closed
from tools.plot import spheres
from tools.plot.captions import fit_label
from tools.plot.style import CURVES, LINE_MAP, PAGE_WIDTH, ROUNDING, curve, plt, save

ROW = 1.75  # inches: height of a row of panels
AXIS = 1.4  # inches: of the axes in it
SIGNS = 90  # of a legend across the page
NAMED = 24  # signs of a line in a legend


def outlets(run):
    """[(name, flux outwards (n,))] of fluxes.csv at the times of fluid.csv, for each label that is no inlet, where there are
    several; a side of a period stands for both."""
    if not run.has("fluxes"):
        return []
    table = run.columns("fluxes", "t", "label", "flux")
    moving = (run.info.get("labels") or {}).get("moving") or ()  # of a case; "inlet" of a run that does not list its labels
    labels = [int(one) for one in np.unique(table["label"]) if SIDES.get(int(one)) != "inlet" and one not in moving]
    found = []
    for label in labels:
        here = table["label"] == label
        name = run.sides.get(label) or SIDES.get(label, f"label {label}")
        found.append((name, np.interp(run.fluid["t"], table["t"][here], table["flux"][here])))
    names = [name for name, _ in found]
    for one, other in (("left", "right"), ("bottom", "top")):
        if one in names and other in names and np.allclose(sum(found[names.index(k)][1] for k in (one, other)), 0,
                atol=1e-9 * max(abs(found[names.index(one)][1]).max(initial=0), 1e-300)):
            found = [pair for pair in found if pair[0] != one]
    return found if len(found) > 1 else []


def series(run):
    """The panels of the time series: [(label of the axis, [(name, values)], log scale)]. What the run did not write is left out,
    and what is zero throughout: flux and pressure drop of a closed box, contacts, overlaps. Curves that are not of fluid.csv have
    their times too: (name, values, times)."""
    table = run.fluid
    length, second = run.units["length"], run.units["time"]
    pressure, energy = run.units_per_depth["pressure"], run.units_per_depth["energy"]

    def there(*pairs):
        return [(name, table[column]) for column, name in pairs if column in table]
    fluxes = there(("flux_in", "inlet"), ("flux_out", "outlet"))
    if fluxes and closed(run, max(abs(v).max(initial=0) for _, v in fluxes)):
        fluxes = []
    elif several := outlets(run):
        fluxes = fluxes[:1] + several
    wanted = [
        (f"flux ({length}$^2$/{second})", fluxes, False),
        (f"pressure drop ({pressure})", there(("pressure_drop", "")), False),
        (f"kinetic energy ({energy})", there(("kinetic_energy", "")), False),
        ("number", there(("particles", "particles inside"), ("contacts", "contacts")), False),
    ]
    if "worst_gap" in table and np.any(table.get("particles", 1)):
        overlap = np.maximum(0.0, -table["worst_gap"])
        smallest = run.particles["radius"].min() if run.has("particles") and len(run.particles["t"]) else None
        overlap[overlap < ROUNDING * (smallest or 1.0)] = 0.0
        label = "worst overlap / radius" if smallest else f"worst overlap ({length})"
        wanted.append((label, [("", overlap / (smallest or 1.0))], True))
    if "divergence" in table and "top_speed" in table:
        speed = np.where(table["top_speed"] > 0, table["top_speed"], np.nan)
        wanted.append(("norm of div u /\nlargest speed", [("", table["divergence"] / speed)], True))
    def tells(label, curves):  # bodies that are always as many tell nothing, unless they touch
        if label == "number" and all(np.ptp(v) == 0 for _, v in curves if len(v)) and not (len(curves) > 1 and curves[1][1].any()):
            return False
        return any(np.isfinite(v).any() and (v[np.isfinite(v)].any() or "energy" in label) for _, v in curves)
    panels = [panel for panel in wanted if tells(*panel[:2])]
    return spheres.track_panels(run) + [panel for panel in panels if spheres.tells(run, *panel[:2])] if run.in_space else panels


def beside(names, signs):
    """How many of the names of curves, wrapped, stand beside each other in a legend in a width of so many signs; 1 at least."""
    widths = [9 + max(map(len, name.split("\n"))) for name in names]  # with the piece of a line before each
    fits = [count for count in range(1, min(len(names), 4) + 1) if sum(map(max, np.array_split(widths, count))) <= signs]
    return max(fits, default=1)


def plot_series(run, path):
    """fluid.csv over time; overlaps are over the smallest radius."""
    wanted = series(run)
    t = run.fluid["t"]
    if not wanted or not len(t):
        raise BadInput(f"{run.folder / 'fluid.csv'} has no rows or none of the columns that are drawn")
    columns = min(len(wanted), 2)
    rows = -(-len(wanted) // columns)
    figure = plt.figure(figsize=(PAGE_WIDTH, 0.5 + ROW * rows), layout="constrained")
    grid, axes = figure.add_gridspec(rows, columns), []
    for place in range(len(wanted)):  # an odd last one is as wide as the page
        row, column = divmod(place, columns)
        alone = place == len(wanted) - 1 and column == 0
        axes.append(figure.add_subplot(grid[row, :] if alone else grid[row, column], sharex=axes[0] if axes else None))
    for one, (label, curves, log) in zip(axes, wanted):
        for k, (name, values, *own) in enumerate(curves):
            one.plot(own[0] if own else t, np.where(values > 0, values, np.nan) if log else values, label=name,
                     **(curve(k) if len(curves) <= len(CURVES) else {"color": LINE_MAP(k / len(curves)), "linewidth": 0.7}),
                     **({"marker": ".", "markersize": 3 if len(t) > 1 else 7} if len(t) == 1 or log
                         and (len(t) <= 150 or np.count_nonzero(values > 0) <= 150) else {}))
        if log and any((values > 0).any() for _, values, *_ in curves):
            one.set_yscale("log")
            one.yaxis.set_minor_formatter(NullFormatter())
            low, high = one.get_ylim()
            if np.floor(np.log10(high)) - np.ceil(np.log10(low)) < 1:  # two labelled ticks at least
                one.set_ylim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        if 1 < len(curves) <= len(CURVES):  # in a row above the curves
            low, high = one.get_ylim()
            names = [fill(name, NAMED) for name, *_ in curves]
            lines = max(name.count("\n") + 1 for name in names)
            across = beside(names, SIGNS * len(one.get_subplotspec().colspan) / columns)
            one.set_ylim(low, high + 0.2 * lines * -(-len(names) // across) * (high - low))
            one.legend(names, loc="upper center", ncols=across)
        if label == "number":
            one.yaxis.set_major_locator(MaxNLocator(integer=True))
        fit_label(one, label, AXIS)
        one.grid(True)
    for place, one in enumerate(axes):  # wide labels, such as 0.025, would run together
        one.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        last = place // columns >= rows - 1 - (len(wanted) % columns)  # an odd panel has another scale than those above
        one.tick_params(labelbottom=last)
        if last:
            one.set_xlabel(f"t ({run.units['time']})")
    figure.suptitle(f"{(run.whole if run.in_space else run).title}: time series", fontsize=10)
    return save(figure, path)
