"""A disk thrown at a wall in a fluid: speed of rebound over that of impact against the Stokes number, from mesh to mesh.

No published curve is for disks in two dimensions. The target is the suite's own run on a mesh twice as fine, with half the step;
the curve of lubrication alone, without the inertia of the fluid, is drawn beside it.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.films import CASE, RADIUS, at_wall
from tools.validation.particles import axes_of

OWN = "the suite's own run on a mesh twice as fine"
RESTITUTION, DENSITY, ROUGH, PASSED = 0.97, 8.0, 0.02, 0.25  # gaps in radii; speeds are those at the gap PASSED
STOKES = {5: 0.4, 15: 0.4, 50: 0.55, 80: 0.55, 150: 0.4, 500: 0.4}  # of the speed at the start: time of the run, s


def lubrication(stokes):
    """Speed of rebound over that of impact if the film alone acts, from the gap PASSED to the roughness and back:
    e - (1 + e) S/St, S = 2/(9 pi) int F/(mu V) dgap; at least 0."""
    gap = np.geomspace(ROUGH, PASSED, 2000)
    critical = 2 / (9 * np.pi) * np.trapezoid(at_wall(gap), gap)
    return np.maximum(0, RESTITUTION - (1 + RESTITUTION) * critical / np.asarray(stokes))


def rebound(table, mu):
    """(Stokes number, speed of rebound over that of impact), both speeds at the gap PASSED; 0 if it stops before.
    Raises Failed where the run ends on the way."""
    gap, closing = table["gap"], table["closing"]
    turn = int(np.argmin(gap))
    if not gap[turn] < PASSED < gap[0]:
        raise Failed("the disk has not come to the wall")
    if gap[-1] < PASSED and abs(closing[-1]) > 0.01:
        raise Failed("the run ends before the disk is back, or at rest")
    speed = float(np.interp(-PASSED, -gap[:turn + 1], closing[:turn + 1]))
    back = float(np.interp(PASSED, gap[turn:], -closing[turn:])) if gap[-1] > PASSED else 0.0
    return DENSITY * speed * 2 * RADIUS / (9 * mu), back / speed


def draw(found, path):
    """Saves the picture; found: {elements per radius: [(Stokes number, speed of rebound over that of impact), ...]}."""
    figure, axes = axes_of()
    for number, (cells, pairs) in enumerate(sorted(found.items())):
        axes.semilogx(*zip(*pairs), **(curve(number) | {"linestyle": "none", "marker": "os"[number % 2]}),
            markerfacecolor="none" if number == 0 else None, label=f"elements of R/{cells}")
    line = np.geomspace(2, 600, 600)
    axes.semilogx(line, lubrication(line), **(curve(2) | {"marker": ""}), label="lubrication alone")
    axes.axhline(RESTITUTION, **(curve(3) | {"marker": ""}), label=f"dry, e = {RESTITUTION}")
    axes.set_xlabel("Stokes number at a gap of a quarter of the radius")
    axes.set_ylabel("speed of rebound over that of impact")
    axes.set_ylim(-0.03, 1.03)
    axes.legend(loc="upper left", bbox_to_anchor=(0, 0.91))
    save(figure, path)


def thrown_at_a_wall(context):
    """Rebound against the Stokes number, elements of a quarter and of an eighth of the radius."""
    found = {}
    for stokes, end in STOKES.items():
        cpu, values = 0.0, []
        mu = DENSITY * 2 * RADIUS / (9 * stokes)
        for cells in (4, 8):
            words = {"-gap": 0.5, "-speed": 1, "-rhos": DENSITY, "-mu": mu, "-dt": 0.01 / cells, "-cfl": 0, "-every": 0,
                "-x": 1.017, "-tend": end, "-film-roughness": ROUGH, "-restitution": RESTITUTION}
            try:
                run = context.run(CASE, words, f"rebound_{stokes}_{cells}",
                    ("box", RADIUS / cells, "--width", "2", "--height", "2"))
                values.append(rebound(run.folder.table("near"), mu))
                cpu += run.cpu_s
                found.setdefault(cells, []).append(values[-1])
            except Failed as problem:
                yield context.failed(f"Stokes number {stokes}, R/{cells}", OWN, float("nan"), problem)
        if len(values) == 2:
            yield context.row(f"Stokes number {stokes} at the start ({values[1][0]:.3g} at the wall): speed of rebound over "
                "that of impact, from mesh to mesh", OWN, values[1][1], values[0][1], atol=0.05, cpu_s=cpu)
    draw(found, context.figure_path("rebound"))


VALIDATIONS = [thrown_at_a_wall]
