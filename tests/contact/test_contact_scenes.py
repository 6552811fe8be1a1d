"""Contacts alone where walls move, lie over seams or have an end within the period; held disks; what the tables say."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table
from tools.peers.contact_problems import Scene
from tools.plot.contact_run import ContactRun
from tools.plot.contacts import make_film, plot_chains, plot_frames


@pytest.fixture
def contacts(freefem_text, tmp_path):
    """Runs a scene of contacts alone; returns its folder, or what a refused one says."""

    def run(bodies, walls="", *words, gravity=0, more="", name="run", check=True):
        text = CONTACTS.format(bodies=bodies, walls=walls, gravity=gravity, more=more).replace('include "lib/contact/walls.idp"',
            'include "lib/contact/walls.idp"\ninclude "lib/contact/periodic.idp"')
        done = freefem_text(text, *words, "-out", tmp_path / name, check=check)
        return tmp_path / name if check else done

    return run


def test_overlaps_are_pushed_apart_as_if_the_walls_stood_still(contacts):
    folder = contacts("bodyDisk(0.2, 0.09, 0.1, 1);", "contactWallSegment(-5, 0, 5, 0); contactWallVelocity(0, 0, 0.5);",
        "-contact-initial", "push", "-dt", 0.001, "-tend", 0.01)
    assert read_table(folder / "particles.csv")["y"][0] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("off", [0, 0.02])
def test_a_disk_rests_between_the_two_ends_of_a_wall_over_the_seam(contacts, off):
    folder = contacts(f"bodyDisk({off}, 0.25, 0.15, 1000);", "contactWallSegment(0.1, 0, 0.9, 0); contactPeriodic(0, 0, 1, 0);",
        "-dt", 0.002, "-tend", 2, "-every", 1, gravity=-10)
    last = read_table(folder / "particles.csv")
    assert [last["x"][-1], last["y"][-1]] == pytest.approx([0, np.sqrt(0.15**2 - 0.1**2)], abs=1e-6)


def test_a_slanted_wall_of_a_periodic_scene_moves_as_a_whole(contacts):
    """The wall is cut into pieces; its velocity is asked for under its own number."""
    folder = contacts("bodyDisk(0.75, 0.5, 0.1, 1000);", "contactWallSegment(0.1, 0, 0.9, 0.3); contactPeriodic(0, 0, 1, 0);",
        "-dt", 0.005, "-tend", 0.5,
                      more="macro caseStep() contactWallVelocity(0, 0, 1); // EOM")
    moves, disk = read_table(folder / "wallmoves.csv"), read_table(folder / "particles.csv")
    last = moves["t"] == moves["t"].max()
    assert last.sum() > 1 and moves["y1"][last].min() == pytest.approx(0.5) and moves["y2"][last].max() == pytest.approx(0.8)
    along = np.array([0.8, 0.3]) / np.hypot(0.8, 0.3)
    away = (disk["x"][-1] - 0.1) * -along[1] + (disk["y"][-1] - 0.5) * along[0]
    assert away >= 0.1 - 1e-9


@pytest.mark.parametrize("shift", [0, -0.5])
def test_a_disk_in_an_obstacle_is_refused_over_the_seam_too(contacts, shift):
    corners = [(0.9 + shift, 0), (1.1 + shift, 0), (1.0 + shift, 0.2), (0.9 + shift, 0)]
    walls = " ".join(f"contactWallSegment({a}, {b}, {c}, {d});" for (a, b), (c, d) in zip(corners,
        corners[1:])) + " contactPeriodic(0, 0, 1, 0);"
    bodies = " ".join(f"bodyDisk({x + shift}, {y}, {r}, 1000);" for x, y, r in ((0.03, 0.05, 0.01), (0.5, 0.5, 0.1),
        (0.2, 0.5, 0.1)))
    done = contacts(bodies, walls, "-tend", 0.01, check=False)
    assert done.returncode == 5 and "particle 0 stands inside an obstacle" in done.stderr


def test_a_disk_wider_than_the_period_is_refused(contacts):
    done = contacts("bodyDisk(0.5, 0.5, 0.6, 1);", "contactWallSegment(0, -1, 1, -1); contactPeriodic(0, 0, 1, 0);", "-tend", 0.01,
        check=False)
    assert done.returncode == 5 and "overlaps its own image" in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_held_disks_take_part_in_the_balance_and_rows_are_of_their_time(contacts):
    folder = contacts("bodyAdd(0, 0, 0.1, 1000, 0, 0, 0, 0); bodyDisk(0, 0.25, 0.1, 1000);", "", "-dt", 0.001, "-tend", 0.3,
        gravity=-10)
    motion, rows, disks = (read_table(folder / f"{name}.csv") for name in ("motion", "contacts", "particles"))
    assert np.abs(motion["momentum_error"]).max() < 1e-9 * np.abs(motion["momentum_y"]).max()
    top = {t: y for t, i, y in zip(disks["t"], disks["id"], disks["y"]) if i == 1}
    assert len(rows["t"]) > 100
    for t, gap in zip(rows["t"], rows["gap"]):
        assert gap == pytest.approx(top[t] - 0.2, abs=1e-12)


def test_the_least_gap_is_a_bound_where_nobody_can_meet(contacts):
    bodies = "bodyAdd(-0.135, 0, 0.1, 1000, 1, 0, 0, 1); bodyAdd(0.135, 0, 0.1, 1000, -1, 0, 0, 1); bodyAdd(0, 5, 0.1, 1000, 0, 0, 0, 1);"
    folder = contacts(bodies, "", "-dt", 0.02, "-tend", 0.02)
    assert -1e-12 < read_table(folder / "motion.csv")["worst_gap"][-1] <= 0.03 + 1e-12


def test_walls_that_move_are_written_after_a_restart(contacts, tmp_path):
    scene = ("bodyDisk(0, 0.1, 0.1, 1000); bodyDisk(0, 0.3, 0.1, 1000);", "contactWallSegment(-1, 0, 1, 0); "
        "contactWallSegment(-1, -1, -1, 1);")
    words = ("-dt", 0.001, "-every", 0.01, "-checkpoint", 50)
    more = "macro caseStep() if (timeNow == 0) contactWallVelocity(0, 0, 0.2); // EOM"
    whole = contacts(*scene, *words, "-tend", 0.1, gravity=-10, more=more, name="whole")
    contacts(*scene, *words, "-tend", 0.05, gravity=-10, more=more, name="half")
    rest = contacts(*scene, *words, "-tend", 0.1, "-restart", tmp_path / "half", gravity=-10, more=more, name="rest")
    one, two = read_table(whole / "wallmoves.csv"), read_table(rest / "wallmoves.csv")
    later = one["t"] > 0.05 + 1e-9
    assert later.sum() >= 5
    for name, values in one.items():
        np.testing.assert_array_equal(np.asarray(values)[later], two[name])


@pytest.mark.parametrize("number, status", [("0 ", 0), (" 0", 0), ("1e400", 3)])
def test_blanks_are_no_fault_and_numbers_out_of_range_one(freefem, tmp_path, number, status):
    scene = Scene(np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([0.5, 0.5]), np.ones(2), np.zeros((2, 2)), np.empty((0, 4)))
    (tmp_path / "disks.csv").write_text("id,x,y,radius,mass,u,v\n" + "".join(f"{k},{x},{y},0.5,1,{number},-1\n" for k,
        (x, y) in enumerate(scene.x)))
    done = freefem("scripts/project_velocities.edp", "-bodies", tmp_path / "disks.csv", "-out", tmp_path / "out.csv", check=False)
    assert done.returncode == status
    if status:
        assert "'1e400' is out of range" in done.stderr
    else:
        np.testing.assert_array_equal(read_table(tmp_path / "out.csv")["v"], [-1, -1])


@pytest.mark.parametrize("gravity", [0, -10])
def test_a_wall_within_a_period_is_one_wall(contacts, gravity):
    """It is cut into pieces for the period; a disk that slides along it felt the joints (0.98 of its speed was left)."""
    wall = "contactWallSegment(0, 0, 0.8, 0);"
    rows = [read_table(contacts("bodyAdd(0.2, 0.05, 0.05, 1000, 1, 0, 0, 1);", wall + period, "-dt", 0.01, "-tend", 0.5,
        gravity=gravity, name=name) / "particles.csv")
            for name, period in (("alone", ""), ("period", " contactPeriodic(-0.5, 0, 2, 0);"))]
    for column in ("x", "y", "u", "v"):
        assert rows[1][column][-1] == pytest.approx(rows[0][column][-1], abs=1e-9)
    assert rows[1]["u"][-1] == pytest.approx(1, abs=1e-9)


@pytest.mark.parametrize("bodies, walls", [
    ("bodyAdd(0, 0, 0.1, 1, 1, 0, 0, 0); bodyAdd(0.5, 0, 0.1, 1, -1, 0, 0, 0);", ""),
    ("bodyAdd(0, 0, 0.1, 1, 0, 0, 0, 0); bodyAdd(0.5, 0.5, 0.1, 1, 0, 0, 0, 0);", "contactWallSegment(-1, -0.3, 1, -0.3); "
        "contactWallVelocity(0, 0, 1);"),
])
def test_held_disks_that_overlap_are_told_once(freefem_text, tmp_path, bodies, walls):
    """They went through each other without a word, and the least gap was that of the others."""
    text = CONTACTS.format(bodies=bodies + " bodyDisk(0, 2, 0.1, 1);", walls=walls, gravity=0, more="")
    done = freefem_text(text, "-dt", 0.01, "-tend", 0.25, "-every", 0.01, "-out", tmp_path / "run")
    assert (done.stdout + done.stderr).count("warning: prescribed motions make bodies overlap") == 1
    gaps = read_table(tmp_path / "run/motion.csv")["worst_gap"]
    assert gaps[-1] == pytest.approx(-0.2 if not walls else -0.05, abs=1e-9)
    assert gaps[5] == pytest.approx(0.2 if not walls else 0.15, abs=0.2) and gaps[5] >= 0


@pytest.mark.parametrize("speed, gap", [(1, -0.1), (0.8, 0.1), (0.3, 0.6)])
def test_the_least_gap_of_disks_that_are_all_held(freefem, tmp_path, speed, gap):
    (tmp_path / "disks.csv").write_text(f"id,x,y,radius,mass,u,v\n0,0,0,0.5,-1,{speed},0\n1,1.9,0,0.5,-1,-{speed},0\n2,0,9,0.5,-1,0,0\n")
    done = freefem("scripts/project_velocities.edp", "-bodies", tmp_path / "disks.csv", "-out", tmp_path / "out.csv", "-dt", 0.5)
    found = float(done.stdout.split("least gap ")[1].split()[0])
    assert found == pytest.approx(gap, abs=1e-12) if gap < 0.2 else 0 <= found <= 0.6
    assert ("warning" in done.stdout + done.stderr) == (gap < 0)


@pytest.mark.parametrize("change", ["contactWallSegment(-1, 0.45, 1, 0.45);", "contactWallsKeep(1);"])
def test_a_list_of_walls_that_changes_goes_on_from_a_checkpoint(contacts, tmp_path, change):
    """It was refused as made with other walls, or read into arrays of another size."""
    scene = ("bodyDisk(0, 0.1, 0.1, 1000); bodyAdd(0, 0.31, 0.1, 1000, 0, 3, 0, 1);", "contactWallSegment(-1, 0, 1, 0); "
        "contactWallSegment(-1, 0.6, 1, 0.6);")
    words = ("-dt", 0.001, "-every", 0.01, "-checkpoint", 50)
    more = f"macro caseStep() if (driveStep == 20) {{ {change} }} // EOM"
    whole = contacts(*scene, *words, "-tend", 0.1, gravity=-10, more=more, name="whole")
    contacts(*scene, *words, "-tend", 0.05, gravity=-10, more=more, name="half")
    contacts(*scene, *words, "-tend", 0.1, "-restart", tmp_path / "half", gravity=-10, more=more, name="half")
    for name in ("particles.csv", "contacts.csv"):
        assert (whole / name).read_bytes() == (tmp_path / "half" / name).read_bytes(), name
    assert len(read_table(whole / "contacts.csv")["t"]) > 0
    if "Segment" in change:
        assert len(ContactRun(whole).walls) == 2 and ContactRun(whole).walls_at(0.1).shape == (3, 2, 2)


def test_gravity_that_is_no_number_is_refused(contacts):
    """The step was blamed for it."""
    done = contacts("bodyDisk(0.3, 0.5, 0.1, 1);", "contactWallSegment(0, 0, 1, 0);", "-tend", 0.01, gravity="1e300*1e300",
        check=False)
    assert done.returncode == 3 and "gravityY inf; both must be numbers" in done.stderr


def test_a_disk_without_weight_is_refused(contacts):
    done = contacts("bodyDisk(0.3, 0.5, 0.1, -1);", "contactWallSegment(0, 0, 1, 0);", "-tend", 0.01, check=False)
    assert done.returncode == 3 and "particle 0 has density -1" in done.stderr


def test_pictures_of_a_period_show_disks_within_it_and_over_its_seams(contacts):
    """The disks lie in a row over the seam; who has gone on by a period is drawn where its image is."""
    bodies = "bodyAdd(0.25, 0.1, 0.1, 1, 0, 0, 0, 1); bodyAdd(0.45, 0.1, 0.1, 1, 0, 0, 0, 1); bodyAdd(1.05, 0.1, 0.1, 1, 0, 0, 0, 1);"
    folder = contacts(bodies, "contactWallSegment(0, 0, 1, 0); contactPeriodic(0, 0, 1, 0);", "-dt", 0.001, "-tend", 0.01,
        gravity=-1)
    run = ContactRun(folder)
    assert run.period == (1, 0) and run.view[:2] == (0, 1)
    shown = run.frame(len(run.times) - 1)
    assert sorted(shown["x"]) == pytest.approx([0.05, 0.25, 0.45, 1.05],
        abs=1e-6) and len(shown["radius"]) == len(shown["speed"]) == 4
    made = [plot_frames(run, folder / "frames.png"), plot_chains(run, folder / "chains.png"), make_film(run, folder)]
    assert all(path.stat().st_size > 5000 for path in made)


FREE = """include "lib/bodies/bodies.idp"
optCase("free", "disks without walls");
real gravityX = {gx}, gravityY = {gy};
macro caseWalls() // EOM
macro caseParticles() {bodies} // EOM
include "scripts/contacts.edp"
"""


def free_disks(freefem_text, folder, bodies, gx, gy, *words):
    """{id: columns} of disks without walls."""
    freefem_text(FREE.format(gx=gx, gy=gy, bodies=bodies), "-out", folder, *words)
    return RunFolder(folder).tracks


def test_held_disks_do_not_fall_along_x_either(freefem_text, tmp_path):
    tracks = free_disks(freefem_text, tmp_path / "run", "bodyAdd(0, 0, 0.1, 1, 0, 0, 0, 0); bodyDisk(3, 0, 0.1, 1);", -2, 0, "-dt",
        0.01, "-tend", 0.5)
    assert abs(tracks[0]["x"]).max() == 0 and abs(tracks[0]["u"]).max() == 0
    assert tracks[1]["u"][-1] == pytest.approx(-1)


@pytest.mark.parametrize("upper", [0, 1])
def test_two_disks_that_fly_beside_each_other_do_not_touch(upper, freefem_text, tmp_path):
    """In free fall, a 500th of a diameter apart: each goes its parabola, whichever is named first."""
    bodies = ["bodyDisk(0, 0.2002, 0.1, 1);", "bodyDisk(0.001, 0, 0.1, 1);"]
    tracks = free_disks(freefem_text, tmp_path / "run", bodies[upper] + bodies[1 - upper], 0, -9.81, "-dt", 0.01, "-tend", 0.5,
        "-contact-form", "ballistic")
    for track in tracks.values():
        np.testing.assert_allclose(track["y"], track["y"][0] - 9.81 * track["t"] ** 2 / 2, atol=1e-12)


def test_the_least_gap_is_that_between_the_rows_too(freefem_text, tmp_path):
    """A disk passes a held one by 0.001 while no row is written."""
    free_disks(freefem_text, tmp_path / "run", "bodyAdd(0, 0, 0.1, 1, 0, 0, 0, 0); bodyAdd(-0.5, 0.201, 0.1, 1, 1, 0, 0, 1);", 0,
        0, "-dt", 0.01, "-tend", 0.55, "-every", 1)
    assert read_table(tmp_path / "run" / "motion.csv")["worst_gap"][-1] < 0.0015


@pytest.mark.parametrize("solver", ["newton", "accelerated", "uzawa"])
def test_a_piston_goes_down_till_the_disks_under_it_have_no_room(contacts, tmp_path, solver):
    """Five in a shaft one and a half of their diameters wide: side by side in turn they need a height of 0.2 + 4 sqrt(0.03) m,
    which the piston passes in a step of 0.01 m."""
    bodies = "for (int k = 0; k < 5; ++k) bodyDisk(0.1 + 0.1*(k % 2), 0.1 + 0.2*k, 0.1, 1);"
    walls = "contactWallSegment(0, 0, 0.3, 0); contactWallSegment(0, -1, 0, 3); contactWallSegment(0.3, -1, 0.3, 3); contactWallVelocity(contactWallSegment(0, 1.203, 0.3, 1.203), 0, -1);"
    done = contacts(bodies, walls, "-dt", 0.01, "-tend", 0.5, "-every", 0.01, "-contact-solver", solver, gravity=-10, check=False)
    assert done.returncode == 4 and "leave a body no room: no motion satisfies the contacts" in done.stderr
    motion, need = read_table(tmp_path / "run" / "motion.csv"), 0.2 + 4 * 0.03**0.5
    assert need <= 1.203 - motion["t"][-1] < need + 0.01 and min(motion["worst_gap"]) > -1e-9


def test_disks_of_many_sizes_and_weights_under_a_piston_jam_in_so_many_words(contacts):
    """In their last step they lack less than a thousandth of a radius, which shows in how the pushes grow: the run ended with "did
    not converge" after 200,000 steps."""
    places = [(0.125837, 0.13), (0.384978, 0.13), (0.633323, 0.13), (0.125368, 0.38), (0.380675, 0.38), (0.631093, 0.38),
        (0.125069, 0.63), (0.376791, 0.63), (0.626649, 0.63),
              (0.129620, 0.88), (0.380670, 0.88), (0.629519, 0.88)]
    radii = [0.09964, 0.04384, 0.07058, 0.05622, 0.04678, 0.05743, 0.06042, 0.07527, 0.08746, 0.03681, 0.04903, 0.07462]
    weights = [6.6, 5.3, 0.34, 29, 3.2, 0.55, 0.032, 2.6, 0.11, 19, 0.47, 9.7]
    bodies = " ".join(f"bodyDisk({x}, {y}, {r}, {m});" for (x, y), r, m in zip(places, radii, weights))
    walls = "contactWallSegment(0, 0, 0.76, 0); contactWallSegment(0, -1, 0, 5); contactWallSegment(0.76, -1, 0.76, 5); contactWallVelocity(contactWallSegment(0, 1.23, 0.76, 1.23), 0, -1);"
    done = contacts(bodies, walls, "-dt", 0.01, "-tend", 1.2, gravity=-10, check=False)
    assert done.returncode == 4 and "leave a body no room: no motion satisfies the contacts" in done.stderr


