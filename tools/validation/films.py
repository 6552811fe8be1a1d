"""Films below the mesh: disks at walls, straight and round, and near each other, against exact and body-fitted resistances,
closed forms, and from mesh to mesh.

Exact, a disk at a plane: Jeffrey & Onishi, Q. J. Mech. Appl. Math. 34 (1981) 129. Two equal disks that approach each other in
Stokes flow: a body-fitted computation, outer radius 100, of about 0.2 % (PAIR).
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of

CASE = "tools/validation/near_disks.edp"
EXACT = "exact (Jeffrey & Onishi 1981)"
GAPS = (0.5, 0.25, 0.18, 0.13, 0.1, 0.07, 0.05, 0.035, 0.025, 0.018, 0.0105)  # radii
RADIUS, PUSH, DENSITY = 0.25, 31.4, 2.0  # Reynolds number at the start: 0.3
BODY_FITTED = "body-fitted computation"
# gap in radii: force over viscosity and speed of a disk without torque along the floor of the box of along(); exact without the
# other walls: 16.6, 28.3, 62.9
ALONG = {0.3: 22.2, 0.1: 33.3, 0.02: 67.7}
# gap in radii, force over viscosity and the speed of each
PAIR = np.array([(1, 25.96), (0.5, 49.72), (0.2, 141.5), (0.1, 349.0), (0.05, 914.9), (0.02, 3446), (0.01, 9585)])
# the same of one disk that moves along the radius of a round box of four radii: finite elements in bipolar coordinates
RING = np.array([(1, 45.12), (0.7, 63.14), (0.5, 90.33), (0.3, 165.4), (0.2, 278.3), (0.1, 717.1), (0.05, 1930.9), (0.03, 4071.7),
    (0.02, 7404), (0.01, 20728), (0.008, 28909)])


def at_wall(gap):
    """Resistance over the viscosity of a disk that moves towards a plane; gap: radii, above 0."""
    a = np.arccosh(1 + np.asarray(gap))
    return 4 * np.pi / (a - np.tanh(a))


def of_pair(gap):
    """Resistance over the viscosity of each of two disks that approach each other with the same speed; gap: radii, 0.005 to 1.
    Between the computed gaps the ratio to 3 pi gap^-1.5, the leading term, is linear."""
    known = PAIR[::-1]
    return 3 * np.pi * np.asarray(gap) ** -1.5 * np.interp(gap, known[:, 0], known[:, 1] / (3 * np.pi * known[:, 0] ** -1.5))


def in_ring(gap):
    """As at_wall(), in a round box of four radii; gap: radii, 0.008 to 1. Between the computed gaps as of_pair() has it."""
    known = RING[::-1]
    leading = lambda gap: 1.5 * np.pi * (8 / 3 / np.asarray(gap)) ** 1.5
    return leading(gap) * np.interp(gap, known[:, 0], known[:, 1] / leading(known[:, 0]))


def duration(exact, from_gap, to_gap, pair):
    """Time in s from one gap to another (radii) at the exact resistance."""
    gap = np.geomspace(to_gap, from_gap, 4000)
    return np.trapezoid(exact(gap), gap) * RADIUS / (PUSH * (2 if pair else 1))


def passed_at(table, gap):
    """When the disk passed a gap, s; nan where it did not."""
    least = np.minimum.accumulate(table["gap"])
    if least[-1] > gap:
        return np.nan
    return float(np.interp(-gap, -least, table["t"]))


def resistances(table, exact, pair):
    """(gaps, resistance over the exact one) of a run: the push less what accelerates the disk, over its speed."""
    speed = table["closing"] / (2 if pair else 1)
    force = PUSH - DENSITY * np.pi * RADIUS**2 * np.gradient(speed, table["t"])
    seen = (table["gap"] < 0.55) & (table["gap"] > 0.0099)
    return table["gap"][seen], force[seen] / speed[seen] / exact(table["gap"][seen])


def pushed(context, exact, pair, runs, mesh, within, unit):
    """Rows of disks pushed together. runs: (size, step over size^2, options); unit: what the rows are about."""
    found, cpu, times = [], 0.0, []
    whole = duration(exact, 0.9, 0.0101, pair)
    for size, share, options in runs:
        name = "_".join([f"{size:g}", f"{share:g}"] + [f"{value:g}" for value in options.values()])
        words = {"-kind": "pair" if pair else "wall", "-gap": 0.95, "-force": PUSH, "-rhos": DENSITY, "-dt": share * size**2,
            "-cfl": 0, "-every": 0, "-tend": 1.12 * whole, **options}
        try:
            run = context.run(CASE, words, f"{words['-kind']}_{name}", (mesh[0], size, *mesh[1:]))
        except Failed as problem:
            yield context.failed(f"{unit}, {name}: runs", EXACT, float("nan"), problem)
            continue
        table = run.folder.table("near")
        found.append(resistances(table, exact, pair))
        times.append((passed_at(table, 0.0101) - passed_at(table, 0.9)) / whole)
        cpu += run.cpu_s
    if not found:
        return
    figure, axes = axes_of()
    for number, (gap, ratio) in enumerate(found):
        axes.semilogx(gap, ratio, **(curve(number) | {"marker": ""}))
    axes.set_xlabel("gap over the radius")
    axes.set_ylabel("resistance over the exact one")
    path = save(figure, context.figure_path(unit.replace(",", "").replace(" ", "_")))
    source = EXACT if exact is at_wall else BODY_FITTED
    for gap in GAPS:
        values = [float(np.interp(-gap, -np.minimum.accumulate(gaps), ratio)) for gaps, ratio in found]
        yield context.row(f"{unit}, gap {gap:g} R: resistance over the exact one, worst of {len(values)} runs", source, 1,
            max(values, key=lambda value: abs(value - 1)), rtol=within, cpu_s=cpu / len(GAPS), figure=path)
    yield context.row(f"{unit}: largest resistance over the exact one at any step from 0.5 to 0.01 R", source, 1,
        max(ratio.max() for _, ratio in found), at_most=1.5)
    yield context.row(f"{unit}: time from 0.9 to 0.01 R over the exact one, worst of {len(times)} runs", source, 1,
        max(times, key=lambda value: abs(value - 1) if value == value else np.inf), rtol=0.03 if not pair else within)


def disk_and_wall(context):
    """A disk pushed to the floor: eight places in the mesh, two meshes, three steps."""
    runs = [(RADIUS / 4, 2, {"-x": 1 + RADIUS / 4 * k / 8}) for k in range(8)]
    runs += [(RADIUS / 4, share, {"-x": 1.024}) for share in (1, 0.5)]
    runs += [(RADIUS / 8, 2, {"-x": 1 + RADIUS / 8 * k / 8}) for k in (1, 4)]
    yield from pushed(context, at_wall, False, runs, ("box", "--width", "2", "--height", "2"), 0.15, "disk and wall")


def curved_wall(context):
    """A disk pushed to the lowest point of a round box of four radii, which is a vertex of its chords: two meshes, two steps."""
    runs = [(RADIUS / 4, share, {"-ring": 4}) for share in (2, 0.5)] + [(RADIUS / 8, 2, {"-ring": 4})]
    yield from pushed(context, in_ring, False, runs, ("box", "--width", "2", "--height", "2"), 0.15, "disk in a round box")


def graded_mesh(context):
    """A disk pushed to the floor, where elements are half as high as at the disk's top: three places in the mesh."""
    runs = [(RADIUS / 4, 2, {"-graded": 1.25, "-x": 1 + RADIUS / 4 * k / 3}) for k in range(3)]
    yield from pushed(context, at_wall, False, runs, ("box", "--width", "2", "--height", "2"), 0.15, "disk and wall, graded mesh")


