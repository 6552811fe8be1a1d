"""What contacts keep from step to step: lists of near pairs, pairs that need no search, impulses. They change the computing time and
nothing else."""
import pytest

from tests.tables import rows

HEAD = """
include "lib/contact/contact.idp"
optCase("kept", "test");
contactDeclare();
cout.precision(17);
randinit(SEED);
func real far(real ax, real ay, int s) { // from a wall
    real tx = contactSX2[s] - contactSX1[s], ty = contactSY2[s] - contactSY1[s], c = max(0., min(1., ((ax - contactSX1[s])*tx + (ay - contactSY1[s])*ty)/max(tx*tx + ty*ty, 1e-300)));
    return sqrt((ax - contactSX1[s] - c*tx)^2 + (ay - contactSY1[s] - c*ty)^2);
}
"""
LIST = HEAD + """
optEnd();
int n = 60;
real reach = 0, worst = 0;
real[int] px(n), py(n), r(n), lot(3);
int[int] id = 0:n - 1;
for (int k = 0; k < n; ++k) { px[k] = randreal1(); py[k] = randreal1(); r[k] = 0.01 + 0.02*randreal1(); }
contactWallSegment(0.1, 0.2, 0.9, 0.3); contactWallSegment(0.5, 0.9, 0.5, 0.5);
for (int step = 0; step < 150; ++step) {
    int what = int(12*randreal1());
    reach = 0.04*randreal1();
    if (what < 6) for (int k = 0; k < n; ++k) { px[k] += 0.002*(randreal1() - 0.5); py[k] += 0.002*(randreal1() - 0.5); }
    if (what == 6) { px[7] += 0.1*(randreal1() - 0.5); py[11] = randreal1(); }
    if (what == 7) r[int(0.9*n)] *= 0.8 + 0.6*randreal1();
    if (what == 8) { real keep = px[3]; px[3] = px[4]; px[4] = keep; keep = py[3]; py[3] = py[4]; py[4] = keep; keep = r[3]; r[3] = r[4]; r[4] = keep; int name = id[3]; id[3] = id[4]; id[4] = name; }
    if (what == 9) { real dx0 = 0.1*(randreal1() - 0.5), dy0 = 0.1*(randreal1() - 0.5); contactWallVelocity(0, dx0, 0); contactWallVelocity(1, 0, dy0); contactWallsMove(1); }
    if (what == 10) { contactWallsKeep(1 + (step % 2)); contactWallSegment(randreal1(), randreal1(), randreal1(), randreal1()); }
    contactUpdate(px, py, r, id, reach);
    int pairs = 0, walls = 0;
    for (int i = 0; i < n; ++i) for (int j = i + 1; j < n; ++j) pairs += sqrt((px[i] - px[j])^2 + (py[i] - py[j])^2) - r[i] - r[j] < reach;
    for (int i = 0; i < n; ++i) for (int s = 0; s < contactSN; ++s) walls += far(px[i], py[i], s) - r[i] < reach;
    cout << "count " << contactPairs << " " << pairs << " " << contactN - contactPairs << " " << walls << endl;
}
"""


@pytest.mark.parametrize("seed", [1, 2])
def test_a_list_that_is_kept_holds_what_a_double_loop_finds(freefem_text, seed):
    """Disks go on a little or far, grow, change places, walls move, come and go: the list is old where it may be, and made anew
    where it must be."""
    found = rows(freefem_text(LIST.replace("SEED", str(seed))).stdout, "count")
    assert len(found) == 150 and found[:, 1].sum() > 2000 and found[:, 3].sum() > 100
    assert (found[:, 0] == found[:, 1]).all() and (found[:, 2] == found[:, 3]).all()


