"""The figures: one map, and all of them on a page. Each cell has a letter besides its colour."""
import math
import textwrap

from matplotlib.patches import Patch, Rectangle

from tools.plot.style import PAGE_WIDTH, plt, save
from tools.stress.classes import LETTERS, WORDS

# Pale to dark in grey print too; hatched where a run failed.
COLOURS = {"accurate": "#f7f7f7", "stable": "#bcd7e8", "stopped": "#e6c35c", "late": "#b08fc7", "overlap": "#c8553d",
           "blown up": "#7a1f1f", "not run": "#ffffff"}
INK = {"overlap": "white", "blown up": "white"}
HATCH = {"overlap": "///", "blown up": "xxx", "not run": "..."}


def draw_cells(axes, one, grid, rows, size=9, short=False):
    """The cells of a map with their letters; a thick frame round the case's own values."""
    xs, ys = list(dict.fromkeys(x for x, _ in grid)), list(dict.fromkeys(y for _, y in grid))
    for x, y in grid:
        kind, i, j = rows[x, y]["class"], xs.index(x), ys.index(y)
        axes.add_patch(Rectangle((i - 0.5, j - 0.5), 1, 1, facecolor=COLOURS[kind], hatch=HATCH.get(kind), edgecolor="#505050",
            linewidth=0.6))
        box = {"facecolor": COLOURS[kind], "edgecolor": "none", "pad": 0.6} if kind in HATCH else None
        axes.text(i, j, LETTERS[kind], ha="center", va="center", fontsize=size, color=INK.get(kind, "black"), bbox=box)
        if (x, y) == one.default:
            axes.add_patch(Rectangle((i - 0.5, j - 0.5), 1, 1, fill=False, edgecolor="black", linewidth=2.2, zorder=5))
    axes.set(xlim=(-0.5, len(xs) - 0.5), ylim=(-0.5, len(ys) - 0.5))
    axes.set_xticks(range(len(xs)), [one.x.text(x) for x in xs])
    axes.set_yticks(range(len(ys)), [one.y.text(y) for y in ys])
    if max(len(one.x.text(x)) for x in xs) * len(xs) > (30 if short else 60):
        plt.setp(axes.get_xticklabels(), rotation=35, ha="right", rotation_mode="anchor")
    axes.set_xlabel(one.x.label, fontsize=size)
    axes.set_ylabel(one.y.label, fontsize=size)
    axes.tick_params(length=0, labelsize=size - 1)
    axes.set_title(one.title, fontsize=size + (0 if short else 1))


def legend(figure, kinds, columns):
    """What the letters stand for."""
    handles = [Patch(facecolor=COLOURS[kind], hatch=HATCH.get(kind), edgecolor="#505050", label=f"{LETTERS[kind]}  {WORDS[kind]}")
        for kind in kinds]
    handles.append(Patch(facecolor="none", edgecolor="black", linewidth=2.0, label="near the case's default"))
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)


def shown(maps):
    """The classes that occur, the good ones always."""
    there = {row["class"] for _, grid, rows in maps for row in (rows[pair] for pair in grid)}
    return [kind for kind in LETTERS if kind in there | {"accurate", "stable", "stopped", "blown up"}]


def draw_map(one, grid, rows, out):
    """MAP.png; returns its path."""
    number = len({y for _, y in grid})
    figure, axes = plt.subplots(figsize=(PAGE_WIDTH, 1.9 + 0.3 * number), layout="constrained")
    draw_cells(axes, one, grid, rows)
    axes.set_title("")
    figure.suptitle("\n".join([one.title, *textwrap.wrap(f"A: {one.held}", 100)]), fontsize=8.5)
    legend(figure, shown([(one, grid, rows)]), 3)
    return save(figure, out / f"{one.name}.png")


def draw_all(maps, path):
    """All maps [(map, grid, rows)] on a page; returns the path."""
    columns = 3
    weights = [max(len({y for _, y in grid}), 3) for _, grid, _ in maps]
    lines = [max(weights[k:k + columns]) for k in range(0, len(maps), columns)]
    figure, panels = plt.subplots(len(lines), columns, figsize=(14.5, sum(0.85 + 0.17 * n for n in lines) + 0.7), squeeze=False,
                                  layout="constrained", height_ratios=[0.85 + 0.17 * n for n in lines])
    for axes, (one, grid, rows) in zip(panels.ravel(), maps):
        draw_cells(axes, one, grid, rows, size=7, short=True)
    for axes in panels.ravel()[len(maps):]:
        axes.set_axis_off()
    legend(figure, shown(maps), math.ceil((len(shown(maps)) + 1) / 2))
    return save(figure, path)
