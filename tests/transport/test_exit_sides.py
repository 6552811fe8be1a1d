"""Sides of the mesh: which are walls for point particles when the case does not say, and what is said of particles that leave
elsewhere than at an outlet."""
import pytest

from tests.conftest import make_mesh
from tools.base.tables import read_table

SCENE = """include "lib/case.idp"
optCase("sides", "spheres in a channel, a scene of tests/transport/test_exit_sides.py");
optDefault("-dt", "0.01"); optDefault("-tend", "1.5"); optDefault("-every", "0.1"); optDefault("-drag", "schiller-naumann");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = {gravity};
{more}
macro caseCarrier() {{ carrierWh u = {u}, v = 0*x; carrierFlow(u[], v[]); }} // EOM
macro caseParticles() {{ real[int] x0 = [0.1, 0.2, 0.3], y0 = [0.1, 0.5, 0.9], r(3), d(3), o(3); r = 0.01; d = 2500; o = 0.; transportAppend(x0, y0, r, d, o, o, o); }} // EOM
include "scripts/transport.edp"
"""


def scene(gravity=-9.81, u="4*y*(1 - y)", more=""):
    return SCENE.format(gravity=gravity, u=u, more=more)


@pytest.fixture(scope="module")
def channel(tmp_path_factory):
    """A channel of 1 by 1: inlet, outlet, walls below and above."""
    return make_mesh(tmp_path_factory.mktemp("sides") / "channel.mesh", "poiseuille", "--length", 1, "--height", 1, "--size", 0.1)


def left(folder):
    return len(read_table(folder / "exits.csv")["t"]) if len((folder / "exits.csv").read_text().splitlines()) > 1 else 0


def warnings(done):
    return [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("warning")]


def test_walls_of_the_mesh_are_walls_unless_the_case_says_otherwise(channel, freefem_text, tmp_path):
    """Two of three left through the walls in silence."""
    done = freefem_text(scene(), "-mesh", channel, "-tend", 1, "-out", tmp_path / "run")
    assert left(tmp_path / "run") == 0 and warnings(done) == []
    last = read_table(tmp_path / "run" / "particles.csv")
    assert last["y"].min() >= 0.01 - 1e-9 and (last["y"][-3:] < 0.4).any()


@pytest.mark.parametrize("more, words, ends", [("macro caseWallLabels() [-1] // EOM", [], "caseWallLabels lists the sides that "
    "are walls"), ("", ["-contacts", 0], "without contacts (-contacts 0) no side is a wall")])
def test_particles_that_leave_through_walls_are_counted_at_the_end(more, words, ends, channel, freefem_text, tmp_path):
    done = freefem_text(scene(more=more), "-mesh", channel, "-tend", 1, *words, "-out", tmp_path / "run")
    rows, said = read_table(tmp_path / "run" / "exits.csv"), warnings(done)
    assert len(rows["t"]) == 2 and len(said) == 1
    assert said[0].startswith(f"warning: 2 particles left the mesh elsewhere than at an outlet, the first (0) at t = "
        f"{rows['t'][0]:.6g} s at ({rows['x'][0]:.6g}, {rows['y'][0]:.6g}) m through the side with label 3 (wall)")
    assert said[0].endswith(ends)


@pytest.mark.parametrize("u", ["1.", "-1."])
def test_particles_leave_through_an_outlet_in_silence(u, channel, freefem_text, tmp_path):
    """Where the fluid leaves by the side with the label inlet, so do the particles."""
    done = freefem_text(scene(gravity=0, u=u), "-mesh", channel, "-out", tmp_path / "run")
    assert left(tmp_path / "run") == 3 and warnings(done) == []


def test_particles_that_fall_out_of_an_inlet_against_the_flow_are_warned_of(channel, freefem_text, tmp_path):
    text = scene(gravity=0, u="0.05*4*y*(1 - y)").replace("gravityX = 0", "gravityX = -9.81")
    said = warnings(freefem_text(text, "-mesh", channel, "-out", tmp_path / "run"))
    assert left(tmp_path / "run") == 3 and len(said) == 1 and "3 particles" in said[0] and "label 1 (inlet)" in said[0]


def test_the_warning_counts_across_a_restart(channel, freefem_text, tmp_path):
    words = ["-mesh", channel, "-contacts", 0, "-checkpoint", 10]
    whole = warnings(freefem_text(scene(), *words, "-tend", 1, "-out", tmp_path / "whole"))
    freefem_text(scene(), *words, "-tend", 0.5, "-out", tmp_path / "part")
    rest = warnings(freefem_text(scene(), *words, "-tend", 1, "-restart", tmp_path / "part", "-out", tmp_path / "rest"))
    assert len(whole) == 1 and rest == whole and "2 particles" in whole[0]
