"""Files of particles: what is read, and what is refused with its line."""
import pytest

from tests.conftest import ROOT
from tools.base.tables import read_table


@pytest.mark.parametrize("rows, complaint", [("5,1,2,x,2\n", "line 2"), ("", "contains no particle"),
    ("5,1,2,0.1,2\n\n6,1,3,0.1\n", "line 4: a missing or bad number: 4 entries, not 5 as in the first line"),
    ("5,1,2, 1d-1,2\n", "line 2: a missing or bad number: '1d-1' in the column radius")])
def test_a_bad_file_of_particles_is_refused_with_its_line(freefem_refused, reading, tmp_path, rows, complaint):
    file = tmp_path / "disks.csv"
    file.write_text("id,x,y,radius,density\n" + rows)
    assert complaint in freefem_refused(3, reading, "-particles", file)


def test_a_folder_is_no_shape_file(freefem_refused, reading, tmp_path):
    (tmp_path / "rod.csv").mkdir()
    (tmp_path / "disks.csv").write_text("id,x,y,radius,density,shape\n5,1,2,0.1,2,rod.csv\n")
    said = freefem_refused(3, reading, "-particles", tmp_path / "disks.csv")
    assert "names a folder" in said or "particles with a shape" in said  # by the awk of the machine


@pytest.mark.parametrize("head, row, complaint", [
    ("id,x,y,radius,mass", "5,1,2,0.1,2", "the column 'mass'"),
    ("id,x,y,radius,density,x", "5,1,2,0.1,2,1", "the column 'x'"),
    ("id,x,y,radius", "5,1,2,0.1", "lacks the column density"),
    ("id,x,y,radius,density", "5,1,2,0.1,2\n5,1,4,0.1,2", "line 3: particle 5 is listed a second time"),
])
def test_what_is_wrong_in_a_file_of_particles_is_named(freefem_refused, reading, tmp_path, head, row, complaint):
    file = tmp_path / "disks.csv"
    file.write_text(f"{head}\n{row}\n")
    assert complaint in freefem_refused(3, reading, "-particles", file)


