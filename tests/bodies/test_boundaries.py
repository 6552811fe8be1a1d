"""Particles at boundaries of every kind: turning walls, outlets that are not on the right, inlets, seams, planes of symmetry; the
walls in a budget."""
import numpy as np
import pytest

from tests.conftest import standard_alone
from tests.scenes import PERIODIC, SEAM, case, ring, square
from tools.base.run_folder import RunFolder


def test_a_turning_cylinder_stops_a_disk(freefem_text, tmp_path):
    mesh = tmp_path / "ring.mesh"
    text = ring(mesh) + case("bodyDisk(0.01, 0.65, 0.12, 30);", walls="labelWall", moving="labelCylinder",
                             more="macro boundaryU() (-0.3*y) // EOM\nmacro boundaryV() (0.3*x) // EOM")
    text = text.replace("gravityY = -1", "gravityY = -5")
    freefem_text(text, "-mesh", mesh, "-film", 0, "-tend", 0.8, "-every", 0.02, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    chord = 0.4 * np.cos(np.pi / 24)
    distance = np.hypot(run.particles["x"], run.particles["y"])
    assert run.fluid["contacts"].max() >= 1 and distance.min() > chord + 0.12 - 1e-6
    assert distance.min() < 0.4 + 0.12 + 0.002


@pytest.mark.parametrize("bound, bodies, status, said", [
    (0.3, "bodyDisk(0.2, 0.5, 0.12, 3); bodyDisk(0.5, 0.5, 0.12, 3);", 5, "particle 1 at (0.5, 0.5) lies wholly beyond x = 0.3 "
        "(motionBound)"),
    (0.4, "bodyDisk(0.2, 0.5, 0.12, 3); bodyDisk(0.5, 0.5, 0.12, 3);", 0, ""),
    (-1, "queueAdd(0.5, 0.12, 3, 9);", 3, "a waiting particle enters at x = 0.126, wholly beyond x = -1 (motionBound)"),
])
def test_particles_that_would_be_taken_out_at_once_are_refused(bound, bodies, status, said, freefem_text, tmp_path):
    text = case(bodies, walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
        more="macro boundaryU() (0.01*4*y*(1 - y)) // EOM")
    done = freefem_text(text.replace("motionBound = 1e30", f"motionBound = {bound}"), "-tend", 0.01, "-out", tmp_path / "run",
        check=False)
    assert done.returncode == status and said in done.stderr and len(done.stderr.strip().splitlines()) == (status > 0)


def one_label(mesh):
    """A unit square with the label 3 on all sides."""
    return f'int[int] three = [3, 3, 3, 3];\nsavemesh(square(16, 16, label = three), "{mesh}");\n'


def drum(mesh, chords=42):
    """A circle with the label 3; of 42 chords one at the top and one at the bottom lie level."""
    return f'border c(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}\nsavemesh(buildmesh(c({chords})), "{mesh}");\n'


@pytest.mark.parametrize("make, u, v, refused", [
    (one_label, "-1.", "0.", True), (one_label, "1.", "1.", False), (one_label, "1. - 2*(x - 0.5)*(y - 0.5)", "0.", True),
    (drum, "1.", "0.", False), (drum, "-y", "x", False), (drum, "(x > 0 ? 0. : -y)", "(x > 0 ? 1. : x)", True),
])
def test_a_label_of_sides_that_let_through_and_sides_that_do_not_is_refused(make, u, v, refused, freefem_text, tmp_path):
    """The latter would let the particles through."""
    mesh = tmp_path / "domain.mesh"
    text = make(mesh) + case("bodyDisk(0.4, 0.4, 0.12, 3);", walls="", moving="3", more=f"macro boundaryU() ({u}) // EOM\nmacro "
        f"boundaryV() ({v}) // EOM")
    done = freefem_text(text, "-mesh", mesh, "-tend", 0.02, "-out", tmp_path / "run", check=False)
    assert done.returncode == (3 if refused else 0), done.stderr
    assert ("label 3 (flowMoving) has flow across some sides" in done.stderr) == refused


@pytest.mark.parametrize("place", ["0, 0", "0.05, 0.1"])
def test_a_disk_in_the_hole_of_a_ring_is_refused(place, freefem_text, tmp_path):
    mesh = tmp_path / "ring.mesh"
    done = freefem_text(ring(mesh) + case(f"bodyDisk({place}, 0.12, 30);", walls="labelWall, labelCylinder"), "-mesh", mesh,
        "-out", tmp_path / "run", check=False)
    assert (done.returncode == 5 and "particle 0 at (" in done.stderr
        and "lies outside the mesh, which reaches from x = " in done.stderr)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("side, x, y, pull", [("Bottom", 0.5, 0.3, (0, -20)), ("Top", 0.5, 0.7, (0, 20)), ("Right", 0.7, 0.5,
    (20, 0)), ("Left", 0.3, 0.5, (-20, 0))])
def test_a_disk_leaves_through_an_outlet_on_any_side(side, x, y, pull, freefem_text, tmp_path):
    walls = ", ".join(f"label{name}" for name in ("Left", "Right", "Bottom", "Top") if name != side)
    text = case(f"bodyDisk({x}, {y}, 0.12, 3);", walls=walls, outlet=f"label{side}").replace("gravityX = 0, gravityY = -1",
        f"gravityX = {pull[0]}, gravityY = {pull[1]}")
    freefem_text(text, "-tend", 0.6, "-every", 0, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.fluid["particles"][0] == 1 and run.fluid["particles"][-1] == 0
    assert run.open == ({"Left": 11, "Right": 12, "Bottom": 13, "Top": 14}[side],)  # drawn dashed
    assert list(run.table("exits")["label"]) == list(run.open)
    outside = max(np.abs(run.particles["x"] - 0.5).max(), np.abs(run.particles["y"] - 0.5).max())
    assert 0.5 < outside < 0.5 + 0.12 + 0.1  # not much further than wholly beyond the side


def test_a_waiting_particle_minds_the_disk_over_the_seam(freefem_text, tmp_path):
    for height in (0.1, 1.1):
        text = case(f"bodyAdd(0.14, {height}, 0.12, 1, 0, 0, 0, 0); queueAdd(0.95, 0.12, 1, 0.); queueAdd(0.5, 0.12, 1, 0.);",
                    walls="", moving="labelLeft", outlet="labelRight", more=SEAM, period=1).replace("gravityY = -1", "gravityY = 0")
        freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-tend", 0.03, "-every", 0, "-out", tmp_path / f"run{height}")
        last = RunFolder(tmp_path / f"run{height}")
        # the one that has room: the held one is no particle that counts, and the other waits
        assert last.fluid["particles"][-1] == 1 and last.fluid["worst_gap"].min() > 0


@pytest.mark.parametrize("height", [0.5, 0.03])
def test_a_disk_that_enters_over_a_seam_takes_the_motion_of_the_fluid(height, freefem_text, tmp_path):
    text = case(f"queueAdd({height}, 0.12, 1, 0.);", walls="", moving="labelLeft", outlet="labelRight", more=SEAM,
        period=1).replace("gravityY = -1", "gravityY = 0")
    freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-tend", 0.01, "-every", 0, "-out", tmp_path / "run")
    disk = RunFolder(tmp_path / "run").particles
    assert disk["u"][0] == pytest.approx(1, abs=1e-3) and disk["omega"][0] == pytest.approx(0, abs=1e-2)


DRAIN = "border hole(s = 0, 2*pi) { x = 0.5 + 0.15*cos(s); y = 0.5 + 0.15*sin(s); label = 2; }"


def test_a_disk_goes_down_a_drain_wherever_its_period_is_counted_from(freefem_text, tmp_path):
    """The outlet is a hole; a disk one period up goes with its image's centre, no earlier."""
    mesh, rows = tmp_path / "square.mesh", []
    for up in (0, 1):
        text = square(mesh, hole=DRAIN) + case(f"bodyDisk(0.5131, {0.8531 + up}, 0.1113, 4);", walls="labelLeft, labelRight",
            outlet="labelOutlet", more=PERIODIC, period=1)
        freefem_text(text.replace("gravityY = -1", "gravityY = -4"), "-mesh", mesh, "-tend", 0.8, "-every", 0, "-out",
            tmp_path / f"run{up}")
        run = RunFolder(tmp_path / f"run{up}")
        assert run.fluid["particles"][-1] == 0
        rows.append(run.particles["y"] - up)
    assert len(rows[0]) == len(rows[1]) and np.abs(rows[0] - rows[1]).max() < 1e-9


def test_an_inlet_elsewhere_is_refused(freefem_text, tmp_path):
    text = case("queueAdd(0.5, 0.12, 1, 0.);", walls="labelBottom, labelTop", moving="labelRight", outlet="labelLeft",
        more="macro boundaryU() -1. // EOM")
    done = freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "no inlet" in done.stderr and len(done.stderr.strip().splitlines()) == 1
    freefem_text(text.replace("queueAdd", "queueX = 1; queueDirection = -1; queueAdd"), "-tend", 0.01, "-out", tmp_path / "run")


def test_a_plane_of_symmetry_that_is_no_plane_is_refused(freefem_text, tmp_path):
    mesh = tmp_path / "ring.mesh"
    text = ring(mesh) + case("bodyDisk(0, 0.7, 0.12, 2);", walls="labelWall", slip="labelCylinder")
    done = freefem_text(text, "-mesh", mesh, "-tend", 0.01, "-out", tmp_path / "run", check=False)
    assert (done.returncode == 3 and "label 6" in done.stderr and "horizontal or upright" in done.stderr
        and len(done.stderr.strip().splitlines()) == 1)


@pytest.mark.parametrize("walls, slip, along, film", [("labelLeft, labelRight, labelBottom, labelTop", "", "y", 0),
    ("labelLeft, labelRight", "labelBottom, labelTop", "y", 1), ("labelBottom, labelTop", "labelLeft, labelRight", "x", 0)])
def test_momentum_holds_with_planes_of_symmetry_and_with_a_disk_that_lands(walls, slip, along, film, freefem_text, cell, tmp_path):
    """On the floor or plane, or on the film above it."""
    place, pull = ("0.5, 0.2", "gravityX = 0, gravityY = -4") if along == "y" else ("0.2, 0.5", "gravityX = -4, gravityY = 0")
    text = case(f"bodyDisk({place}, 0.12, 8.);", walls=walls, slip=slip).replace("gravityX = 0, gravityY = -1", pull)
    freefem_text(text, "-mesh", cell, "-film", film, "-tend", 1.2, "-budget", 1, "-every", 0.05, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    budget = run.table("budget")
    assert run.fluid["contacts"][-1] == 1 - film
    off = budget[f"momentum_{along}"] - budget[f"walls_{along}"] - budget[f"weight_{along}"]
    weight = 4 * 7 * np.pi * 0.12**2 * 1.2
    assert budget[f"weight_{along}"][-1] == pytest.approx(-weight, rel=1e-3)
    assert np.abs(off).max() < 0.02 * weight


def test_budgets_that_cannot_close_are_refused(freefem_text, tmp_path):
    for particles, more in (("bodyAdd(0.5, 0.5, 0.12, 2, 0, 0, 0, 0);", ""), ("bodyDisk(0.5, 0.5, 0.12, 2);",
        "macro flowForceX() 1. // EOM")):
        done = freefem_text(case(particles, more=more), "-budget", 1, "-tend", 0.01, "-out", tmp_path / "run", check=False)
        assert done.returncode == 3 and "-budget 1 is for" in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_large_ids_cost_nothing(freefem, tmp_path):
    disks = tmp_path / "disks.csv"
    disks.write_text("id,x,y,radius,density\n1000000000,0.5,2,0.15,1.2\n1999999999,1.5,2,0.15,1.2\n")
    freefem("cases/settling_disk.edp", "-particles", disks, "-tend", 0.004, "-checkpoint", 1, "-out", tmp_path / "run", timeout=20)
    assert set(RunFolder(tmp_path / "run").particles["id"]) == {0, 1000000000, 1999999999}
    assert sum(file.stat().st_size for file in (tmp_path / "run").iterdir()) < 2e7


def test_walls_are_written_so_that_contacts_can_name_them(freefem_text, tmp_path):
    freefem_text(case("bodyDisk(0.5, 0.12, 0.12, 2);"), "-tend", 0.05, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    wall = -1 - int(run.table("contacts")["j"][0])
    ends = [run.table("walls")[name][wall] for name in ("x1", "y1", "x2", "y2")]
    assert sorted(ends[::2]) == [0, 1] and ends[1::2] == [0, 0]  # the floor


@pytest.mark.parametrize("start, queue", [("bodyDisk(0.51, 0.7, 0.12, 3);", "queueAt(0.51, 0.7, 0.12, 3, DUE);"),
    ("bodyEllipse(0.51, 0.7, 0.12, 0.08, 0.6, 3);", "queueEllipseAt(0.51, 0.7, 0.12, 0.08, 0.6, 3, DUE);")])
def test_a_particle_let_go_later_falls_like_one_let_go_at_the_start(start, queue, freefem_text, cell, tmp_path):
    """From its first row on, at a place in a closed box (4 % slower while the pressure of its weight came late); a second one at
    the same place waits until there is room."""
    falls = []
    for name, body in (("start", start), ("later", queue.replace("DUE", "0.05") + queue.replace("DUE", "0.06"))):
        freefem_text(case(body, gravity=-20), "-mesh", cell, "-dt", 0.005, "-cfl", 0, "-tend", 0.6, "-every", 0, "-out",
            tmp_path / name)
        rows = RunFolder(tmp_path / name).particles
        falls.append({column: rows[column][rows["id"] == 0] for column in ("t", "y", "v", "theta")})
    entries = RunFolder(tmp_path / "later").table("entries")
    assert entries["t"][0] == pytest.approx(0.055, abs=1e-9) and (entries["x"][0], entries["y"][0]) == (0.51, 0.7)
    start, later = falls
    for after in (0.005, 0.01, 0.05, 0.1, 0.2):
        v = [np.interp(after + begin, fall["t"], fall["v"]) for begin, fall in ((0, start), (0.05, later))]
        assert v[1] == pytest.approx(v[0], rel=0.01), after
        theta = [np.interp(after + begin, fall["t"], fall["theta"]) for begin, fall in ((0, start), (0.05, later))]
        assert theta[1] == pytest.approx(theta[0], abs=0.01), after
    assert entries["t"][1] > 0.1 and 0.7 - np.interp(entries["t"][1], later["t"], later["y"]) > 0.24
    assert RunFolder(tmp_path / "later").fluid["worst_gap"].min() > -1e-6 * 0.12


def test_ellipses_enter_among_disks(freefem_text, cell, tmp_path):
    """Two disks are held, an ellipse and a disk come in behind them and are too large to pass: the first ellipse of the scene, in
    contacts as well. It has the mean motion of
    the fluid that it displaces, and whoever is in shapes.csv has the axes that were asked for."""
    queue = "bodyHeld(bodyDisk(0.6, 0.75, 0.17, 8)); bodyHeld(bodyDisk(0.6, 0.28, 0.17, 8)); queueEllipse(0.55, 0.15, 0.08, 0.7, 1, 0.05); queueAdd(0.4, 0.1, 1, 0.06);"
    text = case(queue, walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() (2*y) // "
        "EOM", gravity=0)
    freefem_text(text, "-mesh", cell, "-tend", 0.8, "-every", 0, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    shapes, entries = run.table("shapes"), run.table("entries")
    assert shapes["id"].tolist() == [0, 1, 2, 3] and shapes["major"] == pytest.approx([0.17, 0.17, 0.15,
        0.1]) and shapes["minor"] == pytest.approx([0.17, 0.17, 0.08, 0.1])
    assert entries["id"].tolist() == [0, 1, 2, 3] and entries["x"][2] == pytest.approx(1.05
        * 0.15) and entries["t"][3] > entries["t"][2]
    first = {column: values[run.particles["id"] == 2][0] for column, values in run.particles.items()}
    assert entries["u"][2] == pytest.approx(1.1, rel=0.1) and first["omega"] < -0.3 and abs(first["theta"] - 0.7) < 0.05
    assert len(run.table("contacts")["t"]) > 0 and run.fluid["worst_gap"].min() > -1e-6 * 0.08


@pytest.mark.parametrize("scheme", ["standard", "published"])
def test_an_inlet_by_label_has_the_course_of_the_ramp(scheme, freefem_text, cell, tmp_path):
    inlet = case("bodyDisk(0.45, 0.5, 0.12, 2);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
        more="macro boundaryU() (4*y*(1 - y)) // EOM\nMORE", gravity=0)
    by_label = inlet.replace("MORE", "macro caseBoundary(now) inflowScale(labelLeft, 0.3 + now); // EOM")
    by_ramp = inlet.replace("MORE", "").replace("return 1;", "return 0.3 + t;")
    for name, text in (("label", by_label), ("ramp", by_ramp)):
        freefem_text(text, "-scheme", scheme, "-mesh", cell, "-tend", 0.05, "-every", 0, "-out", tmp_path / name)
    u, v = ((RunFolder(tmp_path / name).particles[q] for q in "uv") for name in ("label", "ramp"))
    for a, b in zip(u, v):
        assert np.abs(a - b).max() < 1e-8  # published: one run differs from the next by 1e-10
    assert RunFolder(tmp_path / "label").fluid["flux_in"][-1] == pytest.approx(0.35 * 2 / 3, rel=1e-6)


@pytest.mark.parametrize("driver", ["resolved", "flow"])
def test_two_inlets_have_courses_of_their_own(driver, freefem_text, tmp_path):
    """The second opens when the first one closes; the fluxes of each label say so, after a restart too."""
    more = "macro boundaryU() (x < 1e-9 ? 4*y*(1 - y) : 0.) // EOM\nmacro boundaryV() (x > 1e-9 ? 4*x*(1 - x) : 0.) // EOM\nmacro caseBoundary(now) { inflowScale(labelLeft, 1 - 2*now); inflowScale(labelBottom, 5*now); } // EOM"
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="labelTop", moving="labelLeft, labelBottom", outlet="labelRight", more=more,
        gravity=0).replace("resolved.edp", f"{driver}.edp")
    if driver == "flow":
        text = text.replace(", gravityX = 0, gravityY = 0", "")
    for more in (("-tend", 0.05, "-checkpoint", 5), ("-tend", 0.1, "-restart", tmp_path / "run")):
        freefem_text(text, "-every", 0, "-fluxes", 1, *more, "-out", tmp_path / ("run" if "-checkpoint" in more else "on"))
    for name, end in (("run", 0.05), ("on", 0.1)):
        fluxes = RunFolder(tmp_path / name).table("fluxes")
        for label, factor in ((11, 1 - 2 * end), (13, 5 * end)):
            assert fluxes["flux"][fluxes["label"] == label][-1] == pytest.approx(-factor * 2 / 3, rel=1e-6), label


@pytest.mark.parametrize("course, words", [("inflowScale(labelTop, 1.);", "label 14 (top) is not in flowMoving"),
    ("inflowScale(labelLeft, sqrt(now - 1.));", "the factor is not finite"),
                                           ("inflowScale(labelLeft, 1 + now);", "have a net flux of")])
def test_a_course_of_an_inlet_that_cannot_be_is_refused(course, words, freefem_text, tmp_path):
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="labelBottom, labelTop", moving="labelLeft, labelRight",
        more=f"macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseBoundary(now) {course} // EOM")
    done = freefem_text(text, "-tend", 0.05, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stderr and len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("period, more, walls, slip, words", [
    (1, "", "labelLeft, labelRight", "", "flowPeriodY is 1, but the case has no macro flowPeriodicLabels(); a periodic case sets"),
    (0, "", "labelLeft, labelRight, labelBottom", "", "label 14 (top), for which this case has no condition; list it in "
        "flowNoSlip, flowMoving, flowOutlet or flowSlip"),
    (0, "", "labelLeft, labelRight, labelBottom, labelTop", "labelAxis", "no edge with label 8 (axis), which this case needs as "
        "plane of symmetry; its edges have label 11 (left), label 12 (right), label 13 (bottom), label 14 (top)"),
])
def test_labels_that_do_not_fit_the_mesh_are_refused_with_what_to_do(period, more, walls, slip, words, freefem_text, tmp_path):
    done = freefem_text(case("bodyDisk(0.5, 0.5, 0.12, 2);", walls=walls, slip=slip, period=period, more=more), "-out",
        tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stderr and len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize("given, warnings", [("", 1), ("macro boundaryU() (4*y*(1 - y)) // EOM\n", 0)])
def test_an_inflow_that_scales_nothing_is_warned_of_once(given, warnings, freefem_text, tmp_path):
    """A boundaryU that is missing, or a func instead of a macro, leaves 0 to be scaled."""
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
        more=given + "macro caseBoundary(now) inflowScale(labelLeft, 1 + now); // EOM")
    done = freefem_text(text, "-tend", 0.03, "-out", tmp_path / "run")
    assert done.stdout.count("warning: inflowScale(11, ...) has no effect") == warnings, done.stdout


@pytest.mark.parametrize("scheme", ["standard", "published"])
def test_particles_that_never_had_room_to_enter_are_warned_of(scheme, freefem_text, cell, tmp_path):
    """Three at one place at once: the first enters and stays there, the others wait; another one is not due."""
    queue = "".join(f"queueAt(0.5, 0.5, 0.12, 1, {time});" for time in (0, 0.01, 0.02, 9))
    text = case(queue, gravity=0)
    done = freefem_text(text, "-mesh", cell, "-tend", 0.05, "-scheme", scheme, "-out", tmp_path / "run")
    assert "warning: 2 of the waiting particles were due, but had no room to enter at the end; the first: at (0.5, 0.5), due at t = 0.01 s" in done.stdout, done.stdout
    done = freefem_text(case("queueAt(0.5, 0.5, 0.12, 1, 0.); queueAt(0.5, 0.5, 0.12, 1, 9);", gravity=0), "-mesh", cell,
        "-tend", 0.05, "-scheme", scheme, "-out", tmp_path / "alone")
    assert "had no room" not in done.stdout


def test_an_obstacle_behind_the_inlet_is_in_the_way(freefem_text, tmp_path):
    mesh = tmp_path / "drain.mesh"
    text = square(mesh, hole=DRAIN) + case("queueAdd(0.5, 0.2, 1, 0.);", walls="labelBottom, labelTop, labelOutlet",
        moving="labelLeft", outlet="labelRight", more="macro boundaryU() 1. // EOM")
    done = freefem_text(text, "-mesh", mesh, "-out", tmp_path / "run", check=False)
    assert done.returncode == 5 and "would overlap a wall by" in done.stderr


def test_heights_sizes_and_times_of_those_who_wait(freefem_text):
    """Heights are normal, or uniform where the deviation is wide, and leave room at the walls; sizes are uniform."""
    out = freefem_text("""include "lib/bodies/waiting.idp"
cout.precision(12);
queueGaussian(2000, 3, -1, 1, 0.2, 0.2, 1e9, 1, 0, 0);
cout << "HEIGHTS " << queueY.min << " " << queueY.max << " " << queueY.sum/2000 << " " << (queueY'*queueY)/2000 << endl;
queueWaiting = 0;
queueGaussian(4000, 3, -1, 2, 0.2, 0.6, 0.2, 1, 0.3, 0.02);
real[int] off = queueY, wide = queueRadius, late = queueTime, rank = 0:3999;
off -= 0.5; late -= 0.3; late -= 0.02*rank;
cout << "NORMAL " << off.sum/4000 << " " << sqrt(off'*off/4000) << " " << wide.min << " " << wide.max << " " << wide.sum/4000 << " " << late.linfty << endl;""").stdout
    low, high, mean, square2 = map(float, out.split("HEIGHTS")[1].split()[:4])
    room = 1 - 0.1 * 1.05
    assert -room <= low < -0.95 * room and 0.95 * room < high <= room
    assert mean == pytest.approx(0, abs=0.05) and square2 == pytest.approx(room**2 / 3, rel=0.06)
    mean, deviation, smallest, largest, size, late = map(float, out.split("NORMAL")[1].split()[:6])
    assert mean == pytest.approx(0, abs=0.015) and deviation == pytest.approx(0.2, rel=0.05)
    assert 0.1 <= smallest < 0.101 and 0.299 < largest <= 0.3 and size == pytest.approx(0.2, abs=0.005) and late < 1e-9


def test_the_flux_through_a_period_is_that_of_poiseuille(freefem_text, tmp_path):
    """Driven by a force f: f H^3/(12 mu), in by one side and out by the other."""
    text = case("", walls="labelLeft, labelRight", more=PERIODIC + "\nmacro flowForceY() 1. // EOM", period=1, mu=0.5, gravity=0)
    freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-dt", 0.02, "-tend", 3, "-every", 1, "-fluxes", 1, "-out",
        tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("fluxes")
    assert list(table["label"][-2:]) == [13, 14] and table["flux"][-2:] == pytest.approx([-1 / 6, 1 / 6], rel=1e-4)


@pytest.mark.parametrize("scheme", ["standard", "published"])
def test_a_force_that_a_case_switches_off_is_off_in_either_scheme(scheme, freefem_text, cell, tmp_path):
    energy = []
    for off in (0, 1):
        more = f"macro flowForceX() (y - 0.5) // EOM\nmacro caseStep() {{ if ({off}) {{ flowFX = 0; flowFY = 0; }} }} // EOM"
        freefem_text(case("bodyDisk(0.5, 0.6, 0.12, 1);", more=more, gravity=0), "-scheme", scheme, "-mesh", cell, "-cfl", 0,
            "-dt", 0.02, "-tend", 0.1, "-out", tmp_path / f"run{off}")
        energy.append(RunFolder(tmp_path / f"run{off}").fluid["kinetic_energy"][-1])
    assert energy[1] < 0.1 * energy[0]


@pytest.mark.parametrize("scheme", ["standard", "published"])
def test_a_case_knows_time_and_step_in_either_scheme(scheme, freefem_text, tmp_path):
    """The last step is what is left until -tend."""
    more = f'macro caseStart() {{ ofstream f("{tmp_path}/steps"); f << timeDt << endl; }} // EOM\nmacro caseStep() {{ ofstream f("{tmp_path}/steps", append); f << timeNow << " " << timeDt << endl; }} // EOM'
    freefem_text(case("bodyDisk(0.5, 0.6, 0.12, 1);", more=more), "-scheme", scheme, "-cfl", 0, "-dt", 0.02, "-tend", 0.05, "-out",
        tmp_path / "run")
    first, *rows = (tmp_path / "steps").read_text().splitlines()
    times, steps = np.array([row.split() for row in rows], dtype=float).T
    assert float(first) == 0.02 and np.diff([0, *times]) == pytest.approx(steps) and times[-1] == pytest.approx(0.05)


def test_an_inlet_that_stays_shut_ends_well(freefem_text, tmp_path):
    text = case("bodyDisk(0.5, 0.5, 0.12, 1.5);", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
        more="macro boundaryU() (4*y*(1 - y)) // EOM")
    freefem_text(text.replace("return 1;", "return 0;"), "-tend", 0.05, "-out", tmp_path / "run")
    assert RunFolder(tmp_path / "run").status == "finished"


def test_a_particle_let_go_over_an_outlet_takes_the_motion_of_the_fluid_that_is_there(freefem_text, tmp_path):
    text = case("queueAt(0.97, 0.5, 0.12, 1, 0.);", walls="", moving="labelLeft", outlet="labelRight", slip="labelBottom, labelTop",
                more="macro boundaryU() 1. // EOM\nmacro caseStart() { Wh one = 1.; flowU = one[]; } // EOM", gravity=0)
    freefem_text(text, "-tend", 0.01, "-every", 0, "-out", tmp_path / "run")
    disk = RunFolder(tmp_path / "run").table("entries")
    assert disk["u"][0] == pytest.approx(1, abs=1e-3)


def test_the_density_of_a_held_body_means_nothing(freefem_text, tmp_path):
    """Drag on a held cylinder in a stream, and the torque, that of density 1 for any other."""
    found = []
    for density in (1, 0.01, 100):
        text = case(f"bodyHeld(bodyDisk(0.41, 0.53, 0.11, {density}));", walls="labelBottom, labelTop", moving="labelLeft",
            outlet="labelRight",
                    more="macro boundaryU() (4*y*(1 - y)) // EOM", mu=0.02, gravity=0)
        freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-dt", 0.02, "-tend", 0.3, "-every", 0, "-tolerance", 1e-10,
            "-forces", 1, "-out", tmp_path / f"run{density}")
        table = RunFolder(tmp_path / f"run{density}").table("forces")
        found.append(np.array([table["fx"], table["fy"], table["torque"] / 0.11]))
    assert abs(found[0][0]).max() > 0.1 and all(abs(one - found[0]).max() < 1e-6 for one in found[1:])


def test_a_disk_that_leaves_does_not_mind_how_many_nodes_are_in_bodies(freefem_text, tmp_path):
    """Half out of the outlet, where the torque of its nodes on the side hung on that."""
    turns = []
    for number in (200, 0):
        text = case("bodyAdd(0.86, 0.55, 0.12, 1.2, 1, 0, 3, 1);", walls="labelBottom, labelTop", moving="labelLeft",
            outlet="labelRight",
                    more=f'macro boundaryU() (4*y*(1 - y)) // EOM\nmacro caseMotion(now) ghostFew = {number}; // EOM', mu=0.02,
                        gravity=0)
        freefem_text(text, "-mesh", "meshes/cylinder_array.mesh", "-dt", 0.01, "-tend", 0.15, "-every", 0, "-tolerance", 1e-10,
            "-out", tmp_path / "run", "-overwrite", 1)
        turns.append(RunFolder(tmp_path / "run").particles["omega"])
    assert len(turns[0]) > 10 and abs(turns[1] - turns[0]).max() < 1e-6


def test_walls_that_the_mesh_does_not_have_are_none(freefem_text, tmp_path):
    """Between planes of symmetry, with a label of walls that is not there: the drag of the walls has nothing to hold it."""
    more = "macro boundaryU() 1. // EOM"
    text = case("", walls="labelWall", moving="labelLeft", outlet="labelRight", slip="labelBottom, labelTop", more=more, gravity=0)
    text = "int[int] sides = [13, 12, 14, 11];\n" + f'savemesh(square(8, 8, label = sides), "{tmp_path}/box.mesh");\n' + text
    freefem_text(text, "-mesh", tmp_path / "box.mesh", "-tend", 0.1, "-every", 0, "-wallforces", 1, "-out", tmp_path / "run")
    fluid = RunFolder(tmp_path / "run").fluid
    assert set(RunFolder(tmp_path / "run").table("wallforces")["label"]) == {11}  # the inlet, and no wall
    assert (abs(fluid["flux_out"][6:] - 1) < 0.04).all()  # from the seventh step on: an outlet takes over at once


def test_macros_of_the_boundary_may_be_sums(freefem_text, tmp_path):
    """Plates that move against each other along themselves are no inlets, however their velocity is written; a force may be a sum
    too."""
    more = "macro boundaryU() y - 0.5 // EOM\nmacro flowForceX() 1. - 1. // EOM"
    text = case("bodyDisk(0.5, 0.5, 0.12, 1);", walls="labelLeft, labelRight", moving="labelBottom, labelTop", more=more, gravity=0)
    text = "int[int] sides = [13, 12, 14, 11];\n" + f'savemesh(square(12, 12, label = sides), "{tmp_path}/box.mesh");\n' + text
    freefem_text(text, "-mesh", tmp_path / "box.mesh", "-tend", 0.05, "-out", tmp_path / "run")
    fluid = RunFolder(tmp_path / "run").fluid
    assert (fluid["pressure_drop"] == 0).all() and (fluid["flux_in"] == 0).all()


LEAVES = """macro caseStep() {
    if (driveStep == 3) { int[int] stay = [0, 2]; bodyKeep(stay); rigidStale = 1; }
    if (driveStep == 4) {
        real[int] diagonal = momentumBodyDiag, gain = momentumGain;
        int age = momentumAge;
        momentumAge = 40;
        momentumDiagonal();
        diagonal ./= momentumBodyDiag; gain ./= momentumGain;
        diagonal -= 1.; gain -= 1.;
        cout << "kept " << age << " " << bodyNumber << " " << diagonal.n << " " << diagonal.linfty << " " << gain.n << " " << gain.linfty << endl;
    }
} // EOM
"""


def test_who_stays_keeps_diagonal_and_gain_when_another_leaves(freefem_text, tmp_path):
    """They are those that are found anew, but for how far the bodies have gone (sizes and densities differ, so a wrong order would
    show)."""
    # as large as a file may say
    bodies = "bodyDisk(0.3, 0.3, 0.11, 1.5); bodyDisk(0.7, 0.3, 0.08, 3); bodyNextId = 2000000000; bodyDisk(0.5, 0.7, 0.16, 1.1);"
    done = freefem_text(standard_alone(case(bodies, more=LEAVES)), "-dt", 0.002, "-tend", 0.01, "-out", tmp_path / "run")
    age, bodies, size, off, gains, gain_off = [float(word) for word in next(line for line in done.stdout.splitlines()
        if line.startswith("kept")).split()[1:]]
    assert (age, bodies, size, gains) == (3, 2, 6, 2)  # found anew they would be of this step, 1
    assert off < 0.1 and gain_off < 0.3


def test_who_leaves_is_written_with_the_velocity_it_had(freefem_text, tmp_path):
    text = case("bodyAdd(0.95, 0.5, 0.1, 2, 1.5, 0, 0, 1);", more="macro boundaryU() (4*y*(1 - y)) // EOM",
        walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight")
    freefem_text(text, "-every", 0, "-cfl", 0, "-dt", 0.01, "-tend", 0.2, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    gone, last = run.table("exits"), run.tracks[0]
    assert list(gone["id"]) == [0] and gone["u"][0] == pytest.approx(last["u"][-1],
        rel=0.1) and gone["u"][0] > 0.7 and abs(gone["v"][0]) < 0.3


@pytest.mark.parametrize("words", [["-forces", 1], ["-scheme", "published"], ["-scheme", "published", "-indicator", "levelset"]])
def test_gravity_along_x_is_as_gravity_along_y(words, freefem_text, cell, tmp_path):
    """The scene is symmetric about the diagonal, but for the mesh: velocity and force from the first row on."""
    text, runs = case("bodyDisk(0.5, 0.5, 0.15, 2);"), []
    for name, gx, gy in (("down", 0, -1), ("left", -1, 0)):
        one = text.replace("gravityX = 0", f"gravityX = {gx}").replace("gravityY = -1", f"gravityY = {gy}")
        freefem_text(one, "-mesh", cell, "-cfl", 0, "-dt", 0.01, "-every", 0, "-tend", 0.07, *words, "-out", tmp_path / name)
        runs.append(RunFolder(tmp_path / name))
    down, left = runs
    assert down.particles["v"][-1] < -0.01
    np.testing.assert_allclose(left.particles["u"], down.particles["v"], rtol=0.05 if len(words) > 2 or "published" in words
        else 0.02)
    if "-forces" in words:
        np.testing.assert_allclose(left.table("forces")["fx"], down.table("forces")["fy"], rtol=0.02)


@pytest.mark.parametrize("velocity, told", [("macro boundaryU() (0.2*(0.5 - y)) // EOM\nmacro boundaryV() (0.2*(x - 0.5)) // EOM",
    4), ("macro boundaryU() 0.1 // EOM", 0)])
def test_a_wall_that_does_not_move_along_itself_is_told(velocity, told, freefem_text, tmp_path):
    """The sides of a box that turns: what the fluid has there crosses them, and so do particles."""
    sides = "labelLeft, labelRight, labelBottom, labelTop"
    text = case("bodyDisk(0.5, 0.5, 0.12, 2);", walls="" if told else "labelLeft, labelRight, labelTop", moving=sides
        if told else "labelBottom", more=velocity, gravity=0)
    done = freefem_text(text, "-tend", 0.01, "-out", tmp_path / "run")
    assert done.stdout.count("(flowMoving) goes in and out equally: it is not a wall") == told, done.stdout
