"""Particles carried by a flow: paths, orders, dispersion, sampling of the flow, contacts, exits, checkpoints."""
import csv
import json
import re

import numpy as np
import pytest

from conftest import ROOT, make_mesh
from tools import transport_exact as exact
from tools import validate_transport
from tools.command import BadInput
from tools.run_folder import RunFolder
from tools.tables import read_table
from tools.transport_table import main as transport_table
from tools.transport_table import fates, table_of
from tools.validation import Context

SCRIPT = "tests/transport/scripts/analytic.edp"


@pytest.mark.parametrize("name", ["tracer", "together", "unsteady", "dispersion", "pair"])
def test_paths(name, tmp_path):
    for row in getattr(validate_transport, name)(Context("transport", tmp_path, 300, lambda line: None)):
        assert row.passed, f"{row.quantity}: {row.measured} (target {row.target}, {row.allowed}) {row.reason}"


def test_flow_at_points_is_exact_for_a_quadratic(freefem):
    text = freefem("tests/transport/scripts/carrier.edp").stdout
    number = {name: float(value) for name, value in re.findall(r"^(time|worst|outside|edges|lost) (\S+)", text, re.M)}
    assert number["worst"] < 1e-10 and number["outside"] == 0
    assert number["edges"] > 1000 and number["lost"] == 0
    assert "flags 01010" in text
    values = [float(word) for word in re.search(r"^rim (.*)", text, re.M)[1].split()]
    assert values[0] == pytest.approx(values[1], abs=0.02) and values[2] == pytest.approx(values[3], abs=0.02)


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_contacts_keep_falling_spheres_apart(freefem, run_folder):
    """Large spheres fall on small ones below them: none overlaps."""
    freefem(SCRIPT, "-out", run_folder, "-number", 5, "-spread", 0.012, "-radius", 0.001, "-contacts", 1, "-density", 2500, "-radius-last", 0.0005,
            "-drag", "brown-lawler", "-tend", 0.2, "-dt", 0.001)
    table = rows(run_folder / "particles.csv")
    end = max(float(row["t"]) for row in table)
    last = sorted((row for row in table if float(row["t"]) == end), key=lambda row: int(row["id"]))
    y, r, x = (np.array([float(row[name]) for row in last]) for name in ("y", "radius", "x"))
    assert (np.hypot(np.diff(x), np.diff(y)) - r[1:] - r[:-1]).min() > -1e-10
    gaps = [float(row["worst_gap"]) for row in rows(run_folder / "steps.csv") if float(row["worst_gap"]) < 1e29]
    assert min(gaps) > -1e-8 * 0.0005


def test_gaps_and_normals_of_contacts_are_of_their_row_s_time(freefem, run_folder):
    """They were those before the step's move."""
    freefem(SCRIPT, "-out", run_folder, "-flow", "straining", "-rate", 20, "-number", 5, "-start-x", 0.01, "-start-y", -0.006, "-spread", 0.012, "-radius", 0.001,
            "-radius-last", 0.0012, "-contacts", 1, "-gravity", -5, "-drag", "brown-lawler", "-tend", 0.1, "-dt", 0.002, "-every", 0.002)
    at = {(row["t"], row["id"]): np.array([float(row[name]) for name in ("x", "y", "radius")]) for row in rows(run_folder / "particles.csv")}
    touching = rows(run_folder / "contacts.csv")
    assert len(touching) > 20
    for row in touching:
        apart = at[row["t"], row["i"]] - at[row["t"], row["j"]]
        far = np.hypot(*apart[:2])
        assert float(row["gap"]) == pytest.approx(far - at[row["t"], row["i"]][2] - at[row["t"], row["j"]][2], abs=2e-12)
        np.testing.assert_allclose([float(row["nx"]), float(row["ny"])], apart[:2] / far, atol=1e-8)


FLOOR = """include "lib/case.idp"
optCase("floor", "small spheres on a floor");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = -9.81;
macro carrierExact(px, py, t) carrierU = 0.; // EOM
macro caseParticles() {
    contactWallSegment(-1, 0, 1, 0);
    real[int] x0 = [0., 0.1, 0.2], y0 = [3e-5, 2e-4, 2e-3], r = [3e-5, 2e-4, 2e-3], d = [2500., 2500., 2500.], z = [0., 0., 0.];
    transportAppend(x0, y0, r, d, z, z, z);
} // EOM
include "scripts/transport.edp"
"""


@pytest.mark.parametrize("history", [0, 1])
def test_spheres_on_a_floor_press_with_their_weight_whatever_the_step(history, freefem_text, tmp_path):
    """The drag had taken its part of what the contact had to undo, and the history's: of the weight of the smallest 29 % were left, 21 % with history."""
    freefem_text(FLOOR, "-dt", 0.002, "-tend", 0.1, "-drag", "stokes", "-history", history, "-out", tmp_path / "run")
    table = rows(tmp_path / "run/contacts.csv")
    for one, radius in enumerate((3e-5, 2e-4, 2e-3)):
        pressed = [float(row["impulse"]) for row in table if row["i"] == str(one)]
        assert len(pressed) >= 49 and pressed == pytest.approx([1500 * 4 / 3 * np.pi * radius**3 * 9.81 * 0.002] * len(pressed), rel=1e-6)


SLIDE = FLOOR.replace("gravityX = 0", "gravityX = optReal(\"-gx\", 0, \"m/s2\", \"gravity along the floor\"), rate0 = optReal(\"-rate\", 0, \"1/s\", \"rate of shear\")")
SLIDE = SLIDE.replace("carrierU = 0.;", "carrierU = rate0*py; carrierUY = rate0;")


@pytest.mark.parametrize("dt", [0.002, 0.02])
def test_spheres_slide_on_a_floor_by_the_forces_along_it_whatever_the_step(dt, freefem_text, tmp_path):
    """They had the drag of their fall in each step, and its lift, and the shear below the floor: in a shear flow they went upstream, down a slope of 45 degrees by up to 12 % too slowly."""
    radii = np.array([3e-5, 2e-4, 2e-3])
    for law in ("constant", "schiller-naumann"):
        freefem_text(SLIDE, "-dt", dt, "-tend", 0.6, "-every", 0.6, "-drag", law, "-gx", 9.81, "-out", tmp_path / law)
        slides = read_table(tmp_path / law / "particles.csv")
        fall = [exact.terminal_velocities(law, radius, 2500.0)[0] for radius in radii]
        assert slides["u"][-3:] == pytest.approx(fall, rel=1e-5) and slides["y"][-3:] == pytest.approx(radii, rel=1e-6)
    freefem_text(SLIDE, "-dt", dt, "-tend", 0.6, "-every", 0.6, "-drag", "constant", "-rate", 2, "-out", tmp_path / "shear")
    k = 3 / 8 * 0.44 * 1000 / 3000 / radii  # (m_p + m_f/2) dU/dt = 0.22 rho pi R2 (u - U)^2
    assert read_table(tmp_path / "shear/particles.csv")["u"][-3:] == pytest.approx(2 * radii * (1 - 1 / (1 + k * 2 * radii * 0.6)), rel=1e-5)


def test_who_slides_steadily_needs_no_pass_beyond_those_of_the_drag(freefem_text, tmp_path):
    """The contact forces of the last step start the next, of who stays when the first of three leaves too: it took 5 passes, of which 3 were not counted. A step that begins a contact has more than one without."""
    text = SLIDE.replace("macro caseParticles", "macro caseBound() 0.3 // EOM\nmacro caseParticles")
    for old, new in (("x0 = [0., 0.1, 0.2]", "x0 = [0.2, 0.1, 0.]"), ("[3e-5, 2e-4, 2e-3]", "[2e-3, 2e-4, 3e-5]"), ("d = [2500., 2500., 2500.]", "d = [2500., 4000., 1600.]")):
        assert old in text
        text = text.replace(old, new)
    found = {}
    for contacts in (1, 0):
        freefem_text(text, "-dt", 0.02, "-tend", 2, "-every", 0, "-drag", "schiller-naumann", "-gx", 0.5, "-contacts", contacts, "-out", tmp_path / str(contacts))
        found[contacts] = read_table(tmp_path / str(contacts) / "steps.csv")
    (begin,), steady = found[1]["passes"][found[1]["step"] == 1], found[1]["t"] > 1.25
    gone = rows(tmp_path / "1/exits.csv")
    assert [row["id"] for row in gone] == ["0"] and 1.3 < float(gone[0]["t"]) < 1.8
    assert begin > found[0]["passes"][found[0]["step"] == 1][0]
    assert (found[1]["passes"][steady] == 2).all()


