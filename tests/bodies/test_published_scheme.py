"""The published scheme beside the standard one: starts, rows, contacts, the seam of a period, shear, a heavy disk."""
import numpy as np
import pytest

from tests.scenes import case, particles
from tests.tables import particles_of
from tools.base.command import ROOT
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table


def test_published_scheme_starts_with_the_velocities_given(freefem, tmp_path):
    disks = particles(tmp_path, (5, 0.5, 2, 0.25, 2, 0, -5, 0))
    freefem("cases/settling_disk.edp", "-particles", disks, "-scheme", "published", "-dt", "0.001", "-tend", "0.001", "-out",
        tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("particles")
    # the fluid takes its share at once: two thirds are left of -5, and gravity adds 0.3
    assert table["v"][table["id"] == 5][-1] == pytest.approx(-5 * 2 / 3 - 0.3, rel=0.25)


def test_published_scheme_records_where_a_disk_is_at_the_time_of_the_row(freefem, shaft, tmp_path):
    disks = particles(tmp_path, (5, 0.5, 2, 0.25, 2, 0, -5, 0))
    freefem("cases/settling_disk.edp", *shaft[:-1], 1, "-particles", disks, "-scheme", "published", "-dt", "0.002", "-tend",
        "0.003", "-out", tmp_path / "run")
    table = RunFolder(tmp_path / "run").table("particles")
    one = table["id"] == 5
    t, y = np.append(0, table["t"][one]), np.append(2, table["y"][one])
    assert t[-1] == pytest.approx(0.003) and np.diff(y) == pytest.approx(np.diff(t) * table["v"][one], rel=1e-6)


def test_published_scheme_counts_no_contacts_of_disks_that_have_left(freefem, coarse, tmp_path):
    disks = particles(tmp_path, (5, 0.999, 0, 0.01, 5000, 6, 1, 0), (6, 0.999, 0.02001, 0.01, 5000, 6, -1, 0))
    freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", "0", "-particles", disks, "-scheme", "published", "-dt",
        "0.007", "-convection", "0", "-every", "0", "-tend", "0.014",
            "-out", tmp_path / "run")
    fluid = RunFolder(tmp_path / "run").table("fluid")
    gone = fluid["particles"] == 0
    assert gone.sum() > 1 and not fluid["contacts"][gone].any()  # they press each other in the step that takes them out
    assert len((tmp_path / "run/contacts.csv").read_text().splitlines()) == 1


def test_published_scheme_carries_a_disk_over_the_seam(freefem, cell, tmp_path):
    disks, found = particles(tmp_path, (5, 0.92, 0.75, 0.1, 1, 0.25, 0, 0)), {}
    for scheme in ("standard", "published"):
        freefem("cases/couette_disk.edp", "-mesh", cell, "-particles", disks, "-reynolds", "0", "-scheme", scheme, "-dt", "0.02",
            "-tend", "0.8", "-out", tmp_path / scheme)
        table = RunFolder(tmp_path / scheme).table("particles")
        beyond = (table["id"] == 5) & (table["x"] > 1)
        found[scheme] = {name: table[name][beyond].mean() for name in ("u", "omega")}
    assert beyond.sum() > 10
    # in the mean: the turning of a disk with four elements across wavers by a half
    assert found["published"]["u"] == pytest.approx(found["standard"]["u"], rel=0.05)
    assert found["published"]["omega"] == pytest.approx(found["standard"]["omega"], rel=0.2)


def test_published_and_standard_scheme_agree_roughly(freefem, shaft, tmp_path):
    """First order in time and an element-wise interface on one side: a quarter is what to expect at 4 cells."""
    standard = particles_of(freefem, tmp_path / "standard", "settling_disk", *shaft, "-tend", "0.04", "-dt", "0.0025")
    published = particles_of(freefem, tmp_path / "published", "settling_disk", *shaft, "-tend", "0.04", "-dt", "0.005", "-scheme",
        "published")
    assert published["v"][-1] == pytest.approx(standard["v"][-1], rel=0.25)
    tensorial = particles_of(freefem, tmp_path / "tensorial", "settling_disk", *shaft, "-tend", "0.04", "-dt", "0.005", "-scheme",
        "tensorial")
    assert tensorial["v"][-1] == pytest.approx(standard["v"][-1], rel=0.25)
    assert tensorial["v"][-1] != published["v"][-1]
    multipliers = particles_of(freefem, tmp_path / "multipliers", "settling_disk", *shaft, "-tend", "0.04", "-dt", "0.00125",
        "-scheme", "multipliers")
    assert multipliers["v"][-1] == pytest.approx(standard["v"][-1], rel=0.15)


