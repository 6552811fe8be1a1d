"""Pictures of a run of spheres in three dimensions: a plane through it, two projections of the paths, their time series.

SphereRun is the run as one plane shows it: an extent, a mesh and fields of two dimensions, so that tools/plot/resolved.py and
film.py draw it as they draw a plane run. The spheres that the plane cuts are filled circles; thin circles are those in front of
the plane (solid) and behind it (dashed). Where the domain ends in a plane of symmetry through a sphere, its mirror image is drawn
too.
"""
from functools import cached_property

import numpy as np
from matplotlib.collections import PatchCollection
from matplotlib.patches import Ellipse

from tools.base.command import BadInput
from tools.base.mesh_files import Mesh
from tools.base.run_folder import RunFolder
from tools.base.space_mesh import SNAP, Section
from tools.plot.captions import headline
from tools.plot.colour import Look
from tools.plot.in_time import broken
from tools.plot.style import BODY_EDGE, LINE_MAP, PAGE_WIDTH, clip_to, draw_outline, frame, particle_artists, plt, save, title

RIM = {"front": "-", "behind": (0, (3, 2))}  # dashes of the spheres that the plane does not cut
STILL = 1e-6  # of a radius: a sphere that moves less is fixed


def plane_of(text):
    """(axis, position) of a plane such as y=0.1. Raises BadInput."""
    name, _, number = text.replace(" ", "").partition("=")
    try:
        at = float(number)
    except ValueError:
        at = np.nan
    if name not in ("x", "y", "z") or not np.isfinite(at):
        raise BadInput(f"--plane needs x, y or z and a position, such as y=0.1, not '{text}'")
    return "xyz".index(name), at


class SphereRun(RunFolder):
    """A run in three dimensions as the plane x, y or z (axis 0, 1, 2) = at shows it; without a plane that of usual_plane()."""

    def __init__(self, folder, plane=None):
        super().__init__(folder)
        self.whole = RunFolder(folder)
        self.axis, self.at = plane or self.usual_plane()
        self.across = [k for k in range(3) if k != self.axis]
        self.names = tuple("xyz"[k] for k in self.across)

    def usual_plane(self):
        """The first plane that cuts a sphere at some time: the middle of y, a side of the domain normal to y (where that is a plane
        of symmetry), the same of x; else the middle of y."""
        low, size = np.array(self.whole.extent).reshape(2, 3)
        table = self.particles if self.has("particles") else {}
        for axis in (1, 0):
            for at in (middle(low[axis], size[axis]), low[axis], low[axis] + size[axis]):
                if len(table) and np.any(abs(self.whole.wrapped(table["xyz"[axis]], axis) - at) < table["radius"]):
                    return axis, float(at)
        return 1, middle(low[1], size[1])

    @property
    def title(self):
        """The case's name as words, and the plane."""
        return f"{self.whole.title}, {'xyz'[self.axis]} = {self.at:.4g}" + (f" {self.units['length']}" if self.at else "")

    @cached_property
    def mirrors(self):
        """{axis: position} of the sides of the domain that are no walls and in which the centre of a sphere stays: planes of
        symmetry."""
        low, size = np.array(self.whole.extent).reshape(2, 3)
        points, found = self.whole.mesh.points[self.whole.mesh.triangles], {}
        for axis in np.flatnonzero(np.array(self.whole.period) == 0):
            for at in (low[axis], low[axis] + size[axis]):
                labels = self.whole.mesh.labels[(abs(points[:, :, axis] - at) < SNAP * size.max()).all(axis=1)]
                if set(labels) <= set(self.open) and self.has("particles") and any((abs(track["xyz"[axis]] - at)
                        < SNAP * size.max()).all() for track in self.tracks.values()):
                    found[axis] = float(at)
        return found

    @cached_property
    def drawn(self):
        """The corner (3,) and the sides (3,) of the domain with its mirror images."""
        low, size = np.array(self.whole.extent).reshape(2, 3)
        for axis, at in self.mirrors.items():
            low[axis], size[axis] = min(low[axis], 2 * at - low[axis] - size[axis]), 2 * size[axis]
        return low, size

    @cached_property
    def extent(self):
        """(x0, y0, width, height) of what is drawn, in the coordinates of the plane."""
        low, size = self.drawn
        return (*low[self.across], *size[self.across])

    @cached_property
    def mesh(self):
        """The section of the mesh, with the sides of the domain."""
        return self.outline(self.axis, self.at)

    def outline(self, axis, at):
        """The section of the mesh by a plane, with its mirror images."""
        cut = Section(self.whole.mesh, axis, at)
        return self.mirrored(cut)[0]

    def mirrored(self, cut, values=None):
        """A Section's mesh and nodal values in it, with their mirror images."""
        mesh, values = cut.mesh, values or {}
        for k, axis in enumerate(cut.across):
            if axis in self.mirrors:
                mesh = reflected(mesh, k, self.mirrors[axis], SNAP * max(self.whole.extent[3:]))
                sign = np.where(np.arange(3) == axis, -1, 1)
                values = {name: np.concatenate([array, array * sign if array.ndim == 2 else array])
                    for name, array in values.items()}
        return mesh, values

    @cached_property
    def _cuts(self):
        return {}

    def field(self, k):
        """The k-th field in the plane: (Mesh, {"velocity": (n, 3), "pressure": (n,)})."""
        space, values = self.whole.field(k)
        key = hash(space.points.tobytes()), hash(space.tetrahedra.tobytes())
        if key not in self._cuts:
            self._cuts[key] = Section(space, self.axis, self.at)
        cut = self._cuts[key]
        return self.mirrored(cut, {name: cut.of(array) for name, array in values.items()})

    def spheres_at(self, time, across):
        """(id, x, y, z, radius) arrays of the spheres at a time, with their images in mirrors normal to the axes `across`."""
        rows = self.whole.particles_at(time)
        for axis in set(across) & set(self.mirrors):
            images = rows[:, abs(rows[1 + axis] - self.mirrors[axis]) > SNAP * rows[4]]
            images[1 + axis] = 2 * self.mirrors[axis] - images[1 + axis]
            rows = np.concatenate([rows, images], axis=1)
        return rows

    def draw_particles(self, axes, time, look=None):
        """The spheres at a time, filled as look (tools/plot/colour.py) says; returns the artists."""
        ids, *place, radius = self.spheres_at(time, self.across)
        x, y = (place[k] for k in self.across)
        ahead = (place[self.axis] - self.at) * (-1 if self.axis == 1 else 1)  # towards the viewer
        cut = abs(ahead) < radius
        inner = np.sqrt(np.maximum(radius**2 - ahead**2, 0))[cut]
        artists = particle_artists(axes, (ids[cut], x[cut], y[cut], 0 * inner, inner, inner), clip=self.clip, spokes=False,
            look=look and look.at((ids[cut],), time))
        outlined = ~cut
        outlined[cut] = inner < 0.98 * radius[cut]  # those that it cuts beside their middle too
        colour = "white" if self.fields else "#707070"  # over a field, over paper
        for side, dashes in RIM.items():
            these = outlined & ((ahead > 0) == (side == "front"))
            circles = PatchCollection([Ellipse((a, b), 2 * r, 2 * r) for a, b, r in zip(x[these], y[these], radius[these])],
                facecolor="none", edgecolor=colour, linewidth=0.7, linestyle=dashes, zorder=4.8 if side == "behind" else 5.2)
            artists.append(axes.add_collection(circles, autolim=False))
            clip_to(axes, circles, self.clip)
        return artists


