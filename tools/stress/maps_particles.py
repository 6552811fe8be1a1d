"""Stability maps of particles in a flow: density, penalty, resolution, crowding, size, gaps, jam."""
from functools import lru_cache

import numpy as np

from tools.peers.contact_problems import packing
from tools.stress.cells import Axis, Cell, Disks, Map, Mesh
from tools.stress.classes import Checks

CASE = "cases/settling_disk.edp"
GRAVITY, DIAMETER = 100.0, 0.25  # cm/s2, cm
SMALLER = "a smaller -dt"
FINER = "a finer mesh (python -m tools.mesh CASE --size), 4 elements or more across the smallest particle"


def box(size, side=2.0):
    """A closed box."""
    return Mesh(("box", "--width", side, "--height", side, "--size", size))


def settling(dt, mesh, end, **more):
    """Options of a disk in a box of 2 cm."""
    return {"-mesh": mesh, "-cfl": 0, "-dt": dt, "-tend": end, "-every": 0, "-gravity": -GRAVITY, "-x": 1.0, "-y": 1.03, **more}


def falls(end, share=1.0):
    """Nothing goes faster than twice a free fall: no body's acceleration in a fluid exceeds gravity."""
    speed = 2 * GRAVITY * end * share
    return Checks({"particles.u": speed, "particles.v": speed, "fluid.top_speed": 3 * speed}, end)


def velocities(run):
    """u and v of all particles at the end, in the order of their ids."""
    table = run.particles
    last = table["t"] == table["t"].max()
    order = np.argsort(table["id"][last])
    return np.concatenate([table["u"][last][order], table["v"][last][order]])


def mean_fall(run):
    """Mean v of all particles at the end."""
    table = run.particles
    return np.array([table["v"][table["t"] == table["t"].max()].mean()])


def first_fall(run):
    """v of particle 0 at the end."""
    return np.array([run.tracks[0]["v"][-1]])


def density(dt, ratio):
    """One disk, 4 elements across, of any density."""
    return Cell(CASE, settling(dt, box(0.0625), 0.1, **{"-rhos": ratio}), falls(0.1), velocities, (0.0005, ratio), 0.05, 0.01)


def published(size, eps):
    """One disk by the published method, 10 steps."""
    if size == "standard":
        return Cell(CASE, settling(0.0025, box(1 / 32), 0.1), falls(0.1), velocities)
    options = settling(0.01, box(size), 0.1, **{"-scheme": "published", "-penalty": eps})
    return Cell(CASE, options, falls(0.1), velocities, ("standard", 0), 0.15, may_refuse=eps < 1e-13)  # below 1e-14/mu: refused


def across(number, dt):
    """One disk with so many elements across, in a box of 1 cm."""
    options = settling(dt, box(DIAMETER / number, 1.0), 0.1, **{"-x": 0.5, "-y": 0.53})
    return Cell(CASE, options, falls(0.1), velocities, (32, 0.0005), 0.05)


@lru_cache(maxsize=None)
def crowd(percent, side=2.0, radius=0.125, seed=3):
    """Rows for Disks: centres of equal disks that fill so much of the box."""
    number = max(2, round(percent / 100 * side**2 / (np.pi * radius**2)))
    filled = np.pi * number / (side / radius - 1) ** 2
    made = packing(number, "random", seed, radius=radius, filled=filled, spread=0.0)
    # the packing's own box is side wide up to rounding; its disks shrank until they only touch
    r = made.radius[0] * (1 - 1e-9)
    return np.column_stack([np.arange(number), made.x, np.full(number, r), np.full(number, 1.5), np.zeros((number, 3))])


def suspension(dt, percent):
    """Equal disks at rest, 1.5 times as dense as the fluid, that begin to fall."""
    rows = crowd(percent)
    first, rest = rows[0], rows[1:]
    options = settling(dt, box(0.0625), 0.1, **{"-x": float(first[1]), "-y": float(first[2]), "-diameter": 2 * float(first[3]),
                                                "-rhos": 1.5, "-particles": Disks(rest)})
    return Cell(CASE, options, falls(0.1), mean_fall, (0.0005, percent), 0.1, 0.1)


