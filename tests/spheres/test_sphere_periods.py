"""Periodic sides in three dimensions: lattices of fixed spheres, spheres that pass a side, contacts across it, refusals."""
import numpy as np
import pytest

from tests.cells import scene
from tests.conftest import make_mesh
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    """A cube of side 1, six elements on a side."""
    return make_mesh(tmp_path_factory.mktemp("cell") / "cell.mesh", "sphere_lattice", "--size", 1 / 6, "--octants", "alike")


def apart(a, b):
    """Largest distance of coordinates modulo 1."""
    return abs((a - b + 0.5) % 1 - 0.5).max()


def test_a_scene_that_is_shifted_across_the_sides_is_the_same(cell, freefem_text, tmp_path):
    """By three and four elements: spheres pass the sides at other times, touch across them or within the cell, and move alike."""
    runs = []
    for k, (x, y) in enumerate(((0, 0), (0.5, 2 / 3))):
        freefem_text(scene(), "-mesh", cell, "-x", x, "-y", y, "-out", tmp_path / f"run{k}")
        rows, fluid = read_table(tmp_path / f"run{k}/particles.csv"), read_table(tmp_path / f"run{k}/fluid.csv")
        info = RunFolder(tmp_path / f"run{k}").info
        assert info["period"] == [1, 1, 0] and info["low"][:2] == [0, 0] and set(info["fluid"]) == {"density", "viscosity"}
        assert set(info["labels"]) == {"no slip", "moving", "outlet", "slip"} and len(info["labels"]["no slip"]) > 0
        assert rows["x"].min() >= 0 and rows["x"].max() < 1
        assert max(abs(np.diff(rows["x"][rows["id"] == one])).max() for one in (0, 1)) > 0.5
        assert fluid["contacts"].max() == 1 and fluid["worst_gap"].min() > -1e-6 * 0.2
        runs.append((rows, x, y))
    (first, *_), (second, x, y) = runs
    assert apart(first["x"] + x, second["x"]) < 1e-6 and apart(first["y"] + y, second["y"]) < 1e-6
    assert abs(first["w"] - second["w"]).max() < 1e-6 and abs(first["omega_y"] - second["omega_y"]).max() < 1e-5


