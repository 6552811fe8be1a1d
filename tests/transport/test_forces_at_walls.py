"""Contacts of carried particles: weight on a floor, sliding, heaps, moving walls, crowds."""
import re

import numpy as np
import pytest

from tests.scenes import ANALYTIC, FORMULA
from tests.tables import in_formula, records
from tools.base.tables import read_table
from tools.peers import spheres_exact as exact


def test_contacts_keep_falling_spheres_apart(freefem, run_folder):
    """Large spheres fall on small ones below them: none overlaps."""
    freefem(ANALYTIC, "-out", run_folder, "-number", 5, "-spread", 0.012, "-radius", 0.001, "-contacts", 1, "-density", 2500,
        "-radius-last", 0.0005,
            "-drag", "brown-lawler", "-tend", 0.2, "-dt", 0.001)
    table = records(run_folder / "particles.csv")
    end = max(float(row["t"]) for row in table)
    last = sorted((row for row in table if float(row["t"]) == end), key=lambda row: int(row["id"]))
    y, r, x = (np.array([float(row[name]) for row in last]) for name in ("y", "radius", "x"))
    assert (np.hypot(np.diff(x), np.diff(y)) - r[1:] - r[:-1]).min() > -1e-10
    gaps = [float(row["worst_gap"]) for row in records(run_folder / "steps.csv") if float(row["worst_gap"]) < 1e29]
    assert min(gaps) > -1e-8 * 0.0005


def test_gaps_and_normals_of_contacts_are_of_their_row_s_time(freefem, run_folder):
    """They were those before the step's move."""
    freefem(ANALYTIC, "-out", run_folder, "-flow", "straining", "-rate", 20, "-number", 5, "-start-x", 0.01, "-start-y", -0.006,
        "-spread", 0.012, "-radius", 0.001,
            "-radius-last", 0.0012, "-contacts", 1, "-gravity", -5, "-drag", "brown-lawler", "-tend", 0.1, "-dt", 0.002, "-every",
                0.002)
    at = {(row["t"], row["id"]): np.array([float(row[name]) for name in ("x", "y", "radius")])
        for row in records(run_folder / "particles.csv")}
    touching = records(run_folder / "contacts.csv")
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
    """The drag had taken its part of what the contact had to undo, and the history's: of the weight of the smallest 29 % were left,
    21 % with history."""
    freefem_text(FLOOR, "-dt", 0.002, "-tend", 0.1, "-drag", "stokes", "-history", history, "-out", tmp_path / "run")
    table = records(tmp_path / "run/contacts.csv")
    for one, radius in enumerate((3e-5, 2e-4, 2e-3)):
        pressed = [float(row["impulse"]) for row in table if row["i"] == str(one)]
        assert len(pressed) >= 49 and pressed == pytest.approx([1500 * 4 / 3 * np.pi * radius**3 * 9.81 * 0.002] * len(pressed),
            rel=1e-6)


SLIDE = FLOOR.replace("gravityX = 0", "gravityX = optReal(\"-gx\", 0, \"m/s2\", \"gravity along the floor\"), rate0 = "
    "optReal(\"-rate\", 0, \"1/s\", \"rate of shear\")")
SLIDE = SLIDE.replace("carrierU = 0.;", "carrierU = rate0*py; carrierUY = rate0;")


