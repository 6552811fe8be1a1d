"""Elements that the edge of a body cuts: the part inside and its flux, against the area of a disk and a NumPy twin."""
import numpy as np
import pytest

from tests.scenes import script
from tests.tables import rows
from tools.base.run_folder import RunFolder

CELLS = 16
FIND = """
cutSetUp();
cutFind();
cout << "pairs " << cutN << endl;
for (int i = 0; i < cutN; ++i) for (int k = 0; k < 6; ++k) cout << "cut " << cutOwner[k*cutN + i] << " " << cutIn[k*cutN + i] << " " << cutX[k*cutN + i] << " " << cutY[k*cutN + i] << " " << cutInside[k*cutN + i] << " " << flowX[cutNode[k*cutN + i]] << " " << flowY[cutNode[k*cutN + i]] << endl;
"""
MESH = """
for (int T = 0; T < Th.nt; ++T) for (int k = 0; k < 6; ++k) cout << "place " << flowX[Wh(T, k)] << " " << flowY[Wh(T, k)] << endl;
"""


def run(freefem_text, bodies, more, periodic=False):
    text = script([], periodic, more).replace("rigidSetUp();", bodies + "\nrigidSetUp();", 1)
    return freefem_text(text.replace('include "lib/immersed/ghost_values.idp"', 'include "lib/immersed/cut_flux.idp"', 1)).stdout


def disks(some):
    return "\n".join(f"bodyDisk({x!r}, {y!r}, {r!r}, 1.);" for x, y, r in some)


def inner_elements(nodes, inside):
    """Area of the triangles all of whose six nodes are inside, and its first moments; nodes: 6 rows of x, y a triangle."""
    total = np.zeros(3)
    for six in nodes.reshape(-1, 6, 2):
        if inside(*six.T).all():
            total += np.array([1, *six[:3].mean(axis=0)]) / CELLS**2 / 2
    return total


@pytest.mark.parametrize("semi", [(0.21, 0.21, 0.0), (0.127, 0.127, 0.0), (0.28, 0.14, 0.6)])
def test_the_parts_inside_add_up_to_the_body(freefem_text, semi):
    """Area and centre: sum of int phi_k, and of x_k int phi_k, which is exact for linear functions."""
    x0, y0, (a, b, turn) = 0.47, 0.53, semi
    body = f"bodyEllipse({x0}, {y0}, {a}, {b}, {turn}, 1.);" if a != b else disks([(x0, y0, a)])
    out = run(freefem_text, body, FIND + MESH)
    cut = rows(out, "cut")

    def inside(x, y):
        dx, dy = x - x0, y - y0
        along, across = np.cos(turn) * dx + np.sin(turn) * dy, np.cos(turn) * dy - np.sin(turn) * dx
        return (along / a) ** 2 + (across / b) ** 2 < 1
    assert (cut[:, 1] == inside(cut[:, 5], cut[:, 6])).all()
    share = cut[:, 4] / CELLS**2 / 2
    total = inner_elements(rows(out, "place"), inside) + [share.sum(), (share * cut[:, 5]).sum(), (share * cut[:, 6]).sum()]
    # the rest lies in elements whose nodes are all outside, and in the sum over parts
    assert total[0] == pytest.approx(np.pi * a * b, rel=0.01)
    assert total[1:] / total[0] == pytest.approx([x0, y0], abs=0.003 * a)


FLUX = """
real[int] u = flowX, v = flowY, q = MOTION, r(flowNq);
u *= 3.; u = sin(u); v *= 4.; v = cos(v);
rigidSpread(q, u, v);
cutSetUp();
cutFind();
r = 0;
cutFlux(u, v, q, r);
cout << "sum " << r.sum << " " << r.linfty << " " << cutN << endl;
for (int T = 0; T < Th.nt; ++T) for (int k = 0; k < 6; ++k) cout << "corner " << T << " " << flowX[Wh(T, k)] << " " << flowY[Wh(T, k)] << " " << u[Wh(T, k)] << " " << v[Wh(T, k)] << " " << (k < 3 ? Qh(T, k) : -1) << endl;
for (int i = 0; i < flowNq; ++i) cout << "vertex " << r[i] << endl;
"""


def twin(nodes, bodies, motions, size):
    """grad q . I of lib/immersed/cut_flux.idp, the integrals by sums over many points of each cut element; the bodies that cut each
    of these."""
    fine = 60
    a, b = np.meshgrid(np.arange(fine), np.arange(fine), indexing="ij")
    points = np.vstack([np.column_stack([((a + s) / fine).ravel(), ((b + s) / fine).ravel()])[(a + b < fine - (s > 0.5)).ravel()]
        for s in (1 / 3, 2 / 3)])
    l1, l2 = points.T
    l0 = 1 - l1 - l2
    phi = np.array([l0 * (2 * l0 - 1), l1 * (2 * l1 - 1), l2 * (2 * l2 - 1), 4 * l1 * l2, 4 * l0 * l2, 4 * l0 * l1])
    found, cuts = np.zeros(size), []
    for six in nodes.reshape(-1, 6, 6):
        x, y, u, v, vertex = six[:, 1:].T
        (x0, x1, x2), (y0, y1, y2) = x[:3], y[:3]
        twice = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        grad = np.array([[y1 - y2, x2 - x1], [y2 - y0, x0 - x2], [y0 - y1, x1 - x0]]) / twice
        cuts.append(0)
        px, py = l0 * x0 + l1 * x1 + l2 * x2, l0 * y0 + l1 * y1 + l2 * y2
        for (bx, by, radius), (mu, mv, mw) in zip(bodies, motions):
            far = np.hypot(x - bx, y - by)
            rigid = far < radius
            if rigid.all() or not rigid.any():
                continue
            cuts[-1] += 1
            part = np.hypot(px - bx, py - by) < radius
            inside, outside = (phi * part).mean(axis=1), (phi * ~part).mean(axis=1)
            reach = np.where(rigid, 0, far - radius)
            for component, w in enumerate((u - mu + mw * (y - by), v - mv - mw * (x - bx))):
                slope = (w * reach).sum() / ((reach**2).sum() + 0.01 * ((radius - far)[rigid]**2).sum())
                ghost = -slope * (radius - far)[rigid]
                found[vertex[:3].astype(int)] += grad[:, component] * twice / 2 * ((ghost * outside[rigid]).sum()
                    - (w * inside)[~rigid].sum())
    return found, np.array(cuts)


