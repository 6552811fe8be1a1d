"""Lubrication films in gaps that the mesh does not resolve: the exact resistance of a disk at a wall, what films leave alone, and
the records."""
import numpy as np
import pytest

from tests.conftest import make_mesh, standard_alone
from tests.scenes import case
from tests.tables import broken_off, rows
from tools.base.run_folder import RunFolder
from tools.validation.films import of_pair

WEIGHT = 10.0


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    """A box of 8 x 8 radii, four elements a radius."""
    return make_mesh(tmp_path_factory.mktemp("box") / "box.mesh", "box", "--width", 8, "--height", 8, "--size", 0.25)


def scene(bodies, more="", gravity=-WEIGHT / np.pi, slip="", mu=1):
    walls = "labelLeft, labelRight, labelBottom, labelTop, labelWall" if not slip else ", ".join({"labelLeft", "labelRight",
        "labelBottom", "labelTop"} - {slip})
    return case(bodies, walls=walls, more=more, gravity=gravity, slip=slip, mu=mu)


def exact(gap):
    """Resistance of a unit disk towards a plane, over mu (Jeffrey & Onishi 1981)."""
    a = np.arccosh(1 + gap)
    return 4 * np.pi / (a - np.tanh(a))


def sink(freefem_text, folder, mesh, gap, end, *options, x=4.07, step=0.1):
    freefem_text(scene(f"bodyDisk({x}, {1 + gap}, 1, 2);"), "-mesh", mesh, "-dt", step, "-cfl", 0, "-stabilise", 0, "-tend", end,
        "-every", 0, *options, "-out", folder)
    run = RunFolder(folder)
    return run, run.particles["y"] - 1, -run.particles["v"]


@pytest.mark.parametrize("x, step", [(4.0, 0.1), (4.07, 0.025)])
def test_a_disk_sinks_to_the_floor_as_the_exact_resistance_says(x, step, box, freefem_text, tmp_path):
    """It hung, 4 to 6 times too slow, from a gap that depended on the step: the continuity equation came back at the vertices of
    walls where nu dt > h^2/2."""
    _, gap, speed = sink(freefem_text, tmp_path / "run", box, 0.16, 8.5, x=x, step=step)
    late = (gap < 0.12) & (np.arange(len(gap)) * step > 0.4)  # it starts from rest
    ratio = (WEIGHT - 2 * np.pi * np.gradient(speed, step)) / speed / exact(gap)  # less what accelerates it
    # for some steps after another vertex has been left out
    assert gap.min() < 0.041 and 0.85 < ratio[late].min() and ratio[late].max() < 1.25
    assert 0.94 < np.median(ratio[late]) < 1.1
    first, last = np.argmax(late), len(gap) - 1
    way = np.linspace(gap[last], gap[first], 2000)
    assert (last - first) * step == pytest.approx(np.trapezoid(exact(way), way) / WEIGHT, rel=0.07)


CURVED = "macro caseDomain() {{ border round(s = 0, 2*pi) {{ x = 4*cos(s); y = 4 + 4*sin(s); label = labelWall; }} " \
    "Th = buildmesh(round({chords})); }} // EOM"
GRADED = "macro caseDomain() Th = movemesh(Th, [x, 8*(y/8)^1.25]); // EOM"


@pytest.mark.parametrize("domain, x, whole", [(CURVED.format(chords=100), 0, 1930.9), (GRADED, 4.07, 1252)])
def test_films_at_a_curved_wall_and_in_a_graded_mesh(domain, x, whole, box, freefem_text, tmp_path):
    """At a gap of 0.05. In a round box of four radii (finite elements in bipolar coordinates: whole) the wall was taken for
    straight, and the disk met 0.78 of the resistance."""
    freefem_text(scene(f"bodyDisk({x}, 1.08, 1, 2);", domain, gravity=-2 * WEIGHT / np.pi), "-mesh", box, "-dt", 0.1, "-cfl", 0,
        "-stabilise", 0, "-tend", 4.5 if x == 0 else 2.7, "-every", 0, "-out", tmp_path / "run")
    bodies = RunFolder(tmp_path / "run").particles
    gap, speed = bodies["y"] - 1, -bodies["v"]
    force = 2 * WEIGHT - 2 * np.pi * np.gradient(speed, 0.1)
    late = (gap < 0.06) & (gap > 0.045)
    assert gap[-1] < 0.05 and np.median((force / speed * gap**1.5)[late]) == pytest.approx(whole * 0.05**1.5, rel=0.12)


