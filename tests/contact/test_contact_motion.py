"""Disks in motion: walls, corners, a ramp, moving walls, heaps; the search; restarts."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tools.base.tables import read_table


@pytest.fixture
def run_scene(freefem_text, tmp_path):
    """Runs a scene; returns (particles as a dict id -> columns, folder)."""

    def run(bodies, walls="", gravity=-9.81, more="", name="run", **options):
        text = CONTACTS.format(bodies=bodies, walls=walls, gravity=gravity, more=more)
        words = [w for key, value in options.items() for w in ("-" + key.replace("_", "-"), value)]
        freefem_text(text, "-out", tmp_path / name, *words)
        table = read_table(tmp_path / name / "particles.csv")
        ids = np.unique(table["id"])
        return {int(k): {c: np.asarray(v)[table["id"] == k] for c, v in table.items()} for k in ids}, tmp_path / name

    return run


def test_a_ball_comes_to_rest_in_a_concave_corner_without_overlap(run_scene):
    walls = "contactWallSegment(-1, 1, 0, 0); contactWallSegment(0, 0, 1, 2);"
    disks, folder = run_scene("bodyDisk(-0.3, 0.9, 0.1, 1); bodyDisk(0.1, 1.2, 0.05, 1);", walls, dt=0.01, tend=4)
    motion = read_table(folder / "motion.csv")
    assert min(motion["worst_gap"]) > -1e-9
    assert motion["kinetic_energy"][-1] < 1e-12 * max(motion["kinetic_energy"])
    # The larger disk touches both walls: its centre lies on the lines 0.1 above them.
    x, y = disks[0]["x"][-1], disks[0]["y"][-1]
    touch = np.linalg.solve([[1, 1], [-2, 1]], [0.1 * np.sqrt(2), 0.1 * np.sqrt(5)])
    np.testing.assert_allclose([x, y], touch, atol=1e-9)


def test_a_ball_on_a_convex_corner_rounds_it(run_scene):
    walls = "contactWallSegment(-1, 0, 0, 0); contactWallSegment(0, 0, 0, -1);"
    disks, _ = run_scene("bodyAdd(-0.05, 0.1, 0.1, 1, 0.3, 0, 0, 1);", walls, dt=0.001, tend=0.6)
    distance = np.hypot(np.maximum(disks[0]["x"], 0), np.maximum(disks[0]["y"], 0))
    assert distance.min() > 0.1 - 1e-9
    assert disks[0]["x"][-1] > 0.05 and disks[0]["y"][-1] < 0


def test_nothing_tunnels_through_a_thin_wall(run_scene):
    """50 radii a step against a wall, its end, and between two walls."""
    walls = "contactWallSegment(0, -1, 0, 1); contactWallSegment(0.05, 1, 0.05, -1);"
    bodies = "bodyAdd(-2, 0.3, 0.01, 1, 50, 0, 0, 1); bodyAdd(-2, 1.005, 0.01, 1, 50, 0, 0, 1); bodyAdd(0.025, 0, 0.01, 1, -50, 3, 0, 1);"
    disks, folder = run_scene(bodies, walls, gravity=0, dt=0.01, tend=0.2)
    assert disks[0]["x"].max() == pytest.approx(-0.01, abs=1e-9)
    assert disks[1]["x"][4] < -0.008 and disks[1]["v"][5] > 1  # the end of the wall turns it upwards
    assert 0.01 - 1e-9 < disks[2]["x"].min() and disks[2]["x"].max() < 0.04 + 1e-9
    assert min(read_table(folder / "motion.csv")["worst_gap"]) > -1e-9


def ramp_error(run_scene, dt, form):
    """A ball slides from rest down a smooth ramp of 45 degrees and flies off: greatest
    distance from the exact path within 0.8 s."""
    g, r, length = 9.81, 0.05, 0.5
    walls = f"contactWallSegment({-length * np.sqrt(0.5)}, {length * np.sqrt(0.5)}, 0, 0);"
    s = np.sqrt(0.5)
    start = np.array([-length * s + r * s, length * s + r * s])
    slide = np.sqrt(2 * length / (g * s))  # until the contact reaches the end of the ramp
    disks, _ = run_scene(f"bodyDisk({start[0]:.17g}, {start[1]:.17g}, {r}, 1);", walls, dt=dt, tend=0.8, contact_form=form,
        name=f"ramp_{form}_{dt}")
    t, x, y = (disks[0][c] for c in "txy")
    speed = g * s * slide
    # Beyond the edge the ball is free at once: the ramp was a tangent of its flight.
    free = t > slide
    fly = t - slide
    exact_x = np.where(free, r * s + speed * s * fly, start[0] + 0.5 * g * s * t**2 * s)
    exact_y = np.where(free, r * s - speed * s * fly - 0.5 * g * fly**2, start[1] - 0.5 * g * s * t**2 * s)
    return np.hypot(x - exact_x, y - exact_y).max()


def test_a_ball_off_a_ramp_converges_with_the_time_step(run_scene):
    linear = [ramp_error(run_scene, dt, "linear") for dt in (0.02, 0.01, 0.005)]
    assert 1.7 < linear[0] / linear[1] < 2.3 and 1.7 < linear[1] / linear[2] < 2.3  # first order
    ballistic = [ramp_error(run_scene, dt, "ballistic") for dt in (0.02, 0.01, 0.005)]
    # The slide itself is exact; what is left is made in the step across the edge.
    assert all(b < a for a, b in zip(linear, ballistic)), (linear, ballistic)
    assert ballistic[2] < 0.6 * ballistic[0], (linear, ballistic)


def test_glancing_disks_keep_their_speed_along_each_other(run_scene):
    """24 disks of radius 0.5 and speed 1 hit held ones at equal offsets, in thirds of a step, with moves of 0.2 radii. What is left
    of the speed is the part along each other, the offset over the sum of the radii. Normals of the middle of the step keep 4 % too
    much."""
    offset, step = np.linspace(0.05, 0.95, 24), 0.1
    bodies = "".join(f"bodyHeld(bodyDisk(0, {10 * k}, 0.5, 1)); bodyAdd({-2 - step * (k % 3) / 3!r}, {10 * k + float(b)!r}, 0.5, 1, 1, 0, 0, 1);"
                     for k, b in enumerate(offset))
    disks, _ = run_scene(bodies, gravity=0, dt=step, tend=4, every=4)
    left = np.array([np.hypot(disks[2 * k + 1]["u"][-1], disks[2 * k + 1]["v"][-1]) for k in range(24)])
    assert np.abs(left / offset - 1).max() < 0.006 and np.abs(left / offset - 1).mean() < 0.002


def test_a_moving_wall_pushes_and_a_moving_disk_too(run_scene):
    more = "macro caseStep() if (timeNow == 0) contactWallVelocity(0, 0.5, 0); // EOM"
    bodies = "bodyDisk(0.2, 0, 0.05, 1); bodyDisk(0.35, 0, 0.05, 2); bodyAdd(2, 0, 0.1, 1, -0.2, 0, 0, 0);"
    disks, folder = run_scene(bodies, "contactWallSegment(0, -1, 0, 1);", gravity=0, more=more, dt=0.01, tend=1)
    assert disks[0]["u"][-1] == pytest.approx(0.5, abs=1e-9) and disks[1]["u"][-1] == pytest.approx(0.5, abs=1e-9)
    assert disks[0]["x"][-1] == pytest.approx(0.5 + 0.05, abs=1e-8)
    assert disks[2]["u"][-1] == -0.2 and disks[2]["x"][-1] == pytest.approx(1.8)
    assert min(read_table(folder / "motion.csv")["worst_gap"]) > -1e-9


def test_falling_disks_lose_energy_only_and_balance_their_momentum(freefem, tmp_path):
    done = freefem("cases/falling_particles.edp", "-tend", 24, "-dt", 0.04, "-every", 0.04, "-out", tmp_path / "run")
    assert "finished at t = 24 s" in done.stdout
    motion = {key: np.asarray(value) for key, value in read_table(tmp_path / "run" / "motion.csv").items()}
    energy, peak = motion["kinetic_energy"] + motion["potential_energy"], motion["kinetic_energy"].max()
    assert np.diff(energy).max() < 1e-10 * peak
    assert motion["worst_gap"].min() > -1e-10 * 0.02
    assert motion["momentum_error"].max() < 1e-12 * np.hypot(motion["momentum_x"], motion["momentum_y"]).max()
    assert motion["kinetic_energy"][-1] < 1e-2 * peak
    contacts = read_table(tmp_path / "run" / "contacts.csv")
    assert min(contacts["impulse"]) > 0 and np.allclose(np.hypot(contacts["nx"], contacts["ny"]), 1)
    # At the end the floor carries the weight.
    last = np.asarray(contacts["t"]) > 20
    floor = last & (np.asarray(contacts["j"]) == -1)
    particles = read_table(tmp_path / "run" / "particles.csv")
    weight = 100 * np.pi * (np.asarray(particles["radius"])[:50]**2).sum() * 0.02
    assert np.asarray(contacts["impulse"])[floor].sum() / 4 == pytest.approx(weight, rel=0.02)


@pytest.mark.slow
def test_falling_disks_come_to_rest(freefem, tmp_path):
    freefem("cases/falling_particles.edp", "-out", tmp_path / "run")
    motion = read_table(tmp_path / "run" / "motion.csv")
    assert motion["kinetic_energy"][-1] < 1e-8 * max(motion["kinetic_energy"])
    assert min(motion["worst_gap"]) > -1e-10 * 0.02


def test_an_hourglass_of_few_disks(freefem, tmp_path):
    freefem("cases/hourglass.edp", "-number", 150, "-radius", 0.02, "-neck", 0.16, "-tend", 1, "-out", tmp_path / "run")
    motion = read_table(tmp_path / "run" / "motion.csv")
    assert min(motion["worst_gap"]) > -1.1e-5 * 0.016
    particles = read_table(tmp_path / "run" / "particles.csv")
    last = np.asarray(particles["t"]) > 0.999
    x, y = np.asarray(particles["x"])[last], np.asarray(particles["y"])[last]
    assert (np.abs(x) < 0.35).all() and (y > -0.8).all()
    assert (y < 0).sum() > 20


SEARCH = """
include "lib/contact/contact.idp"
optCase("search", "test");
contactDeclare(); optEnd();
int n = {n};
randinit({seed});
real[int] px(n), py(n), r(n);
for (int k = 0; k < n; ++k) {{ px[k] = {px}; py[k] = {py}; r[k] = {r}; }}
contactWallSegment(0.2, 0.3, 0.9, 0.4); contactWallSegment(0.5, 0.5, 0.5, 0.5);
int[int] id = 0:n - 1;
contactUpdate(px, py, r, id, {reach});
int pairs = 0, walls = 0;
for (int k = 0; k < contactN; ++k) if (contactJ[k] >= 0) pairs++; else walls++;
int allPairs = 0, allWalls = 0;
real worst = 0;
for (int i = 0; i < n; ++i) {{
    for (int j = i + 1; j < n; ++j) if (sqrt((px[i] - px[j])^2 + (py[i] - py[j])^2) - r[i] - r[j] < {reach}) allPairs++;
    for (int s = 0; s < 2; ++s) {{
        real tx = contactSX2[s] - contactSX1[s], ty = contactSY2[s] - contactSY1[s];
        real a = max(0., min(1., ((px[i] - contactSX1[s])*tx + (py[i] - contactSY1[s])*ty)/max(tx*tx + ty*ty, 1e-300)));
        if (sqrt((px[i] - contactSX1[s] - a*tx)^2 + (py[i] - contactSY1[s] - a*ty)^2) - r[i] < {reach}) allWalls++;
    }}
}}
cout << "counts " << pairs << " " << allPairs << " " << walls << " " << allWalls << endl;
"""


@pytest.mark.parametrize("px, py, r, reach", [
    ("randreal1()", "randreal1()", "0.02", 0.01),
    ("randreal1()", "randreal1()", "0.001*exp(4.6*randreal1())", 0.002),   # 100 : 1
    ("randreal1()", "randreal1()", "(k % 60 == 0 ? 0.1 : 0.001)", 0.001),
    ("randreal1()", "1e7*randreal1()", "0.02", 0.01),                      # far apart
    ("1e6*(k % 3) + randreal1()", "1e6*(k % 5) + randreal1()", "0.02", 0.2),
    ("(k % 30)*0.04", "(k/30)*0.04", "0.02", 0.000001),                    # a lattice that just touches
])
def test_the_search_finds_what_a_double_loop_finds(freefem_text, px, py, r, reach):
    for n in (1, 2, 700):
        done = freefem_text(SEARCH.format(n=n, seed=n, px=px, py=py, r=r, reach=reach))
        pairs, all_pairs, walls, all_walls = map(int, done.stdout.split("counts ")[1].split()[:4])
        assert (pairs, walls) == (all_pairs, all_walls)


def test_the_search_holds_in_many_mixtures(freefem_text):
    """Boxes and bunches of all shapes: nothing out of bounds, as many pairs both ways round."""
    done = freefem_text("""
