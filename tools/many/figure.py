"""The picture of a sweep: each quantity over the first parameter that varies, with the spread over seeds."""
import re
import textwrap

import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from tools.base.command import BadInput
from tools.base.expressions import is_expression, unit_in, unit_of
from tools.base.run_folder import RunFolder
from tools.many.plan import value_of
from tools.many.table import is_number, mean_and_error, state
from tools.plot.style import MARKERS, PAGE_WIDTH, curve, plt, save

WIDE = 20  # ratio of the largest to the least value from which an axis is logarithmic
LINE = 32  # signs of a line of a label
FEW = 8  # values that are ticks of their own
NAMED = {"mean_u": (1, -1, 0), "mean_v": (1, -1, 0), "mean_w": (1, -1, 0), "peak_speed": (1, -1, 0), "mean_omega": (0, -1, 0),
    "final_x": (1, 0, 0), "final_y": (1, 0, 0), "final_z": (1, 0, 0), "mean_kinetic_energy": (1, -2, 1),
    "mean_pressure_drop": (-1, -2, 1), "mean_fx": (0, -2, 1), "mean_fy": (0, -2, 1), "mean_torque": (1, -2, 1),
    "mean_wall_fx": (0, -2, 1), "mean_flux": (2, -1, 0)}


def units(sweep, records):
    """({quantity: unit}, {parameter: unit}) as the first run that finished has them."""
    for record in records:
        try:
            run = RunFolder(record["run"])
            given = run.info.get("units") or {}
        except BadInput:
            continue
        if state(record) == "finished":
            found = {}
            for name in sweep.quantities:
                word, _, rest = name.partition(":")
                found[name] = (unit_of(name, run) if is_expression(name) else run.result_units.get(rest, "") if word == "result"
                    else unit_in(NAMED[word], run) if word in NAMED else "")
            return found, {name: str(given.get(f"-{name}", "")) for name in sweep.vary}
    return {}, {}


def with_unit(name, unit):
    """A label: the name, and its unit in brackets, powers raised."""
    raised = re.sub(r"(?<=[A-Za-z])-?[0-9]+", r"$^{\g<0>}$", unit)
    return f"{name} ({raised})" if unit else name


def words_of(quantity, unit=""):
    """A quantity and its unit for the label of an axis, in lines; the unit may get a power of ten."""
    words = "\n".join(textwrap.wrap(quantity.removeprefix("result:").replace(":", " ").replace("_", " "), LINE))
    long = unit and len(f"{words.rpartition(chr(10))[2]} ({unit})") > LINE - 5
    return f"{words}\n{with_unit('', unit).strip()}" if long else with_unit(words, unit)


def axis_of(sweep):
    """(the parameter along the axis, whether means are taken over all that varies)."""
    kept = [name for name, texts in sweep.vary.items() if name not in sweep.over and len(texts) > 1]
    numbers = [name for name in kept if is_number(sweep.vary[name])]
    return ((numbers or kept)[0], False) if kept else (next(iter(sweep.over or sweep.vary)), bool(sweep.over))


def places(texts):
    """(places of the values on the axis, function that fits an axis to them)."""
    if not is_number(texts):
        return np.arange(len(texts), dtype=float), lambda axes: axes.set_xticks(range(len(texts)), texts)
    values = np.array([value_of(text) for text in texts])

    def fit(axes):
        if values.min() > 0 and values.max() >= WIDE * values.min():
            axes.set_xscale("log")
        if len(values) <= FEW:
            axes.xaxis.set_major_locator(FixedLocator(sorted(values)))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
    return values, fit


def draw(sweep, records, groups):
    """Writes sweep.png; returns its path, None where no run has a value. groups: those of tools.many.table.means."""
    sweep.out.joinpath("sweep.png").unlink(missing_ok=True)
    shown = [name for name in sweep.quantities if any(values[name] for _, values, _ in groups)]
    if not shown:
        return None
    along, alone = axis_of(sweep)
    of_quantity, of_parameter = units(sweep, records)
    at, fit = places(sweep.vary[along])
    place = dict(zip(sweep.vary[along], at))
    figure, panels = plt.subplots(len(shown), 1, figsize=(0.75 * PAGE_WIDTH, 2.5 * len(shown) + 0.6), layout="constrained",
        squeeze=False, sharex=True)
    for axes, name in zip(panels[:, 0], shown):
        if alone:
            one_family(axes, sweep, records, name, place, along)
        else:
            families(axes, sweep, groups, name, place, along, of_parameter)
        fit(axes)
        axes.margins(x=0.08)
        axes.grid(True)
        axes.set_ylabel(words_of(name, of_quantity.get(name, "")))
    panels[-1, 0].set_xlabel(with_unit(along, of_parameter.get(along, "")))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside lower center", ncols=min(3, len(labels)))
    failed = sum(state(record) != "finished" for record in records)
    number = f"{len(records)} runs" + (f", {failed} of them without values" if failed else "")
    figure.suptitle(f"{sweep.case.replace('_', ' ')}: {number}", fontsize=10)
    return save(figure, sweep.out / "sweep.png")


def families(axes, sweep, groups, name, place, along, units_of):
    """A curve for each combination of the other parameters: means, bars of the standard error, and the single values."""
    lines = {}
    for rest, values, _ in groups:
        others = tuple((key, text) for key, text in rest.items() if key != along and len(sweep.vary[key]) > 1)
        lines.setdefault(others, []).append((place[rest[along]], values[name]))
    several = any(len(values) > 1 for line in lines.values() for _, values in line)
    for k, (others, line) in enumerate(lines.items()):
        line = sorted([pair for pair in line if pair[1]], key=lambda pair: pair[0])
        if not line:
            continue
        means, errors = zip(*(mean_and_error(values) for _, values in line))
        look, x = curve(k), [where for where, _ in line]
        label = ", ".join(f"{key} {text} {units_of.get(key, '')}".rstrip() for key, text in others)
        if several:
            label = f"{label}: mean and standard error" if label else "mean and standard error"
            for where, values in line:
                axes.plot([where] * len(values), values, ".", color=look["color"], alpha=0.35, markersize=4, zorder=1)
        axes.errorbar(x, means, yerr=np.nan_to_num(errors) if several else None, marker=MARKERS[k % len(MARKERS)], markersize=5,
            capsize=2.5, elinewidth=1, label=label or None, **look)


def one_family(axes, sweep, records, name, place, along):
    """The value of each run, with mean and standard error of all as a line and a band."""
    pairs = [(place[point[along]], record["values"][name][0]) for point, record in zip(sweep.points, records)
        if np.isfinite(record["values"][name][0])]
    axes.plot(*zip(*pairs), linestyle="none", marker="o", markersize=4, color=curve(0)["color"], label="runs")
    mean, error = mean_and_error([value for _, value in pairs])
    axes.axhline(mean, label="mean and standard error", **curve(1))
    if np.isfinite(error):
        axes.axhspan(mean - error, mean + error, color=curve(1)["color"], alpha=0.2, linewidth=0)
