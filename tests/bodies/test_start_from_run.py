"""A run that starts from the flow of another run on another mesh (-start): what it keeps, how soon it is as a run of its own."""
import re

import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import write_box
from tools.base.run_folder import RunFolder

CHANNEL = """include "lib/case.idp"
optCase("channel", "a disk in a channel");
optUnits("cm", "g", "s");
optDefault("-dt", "0.04");
optDefault("-tolerance", "1e-8");
optDefault("-forces", "1");
optDefault("-fluxes", "1");
real rhoFluid = 1, mu = 0.05, gravityX = 0, gravityY = 0;
int[int] flowNoSlip = [labelWall], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip(0);
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return min(1., t/0.2); }
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
int free = optInt("-free", 0, 0, "1: the disk is let go");
macro caseParticles() { int d = bodyDisk(1, 0.52, 0.15, 1); if (!free) bodyHeld(d); } // EOM
include "scripts/resolved.edp"
"""


@pytest.fixture(scope="module")
def channel(tmp_path_factory):
    """A folder with the case, coarse and fine meshes of the channel, and the developed coarse run."""
    folder = tmp_path_factory.mktemp("channel")
    (folder / "channel.edp").write_text(CHANNEL)
    for rows in (16, 24):
        write_box(folder / f"{rows}.mesh", 3, 0, 1, 3 * rows, rows, 3)
    run_freefem(folder / "channel.edp", "-mesh", folder / "16.mesh", "-tend", 3, "-every", 1, "-checkpoint", 10000,
        "-fields", 3, "-fields-precision", "double", "-out", folder / "coarse")
    return folder


def said(done):
    """The percentages of the line of a start: change of the velocity, and of its mean."""
    found = re.search(r"starts at t = (\S+) s from the flow in .* changes by (\S+) %, its mean by (\S+) %", done.stdout)
    return float(found.group(2)), float(found.group(3))


def test_the_flow_rates_of_a_channel_are_kept(freefem, tmp_path):
    """Poiseuille's flow, without bodies, on a mesh that shares no nodes with the coarse one: within 1e-6 from the first row on, and
    its pressure drop within 0.1 %."""
    for rows in (5, 13):
        write_box(tmp_path / f"{rows}.mesh", 4, 0, 1, 4 * rows, rows, 3)
    words = ["cases/poiseuille.edp", "-fluxes", 1, "-every", 0]
    freefem(*words, "-mesh", tmp_path / "5.mesh", "-tend", 1, "-checkpoint", 10000, "-out", tmp_path / "coarse")
    change, loss = said(freefem(*words, "-mesh", tmp_path / "13.mesh", "-tend", 1.1, "-start", tmp_path / "coarse", "-out",
        tmp_path / "fine"))
    run = RunFolder(tmp_path / "fine")
    assert change < 1e-3 and loss < 1e-3
    assert np.abs(np.abs(run.table("fluxes")["flux"]) - 2 / 3).max() < 1e-6 * 2 / 3
    assert run.fluid["pressure_drop"] == pytest.approx(3.2, rel=1e-3) and run.fluid["t"][0] == pytest.approx(1.02)


def test_a_coarse_flow_goes_on_on_a_fine_mesh(channel):
    """Round a disk: what flows in is exact, what flows out within 2e-6 in the first step, whose pressure adapts to the mesh, and
    within 1e-6 then; the mean velocity within 0.01 % at the start, and after five steps the drag within 0.3 % of that which the
    flow has where it has developed on the fine mesh itself."""
    words = ["-mesh", channel / "24.mesh", "-tend", 3.2]
    own = run_freefem(channel / "channel.edp", *words, "-every", 1, "-out", channel / "fine")
    begun = run_freefem(channel / "channel.edp", *words, "-start", channel / "coarse", "-out", channel / "begun")
    assert "starts at" not in own.stdout
    change, loss = said(begun)
    assert 0 < change < 1 and loss < 0.01
    run, fine = RunFolder(channel / "begun"), RunFolder(channel / "fine")
    enters, leaves = (np.abs(run.table("fluxes")["flux"][k::2] / (2 / 3)) - 1 for k in (0, 1))
    assert np.abs(enters).max() < 1e-11 and abs(leaves[0]) < 2e-6 and np.abs(leaves[1:]).max() < 1e-6
    drag, should = run.table("forces")["fx"], fine.table("forces")["fx"][-1]
    assert drag[-1] == pytest.approx(should, rel=0.003) and drag[0] == pytest.approx(should, rel=0.02)
    assert run.fluid["kinetic_energy"][-1] == pytest.approx(fine.fluid["kinetic_energy"][-1], rel=1e-3)
    assert run.fluid["t"][0] == pytest.approx(3.04) and run.fluid["step"][0] == 1


