"""Stability maps of awkward meshes, of long runs, and of the cases around their defaults."""
import numpy as np

from tools.stress.awkward import KINDS
from tools.stress.cells import Axis, Cell, Disks, Map, Mesh
from tools.stress.classes import Checks
from tools.stress.maps_contacts import DISCHARGE, fall_error, glass_error
from tools.stress.maps_flow import last_quarter
from tools.stress.maps_particles import CASE, falls, settling, velocities

SQUARE = ("periodic_box", "--size", 1 / 32)
CHANNEL = ("channel", "--size", 1 / 8)


def awkward(kind, scene):
    """A scene on a mesh of a kind."""
    if scene == "moving vortices":
        options = {"-mesh": Mesh(SQUARE, kind), "-dt": 0.01, "-tend": 0.2}
        return Cell("cases/taylor_green.edp", options, Checks({"fluid.top_speed": 6, "errors.velocity": 1}, 0.2),
                    lambda run: run.table("errors")["velocity"], "own", 0.01, may_refuse=kind == "clockwise")
    if scene == "Poiseuille flow":
        options = {"-mesh": Mesh(CHANNEL, kind), "-tend": 20, "-every": 1}
        return Cell("cases/poiseuille.edp", options, Checks({"fluid.top_speed": 3}, 20),
                    lambda run: run.table("errors")["velocity_x"], "own", 1e-9, may_refuse=kind == "clockwise")
    mesh = Mesh(("box", "--width", 2.0, "--height", 2.0, "--size", 0.0625), kind)
    more = {"-scheme": "published"} if scene == "disk, published" else {}
    dt = 0.01 if more else 0.002
    return Cell(CASE, settling(dt, mesh, 0.1, **more), falls(0.1), velocities, ("plain", scene), 0.1,
        may_refuse=kind == "clockwise")


def drift(run):
    """Change of the energy between the third and the last quarter of the run, over its level;
    the largest error of the flux through the domain, over the flux."""
    name = "motion" if run.has("motion") else "fluid"
    table = run.table(name)
    t, energy = table["t"], table["kinetic_energy"] + table.get("potential_energy", 0)
    third, last = (t >= 0.5 * t[-1]) & (t < 0.75 * t[-1]), t >= 0.75 * t[-1]
    found = [abs(energy[last].mean() - energy[third].mean()) / max(abs(energy).max(), 1e-300)]
    if "flux_in" in table and abs(table["flux_in"]).max() > 0:
        found.append(abs(abs(table["flux_in"][last]) - abs(table["flux_out"][last])).max() / abs(table["flux_in"]).max())
    return np.array(found)


LONG = {
    "disk in shear": ("cases/couette_disk.edp", 0.02, {"-mesh": Mesh(("couette", "--size", 1 / 10)), "-radius": 0.2, "-y": 0.5},
                      Checks({"particles.u": 2, "particles.v": 1, "particles.omega": 5, "fluid.top_speed": 1}, period=(1.0, 0.0))),
    "disk at rest on the floor": (CASE, 0.002, {"-mesh": Mesh(("box", "--width", 1.0, "--height", 1.0, "--size", 1 / 10)),
        "-x": 0.5, "-y": 0.3,
                                                "-gravity": -100.0, "-diameter": 0.4},
                                                    Checks({"particles.u": 5, "particles.v": 5})),
    "flow in a channel": ("cases/poiseuille.edp", 0.02, {"-mesh": Mesh(("channel", "--size", 1 / 4)), "-tolerance": 1e-9},
        Checks({"fluid.top_speed": 2})),
    "heap, contacts alone": ("cases/falling_particles.edp", 0.01, {"-number": 20, "-gravity": 9.81},
        Checks({"particles.v": 20, "particles.u": 20})),
}


def long_run(steps, scene):
    """A small scene over so many steps; the rows of at most 1000 of them are kept."""
    script, dt, options, checks = LONG[scene]
    end = dt * steps
    options = {**options, "-dt": dt, "-tend": end, "-every": max(dt, end / 1000)}
    held = Checks(checks.bounds, end, period=checks.period)
    return Cell(script, options, held, drift, "own", 1e-3, patience=max(1, steps / 1e4), memory_of=(1000, scene))


def turning(run):
    """Angular velocity of particle 0 at the end."""
    return np.array([run.tracks[0]["omega"][-1]])


