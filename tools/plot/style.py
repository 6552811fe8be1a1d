"""The look of every figure, and the drawing of a scene: domain, velocity, particles.

Colours are told apart in grey print and by colour-blind readers: viridis for fields,
cividis for a property of particles, a fixed cycle with its own dash per curve.
"""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.collections import LineCollection, PatchCollection  # noqa: E402
from matplotlib.colors import to_rgba_array  # noqa: E402
from matplotlib.patches import Ellipse, Polygon, Rectangle  # noqa: E402
from matplotlib.ticker import FixedLocator, MaxNLocator  # noqa: E402

from tools.base.command import BadInput  # noqa: E402
from tools.base.mesh_files import AXIS, OPEN, SOLID, chains  # noqa: E402
from tools.base.outlines import placed  # noqa: E402
from tools.base.run_folder import own  # noqa: E402
from tools.plot.captions import LETTER, fold_powers, plain, thin_labels  # noqa: E402

FIELD_MAP, SIGNED_MAP = "viridis", "RdBu_r"
SHOWN = ("speed", "vorticity", "stream")  # what of a field is drawn
# The pale end of a map is lost on white paper, so lines use the darker part.
LINE_MAP = matplotlib.colors.LinearSegmentedColormap.from_list(
    "cividis_dark", matplotlib.colormaps["cividis"](np.linspace(0, 0.88, 256)))
CURVES = [("#0072b2", "-"), ("#d55e00", "--"), ("#009e73", "-."), ("#000000", ":"),
          ("#cc79a7", (0, (5, 1, 1, 1, 1, 1))), ("#e69f00", (0, (7, 2)))]
MARKERS = "os^Dvp"
BODY, BODY_EDGE, HELD = "#e8e8e8", "#1a1a1a", "#a6a6a6"
PALE, DARK = "#d0d0d0", 0.15  # the pen on bodies whose luminance is below DARK
BODY_MAP = "plasma"  # of bodies over a field
DOT = 3.0  # points: the least diameter of a body that is drawn
ROUNDING = 1e-10  # of the radius: smaller overlaps are not drawn
PAGE_WIDTH = 7.2  # inches: fits a printed page
DIGIT, OVERHANG = 0.073, 0.07  # inches: width of a digit of a tick's label; what of a label may stand out beside a panel
COLUMN = 0.8  # inches: the least that a column of panels takes with its gap, for title and names below
LINE = 0.13  # inches: height of a tick's label
MARGINS = (0.62, 1.0, 0.52, 0.46)  # inches: left, right, bottom, top of panels
TWO_BARS = (0.62, 1.86, 0.52, 0.46)  # with room for a second colour bar

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 9, "axes.labelsize": 9, "legend.fontsize": 8,
    "xtick.labelsize": 8, "ytick.labelsize": 8, "figure.dpi": 100, "savefig.dpi": 200,
    "axes.grid": False, "grid.color": "#d0d0d0", "grid.linewidth": 0.5, "lines.linewidth": 1.4,
    "legend.frameon": False, "hatch.linewidth": 0.5, "axes.formatter.useoffset": False, "axes.formatter.limits": (-3, 4),
})


def curve(k):
    """Colour and dash of the k-th curve of a figure."""
    colour, dash = CURVES[k % len(CURVES)]
    return {"color": colour, "linestyle": dash}


