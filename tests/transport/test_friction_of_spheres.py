"""Point spheres that roll and slide on a wall."""
import numpy as np
import pytest

from tools.base.run_folder import RunFolder

SLOPE = """
include "lib/case.idp"
optCase("slope", "spheres on a slope");
real tilt = optReal("-tilt", 20, "degrees", "angle")*pi/180;
real rhoFluid = 1e-6, mu = 1e-12, gravityX = 9.81*sin(tilt), gravityY = -9.81*cos(tilt);
macro carrierExact(px, py, t) carrierU = 0.; // EOM
macro caseParticles() {
    contactWallSegment(-1, 0, 100, 0);
    real[int] x0 = [0., 0.1], y0 = [2e-3, 2e-2], r = [2e-3, 2e-2], d = [2500., 2500.], z = [0., 0.];
    transportAppend(x0, y0, r, d, z, z, z);
} // EOM
include "scripts/transport.edp"
"""


@pytest.mark.parametrize("tilt", [10, 40, 50, 80])
def test_spheres_roll_or_slide_down_a_slope(tilt, freefem_text, tmp_path):
    """With the moment 2/5 m R^2: 5/7 g sin a where tan a <= 7/2 mu, else g (sin a - mu cos a), 5/2 mu g cos a/R; mu = 0.3."""
    freefem_text(SLOPE, "-tilt", tilt, "-friction", 0.3, "-dt", 0.002, "-tend", 0.2, "-every", 0.2, "-drag", "stokes", "-out",
        tmp_path / "run")
    table = RunFolder(tmp_path / "run").particles
    a, g, t, radius = np.radians(tilt), 9.81, 0.2, np.array([2e-3, 2e-2])
    rolls = np.tan(a) <= 3.5 * 0.3
    speed = 5 / 7 * g * np.sin(a) if rolls else g * (np.sin(a) - 0.3 * np.cos(a))
    spin = speed / radius if rolls else 2.5 * 0.3 * g * np.cos(a) / radius
    assert table["u"][-2:] == pytest.approx([speed * t] * 2, rel=1e-4)
    assert table["omega"][-2:] == pytest.approx(-spin * t, rel=1e-4)
    assert table["x"][-2:] == pytest.approx(np.array([0, 0.1]) + speed * t**2 / 2, rel=1e-4)
    assert table["theta"][-2:] == pytest.approx(-spin * t**2 / 2, rel=1e-4)


def test_without_friction_spheres_do_not_turn(freefem_text, tmp_path):
    freefem_text(SLOPE, "-tilt", 30, "-dt", 0.002, "-tend", 0.1, "-every", 0.1, "-drag", "stokes", "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert not run.particles["omega"].any() and "tangential" not in run.table("contacts")
    assert run.particles["u"][-1] == pytest.approx(9.81 * 0.5 * 0.1, rel=1e-6)
