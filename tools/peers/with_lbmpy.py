"""Free disks and an ellipse with lbmpy: lattice Boltzmann, partially saturated cells.

    python -m tools.peers.with_lbmpy settling|fast|two|drift|ellipse LEVEL [FACTOR]

On the lattice of tools/peers/saturated_lattice.py, cells at the rim sampled 8 x 8. The momentum exchanged moves the disk, the fluid
inside which is accelerated with the last step's acceleration (of an ellipse its turning too).
  settling   cases/settling_disk.edp up to 0.4 s: mean velocity over 0.3 to 0.4 s, cm/s
  fast       the same with rho_s = 1.5 g/cm3, mu = 0.01 g/(cm s): largest Reynolds number, with rho_s
  two        cases/drafting_kissing_tumbling.edp up to 0.15 s, before the disks touch: heights, cm
  drift      cases/couette_disk.edp (period 1, lengths in the distance H of the plates, speeds in theirs): heights at t U/H = 10, 20
  ... 60
             and the largest distance of the path up to there from that of Feng et al. (1994)
  ellipse    cases/ellipse_in_shear.edp (rates in that of the shear): time of half a turn, angular velocity at t G = 1, 3 ... 9
A level is cells across the diameter (the minor axis of the ellipse) and the speed on the lattice that stands for that of the scene,
times FACTOR (1): the time step, and with it the compressibility and the relaxation time.
cpu_s is without the generation and compilation of the kernels, as it is without every package's
imports.
"""
import time

from tools.base.command import ROOT
from tools.peers.common import asked, report

import warnings
from dataclasses import dataclass

import numpy as np

from tools.peers.saturated_lattice import Lattice, finite, saturation, shares


@dataclass
class Scene:
    """Disks that start at rest: centres (cm), density over the fluid's, nu (cm2/s), a speed (cm/s), an end (s); the box (cm),
    gravity (cm/s2).

    shear: rate (1/s) of a flow between plates that move against each other, periodic along them; 0: a closed box.
    diameter: cm, of an ellipse the minor axis; aspect: major over minor axis, the major one upright at the start.
    """

    starts: tuple
    ratio: float
    nu: float
    speed: float
    end: float
    levels: tuple  # (cells across the diameter, speed on the lattice)
    size: tuple = (2.0, 6.0)
    gravity: float = 981.0
    shear: float = 0.0
    diameter: float = 0.25
    aspect: float = 1.0


SCENES = {"settling": Scene(((1.0, 4.0),), 1.25, 0.1, 5.6, 0.4, ((6, 0.04), (8, 0.04), (12, 0.04), (16, 0.04))),
          "fast": Scene(((1.0, 4.0),), 1.5, 0.01, 14.0, 0.35, ((16, 0.03), (24, 0.03), (32, 0.03), (48, 0.03))),
          "two": Scene(((1.0005, 4.5), (0.9995, 5.0)), 1.5, 0.01, 14.0, 0.1501, ((16, 0.03), (24, 0.03), (32, 0.03), (48, 0.03))),
          "drift": Scene(((0.5, 0.25),), 1.0, 1 / 40, 0.5, 60.0, ((8, 0.03), (12, 0.03), (16, 0.03), (24, 0.03)), size=(1.0, 1.0),
              gravity=0.0, shear=1.0),
          "ellipse": Scene(((1.0, 0.5),), 1.0, 0.04, 0.5, 10.0, ((8, 0.02), (12, 0.015), (16, 0.0125), (24, 0.01)),
              size=(2.0, 1.0), gravity=0.0, shear=1.0, diameter=0.1, aspect=2.0)}


def covered(rx, ry, major, minor, theta):
    """Share of each cell, centre at (rx, ry) from the body's, that the body covers; semi-axes in cells, angle of the major one."""

    def level(point):
        x, y = point[..., 0], point[..., 1]
        along, across = x * np.cos(theta) + y * np.sin(theta), y * np.cos(theta) - x * np.sin(theta)
        return np.hypot(along / major, across / minor)

    centres = np.stack([rx, ry], axis=-1)
    return shares(lambda point: level(point) < 1, centres, abs(level(centres) - 1) * minor < 1, 8)


