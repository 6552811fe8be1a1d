"""Inertia of bodies: mass of light ones, neutral ones of few nodes, added mass at the start."""
import numpy as np
import pytest

from tests.scenes import case, script
from tests.tables import particles_of, rows
from tools.base.run_folder import RunFolder
from tools.validation.particles import started


def test_the_mass_near_light_disks_is_that_of_the_whole_matrix(freefem_text):
    text = script([(0.3, 0.4, 0.127), (0.7, 0.65, 0.11)], more="""
bodyDensity = 0.2;
for (int k = 0; k < 2; ++k) {
    rowsShare = k;
    momentumInertia();
    for (int d = 0; d < 2; ++d) cout << "net " << momentumMass[d] << " " << momentumMoment[d] << endl;
}
real[int] nodes(2);
momentumUnit(flowM, rigidNode, 2, nodes);
for (int d = 0; d < 2; ++d) cout << "carried " << nodes[d] << endl;
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp\"""")
    out = freefem_text(text).stdout
    net = rows(out, "net")
    np.testing.assert_allclose(net[:2], net[2:], rtol=1e-13)
    fluid = np.pi * np.array([0.127, 0.11])**2
    # (s - (2 k - 1 + s) + 1.25 - s) m_f = (2.05 - 2 k) m_f for s = 0.2, 1/2 < k < 1 the share of the displaced fluid that the nodes
    # carry
    assert ((net[:2, 0] / fluid > 0.05) & (net[:2, 0] / fluid < 1.05)).all()
    # disks have no virtual moment: with what the nodes carry at most s and at least a tenth of the fluid's (momentumTurn)
    turning = (net[:2, 1] + rows(out, "carried")[:, 0]) / (fluid * np.array([0.127, 0.11])**2 / 2)
    assert ((turning > 0.1 - 1e-9) & (turning < 0.21)).all()


def test_neutral_bodies_of_next_to_no_nodes_have_inertia(freefem_text):
    """Their own, or with their nodes half the fluid's mass and at least a tenth of its moment; resolved ones are the fluid's but
    for the virtual mass."""
    # a middle of an edge, a vertex, one node, none
    tiny = [(a, b, 0.02) for a, b in ((0.5, 0.53125), (0.5, 0.5), (0.22, 0.31), (0.703125, 0.234375))]
    disks = [*tiny, (-0.08, 0.8, 0.127), (0.3, 0.75, 0.127)]
    text = script(disks, more="""
momentumInertia();
real[int] nodes(bodyNumber), turn(bodyNumber);
momentumUnit(flowM, rigidNode, 0, nodes); momentumUnit(flowM, rigidNode, 2, turn);
for (int d = 0; d < bodyNumber; ++d) cout << "inertia " << momentumMass[d] << " " << momentumMoment[d] << " " << nodes[d] << " " << turn[d] << endl;
""").replace('include "lib/immersed/ghost_values.idp"', """int withGhost = 1;
real stabilise = 0, momentumTolerance = 1e-5;
include "lib/scheme/pressure_step.idp\"""")
    mass, moment, nodes, turn = rows(freefem_text(text).stdout, "inertia").T
    area = np.pi * np.array(disks)[:, 2]**2
    arm = np.array(disks)[:, 2]**2 / 2
    assert nodes[3] == 0 and (nodes[:3] > 0).all() and nodes[4] < 0.3 * area[4]
    both, turning = (mass + nodes) / area - 0.25, (moment + turn) / area / arm
    assert (both[:5] > 0.5 - 1e-9).all() and (turning[:5] > 0.1 - 1e-9).all()
    assert both[3] == pytest.approx(1) and turning[3] > 1
    assert mass[5] == pytest.approx(0.25 * area[5], rel=1e-12) and moment[5] == 0


@pytest.mark.parametrize("radius, density, mu, dt", [(0.011, 1, 0.01, 0.005), (0.04, 0.1, 0.005, 0.002)])
def test_small_neutral_and_light_disks_turn_with_the_fluid(radius, density, mu, dt, freefem_text, tmp_path):
    """Half an element across, which hold a node now and then, and two across (with a least moment of a tenth the solver stopped;
    2.6 instead of 1)."""
    text = case(" ".join(f"bodyDisk({x}, {y}, {radius}, {density});" for x, y in ((0.13, 0.21), (0.31, 0.36), (0.42, 0.62),
        (0.22, 0.77), (0.61, 0.44))), walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
                more="macro boundaryU() (4*y*(1 - y)) // EOM", mu=mu, gravity=0)
    freefem_text(text, "-dt", dt, "-cfl", 0, "-tend", 80 * dt, "-every", 0, "-out", tmp_path / "run")
    disks = RunFolder(tmp_path / "run").particles
    assert np.hypot(disks["u"], disks["v"]).max() < 1.5
    assert np.abs(disks["omega"]).max() * radius < 0.5


@pytest.mark.parametrize("ratio,error", [(0.01, 0.1), (2, 0.1), (1000, 0.02)])
def test_light_and_heavy_disks_start_as_added_mass_says(freefem, tmp_path, ratio, error):
    run = particles_of(freefem, tmp_path / "run", "settling_disk", "-rhos", ratio, "-mu", "0.01", "-y", "3", "-dt", "0.0002",
        "-tend", "0.004")
    assert np.isfinite(run["v"]).all()
    assert run["v"][-1] == pytest.approx(started(ratio, 0.01, 0.004), rel=error)


def test_a_heavy_disk_leaves_the_solver_s_care_to_a_light_one(freefem_text, cell, tmp_path):
    """The tolerance is on the loads of the fluid; on those of a disk of 1e5 times its density the light one's velocity errs by 2
    %."""
    found = []
    for tolerance in (1e-5, 1e-10):
        freefem_text(case("bodyDisk(0.27, 0.6, 0.11, 1.1); bodyDisk(0.74, 0.7, 0.12, 1e5);"), "-tolerance", tolerance, "-mesh",
            cell, "-tend", 0.3, "-every", 0, "-out", tmp_path / f"run{tolerance}")
        found.append(RunFolder(tmp_path / f"run{tolerance}").tracks[0]["v"][-1])
    assert found[0] == pytest.approx(found[1], rel=1e-3)


def test_a_neutral_disk_stays_at_rest(freefem, tmp_path):
    run = particles_of(freefem, tmp_path / "run", "settling_disk", "-rhos", "1", "-tend", "0.02")
    assert max(abs(run["u"]).max(), abs(run["v"]).max(), abs(run["omega"]).max()) < 1e-9
