"""Disks that roll and slide on a wall in a fluid."""
import numpy as np
import pytest

from tests.tables import assert_refused
from tools.base.run_folder import RunFolder

# A disk of a thousand times the density of its fluid on the lower wall of a long box: the fluid takes 0.2 % of its acceleration.
HEAVY = """
include "lib/case.idp"
optCase("slope", "a heavy disk on a slope");
real tilt = optReal("-tilt", 20, "degrees", "angle")*pi/180;
real rhoFluid = 1, mu = 0.001, gravityX = 9.81*sin(tilt), gravityY = -9.81*cos(tilt);
int[int] flowNoSlip = [labelLeft, labelRight, labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
func real boundaryRamp(real t) { return 1; }
macro caseParticles() CODE // EOM
include "scripts/resolved.edp"
"""


@pytest.fixture(scope="module")
def long_box(tmp_path_factory):
    from tests.conftest import make_mesh
    return make_mesh(tmp_path_factory.mktemp("mesh") / "box.mesh", "box", "--width", 3, "--height", 0.8, "--size", 0.05, "--sides",
        "named")


@pytest.mark.parametrize("tilt, rolls", [(20, True), (60, False)])
def test_a_heavy_disk_rolls_or_slides_down_a_slope(tilt, rolls, long_box, freefem_text, tmp_path):
    """2/3 g sin a where tan a <= 3 mu, else g (sin a - mu cos a), with the angular acceleration 2 mu g cos a/R; mu = 0.3. The rest
    is drag and added mass."""
    freefem_text(HEAVY.replace("CODE", "bodyDisk(0.5, 0.1, 0.1, 1000);"), "-mesh", long_box, "-tilt", tilt, "-friction", 0.3, "-dt",
        0.005, "-tend", 0.3, "-every", 0.1, "-stabilise", 0, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    a, g, mu, radius, t = np.radians(tilt), 9.81, 0.3, 0.1, 0.3
    speed = (2 / 3 * g * np.sin(a) if rolls else g * (np.sin(a) - mu * np.cos(a))) * t
    spin = -speed / radius if rolls else -2 * mu * g * np.cos(a) / radius * t
    assert run.particles["u"][-1] == pytest.approx(speed, rel=0.01) and run.particles["u"][-1] < speed
    assert run.particles["omega"][-1] == pytest.approx(spin, rel=0.01)
    if rolls:
        assert run.particles["u"][-1] == pytest.approx(-radius * run.particles["omega"][-1], rel=1e-4)
    last = run.table("contacts")
    assert set(last["sliding"]) == {0.0 if rolls else 1.0}
    share = np.abs(last["tangential"]) / last["impulse"]
    assert share == pytest.approx(0.3, rel=1e-4) if not rolls else (share < 0.15).all()


def test_momentum_holds_with_friction(freefem, tmp_path):
    """What wall and contact give the fluid and the disk is their change of momentum, as without friction."""
    off = []
    for friction in (0, 0.5):
        freefem("cases/rolling_disk.edp", "-friction", friction, "-tend", 0.1, "-budget", 1, "-out", tmp_path / str(friction))
        budget = RunFolder(tmp_path / str(friction)).table("budget")
        off.append([np.abs(budget[f"momentum_{d}"] - budget[f"walls_{d}"] - budget[f"weight_{d}"]).max() for d in "xy"])
        assert (budget["kinetic_energy"] + budget["dissipated"] < 1.015 * budget["work"]).all()
    assert np.array(off[1]) == pytest.approx(off[0], rel=0.02)


def test_a_pinned_disk_is_turned_by_one_that_slides_over_it(long_box, freefem_text, tmp_path):
    """Gears: the pinned one turns the other way round; without friction it hardly turns."""
    scene = HEAVY.replace("CODE", "{ bodyPinned(bodyDisk(1, 0.4, 0.1, 1000)); bodyAdd(0.81, 0.52, 0.1, 1000, 3, 0, 0, 1); }")
    spins = []
    for friction in (0, 0.5):
        freefem_text(scene, "-mesh", long_box, "-tilt", 0, "-friction", friction, "-dt", 0.002, "-tend", 0.03, "-every", 0.03,
            "-stabilise", 0, "-out", tmp_path / str(friction))
        table = RunFolder(tmp_path / str(friction)).particles
        spins.append(table["omega"][table["id"] == 0][-1])
    assert abs(spins[0]) < 0.02 * abs(spins[1]) and spins[1] < -0.5


def test_a_wall_of_the_mesh_may_have_a_friction_of_its_own(long_box, freefem_text, tmp_path):
    scene = HEAVY.replace("CODE", "{ wallRough(labelBottom, 0.1); bodyDisk(0.5, 0.1, 0.1, 1000); }")
    freefem_text(scene, "-mesh", long_box, "-tilt", 60, "-friction", 0.3, "-dt", 0.005, "-tend", 0.05, "-out", tmp_path / "run")
    last = RunFolder(tmp_path / "run").table("contacts")
    assert np.abs(last["tangential"]) / last["impulse"] == pytest.approx(0.1, rel=1e-4)


@pytest.mark.parametrize("code, words, says", [
    ("bodyEllipse(0.5, 0.2, 0.1, 0.05, 0, 2);", [], "ellipses"),
    ("bodyDisk(0.5, 0.2, 0.1, 2);", ["-scheme", "published"], "friction is for -scheme standard"),
    ("{ wallRough(77, 0.1); bodyDisk(0.5, 0.2, 0.1, 2); }", [], "no wall with this label"),
    ("bodyRough(bodyDisk(0.5, 0.2, 0.1, 2), -1);", [], "coefficient of friction"),
])
def test_what_friction_does_not_take_is_refused(code, words, says, long_box, freefem_text, tmp_path):
    done = freefem_text(HEAVY.replace("CODE", code), "-mesh", long_box, "-friction", 0.3, "-dt", 0.01, "-tend", 0.02, "-out",
        tmp_path / "run", *words, check=False)
    assert_refused(done, [3], says)
