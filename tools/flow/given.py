"""What the readers of a flow return, and which of a file's arrays is what."""
import re
from dataclasses import dataclass, field

import numpy as np

from tools.base.command import BadInput

# Names of arrays and columns, in lower case and without units in brackets: of OpenFOAM, Fluent, CFD-Post, STAR-CCM+, ParaView and
# this project. Components come in threes, x, y and z.
PLACES = ("x", "y", "z"), ("x-coordinate", "y-coordinate", "z-coordinate"), ("points:0", "points:1", "points:2"), ("points_0",
    "points_1", "points_2")
VECTORS = "u", "velocity", "vel"
JOINTS, FIRST = (":", "_", "-", ".", " "), ("-", "_", " ", "")  # between a velocity and its component, or before it
SUFFIXES = {letters: [joint + "%s" for joint in JOINTS] + ["[%s]"] for letters in ("012", "xyz", "ijk")}
COMPONENTS = (("u", "v", "w"), ("ux", "uy", "uz"), ("vx", "vy", "vz"),
    *(tuple(f"{one}{joint}velocity" for one in "xyz") for joint in FIRST),
    *(tuple(f"{name}{joint}{one}" for one in "uvw") for name in ("velocity", "vel") for joint in JOINTS),
    *(tuple(name + form % one for one in letters) for name in (*VECTORS, "v") for letters, forms in SUFFIXES.items()
        for form in forms))
SCALARS = {"k": ("k", "turb-kinetic-energy", "turb_kinetic_energy", "turbulent_kinetic_energy", "turbulence kinetic energy", "tke"),
           "epsilon": ("epsilon", "turb-diss-rate", "turb_diss_rate", "turbulent_dissipation_rate", "turbulence eddy dissipation"),
           "omega": ("omega", "specific-diss-rate", "specific_diss_rate", "turbulence eddy frequency")}
ROLES = {"length": {name for some in PLACES for name in some},
    "velocity": {*VECTORS} | {name for some in COMPONENTS for name in some}, **{name: {*known} for name, known in SCALARS.items()}}
UNITS = {"length": ("m",), "velocity": ("m/s", "ms^-1", "ms-1"), "k": ("m^2/s^2", "m2/s2", "m^2s^-2", "m2s-2", "J/kg", "Jkg^-1"),
    "epsilon": ("m^2/s^3", "m2/s3", "m^2s^-3", "m2s-3", "W/kg", "Wkg^-1"), "omega": ("1/s", "s^-1", "s-1")}  # behind a name
# A unit is in brackets, unless these hold a component; in parentheses, where these hold a length or a quotient.
UNIT = re.compile(r"\s*(?:\[(?![ijkxyz\d]\])([^]]*)\]|\(\s*((?:m|cm|mm|um|µm|nm|km|in|inch|ft)|[^)]*(?:/|-?\d)[^)]*)\s*\))\s*$",
    re.IGNORECASE)
CMU = 0.09  # epsilon = CMU k omega
NEGATIVE_MOST = 0.01  # k or epsilon below 0, over its largest value: less is the rounding of another program, which becomes 0
THIRD_MOST = 1e-3  # third component of the velocity over the largest of the others: above it a flow is not plane


@dataclass
class Given:
    """A plane flow as read.

    points: (n, 2), m; polygons: the cells, a list of arrays of corners (any sense of rotation); times: s; frames: of each time a
    dict of arrays, u and v (m/s), and k (m2/s2), epsilon (m2/s3) where both are there, of length n (at points) or of the number of
    cells (in_cells). sides: {name of a patch: (k, 2) corners of its edges}; kinds: {name: "wall", "symmetry" or ""}; on_sides: of
    each time {name: {array: values at the middles of its edges}}, for the patches where they are given. unused: names of
    turbulent quantities of the files that it lacks.
    """
    points: np.ndarray
    polygons: list
    times: list
    frames: list
    in_cells: bool
    sides: dict = field(default_factory=dict)
    kinds: dict = field(default_factory=dict)
    on_sides: list = field(default_factory=list)
    unused: list = field(default_factory=list)


def plain(name):
    """The name of an array as in the lists above."""
    return UNIT.sub("", name.lower())


def unit_of(name):
    """The unit behind a name, without blanks ("ms^-1"); "" where there is none."""
    found = UNIT.search(name)
    return "".join((found[1] or found[2] or "").split()) if found else ""


def require_si(names, scaled, source):
    """Raises BadInput where a name of a column has a unit in brackets that is none of SI; scaled: lengths may have any."""
    for name in names:
        role = next((role for role, known in ROLES.items() if plain(name) in known), "")
        unit = unit_of(name)
        if unit and role and unit not in UNITS[role] and not (scaled and role == "length"):
            raise BadInput(f"{source}: the column {name} is not in {UNITS[role][0]}: write the table in SI units"
                + (", or give --scale" if role == "length" else ""))


def unused(*names):
    """The turbulent quantities among names of arrays, in lists of those at one place each, the velocities' first, that make no k
    and epsilon there."""
    kinds = [[kind for kind, known in SCALARS.items() if any(plain(one) in known for one in some)] for some in names]
    whole = "k" in kinds[0] and len(kinds[0]) > 1
    return [] if whole else sorted({kind for some in kinds for kind in some})


def components(names, axes):
    """(first, second, third) among (names of x, y, z) of a plane along axes."""
    return names[axes[0]], names[axes[1]], names[3 - sum(axes)]


