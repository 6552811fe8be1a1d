"""The check of the energy (lib/scheme/energy_guard.idp): what it stops, what it names, over a restart, and what it lets pass."""
import re

import numpy as np
import pytest

from tests.conftest import mesh, run_freefem
from tests.scenes import case, square
from tools.base.run_folder import RunFolder

SINKING = "bodyDisk(0.3, 0.7, 0.1, 2); bodyDisk(0.7, 0.3, 0.1, 1.01);"
JET = "macro caseStep() if (timeNow > 0.1) for (int i = 0; i < flowNw; ++i) if ((flowX[i] - 0.3)^2 + (flowY[i] - 0.7)^2 < 0.15^2) flowU[i] += {speed}; // EOM"
GROWTH = "macro caseStep() { flowU *= 1.06; flowV *= 1.06; flowU1 *= 1.06; flowV1 *= 1.06; bodyQ *= 1.06; bodyQ1 *= 1.06; } // EOM"
STOP = r"error: boundaries: at t = (\S+) s the kinetic energy is (\S+) times what was there and what boundaries, loads and weights have supplied since; the fluid is fastest, \S+ m/s, at \((\S+), (\S+)\) near particle 0;"


def test_a_run_in_which_the_fluid_begins_to_jet_stops_and_says_where(freefem_text, tmp_path):
    done = freefem_text(case(SINKING, more=JET.format(speed=1.0)), "-tend", 0.3, "-out", tmp_path / "run", check=False)
    said = re.search(STOP, done.stderr)
    assert done.returncode == 4 and said and len(done.stderr.strip().splitlines()) == 1
    time, times, x, y = map(float, said.groups())
    assert 0.1 < time < 0.135 and times > 2 and np.hypot(x - 0.3, y - 0.7) < 0.2
    assert RunFolder(tmp_path / "run").fluid["t"].max() < time


def test_a_slow_growth_is_stopped_at_the_same_time_by_a_run_that_was_broken_off(freefem_text, tmp_path):
    """The energy of earlier steps is kept in checkpoints."""
    text, found = case("bodyAdd(0.3, 0.7, 0.1, 2, 0.2, 0, 0, 1);", more=GROWTH, gravity=0, mu=0.005), []
    for words in (["-out", tmp_path / "whole", "-tend", 1], ["-out", tmp_path / "part", "-tend", 0.08, "-checkpoint", 8],
        ["-restart", tmp_path / "part", "-out", tmp_path / "rest", "-tend", 1]):
        done = freefem_text(text, *words, check=False)
        found.append((done.returncode, re.search(STOP, done.stderr)))
    assert [status for status, _ in found] == [4, 0, 4]
    # 12 % a step; by the steps after the break alone it would be later
    assert found[0][1].groups() == found[2][1].groups() and 0.085 < float(found[0][1][1]) < 0.135


def test_bodies_that_rise_and_sink_in_turn_earn_nothing_by_it(freefem_text, tmp_path):
    """A heavy disk and a light one, whose motion is turned round in every third step and grows by 15 %. With the work of their
    weights counted without its sign they were stopped at 0.94 s only, with 370 times the energy."""
    swing = "macro caseStep() if (driveStep % 3 == 0) {{ {} }} // EOM".format(" ".join(f"{name} *= -1.15;" for name in
        ("flowU", "flowV", "flowU1", "flowV1", "bodyQ", "bodyQ1")))
    done = freefem_text(case("{ bodyDisk(0.3, 0.7, 0.1, 2); bodyDisk(0.7, 0.3, 0.1, 0.5); }", more=swing, gravity=-2, mu=0.005),
        "-tend", 0.5, "-every", 0, "-out", tmp_path / "run", check=False)
    assert done.returncode == 4 and "kinetic energy is" in done.stderr


KEEP = """macro caseStep() {
    real E = flowSquare(flowM, flowU, flowV);
    if (driveStep > 5) { E = sqrt(2e-4/E); flowU *= E; flowV *= E; flowU1 *= E; flowV1 *= E; bodyQ *= E; bodyQ1 *= E; }
} // EOM"""