include "lib/contact/search.idp"
int n = 800, unequal = 0;
real[int] px(n), py(n), r(n);
for (int trial = 0; trial < 60; ++trial) {
    randinit(trial);
    real stretch = exp(6*randreal1()), share = randreal1();
    for (int k = 0; k < n; ++k) {
        px[k] = randreal1(); py[k] = stretch*randreal1(); r[k] = 0.005*(randreal1() < share ? 1 : 2 + randreal1());
        if (r[k] > 0.0075) { px[k] = 0.3 + 0.1*px[k]; py[k] = 0.2 + 0.3*py[k]; }
    }
    contactSearch(px, py, r, 0.001, 0);
    int first = contactNearN;
    contactSearch(py, px, r, 0.001, 0);
    if (contactNearN != first) unequal++;
}
cout << "unequal " << unequal << endl;
""")
    assert "unequal 0" in done.stdout


def test_the_list_of_near_disks_stays_short_where_they_move_far(freefem_text):
    """A crowd that a stream carries by forty radii a step: its list held half of all pairs, and a stream of 20,000 spheres took 2.2
    GB."""
    out = freefem_text("""
include "lib/contact/contact.idp"
optCase("far", "a crowd that moves far in a step");
contactDeclare();
optEnd();
int side = 30, n = side^2;
real[int] px(n), py(n), r(n), mass(n), u(n), v(n);
int[int] id = 0:n - 1;
for (int k = 0; k < n; ++k) { px[k] = 30*(k % side); py[k] = 30*(k/side); }
r = 1.; mass = 1.; u = 40.; v = 0.;
contactProject(px, py, r, id, mass, u, v, 1.);
cout << "near " << contactNearN << " least " << contactWorstGap << endl;
""").stdout
    words = next(line for line in out.splitlines() if line.startswith("near ")).split()
    assert int(words[1]) < 900 and 2 < float(words[3]) <= 28  # nobody can meet: a lower bound of the gap, which is 28


def test_a_restart_with_changed_places_goes_on_as_before(freefem_text, tmp_path):
    """Two runs, one saved and loaded in the middle with the disks in another order, agree to
    the last digit; impulses follow the ids."""
    text = """
