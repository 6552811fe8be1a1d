"""Contacts alone reach the end of the run."""
import pytest

from tools.base.run_folder import RunFolder


@pytest.mark.parametrize("tend, steps, end", [("0.009", 1, 0.009), ("0.03", 2, 0.03), ("0.04", 2, 0.04)])
def test_contacts_alone_reach_the_end(freefem, tmp_path, tend, steps, end):
    done = freefem("cases/falling_particles.edp", "-number", "3", "-tend", tend, "-dt", "0.02", "-every", "0", "-out",
        tmp_path / "run")
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