def test_the_flux_is_that_of_a_numpy_twin_also_where_two_disks_share_an_element(freefem_text):
    bodies, motions = [(0.31, 0.42, 0.127), (0.545, 0.42, 0.1), (0.7, 0.7, 0.16)], [(0.3, -0.2, 0.7), (1.0, 0.4, -2.0),
        (-0.5, 0.1, 1.0)]
    motion = "[" + ", ".join(str(m[k]) for k in range(3) for m in motions) + "]"
    out = run(freefem_text, disks(bodies), FLUX.replace("MOTION", motion))
    total, largest, pairs = rows(out, "sum")[0]
    found = rows(out, "vertex").ravel()
    expected, cuts = twin(rows(out, "corner"), bodies, motions, len(found))
    assert pairs == cuts.sum() and cuts.max() == 2
    assert abs(total) < 1e-14 and largest > 1e-4
    np.testing.assert_allclose(found, expected, atol=0.06 * largest)  # 36 parts an element; 0.03 with 64


def test_the_flux_of_a_disk_on_the_seam_is_that_of_one_elsewhere(freefem_text):
    """A disk moved by whole cells, over the seam: the same shares in the same order of places."""
    shares = []
    for x in (0.53, 0.03 + 1):  # half the box is 8 cells: the pattern of triangles repeats
        cut = rows(run(freefem_text, disks([(x, 0.4, 0.13)]), FIND, periodic=True), "cut").reshape(-1, 6, 7)
        order = np.lexsort(np.round(cut[:, :3, 2:4].mean(axis=1), 9).T)
        shares.append(cut[order][:, :, 1:5])
    np.testing.assert_allclose(shares[0], shares[1], atol=1e-12)


def test_small_bodies_and_none_cut_nothing(freefem_text):
    assert rows(run(freefem_text, disks([(0.5, 0.5, 0.9 / CELLS)]), FIND), "pairs")[0, 0] == 0
    text = FIND + "bodyKeep(none); rigidStale = 1; rigidFind(); cutFind(); real[int] r(flowNq), q(0); r = 0; cutFlux(flowU, flowV, q, r); cout << \"left \" << cutN << \" \" << r.linfty << endl;"
    out = run(freefem_text, disks([(0.5, 0.5, 0.1)]), "int[int] none(0);\n" + text)
    assert rows(out, "pairs")[0, 0] > 10 and tuple(rows(out, "left")[0]) == (0, 0)


@pytest.mark.parametrize("place", [(0.5, 0.5), (0.513, 0.527)])
def test_a_cylinder_that_nearly_fills_its_period_is_cut_where_it_is(place, freefem, tmp_path):
    """Solid fraction 0.75: the nodes beyond the gap are those of its neighbour's side. The force on the fluid is what holds the
    cylinder (0.4 of it before)."""
    freefem("cases/cylinder_array.edp", "-fraction", 0.75, "-x", place[0], "-y", place[1], "-out", tmp_path / "run")
    drag = RunFolder(tmp_path / "run").table("summary")
    assert drag["drag"][-1] == pytest.approx(drag["drag_by_balance"][-1], rel=1e-4) and drag["drag"][-1] > 4e4


GRADED = """
real[int] resolved = rigidResolved, first(bodyNumber), same(rigidCount);
first = -1;
for (int i = 0; i < rigidCount; ++i) if (first[rigidOwner[i]] < 0) first[rigidOwner[i]] = resolved[i];
same = first(rigidOwner); same -= resolved;
real[int] size = flowH(rigidNode);
cout << "whole " << rigidCount << " " << same.linfty << " " << size.min << " " << size.max << " " << first.sum << endl;
"""


def test_a_body_is_resolved_as_a_whole_where_elements_differ(freefem_text):
    """Disks of two elements across in a mesh whose elements are not of one size: node by node some were both at once."""
    text = script([], False, GRADED).replace("rigidSetUp();", disks([(0.12 + 0.15 * k, 0.12 + 0.15 * j, 0.062) for k in range(6)
        for j in range(6)]) + "\nrigidSetUp();", 1)
    text = text.replace("real flowPeriodX", "Th = movemesh(Th, [0.4*x + 0.6*x^2, y]);\nreal flowPeriodX", 1)
    assert "movemesh" in text
    count, differ, least, most, resolved = rows(freefem_text(text).stdout, "whole")[0]
    assert count > 100 and most > 1.5 * least and differ == 0 and 5 < resolved < 31
