"""Starts of slow flows: no step is limited by the free fall that viscosity ends at once, and no body is faster than it can be."""
import numpy as np
import pytest

from tests.conftest import make_mesh
from tools.base.run_folder import RunFolder

SCENE = """
include "lib/case.idp"
optCase("slow", "bodies in a very viscous fluid");
optDefault("-every", "0");
real rhoFluid = {rho}, mu = {mu}, gravityX = 0, gravityY = {gravity};
int[int] flowNoSlip = [labelWall], flowMoving(0), flowOutlet(0), flowSlip(0);
func real boundaryRamp(real t) {{ return 1; }}
{more}
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
macro caseParticles() {{ {bodies} }} // EOM
include "scripts/resolved.edp"
"""


def scene(bodies, rho, mu, gravity, more=""):
    return SCENE.format(bodies=bodies, rho=rho, mu=mu, gravity=gravity, more=more)


def slow(kind, size):
    """The text of a scene in a box 10 by 20 radii `size`, m, and a step in which a body moves much less than an element."""
    r = size
    if kind == "mantle":
        return scene(f"bodyDisk({5 * r}, {12 * r}, {r}, 3400);", 3300, 1e21, -9.81), 2e10 * (1e5 / r)
    if kind == "colloid":
        return scene(f"bodyDisk({5 * r}, {12 * r}, {r}, 1050);", 1000, 1e-3, -9.81), 1.0
    if kind == "syrup":  # grams, centimetres
        return scene(f"bodyDisk({5 * r}, {12 * r}, {r}, 1.2);", 1, 1e6, -981), 20 / r
    if kind == "ellipse":
        return scene(f"bodyEllipse({5 * r}, {12 * r}, {r}, {0.6 * r}, 0.4, 3400);", 3300, 1e21, -9.81), 2e10 * (1e5 / r)
    return scene(f"bodyDisk({3 * r}, {12 * r}, {r}, 3400); bodyDisk({7 * r}, {14 * r}, {r}, 3200); bodyEllipse({5 * r}, {6 * r}, "
        f"{r}, {0.7 * r}, 1, 3500);", 3300, 1e21, -9.81), 2e10 * (1e5 / r)


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A function (radius, elements per radius) that gives a mesh file of a box of 10 by 20 radii."""
    folder = tmp_path_factory.mktemp("boxes")

    def make(radius, fine=2):
        text = f"{radius:g}_{fine}".replace("+", "")
        file = folder / f"box{text}.mesh"
        if not file.exists():
            make_mesh(file, "box", "--width", 10 * radius, "--height", 20 * radius, "--size", radius / fine)
        return file

    return make


@pytest.mark.parametrize("kind, radius", [("mantle", 1e5), ("colloid", 1e-7), ("syrup", 0.5), ("ellipse", 1e5), ("several", 1e5)])
def test_slow_flows_take_the_step_of_the_case(kind, radius, box, freefem_text, tmp_path):
    """As without -cfl. By free fall the first step was 1e-4 to 1e-12 of that, and steps grow by a fifth each; a mantle was
    refused."""
    text, dt = slow(kind, radius)
    for cfl in (0, 1.5):
        freefem_text(text, "-mesh", box(radius), "-dt", dt, "-tend", 4 * dt, "-cfl", cfl, "-out", tmp_path / f"run{cfl}")
    rows = [(tmp_path / f"run{cfl}" / "particles.csv").read_text() for cfl in (0, 1.5)]
    assert rows[0] == rows[1] and len(RunFolder(tmp_path / "run1.5").fluid["t"]) == 4


def test_a_body_in_a_mantle_sinks_as_faxen_says(box, freefem_text, tmp_path):
    """Between walls 2 h apart, k = R/h: the force over 4 pi mu U is 1/(-0.9157 - ln k + 1.7244 k^2 - 1.7302 k^4); the ends are 5
    channel widths away."""
    r, k = 1e5, 0.2
    text, dt = slow("mantle", r)
    freefem_text(text, "-mesh", make_mesh(tmp_path / "long.mesh", "box", "--width", 10 * r, "--height", 40 * r, "--size",
        r / 4).as_posix(), "-dt", dt, "-tend", 4 * dt, "-out", tmp_path / "run")
    speed = -100 * 9.81 * np.pi * r**2 / (4 * np.pi * 1e21) * (-0.9157 - np.log(k) + 1.7244 * k**2 - 1.7302 * k**4)
    assert RunFolder(tmp_path / "run").particles["v"][-1] == pytest.approx(speed, rel=0.015)


def test_a_fast_start_of_a_slow_flow_takes_small_steps_first(box, freefem_text, tmp_path):
    """Thrown at 1 m/s, half of which it keeps, into a mantle, which stops it at once: the first step, 1e-10 of -tend, is bounded by
    that speed, later ones grow. It was refused
    because steps of this size would be too many."""
    r = 1e5
    text = scene(f"bodyAdd({5 * r}, {12 * r}, {r}, 3400, 0, 1, 0, 1);", 3300, 1e21, -9.81, "macro caseStep() if (driveStep == "
        "6) exit(0); // EOM")
    freefem_text(text, "-mesh", box(r), "-dt", 2e13, "-tend", 1e15, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    dt = run.fluid["dt"]
    assert len(dt) == 6 and dt[0] < 2 * 1.6 * r / 2 and dt[1:] / dt[:-1] == pytest.approx(1.2, rel=0.01)


def test_a_strong_push_in_a_slow_flow_bounds_the_first_step(box, freefem_text, tmp_path):
    """A force of 1e12 times the weight gives a body 1e3 elements in a step of the case."""
    r = 1e5
    push = scene(f"bodyDisk({5 * r}, {12 * r}, {r}, 3400);", 3300, 1e21, -9.81, "macro caseLoads(now) bodyPush(0, 1e20, 0, 0); "
        "// EOM")
    freefem_text(push, "-mesh", box(r), "-dt", 2e10, "-tend", 1e7, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.fluid["dt"][0] < 1e7 and np.abs(run.particles["u"] * run.fluid["dt"]).max() < 3 * r / 2


# Units of the body: radius, density and viscosity of the fluid 1, so that nu dt/R^2 is the step; so slow that it hardly moves.
DISK, ELLIPSE = "bodyDisk(5.03, 10.02, 1, {s});", "bodyEllipse(5.03, 10.02, 1, 0.6, 0.4, {s});"


# Steps of nu dt/R^2 = 100 or more after which a body has its terminal velocity, to 1e-3 of what it has after four times as many.
SETTLED = 10


def sunk(freefem_text, folder, body, mesh, dt, steps, *words, more=""):
    """Velocities (rows, 2) of the body of id 0 in each step."""
    freefem_text(scene(body, 1, 1, -1e-9, more), "-mesh", mesh, "-dt", dt, "-tend", dt * steps, "-cfl", 0, *words, "-out", folder)
    rows = RunFolder(folder).particles
    mine = rows["id"] == 0
    return np.column_stack([rows["u"], rows["v"]])[mine]


@pytest.mark.parametrize("shape", [DISK, ELLIPSE])
@pytest.mark.parametrize("ratio", [0.1, 1.05, 20])
def test_a_start_never_exceeds_the_terminal_velocity(ratio, shape, box, freefem_text, tmp_path):
    """First rows were -0.7 (light), 1.8 and 4.6 times the terminal velocity, those of a body of 20 times the density up to 2 with
    nu dt/R^2 = 10. Where viscosity crosses the body many
    times in a step, it has its velocity in the first row."""
    body, mesh = shape.format(s=ratio), box(1)
    end = sunk(freefem_text, tmp_path / "end", body, mesh, 100, SETTLED)[-1, 1]
    for dt in (0.1, 1, 10, 1e4):
        share = sunk(freefem_text, tmp_path / f"run{dt}", body, mesh, dt, 6)[:, 1] / end
        assert len(share) == 6 and share.min() > -0.005 and share.max() < 1.02, (dt, share)
        assert dt < 1e4 or abs(share - 1).max() < 0.02, share
        assert dt in (0.1, 1) or (share[1:] > 0.98 * share[:-1]).all(), (dt, share)


def test_bodies_of_all_densities_start_together(box, freefem_text, tmp_path):
    bodies = "bodyDisk(3, 10, 1, 20); bodyDisk(7, 10.5, 0.8, 0.2); bodyEllipse(5, 15, 1, 0.6, 0.4, 1.5);"
    runs = []
    for dt, steps in ((1e3, 6), (100, SETTLED)):
        freefem_text(scene(bodies, 1, 1, -1e-9), "-mesh", box(1), "-dt", dt, "-tend", dt * steps, "-cfl", 0, "-out",
            tmp_path / f"run{steps}")
        rows = RunFolder(tmp_path / f"run{steps}").particles
        runs.append(np.column_stack([rows["u"], rows["v"], rows["omega"]]).reshape(-1, 3, 3))
    assert abs(runs[0] - runs[1][-1]).max() < 0.02 * abs(runs[1][-1]).max()


@pytest.mark.parametrize("ratio", [0.2, 1.05, 5])
def test_a_later_push_gives_no_more_than_the_terminal_velocity_either(ratio, box, freefem_text, tmp_path):
    """By a constant force from the fifth step on."""
    dt, mesh, push = 1e3, box(1, 3), "macro caseLoads(now) if (now > {from_}) bodyPush(0, 1e-9, 0, 0); // EOM"
    body = DISK.format(s=ratio)
    rows = []
    for start, steps in ((-1, SETTLED), (4.5 * dt, 11)):
        text = scene(body, 1, 1, 0, push.format(from_=start))
        freefem_text(text, "-mesh", mesh, "-dt", dt, "-tend", steps * dt, "-cfl", 0, "-out", tmp_path / f"run{steps}")
        rows.append(RunFolder(tmp_path / f"run{steps}").particles["u"])
    share = rows[1] / rows[0][-1]
    assert abs(share[:4]).max() == 0 and abs(share[4:] - 1).max() < 0.04, share


def test_a_body_that_enters_a_slow_flow_later_sinks_at_once(box, freefem_text, tmp_path):
    dt, mesh = 1e3, box(1, 3)
    rows = []
    for due, steps in ((0, SETTLED), (3.5 * dt, 9)):
        freefem_text(scene(f"queueAt(5.03, 10.02, 1, 2, {due});", 1, 1, -1e-9), "-mesh", mesh, "-dt", dt, "-tend", steps * dt,
            "-cfl", 0, "-out", tmp_path / f"run{steps}")
        rows.append(RunFolder(tmp_path / f"run{steps}").particles["v"])
    share = rows[1] / rows[0][-1]
    assert len(share) == 5 and abs(share - 1).max() < 0.04, share


def test_a_restart_within_a_slow_start_is_bit_for_bit(box, freefem_text, tmp_path):
    """The passes and the implicit second step belong to the start, not to the run."""
    text, words = scene(DISK.format(s=20), 1, 1, -1e-9), ["-mesh", box(1), "-dt", 10, "-cfl", 0, "-checkpoint", 1]
    freefem_text(text, *words, "-tend", 60, "-out", tmp_path / "whole")
    for step in (1, 3):
        freefem_text(text, *words, "-tend", 10 * step, "-out", tmp_path / f"part{step}")
        freefem_text(text, *words, "-tend", 60, "-restart", tmp_path / f"part{step}", "-out", tmp_path / f"rest{step}")
        whole, rest = ((tmp_path / name / "particles.csv").read_text().splitlines() for name in ("whole", f"rest{step}"))
        assert len(rest) == 1 + 6 - step and rest[1:] == whole[-(6 - step):]
