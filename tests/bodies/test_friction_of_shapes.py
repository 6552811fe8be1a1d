"""Bodies of any shape that rub in a flow: on an incline, against a wall, against each other."""
import numpy as np
import pytest

from tests.contact.shapes import moments
from tests.friction import struck
from tests.scenes import case, write_moved
from tools.base.mesh_files import read_mesh
from tools.base.run_folder import RunFolder

WORDS = 'include "lib/bodies/shapes.idp"\n'
G, MU = 9.81, 0.3


def run_of(freefem_text, box, folder, body, *words, arrays="", tilt=0.0, gravity=G, mu=0.001, dt=0.005, budget=1):
    """A scene of heavy bodies of any shape in a thin fluid."""
    text = case("{ " + body + " }", more=WORDS + arrays, mu=mu).replace("gravityX = 0, gravityY = -1",
        f"gravityX = {float(gravity * np.sin(tilt))!r}, gravityY = {float(-gravity * np.cos(tilt))!r}")
    freefem_text(text, "-mesh", box, "-dt", dt, "-every", 0, "-stabilise", 0, "-budget", budget, "-out", folder, *words)
    return RunFolder(folder)


def told(name, values):
    return f"real[int] {name} = [{', '.join(repr(float(value)) for value in values)}];\n"


SQUARE = told("px", [0.42, 0.58, 0.58, 0.42]) + told("py", [0.02, 0.02, 0.14, 0.14])
BLOCKS = {"square": ("bodyPolygon(px, py, 0.02, 1000);", SQUARE),
    "capsule": ("bodyCapsule(0.5, 0.06, 0.1, 0.06, 0, 1000);", ""),
    "clump": ("bodyClump(px, py, pr, 1000);", told("px", [0.42, 0.58]) + told("py", [0.08, 0.08]) + told("pr", [0.08, 0.08]))}


@pytest.mark.parametrize("kind, tilt", [("square", 14), ("clump", 45), *(pytest.param(*one, marks=pytest.mark.slow) for one in (
    ("square", 45), ("clump", 14), ("capsule", 14), ("capsule", 45)))])
def test_a_block_on_an_incline_sticks_or_slides(kind, tilt, long_box, freefem_text, tmp_path):
    """It stays where tan a < mu, else slides with g (sin a - mu cos a), and its two contacts carry what the lever of the friction
    gives them; mu = 0.3. Added mass and drag take 0.4 % of the acceleration."""
    body, arrays = BLOCKS[kind]
    a, t = np.radians(tilt), 0.1
    run = run_of(freefem_text, long_box, tmp_path / "run", body, "-friction", MU, "-film", 0, "-tend", t, arrays=arrays, tilt=a)
    table, last = run.particles, run.table("contacts")
    slides = np.tan(a) > MU
    assert table["u"][-1] == pytest.approx(G * (np.sin(a) - MU * np.cos(a)) * t if slides else 0, rel=0.01, abs=1e-5)
    assert np.abs(table["omega"]).max() < 1e-4 and np.abs(table["y"] - table["y"][0]).max() < 1e-7
    press, rub = last["impulse"][-2:], last["tangential"][-2:]
    assert set(last["sliding"][-2:]) == {float(slides)} and rub.sum() / press.sum() == pytest.approx(min(np.tan(a), MU), rel=0.003)
    height, half = {"square": (0.08, 0.08), "capsule": (0.06, 0.1), "clump": (0.08, 0.08)}[kind]
    assert np.ptp(press) / press.sum() == pytest.approx(min(np.tan(a), MU) * height / half, rel=0.01)


def test_who_enters_later_keeps_its_friction(long_box, freefem_text, tmp_path):
    """A capsule and disks fall on an incline: they roll with 2/3 g sin a, slide with g (sin a - mu cos a), or lie."""
    a = np.radians(30)
    body = """queueShape(bodyRough(bodyCapsule(0.4, 0.17, 0.1, 0.06, 0, 1000), 0.9), 0);
        queueShape(bodyCapsule(0.9, 0.17, 0.1, 0.06, 0, 1000), 0); queueRough(queueAt(1.3, 0.101, 0.1, 1000, 0), 0.7);
        queueRough(queueAt(1.7, 0.101, 0.1, 1000, 0), 0.1);"""
    run = run_of(freefem_text, long_box, tmp_path / "run", body, "-friction", 0, "-friction-wall", 1, "-film", 0, "-tend", 0.35,
        tilt=a, budget=0)
    drive, press = G * np.sin(a), G * np.cos(a)
    for k, exact in enumerate([0, drive, 2 / 3 * drive, drive - 0.1 * press]):
        rows = run.tracks[k]
        late = rows["t"] > 0.25
        rate = np.polyfit(rows["t"][late], rows["u"][late], 1)[0]
        assert rate == pytest.approx(exact, abs=0.01 * drive), k


