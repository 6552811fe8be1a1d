"""A disk settling in a closed box, against a body-fitted transient and published curves.

Box 2 x 6 cm, d = 0.25 cm, rho_s = 1.25 g/cm3, mu = 0.1 g/(cm s), from rest at (1, 4).
The mean velocity over t in [0.3, 0.4] s of a body-fitted computation in the disk's frame
is -5.512 cm/s. Peak velocity 5.59 cm/s and the curves: Koblitz, Lovett, Nikiforakis and
Henshaw, J. Comput. Phys. 343 (2017) 414-431, figures 6a and 6b, digitised (about 1 %).
"""
import numpy as np

from tools import quantities
from tools.command import ROOT
from tools.plotting import PAGE_WIDTH, curve, plt, save
from tools.tables import read_table
from tools.validation import Failed

DIAMETER, MEAN, PEAK = 0.25, -5.512, 5.59
FITTED, PUBLISHED = "body-fitted transient", "Koblitz et al. 2017"
# Cells across the diameter: allowed relative error of the mean velocity.
ALLOWED = {4: 0.005, 6: 0.003, 8: 0.0015}
NOISE = {4: 0.0015, 6: 0.0015, 8: 0.0003}  # of the velocity, as the disk crosses the mesh
BEFORE_FLOOR = (0.05, 0.7)  # s: after the scatter of the first digitised points, before the floor is near


def published():
    """The digitised curves: (t, height in cm), (t, velocity in cm/s)."""
    folder = ROOT / "tests" / "reference"
    height = read_table(folder / "settling_disk_height_koblitz2017_fig6a.csv")
    speed = read_table(folder / "settling_disk_velocity_koblitz2017_fig6b.csv")
    return (height["t_s"], height["y_cm"]), (speed["t_s"], speed["v_cm_per_s"])


def distances(track):
    """(largest distance of the heights in cm, root mean square distance of the velocities
    over the peak velocity), over the digitised points in BEFORE_FLOOR."""
    (t_y, y), (t_v, v) = published()
    now = (t_y >= BEFORE_FLOOR[0]) & (t_y <= BEFORE_FLOOR[1])
    far = abs(np.interp(t_y[now], track["t"], track["y"]) - y[now]).max()
    now = (t_v >= BEFORE_FLOOR[0]) & (t_v <= BEFORE_FLOOR[1])
    off = np.sqrt(np.mean((np.interp(t_v[now], track["t"], track["v"]) - v[now]) ** 2))
    return far, off / PEAK


def draw(tracks, path):
    """Heights and velocities with the digitised points. tracks: {cells: rows of the disk}."""
    (t_y, y), (t_v, v) = published()
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH, 3.1), layout="constrained")
    for axes, times, values, name, label in ((left, t_y, y, "y", "height of the centre (cm)"),
                                             (right, t_v, v, "v", "velocity (cm/s)")):
        axes.plot(times, values, "o", markersize=3.5, markerfacecolor="white", markeredgecolor="black",
                  markeredgewidth=0.8, label=PUBLISHED)
        for k, (cells, track) in enumerate(sorted(tracks.items())):
            axes.plot(track["t"], track[name], **curve(k), label=f"D/h = {cells}")
        axes.set_xlabel("t (s)")
        axes.set_ylabel(label)
        axes.grid(True)
    left.legend(loc="best")
    return save(figure, path)


def settling_disk(context):
    """The disk at 4, 6 and 8 cells across its diameter."""
    tracks, runs = {}, {}
    for cells in ALLOWED:
        size = DIAMETER / cells
        options = {"-dt": 0.004 / cells, "-tend": 0.8, "-rhos": 1.25, "-mu": 0.1}
        try:
            runs[cells] = context.run("cases/settling_disk.edp", options, f"cells_{cells}", mesh=("settling_disk", size))
            tracks[cells] = next(iter(runs[cells].folder.tracks.values()))
        except (Failed, StopIteration) as problem:
            yield context.failed(f"D/h = {cells}: mean velocity (cm/s)", FITTED, MEAN, problem)
    figure = draw(tracks, context.figure_path("curves")) if tracks else None
    for cells, track in tracks.items():
        run, name = runs[cells], f"D/h = {cells}: "
        cost = {"cpu_s": run.cpu_s, "figure": figure}
        try:
            yield context.row(name + "mean velocity over 0.3 to 0.4 s (cm/s)", FITTED, MEAN,
                              quantities.mean_v(run.folder, 0.3, 0.4), rtol=ALLOWED[cells], **cost)
            yield context.row(name + "deviation of the velocity from its parabola over 0.3 to 0.4 s, over the mean", "none", 0,
                              quantities.noise_v(run.folder, 0.3, 0.4), at_most=NOISE[cells], **cost)
            yield context.row(name + "peak velocity (cm/s)", PUBLISHED, PEAK, quantities.peak_speed(run.folder), rtol=0.01, **cost)
            far, off = distances(track)
            yield context.row(name + "largest distance of the heights (cm), 0.05 to 0.7 s", PUBLISHED + ", fig. 6a", 0, far,
                              at_most=0.04, **cost)
            yield context.row(name + "rms distance of the velocities over the peak, 0.05 to 0.7 s", PUBLISHED + ", fig. 6b", 0,
                              off, at_most=0.01, **cost)
        except ValueError as problem:
            yield context.failed(name + "mean velocity (cm/s)", FITTED, MEAN, problem)


VALIDATIONS = [settling_disk]