include "lib/contact/contact.idp"
optCase("restart", "test");
contactDeclare(); optEnd();
int n = 30;
randinit(3);
real[int] px(n), py(n), r(n), mass(n), u(n), v(n);
for (int k = 0; k < n; ++k) { px[k] = 0.1*(k % 6) + 0.05 + 0.005*randreal1(); py[k] = 0.1*(k/6) + 0.06; r[k] = 0.03 + 0.014*randreal1(); }
mass = r .* r; u = 0.; v = 0.;
int[int] id = 0:n - 1;
contactWallSegment(0, 0, 0.6, 0); contactWallSegment(0, 0, 0, 2); contactWallSegment(0.6, 0, 0.6, 2);
for (int step = 0; step < 60; ++step) {
    v -= 0.02;
    contactProject(px, py, r, id, mass, u, v, 0.01);
    px += 0.01*u; py += 0.01*v;
    if (step == 39) {
        contactSave("STATE");
        RELOAD
    }
}
{ ofstream f("OUT"); f.precision(15); for (int k = 0; k < n; ++k) f << id[k] << " " << px[k] << " " << py[k] << " " << contactNearLoad.sum << endl; }
cout << "steps " << contactIterations << endl;
"""
    turn = """contactMemory.resize(0); contactNearLoad = 0.; contactLoad("STATE");
        int[int] other = 0:n - 1; for (int k = 0; k < n; ++k) other[k] = n - 1 - k;
        real[int] t1 = px(other), t2 = py(other), t3 = r(other), t4 = mass(other), t5 = u(other), t6 = v(other);
        int[int] t7 = id(other);
        px = t1; py = t2; r = t3; mass = t4; u = t5; v = t6; id = t7;"""
    results = []
    for name, change in (("a", "1;"), ("b", turn), ("c", 'contactMemory.resize(0); contactNearLoad = 0.; contactLoad("STATE");')):
        freefem_text(text.replace("RELOAD", change).replace("OUT", str(tmp_path / name)).replace("STATE",
            str(tmp_path / ("s" + name))))
        rows = np.loadtxt(tmp_path / name)
        results.append(rows[np.argsort(rows[:, 0])])
    np.testing.assert_array_equal(results[0], results[2])
    np.testing.assert_allclose(results[0], results[1], atol=1e-9)


@pytest.mark.parametrize("walls, step, says", [
    ("contactWallSegment(0, log(-1.), 1, 0);", "", "its ends must be finite"),
    ("contactWallSegment(0, 0, 1, 0);", "contactWallVelocity(7, 0, 1);", "there is no such wall"),  # moved nothing, in silence
    # ended with status 0, its wall nowhere
    ("contactWallSegment(0, 0, 1, 0);", "contactWallVelocity(0, 0, log(-1.));", "is not finite"),
])
def test_walls_of_no_numbers_and_walls_that_there_are_not_are_refused(freefem_text, tmp_path, walls, step, says):
    done = freefem_text(f"""include "lib/core/output.idp"
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("walls", "a disk and a wall");
real gravityX = 0, gravityY = -1;
macro caseParticles() bodyDisk(0.5, 0.5, 0.1, 1); // EOM
macro caseWalls() {walls} // EOM
macro caseStep() {step} // EOM
include "scripts/contacts.edp"
""", "-tend", 0.05, "-dt", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_walls_from_a_mesh_are_merged(freefem_text):
    done = freefem_text("""
