"""Stability maps of contacts alone: stacks, size ratio, lattices, the discharge of an hourglass, disks larger than the neck."""
import numpy as np

from tools.base.command import BadInput
from tools.stress.cells import Axis, Cell, Map
from tools.stress.classes import Checks

FALL, GLASS = "cases/falling_particles.edp", "cases/hourglass.edp"
RADIUS, DENSITY, GRAVITY = 0.06, 100.0, 9.81  # m, kg/m2, m/s2
# Limits for dt -> 0, which docs/limits/contacts_alone.md measures. The time in which half of the disks pass the neck (m: s), means
# over seeds: {width of the neck: (disks, end time, limit)}.
DISCHARGE = {0.12: (500, 2.0, 1.34), 0.3: (300, 0.6, 0.353)}
# The way of the mean height of lattices of so many disks in 0.4 s, m, from steps of 0.0005 and 0.001 s.
LATTICE = {50: 0.437, 200: 0.164, 500: 0.104}
FALLEN = 0.3388  # mean height of the disks of falling_particles at 8 s over that at the start
NEAR = 0.04  # relative error of a discharge, and of the way of a lattice, that counts as accurate
METHODS = {"Newton finish, dt 0.001 s": ("newton", 0.001), "Newton finish, dt 0.01 s": ("newton", 0.01),
           "Newton finish, dt 0.05 s": ("newton", 0.05), "accelerated, dt 0.01 s": ("accelerated", 0.01),
               "plain Uzawa, dt 0.01 s": ("uzawa", 0.01)}


def fall_bounds(height, end):
    """No disk is faster than twice what a fall from the height gives it; times of `end` s."""
    speed = 2 * np.sqrt(2 * GRAVITY * height)
    return Checks({"particles.u": speed, "particles.v": speed}, end)


def weight_error(run, number, dt, radius=RADIUS):
    """|impulse of the floor / (dt weight of all disks) - 1| at the end."""
    table = run.contacts
    floor = (table["t"] == table["t"].max()) & (table["j"] == -1)
    weight = number * DENSITY * np.pi * radius**2 * GRAVITY
    return np.array([abs(table["impulse"][floor].sum() / (dt * weight) - 1)])


def stack(number, method):
    """So many equal disks in a shaft little wider than one of them fall on each other and rest."""
    solver, dt = METHODS[method]
    options = {"-number": number, "-width": 0.14, "-rmin": RADIUS, "-rmax": RADIUS, "-gravity": GRAVITY, "-dt": dt, "-tend": 2.5,
               "-every": 0.1, "-contact-solver": solver}
    return Cell(FALL, options, fall_bounds(0.03 * number + 0.5, 2.5), lambda run: weight_error(run, number, dt), "own", 1e-3)


def balance_error(run):
    """Largest of: rise of the energy in a step over the peak, error of the momentum over its
    peak, overlap over the smallest radius."""
    motion = run.table("motion")
    kinetic = motion["kinetic_energy"]
    energy = kinetic + motion["potential_energy"]
    momentum = np.hypot(motion["momentum_x"], motion["momentum_y"]).max()
    return np.array([max(np.diff(energy).max(), 0) / kinetic.max(), motion["momentum_error"].max() / momentum])


def mixed(ratio, dt):
    """Fifty disks of sizes between the largest and one so many times smaller fall on a plane."""
    options = {"-rmin": RADIUS / ratio, "-rmax": RADIUS, "-gravity": GRAVITY, "-dt": dt, "-tend": 1.0, "-every": dt}
    return Cell(FALL, options, fall_bounds(2.5, 1.0), balance_error, "own", 1e-8)


def neck(dt, share):
    """Sixty equal disks above a neck that is so many of their diameters wide."""
    options = {"-number": 60, "-radius": 0.02, "-spread": 0, "-neck": 0.04 * share, "-dt": dt, "-tend": 1.0, "-every": dt}
    # none may pass: the lowest place is that of a disk wedged in the cone
    checks = fall_bounds(1.5, 1.0)
    checks.deepest = 1e-4
    checks.within = {"y": (-0.001, 3.0)}
    return Cell(GLASS, options, checks, rest_error, "own", 1e-4)


def heights(run):
    """(times, T; heights of the disks, T x N) of a run."""
    table = run.particles
    times = np.unique(table["t"])
    return times, table["y"].reshape(len(times), -1)


def half_discharge(run):
    """Time in which half of the disks have passed the neck, at the height 0, s. Raises BadInput where fewer have."""
    times, y = heights(run)
    passed = (y < 0).sum(axis=1) / y.shape[1]
    if passed[-1] < 0.5:
        raise BadInput(f"{100 * passed[-1]:.0f} % of the disks have passed the neck at the end, not half of them")
    at = int(np.argmax(passed >= 0.5))
    return float(np.interp(0.5, passed[max(at - 1, 0):at + 1], times[max(at - 1, 0):at + 1]))


def discharge_error(run, limit):
    """Relative error of the time of half of the discharge, infinity where not half have passed by the end."""
    try:
        return np.array([abs(half_discharge(run) / limit - 1)])
    except BadInput:
        return np.array([1.0])


