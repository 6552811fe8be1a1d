"""A run as arrays: tables as pandas frames, bodies over time, fields over time, fields as pyvista grids.

Mixed into tools.base.run_folder.RunFolder. pandas and pyvista are not among the packages that make setup installs; what needs one
of them says so where it is not there.
"""
import importlib
from dataclasses import dataclass

import numpy as np

from tools.base.command import BadInput

SAME_TIME = 1e-12  # of the length of the run: rows this close are of one time


def package(name):
    """A package that not everybody has. Raises BadInput where it is not there."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise BadInput(f"this needs the package {name}: .venv/bin/python -m pip install {name}") from None


@dataclass
class Bodies:
    """The particles of a run over time. t: (T,) times; id: (N,) in rising order; columns: {name: (T, N)} of particles.csv, nan
    where a particle is not inside at that time. bodies.x is bodies.columns["x"]; units are those of the case."""
    t: np.ndarray
    id: np.ndarray
    columns: dict

    def __getattr__(self, name):
        columns = self.__dict__.get("columns", {})
        if name not in columns:
            raise AttributeError(f"particles.csv has no column {name}; it has {', '.join(columns)}")
        return columns[name]

    def of(self, one):
        """{name: (T,)} of the particle with this id. Raises BadInput where there is none."""
        k = np.flatnonzero(self.id == one)
        if not len(k):
            raise BadInput(f"there is no particle {one}")
        return {name: values[:, k[0]] for name, values in self.columns.items()}


class Arrays:
    """What RunFolder offers as arrays."""

    def frame(self, name):
        """NAME.csv as a pandas.DataFrame. Raises BadInput where the run has no such table, or pandas is not installed."""
        return package("pandas").DataFrame(self.table(name))

    @property
    def bodies(self):
        """particles.csv as Bodies: arrays of times by particles."""
        table = self.particles
        every = np.unique(table["t"])
        slack = SAME_TIME * (np.ptp(every) if len(every) else 0.0)
        times = every[np.r_[True, np.diff(every) > slack]] if len(every) else every
        ids = np.unique(table["id"]).astype(int)
        row = np.clip(np.searchsorted(times, table["t"] + slack, side="right") - 1, 0, None)
        column = np.searchsorted(ids, table["id"].astype(int))
        found = {}
        for name, values in table.items():
            if name not in ("t", "id", "step"):
                found[name] = np.full((len(times), len(ids)), np.nan)
                found[name][row, column] = values
        return Bodies(times, ids, found)

    def over_time(self, name):
        """(times (T,), values (T, n) or (T, n, 2), in three dimensions (T, n, 3)) of a nodal field, such as "pressure" or "velocity",
        at all times of the fields. Raises BadInput where the run has no fields, or none of that name, or where their meshes differ."""
        if not self.fields:
            self.field_file()
            raise BadInput(f"the fields of {self.folder} have no times: the flow is steady, field(0) reads it")
        values = []
        for k in range(len(self.fields)):
            _, found = self.field(k)
            if name not in found:
                raise BadInput(f"the fields of {self.folder} have no {name}; they have {', '.join(found)}")
            values.append(found[name])
        if len({one.shape for one in values}) > 1:
            raise BadInput(f"the fields of {self.folder} are on meshes that differ: read them one by one")
        return np.array([t for t, _ in self.fields]), np.array(values)

    def field_file(self, k=-1):
        """The path of the k-th field file; of a steady flow, and of point particles in a steady flow, there is one, without a time.
        Raises BadInput where there is none."""
        single = [self.folder / name for name in ("fields.vtu", "fields_0000000.vtu")]
        paths = [path for _, path in self.fields] or [path for path in single if path.is_file()][:1]
        number = len(paths)
        if not paths:
            raise BadInput(f"the run {self.folder} has no fields: the option -fields writes them, where the case has it")
        if not -number <= k < number:
            raise BadInput(f"the run {self.folder} has {number} field files, 0 to {number - 1}; there is no {k}")
        return paths[k]

    def grid(self, k=-1):
        """The k-th field file (the last by default) as a pyvista.UnstructuredGrid. Raises BadInput where there is none, or pyvista
        is not installed."""
        path = self.field_file(k)
        return package("pyvista").read(str(path))