@pytest.mark.parametrize("mu, u, omega, sticks", [(0.3, 1, 0, False), (0.9, 0.2, 2, True)])
def test_a_square_that_hits_a_wall_with_a_corner(mu, u, omega, sticks, long_box, freefem_text, tmp_path):
    """The impulses of one contact in closed form. The fluid takes a thousandth of the momentum."""
    size, radius, rho = 0.13, 0.02, 1000
    angles = 0.5 + np.pi / 2 * np.arange(4)
    corners = size * np.column_stack([np.cos(angles), np.sin(angles)])
    at = corners + [1.5, 0.03 + radius - corners[:, 1].min()]
    run = run_of(freefem_text, long_box, tmp_path / "run", f"bodyThrown(bodyPolygon(px, py, {radius}, {rho}), {u}, -1, {omega});",
        "-friction", mu, "-film", 0, "-tend", 0.045, arrays=told("px", at[:, 0]) + told("py", at[:, 1]), gravity=0.0)
    rows, contact = run.particles, run.table("contacts")
    hit = int(np.argmax(np.diff(rows["v"])))
    area, _, _, moment = moments([(1, corners, radius)])
    turn = rows["theta"][hit]
    arm = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    arm = arm[np.argmin(arm[:, 1])] - [0, radius]
    before = np.array([rows[key][hit] for key in ("u", "v", "omega")])
    (press, rub), after = struck(rho * area, rho * moment, arm, before, mu)
    assert len(contact["t"]) == 1 and contact["sliding"][0] == (not sticks) and (abs(rub) < mu * press * 0.999) == sticks
    assert [contact["impulse"][0], contact["tangential"][0]] == pytest.approx([press, rub], rel=0.01)
    assert [rows[key][hit + 1] for key in ("u", "v")] == pytest.approx(after[:2], abs=0.005)
    assert rows["omega"][hit + 1] * size == pytest.approx(after[2] * size, abs=0.005)


PAIR = told("px", [1.3, 1.46, 1.46, 1.3]) + told("py", [0.3, 0.28, 0.44, 0.46]) + told("qx", [1.6, 1.72]) + told("qy",
    [0.36, 0.5]) + told("qr", [0.08, 0.06])


@pytest.mark.parametrize("mu", [0.5, *(pytest.param(one, marks=pytest.mark.slow) for one in (0, 0.1, 10))])
def test_bodies_that_meet_keep_momentum_and_gain_no_energy(mu, long_box, freefem_text, tmp_path):
    """A polygon and a clump. What the walls do not explain of the momentum is at most 0.5 % of the impulse in the step of the
    collision (0.3 % in others, by the nodes that bodies cover and leave), and the kinetic energy falls in every step. The contact
    sticks with 0.15 of the pressure."""
    body = "bodyThrown(bodyPolygon(px, py, 0.02, 20), 1, -0.4, -3); bodyThrown(bodyClump(qx, qy, qr, 20), -1, 0.6, -3);"
    run = run_of(freefem_text, long_box, tmp_path / "run", body, "-friction", mu, "-film", 0, "-tend", 0.06, "-tolerance", "1e-8",
        dt=0.002, arrays=PAIR, gravity=0.0, mu=0.005)
    contact, budget = run.table("contacts"), run.table("budget")
    off = np.hypot(*(np.diff(budget[f"momentum_{d}"] - budget[f"walls_{d}"]) for d in "xy"))
    at = int(np.argmin(abs(budget["t"] - contact["t"][0]))) - 1
    assert off[at] < 0.005 * contact["impulse"][0]
    whole = budget["kinetic_energy"] + budget["dissipated"]
    assert np.diff(budget["kinetic_energy"]).max() < 0 and np.diff(whole)[at] < 0
    if mu > 0:
        share = abs(contact["tangential"][0]) / contact["impulse"][0]
        assert share == pytest.approx(0.1, rel=0.01) if mu == 0.1 else 0.12 < share < 0.2


PAIRED = ((0.35, 0.2, 0.4, 0.6, -1.5, 3), (0.66, 0.35, 2, -0.6, -1, -2))  # x, y, angle, u, v, omega


@pytest.mark.parametrize("density, more", [(3, ("-film", 0)), (100, ("-film", 1, "-film-roughness", 0.02, "-restitution", 0.6))])
def test_friction_of_collisions_does_not_hang_on_the_unit_of_length(density, more, cell, freefem_text, tmp_path):
    """Two capsules that meet each other and the floor, in units and in micrometres: the same to rounding, and the law holds. (Below
    a millimetre a collision rubbed by more than mu times its pressure: the residual of the law had a unit.)"""
    found = []
    for unit in (1.0, 2.0**-20):
        write_moved(read_mesh(cell), tmp_path / f"{unit}.mesh", np.eye(2), unit)
        body = "".join(f"bodyThrown(bodyCapsule({x * unit!r}, {y * unit!r}, {0.06 * unit!r}, {0.1 * unit!r}, {turn}, "
            f"{density}), {u * unit!r}, {v * unit!r}, {spin});" for x, y, turn, u, v, spin in PAIRED)
        text = case("{ " + body + " }", more=WORDS, mu=0.002 * unit**2).replace("gravityY = -1", f"gravityY = {-4 * unit!r}")
        freefem_text(text, "-mesh", tmp_path / f"{unit}.mesh", "-dt", 0.01, "-tend", 0.2, "-every", 0, "-cfl", 0, "-friction", MU,
            *more, "-out", tmp_path / f"{unit}")
        run = RunFolder(tmp_path / f"{unit}")
        contacts, rows = run.table("contacts"), run.particles
        assert len(contacts["t"]) > 2 and (abs(contacts["tangential"]) < MU * contacts["impulse"] * (1 + 2e-3)).all()
        found.append(np.column_stack([rows["x"] / unit, rows["y"] / unit, rows["u"] / unit, rows["v"] / unit, rows["omega"]]))
    assert np.abs(found[0] - found[1]).max() < 1e-8
