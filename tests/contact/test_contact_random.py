"""Contacts of random scenes, many in one run: the conditions of the minimum, written apart from lib/; true gaps; mirrored, turned,
moving along, other velocities."""
import numpy as np
import pytest

from tests.tables import outline, rows

DT, TOL = 0.01, 1e-10
MANY = """
include "lib/contact/ellipse_project.idp"
optCase("many", "projections of scenes in a file");
string file = optFile("-scenes", "", "bodies and walls");
contactDeclare();
optEnd();
cout.precision(17);
int scenes = 0;
ifstream f(file);
f >> scenes;
for (int k = 0; k < scenes; ++k) {
    int n = 0, walls = 0, disks = 0;
    real period = 0, a = 0, b = 0, c = 0, d = 0, e = 0, g = 0;
    f >> n >> walls >> disks >> period;
    real[int] px(n), py(n), r(n), aspect(n), turn(n), mass(n), moment(n), u(n), v(n), w(n);
    int[int] id = 0:n - 1;
    for (int i = 0; i < n; ++i) f >> px[i] >> py[i] >> r[i] >> aspect[i] >> turn[i] >> mass[i] >> moment[i] >> u[i] >> v[i] >> w[i];
    contactWallsKeep(0);
    for (int i = 0; i < walls; ++i) { f >> a >> b >> c >> d >> e >> g; contactWallSegment(a, b, c, d); contactWallVelocity(i, e, g); }
    contactPeriodic(0, -50, period, 0);
    contactListRange = -1; contactMemory.resize(0);
    if (disks) contactProject(px, py, r, id, mass, u, v, DT);
    else contactEllipseProject(px, py, turn, r, aspect, id, mass, moment, u, v, w, DT);
    for (int i = 0; i < n; ++i) cout << "speed " << k << " " << u[i] << " " << v[i] << " " << w[i] << endl;
    for (int i = 0; i < contactN; ++i) if (contactImpulse[i] > 0) cout << "press " << k << " " << contactI[i] << " " << contactJ[i] << " " << contactImpulse[i] << endl;
}
""".replace("DT", str(DT))


class Bodies:
    """x (N, 2), r, aspect, turn, mass, moment (N), motion (N, 3); walls (S, 4) and their velocities (S, 2); period along x, 0:
    none."""

    def __init__(self, x, r, mass, motion, walls, drift=None, period=0.0, aspect=1.0, turn=0.0):
        self.x, self.r, self.mass, self.motion, self.walls, self.period = x, r, mass, motion, walls, period
        self.aspect, self.turn = np.broadcast_to(aspect, len(r)), np.broadcast_to(turn, len(r))
        self.drift = np.zeros((len(walls), 2)) if drift is None else drift
        self.moment = np.abs(mass) * r**2 * (1 + self.aspect**2) / 4
        self.free = mass > 0

    def text(self):
        lines = [f"{len(self.r)} {len(self.walls)} {int((self.aspect == 1).all())} {self.period:.17g}"]
        bodies = np.column_stack([self.x, self.r, self.aspect, self.turn, self.mass, self.moment, self.motion])
        lines += [" ".join(f"{value:.17g}" for value in row) for row in [*bodies, *np.hstack([self.walls, self.drift])]]
        return "\n".join(lines) + "\n"

    def image(self, way):
        """The scene mirrored about x = 0, turned by a right angle, or seen from one who goes along."""
        if way == "along":
            off, speed = np.array([0.37, -0.21]), np.array([0.4, 0.3])
            return Bodies(self.x + off, self.r, self.mass, self.motion + [*speed, 0], self.walls + np.tile(off, 2),
                self.drift + speed, self.period, self.aspect, self.turn)
        to = np.array([[-1, 0], [0, 1]]) if way == "mirrored" else np.array([[0, -1], [1, 0]])
        hand = round(np.linalg.det(to))
        x, walls = self.x @ to.T, np.hstack([self.walls[:, :2] @ to.T, self.walls[:, 2:] @ to.T])
        return Bodies(x, self.r, self.mass, np.column_stack([self.motion[:, :2] @ to.T, hand * self.motion[:, 2]]), walls,
            self.drift @ to.T, self.period,
                      self.aspect, hand * self.turn + (np.pi / 2 if way == "turned" else 0))

    def back(self, way, motion):
        """A motion of the image as one of this."""
        if way == "along":
            return motion - [0.4, 0.3, 0]
        return motion * [-1, 1, -1] if way == "mirrored" else np.column_stack([motion[:, 1], -motion[:, 0], motion[:, 2]])

    def norm(self, motion):
        """Of a change of motion, in mean radii a step and mean masses."""
        mass = np.where(self.free, self.mass, 0) / self.mass[self.free].mean()
        turning = np.where(self.free, self.moment, 0) / self.mass[self.free].mean()
        return DT / self.r.mean() * np.sqrt((mass * (motion[:, 0]**2 + motion[:, 1]**2) + turning * motion[:, 2]**2).sum())