def panels(number, extent, width=PAGE_WIDTH, height=8.6, gaps=(0.2, 0.34), margins=MARGINS, lowest=0.0):
    """A figure with `number` panels of the scene's own proportions and room for a colour
    bar on the right, rows and columns chosen so that the panels are as large as the page
    allows. Returns (figure, axes in reading order, axes of the colour bar).

    margins: left, right, bottom, top in inches; gaps: between columns and rows; lowest: least height of the figure.
    """
    _, _, w, h = extent
    w, h = max(w, 1e-300), max(h, 1e-300)
    left, right, bottom, top = margins
    best = None
    for columns in range(1, number + 1):
        rows = -(-number // columns)
        room_x = (width - left - right - (columns - 1) * gaps[0]) / columns
        room_y = (height - bottom - top - (rows - 1) * gaps[1]) / rows
        scale = min(room_x / w, room_y / h)
        if room_x > 0.4 and room_y > 0.3 and (best is None or scale > 1.02 * best[0]):
            best = (scale, rows, columns)
    if best is None:
        raise BadInput(f"{number} times are more than fit on a page; ask for fewer")
    scale, rows, columns = best
    size = scale * w, scale * h
    gap = max(gaps[0], min(COLUMN, (width - left - right) / columns) - size[0])
    needed = bottom + top + rows * size[1] + (rows - 1) * gaps[1]
    total = left + right + columns * size[0] + (columns - 1) * gap, max(needed, lowest)
    figure = plt.figure(figsize=total)
    axes = []
    for k in range(number):
        row, column = divmod(k, columns)
        x = left + column * (size[0] + gap)
        y = bottom + 0.5 * (total[1] - needed) + (rows - 1 - row) * (size[1] + gaps[1])
        one = figure.add_axes([x / total[0], y / total[1], size[0] / total[0], size[1] / total[1]])
        if column:
            one.tick_params(labelleft=False)
        if k + columns < number:
            one.tick_params(labelbottom=False)
        one.has_neighbour, one.room, one.scale = columns > 1, size[0] + gap, scale  # inches per unit of length
        one.first_column, one.last_row = column == 0, k + columns >= number
        axes.append(one)
    bar_height = min(total[1] - bottom - top, 4.0)
    middle = 0.5 * (bottom + total[1] - top)
    bar = figure.add_axes([(total[0] - right + 0.12) / total[0], (middle - bar_height / 2) / total[1],
                           0.14 / total[0], bar_height / total[1]])
    bar.is_bar = True
    return figure, axes, bar


def lowest_with(label, margins=MARGINS):
    """The least height of a figure, inches, whose colour bar is as long as its label."""
    return margins[2] + margins[3] + LETTER * len(plain(label))


def fitting(words, inches):
    """The first of some titles that is no wider than this, else the last."""
    return next((text for text in words if LETTER * len(text) < inches), words[-1])


def fit_ticks(axes, inches, ends=None):
    """Ticks along x (between the ends of the domain) whose labels stay apart, and within the panel where another one stands beside
    it: two at least if that can be."""
    low, high = axes.get_xlim()
    first, last = ends or (low, high)
    slack = 1e-9 * (last - first)
    scale = inches / (high - low)

    def choice(number):
        """Ticks of about this number, and half the width of a label in inches."""
        ticks = MaxNLocator(number, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
        ticks = ticks[(ticks >= first - slack) & (ticks <= last + slack)]
        half = 0.5 * DIGIT * max(map(len, axes.xaxis.get_major_formatter().format_ticks(ticks)), default=0)
        inside = (scale * (ticks - low) > half - OVERHANG) & (scale * (high - ticks) > half - OVERHANG)
        return ticks[inside] if getattr(axes, "has_neighbour", False) else ticks, half

    choices = [choice(number) for number in range(9, 0, -1)]
    choices += [(ticks[[0, -1]], half) for ticks, half in choices if len(ticks) > 2]  # the outer two
    fits = [ticks for ticks, half in choices if len(ticks) > 1 and scale * (ticks[1] - ticks[0]) > 2 * (half + DIGIT)]
    single = [ticks for ticks, _ in choices if len(ticks) == 1] + [choices[0][0][:1]]
    axes.xaxis.set_major_locator(FixedLocator(fits[0] if fits else single[0]))


def fit_heights(axes, inches):
    """Ticks along y, one alone where the labels of two would overlap."""
    axes.locator_params(axis="y", nbins=int(np.clip(inches / 0.3, 2, 9)))
    low, high = axes.get_ylim()
    ticks = axes.yaxis.get_major_locator().tick_values(low, high)
    ticks = ticks[(ticks >= low) & (ticks <= high)]
    if len(ticks) > 1 and (ticks[1] - ticks[0]) * inches / (high - low) < LINE:
        axes.yaxis.set_major_locator(FixedLocator(ticks[len(ticks) // 2:][:1]))


def frame(axes, extent, length="m", pad=0.015, names=("x", "y")):
    """Limits with a small border, in proportion so that the panel is filled; equal aspect, labels with the names of the coordinates
    and the unit of length."""
    x0, y0, w, h = extent
    axes.set_aspect("equal")
    axes.set_xlim(x0 - pad * w, x0 + w + pad * w)
    axes.set_ylim(y0 - pad * h, y0 + h + pad * h)
    slots = axes.get_position().size * axes.figure.get_size_inches()
    fit_ticks(axes, slots[0], (x0, x0 + w))
    fit_heights(axes, slots[1])
    for side in axes.spines.values():
        side.set_visible(False)
    if getattr(axes, "last_row", True):
        axes.set_xlabel(f"{names[0]} ({length})")
    if getattr(axes, "first_column", True):
        axes.set_ylabel(f"{names[1]} ({length})")


def draw_outline(axes, mesh, open_ends=OPEN):
    """The boundary by its labels: walls thick, those of open_ends dashed, axes and planes of symmetry dotted and dashed, bodies in
    the flow thicker."""
    if mesh is None:
        return
    for label in np.unique(mesh.labels):
        style = {"color": "black", "linewidth": 1.1, "linestyle": "-"}
        if label in open_ends:
            style.update(color="#555555", linewidth=0.9, linestyle=(0, (4, 2)))
        elif label == AXIS:
            style.update(color="#555555", linewidth=0.9, linestyle=(0, (8, 2, 1, 2)))
        elif label in SOLID:
            style.update(linewidth=1.5)
        lines = [mesh.points[line] for line in chains(mesh.edges[mesh.labels == label])]
        axes.add_collection(LineCollection(lines, zorder=4, capstyle="round", clip_on=False, **style), autolim=False)


def draw_boundary(axes, run):
    """The boundary of a run: that of its mesh, else the walls that it wrote."""
    draw_outline(axes, run.mesh, run.open)
    if run.mesh is None:
        axes.add_collection(LineCollection(run.walls, color="black", linewidth=1.1, capstyle="round", zorder=4), autolim=False)


def draw_particles(axes, run, time, look):
    """The particles of a run at a time, none where it has none. look: the Look of tools/plot/colour.py that fills them. Returns the
    artists, for removal."""
    if not run.has("particles"):
        return []
    if run.in_space:  # a SphereRun (tools/plot/spheres.py)
        return run.draw_particles(axes, time, look)
    particles = run.particles_at(time)
    return particle_artists(axes, particles, clip=run.clip, spokes=run.turns, look=look.at(particles, time),
        outlines=run.outlines)


def patches_of(outlines, one, centre, theta, radius, minor):
    """The patches of the body `one` with these semi-axes: an ellipse, or a polygon for each loop of a body of any shape."""
    if outlines and int(one) in outlines:
        return [Polygon(loop, closed=True) for loop in placed(outlines[int(one)], *centre, theta)]
    return [Ellipse(centre, 2 * radius, 2 * minor, angle=np.degrees(theta))]


def dark(faces):
    """Which of the colours (n,) are so dark that a black line on them is not seen: bool (n,)."""
    return to_rgba_array(faces)[:, :3] @ [0.2126, 0.7152, 0.0722] < DARK


def particle_artists(axes, particles, zorder=5, clip=None, spokes=True, look=None, outlines=None):
    """Particles as neutral disks or ellipses, each with a line from its centre to the rim at theta.
    particles: (id, x, y, theta, radius, minor) arrays; clip: (x0, y0, width, height) beyond which
    nothing is drawn; spokes: False for particles that do not turn; look: (faces, held) of tools/plot/colour.py,
    held ones are hatched; outlines: {id: loops} of bodies of any shape (tools/base/outlines.py). What is too small to be seen in a
    panel of panels() is a dot, of which headline() tells. Returns the artists, for removal."""
    ids, x, y, theta, radius, minor = particles
    if not len(x):
        return []
    faces, held = look if look is not None else ([BODY] * len(x), np.zeros(len(x), bool))
    dots = np.asarray(radius) * getattr(axes, "scale", np.inf) < 0.5 * DOT / 72
    if dots.any():
        axes.dotted = True
        shades = ["black" if isinstance(faces[k], str) else faces[k] for k in np.flatnonzero(dots)]
        drawn = axes.scatter(np.asarray(x)[dots], np.asarray(y)[dots], DOT**2, shades, linewidths=0, zorder=zorder)
        clip_to(axes, drawn, clip)
        others = [faces[k] for k in np.flatnonzero(~dots)], held[~dots]
        rest = [np.asarray(one)[~dots] for one in particles]
        return [drawn, *particle_artists(axes, rest, zorder, clip, spokes, others, outlines)]
    # The rim is drawn inside, so that a thick pen does not make touching disks overlap.
    shapes = [patches_of(outlines, one, (a, b), t, r, s) for one, a, b, t, r, s in zip(ids, x, y, theta, radius, minor)]
    groups, dim = [], dark(faces)
    for which, hatch, pen in ((~held, None, BODY_EDGE), (held & ~dim, "////", BODY_EDGE), (held & dim, "////", PALE)):
        if which.any():
            parts = [(patch, faces[k]) for k in np.flatnonzero(which) for patch in shapes[k]]
            groups.append(PatchCollection([patch for patch, _ in parts], facecolor=[face for _, face in parts],
                edgecolor=pen, linewidth=0.6, zorder=zorder, hatch=hatch))
            joined = [(patch, faces[k]) for k in np.flatnonzero(which) if len(shapes[k]) > 1 for patch in shapes[k]]
            if joined:  # the inside of a union hides the rims of its parts
                groups.append(PatchCollection([patch for patch, _ in joined], facecolor=[face for _, face in joined],
                    edgecolor="none", zorder=zorder, hatch=hatch))
    ends = np.stack([np.column_stack([x, y]),
                     np.column_stack([x + radius * np.cos(theta), y + radius * np.sin(theta)])], axis=1)
    marks = LineCollection(ends, colors=np.where(dim, PALE, BODY_EDGE), linewidth=0.8, zorder=zorder + 0.1)
    artists = [axes.add_collection(artist, autolim=False) for artist in ((*groups, marks) if spokes else groups)]
    for artist in artists:
        clip_to(axes, artist, clip)
    return artists


def clip_to(axes, artist, clip):
    """Nothing of the artist is drawn beyond clip, (x0, y0, width, height) or None."""
    if clip:
        artist.set_clip_path(Rectangle(clip[:2], *clip[2:], transform=axes.transData))


def draw_speed(axes, mesh, speed, top, low=0.0, colours=FIELD_MAP):
    """A nodal field on the P1 mesh, by default |velocity|, colours from low to top. Returns the artist."""
    drawn = axes.tripcolor(mesh.points[:, 0], mesh.points[:, 1], mesh.triangles, speed,
                           shading="gouraud", cmap=colours, vmin=low, vmax=top, zorder=1, rasterized=True)
    return drawn


def speed_of(values):
    """|velocity| at the vertices."""
    return np.linalg.norm(values["velocity"], axis=1)


def speed_top(speeds):
    """Upper end of the colour scale, and how the bar ends. A few nodes at sharp corners
    must not darken the rest: the top 0.1 % of the nodes may lie above ("max" arrow)."""
    everything = np.concatenate(speeds)
    everything = everything[np.isfinite(everything)]
    if not len(everything) or everything.max() <= 0:
        return 1.0, "neither"
    high = float(np.quantile(everything, 0.999))
    most = float(everything.max())
    return (high, "max") if 0 < high < 0.97 * most else (most, "neither")


def shown_of(values, show, run):
    """The nodal values of a field that are drawn, one of SHOWN. Raises BadInput where the fields of the run do not have them."""
    if show == "speed":
        return speed_of(values)
    if show not in values:
        raise BadInput(f"the fields of {run.folder} hold no {show}: another version of the program wrote them, or a "
            f"steady flow")
    return values[show]


def scale_of(arrays, show):
    """Ends of the colour scale of fields, how the bar ends, and its colours: {"low", "top", "colours"}, extend. The vorticity
    has white at 0 and the same range on both sides; its largest 2 %, at corners and in thin layers, lie beyond."""
    if show == "speed":
        top, extend = speed_top(arrays)
        return {"low": 0.0, "top": top, "colours": FIELD_MAP}, extend
    everything = np.concatenate(arrays)
    everything = everything[np.isfinite(everything)]
    if show == "stream":
        low, top = (everything.min(), everything.max()) if len(everything) and np.ptp(everything) > 0 else (0.0, 1.0)
        return {"low": low, "top": top, "colours": FIELD_MAP}, "neither"
    top = float(np.quantile(abs(everything), 0.98)) if len(everything) else 0.0
    top = top if top > 0 else float(abs(everything).max(initial=0)) or 1.0
    return {"low": -top, "top": top, "colours": SIGNED_MAP}, "both" if abs(everything).max(initial=0) > top else "neither"


def label_of(show, units):
    """The name of what is drawn, with its unit."""
    length, second = units["length"], units["time"]
    return {"speed": f"velocity magnitude ({length}/{second})", "vorticity": f"vorticity (1/{second})",
        "stream": f"stream function ({length}$^2$/{second})"}[show]


def draw_streamlines(axes, mesh, stream, scale, colour="white", number=24):
    """Lines of equal stream function at `number` levels of its scale. Returns the artist."""
    levels = np.linspace(scale["low"], scale["top"], number + 2)[1:-1]
    return axes.tricontour(mesh.points[:, 0], mesh.points[:, 1], mesh.triangles, stream, levels=levels, colors=colour,
        linewidths=0.5, linestyles="solid", zorder=2)


def title(run, what, inches):
    """'case: what', or only what where the figure is too narrow for both."""
    text = f"{run.title}: {what}"
    return text if len(text) * LETTER < inches else what


def time_text(t, unit="s", last=None):
    """A time for a title; with the last time of the run, all of them with as many decimals, or the same power of ten."""
    if last is None or not last > 0:
        return f"t = {t:.4g} {unit}"
    if not 1e-3 <= last < 1e6:
        power = int(np.floor(np.log10(last)))
        return f"t = {t / 10.0**power:.2f}e{power:+03d} {unit}"
    return f"t = {t:.{max(0, 2 - int(np.floor(np.log10(last))))}f} {unit}"


def save(figure, path):
    """Write the figure and let it go. Returns the path."""
    fold_powers(figure)
    thin_labels(figure)
    figure.savefig(path, bbox_inches="tight", pad_inches=0.08)  # labels as wide as they are
    plt.close(figure)
    return own(path)