def two_disks(context):
    """Two disks pushed together: places in the mesh, directions, and two meshes."""
    places = ((1.5, 1.25, 0), (1.515, 1.26, 0), (1.53125, 1.25, 0), (1.5, 1.28, 0), (1.5, 1.25, np.pi / 4),
        (1.52, 1.25, 3 * np.pi / 4), (1.5, 1.25, 0.4), (1.53, 1.26, 0.4))
    runs = [(RADIUS / 4, 2, dict(zip(("-x", "-y", "-angle"), place))) for place in places]
    runs += [(RADIUS / 4, 0.5, {"-x": 1.515, "-y": 1.26, "-angle": 0.0}), (RADIUS / 8, 2, {"-x": 1.505, "-y": 1.25, "-angle": 0.0})]
    yield from pushed(context, of_pair, True, runs, ("box", "--width", "3", "--height", "2.5"), 0.25, "two disks")


def along(context):
    """A disk pushed along the floor in the middle of a box of 16 x 8 radii, free to turn: its steady speed."""
    for gap, whole in ALONG.items():
        size = RADIUS / 4
        try:
            run = context.run(CASE, {"-gap": gap, "-across": 0.05, "-dt": size**2, "-cfl": 0, "-every": 0, "-tend": 0.3,
                "-x": 2.02}, f"along_{gap:g}", ("box", size, "--width", "4", "--height", "2"))
        except Failed as problem:
            yield context.failed(f"along the floor, gap {gap:g} R: runs", BODY_FITTED, float("nan"), problem)
            continue
        speed = abs(run.folder.table("near")["across"][-20:].mean())
        yield context.row(f"along the floor, gap {gap:g} R: resistance over the viscosity", BODY_FITTED, whole, 0.05 / speed,
            rtol=0.15, cpu_s=run.cpu_s)


