"""A run folder, read: run.json, the CSVs, the fields with their times, and the mesh.

    run = RunFolder("results/settling_disk/default")
    run.info["parameters"], run.particles["y"], run.fluid["t"], run.field(k), run.mesh

Everything is read when first asked for. Errors: BadInput naming the file and what is
wrong. Units are those of the case; run.units gives their names. A run of spheres in three
dimensions (in_space) has a SpaceMesh and fields on tetrahedra (tools/base/space_mesh.py),
an extent (x0, y0, z0, width, depth, height), and particles_at gives (id, x, y, z, radius).
"""
import csv
import json
import re
import sys
import xml.etree.ElementTree as xml
from functools import cached_property
from pathlib import Path

import numpy as np

from tools.base.command import BadInput
from tools.base.mesh_files import OPEN, read_field, read_mesh
from tools.base.outlines import read_outlines
from tools.base.run_arrays import Arrays
from tools.base.space_mesh import dimension_of, read_space_field, read_space_mesh
from tools.base.tables import read_table

SI = {"length": "m", "time": "s", "mass": "kg"}
SYMBOLS = {"length": "L", "time": "T", "mass": "M"}  # of a case whose own parameters have no units
SMALLER = {"length": ("cm", "mm", "um", "nm", "km"), "time": ("ms", "us", "ns", "min"), "mass": ("g", "mg", "ug", "ng", "pg", "fg",
    "t")}
JOINT = {"Pa", "N", "J", "W"}  # units of SI that are made of the three
DRIVER = {"-tend", "-dt", "-every", "-fields", "-maxwall", "-penalty", "-cohesion", "-restitution-speed", "-coupling-width",
    "-depth"}  # options of drivers with units, whatever those of the case
NEEDED = {"particles": "t id x y theta radius", "fluid": "t", "contacts": "t i j", "shapes": "id major minor",
    "outlines": "id part closed x y radius", "steps": "t",
    "exits": "id t outlet",
          "motion": "step t kinetic_energy potential_energy worst_gap", "walls": "x1 y1 x2 y2", "wallmoves": "t wall x1 y1 x2 y2",
          "wall": "x side shear pressure", "zones": "side separation reattachment"}  # columns without which a table says nothing
IN_SPACE = {"particles": "t id x y z radius"}  # those of a run in three dimensions
KINDS = {"parameters": (dict, "an object in braces"), "units": (dict, "an object in braces"),
    "base_units": (dict, "an object in braces"), "labels": (dict, "an object in braces"), "sides": (dict, "an object in braces"),
    "period": (list, "two or three numbers in brackets"),
    "low": (list, "two or three numbers in brackets"), "open": (list, "labels in brackets")}


def own(path):
    """Adds a file that a tool has made to the list of a run's own files, which -overwrite 1 replaces, where it lies in a run;
    returns the path."""
    listed = Path(path).parent / ".files"
    if listed.is_file() and Path(path).name not in listed.read_text(encoding="utf-8").splitlines():
        with open(listed, "a", encoding="utf-8") as stream:
            stream.write(f"{Path(path).name}\n")
    return path


