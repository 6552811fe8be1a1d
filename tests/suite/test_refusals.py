"""What is refused at the start, in one line and before there is a folder: options, schemes, folders, sizes."""
import pytest

from tests.conftest import ROOT, run_freefem
from tests.scenes import READING, particles
from tools.base.run_folder import RunFolder


@pytest.mark.parametrize("words, says", [
    (["-dt", "0"], "must be above 0"),
    (["-tend", "never"], "needs a number"),
    (["-stabilise", "-1"], "must not be below 0"),
    (["-mesh", "nowhere.mesh"], "cannot read the mesh"),
    (["-mesh", "meshes/cavity.mesh"], "label"),
    (["-tned", "1"], "-tend"),
    (["-inflow", "slowly"], "must be one of"),
])
def test_bad_input_is_refused_in_words(words, says, run_folder):
    run = run_freefem("cases/cylinder_channel.edp", "-out", run_folder, *words, check=False)
    assert run.returncode == 3, run.stdout + run.stderr
    assert says in run.stderr
    assert not (run_folder / "fluid.csv").exists()


@pytest.mark.parametrize("words, complaint", [
    (["cases/rotating_cylinder.edp", "-scheme", "published"], "a fixed particle, or one with prescribed motion"),
    (["cases/ellipse_in_shear.edp", "-scheme", "published"], "ellipse"),
    (["cases/settling_disk.edp", "-scheme", "tensorial", "-film", "1"], "-film"),
    (["cases/settling_disk.edp", "-scheme", "multipliers", "-rhos", "1"], "not denser than the fluid"),
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


@pytest.mark.parametrize("words", [["-dt"], ["-number"], ["-mesh"], ["-scheme"], ["-dt", "0.01", "-dt", "0.02"],
    ["-seed", "1", "-seed", "2"]], ids=" ".join)
def test_an_option_without_a_value_or_twice_is_refused_by_a_case(freefem_refused, words):
    assert f"option {words[0]} " in freefem_refused(3, "cases/pipe_obstacles.edp", *words)


@pytest.mark.parametrize("right, wrong, says", [
    ("flowPeriodX = 0", "flowPeriodX = -2", "flowPeriodX is -2"),
    ("flowPeriodY = 0", "flowPeriodY = sqrt(-mu)", "a period is above 0, and 0 is none"),
    ("motionBound = 1e30", "motionBound = sqrt(-mu)", "motionBound is"),
])
def test_a_number_of_the_case_that_makes_no_sense_is_refused(freefem_text, right, wrong, says):
    """A negative period was taken for none, a bound that is no number for one that is never reached."""
    done = freefem_text((ROOT / "cases/template.edp").read_text().replace(right, wrong), "-tend", 0.01, check=False)
    assert done.returncode == 3 and says in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.parametrize("words, says", [
    ("bodyEllipse(1, 1, 0.2, 0.1, 0, 1.2);", "a particle is added at (1, 1) after the run has begun"),
    ('real late = optReal("-late", 1, "", "an option");', "-late is declared after the driver has read the command"),
    ('optDefault("-dt", "0.1");', "the default of -dt is set after the driver has read"),
])
def test_what_stands_behind_the_driver_is_refused(freefem_text, tmp_path, words, says):
    """It was passed over in silence, and bodies that caseStep added overlapped others. The run before stays finished."""
    done = freefem_text(f'{READING}outEnd(0., 0, "finished");\n{words}', "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert RunFolder(tmp_path / "run").info["status"] == "finished"


def test_a_motion_of_the_case_is_refused_by_other_schemes(freefem_text):
    text = (ROOT / "cases/template.edp").read_text().replace("bodyEllipse(1.,", "if (0) bodyEllipse(1.,")
    text = text.replace("macro caseP", "macro caseMotion(now) givenMotion(0, 1, 0, 0); // EOM\nmacro caseP")
    done = freefem_text(text, "-scheme", "tensorial", check=False)
    assert done.returncode == 3 and "(caseMotion) is for -scheme standard" in done.stderr and done.stderr.count("\n") == 1


def test_a_case_without_a_driver_is_refused(freefem_text, tmp_path):
    """It computed nothing and ended with status 0."""
    text = (ROOT / "cases/template.edp").read_text()
    done = freefem_text(text.replace('include "scripts/resolved.edp"', '// include "scripts/resolved.edp"'), "-tend", 0.01,
        check=False)
    assert done.returncode == 3 and "script.edp includes no driver" in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_folder_with_other_files_is_left_alone(freefem_refused, tmp_path):
    (tmp_path / "particles.csv").write_text("precious")
    for more in ([], ["-overwrite", "1"]):
        assert "contains files, but no run" in freefem_refused(3, "cases/settling_disk.edp", "-tend", "0.01", "-out", tmp_path,
            *more)
    assert (tmp_path / "particles.csv").read_text() == "precious" and len(list(tmp_path.iterdir())) == 1


def test_an_input_in_the_folder_of_the_run_is_not_overwritten(freefem, freefem_refused, tmp_path):
    """A file of the run itself is refused as input; one that the user has put there stays, and is read."""
    freefem("cases/settling_disk.edp", "-tend", "0.01", "-out", tmp_path / "run")
    words = ["cases/settling_disk.edp", "-tend", "0.01", "-out", tmp_path / "run", "-overwrite", "1", "-particles"]
    file = tmp_path / "run/disks.csv"
    file.write_text("id,x,y,radius,density\n5,1,2,0.125,2\n")
    freefem(*words, file)
    with open(tmp_path / "run/.files", "a") as owned:
        owned.write("disks.csv\n")
    assert "would delete" in freefem_refused(3, *words, file)
    assert (tmp_path / "run/particles.csv").exists()
    assert file.read_text() == "id,x,y,radius,density\n5,1,2,0.125,2\n"


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
    with open(tmp_path / "run/.files", "a") as owned:
        owned.write("steady_flow.txt\n")
    assert "-overwrite 1 would delete what -flow reads" in freefem_refused(3, *words, "-overwrite", 1, "-flow", f"{tmp_path}/run/")
    assert (tmp_path / "run/steady_flow.txt").exists() and (tmp_path / "run/run.json").exists()
    freefem(*words, "-overwrite", 1)
    assert not (tmp_path / "run/steady_flow.txt").exists()


def test_a_pipe_of_another_size_than_its_mesh_is_refused(freefem_refused):
    for words in (["-radius", "0.2"], ["-length", "5"]):
        assert "not what -length and -radius say" in freefem_refused(3, "cases/pipe_obstacles.edp", *words)


@pytest.mark.parametrize("words", [["-radius", "0.3"], ["-neck", "0.8"]])
def test_an_impossible_hourglass_is_refused(freefem_refused, words):
    assert words[0] in freefem_refused(3, "cases/hourglass.edp", *words)


def test_forces_without_a_cylinder_are_refused(freefem_refused, tmp_path):
    assert "label cylinder" in freefem_refused(3, "cases/poiseuille.edp", "-forces", "1", "-tend", "0.1", "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_disk_too_fast_for_any_step_stops_the_run(freefem_refused, tmp_path):
    disks = particles(tmp_path, (1, 1.2, 3, 0.125, 1.25, 1e12, 0, 0))
    line = freefem_refused(4, "cases/settling_disk.edp", "-particles", disks, "-out", tmp_path / "run")
    assert "-cfl allows no more than steps of" in line and len(RunFolder(tmp_path / "run").table("particles")["t"]) == 0
