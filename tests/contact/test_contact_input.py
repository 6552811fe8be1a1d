"""Scenes that cannot be: refused in words, a line each, with the right status."""
import numpy as np
import pytest

from tools.base.command import BadInput
from tools.peers.contact_problems import Scene, box, project

SCRIPT = "scripts/project_velocities.edp"
GOOD = ["0,0.1,0.1,0.01,1,0,0", "1,0.2,0.1,0.01,1,0,0"]


@pytest.fixture
def refused(freefem, tmp_path):
    """Runs the script on rows of bodies (and walls); returns status and the lines of errors."""

    def run(rows, walls=None, *options, header="id,x,y,radius,mass,u,v"):
        (tmp_path / "bodies.csv").write_text("\n".join([header, *rows]) + "\n")
        words = ["-bodies", tmp_path / "bodies.csv", "-out", tmp_path / "out.csv", *options]
        if walls is not None:
            (tmp_path / "walls.csv").write_text("\n".join(["x1,y1,x2,y2", *walls]) + "\n")
            words += ["-walls", tmp_path / "walls.csv"]
        done = freefem(SCRIPT, *words, check=False)
        return done.returncode, [line for line in done.stderr.splitlines() if line.startswith("error:")]

    return run


@pytest.mark.parametrize("row, words", [
    ("7,0.3,0.1,-0.01,1,0,0", "particle 7 has a radius that is not above 0"),
    ("7,0.3,0.1,0,1,0,0", "particle 7 has a radius that is not above 0"),
    ("7,0.3,0.1,0.01,0,0,0", "particle 7 has no mass"),
    ("1,0.3,0.1,0.01,1,0,0", "the id 1 is given twice"),
    ("7,nan,0.1,0.01,1,0,0", "row 4: 'nan' is not a finite number"),
    ("7,0.3,0.1,0.01,1,inf,0", "row 4: 'inf' is not a finite number"),
    ("7,0.3,zero,0.01,1,0,0", "row 4: 'zero' is not a finite number"),
    ("7,0.3,0.1,0.01,1,0", "row 4: 6 columns, not 7"),
    ("7.5,0.3,0.1,0.01,1,0,0", "the id 7.5 is not a whole number"),
])
def test_bad_numbers_are_named(refused, row, words):
    status, lines = refused([*GOOD, row])
    assert status == 3
    assert sum(words in line for line in lines) == 1


def test_every_fault_has_its_line(refused):
    status, lines = refused([*GOOD, "2,0.3,0.1,-1,1,0,0", "3,0.4,0.1,-1,1,0,0", "3,0.5,0.1,0.01,0,0,0"])
    assert status == 3 and len(lines) == 5 and "4 faults" in lines[-1]


def test_a_wrong_header_an_empty_file_and_no_file(refused, freefem, tmp_path):
    assert refused(GOOD, header="id,x,y,r,mass,u,v")[0] == 3
    assert refused([])[0] == 3
    done = freefem(SCRIPT, "-bodies", tmp_path / "none.csv", check=False)
    assert done.returncode == 3 and "cannot read the file" in done.stderr
    done = freefem(SCRIPT, check=False)
    assert done.returncode == 3 and "-bodies FILE is needed" in done.stderr


def test_an_unknown_solver_or_option(refused):
    status, lines = refused(GOOD, None, "-solver", "magic")
    assert status == 3 and "uzawa|accelerated|newton" in lines[0]
    status, lines = refused(GOOD, None, "-tool", "1")
    assert status == 3 and "the nearest is -tol" in lines[0]


@pytest.mark.parametrize("short, value", [("solver", "uzawa"), ("tol", "1e-8")])
def test_an_option_and_its_short_name_are_not_both_given(refused, short, value):
    status, lines = refused(GOOD, None, f"-{short}", value, f"-contact-{short}", value)
    assert status == 3 and lines == [f"error: -{short} is short for -contact-{short}; give one of them"]


def test_overlaps_are_listed(refused):
    status, lines = refused(["0,0.1,0.1,0.01,1,0,0", "5,0.115,0.1,0.01,1,0,0", "9,0.3,0.005,0.01,1,0,0"], ["0,0,1,0"])
    assert status == 5
    assert any(line.endswith("particles 0 and 5 overlap by 0.005") for line in lines)
    assert any(line.startswith("error: particle 9 overlaps the wall from (") and line.endswith(") by 0.005") for line in lines)


def test_overlaps_are_pushed_apart_on_request():
    x = np.array([[0.1, 0.1], [0.115, 0.1], [0.3, 0.005]])
    answer = project(Scene(x, 0.01, [1.0, 3.0, 1.0], np.zeros((3, 2)), [[0, 0, 1, 0]]), options={"-contact-initial": "push"})
    np.testing.assert_allclose(answer.velocity, 0, atol=1e-9)
    assert answer.figures[0]["gap"] > -1e-10


