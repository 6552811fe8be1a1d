"""Inflows that are probably not what was meant: out of the domain, not 0 at walls; bodies that wait across an inlet or its edge.
One line each, and the run goes on."""
import pytest

from tests.scenes import case

HEAD = 'include "lib/case.idp"\noptCase("inflow", "a scene of tests/flow/test_given_inflows.py");\n'
FLOW = HEAD + """optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1, mu = 0.05, flowPeriodX = 0, flowPeriodY = 0;
int[int] flowNoSlip = [labelBottom, labelTop], flowMoving = [{moving}], flowOutlet = [labelRight], flowSlip(0);
macro boundaryU() ({u}) // EOM
{more}
func real boundaryRamp(real t) {{ return {ramp}; }}
include "scripts/flow.edp"
"""
STEADY = HEAD + """optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1, mu = 0.05, speed = 1, size = 1;
int[int] labelsMoving = [labelLeft], labelsStill = [labelBottom, labelTop], labelsFree = [labelRight];
macro inletU() ({u}) // EOM
include "scripts/steady_laminar.edp"
"""
OUT, EDGE = "out of the domain, and the fluid enters through the outlet", "where the inlet meets a no-slip wall, at ("
TIMES = ["-dt", 0.01, "-tend", 0.01]


def flow(u="4*y*(1 - y)", moving="labelLeft", ramp="1", more=""):
    return FLOW.format(u=u, moving=moving, ramp=ramp, more=more)


def said(done):
    """The warnings of the inflow and of waiting bodies."""
    return [line for line in (done.stdout + done.stderr).splitlines() if line.startswith("warning")
        and "at the end the outflow" not in line and "elements per diameter" not in line]


@pytest.mark.parametrize("name, text, expected", [
    ("good", flow(), None),
    ("outward", flow("-4*y*(1 - y)"), OUT),
    ("outward, slow", flow("-1e-9*4*y*(1 - y)"), OUT),
    ("reversed by its factor", flow("-4*y*(1 - y)", ramp="-1"), None),
    ("outward by its factor", flow(ramp="-t"), OUT),
    ("to and fro", flow(ramp="sin(2*pi*t/0.0075)"), None),
    ("changed by the case", flow("-4*y*(1 - y)", more="macro caseBoundary(now) inflowScale(labelLeft, -1.); // EOM"), None),
    ("plug", flow("1."), EDGE),
    ("nearly 0 at the walls", flow("4*y*(1 - y) + 0.005"), None),
    ("one end", flow("y"), EDGE),
    ("steady, good", STEADY.format(u="4*y*(1 - y)"), None),
    ("steady, outward", STEADY.format(u="-4*y*(1 - y)"), OUT),
    ("steady, plug", STEADY.format(u="1."), EDGE),
])
def test_inflows_that_were_hardly_meant_are_warned_of(name, text, expected, freefem_text, tmp_path):
    lines = said(freefem_text(text, *(TIMES if "steady," not in name else ["-steps", 40]), "-out", tmp_path / "run"))
    assert len(lines) == (expected is not None) and (expected is None or expected in lines[0]), lines


def test_the_place_and_size_of_a_step_at_the_wall_are_named(freefem_text, tmp_path):
    line = said(freefem_text(flow("y"), *TIMES, "-out", tmp_path / "run"))[0]
    assert "is 1 m/s (its maximum: 1)" in line and "at (0, 1)" in line


def test_a_channel_with_a_given_inflow_and_a_smaller_given_outflow_is_not_warned_of(freefem_text, tmp_path):
    """Fluid is drawn off through the upper side; the rest goes to the outlet. Where more is drawn off than enters, some comes back
    through the outlet."""
    for drawn, number in (("0.3", 0), ("3", 0), ("5", 1)):  # a sixth of this, in m2/s, where 2/3 enters
        more = f"macro boundaryV() ((y > 0.999)*{drawn}*x*(1 - x)) // EOM"
        text = flow("(y < 0.999)*4*y*(1 - y)", "labelLeft, labelTop", more=more).replace("flowNoSlip = [labelBottom, labelTop]",
            "flowNoSlip = [labelBottom]")
        lines = said(freefem_text(text, *TIMES, "-out", tmp_path / f"run{drawn}"))
        assert len(lines) == number and all(OUT in line for line in lines), lines


