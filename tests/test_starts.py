"""Starts at which bodies and fluid do not fit together, blows between light and heavy bodies, and bodies that are none of each other's business."""
import numpy as np
import pytest

from test_boundaries import case
from tools.run_folder import RunFolder

BOX = """
include "lib/options.idp"
optCase("starts", "a scene of tests/test_starts.py");
optDefault("-mesh", "meshes/cylinder_array.mesh");
optDefault("-every", "1e-9");
real rhoFluid = 1, mu = {mu}, gravityX = 0, gravityY = {gravity};
include "lib/labels.idp"
int[int] flowNoSlip(0), flowMoving(0), flowOutlet(0), flowSlip(0);
macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]);
    fespace Qh(Th, P1, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight, labelBottom, labelTop] // EOM
func real boundaryRamp(real t) {{ return 1; }}
real flowPeriodX = 1, flowPeriodY = 1, motionBound = 1e30;
macro caseParticles() {{ {bodies} }} // EOM
include "scripts/resolved.edp"
"""


def box(bodies, mu=0.01, gravity=0):
    return BOX.format(bodies=bodies, mu=mu, gravity=gravity)


@pytest.mark.parametrize("ratio", [0.2, 1, 5, 1000])
def test_a_body_thrown_into_fluid_at_rest_shares_its_momentum(ratio, freefem_text, tmp_path):
    drift, ends = [], []
    for dt in (0.01, 0.0025):
        freefem_text(box(f"bodyAdd(0.51, 0.53, 0.13, {ratio}, 1, 0, 0, 1);"), "-dt", dt, "-tend", 0.1, "-cfl", 0, "-convection", 0, "-tolerance", 1e-9, "-budget", 1, "-out", tmp_path / f"run{dt}")
        run = RunFolder(tmp_path / f"run{dt}")
        momentum = run.table("budget")["momentum_x"]
        drift.append(abs(momentum[-1] - momentum[0]) / momentum[0])
        ends.append(run.particles["u"][-1])
    assert momentum[0] == pytest.approx(np.pi * 0.13**2 * ratio, rel=0.1 if ratio < 1 else 0.02)  # light ones: their nodes' share
    assert drift[1] < 0.02 and drift[0] < 0.04
    assert ends[0] == pytest.approx(ends[1], rel=0.05)


STREAM = case("bodyDisk(0.41, 0.52, 0.12, 1);", walls="", moving="labelLeft", outlet="labelRight", slip="labelBottom, labelTop", more="macro boundaryU() 1. // EOM", mu=0.001, gravity=0)


def test_a_neutral_disk_goes_with_a_stream_that_is_there_at_once(freefem_text, tmp_path):
    freefem_text(STREAM, "-dt", 0.005, "-tend", 0.1, "-cfl", 0, "-out", tmp_path / "run")
    speed = RunFolder(tmp_path / "run").particles["u"]
    assert np.abs(speed - 1).max() < 0.02


@pytest.mark.parametrize("low, high", [(0.5, 2), (1.1, 2.5)])
def test_a_blow_of_bodies_changes_no_momentum(low, high, freefem_text, tmp_path):
    text = box(f"bodyDisk(0.5, 0.33, 0.1, {low}); bodyDisk(0.51, 0.62, 0.1, {high});", mu=0.003, gravity=-1)
    freefem_text(text, "-dt", 0.005, "-tend", 1.2, "-cfl", 0, "-budget", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    budget, first = run.table("budget"), run.table("contacts")
    lost = budget["momentum_y"] - budget["weight_y"]
    k = int(np.argmin(np.abs(budget["t"] - first["t"][0])))
    assert abs(lost[k] - lost[k - 1]) < 0.06 * first["impulse"][0]


def test_a_small_body_far_away_changes_nothing(freefem_text, tmp_path):
    speeds = []
    for more in ("", "bodyAdd(0.31, 0.53, 0.04, 1, 0, 0, 0, 0);"):
        text = case(f"{{ bodyDisk(1.01, 4.2, 0.2, 1.5); {more} }}", walls="labelWall", mu=1, gravity=-981)
        freefem_text(text, "-mesh", "meshes/settling_disk.mesh", "-dt", 0.01, "-tend", 0.1, "-tolerance", 1e-8, "-out", tmp_path / f"run{len(speeds)}")
        rows = RunFolder(tmp_path / f"run{len(speeds)}").particles
        speeds.append(np.column_stack([rows["v"], rows["omega"]])[rows["id"] == 0][-1])
    np.testing.assert_allclose(speeds[1], speeds[0], rtol=1e-5)


def test_the_first_step_from_rest_is_bounded_by_cfl(freefem, tmp_path):
    freefem("cases/template.edp", "-dt", 0.2, "-tend", 0.4, "-every", 1e-9, "-out", tmp_path / "run")
    fluid = RunFolder(tmp_path / "run").fluid
    assert fluid["dt"][0] < 0.05 and fluid["top_speed"].max() < 30