# Each case that marches in time: (options, default time step, end, bounds, period, quantity).
FLOW = "fluid.top_speed"
CASES = {
    "cylinder_channel": ({}, 0.003, 0.3, {FLOW: 15}, last_quarter),
    "taylor_green": ({}, 0.01, 0.2, {FLOW: 6, "errors.velocity": 1}, last_quarter),
    "poiseuille": ({}, 0.02, 2.0, {FLOW: 3}, last_quarter),
    "pipe_jet": ({}, 0.002, 0.3, {FLOW: 40}, last_quarter),
    "pipe_obstacles": ({"-first": 0.02}, 0.002, 0.2, {FLOW: 40, "particles.u": 10, "particles.v": 10}, last_quarter),
    "settling_disk": ({}, 0.00125, 0.1, {FLOW: 60, "particles.v": 60}, velocities),
    "settling_ellipses": ({"-number": 16}, 0.002, 0.3, {FLOW: 60, "particles.v": 60, "particles.omega": 200}, velocities),
    "drafting_kissing_tumbling": ({}, 0.0005, 0.03, {FLOW: 60, "particles.v": 60}, velocities),
    "couette_disk": ({}, 0.02, 2.0, {FLOW: 1, "particles.u": 1}, velocities),
    "sheared_suspension": ({}, 0.02, 0.4, {FLOW: 1.5, "particles.u": 1}, velocities),
    "segre_silberberg": ({}, 0.4, 40.0, {FLOW: 1, "particles.u": 1}, velocities),
    "ellipse_in_shear": ({}, 0.01, 1.0, {FLOW: 2, "particles.omega": 5}, turning),
    "rotating_cylinder": ({}, 0.001, 0.1, {FLOW: 1}, last_quarter),
    "oscillating_cylinder": ({}, 0.025, 2.5, {FLOW: 2}, last_quarter),
    "cylinder_array": ({}, 0.001, 0.1, {FLOW: 1}, last_quarter),
    "cylinder_between_plates": ({}, 0.0025, 0.1, {FLOW: 5}, last_quarter),
    "pipe_transport": ({"-model": "laminar", "-reynolds": 50}, 0.002, 0.2, {"particles.u": 6, "particles.v": 6}, velocities),
    "falling_particles": ({}, 0.02, 20.0, {"particles.v": 3}, fall_error),
    "hourglass": ({"-number": DISCHARGE[0.3][0], "-radius": 0.013, "-neck": 0.3}, 0.002, DISCHARGE[0.3][1], {"particles.v": 15},
        glass_error),
}
PERIODIC = {"couette_disk": (1.0, 0.0), "ellipse_in_shear": (2.0, 0.0), "segre_silberberg": (1.0, 0.0), "cylinder_array": (1.0,
    1.0), "sheared_suspension": (1.0, 0.0)}


def around_default(factor, case):
    """A case for a short time with its own options, but for the time step."""
    options, dt, end, bounds, quantity = CASES[case]
    options = {**options, "-dt": dt * factor, "-tend": end, "-every": 0}
    cell = Cell(f"cases/{case}.edp", options, Checks(bounds, end, 1e-4 if case == "hourglass" else 1e-6,
        PERIODIC.get(case, (0.0, 0.0))))
    if quantity in (fall_error, glass_error):
        cell.quantity, cell.reference, cell.tolerance = quantity, "own", 1.0
    else:
        cell.quantity, cell.reference, cell.tolerance, cell.floor = quantity, (0.5, case), 0.05, 1e-6
    return cell


# elements across, place of the centre within an element
ALONE = {"one disk": (6, 0.0), "disk of 4 elements": (4, 0.5), "disk of 3 elements": (3, 0.5)}


def viscous(reach, scene):
    """A shear flow without inertia whose time step is so many times h^2/nu: one disk in the middle, or many that touch."""
    size, end = 1 / 20, 2.0 if scene in ALONE else 10.0
    options = {"-mesh": Mesh(("couette", "--size", size)), "-radius": 0.15, "-convection": 0, "-cfl": 0, "-dt": reach * size**2,
        "-tend": end, "-every": 0}
    if scene in ALONE:
        across, place = ALONE[scene]
        options |= {"-fraction": 0, "-particles": Disks(np.array([[0, 0.5 + place * size, 0.5 + place * size, across * size / 2, 1,
            0, 0, 0]]))}
    else:
        options["-fraction"] = float(scene.split()[0]) / 100
    cell = Cell("cases/sheared_suspension.edp", options, Checks({"particles.u": 1.5, "particles.v": 1.5, "particles.omega": 5,
        "fluid.top_speed": 1.5}, end, period=(1.0, 0.0)))
    if scene in ALONE:
        cell.quantity, cell.reference, cell.tolerance = turning, (1, scene), 0.01
    return cell