class Disk:
    """A disk or ellipse on the lattice (cells, steps): it covers cells, and the momentum exchanged there moves it."""

    def __init__(self, start, cells, aspect, ratio, weight):
        self.minor, self.major, self.x, self.theta = cells / 2, aspect * cells / 2, np.array(start), np.pi / 2
        self.v, self.before, self.omega, self.omega_before = np.zeros(2), np.zeros(2), 0.0, 0.0
        self.fluid = np.pi * self.major * self.minor
        self.mass, self.weight = ratio * self.fluid, np.array([0.0, -(ratio - 1) * self.fluid * weight])
        self.inertia = self.mass * (self.major**2 + self.minor**2) / 4
        self.inner = self.inertia / ratio if aspect != 1 else 0.0  # of the fluid inside, where its turning counts
        self.reach, self.window = int(np.ceil(self.major)) + 2, None

    def lift_off(self, lattice):
        """Leaves the cells of the last step."""
        if self.window:
            lattice.solid[self.window] = 0
            lattice.velocity[self.window] = 0

    def cover(self, lattice, relaxation):
        """Sets the solid share and velocity of the cells round the centre (cell centres at whole numbers and a half)."""
        corner = np.floor(self.x).astype(int) - self.reach
        self.rx, self.ry = np.meshgrid(*(np.arange(c, c + 2 * self.reach + 1) + 0.5 - centre for c, centre in zip(corner, self.x)),
            indexing="ij")
        share = covered(self.rx, self.ry, self.major, self.minor, self.theta)
        self.own = share > 0
        along, across = (np.arange(c, c + 2 * self.reach + 1) for c in corner)
        self.window = np.ix_(along % lattice.shape[0] + lattice.ghosts, across + lattice.ghosts)
        lattice.solid[self.window] += saturation(share, relaxation)
        lattice.velocity[self.window + (0,)] += self.own * (self.v[0] - self.omega * self.ry)
        lattice.velocity[self.window + (1,)] += self.own * (self.v[1] + self.omega * self.rx)

    def move(self, lattice):
        """One step by the momentum exchanged in its own cells."""
        exchanged = lattice.force[self.window] * self.own[..., None]
        torque = (self.rx * exchanged[..., 1] - self.ry * exchanged[..., 0]).sum()
        last, self.before = self.v - self.before, self.v
        self.v = self.v + (exchanged.sum((0, 1)) + self.fluid * last + self.weight) / self.mass
        turned, self.omega_before = self.omega - self.omega_before, self.omega
        self.omega += (torque + self.inner * turned) / self.inertia
        self.x = self.x + 0.5 * (self.v + self.before)
        self.theta += 0.5 * (self.omega + self.omega_before)


def fall(scene, level, factor=1.0):
    """Times (n), centres and velocities (n, disks, 2) in s and cm, angles (n, disks), the number of cells and time.process_time()
    after compilation."""
    cells, speed = scene.levels[level]
    speed *= factor
    h = scene.diameter / cells
    dt = speed * h / scene.speed
    nx, ny = (round(side / h) for side in scene.size)
    relaxation = 3 * scene.nu * dt / h**2 + 0.5
    lattice = Lattice((nx, ny), 1 / relaxation, scene.shear * dt)
    begin = time.process_time()
    disks = [Disk(np.array(start) / h, cells, scene.aspect, scene.ratio, scene.gravity * dt**2 / h) for start in scene.starts]
    steps = round(scene.end / dt)
    x, v, angle = np.empty((steps, len(disks), 2)), np.empty((steps, len(disks), 2)), np.empty((steps, len(disks)))
    for step in range(steps):
        for disk in disks:
            disk.lift_off(lattice)
        for disk in disks:
            disk.cover(lattice, relaxation)
        lattice.step()
        for k, disk in enumerate(disks):
            disk.move(lattice)
            x[step, k], v[step, k], angle[step, k] = disk.x, disk.v, disk.theta
        finite(v[step])
    return (np.arange(steps) + 1) * dt, x * h, v * h / dt, angle, nx * ny, begin


def feng():
    """Times and heights of the published path."""
    lines = (ROOT / "tests" / "reference" / "shear_migration_feng1994.csv").read_text(encoding="utf-8").splitlines()
    return np.array([[float(word) for word in line.split(",")] for line in lines if line[0].isdigit()]).T


def found(name, t, x, v, angle):
    """The numbers of a scene."""
    if name == "settling":
        return {"mean_v": np.interp(np.linspace(0.3, SCENES[name].end, 1001), t, v[:, 0, 1]).mean()}
    if name == "fast":
        return {"reynolds_most": SCENES[name].ratio * np.hypot(*v[:, 0].T).max() * SCENES[name].diameter / SCENES[name].nu}
    if name == "drift":
        when, height = feng()
        off = abs(np.interp(when, t, x[:, 0, 1]) - height)[when <= SCENES[name].end + 0.1]
        return {f"y_{at}": np.interp(at, t, x[:, 0, 1]) for at in range(10, 61, 10)} | {"off_feng": off.max()}
    if name == "ellipse":
        rate = -np.gradient(angle[:, 0], t)
        return {"half_turn": np.interp(np.pi, np.pi / 2 - angle[:, 0], t)} | {f"omega_{at}": np.interp(at, t, rate)
            for at in range(1, 10, 2)}
    return {"leading_y": np.interp(0.15, t, x[:, 0, 1]), "trailing_y": np.interp(0.15, t, x[:, 1, 1])}


if __name__ == "__main__":
    problem, level, *factor = asked(dict.fromkeys(SCENES, 4), dict.fromkeys(SCENES, ["FACTOR of the speed on the lattice"]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        t, x, v, angle, cells, begin = fall(SCENES[problem], level, *factor)
    report(begin, 9 * cells, steps=len(t), **found(problem, t, x, v, angle))
