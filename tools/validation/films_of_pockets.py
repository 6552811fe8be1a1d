"""Fluid that films enclose: a held disk that moves slowly into a corner, or between others, against body-fitted computations.

FITTED is from tools/peers/body_fitted/corner_stokes.edp -solid 270, pocket_stokes.edp, and lattice_stokes.edp (-fine 2, for 0.02
-fine 3; coarser meshes differ by 0.4 %). The bound was set before the runs.
"""
import numpy as np

from tools.validation import Failed
from tools.validation.films_at_corners import words

CORNER, POCKET, LATTICE = (f"tools/validation/near_{name}.edp" for name in ("corner", "pocket", "lattice"))
SOURCE, WITHIN, STEPS = "body-fitted computation", 0.25, 150
PUSH = 30
FITTED_CORNER = {0.5: 237.2, 0.25: 935.5, 0.1: 7394.6, 0.05: 38708.0, 0.02: 364836.0}  # by the gap in radii
FITTED_POCKET = {(0.25, 0.25): 278.3, (0.25, 0.1): 333.3, (0.1, 0.1): 1933.7, (0.1, 0.02): 2576.7, (0.05, 0.005): 13523.7,
    (0.02, 0.1): 7317.9, (0.02, 0.02): 87909.8}  # by the gap, and that of the other two
FITTED_LATTICE = {0.25: 764.9, 0.1: 5944.2, 0.05: 30732.0, 0.02: 287320.0}  # by the gap


def of_corner(forces, gap, tilt=0.0):
    """Resistance along the bisector, over viscosity and speed; tilt: degrees."""
    angle = np.radians(135 + tilt)
    return float(np.array([forces["fx"][-1], forces["fy"][-1]]) @ [np.cos(angle), np.sin(angle)]) / (1e-4 * gap)


def of_pocket(forces, gap, tilt=0.0):
    """Resistance of the third disk."""
    third = forces["id"] == 2
    angle = np.radians(90 + tilt)
    return float(np.array([forces["fx"][third][-1], forces["fy"][third][-1]]) @ [np.cos(angle), np.sin(angle)]) / (1e-4 * gap)


def corner_words(gap, size=0.25, tilt=0):
    """Options of a run."""
    return {**words(270, 45, gap, 0, size), "-dt": 0.5 * size**2, "-tilt": tilt, "-tend": 0.5 * size**2 * STEPS}


def pocket_words(gap, apart, size=0.25, tilt=0):
    """Options of a run."""
    return {"-gap": gap, "-apart": apart, "-size": size, "-tilt": tilt, "-dt": 0.5 * size**2, "-cfl": 0, "-every": 0, "-forces": 1,
        "-tend": 0.5 * size**2 * STEPS}


def of_lattice(forces, gap):
    """Resistance of the middle disk."""
    return float(-forces["fx"][forces["id"] == 4][-1]) / (1e-4 * gap)


def lattice_words(gap, place=(0, 0), size=0.25):
    """Options of a run."""
    return {"-gap": gap, "-size": size, "-x": place[0], "-y": place[1], "-dt": 0.5 * size**2, "-cfl": 0, "-every": 0, "-forces": 1,
        "-tend": 0.5 * size**2 * STEPS}


def lubrication(gap):
    """Resistance in the corner: two films, and the flow through both; 0.2 to 0.8 % above FITTED_CORNER."""
    return 4.5 * np.pi * np.sqrt(2) * gap**-2.5 * (1 + gap / 2) ** 2 + 1.5 * np.pi * (2 / gap) ** 1.5 * (1 + gap)


def pushed(context):
    """A free disk that is pushed into the corner: resistance at some gaps, over that of lubrication theory."""
    for size, tilt in ((0.25, 0), (0.25, 17), (0.125, 0)):
        options = {**words(270, 45, 0.6, 0, size), "-force": PUSH, "-tilt": tilt, "-tend": 60, "-forces": 0}
        name = f"pushed into a corner, {1 / size:g} elements per radius, turned by {tilt} degrees"
        try:
            run = context.run(CORNER, options, f"pushed_{size:g}_{tilt}")
        except Failed as problem:
            yield context.failed(name, "lubrication theory", 1, problem)
            continue
        table, angle = run.folder.particles, np.radians(135 + tilt)
        gap = (table["x"] * np.cos(angle) + table["y"] * np.sin(angle)) / np.sqrt(2) - 1
        speed = -(table["u"] * np.cos(angle) + table["v"] * np.sin(angle))
        for at in (0.3, 0.2, 0.15, 0.1, 0.08):
            k = int(np.argmax(gap < at))
            found = float(PUSH / speed[k] / lubrication(gap[k]))
            yield context.row(f"{name}: gap {at:g} R", "lubrication theory", 1, found, rtol=WITHIN, cpu_s=run.cpu_s)


def pockets(context):
    """Two places in the mesh each, four elements per radius; in the corner eight, too."""
    for gap, fitted in FITTED_CORNER.items():
        for size, tilt in ((0.25, 0), (0.25, 17), (0.125, 0)):
            name = f"corner, gap {gap:g} R, {1 / size:g} elements per radius, turned by {tilt} degrees"
            try:
                run = context.run(CORNER, corner_words(gap, size, tilt), f"corner_{gap:g}_{size:g}_{tilt}")
            except Failed as problem:
                yield context.failed(name, SOURCE, fitted, problem)
                continue
            yield context.row(name, SOURCE, fitted, of_corner(run.folder.table("forces"), gap, tilt), rtol=WITHIN, cpu_s=run.cpu_s)
    for (gap, apart), fitted in FITTED_POCKET.items():
        for tilt in (0, 25):
            name = f"between two disks, {apart:g} R apart, gap {gap:g} R, turned by {tilt} degrees"
            try:
                run = context.run(POCKET, pocket_words(gap, apart, tilt=tilt), f"pocket_{gap:g}_{apart:g}_{tilt}")
            except Failed as problem:
                yield context.failed(name, SOURCE, fitted, problem)
                continue
            yield context.row(name, SOURCE, fitted, of_pocket(run.folder.table("forces"), gap, tilt), rtol=WITHIN, cpu_s=run.cpu_s)


def lattice(context):
    """The middle one of nine disks in a domain without walls, at two places in the mesh."""
    for gap, fitted in FITTED_LATTICE.items():
        for place in ((0, 0), (3, 2.2)):
            name = f"lattice without walls, gap {gap:g} R, place {place[0]:g}, {place[1]:g} R"
            try:
                run = context.run(LATTICE, lattice_words(gap, place), f"lattice_{gap:g}_{place[0]:g}")
            except Failed as problem:
                yield context.failed(name, SOURCE, fitted, problem)
                continue
            yield context.row(name, SOURCE, fitted, of_lattice(run.folder.table("forces"), gap), rtol=WITHIN, cpu_s=run.cpu_s)


VALIDATIONS = [pockets, lattice, pushed]
