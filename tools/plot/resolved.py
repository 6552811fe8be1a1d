"""Pictures of a run: velocity and particles at six times, trajectories, time series, force chains, film.

    python -m tools.plot RUN [--out DIR] [--no-film] [--only fields trajectories series chains film outlines]
        [--show vorticity] [--streamlines] [--colour density] [--times 0.1 0.2]
    python -m tools.plot RUN_OF_SPHERES [--plane y=0.1] [--times 0.1 0.2]

Writes fields.png, trajectories.png, series.png, chains.png (forces of contacts at the last time
with contacts) and film.mp4 (a gif where no mp4 can be made) into DIR, by default the run folder
itself, and prints where they are; with --times also outlines.png, the bodies at all these times
in one panel. What a run does not hold (no particles, no field files, no contacts) is left out
and said. Held bodies are hatched. Bodies stand where they are at the time of a picture; fields
between two snapshots are linear in time.

A run of spheres in three dimensions is shown in a plane: filled circles are the spheres that it
cuts, thin ones those in front of it (solid) and behind it (dashed); the paths are drawn in two
projections. Chains, outlines and streamlines are of plane runs alone.
"""
from functools import partial
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, Parser, non_negative, whole
from tools.base.run_folder import RunFolder
from tools.plot import spheres
from tools.plot.captions import headline, second_bar
from tools.plot.colour import COLOURS, Look
from tools.plot.film import make_film
from tools.plot.in_time import FieldsInTime, broken
from tools.plot.overlays import plot_chains, plot_outlines
from tools.plot.series import plot_series, series
from tools.plot.style import (LINE_MAP, MARGINS, SHOWN, TWO_BARS, clip_to, draw_boundary, draw_particles, draw_speed,
    draw_streamlines, fitting, frame, label_of, lowest_with, panels, particle_artists, plt, save, scale_of, shown_of, time_text,
    title)

MADE = ("fields", "trajectories", "series", "chains", "film")
ASKED = ("outlines",)  # with --times or --only
OF_A_PLANE = ("chains", "outlines")  # not of spheres in three dimensions


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