def sizes(dt, ratio):
    """A disk of 8 elements across and, touching it from below, up to eight that are so many times smaller."""
    big = 0.25
    r = big / ratio
    number = min(8, int(0.8 * (ratio + 1)))  # as many as find room on the arc
    angle = -np.pi / 2 + (np.linspace(-0.9, 0.9, number) if number > 1 else np.zeros(1))
    reach = (big + r) * (1 + 1e-9)
    x, y = 1 + reach * np.cos(angle), 1.2 + reach * np.sin(angle)
    rows = np.column_stack([np.arange(1, len(x) + 1), x, y, np.full(len(x), r), np.full(len(x), 1.5), np.zeros((len(x), 3))])
    options = settling(dt, box(0.0625), 0.1, **{"-y": 1.2, "-diameter": 2 * big, "-rhos": 1.5, "-particles": Disks(rows)})
    return Cell(CASE, options, falls(0.1), first_fall, (0.0005, ratio), 0.05, 0.1)


def gaps(gap, scene):
    """Two disks, or a disk and a wall, with a gap of so many radii between them."""
    r = DIAMETER / 2
    fine = isinstance(gap, str)  # the reference of "GAP with 0.0005 s"
    g = float(gap.split()[0]) if fine else gap
    dt, rows = (0.0005 if fine else 0.002), []
    place = {"-x": 1.0, "-y": 1.0, "-rhos": 1.5}
    if scene == "side by side":
        rows = [[1, 1.0 + r * (2 + g), 1.0, r, 1.5, 0, 0, 0]]
    elif scene == "one above the other":
        rows = [[1, 1.0, 1.0 + r * (2 + g), r, 2.5, 0, 0, 0]]
    elif scene == "above the floor":
        place["-y"] = r * (1 + g)
    elif scene == "beside a wall":
        place["-x"] = r * (1 + g)
    elif scene == "three, on the floor":
        place["-y"] = r * (1 + g)
        rows = [[k, 1.0, r * (1 + g) + k * r * (2 + g), r, 1.5, 0, 0, 0] for k in (1, 2)]
    if rows:
        place["-particles"] = Disks(np.array(rows))
    return Cell(CASE, settling(dt, box(0.0625), 0.06, **place), falls(0.06), velocities, (f"{g:g} with 0.0005 s", scene), 0.05,
        0.05)


PIPE, THROAT = Mesh(("pipe_obstacles", "--size", 0.016)), 0.1


def jam(dt, share):
    """Four equal disks, so many throats across, carried against the diaphragm."""
    diameter = share * THROAT
    within = {"x": (-0.01, 0.3)} if share > 1 else {}
    options = {"-mesh": PIPE, "-cfl": 0, "-dt": dt, "-number": 4, "-dmin": diameter, "-dmax": diameter, "-deviation": 0.01,
               "-first": 0.1, "-interval": 0.01, "-tend": 0.5, "-every": 0}
    checks = Checks({"particles.u": 40, "particles.v": 40, "fluid.top_speed": 1000}, 0.5, within=within)
    cell = Cell("cases/pipe_obstacles.edp", options, checks)
    if share > 1:
        cell.quantity, cell.reference, cell.tolerance = speed_left, "own", 0.01
    return cell


def speed_left(run):
    """Largest speed of a disk at the end, over that of the inflow (2 m/s)."""
    return np.array([np.abs(velocities(run)).max() / 2.0])


