"""Bodies that rebound in a fluid, a thousand times as heavy as it and of little viscosity: Newton's law within what the fluid
takes, and Poisson's with friction.
"""
import numpy as np
import pytest

from tests.contact.shapes import moments, polygon
from tests.friction import poisson
from tests.tables import assert_refused, broken_off, momentum_told, numbers
from tools.base.run_folder import RunFolder

STEP = 0.005
HEAVY = """
include "lib/case.idp"
optCase("rebound", "heavy disks in a box");
real gravity = optNonNegative("-gravity", 9.81, "m/s2", "gravity");
real rhoFluid = 1, mu = 0.001, gravityX = 0, gravityY = -gravity;
int[int] flowNoSlip = [labelLeft, labelRight, labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
func real boundaryRamp(real t) { return 1; }
macro caseParticles() CODE // EOM
include "scripts/resolved.edp"
"""


def run_of(freefem_text, box, folder, code, *words):
    text = HEAVY.replace("CODE", "{" + code + "}")
    step = [] if "-dt" in words else ["-dt", STEP]
    freefem_text(text, "-mesh", box, *step, "-every", 0, "-stabilise", 0, "-budget", 1, "-out", folder, *words)
    return RunFolder(folder)


def energy_told(run, share):
    """Kinetic and dissipated energy less the work of the weights never exceeds what was there, by this share of its maximum."""
    budget = run.table("budget")
    whole = budget["kinetic_energy"] + budget["dissipated"] - budget["work"]
    assert np.diff(whole).max() < share * budget["kinetic_energy"].max()
    assert whole.max() < whole[0] + share * budget["kinetic_energy"].max()


@pytest.mark.parametrize("e", [0.8, 1])
def test_a_disk_that_falls_rebounds_with_its_part_of_the_speed(e, long_box, freefem_text, tmp_path):
    run = run_of(freefem_text, long_box, tmp_path / "run", "bodyDisk(1.5, 0.35, 0.1, 1000);", "-restitution", e, "-tend", 0.26)
    v, y, contacts = run.particles["v"], run.particles["y"], run.table("contacts")
    hit = int(np.argmax(np.diff(v)))
    before = 2 * v[hit] - v[hit - 1]
    assert len(contacts["t"]) == 1 and y.min() > 0.1 - 1e-9
    assert v[hit + 1] == pytest.approx(-e * before, rel=0.01)
    assert contacts["impulse"][0] == pytest.approx(-1000 * np.pi * 0.1**2 * (1 + e) * before, rel=0.01)
    energy_told(run, 1e-3)
    budget = run.table("budget")
    off = budget["momentum_y"] - budget["walls_y"] - budget["weight_y"]
    assert abs(off).max() < 2e-3 * contacts["impulse"][0]


def test_disks_that_meet_keep_their_momentum_and_part(long_box, freefem_text, tmp_path):
    run = run_of(freefem_text, long_box, tmp_path / "run", "bodyAdd(1.2, 0.4, 0.1, 1000, 1, 0, 0, 1); "
        "bodyBouncy(bodyAdd(1.6, 0.4, 0.1, 500, -1, 0, 0, 1), 0.6);", "-restitution", 0.9, "-gravity", 0, "-tend", 0.13)
    one, two = (run.tracks[k]["u"] for k in (0, 1))
    hit = int(np.argmin(np.diff(one)))
    assert two[hit + 1] - one[hit + 1] == pytest.approx(0.6 * (one[hit] - two[hit]), rel=0.01)  # the lesser coefficient
    assert 2 * one[hit + 1] + two[hit + 1] == pytest.approx(2 * one[hit] + two[hit], rel=0.005)
    energy_told(run, 1e-3)
    lost = 0.5 * (1 - 0.6**2) * 1000 * np.pi * 0.1**2 / 3 * (one[hit] - two[hit])**2  # the reduced mass is a third of the first
    assert run.table("budget")["contacts"][-1] == pytest.approx(lost, rel=0.01)


