"""How bodies are filled: by density, size, id or speed, and held ones told apart.

    look = Look(run, "speed")
    particle_artists(axes, particles, look=look.at(particles, time))

What of entries.csv a picture needs is read here too: density and free.
"""
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator

from tools.base.command import BadInput
from tools.plot.style import BODY, BODY_MAP, HELD

COLOURS = ("density", "size", "id", "speed")


def known(run, ids):
    """{"density": (n,), "free": (n,)} of particles by id, as far as entries.csv has these columns; nan for others than its ids."""
    if not run.has("entries"):
        return {}
    table = run.columns("entries", "id")
    found = {}
    for name in ("density", "free"):
        if name in table:
            of = dict(zip(table["id"].astype(int), table[name]))
            found[name] = np.array([of.get(int(one), np.nan) for one in ids], float)
    return found


def speed_at(run, ids, time):
    """Speeds (n,) of particles by id at a time, linear between the rows of particles.csv."""
    names = components(run)
    return np.sqrt(sum(np.array([np.interp(time, run.tracks[int(one)]["t"], run.tracks[int(one)][name]) for one in ids])**2
        for name in names)).reshape(-1)


def components(run):
    """Columns of the velocity in particles.csv: of spheres there are three."""
    names = ("u", "v", "w") if run.in_space else ("u", "v")
    run.columns("particles", *names)
    return names


class Look:
    """The filling of the bodies of a run, the same in all of its pictures.

    colour: one of COLOURS, None for neutral bodies. scale, label: of the colour bar, None without colour, and where all bodies have
    the same value, which the title then tells. held: True if a body is.
    Raises BadInput where the run does not tell the quantity.
    """

    def __init__(self, run, colour=None):
        self.run, self.colour, self.scale, self.label, self.same = run, colour, None, None, ""
        ids = np.array(list(run.tracks), int) if run.has("particles") and len(run.particles["t"]) else np.zeros(0, int)
        free = known(run, ids).get("free", np.ones(len(ids)))
        self.fixed = {int(one) for one, moves in zip(ids, free) if moves == 0}
        if colour is None or not len(ids):
            self.colour = None
            return
        length, second, mass = (run.units[kind] for kind in ("length", "time", "mass"))
        if colour == "speed":
            low, high = 0.0, float(np.sqrt(sum(run.particles[name]**2 for name in components(run))).max())
            self.label = f"speed of the bodies ({length}/{second})"
        else:
            values = self.constant(ids)
            values = values[np.isfinite(values)]
            if not len(values):
                raise BadInput(f"{run.folder}: no table of this run tells the density of its bodies")
            low, high = float(values.min()), float(values.max())
            size = "long axis" if run.has("shapes") else "diameter"
            self.label = {"density": f"density ({mass}/{length}$^3$)", "size": f"{size} ({length})", "id": "id of the body"}[colour]
        if high - low <= 1e-9 * abs(high):
            name, _, unit = self.label.partition(" (")
            self.same, self.label, self.colour = f"{name} {high:.4g} {unit.rstrip(')')}".strip(), None, None
        self.scale = Normalize(low, high)

    @property
    def held(self):
        """Whether a body of the run is held."""
        return bool(self.fixed)

    def constant(self, ids):
        """A quantity that a body keeps: density, size or id, (n,)."""
        if self.colour == "size":
            return np.array([2 * self.run.tracks[int(one)]["radius"][-1] for one in ids])
        if self.colour == "id":
            return np.asarray(ids, float)
        return known(self.run, ids).get("density", np.full(len(ids), np.nan))

    def at(self, particles, time):
        """(faces (n, 4) or (n,), held (n,) of bool) of particles (see RunFolder.particles_at) at a time."""
        ids = particles[0].astype(int)
        held = np.array([int(one) in self.fixed for one in ids], bool)
        if self.colour is None:
            return [HELD if one else BODY for one in held], held
        values = speed_at(self.run, ids, time) if self.colour == "speed" else self.constant(ids)
        return ScalarMappable(self.scale, BODY_MAP).to_rgba(np.ma.masked_invalid(values)), held

    def draw_bar(self, figure, bar):
        """The colour bar of the bodies on its axes; ids have whole numbers."""
        drawn = figure.colorbar(ScalarMappable(self.scale, BODY_MAP), cax=bar)
        drawn.set_label(self.label)
        if self.colour == "id":
            drawn.locator = MaxNLocator(integer=True)
            drawn.update_ticks()

    def words(self):
        """What a title says of the filling: that hatched bodies are held, where some are; a value that is that of all bodies."""
        said = [self.same] * bool(self.same) + ["hatched: held"] * self.held
        return f" ({', '.join(said)})" if said else ""