include "lib/contact/walls.idp"
mesh Th = square(13, 7);
int[int] three = [1, 2, 4], all = [1, 2, 3, 4], none(0);
int made3 = contactWallsFromMesh(Th, three);
contactWallsKeep(0);
int made4 = contactWallsFromMesh(Th, all), made0 = contactWallsFromMesh(Th, none);
cout << "made " << made3 << " " << made4 << " " << made0 << " length "
     << abs(contactSX2[0] - contactSX1[0]) + abs(contactSY2[0] - contactSY1[0]) << endl;
border ring(t = 0, 2*pi) { x = cos(t); y = sin(t); }
mesh disk = buildmesh(ring(40));
contactWallsKeep(0);
int[int] one = [1];
for (int k = 0; k < disk.nbe; ++k) one[0] = disk.be(k).label;
cout << "ring " << contactWallsFromMesh(disk, one) << endl;
""")
    assert "made 3 4 0 length 1" in done.stdout and "ring 40" in done.stdout


def test_a_heap_of_equal_disks_comes_to_rest_at_a_tight_residual(freefem, tmp_path):
    """Lattices with more contacts than needed, whose gaps agree only to rounding."""
    freefem("cases/falling_particles.edp", "-rmin", "0.06", "-rmax", "0.06", "-gravity", "9.81", "-dt", "0.005", "-tend", "1",
        "-out", tmp_path / "run")
    motion = read_table(tmp_path / "run" / "motion.csv")
    assert motion["kinetic_energy"][-1] < 1e-8 * motion["kinetic_energy"].max()
    assert motion["worst_gap"].min() > -1e-10 * 0.06
    assert motion["residual"].max() <= 1e-11


GATE = """
include "lib/case.idp"
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("gate", "a scene of tests/contact/test_contact_motion.py");
optDefault("-dt", "0.01");
real gravityX = 0, gravityY = -1;
macro caseParticles() bodyDisk(0, 0.1, 0.1, 1); // EOM
macro caseWalls() { contactWallSegment(-1, -1, 1, -1); contactWallSegment(-0.5, 0, 0.5, 0); } // EOM
macro caseStep() contactWallVelocity(1, driveStep > 10, 0); // EOM
include "scripts/contacts.edp"
"""


def test_walls_that_move_are_written_where_they_are(freefem_text, tmp_path):
    from tools.plot.contact_run import ContactRun
    freefem_text(GATE, "-tend", 0.5, "-every", 0.1, "-out", tmp_path / "run")
    run = ContactRun(tmp_path / "run")
    np.testing.assert_allclose(run.walls_at(0.0), run.walls)
    moved = run.walls_at(0.4)
    np.testing.assert_allclose(moved[0], run.walls[0])
    np.testing.assert_allclose(moved[1], run.walls[1] + [0.3, 0], atol=1e-9)


def test_contacts_end_at_the_end(freefem_text, tmp_path):
    freefem_text(GATE, "-dt", 0.03, "-tend", 0.1, "-out", tmp_path / "run")
    from tools.base.tables import read_table
    assert read_table(tmp_path / "run/motion.csv")["t"][-1] == pytest.approx(0.1, rel=1e-12)


LEAST = """
include "lib/contact/contact.idp"
optCase("least", "a few disks of different speeds above a floor");
contactDeclare();
optEnd();
randinit(1);
contactWallSegment(-3, -3, 40, -3);
for (int scene = 0; scene < 30; ++scene) {
    int n = 2 + int(5*randreal1()), quick = int(0.999*n*randreal1());
    real[int] px(n), py(n), r(n), mass(n), u(n), v(n);
    int[int] id = 0:n - 1;
    contactListRange = -1; contactIdleRoom = -1;
    for (int k = 0; k < n; ++k) { px[k] = 7*k + 2*randreal1(); py[k] = 6*randreal1(); r[k] = 0.3 + 0.7*randreal1(); u[k] = 0.3*(randreal1() - 0.5); v[k] = 0.3*(randreal1() - 0.5); mass[k] = 1; }
    if (scene % 3 > 0) { u[quick] = 5*(randreal1() - 0.5); v[quick] = 3*(randreal1() - 0.5); }
    real dt = 0.3*randreal1();
    for (int step = 0; step < 12; ++step) {
        for (int k = 0; k < n; ++k) { u[k] += 0.1*(randreal1() - 0.5); v[k] += 0.1*(randreal1() - 0.5); }
        int found = contactProject(px, py, r, id, mass, u, v, dt);
        px += dt*u; py += dt*v;
        real least = 1e30;
        for (int k = 0; k < n; ++k) {
            for (int j = 0; j < k; ++j) least = min(least, sqrt((px[k] - px[j])^2 + (py[k] - py[j])^2) - r[k] - r[j]);
            least = min(least, sqrt(max(max(-3 - px[k], px[k] - 40), 0.)^2 + (py[k] + 3)^2) - r[k]);
        }
        cout << "LEAST " << found << " " << contactWorstGap << " " << least << endl;
    }
}
"""


def test_the_least_gap_that_is_told_is_never_above_the_true_one(freefem_text):
    """One fast disk far from a wall was in the list of near ones, two slow ones nearer to each other were not; a list that had been
    kept was taken for a new one."""
    rows = np.array([line.split()[1:] for line in freefem_text(LEAST).stdout.splitlines() if line.startswith("LEAST")], float)
    apart = rows[:, 0] == 0
    assert len(rows) == 360 and apart.sum() > 300
    assert (rows[:, 1] - rows[:, 2]).max() < 1e-5  # six digits
    assert np.median(rows[apart, 1] / rows[apart, 2]) > 0.05  # nor next to nothing
