"""Films beside convex corners of walls: the resistance of a held disk that moves slowly, against body-fitted computations.

The disk approaches the wall, or moves along it, where the corner is nearest and where it lies beside the nearest point. FITTED is
from tools/peers/body_fitted/corner_stokes.edp. The bounds are those of disks at a plane (tools/validation/films.py).
"""
import numpy as np

from tools.validation import Failed

CASE, SOURCE, WITHIN, STEPS = "tools/validation/near_corner.edp", "body-fitted computation", 0.15, 20
# angle of the solid in degrees, direction to the centre from the corner in degrees or (below 0) distance of the nearest point from
# it in radii, gap in radii: force over viscosity and speed towards the wall, and along it
FITTED = {
    (90, 45, 0.1): (59.2, 49.6), (90, 45, 0.02): (104.2, 54.7), (90, 45, 0.003): (175.8, 69.0),
    (90, 80, 0.1): (102.8, 56.3), (90, 80, 0.02): (394.6, 60.7), (90, 80, 0.003): (1616.0, 77.1),
    (90, 90, 0.1): (163.1, 61.6), (90, 90, 0.02): (1287.1, 78.2), (90, 90, 0.003): (18481.8, 130.7),
    (90, -0.1, 0.1): (220.9, 62.0), (90, -0.1, 0.02): (2671.6, 81.3), (90, -0.1, 0.003): (68443.5, 154.8),
    (90, -0.25, 0.1): (310.9, 62.3), (90, -0.25, 0.02): (4114.1, 84.9), (90, -0.25, 0.003): (79989.6, 176.1),
    (60, 30, 0.1): (45.4, 50.9), (60, 30, 0.02): (66.4, 54.8), (60, 30, 0.003): (96.5, 66.0),
    (60, 70, 0.1): (72.0, 53.0), (60, 70, 0.02): (184.8, 56.5), (60, 70, 0.003): (483.1, 70.5),
    (60, -0.05, 0.1): (188.8, 61.5), (60, -0.05, 0.02): (1949.1, 79.2), (60, -0.05, 0.003): (48913.7, 143.2)}
SENSES = ("towards the wall", "along it")


def words(solid, where, gap, sense, size=0.25):
    """Options of a run; where: as in FITTED."""
    place = {"-to": where} if where > 0 else {"-past": -where}
    return {"-solid": solid, "-gap": gap, "-sense": sense, "-size": size, "-dt": 2 * size**2, "-cfl": 0, "-every": 0, "-forces": 1,
        "-tend": 2 * size**2 * STEPS, **place}


def resistance(forces, where, gap, sense, tilt=0.0):
    """That of the last row of forces.csv, over viscosity and speed; tilt: degrees."""
    angle = np.radians((where if where > 0 else 90) + tilt)
    n = np.array([np.cos(angle), np.sin(angle)])
    force = np.array([forces["fx"][-1], forces["fy"][-1]]) / (1e-4 * gap)
    return float(force @ n if sense == 0 else force @ [n[1], -n[0]])


def corners(context):
    """Corners of 90 and 60 degrees, four elements per radius."""
    for (solid, where, gap), fitted in FITTED.items():
        place = f"{where:g} degrees" if where > 0 else f"{-where:g} R beside the corner"
        for sense, name in enumerate(SENSES):
            unit = f"corner of {solid} degrees, {place}, gap {gap:g} R: resistance {name}"
            try:
                run = context.run(CASE, words(solid, where, gap, sense), f"{solid}_{where:g}_{gap:g}_{sense}")
            except Failed as problem:
                yield context.failed(unit, SOURCE, fitted[sense], problem)
                continue
            yield context.row(unit, SOURCE, fitted[sense], resistance(run.folder.table("forces"), where, gap, sense), rtol=WITHIN,
                cpu_s=run.cpu_s)


VALIDATIONS = [corners]
