"""Sudden accelerations (lib/scheme/sudden_acceleration.idp): which are found, and what is remembered of them, against NumPy and
over a restart."""
import numpy as np
import pytest

from tests.conftest import standard_alone
from tests.scenes import case
from tests.tables import broken_off

TRIALS = 60
BODIES = "{ bodyDisk(0.2, 0.2, 0.15, 2.5); bodyDisk(0.8, 0.2, 0.14, 0.4); bodyHeld(bodyEllipse(0.22, 0.78, 0.16, 0.12, 0.3, 0.7)); bodyPinned(bodyEllipse(0.78, 0.78, 0.18, 0.14, 0.3, 3)); bodyDisk(0.5, 0.45, 0.16, 1); }"
LOOK = """macro driveTell(name, a) f << name; for (int driveI = 0; driveI < a.n; ++driveI) f << " " << a[driveI]; f << endl; // EOM
func int tellAll(ofstream & f) {
    real[int] figures = [bodyNumber, timeDt, timeDt1, timeB2, onsetGiven, onsetInflow, onsetInflowJump, givenN];
    driveTell("figures", figures) driveTell("q", bodyQ) driveTell("q1", bodyQ1) driveTell("load", bodyLoad) driveTell("asked", bodyAsked)
    driveTell("u", flowU) driveTell("v", flowV) driveTell("u1", flowU1) driveTell("v1", flowV1) driveTell("dataU", flowDataU) driveTell("dataV", flowDataV)
    return 0;
}
macro driveDraw(a, size) for (int driveI = 0; driveI < a.n; ++driveI) a[driveI] = (size)*(2*randreal1() - 1); // EOM
func int lookOnce(ofstream & f, int trial) {
    int n = bodyNumber;
    real[int] pushed(3*n), rate(3*n), force(3*n), fresh(3*n), a(0), told(0), done(0);
    timeDt = 0.01*(1 + randreal1()); timeDt1 = 0.01*(1 + randreal1()); timeB2 = trial % 7 == 6 ? 0 : 0.5;
    onsetGiven = trial/3 % 2;
    onsetInflow = trial % 5 == 4 ? -1 : 100*randreal1()^3; onsetInflowJump = 30*randreal1()^3;
    driveDraw(bodyQ, 10^(3*randreal1() - 1)) driveDraw(bodyQ1, 1) driveDraw(bodyLoad, 10^(2*randreal1() - 1)) driveDraw(pushed, 1)
    driveDraw(bodyAsked, 100) bodyAsked = abs(bodyAsked);
    for (int d = 0; d < n; ++d) { bodyAsked[n + d] *= 0.3*randreal1(); bodyAsked[2*n + d] = int(20*randreal1()); }
    if (trial % 4 == 0) { bodyQ *= 1e-3; bodyQ1 = bodyQ; bodyLoad = pushed; bodyAsked(0:2*n - 1) = 1e-4*bodyAsked(0:2*n - 1); } // next to nothing has changed
    if (trial % 8 == 0) { bodyAsked(0:2*n - 1) = 0*bodyAsked(0:2*n - 1); bodyLoad[1] *= 1 + 10^(-6 - 5*randreal1()); }
    driveDraw(flowU, 1) driveDraw(flowV, 1) driveDraw(flowU1, 1) driveDraw(flowV1, 1) driveDraw(flowDataU, 1) driveDraw(flowDataV, 1)
    real ramp = 0.5 + randreal1(), part = 10^(-8*randreal1());
    if (trial % 5 == 1) { onsetInflow = 0; onsetInflowJump = 0; part = sqrt(part)*1e-4; }
    if (trial % 2) { flowU1 = flowU; flowV1 = flowV; flowU1 *= 1 - part; flowDataU = flowU/ramp; flowDataV = flowV/ramp; flowDataV *= 1 + part; }
    if (trial % 3 != 2) givenMotion(2, randreal1(), randreal1(), randreal1());
    real[int] given(3*n), known = [ramp, trial % 4];
    given = bodyQ; givenPut(given);
    driveTell("trial", known) tellAll(f); driveTell("pushed", pushed) driveTell("given", given)
    int asked = onsetAsked(pushed, rate, force), jumped = onsetInflowAsked(ramp, a);
    if (!asked) { rate = 0; force = 0; }
    if (!jumped) a.resize(0);
    fresh = 0;
    int many = onsetNew(trial % 4, fresh);
    done.resize(6) = [asked, jumped, onsetGiven, onsetInflow, onsetInflowJump, many];
    driveTell("done", done) driveTell("after", bodyAsked) driveTell("rate", rate) driveTell("force", force) driveTell("fresh", fresh) driveTell("boundary", a)
    givenN = 0;
    return 1;
}
"""
RUN = """include "lib/scheme/pressure_step.idp"
include "lib/motion/move.idp"
include "lib/scheme/sudden_acceleration.idp"
{look}
{{
    randinit(5);
    ofstream f("{file}");
    f.precision(17);
    driveTell("density", bodyDensity) driveTell("radius", bodyRadius) driveTell("aspect", bodyAspect) driveTell("free", bodyFree) driveTell("turns", bodyTurns) driveTell("freeU", flowFreeU) driveTell("freeV", flowFreeV)
    for (int trial = 0; trial < {trials}; ++trial) lookOnce(f, trial);
}}
"""


