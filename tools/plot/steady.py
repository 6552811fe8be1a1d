"""Pictures of a steady flow: streamlines, speed, pressure, k and eddy viscosity.

    python -m tools.plot_steady results/pipe_flow/run_001

Reads fields.vtu, mesh.mesh, wall.csv and zones.csv of a run of scripts/steady.edp, or fields.vtu
and mesh.mesh of one of scripts/steady_laminar.edp with -fields 1, and writes PNGs into the run
folder (or --out FOLDER). Pressures are gauge ones, above the outlet's (results.csv holds absolute
ones). Exit status 3 when they are not there.
"""
from pathlib import Path

import numpy as np
from matplotlib.tri import LinearTriInterpolator, Triangulation

from tools.base.command import BadInput, Parser
from tools.base.mesh_files import read_field, read_mesh
from tools.base.run_folder import RunFolder
from tools.plot.style import FIELD_MAP, PAGE_WIDTH, curve, draw_outline, frame, plt, save

# file, label of the colour bar with the units of the case, how the values come from the fields
PICTURES = [
    ("speed", "speed ({speed})", lambda v: np.hypot(*v["velocity"][:, :2].T)),
    ("pressure", "gauge pressure ({pressure})", lambda v: v["pressure"]),
    ("k", "k ({length}$^2$/{time}$^2$)", lambda v: v["k"]),
    ("nu_t", "eddy viscosity ({length}$^2$/{time})", lambda v: v["nu_t"]),
]


def size_of(points):
    """Width and height in inches of a flow drawn to scale."""
    extent = np.ptp(points, axis=0)
    return extent * min((PAGE_WIDTH - 1.6) / extent[0], 5.0 / extent[1])


def one_panel(run, mesh, title):
    """(figure, axes) for a flow drawn to scale, as wide as its shape asks for; of an axisymmetric one the ordinate is a radius."""
    low = mesh.points.min(axis=0)
    width, height = size_of(mesh.points)
    figure, axes = plt.subplots(figsize=(max(width + 1.6, 2.6), max(height, 0.7) + 0.9), layout="constrained")
    frame(axes, (*low, *np.ptp(mesh.points, axis=0)), run.units["length"])
    if run.parameter("-axisymmetric", 0) > 0:
        axes.set_ylabel(f"r ({run.units['length']})")
    figure.suptitle(title, fontsize=10)
    return figure, axes


def caption(run):
    """Case, model, whether it is axisymmetric, and the Reynolds number where one was given."""
    given = run.info.get("parameters") or {}
    words = [str(given["-model"])] if "-model" in given else []
    if run.parameter("-axisymmetric", 0) > 0:
        words.append("axisymmetric")
    reynolds = run.parameter("-reynolds", 0)
    if reynolds > 0:
        words.append(f"Reynolds number {reynolds:g}")
    return run.title + (f" ({', '.join(words)})" if words else "")


def draw_field(run, mesh, field_mesh, values, label, path, title, streams=None):
    """One scalar field with the outline of the mesh; `streams`: velocity whose streamlines go on top."""
    figure, axes = one_panel(run, mesh, title)
    grid = Triangulation(*field_mesh.points.T, field_mesh.triangles)
    drawn = axes.tripcolor(grid, values, shading="gouraud", cmap=FIELD_MAP, rasterized=True)
    if streams is not None:
        draw_streams(axes, grid, streams)
    draw_outline(axes, mesh)
    figure.colorbar(drawn, ax=axes, label=label, shrink=0.95, pad=0.01)
    save(figure, path)


def draw_streams(axes, grid, velocity):
    """Streamlines on a regular grid, masked outside the fluid; on the page at least 0.06 inches apart along x, 0.027 along y."""
    wide, high = size = size_of(np.column_stack([grid.x, grid.y]))
    rows = int(np.clip(600 * high / wide, 60, 600))
    # streamplot draws nothing on the rim, where rounding may put a point outside
    x = np.linspace(grid.x.min(), grid.x.max(), 600)
    y = np.linspace(grid.y.min(), grid.y.max(), rows)
    points = np.meshgrid(x, y)
    u, v = (LinearTriInterpolator(grid, component)(*points) for component in velocity[:, :2].T)
    axes.streamplot(x, y, u, v, color="white", linewidth=0.45, arrowsize=0.5,
                    density=np.clip(np.minimum(size / (1.75, 0.8), 10 * size[::-1]), 0.2, 6.5), broken_streamlines=True)


