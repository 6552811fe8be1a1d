"""Comparisons of runs with published or exact figures, for python -m tools.validate.

A module in this folder registers comparisons by a list VALIDATIONS of functions. Each
takes a Context and yields Rows as they come; it runs cases by context.run(...) and judges
with context.row(...). A run that fails, or a function that raises, becomes a row with its
reason. `make validate CASE=NAME` takes the name of a module or of a function.

    def falling(context):
        "One line on what is compared."
        run = context.run("cases/settling_disk.edp", {"-dt": 0.001}, mesh=("settling_disk", 0.0625))
        yield context.row("mean velocity", "who found it", -5.5073, quantities.mean_v(run.folder), rtol=0.005, cpu_s=run.cpu_s)

    VALIDATIONS = [falling]
"""
import importlib
import math
import pkgutil
import sys
from dataclasses import dataclass
from pathlib import Path

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import make_mesh, run_case
from tools.study.study import mesh_name


class Failed(Exception):
    """A run or a mesh that did not come about; the text is the reason, cpu_s what it cost."""

    def __init__(self, reason, cpu_s=math.nan):
        super().__init__(reason)
        self.cpu_s = cpu_s


@dataclass
class Row:
    """One line of the report. target and measured in the same unit, `allowed` in words;
    figure: a path, or None; reason: why there is no measurement, or a remark."""
    case: str
    quantity: str
    source: str
    target: float
    allowed: str
    measured: float
    passed: bool
    cpu_s: float = math.nan
    figure: str = None
    reason: str = ""


@dataclass
class Run:
    """A run that ended well: its tables and its cost."""
    folder: RunFolder
    cpu_s: float
    memory_mb: float


def judge(target, measured, rtol=None, atol=None, at_most=None, at_least=None, between=None):
    """(passed, what was allowed in words) of a measured number; not finite never passes."""
    if between is not None:
        within, allowed = between[0] <= measured <= between[1], f"{between[0]:g} to {between[1]:g}"
    elif at_most is not None:
        within, allowed = measured <= at_most, f"at most {at_most:g}"
    elif at_least is not None:
        within, allowed = measured >= at_least, f"at least {at_least:g}"
    elif atol is not None:
        within, allowed = abs(measured - target) <= atol, f"+- {atol:g}"
    elif rtol is not None:
        within, allowed = abs(measured - target) <= rtol * abs(target), f"+- {100 * rtol:g} %"
    else:
        raise ValueError("a row needs rtol, atol, at_most, at_least or between")
    return bool(within and math.isfinite(measured)), allowed


class Context:
    """What a comparison works with: the folder for its files, and ways to run and judge."""

    def __init__(self, case, out, limit=None, say=print):
        self.case, self.out, self.limit, self.say = case, Path(out), limit, say

    def mesh(self, recipe, size, *more):
        """The file of a mesh made by tools.mesh. Raises Failed."""
        try:
            return make_mesh([recipe, "--size", f"{size:.12g}", *more], self.out / "meshes" / mesh_name([recipe, *more], size),
                self.limit)
        except BadInput as problem:
            raise Failed(problem) from None

    def run(self, script, options, name, mesh=None):
        """Run a case into the folder runs/CASE/NAME; mesh: None, a file, or (recipe, size).
        Raises Failed with the reason if it does not end well."""
        options = dict(options)
        if isinstance(mesh, tuple):
            mesh = self.mesh(*mesh)
        if mesh is not None:
            options["-mesh"] = str(mesh)
        folder = self.out / "runs" / self.case / name
        self.say(f"{self.case}: running {name}")
        done = run_case(script, options, out=folder, limit=self.limit)
        if not done.ok:
            raise Failed(f"{name}: {done.reason}", done.cpu_s)
        try:
            return Run(RunFolder(folder), done.cpu_s, done.memory_mb)
        except BadInput as problem:
            raise Failed(f"{name}: {problem}", done.cpu_s) from None

    def row(self, quantity, source, target, measured, rtol=None, atol=None, at_most=None, at_least=None, between=None,
            cpu_s=math.nan, figure=None, reason=""):
        """A Row that passes within rtol |target|, within atol, on the right side of a bound, or between two.
        at_most, at_least and between are bounds in the unit of the quantity; target may then be nan."""
        passed, allowed = judge(target, measured, rtol, atol, at_most, at_least, between)
        return Row(self.case, quantity, source, float(target), allowed, float(measured), passed, cpu_s,
                   figure and str(figure), reason)

    def failed(self, quantity, source, target, problem):
        """A Row without a measurement; problem: what was raised."""
        text = " ".join(str(problem).split()) or type(problem).__name__
        return Row(self.case, quantity, source, float(target), "", math.nan, False, getattr(problem, "cpu_s", math.nan), None, text)

    def with_figure(self, rows, path):
        """The rows, each with the figure that shows them all."""
        for row in rows:
            row.figure = str(path)
            yield row

    def figure_path(self, name):
        """Where a figure of this case belongs."""
        path = self.out / "figures" / f"{self.case}_{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def discover(package=None):
    """{name: [functions]} of the modules in this folder, in order; a module is called NAME, or else as its file."""
    package = package or sys.modules[__name__]
    found = {}
    for info in sorted(pkgutil.iter_modules(package.__path__), key=lambda info: info.name):
        module = importlib.import_module(f"{package.__name__}.{info.name}")
        if hasattr(module, "VALIDATIONS"):
            found[getattr(module, "NAME", info.name)] = list(module.VALIDATIONS)
    return found
