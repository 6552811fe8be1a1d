"""Contacts alone after a restart."""
from tests.conftest import run_freefem


def test_contacts_alone_stop_at_maxwall_and_go_on(tmp_path):
    words = ["cases/falling_particles.edp", "-tend", "10"]
    assert "stopped by -maxwall" in run_freefem(*words, "-out", tmp_path / "run", "-maxwall", "0.05").stdout
    assert "finished at t = 10 s" in run_freefem(*words, "-restart", tmp_path / "run").stdout
    moved = run_freefem("cases/falling_particles.edp", "-tend", "10", "-number", "20", "-restart", tmp_path / "run", check=False)
    assert moved.returncode == 3 and "other options" in moved.stderr


def test_contacts_without_a_disk_have_their_checkpoint(freefem_text, tmp_path):
    text = """include "lib/case.idp"
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("empty", "a scene of tests/contact/test_restart_contacts.py");
optDefault("-dt", "0.01");
real gravityX = 0, gravityY = -1;
macro caseParticles() // EOM
macro caseWalls() contactWallSegment(-1, -1, 1, -1); // EOM
include "scripts/contacts.edp"
"""
    freefem_text(text, "-tend", 0.1, "-checkpoint", 5, "-out", tmp_path / "run")
    assert "goes on from t = 0.1 s, step 10" in freefem_text(text, "-tend", 0.2, "-restart", tmp_path / "run").stdout
