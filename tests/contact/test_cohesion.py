"""Contacts that stick (contacts alone)."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tests.tables import assert_refused
from tools.base.tables import read_table

PLANE = dict(bodies="bodyDisk(0, 0.1, 0.1, 1000);", walls="contactWallSegment(-100, 0, 100, 0);")
TURN = "real turned = optReal(\"-turned\", 0.5, \"s\", \"when gravity is reversed\");" \
    "macro caseStep() if (timeNow > turned - 1e-9) gravityY = 9.81; // EOM"


@pytest.mark.parametrize("dt", [0.02, 0.005])
@pytest.mark.parametrize("most", [100, 2])
def test_a_disk_leaves_a_plane_at_the_exact_time(most, dt, freefem_text, tmp_path):
    """Gravity presses it for 0.5 s, then pulls: it holds until pulls have used up what has pressed it, p_max at most (Lefebvre
    2009)."""
    freefem_text(CONTACTS.format(**PLANE, gravity=-9.81, more=TURN), "-cohesion", most, "-dt", dt, "-tend", 1.5, "-out",
        tmp_path / "run")
    table = read_table(tmp_path / "run/particles.csv")
    leaves = 0.5 + min(0.5, most / 9.81)
    t, v = np.array(table["t"]), np.array(table["v"])
    assert v == pytest.approx(9.81 * np.maximum(0, t - leaves), abs=1e-9)
    contacts = read_table(tmp_path / "run/contacts.csv")
    mass = 1000 * np.pi * 0.01
    signs = np.where(np.array(contacts["t"]) < 0.5 + dt / 2, 1, -1)
    held = np.array(contacts["t"]) < leaves - 1e-9  # the last pull may be part of a step
    assert np.array(contacts["impulse"])[held] == pytest.approx(signs[held] * mass * 9.81 * dt, rel=1e-9)


def test_disks_stick_together_and_keep_their_momentum(freefem_text, tmp_path):
    """The impulse of the collision is what holds them: the third one, which pulls with less, goes along; one that is faster
    leaves."""
    pair = "bodyAdd(-0.1001, 0, 0.1, 1000, 1, 0, 0, 1); bodyAdd(0.1001, 0, 0.1, 1000, -1, 0, 0, 1);"
    freefem_text(CONTACTS.format(bodies=pair, walls="", gravity=0, more="macro caseStep() if (abs(timeNow - 0.1) < 1e-9) { "
        "driveU[0] -= 0.6; driveU[1] += 0.6; } if (abs(timeNow - 0.2) < 1e-9) { driveU[0] -= 0.6; driveU[1] += 0.6; } // EOM"),
        "-cohesion", 10, "-dt", 0.01, "-tend", 0.3, "-every", 0.01, "-out", tmp_path / "run")
    table = read_table(tmp_path / "run/particles.csv")
    first, t = np.array(table["u"])[::2], np.array(table["t"])[::2]
    assert abs(first[(t > 0.015) & (t < 0.195)]).max() < 1e-9 and first[-1] == pytest.approx(-0.2, abs=3e-2)
    assert np.array(table["u"])[::2] == pytest.approx(-np.array(table["u"])[1::2], abs=1e-12)


def test_a_glued_scene_goes_on_bit_for_bit(freefem_text, tmp_path):
    text = CONTACTS.format(**PLANE, gravity=-9.81, more=TURN)
    freefem_text(text, "-cohesion", 100, "-dt", 0.01, "-tend", 1.2, "-out", tmp_path / "whole")
    freefem_text(text, "-cohesion", 100, "-dt", 0.01, "-tend", 0.7, "-checkpoint", 70, "-out", tmp_path / "part")
    freefem_text(text, "-cohesion", 100, "-dt", 0.01, "-tend", 1.2, "-restart", tmp_path / "part", "-out", tmp_path / "part")
    assert (tmp_path / "whole/particles.csv").read_bytes() == (tmp_path / "part/particles.csv").read_bytes()


@pytest.mark.parametrize("words", [("-friction", 0.3), ("-restitution", 0.5), ("-contact-form", "ballistic")])
def test_cohesion_goes_alone(words, freefem_text, tmp_path):
    done = freefem_text(CONTACTS.format(**PLANE, gravity=-9.81, more=""), "-cohesion", 1, *words, "-out", tmp_path / "run",
        check=False)
    assert_refused(done, [3], "cohesion is for contacts without friction and restitution")