def gaps(x, r, walls, period):
    """i, j (-1 - k: wall k), gap and direction of all pairs and walls, of the nearest image."""
    i, j = np.triu_indices(len(r), 1)
    apart = x[i] - x[j]
    if period:
        apart[:, 0] -= period * np.round(apart[:, 0] / period)
    found = [(i, j, np.hypot(*apart.T) - r[i] - r[j], apart)]
    for k, wall in enumerate(walls):
        along = wall[2:] - wall[:2]
        at = x - wall[:2]
        if period:
            at[:, 0] -= period * np.round((at[:, 0] - along[0] / 2) / period)
        at = at - np.clip(at @ along / (along @ along), 0, 1)[:, None] * along
        found.append((np.arange(len(r)), np.full(len(r), -1 - k), np.hypot(*at.T) - r, at))
    i, j, gap, e = (np.concatenate([part[c] for part in found]) for c in range(4))
    return i, j, gap, e / np.maximum(np.hypot(*e.T), 1e-300)[:, None]


def random_disks(rng, kind):
    """Up to 40 disks of a kind that do not overlap, in a box or a period."""
    number, most = int(rng.integers(2, 40)), 100 if kind == "sizes" else 3
    r = 0.01 * most ** -rng.random(number) if kind != "lattice" else np.full(number, 0.01)
    side = 2.5 * r.max() + rng.choice([2.1, 2.5, 3.2]) * np.sqrt((r**2).sum())
    low, period = (side, 2.1 * side) if kind == "period" else (0, 0.0)
    walls = np.array([[-low, 0, side + low, 0], [-low, side, side + low, side], [0, 0, 0, side], [side, 0, side, side]][:2
        if period else 4])
    if kind == "period":
        walls[:, 0], walls[:, 2] = 0, period
    wide = period or side
    if rng.random() < 0.5:  # a corner stands into the room
        tip, base = np.array([0.5 * wide, 0.5 * side]), np.array([0.6 * wide, 0.2 * side])
        walls = np.vstack([walls, [*tip, *base], [*tip, base[0] - 0.2 * wide, base[1]]])
    kept, x = [], np.zeros((0, 2))
    for k in np.argsort(-r, kind="stable"):
        for _ in range(60):
            new = r[k] + rng.random(2) * [wide - 2 * r[k], side - 2 * r[k]]
            if kept and rng.random() < {"touching": 0.9, "lattice": 0.95}.get(kind, 0.3):
                j = rng.integers(len(kept))
                angle = np.pi / 3 * rng.integers(6) if kind == "lattice" else rng.uniform(0, 2 * np.pi)
                new = x[j] + (r[k] + r[kept[j]]) * (1 + rng.choice([1e-13, 1e-9, 1e-5])) * np.array([np.cos(angle), np.sin(angle)])
            both = gaps(np.vstack([x, new]), r[[*kept, k]], walls, period)
            mine = (both[0] == len(kept)) | (both[1] == len(kept))
            if both[2][mine].min() > 0 and (period or (r[k] < new).all()
                and (new < side - r[k]).all()) and r[k] < new[1] < side - r[k]:
                kept.append(k)
                x = np.vstack([x, new])
                break
    r = r[kept]
    mass = np.pi * r**2 * (10 ** rng.uniform(-6, 0, len(r)) if kind == "masses" else 1)
    motion = np.zeros((len(r), 3))
    motion[:, :2] = r.mean() / DT * 10 ** rng.uniform(-2, -0.5 if period else 0.5) * (rng.standard_normal((len(r), 2))
        if rng.random() < 0.6 else np.array([0.0, -1.0]))
    if rng.random() < 0.3:
        motion[rng.random(len(r)) < 0.8] = 0
    drift = np.zeros((len(walls), 2))
    if kind == "held":
        held = rng.random(len(r)) < 0.2
        mass[held], motion[held] = -1, 0
        mass[0] = abs(mass[0])
    if kind == "walls":
        drift[0] = [0, 0.3 * r.min() / DT]
        drift[1] = [0.5 * r.min() / DT, 0]
    return Bodies(x, r, mass, motion, walls, drift, period)