GAPS = [0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0]
RATIOS = [0.001, 0.01, 0.1, 0.5, 0.9, 1.01, 1.25, 2, 10, 100, 1000]
STEPS = [0.001, 0.002, 0.004, 0.008, 0.016, 0.032]
IN_TIME = "within {} % of the velocity with a time step of 0.0005 s on the same mesh"
MAPS = [
    Map("dt_density", "One disk: time step and density ratio", Axis("time step", "s", STEPS, [0.002, 0.016]),
        Axis("density ratio, disk to fluid", "", RATIOS, [0.001, 1.25, 1000]), density, IN_TIME.format(5),
        {"stable": SMALLER, "stopped": SMALLER, "blown up": SMALLER, "overlap": SMALLER}, (0.001, 1.25)),
    Map("penalty_mesh", "Published method: penalty and mesh", Axis("element size", "cm", [1 / 8, 1 / 12, 1 / 16, 1 / 24, 1 / 32],
        [1 / 8, 1 / 16],
        {1 / 8: "1/8", 1 / 12: "1/12", 1 / 16: "1/16", 1 / 24: "1/24", 1 / 32: "1/32", "standard": "standard"}),
        Axis("penalty eps", "cm s/g", [1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14], [1.0, 1e-6, 1e-14]), published,
        "velocity within 15 % of the standard scheme on the mesh of 1/32 cm",
        {"stable": "-penalty 1e-6 and " + FINER + "; or -scheme standard, which needs no penalty",
            "stopped": "-penalty 1e-6 (the least is 1e-14/viscosity), or -scheme standard",
         "blown up": "-scheme standard", "late": "-scheme standard"}, (1 / 16, 1e-6)),
    Map("elements_per_diameter", "One disk: elements per diameter", Axis("elements per diameter", "", [1, 1.5, 2, 3, 4, 6, 8, 12,
        16, 24, 32], [1, 2, 4, 8]),
        Axis("time step", "s", [0.001, 0.002, 0.004, 0.008], [0.002]), across,
        "velocity within 5 % of that with 32 elements per diameter and a time step of 0.0005 s",
        {"stable": FINER, "stopped": SMALLER, "blown up": SMALLER}, (4, 0.001)),
    Map("area_fraction", "Suspension: area fraction", Axis("time step", "s", STEPS, [0.002, 0.016]),
        Axis("area fraction", "%", [5, 10, 20, 30, 40, 50, 60, 70], [10, 40, 70]), suspension,
        "mean velocity of fall within 10 % of that with a time step of 0.0005 s on the same mesh",
        {"stable": SMALLER, "stopped": SMALLER, "overlap": SMALLER, "blown up": SMALLER}, (0.001, 20)),
    Map("size_ratio", "Particles of different size", Axis("time step", "s", STEPS, [0.002]),
        Axis("size ratio", "", [1, 2, 5, 10, 20, 50, 100], [1, 10, 100]), sizes,
        "velocity of the large disk within 5 % of that with a time step of 0.0005 s on the same mesh",
        {"stable": SMALLER, "stopped": FINER, "overlap": SMALLER, "blown up": FINER}, (0.001, 2)),
    Map("gap", "Gaps down to nothing", Axis("gap", "radii", GAPS, [1e-2, 1e-12, 0.0]),
        Axis("scene", "", ["side by side", "one above the other", "above the floor", "beside a wall", "three, on the floor"],
             ["one above the other", "above the floor"]), gaps,
        "velocities within 5 % of those with a quarter of the time step (0.0005 s)",
        {"stable": SMALLER, "stopped": SMALLER, "overlap": SMALLER, "blown up": SMALLER}, (0.1, "above the floor")),
    Map("jam", "Disks larger than the throat of the diaphragm", Axis("time step", "s", [0.001, 0.002, 0.004, 0.008], [0.004]),
        Axis("diameter / throat", "", [0.6, 0.9, 1.02, 1.2, 1.6], [1.2]), jam,
        "disks at rest: slower than 1 % of the inflow at the end (the flow past a throat that is shut means nothing); smaller "
            "disks have no reference",
        {"stable": "a longer -tend, or " + SMALLER, "stopped": "smaller particles: a throat that is shut lets no given inflow "
            "through", "overlap": SMALLER,
         "blown up": SMALLER, "late": SMALLER}, (0.002, 0.6)),
]
