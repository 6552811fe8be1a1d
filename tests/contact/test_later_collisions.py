"""Collisions that follow from others within a step (lib/contact/later_collisions.idp): energy at e = 1; disks that spin."""
import numpy as np
import pytest

from tests.scenes import CONTACTS
from tools.base.tables import read_table

BOX = ("contactWallSegment(0, 0, 1, 0); contactWallSegment(1, 0, 1, 0.8); contactWallSegment(1, 0.8, 0, 0.8);"
    "contactWallSegment(0, 0.8, 0, 0);")


@pytest.fixture
def energies(freefem_text, tmp_path):
    """Kinetic energies, over that at the start, of disks of masses up to so many to one in a box, in each step."""

    def run(disks, ratio, *words):
        rng = np.random.default_rng(5)
        across, up = disks
        radius = 0.4 * min(1 / across, 0.8 / up) if across > 5 else 0.05
        bodies = [f"bodyAdd({(i + 0.5) / across!r}, {(j + 0.5) * 0.8 / up!r}, {radius!r}, "
            f"{1000 * ratio ** rng.uniform(-0.5, 0.5)!r}, {rng.normal()!r}, {rng.normal()!r}, 0, 1);"
            for i in range(across) for j in range(up)]
        freefem_text(CONTACTS.format(gravity=0, walls=BOX, bodies="\n".join(bodies), more=""), *words, "-every", 0, "-out",
            tmp_path / "run")
        energy = read_table(tmp_path / "run" / "motion.csv")["kinetic_energy"]
        return np.array(energy) / energy[0]

    return run


@pytest.mark.parametrize("dt, ratio", [(0.004, 100), (0.004, 1), (0.001, 100)])
def test_nothing_is_lost_where_all_rebounds_are_whole(dt, ratio, energies):
    """A third of the energy was lost, or a tenth gained in a step."""
    energy = energies((5, 4), ratio, "-restitution", 1, "-dt", dt, "-tend", 0.6)
    assert np.diff(energy).max() < 1e-9 and energy[-1] > 1 - 1e-6


@pytest.mark.parametrize("words", [("-restitution", 1), ("-restitution", 0.9, "-friction", 0.3)])
def test_long_steps_of_a_dense_crowd_gain_nothing_and_end_well(words, energies):
    """Rebounds that ask for more room than there is are left out of the step."""
    energy = energies((8, 6), 10, *words, "-dt", 0.02, "-tend", 0.2)
    assert np.diff(energy).max() < 1e-9 and energy[-1] > 0


def test_a_disk_that_spins_bounces_with_the_whole_coefficient(freefem_text, tmp_path):
    """Friction turns rotation into translation, whose energy grows; the coefficient was halved for that."""
    radius, spin = 0.05, 200.0
    freefem_text(CONTACTS.format(gravity=0, walls="contactWallSegment(-3, 0, 3, 0);",
        bodies=f"bodyAdd(0, {radius + 0.030001}, {radius}, 1000, 0.3, -1, {spin}, 1);", more=""), "-dt", 0.001, "-tend", 0.06,
        "-every", 0.06, "-restitution", 1, "-friction", 0.5, "-friction-tol", 1e-12, "-out", tmp_path / "run")
    rows = read_table(tmp_path / "run" / "particles.csv")
    assert rows["v"][-1] == pytest.approx(1, abs=1e-9) and rows["u"][-1] == pytest.approx(0.3 - 0.5 * 2, abs=1e-9)


def test_pinned_disks_are_gears(freefem_text, tmp_path):
    """A disk that spins on two pinned ones gives them a third of its speed each: I w0 - 2 J = I w, J = I w'."""
    radius, apart = 0.01, 0.012
    bodies = f"""bodyPinned(bodyDisk({-apart}, 0, {radius}, 1000)); bodyPinned(bodyDisk({apart}, 0, {radius}, 1000));
        bodyAdd(0, {float(np.sqrt(4 * radius**2 - apart**2)) + 1e-9!r}, {radius}, 1000, 0, 0, 30, 1);"""
    freefem_text(CONTACTS.format(gravity=-9.81, walls="int none = 0;", bodies=bodies, more=""), "-dt", 0.0005, "-tend", 0.3,
        "-every", 0.1, "-friction", 0.3, "-out", tmp_path / "run")
    omega = read_table(tmp_path / "run" / "particles.csv")["omega"]
    assert omega[-3:] == pytest.approx(np.array([-10.0, -10.0, 10.0]), abs=1e-6)


def test_ellipses_that_follow_each_other_keep_their_energy(freefem_text, tmp_path):
    """Twenty of masses of a hundred to one, steps of a thousandth of a second; a tenth was lost."""
    rng = np.random.default_rng(5)
    places = [((i + 0.5) * 0.2, (j + 0.5) * 0.2) for i in range(5) for j in range(4)]
    bodies = [f"bodyEllipse({x!r}, {y!r}, 0.05, 0.04, {rng.uniform(0, 3)!r}, {1000 * 100 ** rng.uniform(-0.5, 0.5)!r});" for x,
        y in places] + [f"bodyQ[{k}] = {rng.normal()!r};" for k in range(40)]
    freefem_text(CONTACTS.format(gravity=0, walls=BOX, bodies="\n".join(bodies), more=""), "-restitution", 1, "-dt", 0.001,
        "-tend", 0.25, "-every", 0, "-out", tmp_path / "run")
    energy = np.array(read_table(tmp_path / "run" / "motion.csv")["kinetic_energy"])
    assert (np.diff(energy) < 1e-8 * energy[0]).all() and energy[-1] > (1 - 1e-6) * energy[0]
