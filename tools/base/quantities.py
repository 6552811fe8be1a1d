"""Numbers to judge a run by: each is a function of the tables in the run folder.

A study selects them by name: --quantity mean_v, or with arguments mean_v:0.2:0.5; or by an expression on a table
(tools/base/expressions.py): particles.csv:y:last. --quantities FILE
adds those of a Python file: its public functions, whose first argument is the run
(tools.base.run_folder.RunFolder) and whose others are numbers with defaults, or strings where they are
annotated so (name: str). --help shows the first line of the docstring. A function that cannot
give its number raises ValueError with the reason.
"""
import importlib.util
import inspect
import itertools
import math
from pathlib import Path

import numpy as np

from tools.base import expressions
from tools.base.command import BadInput

# Windows of time in which the references of a case are given, s.
WINDOWS = {"settling_disk": (0.3, 0.4)}
DENSE = 0.1  # of the time of all rows: neighbours closer than this make a mean over any window
NO_FLUX = 1e-10  # of the top speed times the longer side of the domain: smaller fluxes are rounding
NOT_QUANTITIES = ("closed", "functions_of", "load", "usage", "summary", "parse", "evaluate")


def _window(run, start, end, times):
    """The window asked for, else the one of the case's references, else the last quarter."""
    if math.isnan(start) or math.isnan(end):
        usual = WINDOWS.get(run.case, (times[0] + 0.75 * (times[-1] - times[0]), times[-1]))
        start, end = (u if math.isnan(g) else g for g, u in zip((start, end), usual))
    slack = 1e-6 * max(abs(end), 1e-300)
    if not (start < end and math.isfinite(end - start)):
        raise ValueError(f"the window from {start:g} to {end:g} {'is empty' if start >= end else 'has no end'}")
    if times[0] > start + slack or times[-1] < end - slack:
        raise ValueError(f"the rows go from t = {times[0]:.6g} to {times[-1]:.6g}, not over {start:g} to {end:g}")
    return start, end


def _mean(run, times, values, start, end):
    """Mean over the window, of the straight lines between rows. Raises ValueError where one of these is longer than the window."""
    start, end = _window(run, start, end, times)
    inner = (times > start) & (times < end)
    longest = np.diff(times).max(where=(times[1:] > start) & (times[:-1] < end), initial=0.0)
    if longest > max(end - start, DENSE * (times[-1] - times[0])) * (1 + 1e-6):
        raise ValueError(f"only {np.count_nonzero((times >= start) & (times <= end))} rows in the window from {start:g} to "
            f"{end:g}, and they lie {longest:g} apart: write more rows, or ask for a longer window")
    t = np.concatenate([[start], times[inner], [end]])
    v = np.interp(t, times, values)
    return float(np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(t)) / (end - start))


def _track(run, particle):
    """The rows of one particle (by default that of the least id)."""
    tracks = run.tracks
    if not tracks:
        raise ValueError("particles.csv has no rows")
    one = min(tracks) if particle < 0 else particle
    if one not in tracks:
        raise ValueError(f"there is no particle {one:g}")
    return tracks[one]


def _of(track, name):
    """A column of the rows of a particle; of spheres in three dimensions others than of disks."""
    if name not in track:
        raise ValueError(f"particles.csv has no column {name}; it has {', '.join(track)}")
    return track[name]


def _column(run, name):
    """A column of fluid.csv and its times."""
    if name not in run.fluid or not len(run.fluid["t"]):
        raise ValueError(f"fluid.csv has no rows or no column {name}")
    return run.fluid["t"], run.fluid[name]


def mean_u(run, start=math.nan, end=math.nan, particle=-1):
    """Mean velocity u of a particle over a window (the case's, else the last quarter)."""
    track = _track(run, particle)
    return _mean(run, track["t"], _of(track, "u"), start, end)


def mean_v(run, start=math.nan, end=math.nan, particle=-1):
    """Mean velocity v of a particle over a window (the case's, else the last quarter)."""
    track = _track(run, particle)
    return _mean(run, track["t"], _of(track, "v"), start, end)


def mean_w(run, start=math.nan, end=math.nan, particle=-1):
    """Mean velocity w of a sphere over a window (the case's, else the last quarter), in three dimensions."""
    track = _track(run, particle)
    return _mean(run, track["t"], _of(track, "w"), start, end)