def test_the_published_scheme_turns_a_disk_in_shear_by_either_indicator(freefem_text, cell, tmp_path):
    text = case("bodyDisk(0.5, 0.5, 0.2, 1);", walls="labelLeft, labelRight", moving="labelBottom, labelTop",
        more="macro boundaryU() (2*y - 1) // EOM", gravity=0)
    found = {}
    for kind in ("centre", "levelset"):
        freefem_text(text, "-scheme", "published", "-mesh", cell, "-indicator", kind, "-convection", 0, "-dt", 0.02, "-every", 0,
            "-tend", 0.2, "-out", tmp_path / kind)
        found[kind] = RunFolder(tmp_path / kind).particles
    assert found["centre"]["omega"][-1] < -0.05 and found["levelset"]["omega"][-1] == pytest.approx(found["centre"]["omega"][-1],
        rel=0.2)
    assert found["centre"]["theta"][-1] == pytest.approx(np.sum(found["centre"]["omega"]) * 0.02, rel=1e-6)


@pytest.mark.parametrize("kind", ["centre", "levelset", "smooth"])
def test_the_published_scheme_lets_a_heavy_disk_fall_freely(kind, freefem_text, tmp_path):
    """Ten thousand times as dense as the fluid, which bears some 1e-4 of its weight; whatever the indicator makes of the edge."""
    text = case("bodyDisk(0.51, 0.72, 0.15, 1e4);", mu=0.001, gravity=-2)
    freefem_text(text, "-scheme", "published", "-indicator", kind, "-convection", 0, "-dt", 0.02, "-every", 0, "-tend", 0.04,
        "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    steps = np.arange(1, 3)
    assert rows["v"] == pytest.approx(-2 * 0.02 * steps, rel=5e-3) and abs(rows["omega"]).max() < 5e-3
    assert rows["y"] == pytest.approx(0.72 - 2 * 0.02**2 * steps * (steps + 1) / 2, abs=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("scheme, dt, within", [("tensorial", 0.005, 0.12), ("multipliers", 0.00125, 0.02)])
def test_the_other_schemes_settle_a_disk_as_a_body_fitted_computation_does(scheme, dt, within, freefem, tmp_path):
    """Height at 0.3 s, from 4 cm, on the default mesh: 4 elements per diameter."""
    freefem("cases/settling_disk.edp", "-scheme", scheme, "-dt", dt, "-tend", 0.3, "-out", tmp_path / "run")
    table = read_table(ROOT / "tests/reference/settling_disk_body_fitted.csv")
    fall = 4 - np.interp(0.3, table["t_s"], table["y_cm"])
    assert 4 - RunFolder(tmp_path / "run").particles["y"][-1] == pytest.approx(fall, rel=within)


def test_disks_in_contact_do_not_overlap_with_multipliers(freefem_text, tmp_path):
    """Two disks that are driven onto each other, and one onto the floor."""
    text = case("bodyAdd(0.4, 0.5, 0.1, 3, 1, 0, 0, 1); bodyAdd(0.62, 0.5, 0.1, 3, -1, 0, 0, 1); bodyDisk(0.3, 0.12, 0.1, 3);",
        gravity=-10)
    freefem_text(text, "-scheme", "multipliers", "-dt", 0.02, "-every", 0, "-tend", 0.2, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    assert run.table("fluid")["worst_gap"].min() > -1e-6 and run.table("fluid")["contacts"].max() >= 1
    ends = [track for track in run.tracks.values()]
    assert np.hypot(ends[0]["x"] - ends[1]["x"], ends[0]["y"] - ends[1]["y"]).min() > 0.2 - 1e-6
