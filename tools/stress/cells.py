"""What a stability map is made of: axes, cells, meshes and particles that a cell needs.

A Map builds a Cell (script, options, checks) from a pair of values. A cell's reference is
another cell of the same map, (x, y), in the grid or not, or an array of exact values.
"""
import hashlib
import re
import threading
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tools.base.command import ROOT
from tools.meshing.main import parser
from tools.meshing import CASES
from tools.meshing.medit import write
from tools.stress.awkward import spoiled
from tools.stress.classes import Checks
from tools.base.tables import write_text

MAKERS = [*ROOT.glob("tools/meshing/*.py"), ROOT / "tools/stress/awkward.py"]
MAKING = threading.Lock()  # gmsh serves one thread at a time


@dataclass
class Axis:
    """Name, unit and values of an axis; quick: the values of a quick run; words: how each
    value is written (default: as a number)."""
    name: str
    unit: str
    values: list
    quick: list
    words: dict = field(default_factory=dict)

    @property
    def label(self):
        """Name with the unit, for a figure."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def key(self, value):
        """A value in a file name."""
        return self.words.get(value, f"{value:g}" if isinstance(value, (int, float)) else str(value))

    def text(self, value):
        """A value as it is written in a figure and in a list: 1e5, 1e-9, 2000."""
        if value in self.words or isinstance(value, str):
            return self.key(value)
        text = f"{value:.0e}" if value >= 1e4 and float(f"{value:.0e}") == value else f"{value:g}"
        return re.sub(r"e([+-])0*", lambda found: "e" + found[1].strip("+"), text)


@dataclass
class Mesh:
    """A mesh by tools.mesh, its words; kind: plain or one of tools.stress.awkward."""
    words: tuple
    kind: str = "plain"

    @property
    def name(self):
        """A file name for it."""
        words = (f"{word:.6g}" if isinstance(word, float) else str(word) for word in (*self.words, self.kind))
        return re.sub(r"[^A-Za-z0-9_.]+", "-", "_".join(word.strip("-") for word in words)) + ".mesh"

    def make(self, folder):
        """Write it into the folder unless it is there and newer than what makes it; returns the path."""
        path = Path(folder) / self.name
        with MAKING:
            if not path.is_file() or path.stat().st_mtime < max(maker.stat().st_mtime for maker in MAKERS):
                words = [f"{word:.12g}" if isinstance(word, float) else str(word) for word in self.words]
                options = parser().parse_args([*words, "--out", "unused.mesh"])
                _, mesh = CASES[options.case][0].build(options)
                write(mesh if self.kind == "plain" else spoiled(mesh, self.kind), path)
        return path


@dataclass
class Disks:
    """Particles for -particles: rows of the columns, units of the case."""
    rows: np.ndarray
    columns: str = "id,x,y,radius,density,u,v,omega"

    def make(self, folder):
        """Write the CSV, named after its contents; returns the path."""
        text = self.columns + "\n"
        text += "".join(",".join([f"{row[0]:.0f}", *(f"{value:.17g}" for value in row[1:])]) + "\n" for row in self.rows)
        path = Path(folder) / f"disks_{hashlib.sha256(text.encode()).hexdigest()[:12]}.csv"
        with MAKING:  # cells that run side by side share it
            if not path.is_file():
                write_text(path, text)
        return path


@dataclass
class Cell:
    """One run: script, options (values may be a Mesh or Disks), the checks on its outputs.

    quantity(run) -> array, what its accuracy is judged by; reference: (x, y) of the cell
    it is held against, "own" (quantity is an error already), or None; tolerance and floor: the error is
    max |q - q_ref| / max(|q_ref|, floor), accurate up to the tolerance.
    """
    script: str
    options: dict
    checks: Checks
    quantity: object = None
    reference: object = None
    tolerance: float = 0.05
    floor: float = 0.0
    may_refuse: bool = False  # status 3 counts as a clean stop, not as a fault of the map
    patience: float = 1.0  # times the limit on CPU time
    memory_of: tuple = None  # (x, y) of the cell whose peak memory it may not exceed by a tenth


@dataclass
class Map:
    """A stability map. held: what "accurate" means, in words. default: (x, y), the case's own
    values or what lies nearest to them. remedies: {class: what to do}."""
    name: str
    title: str
    x: Axis
    y: Axis
    build: object
    held: str
    remedies: dict
    default: tuple = None
    quick: bool = True

    def pairs(self, quick=False):
        """The (x, y) of its cells, and those of the references they need."""
        xs, ys = (self.x.quick, self.y.quick) if quick else (self.x.values, self.y.values)
        grid = [(x, y) for y in ys for x in xs]
        needed = [self.build(x, y).reference for x, y in grid]
        return grid, [pair for pair in dict.fromkeys(n for n in needed if isinstance(n, tuple)) if pair not in grid]
