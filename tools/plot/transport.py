"""Pictures of a transport run: particles and flow at successive times, and trajectories.

    python -m tools.plot_transport RUN [--out DIR] [--times T1,T2,...]

Writes transport.png (figure 7 of the paper: positions over the speed of the steady flow)
and trajectories.png (the picture that tools.plot draws under this name) into DIR, by default the run folder.
"""
from pathlib import Path

import numpy as np

from tools.base.command import BadInput, Parser
from tools.base.mesh_files import read_field
from tools.base.run_folder import RunFolder
from tools.plot.captions import headline
from tools.plot.resolved import plot_trajectories
from tools.plot.style import (
    draw_boundary, draw_speed, fitting, frame, lowest_with, panels, particle_artists, save, speed_of, speed_top,
    time_text)


def chosen_times(run, number=6):
    """Times spread over the part of the run in which most happens: until nine tenths of
    the particles that leave have left, at least a third of the run."""
    end = float(run.particles["t"].max())
    if run.has("exits") and len(run.columns("exits")["t"]):
        end = min(end, max(end / 3, 1.1 * float(np.quantile(run.columns("exits")["t"], 0.9))))
    times = np.linspace(0, end, number + 1)[1:]
    return np.minimum([float(f"{t:.2g}") for t in times], end)


def plot_transport(run, path, times=None):
    """The particles at the times, over the speed of the flow that carries them."""
    field = run.folder / "fields_0000000.vtu"
    if not len(run.particles["t"]):
        raise BadInput(f"{run.folder / 'particles.csv'} has no rows: nothing to draw")
    flow = read_field(field) if field.is_file() else None
    times = chosen_times(run) if times is None else times
    label = f"speed of the flow ({run.units_per_depth['speed']})"
    figure, axes, bar = panels(len(times), run.extent, lowest=lowest_with(label) if flow else 0.0)
    drawn = None
    top, extend = speed_top([speed_of(flow[1])]) if flow else (1, "neither")
    for one, t in zip(axes, times):
        if flow:
            drawn = draw_speed(one, flow[0], speed_of(flow[1]), top)
        draw_boundary(one, run)
        inside = run.particles_at(t)
        particle_artists(one, inside, clip=run.clip, spokes=run.turns)
        frame(one, run.extent, run.units["length"])
        when = time_text(t, run.units["time"], max(times))
        one.set_title(fitting([f"{when}: {inside.shape[1]} inside", when, when.split()[2]], one.room - 0.1), pad=3)
    if drawn is None:
        bar.remove()
    else:
        figure.colorbar(drawn, cax=bar, extend=extend).set_label(label)
    headline(figure, run.title + (": flow and particles" if flow else ": particles"))
    return save(figure, path)


def parser():
    """The options."""
    options = Parser(prog="python -m tools.plot_transport", description=__doc__)
    options.add_argument("run", help="run folder of a transport case")
    options.add_argument("--out", metavar="DIR", help="where the pictures go (default: the run folder)")
    options.add_argument("--times", metavar="T1,T2,...", help="times within the run (default: six)")
    return options


def main(words=None):
    """Make both pictures."""
    given = parser().parse_args(words)
    run = RunFolder(given.run)
    if not run.has("steps"):
        tool = "plot_steady" if run.has("zones") else "plot_contacts" if run.has("motion") else "plot"
        raise BadInput(f"{given.run} is no run of a transport case (it has no steps.csv); python -m tools.{tool} draws it")
    run.warn_unfinished()
    times = None
    if given.times:
        try:
            times = [float(word) for word in given.times.split(",")]
        except ValueError:
            raise BadInput(f"--times needs numbers with commas between, not '{given.times}'") from None
        end = max((float(run.columns(name)["t"].max(initial=0)) for name in ("steps", "particles") if run.has(name)), default=0.0)
        for t in times:
            if not 0 <= t <= end * (1 + 1e-9):
                raise BadInput(f"--times: {t:g} is not between 0 and {end:g} {run.units['time']}, the end of the run")
    out = Path(given.out or given.run)
    out.mkdir(parents=True, exist_ok=True)
    print(plot_transport(run, out / "transport.png", times))
    print(plot_trajectories(run, out / "trajectories.png"))
    return 0
