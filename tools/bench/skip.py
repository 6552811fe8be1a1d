"""What a feature costs where it is not used: the scene, against a program without the feature.

Both run in trees of sources of their own (timed.py), one after the other, again and again; the
program without is the same sources with every statement that the feature guards cut out, or
another driver. Each pair of runs gives a difference; the first pair of the list is the same
program twice and shows what the machine itself does.
"""
import math
import statistics
from dataclasses import dataclass

import numpy as np

from tools.base.command import BadInput
from tools.base.timed import step_time, tree

JET, PIPE, DISK, SPHERES = "cases/pipe_jet.edp", "cases/pipe_obstacles.edp", "cases/settling_disk.edp", "tests/transport/scripts/bench.edp"
FLOW_FILES = ("scripts/flow.edp", "lib/scheme/velocity_step.idp", "lib/scheme/pressure_step.idp")
CARRIED_FILES = ("lib/transport/step.idp", "lib/transport/velocity.idp", "lib/transport/forces.idp")
STILL = {"-dt": 0.0005, "-every": 1000}
PIPE_STEP = {**STILL, "-cfl": 0, "-ramp": 0.01}
ALONE = {"-number": 5000, "-lift": 0, "-added-mass": 0, "-fluid-acceleration": 0, "-magnus": 0, "-turbulence": "off",
    "-drag": "brown-lawler", "-dt": 1e-5}


@dataclass
class Variant:
    """A script, its options, and what is cut out of which files."""
    script: str
    options: dict
    guards: tuple = ()
    calls: tuple = ()
    files: tuple = ()


@dataclass
class Feature:
    """A feature that the scene of `unused` does not use, and the program without it."""
    name: str
    about: str
    unused: Variant
    without: Variant
    steps: int = 50


JET_STILL, SETTLE = Variant(JET, {**PIPE_STEP, "-budget": 0}), Variant(DISK, STILL)
CARRIED = Variant(SPHERES, ALONE)
FEATURES = [
    Feature("none", "the same program twice", JET_STILL, JET_STILL),
    Feature("particles", "resolved.edp without a particle, against flow.edp", Variant(PIPE, {**PIPE_STEP, "-number": 0}),
        JET_STILL),
    Feature("contacts", "a disk far from the walls, against a program that never looks", SETTLE,
            Variant(DISK, STILL, calls=("motionContacts", "impactShare"), files=("scripts/resolved_standard.idp",))),
    Feature("contacts of carried spheres", "-contacts 0, against a program without them", CARRIED,
            Variant(SPHERES, ALONE, guards=("transportContacts",), files=("lib/transport/step.idp",)), 200),
    Feature("contacts of spheres far apart", "-contacts 1 where none can touch (used, not skipped), against -contacts 0",
        Variant(SPHERES, {**ALONE, "-contacts": 1, "-number": 200}),
            Variant(SPHERES, {**ALONE, "-number": 200}), 200),
    Feature("convection", "Stokes flow, against a program without convection", Variant(JET, {**PIPE_STEP, "-budget": 0,
        "-convection": 0}),
            Variant(JET, {**PIPE_STEP, "-budget": 0, "-convection": 0}, guards=("withConvection",), files=FLOW_FILES)),
    Feature("fields", "no fields asked for, against a program that cannot write any", JET_STILL,
            Variant(JET, JET_STILL.options, calls=("fieldsWrite",), files=("scripts/flow.edp",))),
    Feature("rotation", "spheres that do not turn, against a program without rotation", CARRIED,
            Variant(SPHERES, ALONE, guards=("forceMagnus",), files=CARRIED_FILES), 200),
    Feature("turbulence", "no fluctuations, against a program without them", CARRIED,
            Variant(SPHERES, ALONE, guards=("turbMode",), files=CARRIED_FILES), 200),
    Feature("transport forces", "drag and weight alone, against a program with no other force", CARRIED,
            Variant(SPHERES, ALONE, guards=("forceMagnus", "forceLift", "forceAddedMass", "forceSided", "bassetOn", "turbMode"),
                files=CARRIED_FILES), 200),
]


@dataclass
class Skipped:
    """What was found: seconds of a step (medians), difference in % (median over pairs) with its
    quartiles, number of pairs; note: why there is none."""
    name: str
    about: str
    used_s: float = math.nan
    without_s: float = math.nan
    percent: float = math.nan
    quartiles: tuple = (math.nan, math.nan)
    pairs: int = 0
    note: str = ""


def timing(variant, folder, steps, limit):
    """Seconds of a step of a variant in its tree."""
    dt = variant.options["-dt"]
    return step_time(folder, variant.script, {**variant.options, "-tend": dt * (steps + 2)}, folder / "run", limit)[0]


def compare(feature, out, pairs, shorter, limit, say=print):
    """A Skipped of `pairs` pairs of runs, in turn A B and B A; steps divided by `shorter`."""
    found = Skipped(feature.name, feature.about)
    steps = max(10, feature.steps // shorter)
    try:
        folders = [tree(out / "trees" / f"skip_{k}", one.script, steps, steps // 5, one.guards, one.calls, one.files)
                   for k, one in enumerate((feature.unused, feature.without))]
        times = [[], []]
        for pair in range(pairs):
            for k in ((0, 1), (1, 0))[pair % 2]:
                times[k].append(timing((feature.unused, feature.without)[k], folders[k], steps, limit))
    except BadInput as problem:
        found.note = str(problem)
        say(f"skip {feature.name}: {found.note}")
        return found
    differences = [100 * (a / b - 1) for a, b in zip(*times)]
    found.used_s, found.without_s = (statistics.median(some) for some in times)
    found.percent, found.pairs = statistics.median(differences), pairs
    found.quartiles = tuple(np.quantile(differences, (0.25, 0.75)))
    say(f"skip {feature.name}: {1e3 * found.used_s:.3f} ms a step, without {1e3 * found.without_s:.3f}, "
        f"{found.percent:+.2f} % ({found.quartiles[0]:+.2f} to {found.quartiles[1]:+.2f})")
    return found
