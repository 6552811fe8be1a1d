"""Fluid that films enclose leaves through their gaps, against a resistance."""
import numpy as np
import pytest

from tests.conftest import standard_alone
from tests.scenes import case
from tests.tables import numbers
from tools.base.run_folder import RunFolder
from tools.validation.films_of_pockets import (CORNER, FITTED_CORNER, FITTED_LATTICE, FITTED_POCKET, LATTICE, POCKET, WITHIN,
    corner_words, lattice_words, of_corner, of_lattice, of_pocket, pocket_words)


def run_words(options):
    return [word for pair in options.items() for word in pair]


@pytest.mark.parametrize("gap, tilt", [(0.05, 0), (0.02, 17)])
def test_a_disk_that_sinks_into_a_corner_presses_the_fluid_out(gap, tilt, freefem, tmp_path):
    """It met a fiftieth of the resistance at 0.02 radii."""
    freefem(CORNER, *run_words(corner_words(gap, tilt=tilt)), "-out", tmp_path / "run")
    assert of_corner(numbers(tmp_path / "run", "forces.csv"), gap, tilt) == pytest.approx(FITTED_CORNER[gap], rel=WITHIN)


@pytest.mark.parametrize("gap, apart, tilt", [(0.1, 0.1, 0), (0.02, 0.02, 25)])
def test_three_disks_enclose_fluid(gap, apart, tilt, freefem, tmp_path):
    """The disk that sinks between the others met a sixth of the resistance, and a two hundredth."""
    freefem(POCKET, *run_words(pocket_words(gap, apart, tilt=tilt)), "-out", tmp_path / "run")
    found = of_pocket(numbers(tmp_path / "run", "forces.csv"), gap, tilt)
    assert found == pytest.approx(FITTED_POCKET[gap, apart], rel=WITHIN)


@pytest.mark.parametrize("gap, place", [(0.05, (0, 0)), (0.02, (3, 2.2))])
def test_disks_enclose_fluid_where_the_domain_is_periodic_in_both_directions(gap, place, freefem, tmp_path):
    """A disk of a lattice across the seams; without the flow through gaps it has a twelfth of the resistance and less."""
    freefem(LATTICE, *run_words({**lattice_words(gap, place), "-tend": 0.5}), "-out", tmp_path / "run")
    assert of_lattice(numbers(tmp_path / "run", "forces.csv"), gap) == pytest.approx(FITTED_LATTICE[gap], rel=WITHIN)


BESIDE = """macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelLeft, y], [labelRight, y]]);
    fespace Qh(Th, P1, periodic = [[labelLeft, y], [labelRight, y]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight] // EOM
macro caseMotion(now) givenMotion(0, 0.001, -0.001, 0); // EOM
"""


def test_a_pocket_under_disks_is_the_same_across_the_seam_and_below_an_outlet(freefem_text, tmp_path):
    """Three disks beside each other on a floor, periodic along it. Where the top lets through, a flux round the period is free;
    there was no resistance then."""
    found = []
    for name, middle, walls, outlet in (("shut", 0.5, "labelBottom, labelTop", ""), ("open", 0.5, "labelBottom", "labelTop"),
            ("seam", 0.0, "labelBottom", "labelTop")):
        bodies = " ".join(f"bodyHeld(bodyDisk({(middle + k * 0.3125) % 1}, 0.16, 0.15, 1));" for k in (-1, 0, 1))
        text = case(f"{{ {bodies} }}", walls=walls, outlet=outlet, more=BESIDE, gravity=0, mu=1)
        freefem_text(text.replace("flowPeriodX = 0", "flowPeriodX = 1"), "-dt", 0.002, "-cfl", 0, "-tend", 0.02, "-every", 0,
            "-forces", 1, "-film", 1, "-out", tmp_path / name)
        forces = RunFolder(tmp_path / name).table("forces")
        found.append([forces[c][forces["id"] == 1][-1] for c in ("fx", "fy")])
    assert found[2] == pytest.approx(found[1], rel=0.01) and found[1] == pytest.approx(found[0], rel=0.05)


