"""Films of capsules and squares whose faces lie parallel to the floor, or to each other.

References: body-fitted computations, at the floor (FITTED, `FreeFem++ -nw tools/peers/body_fitted/shapes_stokes.edp -wide 1
-points 300 -radius 0.125 -half 0.375 -gap D`, of the square -half 0.125 -high 0.125) and of two capsules (PAIR, the same with
-pair 1). Between their gaps they go as Reynolds' equation has it: the force over viscosity and speed is the integral of
12 xi^2/H^3 over the gap H.
"""
import numpy as np

from tools.plot.style import curve, save
from tools.validation import Failed
from tools.validation.particles import axes_of

CASE = "tools/validation/near_shapes.edp"
# gap: force over viscosity and speed of a capsule and of a square in the middle of the floor of a box of 2 x 2
FITTED = np.array([(0.1875, 255.49, 60.90), (0.15, 401.71, 82.01), (0.125, 601.24, 107.88), (0.09, 1314.5, 188.79),
    (0.0625, 3321.3, 382.88), (0.045, 7931.8, 771.79), (0.03125, 21429, 1778.8), (0.022, 56903, 4156.6),
    (0.015625, 149549, 9836.1), (0.01125, 382039, 23070), (0.008, 1019730, 57112)])
# the same of a capsule and a held one below it, 0.5 above the floor of such a box
PAIR = np.array([(0.125, 488.97), (0.109375, 668.22), (0.09375, 974.12), (0.078125, 1549.4), (0.0625, 2790.7), (0.04375, 7379.9),
    (0.03125, 18908), (0.022, 51252), (0.015625, 136995), (0.01125, 354769)])
SOURCE = "body-fitted computation"
SIZE, RADIUS, DENSITY = 0.0625, 0.125, 2.0
FACES = {"capsule": 1 - 2 * RADIUS, "square": 0.5 - 2 * RADIUS}  # width of the face between the round ends
AREAS = {"capsule": (1 - 2 * RADIUS) * 2 * RADIUS + np.pi * RADIUS**2, "square": 0.25 - (4 - np.pi) * RADIUS**2}
PUSH = {"capsule": 5000.0, "square": 500.0}
GAPS = (0.7, 0.5, 0.35, 0.25, 0.18)  # elements of 1/16
WIDE = (1.5, 1.25, 1.1, 1.02, 0.9)


def squeezed(gap, face, radius, ends):
    """Force over viscosity and speed between two faces of the width `face` with round ends, `ends` of them on each side (1: a body
    and a wall, 2: two bodies); lengths in one unit."""
    xi = np.concatenate([np.linspace(0, face / 2, 2000), face / 2 + radius * np.sin(np.linspace(0, np.pi / 2, 4000)[1:])])
    beyond = np.clip(xi - face / 2, 0, radius)
    width = gap + ends * (radius - np.sqrt(np.clip(radius**2 - beyond**2, 0, None)))
    return 2 * np.trapezoid(12 * xi**2 / width**3, xi)


def resistance(gap, kind, near):
    """That of the reference, over viscosity and speed. Between the computed gaps its ratio to Reynolds' equation is linear."""
    theory = lambda gap: np.array([squeezed(one, FACES[kind], RADIUS, 2 if near == "pair" else 1) for one in np.atleast_1d(gap)])
    table = PAIR[::-1, (0, 1)] if near == "pair" else FITTED[::-1, (0, 1 if kind == "capsule" else 2)]
    return theory(gap) * np.interp(gap, table[:, 0], table[:, 1] / theory(table[:, 0]))


def ratios(table, kind, near, push=None):
    """(gaps, resistance over that of the reference): the push less what accelerates the body, over its speed."""
    seen = (table["gap"] < (1.2 if push is None else 2) * SIZE) & (table["closing"] > 0)
    mass = DENSITY * AREAS[kind]
    force = (push or PUSH[kind]) - mass * np.gradient(table["closing"], table["t"])
    return table["gap"][seen], force[seen] / table["closing"][seen] / resistance(table["gap"][seen], kind, near)


def faces(context):
    """A capsule and a square pushed to the floor, and a capsule to a held one, from rest at a gap of an element: places in the
    mesh, three steps, two meshes."""
    figure, axes = axes_of()
    number = 0
    for kind, near in (("capsule", "wall"), ("square", "wall"), ("capsule", "pair")):
        found, cpu = [], 0.0
        for size, share, x in ((SIZE, 1, 1), (SIZE, 0.25, 1.02), (SIZE, 0.5, 1.031), (SIZE / 2, 1, 1.01)):
            words = {"-kind": kind, "-near": near, "-force": PUSH[kind], "-x": x, "-gap": 0.96 * size, "-dt": share * size**2,
                "-cfl": 0, "-every": 0, "-tend": 0.5, "-rhos": DENSITY}
            try:
                run = context.run(CASE, words, f"{kind}_{near}_{size:g}_{share:g}", ("box", size, "--width", "2", "--height", "2"))
            except Failed as problem:
                yield context.failed(f"{kind}, {near}: runs", SOURCE, float("nan"), problem)
                continue
            found.append(ratios(run.folder.table("near"), kind, near))
            cpu += run.cpu_s
        for gap, ratio in found[:1]:
            axes.semilogx(gap / SIZE, ratio, **(curve(number) | {"marker": "", "label": f"{kind}, {near}"}))
        number += 1
        for gap in GAPS:
            values = [float(np.interp(-gap * SIZE, -np.minimum.accumulate(gaps), ratio)) for gaps, ratio in found
                if gap * SIZE < gaps[0]]
            yield context.row(f"{kind}, {near}, gap of {gap:g}/16: resistance over the reference, worst of {len(values)} runs",
                SOURCE, 1, max(values, key=lambda value: abs(value - 1)), rtol=0.25 if gap > 0.4 or near == "pair" else 0.15,
                cpu_s=cpu / len(GAPS))
    axes.set_xlabel("gap over the size of the elements")
    axes.set_ylabel("resistance over the reference")
    axes.legend(loc="best")
    save(figure, context.figure_path("faces"))


def wide_gaps(context):
    """The same bodies pushed less hard, from rest at a gap of 2.2 elements: gaps of one to two elements, and the way into one."""
    for kind, near, push, end in (("capsule", "wall", 300.0, 1.2), ("square", "wall", 50.0, 0.8), ("capsule", "pair", 300.0, 1.2)):
        found, cpu = [], 0.0
        for x in (1, 1.03):
            words = {"-kind": kind, "-near": near, "-force": push, "-x": x, "-gap": 0.14, "-dt": 1 / 256, "-cfl": 0, "-every": 0,
                "-tend": end, "-rhos": DENSITY}
            try:
                run = context.run(CASE, words, f"wide_{kind}_{near}_{x:g}", ("box", SIZE, "--width", "2", "--height", "2"))
            except Failed as problem:
                yield context.failed(f"{kind}, {near}, wide gaps: runs", SOURCE, float("nan"), problem)
                continue
            found.append(ratios(run.folder.table("near"), kind, near, push))
            cpu += run.cpu_s
        for gap in WIDE:
            values = [float(np.interp(-gap * SIZE, -np.minimum.accumulate(gaps), ratio)) for gaps, ratio in found]
            if values:
                yield context.row(f"{kind}, {near}, gap of {gap:g}/16: resistance over the reference, worst of {len(values)} runs",
                    SOURCE, 1, max(values, key=lambda value: abs(value - 1)), rtol=0.25, cpu_s=cpu / len(WIDE))


VALIDATIONS = [faces, wide_gaps]
