"""Forces on walls: the flow alone, a closed box, the work of a lid, and the viscosity of a suspension against a body-fitted
computation."""
import numpy as np
import pytest

from tests.scenes import case
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table

SUSPENSION = "cases/sheared_suspension.edp"
HEAD = "id,x,y,radius,density\n"

# Stokes flow round a free disk in the middle of a periodic cell; the relative viscosity is the dissipation,
# and the disk turns so that it is least (no torque).
FITTED = """
real R = {radius};
int n = 40, m = 160;
border lower(t = 0, 1) {{ x = t; y = 0; label = 1; }}
border right(t = 0, 1) {{ x = 1; y = t; label = 2; }}
border upper(t = 0, 1) {{ x = 1 - t; y = 1; label = 3; }}
border left(t = 0, 1) {{ x = 0; y = 1 - t; label = 4; }}
border rim(t = 0, 2*pi) {{ x = 0.5 + R*cos(t); y = 0.5 + R*sin(t); label = 5; }}
mesh Th = buildmesh(lower(n) + right(n) + upper(n) + left(n) + rim(-m), fixedborder = true);
fespace Xh(Th, [P2, P2, P1], periodic = [[2, y], [4, y]]);
macro strain(a, b, c, d) (2*dx(a)*dx(c) + 2*dy(b)*dy(d) + (dy(a) + dx(b))*(dy(c) + dx(d))) // EOM
real plates = 1, turn = 0;
varf stokes([u, v, p], [a, b, q]) = int2d(Th)(strain(u, v, a, b) - p*(dx(a) + dy(b)) - q*(dx(u) + dy(v)) - 1e-10*p*q)
    + on(1, 3, u = plates*(y - 0.5), v = 0) + on(5, u = -turn*(y - 0.5), v = turn*(x - 0.5));
matrix A = stokes(Xh, Xh);
set(A, solver = UMFPACK);
Xh [u0, v0, p0], [u1, v1, p1];
real[int] b0 = stokes(0, Xh);
u0[] = A^-1*b0;
plates = 0; turn = 1;
real[int] b1 = stokes(0, Xh);
u1[] = A^-1*b1;
real both = int2d(Th)(strain(u0, v0, u1, v1)), own = int2d(Th)(strain(u1, v1, u1, v1));
cout.precision(10);
cout << "viscosity " << int2d(Th)(strain(u0, v0, u0, v0)) - both^2/own << " omega " << -both/own << endl;
"""


def disk(folder, radius):
    path = folder / "disk.csv"
    path.write_text(HEAD + f"3,0.5,0.5,{radius},1\n")
    return path


def test_the_plates_of_a_flow_without_disks_carry_its_shear(freefem, tmp_path):
    freefem(SUSPENSION, "-fraction", "0", "-reynolds", "4", "-tend", "0.2", "-out", tmp_path / "run")
    walls = read_table(tmp_path / "run" / "wallforces.csv")
    lower, upper = (walls["fx"][walls["label"] == label] for label in (13, 14))
    np.testing.assert_allclose(lower, 0.25, rtol=1e-8)
    np.testing.assert_allclose(upper, -0.25, rtol=1e-8)
    assert abs(walls["fy"]).max() < 1e-8