def random_ellipses(rng):
    """Up to 16 ellipses in rows, in a box that the next may touch, some held or light, who turn by about half a radian a step."""
    across, up = rng.integers(1, 5, 2)
    x = 2.02 * np.array([(i, j) for j in range(up) for i in range(across)], float)
    r, aspect = rng.uniform(0.4, 1, len(x)), rng.choice([0.1, 0.3, 0.6, 1], len(x))
    if (aspect == 1).all():
        aspect[0] = 0.5
    mass = np.pi * r**2 * aspect * 10 ** rng.uniform(-rng.choice([0, 3]), 0, len(x))
    motion = rng.standard_normal((len(x), 3)) * np.array([0.5, 0.5, 0.5]) / DT
    if len(x) > 1 and rng.random() < 0.3:
        mass[1], motion[1] = -1, 0
    low, high = -np.ones(2) * 1.01, x.max(0) + 1.01
    walls = np.array([[*low, high[0], low[1]], [high[0], low[1], *high], [*high, low[0], high[1]], [low[0], high[1], *low]])
    return Bodies(x, r, mass, motion, walls, aspect=aspect, turn=rng.uniform(0, 2 * np.pi, len(x)))


def answers(freefem_text, folder, scenes):
    """(motion, [(i, j, impulse)]) of each scene."""
    (folder / "scenes.txt").write_text(f"{len(scenes)}\n" + "".join(scene.text() for scene in scenes))
    out = freefem_text(MANY, "-scenes", folder / "scenes.txt", "-contact-tol", TOL).stdout
    speed, press = rows(out, "speed"), rows(out, "press")
    return [(speed[speed[:, 0] == k, 1:], press[press[:, 0] == k, 1:]) for k in range(len(scenes))]


def hidden(scene, i, j, e):
    """Contacts of a body with an end of a wall that lies on or behind the line of another wall, at rest beside it, which the body
    faces: it stays in front of that line, and so meets no such end."""
    along = scene.walls[:, 2:] - scene.walls[:, :2]
    found = np.zeros(len(i), bool)
    for body in range(len(scene.r)):
        mine = np.flatnonzero((i == body) & (j < 0))
        walls = -1 - j[mine]
        away = scene.x[body] - scene.walls[walls, :2]
        if scene.period:
            away[:, 0] -= scene.period * np.round((away[:, 0] - along[walls, 0] / 2) / scene.period)
        faces = np.abs((e[mine] * along[walls]).sum(1)) <= 1e-9 * np.hypot(*along[walls].T)
        for f in np.flatnonzero(faces):
            for t in np.flatnonzero(~faces):
                ends = np.array([away[t], away[t] - along[walls[t]]])  # from the ends to the body
                if ((ends - away[f]) @ e[mine[f]] > -1e-12).all() and (scene.drift[walls[f]] == scene.drift[walls[t]]).all():
                    found[mine[t]] = True
    return found


def check_minimum(scene, motion, press):
    """The conditions of the minimum over all pairs and walls that can be met, and true gaps after the move. Lengths in mean radii,
    masses in mean masses."""
    every = gaps(scene.x, scene.r, scene.walls, scene.period)
    loose = scene.free[every[0]] | ((every[1] >= 0) & scene.free[np.maximum(every[1], 0)])
    i, j, gap, e = (part[~hidden(scene, every[0], every[1], every[3])] for part in every)
    length, n = scene.r.mean(), len(scene.r)
    matrix = np.zeros((len(i), 2 * n))
    k, pair = np.arange(len(i)), j >= 0
    for c in (0, 1):
        matrix[k, 2 * i + c] = e[:, c]
        matrix[k[pair], 2 * j[pair] + c] = -e[pair, c]
    after = gap / length + DT / length * (matrix @ motion[:, :2].ravel())
    after[~pair] -= DT / length * (e[~pair] * scene.drift[-1 - j[~pair]]).sum(1)
    inverse = np.repeat(np.where(scene.free, 1 / np.abs(scene.mass), 0), 2) * scene.mass[scene.free].mean()
    load = np.zeros(len(i))
    place = {(a, b): at for at, (a, b) in enumerate(zip(i, j))}
    for a, b, impulse in press:
        load[place[int(a), int(b)]] = impulse * DT / (scene.mass[scene.free].mean() * length)
    diagonal = matrix**2 @ inverse
    push = diagonal * load
    moved = DT / length * (motion - scene.motion)[:, :2].ravel()
    assert np.abs(moved - inverse * (matrix.T @ load)).max() < 1e-11 * max(1, push.max())  # stationary
    assert np.abs(np.minimum(push, after))[diagonal > 0].max() < 1.1 * max(TOL, 2e-15 * push.max())  # feasible, complementary
    turned = gaps(scene.x + DT * motion[:, :2], scene.r, scene.walls + DT * np.tile(scene.drift, 2), scene.period)
    assert turned[2][loose].min() > -1.1e-8 * scene.r.min()