def test_walls_that_move_along_themselves_are_no_inflow(freefem_text, tmp_path):
    text = flow("1.", "labelLeft").replace("macro boundaryU() (1.)", "macro boundaryV() 1.")
    assert said(freefem_text(text, *TIMES, "-out", tmp_path / "run")) == []


QUEUE = dict(walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight", more="macro boundaryU() (4*y*(1 - y)) // EOM",
    gravity=0)


@pytest.mark.parametrize("bodies, expected", [
    ("queueAt(0.3, 0.5, 0.12, 1, 9);", None),
    ("queueAdd(0.5, 0.12, 1, 9);", None),
    ("queueAt(0.1, 0.5, 0.12, 1, 9);", "1 of the waiting particles lies across an inlet, the first (0) at (0.1, 0.5)"),
    ("{ queueAt(0.4, 0.5, 0.12, 1, 9); queueEllipseAt(0.1, 0.5, 0.2, 0.12, 1.5708, 1, 9); queueEllipseAt(0.15, 0.5, 0.2, 0.12, "
        "0, 1, 9); queueAt(0.1, 0.5, 0.12, 1, 9); }",
     "3 of the waiting particles lie across an inlet, the first (1) at (0.1, 0.5)"),
    ("queueEllipseAt(0.15, 0.5, 0.2, 0.12, 1.5708, 1, 9);", None),
])
def test_bodies_that_wait_across_an_inlet_are_warned_of(bodies, expected, freefem_text, tmp_path):
    lines = said(freefem_text(case(bodies, **QUEUE), *TIMES, "-out", tmp_path / "run"))
    assert len(lines) == (expected is not None) and (expected is None or expected in lines[0]), lines


HALF = """
int[int] sides = [13, 12, 14, 11];
mesh Tq = square(20, 20, label = sides);
{{ ofstream f("{file}"); f << "MeshVersionFormatted 2\\nDimension 2\\nVertices\\n" << Tq.nv << "\\n"; for (int k = 0; k < Tq.nv; ++k) f << Tq(k).x << " " << Tq(k).y << " 0\\n";
  f << "Edges\\n" << Tq.nbe << "\\n"; for (int k = 0; k < Tq.nbe; ++k) f << Tq.be(k)[0] + 1 << " " << Tq.be(k)[1] + 1 << " " << (Tq.be(k).label == 11 && Tq.be(k)[0].y + Tq.be(k)[1].y > 1.2001 ? 3 : Tq.be(k).label) << "\\n";
  f << "Triangles\\n" << Tq.nt << "\\n"; for (int k = 0; k < Tq.nt; ++k) f << Tq[k][0] + 1 << " " << Tq[k][1] + 1 << " " << Tq[k][2] + 1 << " 0\\n"; f << "End\\n"; }}
"""


@pytest.mark.parametrize("bodies, expected", [
    ("queueAdd(0.3, 0.12, 1, 9);", None),
    ("{ queueAdd(0.3, 0.12, 1, 9); queueAdd(0.55, 0.12, 1, 9); }", "1 of the waiting particles reaches beyond the inlet where "
        "they enter, the first (1, at y = 0.55, radius 0.12) beyond its edges at y = 0 and 0.6"),
    ("queueEllipse(0.5, 0.2, 0.09, 0, 1, 9);", None),
    ("queueEllipse(0.5, 0.2, 0.09, 1.5708, 1, 9);", "1 of the waiting particles reaches beyond the inlet"),
])
def test_bodies_that_would_enter_through_the_edge_of_an_inlet_are_warned_of(bodies, expected, freefem_text, tmp_path):
    """The left side is an inlet up to y = 0.6 and a wall above: half of a disk came through the wall."""
    mesh = tmp_path / "half.mesh"
    text = HALF.format(file=mesh) + case(bodies, **QUEUE | dict(walls="labelBottom, labelTop, labelWall",
        more="macro boundaryU() (y*(0.6 - y)) // EOM"))
    lines = said(freefem_text(text, "-mesh", mesh, *TIMES, "-out", tmp_path / "run"))
    assert len(lines) == (expected is not None) and (expected is None or expected in lines[0]), lines
