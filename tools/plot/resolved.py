"""Pictures of a run: velocity and particles at six times, trajectories, time series, film.

    python -m tools.plot RUN [--out DIR] [--no-film] [--only fields trajectories series film] [--show vorticity]
    python -m tools.plot RUN_OF_SPHERES --plane y=0.1

Writes fields.png, trajectories.png, series.png and film.mp4 (a gif where no mp4 can be
made) into DIR, by default the run folder itself, and prints where they are. What a run
does not hold (no particles, no field files) is left out and said. A run of spheres in three
dimensions is shown in a plane: filled circles are the spheres that it cuts, thin ones those
in front of it (solid) and behind it (dashed); the paths are drawn in two projections.
"""
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.ticker import MaxNLocator, NullFormatter

from tools.base.command import BadInput, Parser, whole
from tools.plot import spheres
from tools.plot.film import make_film
from tools.plot.style import (CURVES, LINE_MAP, PAGE_WIDTH, ROUNDING, SHOWN, clip_to, curve, draw_boundary, draw_particles,
    draw_speed, draw_streamlines, fitting, frame, headline, label_of, lowest_with, panels, particle_artists, plt, save, scale_of,
    shown_of, time_text, title)
from tools.base.quantities import closed
from tools.base.run_folder import RunFolder

MADE = ("fields", "trajectories", "series", "film")


def spread(frames, number=6):
    """At most `number` frames spread over the run, ending at its end; the start, where
    nothing has happened yet, is left out if there are enough others."""
    if len(frames) <= number:
        return list(frames)
    times = np.array([t for t, _ in frames])
    wanted = times[0] + (times[-1] - times[0]) * np.arange(1, number + 1) / number
    picked, last = [], -1
    for place, time in enumerate(wanted):
        low, high = last + 1, len(frames) - (number - place)
        last = low + int(np.argmin(abs(times[low:high + 1] - time)))
        picked.append(frames[last])
    return picked


def plot_fields(run, path, number=6, show="speed"):
    """What of the fields is shown (SHOWN), with the particles at six times and one colour bar."""
    chosen = spread(run.frames, number)
    if not chosen:
        raise BadInput(f"the run {run.folder} has neither fields nor particles to draw")
    length, second = run.units["length"], run.units["time"]
    fields = [None if k is None else run.field(k) for _, k in chosen]
    with_velocity = all(field is not None for field in fields)
    if with_velocity:
        drawn_values = [shown_of(values, show, run) for _, values in fields]
        scale, extend = scale_of(drawn_values, show)
    label = label_of(show, run.units)
    figure, axes, bar = panels(len(chosen), run.extent, lowest=lowest_with(label) if with_velocity else 0.0)
    drawn = None
    for k, (one, (t, _), field) in enumerate(zip(axes, chosen, fields)):
        if with_velocity:
            drawn = draw_speed(one, field[0], drawn_values[k], **scale)
            if show == "stream":
                draw_streamlines(one, field[0], drawn_values[k], scale)
        draw_boundary(one, run)
        draw_particles(one, run, t)
        frame(one, run.extent, length, names=run.names)
        when = time_text(t, second, chosen[-1][0])
        one.set_title(fitting([when, when[4:], when.split()[2], f"{t:.2g}"], one.room - 0.1), pad=3)
    if drawn is not None:
        figure.colorbar(drawn, cax=bar, extend=extend).set_label(label)
    else:
        bar.remove()
    name = {"speed": "velocity", "stream": "streamlines"}.get(show, show)
    bodies = "spheres" if run.in_space else "particles"
    what = f"{name} and {bodies}" if with_velocity and run.has("particles") else name if with_velocity else bodies
    headline(figure, title(run, what, figure.get_figwidth()))
    return save(figure, path)


def broken(track, extent, period=(0, 0)):
    """A track as pieces (k, 2) in the domain, cut at its seams. Where the period is known a piece goes on for a
    row beyond the seam at either end, to be clipped there; else it ends where the table jumps over the seam."""
    points, period = np.column_stack([track["x"], track["y"]]), np.asarray(period, dtype=float)
    if not period.any():
        jumps = np.any(abs(np.diff(points, axis=0)) > 0.5 * np.asarray(extent[2:]), axis=1)
        return np.split(points, np.flatnonzero(jumps) + 1)
    cells = np.floor((points - extent[:2]) / np.where(period > 0, period, np.inf))
    cuts = [0, *np.flatnonzero(np.diff(cells, axis=0).any(axis=1)) + 1, len(points)]
    return [points[max(low - 1, 0):high + 1] - cells[low] * period for low, high in zip(cuts, cuts[1:])]