def test_a_disk_let_go_at_rest_meets_the_floor_in_one_long_ballistic_step(contacts):
    """It is looked after as far as its weight brings it, not its velocity alone."""
    folder = contacts("bodyDisk(0, 0.12, 0.1, 1);", "contactWallSegment(-1, 0, 1, 0);", "-dt", 0.1, "-tend", 0.1, "-contact-form",
        "ballistic", gravity=-10)
    assert read_table(folder / "particles.csv")["y"][-1] == pytest.approx(0.1, abs=1e-9)


@pytest.mark.parametrize("along", [0, 1])
def test_the_least_gap_of_a_ballistic_step_is_that_of_its_places(along, freefem_text, tmp_path):
    """A disk falls past a held one, along either axis; what the weight does to its place in a step of 0.04 s is 0.08 of its
    radius."""
    first, second = ("bodyAdd(-0.5, 0.215, 0.1, 1, 1, 0, 0, 1);",
        "bodyAdd(0.215, -0.5, 0.1, 1, 0, 1, 0, 1);")[along], "bodyAdd(0, 0, 0.1, 1, 0, 0, 0, 0);"
    pull = ((10, 0), (0, 10))[along]
    tracks = free_disks(freefem_text, tmp_path / "run", first + second, *pull, "-dt", 0.04, "-tend", 0.4, "-every", 0,
        "-contact-form", "ballistic")
    gap, told = np.hypot(tracks[0]["x"], tracks[0]["y"]) - 0.2, read_table(tmp_path / "run" / "motion.csv")["worst_gap"]
    nearest = gap.argmin()
    assert gap[nearest] < 0.04 and (told <= gap + 1e-9).all() and told[nearest] == pytest.approx(gap[nearest], abs=1e-9)


@pytest.mark.parametrize("bodies, walls", [("bodyDisk(0, 0.1, 0.1, 1);", "contactWallSegment(-1, 0, 1, 0);"),
    ("bodyDisk(0, 0.1, 0.1, 1); bodyDisk(0, 0.4, 0.1, 1);", "contactWallSegment(-1, 0, 1, 0); contactWallSegment(-1, 0, -1, 1);")])
def test_a_checkpoint_of_other_disks_or_walls_is_refused(contacts, tmp_path, bodies, walls):
    """A scene that has been edited since: a disk less, or a wall more."""
    words = ("-dt", 0.01, "-checkpoint", 5)
    contacts("bodyDisk(0, 0.1, 0.1, 1); bodyDisk(0, 0.4, 0.1, 1);", "contactWallSegment(-1, 0, 1, 0);", *words, "-tend", 0.1,
        gravity=-10)
    done = contacts(bodies, walls, *words, "-tend", 0.2, "-restart", tmp_path / "run", gravity=-10, check=False)
    assert done.returncode == 3 and "was made with other disks or walls" in done.stderr and len([line
        for line in done.stderr.splitlines() if line.startswith("error")]) == 1
