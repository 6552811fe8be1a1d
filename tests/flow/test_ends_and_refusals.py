"""Where a domain ends: plates that move along themselves, inlets, the sides of a period; and what is refused at the start."""
import numpy as np
import pytest

from tests.conftest import ROOT
from tools.run_folder import RunFolder

HEAD = "id,x,y,radius,density,u,v,omega\n"


def particles(folder, *rows):
    path = folder / "disks.csv"
    path.write_text(HEAD + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    return path


def test_a_moving_plate_stops_a_disk(freefem, tmp_path):
    disks = particles(tmp_path, (5, 0.6, 0.8, 0.08, 50, 0, 2, 0))
    words = ["cases/couette_disk.edp", "-particles", disks, "-reynolds", "10", "-dt", "0.005", "-tend", "0.15"]
    freefem(*words, "-every", "0", "-out", tmp_path / "all")
    run = RunFolder(tmp_path / "all")
    fluid, disk = run.table("fluid"), run.table("particles")
    thrown = disk["id"] == 5
    assert fluid["contacts"].max() == 1
    assert (1 - 0.08 - disk["y"][thrown]).min() > -1e-9 and disk["v"][thrown].max() > 1
    freefem(*words, "-every", "0.07", "-out", tmp_path / "few")
    few = RunFolder(tmp_path / "few").table("fluid")
    assert len(few["t"]) < 5 and few["worst_gap"].min() == fluid["worst_gap"].min()


def test_a_disk_beyond_a_plate_of_a_periodic_domain_is_refused(freefem_refused, tmp_path):
    out = particles(tmp_path, (5, 0.5, 1.6, 0.08, 1, 0, 0, 0))
    assert "outside the mesh" in freefem_refused(5, "cases/couette_disk.edp", "-particles", out, "-tend", "0.01", "-out", tmp_path / "run")


def test_a_disk_that_leaves_by_the_inlet_is_taken_out(freefem, coarse, tmp_path):
    disks = particles(tmp_path, (5, 0.03, 0, 0.01, 5000, -6, 0, 0))
    freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", "0", "-particles", disks, "-tend", "0.05", "-every", "0", "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.table("fluid")["particles"][-1] == 0
    assert run.table("particles")["x"].min() > -0.03  # out of the fluid nothing moves it on


def test_published_scheme_starts_with_the_velocities_given(freefem, tmp_path):
    disks = particles(tmp_path, (5, 0.5, 2, 0.25, 2, 0, -5, 0))
    freefem("cases/settling_disk.edp", "-particles", disks, "-scheme", "published", "-dt", "0.001", "-tend", "0.001", "-out", tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("particles")
    # the fluid takes its share at once: two thirds are left of -5, and gravity adds 0.3
    assert table["v"][table["id"] == 5][-1] == pytest.approx(-5 * 2 / 3 - 0.3, rel=0.25)


def test_published_scheme_records_where_a_disk_is_at_the_time_of_the_row(freefem, shaft, tmp_path):
    disks = particles(tmp_path, (5, 0.5, 2, 0.25, 2, 0, -5, 0))
    freefem("cases/settling_disk.edp", *shaft[:-1], 1, "-particles", disks, "-scheme", "published", "-dt", "0.002", "-tend", "0.003", "-out", tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("particles")
    one = table["id"] == 5
    t, y = np.append(0, table["t"][one]), np.append(2, table["y"][one])
    assert t[-1] == pytest.approx(0.003) and np.diff(y) == pytest.approx(np.diff(t) * table["v"][one], rel=1e-6)


def test_published_scheme_counts_no_contacts_of_disks_that_have_left(freefem, coarse, tmp_path):
    disks = particles(tmp_path, (5, 0.999, 0, 0.01, 5000, 6, 1, 0), (6, 0.999, 0.02001, 0.01, 5000, 6, -1, 0))
    freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", "0", "-particles", disks, "-scheme", "published", "-dt", "0.007", "-convection", "0", "-every", "0", "-tend", "0.014",
            "-out", tmp_path / "run")
    fluid = RunFolder(tmp_path / "run").table("fluid")
    gone = fluid["particles"] == 0
    assert gone.sum() > 1 and not fluid["contacts"][gone].any()  # they press each other in the step that takes them out
    assert len((tmp_path / "run/contacts.csv").read_text().splitlines()) == 1


def test_published_scheme_carries_a_disk_over_the_seam(freefem, cell, tmp_path):
    disks, found = particles(tmp_path, (5, 0.92, 0.75, 0.1, 1, 0.25, 0, 0)), {}
    for scheme in ("standard", "published"):
        freefem("cases/couette_disk.edp", "-mesh", cell, "-particles", disks, "-reynolds", "0", "-scheme", scheme, "-dt", "0.02", "-tend", "0.8", "-out", tmp_path / scheme)
        table = RunFolder(tmp_path / scheme).table("particles")
        beyond = (table["id"] == 5) & (table["x"] > 1)
        found[scheme] = {name: table[name][beyond].mean() for name in ("u", "omega")}
    assert beyond.sum() > 10
    # in the mean: the turning of a disk with four elements across wavers by a half
    assert found["published"]["u"] == pytest.approx(found["standard"]["u"], rel=0.05)
    assert found["published"]["omega"] == pytest.approx(found["standard"]["omega"], rel=0.2)


@pytest.mark.parametrize("words, complaint", [
    (["cases/rotating_cylinder.edp", "-scheme", "published"], "a fixed particle, or one with prescribed motion"),
    (["cases/ellipse_in_shear.edp", "-scheme", "published"], "ellipse"),
    (["cases/segre_silberberg.edp", "-scheme", "published"], "periodic"),
    (["cases/couette_disk.edp", "-scheme", "published"], "periodic"),
    (["cases/settling_disk.edp", "-scheme", "published", "-forces", "1"], "-forces"),
    (["cases/settling_disk.edp", "-scheme", "published", "-budget", "1"], "-budget"),
    (["cases/settling_disk.edp", "-scheme", "published", "-checkpoint", "5"], "-checkpoint"),
    (["cases/settling_disk.edp", "-contact-form", "ballistic"], "contacts alone"),
    (["cases/couette_disk.edp", "-budget", "1"], "closed box"),
])
def test_what_a_scheme_does_not_do_is_refused_before_there_is_a_folder(freefem_refused, tmp_path, words, complaint):
    assert complaint in freefem_refused(3, *words, "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("words", [["-dt"], ["-number"], ["-mesh"], ["-scheme"], ["-dt", "0.01", "-dt", "0.02"], ["-seed", "1", "-seed", "2"]], ids=" ".join)
def test_an_option_without_a_value_or_twice_is_refused_by_a_case(freefem_refused, words):
    assert f"option {words[0]} " in freefem_refused(3, "cases/pipe_obstacles.edp", *words)


def test_a_case_without_a_driver_is_refused(freefem_text, tmp_path):
    """It computed nothing and ended with status 0."""
    text = (ROOT / "cases/template.edp").read_text()
    done = freefem_text(text.replace('include "scripts/resolved.edp"', '// include "scripts/resolved.edp"'), "-tend", 0.01, check=False)
    assert done.returncode == 3 and "script.edp includes no driver" in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_folder_with_other_files_is_left_alone(freefem_refused, tmp_path):
    (tmp_path / "particles.csv").write_text("precious")
    for more in ([], ["-overwrite", "1"]):
        assert "contains files, but no run" in freefem_refused(3, "cases/settling_disk.edp", "-tend", "0.01", "-out", tmp_path, *more)
    assert (tmp_path / "particles.csv").read_text() == "precious" and len(list(tmp_path.iterdir())) == 1


def test_an_input_in_the_folder_of_the_run_is_not_overwritten(freefem, freefem_refused, tmp_path):
    freefem("cases/settling_disk.edp", "-tend", "0.01", "-out", tmp_path / "run")
    file = tmp_path / "run/disks.csv"
    file.write_text("id,x,y,radius,density\n5,1,2,0.125,2\n")
    words = ["cases/settling_disk.edp", "-tend", "0.01", "-particles", file, "-out", tmp_path / "run", "-overwrite", "1"]
    assert "would delete" in freefem_refused(3, *words)
    assert file.exists() and (tmp_path / "run/particles.csv").exists()


def test_a_folder_that_the_run_reads_is_not_overwritten(freefem, freefem_refused, tmp_path):
    """As -flow of pipe_transport; -out itself is not read."""
    script = """include "lib/core/output.idp"
optCase("reader", "reads a folder");
string folder = optFile("-flow", "", "folder of a run");
outDeclare();
optEnd();
outBegin("");
outEnd(1., 1, "finished");
"""
    (tmp_path / "reader.edp").write_text(script)
    words = [tmp_path / "reader.edp", "-out", tmp_path / "run"]
    freefem(*words)
    (tmp_path / "run/steady_flow.txt").write_text("precious")
    assert "-overwrite 1 would delete what -flow reads" in freefem_refused(3, *words, "-overwrite", 1, "-flow", f"{tmp_path}/run/")
    assert (tmp_path / "run/steady_flow.txt").exists() and (tmp_path / "run/run.json").exists()
    freefem(*words, "-overwrite", 1)
    assert not (tmp_path / "run/steady_flow.txt").exists()


def test_a_pipe_of_another_size_than_its_mesh_is_refused(freefem_refused):
    for words in (["-radius", "0.2"], ["-length", "5"]):
        assert "not what -length and -radius say" in freefem_refused(3, "cases/pipe_obstacles.edp", *words)


@pytest.mark.parametrize("rows, complaint", [("5,1,2,x,2\n", "line 2"), ("", "contains no particle"), ("5,1,2,0.1,2\n\n6,1,3,0.1\n", "line 4")])
def test_a_bad_file_of_particles_is_refused_with_its_line(freefem_refused, tmp_path, rows, complaint):
    file = tmp_path / "disks.csv"
    file.write_text("id,x,y,radius,density\n" + rows)
    assert complaint in freefem_refused(3, "cases/settling_disk.edp", "-particles", file)


@pytest.mark.parametrize("head, row, complaint", [
    ("id,x,y,radius,mass", "5,1,2,0.1,2", "the column 'mass'"),
    ("id,x,y,radius,density,x", "5,1,2,0.1,2,1", "the column 'x'"),
    ("id,x,y,radius", "5,1,2,0.1", "lacks the column density"),
    ("id,x,y,radius,density", "5,1,2,0.1,2\n5,1,4,0.1,2", "line 3: particle 5 is listed a second time"),
])
def test_what_is_wrong_in_a_file_of_particles_is_named(freefem_refused, tmp_path, head, row, complaint):
    file = tmp_path / "disks.csv"
    file.write_text(f"{head}\n{row}\n")
    assert complaint in freefem_refused(3, "cases/settling_disk.edp", "-particles", file)


@pytest.mark.parametrize("words", [["-radius", "0.3"], ["-neck", "0.8"]])
def test_an_impossible_hourglass_is_refused(freefem_refused, words):
    assert words[0] in freefem_refused(3, "cases/hourglass.edp", *words)


def test_forces_without_a_cylinder_are_refused(freefem_refused, tmp_path):
    assert "label cylinder" in freefem_refused(3, "cases/poiseuille.edp", "-forces", "1", "-tend", "0.1", "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("tend, steps, end", [("0.009", 1, 0.009), ("0.03", 2, 0.03), ("0.04", 2, 0.04)])
def test_contacts_alone_reach_the_end(freefem, tmp_path, tend, steps, end):
    done = freefem("cases/falling_particles.edp", "-number", "3", "-tend", tend, "-dt", "0.02", "-every", "0", "-out", tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("motion")
    assert table["step"].tolist() == list(range(steps + 1)) and table["t"][-1] == pytest.approx(end)
    assert f"finished at t = {end:g} s after {steps} step" in done.stdout


def test_contacts_alone_of_no_disk_say_the_time_of_the_end(freefem_text, tmp_path):
    scene = """include "lib/case.idp"
optCase("empty", "no disk at all");
real gravityX = 0, gravityY = -9.81;
macro caseParticles() // EOM
macro caseWalls() contactWallSegment(0., 0., 1., 0.); // EOM
include "scripts/contacts.edp"
"""
    done = freefem_text(scene, "-tend", "0.5", "-dt", "0.01", "-out", tmp_path / "run")
    assert "finished at t = 0.5 s after 50 steps" in done.stdout


def test_a_disk_too_fast_for_any_step_stops_the_run(freefem_refused, tmp_path):
    disks = particles(tmp_path, (1, 1.2, 3, 0.125, 1.25, 1e12, 0, 0))
    line = freefem_refused(4, "cases/settling_disk.edp", "-particles", disks, "-out", tmp_path / "run")
    assert "-cfl allows no more than steps of" in line and len(RunFolder(tmp_path / "run").table("particles")["t"]) == 0


def test_a_mesh_of_savemesh_is_read_again_from_the_folder_of_the_run(freefem, freefem_text, freefem_refused, tmp_path):
    """savemesh names a second file beside the mesh, without which FreeFEM reads neither."""
    freefem_text(f'mesh Th = readmesh("meshes/poiseuille.mesh");\nsavemesh(Th, "{tmp_path}/mine.mesh");\n')
    assert "Geometry" in (tmp_path / "mine.mesh").read_text()
    freefem("cases/poiseuille.edp", "-mesh", tmp_path / "mine.mesh", "-tend", 0.01, "-out", tmp_path / "run")
    (tmp_path / "mine.mesh.gmsh").unlink()
    freefem("cases/poiseuille.edp", "-mesh", tmp_path / "run/mesh.mesh", "-tend", 0.01, "-out", tmp_path / "again")
    assert "Geometry" in freefem_refused(3, "cases/poiseuille.edp", "-mesh", tmp_path / "mine.mesh", "-out", tmp_path / "none")


@pytest.mark.parametrize("x, warned", [(0.02, True), (0.3, False)])
def test_a_disk_that_reaches_into_an_inlet_is_warned_of(x, warned, freefem, coarse, tmp_path):
    disks = particles(tmp_path, (7, x, 0, 0.05, 1200, 0, 0, 0))
    done = freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", 0, "-particles", disks, "-tend", 0.001, "-dt", 0.001, "-out", tmp_path / "run")
    assert ("particle 7 overlaps an inlet" in done.stdout + done.stderr) == warned
