"""Pictures of bodies without the flow: outlines at several times in one panel, and force chains."""
import numpy as np
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from tools.base.command import BadInput
from tools.base.outlines import placed
from tools.plot.bodies import contact_lines
from tools.plot.captions import headline
from tools.plot.colour import Look
from tools.plot.style import (FIELD_MAP, LINE_MAP, clip_to, draw_boundary, fitting, frame, lowest_with, panels, particle_artists,
    patches_of, plt, save, time_text, title)

NUMBER = 8  # times of the outlines
PIECE = 0.004  # of the extent of a body: the pieces of its rim


def rim(loops):
    """The outline of a union of loops (n, 2) as a patch: what lies within another loop is left out."""
    ends = [np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in loops]  # (n, 2, 2): the sides
    piece = PIECE * np.ptp(np.concatenate(loops), axis=0).max()
    kept = []
    for k, sides in enumerate(ends):
        at = [np.linspace(0, 1, 2 + int(np.hypot(*(b - a)) / piece))[:, None] for a, b in sides]
        points = [a + t * (b - a) for t, (a, b) in zip(at, sides)]
        pieces = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in points])
        hidden = np.zeros(len(pieces), bool)
        for other in loops[:k] + loops[k + 1:]:
            hidden |= Path(other).contains_points(pieces.mean(axis=1))
        kept.append(pieces[~hidden])
    corners = np.concatenate(kept).reshape(-1, 2)
    return PathPatch(Path(corners, [Path.MOVETO, Path.LINETO] * (len(corners) // 2)))


def rim_of(outlines, one, centre, theta, radius, minor):
    """The rim of the body `one` with these semi-axes, as one patch."""
    patches = patches_of(outlines, one, centre, theta, radius, minor)
    return patches[0] if len(patches) == 1 else rim(placed(outlines[int(one)], *centre, theta))


def plot_outlines(run, path, times=None):
    """The rims of the bodies at several times (by default eight), coloured by time; held bodies stand once, hatched."""
    rows = run.particles["t"]
    times = np.linspace(rows.min(), rows.max(), NUMBER) if times is None else np.asarray(times, float)
    label = f"t ({run.units['time']})"
    figure, (axes,), bar = panels(1, run.extent, height=6.0, lowest=lowest_with(label))
    look = Look(run)
    scale = plt.Normalize(times[0], times[-1]) if len(times) > 1 else plt.Normalize(times[0] - 1, times[0] + 1)
    for t in times:
        particles = run.particles_at(t)
        held = look.at(particles, t)[1]
        if t == times[-1]:
            fixed = particles[:, held]
            particle_artists(axes, fixed, zorder=3, clip=run.clip, spokes=run.turns, look=look.at(fixed, t),
                outlines=run.outlines)
        rims = PatchCollection([rim_of(run.outlines, one, (x, y), a, r, s) for one, x, y, a, r, s in particles[:, ~held].T],
            facecolor="none", edgecolor=LINE_MAP(scale(t)), linewidth=1.1, zorder=5)
        axes.add_collection(rims, autolim=False)
        clip_to(axes, rims, run.clip)
    draw_boundary(axes, run)
    frame(axes, run.extent, run.units["length"])
    drawn = figure.colorbar(plt.cm.ScalarMappable(scale, LINE_MAP), cax=bar)
    drawn.set_label(label)
    if len(times) <= NUMBER:  # a line for each
        drawn.set_ticks(times, labels=[f"{t:.3g}" for t in times])
    headline(figure, title(run, f"outlines at {len(times)} times{look.words()}", figure.get_figwidth()))
    return save(figure, path)


def plot_chains(run, path, times=None):
    """Normal forces of the contacts as lines between the centres, at the last row with contacts, or at the rows nearest to the
    given times: impulses are known there alone. Raises BadInput where the tables do not tell the length of a step."""
    rows = np.unique(run.particles["t"])
    wanted = [run.contacts["t"][-1]] if times is None else times
    chosen = sorted({float(rows[abs(rows - t).argmin()]) for t in wanted})
    force_unit = run.units_per_depth["force"]
    label = f"normal force per depth ({force_unit})"
    found = []
    for t in chosen:
        bodies = run.particles_at(t)
        lines, values, _ = contact_lines(run, t, bodies)
        if not np.isfinite(values["force"]).all():
            raise BadInput(f"{run.folder}: no table tells the length of the step at t = {t:g}, so that impulses are no forces")
        found.append((t, bodies, lines, values["force"]))
    top = max([force.max() for *_, force in found if len(force)], default=0.0) or 1.0
    figure, axes, bar = panels(len(found), run.extent, lowest=lowest_with(label))
    look, scale = Look(run), plt.Normalize(0, top)
    for one, (t, bodies, lines, force) in zip(axes, found):
        particle_artists(one, bodies, clip=run.clip, spokes=False, look=look.at(bodies, t), outlines=run.outlines)
        thick = 3.0 if len(force) < 300 else 1.6
        drawn = LineCollection(lines, linewidths=0.4 + thick * force / top, cmap=FIELD_MAP, norm=scale, array=force, zorder=6,
            capstyle="round")
        one.add_collection(drawn, autolim=False)
        clip_to(one, drawn, run.clip)
        draw_boundary(one, run)
        frame(one, run.extent, run.units["length"])
        when = time_text(t, run.units["time"], chosen[-1])
        many = "no contact" if not len(force) else "one contact" if len(force) == 1 else f"{len(force)} contacts"
        one.set_title(fitting([f"{when}: {many}", when, when[4:], when.split()[2]], one.room - 0.1), pad=3)
    if any(len(force) for *_, force in found):
        figure.colorbar(plt.cm.ScalarMappable(scale, FIELD_MAP), cax=bar).set_label(label)
    else:
        bar.remove()
    headline(figure, title(run, f"forces of contacts{look.words()}", figure.get_figwidth()))
    return save(figure, path)