def draw_walls(run, path):
    """Wall shear and pressure along the walls below and above the fluid; zones of reversed flow grey."""
    wall, zones, pressure = run.columns("wall"), run.columns("zones"), run.units_per_depth["pressure"]
    figure, both = plt.subplots(2, 1, figsize=(PAGE_WIDTH, 4.4), sharex=True, layout="constrained")
    for k, (side, name) in enumerate(((-1, "walls below the fluid"), (1, "walls above the fluid"))):
        own = wall["side"] == side
        if not own.any():
            continue
        # a gap between walls that do not hang together
        ends = np.flatnonzero(np.diff(wall["wall"][own])) + 1 if "wall" in wall else []
        for axes, column in zip(both, ("shear", "pressure")):
            axes.plot(np.insert(wall["x"][own], ends, np.nan), np.insert(wall[column][own], ends, np.nan), **curve(k), label=name)
    for side, start, end in zip(zones["side"], zones["separation"], zones["reattachment"]):
        for axes in both:
            axes.axvspan(start, end, ymin=0 if side < 0 else 0.96, ymax=0.04 if side < 0 else 1, color="#9a9a9a")
    figure.suptitle(f"{caption(run)}: walls", fontsize=10)
    both[0].axhline(0, color="black", linewidth=0.6)
    both[0].set_ylabel(f"wall shear ({pressure})")
    # a sharp edge carries a peak that would hide the rest
    spread = np.percentile(abs(wall["shear"]), 97)
    both[0].set_ylim(-1.3 * spread, 1.3 * spread)
    if np.max(abs(wall["shear"])) > 1.3 * spread:
        both[0].set_title(f"peaks at sharp edges, up to {np.max(abs(wall['shear'])):.3g} {pressure}, are cut off", fontsize="small")
    both[1].set_ylabel(f"gauge pressure\nat walls ({pressure})")
    both[1].set_xlabel(f"x ({run.units['length']})" + ("; grey bars: reversed flow at walls below (bottom) and above (top)"
        if zones["side"].size else ""))
    for axes in both:
        axes.grid(True)
    both[1].legend(loc="best")
    save(figure, path)


def main(arguments=None):
    """The command line."""
    parser = Parser(prog="python -m tools.plot_steady", description=__doc__)
    parser.add_argument("run", help="folder of the run")
    parser.add_argument("--out", metavar="FOLDER", help="folder for the pictures (default: the run's)")
    options = parser.parse_args(arguments)
    run = RunFolder(options.run)
    out = Path(options.out or options.run)
    if not (run.folder / "fields.vtu").is_file() or not (run.folder / "mesh.mesh").is_file():
        raise BadInput(f"{options.run} holds no fields.vtu and mesh.mesh of a steady flow"
            + (" (-fields 1 writes the fields)" if run.has("results") else "; python -m tools.plot draws other runs"))
    field_mesh, values = read_field(run.folder / "fields.vtu")
    laminar = "k" not in values  # of scripts/steady_laminar.edp, which writes no tables along the walls
    caption(run), laminar or (run.columns("wall"), run.columns("zones"))  # what is damaged ends before anything is written
    run.warn_unfinished()
    out.mkdir(parents=True, exist_ok=True)
    mesh = read_mesh(run.folder / "mesh.mesh")
    # the fields' are those of the mesh cut in four
    if len(field_mesh.triangles) not in (len(mesh.triangles), 4 * len(mesh.triangles)):
        raise BadInput(f"{options.run}: fields.vtu and mesh.mesh do not belong together")
    names = run.units | run.units_per_depth
    speed = np.hypot(*values["velocity"][:, :2].T)
    draw_field(run, mesh, field_mesh, speed, f"speed ({names['speed']})", out / "streamlines.png", caption(run) + ": streamlines",
        streams=values["velocity"])
    made = ["streamlines.png"]
    for name, label, read in PICTURES[:2] if laminar else PICTURES:
        field, label = read(values), label.replace("gauge ", "") if laminar else label  # a cavity has no outlet
        if np.ptp(field) > 0:  # k and nu_t of a laminar flow are 0
            draw_field(run, mesh, field_mesh, field, label.format(**names), out / f"{name}.png",
                f"{caption(run)}: {label.split(' (')[0]}")
            made.append(f"{name}.png")
    if not laminar and run.columns("wall")["x"].size:  # a flow between planes of symmetry has none
        draw_walls(run, out / "walls.png")
        made.append("walls.png")
    print(f"{out}: " + ", ".join(made))
    return 0