def plot_trajectories(run, path):
    """Paths of the centres coloured by diameter; a disk where a particle is at the end, none where it has left."""
    tracks = list(run.tracks.values())
    if not tracks:
        raise BadInput(f"{run.folder / 'particles.csv'} has no rows: no trajectory to draw")
    length = run.units["length"]
    diameters = np.array([2 * track["radius"][-1] for track in tracks])
    low, high = diameters.min(), diameters.max()
    several, size = high - low > 1e-6 * high, "long axis" if run.has("shapes") else "diameter"
    label = f"{size} ({length})"
    figure, (axes,), bar = panels(1, run.extent, height=6.0, lowest=lowest_with(label) if several else 0.0)
    scale = plt.Normalize(low, high) if several else plt.Normalize(0.5 * low, 1.5 * high)
    ends, colours, last = [], [], max([track["t"][-1] for track in tracks] + [run.columns(name)["t"].max(initial=0)
        for name in ("fluid", "steps") if run.has(name)])
    for track, diameter in zip(tracks, diameters):
        colour = LINE_MAP(scale(diameter))
        for piece in broken(track, run.extent, run.period):
            line, = axes.plot(piece[:, 0], piece[:, 1], color=colour, linewidth=1.1, alpha=0.9, zorder=3, solid_capstyle="round")
            clip_to(axes, line, run.clip)
        if track["t"][-1] < last * (1 - 1e-9):
            continue
        colours.append(colour)
        ends.append([0] + [track[name][-1] for name in ("x", "y", "theta", "radius")] + [track["radius"][-1]
            * run.aspect(track["id"][0])])
    ends = np.array(ends, dtype=float).reshape(-1, 6)
    ends[:, 0] = np.arange(len(ends))
    ends = run.images(ends)
    for artist in particle_artists(axes, ends.T, zorder=5, clip=run.clip, spokes=run.turns)[:1]:
        artist.set_facecolor([colours[int(k)] for k in ends[:, 0]])
        artist.set_alpha(0.75)
    draw_boundary(axes, run)
    frame(axes, run.extent, length)
    if several:
        figure.colorbar(plt.cm.ScalarMappable(scale, LINE_MAP), cax=bar).set_label(label)
    else:
        bar.remove()
    number = f"{len(tracks)} particles" if len(tracks) > 1 else "one particle"
    if not several:
        number += f", {size} {low:.4g} {length}"
    headline(figure, title(run, ("path of " if len(tracks) == 1 else "paths of ") + number, figure.get_figwidth()))
    return save(figure, path)


def series(run):
    """The panels of the time series: [(label of the axis, [(name, values)], log scale)];
    a column that the run did not write is left out. Curves that are not of fluid.csv have their times too:
    (name, values, times)."""
    table = run.fluid
    length, second = run.units["length"], run.units["time"]
    pressure, energy = run.units_per_depth["pressure"], run.units_per_depth["energy"]

    def there(*pairs):
        return [(name, table[column]) for column, name in pairs if column in table]
    fluxes = there(("flux_in", "inlet"), ("flux_out", "outlet"))
    if fluxes and closed(run, max(abs(v).max(initial=0) for _, v in fluxes)):
        fluxes = []
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
    def tells(label, curves):  # a closed box has no flux and no pressure drop, a flow alone no particles
        return any(np.isfinite(v).any() and (v.any() or label not in (wanted[0][0], wanted[1][0], "number")) for _, v in curves)
    if run.in_space:
        return spheres.track_panels(run) + [panel for panel in wanted if tells(*panel[:2]) and spheres.tells(run, *panel[:2])]
    return [panel for panel in wanted if tells(*panel[:2])]