def mean_omega(run, start=math.nan, end=math.nan, particle=-1):
    """Mean angular velocity of a particle over a window (the case's, else the last quarter)."""
    track = _track(run, particle)
    return _mean(run, track["t"], _of(track, "omega"), start, end)


def noise_v(run, start=math.nan, end=math.nan, particle=-1):
    """Standard deviation of v about its parabola over a window, over the mean |v|.

    It is what the mesh adds as the particle crosses it."""
    track = _track(run, particle)
    start, end = _window(run, start, end, track["t"])
    inside = (track["t"] >= start - 1e-12) & (track["t"] <= end + 1e-12)
    t, v = track["t"][inside], track["v"][inside]
    if len(t) < 5:
        raise ValueError(f"only {len(t)} rows in the window")
    s = (t - t.mean()) / max(np.ptp(t), 1e-300)
    return float(np.std(v - np.polyval(np.polyfit(s, v, 2), s)) / max(abs(v).mean(), 1e-300))


def peak_speed(run, particle=-1):
    """Largest speed of a particle."""
    track = _track(run, particle)
    return float(np.linalg.norm([track[name] for name in ("u", "v", "w") if name in track], axis=0).max())


def final_x(run, particle=-1):
    """x of a particle at the end, or when it left."""
    return float(_track(run, particle)["x"][-1])


def final_y(run, particle=-1):
    """y of a particle at the end, or when it left."""
    return float(_track(run, particle)["y"][-1])


def final_z(run, particle=-1):
    """z of a sphere at the end, or when it left, in three dimensions."""
    return float(_of(_track(run, particle), "z")[-1])


def final_theta(run, particle=-1):
    """Angle of a particle at the end, or when it left, rad."""
    return float(_of(_track(run, particle), "theta")[-1])


def mean_kinetic_energy(run, start=math.nan, end=math.nan):
    """Mean kinetic energy of the fluid over a window."""
    return _mean(run, *_column(run, "kinetic_energy"), start, end)


def mean_pressure_drop(run, start=math.nan, end=math.nan):
    """Mean pressure drop over a window."""
    return _mean(run, *_column(run, "pressure_drop"), start, end)


def result(run, name: str):
    """A number of results.csv, where steady flows write theirs, by its name (result:drag_coefficient)."""
    if name not in run.results:
        raise ValueError(f"results.csv has no {name}; it has {', '.join(run.results)}")
    return run.results[name]


def mean_wall_fx(run, label=-1, start=math.nan, end=math.nan):
    """Mean force of the fluid along x on the walls of a label (default: all) over a window (-wallforces 1)."""
    table = run.table("wallforces")
    own = table["label"] == label if label >= 0 else table["t"] == table["t"]
    if not own.any():
        raise ValueError("wallforces.csv has no rows" + (f" of label {label:g}" if label >= 0 else ""))
    times, at = np.unique(table["t"][own], return_inverse=True)
    return _mean(run, times, np.bincount(at, table["fx"][own]), start, end)


def _force(run, name, start, end, particle):
    """Mean of a column of forces.csv for one particle, by default that of the least id (-forces 1)."""
    table = run.table("forces")
    if "id" not in table:
        raise ValueError("forces.csv is that of a flow without particles")
    if not len(table["id"]):
        raise ValueError("forces.csv has no rows")
    one = min(table["id"]) if particle < 0 else particle
    own = table["id"] == one
    if not own.any():
        raise ValueError(f"there is no particle {one:g}")
    return _mean(run, table["t"][own], table[name][own], start, end)


def mean_fx(run, start=math.nan, end=math.nan, particle=-1):
    """Mean force of the fluid along x on a particle over a window (-forces 1)."""
    return _force(run, "fx", start, end, particle)


def mean_fy(run, start=math.nan, end=math.nan, particle=-1):
    """Mean force of the fluid along y on a particle over a window (-forces 1)."""
    return _force(run, "fy", start, end, particle)


def mean_torque(run, start=math.nan, end=math.nan, particle=-1):
    """Mean torque of the fluid on a particle over a window (-forces 1)."""
    return _force(run, "torque", start, end, particle)