STEPS = HEAD + """
string states = optFile("-states", "", "places and velocities before each projection: written, or read where nothing is kept");
int fresh = optFlag("-fresh", 0, "1: keeps nothing from step to step");
optEnd();
int n = 9, held = 2, ballistic = contactForm == "ballistic";
real dt = 0.1, size = SIZE;
real[int] px(n), py(n), r(n), mass(n), u(n), v(n), gx(n), gy(n), nextX(n), nextY(n), walls(6);
int[int] id = 0:n - 1;
for (int k = 0; k < n; ++k) { px[k] = 0.9*size*((k % 3) - 1); py[k] = 0.9*size*((k/3) - 1); r[k] = 0.3 + 0.5*randreal1(); u[k] = randreal1() - 0.5; v[k] = randreal1() - 0.5; }
mass = r .* r;
mass[held] = -1;
gx = 0.; gy = 0.;
contactWallSegment(-1.5*size, -1.5*size, 1.5*size, -1.5*size); contactWallSegment(1.5*size, 1.5*size, -1.5*size, 1.5*size); contactWallSegment(-1.5*size, 1.5*size, -1.5*size, -1.5*size); contactWallSegment(1.5*size, -1.5*size, 1.5*size, 1.5*size);
contactWallSegment(0.4*size, 0.4*size, 0.5*size, 0.45*size);
if (ballistic) { gy = -0.4; gx = 0.3; gx[held] = 0; gy[held] = 0; contactGammaX.resize(n) = 1.*gx; contactGammaY.resize(n) = 1.*gy; }
{ ofstream f(states + (fresh ? "_not" : "")); f << "" << endl; }
ifstream old(states);
for (int step = 0; step < 250; ++step) {
    int what = int(30*randreal1()), who = int(n*randreal1());
    if (what < 2 && who != held) { u[who] = 3*(randreal1() - 0.5); v[who] = 3*(randreal1() - 0.5); }
    if (what == 2) { u[held] = 0.3*(randreal1() - 0.5); v[held] = 0.3*(randreal1() - 0.5); }
    if (what == 3) contactWallVelocity(4, 0.6*(randreal1() - 0.5), 0.6*(randreal1() - 0.5));
    if (what == 4) contactWallVelocity(4, 0, 0);
    if (fresh) {
        old >> px; old >> py; old >> u; old >> v; old >> walls;
        contactSX1[4] = walls[0]; contactSY1[4] = walls[1]; contactSX2[4] = walls[2]; contactSY2[4] = walls[3]; contactSU[4] = walls[4]; contactSV[4] = walls[5];
        contactListRange = -1; contactIdleRoom = -1; contactMemory.resize(0);
    } else {
        walls = [contactSX1[4], contactSY1[4], contactSX2[4], contactSY2[4], contactSU[4], contactSV[4]];
        ofstream f(states, append);
        f.precision(17);
        f << px << endl << py << endl << u << endl << v << endl << walls << endl;
    }
    contactProject(px, py, r, id, mass, u, v, dt);
    real least = 1e30;
    nextX = px + dt*u; nextY = py + dt*v;
    if (ballistic) { nextX += 0.5*dt*dt*gx; nextY += 0.5*dt*dt*gy; }
    contactWallsMove(dt);
    for (int i = 0; i < n; ++i) for (int j = i + 1; j < n; ++j) least = min(least, sqrt((nextX[i] - nextX[j])^2 + (nextY[i] - nextY[j])^2) - r[i] - r[j]);
    for (int i = 0; i < n; ++i) for (int s = 0; s < contactSN; ++s) if (mass[i] > 0) least = min(least, far(nextX[i], nextY[i], s) - r[i]);
    cout << "step " << contactLeast() << " " << least << " " << (contactIdleRoom >= 0);
    for (int k = 0; k < n; ++k) cout << " " << u[k] << " " << v[k];
    cout << endl;
    px = nextX; py = nextY;
    if (ballistic) { u += dt*gx; v += dt*gy; }
    if (step % 40 == 39) { gx *= -1.; gy *= -1.; if (ballistic) { contactGammaX = gx; contactGammaY = gy; } }
}
"""


@pytest.mark.parametrize("form", ["linear", "ballistic"])
@pytest.mark.parametrize("size", [4, 40])
def test_what_is_kept_between_steps_changes_no_motion(freefem_text, tmp_path, form, size):
    """Disks that fly about, one held, a wall that moves and stops; and each projection by itself, which knows nothing of the steps
    before. The least gap that is told is the true one or less where it is short."""
    text = STEPS.replace("SEED", "5").replace("SIZE", str(size))
    kept, alone = (rows(freefem_text(text, "-contact-form", form, "-states", tmp_path / "states", "-fresh", fresh).stdout, "step")
        for fresh in (0, 1))
    assert len(kept) == 250 and kept[:, 3:] == pytest.approx(alone[:, 3:], abs=1e-7)
    short = kept[:, 1] < 0.3
    assert (kept[short, 0] <= kept[short, 1] + 1e-9).all() and kept[:, 1].min() > -1e-8 and (size == 40 or short.sum() > 30)


APART = """
include "lib/contact/contact.idp"
optCase("apart", "what meets after many steps in which nobody could");
contactDeclare();
optEnd();
int walls = {walls};
if (walls) contactWallSegment({wall});
real[int] px = [{place[0]}, {far}], py = [{place[1]}, {far}], r = [1., 1.], mass = [1., 1.], u = [{speed[0]}, {other[0]}], v = [{speed[1]}, {other[1]}];
int[int] id = [0, 1];
int idle = 0;
real least = 1e30;
for (int step = 0; step < 160; ++step) {{
    if (step == 20 && walls == 2) contactWallVelocity(0, {push});
    idle += contactIdle(px, py, r, id, u, v, 0.1);
    contactProject(px, py, r, id, mass, u, v, 0.1);
    px += 0.1*u; py += 0.1*v;
    contactWallsMove(0.1);
    if (walls) least = min(least, {gap} - 1.);
    else least = min(least, sqrt((px[0] - px[1])^2 + (py[0] - py[1])^2) - 2);
}}
cout << "APART " << idle << " " << least << endl;
"""
MEETINGS = {
    "disks along x": dict(place=(-8, 0), speed=(1, 0), far=0), "disks along y": dict(place=(0, -8), speed=(0, 1), far=0),
        "disks aslant": dict(place=(6, -6), speed=(-0.7, 0.7), far=0),
    "both along x": dict(place=(-6, 0), speed=(1, 0), other=(-1, 0), far=0), "both along y": dict(place=(0, -6), speed=(0, 1),
        other=(0, -1), far=0),
    "a floor": dict(place=(0, 8), speed=(0, -1), wall="-20, 0, 20, 0", gap="py[0]"), "a wall": dict(place=(8, 0), speed=(-1, 0),
        wall="0, -20, 0, 20", gap="px[0]"),
    "a floor that rises": dict(place=(0, 8), speed=(0, 0), wall="-20, 0, 20, 0", gap="py[0] - contactSY1[0]", walls=2, push="0, 1"),
}


@pytest.mark.parametrize("meeting", MEETINGS)
def test_what_could_not_meet_for_many_steps_is_looked_after_in_time(meeting, freefem_text):
    """From whichever side they come, and from when a wall begins to move."""
    words = dict(far=1000, other=(0, 0), walls=int("wall" in MEETINGS[meeting]), wall="0, 0, 1, 1", gap="0",
        push="0, 0") | MEETINGS[meeting]
    idle, least = map(float, freefem_text(APART.format(**words)).stdout.split("APART")[1].split()[:2])
    assert idle > 10 and abs(least) < 1e-6  # they meet, and no more than that