def plot_fields(run, path, number=6, show="speed", colour=None, streamlines=False, times=None):
    """What of the fields is shown (SHOWN), with the particles at six times, or at those given, and one colour bar; a second one
    where bodies have colours (COLOURS). streamlines: of the velocity, over whatever is shown."""
    fields_at = FieldsInTime(run)
    chosen = spread(run.frames, number) if times is None else [(t, 0 if run.fields else None) for t in times]
    if not chosen:
        raise BadInput(f"the run {run.folder} has neither fields nor particles to draw")
    length, second = run.units["length"], run.units["time"]
    with_velocity = all(k is not None for _, k in chosen)
    fields = [fields_at.at(t) if with_velocity else None for t, _ in chosen]
    lines = streamlines or show == "stream"
    if lines and not with_velocity:
        raise BadInput(f"the run {run.folder} wrote no fields, of which streamlines are drawn (-fields SECONDS)")
    if with_velocity:
        drawn_values = [shown_of(values, show, run) for _, values in fields]
        scale, extend = scale_of(drawn_values, show)
        streams = [shown_of(values, "stream", run) for _, values in fields] if lines else None
        levels = scale_of(streams, "stream")[0] if lines else None
    look, label = Look(run, colour), label_of(show, run.units)
    both = with_velocity and look.label
    figure, axes, bar = panels(len(chosen), run.extent, margins=TWO_BARS if both else MARGINS, lowest=lowest_with(label
        if with_velocity else look.label) if with_velocity or look.label else 0.0)
    drawn = None
    for k, (one, (t, _), field) in enumerate(zip(axes, chosen, fields)):
        if with_velocity:
            drawn = draw_speed(one, field[0], drawn_values[k], **scale)
            if lines:
                draw_streamlines(one, field[0], streams[k], levels, "#505050" if show == "vorticity" else "white")
        draw_boundary(one, run)
        draw_particles(one, run, t, look)
        frame(one, run.extent, length, names=run.names)
        when = time_text(t, second, chosen[-1][0])
        one.set_title(fitting([when, when[4:], when.split()[2], f"{t:.2g}"], one.room - 0.1), pad=3)
    if drawn is not None:
        figure.colorbar(drawn, cax=bar, extend=extend).set_label(label)
    if look.label:
        look.draw_bar(figure, second_bar(figure, bar) if both else bar)
    elif drawn is None:
        bar.remove()
    name = {"speed": "velocity", "stream": "streamlines"}.get(show, show)
    bodies = f"{'spheres' if run.in_space else 'particles'}{look.words()}"
    what = f"{name} and {bodies}" if with_velocity and run.has("particles") else name if with_velocity else bodies
    headline(figure, title(run, what, figure.get_figwidth()))
    return save(figure, path)


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
    look, ends, colours, stays, names = Look(run), [], [], [], []
    last = max([track["t"][-1] for track in tracks] + [run.columns(name)["t"].max(initial=0)
        for name in ("fluid", "steps") if run.has(name)])
    for track, diameter in zip(tracks, diameters):
        colour = LINE_MAP(scale(diameter))
        for piece in broken(track, run.extent, run.period):
            line, = axes.plot(piece[:, 0], piece[:, 1], color=colour, linewidth=1.1, alpha=0.9, zorder=3, solid_capstyle="round")
            clip_to(axes, line, run.clip)
        if track["t"][-1] < last * (1 - 1e-9):
            continue
        colours.append(colour)
        stays.append(int(track["id"][0]) in look.fixed)
        names.append(int(track["id"][0]))
        ends.append([0] + [track[name][-1] for name in ("x", "y", "theta", "radius")] + [track["radius"][-1]
            * run.aspect(track["id"][0])])
    ends = np.array(ends, dtype=float).reshape(-1, 6)
    ends[:, 0] = np.arange(len(ends))
    ends = run.images(ends)
    held = np.array([stays[int(k)] for k in ends[:, 0]], bool)
    particle_artists(axes, ends.T, zorder=5, clip=run.clip, spokes=run.turns, look=([(*colours[int(k)][:3], 0.75)
        for k in ends[:, 0]], held), outlines={k: run.outlines[one] for k, one in enumerate(names) if one in run.outlines})
    draw_boundary(axes, run)
    frame(axes, run.extent, length)
    if several:
        figure.colorbar(plt.cm.ScalarMappable(scale, LINE_MAP), cax=bar).set_label(label)
    else:
        bar.remove()
    fixed = sum(int(one) in run.held and np.ptp(track["x"]) + np.ptp(track["y"]) == 0 for one, track in run.tracks.items())
    count = len(tracks) - fixed
    number = f"{count} particles" if count > 1 else "one particle" if count else "fixed particles"
    if not several:
        number += f", {size} {low:.4g} {length}"
    number += look.words() if any(stays) else ""
    headline(figure, title(run, ("path of " if count == 1 else "paths of " if count else "") + number, figure.get_figwidth()))
    return save(figure, path)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.plot", description=__doc__)
    options.add_argument("run", help="run folder, such as results/pipe_obstacles/default")
    options.add_argument("--out", metavar="DIR", help="where the pictures go (default: the run folder)")
    options.add_argument("--only", nargs="+", choices=MADE + ASKED, metavar="WHAT", help="some of: " + ", ".join(MADE + ASKED))
    options.add_argument("--show", choices=SHOWN, default="speed", help="of the fields, in picture and film: " + ", ".join(SHOWN)
        + " (default speed)")
    options.add_argument("--colour", choices=COLOURS, help="of the bodies, in picture and film: " + ", ".join(COLOURS)
        + " (default: none)")
    options.add_argument("--streamlines", action="store_true", help="streamlines over the fields, in picture and film")
    options.add_argument("--times", nargs="+", type=non_negative, metavar="T",
        help="times of the fields, the outlines and the chains")
    options.add_argument("--plane", metavar="y=0.1", help="of a run in three dimensions: the plane that is shown (default: the "
        "first that cuts a sphere: the middle of y, a side normal to y, the same of x)")
    options.add_argument("--no-film", action="store_true", help="no film")
    options.add_argument("--gif", action="store_true", help="the film as a gif even where an mp4 can be made")
    options.add_argument("--frames", type=whole(2), default=300, metavar="N", help="most frames of the film (default 300)")
    return options