def mean_flux(run, label=2, start=math.nan, end=math.nan):
    """Mean flux out through the boundary of a label (default 2, outlet) over a window (-fluxes 1)."""
    table = run.table("fluxes")
    own = table["label"] == label
    if not own.any():
        raise ValueError(f"fluxes.csv has no rows of label {label:g}")
    return _mean(run, table["t"][own], table["flux"][own], start, end)


def closed(run, most):
    """Whether the largest flux is none but rounding."""
    if most == 0 or "top_speed" not in run.fluid or run.mesh is None:
        return most == 0
    return most < NO_FLUX * run.fluid["top_speed"].max() * max(run.extent[len(run.extent) // 2:])


def flux_error(run):
    """Largest | |flux in| - |flux out| | over the largest flux (0: nothing flows in or out)."""
    _, inlet = _column(run, "flux_in")
    _, outlet = _column(run, "flux_out")
    most = max(abs(inlet).max(), abs(outlet).max())
    return float(abs(abs(inlet) - abs(outlet)).max() / most) if not closed(run, most) else 0.0


def worst_overlap(run):
    """Largest overlap of a body with another or a wall, over the smallest radius (of an ellipse the semi-major axis; 0: none)."""
    _, gap = _column(run, "worst_gap")
    radius = run.particles["radius"]
    if not len(radius):
        raise ValueError("particles.csv has no rows")
    return float(max(0.0, -gap.min()) / radius.min())


def functions_of(module):
    """{name: function} of the public functions a module defines, and not of those it imports."""
    return {name: one for name, one in vars(module).items()
            if inspect.isfunction(one) and not name.startswith("_")
            and one.__module__ == module.__name__ and name not in NOT_QUANTITIES}


def load(extra=()):
    """The quantities of this module and of the files named in `extra`, which come first."""
    import tools.base.quantities as here
    known = functions_of(here)
    for k, path in enumerate(extra):
        if not Path(path).is_file():
            raise BadInput(f"there is no file of quantities {path}")
        if Path(path).suffix != ".py":
            raise BadInput(f"the file of quantities {path} must be Python, its name ending with .py")
        spec = importlib.util.spec_from_file_location(f"own_quantities_{k}", path)
        try:
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        except Exception as problem:
            raise BadInput(f"the file of quantities {path} cannot be used: {type(problem).__name__}: {problem}") from None
        found = functions_of(module)
        if not found:
            raise BadInput(f"the file of quantities {path} defines no public function")
        known.update(found)
    return known


def usage(name, one):
    """How a quantity is asked for: its name and its arguments in their order."""
    return ":".join([name, *(word.upper() for word in list(inspect.signature(one).parameters)[1:])])


def summary(known):
    """One line per quantity, for --help: its name, its arguments in their order, and what it is."""
    return "\n".join(f"  {usage(name, one):<38}  {(inspect.getdoc(one) or '').splitlines()[0] if one.__doc__ else ''}"
                     for name, one in sorted(known.items()))


def parse(text, known):
    """'mean_v:0.2:0.5', or an expression of tools/base/expressions.py, as a function of the run."""
    if expressions.is_expression(text):
        return expressions.parse(text)
    name, *words = text.split(":")
    if name not in known:
        raise BadInput(f"there is no quantity {name}; known are {', '.join(sorted(known))}")
    signature = inspect.signature(known[name])
    kinds = [one.annotation in (str, "str") for one in list(signature.parameters.values())[1:]]
    try:
        values = [word if is_word else float(word) for word, is_word in itertools.zip_longest(words, kinds[:len(words)],
            fillvalue=False)]
        signature.bind(None, *values)
    except ValueError:
        raise BadInput(f"quantity '{text}' needs numbers after its name") from None
    except TypeError:
        raise BadInput(f"quantity '{text}' has too many or too few arguments: {usage(name, known[name])}") from None
    return lambda run: known[name](run, *values)


def evaluate(function, run):
    """(value, "") or (nan, reason)."""
    try:
        value = float(function(run))
    except Exception as problem:  # a user's function may raise anything: it becomes a reason
        return math.nan, " ".join(str(problem).split()) or type(problem).__name__
    return (value, "") if math.isfinite(value) else (math.nan, f"the quantity is {value}")