def drawn(freefem_text, tmp_path, loads):
    """What the scene has throughout, and in each of the trials (dicts)."""
    text = case(BODIES, walls="", slip="labelTop, labelLeft", moving="labelBottom", outlet="labelRight", gravity=-9,
        more="macro boundaryV() (x*(1 - x)) // EOM\n" + ("macro caseLoads(now) bodyPush(0, 0, 0, 0); // EOM" if loads else ""))
    driver = standard_alone(text).split('if (scheme == "standard") {')[0]
    box = f'int[int] sides = [13, 12, 14, 11];\nsavemesh(square(5, 5, label = sides), "{tmp_path / "box.mesh"}");\n'
    freefem_text(box + driver + RUN.format(look=LOOK, file=tmp_path / "told", trials=TRIALS), "-mesh", tmp_path / "box.mesh",
        "-out", tmp_path / "run")
    scene, trials = {}, []
    for line in (tmp_path / "told").read_text().splitlines():
        name, *values = line.split()
        if name == "trial":
            trials.append({})
        (trials[-1] if trials else scene)[name] = np.array(values, float)
    assert len(trials) == TRIALS
    return scene, trials


def lengths(a, radius):
    """Of accelerations (3N), the angular ones as those of the edge."""
    a = a.reshape(3, -1)
    return np.sqrt(a[0]**2 + a[1]**2 + (radius * a[2])**2)