@pytest.mark.parametrize("text,words", [
    ("id,x,y,radius\n0,1,1,0.1\n", "first line"),
    ("id,x,y,radius,density\n0,1,1,0.1,abc\n", "missing or bad number"),
    ("id,x,y,radius,density\n0,1,1,0.1,2\n0,1,3,0.1,2\n", "second time"),
    ("id,x,y,radius,density\n0,1,1,-0.1,2\n", "radius"),
    ("id,x,y,radius,density,colour\n0,1,1,0.1,2,3\n", "first line"),
    ("id,x,y,radius,density,x\n0,1,1,0.1,2,3\n", "first line"),
    ("id,x,y,radius,density,aspect\n0,1,1,0.1,2,1.5\n", "minor over the major"),
    ("id,x,y,radius,density,free\n0,1,1,0.1,2,0.5\n", "1: it moves freely"),
    ("id,x,y,radius,density,free,turns\n0,1,1,0.1,2,0,0.5\n", "1: it turns freely"),
    ("id,x,y,radius,density,turns\n0,1,1,0.1,2,0\n", "1: it turns freely"),
    ("id,x,y,radius,density,friction\n0,1,1,0.1,2,-1\n", "coefficient of friction -1;"),
    ("id,x,y,radius,density,restitution\n0,1,1,0.1,2,1.1\n", "coefficient of restitution 1.1;"),
])
def test_a_bad_list_of_particles_is_refused(freefem, reading, tmp_path, text, words):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    done = freefem(reading, "-particles", file, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and words in done.stdout + done.stderr


def test_what_windows_and_spreadsheets_write_is_read(freefem_text, tmp_path):
    """Numbers such as 5., blanks beside names and numbers, line ends and a byte order mark of Windows, in particles and in a
    mesh."""
    mesh = (ROOT / "meshes/cavity.mesh").read_bytes()
    (tmp_path / "windows.mesh").write_bytes(mesh.replace(b"\n", b"\r\n"))
    (tmp_path / "windows.csv").write_bytes(b"\xef\xbb\xbfid, x,y , radius,density\r\n7,5.,-.5,1.e-1,2\r\n9,3, 4.e0 ,1,2.\r\n")
    got = freefem_text(f"""include "lib/bodies/read_particles.idp"
include "lib/mesh/read_mesh.idp"
bodyRead("{tmp_path}/windows.csv");
mesh Th = meshRead("{tmp_path}/windows.mesh"), Ts = meshRead("meshes/cavity.mesh");
cout << "read " << bodyNumber << " " << bodyId[0] << " " << bodyX[0] << " " << bodyY[0] << " " << bodyRadius[0] << " " << bodyId[1] << " " << bodyY[1] << " " << bodyDensity[1] << " " << Th.nt - Ts.nt << " " << Th.nbe - Ts.nbe << " " << int1d(Th, labelTop)(x) - int1d(Ts, labelTop)(x) << endl;
""").stdout
    line = next(line for line in got.splitlines() if line.startswith("read "))
    assert [float(word) for word in line.split()[1:]] == [2, 7, 5, -0.5, 0.1, 9, 4, 2, 0, 0, 0]
    assert read_table(tmp_path / "windows.csv")["id"].tolist() == [7, 9]


def test_lines_of_blanks_are_no_particles(freefem_text, tmp_path):
    (tmp_path / "some.csv").write_text("id,x,y,radius,density\n7,5,0,1,2\n   \n \t\r\n9,8,0,1,2\n  ")
    got = freefem_text(f"""include "lib/bodies/read_particles.idp"
bodyRead("{tmp_path}/some.csv");
cout << "read " << bodyNumber << " " << bodyId[1] << endl;""").stdout
    assert "read 2 9" in got


def test_columns_stand_in_any_order_and_make_ellipses_held_and_pinned_bodies(freefem, tmp_path):
    """As the same scene written into the case."""
    (tmp_path / "scene.csv").write_text("theta,x,y,aspect,turns,id,radius,density,free,u\n0.7,0.8,1.5,0.5,1,0,0.4,1.3,1,0\n0,1.3,3,1,0,1,0.2,1,0,0.5\n0.2,0.8,2.9,0.5,1,2,0.3,1.1,0,0\n")
    box = (ROOT / "cases/template.edp").read_text()
    bodies = box[box.index("macro caseParticles()"):box.index("include \"scripts/resolved.edp\"")]
    inside = "bodyEllipse(0.8, 1.5, 0.4, 0.2, 0.7, 1.3); bodyAdd(1.3, 3, 0.2, 1, 0.5, 0, 0, 0); bodyPinned(bodyEllipse(0.8, 2.9, 0.3, 0.15, 0.2, 1.1));"
    for name, text, words in (("file", "", ("-particles", tmp_path / "scene.csv")), ("case", inside, ())):
        (tmp_path / f"{name}.edp").write_text(box.replace(bodies, f"macro caseParticles() {text} // EOM\n"))
        freefem(tmp_path / f"{name}.edp", *words, "-tend", 0.02, "-out", tmp_path / name)
    assert (tmp_path / "file/particles.csv").read_bytes() == (tmp_path / "case/particles.csv").read_bytes()
    assert (tmp_path / "file/shapes.csv").read_bytes() == (tmp_path / "case/shapes.csv").read_bytes()
    rows = read_table(tmp_path / "file/particles.csv")
    assert set(rows["u"][rows["id"] == 1]) == {0.5} and abs(rows["omega"][rows["id"] == 0]).max() > 0
    pinned = rows["id"] == 2
    assert set(rows["u"][pinned]) == {0} and abs(rows["omega"][pinned]).max() > 0


def test_an_id_of_the_case_itself_is_told_from_one_given_twice(freefem_refused, tmp_path):
    (tmp_path / "more.csv").write_text("id,x,y,radius,density\n5,0.4,1,0.2,2\n0,0.4,2,0.2,2\n")
    line = freefem_refused(3, "cases/template.edp", "-particles", tmp_path / "more.csv", "-out", tmp_path / "run")
    assert "has a particle 0, an id that a particle of the case itself has; ids from 3 on are free" in line


@pytest.mark.parametrize("values", ["1e31, 0, 0", "0, 1e31, 0", "0, 0, 1e31", "0, sqrt(-bodyX[0]), 0"])
def test_a_velocity_that_is_no_number_is_refused(freefem_text, values):
    text = f'include "lib/bodies/bodies.idp"\nbodyDisk(1, 1, 0.1, 2);\nbodyAdd(2, 1, 0.1, 2, {values}, 1);\nbodyDisk(3, 1, 0.1, 2);\nbodyCheck();\n'
    done = freefem_text(text, check=False)
    assert done.returncode == 3 and "particle 1 has" in done.stderr and "velocity that is not finite" in done.stderr


def test_nonsense_ellipses_are_refused(freefem_text):
    text = 'include "lib/bodies/bodies.idp"\noptCase("bad", "test"); optEnd();\nbodyEllipse(0, 0, 0.1, 0.2, 0, 1.);\n'
    done = freefem_text(text, check=False)
    assert done.returncode == 3 and "semi-axes" in done.stderr