@pytest.mark.parametrize("rows, walls", [
    (["0,0.1,0.1,0.01,1,0,0", "1,0.1,0.1,0.01,1,0,0"], ["0,0,1,0"]),
    (["0,0.1,0.1,0.01,1,0,0", "1,0.1,0.1,0.02,3,0,0", "2,0.1,0.1,0.01,1,0,0", "3,0.11,0.1,0.01,1,0,0"], None),
    (["0,0.1,0,0.01,1,0,0", "1,0.2,0,0.01,1,0,0"], ["0,0,1,0"]),
    (["0,0.1,0.1,0.01,1,0,0"], ["0,0,0.2,0.2"]),
    (["0,0,0.1,0.01,1,0,0", "1,0,0.1,0.02,1,0,0"], ["0,0,0,1"]),
])
def test_centres_in_one_place_or_on_a_wall_are_pushed_apart_too(refused, rows, walls):
    assert refused(rows, walls, "-contact-initial", "push") == (0, [])


@pytest.mark.parametrize("obstacle", [True, False])
def test_a_disk_on_the_wrong_side_of_closed_walls(refused, obstacle):
    corners = [(0.3, 0.3), (0.4, 0.3), (0.35, 0.4)]
    walls = [f"{a[0]},{a[1]},{b[0]},{b[1]}" for a, b in zip(corners, corners[1:] + corners[:1])]
    walls += [",".join(map(str, row)) for row in box(1, 1)]
    place = "0.35,0.33" if obstacle else "1.35,0.33"
    status, lines = refused([*GOOD, f"4,{place},0.005,1,0,0"], walls)
    assert status == 5
    assert ("particle 4 stands inside an obstacle" if obstacle else "particle 4 stands outside") in lines[0]


def test_numbers_that_stop_being_finite(freefem_text):
    done = freefem_text("""
        include "lib/contact/contact.idp"
        optCase("finite", "test");
        contactDeclare(); optEnd();
        real[int] px = [0., 1.], py = [0., 0.], r = [0.1, 0.1], mass = [1., 1.], u = [0., 0.], v = [0., 0.];
        int[int] id = [0, 1];
        u[0] = sqrt(-1 - px[0]);
        contactProject(px, py, r, id, mass, u, v, 0.1);
    """, check=False)
    assert done.returncode == 3 and "not finite" in done.stderr




def test_bad_words_from_python():
    with pytest.raises(BadInput, match="has no mass"):
        project(Scene([[0, 0]], 0.1, 0.0, [[0, 0]]))


@pytest.mark.parametrize("end", ["", "\n", "\r\n", "\n   \n\n \t \n"])
def test_the_last_line_may_lack_its_end_and_blanks_make_no_line(freefem, tmp_path, end):
    for name, head, rows in (("bodies", "id,x,y,radius,mass,u,v", [*GOOD[:1], "   ", *GOOD[1:]]), ("walls", "x1,y1,x2,y2",
        ["0,0,1,0", "     ", "0,1,1,1"])):
        (tmp_path / f"{name}.csv").write_text("\n".join([head, *rows]) + end)
    done = freefem(SCRIPT, "-bodies", tmp_path / "bodies.csv", "-walls", tmp_path / "walls.csv", "-out", tmp_path / "out.csv")
    assert "disks 2," in done.stdout
    assert (tmp_path / "out.csv").read_text().splitlines() == ["id,u,v", "0,0,0", "1,0,0"]


@pytest.mark.parametrize("name", ["2000000001", "5e9", "1e300", "-1"])
def test_ids_beyond_2e9_are_refused(refused, name):
    status, lines = refused([*GOOD, f"{name},0.3,0.1,0.01,1,0,0"])
    assert status == 3 and "is not a whole number from 0 to 2e9" in lines[0] and len(lines) == 2
    assert refused([*GOOD, "2000000000,0.3,0.1,0.01,1,0,0"])[0] == 0


def ring(*corners):
    """The rows of walls.csv of a closed chain."""
    return [f"{a[0]},{a[1]},{b[0]},{b[1]}" for a, b in zip(corners, corners[1:] + corners[:1])]


def square(low, high):
    return ring((low, low), (high, low), (high, high), (low, high))


TRIANGLE = ring((0, 0), (1, 0), (0.5, 1))
BOX, NEXT = ring((0, 0), (1, 0), (1, 1), (0, 1)), ["1,0,2,0", "2,0,2,1", "2,1,1,1"]