def plot_series(run, path):
    """fluid.csv over time; overlaps are over the smallest radius."""
    wanted = series(run)
    t = run.fluid["t"]
    if not wanted or not len(t):
        raise BadInput(f"{run.folder / 'fluid.csv'} has no rows or none of the columns that are drawn")
    columns = min(len(wanted), 2)
    rows = -(-len(wanted) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(PAGE_WIDTH, 0.5 + 1.75 * rows), sharex=True, layout="constrained",
                                squeeze=False)
    for one, (label, curves, log) in zip(axes.flat, wanted):
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
        elif log:
            one.text(0.5, 0.5, f"below {ROUNDING:g} throughout" if "overlap" in label else "zero throughout",
                transform=one.transAxes, ha="center", va="center")
            one.set_yticks([])
        if 1 < len(curves) <= len(CURVES):  # in a row above the curves
            low, high = one.get_ylim()
            one.set_ylim(low, high + 0.2 * (high - low))
            one.legend(loc="upper center", ncols=min(len(curves), 4))
        if label == "number":
            one.yaxis.set_major_locator(MaxNLocator(integer=True))
        one.set_ylabel(label)
        one.grid(True)
    for one in axes.flat[len(wanted):]:
        one.remove()
    for one in axes.flat:  # wide labels, such as 0.025, would run together
        one.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    for column in range(columns):
        shown = [row for row in range(rows) if columns * row + column < len(wanted)]
        if shown:
            axes[shown[-1], column].set_xlabel(f"t ({run.units['time']})")
            axes[shown[-1], column].tick_params(labelbottom=True)
    figure.suptitle(f"{RunFolder.title.fget(run)}: time series", fontsize=10)
    return save(figure, path)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.plot", description=__doc__)
    options.add_argument("run", help="run folder, such as results/pipe_obstacles/default")
    options.add_argument("--out", metavar="DIR", help="where the pictures go (default: the run folder)")
    options.add_argument("--only", nargs="+", choices=MADE, metavar="WHAT", help="some of: " + ", ".join(MADE))
    options.add_argument("--show", choices=SHOWN, default="speed", help="of the fields, in picture and film: " + ", ".join(SHOWN)
        + " (default speed)")
    options.add_argument("--plane", metavar="y=0.1", help="of a run in three dimensions: the plane that is shown (default: the "
        "first that cuts a sphere: the middle of y, a side normal to y, the same of x)")
    options.add_argument("--no-film", action="store_true", help="no film")
    options.add_argument("--gif", action="store_true", help="the film as a gif even where an mp4 can be made")
    options.add_argument("--frames", type=whole(2), default=300, metavar="N", help="most frames of the film (default 300)")
    return options


def main(words=None):
    """Make the pictures; 0 if one was made at least."""
    given = parser().parse_args(words)
    run = RunFolder(given.run)
    if run.has("zones"):
        raise BadInput(f"{given.run} is a steady flow; python -m tools.plot_steady draws it")
    if run.has("motion"):
        raise BadInput(f"{given.run} is a run of contacts alone; python -m tools.plot_contacts draws it")
    if run.in_space:
        if given.show != "speed":
            raise BadInput(f"{given.run} is a run in three dimensions, whose fields hold no {given.show}")
        run = spheres.SphereRun(given.run, given.plane and spheres.plane_of(given.plane))
    elif given.plane:
        raise BadInput(f"--plane is for runs in three dimensions; {given.run} is a plane run")
    run.warn_unfinished()
    out = Path(given.out or given.run)
    out.mkdir(parents=True, exist_ok=True)
    wanted = [name for name in (given.only or MADE) if not (name == "film" and given.no_film)]
    made = 0
    for name in wanted:
        if name in ("fields", "film") and not run.frames:
            reason = "no field files and no particles (fields are written when asked for)"
        elif name == "trajectories" and not (run.has("particles") and len(run.particles["t"])):
            reason = "no rows in particles.csv"
        elif name == "trajectories" and run.in_space and not spheres.moving(run):
            reason = "no sphere moves"
        elif name == "series" and run.has("steps") and not run.has("fluid"):
            reason = "a transport run has no fluid.csv (python -m tools.plot_transport draws the particles over the flow)"
        elif name == "series" and not (run.has("fluid") and len(run.fluid["t"]) and series(run)):
            reason = "no rows in fluid.csv"
        elif name == "film" and len(run.frames) < 2:
            reason = "only one time to show"
        else:
            reason = None
        if reason:
            print(f"{name}: left out, {reason}")
            continue
        if name == "film":
            path = make_film(run, out, most=given.frames, gif=given.gif, show=given.show)
        else:
            draw = {"fields": partial(plot_fields, show=given.show), "trajectories": spheres.plot_trajectories if run.in_space
                else plot_trajectories, "series": plot_series}[name]
            path = draw(run, out / f"{name}.png")
        made += 1
        bare = name == "fields" and all(field is None for _, field in run.frames)
        print(f"{name}: {path}" + (" (particles only: the run wrote no velocity, see -fields)" if bare else ""), flush=True)
    if not made:
        raise BadInput(f"nothing in {run.folder} can be drawn")
    return 0
