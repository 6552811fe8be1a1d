"""Flux through sides and forces on walls in three dimensions: exact flows, the balance of forces around a held sphere."""
import numpy as np
import pytest

from tools.base.tables import read_table

# a box of 1 x 1 x 2 whose long axis lies along z, x or y: walls at y = -1/2 (label 3) and 1/2 (4), planes of symmetry at x,
# inlet 1, outlet 2, before the axes are exchanged
BOX = """
load "msh3"
mesh3 T = cube(4, 4, 8, [x - 0.5, y - 0.5, 2*z]);
int[int] sides = [1, 3, 2, 9, 3, 4, 4, 8, 5, 1, 6, 2];
T = change(T, label = sides);
savemesh(movemesh3(T, transfo = [AXES]), "FILE");
"""
PLATES = """
include "lib/spheres/case.idp"
optCase("plates", "a stream between plates, one of which moves along itself");
optDefault("-dt", "0.05");
real rhoFluid = 2, mu = 0.3, gravityX = 0, gravityY = 0, gravityZ = 0;
int[int] flowNoSlip = [3], flowSlip = [8, 9], flowMoving = [1, 4], flowOutlet = [2];
func real stream(real h) {{ return 1 - 4*h^2 + 0.5*(h + 0.5); }}
macro boundary{along}() stream({across}) // EOM
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {particles} // EOM
include "scripts/spheres.edp"
"""
AXES = {"xyz": "x, y, z", "zxy": "z, x, y", "yzx": "y, z, x"}  # what stands along x, y, z after the exchange


def plates(order, particles, tmp_path, freefem_text):
    mesh = tmp_path / "box.mesh"
    freefem_text(BOX.replace("AXES", AXES[order]).replace("FILE", str(mesh)))
    at = {old: "xyz"[order.index(old)] for old in "xyz"}
    return mesh, PLATES.format(along="UVW"[order.index("z")], across=at["y"], particles=particles), \
        [f"f{at[old]}" for old in "xyz"]


@pytest.mark.parametrize("order", list(AXES))
def test_a_stream_between_plates_has_its_exact_fluxes_and_forces(order, freefem_text, tmp_path):
    """Of the second degree, with a pressure that is linear: exact in these elements. Drag 8 mu on both plates, and mu/2 times their
    area from one to the other; the pressure 8 mu (2 - z) lifts them and pushes on the inlet."""
    mesh, text, names = plates(order, "", tmp_path, freefem_text)
    freefem_text(text, "-mesh", mesh, "-tend", 8, "-cfl", 0, "-tolerance", 1e-9, "-fluxes", 1, "-wallforces", 1, "-out",
        tmp_path / "run")
    flux, force = read_table(tmp_path / "run/fluxes.csv"), read_table(tmp_path / "run/wallforces.csv")
    last = flux["t"] == flux["t"].max()
    assert dict(zip(flux["label"][last], flux["flux"][last])) == pytest.approx({1: -2 / 3 - 0.25, 2: 2 / 3 + 0.25}, abs=1e-5)
    last = force["t"] == force["t"].max()
    found = dict(zip(force["label"][last], np.array([force[name][last] for name in names]).T))
    mu = 0.3
    for label, exact in ((3, (0, -16 * mu, 8 * mu + mu)), (4, (0, 16 * mu, 8 * mu - mu)), (1, (0, mu / 2, -16 * mu))):
        assert found[label] == pytest.approx(np.array(exact), abs=1e-4)


def test_forces_on_walls_inlet_and_a_held_sphere_balance(freefem_text, tmp_path):
    """Slow flow: what pushes at the inlet is borne by walls and sphere; the outlet is free. """
    mesh, text, names = plates("zxy", "sphereHeld(bodySphere(0.9, 0.05, -0.1, 0.3, 2));", tmp_path, freefem_text)
    words = ["-mesh", mesh, "-tend", 6, "-cfl", 0, "-tolerance", 1e-8, "-convection", 0, "-forces", 1, "-fluxes", 1,
        "-wallforces", 1]
    freefem_text(text, *words, "-out", tmp_path / "run")
    walls, sphere = read_table(tmp_path / "run/wallforces.csv"), read_table(tmp_path / "run/forces.csv")
    last = walls["t"] == walls["t"].max()
    along = names[2]
    assert sphere[along][-1] > 5 * 0.3 and walls[along][last].min() < -sphere[along][-1]
    assert abs(walls[along][last].sum() + sphere[along][-1]) < 1e-3 * sphere[along][-1]


def test_fluxes_of_a_closed_box_are_refused(freefem_refused, tmp_path):
    assert "nothing flows through" in freefem_refused(3, "cases/settling_sphere.edp", "-fluxes", 1, "-out", tmp_path / "run")


def test_a_run_goes_on_where_its_last_sphere_leaves_from_a_wall(freefem_text, tmp_path):
    """It presses on a wall in the step before it has left; its contact was written in the step after, and the run ended with
    status 8."""
    sphere = "sphereMoves(bodySphere(1.45, -0.166, 0, 0.33, 200), 9.2, -1, 0);"
    mesh, text, _ = plates("zxy", sphere, tmp_path, freefem_text)
    freefem_text(text, "-mesh", mesh, "-tend", 0.3, "-cfl", 0, "-out", tmp_path / "run")
    touched, gone = read_table(tmp_path / "run/contacts.csv"), read_table(tmp_path / "run/exits.csv")
    assert gone["label"].tolist() == [2] and gone["t"][0] - 0.051 < touched["t"].max() < gone["t"][0]
