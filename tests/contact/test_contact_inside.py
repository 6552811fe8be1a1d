"""How many closed walls are round each disk (lib/contact/inside.idp): against points in polygons."""
import numpy as np
import pytest

from tests.scenes import write_walls

SCRIPT = """
include "lib/contact/contact.idp"
include "lib/contact/check.idp"
contactWallsFromCsv("{folder}/walls.csv");
contactPeriodic({low[0]}, {low[1]}, {period[0]}, {period[1]});
int n;
ifstream f("{folder}/places.txt");
f >> n;
real[int] px(n), py(n), depth(n);
for (int k = 0; k < n; ++k) f >> px[k] >> py[k];
contactDepth(px, py, depth);
ofstream g("{folder}/depth.txt");
for (int k = 0; k < n; ++k) g << depth[k] << endl;
"""


def within(corners, x):
    """Whether the points x (N, 2) lie in a polygon: the angle that its corners go round them."""
    angle = np.unwrap(np.arctan2(*(corners[:, None] - x).T[::-1]), axis=1)
    turn = angle[:, -1] + (np.angle(np.exp(1j * (angle[:, 0] - angle[:, -1])))) - angle[:, 0]
    return np.abs(turn) > np.pi


def group(rng, centre, size, plain):
    """(walls, polygons that they fill): a polygon, and unless `plain` spokes, fins, a chamber on one side, one at a corner, walls
    drawn twice, in pieces or without a length."""
    number = int(rng.integers(5, 9))
    angle = 2 * np.pi * (np.arange(number) + rng.uniform(-0.25, 0.25, number)) / number
    corners = centre + size * rng.uniform(0.7, 1, number)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    if rng.random() < 0.5:  # level at the bottom, to the last digit
        low = np.sort(np.argsort(corners[:, 1])[:2])
        corners[low, 1] = corners[low, 1].mean() if low[1] - low[0] in (1, number - 1) else corners[low, 1]
    walls, filled = [], [corners]
    for k in range(number):
        a, b = corners[k], corners[(k + 1) % number]
        if not plain and rng.random() < 0.3:
            middle = a + rng.uniform(0.3, 0.7) * (b - a)
            walls += [(a, middle), (middle, b)]
        else:
            walls.append((a, b))
        # ends on the middle of a wall, out of order
        for share in [] if plain else rng.permutation([0.2, 0.35, 0.6, 0.8])[:int(rng.integers(0, 4))]:
            foot = a + share * (b - a)
            walls.append((foot, centre + rng.choice([0, 0.8, 1.2]) * (foot - centre)))
    if not plain:
        a, b = corners[0] + 0.45 * (corners[1] - corners[0]), corners[0] + 0.55 * (corners[1] - corners[0])
        tip = centre + 1.5 * (0.5 * (a + b) - centre)
        walls += [(a, tip), (tip, b)]
        filled.append(np.array([a, tip, b]))
        v = corners[3]
        turn = [[np.cos(0.1), -np.sin(0.1)], [np.sin(0.1), np.cos(0.1)]]
        a, b = centre + 1.5 * (v - centre) @ turn, centre + 1.5 * (v - centre) @ np.transpose(turn)
        walls += [(v, a), (a, b), (b, v)]
        filled.append(np.array([v, a, b]))
        walls += [walls[k] for k in rng.integers(len(walls), size=5)] + [(corners[k], corners[k]) for k in (0, 2)]
    return walls, filled


def scene(rng, axes):
    """Groups of walls that do not meet, some in others, in a unit square with these periods; places with the number of groups round
    them."""
    centres, groups = [], []
    low = rng.uniform(-1, 1, 2)
    steps = [(-1, 0, 1) if axis in axes else (0,) for axis in (0, 1)]
    shifts = np.array([(a, b) for a in steps[0] for b in steps[1]])
    # places on a side, where it is one of the period
    seams = [low + np.array([0 if axis in axes else 0.25, 0.5])[::1 - 2 * axis] for axis in (0, 1)]
    while len(centres) < 5:
        at = seams[len(centres)] if len(centres) < 2 else low + rng.random(2)
        if all(np.hypot(*(at - c - s)) > 0.32 for c in centres for s in shifts):
            centres.append(at)
            plain = len(centres) % 2 == 0
            groups.append(group(rng, at, 0.1, plain))
            if plain:
                groups.append(group(rng, at, 0.017, len(centres) % 4 == 0))
    x = np.concatenate([low + rng.random((1500, 2)), *(c + rng.uniform(-far, far, (200, 2)) for c in centres
        for far in (0.15, 0.02))])
    ends = np.concatenate([np.reshape(walls, (-1, 2)) for walls, _ in groups])
    x[:1500:3, 1] = ends[rng.integers(len(ends), size=500), 1]  # as high as a corner
    depth = sum(np.any([within(polygon, x + shift) for polygon in filled for shift in shifts], axis=0).astype(int) for _,
        filled in groups)
    walls = np.array([wall for part, _ in groups for wall in part])
    left, right = walls.min(1)[:, 0], walls.max(1)[:, 0]
    level = walls[:, 0, 1] == walls[:, 1, 1]
    on = [(abs(x[:, 1:] + shift[1] - walls[level, 0, 1]) < 1e-9) & (x[:, :1] + shift[0] > left[level] - 1e-9)
        & (x[:, :1] + shift[0] < right[level] + 1e-9) for shift in shifts]
    off = ~np.any(on, axis=(0, 2))
    walls = walls[rng.permutation(len(walls))]
    flip = rng.random(len(walls)) < 0.5
    walls[flip] = walls[flip][:, ::-1]
    return low, walls.reshape(-1, 4), x[off], depth[off]


@pytest.mark.parametrize("seed, axes", [(1, ()), (2, (0,)), (1, (1,)), (2, (0, 1))])
def test_the_walls_round_a_place_are_counted_as_polygons_that_hold_it(seed, axes, freefem_text, tmp_path):
    """Also from some periods away, and where a group lies across a side of the period."""
    rng = np.random.default_rng(seed)
    low, walls, x, depth = scene(rng, axes)
    far = x + rng.integers(-3, 4, x.shape) * [axis in axes for axis in (0, 1)]
    write_walls(tmp_path / "walls.csv", walls)
    (tmp_path / "places.txt").write_text(f"{len(far)}\n" + "".join(f"{a:.17g} {b:.17g}\n" for a, b in far))
    freefem_text(SCRIPT.format(folder=tmp_path, low=low, period=[int(axis in axes) for axis in (0, 1)]))
    found = np.loadtxt(tmp_path / "depth.txt")
    assert np.bincount(depth)[:3].min() > 20
    assert (found == depth).all(), np.column_stack([x, found, depth])[found != depth]