def test_a_periodic_cell_is_the_symmetric_eighth(freefem, tmp_path):
    """On a mesh with the mirror images of the cells of the eighth, to rounding: 4 elements to the diameter."""
    mesh, found = make_mesh(tmp_path / "eighth.mesh", "sphere_array", "--size", 0.125), []
    for case, options in (("sphere_array", ["-mesh", mesh]), ("sphere_lattice", [])):
        freefem(f"cases/{case}.edp", *options, "-tend", 0.1, "-tolerance", 1e-9, "-out", tmp_path / case)
        found.append(read_table(tmp_path / case / "array.csv")["drag"])
    assert found[0] == pytest.approx(found[1], rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("lattice, exact", [("simple", 2.810), ("body", None), ("face", None)])
def test_drag_in_lattices(lattice, exact, freefem, tmp_path):
    """Zick & Homsy (1982) at a solid fraction of 0.064 with 4 elements to the diameter; Hasimoto (1959) at 0.027, with 4.7 and 3.7.
    The lattice is shifted across the sides."""
    options = ["-x", 0.03, "-y", 0.97, "-z", 0.02, "-tend", 0.6]
    if not exact:
        c, b = 0.027, 0.329 if lattice == "body" else 0.302
        exact = 1 / (1 - 1.791 * c ** (1 / 3) + c - b * c**2)
        mesh = make_mesh(tmp_path / "fine.mesh", "sphere_lattice", "--size", 1 / 16)
        options = ["-lattice", lattice, "-fraction", c, "-mesh", mesh, "-tend", 1]
    freefem("cases/sphere_lattice.edp", *options, "-out", tmp_path / "run")
    assert read_table(tmp_path / "run/array.csv")["drag"][-1] == pytest.approx(exact, rel=0.015)


@pytest.mark.parametrize("change, status, said", [
    ({"spaces": ""}, 3, "not periodic as the sides"),
    ({"labels": "-1"}, 3, "for which the case has no condition"),
    ({"labels": "labelLeft, labelFront, labelBack"}, 3, "normal to x are not one on each side"),
    ({"radius": 0.5001}, 5, "overlaps its image"),
    ({"more": "sphereWaits(0.2, 0.2, 0.5, 0.1, 1, 0.1);"}, 3, "not for periodic sides"),
])
def test_what_is_not_a_periodic_scene_is_refused(change, status, said, cell, freefem_text, tmp_path):
    run = freefem_text(scene(**change), "-mesh", cell, "-out", tmp_path / "run", check=False)
    assert run.returncode == status and said in run.stderr and run.stderr.count("\n") == 1


CURLED = """
include "lib/spheres/case.idp"
optCase("curled", "a decaying flow that is parallel to its vorticity");
optDefault("-dt", "0.01"); optDefault("-tend", "0.2"); optDefault("-cfl", "0"); optDefault("-tolerance", "1e-8");
real rhoFluid = 1, mu = 0.001, gravityX = 0, gravityY = 0, gravityZ = 0, q = 2*pi;
macro flowSpaces() fespace spaceWh(Th, P2, periodic = [[labelLeft, y, z], [labelRight, y, z], [labelFront, x, z],
    [labelBack, x, z], [labelBottom, x, y], [labelTop, x, y]]); fespace spaceQh(Th, P1, periodic = [[labelLeft, y, z],
    [labelRight, y, z], [labelFront, x, z], [labelBack, x, z], [labelBottom, x, y], [labelTop, x, y]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight, labelFront, labelBack, labelBottom, labelTop] // EOM
int[int] flowNoSlip(0), flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) { return 1; }
macro caseParticles() // EOM
macro caseStart() {
    spaceWh f = sin(q*z) + 0.6*cos(q*y), g = 0.8*sin(q*x) + cos(q*z), h = 0.6*sin(q*y) + 0.8*cos(q*x);
    spaceU = f[]; spaceV = g[]; spaceW = h[];
    outHeader("error.csv", "t,error");
} // EOM
macro caseStep() if (timeNow > 0.1999) {
    real fall = exp(-mu*q^2*timeNow), error = 0;
    spaceWh f, g, h;
    f[] = spaceU; g[] = spaceV; h[] = spaceW;
    error = int3d(Th)((f - fall*(sin(q*z) + 0.6*cos(q*y)))^2 + (g - fall*(0.8*sin(q*x) + cos(q*z)))^2
        + (h - fall*(0.6*sin(q*y) + 0.8*cos(q*x)))^2);
    real[int] row = [timeNow, sqrt(error/2)];
    outRow("error.csv", row);
} // EOM
include "scripts/spheres.edp"
"""


@pytest.mark.slow
def test_stabilisation_keeps_the_order(freefem_text, tmp_path):
    """An exact flow whose vorticity is parallel to it (Arnold 1965; Childress 1970), at Reynolds numbers of the elements above 100:
    the error falls at least in second order, and to less than half of that without stabilisation."""
    error = {}
    for cells, factor in ((4, 0.1), (8, 0.1), (8, 0)):
        mesh = make_mesh(tmp_path / f"{cells}_{factor}.mesh", "sphere_lattice", "--size", 1 / cells)
        freefem_text(CURLED, "-mesh", mesh, "-stabilise", factor, "-out", tmp_path / f"run_{cells}_{factor}")
        error[cells, factor] = read_table(tmp_path / f"run_{cells}_{factor}/error.csv")["error"][-1]
    assert error[4, 0.1] > 4 * error[8, 0.1] and error[8, 0.1] < 0.5 * error[8, 0]
