"""The flow without particles against exact solutions: Poiseuille, Taylor and Green, a closed box."""
import numpy as np

from tests.conftest import mesh, run_freefem
from tools.base.tables import read_table


def test_poiseuille_is_exact(meshes, run_folder):
    coarse = mesh(meshes, "poiseuille", "--size", 0.25)
    run_freefem("cases/poiseuille.edp", "-mesh", coarse, "-dt", 0.05, "-out", run_folder)
    off = read_table(run_folder / "errors.csv")
    assert max(off["velocity_x"][-1], off["velocity_y"][-1], off["pressure"][-1]) < 1e-9


def taylor_green(folder, file, **options):
    """(velocity error, pressure error) at the end of a run."""
    words = [w for name, value in options.items() for w in (f"-{name}", value)]
    run_freefem("cases/taylor_green.edp", "-mesh", file, "-out", folder, *words)
    off = read_table(folder / "errors.csv")
    return np.array([off["velocity"][-1], off["pressure"][-1]])


def test_third_order_of_the_velocity_in_space(meshes, tmp_path):
    coarse, fine = (mesh(meshes, "taylor_green", "--size", size) for size in (1 / 10, 1 / 20))
    first = taylor_green(tmp_path / "a", coarse, dt=0.002, tend=0.02)
    second = taylor_green(tmp_path / "b", fine, dt=0.002, tend=0.02)
    assert np.log2(first / second)[0] > 2.8


def test_second_order_in_time(meshes, tmp_path):
    fine = mesh(meshes, "taylor_green", "--size", 1 / 24)
    errors = [taylor_green(tmp_path / f"r{k}", fine, dt=dt, tend=0.2) for k, dt in enumerate((0.02, 0.01))]
    velocity, pressure = np.log2(errors[0] / errors[1])
    assert velocity > 1.9 and pressure > 1.4


def test_restless_fluid_in_a_closed_box_only_loses_energy(freefem_text, run_folder):
    scene = """
    include "lib/case.idp"
    optCase("box", "decay of a rough flow at a high cell Reynolds number");
    optDefault("-mesh", "MESH");
    include "lib/mesh/labels.idp"
    real rhoFluid = 1, mu = 1e-6;
    int[int] flowNoSlip = [labelLeft, labelRight, labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
    real flowPeriodX = 0, flowPeriodY = 0;
    func real boundaryRamp(real t) { return 1; }
    macro caseStart() {
        Wh psi = square(sin(pi*x)*sin(pi*y))*(sin(13*x + 5*y) + cos(17*y*x));
        Wh su = dy(psi), sv = -dx(psi);
        flowU = su[] .* flowFreeU; flowV = sv[] .* flowFreeV;
        flowU1 = flowU; flowV1 = flowV;
    } // EOM
    include "scripts/flow.edp"
    """
    file = mesh(run_folder.parent, "taylor_green", "--size", 1 / 16)
    freefem_text(scene.replace("MESH", str(file)), "-dt", 0.01, "-tend", 1, "-out", run_folder)
    energy = read_table(run_folder / "fluid.csv")["kinetic_energy"]
    assert np.isfinite(energy).all()
    assert energy[3:].max() <= energy[2] * 1.001 and energy[-1] < energy[2]