def given_times(run, times):
    """The times in order, none twice. Raises BadInput for one beyond the run."""
    if times is None:
        return None
    ends = [t for t, _ in run.frames] + [float(run.particles["t"].max(initial=0))] * run.has("particles")
    first, last = min(ends, default=0), max(ends, default=0)
    for t in times:
        if not first * (1 - 1e-9) <= t <= last * (1 + 1e-9):
            raise BadInput(f"--times: {t:g} is not between {first:g} and {last:g} {run.units['time']}, the first and the last time "
                f"that can be drawn")
    return sorted(set(times))


def why_not(run, name):
    """Why a picture cannot be made, None where it can."""
    bodies = run.has("particles") and len(run.particles["t"])
    if name in ("fields", "film") and not run.frames:
        return "no field files and no particles (fields are written when asked for)"
    if run.in_space and name in OF_A_PLANE:
        return "the run is in three dimensions (python -m tools.bodies writes spheres and contacts for ParaView)"
    if name in ("trajectories", "outlines", "chains") and not bodies:
        return "no rows in particles.csv"
    if name == "trajectories" and run.in_space and not spheres.moving(run):
        return "no sphere moves"
    if name == "chains" and not (run.has("contacts") and {"gap", "nx", "ny", "impulse"} <= set(run.contacts)
            and len(run.contacts["t"])):
        return "no contacts"
    if name == "series" and run.has("steps") and not run.has("fluid"):
        return "a transport run has no fluid.csv (python -m tools.plot_transport draws the particles over the flow)"
    if name == "series" and not (run.has("fluid") and len(run.fluid["t"]) and series(run)):
        return "no rows in fluid.csv"
    if name == "film" and len(run.frames) < 2:
        return "only one time to show"
    return None


def shown_in_plane(given):
    """The SphereRun of a run in three dimensions. Raises BadInput for options that are of plane runs alone."""
    for option, wrong in ((f"--show {given.show}", given.show != "speed"), ("--streamlines", given.streamlines)):
        if wrong:
            raise BadInput(f"{option} is for plane runs; {given.run} is a run in three dimensions")
    return spheres.SphereRun(given.run, given.plane and spheres.plane_of(given.plane))


def main(words=None):
    """Make the pictures; 0 if one was made at least."""
    given = parser().parse_args(words)
    run = RunFolder(given.run)
    if run.has("zones") or (run.has("results") and not run.has("fluid") and not run.has("particles")):
        words = "its numbers stand in results.csv, and -fields 1 writes what python -m tools.plot_steady draws"
        if (run.folder / "fields.vtu").is_file():
            words = "python -m tools.plot_steady draws it"
        raise BadInput(f"{given.run} is a steady flow; {words}")
    if run.has("motion"):
        raise BadInput(f"{given.run} is a run of contacts alone; python -m tools.plot_contacts draws it")
    if run.in_space:
        run = shown_in_plane(given)
    elif given.plane:
        raise BadInput(f"--plane is for runs in three dimensions; {given.run} is a plane run")
    times = given_times(run, given.times)
    run.warn_unfinished()
    out = Path(given.out or given.run)
    out.mkdir(parents=True, exist_ok=True)
    wanted = [name for name in (given.only or MADE + ASKED * bool(times)) if not (name == "film" and given.no_film)]
    look = {"show": given.show, "colour": given.colour}
    draw = {"fields": partial(plot_fields, streamlines=given.streamlines, times=times, **look), "series": plot_series,
        "trajectories": spheres.plot_trajectories if run.in_space else plot_trajectories,
        "outlines": partial(plot_outlines, times=times), "chains": partial(plot_chains, times=times)}
    made = 0
    for name in wanted:
        if reason := why_not(run, name):
            print(f"{name}: left out, {reason}")
            continue
        if name == "film":
            path = make_film(run, out, most=given.frames, gif=given.gif, streamlines=given.streamlines, **look)
        else:
            path = draw[name](run, out / f"{name}.png")
        made += 1
        bare = name == "fields" and all(field is None for _, field in run.frames)
        alone = "python -m tools.plot_transport draws the flow" if run.has("steps") else "the run wrote no velocity, see -fields"
        print(f"{name}: {path}" + (f" (particles only: {alone})" if bare else ""), flush=True)
    if not made:
        raise BadInput(f"nothing in {run.folder} can be drawn")
    return 0
