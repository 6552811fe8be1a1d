"""The discrete element method: scenes of the suite's contacts in LIGGGHTS (soft spheres), started from a run of the suite.

    python -m tools.peers.with_liggghts RUN YOUNG OUT        RUN: a run of contacts alone; writes OUT/positions.csv (t,id,x,y)

Disks become spheres of the disks' masses that are kept in the plane (their velocity out of it is set to 0); walls become
triangles. Contacts are springs with dashpots (model hooke) with the friction of the run, if it has one (-friction; the same for disks
and walls; the spheres have 2/5 m r^2 instead of 1/2 m r^2) and its restitution (-restitution), at least 0.06, the least that the
model handles well: in the limit of stiff springs these are the inelastic contacts of the suite. YOUNG is the modulus of
the series that leads to it, Pa. A step is 1/STEPS of the time in which two of the lightest disks collide. The gravity and the
end time are those of RUN.
LIGGGHTS is a package of Debian (apt-get install liggghts); nothing but the benchmark needs it.
"""
import shutil
import sys
from pathlib import Path

import numpy as np

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import finished, run_command
from tools.base.tables import read_table, write_table

RESTITUTION, POISSON, VELOCITY, STEPS, SKIN = 0.06, 0.3, 2.0, 25, 0.6  # m/s, steps of a collision, mean radii
PIECE = 100  # longest triangle of a wall, heights
PROGRAM = "liggghts"
MISSING = "LIGGGHTS is not there (Debian: apt-get install liggghts): the discrete element method is left out"


def program():
    """The path of LIGGGHTS, None where it is not installed."""
    return shutil.which(PROGRAM)


def collision(young, radius, mass):
    """(stiffness, N/m; time of a collision, s) of two equal spheres by the model hooke of LIGGGHTS:
    k = 16/15 sqrt(R) Y (15 m V^2/(16 sqrt(R) Y))^(1/5) with R = radius/2, m = mass/2, Y = young/(2 (1 - nu^2)); pi sqrt(m/k)."""
    root, modulus, half = np.sqrt(radius / 2), young / (2 * (1 - POISSON**2)), mass / 2
    stiffness = 16 / 15 * root * modulus * (15 * half * VELOCITY**2 / (16 * root * modulus)) ** 0.2
    return stiffness, np.pi * np.sqrt(half / stiffness)


def start(run, at=None, kept=None):
    """(centres 2 x N in m, radii in m, walls M x 4 in m) of a row of a run of the suite: the first one, or the one closest to the
    time at. kept: the numbers of the walls (default: all)."""
    table = RunFolder(run).particles
    time = table["t"].min() if at is None else table["t"][np.abs(table["t"] - at).argmin()]
    first = table["t"] == time
    walls = read_table(Path(run) / "walls.csv")
    walls = np.column_stack([walls[name] for name in ("x1", "y1", "x2", "y2")])
    return np.array([table["x"][first], table["y"][first]]), table["radius"][first], walls if kept is None else walls[kept]


def data_text(centres, radius, masses, walls):
    """The file of the spheres, in a box round disks and walls; their densities give them the disks' masses (kg per metre of depth, as
    kg)."""
    density = masses / (4 / 3 * np.pi * radius**3)
    reach = 2 * radius.max()
    ends = np.concatenate([centres.T, walls.reshape(-1, 2)])
    low, high = ends.min(axis=0) - 4 * reach, ends.max(axis=0) + 4 * reach
    lines = ["disks", "", f"{len(radius)} atoms", "1 atom types", "", f"{low[0]:.9g} {high[0]:.9g} xlo xhi",
             f"{low[1]:.9g} {high[1]:.9g} ylo yhi", f"{-2 * reach:.9g} {2 * reach:.9g} zlo zhi", "", "Atoms", ""]
    return "\n".join([*lines, *(f"{k + 1} 1 {2 * r:.12g} {d:.12g} {x:.12g} {y:.12g} 0"
                                for k, (r, d, x, y) in enumerate(zip(radius, density, *centres)))]) + "\n"


def walls_text(walls, height):
    """The walls as an STL file of triangles from -height to height, in pieces of at most PIECE heights: LIGGGHTS stops without a
    word at slimmer ones."""
    lines, pieces = ["solid walls"], []
    for wall in np.asarray(walls, float):
        number = int(np.ceil(np.hypot(*(wall[2:] - wall[:2])) / (PIECE * height)))
        ends = np.linspace(wall[:2], wall[2:], max(number, 1) + 1)
        pieces += [np.concatenate(pair) for pair in zip(ends[:-1], ends[1:])]
    for a, b, c, d in pieces:
        corners = [(a, b, -height), (c, d, -height), (c, d, height), (a, b, height)]
        for some in ((0, 1, 2), (0, 2, 3)):
            lines += ["facet normal 0 0 0", "outer loop", *("vertex {:.12g} {:.12g} {:.12g}".format(*corners[k]) for k in some),
                      "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid walls"]) + "\n"