class RunFolder(Arrays):
    """What a run wrote, by name; as arrays and frames: tools/base/run_arrays.py."""
    names = "x", "y"  # of the coordinates along the axes of a picture

    def __init__(self, folder):
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise BadInput(f"there is no run folder {folder}")
        if not any((self.folder / name).is_file() for name in ("run.json", "particles.csv", "fluid.csv")):
            raise BadInput(f"{self.folder} is not a run folder: it has no run.json, particles.csv or fluid.csv")

    @cached_property
    def info(self):
        """run.json as a dict, empty if the run wrote none."""
        path = self.folder / "run.json"
        if not path.is_file():
            return {}
        try:
            info = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as problem:
            raise BadInput(f"cannot read {path}: {problem}") from None
        if not isinstance(info, dict):
            raise BadInput(f"{path} must hold one object in braces")
        for name, (kind, words) in KINDS.items():
            value = info.get(name)
            if value is not None and (not isinstance(value, kind) or kind is list and not all(type(one) in (int, float)
                for one in value) or name in ("period", "low")
                    and len(value) not in (2, 3)):
                raise BadInput(f'{path}: "{name}" must be {words}, not {json.dumps(value)[:60]}')
        return info

    @property
    def case(self):
        """The case's name, else the folder's."""
        return str(self.info.get("case") or self.folder.name)

    def parameter(self, name, standard):
        """An option of the run that is a number, `standard` where run.json does not name it."""
        there = self.info.get("parameters") or {}
        if name not in there and standard is None:
            return None
        given = there.get(name, standard)
        try:
            return float(given)
        except (TypeError, ValueError):
            raise BadInput(f"{self.folder / 'run.json'}: {name} must be a number, not {json.dumps(given)[:60]}") from None

    @property
    def status(self):
        """What run.json says of the run: finished, running, not converged, failed (4), ...; empty if it says nothing."""
        return str(self.info.get("status") or "")

    @property
    def alive(self):
        """False if run.json names a process of this machine that is not there any more."""
        number = self.info.get("pid")
        return not (Path("/proc/self").exists() and isinstance(number, int) and not Path(f"/proc/{number}").exists())

    @property
    def title(self):
        """The case's name as words, and how the run ended if it failed or did not converge."""
        return self.case.replace("_", " ") + (f" ({self.status})" if self.status.startswith(("failed", "not", "killed", "ended"))
            else "")

    def warn_unfinished(self):
        """One line on the error stream when the run has not come to its end."""
        if self.status not in ("", "finished"):
            how = f"ended as '{self.status}'"
            if self.status == "running":
                how = "is still running, or was cut off" if self.alive else "ended without a word (its process is gone)"
            print(f"warning: the run {self.folder} {how}: what it holds is not its end", file=sys.stderr)

    @cached_property
    def units(self):
        """Names of the units of length, time and mass: those that the case has declared (run.json: base_units), else those of which
        its own options (run.json: units) speak, where they speak of one. A kind of which they do not speak has the unit of SI if all
        others do, time that of the driver's options, and else a letter: L, T or M. So has a kind with several units, and all where
        no option has a unit but angles and lengths of the scene (radii, heights)."""
        if declared := self.info.get("base_units"):
            return {kind: str(declared.get(kind) or SYMBOLS[kind]) for kind in SI}
        own = [str(unit) for name, unit in (self.info.get("units") or {}).items() if name not in DRIVER
            and not name.startswith("-contact-")]
        words = set(re.findall("[A-Za-z]+", " ".join(own)))
        if not own:
            return SI
        named = {kind: [name for name in (SI[kind], *SMALLER[kind]) if name in words] for kind in SI}
        if words & JOINT:  # Pa s, N: of SI throughout
            named = {kind: named[kind] + [SI[kind]] * (SI[kind] not in named[kind]) for kind in SI}
        if not any(named.values()):
            return SYMBOLS
        usual = all(SI[kind] in names for kind, names in named.items() if names)
        standard = {kind: SI[kind] if usual or kind == "time" else SYMBOLS[kind] for kind in SI}
        return {kind: names[0] if len(names) == 1 else SYMBOLS[kind] if names else standard[kind] for kind, names in named.items()}

    @property
    def units_per_depth(self):
        """Names of the units of speed, pressure, and of force and energy per unit of depth; of the whole of these in three
        dimensions."""
        length, second, mass = (self.units[kind] for kind in ("length", "time", "mass"))
        si = (length, second, mass) == ("m", "s", "kg")
        if self.in_space:
            return {"speed": f"{length}/{second}", "pressure": "Pa" if si else f"{mass}/({length} {second}$^2$)",
                "force": "N" if si else f"{mass} {length}/{second}$^2$", "energy": "J" if si else
                f"{mass} {length}$^2$/{second}$^2$"}
        if si:
            return {"speed": "m/s", "pressure": "Pa", "force": "N/m", "energy": "J/m"}
        return {"speed": f"{length}/{second}", "pressure": f"{mass}/({length} {second}$^2$)",
                "force": f"{mass}/{second}$^2$", "energy": f"{mass} {length}/{second}$^2$"}

    @cached_property
    def period(self):
        """The period of the domain along x and y, in three dimensions also z, 0 for none."""
        return tuple(self.info.get("period") or (0.0,) * (3 if self.in_space else 2))

    @cached_property
    def low(self):
        """Where a period begins along x and y, in three dimensions also z."""
        return tuple(self.info.get("low") or self.extent[:len(self.extent) // 2])

    @cached_property
    def open(self):
        """Labels of the sides that are no walls: inlets, outlets, seams of a period. A run that says which of its sides are walls
        (run.json: labels), and of none that it is open, has none."""
        told = {"no slip", "wall"}.intersection(self.info.get("labels") or {})
        return tuple(self.info.get("open") or (() if told else OPEN))

    @cached_property
    def sides(self):
        """{label: name} of the sides that have names of the case's own or the mesh's."""
        return {int(label): str(name) for label, name in (self.info.get("sides") or {}).items()}

    @property
    def clip(self):
        """(x0, y0, width, height) beyond which no particle is drawn (seams, outlets): that of the mesh, None where there is
        none."""
        return self.extent if any(self.period) or self.mesh is not None else None

    def wrapped(self, x, axis):
        """Coordinates brought back into the period."""
        low, period = self.low[axis], self.period[axis]
        return low + np.mod(np.asarray(x) - low, period) if period > 0 else x

    def images(self, rows):
        """Rows (n, 6) of id, x, y, theta, radius, minor, or in three dimensions (n, 5) of id, x, y, z, radius: brought back into
        the period, with a copy over each seam that a particle crosses."""
        for axis, period in enumerate(self.period):
            if period > 0 and len(rows):
                rows[:, 1 + axis] = self.wrapped(rows[:, 1 + axis], axis)
                step = np.zeros(rows.shape[1])
                step[1 + axis] = period
                low, radius = rows[:, 1 + axis] - self.low[axis], rows[:, 4]
                rows = np.vstack([rows, rows[low < radius] + step, rows[low > period - radius] - step])
        return rows

    def has(self, name):
        """True if the run wrote NAME.csv."""
        return (self.folder / f"{name}.csv").is_file()

    def table(self, name, finite=False):
        """The columns of NAME.csv; finite: nan and inf are refused."""
        if not self.has(name):
            raise BadInput(f"the run {self.folder} has no {name}.csv")
        return read_table(self.folder / f"{name}.csv", finite, of_run=True)

    def columns(self, name, *needed):
        """The columns of NAME.csv to draw or to count: the needed ones (and those of NEEDED) are there, all values finite."""
        table = self.table(name, finite=True)
        always = (NEEDED | IN_SPACE if self.in_space else NEEDED).get(name, "")
        missing = [column for column in (*always.split(), *needed) if column not in table]
        if missing:
            raise BadInput(f"{self.folder / (name + '.csv')} has no column {missing[0]}")
        return table

    @cached_property
    def particles(self):
        """particles.csv: one row per particle inside and output time."""
        return self.columns("particles")

    @cached_property
    def _aspects(self):
        shapes = self.columns("shapes") if self.has("shapes") else {"id": [], "major": [], "minor": []}
        return {int(one): minor / major for one, major, minor in zip(shapes["id"], shapes["major"], shapes["minor"])}

    def aspect(self, one):
        """Minor over major axis of the particle with this id: 1 for a disk."""
        return self._aspects.get(int(one), 1.0)

    @cached_property
    def held(self):
        """Ids of the particles that do not move freely: fixed, moved as prescribed, or pinned; none where entries.csv does not say."""
        table = self.columns("entries", "id") if self.has("entries") else {}
        return {int(one) for one, free in zip(table["id"], table["free"]) if free < 0.5} if "free" in table else set()

    @cached_property
    def outlines(self):
        """{id: loops} of bodies of any shape in their own frames (tools/base/outlines.py); empty where the run has none."""
        return read_outlines(self.columns("outlines")) if self.has("outlines") else {}

    @cached_property
    def fluid(self):
        """fluid.csv: one row per output time."""
        return self.columns("fluid")

    @cached_property
    def contacts(self):
        """contacts.csv: one row per touching pair and output time."""
        return self.columns("contacts")

    @cached_property
    def results(self):
        """results.csv of a steady flow as {quantity: value}."""
        path = self.folder / "results.csv"
        if not path.is_file():
            raise BadInput(f"the run {self.folder} has no results.csv; steady flows write it")
        try:
            text = path.read_text(encoding="utf-8")
            if not text.endswith("\n"):
                raise ValueError("its last line has no end: the run was cut off while it wrote it, or writes it now")
            return {row["quantity"]: float(row["value"]) for row in csv.DictReader(text.splitlines())}
        except (OSError, ValueError, KeyError, TypeError) as problem:
            raise BadInput(f"cannot read {path}: {problem}") from None

    @cached_property
    def result_units(self):
        """{quantity: unit} of results.csv, empty where the run wrote none."""
        try:
            text = (self.folder / "results.csv").read_text(encoding="utf-8")
        except OSError:
            return {}
        return {row.get("quantity"): row.get("unit") or "" for row in csv.DictReader(text.splitlines())}

    @cached_property
    def walls(self):
        """walls.csv, the walls at the start, as segments (S, 2, 2); none if the run wrote none."""
        if not self.has("walls"):
            return np.zeros((0, 2, 2))
        table = self.columns("walls")
        return np.column_stack([table[c] for c in ("x1", "y1", "x2", "y2")]).reshape(-1, 2, 2)

    @property
    def turns(self):
        """Whether the angles of the particles mean anything: those of carried particles may all be 0."""
        return not self.has("steps") or bool(np.any(self.particles["theta"]))

    @cached_property
    def _mesh_file(self):
        """The file of the mesh, None if there is none."""
        path = self.folder / "mesh.mesh"
        if path.is_file():
            return path
        named = self.info.get("mesh")
        return Path(named) if named and Path(named).is_file() else None

    @cached_property
    def in_space(self):
        """Whether the run is one in three dimensions, by the head of its mesh; without a mesh, by that of particles.csv."""
        if self._mesh_file is None:
            table = self.folder / "particles.csv"
            return table.is_file() and ",z," in table.open(encoding="utf-8", errors="replace").readline()
        return dimension_of(self._mesh_file) == 3

    @cached_property
    def mesh(self):
        """The mesh of the run (see tools/base/mesh_files.py and space_mesh.py), None if the folder holds none."""
        if self._mesh_file is None:
            return None
        return read_space_mesh(self._mesh_file) if self.in_space else read_mesh(self._mesh_file)

    @cached_property
    def fields(self):
        """[(t, path)] of the field files in order of time: from fields.pvd, else the
        steps in the file names looked up in fluid.csv."""
        listed = self.folder / "fields.pvd"
        if listed.is_file():
            try:
                sets = xml.fromstring(listed.read_text(encoding="utf-8")).iter("DataSet")
                pairs = [(float(one.get("timestep")), self.folder / one.get("file")) for one in sets]
            except (OSError, ValueError, TypeError, xml.ParseError) as problem:
                raise BadInput(f"cannot read {listed}: {problem}") from None
            latest = {path: time for time, path in pairs if path.is_file()}  # a file listed twice: the later entry
            return sorted(((time, path) for path, time in latest.items()), key=lambda pair: pair[0])
        files = {}
        for path in self.folder.glob("fields_*.vtu"):
            step = path.stem.removeprefix("fields_")
            if step.isdigit():
                files[int(step)] = path
        if not files or not self.has("fluid") or "step" not in self.fluid:
            return []
        times = dict(zip(self.fluid["step"].astype(int), self.fluid["t"]))
        return [(float(times[step]), files[step]) for step in sorted(files) if step in times]

    @cached_property
    def frames(self):
        """[(t, number of the field file or None)]: the times that can be drawn. Without field
        files these are the output times of the particles."""
        if self.fields or not self.has("particles"):
            return [(t, k) for k, (t, _) in enumerate(self.fields)]
        return [(float(t), None) for t in np.unique(self.particles["t"])]

    def field(self, k):
        """The k-th field file as (mesh, {"velocity": (n, 2), "pressure": (n,)}); in three dimensions the velocity is (n, 3)."""
        return (read_space_field if self.in_space else read_field)(self.field_file(k))

    @cached_property
    def tracks(self):
        """{id: {column: array}} of particles.csv, each in order of time."""
        table = self.particles
        order = np.lexsort((table["t"], table["id"]))
        ids, first = np.unique(table["id"][order], return_index=True)
        parts = np.split(order, first[1:])
        tracks = {int(one): {name: column[rows] for name, column in table.items()} for one, rows in zip(ids, parts)}
        for name, period in zip("xyz", self.period if self.in_space else ()):
            for track in tracks.values() if period > 0 else ():
                track[name] = np.unwrap(track[name], period=period)
        return tracks

    def particles_at(self, time):
        """(id, x, y, theta, radius, minor) arrays of the particles inside at a time, linear in time
        between rows, and before the first row of the run this one for who was there from the start.
        In a periodic domain images() of them; a table that jumps over its seam gives the nearer row.
        In three dimensions (id, x, y, z, radius) of images()."""
        rows, begin = [], min((track["t"][0] for track in self.tracks.values()), default=0.0)
        if self.has("fluid") and len(self.fluid["t"]) and begin <= self.fluid["t"][0]:
            time = max(time, begin)
        slack = 1e-5 * abs(time)  # times in fields.pvd may have six digits
        shown = ("x", "y", "z", "radius") if self.in_space else ("x", "y", "theta", "radius")
        widths = self.extent[2:] if self.mesh is not None else (np.inf, np.inf)
        for one, track in self.tracks.items():
            times = track["t"]
            if not times[0] - slack <= time <= times[-1] + slack:
                continue
            k = int(np.clip(np.searchsorted(times, time), 1, max(1, len(times) - 1)))
            if len(times) == 1:
                low = high = 0
                share = 0.0
            else:
                low, high = k - 1, k
                share = float(np.clip((time - times[low]) / max(times[high] - times[low], 1e-300), 0, 1))
            if not (self.in_space or any(self.period)) and any(abs(track[c][high] - track[c][low]) > 0.5 * w
                    for c, w in zip("xy", widths)):
                share = round(share)
            rows.append([one] + [(1 - share) * track[c][low] + share * track[c][high] for c in shown]
                + ([] if self.in_space else [track["radius"][0] * self.aspect(one)]))
        if self.in_space:
            return self.images(np.array(rows, dtype=float).reshape(-1, 5)).T
        return self.images(np.array(rows, dtype=float).reshape(-1, 6)).T

    @cached_property
    def extent(self):
        """(x0, y0, width, height) of the mesh, else of the particles' tracks; (x0, y0, z0, width, depth, height) in three
        dimensions."""
        if self.mesh is not None:
            points = self.mesh.points
        else:
            table = self.particles
            r = table["radius"].max() if len(table["radius"]) else 1.0
            points = np.column_stack([np.r_[table["x"] - r, table["x"] + r], np.r_[table["y"] - r, table["y"] + r]])
        if not len(points):
            raise BadInput(f"the run {self.folder} has neither a mesh nor particles to draw")
        low, high = points.min(axis=0), points.max(axis=0)
        return (*low, *(high - low))


