"""Resolved scenes against other computations of the same: body-fitted and steady; the scene upside down; what comes in and goes
out."""
import numpy as np
import pytest

from tests.scenes import RING, SIDES, STREAM, case
from tools.base.run_folder import RunFolder

# centre, semi-axes, angle; held one behind the other in a channel of 4 by 1
HELD = [(1.0, 0.45, 0.15, 0.15, 0.0), (1.6, 0.57, 0.2, 0.12, 0.5)]


FITTED = """
include "lib/case.idp"
optCase("fitted", "a disk and an ellipse in a channel");
real rhoFluid = 1, speed = 1, size = 0.3, mu = {mu};
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall, labelObstacle, labelCylinder], labelsMoving = [labelInlet], labelsFree = [labelOutlet];
macro inletU() (4*y*(1 - y)) // EOM
macro caseResult() {{
    real[int] force(2);
    steadyForceOn(labelObstacle, force); resultPut("fx0", force[0], "N/m"); resultPut("fy0", force[1], "N/m");
    steadyForceOn(labelCylinder, force); resultPut("fx1", force[0], "N/m"); resultPut("fy1", force[1], "N/m");
}} // EOM
include "scripts/steady_laminar.edp"
"""


def test_bodies_one_behind_the_other_bear_the_forces_of_a_body_fitted_mesh(freefem_text, tmp_path):
    """Reynolds number 15; 9 elements across the disk, 7 across the ellipse behind it, which bears four fifths of its drag."""
    rings = "".join(RING.format(k=k, x=x, y=y, a=a, b=b, c=angle, label=5 + k) for k, (x, y, a, b, angle) in enumerate(HELD))
    mesh = f'savemesh(buildmesh(below(128) + out(32) + above(128) + into(32) + ring0(-64) + ring1(-64)), "{tmp_path}/fitted.mesh");\n'
    freefem_text(SIDES + rings + mesh + FITTED.format(mu=0.02), "-mesh", tmp_path / "fitted.mesh", "-out", tmp_path / "fitted")
    known = dict(line.split(",")[:2] for line in (tmp_path / "fitted/results.csv").read_text().splitlines()[1:])
    bodies = " ".join(f"bodyHeld(bodyEllipse({x}, {y}, {a}, {b}, {angle}, 1));" for x, y, a, b, angle in HELD)
    text = case("{ " + bodies + " }", walls="labelWall", moving="labelInlet", outlet="labelOutlet", mu=0.02, gravity=0, more=STREAM)
    mesh = f'savemesh(buildmesh(below(128) + out(32) + above(128) + into(32)), "{tmp_path}/plain.mesh");\n'
    freefem_text(SIDES + mesh + text, "-mesh", tmp_path / "plain.mesh", "-dt", 0.04, "-every", 2, "-tend", 2, "-forces", 1, "-out",
        tmp_path / "run")
    forces = RunFolder(tmp_path / "run").table("forces")
    for body in (0, 1):
        last = (forces["id"] == body) & (forces["t"] > 1.9)
        for part in ("fx", "fy"):
            assert forces[part][last] == pytest.approx(float(known[f"{part}{body}"]), abs=0.005 * float(known[f"fx{body}"]))


def test_a_light_disk_rises_as_a_heavy_one_falls(freefem_text, tmp_path):
    """Slow flow, weights less buoyancy of one size; the box upside down. The light one has a virtual mass that the heavy one has
    not."""
    speed = {}
    for density, height in ((1.5, 0.62), (0.5, 0.38)):
        freefem_text(case(f"bodyDisk(0.5, {height}, 0.12, {density});", mu=1), "-dt", 0.01, "-convection", 0, "-tend", 0.3, "-out",
            tmp_path / f"{density}")
        rows = RunFolder(tmp_path / f"{density}").particles
        speed[density] = rows["v"][-1]
    assert speed[1.5] < -1e-3 and speed[0.5] == pytest.approx(-speed[1.5], rel=0.003)


def test_what_bodies_cross_lets_through_as_much_in_as_out(freefem_text, tmp_path):
    """Two inlets, two outlets; disks and ellipses enter at an inlet, cross and leave by both outlets, one over the corner between
    them (it took a row of exits.csv for another that stayed)."""
    bodies = "{ bodyAdd(0.85, 0.4, 0.1, 1.2, 1, 0, 0, 1); bodyAdd(0.4, 0.85, 0.1, 1.2, 0, 1, 0, 1); bodyAdd(0.3, 0.3, 0.1, 2, 0.5, 0.5, 0, 1); queueAdd(0.6, 0.08, 1.5, 0.1); queueEllipse(0.3, 0.1, 0.07, 0.5, 2, 0.2); }"
    more = "macro boundaryU() ((x < 1e-9)*4*y*(1 - y)) // EOM\nmacro boundaryV() ((y < 1e-9)*4*x*(1 - x)) // EOM"
    text = case(bodies, walls="", moving="labelLeft, labelBottom", outlet="labelRight, labelTop", more=more, gravity=0)
    freefem_text(text, "-dt", 0.01, "-tend", 1.5, "-fluxes", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    table, exits, particles = run.table("fluxes"), run.table("exits"), run.particles
    net = np.array([table["flux"][table["t"] == t].sum() for t in np.unique(table["t"])])
    assert abs(net[5:]).max() < 0.01 * 4 / 3 and abs(net[-40:]).max() < 0.001
    assert sorted(exits["id"]) == [0, 1, 2, 3, 4] and ((exits["x"] > 1) | (exits["y"] > 1)).all()
    for body, t in zip(exits["id"], exits["t"]):  # rows end where one leaves
        assert particles["t"][particles["id"] == body].max() < t + 1e-9
