"""Curved walls made of many short segments (lib/wall_bends.idp): what slides along them keeps its speed, and nothing is kept off where there is no wall."""
import numpy as np
import pytest

from tests.test_pipe import distances_to_segments
from tools.run_folder import RunFolder

RING = """
include "lib/bodies.idp"
include "lib/walls.idp"
optCase("ring", "a disk slides along a ring of {count} segments");
optDefault("-every", "1"); optDefault("-contact-tol", "1e-12"); optDefault("-contact-overlap", "1e-10");
real gravityX = 0, gravityY = 0;
macro caseParticles() {{ bodyAdd(0, {start:.9g}, 0.1, 1, 1, 0, 0, 1); }} // EOM
macro caseWalls() {{ for (int k = 0; k < {count}; ++k) contactWallSegment(cos(2*pi*k/{count}), sin(2*pi*k/{count}), cos(2*pi*(k + 1)/{count}), sin(2*pi*(k + 1)/{count})); }} // EOM
include "scripts/contacts.edp"
"""


@pytest.mark.parametrize("count, move", [(2000, 0.02), (300, 0.01)])
def test_a_disk_slides_round_a_ring(count, move, freefem_text, tmp_path):
    """The projection onto the wall at the end of each move takes (move/R)^2 of the speed: 1/v^2 grows by 2 dt/R^2 t, R the radius of the centre's way. 17 and 5 % went on a radius before."""
    freefem_text(RING.format(count=count, start=-0.9 + 1e-5 + (np.pi / count) ** 2), "-dt", move, "-tend", 1, "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").particles
    x, y = last["x"][-1], last["y"][-1]
    assert np.hypot(last["u"][-1], last["v"][-1]) == pytest.approx((1 + 2 * move / 0.9**2) ** -0.5, abs=0.1 * move / 0.9**2 + 1e-5)
    assert np.hypot(x, y) * np.cos(np.pi / count) < 0.9 and np.hypot(x, y) > 0.9 - 2e-3


GAPS = """
include "lib/contact.idp"
contactWallsFromCsv("{walls}");
int n;
ifstream f("{disks}");
f >> n;
real[int] px(n), py(n), r(n);
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> r[k];
contactSearch(px, py, r, 0, 1.);
contactMeasure(px, py, r);
ofstream g("{gaps}");
g.precision(15);
for (int k = contactNearPairs; k < contactNearN; ++k) g << contactNearI[k] << " " << -1 - contactNearJ[k] << " " << contactNearGap[k] << endl;
cout << "bends " << bendFind() << endl;
"""


@pytest.mark.parametrize("seed", range(6))
def test_a_disk_that_touches_nothing_has_no_negative_gap(seed, freefem_text, tmp_path):
    """On either side of a wavy closed line with bumps narrower than the disks, and of an open one: gaps are never above the distance to the segment, and below 0 only for who overlaps a wall."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(40, 200))
    phi = np.sort(rng.uniform(0, 2 * np.pi, count)) if seed % 2 else np.linspace(0, 2 * np.pi, count, endpoint=False)
    radius = 1 + sum(a * np.cos(k * phi + rng.uniform(0, 7)) for k, a in ((2, 0.2), (5, 0.1 * rng.random()), (9, 0.05 * rng.random())))
    x, y = radius * np.cos(phi), radius * np.sin(phi)
    ends = np.column_stack([x, y, np.roll(x, -1), np.roll(y, -1)])[: count - seed % 3]
    flip = rng.random(len(ends)) < 0.5
    ends[flip] = ends[flip][:, [2, 3, 0, 1]]
    ends = ends[rng.permutation(len(ends))]
    px, py = rng.uniform(-1.6, 1.6, (2, 1500))
    near = distances_to_segments(px, py, ends[:, :2], ends[:, 2:]).min(1)
    r = np.minimum(near, 10 ** rng.uniform(-2, -0.2, 1500)) * (1 - 1e-9)  # many touch, none overlaps
    (tmp_path / "walls.csv").write_text("x1,y1,x2,y2\n" + "".join(",".join(f"{value:.17g}" for value in row) + "\n" for row in ends))
    (tmp_path / "disks.txt").write_text(f"{len(px)}\n" + "".join(f"{a:.17g} {b:.17g} {c:.17g}\n" for a, b, c in zip(px, py, r)))
    done = freefem_text(GAPS.format(walls=tmp_path / "walls.csv", disks=tmp_path / "disks.txt", gaps=tmp_path / "gaps.txt"))
    found = np.loadtxt(tmp_path / "gaps.txt")
    disk, wall, gap = found[:, 0].astype(int), found[:, 1].astype(int), found[:, 2]
    true = distances_to_segments(px, py, ends[:, :2], ends[:, 2:])[disk, wall] - r[disk]
    assert len(found) > 10000 and "bends 1" in done.stdout
    assert (gap <= true + 1e-12).all() and (gap < true - 1e-3).sum() > 100  # some gaps are those to lines
    assert gap.min() > -1e-12