def discharge(dt, neck):
    """Disks of different size run through a neck; the time in which half of them have passed."""
    number, end, limit = DISCHARGE[neck]
    options = {"-number": number, "-radius": 0.013, "-neck": neck, "-dt": dt, "-tend": end, "-every": max(0.01, dt)}
    return Cell(GLASS, options, fall_bounds(2.5, end), lambda run: discharge_error(run, limit), "own", NEAR, patience=2)


def glass_error(run):
    """Largest of the errors of the balances over 1e-8 and of the discharge through the wide neck over NEAR."""
    return np.array([max(balance_error(run)[0] / 1e-8, discharge_error(run, DISCHARGE[0.3][2])[0] / NEAR)])


def fall_error(run):
    """Largest of the errors of the balances over 1e-8 and of the mean height (of the mass) at 8 s over NEAR."""
    times, y = heights(run)
    mass = run.particles["radius"][:y.shape[1]] ** 2
    mean = y @ mass / mass.sum()
    return np.array([max(balance_error(run)[0] / 1e-8, abs(np.interp(8, times, mean) / mean[0] / FALLEN - 1) / NEAR)])


def lattice_error(run, number):
    """Largest of the errors of the balances over 1e-6 (balance_error) and of the way of the mean height over NEAR."""
    _, y = heights(run)
    way = y[0].mean() - y[-1].mean()
    return np.array([max(balance_error(run)[0] / 1e-6, abs(way / LATTICE[number] - 1) / NEAR)])


def lattice(number, dt):
    """So many equal disks, a lattice whose contacts are redundant, start to run through the neck."""
    radius = 0.3 / number**0.5
    options = {"-number": number, "-radius": radius, "-spread": 0, "-neck": 8 * radius, "-dt": dt, "-tend": 0.4, "-every": dt}
    return Cell(GLASS, options, fall_bounds(2.0, 0.4), lambda run: lattice_error(run, number), "own", 1.0)


def rest_error(run):
    """Kinetic energy at the end over its peak."""
    kinetic = run.table("motion")["kinetic_energy"]
    return np.array([kinetic[-1] / kinetic.max()])


MAPS = [
    Map("stack", "Stacks of disks, contacts alone", Axis("disks in the stack", "", [1, 2, 5, 10, 20, 50, 100, 200], [1, 10, 20]),
        Axis("projection", "", list(METHODS), ["Newton finish, dt 0.01 s", "plain Uzawa, dt 0.01 s"]), stack,
        "the floor carries the weight of the stack within 0.1 % at 2.5 s",
        {"stable": "a longer -tend: not yet at rest", "stopped": "-contact-solver newton, the default",
            "late": "-contact-solver newton, the default",
         "overlap": "-contact-solver newton", "blown up": "a smaller -dt"}, (50, "Newton finish, dt 0.01 s")),
    Map("contact_size_ratio", "Disks of different size, contacts alone", Axis("size ratio", "", [1, 2, 5, 10, 20, 50, 100],
        [1, 10, 100]),
        Axis("time step", "s", [0.001, 0.005, 0.02, 0.05], [0.005]), mixed,
        "energy rises by less than 1e-8 of its peak in a step, momentum is kept to 1e-8",
        {"stable": "a smaller -contact-tol", "stopped": "-contact-tol 1e-10: equal disks form lattices with more contacts than "
            "needed", "late": "a larger -dt",
         "overlap": "a smaller -contact-overlap"}, (2, 0.02)),
    Map("lattice", "Equal disks as a lattice, contacts alone", Axis("disks", "", [50, 200, 500], [50]),
        Axis("time step", "s", [0.002, 0.004, 0.016], [0.002, 0.016]), lattice,
        f"the mean height at 0.4 s has moved as for dt -> 0 within {100 * NEAR:g} %; energy rises by less than 1e-6 of its peak in a "
        "step, momentum is kept to 1e-6",
        {"stable": "a smaller -dt", "overlap": "a smaller -contact-overlap", "stopped": "a -spread above 0",
            "late": "a -spread above 0"}, (200, 0.002)),
    Map("discharge", "Discharge of an hourglass, contacts alone", Axis("time step", "s", [0.001, 0.002, 0.004, 0.008, 0.016],
        [0.002, 0.016]), Axis("neck", "m", list(DISCHARGE), [0.3]), discharge,
        f"half of the disks of 0.013 m have passed at the time for dt -> 0 within {100 * NEAR:g} %",
        {"stable": "a smaller -dt", "overlap": "a smaller -contact-overlap", "late": "a larger -dt"}, (0.002, 0.12)),
    Map("neck", "Disks larger than the neck, contacts alone", Axis("time step", "s", [0.001, 0.002, 0.004, 0.016, 0.05], [0.002]),
        Axis("neck / diameter", "", [0.25, 0.5, 0.9, 0.99], [0.9]), neck,
        "at rest: kinetic energy below 1e-4 of its peak after 1 s",
        {"stable": "a longer -tend: not yet at rest", "overlap": "a smaller -dt", "stopped": "a larger -contact-maxit",
            "late": "a larger -dt"}, (0.002, 0.99)),
]
