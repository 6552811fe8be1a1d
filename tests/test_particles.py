"""Rigid particles: node sets and ghost values against NumPy, drag, density ratios, periodic boxes."""
import numpy as np
import pytest

from tools.tables import read_table
from tools.validation.particles import started
from tests.conftest import ROOT

# A box of N x N cells with disks; prints the rigid nodes. PERIODIC and DISKS are filled in.
SETS = """
include "lib/options.idp"
optCase("sets", "rigid sets"); optEnd();
real rhoFluid = 1, mu = 1, gravityX = 0, gravityY = 0;
mesh Th = square(16, 16, flags = 3);
int[int] flowNoSlip = [SOLID], flowMoving(0), flowOutlet(0), flowSlip(0);
real flowPeriodX = PERIOD, flowPeriodY = 0;
MACROS
include "lib/ghost.idp"
DISKS
rigidSetUp();
rigidFind();
cout.precision(15);
for (int k = 0; k < rigidCount; ++k) cout << "rigid " << rigidNode[k] << " " << rigidOwner[k] << " " << rigidX[k] << " " << rigidY[k] << endl;
for (int k = 0; k < flowNw; ++k) cout << "node " << k << " " << flowX[k] << " " << flowY[k] << " " << flowFreeU[k] << endl;
"""
PERIODIC_SPACES = """macro flowSpaces() fespace Wh(Th, P2, periodic = [[4, y], [2, y]]); fespace Qh(Th, P1, periodic = [[4, y], [2, y]]); // EOM
macro flowPeriodicLabels() [2, 4] // EOM"""


def script(disks, periodic=False, more=""):
    text = SETS.replace("PERIOD,", "1," if periodic else "0,").replace("SOLID", "1, 3" if periodic else "1, 2, 3, 4")
    text = text.replace("MACROS", PERIODIC_SPACES if periodic else "")
    return text.replace("DISKS", "\n".join(f"bodyDisk({x!r}, {y!r}, {r!r}, 1.);" for x, y, r in disks)) + more


def rows(text, word):
    return np.array([[float(w) for w in line.split()[1:]] for line in text.splitlines() if line.startswith(word + " ")])


@pytest.mark.parametrize("periodic", [False, True])
def test_rigid_sets_are_those_of_a_numpy_twin(freefem_text, periodic):
    disks = [(0.31, 0.42, 0.127), (0.62, 0.71, 0.09), (0.04 if periodic else 0.2, 0.8, 0.11), (0.5, 0.06, 0.1)]
    out = freefem_text(script(disks, periodic)).stdout
    rigid, nodes = rows(out, "rigid"), rows(out, "node")
    expected = {}
    for d, (x, y, r) in enumerate(disks):
        dx = nodes[:, 1] - x
        if periodic:
            dx -= np.round(dx)
        inside = (np.hypot(dx, nodes[:, 2] - y) < r) & (nodes[:, 3] > 0.5)
        expected |= {int(k): (d, dx[k], nodes[k, 2] - y) for k in np.flatnonzero(inside)}
    assert len(rigid) == len(expected) and len(set(rigid[:, 0])) == len(rigid)
    for k, d, rx, ry in rigid:
        assert expected[int(k)] == pytest.approx((d, rx, ry), abs=1e-12)


def test_ghost_values_of_a_linear_field(freefem_text):
    """u = (3 y - 1, 2 x): P2 holds it exactly, so the slip at the outer points is known."""
    x0, y0, r = 0.47, 0.53, 0.21
    more = """
real[int] u = flowY, v = flowX, q = [0.3, -0.2, 0.7], fu(flowNw), fv(flowNw);
u *= 3; u += -1.; v *= 2;
fu = 0; fv = 0;
ghostAdd(u, v, q, fu, fv);
for (int k = rigidLayer; k < rigidCount; ++k) cout << "ghost " << rigidX[k] << " " << rigidY[k] << " " << ghostU[rigidNode[k]] << " " << ghostV[rigidNode[k]] << endl;
real[int] ku = flowK*ghostU;
ku += fu;
cout << "force " << ku.linfty << endl;
"""
    more = more.replace("u += -1.;", "{ real[int] one(flowNw); one = 1; u -= one; }")
    out = freefem_text(script([(x0, y0, r)], more=more)).stdout
    rx, ry, gu, gv = rows(out, "ghost").T
    size = 1 / 16
    far = np.hypot(rx, ry)
    nx, ny, depth = rx / far, ry / far, r - far

    def slip(k):
        reach = r + k * size
        px, py = x0 + reach * nx, y0 + reach * ny
        return -ny * (3 * py - 1 - 0.3) + nx * (2 * px + 0.2) - 0.7 * reach
    g = depth * (-2 * slip(1) / size + slip(2) / (2 * size))
    assert len(g) > 50 and depth.min() > 0
    np.testing.assert_allclose(gu, -ny * g, atol=1e-8)
    np.testing.assert_allclose(gv, nx * g, atol=1e-8)
    assert rows(out, "force")[0, 0] < 1e-12  # the force is -mu K g


