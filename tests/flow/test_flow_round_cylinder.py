"""The unsteady flow round a cylinder: drag, fluxes, energy, vortices, and nothing spent on particles."""
import numpy as np
import pytest

from tests.conftest import mesh, run_freefem
from tests.scenes import THROUGH
from tools.base.tables import read_table
from tools.validation.particles import reference


@pytest.fixture(scope="module")
def cylinder(meshes, tmp_path_factory):
    """A short run past a cylinder on a coarse mesh."""
    coarse = mesh(meshes, "cylinder_channel", "--circle-points", 24)
    folder = tmp_path_factory.mktemp("cylinder") / "run"
    run_freefem("cases/cylinder_channel.edp", "-mesh", coarse, "-tend", 0.5, "-dt", 0.005, "-every", 0, "-budget", 1, "-out",
        folder)
    return folder


def test_cylinder_drag_flux_and_divergence(cylinder):
    force, fluid = read_table(cylinder / "forces.csv"), read_table(cylinder / "fluid.csv")
    assert 20 * force["force_x"][-1] == pytest.approx(2.98, rel=0.05)  # before the vortices are shed
    assert abs(20 * force["force_y"][-1]) < 0.1
    assert fluid["flux_out"][-1] == pytest.approx(fluid["flux_in"][-1], rel=1e-2)  # of the predicted velocity
    assert fluid["flux_in"][-1] == pytest.approx(1.0 * 0.41, rel=1e-9)
    assert fluid["top_speed"][fluid["t"] > 0.1].max() < 3  # the start at once pushes


def test_energy_budget_closes(cylinder):
    budget = read_table(cylinder / "budget.csv")
    begin = np.searchsorted(budget["t"], 0.1)  # after the start at once
    last = {name: values[-1] - values[begin] for name, values in budget.items()}
    assert abs(last["rest"]) < 1e-3 * last["supplied"]
    assert last["dissipated"] > 0 and last["left"] > 0
    assert abs(last["damped"]) + abs(last["split"]) < 0.1 * last["supplied"]


def test_a_cylinder_that_turns_supplies_its_torque_times_its_speed(freefem_text, tmp_path, run_folder):
    """Between two cylinders, the inner one turning, and that is what is dissipated (mu |grad u|^2 alone: 0.58 of it)."""
    mesh = tmp_path / "ring.mesh"
    ring = f'border outer(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }} border inner(s = 0, 2*pi) {{ x = 0.4*cos(s); y = 0.4*sin(s); label = 6; }} savemesh(buildmesh(outer(90) + inner(-48)), "{mesh}");'
    text = THROUGH.replace("flowNoSlip = [labelBottom, labelTop], flowMoving = [labelLeft, labelRight]",
        "flowNoSlip = [labelWall], flowMoving = [labelCylinder]")
    text = text.replace("macro boundaryU() (4*y*(1 - y)) // EOM", "macro boundaryU() (-2*y) // EOM\nmacro boundaryV() (2*x) // "
        "EOM").replace("macro caseStart", "macro none")
    freefem_text(ring + text, "-mesh", mesh, "-dt", 0.1, "-cfl", 0, "-tend", 20, "-every", 4, "-budget", 1, "-out", run_folder)
    budget = read_table(run_folder / "budget.csv")
    rate = {name: (budget[name][-1] - budget[name][-2]) / (budget["t"][-1] - budget["t"][-2]) for name in ("supplied",
        "dissipated", "rest")}
    torque = 4 * np.pi * 0.1 * 2 * 0.4**2 / (1 - 0.4**2)
    assert rate["supplied"] == pytest.approx(2 * torque, rel=0.01) and rate["dissipated"] == pytest.approx(2 * torque, rel=0.01)
    assert abs(rate["rest"]) < 1e-6 * torque


# What the parts for particles leave behind when they are called, whoever is there: rigidFind sets rigidStale, momentumDisks counts
# momentumAge.
SPARED = """
macro caseStart() rigidStale = 7; // EOM
macro caseStep()
    cout << "SEEN " << rigidStale << " " << momentumAge << endl;
    IFMACRO(motionIncluded) cout << "MOTION" << endl; ENDIFMACRO
    IFMACRO(contactSolveIncluded) cout << "CONTACTS" << endl; ENDIFMACRO
// EOM
include "cases/pipe_jet.edp"
"""


def test_a_flow_without_particles_spends_no_time_on_them(cylinder, freefem_text, meshes, tmp_path):
    names = read_table(cylinder / "fluid.csv")
    assert not [name for name in names if "rigid" in name or "contact" in name or name == "particles"]
    coarse = mesh(meshes, "pipe_obstacles", "--size", 0.02)
    text = freefem_text(SPARED, "-mesh", coarse, "-cfl", 0, "-dt", 0.001, "-tend", 0.005, "-out", tmp_path / "run").stdout
    assert [line for line in text.splitlines() if line.startswith(("SEEN", "MOTION", "CONTACTS"))] == 5 * ["SEEN 7 0"]


@pytest.mark.slow
def test_vortices_behind_the_cylinder(meshes, run_folder):
    coarse = mesh(meshes, "cylinder_channel")
    run_freefem("cases/cylinder_channel.edp", "-mesh", coarse, "-out", run_folder, timeout=1800)
    force = read_table(run_folder / "forces.csv")
    late = force["t"] > 5
    assert 20 * force["force_x"][late].max() == pytest.approx(3.2274, rel=0.005)
    assert 20 * np.ptp(force["force_y"][late]) == pytest.approx(2.00787, rel=0.005)


@pytest.mark.slow
def test_a_started_cylinder_follows_the_published_drag(meshes, tmp_path):
    """Reynolds number 1000, t U/R from 0.3 to 1.6 (Koumoutsakos & Leonard 1995, digitised: about 1 % of the maximum of 1.3)."""
    coarse = mesh(meshes, "started_cylinder", "--circle-points", 160, "--growth", 0.15)
    run_freefem("cases/started_cylinder.edp", "-mesh", coarse, "-tend", 0.8, "-out", tmp_path / "run")
    force = read_table(tmp_path / "run" / "forces.csv")
    at, target = reference("started_cylinder_re1000_koumoutsakos1995")
    there = (at > 0.3) & (at < 1.6)
    off = np.interp(at[there], 2 * force["t"], 2 * force["force_x"]) - target[there]
    assert abs(off).mean() < 0.05 * target[there].mean()