@pytest.mark.parametrize("walls, places, wrong", [
    (BOX + ring((3, 0), (4, 0), (4, 1), (3, 1)), [(0.3, 0.5), (3.3, 0.5)], None),  # two boxes
    (BOX + NEXT, [(0.3, 0.5), (0.7, 0.5), (1.5, 0.5)], None),  # chambers that share a wall, drawn once,
    (BOX + ring((1, 0), (2, 0), (2, 1), (1, 1)), [(0.3, 0.5), (1.5, 0.5), (1.7, 0.5)], None),  # twice,
    (BOX + ["1,0.2,2,0.2", "2,0.2,2,0.8", "2,0.8,1,0.8"], [(0.3, 0.5), (1.5, 0.5)], None),  # from the middle of another
    (BOX + ["0.5,0,0.5,1"], [(0.3, 0.5), (0.7, 0.5)], None),  # a partition
    (BOX + NEXT, [(0.3, 0.5), (3, 3), (4, 3)], "particle 0 stands inside an obstacle"),
    (square(0, 4) + square(1, 3), [(0.5, 0.5), (2, 2), (0.5, 3.5)], "particle 1 stands inside an obstacle"),
    # one of two: the one in the box stands right
    (square(0, 4) + square(1, 3), [(0.5, 0.5), (2, 2)], "particle 1 stands inside an obstacle"),
    (square(0, 4) + square(1, 3), [(2, 2), (5, 5), (6, 6)], None),  # in the hole of a ring, and around it
    (square(0, 9) + square(1, 4) + square(2, 3), [(0.5, 0.5), (2.5, 2.5), (5, 5), (1.5, 2.5)], "particle 3 stands inside an "
        "obstacle"),
    (TRIANGLE, [(0.5, 0.35), (3, 3), (4, 3)], "particle 0 stands inside an obstacle"),
    (["0,0,-0.5,0"] + TRIANGLE, [(0.5, 0.35), (3, 3), (4, 3)], "particle 0 stands inside an obstacle"),  # with a fin
    (TRIANGLE + ["0,0,-0.5,0", "0.5,0,0.5,-1"], [(0.5, 0.35), (3, 3), (4, 3)], "particle 0 stands inside an obstacle"),
    (["0.5,1,0.5,0.5", "0.5,1,0.5,2"] + TRIANGLE, [(0.7, 0.35), (3, 3), (4, 3)], "particle 0 stands inside an obstacle"),
    (TRIANGLE[:2] + ["0,0,-0.5,0"], [(0.5, 0.35), (3, 3), (4, 3)], None),  # not closed
    (TRIANGLE + ["0,0,-1,0", "0,0,-0.5,1", "-1,0,-0.5,1"], [(0.5, 0.35), (-0.5, 0.35), (3, 3), (4, 3), (5, 3)],
        "particle 1 stands inside an obstacle"),
])
def test_chambers_and_obstacles(refused, walls, places, wrong):
    status, lines = refused([f"{k},{x},{y},0.05,1,0,0" for k, (x, y) in enumerate(places)], walls)
    assert status == (5 if wrong else 0), lines
    assert wrong is None or any(wrong in line for line in lines)


@pytest.mark.parametrize("words", [("-out", "none/out.csv"), ("-contacts", "none/contacts.csv"), ("-out", "."),
    ("-out", "/proc/none")])
def test_what_cannot_be_written_is_refused_before_the_work(freefem_refused, tmp_path, words):
    (tmp_path / "bodies.csv").write_text("\n".join(["id,x,y,radius,mass,u,v", *GOOD]) + "\n")
    files = {"-out": tmp_path / "out.csv", words[0]: tmp_path / words[1]}
    line = freefem_refused(3, SCRIPT, "-bodies", tmp_path / "bodies.csv", *(word for pair in files.items() for word in pair))
    assert f"{words[0]}: cannot write the file" in line and not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("options", [("-out", "-bodies"), ("-out", "-walls"), ("-contacts", "-bodies"), ("-contacts", "-walls"),
    ("-contacts", "-out")])
def test_no_file_is_written_over_one_that_is_read(freefem_refused, tmp_path, options):
    (tmp_path / "bodies.csv").write_text("\n".join(["id,x,y,radius,mass,u,v", *GOOD]) + "\n")
    (tmp_path / "walls.csv").write_text("x1,y1,x2,y2\n0,0,1,0\n")
    before = {path: path.read_text() for path in tmp_path.glob("*.csv")}
    files = {"-bodies": tmp_path / "bodies.csv", "-walls": tmp_path / "walls.csv", "-out": tmp_path / "out.csv"}
    files[options[0]] = f"{tmp_path}/../{tmp_path.name}/{files[options[1]].name}"
    line = freefem_refused(3, SCRIPT, *(word for pair in files.items() for word in pair))
    assert f"{options[0]} and {options[1]} are one file" in line
    assert {path: path.read_text() for path in tmp_path.glob("*.csv")} == before
