"""A disk settling in a closed box, against a body-fitted transient and published curves.

Box 2 x 6 cm, d = 0.25 cm, rho_s = 1.25 g/cm3, mu = 0.1 g/(cm s), from rest at (1, 4).
Body-fitted: tools/peers/body_fitted/settling_disk.edp, which shares no code with the suite; its numbers
stand in tests/reference/settling_disk_body_fitted.csv. Peak velocity 5.59 cm/s and the curves: Koblitz, Lovett, Nikiforakis and
Henshaw, J. Comput. Phys. 343 (2017) 414-431, figures 6a and 6b, digitised (about 1 %).
"""
import numpy as np

from tools.base import quantities
from tools.base.command import ROOT
from tools.base.tables import read_table
from tools.plot.style import PAGE_WIDTH, curve, plt, save
from tools.validation import Failed

DIAMETER, PEAK = 0.25, 5.59
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


def fitted():
    """The body-fitted transient: t (s), height (cm), velocity (cm/s)."""
    table = read_table(ROOT / "tests" / "reference" / "settling_disk_body_fitted.csv")
    return table["t_s"], table["y_cm"], table["v_cm_per_s"]


def fitted_mean(start=0.3, end=0.4):
    """Its mean velocity between two times, cm/s."""
    t, y, _ = fitted()
    return float(np.interp(end, t, y) - np.interp(start, t, y)) / (end - start)


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
    """Heights and velocities with the digitised points, and velocities less the body-fitted one.
    tracks: {cells: rows of the disk}."""
    (t_y, y), (t_v, v) = published()
    t_fitted, _, v_fitted = fitted()
    figure, (left, right, apart) = plt.subplots(1, 3, figsize=(PAGE_WIDTH, 2.8), layout="constrained")
    for axes, times, values, name, label in ((left, t_y, y, "y", "height of the centre (cm)"),
                                             (right, t_v, v, "v", "velocity (cm/s)")):
        axes.plot(times, values, "o", markersize=3, markerfacecolor="white", markeredgecolor="black",
                  markeredgewidth=0.7, label=PUBLISHED)
        for k, (cells, track) in enumerate(sorted(tracks.items())):
            axes.plot(track["t"], track[name], **curve(k), label=f"D/h = {cells}")
        axes.set_ylabel(label)
    for k, (_, track) in enumerate(sorted(tracks.items())):
        now = (track["t"] >= BEFORE_FLOOR[0]) & (track["t"] <= BEFORE_FLOOR[1])
        off = track["v"][now] - np.interp(track["t"][now], t_fitted, v_fitted)
        apart.plot(track["t"][now], 100 * off / v_fitted.min(), **curve(k))
    apart.axhline(0, color="black", linewidth=0.7)
    apart.set_ylabel("less body-fitted (% of peak)")
    for axes in (left, right, apart):
        axes.set_xlabel("t (s)")
        axes.grid(True)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return save(figure, path)


def settling_disk(context):
    """The disk at 4, 6 and 8 cells across its diameter."""
    tracks, runs, errors, mean = {}, {}, {}, fitted_mean()
    for cells in ALLOWED:
        size = DIAMETER / cells
        options = {"-dt": 0.004 / cells, "-tend": 0.8, "-rhos": 1.25, "-mu": 0.1}
        try:
            runs[cells] = context.run("cases/settling_disk.edp", options, f"cells_{cells}", mesh=("settling_disk", size))
            tracks[cells] = next(iter(runs[cells].folder.tracks.values()))
        except (Failed, StopIteration) as problem:
            yield context.failed(f"D/h = {cells}: mean velocity (cm/s)", FITTED, mean, problem)
    figure = draw(tracks, context.figure_path("curves")) if tracks else None
    for cells, track in tracks.items():
        run, name = runs[cells], f"D/h = {cells}: "
        cost = {"cpu_s": run.cpu_s, "figure": figure}
        try:
            found = quantities.mean_v(run.folder, 0.3, 0.4)
            errors[cells] = abs(found / mean - 1)
            yield context.row(name + "mean velocity over 0.3 to 0.4 s (cm/s)", FITTED, mean, found, rtol=ALLOWED[cells], **cost)
            yield context.row(name + "deviation of the velocity from its parabola over 0.3 to 0.4 s, over the mean", "none", 0,
                              quantities.noise_v(run.folder, 0.3, 0.4), at_most=NOISE[cells], **cost)
            yield context.row(name + "peak velocity (cm/s)", PUBLISHED, PEAK, quantities.peak_speed(run.folder), rtol=0.01, **cost)
            far, off = distances(track)
            yield context.row(name + "largest distance of the heights (cm), 0.05 to 0.7 s", PUBLISHED + ", fig. 6a", 0, far,
                              at_most=0.04, **cost)
            yield context.row(name + "rms distance of the velocities over the peak, 0.05 to 0.7 s", PUBLISHED + ", fig. 6b", 0,
                              off, at_most=0.01, **cost)
        except ValueError as problem:
            yield context.failed(name + "mean velocity (cm/s)", FITTED, mean, problem)
    if len(errors) == len(ALLOWED):
        order = -np.polyfit(np.log(list(errors)), np.log(list(errors.values())), 1)[0]
        yield context.row("order of the mean velocity, mesh and time step refined together", "second order", 2, order, at_least=1.8)


VALIDATIONS = [settling_disk]