@pytest.mark.parametrize("loads", [1, 0])
def test_the_accelerations_that_are_sudden_are_those_that_numpy_finds(loads, freefem_text, tmp_path):
    """Of bodies that are moved and pushed, of the boundary, and of bodies that are new; and what is kept for the next step."""
    scene, trials = drawn(freefem_text, tmp_path, loads)
    radius, density, free = scene["radius"], scene["density"], scene["free"]
    mass = density * np.pi * radius**2 * scene["aspect"]
    inertia = np.concatenate([mass, mass, mass * radius**2 * (1 + scene["aspect"]**2) / 4])
    fixed = 1 - np.concatenate([free, free, scene["turns"]])
    met = {key: 0 for key in ("sudden", "spared", "boundary", "new", "old")}
    for one in trials:
        number, dt, dt1, second, was_given, largest, last, given = one["figures"]
        q, ramp, newest = one["q"], one["trial"][0], 5 - int(one["trial"][1])
        most, change, since = one["asked"].reshape(3, -1)
        since = since + 1
        rate, force, due = np.zeros(15), np.zeros(15), np.zeros(5)
        if (given or was_given or loads) and second:
            rate, force = fixed * (one["given"] - q) / dt, one["load"] - one["pushed"]
            size = lengths(rate + one["load"] / inertia, radius)
            rate = rate - fixed * (q - one["q1"]) / dt1
            jump = lengths(rate + force / inertia, radius)
            sudden = jump > np.max([3 * change, 0.5 * most, np.full(5, 1e-6 * abs(q[:10]).max() / dt)], axis=0)
            due = sudden & (~((density < 1) & (free > 0)) | (since > 11.5))
            met["sudden"] += due.sum()
            met["spared"] += (sudden & ~due).sum()
            since = np.where(sudden, 0, since)
            most, change = np.maximum(most, size), jump
        asked, jumped, kept, inflow, change1, many = one["done"]
        assert asked == due.any() and kept == (given > 0)
        np.testing.assert_allclose(one["after"], np.concatenate([most, change, since]), rtol=1e-11)
        np.testing.assert_allclose(one["rate"], rate * np.tile(due, 3), rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(one["force"], force * np.tile(due, 3), rtol=1e-10, atol=1e-12)
        wanted, far, top = [], [], 0
        for now, before, data, held in ((one["u"], one["u1"], one["dataU"], scene["freeU"]), (one["v"], one["v1"], one["dataV"],
            scene["freeV"])):
            at = scene["freeU"] * scene["freeV"] == 0
            wanted.append(((ramp * data - now) / dt * (1 - held))[at])
            far.append(((now - before) / dt1 * (1 - held))[at])
            top = max(top, abs(data).max())
        wanted, far = np.concatenate(wanted), np.concatenate(far)
        if second:
            after, jump = max(largest, abs(wanted).max()), abs(wanted - far).max()
            sudden = largest >= 0 and jump > 3 * last and jump > 0.5 * after and jump * dt > 1e-6 * top
            met["boundary"] += sudden
            assert jumped == sudden and (inflow, change1) == pytest.approx((after, jump), rel=1e-9)
            np.testing.assert_allclose(one["boundary"], wanted - far if sudden else [], rtol=1e-9, atol=1e-9)
        else:
            assert jumped == 0 and (inflow, change1) == (largest, last)
        push = one["load"] + np.concatenate([np.zeros(5), -9 * (density - 1) * mass / density, np.zeros(5)])
        fresh = (np.arange(5) >= newest) & (np.hypot(push[:5], push[5:10]) * dt / mass > 0.01 * np.hypot(q[:5], q[5:10]))
        met["new"] += fresh.sum()
        met["old"] += (np.arange(5) >= newest).sum() - fresh.sum()
        assert many == fresh.sum()
        np.testing.assert_allclose(one["fresh"], push * np.tile(fresh, 3), rtol=1e-11, atol=1e-13)
    assert min(met.values()) > 2, met


# a body is sped up until the checkpoint and not after it; a stream that overtakes one begins in the step after it, while the
# criterion of the frames rests
KEPT = {"a motion that ends": (dict(particles="bodyHeld(bodyDisk(0.4, 0.5, 0.15, 1));", more="macro caseMotion(now) if (now < "
    "0.105) givenMotion(0, 3*(now), 0, 0); // EOM"), 0.14, 10),
        "a stream that begins": (dict(particles="bodyAdd(0.3, 0.5, 0.1, 1, 1, 0, 0, 0);", walls="labelBottom, labelTop",
            moving="labelLeft", outlet="labelRight",
                                      more="macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) "
                                          "inflowScale(labelLeft, ((now) < 0.125 ? 0.01 : 2.)); // EOM"), 0.16, 12)}


@pytest.mark.parametrize("name", KEPT)
def test_what_is_remembered_of_the_step_before_a_checkpoint_is_in_it(name, tmp_path):
    scene, end, keep = KEPT[name]
    (tmp_path / "scene.edp").write_text(case(gravity=0, **scene))
    whole, broken = broken_off([tmp_path / "scene.edp", "-cfl", "0", "-tend", end, "-every", "0", "-forces", "1", "-checkpoint",
        keep], tmp_path, keep)
    given, idle = (int((whole / f"restart_{keep:09d}.scheme").read_text().split()[k]) for k in (3, 6))
    assert given if "motion" in name else idle
    for table in ("particles", "forces"):
        assert (broken / f"{table}.csv").read_bytes() == (whole / f"{table}.csv").read_bytes(), table