@pytest.mark.parametrize("density, friction", [(0.02, 0), (0.002, 0.5)])
def test_a_light_disk_gains_no_energy_when_it_rebounds(density, friction, long_box, freefem_text, tmp_path):
    """It rises to the top and rebounds wholly, with all the fluid around it. (Judged by the work of the contacts alone, a collision
    added up to a sixth of the kinetic energy: the flow that the mesh has in a narrow gap is not the one of its impulse.)"""
    run = run_of(freefem_text, long_box, tmp_path / "run", f"bodyDisk(1.5, 0.4, 0.15, {density});", "-restitution", 1, "-gravity",
        1, "-friction", friction, "-dt", 0.02, "-tend", 1.8)
    budget, contacts = run.table("budget"), run.table("contacts")
    most, energy = budget["work"].max(), budget["kinetic_energy"] - budget["work"]
    collided = np.isin(np.round(budget["t"][1:], 9), np.round(contacts["t"], 9))
    assert collided.sum() > 1 and run.particles["v"].min() < -0.1
    assert np.diff(energy)[collided].max() < 1e-4 * most
    assert np.diff(energy + budget["dissipated"])[collided].max() < 0.01 * most


FORMS = {"ellipse": ("", "{ bodyEllipse(1.5, 0.18, 0.12, 0.06, 0.7, 1000); MOVE }"),
    "square": ("real[int] px = [1.4, 1.6, 1.6, 1.4], py = [0.1, 0.14, 0.34, 0.3];", "{ bodyPolygon(px, py, 0.02, 1000); MOVE }")}


