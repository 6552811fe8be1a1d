"""Stability maps of contacts with friction: coefficients, stacks, size ratio, many bodies; residual, overlap and energy."""
import numpy as np

from tools.stress.cells import Axis, Cell, Map
from tools.stress.maps_contacts import FALL, GRAVITY, RADIUS, balance_error, fall_bounds

COEFFICIENTS = [0, 0.1, 0.3, 0.5, 1, 2, 5, 10]
RISE, KEPT, LEFT = 1e-6, 1e-8, 1e-4  # energy in a step over its peak, momentum over its peak, residual of the law in mean radii
HELD = (f"energy rises by less than {RISE:g} of its peak in a step, momentum is kept to {KEPT:g}, the residual of Coulomb's law "
    f"is at most {LEFT:g} mean radii")
REMEDIES = {"stable": "a larger -friction-maxit, or a smaller -dt", "stopped": "a smaller -dt", "late": "a larger -friction-tol",
    "overlap": "a smaller -contact-overlap", "blown up": "a smaller -dt"}


def law_error(run):
    """Largest of: rise of the energy over RISE, momentum over KEPT, residual over LEFT; the table has a row for each step."""
    energy, momentum = balance_error(run)
    return np.array([energy / RISE, momentum / KEPT, run.table("motion")["residual"].max() / LEFT])


def falls(options, height, end, patience=1.0):
    """A cell of disks that fall, judged by law_error()."""
    words = {"-gravity": GRAVITY, "-tend": end, "-every": 0, **options}
    return Cell(FALL, words, fall_bounds(height, end), law_error, "own", 1.0, patience=patience)


def heap(mu, dt):
    """Fifty disks of sizes within a factor 3 fall on each other."""
    return falls({"-number": 50, "-rmin": RADIUS / 3, "-rmax": RADIUS, "-friction": mu, "-dt": dt}, 2.5, 0.8)


def stack(number, mu):
    """So many equal disks in a shaft little wider than one of them."""
    return falls({"-number": number, "-width": 0.14, "-rmin": RADIUS, "-rmax": RADIUS, "-friction": mu, "-dt": 0.005},
        0.03 * number + 0.5, 0.5)


def mixed(ratio, mu):
    """Fifty disks of sizes between the largest and one so many times smaller."""
    return falls({"-number": 50, "-rmin": RADIUS / ratio, "-rmax": RADIUS, "-friction": mu, "-dt": 0.002}, 2.5, 0.5)


def crowd(number, dt):
    """So many disks in a box as wide as their number asks for; the lowest rows have landed at the end."""
    return falls({"-number": number, "-width": 0.14 * number**0.5, "-friction": 0.5, "-dt": dt}, 2.0 * number**0.5, 0.48,
        patience=5)


MAPS = [
    Map("friction", "Coefficients of friction, contacts alone", Axis("coefficient", "", COEFFICIENTS, [0.5, 10]),
        Axis("time step", "s", [0.001, 0.004, 0.016], [0.016]), heap, HELD, REMEDIES, (0.5, 0.001)),
    Map("friction_stack", "Stacks of disks with friction, contacts alone", Axis("disks in the stack", "", [1, 5, 20, 50], [5]),
        Axis("coefficient", "", [0, 0.3, 1, 10], [1]), stack, HELD, REMEDIES, (20, 0.3)),
    Map("friction_size_ratio", "Disks of different size with friction, contacts alone", Axis("size ratio", "", [1, 3, 10, 30, 100],
        [100]), Axis("coefficient", "", [0.1, 0.5, 2], [0.5]), mixed, HELD, REMEDIES, (3, 0.5)),
    Map("friction_crowd", "Many disks with friction, contacts alone", Axis("disks", "", [50, 500, 5000], [50]),
        Axis("time step", "s", [0.002, 0.004, 0.016], [0.004]), crowd, HELD, REMEDIES, (500, 0.002)),
]
