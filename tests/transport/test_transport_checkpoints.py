"""Carried particles go on from a checkpoint bit for bit."""
import pytest

from tests.conftest import ROOT, make_mesh
from tests.scenes import ANALYTIC
from tests.tables import records

QUEUE = ["-tend", 0.12, "-checkpoint", 20]


@pytest.mark.parametrize("more", [["-turbulence", "fluctuation"], ["-turbulence", "paper", "-history", 0], ["-coupling", "two-way",
    "-coupling-solver", "umfpack"]])
def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(freefem, tmp_path, more):
    """With particles that wait, seeded turbulence, history and contacts; the one that goes on lacks the last checkpoint and has
    rows too many."""
    words = ["-mesh", make_mesh(tmp_path / "pipe.mesh", "pipe_obstacles", "--size", 0.025), *QUEUE, *more]
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    freefem("tests/transport/scripts/queue.edp", *words, "-out", whole)
    freefem("tests/transport/scripts/queue.edp", *words[:2], "-tend", 0.1, *words[4:], "-out", broken)
    for file in broken.glob("restart_000000050*"):
        file.unlink()
    freefem("tests/transport/scripts/queue.edp", *words, "-restart", broken)
    names = ["particles.csv", "entries.csv", "exits.csv", "contacts.csv"]
    assert len(records(whole / "entries.csv")) > 12 and len(records(whole / "contacts.csv")) > 5
    waiting = [int(row["waiting"]) for row in records(whole / "steps.csv") if int(row["step"]) == 40][0]
    assert waiting > 0
    for name in names:
        assert (whole / name).read_bytes() == (broken / name).read_bytes(), name
    for name in ["steps.csv"] + (["coupling.csv"] if "two-way" in more else []):
        for one, other in zip(records(whole / name), records(broken / name), strict=True):
            assert {key: value for key, value in one.items() if "time" not in key} == {key: value for key, value in other.items()
                if "time" not in key}, name


def test_who_enters_after_a_restart_draws_as_before_whatever_else_drew(freefem_text, coarse, tmp_path):
    """Particles that are there at the start draw before the queue resets FreeFEM's generator."""
    text = (ROOT / "tests/transport/scripts/queue.edp").read_text()
    first = "real[int] x0 = [0.01], y0 = [0.05], r0 = [0.005], d0 = [2500.], z0 = [0.]; transportAppend(x0, y0, r0, d0, z0, z0, z0);"
    text = text.replace("macro caseParticles() ", "macro caseParticles() " + first + " ")
    words = ["-mesh", coarse, "-checkpoint", 5, "-out"]
    freefem_text(text, "-tend", 0.04, *words, tmp_path / "whole")
    freefem_text(text, "-tend", 0.02, *words, tmp_path / "broken")
    freefem_text(text, "-tend", 0.04, *words[:-1], "-restart", tmp_path / "broken")
    entries = [float(row["t"]) for row in records(tmp_path / "whole/entries.csv")]
    assert entries[0] == 0 and max(entries) > 0.02
    assert (tmp_path / "whole/particles.csv").read_bytes() == (tmp_path / "broken/particles.csv").read_bytes()


def test_a_restart_with_other_options_or_without_a_checkpoint_is_refused(freefem, coarse, tmp_path):
    words = ["-mesh", coarse, "-tend", 0.01, "-checkpoint", 2]
    freefem("tests/transport/scripts/queue.edp", *words, "-out", tmp_path / "run")
    for folder, more in (("run", ["-lift", 0]), ("nowhere", [])):
        done = freefem("tests/transport/scripts/queue.edp", *words, *more, "-restart", tmp_path / folder, check=False)
        assert done.returncode == 3 and len(done.stderr.splitlines()) == 1
    done = freefem("tests/transport/scripts/queue.edp", "-mesh", "meshes/pipe_obstacles.mesh", "-checkpoint", 2, "-tend", 0.02,
        "-restart", tmp_path / "run", check=False)
    assert done.returncode == 3 and "another mesh" in done.stderr


def test_a_restart_keeps_its_step(freefem, freefem_refused, tmp_path):
    freefem(ANALYTIC, "-out", tmp_path / "run", "-tend", 0.01, "-dt", 0.003, "-checkpoint", 2)
    assert "steps of 0.0025 s" in freefem_refused(3, ANALYTIC, "-out", tmp_path / "more", "-tend", 0.021, "-dt", 0.003, "-restart",
        tmp_path / "run")


def test_carried_particles_go_on_in_the_midst_of_their_history(freefem, coarse, tmp_path):
    """A checkpoint whose step is no multiple of the window of the history force."""
    words = ["-mesh", coarse, "-checkpoint", 15, "-turbulence", "fluctuation", "-tend"]
    freefem("tests/transport/scripts/queue.edp", *words, 0.12, "-out", tmp_path / "whole")
    freefem("tests/transport/scripts/queue.edp", *words, 0.1, "-out", tmp_path / "broken")
    for file in (tmp_path / "broken").glob("restart_000000050*"):
        file.unlink()
    freefem("tests/transport/scripts/queue.edp", *words, 0.12, "-restart", tmp_path / "broken")
    assert (tmp_path / "whole" / "particles.csv").read_bytes() == (tmp_path / "broken" / "particles.csv").read_bytes()


def test_carried_particles_make_a_step_at_least_before_maxwall(freefem, coarse, tmp_path):
    """However long a run takes to begin: one that is begun again and again comes to its end."""
    words = ["tests/transport/scripts/queue.edp", "-mesh", coarse, "-tend", 0.006, "-maxwall", 1e-6]
    for step in (1, 2):
        done = freefem(*words, *(["-out"] if step == 1 else ["-restart"]), tmp_path / "run")
        assert f"stopped by -maxwall at t = {0.002 * step:g} s" in done.stdout, done.stdout
    assert "finished at t = 0.006 s" in freefem(*words, "-restart", tmp_path / "run").stdout
    freefem(*words[:-2], "-out", tmp_path / "whole")
    assert (tmp_path / "run" / "particles.csv").read_bytes() == (tmp_path / "whole" / "particles.csv").read_bytes()
