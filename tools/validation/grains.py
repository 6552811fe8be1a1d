"""Disks with friction, contacts alone: inclines, a thrown disk, a pyramid, a silo, heaps, collapses."""
import numpy as np

from tools.peers.collapse import column, extent
from tools.peers.event_driven import by_events

G, R = 9.81, 0.01
HEAP = {"-number": 200, "-dt": 0.002, "-friction-tol": 1e-3, "-tend": 2.2}
SCENE = """
include "lib/case.idp"
include "lib/contact/walls.idp"
optCase("grains", "a scene of tools/validation/grains.py");
optDefault("-friction-tol", "{tol}"); optDefault("-contact-tol", "1e-12");
real gravityX = 0, gravityY = -9.81;
macro caseParticles() {{ {bodies} }} // EOM
macro caseWalls() {{ {walls} }} // EOM
{more}
include "scripts/contacts.edp"
"""


def scene(context, name, bodies, walls, options, tol=1e-12, more=""):
    """Runs bodies and walls, lines of a case; returns the run."""
    script = context.out / f"{name}.edp"
    script.parent.mkdir(parents=True, exist_ok=True)
    script.write_text(SCENE.format(bodies="\n".join(bodies), walls="\n".join(walls), tol=tol, more=more))
    return context.run(script.resolve(), options, name)


def last(run):
    """The columns of the last rows of particles.csv."""
    rows = run.folder.columns("particles")
    at = rows["t"] == rows["t"].max()
    return {name: values[at] for name, values in rows.items()}


def inclines(context):
    """A disk on seven inclines rolls with 2/3 g sin a where tan a <= 3 mu, else slips with g (sin a - mu cos a); a thrown disk."""
    mu, angles = 0.3, np.radians([5, 16, 17.5, 30, 41.9, 42.1, 60])
    bodies, walls = [], []
    for k, a in enumerate(angles):
        c, s = float(np.cos(a)), float(np.sin(a))
        walls.append(f"contactWallSegment({k}, 0, {k + 0.9 * c!r}, {-0.9 * s!r});")
        bodies.append(f"bodyDisk({k + 0.1 * c + R * s!r}, {-0.1 * s + R * c!r}, {R}, 1000);")
    walls.append("contactWallSegment(10, 0, 12, 0);")
    bodies.append(f"bodyAdd(10.1, {R}, {R}, 1000, 1, 0, 0, 1);")
    run = scene(context, "inclines", bodies, walls, {"-friction": mu, "-dt": 0.001, "-tend": 0.2})
    end = last(run)
    found = (end["u"][:7] * np.cos(angles) - end["v"][:7] * np.sin(angles)) / 0.2
    exact = np.where(np.tan(angles) <= 3 * mu, 2 / 3 * G * np.sin(angles), G * (np.sin(angles) - mu * np.cos(angles)))
    yield context.row("disk on seven inclines: greatest error of the acceleration (m/s2)", "closed form", 0,
        np.abs(found - exact).max(), atol=1e-7, cpu_s=run.cpu_s)
    yield context.row("thrown disk: speed at which it rolls over that of the throw", "closed form", 2 / 3, end["u"][7], atol=1e-7)


def pyramids(context):
    """Three equal disks stand for mu >= 2 - sqrt 3 between them and (2 - sqrt 3)/3 on the floor."""
    disks, floors = 2 - np.sqrt(3), (2 - np.sqrt(3)) / 3
    bodies, walls = [], []
    for k, (between, floor) in enumerate([(1.01 * disks, 0.5), (0.99 * disks, 0.5), (0.5, 1.01 * floors), (0.5, 0.99 * floors)]):
        walls.append(f"contactWallRough(contactWallSegment({k}, 0, {k + 0.9}, 0), {float(floor)!r});")
        bodies += [f"bodyRough(bodyDisk({k + 0.3 + x * R!r}, {float(y * R)!r}, {R}, 1000), {float(between)!r});"
            for x, y in ((-1, 1), (1, 1), (0, 1 + np.sqrt(3)))]
    run = scene(context, "pyramids", bodies, walls, {"-friction": 1, "-dt": 0.001, "-tend": 0.05})
    sunk = 1 + np.sqrt(3) - last(run)["y"][2::3] / R
    yield context.row("pyramids of three with 1.01 of the friction they need: sinking (radii)", "closed form", 0,
        np.abs(sunk[[0, 2]]).max(), atol=1e-7, cpu_s=run.cpu_s)
    yield context.row("pyramids of three with 0.99 of it: sinking (radii)", "closed form", np.nan, sunk[[1, 3]].min(),
        at_least=1e-3)