@pytest.mark.parametrize("kind", ["ellipse", pytest.param("square", marks=pytest.mark.slow)])
def test_an_oblique_impact_without_friction_turns_a_body(kind, long_box, freefem_text, tmp_path):
    """The impulse is (1 + e) m' v, v the speed of approach and 1/m' = 1/m + a^2/J with the lever a. The fluid takes a hundredth."""
    more, code = FORMS[kind]
    text = HEAVY.replace("CODE", code.replace("MOVE", "bodyQ = [0.5, -1, 2]; bodyQ1 = bodyQ; bodyQ2 = bodyQ;"))
    if more:
        text = text.replace("optCase", 'include "lib/bodies/shapes.idp"\n' + more + "\noptCase")
    freefem_text(text, "-mesh", long_box, "-dt", 0.002, "-every", 0, "-stabilise", 0, "-budget", 1, "-gravity", 0, "-restitution",
        0.8, "-tend", 0.1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    rows, contact = run.particles, run.table("contacts")
    hit = int(np.argmax(np.diff(rows["v"])))
    u, v, omega = (rows[key][hit] for key in ("u", "v", "omega"))
    turn = rows["theta"][hit] + 0.5 * (rows["theta"][hit + 1] - rows["theta"][hit])
    if kind == "ellipse":
        height = np.hypot(0.12 * np.sin(turn), 0.06 * np.cos(turn))
        lever = -(0.12**2 - 0.06**2) * np.sin(turn) * np.cos(turn) / height
        mass, arm2 = 1000 * np.pi * 0.12 * 0.06, (0.12**2 + 0.06**2) / 4
    else:
        corners = np.array([[-0.1, -0.12], [0.1, -0.08], [0.1, 0.12], [-0.1, 0.08]])
        area, _, _, moment = moments([(1, corners, 0.02)])
        c, s = np.cos(turn), np.sin(turn)
        lever = (corners @ np.array([[c, s], [-s, c]]))[(corners @ [s, c]).argmin(), 0]
        mass, arm2 = 1000 * area, moment / area
    press = -1.8 * (v + lever * omega) / (1 / mass + lever**2 / (mass * arm2))
    assert len(contact["t"]) == 1 and contact["impulse"][0] == pytest.approx(press, rel=0.02)
    assert rows["v"][hit + 1] == pytest.approx(v + press / mass, abs=0.02)
    assert rows["omega"][hit + 1] * 0.1 == pytest.approx((omega + lever * press / (mass * arm2)) * 0.1, abs=0.02)
    assert rows["u"][hit + 1] == pytest.approx(u, abs=0.01) and run.fluid["worst_gap"].min() > -1e-8
    energy_told(run, 1e-3)


def rubbed(freefem_text, box, folder, lines, motion, *words):
    """A run of bodies that are no disks, with these velocities (n, 3), on walls whose coefficients are greater than theirs."""
    told = [line.split("@") for line in lines]
    code = "".join(line[-1] for line in told) + f"bodyQ = [{', '.join(f'{v:.17g}' for v in np.transpose(motion).ravel())}]; "
    text = HEAVY.replace("CODE", "{" + code + "bodyQ1 = bodyQ; bodyQ2 = bodyQ; }")
    if len(told[0]) > 1:
        more = "\n".join(line[0] for line in told)
        text = text.replace("optCase", 'include "lib/bodies/shapes.idp"\n' + more + "\noptCase")
    freefem_text(text, "-mesh", box, "-every", 0, "-stabilise", 0, "-budget", 1, "-gravity", 0, "-restitution-wall", 1,
        "-friction-wall", 1, "-out", folder, *words)
    run = RunFolder(folder)
    kinetic, contacts = run.table("budget"), run.table("contacts")
    collided = np.isin(np.round(kinetic["t"][1:], 9), np.round(contacts["t"], 9))
    assert np.diff(kinetic["kinetic_energy"])[collided].max() < 0 and run.fluid["worst_gap"].min() > -1e-6
    return run, contacts


@pytest.mark.parametrize("kind", ["ellipse", pytest.param("polygon", marks=pytest.mark.slow)])
def test_oblique_impacts_with_friction_are_those_of_poissons_law(kind, long_box, freefem_text, tmp_path):
    """Four bodies on a floor, with coefficients of their own: the closed form, which the fluid changes by a hundredth. The friction
    of the last, 1e-9, is as good as none. (It stuck: what slides was told by the last digit of its friction.)"""
    rng = np.random.default_rng(1)
    one = np.column_stack([rng.uniform(0.1, 1.4, 4), rng.uniform(-1, 1, 4), rng.uniform(-1.5, -1, 4), rng.uniform(-3, 3, 4),
        [0.2, 0.5, 1, 1e-9], [0.8, 0.4, 1, 0.6]])
    lines, shapes = [], []
    for k, (angle, *_, mu, e) in enumerate(one):
        if kind == "ellipse":
            made = f"bodyRough(bodyEllipse({0.4 + 0.7 * k}, 0.16, 0.12, 0.06, {angle:.17g}, 1000), {mu:.17g});"
        else:
            around = angle + 2 * np.pi / (3 + k % 2) * np.arange(3 + k % 2)
            corners = 0.12 * np.column_stack([np.cos(around), np.sin(around)])
            made = polygon(corners + [0.4 + 0.7 * k, 0.2], 0.02, mu=mu)
            shapes.append((corners, *np.array(moments([(1, corners, 0.02)]))[[0, 3]]))
        lines.append(made.replace("bodyRough(", "bodyBouncy(bodyRough(").rstrip(";") + f", {e});")
    run, contacts = rubbed(freefem_text, long_box, tmp_path / "run", lines, one[:, 1:4], "-dt", 0.001, "-tend", 0.1)
    energy_told(run, 1e-3)
    budget = run.table("budget")
    for d in "xy":
        left = budget[f"momentum_{d}"] - budget[f"walls_{d}"]
        assert np.abs(left - left[0]).max() < 1e-3 * contacts["impulse"].max()
    for k, (_, *_, mu, e) in enumerate(one):
        rows = run.tracks[k]
        hit, own = int(np.argmax(np.diff(rows["v"]))), contacts["i"] == k
        turn = rows["theta"][hit]
        if kind == "ellipse":
            height = np.hypot(0.12 * np.sin(turn), 0.06 * np.cos(turn))
            arm = (-(0.12**2 - 0.06**2) * np.sin(turn) * np.cos(turn) / height, -height)
            mass, arm2 = 1000 * np.pi * 0.12 * 0.06, (0.12**2 + 0.06**2) / 4
        else:
            corners, area, moment = shapes[k]
            c, s = np.cos(turn), np.sin(turn)
            placed = corners @ np.array([[c, s], [-s, c]])
            arm, mass, arm2 = placed[placed[:, 1].argmin()] - [0, 0.02], 1000 * area, moment / area
        before, after = ([rows[key][at] for key in ("u", "v", "omega")] for at in (hit, hit + 1))
        exact, _ = poisson(mass, mass * arm2, arm, np.array(before), mu, e)
        assert np.array(after) * [1, 1, 0.1] == pytest.approx(exact * [1, 1, 0.1], abs=0.025)
        assert (np.abs(contacts["tangential"][own]) <= mu * contacts["impulse"][own] * (1 + 2e-3)).all()


@pytest.mark.parametrize("kind, density, seed", [("ellipse", 1000, 3)] + [pytest.param(kind, density, seed, marks=pytest.mark.slow)
    for kind in ("ellipse", "polygon") for density in (2, 1000) for seed in (4, 5)])
def test_a_crowd_that_rebounds_and_rubs_gains_no_energy(kind, density, seed, long_box, freefem_text, tmp_path):
    """Ten bodies in a box, friction from 0.1 to 1 and restitution from 0.2 to 1 at random: no collision adds kinetic energy."""
    rng, lines = np.random.default_rng(seed), []
    for k in range(10):
        x, y, mu, e, own = 0.45 + 0.5 * (k % 5), 0.22 + 0.36 * (k // 5), rng.uniform(0.1, 1), rng.uniform(0.2, 1), rng.uniform(0, 3)
        if kind == "ellipse":
            made = (f"bodyRough(bodyEllipse({x}, {y}, 0.12, {rng.uniform(0.06, 0.12)}, {own}, {density * rng.uniform(0.5, 2)}), "
                f"{mu});")
        else:
            around = own + 2 * np.pi / (3 + k % 3) * np.arange(3 + k % 3)
            made = polygon([x, y] + 0.1 * np.column_stack([np.cos(around), np.sin(around)]), 0.02, mu=mu)
            made = made.replace(", 1000)", f", {density * rng.uniform(0.5, 2)})")
        lines.append(made.replace("bodyRough(", "bodyBouncy(bodyRough(").rstrip(";") + f", {e});")
    motion = rng.normal(0, 1, (10, 3)) * [2, 2, 5]
    _, contacts = rubbed(freefem_text, long_box, tmp_path / "run", lines, motion, "-dt", 0.004, "-tend", 0.2)
    assert len(contacts["t"]) > 1


@pytest.mark.slow
def test_two_ellipses_that_rebound_and_rub_keep_their_momentum(freefem_text, tmp_path):
    """As without restitution (tests/bodies/test_friction_in_flow.py), and with more of it."""
    bodies = ("{ bodyEllipse(0.38, 0.5, 0.11, 0.07, 0.5, 2); bodyEllipse(0.62, 0.55, 0.1, 0.07, 0.9, 2); "
        "bodyQ = [1, -1, 0, 0.6, 0, 0]; bodyQ1 = bodyQ; bodyQ2 = bodyQ; }")
    press = []
    for e in (0, 0.8):
        found = momentum_told(freefem_text, tmp_path / str(e), bodies, words=("-friction", 0.5, "-restitution", e))
        hit = int(np.argmax(found[:, 2] > 1e-4))
        press.append(found[hit, 2])
        assert hit > 1 and np.hypot(*(found[hit] - found[hit - 1])[:2]) < 1.2e-3 * press[-1]
    assert 1.75 < press[1] / press[0] < 1.85


CHAIN = ("bodyBouncy(bodyAdd(1.0, 0.4, 0.1, 1000, 2, 0, 0, 1), 1); bodyBouncy(bodyAdd(1.21, 0.4, 0.1, 50, 1.99, 0, 0, 1), 1); "
    "bodyBouncy(bodyAdd(1.42, 0.41, 0.1, 1000, -2, 0, 0, 1), 0.1);")


@pytest.mark.parametrize("friction", [0, pytest.param(0.5, marks=pytest.mark.slow)])
def test_a_chain_with_several_coefficients_gains_no_energy(friction, long_box, freefem_text, tmp_path):
    """Newton's law at several contacts at once can add energy: here a fifth of what there is, if nothing prevents it."""
    run = run_of(freefem_text, long_box, tmp_path / "run", CHAIN, "-gravity", 0, "-friction", friction, "-tend", 0.05)
    assert len(run.table("contacts")["t"]) > 1 and run.fluid["worst_gap"].min() > -1e-9
    energy_told(run, 1e-3)


def test_a_disk_comes_to_rest_and_a_wall_without_restitution_stops_it(long_box, freefem_text, tmp_path):
    """Contacts slower than twice what gravity adds in a step do not rebound. The wall: byte for byte what a scene without has."""
    disk = "bodyDisk(1.5, 0.14, 0.1, 1000);"
    run = run_of(freefem_text, long_box, tmp_path / "run", disk, "-restitution", 0.5, "-tend", 0.5)
    v, y = run.particles["v"], run.particles["y"]
    assert v.max() == pytest.approx(0.5 * -v.min(), rel=0.1)
    assert abs(v[-20:]).max() < 1e-3 and abs(y[-20:] - 0.1).max() < 1e-6
    ellipse = disk.replace(");", "); bodyRough(bodyEllipse(0.5, 0.13, 0.12, 0.07, 0.7, 1000), 0.5);")
    text = [run_of(freefem_text, long_box, tmp_path / f"stop{k}", "{" + ellipse + "}", "-film", 0, "-tend", 0.12,
        *words).folder / "particles.csv"
        for k, words in enumerate(([], ["-restitution", 0.5, "-restitution-wall", 0]))]
    assert text[0].read_bytes() == text[1].read_bytes()


SQUEEZED = [(0.12612, 0.10525, 0.09040, 671.09, -1.7848, -0.2513, 8.174),
    (0.24891, 0.30720, 0.12061, 14203, -1.2857, -1.7089, -2.875)]


@pytest.mark.parametrize("e, friction, bodies", [
    (1, 0.5, [(0.3, 0.3, 0.1, 1000, -2, -1.9, 0), (0.52, 0.5, 0.1, 20000, -2, -1.9, 3), (0.3, 0.6, 0.05, 50, -1, -3, 0)]),
    pytest.param(1, 0.3, SQUEEZED, marks=pytest.mark.slow)])
def test_what_a_collision_sends_against_another_wall_rebounds_at_once(e, friction, bodies, long_box, freefem_text, tmp_path):
    """Heavy disks strike light ones in a corner. Momentum holds in each step, and in no step is it a contact force that stops a
    disk. (A wall that the first collision had released counted as touched since: 2 % of the impulse was missing for a step.)"""
    code = " ".join(f"bodyAdd({', '.join(str(float(value)) for value in one)}, 1);" for one in bodies)
    run = run_of(freefem_text, long_box, tmp_path / "run", code, "-gravity", 0, "-restitution", e, "-friction", friction, "-dt",
        0.002, "-tend", 0.2)
    budget, contacts = run.table("budget"), run.table("contacts")
    assert len(contacts["t"]) > 8 and run.fluid["worst_gap"].min() > -1e-9
    for d in "xy":
        left = budget[f"momentum_{d}"] - budget[f"walls_{d}"]
        assert np.abs(np.diff(left)).max() < 1e-3 * contacts["impulse"].max()
    energy_told(run, 1e-3)


@pytest.mark.slow
def test_a_run_that_rebounds_continues_bit_for_bit(long_box, tmp_path):
    """The checkpoint is of the step before the collision, and of that behind it."""
    code = "{ bodyBouncy(bodyAdd(1.5, 0.15, 0.1, 1000, 0.3, -1, 0, 1), 0.7); wallBouncy(labelBottom, 0.9); }"
    (tmp_path / "scene.edp").write_text(HEAVY.replace("CODE", code))
    for steps in (7, 8):
        words = [tmp_path / "scene.edp", "-mesh", long_box, "-dt", "0.005", "-every", "0", "-budget", "1", "-tend",
            "0.07", "-friction", "0.3", "-cfl", "0", "-checkpoint", str(steps)]
        whole, broken = broken_off(words, tmp_path / str(steps), steps)
        table = numbers(whole, "particles.csv")
        assert table["t"][np.argmax(np.diff(table["v"])) + 1] == pytest.approx(0.04) and table["v"].max() > 0.6
        for name in ("particles.csv", "contacts.csv", "budget.csv"):
            assert (broken / name).read_bytes() == (whole / name).read_bytes(), name


@pytest.mark.parametrize("code, words, says", [
    ("bodyDisk(1.5, 0.4, 0.1, 2);", ["-restitution", 0.5, "-scheme", "published"], "restitution in a flow is for -scheme standard"),
    pytest.param("{ bodyDisk(1.5, 0.4, 0.1, 2); wallBouncy(77, 0.5); }", [], "no wall with this label", marks=pytest.mark.slow),
])
def test_what_is_refused(code, words, says, long_box, freefem_text, tmp_path):
    done = freefem_text(HEAVY.replace("CODE", code), "-mesh", long_box, "-dt", 0.01, "-tend", 0.01, "-out",
        tmp_path / "run", *words, check=False)
    assert_refused(done, [3], says)
