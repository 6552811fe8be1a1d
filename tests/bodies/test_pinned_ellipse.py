"""An ellipse on a pin in a stream, against the torques of body-fitted steady computations."""
import numpy as np
import pytest

from tests.scenes import RING, SIDES, STREAM, case
from tools.base.run_folder import RunFolder

# the middle of the ellipse stands off the midline of a channel of 4 by 1, where the stream shears it
PLACE, LONG, SHORT, MU = (1.2, 0.42), 0.2, 0.12, 0.02
FITTED = """
include "lib/case.idp"
optCase("fitted", "an ellipse in a channel");
real rhoFluid = 1, speed = 1, size = 0.4, mu = {mu};
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall, labelObstacle], labelsMoving = [labelInlet], labelsFree = [labelOutlet];
macro inletU() (4*y*(1 - y)) // EOM
macro caseResult() {{
    varf rim(a, c) = on(labelObstacle, a = 1);
    real[int] there = rim(0, NWh, tgv = 1.), pull = newtonReaction(0:newtonNw - 1), push = newtonReaction(newtonNw:2*newtonNw - 1);
    NWh across = y - {place[1]}, along = x - {place[0]};
    along[] .*= there; across[] .*= there;
    resultPut("torque", -rhoFluid*(along[]'*push - across[]'*pull), "N");
}} // EOM
include "scripts/steady_laminar.edp"
"""


def torque(freefem_text, folder, angle):
    """Of the steady stream on the ellipse at this angle."""
    folder.mkdir()
    text = SIDES + RING.format(k=0, x=PLACE[0], y=PLACE[1], a=LONG, b=SHORT, c=angle, label=5)
    text += (f'savemesh(buildmesh(below(96) + out(24) + above(96) + into(24) + ring0(-80)), "{folder}/fitted.mesh");\n'
        + FITTED.format(mu=MU, place=PLACE))
    freefem_text(text, "-mesh", folder / "fitted.mesh", "-out", folder / "run")
    return next(float(line.split(",")[1]) for line in (folder / "run/results.csv").read_text().splitlines()
        if line.startswith("torque,"))


def turned(freefem_text, folder, body, end, *words):
    folder.mkdir()
    text = SIDES + f'savemesh(buildmesh(below(112) + out(28) + above(112) + into(28)), "{folder}/plain.mesh");\n'
    text += case(body, walls="labelWall", moving="labelInlet", outlet="labelOutlet", mu=MU, gravity=0, more=STREAM)
    freefem_text(text, "-mesh", folder / "plain.mesh", "-dt", 0.05, "-every", 0, "-tend", end, "-forces", 1, "-out",
        folder / "run", *words)
    return RunFolder(folder / "run")


def test_a_held_ellipse_bears_the_torque_of_a_body_fitted_mesh(freefem_text, tmp_path):
    """Reynolds number 20, seven elements across the short axis."""
    exact = torque(freefem_text, tmp_path / "fitted", 0.6)
    found = turned(freefem_text, tmp_path / "held", f"bodyHeld(bodyEllipse({PLACE[0]}, {PLACE[1]}, {LONG}, {SHORT}, 0.6, 1));",
        2).table("forces")
    assert exact > 0 and found["torque"][found["t"] > 1.8] == pytest.approx(exact, rel=0.012)


def test_an_ellipse_on_a_pin_comes_to_rest_where_the_stream_does_not_turn_it(freefem_text, tmp_path):
    """Nearly across the stream, a twentieth of a radian beyond by its shear; at that angle the torque of a body-fitted steady
    computation is 0 and falls, by a fifth of its largest in each tenth of a radian."""
    rows = turned(freefem_text, tmp_path / "pinned", f"bodyPinned(bodyEllipse({PLACE[0]}, {PLACE[1]}, {LONG}, {SHORT}, 0.6, 1));",
        6).particles
    before, beyond = (torque(freefem_text, tmp_path / f"{angle}", angle) for angle in (1.5, 1.7))
    rest = 1.5 + 0.2 * before / (before - beyond)
    assert before > 0 > beyond and rest > np.pi / 2 + 0.02
    assert rows["theta"][-1] == pytest.approx(rest, abs=0.006) and abs(rows["omega"][-20:]).max() < 0.002