def thrown(context):
    """A disk thrown at the floor, at three Reynolds numbers and on two meshes: rebound and final gap."""
    for reynolds in (0.1, 10, 100):
        gaps, cpu = [], 0.0
        for size in (RADIUS / 4, RADIUS / 8):
            mu = 2 * RADIUS / reynolds  # unit speed and density
            step = min(0.25 * size, 2 * size**2 / mu)
            end, density = (1.0, 8) if reynolds > 1 else (0.3, 800)  # in slow flow a light disk would stop far from the floor
            words = {"-gap": 0.3, "-speed": 1, "-rhos": density, "-mu": mu, "-dt": step, "-cfl": 0, "-every": 0,
                "-tend": end, "-x": 1.017}
            try:
                run = context.run(CASE, words, f"thrown_{reynolds:g}_{size:g}", ("box", size, "--width", "2", "--height", "2"))
            except Failed as problem:
                yield context.failed(f"thrown at the floor, Re {reynolds:g}: runs", "", float("nan"), problem)
                continue
            table = run.folder.table("near")
            cpu += run.cpu_s
            gaps.append(table["gap"][-1])
            yield context.row(f"thrown at the floor, Re {reynolds:g}, element R/{RADIUS / size:g}: rebound over the speed", "", 0,
                -table["closing"].min(), at_most=0.025, cpu_s=run.cpu_s)
        if len(gaps) == 2:
            yield context.row(f"thrown at the floor, Re {reynolds:g}: final gap (R), from mesh to mesh", "the finer mesh", gaps[1],
                gaps[0], rtol=0.05, cpu_s=cpu)
        if gaps and reynolds < 1:  # momentum over the viscosity: the integral of the resistance over the way
            ways = np.geomspace(0.3, 1e-3, 20000)
            spent = RADIUS * np.append(0, np.cumsum(0.5 * (at_wall(ways[1:]) + at_wall(ways[:-1])) * -np.diff(ways)))
            exact = float(np.interp(800 * np.pi * RADIUS**2 / mu, spent, ways))
            yield context.row("thrown at the floor, Re 0.1: final gap (R)", EXACT + ", without inertia of the fluid", exact,
                gaps[-1], rtol=0.15)


def push_and_pull(context):
    """Equal impulses towards the floor and back, without inertia: the gap of the start."""
    for share in (2, 1):
        size = RADIUS / 4
        try:
            run = context.run(CASE, {"-gap": 0.1, "-force": PUSH, "-reverse": 0.4, "-rhos": 1, "-dt": share * size**2,
                "-cfl": 0, "-every": 0, "-tend": 0.8, "-x": 1.017}, f"push_and_pull_{share:g}",
                ("box", size, "--width", "2", "--height", "2"))
        except Failed as problem:
            yield context.failed(f"pushed and pulled, nu dt/h^2 = {share:g}: runs", "closed form", float("nan"), problem)
            continue
        yield context.row(f"pushed and pulled, nu dt/h^2 = {share:g}: gap at the end (R)", "closed form", 0.1,
            run.folder.table("near")["gap"][-1], rtol=0.05, cpu_s=run.cpu_s)


VALIDATIONS = [disk_and_wall, curved_wall, graded_mesh, two_disks, along, thrown, push_and_pull]