def middle(low, size):
    """The middle of a side, to three digits of its length."""
    return round(float(low + 0.5 * size), 3 - int(np.floor(np.log10(size)))) + 0.0


def reflected(mesh, k, at, near):
    """A plane Mesh with its mirror image at the coordinate k = at, without the edges within `near` of the mirror."""
    image, number = mesh.points.copy(), len(mesh.points)
    image[:, k] = 2 * at - image[:, k]
    kept = (abs(mesh.points[mesh.edges][:, :, k] - at) > near).any(axis=1)
    edges = mesh.edges[kept]
    return Mesh(np.concatenate([mesh.points, image]), np.concatenate([mesh.triangles, number + mesh.triangles]),
        np.concatenate([edges, number + edges]), np.tile(mesh.labels[kept], 2))


def moved(track):
    """How far a sphere has come from its first row, in each direction (3,)."""
    return np.array([np.ptp(track[name]) for name in "xyz"])


def moves(track):
    """Whether a sphere moves."""
    return moved(track).max() > STILL * track["radius"][0]


def moving(run):
    """Whether a sphere of a run moves."""
    return any(map(moves, run.tracks.values()))


def track_panels(run):
    """Panels of the time series of a run: [(label, [(name, values, times)], log)]: the place along the longest side of the domain,
    the height, the speed and the angular speed of the spheres; none where no sphere moves."""
    if not run.has("particles") or not moving(run):
        return []
    tracks, length, second = run.tracks, run.units["length"], run.units["time"]
    size = np.array(run.whole.extent)[3:]
    far = np.max([moved(track) for track in tracks.values()], axis=0)
    along = int(np.argmax(size))
    names = [f"sphere {one}" for one in tracks]

    def panel(label, values):
        return label, [(name, values(track), track["t"]) for name, track in zip(names, tracks.values())], False
    wanted = []
    for k in sorted({along, 2} if far[along] > STILL * size[along] else {2}):
        wanted.append(panel(f"{'xyz'[k]} ({length})", lambda track, k=k: track["xyz"[k]]))
    wanted.append(panel(f"speed of the spheres\n({length}/{second})", lambda track: norm(track, "u", "v", "w")))
    spin = panel(f"angular speed\n(1/{second})", lambda track: norm(track, "omega_x", "omega_y", "omega_z"))
    return wanted + ([spin] if any(values.any() for _, values, _ in spin[1]) else [])