def script_text(young, step, steps, every, gravity, mean, friction=0.0, restitution=RESTITUTION):
    """The commands. step in s; every: steps between rows; gravity downwards in m/s2; mean: mean radius in m; the coefficients of
    friction and restitution."""
    both = "property/global"
    return "\n".join([
        "atom_style granular", "atom_modify map array", "boundary f f f", "newton off", "dimension 3", "units si",
        "soft_particles yes", "hard_particles yes", "communicate single vel yes", "read_data data", f"neighbor {SKIN * mean:.9g} bin", "neigh_modify delay 0",
        f"fix m1 all {both} youngsModulus peratomtype {young:.9g}", f"fix m2 all {both} poissonsRatio peratomtype {POISSON}",
        f"fix m3 all {both} coefficientRestitution peratomtypepair 1 {restitution:.9g}",
        f"fix m4 all {both} coefficientFriction peratomtypepair 1 {friction:.9g}",
        f"fix m5 all {both} characteristicVelocity scalar {VELOCITY}",
        "pair_style gran model hooke tangential history", "pair_coeff * *", f"timestep {step:.12g}",
        "fix wall all mesh/surface file walls.stl type 1 curvature 1e-5",
        "fix walls all wall/gran model hooke tangential history mesh n_meshes 1 meshes wall",
        f"fix weight all gravity {gravity:.9g} vector 0 -1 0", "fix flat all setforce NULL NULL 0.0", "fix move all nve/sphere",
        f"thermo {steps}", f"dump rows all custom {every} dump id x y", f"run {steps}"]) + "\n"


def read_dump(path, step):
    """(times in s, ids, centres T x N x 2 in m) of a dump file, disks in the order of their ids."""
    times, rows = [], []
    for block in path.read_text().split("ITEM: TIMESTEP\n")[1:]:
        lines = block.split("\n")
        number = int(lines[2])
        rows.append(np.array([line.split()[:3] for line in lines[8:8 + number]], float))
        times.append(int(lines[0]) * step)
    if not rows or len({len(some) for some in rows}) > 1:
        raise BadInput(f"{path.name} of LIGGGHTS has no rows, or disks were lost: take a smaller step")
    rows = np.array([some[np.argsort(some[:, 0])] for some in rows])
    if not np.isfinite(rows).all():
        raise BadInput(f"{path.name} of LIGGGHTS holds positions that are not finite")
    return np.array(times), rows[0, :, 0], rows[:, :, 1:]


def compute(run, young, folder, every=0.02, end=None, limit=None, steps=STEPS, at=None, kept=None):
    """(times, centres T x N x 2, masses N, Done) of LIGGGHTS from the first row of a run, or from rest at the time at with
    the walls kept.
    young in Pa; every: s between rows;
    end: end time in s (default: that of the run); limit: most seconds; steps of a collision. Raises BadInput with the reason where it does not run."""
    if not program():
        raise BadInput(MISSING)
    centres, radius, walls = start(run, at, kept)
    density, gravity, ending = (RunFolder(run).parameter(name, np.nan) for name in ("-density", "-gravity", "-tend"))
    end = end or ending
    if not np.isfinite(density + gravity + end) or young <= 0:
        raise BadInput(f"{run} is no run of contacts alone, or the modulus is not above 0")
    masses = np.pi * radius**2 * density
    step = min(collision(young, radius.min(), masses.min())[1] / steps, every)
    every = max(1, round(every / step))
    folder = Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "data").write_text(data_text(centres, radius, masses, walls))
    (folder / "walls.stl").write_text(walls_text(walls, 3 * radius.max()))
    (folder / "in").write_text(script_text(young, step, int(np.ceil(end / step)), every, gravity, radius.mean(),
        RunFolder(run).parameter("-friction", 0.0), max(RESTITUTION, RunFolder(run).parameter("-restitution", 0.0))))
    done = finished(run_command([program(), "-in", "in"], limit, folder))
    times, _, places = read_dump(folder / "dump", step)
    if len(places[0]) != len(radius):
        raise BadInput("LIGGGHTS lost disks")
    return times, places, masses, done


def main(words):
    """The command."""
    if len(words) != 3:
        print("error: usage: python -m tools.peers.with_liggghts RUN YOUNG OUT", file=sys.stderr)
        return 3
    try:
        times, places, _, done = compute(words[0], float(words[1]), words[2])
    except ValueError:
        print(f"error: the modulus {words[1]} is not a number", file=sys.stderr)
        return 3
    except BadInput as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 3
    rows = [[t, k, *place] for t, some in zip(times, places) for k, place in enumerate(some)]
    write_table(Path(words[2]) / "positions.csv", ["t", "id", "x", "y"], rows)
    print(f"{len(times)} rows of {len(places[0])} disks, {done.cpu_s:.3g} s of CPU")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