HEAP = FLOOR.replace("gravityX = 0", "gravityX = 0, rate0 = 5").replace("carrierU = 0.;", "carrierU = rate0*py; carrierUY = rate0;")
HEAP = HEAP.replace("contactWallSegment(-1, 0, 1, 0);", "contactWallSegment(0, 0, 8e-3, 0); contactWallSegment(0, 0, 0, 1); contactWallSegment(8e-3, 0, 8e-3, 1);")
HEAP = HEAP.replace("x0 = [0., 0.1, 0.2], y0 = [3e-5, 2e-4, 2e-3], r = [3e-5, 2e-4, 2e-3], d = [2500., 2500., 2500.], z = [0., 0., 0.]",
                    "x0 = [1e-3, 3.2e-3, 5.5e-3, 2.1e-3, 4.6e-3, 6.5e-3, 3.3e-3], y0 = [1e-3, 1.1e-3, 1.2e-3, 3.5e-3, 3.6e-3, 3.6e-3, 6e-3], r = [1e-3, 1.1e-3, 1.2e-3, 0.9e-3, 1e-3, 0.8e-3, 1e-3], d(7), z(7); d = 2500; z = 0.")


def test_walls_bear_the_weight_of_a_heap_at_rest_and_its_drag_in_a_shear_flow(freefem_text, tmp_path):
    """Seven spheres between two walls: the floor bears their weight less buoyancy, the sides the drag of the flow at the places where they have come to rest."""
    assert "rate0*py" in HEAP and "8e-3, 1" in HEAP and "d(7)" in HEAP
    freefem_text(HEAP, "-dt", 0.002, "-tend", 0.8, "-every", 0.02, "-drag", "schiller-naumann", "-lift", 0, "-out", tmp_path / "run")
    last = {name: values[-7:] for name, values in read_table(tmp_path / "run/particles.csv").items()}
    press = read_table(tmp_path / "run/contacts.csv")
    slip, radius = 5 * last["y"], last["radius"]
    assert max(abs(last["u"]).max(), abs(last["v"]).max()) < 1e-10
    drag = sum(0.5 * 1000 * np.pi * r**2 * exact.schiller_naumann(1e6 * 2 * r * s) * s**2 for r, s in zip(radius, slip))
    weight = (1500 * 4 / 3 * np.pi * radius**3 * 9.81).sum()
    for t in sorted(set(press["t"]))[-5:]:
        now = press["t"] == t
        assert (press["impulse"] * press["ny"])[now & (press["j"] == -1)].sum() == pytest.approx(0.002 * weight, rel=1e-9)
        assert -(press["impulse"] * press["nx"])[now & (press["j"] < -1)].sum() == pytest.approx(0.002 * drag, rel=1e-9)


@pytest.mark.parametrize("dt", [0.0005, 0.02])
def test_small_spheres_in_contact_fall_as_one_whatever_the_step(dt, freefem, run_folder):
    """Their drags count where these are fast, not their masses: they fell by 6 and 22 % too fast."""
    radii = np.array([3e-5, 6e-5])
    freefem(SCRIPT, "-out", run_folder, "-number", 2, "-radius", radii[0], "-radius-last", radii[1], "-spread", radii.sum(), "-contacts", 1, "-lift", 0, "-drag", "stokes", "-tend", 0.1, "-dt", dt, "-every", 0.02)
    table = rows(run_folder / "particles.csv")[-2:]
    speed = 1500 * 4 / 3 * np.pi * (radii**3).sum() * 9.81 / (6 * np.pi * 1e-3 * radii.sum())
    assert [float(row["v"]) for row in table] == pytest.approx([-speed, -speed], rel=1e-6)
    fallen = [float(row["y"]) for row in rows(run_folder / "particles.csv") if abs(float(row["t"]) - 0.08) < 1e-9]
    assert [float(row["y"]) - y for row, y in zip(table, fallen, strict=True)] == pytest.approx([-0.02 * speed] * 2, rel=1e-5)


def test_two_runs_with_one_seed_are_the_same_and_another_seed_differs(freefem, tmp_path):
    words = ["-turbulence", "fluctuation", "-sigma", 0.1, "-number", 5, "-tend", 0.05, "-dt", 0.01]
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        freefem(SCRIPT, "-out", tmp_path / name, "-turbulence-seed", seed, *words)
    texts = [(tmp_path / name / "particles.csv").read_text() for name in "abc"]
    assert texts[0] == texts[1] != texts[2]


def test_the_time_of_the_fluctuations_is_their_constant_times_k_over_epsilon(freefem, tmp_path):
    words = ["-turbulence", "fluctuation", "-sigma", 0.1, "-number", 5, "-tend", 0.05, "-dt", 0.01]
    for name, constant, decay in (("a", 0.3, 1), ("b", 0.6, 2), ("c", 0.6, 1)):
        freefem(SCRIPT, "-out", tmp_path / name, "-turbulence-time", constant, "-decay", decay, *words)
    one, same, other = (read_table(tmp_path / name / "particles.csv")["u"] for name in "abc")
    assert one == pytest.approx(same, rel=1e-12) and abs(one - other).max() > 1e-3


def test_the_fluctuations_of_a_particle_do_not_depend_on_who_else_is_there(freefem, tmp_path):
    found = []
    for number in (3, 5):
        freefem(SCRIPT, "-out", tmp_path / str(number), "-turbulence", "fluctuation", "-sigma", 0.1, "-number", number, "-tend", 0.05, "-dt", 0.01)
        found.append([row for row in rows(tmp_path / str(number) / "particles.csv") if int(row["id"]) < 3])
    assert found[0] == found[1]
    assert len({row["u"] for row in found[0] if row["t"] == found[0][-1]["t"]}) == 3


def test_the_paper_s_turbulent_force_acts_across_the_flow(freefem, run_folder):
    freefem(SCRIPT, "-out", run_folder, "-flow", "uniform", "-speed", 2, "-start-u", 2, "-turbulence", "paper", "-sigma", 0.2, "-buoyancy", 0,
            "-number", 200, "-tend", 0.05, "-dt", 0.01)
    table = [row for row in rows(run_folder / "particles.csv") if float(row["t"]) > 0.045]
    assert np.std([float(row["v"]) for row in table]) > 1e-3
    assert np.ptp([float(row["u"]) for row in table]) < 0.2 * np.ptp([float(row["v"]) for row in table])


def test_the_paper_s_turbulent_force_is_its_formula(freefem, tmp_path):
    """F = (1/2) rho_f pi R^2 C U_f u'_y to the left of the flow: frozen fluctuations, which the spheres that follow the fluid show, and hardly any other force."""
    words = ["-number", 50, "-sigma", 0.2, "-decay", 1e-9, "-turbulence-seed", 7, "-buoyancy", 0, "-added-mass", 0, "-fluid-acceleration", 0, "-lift", 0, "-magnus", 0, "-history", 0]
    def end(name, *more):
        freefem(SCRIPT, "-out", tmp_path / name, *words, *more)
        table = rows(tmp_path / name / "particles.csv")
        return np.array([[float(row["u"]), float(row["v"])] for row in table if row["t"] == table[-1]["t"]])
    fluctuation = end("tracers", "-turbulence", "fluctuation", "-mu", 1e5, "-drag", "stokes", "-tend", 0.002, "-dt", 0.001)[:, 1]
    assert np.std(fluctuation) == pytest.approx(0.2, rel=0.25)
    paper = ["-turbulence", "paper", "-turbulence-coefficient", 3, "-mu", 1e-9, "-drag", "stokes", "-radius", 0.002, "-tend", 0.01, "-dt", 0.001]
    force = 0.5 * 1000 * np.pi * 0.002**2 * 3 * fluctuation
    mass = 2500 * 4 / 3 * np.pi * 0.002**3
    along = end("along", "-flow", "uniform", "-speed", 2, "-start-u", 2, *paper)
    assert along[:, 1] == pytest.approx(2 * force / mass * 0.01, rel=1e-3) and along[:, 0] == pytest.approx(2, abs=1e-6)
    up = end("up", "-flow", "straining", "-rate", 1e-3, "-start-y", -2000, "-start-v", 2, *paper)
    assert up[:, 0] == pytest.approx(-2 * force / mass * 0.01, rel=1e-3) and up[:, 1] == pytest.approx(2, abs=1e-3)


