"""Nodes in bodies against NumPy, nearest points of ellipses, bodies of too few nodes."""
import numpy as np
import pytest

from tests.scenes import script
from tests.tables import rows


def inside(nodes, x, y, r, periodic):
    """Numbers of the free nodes in a disk, and their places from its centre along x and y."""
    dx, dy = nodes[:, 1] - x, nodes[:, 2] - y
    if periodic:
        dx -= np.round(dx)
    found = np.flatnonzero((np.hypot(dx, dy) < r) & (nodes[:, 3] > 0.5))
    return found, dx[found], dy[found]


@pytest.mark.parametrize("periodic", [False, True])
def test_rigid_sets_are_those_of_a_numpy_twin(freefem_text, periodic):
    disks = [(0.31, 0.42, 0.127), (0.62, 0.71, 0.09), (0.04 if periodic else 0.2, 0.8, 0.11), (0.5, 0.06, 0.1)]
    out = freefem_text(script(disks, periodic)).stdout
    rigid, nodes = rows(out, "rigid"), rows(out, "node")
    expected = {}
    for d, (x, y, r) in enumerate(disks):
        expected |= {int(k): (d, dx, dy) for k, dx, dy in zip(*inside(nodes, x, y, r, periodic))}
    assert len(rigid) == len(expected) and len(set(rigid[:, 0])) == len(rigid)
    for k, d, rx, ry in rigid:
        assert expected[int(k)] == pytest.approx((d, rx, ry), abs=1e-12)


@pytest.mark.parametrize("periodic", [False, True])
def test_rigid_sets_of_moving_disks(freefem_text, periodic):
    """Candidates are looked for ahead of the disks; fast and slow ones, that turn back or cross the seam, have the nodes of the
    twin at each step."""
    disks, steps = np.array([(0.31, 0.42, 0.127), (0.62, 0.71, 0.09), (0.85 if periodic else 0.75, 0.3, 0.11),
        (0.5, 0.1, 0.06)]), 48
    # a step; back after half of them
    pace = 0.012 * np.array([(0.1, 0.4), (-1, 0.2), (1.1 if periodic else -0.3, 0.1), (0.0, 0.0)])
    moves = np.repeat([pace, -pace], steps // 2, axis=0)
    places, more = disks[:, :2] + np.cumsum(moves, axis=0), ""
    for step, move in enumerate(moves):
        more += f"bodyMoved = [{', '.join(map(repr, move.T.ravel().tolist()))}, 0, 0, 0, 0];\n"
        more += "{ real[int] mx = bodyMoved(0:3), my = bodyMoved(4:7); bodyX += mx; bodyY += my; }\nrigidFind();\n"
        more += f'for (int k = 0; k < rigidCount; ++k) cout << "at {step} " << rigidNode[k] << " " << rigidOwner[k] << endl;\n'
    out = freefem_text(script(disks.tolist(), periodic, more + 'cout << "refreshed " << rigidRefreshed << endl;')).stdout
    nodes, at = rows(out, "node"), rows(out, "at")
    for step, place in enumerate(places):
        expected = {(int(k), d) for d, (x, y) in enumerate(place) for k in inside(nodes, x, y, disks[d, 2], periodic)[0]}
        found = [(int(k), int(d)) for _, k, d in at[at[:, 0] == step]]
        assert set(found) == expected and len(found) == len(expected) > 60, step
    looks, path = rows(out, "refreshed")[0, 0], steps * np.hypot(*pace.T).max()
    # the fastest goes 1.9 skins, of an element each, from one look to the next but the first and the turn
    assert looks <= 3 + path / (1.8 / 16)


def test_a_disk_without_nodes_is_refused(freefem, tmp_path):
    done = freefem("cases/settling_disk.edp", "-diameter", "0.025", "-tend", "0.01", "-out", tmp_path / "run", check=False)
    assert done.returncode == 5 and "elements per diameter" in done.stderr and not (tmp_path / "run").exists()


def test_a_disk_of_two_elements_is_warned_of_and_runs(freefem, tmp_path):
    done = freefem("cases/settling_disk.edp", "-diameter", "0.12", "-tend", "0.01", "-out", tmp_path / "run")
    assert "fewer than 2 elements" in done.stdout + done.stderr


def test_nearest_points_of_an_ellipse_are_those_of_a_search(freefem_text):
    major, minor, theta = 1.0, 0.4, 0.7
    spots = np.random.default_rng(3).uniform(-1.2, 1.2, (40, 2))
    spots = spots[np.hypot(*spots.T) > 0.45]  # nearer the centre two sides may be as near
    text = f"""include "lib/bodies/ellipse.idp"
optCase("foot", "test"); optEnd();
bodyDisk(0, 0, 0.3, 1.); bodyEllipse(0, 0, {major}, {minor}, {theta}, 1.);
int[int] owner({len(spots)}); real[int] d({len(spots)}), nx({len(spots)}), ny({len(spots)});
owner = 1;
real[int] rx = [{", ".join(repr(float(x)) for x in spots[:, 0])}], ry = [{", ".join(repr(float(y)) for y in spots[:, 1])}];
ellipseFoot(owner, rx, ry, d, nx, ny);
cout.precision(12);
for (int k = 0; k < d.n; ++k) cout << "foot " << d[k] << " " << nx[k] << " " << ny[k] << endl;
"""
    found = rows(freefem_text(text).stdout, "foot")
    q = np.linspace(0, 2 * np.pi, 400001)
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    edge = turn @ [major * np.cos(q), minor * np.sin(q)]
    normal = turn @ [np.cos(q) / major, np.sin(q) / minor]
    normal /= np.hypot(*normal)
    local = turn.T @ spots.T
    inside = np.hypot(local[0] / major, local[1] / minor) < 1
    for k, spot in enumerate(spots):
        far = np.hypot(*(edge.T - spot).T)
        at = far.argmin()
        assert found[k, 0] == pytest.approx(-far[at] if inside[k] else far[at], abs=1e-6)
        assert found[k, 1:] == pytest.approx(normal[:, at], abs=1e-3)