def named(arrays, wanted, source, axes=(0, 1)):
    """{"u", "v"[, "k", "epsilon"]: values} of the arrays {name: (n,) or (n, components)} of a file.

    wanted: None, the name of a vector, or those of two components with a comma; axes: of the plane, by which components of vectors
    are in order already and those that have names of their own are chosen. Raises BadInput without velocities, for values that are
    not finite, for units that are none of SI, for k or epsilon below 0 and for a flow that is not plane.
    """
    low = {plain(name): np.asarray(values, float) for name, values in arrays.items()}
    there = ", ".join(arrays) or "none"
    names = [name.strip() if name.strip() in arrays else plain(name.strip()) for name in wanted.split(",")] if wanted else []
    low |= {name: np.asarray(arrays[name], float) for name in names if name in arrays}
    missing = [name for name in names if name not in low]
    if missing or len(names) > 2:
        raise BadInput(f"{source} has no velocity '{wanted}'; its arrays: {there}")
    require_si([name for name in arrays if name in names or plain(name) in names] if names else arrays, True, source)
    vector = names[0] if len(names) == 1 else next((name for name in VECTORS if name in low and low[name].ndim == 2), None)
    threes = [components(one, axes) for one in COMPONENTS]
    scalars = {name for name in low if low[name].ndim == 1}
    pair = tuple(names) if len(names) == 2 else next((one[:2] for one in threes if {*one[:2]} <= scalars), None)
    third = None
    if vector and len(names) < 2:
        if low[vector].ndim < 2 or low[vector].shape[1] < 2:
            raise BadInput(f"{source}: '{vector}' is no vector; give two arrays as --velocity U,V")
        u, v, third = low[vector][:, 0], low[vector][:, 1], low[vector][:, 2] if low[vector].shape[1] > 2 else None
    elif pair:
        u, v = low[pair[0]], low[pair[1]]
        if u.ndim > 1 or v.ndim > 1:
            raise BadInput(f"{source}: '{pair[0]}' or '{pair[1]}' is a vector; give one name, as --velocity {pair[0]}")
        third = next((low[one[2]] for one in threes if tuple(map(plain, pair)) == one[:2] and one[2] in scalars), None)
    else:
        raise BadInput(f"{source} has no velocities (as U, velocity, or u and v; --velocity NAME or --velocity U,V names "
            f"others); its arrays: {there}")
    found = {"u": u, "v": v}
    turbulent = {name: next((low[other] for other in others if other in low and low[other].ndim == 1), None)
        for name, others in SCALARS.items()}
    if turbulent["epsilon"] is None and turbulent["k"] is not None and turbulent["omega"] is not None:
        turbulent["epsilon"] = CMU * turbulent["k"] * turbulent["omega"]
    if turbulent["k"] is not None and turbulent["epsilon"] is not None:
        for name in ("k", "epsilon"):
            values = turbulent[name][np.isfinite(turbulent[name])]
            if values.min(initial=0) < -NEGATIVE_MOST * values.max(initial=0):
                raise BadInput(f"{source}: {name} is negative, down to {values.min():g}; it cannot be the "
                    + ("turbulent kinetic energy" if name == "k" else "rate of dissipation"))
        found |= {name: np.maximum(turbulent[name], 0) if np.isfinite(turbulent[name]).all() else turbulent[name]
            for name in ("k", "epsilon")}
    require_finite(found, source)
    if not names:
        require_one(low, threes, u, v, source)
    if third is not None and np.abs(third).max(initial=0) > THIRD_MOST * max(np.abs(u).max(), np.abs(v).max()):
        raise BadInput(f"{source}: the flow is 3-D, its third component reaches {np.abs(third).max():.3g} m/s; only plane flows "
            f"are taken")
    return found


def require_one(low, threes, u, v, source):
    """Raises BadInput where arrays {name in lower case: values} of another name for velocities have other ones than u and v;
    threes: names of components, those of the plane first."""
    several = [(name, low[name][:, 0], low[name][:, 1]) for name in VECTORS if name in low and low[name].ndim == 2
        and low[name].shape[1] > 1]
    several += [(",".join(one[:2]), low[one[0]], low[one[1]]) for one in threes if all(name in low and low[name].ndim == 1
        for name in one[:2])]
    for name, *other in several:
        same = [np.allclose(a, b, rtol=1e-6, atol=1e-6 * np.abs(a).max(initial=0), equal_nan=True)
            for a, b in zip((u, v), other)]
        if not all(same):
            raise BadInput(f"{source} has velocities that differ under {len(several)} names, "
                f"{' and '.join(name for name, *_ in several)}: --velocity says which")


def require_finite(arrays, source):
    """Raises BadInput where an array holds a value that is not finite."""
    for name, values in arrays.items():
        if bad := np.sum(~np.isfinite(values)):
            raise BadInput(f"{source}: {name} has {bad} values that are no finite numbers (nan or inf), the first in place "
                f"{np.flatnonzero(~np.isfinite(values))[0]}")


def chosen_times(times, text, source):
    """The places in `times` (s, ascending) that --times picks: "last" or None, "all", or FROM:TO. Raises BadInput."""
    if text in (None, "last"):
        return [len(times) - 1]
    if text == "all":
        return list(range(len(times)))
    try:
        low, high = (float(word) if word else end for word, end in zip(text.split(":"), (-np.inf, np.inf), strict=True))
    except ValueError:
        raise BadInput(f"--times of {source} is last, all or FROM:TO (s), not '{text}'") from None
    places = [k for k, time in enumerate(times) if low * (1 - 1e-9) - 1e-12 <= time <= high * (1 + 1e-9) + 1e-12]
    if not places:
        raise BadInput(f"{source} has no time from {low:g} to {high:g} s; it has {', '.join(f'{time:g}' for time in times)}")
    return places