@pytest.mark.parametrize("paper", [False, True])
def test_the_drift_of_the_fluctuations_is_that_of_a_well_mixed_fluid(paper, freefem, tmp_path):
    """With the same random numbers, with and without it: w gains T grad(sigma)/(1 + tau/T) (1 - exp(-t/T)), its mean over a step of dt = a T that times 1 - (1 - exp(-a))/a.
    Tracers show it by their places; of spheres of a response time tau = T the paper's force does, across the flow."""
    dt, T, sigma, slope, radius = 0.2, 0.3, 0.2, 0.5, 0.001
    words = ["-number", 9, "-start-y", 0.4, "-spread", 1, "-sigma", sigma, "-sigma-slope", slope, "-drag", "stokes", "-radius", radius, "-buoyancy", 0, "-added-mass", 0, "-lift", 0, "-tend", dt, "-dt", dt]
    if paper:
        words += ["-turbulence", "paper", "-flow", "uniform", "-speed", 2, "-start-u", 2, "-mu", 2500 * 2 / 9 * radius**2 / T]
    else:
        words += ["-turbulence", "fluctuation", "-mu", 1e6]
    ends = []
    for drift in (0, 1):
        freefem(SCRIPT, "-out", tmp_path / str(drift), *words, "-turbulence-drift", drift)
        table = rows(tmp_path / str(drift) / "particles.csv")
        ends.append(np.array([[float(row["y"]), float(row["v"])] for row in table if row["t"] == table[-1]["t"]]))
    y, a = 0.4 + np.linspace(0, 1, 9), dt / T
    mean = sigma * (1 + slope * np.cos(y)) * T * -sigma * slope * np.sin(y) / (1 + paper) * (1 - (1 - np.exp(-a)) / a)
    if paper:
        force = 0.5 * 1000 * np.pi * radius**2 * 2 * mean / (2500 * 4 / 3 * np.pi * radius**3)
        np.testing.assert_allclose((ends[1] - ends[0])[:, 1], force * T * (1 - np.exp(-a)), rtol=1e-6)
    else:
        np.testing.assert_allclose((ends[1] - ends[0])[:, 0], dt * mean, rtol=1e-4)


QUEUE = ["-tend", 0.12, "-checkpoint", 20]


@pytest.mark.parametrize("more", [["-turbulence", "fluctuation"], ["-turbulence", "paper", "-history", 0], ["-coupling", "two-way", "-coupling-solver", "umfpack"]])
def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(freefem, tmp_path, more):
    """With particles that wait, seeded turbulence, history and contacts; the one that goes on lacks the last checkpoint and has rows too many."""
    words = ["-mesh", make_mesh(tmp_path / "pipe.mesh", "pipe_obstacles", "--size", 0.025), *QUEUE, *more]
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    freefem("tests/transport/scripts/queue.edp", *words, "-out", whole)
    freefem("tests/transport/scripts/queue.edp", *words[:2], "-tend", 0.1, *words[4:], "-out", broken)
    for file in broken.glob("restart_000000050*"):
        file.unlink()
    freefem("tests/transport/scripts/queue.edp", *words, "-restart", broken)
    names = ["particles.csv", "entries.csv", "exits.csv", "contacts.csv"]
    assert len(rows(whole / "entries.csv")) > 12 and len(rows(whole / "contacts.csv")) > 5
    waiting = [int(row["waiting"]) for row in rows(whole / "steps.csv") if int(row["step"]) == 40][0]
    assert waiting > 0
    for name in names:
        assert (whole / name).read_bytes() == (broken / name).read_bytes(), name
    for name in ["steps.csv"] + (["coupling.csv"] if "two-way" in more else []):
        for one, other in zip(rows(whole / name), rows(broken / name), strict=True):
            assert {key: value for key, value in one.items() if "time" not in key} == {key: value for key, value in other.items() if "time" not in key}, name


def test_who_enters_after_a_restart_draws_as_before_whatever_else_drew(freefem_text, coarse, tmp_path):
    """Particles that are there at the start draw before the queue resets FreeFEM's generator."""
    text = (ROOT / "tests/transport/scripts/queue.edp").read_text()
    first = "real[int] x0 = [0.01], y0 = [0.05], r0 = [0.005], d0 = [2500.], z0 = [0.]; transportAppend(x0, y0, r0, d0, z0, z0, z0);"
    text = text.replace("macro caseParticles() ", "macro caseParticles() " + first + " ")
    words = ["-mesh", coarse, "-checkpoint", 5, "-out"]
    freefem_text(text, "-tend", 0.04, *words, tmp_path / "whole")
    freefem_text(text, "-tend", 0.02, *words, tmp_path / "broken")
    freefem_text(text, "-tend", 0.04, *words[:-1], "-restart", tmp_path / "broken")
    entries = [float(row["t"]) for row in rows(tmp_path / "whole/entries.csv")]
    assert entries[0] == 0 and max(entries) > 0.02
    assert (tmp_path / "whole/particles.csv").read_bytes() == (tmp_path / "broken/particles.csv").read_bytes()


def test_a_restart_with_other_options_or_without_a_checkpoint_is_refused(freefem, coarse, tmp_path):
    words = ["-mesh", coarse, "-tend", 0.01, "-checkpoint", 2]
    freefem("tests/transport/scripts/queue.edp", *words, "-out", tmp_path / "run")
    for folder, more in (("run", ["-lift", 0]), ("nowhere", [])):
        done = freefem("tests/transport/scripts/queue.edp", *words, *more, "-restart", tmp_path / folder, check=False)
        assert done.returncode == 3 and len(done.stderr.splitlines()) == 1
    done = freefem("tests/transport/scripts/queue.edp", "-mesh", "meshes/pipe_obstacles.mesh", "-checkpoint", 2, "-tend", 0.02, "-restart", tmp_path / "run", check=False)
    assert done.returncode == 3 and "another mesh" in done.stderr


LAMINAR = ["-model", "laminar", "-reynolds", 100]


@pytest.mark.slow
def test_pipe_transport_reuses_its_flow_and_loses_nobody(freefem, tmp_path):
    folder = tmp_path / "flow"
    words = [*LAMINAR, "-flow", folder, "-tend", 0.5, "-number", 20]
    first = freefem("cases/pipe_transport.edp", *words, "-out", tmp_path / "one", timeout=900)
    second = freefem("cases/pipe_transport.edp", *words, "-out", tmp_path / "two", timeout=300)
    assert "computing the steady flow" in first.stdout and "is taken from" in second.stdout
    assert (tmp_path / "one/particles.csv").read_text() == (tmp_path / "two/particles.csv").read_text()
    last = rows(tmp_path / "two/steps.csv")[-1]
    assert int(last["lost"]) == 0 and int(last["entered"]) == int(last["particles"]) + int(last["left"])
    worst = min(float(row["worst_gap"]) for row in rows(tmp_path / "two/steps.csv"))
    assert worst > -1e-8 * 0.01
    refused = freefem("cases/pipe_transport.edp", *LAMINAR, "-vmax", 1, "-flow", folder, "-out", tmp_path / "three", check=False)
    assert refused.returncode == 3 and len(refused.stderr.splitlines()) == 1 and "another setting" in refused.stderr


def test_a_run_that_is_no_steady_flow_is_not_overwritten(freefem, freefem_refused, tmp_path):
    freefem("cases/settling_disk.edp", "-tend", 0.01, "-out", tmp_path / "run")
    kept = (tmp_path / "run/particles.csv").read_text()
    line = freefem_refused(3, "cases/pipe_transport.edp", *LAMINAR, "-flow", tmp_path / "run", "-out", tmp_path / "other")
    assert "no steady flow" in line and (tmp_path / "run/particles.csv").read_text() == kept


def test_a_missing_mesh_is_one_line_and_status_3(freefem, tmp_path):
    done = freefem("cases/pipe_transport.edp", "-out", tmp_path / "run", "-mesh", "nowhere.mesh", check=False)
    assert done.returncode == 3 and "cannot read the mesh file" in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("name", ["README.md", "README.md/flow"])
def test_a_flow_that_cannot_be_a_folder_is_refused(name, freefem_refused, tmp_path):
    readme = (ROOT / "README.md").read_bytes()
    line = freefem_refused(3, "cases/pipe_transport.edp", *LAMINAR, "-flow", name, "-out", tmp_path / "other")
    assert name in line and (ROOT / "README.md").read_bytes() == readme and not (ROOT / "README.md.log").exists()