def test_what_is_created_as_fast_as_it_dissipates_is_found_by_a_run_that_was_broken_off_too(freefem_text, tmp_path):
    """The kinetic energy keeps nearly the value of the fifth step, while viscosity dissipates it once and again."""
    text = case("bodyAdd(0.3, 0.7, 0.1, 1, 0.2, 0, 0, 1);", more=KEEP, gravity=0, mu=0.02)
    found = []
    for words in (["-out", tmp_path / "whole", "-tend", 2], ["-out", tmp_path / "part", "-tend", 0.1, "-checkpoint", 10],
        ["-restart", tmp_path / "part", "-out", tmp_path / "rest", "-tend", 2]):
        done = freefem_text(text, *words, "-every", 0, check=False)
        found.append((done.returncode, re.search(r"t = (\S+) s what viscosity has dissipated is (\S+) times what was there",
            done.stderr)))
    assert [status for status, _ in found] == [4, 0, 4]
    assert found[0][1].groups() == found[2][1].groups() and 1.5 < float(found[0][1][2]) < 1.7


@pytest.mark.parametrize("name, text", [
    ("a heavy disk stops in a very viscous fluid, whose pressure throws it back", case("bodyAdd(0.5, 0.5, 0.1, 12, 0, -1, 0, 1);",
        mu=1.0, gravity=0)),
    ("a load that is reversed", case("bodyDisk(0.5, 0.5, 0.1, 0.1);", more="macro caseLoads(now) bodyPush(0, (now > 0.1 ? -0.1 : "
        "0.1), 0, 0); // EOM", gravity=0)),
    ("a lid set in motion when all is at rest", case("bodyDisk(0.5, 0.5, 0.1, 1);", walls="labelLeft, labelRight, labelBottom",
        moving="labelTop", more="macro boundaryU() (16*x*x*(1 - x)*(1 - x)) // EOM", gravity=0)
        .replace("boundaryRamp(real t) { return 1; }", "boundaryRamp(real t) { return t > 0.1; }")),
    ("a held disk that begins to oscillate", case("{ bodyHeld(bodyDisk(0.5, 0.5, 0.1, 1)); bodyDisk(0.3, 0.3, 0.1, 1.5); }",
        more="macro caseMotion(now) givenMotion(0, (now > 0.1 ? sin(20*now) : 0), 0, 0); // EOM", gravity=0)),
])
def test_energy_that_something_supplies_is_let_pass(name, text, freefem_text, tmp_path):
    freefem_text(text, "-tend", 0.3, "-every", 0, "-out", tmp_path / "run")
    assert RunFolder(tmp_path / "run").fluid["kinetic_energy"].max() > 0, name


@pytest.mark.parametrize("ratio", [0.001, 0.01])
def test_a_light_disk_may_be_let_go(ratio, meshes, tmp_path):
    """Single nodes beside it are several times too fast in the first steps, before viscosity reaches them. This is no energy from
    nothing."""
    run_freefem("cases/settling_disk.edp", "-rhos", ratio, "-mu", 0.01, "-dt", 0.0001, "-tend", 0.004, "-y", 3, "-mesh",
        mesh(meshes, "box_corridor", "--size", 0.25 / 8), "-out", tmp_path / "run")
    assert RunFolder(tmp_path / "run").fluid["t"].max() == pytest.approx(0.004)


@pytest.mark.parametrize("dt", [0.0008, 0.0002])
def test_a_light_disk_of_few_elements_that_is_let_go_is_let_pass(dt, freefem_text, tmp_path):
    """By the midpoint rule its velocities, which differ from node to node, have up to 2.7 times their energy: the run was stopped
    after 13 steps of any length, though kinetic energy and dissipation are less than the work of the weight."""
    file = tmp_path / "square.mesh"
    freefem_text(square(file) + case("bodyDisk(0.5, 0.86, 0.1, 0.017);", mu=0.0005, gravity=-1.8), "-mesh", file, "-dt", dt,
        "-tend", 25 * dt, "-every", 0, "-budget", 1, "-out", tmp_path / "run")
    budget = RunFolder(tmp_path / "run").table("budget")
    rest = budget["work"] - budget["kinetic_energy"] - budget["dissipated"]
    assert budget["work"][-1] > 0 and rest.min() > -0.02 * budget["work"].max()