@pytest.mark.parametrize("dt", [0.002, 0.02])
def test_spheres_slide_on_a_floor_by_the_forces_along_it_whatever_the_step(dt, freefem_text, tmp_path):
    """They had the drag of their fall in each step, and its lift, and the shear below the floor: in a shear flow they went
    upstream, down a slope of 45 degrees by up to 12 % too slowly."""
    radii = np.array([3e-5, 2e-4, 2e-3])
    for law in ("constant", "schiller-naumann"):
        freefem_text(SLIDE, "-dt", dt, "-tend", 0.6, "-every", 0.6, "-drag", law, "-gx", 9.81, "-out", tmp_path / law)
        slides = read_table(tmp_path / law / "particles.csv")
        fall = [exact.terminal_velocities(law, radius, 2500.0)[0] for radius in radii]
        assert slides["u"][-3:] == pytest.approx(fall, rel=1e-5) and slides["y"][-3:] == pytest.approx(radii, rel=1e-6)
    freefem_text(SLIDE, "-dt", dt, "-tend", 0.6, "-every", 0.6, "-drag", "constant", "-rate", 2, "-out", tmp_path / "shear")
    k = 3 / 8 * 0.44 * 1000 / 3000 / radii  # (m_p + m_f/2) dU/dt = 0.22 rho pi R2 (u - U)^2
    assert read_table(tmp_path / "shear/particles.csv")["u"][-3:] == pytest.approx(2 * radii * (1 - 1 / (1 + k * 2 * radii * 0.6)),
        rel=1e-5)


def test_who_slides_steadily_needs_no_pass_beyond_those_of_the_drag(freefem_text, tmp_path):
    """The contact forces of the last step start the next, of who stays when the first of three leaves too: it took 5 passes, of
    which 3 were not counted. A step that begins a contact has more than one without."""
    text = SLIDE.replace("macro caseParticles", "macro caseBound() 0.3 // EOM\nmacro caseParticles")
    for old, new in (("x0 = [0., 0.1, 0.2]", "x0 = [0.2, 0.1, 0.]"), ("[3e-5, 2e-4, 2e-3]", "[2e-3, 2e-4, 3e-5]"),
        ("d = [2500., 2500., 2500.]", "d = [2500., 4000., 1600.]")):
        assert old in text
        text = text.replace(old, new)
    found = {}
    for contacts in (1, 0):
        freefem_text(text, "-dt", 0.02, "-tend", 2, "-every", 0, "-drag", "schiller-naumann", "-gx", 0.5, "-contacts", contacts,
            "-out", tmp_path / str(contacts))
        found[contacts] = read_table(tmp_path / str(contacts) / "steps.csv")
    (begin,), steady = found[1]["passes"][found[1]["step"] == 1], found[1]["t"] > 1.25
    gone = records(tmp_path / "1/exits.csv")
    assert [row["id"] for row in gone] == ["0"] and 1.3 < float(gone[0]["t"]) < 1.8
    assert begin > found[0]["passes"][found[0]["step"] == 1][0]
    assert (found[1]["passes"][steady] == 2).all()


# Seven spheres in a box with a floor and two sides, in the shear flow u = rate0 y, du/dy = rate0: flow, walls and spheres of FLOOR
# are replaced in turn.
HEAP = FLOOR.replace("gravityX = 0", "gravityX = 0, rate0 = 5").replace("carrierU = 0.;", "carrierU = rate0*py; carrierUY = rate0;")
HEAP = HEAP.replace("contactWallSegment(-1, 0, 1, 0);", "contactWallSegment(0, 0, 8e-3, 0); contactWallSegment(0, 0, 0, 1); "
    "contactWallSegment(8e-3, 0, 8e-3, 1);")
HEAP = HEAP.replace("x0 = [0., 0.1, 0.2], y0 = [3e-5, 2e-4, 2e-3], r = [3e-5, 2e-4, 2e-3], d = [2500., 2500., 2500.], z = [0., "
    "0., 0.]",
                    "x0 = [1e-3, 3.2e-3, 5.5e-3, 2.1e-3, 4.6e-3, 6.5e-3, 3.3e-3], y0 = [1e-3, 1.1e-3, 1.2e-3, 3.5e-3, 3.6e-3, "
                        "3.6e-3, 6e-3], r = [1e-3, 1.1e-3, 1.2e-3, 0.9e-3, 1e-3, 0.8e-3, 1e-3], d(7), z(7); d = 2500; z = 0.")