def run_case(freefem, folder, case, *args):
    freefem(f"cases/{case}.edp", "-out", folder, *args)
    return read_table(folder / "particles.csv")


def test_settling_disk_follows_the_published_velocity(freefem, tmp_path):
    run = run_case(freefem, tmp_path / "run", "settling_disk", "-tend", "0.1")
    table = read_table(ROOT / "tests" / "reference" / "settling_disk_velocity_koblitz2017_fig6b.csv")
    t, v = table["t_s"], table["v_cm_per_s"]
    now = (t > 0.055) & (t < 0.1)
    assert now.sum() >= 4
    np.testing.assert_allclose(np.interp(t[now], run["t"], run["v"]), v[now], rtol=0.04)
    assert abs(run["x"] - 1).max() < 2e-3


@pytest.mark.parametrize("ratio,error", [(0.01, 0.1), (2, 0.1), (1000, 0.02)])
def test_light_and_heavy_disks_start_as_added_mass_says(freefem, tmp_path, ratio, error):
    run = run_case(freefem, tmp_path / "run", "settling_disk", "-rhos", ratio, "-mu", "0.01", "-y", "3", "-dt", "0.0002", "-tend", "0.004")
    assert np.isfinite(run["v"]).all()
    assert run["v"][-1] == pytest.approx(started(ratio, 0.01, 0.004), rel=error)


def test_a_neutral_disk_stays_at_rest(freefem, tmp_path):
    run = run_case(freefem, tmp_path / "run", "settling_disk", "-rhos", "1", "-tend", "0.02")
    assert max(abs(run["u"]).max(), abs(run["v"]).max(), abs(run["omega"]).max()) < 1e-9


def test_drag_in_a_periodic_array_is_the_same_everywhere(freefem, tmp_path):
    """Sangani & Acrivos: 51.53 at solid fraction 0.2; a cylinder across the seams is not another one."""
    found = []
    for name, centre in (("middle", "0.5"), ("corner", "0")):
        freefem("cases/cylinder_array.edp", "-fraction", "0.2", "-x", centre, "-y", centre, "-dt", "0.002", "-out", tmp_path / name)
        summary = read_table(tmp_path / name / "summary.csv")
        found.append(float(summary["drag"][0]))
        assert summary["drag_by_balance"][0] == pytest.approx(found[-1], rel=1e-3)
    assert found[0] == pytest.approx(51.53, rel=0.02)
    assert found[1] == pytest.approx(found[0], rel=1e-4)


def test_a_run_repeated_gives_the_same_file(freefem, tmp_path):
    for name in ("one", "two"):
        freefem("cases/drafting_kissing_tumbling.edp", "-tend", "0.003", "-out", tmp_path / name)
    assert (tmp_path / "one" / "particles.csv").read_bytes() == (tmp_path / "two" / "particles.csv").read_bytes()


def test_published_and_standard_scheme_agree_roughly(freefem, tmp_path):
    """First order in time and an element-wise interface on one side: a quarter is what to expect at 4 cells."""
    standard = run_case(freefem, tmp_path / "standard", "settling_disk", "-tend", "0.04", "-dt", "0.0025")
    published = run_case(freefem, tmp_path / "published", "settling_disk", "-tend", "0.04", "-dt", "0.005", "-scheme", "published")
    assert published["v"][-1] == pytest.approx(standard["v"][-1], rel=0.25)


def test_a_disk_of_two_elements_is_warned_of_and_runs(freefem, tmp_path):
    done = freefem("cases/settling_disk.edp", "-diameter", "0.12", "-tend", "0.01", "-out", tmp_path / "run")
    assert "fewer than 2 elements" in done.stdout + done.stderr


@pytest.mark.parametrize("text,words", [
    ("id,x,y,radius\n0,1,1,0.1\n", "first line"),
    ("id,x,y,radius,density\n0,1,1,0.1,abc\n", "missing or bad number"),
    ("id,x,y,radius,density\n0,1,1,0.1,2\n0,1,3,0.1,2\n", "twice"),
    ("id,x,y,radius,density\n0,1,1,-0.1,2\n", "radius"),
])
def test_a_bad_list_of_particles_is_refused(freefem, tmp_path, text, words):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    done = freefem("cases/settling_disk.edp", "-particles", file, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stdout + done.stderr