def test_on_the_same_mesh_the_fields_are_the_same(channel):
    """To rounding, and the drag goes on within the tolerance of the solver."""
    done = run_freefem(channel / "channel.edp", "-mesh", channel / "16.mesh", "-tend", 3.08, "-start", channel / "coarse",
        "-fields", 3, "-fields-precision", "double", "-out", channel / "same")
    change, loss = said(done)
    assert change == 0 and loss < 1e-10
    before, after = RunFolder(channel / "coarse"), RunFolder(channel / "same")
    (t0, _), (t1, _) = before.fields[-1], after.fields[0]
    assert t0 == pytest.approx(3) and t1 == pytest.approx(3)
    last, first = before.field(len(before.fields) - 1)[1], after.field(0)[1]
    for name in ("velocity", "pressure"):
        assert np.abs(last[name] - first[name]).max() < 1e-12 * np.abs(last[name]).max(), name
    assert after.table("forces")["fx"] == pytest.approx(before.table("forces")["fx"][-1], rel=2e-5)


def test_a_held_disk_is_let_go(channel):
    """Place and flow of the run with the held disk; it is at rest, and the stream takes it along: 0.385 m/s after 0.08 s with steps
    half as long."""
    run_freefem(channel / "channel.edp", "-mesh", channel / "16.mesh", "-tend", 3.08, "-start", channel / "coarse", "-free", 1,
        "-dt", 0.01, "-cfl", 0, "-out", channel / "free")
    run = RunFolder(channel / "free")
    entry = run.table("entries")
    assert (entry["t"][0], entry["x"][0], entry["y"][0], entry["free"][0]) == (pytest.approx(3), 1, 0.52, 1)
    assert abs(entry["u"][0]) < 0.02 and np.all(np.diff(run.particles["u"]) > 0)
    assert run.particles["u"][-1] == pytest.approx(0.385, rel=0.01)


@pytest.mark.slow
def test_such_a_run_goes_on_after_its_own_checkpoints(channel, tmp_path):
    """Bit for bit; without -start, or with it in one line."""
    words = ["-mesh", channel / "24.mesh", "-tend", 3.2, "-checkpoint", 2]
    run_freefem(channel / "channel.edp", *words, "-start", channel / "coarse", "-out", tmp_path / "a")
    for path in (tmp_path / "a").glob("restart_000000005*"):
        path.unlink()
    rows = (tmp_path / "a/forces.csv").read_bytes()
    done = run_freefem(channel / "channel.edp", *words, "-start", channel / "coarse", "-restart", tmp_path / "a", check=False)
    assert done.returncode == 3 and "give one of them" in done.stderr
    run_freefem(channel / "channel.edp", *words, "-restart", tmp_path / "a")
    assert (tmp_path / "a/forces.csv").read_bytes() == rows


