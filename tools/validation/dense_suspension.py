"""What films change in a sheared suspension: its viscosity at solid fractions of 0.1 to 0.5, with and without films, on two meshes.

For small fractions Einstein's law in two dimensions, 1 + 2 phi (Brady, Int. J. Multiphase Flow 10 (1984) 113). Beyond, the form of
Krieger and Dougherty with the intrinsic viscosity 2 of disks and a packing of 0.82, for orientation only: it knows no plates.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of
from tools.validation.suspension import CASE, spread, viscosity

SHARES, SEEDS, CELLS, START, END = (0.1, 0.2, 0.3, 0.4, 0.5), (1, 2, 3), (32, 64), 2.0, 8.0
PACKING = 0.82
SAME = 0.1  # from mesh to mesh, with films


def krieger(share):
    """Relative viscosity of disks at a solid fraction, number or array."""
    return (1 - np.asarray(share) / PACKING) ** (-2 * PACKING)


def means(context, found, cells, film):
    """Viscosities of all seeds by fraction into found[cells, film]; yields rows of runs that fail."""
    for share in SHARES:
        for seed in SEEDS if cells == CELLS[0] else SEEDS[:1]:
            name = f"{cells}_{share:g}_{seed}_{film}"
            try:
                run = context.run(CASE, {"-fraction": share, "-seed": seed, "-film": film, "-tend": END}, name,
                    mesh=("couette_disk", 1 / cells))
            except Failed as problem:
                yield context.failed(f"{name}: runs", "", float("nan"), problem)
                continue
            found.setdefault((cells, film), {}).setdefault(share, []).append(viscosity(run, START, END))


def dense_suspension(context):
    """The viscosity of disks between plates with and without films: seeds, and two meshes of the first seed."""
    found = {}
    for cells in CELLS:
        for film in (1, 0):
            yield from means(context, found, cells, film)
    figure, axes = axes_of()
    phi = np.linspace(0, max(SHARES), 50)
    axes.plot(phi, 1 + 2 * phi, "k:", linewidth=1, label="Einstein, 1 + 2φ")
    axes.plot(phi, krieger(phi), "k--", linewidth=1, label="Krieger and Dougherty")
    for number, ((cells, film), by_share) in enumerate(found.items()):
        axes.errorbar(list(by_share), [np.mean(v) for v in by_share.values()], [spread(v) for v in by_share.values()],
            **curve(number), capsize=3, label=f"{cells} cells, {'films' if film else 'no films'}")
    axes.set_xlabel("solid fraction φ")
    axes.set_ylabel("relative viscosity")
    axes.legend(loc="upper left")
    path = save(figure, context.figure_path("viscosity"))
    coarse, fine = ({film: found.get((cells, film), {}) for film in (0, 1)} for cells in CELLS)
    for share in SHARES:
        values, without = (coarse[film].get(share, [float("nan")]) for film in (1, 0))
        yield context.row(f"solid fraction {share:g}: relative viscosity with films, mean of {len(values)} seeds (standard deviation "
            f"{spread(values):.3f}; without films {np.mean(without):.3f}, {spread(without):.3f})", "above Einstein's law",
            1 + 2 * share, np.mean(values), at_least=1 + 2 * share, figure=path)
        finer, finer_without = (fine[film].get(share, [float("nan")])[0] for film in (1, 0))
        yield context.row(f"solid fraction {share:g}, first seed: relative viscosity with films, {CELLS[0]} cells (without: "
            f"{without[0]:.3f}, {finer_without:.3f})", f"{CELLS[1]} cells", finer, values[0], rtol=SAME)


VALIDATIONS = [dense_suspension]
