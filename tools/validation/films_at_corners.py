"""Films beside convex corners of walls, and in round boxes and beside posts that are polygons: the resistance of a held disk that
moves slowly, against body-fitted computations.

The disk approaches the wall, or moves along it, where the corner is nearest and where it lies beside the nearest point. FITTED is
from tools/peers/body_fitted/corner_stokes.edp, POLYGONS from post_stokes.edp there. The bounds are those of disks at a plane
(tools/validation/films.py).
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
POLYGON = "tools/validation/near_polygon.edp"
# 1 inside the polygon or 0 beside it, sides, radius of the circle through its corners in radii of the disk, corner above which the
# disk stands (2.5: middle of a side), gap in radii: force over viscosity and speed towards the wall, and along it
POLYGONS = {
    (1, 24, 3, 2, 0.1): (1017.8, 94.4), (1, 24, 3, 2, 0.03): (9127.7, 201.7), (1, 24, 3, 2, 0.01): (93927.7, 604.9),
    (1, 24, 3, 2.5, 0.1): (750.8, 88.6), (1, 24, 3, 2.5, 0.03): (3352.4, 140.5), (1, 24, 3, 2.5, 0.01): (14507.3, 196.5),
    (1, 40, 3, 2, 0.1): (897.4, 91.8), (1, 40, 3, 2, 0.03): (6131.3, 168.4), (1, 40, 3, 2, 0.01): (48901.7, 356.0),
    (1, 40, 3, 2.5, 0.1): (821.2, 89.6), (1, 40, 3, 2.5, 0.03): (4077.5, 153.2), (1, 40, 3, 2.5, 0.01): (16687.5, 235.2),
    (1, 80, 3, 2, 0.03): (5062.2, 161.3), (1, 80, 3, 2, 0.01): (29292.2, 283.8), (1, 80, 3, 2.5, 0.01): (21619.2, 264.8),
    (0, 16, 1, 2, 0.03): (542.0, 33.6), (0, 16, 1, 2, 0.01): (1400.1, 43.3), (0, 16, 1, 2.5, 0.01): (10718.6, 61.2),
    (0, 64, 2, 2, 0.01): (5695.6, 68.1), (0, 64, 2, 2.5, 0.01): (8797.6, 72.5)}


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


def polygon_words(inside, sides, around, corner, gap, sense):
    """Options of a run; the first five as in POLYGONS. Four elements per radius, or more where sides are shorter than 1.6 elements:
    those as long as elements count as chords of a circle."""
    size = min(0.25, 2 * around * np.sin(np.pi / sides) / 1.6)
    return {"-inside": inside, "-sides": sides, "-post": around, "-corner": corner, "-gap": gap, "-sense": sense, "-size": size,
        "-dt": 2 * size**2, "-cfl": 0, "-every": 0, "-forces": 1, "-tend": 2 * size**2 * STEPS}


def polygon_resistance(forces, inside, sides, corner, gap, sense):
    """As resistance(), beside a polygon."""
    where = np.degrees(0.3 + 2 * np.pi * corner / sides) + 180 * inside
    return resistance(forces, where % 360 + 360, gap, sense)


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


def polygons(context):
    """Round boxes and posts that are polygons, above corners and in the middle of sides."""
    for (inside, sides, around, corner, gap), fitted in POLYGONS.items():
        name = f"{'round box' if inside else 'post'} of {around} R, {sides} sides, {'a corner' if corner == 2 else 'a side'}"
        for sense, way in enumerate(SENSES):
            unit = f"{name}, gap {gap:g} R: resistance {way}"
            try:
                run = context.run(POLYGON, polygon_words(inside, sides, around, corner, gap, sense),
                    f"polygon_{inside}_{sides}_{corner:g}_{gap:g}_{sense}")
            except Failed as problem:
                yield context.failed(unit, SOURCE, fitted[sense], problem)
                continue
            found = polygon_resistance(run.folder.table("forces"), inside, sides, corner, gap, sense)
            yield context.row(unit, SOURCE, fitted[sense], found, rtol=WITHIN, cpu_s=run.cpu_s)


VALIDATIONS = [corners, polygons]
