"""Particles that enter, wait, overlap at the start, leave or are lost; and what is refused of them."""
import json

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.tables import in_formula, records
from tools.base.tables import read_table

THROWN = """
include "lib/case.idp"
include "lib/mesh/labels.idp"
optCase("thrown", "small heavy spheres thrown at a wall in a fluid at rest");
optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro caseCarrier() carrierWh still = 0*x; carrierFlow(still[], still[]); // EOM
macro caseWallLabels() [labelBottom] // EOM
macro caseParticles() {
    int n = 41;
    real[int] x0 = 1:n, y0 = 1:n, r(n), d(n), u0(n), v0(n), w0(n);
    x0 *= 0.02; y0 *= 1e-4; y0 += 5e-3; r = 2e-4; d = 2500; u0 = 0; v0 = -1; w0 = 0;
    transportAppend(x0, y0, r, d, u0, v0, w0);
} // EOM
include "scripts/transport.edp"
"""


@pytest.mark.parametrize("dt", [0.002, 0.0005])
def test_small_spheres_are_not_lost_at_a_wall(dt, freefem_text, tmp_path):
    """The middle of their step lies beyond the wall that holds them (all 41 were taken out with steps of 0.002 s)."""
    freefem_text(THROWN, "-dt", dt, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-out", tmp_path / "run")
    steps, last = records(tmp_path / "run/steps.csv")[-1], records(tmp_path / "run/particles.csv")[-41:]
    assert (steps["particles"], steps["lost"]) == ("41", "0") and records(tmp_path / "run/exits.csv") == []
    assert all(float(row["t"]) > 0.05 - 1e-9 and float(row["y"]) > 2e-4 - 1e-9 for row in last)


def test_who_leaves_is_counted_once_by_the_outlet_or_lost(freefem_text, tmp_path):
    """Of 41 spheres between x = 0.02 and 0.82 those beyond 0.615 have left through the outlet in the first step, the others are
    lost below the bottom in time; those that enter later are told of once."""
    more = 'macro caseBound() 0.615 // EOM\nmacro caseParticles() { queueAt(0.3, 0.5, 2e-4, 2500, 0.02); queueAt(0.4, 0.5, 2e-4, 2500, 0.03);'
    text = THROWN.replace("[labelBottom]", "[labelTop]").replace("macro caseParticles() {", more)
    freefem_text(text, "-dt", 0.002, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-every", 0, "-out", tmp_path / "run")
    gone, steps, entered = records(tmp_path / "run/exits.csv"), read_table(tmp_path / "run/steps.csv"), records(tmp_path
        / "run/entries.csv")
    through = [row for row in gone if row["outlet"] == "1"]
    assert len(through) == 11 and all(float(row["t"]) == 0.002 and float(row["x"]) > 0.615 for row in through)
    assert [int(row["id"]) for row in through] == list(range(30, 41)) and sorted(int(row["id"]) for row in gone) == list(range(41))
    for name, outlet in (("left", "1"), ("lost", "0")):
        assert steps[name].tolist() == [sum(row["outlet"] == outlet and float(row["t"]) <= t + 1e-9 for row in gone)
            for t in steps["t"]]
    assert [int(row["id"]) for row in entered] == list(range(43)) and [float(row["t"])
        for row in entered[-2:]] == pytest.approx([0.02, 0.03])
    assert (steps["particles"] + steps["waiting"] + steps["left"] + steps["lost"]).tolist() == [43] * len(steps["t"])


def test_a_sphere_beyond_the_mesh_is_taken_out(freefem_text, tmp_path):
    freefem_text(THROWN.replace("[labelBottom]", "[labelTop]"), "-dt", 0.002, "-tend", 0.05, "-drag", "stokes", "-lift", 0, "-out",
        tmp_path / "run")
    gone = records(tmp_path / "run/exits.csv")
    assert len(gone) == 41 and all(float(row["y"]) < 0 and row["outlet"] == "0" for row in gone)


PAIR = """include "lib/case.idp"
optCase("pair", "spheres that overlap or stand outside at the start");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
optDefault("-contacts", "1");
{flow}
macro caseParticles() {{ {particles} }} // EOM
include "scripts/transport.edp"
"""
STILL = "macro carrierExact(px, py, t) carrierU = 0.; // EOM"
TWO = "real[int] x0 = [0., 0.01], y0 = [0., 0.], r = [0.01, 0.01], d = [2500., 2500.], z = [0., 0.]; transportAppend(x0, y0, r, d, z, z, z);"
UNIFORM = """include "lib/mesh/labels.idp"
macro caseWallLabels() [labelWall] // EOM
macro caseBound() 1. // EOM
macro caseCarrier() {{ carrierWh u = 1., v = 0.; carrierFlow(u[], v[]); }} // EOM""".replace("{{", "{").replace("}}", "}")


def test_overlaps_at_the_start_are_refused_or_pushed_apart(freefem_text, tmp_path):
    """They were shot apart at half the overlap over the time step."""
    text, words = PAIR.format(flow=STILL, particles=TWO), ["-dt", 0.001, "-tend", 0.01]
    refused = freefem_text(text, *words, "-out", tmp_path / "no", check=False)
    assert refused.returncode == 5 and "particles 0 and 1 overlap by 0.01" in refused.stderr
    freefem_text(text, *words, "-contact-initial", "push", "-out", tmp_path / "pushed")
    last = records(tmp_path / "pushed" / "particles.csv")[-2:]
    assert abs(float(last[1]["x"]) - float(last[0]["x"])) == pytest.approx(0.02, abs=1e-6)
    assert max(abs(float(row["u"])) for row in last) < 1e-6


def test_waiting_particles_that_would_enter_outside_the_mesh_are_refused(freefem_text, tmp_path):
    """They came in and were lost a step later."""
    queue = "queueAdd(0., 0.005, 2500, 0); queueAdd(5., 0.005, 2500, 0.01);"
    done = freefem_text(PAIR.format(flow=UNIFORM, particles=queue), "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01,
        "-tend", 0.05, "-out", tmp_path / "run", check=False)
    assert done.returncode == 5 and "the waiting particle 1 (the first is 0) stands outside the mesh" in done.stderr and "1 particle stands outside" in done.stderr


def test_a_particle_is_let_go_at_a_place(freefem_text, tmp_path):
    """With the velocity of the fluid there, when it is due; one behind the outlet is refused."""
    for x, status in ((0.5, 0), (1.5, 5)):
        text = PAIR.format(flow=UNIFORM, particles=f"queueAt({x}, 0.01, 0.005, 2500, 0.02);")
        done = freefem_text(text, "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01, "-tend", 0.04, "-every", 0, "-out",
            tmp_path / f"run{x}", check=False)
        assert done.returncode == status, done.stderr
    first = records(tmp_path / "run0.5" / "particles.csv")[0]
    assert 0.02 <= float(first["t"]) < 0.0301 and abs(float(first["x"])
        - 0.5) <= float(first["u"]) * 0.0101 and abs(float(first["y"]) - 0.01) < 1e-3


def test_an_ellipse_that_waits_is_refused(freefem_text, tmp_path):
    text = PAIR.format(flow=UNIFORM, particles="queueEllipseAt(0.5, 0.01, 0.005, 0.003, 0, 2500, 0.02);")
    done = freefem_text(text, "-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and "carried particles are round" in done.stderr and not (tmp_path / "run").exists()


@pytest.mark.parametrize("particles, step, says", [
    ("transportAppend(two, two, two, one, two, two, two);", "", "given are 2 x, 2 y, 2 radii, 1 densities"),
    ("bodyDisk(1, 1, 0.1, 2500);", "", "bodyDisk, bodyAdd and the like are for resolved flows"),
    ("transportAppend(one, one, one, one, one, one, one);", "transportAppend(one, one, one, one, one, one, one)",
        "transportAppend adds particles after the run has begun"),
], ids=["uneven arrays", "a disk", "during the run"])
def test_particles_that_are_none_of_a_transport_run_are_refused(freefem_text, tmp_path, particles, step, says):
    """Disks were passed over in silence; what was added during the run stood on what was there."""
    text = """
include "lib/case.idp"
optCase("uneven", "arrays of different lengths");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) carrierU = 0.; // EOM
real[int] two(2), one(1);
two = 0.001; one = 2500;
macro caseParticles() PARTICLES // EOM
STEP
include "scripts/transport.edp"
""".replace("PARTICLES", particles).replace("STEP", step and f"macro caseStep() {step}; // EOM")
    done = freefem_text(text, "-tend", 0.001, "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and done.stderr.count("\n") == 1
    assert step or not (tmp_path / "run").exists()


def test_who_enters_spins_as_the_flow_does(freefem_text, tmp_path):
    """Shear of 2: half of the vorticity is -1."""
    shear = "carrierU = 2.*py; carrierV = 0.; carrierUX = 0.; carrierUY = 2.; carrierVX = 0.; carrierVY = 0.; carrierUT = 0.; carrierVT = 0.;"
    records = in_formula(freefem_text, tmp_path / "run", shear, "queueAt(0, 1, 0.01, 2500, 0);", "-magnus", 1, "-dt", 0.001,
        "-tend", 0.01, "-every", 0.001)
    np.testing.assert_allclose(records["omega"], -1, atol=1e-9)


def test_a_flow_without_k_and_epsilon_has_no_fluctuations(freefem_text, freefem_refused, tmp_path):
    """They were 0, without a word."""
    words = ["-mesh", ROOT / "meshes/pipe_obstacles.mesh", "-dt", 0.01, "-tend", 0.02, "-out", tmp_path / "run"]
    freefem_text(PAIR.format(flow=UNIFORM, particles="queueAt(0.5, 0.01, 0.005, 2500, 0);"), *words)
    assert "no k and epsilon" in freefem_refused(3, tmp_path / "script.edp", *words[:-1], tmp_path / "other", "-turbulence",
        "fluctuation")


@pytest.mark.parametrize("old, new, says", [("mu = 1e-3", "mu = 0", "has density 1000 and viscosity 0"), ("rhoFluid = 1000",
    "rhoFluid = -1", "has density -1 and"),
                                            ("gravityY = 0", "gravityY = 1e300*1e300", "gravityY inf; both must be numbers")])
def test_a_fluid_without_density_or_viscosity_and_gravity_that_is_no_number_are_refused(old, new, says, freefem_text, tmp_path):
    """Without viscosity the run ended with status 8, with a density below 0 it went on."""
    done = freefem_text(PAIR.format(flow=STILL, particles=TWO).replace(old, new), "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.splitlines()) == 1


def test_who_waits_looks_over_the_seam_of_a_period(freefem_text, tmp_path):
    """It was let in where the image of another stood, and both were shot apart; the pictures did not know of the period."""
    there = "contactPeriodic(0, 0, 1, 1); real[int] x0 = [0.98], y0 = [0.5], r = [0.05], d = [2500.], u0 = [1.], z = [0.]; transportAppend(x0, y0, r, d, u0, z, z);"
    text = PAIR.format(flow=STILL.replace("0.", "1."), particles=there + " queueAt(0.02, 0.5, 0.05, 2500, 0);")
    freefem_text(text, "-drag", "off", "-dt", 0.01, "-tend", 0.2, "-out", tmp_path / "run")
    entered = {row["id"]: float(row["t"]) for row in records(tmp_path / "run/entries.csv")}
    last = records(tmp_path / "run/particles.csv")
    assert 0.14 < entered["1"] < 0.16 and all(float(row["u"]) == pytest.approx(1, abs=1e-9) for row in last)
    assert json.loads((tmp_path / "run/run.json").read_text())["period"] == [1, 1]