def test_walls_bear_the_weight_of_a_heap_at_rest_and_its_drag_in_a_shear_flow(freefem_text, tmp_path):
    """Seven spheres between two walls: the floor bears their weight less buoyancy, the sides the drag of the flow at the places
    where they have come to rest."""
    assert "rate0*py" in HEAP and "8e-3, 1" in HEAP and "d(7)" in HEAP
    freefem_text(HEAP, "-dt", 0.002, "-tend", 0.8, "-every", 0.02, "-drag", "schiller-naumann", "-lift", 0, "-out",
        tmp_path / "run")
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
    freefem(ANALYTIC, "-out", run_folder, "-number", 2, "-radius", radii[0], "-radius-last", radii[1], "-spread", radii.sum(),
        "-contacts", 1, "-lift", 0, "-drag", "stokes", "-tend", 0.1, "-dt", dt, "-every", 0.02)
    table = records(run_folder / "particles.csv")[-2:]
    speed = 1500 * 4 / 3 * np.pi * (radii**3).sum() * 9.81 / (6 * np.pi * 1e-3 * radii.sum())
    assert [float(row["v"]) for row in table] == pytest.approx([-speed, -speed], rel=1e-6)
    fallen = [float(row["y"]) for row in records(run_folder / "particles.csv") if abs(float(row["t"]) - 0.08) < 1e-9]
    assert [float(row["y"]) - y for row, y in zip(table, fallen, strict=True)] == pytest.approx([-0.02 * speed] * 2, rel=1e-5)


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
    table = [row for row in records(tmp_path / "whole/particles.csv") if row["id"] == "0"]
    for row in table:
        gap = float(row["x"]) - (float(row["t"]) - 0.03) - 0.01
        assert gap > -1e-10 and (gap < 1e-3 or float(row["t"]) < 0.0205)
    assert len(records(tmp_path / "whole/contacts.csv")) > 5
    assert records(tmp_path / "whole/walls.csv") == [{"x1": "-0.03", "y1": "-1", "x2": "-0.03", "y2": "1"}]
    for name in ("particles.csv", "contacts.csv"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "half" / name).read_bytes(), name


def test_walls_move_before_the_first_particle_is_there(freefem_text, tmp_path):
    """A piston of 1 m/s from x = -0.03 on; a sphere let go at 0.1 is pushed: at 0.15 s its centre is at 0.12 + its radius."""
    bodies = "contactWallSegment(-0.03, -1, -0.03, 1); contactWallVelocity(0, 1, 0); queueAt(0.1, 0, 0.01, 2500, 0.05);"
    records = in_formula(freefem_text, tmp_path / "run", "carrierU = 0.;", bodies, "-dt", 0.001, "-tend", 0.15, "-every", 0.01)
    assert records["x"][-1] >= 0.13 - 1e-9


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
    """Every pair within the moves of both was: a gigabyte for 10,000 spheres. Ten radii a step: hardly a row; forty: nobody in the
    list."""
    said = freefem_text(CROWD, "-dt", 0.00025, "-tend", 0.0005, "-drag", "stokes", "-contact-trace", 1, "-out",
        tmp_path / "run").stdout
    found = [(int(a), int(b)) for a, b in re.findall(r"(\d+) contacts, (\d+) rows", said)]
    assert found and all(contacts > 5000 and records < 10 for contacts, records in found)
    said = freefem_text(CROWD, "-dt", 0.001, "-tend", 0.002, "-drag", "stokes", "-out", tmp_path / "fast").stdout
    assert re.findall(r"near (\d+)", said) == ["0", "0"]


def test_a_fast_sphere_pushes_a_row_of_others_within_a_step(freefem_text, tmp_path):
    """Ten in a line, one of 60 radii a step: places after it are the isotonic regression of those without contact (masses as
    weights), however far one is pushed."""
    radius, start, speed, density = 1e-4, 1e-3 * np.arange(10), [6, 0, 0, 1, 0, 0, 0, -5, 0, 0], 2500 * np.array([9, 1, 1, 4, 1, 1,
        1, 9, 1, 1])
    def text(values):
        return ", ".join(f"{value:g}" for value in values)
    bodies = f"""{{ real[int] x0 = [{text(start)}], d = [{text(density)}], u0 = [{text(speed)}], r(10), z(10); r = {radius}; z = 0.; transportAppend(x0, z, r, d, u0, z, z); }}"""
    got = in_formula(freefem_text, tmp_path / "run", "carrierU = 0.;", bodies, "-drag", "off", "-lift", 0, "-added-mass", 0,
        "-buoyancy", 0, "-dt", 0.001, "-tend", 0.001)
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