@pytest.mark.parametrize("dt, steps", [(0.003, 4), (1, 1), (0.0025, 4)])
def test_the_last_step_ends_at_the_end(dt, steps, freefem, run_folder):
    freefem(SCRIPT, "-out", run_folder, "-tend", 0.01, "-dt", dt)
    last = rows(run_folder / "steps.csv")[-1]
    assert float(last["t"]) == pytest.approx(0.01, rel=1e-12) and int(last["step"]) == steps


def test_a_restart_keeps_its_step(freefem, freefem_refused, tmp_path):
    freefem(SCRIPT, "-out", tmp_path / "run", "-tend", 0.01, "-dt", 0.003, "-checkpoint", 2)
    assert "steps of 0.0025 s" in freefem_refused(3, SCRIPT, "-out", tmp_path / "more", "-tend", 0.021, "-dt", 0.003, "-restart", tmp_path / "run")


def test_the_angle_is_the_integral_of_the_rotation(freefem, tmp_path):
    """Omega relaxes to half the vorticity, -1, at the rate 15 mu/(rho_p R2) = 15 /s, exactly at any step; its integral is the angle."""
    words = ["-flow", "shear", "-rate", 2, "-start-omega", 3, "-radius", 0.02, "-mu", 1, "-magnus", 1, "-gravity", 0, "-tend", 0.4]
    for dt in (0.04, 0.00125):
        freefem(SCRIPT, "-out", tmp_path / str(dt), *words, "-dt", dt)
        last = rows(tmp_path / str(dt) / "particles.csv")[-1]
        assert float(last["theta"]) == pytest.approx(-0.4 + 4 / 15 * (1 - np.exp(-6)), rel=1e-9) and float(last["omega"]) == pytest.approx(-1 + 4 * np.exp(-6), rel=1e-9)


@pytest.mark.parametrize("ratio", [0.1, 1, 4])
def test_spreading_does_not_hang_on_the_step(ratio, freefem, run_folder):
    """Displacements of 5,000 tracers after 12 Lagrangian times against Taylor (1921), their velocities against sigma: within 3.5 standard errors."""
    sigma, lagrangian, n = 0.1, 0.3, 5000
    freefem(SCRIPT, "-out", run_folder, "-turbulence", "fluctuation", "-sigma", sigma, "-decay", 1, "-density", 1000, "-radius", 1e-5, "-drag", "stokes",
            "-gravity", 0, "-lift", 0, "-number", n, "-tend", 12*lagrangian, "-dt", ratio*lagrangian, "-every", 12*lagrangian)
    last = rows(run_folder / "particles.csv")[-n:]
    for names, variance in (("xy", exact.dispersion(12*lagrangian, sigma, lagrangian)), ("uv", sigma**2)):
        measured = np.mean([np.var([float(row[name]) for row in last]) for name in names])
        assert measured == pytest.approx(variance, rel=3.5*(2/(2*n))**0.5)


@pytest.mark.parametrize("slowness, ratio", [(0.3, 1), (3, 16)])
def test_velocities_of_inertial_spheres_in_turbulence_do_not_hang_on_the_step(slowness, ratio, freefem, run_folder):
    """Spheres at rest at first, of a response time of so many Lagrangian times; steps of `ratio` of these. They were 3.3 % slow, 33 % fast."""
    sigma, lagrangian, n = 0.1, 0.3, 8000
    tau = slowness * lagrangian
    dt = ratio * lagrangian
    end = dt * np.ceil(4 * (lagrangian + tau) / dt)
    freefem(SCRIPT, "-out", run_folder, "-turbulence", "fluctuation", "-sigma", sigma, "-decay", 1, "-radius", np.sqrt(4.5e-3 * tau / 2500), "-added-mass", 0, "-drag", "stokes",
            "-gravity", 0, "-lift", 0, "-number", n, "-tend", end, "-dt", dt, "-every", end)
    last = read_table(run_folder / "particles.csv")
    last = {name: last[name][-n:] for name in "xyuv"}
    place, velocity = exact.inertial(end, sigma, lagrangian, tau)
    for names, variance in (("xy", place), ("uv", velocity)):
        assert np.mean([np.var(last[name]) for name in names]) == pytest.approx(variance, rel=3.5 * (1 / n)**0.5)


THROWN = """
include "lib/case.idp"
include "lib/mesh/labels.idp"
optCase("thrown", "small heavy spheres thrown at a wall in a fluid at rest");
optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro caseCarrier() carrierWh still = 0*x; carrierFlow(still[], still[]); // EOM
macro caseWallLabels() [labelBottom] // EOM
macro caseParticles() {
    int n = 41;
    real[int] x0 = 1:n, y0 = 1:n, r(n), d(n), u0(n), v0(n), w0(n);
    x0 *= 0.02; y0 *= 1e-4; y0 += 5e-3; r = 2e-4; d = 2500; u0 = 0; v0 = -1; w0 = 0;
    transportAppend(x0, y0, r, d, u0, v0, w0);
} // EOM
include "scripts/transport.edp"
"""