def tells(run, label, curves):
    """Whether a panel of fluid.csv that is not zero throughout says something of spheres: numbers only of several that change."""
    return label != "number" or len(run.tracks) > 1 and any(np.ptp(values) > 0 for _, values in curves)


def norm(track, *names):
    """The length of a vector by the names of its components, where the table has them."""
    return np.sqrt(sum(track[name]**2 for name in names if name in track) + 0 * track["t"])


def projections(extent):
    """The two pairs of axes to look at, both with the longest side of the domain: (horizontal, vertical) each."""
    along = int(np.argmax(np.array(extent)[3:]))
    return [(0, 2), (1, 2)] if along == 2 else [(along, 2), (along, 1 - along)]


def plot_trajectories(run, path):
    """Paths of the centres in two projections, a colour each, with the spheres that are there at the end; lines of the domain are
    those of its middle planes."""
    if not run.tracks:
        raise BadInput(f"{run.folder / 'particles.csv'} has no rows: no trajectory to draw")
    low, size = run.drawn
    pairs, length = projections(run.whole.extent), run.units["length"]
    figure, both = two_panels(pairs, size)
    last = max([track["t"][-1] for track in run.tracks.values()] + ([run.fluid["t"].max(initial=0)] if run.has("fluid") else []))
    number, look = len(run.tracks), Look(run)
    for axes, (a, b) in zip(both, pairs):
        axis = 3 - a - b
        extent = (low[a], low[b], size[a], size[b])
        inside = np.array(run.whole.extent)
        section = run.outline(axis, inside[axis] + 0.5 * inside[3 + axis])
        if a > b:
            section.points = section.points[:, ::-1]
        draw_outline(axes, section, run.open)
        order = sorted(run.tracks.values(), key=lambda track: track["xyz"[axis]][-1] * (1 if axis != 1 else -1))
        ids = list(run.tracks)
        for track in order:
            colour = LINE_MAP(ids.index(int(track["id"][0])) / max(number - 1, 1))
            flat = {"x": track["xyz"[a]], "y": track["xyz"[b]]}
            for piece in broken(flat, extent, (run.whole.period[a], run.whole.period[b])) if any(run.whole.period) else [
                    np.column_stack([*flat.values()])]:
                line, = axes.plot(*piece.T, color=colour, linewidth=1.1, alpha=0.9, zorder=3)
                clip_to(axes, line, extent)
            if track["t"][-1] >= last * (1 - 1e-9):
                end = np.array([[track[name][-1] for name in ("id", "x", "y", "z", "radius")]])
                for x, y, r in run.whole.images(end)[:, [1 + a, 1 + b, 4]]:
                    disk = Ellipse((x, y), 2 * r, 2 * r, facecolor=colour, edgecolor=BODY_EDGE, alpha=0.75, linewidth=0.6, zorder=5,
                        hatch="////" if int(track["id"][0]) in look.fixed else None)
                    axes.add_patch(disk)
                    clip_to(axes, disk, extent)
        frame(axes, extent, length, names=("xyz"[a], "xyz"[b]))
    free = sum(int(one) not in look.fixed or moves(track) for one, track in run.tracks.items())
    words = "path of one sphere" if free == 1 else f"paths of {free} spheres"
    headline(figure, title(run.whole, words + look.words(), figure.get_figwidth()))
    return save(figure, path)


def two_panels(pairs, size, left=0.62, right=0.2, bottom=0.52, top=0.46, gap=0.62):
    """(figure, [axes, axes]) for two projections to scale: beside each other where both have the same vertical axis, else one above
    the other. size: (3,), the sides of the domain."""
    beside = pairs[0][1] == pairs[1][1]
    sides = np.array([[size[a], size[b]] for a, b in pairs])
    total = np.array([sides[:, 0].sum(), sides[:, 1].max()]) if beside else np.array([sides[:, 0].max(), sides[:, 1].sum()])
    gaps = np.array([gap, 0] if beside else [0, gap])
    scale = min((np.array([PAGE_WIDTH, 6.6]) - [left + right, bottom + top] - gaps) / total)
    inches = np.maximum(scale * total + gaps + [left + right, bottom + top], [3.2, 1.5])
    figure, axes, corner = plt.figure(figsize=inches), [], np.array([left, inches[1] - top])
    for width, height in scale * sides:
        axes.append(figure.add_axes([*np.array([corner[0], corner[1] - height]) / inches, width / inches[0], height / inches[1]]))
        corner += [width + gap, 0] if beside else [0, -height - gap]
    return figure, axes
