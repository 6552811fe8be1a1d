"""Pictures of a run of contacts alone: frames, force chains, energies and a film.

    python -m tools.plot_contacts results/falling_particles/run_001
    python -m tools.plot_contacts RUN --times 0 1 10 20 60 80 100 --only frames chains

Reads particles.csv, contacts.csv, motion.csv, walls.csv, wallmoves.csv and outlines.csv of the run; leaves frames.png
(positions left, velocities right), chains.png (forces at the last time), energy.png and
film.mp4 (a gif where no mp4 can be made). Colours: viridis for speeds.
"""
from pathlib import Path

import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import LogNorm

from tools.base.command import BadInput, Parser, number, whole
from tools.base.outlines import placed
from tools.plot.bodies import reach
from tools.plot.contact_run import ContactRun, chosen, nearest
from tools.plot.film import frame_rate, shot, thinned, write_film
from tools.plot.style import BODY, BODY_EDGE, FIELD_MAP, PAGE_WIDTH, PALE, ROUNDING, curve, fit_ticks, plt, save, time_text

MADE = ["frames", "chains", "energy", "film"]
SMALL = 5  # points: bodies of smaller diameter are drawn without arrows, and filled by a colour without outlines


def shape_artists(axes, run, frame, thin):
    """Bodies of any shape: the edges of all loops, and over these the loops without edges, which are returned; their `owner` (n,)
    is the body of each, as its place in the frame."""
    loops, owner = [], []
    for k, (one, x, y, theta) in enumerate(zip(frame["id"], frame["x"], frame["y"], frame["theta"])):
        mine = placed(run.outlines[int(one)], x, y, theta)
        loops += mine
        owner += [k] * len(mine)
    axes.add_collection(PolyCollection(loops, edgecolor=BODY_EDGE, linewidth=2 * thin, facecolor=BODY, zorder=2.9))
    filled = PolyCollection(loops, edgecolor="none", facecolor=BODY, zorder=3)
    filled.owner = np.array(owner, dtype=int)
    return filled


def ellipses(axes, run, frame, **pen):
    """Disks and ellipses of a frame as a collection."""
    aspect = np.array([run.aspect(one) for one in frame["id"]]) if run.has("shapes") else 1.0
    width = 2 * frame["radius"]
    return EllipseCollection(width, width * aspect, np.degrees(frame.get("theta", 0 * width)), units="xy",
        offsets=np.column_stack([frame["x"], frame["y"]]), transOffset=axes.transData, **pen)


def draw_held(axes, run, frame, colour):
    """Hatches the bodies that are held."""
    held = np.isin(frame["id"].astype(int), list(run.look.fixed))
    if not held.any():
        return
    fixed, pen = {name: values[held] for name, values in frame.items()}, {"facecolor": "none", "edgecolor": colour, "linewidth": 0,
        "hatch": "////", "zorder": 3.1}
    if run.outlines:
        loops = [loop for one, x, y, theta in zip(*(fixed[name] for name in ("id", "x", "y", "theta")))
            for loop in placed(run.outlines[int(one)], x, y, theta)]
        axes.add_collection(PolyCollection(loops, **pen))
    else:
        axes.add_collection(ellipses(axes, run, fixed, **pen))


def diameter(axes, run, frame):
    """Mean diameter of the bodies on the page, in points, in axes that hold the view of the run."""
    x0, x1, y0, y1 = run.view
    place, (width, height) = axes.get_position(), axes.figure.get_size_inches()
    return 72 * min(place.width * width / (x1 - x0), place.height * height / (y1 - y0)) * 2 * np.mean(frame["radius"])


def draw(axes, run, frame, speed=None):
    """Walls and bodies; with `speed` (LogNorm) they are filled by it. Returns the bodies' artist."""
    axes.add_collection(LineCollection(run.walls_at(frame["t"][0]), color="black", linewidth=1.0, capstyle="round", zorder=4,
        label="walls"))
    points = diameter(axes, run, frame)
    thin = min(0.4, 0.08 * points)
    if run.outlines:
        disks = shape_artists(axes, run, frame, thin)
    else:
        disks = ellipses(axes, run, frame, edgecolor=BODY_EDGE, linewidth=thin, facecolor=BODY, zorder=3)
    if speed is not None:
        if points < SMALL:  # outlines would hide the colours
            disks.set_edgecolor("none")
        values = np.clip(frame["speed"], speed.vmin, speed.vmax)
        disks.set(cmap=FIELD_MAP, norm=speed, array=values[disks.owner] if run.outlines else values, facecolor=None)
    axes.add_collection(disks)
    draw_held(axes, run, frame, BODY_EDGE if speed is None else PALE)
    axes.set_xlim(run.view[:2])
    axes.set_ylim(run.view[2:])
    axes.set_aspect("equal")
    for side in axes.spines.values():
        side.set_visible(False)
    return disks


