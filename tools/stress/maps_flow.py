"""Stability maps of the flow: time step against Reynolds number, impulsive inflow, steady cases."""
import numpy as np

from tools.stress.cells import Axis, Cell, Map, Mesh
from tools.stress.classes import Checks

PIPE = Mesh(("pipe_obstacles", "--size", 0.016))  # 13 elements across the pipe, 10 across the throat
STEPS = [0.001, 0.002, 0.004, 0.008, 0.016, 0.032]
SMALLER = "a smaller -dt, or -cfl 1.5, the default, which chooses it"
# The parabola of 2 m/s passes a throat of half the pipe: 2.7 m/s on average, 4 at most.
FAST, LIVELY = 40.0, 5e3  # m/s; J/m


def last_quarter(run, column="kinetic_energy"):
    """Mean of a column of fluid.csv over the last quarter of the time."""
    t, values = run.fluid["t"], run.fluid[column]
    late = t >= 0.75 * t[-1] - 1e-12
    return np.array([values[late].mean()])


def jet(dt, reynolds):
    """The jet behind the diaphragm, no particles, 0.4 s; the inflow starts over 0.2 s."""
    options = {"-mesh": PIPE, "-cfl": 0, "-dt": dt, "-reynolds": reynolds, "-tend": 0.4, "-every": 0}
    checks = Checks({"fluid.top_speed": FAST, "fluid.kinetic_energy": LIVELY}, 0.4)
    return Cell("cases/pipe_jet.edp", options, checks, last_quarter, (STEPS[0] / 2, reynolds), 0.02)


def start(dt, ramp):
    """Three particles in the inlet from the first moment, the inflow starts within a ramp."""
    options = {"-mesh": PIPE, "-cfl": 0, "-dt": dt, "-ramp": ramp, "-tend": 0.24, "-number": 3, "-first": 0,
               "-deviation": 0.02, "-every": 0}
    checks = Checks({"fluid.top_speed": FAST, "fluid.kinetic_energy": LIVELY, "particles.u": 10, "particles.v": 10}, 0.24)
    return Cell("cases/pipe_obstacles.edp", options, checks, last_quarter, (STEPS[0] / 2, ramp), 0.02)


STEADY = {  # case: (option that carries the Reynolds number, its default, other options)
    "cavity": ("-reynolds", 1000, {}),
    "backward_step": ("-reynolds", 800, {}),
    "cylinder_steady": ("-mu", 0.001, {}),
    "sudden_expansion": ("-reynolds", 40, {"-search": 0}),
    "turbulent_channel": ("-retau", 5000, {"-cells": 12}),
    "turbulent_step": ("-reynolds", 44000, {"-size": 0.25, "-inlet": 5, "-outlet": 12, "-tolerance": 0.1}),
    "diaphragm_loss": ("-reynolds", 2e5, {"-cells": 6, "-outlet": 6, "-tolerance": 0.1}),
}


def steady(factor, case):
    """A steady case at its Reynolds number times a factor; accurate: the residual is as asked."""
    name, value, options = STEADY[case]
    options = {**options, name: value / factor if name == "-mu" else value * factor}
    return Cell(f"cases/{case}.edp", options, Checks({}, None), lambda run: np.array([run.results["residual"]]), "own",
                options.get("-tolerance", 1e-5), patience=3)


MAPS = [
    Map("dt_reynolds", "Flow through the diaphragm: time step and Reynolds number",
        Axis("time step", "s", STEPS, [0.002, 0.008, 0.032]),
        Axis("Reynolds number", "", [1, 10, 100, 1e3, 1e4, 1e5, 1e6], [10, 1e3, 1e5]),
        jet, "kinetic energy (mean of the last quarter) within 2 % of that with a time step of 0.0005 s on the same mesh",
        {"stable": SMALLER, "stopped": SMALLER, "blown up": SMALLER, "late": "fewer steps: a larger -dt"}, (0.002, 1e3)),
    Map("impulsive_start", "Impulsive inflow, three particles in the inlet",
        Axis("time step", "s", STEPS, [0.002, 0.008]),
        Axis("ramp of the inflow", "s", [1e-9, 0.001, 0.01, 0.05, 0.2], [1e-9, 0.2]),
        start, "kinetic energy (mean of the last quarter) within 2 % of that with a time step of 0.0005 s on the same mesh",
        {"stable": SMALLER, "stopped": "a longer -ramp, or " + SMALLER, "blown up": "a longer -ramp", "overlap": SMALLER},
            (0.002, 0.2)),
    Map("steady_reynolds", "Steady cases beyond their Reynolds number",
        Axis("Reynolds number / default", "", [0.5, 1, 2, 4], [1]),
        Axis("case", "", list(STEADY), ["cylinder_steady", "turbulent_channel"]),
        steady, "the residual is as small as asked for",
        {"stopped": "start from the flow at a lower Reynolds number, or a finer mesh; a steady flow need not exist or be stable",
         "late": "a coarser mesh first", "stable": "a larger -steps"}, (1, "cylinder_steady")),
]