def cornered(shape):
    """A disk that moves slowly into the lower left corner of a box of 2 x 2, with gaps of a twentieth of its radius."""
    motion = "macro caseMotion(now) givenMotion(0, -0.001, -0.001, 0); // EOM\n"
    return case(f"bodyHeld({shape});", walls="labelLeft, labelRight, labelBottom, labelTop", more=motion, gravity=0, mu=1)


def test_the_pressure_of_a_pocket_is_on_the_walls_around_it(freefem_text, tmp_path):
    """The floor bears the vertical part and the side wall the horizontal one; the bound is that of the steady balance."""
    freefem_text(cornered("bodyDisk(0.2625, 0.2625, 0.25, 1)"), "-dt", 0.01, "-cfl", 0, "-tend", 0.4, "-every", 0, "-forces", 1,
        "-wallforces", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    walls, forces = run.table("wallforces"), run.table("forces")
    late = walls["t"] == walls["t"][-1]
    by_label = {int(label): np.array([fx, fy]) for label, fx, fy in zip(walls["label"][late], walls["fx"][late], walls["fy"][late])}
    body = np.array([forces["fx"][-1], forces["fy"][-1]])
    assert body.min() > 20000 * 0.001  # without a pocket: about 1300
    assert sum(by_label.values()) == pytest.approx(-body, rel=0.02)
    sides = sorted(by_label.values(), key=lambda force: force[0])
    floors = sorted(by_label.values(), key=lambda force: force[1])
    assert sides[0][0] == pytest.approx(-body[0], rel=0.1) and floors[0][1] == pytest.approx(-body[1], rel=0.1)


def test_a_disk_as_a_body_of_any_shape_has_the_same_pocket(freefem_text, tmp_path):
    """Lines of points in place of the formulas of disks."""
    found = []
    for name, shape in (("disk", "bodyDisk(0.2625, 0.2625, 0.25, 1)"), ("clump", "CLUMP")):
        text = cornered(shape)
        if name == "clump":
            text = text.replace("bodyHeld(CLUMP);", "{ real[int] cx = [0.2625], cy = [0.2625], cr = [0.25]; "
                "bodyHeld(bodyClump(cx, cy, cr, 1)); }").replace('include "lib/mesh/labels.idp"', 'include "lib/mesh/labels.idp"\n'
                'include "lib/bodies/shapes.idp"')
        freefem_text(text, "-dt", 0.01, "-cfl", 0, "-tend", 0.2, "-every", 0, "-forces", 1, "-out", tmp_path / name)
        forces = RunFolder(tmp_path / name).table("forces")
        found.append(forces["fx"][-1] + forces["fy"][-1])
    assert found[1] == pytest.approx(found[0], rel=0.15)


LEFT = """macro caseStep() {
    real[int] r(3*bodyNumber), q(0), f(3*bodyNumber), left(3*bodyNumber);
    for (int k = 0; k < 3*bodyNumber; ++k) r[k] = (1 + 0.3*k)*filmInertia[k];
    f = 0.;
    filmSolve(r, q); filmApply(q, f);
    left = r - f; left -= filmInertia .* q;
    left ./= r; f ./= r;
    cout << "left " << filmFluxN << " " << f.linfty << " " << left.linfty << endl;
} // EOM
"""


def test_films_and_inertia_of_a_preconditioned_residual_are_the_residual(freefem_text, tmp_path):
    """The solver takes the forces of films from this; three disks on a floor enclose fluid, one beside them does not."""
    disks = ((0.3, 0.161, 2), (0.615, 0.163, 1), (0.46, 0.435, 3), (0.84, 0.8, 1))
    text = case(" ".join(f"bodyDisk({x}, {y}, 0.15, {rho});" for x, y, rho in disks), walls="labelBottom, labelTop, labelLeft, "
        "labelRight", more=LEFT, mu=1)
    done = freefem_text(standard_alone(text), "-dt", 0.002, "-cfl", 0, "-tend", 0.006, "-every", 0, "-film", 1, "-out",
        tmp_path / "run")
    rows = np.array([[float(v) for v in line.split()[1:]] for line in done.stdout.splitlines() if line.startswith("left ")])
    assert len(rows) == 3 and rows[:, 0].min() >= 4 and rows[:, 1].min() > 0.5 and rows[:, 2].max() < 1e-9
