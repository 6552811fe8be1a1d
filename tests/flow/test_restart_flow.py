"""The flow after a restart: fields, forces, stabilisation, inlets, what a case writes at its end."""
import re

import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import HELD, case
from tests.tables import broken_off, numbers


def test_another_interval_of_the_fields_counts_from_the_restart_on(tmp_path):
    words = ["cases/poiseuille.edp", "-dt", "0.02", "-cfl", "0", "-checkpoint", "3"]
    run_freefem(*words, "-tend", "0.06", "-fields", "1", "-out", tmp_path / "run")

    def times(interval, tend):
        run_freefem(*words, "-tend", tend, "-fields", interval, "-restart", tmp_path / "run")
        return [float(word) for word in re.findall(r'timestep="(\S+)"', (tmp_path / "run/fields.pvd").read_text())]

    assert times("0.04", "0.12") == [0, 0.08, 0.12]
    assert times("0.1", "0.24") == [0, 0.08, 0.12, 0.2]
    assert times("0.02", "0.28") == [0, 0.08, 0.12, 0.2, 0.26, 0.28]


SWINGING = """macro flowForceX() 1. // EOM
macro caseStart() { caseFX.resize(flowFX.n); caseFX = flowFX; } // EOM
macro caseStep() flowFX = cos(20*(timeNow + timeDt))*caseFX; // EOM
real[int] caseFX(0);
"""


@pytest.mark.parametrize("driver, along", [("resolved", "X"), ("flow", "X"), ("resolved", "Y"), ("flow", "Y")])
def test_a_force_on_the_fluid_that_a_case_changes_outlives_a_restart(driver, along, tmp_path):
    """caseStep has scaled it for the next step when the checkpoint is written."""
    text = HELD.replace("macro flowForceX() 1. // EOM\n", SWINGING.replace("flowForceX", "flowForce" + along).replace("flowFX",
        "flowF" + along)).replace("0, 0, 0, 0)", "0, 0, 0, 1)")
    if driver == "flow":
        lines = [line for line in text.splitlines() if "caseParticles" not in line]
        text = "\n".join(lines).replace("lib/bodies/bodies.idp", "lib/case.idp").replace(", gravityX = 0, gravityY = 0",
            "").replace(", motionBound = 1e30", "").replace("resolved.edp", "flow.edp") + "\n"
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-dt", "0.02", "-every", "0", "-tend", "0.2", "-checkpoint", "4"],
        tmp_path, 8)
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    assert np.ptp(expected["kinetic_energy"]) > 0
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)
    if driver == "resolved":
        assert (broken / "particles.csv").read_bytes() == (whole / "particles.csv").read_bytes()


VORTEX = """
include "lib/case.idp"
optCase("vortex", "a vortex dies down in a box");
optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1, mu = 0.05, flowPeriodX = 0, flowPeriodY = 0;
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelLeft, labelRight, labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) { return 1; }
macro caseStart() {
    Wh u = 14*sin(pi*x)^2*sin(2*pi*y), v = -14*sin(2*pi*x)*sin(pi*y)^2;
    flowU = u[]; flowV = v[]; flowU1 = flowU; flowV1 = flowV;
} // EOM
include "scripts/flow.edp"
"""


@pytest.mark.parametrize("tend, every, keep", [(0.2, 5, 35), (0.05, 7, 7)])
def test_a_stabilisation_that_has_fallen_to_0_is_on_after_a_restart(tend, every, keep, tmp_path):
    """With it the diagonal of the velocity's matrix is summed otherwise: to the last digit. Where it is not 0 yet it is that of the
    speeds of some steps before."""
    (tmp_path / "scene.edp").write_text(VORTEX)
    words = [tmp_path / "scene.edp", "-dt", "0.005", "-cfl", "0", "-every", "0", "-tend", tend, "-checkpoint", every]
    whole, broken = broken_off(words, tmp_path, keep)
    share = numbers(whole, "fluid.csv")["unresolved"]
    assert share.max() > 0 and (share[keep - 1:].max() == 0) == (keep == 35)
    last = max(whole.glob("restart_*.sha")).stem
    for end in ("txt", "scheme"):  # the flow and what the scheme keeps, among it the sums of the shares
        assert (broken / f"{last}.{end}").read_bytes() == (whole / f"{last}.{end}").read_bytes(), end


def test_a_force_on_the_fluid_that_was_edited_counts_after_a_restart(tmp_path):
    """It stands in checkpoints only where the case has changed it in the run."""
    case, speeds = tmp_path / "scene.edp", []
    case.write_text(HELD)
    words = ["-dt", "0.02", "-every", "0", "-checkpoint", "4"]
    run_freefem(case, *words, "-tend", "0.1", "-out", tmp_path / "run")
    for push in (1, -5):
        case.write_text(HELD.replace("flowForceX() 1.", f"flowForceX() {push}."))
        run_freefem(case, *words, "-tend", "0.2", "-restart", tmp_path / "run", "-out", tmp_path / f"on{push}")
        speeds.append(numbers(tmp_path / f"on{push}", "fluid.csv")["top_speed"][-1])
    assert abs(speeds[0] - speeds[1]) > 0.1 * speeds[0]


@pytest.mark.parametrize("course, flux", [("10*(now)", 1 / 3), ("((now) < 0.0301 ? 0.5 : 1.)", 2 / 3)], ids=["half", "as at first"])
@pytest.mark.parametrize("driver", ["resolved", "flow"])
def test_an_inlet_that_a_case_sets_no_more_is_as_it_was_after_a_restart(driver, course, flux, tmp_path):
    """caseBoundary scales it until 0.05 s, and says nothing of it from then on. At t = 0 it has another factor than then, in a run
    that goes on too."""
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", gravity=0,
                more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) if (now < 0.0501) inflowScale(labelLeft, COURSE); // EOM".replace("COURSE", course))
    if driver == "flow":
        lines = [line for line in text.splitlines() if "caseParticles" not in line]
        text = "\n".join(lines).replace(", gravityX = 0, gravityY = 0", "").replace(", motionBound = 1e30",
            "").replace("resolved.edp", "flow.edp") + "\n"
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-every", "0", "-cfl", "0", "-dt", "0.01", "-tend", "0.12", "-checkpoint",
        "4"], tmp_path, 8)
    got, expected = numbers(broken, "fluid.csv"), numbers(whole, "fluid.csv")
    assert expected["flux_in"][-1] == pytest.approx(flux, rel=1e-3)
    for column in expected:
        np.testing.assert_array_equal(got[column], expected[column], err_msg=column)


def test_what_a_case_writes_at_its_end_stands_once_in_a_run_that_goes_on(tmp_path):
    """A second row stood below the first."""
    words = ["cases/poiseuille.edp", "-dt", "0.02", "-checkpoint", "3"]
    run_freefem(*words, "-tend", "0.06", "-out", tmp_path / "run")
    first = (tmp_path / "run" / "errors.csv").read_text().splitlines()
    run_freefem(*words, "-tend", "0.12", "-restart", tmp_path / "run")
    second = (tmp_path / "run" / "errors.csv").read_text().splitlines()
    assert len(first) == len(second) == 2 and first[0] == second[0] and first[1] != second[1]