def janssen(context):
    """A silo whose floor sinks slowly: the load of the floor saturates, W rho g/(2 mu K) (1 - exp(-2 mu K z/W)) for one K.

    The load varies by a fifth in time, and friction is only as good as its residual over g dt^2, what a body falls in a step: long
    steps, many of the solver, and a mean over 1.2 s."""
    mu, width, step, loads, weights, cpu = 0.5, 0.2, 0.004, [], [], 0
    for number in (100, 200, 300):
        rng = np.random.default_rng(number)
        across = 7
        bodies = [f"bodyDisk({float(0.0125 + 0.0275 * (k % across) + rng.uniform(0, 0.003))!r}, "
            f"{float(0.013 + 0.0265 * (k // across))!r}, {float(R * rng.uniform(0.85, 1.15))!r}, 1000);" for k in range(number)]
        walls = ["contactWallSegment(0, -1, 0, 3);", f"contactWallSegment({width}, -1, {width}, 3);",
            "contactWallRough(contactWallSegment(-1, 0, 1, 0), 0);", "contactWallVelocity(2, 0, -0.02);"]
        run = scene(context, f"janssen_{number}", bodies, walls, {"-friction": mu, "-dt": step, "-tend": 1.9, "-every": 0.02,
            "-friction-maxit": 30000}, tol=1e-5)
        contacts = run.folder.columns("contacts")
        floor = (contacts["j"] == -3) & (contacts["t"] > 0.7)
        times = len(np.unique(contacts["t"][contacts["t"] > 0.7]))
        loads.append(contacts["impulse"][floor].sum() / times / step)
        weights.append(1000 * np.pi * (last(run)["radius"]**2).sum() * G)
        cpu += run.cpu_s
    loads, weights = np.array(loads), np.array(weights)
    # load = far (1 - exp(-weight/far)): the first silo gives far, the others are to follow
    tries = np.geomspace(0.05, 5, 20000) * weights[0]
    far = tries[np.abs(tries * (1 - np.exp(-weights[0] / tries)) - loads[0]).argmin()]
    for k, number in ((1, 200), (2, 300)):
        yield context.row(f"silo of {number} disks: load of the floor (N/m), from that of 100 disks", "Janssen's law",
            far * (1 - np.exp(-weights[k] / far)), loads[k], rtol=0.1, cpu_s=cpu if k == 1 else np.nan)


def slope(run, radius=0.01):
    """Angle of repose in degrees: of the triangle with the mean height and mean distance from the middle of what lies on the
    base."""
    end = last(run)
    on = (end["y"] > 0.2 * radius) & (np.hypot(end["u"], end["v"]) < 0.05)
    x, y, mass = end["x"][on], end["y"][on], end["radius"][on]**2
    away = np.abs(x - np.average(x, weights=mass))
    return np.degrees(np.arctan(np.average(y, weights=mass) / np.average(away, weights=mass)))


def heap(context):
    """Angles of repose of three seeds rise with the coefficient of friction."""
    before, spent = np.nan, 0
    for mu in (0, 0.1, 0.3, 0.5, 0.8):
        angles = []
        for seed in (1, 2, 3):
            run = context.run("cases/heap.edp", {"-friction": mu, "-seed": seed, "-every": 0.2, **HEAP}, f"{mu}_{seed}")
            angles.append(slope(run))
            spent += run.cpu_s
        mean = np.mean(angles)
        if np.isfinite(before):
            yield context.row(f"angle of repose at a coefficient of {mu} (degrees), above that of the last one",
                "it rises with friction", before, mean, at_least=before, cpu_s=spent)
        before = mean


def runout(run, release):
    """(aspect ratio in the last row before the release, run-out over the half width) of a collapse: of the disks that hang together
    at the end."""
    rows, end = run.folder.columns("particles"), last(run)
    start = rows["t"] == rows["t"][rows["t"] < release + 1e-9].max()
    half, top = column(*(rows[name][start] for name in ("x", "y", "radius")))
    return top / half, extent(end["x"], end["y"], end["radius"]) / 2 / half - 1


def granular_collapse(context):
    """Run-out of a dry column over its aspect ratio, and a loose column without friction against hard disks by events."""
    words = {"-number": 2000, "-friction": 0.53, "-friction-wall": 0.466, "-restitution": 0.755, "-dt": 0.002, "-release": 0.56,
        "-tend": 2.5, "-every": 0.1, "-friction-tol": 1e-3, "-friction-maxit": 1500}  # of glass beads (the header of the case)
    for aspect in (0.5, 1, 2, 3.5, 5):
        run = context.run("cases/granular_collapse.edp", {"-aspect": aspect, **words}, f"{aspect}")
        ratio, far = runout(run, words["-release"])
        yield context.row(f"run-out over the half width, aspect ratio {ratio:.2f}", "Staron & Hinch 2005", 2.5 * ratio if ratio < 2
            else 3.25 * ratio**0.7, far, rtol=0.1, cpu_s=run.cpu_s)
    run = context.run("cases/granular_collapse.edp", {"-number": 150, "-release": 0, "-tend": 0.4, "-friction": 0,
        "-restitution": 0.5, "-every": 0.2}, "events")
    *_, (_, suite, exact, _) = by_events(run.folder.folder, 1e-5)
    yield context.row("mean distance of 150 loose disks without friction after 0.4 s, over the half width", "hard disks by events",
        exact, suite, rtol=0.03, cpu_s=run.cpu_s)


VALIDATIONS = [inclines, pyramids, janssen, heap, granular_collapse]
