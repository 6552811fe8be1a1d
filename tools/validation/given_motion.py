"""A cylinder that is moved to and fro: Morison's coefficients of the force on it.

H. Duetsch, F. Durst, S. Becker & H. Lienhart, J. Fluid Mech. 360 (1998) 249: C_d = 2.09, C_i = 1.45 at a Reynolds number of
100 and a Keulegan-Carpenter number of 5. Body-fitted: tools/peers/body_fitted/oscillating_cylinder.edp, in the frame of the
cylinder.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of

CASE, KC = "cases/oscillating_cylinder.edp", 5.0
PUBLISHED, FITTED = (2.09, 1.45), (2.047, 1.46)


def terms(t):
    """Morison's two terms at these times, (n, 2)."""
    turn = 2 * np.pi / KC
    speed = np.sin(turn * t)
    return np.column_stack([-0.5 * np.abs(speed) * speed, -0.25 * np.pi * turn * np.cos(turn * t)])


def coefficients(t, force):
    """C_d, C_i by least squares."""
    return np.linalg.lstsq(terms(t), force, rcond=None)[0]


def oscillating_cylinder(context):
    """Force on a cylinder moved to and fro in a fluid at rest, over one period, and Morison's coefficients."""
    figure, axes = axes_of()
    rows = []
    for k, cells in enumerate((12, 16, 24)):
        try:
            run = context.run(CASE, {"-dt": 0.3 / cells, "-every": 0}, f"oscillating_{cells}", mesh=("oscillating_cylinder",
                1 / cells))
        except Failed as problem:
            rows.append(context.failed(f"oscillating cylinder, {cells} elements per diameter", "body-fitted", FITTED[0], problem))
            continue
        table = run.folder.table("forces")
        last = table["t"] > table["t"][-1] - KC
        t, force = table["t"][last], table["fy"][last]
        found = coefficients(t, force)
        axes.plot((t - t[-1]) / KC + 1, force, **curve(k), label=f"{cells} elements per diameter")
        for name, value, fitted, published in zip(("C_d", "C_i"), found, FITTED, PUBLISHED):
            rows.append(context.row(f"oscillating cylinder, {cells} elements per diameter: {name}", "body-fitted P2/P1", fitted,
                value, rtol={12: 0.03, 16: 0.02, 24: 0.01}[cells], cpu_s=run.cpu_s))
            rows.append(context.row(f"oscillating cylinder, {cells} elements per diameter: {name}", "Duetsch et al. 1998",
                published, value, rtol=0.03, cpu_s=run.cpu_s))
    phase = np.linspace(0, 1, 200)
    axes.plot(phase, terms(phase * KC) @ PUBLISHED, "k:", linewidth=1, label="Morison's equation, Duetsch et al. 1998")
    axes.set_xlabel("time over the period")
    axes.set_ylabel("force / ($\\rho$ $U^2$ D)")
    axes.set_ylim(-2, 3.8)
    axes.legend(loc="upper left")
    yield from context.with_figure(rows, save(figure, context.figure_path("oscillating_cylinder")))


VALIDATIONS = [oscillating_cylinder]