@pytest.mark.parametrize("radius, within", [(0.1, 0.025), (0.2, 0.01)])  # 6 and 13 elements across
def test_a_disk_adds_the_viscosity_of_a_body_fitted_computation(freefem, freefem_text, tmp_path, radius, within):
    words = freefem_text(FITTED.format(radius=radius)).stdout.split("viscosity ")[1].split()
    exact, omega = float(words[0]), float(words[2])
    assert exact - 1 == pytest.approx(2 * np.pi * radius**2, rel=0.25)  # Einstein, in two dimensions and far from walls
    freefem(SUSPENSION, "-fraction", "0", "-particles", disk(tmp_path, radius), "-convection", "0", "-dt", "0.0025", "-tend",
        "0.4", "-tolerance", "1e-7", "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    walls = read_table(tmp_path / "run" / "wallforces.csv")
    found = [abs(walls["fx"][walls["label"] == label][-1]) for label in (13, 14)]
    assert found[0] == pytest.approx(found[1], rel=1e-5)
    assert found[0] - 1 == pytest.approx(exact - 1, rel=within)
    assert run.table("particles")["omega"][-1] == pytest.approx(omega, rel=within)


def test_the_walls_of_a_closed_box_feel_what_its_momentum_misses(freefem, tmp_path):
    freefem("cases/settling_disk.edp", "-tend", "0.05", "-every", "0", "-cfl", "0", "-budget", "1", "-wallforces", "1", "-out",
        tmp_path / "run")
    walls, budget = (read_table(tmp_path / "run" / f"{name}.csv") for name in ("wallforces", "budget"))
    assert set(walls["label"]) == {3}
    for axis in "xy":
        given = np.diff(np.concatenate([[0], budget[f"walls_{axis}"]])) / np.diff(np.concatenate([[0], budget["t"]]))
        total = np.array([walls[f"f{axis}"][walls["t"] == t].sum() for t in budget["t"]])
        # the trapezoidal rule, but for the first step, of implicit Euler
        mean = np.concatenate([total[:1], (total[1:] + total[:-1]) / 2])
        np.testing.assert_allclose(mean, -given, atol=1e-9 * abs(given).max() + 1e-9)
    assert abs(total).max() > 1


CHANNEL = case("", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() (6*y*(1 - y)) "
    "// EOM", mu=0.1, gravity=0)


@pytest.mark.parametrize("convection", [0, 1])
def test_the_force_at_an_inlet_is_that_of_its_pressure(convection, freefem_text, tmp_path):
    freefem_text(CHANNEL, "-wallforces", 1, "-convection", convection, "-dt", 0.05, "-tend", 8, "-every", 8, "-tolerance", 1e-8,
        "-out", tmp_path / "run")
    walls = read_table(tmp_path / "run" / "wallforces.csv")
    force = {int(label): fx for label, fx in zip(walls["label"], walls["fx"])}
    # developed: the walls take 2 * 6 mu of a channel of length 1, the inlet gives it; across they bear the mean pressure
    assert force[11] == pytest.approx(-1.2, abs=1e-5)
    assert force[13] == pytest.approx(0.6, abs=1e-5) and force[14] == pytest.approx(0.6, abs=1e-5)
    across = dict(zip(walls["label"].astype(int), walls["fy"]))
    assert across[13] == pytest.approx(-0.6, abs=1e-5) and across[14] == pytest.approx(0.6, abs=1e-5)


AT_REST = "macro flowForceY() (-1.) // EOM\nmacro caseStart() { Qh start = 0.5 - y; flowP = start[]; } // EOM"


@pytest.mark.parametrize("slip", ["", "labelTop", "labelTop, labelLeft"])
def test_each_side_of_a_box_at_rest_bears_its_own_pressure(slip, freefem_text, tmp_path):
    sides = {"labelLeft": 11, "labelRight": 12, "labelBottom": 13, "labelTop": 14}
    walls = [name for name in sides if name not in slip]
    freefem_text(case("", walls=", ".join(walls), slip=slip, more=AT_REST, gravity=0), "-wallforces", 1, "-dt", 0.05, "-tend", 0.1,
        "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run" / "wallforces.csv")
    exact = {11: (0, 0), 12: (0, 0), 13: (0, -0.5), 14: (0, -0.5)}  # of a pressure 0.5 - y
    assert set(rows["label"]) == {sides[name] for name in walls}
    for label, fx, fy in zip(rows["label"], rows["fx"], rows["fy"]):
        assert (fx, fy) == pytest.approx(exact[int(label)], abs=1e-9)


def test_a_side_bears_the_whole_stress_where_its_velocity_varies(freefem_text, tmp_path):
    """A uniform shear u = y given all round: the sides that let it in and out bear mu along y, too."""
    sides = "labelLeft, labelRight, labelBottom, labelTop"
    text = case("", walls="", moving=sides, more="macro boundaryU() y // EOM\nmacro caseStart() { Wh shear = y; flowU = shear[]; "
        "} // EOM", mu=0.1, gravity=0)
    freefem_text(text, "-wallforces", 1, "-convection", 0, "-dt", 0.05, "-tend", 0.1, "-every", 0.1, "-tolerance", 1e-10, "-out",
        tmp_path / "run")
    rows = read_table(tmp_path / "run" / "wallforces.csv")
    exact = {11: (0, 0.1), 12: (0, -0.1), 13: (0.1, 0), 14: (-0.1, 0)}
    assert set(rows["label"]) == set(exact)
    for label, fx, fy in zip(rows["label"], rows["fx"], rows["fy"]):
        assert (fx, fy) == pytest.approx(exact[int(label)], abs=1e-9)


def bump(file):
    """A mesh of a channel whose floor (label 3) has a bump (label 6), half a disk."""
    return f"""
    border b1(s = -2, -0.5) {{ x = s; y = 0; label = 3; }}
    border b2(s = pi, 0) {{ x = 0.5*cos(s); y = 0.5*sin(s); label = 6; }}
    border b3(s = 0.5, 2) {{ x = s; y = 0; label = 3; }}
    border b4(s = 0, 1.5) {{ x = 2; y = s; label = 12; }}
    border b5(s = 2, -2) {{ x = s; y = 1.5; label = 14; }}
    border b6(s = 1.5, 0) {{ x = -2; y = s; label = 11; }}
    savemesh(buildmesh(b1(15) + b2(16) + b3(15) + b4(15) + b5(40) + b6(15)), "{file}");
    """


@pytest.mark.parametrize("floor", ["wall", "slip"])
def test_a_flow_alone_has_the_forces_of_one_with_particles(floor, freefem_text, tmp_path):
    """On all walls, and on a cylinder that ends at the floor: forces.csv counted what the floor bears at their common nodes to it
    (lift 3 % too large)."""
    mesh, runs = tmp_path / "bump.mesh", {}
    text = bump(mesh) + case("", walls="labelCylinder, labelWall" if floor == "wall" else "labelCylinder", slip="labelWall"
        if floor == "slip" else "",
                             moving="labelLeft, labelTop", outlet="labelRight", more="macro boundaryU() y // EOM", mu=1, gravity=0)
    for driver in ("resolved", "flow"):
        own = text if driver == "resolved" else text.replace("resolved.edp", "flow.edp").replace(", gravityX = 0, gravityY = 0", "")
        forces = ["-forces", 1] if driver == "flow" else []
        freefem_text(own, "-mesh", mesh, "-wallforces", 1, *forces, "-dt", 0.02, "-tend", 0.1, "-every", 0.1, "-tolerance", 1e-8,
            "-out", tmp_path / driver)
        runs[driver] = read_table(tmp_path / driver / "wallforces.csv")
    for name in ("label", "fx", "fy"):
        np.testing.assert_allclose(runs["flow"][name], runs["resolved"][name], atol=1e-9)
    rows, own = runs["flow"], read_table(tmp_path / "flow" / "forces.csv")
    fx, fy = (rows[name][rows["label"] == 6][-1] for name in ("fx", "fy"))
    assert (own["force_x"][-1], own["force_y"][-1]) == pytest.approx((fx, fy), abs=1e-9) and fy < -1


def test_a_journal_bearing_bears_what_wannier_says_after_some_steps(freefem_text, tmp_path):
    """A cylinder that turns off the middle of another one, mu dt/(rho gap^2) above 100. In a closed flow, too, the walls hold the
    fluid within a step:
    without that the force was at 0.82 of its value after 50 steps, in narrower gaps at 0.06."""
    mesh, inner, outer, off, mu = tmp_path / "bearing.mesh", 0.5, 1, 0.25, 1000
    rings = f"""
    border big(s = 0, 2*pi) {{ x = {outer}*cos(s); y = {outer}*sin(s); label = 3; }}
    border small(s = 0, 2*pi) {{ x = {off} + {inner}*cos(s); y = {inner}*sin(s); label = 6; }}
    savemesh(buildmesh(big(80) + small(-60)), "{mesh}");
    """
    more = f"macro boundaryU() (-y) // EOM\nmacro boundaryV() (x - {off}) // EOM"
    text = rings + case("", walls="labelWall", moving="labelCylinder", more=more, mu=mu, gravity=0)
    freefem_text(text, "-mesh", mesh, "-wallforces", 1, "-dt", 0.02, "-tend", 0.6, "-every", 0.6, "-tolerance", 1e-7, "-out",
        tmp_path / "run")
    rows = read_table(tmp_path / "run" / "wallforces.csv")
    # bipolar coordinates of the two cylinders: Quart. Appl. Math. 8 (1950) 1
    pole = np.sqrt(((outer + inner) ** 2 - off**2) * ((outer - inner) ** 2 - off**2)) / (2 * off)
    a, b = np.arcsinh(pole / inner), np.arcsinh(pole / outer)
    across = 4 * np.pi * mu * inner * np.sinh(b) * np.sinh(a - b) / ((a - b) * (np.sinh(a) ** 2 + np.sinh(b) ** 2) - 2
        * np.sinh(a) * np.sinh(b) * np.sinh(a - b))
    for label, sign in ((6, 1), (3, -1)):
        fx, fy = (rows[name][rows["label"] == label][-1] for name in ("fx", "fy"))
        assert fy == pytest.approx(sign * across, rel=0.015) and abs(fx) < 0.005 * across


# The lid moves faster in its middle than at its ends, where it meets the walls; nothing of the budget is taken from the library:
# the shear at the lid, the strain and the
# kinetic energy of fluid and disk (twice as heavy) are integrated here.
LID = """macro boundaryU() (16*(x*(1 - x))^2) // EOM
macro caseStart() outHeader("lid.csv", "t,work,dissipation,energy"); // EOM
macro caseStep() {
    Wh lidU, lidV;
    lidU[] = flowU; lidV[] = flowV;
    real[int] lidRow = [timeNow, int1d(Th, labelTop)(mu*(dy(lidU) + dx(lidV))*lidU), int2d(Th)(mu*(2*dx(lidU)^2 + 2*dy(lidV)^2 + (dy(lidU) + dx(lidV))^2)), int2d(Th)(0.5*rhoFluid*(lidU^2 + lidV^2))];
    outRow("lid.csv", lidRow);
} // EOM
"""


def budget(freefem_text, folder, cells, dt):
    folder.mkdir()
    text = f'int[int] sides = [13, 12, 14, 11];\nsavemesh(square({cells}, {cells}, label = sides, flags = 2), "{folder}/box.mesh");\n'
    text += case("bodyDisk(0.45, 0.6, 0.12, 2);", walls="labelLeft, labelRight, labelBottom", moving="labelTop", mu=0.05,
        gravity=-1, more=LID)
    freefem_text(text, "-mesh", folder / "box.mesh", "-dt", dt, "-cfl", 0, "-every", 0, "-tend", 1, "-out", folder / "run")
    run = RunFolder(folder / "run")
    table, disk = run.table("lid"), run.particles
    # the disk's own mass over the fluid's that it displaces: 2 - 1 is not in the integral of the mesh
    area, moment = np.pi * 0.12**2, np.pi * 0.12**4 / 2
    energy = table["energy"] + 0.5 * area * (disk["u"]**2 + disk["v"]**2) + 0.5 * moment * disk["omega"]**2
    fallen = area * (0.6 - disk["y"])
    steps = np.diff(table["t"])
    sums = {name: np.concatenate([[0], np.cumsum(0.5 * (table[name][1:] + table[name][:-1]) * steps)]) for name in ("work",
        "dissipation")}
    return table["t"], sums, energy - energy[0], fallen - fallen[0]


@pytest.mark.parametrize("cells, dt, most", [(16, 0.02, 0.01), (24, 0.01, 0.004)])
def test_the_work_of_a_lid_is_stored_lifts_a_disk_or_is_dissipated(cells, dt, most, freefem_text, tmp_path):
    """Four and six elements across the disk, from 0.2 s on, behind the start at once. 1.4 % of the work lifts the disk, 3.6 % is
    kinetic energy, the rest is dissipated."""
    t, sums, energy, fallen = budget(freefem_text, tmp_path / "lid", cells, dt)
    begin = np.searchsorted(t, 0.2)
    work, dissipated, stored, given = (values[-1] - values[begin] for values in (sums["work"], sums["dissipation"], energy, fallen))
    assert given < -0.01 * work and stored > 0.03 * work
    assert abs(work + given - dissipated - stored) < most * work
