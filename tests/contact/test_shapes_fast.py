"""Bodies of any shape that move and turn far in a step: none pass through each other, and little energy is gained."""
import numpy as np
import pytest

from tests.contact.shapes import capsule, clump, polygon, read_bodies, scene_text
from tools.base.tables import read_table

SIDE, DT = 4.4, 0.01
BOX = [f"contactWallSegment({a}, {b}, {c}, {d});" for a, b, c, d in ((0, 0, SIDE, 0), (SIDE, 0, SIDE, SIDE), (SIDE, SIDE, 0, SIDE),
    (0, SIDE, 0, 0))]


def crowd(seed, rotation):
    """Capsules, polygons of three to six vertices and clumps of two disks that turn by up to `rotation` (rad) in a step and move by
    up to 0.4 of it, at most by 0.12."""
    rng = np.random.default_rng(seed)
    bodies = []
    for k in range(16):
        x, y, angle = (k % 4) * 1.1 + 0.55, (k // 4) * 1.1 + 0.55, rng.uniform(0, 2 * np.pi)
        motion = np.array([*rng.uniform(-1, 1, 2) * 0.4 * min(rotation, 0.3), rng.uniform(-1, 1) * rotation]) / DT
        if k % 3 == 0:
            bodies.append(capsule(x, y, rng.uniform(0.3, 0.45), rng.uniform(0.01, 0.06), angle, motion=motion))
        elif k % 3 == 1:
            turn = angle + 2 * np.pi * np.arange(3 + k % 4) / (3 + k % 4)
            far = 0.4 * rng.uniform(0.6, 1, len(turn))
            bodies.append(polygon(np.column_stack([x + far * np.cos(turn), y + far * np.sin(turn)]), rng.uniform(0.01, 0.04),
                motion=motion))
        else:
            along = 0.2 * np.array([np.cos(angle), np.sin(angle)])
            bodies.append(clump([[x, y] - along, [x, y] + along], [0.2, 0.2], motion=motion))
    return bodies


def edges_at(shapes, rows):
    """Begin and end (n, 2), radius and body of all edges, a disk being one from a point to itself."""
    found = []
    for one, x, y, theta in zip(*(rows[name] for name in ("id", "x", "y", "theta"))):
        c, s = np.cos(theta), np.sin(theta)
        for closed, radius, points in shapes[int(one)]:
            points = points @ np.array([[c, s], [-s, c]]) + [x, y]
            n = len(points)
            found += [(points[k], points[(k + 1) % n], radius, one) for k in range(n if closed else max(n - 1, 1))]
    return [np.array(column) for column in zip(*found)]


def cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def overlap(shapes, rows):
    """The deepest overlap of bodies with each other and with the box, over the least radius, and how many edges cross."""
    begin, end, radius, body = edges_at(shapes, rows)
    i, j = np.triu_indices(len(body), 1)
    i, j = (one[body[i] != body[j]] for one in (i, j))
    way = end - begin
    crossing = ((cross(way[i], begin[j] - begin[i]) * cross(way[i], end[j] - begin[i]) < 0)
        & (cross(way[j], begin[i] - begin[j]) * cross(way[j], end[i] - begin[j]) < 0)).sum()
    gap = np.full(len(i), np.inf)
    for points, of in ((begin[i], j), (end[i], j), (begin[j], i), (end[j], i)):
        along = np.clip(((points - begin[of]) * way[of]).sum(1) / ((way[of] ** 2).sum(1) + 1e-300), 0, 1)
        gap = np.minimum(gap, np.hypot(*(points - begin[of] - along[:, None] * way[of]).T))
    walls = np.minimum(begin, SIDE - begin).min(1) - radius
    return min((gap - radius[i] - radius[j]).min(), walls.min()) / radius.min(), crossing


@pytest.mark.parametrize("seeds, rotation, friction", [([1], 0.3, 0)] + [pytest.param(range(1, 9), rotation, friction,
    marks=pytest.mark.slow) for rotation in (0.01, 0.1, 0.3, 1.0) for friction in (0, 0.5)])
def test_what_turns_far_in_a_step_does_not_pass_through(seeds, rotation, friction, freefem_text, tmp_path):
    """Overlaps below 1e-6 of the least radius, energy that rises by at most 1e-3 of that at the start; a run may stop, which is
    counted."""
    stopped, gains = 0, []
    for seed in seeds:
        folder = tmp_path / str(seed)
        done = freefem_text(scene_text(crowd(seed, rotation), BOX, (0.0, -1.0)), "-friction", friction, "-friction-tol", 1e-6,
            "-contact-tol", 1e-9, "-dt", DT, "-tend", 0.4, "-every", DT, "-out", folder, check=False)
        assert done.returncode in (0, 4), done.stderr
        stopped += done.returncode == 4
        rows, shapes = read_table(folder / "particles.csv"), read_bodies(folder)
        for t in np.unique(rows["t"]):
            deep, crossing = overlap(shapes, {name: rows[name][rows["t"] == t] for name in rows})
            assert deep > -1e-6 and crossing == 0
        motion = read_table(folder / "motion.csv")
        gains.append(np.diff(motion["kinetic_energy"] + motion["potential_energy"]).max() / motion["kinetic_energy"][0])
    print(f"rotation {rotation}, friction {friction}: {stopped} of {len(seeds)} stopped, largest gain {max(gains):.2g}")
    assert stopped == 0 and max(gains) < 1e-3