@pytest.mark.parametrize("dt", [0.002, 0.0005])
def test_small_spheres_are_not_lost_at_a_wall(dt, freefem_text, tmp_path):
    """The middle of their step lies beyond the wall that holds them (all 41 were taken out with steps of 0.002 s)."""
    freefem_text(THROWN, "-dt", dt, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-out", tmp_path / "run")
    steps, last = rows(tmp_path / "run/steps.csv")[-1], rows(tmp_path / "run/particles.csv")[-41:]
    assert (steps["particles"], steps["lost"]) == ("41", "0") and rows(tmp_path / "run/exits.csv") == []
    assert all(float(row["t"]) > 0.05 - 1e-9 and float(row["y"]) > 2e-4 - 1e-9 for row in last)


def test_who_leaves_is_counted_once_by_the_outlet_or_lost(freefem_text, tmp_path):
    """Of 41 spheres between x = 0.02 and 0.82 those beyond 0.615 have left through the outlet in the first step, the others are lost below the bottom in time; those that enter later are told of once."""
    more = 'macro caseBound() 0.615 // EOM\nmacro caseParticles() { queueAt(0.3, 0.5, 2e-4, 2500, 0.02); queueAt(0.4, 0.5, 2e-4, 2500, 0.03);'
    text = THROWN.replace("[labelBottom]", "[labelTop]").replace("macro caseParticles() {", more)
    freefem_text(text, "-dt", 0.002, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-every", 0, "-out", tmp_path / "run")
    gone, steps, entered = rows(tmp_path / "run/exits.csv"), read_table(tmp_path / "run/steps.csv"), rows(tmp_path / "run/entries.csv")
    through = [row for row in gone if row["outlet"] == "1"]
    assert len(through) == 11 and all(float(row["t"]) == 0.002 and float(row["x"]) > 0.615 for row in through)
    assert [int(row["id"]) for row in through] == list(range(30, 41)) and sorted(int(row["id"]) for row in gone) == list(range(41))
    for name, outlet in (("left", "1"), ("lost", "0")):
        assert steps[name].tolist() == [sum(row["outlet"] == outlet and float(row["t"]) <= t + 1e-9 for row in gone) for t in steps["t"]]
    assert [int(row["id"]) for row in entered] == list(range(43)) and [float(row["t"]) for row in entered[-2:]] == pytest.approx([0.02, 0.03])
    assert (steps["particles"] + steps["waiting"] + steps["left"] + steps["lost"]).tolist() == [43] * len(steps["t"])


def test_a_sphere_beyond_the_mesh_is_taken_out(freefem_text, tmp_path):
    freefem_text(THROWN.replace("[labelBottom]", "[labelTop]"), "-dt", 0.002, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-out", tmp_path / "run")
    gone = rows(tmp_path / "run/exits.csv")
    assert len(gone) == 41 and all(float(row["y"]) < 0 and row["outlet"] == "0" for row in gone)


PAIR = """include "lib/case.idp"
optCase("pair", "spheres that overlap or stand outside at the start");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
optDefault("-contacts", "1");
{flow}
macro caseParticles() {{ {particles} }} // EOM
include "scripts/transport.edp"
"""
STILL = "macro carrierExact(px, py, t) carrierU = 0.; // EOM"
TWO = "real[int] x0 = [0., 0.01], y0 = [0., 0.], r = [0.01, 0.01], d = [2500., 2500.], z = [0., 0.]; transportAppend(x0, y0, r, d, z, z, z);"
UNIFORM = """include "lib/mesh/labels.idp"
macro caseWallLabels() [labelWall] // EOM
macro caseBound() 1. // EOM
macro caseCarrier() {{ carrierWh u = 1., v = 0.; carrierFlow(u[], v[]); }} // EOM""".replace("{{", "{").replace("}}", "}")


def test_overlaps_at_the_start_are_refused_or_pushed_apart(freefem_text, tmp_path):
    """They were shot apart at half the overlap over the time step."""
    text, words = PAIR.format(flow=STILL, particles=TWO), ["-dt", 0.001, "-tend", 0.01]
    refused = freefem_text(text, *words, "-out", tmp_path / "no", check=False)
    assert refused.returncode == 5 and "particles 0 and 1 overlap by 0.01" in refused.stderr
    freefem_text(text, *words, "-contact-initial", "push", "-out", tmp_path / "pushed")
    last = rows(tmp_path / "pushed" / "particles.csv")[-2:]
    assert abs(float(last[1]["x"]) - float(last[0]["x"])) == pytest.approx(0.02, abs=1e-6)
    assert max(abs(float(row["u"])) for row in last) < 1e-6


def test_waiting_particles_that_would_enter_outside_the_mesh_are_refused(freefem_text, tmp_path):
    """They came in and were lost a step later."""
    queue = "queueAdd(0., 0.005, 2500, 0); queueAdd(5., 0.005, 2500, 0.01);"
    done = freefem_text(PAIR.format(flow=UNIFORM, particles=queue), "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01, "-tend", 0.05, "-out", tmp_path / "run", check=False)
    assert done.returncode == 5 and "the waiting particle 1 (the first is 0) stands outside the mesh" in done.stderr and "1 particle stands outside" in done.stderr


def test_a_particle_is_let_go_at_a_place(freefem_text, tmp_path):
    """With the velocity of the fluid there, when it is due; one behind the outlet is refused."""
    for x, status in ((0.5, 0), (1.5, 5)):
        text = PAIR.format(flow=UNIFORM, particles=f"queueAt({x}, 0.01, 0.005, 2500, 0.02);")
        done = freefem_text(text, "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01, "-tend", 0.04, "-every", 0, "-out", tmp_path / f"run{x}", check=False)
        assert done.returncode == status, done.stderr
    first = rows(tmp_path / "run0.5" / "particles.csv")[0]
    assert 0.02 <= float(first["t"]) < 0.0301 and abs(float(first["x"]) - 0.5) <= float(first["u"]) * 0.0101 and abs(float(first["y"]) - 0.01) < 1e-3


def test_an_ellipse_that_waits_is_refused(freefem_text, tmp_path):
    text = PAIR.format(flow=UNIFORM, particles="queueEllipseAt(0.5, 0.01, 0.005, 0.003, 0, 2500, 0.02);")
    done = freefem_text(text, "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "carried particles are round" in done.stderr and not (tmp_path / "run").exists()


def carried(folder, diameters, status="finished", **parameters):
    """A run of transport, made up: the particles pass the pipe in half a second, and leave it."""
    folder.mkdir()
    rows = [f"0,{t},{k},{2 * t},0,0,2,0,0,{d / 2}" for t in (0, 0.25, 0.5) for k, d in enumerate(diameters)]
    (folder / "particles.csv").write_text("\n".join(["step,t,id,x,y,theta,u,v,omega,radius", *rows]) + "\n")
    exits = [f"0.5,{k},1,0,2,0,{d / 2},2500,1" for k, d in enumerate(diameters)]
    (folder / "exits.csv").write_text("\n".join(["t,id,x,y,u,v,radius,density,outlet", *exits]) + "\n")
    (folder / "run.json").write_text(json.dumps({"case": "pipe_transport", "status": status, "parameters": {f"-{name}": value for name, value in parameters.items()}}))
    return RunFolder(folder)


def test_the_table_counts_every_particle_once(tmp_path):
    """Also those beyond the classes of the paper; the last row is all."""
    rows = table_of([carried(tmp_path / "a", [0.005, 0.012, 0.028, 0.07]), carried(tmp_path / "b", [0.012, 0.09])])
    assert sum(row[2] for row in rows[:-1]) == rows[-1][2] == 3
    assert rows[-1][3:5] == [100, 0]


def test_fates_are_what_the_table_says(tmp_path):
    """Tracks drawn by hand: of each particle its times, x (at the first and the last of them), y, a time with u < 0 and at which x, and its outlet (-1: still there)."""
    tracks = {0: ((0, 1), (0.1, 0.9), 0, 0, 0, 1),  # carried through
              1: ((0, 2), (0.1, 0.2), 0, 0, 0, -1),  # before the diaphragm for two seconds
              2: ((1.2, 2), (0, 0.2), 0, 0, 0, -1),  # on its way
              3: ((0, 2), (0, 0.6), 0, 0.04, 0.5, -1),  # behind it, carried back for too short a time
              4: ((0, 2), (0, 0.6), 0, 0.06, 0.5, -1),  # long enough
              5: ((0, 1.5), (0, 0.2), 0, 0.2, 0.1, 0),  # carried back before it; left, but not by the outlet
              6: ((0, 2), (0, 0.9), -0.085, 0, 0, 1),  # along the bottom: 5 mm above it
              7: ((0, 2), (0, 0.9), -0.075, 0, 0, 1)}  # 15 mm above it
    lines, left, step = ["step,t,id,x,y,theta,u,v,omega,radius"], ["t,id,x,y,u,v,radius,density,outlet"], 0.02
    for t in np.arange(0, 2 + step / 2, step):
        for one, ((start, end), (first, last), y, back, where, outlet) in tracks.items():
            if start - 1e-9 <= t <= end + 1e-9 - step * (outlet >= 0):
                x = first + (last - first) * (t - start) / (end - start)
                u = -1 if back and where <= x and t < start + (end - start) * (where - first) / (last - first) + back - 1e-9 else 1
                lines.append(f"0,{t},{one},{x},{y},0,{u},0,0,0.01")
    left += [f"{end},{one},{last},{y},1,0,0.01,2500,{outlet}" for one, ((_, end), (_, last), y, _, _, outlet) in tracks.items() if outlet >= 0]
    for name, text in (("particles.csv", lines), ("exits.csv", left)):
        (tmp_path / name).write_text("\n".join(text) + "\n")
    (tmp_path / "run.json").write_text(json.dumps({"case": "pipe_transport", "status": "finished", "parameters": {}}))
    sizes, found = fates(RunFolder(tmp_path))
    assert sizes == pytest.approx(0.02)
    assert {name: list(np.flatnonzero(values)) for name, values in found.items()} == {
        "carried through": [0, 6, 7], "trapped": [1], "behind": [3, 4], "recirculation": [4], "bottom": [6]}


@pytest.mark.parametrize("diameters, words, says", [
    ([], {}, "holds no particles"),
    ([0.02], {"status": "failed (4)"}, "not come to its end"),
    ([0.02], {"length": 2}, "-length 2"),
])
def test_the_table_refuses_runs_that_it_cannot_judge(tmp_path, diameters, words, says):
    with pytest.raises(BadInput, match=says):
        table_of([carried(tmp_path / "run", diameters, **words)])


@pytest.mark.parametrize("floor", [0, 1e-3, 1e-6])
def test_the_time_of_turbulence_stays_positive_where_k_falls_to_a_wall(freefem_text, tmp_path, floor):
    """epsilon/k as a plain quadratic turned negative between the nodes of an element."""
    done = freefem_text(f"""
        mesh Th = square(4, 8);
        include "lib/transport/carrier_mesh.idp"
        carrierWh fu = 0, fk = 0.02*square(y*(1 - y)) + {floor}, fe = 0.05;
        carrierFlow(fu[], fu[]);
        carrierTurbulence(fk[], fe[]);
        carrierTurbulent = 1;
        int n = 20000;
        real[int] px(n), py(n);
        randinit(1);
        for (int k = 0; k < n; ++k) px[k] = randreal1();
        for (int k = 0; k < n; ++k) py[k] = randreal1();
        carrierSample(px, py, 0);
        real low = fe[].max/fk[].max, least = carrierRate.min;
        cout << "least " << least/low << " finite " << arrayFinite(carrierRate) << endl;
    """)
    found = re.search(r"least (\S+) finite (\d)", done.stdout)
    assert float(found[1]) > 0.999 and found[2] == "1"


PISTON = """include "lib/case.idp"
optCase("piston", "a wall goes through a fluid at rest");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) carrierU = 0.; // EOM
macro caseParticles() {
    contactWallSegment(-0.03, -1, -0.03, 1); contactWallVelocity(0, 1, 0);
    real[int] x0 = [0., 0.1], y0 = [0., 0.], r = [0.01, 0.01], d = [2500., 2500.], z = [0., 0.];
    transportAppend(x0, y0, r, d, z, z, z);
} // EOM
include "scripts/transport.edp"
"""


def test_walls_that_are_given_a_velocity_go_with_it_over_a_restart_too(freefem_text, tmp_path):
    """The projection heard of the velocity, the wall stood still: the sphere went off at 1 m/s as soon as it was near."""
    words = ["-dt", 0.001, "-every", 0.01, "-checkpoint", 50, "-tend"]
    freefem_text(PISTON, *words, 0.1, "-out", tmp_path / "whole")
    freefem_text(PISTON, *words, 0.05, "-out", tmp_path / "half")
    freefem_text(PISTON, *words, 0.1, "-restart", tmp_path / "half")
    table = [row for row in rows(tmp_path / "whole/particles.csv") if row["id"] == "0"]
    for row in table:
        gap = float(row["x"]) - (float(row["t"]) - 0.03) - 0.01
        assert gap > -1e-10 and (gap < 1e-3 or float(row["t"]) < 0.0205)
    assert len(rows(tmp_path / "whole/contacts.csv")) > 5
    assert rows(tmp_path / "whole/walls.csv") == [{"x1": "-0.03", "y1": "-1", "x2": "-0.03", "y2": "1"}]
    for name in ("particles.csv", "contacts.csv"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "half" / name).read_bytes(), name


def test_the_drag_of_a_hundred_thousand_spheres_is_found(freefem, run_folder):
    """One of them, whose slip falls to a tenth within a step: the secant went below 0, and its velocity was nan from there on."""
    freefem("tests/transport/scripts/bench.edp", "-number", 100000, "-tend", 0.008, "-every", 0.008, "-out", run_folder)
    table = read_table(run_folder / "particles.csv")
    assert len(table["u"]) == 200000 and np.isfinite(table["u"]).all()


def test_a_run_counts_once_in_the_table(tmp_path):
    with pytest.raises(BadInput, match="given twice"):
        transport_table(["--runs", "results/a", str(tmp_path), "results/../results/a"])


@pytest.mark.parametrize("name, text, says", [
    ("exits.csv", "a,b\n1,2\n", "exits.csv has no column id"),
    ("exits.csv", "t,id,outlet\n0.5,0,nan\n", "exits.csv, line 2: outlet is nan"),
    ("particles.csv", "step,t,id,x,y,theta,u,v,omega,radius\n0,0,0,nan,0,0,2,0,0,0.01\n", "particles.csv, line 2: x is nan"),
    ("run.json", '{"status": "finished", "parameters": {"-radius": "wide"}}', '-radius must be a number, not "wide"'),
])
def test_the_table_names_what_is_damaged(tmp_path, name, text, says):
    run = carried(tmp_path / "run", [0.012])
    (tmp_path / "run" / name).write_text(text)
    with pytest.raises(BadInput, match=says):
        table_of([RunFolder(run.folder)])


def test_the_table_is_of_one_scene(tmp_path, capsys):
    first, same, other = (carried(tmp_path / name, [0.012, 0.028], **given) for name, given in (("a", {"seed": 1, "vmax": 2}), ("b", {"seed": 2, "vmax": 2}), ("c", {"seed": 3, "vmax": 1})))
    assert len(table_of([first, same])) == 5
    with pytest.raises(BadInput, match=r"differ in -vmax \(2 and 1\)"):
        table_of([first, same, other])
    assert transport_table(["--runs", str(first.folder), "--out", str(tmp_path / "table")]) == 0
    said = capsys.readouterr().out
    assert "nan" not in said and "100.0       -" in said


@pytest.fixture
def no_flow(tmp_path, monkeypatch):
    """The run within the run, which computes the steady flow, fails."""
    fake = tmp_path / "fake"
    fake.write_text("#!/bin/sh\necho step 1\necho 'error: the residual is 3 after 80 factorisations'\nexit 4\n")
    fake.chmod(0o755)
    monkeypatch.setenv("FREEFEM", str(fake))


def test_a_flow_of_older_sources_is_not_taken(freefem, no_flow, tmp_path):
    """The folder of a steady flow goes by its case and all that this includes."""
    part, flow, script, folders = tmp_path / "part.idp", tmp_path / "flow.edp", tmp_path / "mine.edp", []
    flow.write_text(f'    include "{part}"\n')
    script.write_text((ROOT / "cases/pipe_transport.edp").read_text().replace("cases/pipe_flow.edp", str(flow)))
    for text in ("// one", "// one", 'include "lib/core/errors.idp"'):
        part.write_text(text)
        said = freefem(script, "-out", tmp_path / "run", check=False).stdout
        folders.append(re.search(r"computing the steady flow into (results/pipe_flow/steady_\w{16}) ", said)[1])
        (ROOT / folders[-1]).rmdir()
    assert folders[0] == folders[1] != folders[2]


def test_a_steady_flow_that_does_not_come_about_says_why(freefem_refused, no_flow, tmp_path):
    line = freefem_refused(4, "cases/pipe_transport.edp", "-flow", tmp_path / "flow", "-out", tmp_path / "run")
    assert "was not computed (status 4): the residual is 3 after 80 factorisations; see " in line and "/flow.log" in line


@pytest.mark.parametrize("mode", ["fluctuation", "paper"])
def test_numbers_that_a_case_draws_do_not_hang_on_the_turbulence(mode, freefem_text, tmp_path):
    text = """
include "lib/case.idp"
optCase("drawn", "spheres at places drawn one by one");
optDefault("-contacts", "0");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) carrierU = 0.; carrierSigma = 0.1; carrierRate = 1.; // EOM
macro caseParticles() { randinit(5); for (int k = 0; k < 4; ++k) { real[int] x0(1), y0(1), r(1), d(1), z(1); x0 = randreal1(); y0 = randreal1(); r = 0.001; d = 2500; z = 0.; transportAppend(x0, y0, r, d, z, z, z); } } // EOM
include "scripts/transport.edp"
"""
    places = []
    for how in ("off", mode):
        freefem_text(text, "-turbulence", how, "-tend", 0.001, "-out", tmp_path / how)
        places.append(read_table(tmp_path / how / "entries.csv")["x"])
    assert len(set(places[0])) == 4 and (places[0] == places[1]).all()


def test_arrays_of_particles_are_of_one_length(freefem_text, tmp_path):
    text = """
include "lib/case.idp"
optCase("uneven", "arrays of different lengths");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) carrierU = 0.; // EOM
macro caseParticles() { real[int] two(2), one(1); two = 0.001; one = 2500; transportAppend(two, two, two, one, two, two, two); } // EOM
include "scripts/transport.edp"
"""
    done = freefem_text(text, "-tend", 0.001, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "given are 2 x, 2 y, 2 radii, 1 densities" in done.stderr and not (tmp_path / "run").exists()


FLOW = """
include "lib/case.idp"
optCase("formula", "spheres in a flow by a formula");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) {carrier} // EOM
macro caseParticles() {bodies} // EOM
include "scripts/transport.edp"
"""
FLAT = "carrierUX = 0.; carrierUY = 0.; carrierVX = 0.; carrierVY = 0.;"


def in_formula(freefem_text, folder, carrier, bodies, *words):
    freefem_text(FLOW.format(carrier=carrier, bodies=bodies), "-out", folder, *words)
    return read_table(folder / "particles.csv")


def test_who_enters_spins_as_the_flow_does(freefem_text, tmp_path):
    """Shear of 2: half of the vorticity is -1."""
    shear = "carrierU = 2.*py; carrierV = 0.; carrierUX = 0.; carrierUY = 2.; carrierVX = 0.; carrierVY = 0.; carrierUT = 0.; carrierVT = 0.;"
    rows = in_formula(freefem_text, tmp_path / "run", shear, "queueAt(0, 1, 0.01, 2500, 0);", "-magnus", 1, "-dt", 0.001, "-tend", 0.01, "-every", 0.001)
    np.testing.assert_allclose(rows["omega"], -1, atol=1e-9)


def test_an_unsteady_flow_along_y_moves_a_sphere_as_one_along_x(freefem_text, tmp_path):
    sphere = "real[int] x0 = [0.], y0 = [0.], r = [0.01], d = [2500.], z = [0.]; transportAppend(x0, y0, r, d, z, z, z);"
    words = ["-fluid-acceleration", 1, "-history", 1, "-drag", "schiller-naumann", "-dt", 0.001, "-tend", 0.1, "-every", 0.01]
    along = in_formula(freefem_text, tmp_path / "x", f"carrierU = cos(30*t); carrierV = 0.; {FLAT} carrierUT = -30*sin(30*t); carrierVT = 0.;", sphere, *words)
    up = in_formula(freefem_text, tmp_path / "y", f"carrierV = cos(30*t); carrierU = 0.; {FLAT} carrierVT = -30*sin(30*t); carrierUT = 0.;", sphere, *words)
    assert abs(along["u"]).max() > 0.1
    np.testing.assert_allclose(up["v"], along["u"], rtol=1e-12, atol=1e-14)


def test_the_history_of_a_particle_does_not_hang_on_who_comes_and_goes(freefem_text, tmp_path):
    """In an unsteady shear flow, with all that a particle has (by one pass the drag is that of the slip before): one of three leaves when the tails of the history have begun, another enters later. Those who stay,
    and who enters, move as they do alone, bit for bit."""
    flow = "carrierU = 2.*py; carrierU += cos(30*t); carrierV = 0.; carrierUX = 0.; carrierUY = 2.; carrierVX = 0.; carrierVY = 0.; carrierUT = -30*sin(30*t); carrierVT = 0.;"
    sphere = "{{ real[int] x0 = [{}], y0 = [{}], r = [{}], d = [{}], u0 = [{}], z = [0.]; transportAppend(x0, y0, r, d, u0, z, z); }} "
    first, goes, last = (sphere.format(*values) for values in ((0., 0.1, 0.01, 2500., 0.5), (0.5, 0.2, 0.012, 4000., 2.), (0.1, -0.1, 0.008, 1500., -1.)))
    enters = "queueAt(0.2, 0.05, 0.009, 3000, 0.082);"
    words = ["-history", 1, "-history-window", 6, "-magnus", 1, "-drag", "schiller-naumann", "-drag-passes", 1, "-contacts", 0, "-dt", 0.002, "-tend", 0.12, "-every", 0.002]

    def moves(name, bodies):
        rows = in_formula(freefem_text, tmp_path / name, flow + " // EOM\nmacro caseBound() 0.62", bodies, *words)
        return {number: np.column_stack([rows[word][rows["id"] == number] for word in ("t", "x", "y", "theta", "u", "v", "omega")]) for number in set(rows["id"])}

    together, pair, alone = moves("together", first + goes + last + enters), moves("pair", first + last), moves("alone", enters)
    assert 20 < len(together[1]) < 40 and 15 < len(together[3]) < 25
    for one, other in ((together[0], pair[0]), (together[2], pair[1]), (together[3], alone[0])):
        np.testing.assert_array_equal(one, other)


def test_the_fluctuations_of_a_particle_do_not_depend_on_who_has_left(freefem_text, tmp_path):
    """One that is there then, and one that enters after."""
    flow = "carrierU = 1.; carrierV = 0.; carrierSigma = 0.1; carrierRate = 1."
    bodies = "real[int] x0 = [0.03], y0 = [0.], r = [1e-4], d = [2500.], u0 = [1.], z = [0.]; transportAppend(x0, y0, r, d, u0, z, z); queueAt(0, 0.5, 1e-4, 2500, 0.01); queueAt(0, 0.2, 1e-4, 2500, 0.1);"
    words = ["-turbulence", "fluctuation", "-drag", "stokes", "-dt", 0.01, "-tend", 0.14, "-every", 0.01]
    one, other = (in_formula(freefem_text, tmp_path / name, flow + "; // EOM\nmacro caseBound() " + bound, bodies, *words) for name, bound in (("left", "0.05"), ("there", "10.")))
    assert one["t"][one["id"] == 0].max() < 0.04 < 0.1 < other["t"][other["id"] == 0].max()
    for number in (1, 2):
        first = np.column_stack([one[name][one["id"] == number] for name in ("t", "x", "y", "u", "v")])
        second = np.column_stack([other[name][other["id"] == number] for name in ("t", "x", "y", "u", "v")])
        assert len(first) > 2
        np.testing.assert_array_equal(first, second[:len(first)])  # until it leaves too


def test_walls_move_before_the_first_particle_is_there(freefem_text, tmp_path):
    """A piston of 1 m/s from x = -0.03 on; a sphere let go at 0.1 is pushed: at 0.15 s its centre is at 0.12 + its radius."""
    bodies = "contactWallSegment(-0.03, -1, -0.03, 1); contactWallVelocity(0, 1, 0); queueAt(0.1, 0, 0.01, 2500, 0.05);"
    rows = in_formula(freefem_text, tmp_path / "run", "carrierU = 0.;", bodies, "-dt", 0.001, "-tend", 0.15, "-every", 0.01)
    assert rows["x"][-1] >= 0.13 - 1e-9


def test_drag_that_has_not_settled_is_told_of_once(freefem, tmp_path):
    words = ("-flow", "shear", "-rate", 20, "-tend", 2)
    large = freefem(SCRIPT, "-out", tmp_path / "large", *words, "-dt", 1).stdout
    assert large.count("has not settled after 12 passes") == 1 and "had not settled in 2 of 2 steps" in large
    assert "settled after 12 passes" not in freefem(SCRIPT, "-out", tmp_path / "small", *words, "-dt", 0.01).stdout


def test_a_drag_law_beyond_its_range_is_told_of_once(freefem, tmp_path):
    """Flemmer and Banks's has no drag at all above a Reynolds number of a million."""
    words = ("-drag", "flemmer-banks", "-tend", 0.01, "-start-u")
    fast = freefem(SCRIPT, "-out", tmp_path / "fast", *words, 1000, "-number", 2, "-spread", 0.1, "-radius-last", 1e-7).stdout
    assert fast.count("the drag law flemmer-banks is valid up to 300000") == 1
    assert "is valid up to 300000" not in freefem(SCRIPT, "-out", tmp_path / "slow", *words, 10).stdout


def test_a_constant_drag_far_below_its_range_is_told(freefem, tmp_path):
    """Grains of 20 micrometres fell ninety times faster than Stokes's law says, without a word."""
    words = ("-radius", 1e-5, "-dt", 0.01, "-tend", 0.05)
    assert freefem(SCRIPT, "-out", tmp_path / "constant", *words).stdout.count("use -drag schiller-naumann") == 1
    assert "use -drag" not in freefem(SCRIPT, "-out", tmp_path / "fitted", *words, "-drag", "schiller-naumann").stdout
    assert "use -drag" not in freefem(SCRIPT, "-out", tmp_path / "large", "-radius", 0.01, *words[2:]).stdout
    assert "use -drag" not in freefem(SCRIPT, "-out", tmp_path / "slowed", "-start-u", 1, "-gravity", 0, "-tend", 0.6, "-dt", 0.01).stdout  # from a Reynolds number of 2000 to 59
    assert "use -drag" not in freefem(SCRIPT, "-out", tmp_path / "near", "-start-u", 0.2, "-gravity", 0, "-tend", 0.02, "-dt", 0.01).stdout  # 400


def test_a_flow_without_k_and_epsilon_has_no_fluctuations(freefem_text, freefem_refused, tmp_path):
    """They were 0, without a word."""
    words = ["-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01, "-tend", 0.02, "-out", tmp_path / "run"]
    freefem_text(PAIR.format(flow=UNIFORM, particles="queueAt(0.5, 0.01, 0.005, 2500, 0);"), *words)
    assert "no k and epsilon" in freefem_refused(3, tmp_path / "script.edp", *words[:-1], tmp_path / "other", "-turbulence", "fluctuation")


@pytest.mark.parametrize("old, new, says", [("mu = 1e-3", "mu = 0", "has density 1000 and viscosity 0"), ("rhoFluid = 1000", "rhoFluid = -1", "has density -1 and"),
                                            ("gravityY = 0", "gravityY = 1e300*1e300", "gravityY inf; both must be numbers")])
def test_a_fluid_without_density_or_viscosity_and_gravity_that_is_no_number_are_refused(old, new, says, freefem_text, tmp_path):
    """Without viscosity the run ended with status 8, with a density below 0 it went on."""
    done = freefem_text(PAIR.format(flow=STILL, particles=TWO).replace(old, new), "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.splitlines()) == 1


def test_who_waits_looks_over_the_seam_of_a_period(freefem_text, tmp_path):
    """It was let in where the image of another stood, and both were shot apart; the pictures did not know of the period."""
    there = "contactPeriodic(0, 0, 1, 1); real[int] x0 = [0.98], y0 = [0.5], r = [0.05], d = [2500.], u0 = [1.], z = [0.]; transportAppend(x0, y0, r, d, u0, z, z);"
    text = PAIR.format(flow=STILL.replace("0.", "1."), particles=there + " queueAt(0.02, 0.5, 0.05, 2500, 0);")
    freefem_text(text, "-drag", "off", "-dt", 0.01, "-tend", 0.2, "-out", tmp_path / "run")
    entered = {row["id"]: float(row["t"]) for row in rows(tmp_path / "run/entries.csv")}
    last = rows(tmp_path / "run/particles.csv")
    assert 0.14 < entered["1"] < 0.16 and all(float(row["u"]) == pytest.approx(1, abs=1e-9) for row in last)
    assert json.loads((tmp_path / "run/run.json").read_text())["period"] == [1, 1]


CROWD = """include "lib/case.idp"
optCase("crowd", "spheres that go forty radii in a step");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) carrierU = 2.; // EOM
macro caseParticles() {
    int n = 900;
    real[int] x0(n), y0(n), r(n), d(n), u0(n), z(n);
    for (int k = 0; k < n; ++k) x0[k] = 5e-4*(k % 30);
    for (int k = 0; k < n; ++k) y0[k] = 5e-4*(k/30);
    r = 5e-5; d = 2500; u0 = 2; z = 0;
    transportAppend(x0, y0, r, d, u0, z, z);
} // EOM
macro caseStep() cout << "near " << contactNearN << endl; // EOM
include "scripts/transport.edp"
"""


def test_who_goes_along_is_neither_a_row_of_the_projection_nor_in_the_list(freefem_text, tmp_path):
    """Every pair within the moves of both was: a gigabyte for 10,000 spheres. Ten radii a step: hardly a row; forty: nobody in the list."""
    said = freefem_text(CROWD, "-dt", 0.00025, "-tend", 0.0005, "-drag", "stokes", "-contact-trace", 1, "-out", tmp_path / "run").stdout
    found = [(int(a), int(b)) for a, b in re.findall(r"(\d+) contacts, (\d+) rows", said)]
    assert found and all(contacts > 5000 and rows < 10 for contacts, rows in found)
    said = freefem_text(CROWD, "-dt", 0.001, "-tend", 0.002, "-drag", "stokes", "-out", tmp_path / "fast").stdout
    assert re.findall(r"near (\d+)", said) == ["0", "0"]


def test_a_fast_sphere_pushes_a_row_of_others_within_a_step(freefem_text, tmp_path):
    """Ten in a line, one of 60 radii a step: places after it are the isotonic regression of those without contact (masses as weights), however far one is pushed."""
    radius, start, speed, density = 1e-4, 1e-3 * np.arange(10), [6, 0, 0, 1, 0, 0, 0, -5, 0, 0], 2500 * np.array([9, 1, 1, 4, 1, 1, 1, 9, 1, 1])
    def text(values):
        return ", ".join(f"{value:g}" for value in values)
    bodies = f"""{{ real[int] x0 = [{text(start)}], d = [{text(density)}], u0 = [{text(speed)}], r(10), z(10); r = {radius}; z = 0.; transportAppend(x0, z, r, d, u0, z, z); }}"""
    got = in_formula(freefem_text, tmp_path / "run", "carrierU = 0.;", bodies, "-drag", "off", "-lift", 0, "-added-mass", 0, "-buoyancy", 0, "-dt", 0.001, "-tend", 0.001)
    blocks = [[x + 1e-3 * u - 2 * radius * k, m, 1] for k, (x, u, m) in enumerate(zip(start, speed, density))]
    merged = []
    for block in blocks:  # pool adjacent violators
        merged.append(block)
        while len(merged) > 1 and merged[-2][0] > merged[-1][0]:
            (a, m, i), (b, n, j) = merged[-2:]
            merged[-2:] = [[(m * a + n * b) / (m + n), m + n, i + j]]
    want = np.concatenate([[place] * number for place, _, number in merged]) + 2 * radius * np.arange(10)
    assert 1 < len(merged) < 8
    assert got["x"][-10:] == pytest.approx(want, abs=1e-12)


PERIODIC = """include "lib/case.idp"
optCase("periodic", "spheres go round in a periodic flow");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
optDefault("-mesh", "meshes/periodic_box.mesh");
{flow}
macro caseParticles() {{
    contactPeriodic(0, 0, 1, 1);
    real[int] x0 = [0.9, 0.2], y0 = [0.5, 0.1], r = [1e-3, 1e-3], d = [2500., 2500.], u0 = [0., 1.], v0 = [0., -0.8], z = [0., 0.];
    transportAppend(x0, y0, r, d, u0, v0, z);
}} // EOM
include "scripts/transport.edp"
"""


def test_a_flow_on_a_mesh_goes_on_over_the_seam_of_a_period(freefem_text, tmp_path):
    """Who went over the seam stood outside the mesh and was taken out; now as in the same flow by a formula, for three periods along both."""
    flows = {"mesh": "macro caseCarrier() carrierWh u = 1 + 0.5*sin(2*pi*x), v = -0.8; carrierFlow(u[], v[]); // EOM",
             "formula": 'macro carrierExact(px, py, t) carrierU = (2*pi)*px; carrierUX = cos(carrierU); carrierUX *= pi; carrierU = sin(carrierU); carrierU *= 0.5; carrierU += 1.; carrierV = -0.8; // EOM'}
    found = {}
    for name, flow in flows.items():
        text = PERIODIC.format(flow=flow)
        if name == "formula":
            text = text.replace('optDefault("-mesh", "meshes/periodic_box.mesh");\n', "")
        freefem_text(text, "-drag", "schiller-naumann", "-dt", 0.005, "-tend", 4, "-every", 0.5, "-out", tmp_path / name)
        found[name] = read_table(tmp_path / name / "particles.csv")
        assert rows(tmp_path / name / "exits.csv") == []
    assert found["mesh"]["x"].max() > 3 and found["mesh"]["y"].min() < -2.5
    for name in "xyuv":
        np.testing.assert_allclose(found["mesh"][name], found["formula"][name], atol=3e-3)


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_sphere_slides_on_a_wall_that_is_a_whole_period_long(along, freefem_text, tmp_path):
    """One piece, which has no end: it passes the seam seven times, and the wall bears its weight once in each row."""
    wall, start = ("0, 0, 1, 0", "x0 = [0.3], y0 = [0.1], u0 = [7.], v0 = [0.]") if along == "x" else ("0, 0, 0, 1", "y0 = [0.3], x0 = [0.1], v0 = [7.], u0 = [0.]")
    bodies = f"contactWallSegment({wall}); contactPeriodic(0, 0, 1, 1); real[int] {start}, r = [0.1], d = [2500.], z = [0.]; transportAppend(x0, y0, r, d, u0, v0, z);"
    text = FLOW.format(carrier="carrierU = 0.;", bodies=bodies).replace("gravityX = 0, gravityY = 0", "gravityX = 0, gravityY = -3" if along == "x" else "gravityX = -3, gravityY = 0")
    freefem_text(text, "-drag", "off", "-lift", 0, "-added-mass", 0, "-dt", 0.02, "-tend", 1, "-every", 0, "-out", tmp_path / "run")
    table, touch = read_table(tmp_path / "run/particles.csv"), read_table(tmp_path / "run/contacts.csv")
    across = "y" if along == "x" else "x"
    np.testing.assert_allclose(table[along], 0.3 + 7 * table["t"], atol=1e-9)
    np.testing.assert_allclose(table[across], 0.1, atol=1e-12)
    assert len(touch["t"]) == 50 and len(rows(tmp_path / "run/walls.csv")) == 1
    np.testing.assert_allclose(touch["impulse"], 1500 * 4 / 3 * np.pi * 1e-3 * 3 * 0.02, rtol=1e-9)


def test_a_seed_counts_once_in_the_table(tmp_path):
    """Whatever the folders; another seed of the turbulence is another run."""
    one, again, other = (carried(tmp_path / name, [0.012], **{"seed": 4, "turbulence-seed": turbulence}) for name, turbulence in (("a", 1), ("b", 1), ("c", 2)))
    assert len(table_of([one, other])) == 5
    with pytest.raises(BadInput, match="both of -seed 4"):
        table_of([other, one, again])


def test_a_table_that_is_refused_leaves_nothing(tmp_path):
    run = carried(tmp_path / "run", [0.012])
    for words, says in ((["--runs", str(tmp_path / "none")], "no run folder"), (["--runs", str(run.folder), "-reynolds", "50"], "-reynolds is for runs that are made")):
        with pytest.raises(BadInput, match=says):
            transport_table([*words, "--out", str(tmp_path / "table")])
        assert not (tmp_path / "table").exists()
