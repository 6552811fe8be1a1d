"""Lubrication films of spheres: the exact resistance, the matrix of the films, a fall onto a floor."""
import numpy as np
import pytest
from scipy.integrate import quad

from tests.conftest import make_mesh
from tools.base.tables import read_table
from tools.peers.spheres_slow import approach

# Two spheres near each other, one of them near the plane of symmetry y = 0, the other near the floor z = 0.
FILMS = """
include "lib/core/errors.idp"
load "msh3"
int[int] flowNoSlip = [2, 3, 4, 5, 6], flowMoving(0), flowOutlet(0), flowSlip = [1];
real mu = 0.7, rhoFluid = 1, gravityX = 0, gravityY = 0, gravityZ = 0;
int withConvection = 0, withGhost = 0;
real momentumTolerance = 1e-6, stabilise = 0;
mesh3 Th = cube(12, 12, 12, [3*x, 3*y, 3*z]);
include "lib/spheres/spheres.idp"
bodySphere(1.1, 0.6 + 0.03, 1.2, 0.6, 1);
bodySphere(1.1 + 0.75*1.05, 0.6 + 0.03, 1.2 - sqrt(1 - 0.75^2)*1.05, 0.4, 1);
include "lib/spheres/sphere_contacts.idp"
touchWalls();
solidFind();
squeezeFind();
cout.precision(15);
real[int] q(6), f(6);
for (int k = 0; k < 6; ++k) { q = 0.; q[k] = 1; f = squeezeA*q; for (int l = 0; l < 6; ++l) cout << "A " << f[l] << endl; }
real[int] size(0);
squeezeSizes(size);
cout << "size " << size[0] << " " << size[1] << endl;
"""


def missing(first, second, gap, size, mu, surfaces=2):
    """What a film adds, kg/s: the terms 1/D and ln(1/D) at the gap less those at the mesh's gap (Jeffrey & Onishi 1984)."""
    ratio = second / first
    wide = gap + 0.07 * surfaces * size * min(1, 2 * (1 - gap / size))
    near, log = 2 * ratio**2 / (1 + ratio) ** 3, ratio * (1 + 7 * ratio + ratio**2) / (5 * (1 + ratio) ** 3)
    scaled = 2 / (first + second)
    return 6 * np.pi * mu * first * (near / scaled * (1 / gap - 1 / wide) + log * np.log(wide / gap))


def test_the_exact_resistance_is_the_published_one():
    """Brenner's table: cosh a = 1.5431, 3.7622 have 3.0361, 1.4129; near the plane it is 1/gap + ln(1/gap)/5 + 0.971 (Cox & Brenner
    1967), between equal spheres 1/(4 gap) + 9/20 ln(1/gap) + ... (Jeffrey & Onishi 1984)."""
    assert approach(np.cosh(1) - 1) == pytest.approx(3.0361, abs=6e-5)
    assert approach(np.cosh(2) - 1) == pytest.approx(1.4129, abs=6e-5)
    assert approach(1e-4) == pytest.approx(1e4 + 0.2 * np.log(1e4) + 0.9713, rel=1e-6)
    logs = [approach(gap, free=True) - 1 / (4 * gap) for gap in (1e-3, 1e-4)]
    assert logs[1] - logs[0] == pytest.approx(0.45 * np.log(10), rel=0.01)
    with pytest.raises(ValueError):
        approach(0)


def test_films_act_along_the_gaps(freefem_text):
    """The matrix is that of the films of a pair, a floor and a plane of symmetry, whose image is another sphere."""
    text = freefem_text(FILMS).stdout
    values = np.array([float(line.split()[1]) for line in text.splitlines() if line.startswith("A ")]).reshape(6, 6)
    sizes = [float(word) for word in text.split("size ")[1].split()[:2]]
    pair = missing(0.6, 0.4, 0.05, np.mean(sizes), 0.7)
    e = np.array([-0.75, 0, np.sqrt(1 - 0.75**2)])
    expected = np.zeros((2, 3, 2, 3))
    for i, j, sign in ((0, 0, 1), (0, 1, -1), (1, 0, -1), (1, 1, 1)):
        expected[i, :, j] = sign * pair * np.outer(e, e)
    expected[0, 1, 0, 1] += 2 * missing(0.6, 0.6, 0.06, sizes[0], 0.7)
    expected[1, 2, 1, 2] += missing(0.4, 1e9, 1.2 - 1.05 * np.sqrt(1 - 0.75**2) - 0.4, sizes[1], 0.7, 1)
    assert values.reshape(3, 2, 3, 2).transpose(1, 0, 3, 2) == pytest.approx(expected, rel=1e-6, abs=1e-9 * pair)


FALL = """
include "lib/spheres/case.idp"
optCase("fall", "a sphere falls onto a floor in slow flow");
optDefault("-dt", "10"); optDefault("-convection", "0"); optDefault("-cfl", "0"); optDefault("-tolerance", "1e-6");
real rhoFluid = 0.01, mu = 1, gravityX = 0, gravityY = 0, gravityZ = -0.045, R = 1;
int[int] flowNoSlip = [labelWall], flowSlip = [labelLeft, labelFront], flowMoving(0), flowOutlet(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodySphere(0, 0, 1 + 0.6, R, 1.01); // EOM
include "scripts/spheres.edp"
"""


def test_a_sphere_falls_onto_a_floor_as_fast_as_exact(freefem_text, tmp_path):
    """Four elements to the diameter; without inertia. The time between gaps of 0.4 and 0.05 radii is the integral of the exact
    resistance, within 15 %; without films it is less than 70 % of that."""
    mesh = make_mesh(tmp_path / "box.mesh", "settling_sphere", "--size", 0.5, "--width", 24, "--height", 24, "--corridor", 1.5,
        "--corridor-top", 3.3, "--growth", 8, "--coarse", 8)
    exact, found = 100 * quad(approach, 0.05, 0.4)[0], []
    for film, end in ((1, 310), (0, 250)):
        freefem_text(FALL, "-mesh", mesh, "-film", film, "-tend", end, "-out", tmp_path / f"run{film}")
        rows = read_table(tmp_path / f"run{film}/particles.csv")
        assert rows["z"][-1] < 1.05
        found.append(np.diff(np.interp([-0.4, -0.05], 1 - rows["z"], rows["t"]))[0])
    assert found[0] == pytest.approx(exact, rel=0.15) and found[1] < 0.7 * exact