def arrows(axes, run, frame):
    """Arrows of one length show where a body goes; its colour says how fast."""
    moving = frame["speed"] > run.speeds[0]
    if not moving.any() or diameter(axes, run, frame) < SMALL or run.in_space:  # of spheres, arrows would be of hidden ones too
        return
    direction = np.column_stack([frame["u"], frame["v"]])[moving] / frame["speed"][moving, None]
    reach = 1.6 * frame["radius"][moving]
    axes.quiver(frame["x"][moving], frame["y"][moving], reach * direction[:, 0], reach * direction[:, 1], color="black",
        angles="xy", scale_units="xy", scale=1, width=0.008, headwidth=4, headlength=4.5, headaxislength=4, zorder=5)


def plot_frames(run, path, times=None):
    """Positions left, velocities right, a pair for each time, two pairs beside each other; of a low, long scene speeds alone,
    one time below the other."""
    places = nearest(run, chosen(run) if times is None else times)
    x0, x1, y0, y1 = run.view
    low = y1 - y0 < 0.4 * (x1 - x0)
    across, each = (1, 1) if low else (4, 2)  # panels in a row, and for a time
    rows = -(-len(places) * each // across)
    wide = (PAGE_WIDTH - 1.5) / across
    tall = max(min(wide * (y1 - y0) / (x1 - x0), 2.3), 0.25)
    figure, axes = plt.subplots(rows, across, figsize=(PAGE_WIDTH, rows * (tall + 0.3) + 0.75), squeeze=False,
                                gridspec_kw={"left": 0.075, "right": 0.87, "bottom": 0.5 / (rows * (tall + 0.3) + 0.75),
                                             "top": 1 - 0.42 / (rows * (tall + 0.3) + 0.75), "wspace": 0.22, "hspace": 0.3 / tall})
    norm = LogNorm(*run.speeds)
    disks = None
    for cell in range(rows * across // each):
        panels = axes.flat[cell * each:(cell + 1) * each]
        if cell >= len(places):
            for axis in panels:
                axis.set_axis_off()
            continue
        frame = run.frame(places[cell])
        for axis in panels[:-1]:
            draw(axis, run, frame)
        disks = draw(panels[-1], run, frame, norm)
        arrows(panels[-1], run, frame)
        panels[0].set_title(time_text(run.times[places[cell]], run.units["time"], run.times[places[-1]]), loc="left", pad=2)
        last, first = cell + across // each >= len(places), axes[cell * each // across, 0]
        for axis in panels:
            axis.tick_params(labelbottom=last, labelleft=axis is first, length=2)
            axis.locator_params(axis="y", nbins=int(np.clip(tall / 0.17, 1, 4)), min_n_ticks=1)
            axis.has_neighbour = not low
            fit_ticks(axis, axis.get_position().width * figure.get_figwidth())
            if last:
                axis.set_xlabel(f"x ({run.units['length']})")
        first.set_ylabel(f"{run.upward} ({run.units['length']})")
    bar = figure.colorbar(disks, cax=figure.add_axes((0.895, 0.3, 0.018, 0.4)), extend="min")
    bar.set_label(f"speed ({run.units_per_depth['speed']})")
    figure.canvas.draw()  # now the tick labels are known: what is wide gets its room
    over = 0.01 - min(axis.get_tightbbox().x0 for axis in axes[:, 0]) / figure.bbox.width
    if over > 0:
        axes[0, 0].get_gridspec().update(left=0.075 + over)
    shown = "positions and speeds" if low else "positions (left) and velocities (right)"
    figure.suptitle(f"{run.title}: {shown}{run.look.words()}", fontsize=10, y=1 - 0.1 / figure.get_figheight())
    return save(figure, path)


def plot_chains(run, path):
    """Normal forces at the last time that has contacts, as lines between the centres."""
    contacts = run.columns("contacts", "gap", "nx", "ny", "impulse")
    if not len(contacts["t"]):
        raise BadInput(f"the run {run.folder} has no contacts to draw")
    t = contacts["t"][-1]
    now = contacts["t"] == t
    frame = run.frame(nearest(run, [t])[0])
    place = {int(name): k for k, name in reversed(list(enumerate(frame["id"])))}  # of a disk, not of its copies
    strange = [int(a) for a in (*contacts["i"][now], *contacts["j"][now]) if a >= 0 and int(a) not in place]
    if strange:
        raise BadInput(f"{run.folder / 'contacts.csv'} names particle {strange[0]} at t = {t:g}, where particles.csv has none")
    i = np.array([place[int(a)] for a in contacts["i"][now]])
    motion = run.columns("motion")
    # -dt is shortened to a whole part of -tend
    j, step = contacts["j"][now].astype(int), motion["t"][-1] / max(motion["step"][-1], 1)
    if not step > 0:
        raise BadInput(f"{run.folder / 'motion.csv'} has no row behind the start: impulses of contacts need a step to be forces")
    force = contacts["impulse"][now] / step
    a = np.column_stack([frame["x"], frame["y"]])[i]
    normal = np.column_stack([contacts["nx"][now], contacts["ny"][now]])
    minor = [r * run.aspect(one) for one, r in zip(frame["id"], frame["radius"])]
    shape = np.column_stack([frame["theta"], frame["radius"], minor])
    b = a - normal * contacts["gap"][now][:, None] + [reach(-n, *shape[k]) for n, k in zip(normal, i)]
    b -= [reach(n, *shape[place[k]]) if k >= 0 else 0 * n for n, k in zip(normal, j)]
    if "x" in contacts:  # bodies of any shape: from both centres to the point of contact
        b = np.column_stack([contacts["x"][now], contacts["y"][now]])
        pairs = j >= 0
        k = np.array([place[one] for one in j[pairs]], dtype=int)
        a, b = np.concatenate([a, np.column_stack([frame["x"], frame["y"]])[k]]), np.concatenate([b, b[pairs]])
        force = np.concatenate([force, force[pairs]])
    x0, x1, _, _ = run.view
    y0 = run.view[2]
    y1 = (frame["y"] + frame["radius"]).max() + 0.02 * (x1 - x0)
    scale = min(5.4 / (x1 - x0), 7.0 / (y1 - y0))
    figure, axes = plt.subplots(figsize=((x1 - x0) * scale + 1.6, max((y1 - y0) * scale + 1.1, 3.4)), layout="constrained")
    draw(axes, run, frame)
    axes.set_ylim(y0, y1)
    thick = 4.0 if len(force) < 1000 else 1.6
    lines = LineCollection(np.stack([a, b], axis=1), linewidths=0.3 + thick * force / force.max(), cmap=FIELD_MAP, array=force,
        zorder=6, capstyle="round")
    axes.add_collection(lines)
    figure.colorbar(lines, ax=axes, shrink=0.8).set_label(f"normal force per depth ({run.units_per_depth['force']})")
    axes.set(xlabel=f"x ({run.units['length']})", ylabel=f"y ({run.units['length']})",
        title=f"{run.title}: forces at {time_text(t, run.units['time'])}{run.look.words()}")
    return save(figure, path)


def plot_energy(run, path):
    """Kinetic and potential energy, and overlap, in time."""
    motion = run.columns("motion")
    t = motion["t"]
    radius = run.particles["radius"].min()
    overlap = np.where(motion["worst_gap"] < -ROUNDING * radius, -motion["worst_gap"] / radius, np.nan)
    some = np.isfinite(overlap).any()
    figure, axes = plt.subplots(1 + some, 1, figsize=(PAGE_WIDTH, 4.6 if some else 2.9), sharex=True, layout="constrained",
        squeeze=False)
    top, low = axes[0, 0], axes[-1, 0]
    fallen = motion["potential_energy"] - motion["potential_energy"].min()
    floor = 1e-6 * max(motion["kinetic_energy"].max(), fallen.max(), 1e-300)
    for k, (values, name) in enumerate(((motion["kinetic_energy"], "kinetic"), (fallen, "potential, above its least"))):
        # what is less than the floor, 0 too, leaves the picture below
        top.semilogy(t, np.maximum(values, 0.01 * floor), label=name, **curve(k))
    top.set_ylim(bottom=floor)
    top.set_ylabel(f"energy{'' if run.in_space else ' per depth'}\n({run.units_per_depth['energy']})")
    top.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)  # a run that ends before rest has curves everywhere
    low.set_xlabel(f"t ({run.units['time']})")
    if some:
        low.semilogy(t, overlap, marker=".", **curve(0))
        low.set_ylabel("greatest overlap /\nsmallest radius")
    for one in axes.flat:
        one.grid(True)
    figure.suptitle(f"{run.title}: energy and overlap" if some else f"{run.title}: energy (no overlap above {ROUNDING:g} radii)",
        fontsize=10)
    return save(figure, path)


def shots(run, places):
    """The frames of the film one by one."""
    x0, x1, y0, y1 = run.view
    scale = min(6.0 / (x1 - x0), 6.4 / (y1 - y0))
    size = max((x1 - x0) * scale + 1.7, 3.2), (y1 - y0) * scale + 1.0
    figure = plt.figure(figsize=size, dpi=140)
    axes = figure.add_axes((0.62 / size[0], 0.5 / size[1], (x1 - x0) * scale / size[0], (y1 - y0) * scale / size[1]))
    norm = LogNorm(*run.speeds)
    disks = draw(axes, run, run.frame(places[0]), norm)
    axes.set(xlabel=f"x ({run.units['length']})", ylabel=f"{run.upward} ({run.units['length']})")
    edge = (0.8 + (x1 - x0) * scale) / size[0]
    figure.colorbar(disks, cax=figure.add_axes((edge, 0.25, 0.13 / size[0], 0.5)),
        extend="min").set_label(f"speed ({run.units_per_depth['speed']})")
    for k in places:
        frame = run.frame(k)
        if any(run.period) or run.outlines or run.has("shapes") or run.in_space or run.look.held:
            # copies come and go, bodies turn, spheres pass before others, held ones are hatched
            for part in list(axes.collections):
                part.remove()
            draw(axes, run, frame, norm)
        else:
            disks.set_offsets(np.column_stack([frame["x"], frame["y"]]))
            disks.set_array(np.clip(frame["speed"], *run.speeds))
        next(part for part in axes.collections if part.get_label() == "walls").set_segments(run.walls_at(run.times[k]))
        axes.set_title(f"{run.title}: {time_text(run.times[k], run.units['time'], run.times[-1])}{run.look.words()}", pad=4)
        yield shot(figure)
    plt.close(figure)


def make_film(run, out, most=300, gif=False):
    """film.mp4 or film.gif in the folder; the path."""
    places = thinned(run, range(len(run.times)), most)
    return write_film(out, shots(run, places), frame_rate(len(places)), gif)


def main(words=None):
    """Make the pictures."""
    options = Parser(prog="python -m tools.plot_contacts", description=__doc__)
    options.add_argument("run", help="run folder, such as results/falling_particles/run_001")
    options.add_argument("--out", metavar="DIR", help="where the pictures go (default: the run folder)")
    options.add_argument("--only", nargs="+", choices=MADE, default=MADE, metavar="WHAT", help="some of: " + ", ".join(MADE))
    options.add_argument("--times", nargs="+", type=number, metavar="T", help="times of the frames")
    options.add_argument("--frames", type=whole(2), default=300, metavar="N", help="most frames of the film (default 300)")
    options.add_argument("--gif", action="store_true", help="the film as a gif even where an mp4 can be made")
    given = options.parse_args(words)
    run = ContactRun(given.run)
    if run.in_space:
        from tools.plot.sphere_contacts import SphereContactRun
        run = SphereContactRun(given.run)
    if not run.has("motion"):
        raise BadInput(f"{given.run} is no run of contacts alone (it has no motion.csv); python -m tools.plot draws the others")
    if not len(run.columns("motion")["t"]):
        raise BadInput(f"{run.folder / 'motion.csv'} has no rows: nothing to draw")
    for t in given.times or []:
        if not run.times[0] - 1e-9 <= t <= run.times[-1] * (1 + 1e-9):
            raise BadInput(f"--times: {t:g} is not between {run.times[0]:g} and {run.times[-1]:g} {run.units['time']}, the end "
                f"of the run")
    run.warn_unfinished()
    out = Path(given.out or given.run)
    out.mkdir(parents=True, exist_ok=True)
    if "frames" in given.only:
        print(plot_frames(run, out / "frames.png", given.times))
    if "chains" in given.only and run.in_space:
        if given.only is not MADE:
            raise BadInput("force chains are drawn of plane runs alone")
    elif "chains" in given.only and (given.only is not MADE or (run.folder / "contacts.csv").read_text().count("\n") > 1):
        print(plot_chains(run, out / "chains.png"))
    if "energy" in given.only:
        print(plot_energy(run, out / "energy.png"))
    if "film" in given.only and given.only is MADE and len(run.times) < 2:
        print("film: left out, only one time to show")
    elif "film" in given.only:
        print(make_film(run, out, given.frames, given.gif))
    return 0