def moved(reach, across):
    """A cylinder so many elements across, moved to and fro for eight periods by at most so many elements a step."""
    steps = 320
    end = steps * reach / across
    options = {"-mesh": Mesh(("oscillating_cylinder", "--size", 1 / across)), "-dt": reach / across, "-tend": end, "-kc": end / 8,
        "-every": 0}
    return Cell("cases/oscillating_cylinder.edp", options, Checks({"fluid.top_speed": 3}, end), drift, "own", 0.1)


MAPS = [
    Map("moved_body", "A held body moved for long", Axis("largest move a step (elements)", "", [0.1, 0.3, 1], [0.3]),
        Axis("elements per diameter", "", [4, 8, 12, 20], [8, 12]), moved, "energy over two periods within 10 % of that over the "
            "two before",
        {"stable": "more periods", "stopped": "a smaller -dt", "blown up": "a smaller -dt", "late": "a smaller -dt"}, (0.3, 12)),
    Map("viscous_step", "Slow flow: reach of viscosity in a step", Axis("nu dt/h^2", "", [1, 5, 20, 60], [20]),
        Axis("scene", "", [*ALONE, "10 %", "20 %", "30 %"], ["one disk", "30 %"]), viscous,
        "one disk: angular velocity within 1 % of that with nu dt = h^2; many: bounded, nothing overlaps (no reference)",
        {"stable": "a smaller -dt", "stopped": "a smaller -dt", "blown up": "a smaller -dt", "overlap": "a smaller -dt",
            "late": "a smaller -dt"}, (1, "one disk")),
    Map("awkward_meshes", "Awkward meshes", Axis("mesh", "", list(KINDS), ["plain", "clockwise", "slivers of 1 degree",
        "graded 100:1"]),
        Axis("scene", "", ["moving vortices", "Poiseuille flow", "settling disk", "disk, published"], ["moving vortices",
            "settling disk"]), awkward,
        "vortices: L2 error below 0.01 m/s; Poiseuille: below 1e-9; disk: velocity within 10 % of that on the plain mesh",
        {"stable": "a mesh by python -m tools.mesh, whose angles are above 5 degrees", "stopped": "a mesh by python -m tools.mesh",
         "blown up": "a mesh by python -m tools.mesh", "late": "a mesh by python -m tools.mesh"}, ("plain", "settling disk")),
    Map("long_run", "Long runs of small scenes", Axis("steps", "", [1000, 10000, 100000], [1000, 10000]),
        Axis("scene", "", list(LONG), ["disk in shear", "heap, contacts alone"]), long_run,
        "energy changes by less than 0.1 % between the third and the last quarter, inflow equals outflow to 0.1 %, memory within "
            "a tenth of that of 1000 steps",
        {"stable": "where it is not yet steady a longer -tend; where memory grows -contact-solver accelerated, or -checkpoint "
            "and -restart: each "
         "CHOLMOD factorisation of FreeFEM 4.9 keeps 1 kB and 9 bytes an unknown", "stopped": "a smaller -dt",
             "blown up": "a smaller -dt", "late": "-checkpoint and -restart"},
        (1000, "disk in shear")),
    Map("defaults", "The cases around their own time step", Axis("time step / default", "", [1, 2, 4, 8], [1, 2]),
        Axis("case", "", list(CASES), ["taylor_green", "couette_disk", "falling_particles"]), around_default,
        "kinetic energy or velocities within 5 % of those with half the default time step; contacts alone: time of half of the "
            "discharge, and height of what falls, within 4 % of those for dt -> 0, balances to 1e-8",
        {"stable": "the default -dt", "stopped": "the default -dt", "blown up": "the default -dt", "overlap": "the default -dt",
            "late": "the default -dt"},
        (1, "settling_disk")),
]