def test_moving_bodies_are_taken_over(freefem, shaft, tmp_path):
    """A falling disk on finer elements: place and angle as they were; the velocity within 0.5 %, and soon after within 0.5 % of
    that of a disk that has always fallen on them."""
    coarse = ["cases/settling_disk.edp", *shaft, "-every", 0]
    freefem(*coarse, "-tend", 0.05, "-checkpoint", 10000, "-out", tmp_path / "coarse")
    write_box(tmp_path / "fine.mesh", 1, 0, 2.5, 24, 60, 3)
    text = (tmp_path / "fine.mesh").read_text().splitlines()
    at = text.index("Edges")
    text[at + 2:] = [line.rsplit(" ", 1)[0] + " 3" if line.count(" ") == 2 else line for line in text[at + 2:]]
    (tmp_path / "fine.mesh").write_text("\n".join(text) + "\n")
    fine = ["cases/settling_disk.edp", "-mesh", tmp_path / "fine.mesh", "-x", 0.5, "-y", 2, "-every", 0, "-tend", 0.055]
    freefem(*fine, "-out", tmp_path / "own")
    freefem(*fine, "-start", tmp_path / "coarse", "-out", tmp_path / "begun")
    last = {name: values[-1] for name, values in RunFolder(tmp_path / "coarse").particles.items()}
    begun, own = (RunFolder(tmp_path / name) for name in ("begun", "own"))
    entry = begun.table("entries")
    assert (entry["x"][0], entry["y"][0]) == (last["x"], last["y"]) and entry["v"][0] == pytest.approx(last["v"], rel=5e-3)
    assert abs(begun.particles["theta"][0] - last["theta"]) < 1e-3 and begun.particles["t"][0] == pytest.approx(0.05125)
    assert begun.particles["v"][-1] == pytest.approx(own.particles["v"][-1], rel=5e-3)


@pytest.mark.parametrize("case, words, wrong", [
    ("own", ["-tend", 2], "is that at 3 s, where this run begins, and -tend is 2 s"),
    ("own", ["-scheme", "published", "-tend", 4, "-free", 1], "starting from another run (-start) is for -scheme standard"),
    ("cases/settling_disk.edp", ["-tend", 4], "particle 0 has the radius 0.15 and the aspect 1 in the run"),
    ("cases/template.edp", ["-tend", 4], "has other particles: 1 in all (1 present, 0 waiting), this case 3 (3 "
        "present, 0 waiting)"),
    ("cases/settling_disk.edp", ["-tend", 4, "-diameter", 0.3, "-x", 1, "-y", 0.52], "is of another domain: its sides lie up to 5"),
    ("cases/poiseuille.edp", ["-tend", 4], "has 1 particles, and this driver, flow.edp, has none")])
def test_what_cannot_be_taken_is_refused_in_one_line(channel, freefem_refused, tmp_path, case, words, wrong):
    own = [channel / "channel.edp", "-mesh", channel / "24.mesh"] if case == "own" else [case]
    assert wrong in freefem_refused(3, *own, *words, "-start", channel / "coarse", "-out", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_run_in_other_units_is_refused(channel, freefem_refused, tmp_path):
    """It was taken: mm/s became cm/s."""
    text = (channel / "channel.edp").read_text()
    (tmp_path / "other.edp").write_text(text.replace('"cm", "g", "s"', '"cm", "g", "ms"').replace('"channel"', '"other"'))
    said = freefem_refused(3, tmp_path / "other.edp", "-mesh", channel / "16.mesh", "-tend", 4, "-start", channel / "coarse",
        "-out", tmp_path / "run")
    assert "has the units cm, g, s, this case cm, g, ms" in said and not (tmp_path / "run").exists()


def test_a_run_without_checkpoints_and_another_period_are_refused(channel, freefem_refused, freefem, cell, tmp_path):
    words = ["cases/couette_disk.edp", "-mesh", cell]
    freefem(*words, "-tend", 0.05, "-checkpoint", 1, "-out", tmp_path / "sheared")
    text = (channel / "channel.edp").read_text().replace("bodyDisk(1, 0.52, 0.15, 1)", "bodyDisk(0.5, 0.5, 0.125, 1)")
    text = text.replace("[labelWall]", "[labelBottom, labelTop]").replace("[labelInlet]", "[labelLeft]")
    (tmp_path / "closed.edp").write_text(text.replace("[labelOutlet]", "[labelRight]"))
    said = freefem_refused(3, tmp_path / "closed.edp", "-mesh", cell, "-tend", 1, "-start", tmp_path / "sheared", "-out",
        tmp_path / "run")
    assert "has another period" in said and "this case has no period along x and none along y" in said
    (tmp_path / "empty").mkdir()
    assert "there is no complete checkpoint" in freefem_refused(3, *words, "-tend", 1, "-start", tmp_path / "empty")