POST = """macro caseDomain() {{
    border box(s = 0, 1; i) {{ real a = 9*s - 4.5;
        x = 1.5*cos({to}) + (i == 0 ? a : (i == 1 ? 4.5 : (i == 2 ? -a : -4.5)));
        y = 1.5*sin({to}) + (i == 0 ? -4.5 : (i == 1 ? a : (i == 2 ? 4.5 : -a))); label = labelWall; }}
    border post(s = 0, 1) {{ x = cos(0.3 + 2*pi*s); y = sin(0.3 + 2*pi*s); label = labelWall; }}
    int[int] sides = [36, 36, 36, 36];
    Th = buildmesh(box(sides) + post(-16), fixedborder = true); }} // EOM
macro caseMotion(now) givenMotion(0, -1e-6*cos({to}), -1e-6*sin({to}), 0); // EOM
"""


@pytest.mark.parametrize("corner, off", [(2, 2.01), (2.5, 1.01 + np.cos(np.pi / 16))])
def test_a_post_whose_sides_are_as_long_as_its_elements_is_round(corner, off, box, freefem_text, tmp_path):
    """A post of 16 sides, which are the chords by which its mesh has a circle, a gap of 0.01: the resistance is that of two disks
    (tools/validation/films.py), half of the relative speed each. That of the polygon is 1400 at a corner and 10,719 at a side."""
    to = 0.3 + 2 * np.pi * corner / 16
    body = f"bodyHeld(bodyDisk({off * np.cos(to)}, {off * np.sin(to)}, 1, 1));"
    freefem_text(scene(body, POST.format(to=to), gravity=0), "-mesh", box, "-dt", 0.125, "-cfl", 0, "-stabilise", 0, "-tend", 0.75,
        "-every", 0, "-forces", 1, "-out", tmp_path / "run")
    forces = RunFolder(tmp_path / "run").table("forces")
    assert (forces["fx"][-1] * np.cos(to) + forces["fy"][-1] * np.sin(to)) / 1e-6 == pytest.approx(of_pair(0.01) / 2, rel=0.15)