@pytest.mark.parametrize("along", ["x", "y"])
def test_a_sphere_slides_on_a_wall_that_is_a_whole_period_long(along, freefem_text, tmp_path):
    """One piece, which has no end: it passes the seam seven times, and the wall bears its weight once in each row."""
    wall, start = ("0, 0, 1, 0", "x0 = [0.3], y0 = [0.1], u0 = [7.], v0 = [0.]") if along == "x" else ("0, 0, 0, 1",
        "y0 = [0.3], x0 = [0.1], v0 = [7.], u0 = [0.]")
    bodies = f"contactWallSegment({wall}); contactPeriodic(0, 0, 1, 1); real[int] {start}, r = [0.1], d = [2500.], z = [0.]; transportAppend(x0, y0, r, d, u0, v0, z);"
    text = FORMULA.format(carrier="carrierU = 0.;", bodies=bodies).replace("gravityX = 0, gravityY = 0",
        "gravityX = 0, gravityY = -3" if along == "x" else "gravityX = -3, gravityY = 0")
    freefem_text(text, "-drag", "off", "-lift", 0, "-added-mass", 0, "-dt", 0.02, "-tend", 1, "-every", 0, "-out", tmp_path / "run")
    table, touch = read_table(tmp_path / "run/particles.csv"), read_table(tmp_path / "run/contacts.csv")
    across = "y" if along == "x" else "x"
    np.testing.assert_allclose(table[along], 0.3 + 7 * table["t"], atol=1e-9)
    np.testing.assert_allclose(table[across], 0.1, atol=1e-12)
    assert len(touch["t"]) == 50 and len(records(tmp_path / "run/walls.csv")) == 1
    np.testing.assert_allclose(touch["impulse"], 1500 * 4 / 3 * np.pi * 1e-3 * 3 * 0.02, rtol=1e-9)


PIECES = """
include "lib/case.idp"
optCase("slide", "a sphere slides on a floor in pieces, in a fluid at rest and nearly a vacuum");
optDefault("-lift", "0"); optDefault("-added-mass", "0"); optDefault("-drag", "stokes");
real rhoFluid = 1e-9, mu = 1e-9, gravityX = 0, gravityY = -9.81;
func int still(real[int] & px, real[int] & u0, real[int] & v0, real[int] & ux, real[int] & uy, real[int] & vx, real[int] & vy) { u0 = 0.; v0 = 0.; ux = 0.; uy = 0.; vx = 0.; vy = 0.; return px.n; }
macro carrierExact(px, py, t) still(px, carrierU, carrierV, carrierUX, carrierUY, carrierVX, carrierVY); // EOM
macro caseParticles() { real[int] x0 = [0.5], y0 = [0.1], r = [0.1], d = [1000.], u0 = [1.], v0 = [0.], w0 = [0.]; transportAppend(x0, y0, r, d, u0, v0, w0); for (int k = 0; k < 40; ++k) contactWallSegment(8.*k/40, 0, 8.*(k + 1)/40, 0); } // EOM
include "scripts/transport.edp"
"""


def test_a_sphere_slides_over_a_floor_in_pieces(freefem_text, tmp_path):
    """0.72 of its speed was left."""
    freefem_text(PIECES, "-dt", 0.01, "-tend", 4, "-every", 4, "-out", tmp_path / "run")
    last = read_table(tmp_path / "run" / "particles.csv")
    assert [last["u"][-1], last["x"][-1]] == pytest.approx([1, 4.5], abs=1e-6)