def check_disks(freefem_text, folder, seeds):
    """Scenes of all kinds with their images, each of them a minimum; and with other velocities: a projection brings none farther
    apart."""
    kinds = ["sizes", "masses", "touching", "lattice", "held", "walls", "period"]
    scenes, all_scenes = [random_disks(np.random.default_rng(seed), kinds[seed % len(kinds)]) for seed in seeds], []
    for seed, scene in zip(seeds, scenes):
        other = Bodies(scene.x, scene.r, scene.mass, scene.motion.copy(), scene.walls, scene.drift, scene.period)
        other.motion[scene.free,
            :2] += 0.2 * np.abs(scene.motion).max() * np.random.default_rng(seed).standard_normal((scene.free.sum(), 2))
        all_scenes += [scene, other, scene.image("mirrored"), scene.image("along")] + ([] if scene.period
            else [scene.image("turned")])
    found = iter(answers(freefem_text, folder, all_scenes))
    pressing = 0
    for seed, scene in zip(seeds, scenes):
        (motion, press), (second, second_press) = next(found), next(found)
        check_minimum(scene, motion, press)
        other = all_scenes[all_scenes.index(scene) + 1]
        check_minimum(other, second, second_press)
        assert scene.norm(second - motion) <= scene.norm(other.motion - scene.motion) + 1e-8, seed
        for way in ["mirrored", "along"] + ([] if scene.period else ["turned"]):
            image = scene.back(way, next(found)[0])
            assert scene.norm(image - motion) < 1e-7 * max(1, scene.norm(scene.motion)), (seed, way)
        pressing += len(press)
    return pressing


def check_ellipses(freefem_text, folder, seeds):
    """No outline enters another or a wall, the motion does not hang on how it is looked at, and nobody gains energy by much."""
    scenes = [random_ellipses(np.random.default_rng(seed)) for seed in seeds]
    found = iter(answers(freefem_text, folder, [one for scene in scenes
        for one in (scene, *map(scene.image, ("mirrored", "along", "turned")))]))
    angles = np.linspace(0, 2 * np.pi, 721)
    for seed, scene in zip(seeds, scenes):
        motion = next(found)[0]
        for way in ("mirrored", "along", "turned"):
            image = scene.back(way, next(found)[0])
            assert scene.norm(image - motion) < 1e-6 * scene.norm(scene.motion), (seed, way)
        after = np.column_stack([scene.x, scene.turn]) + DT * motion
        outlines = [outline(*place, a, b, angles) for place, a, b in zip(after, scene.r, scene.aspect)]
        low, high = scene.walls[0, :2], scene.walls[1, 2:]
        for k, points in enumerate(outlines):
            assert (points.min(1) > low - 1e-7).all() and (points.max(1) < high + 1e-7).all(), seed
            for other in range(len(after)):
                c, s = np.cos(after[other, 2]), np.sin(after[other, 2])
                x, y = points - after[other, :2, None]
                assert other == k or np.hypot((c * x + s * y) / scene.r[other],
                    (c * y - s * x) / (scene.r * scene.aspect)[other]).min() > 1 - 1e-6, seed
        assert scene.norm(motion) < 1.1 * scene.norm(scene.motion), seed


def test_disks_of_all_kinds(freefem_text, tmp_path):
    assert check_disks(freefem_text, tmp_path, range(70)) > 500


def test_ellipses_of_all_kinds(freefem_text, tmp_path):
    check_ellipses(freefem_text, tmp_path, range(20))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(100, 1100, 100))
def test_many_more_scenes(freefem_text, tmp_path, first):
    check_disks(freefem_text, tmp_path, range(first, first + 100))
    check_ellipses(freefem_text, tmp_path, range(first, first + 30))