def test_without_films_a_disk_lands_where_viscosity_crosses_an_element_in_a_step(box, freefem_text, tmp_path):
    """nu dt/h^2 = 0.8: between those of wall and interior vertices. It hung at a gap of 0.04."""
    _, gap, _ = sink(freefem_text, tmp_path / "run", box, 0.08, 3, "-film", 0, x=4.08, step=0.05)
    assert gap[-1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("mu, least, most", [(0.2, 0.025, 0.033), (0.02, 0, 0.002)])
def test_a_disk_thrown_at_a_wall_stops_in_the_film_and_stays(mu, least, most, box, freefem_text, tmp_path):
    """At Reynolds numbers of 10 and 100; up to 0.155 of the speed came back."""
    text = scene("bodyAdd(4.07, 1.3, 1, 8, 0, -1, 0, 1);", gravity=0, mu=mu)
    freefem_text(text, "-mesh", box, "-dt", 0.02, "-cfl", 0, "-stabilise", 0, "-tend", 2.5, "-every", 0, "-out", tmp_path / "run")
    bodies = RunFolder(tmp_path / "run").particles
    assert bodies["v"].max() < 0.01 and least < bodies["y"][-1] - 1 < most


def test_the_pressure_in_a_gap_follows_the_velocity_at_once(box, freefem_text, tmp_path):
    """A heavy disk thrown at the floor at a Reynolds number of 0.1: the momentum that it loses from 0.25 to 0.1 radii is that of
    the exact resistance. The mesh's pressure took tens of steps to rise, and 0.9 of it was lost."""
    text = scene("bodyAdd(4.07, 1.3, 1, 800, 0, -1, 0, 1);", gravity=0, mu=20)
    freefem_text(text, "-mesh", box, "-dt", 0.00625, "-cfl", 0, "-stabilise", 0, "-tend", 0.27, "-every", 0, "-out",
        tmp_path / "run")
    bodies = RunFolder(tmp_path / "run").particles
    early, late = np.interp([-0.25, -0.1], 1 - bodies["y"], bodies["v"])
    way = np.linspace(0.1, 0.25, 2000)
    assert 800 * np.pi * (late - early) / 20 == pytest.approx(np.trapezoid(exact(way), way), rel=0.05)


FOLLOWED = """macro caseLoads(now) {{
    filmEach = {each};
    if (filmWho.n > 0) {{
        real[int] thick = filmGap .* filmWide;
        filmMeshForce(thick);
        real sum = 0;
        for (int k = 0; k < filmWho.n; ++k) if (abs(filmVertexY[filmAt[k]]) < 1e-9) sum += 0.25*filmAtVertex[k];
        cout << "FOLLOWED " << sum/filmMesh[0] << " " << filmWho.n << endl;
        filmMesh.resize(0);
    }}
}} // EOM"""


def test_the_pressure_that_follows_is_the_force_that_bodies_meet(box, freefem_text, tmp_path):
    """A disk of eight elements a radius above the floor: the pressure at the vertices of the floor adds up to the force over the
    velocity of approach. The vertices ended before the gap did, and which of them there were depended on the bins they lay in."""
    found = []
    for each in (1, 12):
        out = freefem_text(scene("bodyDisk(4.07, 2.07, 2, 2);", FOLLOWED.format(each=each)), "-mesh", box, "-dt", 0.05, "-cfl", 0,
            "-stabilise", 0, "-tend", 0.2, "-every", 0, "-out", tmp_path / f"run{each}").stdout
        found.append([line for line in out.splitlines() if line.startswith("FOLLOWED")])
    assert found[0] == found[1] and len(found[0]) == 3
    assert float(found[0][-1].split()[1]) == pytest.approx(1, rel=0.02)


def test_a_disk_along_a_wall_is_held_by_the_film(box, freefem_text, tmp_path):
    """4 pi mu/a more than at a gap that the mesh resolves; without the film 0.6 of the whole at a gap of 0.02."""
    found = []
    for gap in (0.3, 0.02):
        freefem_text(scene(f"bodyDisk(3.9, {1 + gap}, 1, 2);", gravity=0).replace("gravityX = 0", "gravityX = 0.3183"), "-mesh",
            box, "-dt", 0.05, "-cfl", 0, "-stabilise", 0, "-tend", 3, "-every", 0, "-out", tmp_path / f"run{gap}")
        found.append(1 / RunFolder(tmp_path / f"run{gap}").particles["u"][30:].mean())
    more = 4 * np.pi * (1 / np.arccosh(1.02) - 1 / np.arccosh(1.3))
    assert found[1] - found[0] == pytest.approx(more, rel=0.2)


def test_an_ellipse_has_the_film_of_its_radius_of_curvature(box, freefem_text, tmp_path):
    """Semi-axes 1 and 1/2, flat: a radius of curvature of 2 at the lowest point."""
    freefem_text(scene("bodyEllipse(4.07, 0.54, 1, 0.5, 0, 3);"), "-mesh", box, "-dt", 0.1, "-cfl", 0, "-stabilise", 0, "-tend", 4,
        "-every", 0, "-out", tmp_path / "run")
    bodies = RunFolder(tmp_path / "run").particles
    gap, late = bodies["y"] - 0.5, slice(10, None)
    film = 1.5 * np.pi * (4 / gap) ** 1.5
    assert np.abs(WEIGHT / -bodies["v"] / film - 1)[late].max() < 0.15 and abs(bodies["theta"][-1]) < 0.01


def test_a_plane_of_symmetry_is_another_disk_in_the_mirror(box, freefem_text, tmp_path):
    half = tmp_path / "half.mesh"
    sides = "int[int] sides = [13, 12, 14, 11]; "
    whole = tmp_path / "whole.mesh"
    freefem_text(f'{sides}savemesh(square(16, 32, [4*x, 8*y], label = sides), "{half}"); savemesh(square(32, 32, [8*x - 4, 8*y], '
        f'label = sides), "{whole}");')
    push = "macro caseLoads(now) { bodyPush(0, -10, 0, 0); if (bodyNumber > 1) bodyPush(1, 10, 0, 0); } // EOM\n"
    gaps = []
    for mesh, bodies, slip in ((half, "bodyDisk(1.03, 4.07, 1, 2);", "labelLeft"), (whole, "bodyDisk(1.03, 4.07, 1, 2); "
        "bodyDisk(-1.03, 4.07, 1, 2);", "")):
        freefem_text(scene(bodies, push, 0, slip), "-mesh", mesh, "-dt", 0.05, "-cfl", 0, "-stabilise", 0, "-tend", 1.5, "-every",
            0, "-out", tmp_path / f"run{slip}")
        table = RunFolder(tmp_path / f"run{slip}").particles
        gaps.append(2 * (table["x"][table["id"] == 0] - 1))
    time = np.log(gaps[0][5] / gaps[0][-1]), np.log(gaps[1][5] / gaps[1][-1])
    assert gaps[0][-1] < 0.04 and time[0] == pytest.approx(time[1], rel=0.1)


LOOK = """macro caseStep() {
    real[int] q(3*bodyNumber), f(3*bodyNumber), s(0);
    filmForce(f);
    cout << "films " << filmN << " " << filmPairs << " " << filmListN << " " << filmDrive() - f'*bodyQ << endl;
    if (filmN > 0) {
        for (int k = 0; k < bodyNumber; ++k) { q[k] = -bodyY[k]; q[bodyNumber + k] = bodyX[k]; q[2*bodyNumber + k] = 1; }
        real turn = 0;
        for (int k = 0; k < bodyNumber; ++k) turn += bodyX[k]*f[bodyNumber + k] - bodyY[k]*f[k] + f[2*bodyNumber + k];
        s.resize(3*bodyNumber); s = 0.; filmApply(q, s);
        real fx = 0, fy = 0;
        for (int k = 0; k < bodyNumber; ++k) { fx += f[k]; fy += f[bodyNumber + k]; }
        cout << "free " << fx << " " << fy << " " << turn << " " << s.linfty << " " << f.linfty << endl;
    }
} // EOM"""


@pytest.mark.parametrize("bodies", [
    "bodyAdd(3.3, 4.1, 1, 2, 0.1, 0.3, 0.2, 1); bodyAdd(5.33, 4.3, 1, 3, -0.1, 0, 0.4, 1);",
    "bodyEllipse(3.3, 4.1, 1, 0.6, 0.3, 2); bodyAdd(4.95, 4.7, 0.7, 3, -0.1, 0, 0.4, 1);"])
def test_films_between_bodies_keep_momentum_and_let_them_rotate_together(bodies, box, freefem_text, tmp_path):
    done = freefem_text(standard_alone(scene(bodies, LOOK, 0)), "-mesh", box, "-dt", 0.02, "-tend", 0.04, "-out", tmp_path / "run")
    found = rows(done.stdout, "films")
    assert len(found) == 2 and (found[:, :2] == 1).all() and found[:, 3].min() > 0
    for fx, fy, turn, rotation, most in rows(done.stdout, "free"):
        assert most > 0.01 and max(abs(fx), abs(fy)) < 1e-9 * most and abs(turn) < 1e-8 * most and rotation < 1e-6


TURN = LOOK.replace("    if (filmN > 0) {", """    real[int] turns(3), rates(0);
    turns = [-bodyY[0], bodyX[0], 1];
    rates.resize(3*filmN) = filmB*turns;
    cout << "turns " << rates[1] << " " << rates[2] << " " << rates[0] << endl;
    if (filmN > 0) {""")


@pytest.mark.parametrize("chords", [60, 300])
def test_a_wall_in_many_pieces_is_one_film(chords, freefem_text, tmp_path):
    """And a disk that turns with a round wall about its centre slides and rolls on it as the wall's own speed has it, 4: there is
    no film where all turn as a whole. For a straight wall they rolled with -2."""
    mesh = tmp_path / "round.mesh"
    text = f'border c(s = 0, 2*pi) {{ x = 4*cos(s); y = 4*sin(s); label = 3; }}\nsavemesh(buildmesh(c({chords})), "{mesh}");\n'
    done = freefem_text(text + standard_alone(case("bodyDisk(0.1, -2.92, 1, 2);", walls="labelWall", more=TURN, mu=1)), "-mesh",
        mesh, "-dt", 0.02, "-tend", 0.04, "-out", tmp_path / "run")
    assert (rows(done.stdout, "films")[:, 0] == 1).all()
    assert rows(done.stdout, "turns") == pytest.approx(np.array([[4, -4, 0]] * 2), abs=0.15)


def test_nothing_is_computed_where_all_are_far_from_each_other(box, freefem_text, tmp_path):
    done = freefem_text(standard_alone(scene("bodyDisk(2.3, 4, 0.8, 2); bodyDisk(5.7, 4, 0.8, 2);", LOOK)), "-mesh", box, "-dt",
        0.02, "-tend", 0.06, "-out", tmp_path / "run")
    assert (rows(done.stdout, "films") == np.zeros((3, 4))).all()


def test_a_disk_that_has_landed_is_carried_by_the_contact(box, freefem_text, tmp_path):
    """The fluid lets go of it as slowly as without films; from rest at the floor the contact bears all."""
    for gap0, end, within in ((0.07, 11, 0.03), (0, 2, 1e-3)):
        run, gap, _ = sink(freefem_text, tmp_path / f"run{gap0}", box, gap0, end, "-film-roughness", 0.05)
        contacts = run.table("contacts")
        assert abs(gap[-1]) < 1e-9 and contacts["t"][-1] == pytest.approx(end)
        assert contacts["impulse"][-1] / 0.1 == pytest.approx(WEIGHT, rel=within)


def test_a_heap_that_lies_is_carried_by_its_contacts(freefem_text, tmp_path):
    """From a gap of 0: disks on the floor and on each other, and a disk on an ellipse. Each body's contacts carry what lies on it,
    so that films and fluid carry less than a thousandth of the weight."""
    r, step = 0.125, 0.002
    bodies = (f"{{ bodyDisk({r}, {r}, {r}, 3); bodyDisk({3 * r}, {r}, {r}, 3); bodyEllipse({6 * r}, {r}, {2 * r}, {r}, 0, 3); "
        f"bodyDisk({6 * r}, {3 * r}, {r}, 3); bodyDisk({2 * r}, {r}*(1 + sqrt(3.)), {r}, 3); }}")
    freefem_text(case(bodies, mu=0.02, gravity=-10), "-dt", step, "-cfl", 0, "-tend", 60 * step, "-every", 0, "-forces", 1, "-out",
        tmp_path / "run")
    run, weight = RunFolder(tmp_path / "run"), 20 * np.pi * r**2 * np.array([1, 1, 2, 1, 1])
    contacts, forces = run.table("contacts"), run.table("forces")
    last, carried = contacts["t"] > 59.5 * step, np.zeros(5)
    up = contacts["impulse"][last] * contacts["ny"][last] / step
    for side, sign in (("i", 1), ("j", -1)):
        who = contacts[side][last].astype(int)
        np.add.at(carried, who[who >= 0], sign * up[who >= 0])
    assert carried == pytest.approx(weight, rel=1e-3) and up[contacts["j"][last] < 0].sum() == pytest.approx(weight.sum(), rel=1e-3)
    assert np.abs(forces["fy"][-5:]).max() < 1e-3 * weight.min()


def test_disks_and_ellipses_that_have_settled_are_carried_by_their_contacts(freefem_text, tmp_path):
    """They sink through their films, with the roughness of the default. The fluid in the heap still moves: its floor bears up to
    0.15 % more than the weight."""
    row = "bodyDisk(0.253, 0.13, 0.12, 3); bodyEllipse(0.703, 0.1, 0.16, 0.09, 0, 3);"
    heap = ("for (int k = 0; k < 4; ++k) bodyDisk(0.125 + 0.25*k, 0.13, 0.12, 3); for (int k = 0; k < 3; ++k) "
        "bodyDisk(0.25 + 0.25*k, 0.14 + 0.125*sqrt(3.), 0.12, 3);")
    for name, bodies, area, end in (("row", row, 0.0288, 2), ("heap", heap, 7 * 0.0144, 2.4)):
        freefem_text(case("{ " + bodies + " }", mu=0.002, gravity=-10), "-dt", 0.004, "-cfl", 0, "-tend", end, "-every", 0,
            "-forces", 1, "-out", tmp_path / name)
        run, weight = RunFolder(tmp_path / name), 20 * np.pi * area
        contacts, forces = run.table("contacts"), run.table("forces")
        floor = (contacts["j"] < 0) & (np.abs(contacts["ny"]) > 0.9) & (contacts["t"] > end - 0.1)
        last = contacts["impulse"][floor].sum() / 0.1
        assert 0.999 < last / weight < 1.002, name
        late = forces["t"] > end - 0.1
        assert abs(forces["fy"][late].sum()) * 0.004 / 0.1 < 2e-3 * weight, name


def test_records_have_the_forces_of_films(box, freefem_text, tmp_path):
    """While it sinks without inertia the floor bears the weight, most of it by the film, and what the weight does is dissipated
    there."""
    run, gap, speed = sink(freefem_text, tmp_path / "run", box, 0.08, 4, "-wallforces", 1, "-budget", 1)
    walls, budget = run.table("wallforces"), run.table("budget")
    assert walls["fy"][20:] == pytest.approx(-WEIGHT, rel=0.02)
    off = budget["momentum_y"] - budget["walls_y"] - budget["weight_y"]
    assert np.abs(off[20:] - off[20]).max() < 0.02 * WEIGHT * (budget["t"][-1] - budget["t"][20])
    assert budget["dissipated"][-1] - budget["dissipated"][20] == pytest.approx(budget["work"][-1] - budget["work"][20], rel=0.05)


def test_the_force_on_a_held_disk_has_the_film(box, freefem_text, tmp_path):
    """A prescribed approach; exact resistance within that of the mesh."""
    motion = "macro caseMotion(now) givenMotion(0, 0, -0.01, 0); // EOM\n"
    freefem_text(scene("bodyHeld(bodyDisk(4.07, 1.05, 1, 1));", motion, 0), "-mesh", box, "-dt", 0.05, "-cfl", 0, "-stabilise", 0,
        "-tend", 1.5, "-every", 0, "-forces", 1, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.table("forces")["fy"][-1] == pytest.approx(0.01 * exact(run.particles["y"][-1] - 1), rel=0.15)


def test_a_restart_within_a_film_gives_the_same_bytes(box, tmp_path):
    text = scene("bodyDisk(3.4, 1.06, 1, 2); bodyDisk(5.45, 1.3, 1, 2.5);")
    (tmp_path / "scene.edp").write_text(text)
    whole, broken = broken_off([tmp_path / "scene.edp", "-mesh", box, "-dt", 0.05, "-cfl", 0, "-every", 1e-9, "-checkpoint", 10,
        "-tend", 1], tmp_path, 10)
    assert (whole / "particles.csv").read_bytes() == (broken / "particles.csv").read_bytes()


def test_bodies_that_are_thrown_beside_a_wall_have_a_budget(box, freefem_text, tmp_path):
    """Their films are found for the flow of the start, before they have a force. (The run ended with status 8.)"""
    bodies = "bodyAdd(4.07, 0.31, 0.3, 0.1, 0.3, -5, 1, 1); bodyAdd(4.68, 0.31, 0.3, 10, -0.5, 5, 1, 1);"
    freefem_text(scene(bodies), "-mesh", box, "-dt", 0.05, "-tend", 0.1, "-every", 0, "-budget", 1, "-out", tmp_path / "run")
    assert len(RunFolder(tmp_path / "run").table("budget")["t"]) > 1


ANSWERED = """macro caseStep() {
    int[int] I(1), J(1);
    real[int] C(1), room(flowNq), part(flowNq);
    [I, J, C] = flowBX; C = abs(C);
    matrix X = [I, J, C]; X.resize(flowNq, flowNw);
    [I, J, C] = flowBY; C = abs(C);
    matrix Y = [I, J, C]; Y.resize(flowNq, flowNw);
    room = X*rigidMaskU; part = Y*rigidMaskV; room += part;
    real least = 1e30;
    for (int k = 0; k < gapWho.n; ++k) if (gapOut[k] > 0) least = min(least, room[gapAt[k]]);
    cout << "ANSWERED " << gapN << " " << least << endl;
} // EOM"""


@pytest.mark.parametrize("place", [(4, 4, 0.4), (4.07, 4.04, 0.4), (4, 4.1, 0.8)])
def test_what_a_gap_displaces_goes_where_a_velocity_answers(place, box, freefem_text, tmp_path):
    """Vertices within a body whose only nodes of the fluid are other vertices took a part: their pressure grew for a hundred steps,
    and bore up to two thirds of the pressure force on two disks."""
    x, y, angle = place
    dx, dy = 1.06 * np.cos(angle), 1.06 * np.sin(angle)
    text = scene(f"bodyAdd({x - dx}, {y - dy}, 1, 2, 0, 0, 0, 1); bodyAdd({x + dx}, {y + dy}, 1, 2, 0, 0, 0, 1);", ANSWERED,
        gravity=0)
    done = freefem_text(standard_alone(text), "-mesh", box, "-dt", 0.1, "-tend", 0.1, "-every", 0, "-out", tmp_path / "run")
    closed, least = next(line for line in done.stdout.splitlines() if line.startswith("ANSWERED")).split()[1:]
    assert int(closed) > 4 and float(least) > 1e-3
