"""The figure of the benchmark: a panel a problem, and one on what is skipped."""
import math

from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter

from tools.bench.page import groups, programs, with_error
from tools.plot.style import PAGE_WIDTH, plt, save

# Colour, marker and line of a program in every panel; told apart by marker and line in grey.
STYLES = {
    "standard": ("#0072b2", "o", "-"), "published": ("#d55e00", "s", "--"), "NGSolve": ("#009e73", "^", "-."),
    "tensorial": ("#56b4e9", "<", (0, (4, 2))), "multipliers": ("#e69f00", "h", (0, (1, 1))),
    "scikit-fem": ("#000000", "D", ":"), "lbmpy": ("#cc79a7", "v", (0, (5, 1, 1, 1, 1, 1))), "SciPy": ("#000000", "p", (0, (7, 2))),
    "LIGGGHTS": ("#e69f00", "H", (0, (2, 2))), "standard, loose": ("#56b4e9", "d", (0, (3, 1, 1, 1))),
    "accelerated": ("#56b4e9", "P", (0, (3, 1))), "piqp": ("#e69f00", "X", "-."), "clarabel": ("#595959", "<", "--"),
    "scs": ("#000000", ">", ":"), "osqp": ("#a05000", "*", (0, (1, 1))), "no particles in the program": ("#009e73", "h", ":"),
    "conjugate gradients": ("#e69f00", "v", (0, (4, 2))),
    "standard, in the jet": ("#56b4e9", "d", (0, (6, 1))), "standard, 3 mm": ("#003f66", "X", (0, (2, 1))),
        "standard, 3 mm, carried": ("#cc79a7", "P", (0, (4, 1, 1, 1))),
}
SHORT = {("flow", "2d1"): "DFG 2D-1, drag", ("flow", "2d2"): "DFG 2D-2, worst of three", ("flow", "cavity"): "cavity, Re 1000",
    ("particles", "settling"): "settling disk, velocity",
         ("particles", "turning"): "disk in shear, rotation",
         ("particles", "pair"): "two settling disks, heights",
         ("particles", "sphere"): "settling sphere, peak speed",
         ("discrete", "discharge"): "500 disks leave an hourglass",
         ("discrete", "fall"): "50 falling disks, own limits", ("discrete", "fall, common limit"): "50 falling disks, common limit",
         ("discrete", "fall, without the start"): "50 falling disks, without starts",
         ("discrete", "discharge, without the start"): "hourglass, without starts",
         ("discrete", "collapse"): "collapse of 1,000 disks",
         ("discrete", "collapse, without the start"): "collapse, without starts",
         ("transport", "spheres"): "1,000 carried spheres",
             ("transport", "step"): "carried spheres",
         ("contacts", "number"): "contacts", ("scaling", "unknowns"): "settling disk",
             ("scaling", "particles"): "disks in the pipe", ("scaling", "sphere"): "settling sphere"}
FEATURES = {"contacts of carried spheres": "contacts, spheres", "contacts of spheres far apart": "used, far apart"}
SIZES = {"number": "disks", "step": "spheres", "unknowns": "unknowns", "sphere": "unknowns", "particles": "disks (0 drawn at 0.3)"}


def look(name):
    """Keywords of a program's curve."""
    colour, marker, dash = STYLES.get(name, ("#000000", "o", "-"))
    return {"color": colour, "marker": marker, "linestyle": dash, "markersize": 7 if marker == "*" else 4.5, "linewidth": 1.2}


def ticks(low, high, digits):
    """The numbers d 10^k of these digits d from low to high."""
    first, last = math.floor(math.log10(low)), math.floor(math.log10(high))
    return [digit * 10.0**power for power in range(first, last + 1) for digit in digits if low <= digit * 10.0**power <= high]


def plain(axis):
    """At most about five plain numbers on a logarithmic axis, at least two where there is room for labels of two."""
    low, high = axis.get_view_interval()
    decades = math.log10(high / low)
    few = ticks(low, high, (1, 2, 5))
    if len(few) < 2:  # LogLocator would label all digits, over each other
        some = ticks(low, high, range(1, 10))
        axis.set_major_locator(FixedLocator(some[::-(-len(some) // 4)] if some else few))
    else:
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if decades < 1.2 else (1, 3) if decades < 2.2 else (1,), numticks=7))
    axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}" if 1e-3 <= v < 1e4 else f"$10^{{{math.log10(v):.0f}}}$"
        if abs(math.log10(v) % 1) < 1e-9
                                           else f"${v / 10**math.floor(math.log10(v)):.0f}\\cdot10^{{{math.floor(math.log10(v))}}}$"))
    axis.set_minor_formatter(NullFormatter())


def draw_points(axes, points):
    """One problem; returns the programs drawn."""
    error, key = with_error(points), (points[0].section, points[0].problem)
    drawn = []
    for name, some in programs(points).items():
        some = [p for p in some if not p.note and p.cost > 0 and (not error or p.error > 0)]
        if not some:
            continue
        x = [p.cost if error else max(p.unknowns, 0.3) for p in some]
        y = [p.error if error else p.cost for p in some]
        axes.plot(x, y, **look(name))
        if not error:
            axes.vlines(x, [p.spread[0] for p in some], [p.spread[1] for p in some], color=STYLES.get(name, ("#000000",))[0],
                linewidth=0.8)
        else:
            axes.hlines(y, [p.spread[0] for p in some], [p.spread[1] for p in some], color=STYLES.get(name, ("#000000",))[0],
                linewidth=0.8)
        drawn.append(name)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.margins(0.12)
    low, high = axes.get_ylim()
    if high < 4 * low:  # a nearly level curve is to look level
        axes.set_ylim(low / 2, high * 2)
    step = any(math.isfinite(p.step_s) for p in points)
    axes.set_xlabel("CPU time (s)" if error else SIZES[points[0].problem])
    axes.set_ylabel(("residual (mean radii)" if points[0].section == "contacts" else "relative error")
        if error else f"CPU time of a {'step' if step else 'solve'} (s)")
    axes.set_title(SHORT.get(key, f"contacts, {points[0].problem}"))
    axes.grid(True)
    plain(axes.xaxis)
    plain(axes.yaxis)
    return drawn


def draw_skipped(axes, skipped):
    """Differences with their quartiles; the target as a line."""
    some = [s for s in skipped if not s.note]
    for k, s in enumerate(some):
        axes.plot([s.quartiles[0], s.quartiles[1]], [k, k], color="#808080", linewidth=2, solid_capstyle="butt", zorder=1)
        axes.plot([s.percent], [k], marker="o" if s.name != "none" else "D", color="#0072b2" if s.name != "none" else "black",
            markersize=4, zorder=2)
    axes.axvline(1, color="black", linewidth=0.8, linestyle="--")
    axes.axvline(0, color="black", linewidth=0.5)
    axes.set_xscale("symlog", linthresh=5, linscale=2)
    low, high = min([-2, *(s.quartiles[0] for s in some)]), max([3, *(s.quartiles[1] for s in some)])
    axes.set_xlim(1.2 * low, 1.2 * high)
    axes.set_xticks([t for t in (-100, -20, -5, -1, 1, 5, 20, 100) if 1.2 * low <= t <= 1.2 * high])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes.set_yticks(range(len(some)), [FEATURES.get(s.name, s.name) for s in some])
    axes.invert_yaxis()
    axes.set_xlabel("extra time of a step when\nthe feature is off (%); target 1")
    axes.set_title("features that are not used")


def draw(points, skipped, path):
    """Write the figure; returns its path, None where nothing has a number."""
    shown = {key: some for key, some in groups(points).items() if key != ("particles", "suspension") and any(not p.note
        for p in some)}
    number = len(shown) + bool(skipped)
    if not number:
        return None
    columns = min(3, number)
    rows = -(-number // columns)
    figure, panels = plt.subplots(rows, columns, figsize=(PAGE_WIDTH * 1.2, 2.55 * rows + 0.7), layout="constrained", squeeze=False)
    flat, names = list(panels.flat), []
    for axes, some in zip(flat, shown.values()):
        names += [name for name in draw_points(axes, some) if name not in names]
    if skipped:
        draw_skipped(flat[len(shown)], skipped)
    for axes in flat[number:]:
        axes.set_visible(False)
    handles = [Line2D([], [], label=name, **look(name)) for name in STYLES if name in names]
    figure.legend(handles=handles, loc="outside upper center", ncols=6, handlelength=3.2)
    return save(figure, path)
