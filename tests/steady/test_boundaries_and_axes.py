"""Boundaries of steady flows: axes, planes of symmetry, inlets aslant, and what is refused."""
import numpy as np
import pytest

from tests.conftest import run_freefem
from tests.scenes import write_box
from tests.steady.conftest import SHORT
from tests.tables import results
from tools.base.mesh_files import read_field


@pytest.mark.parametrize("args, says", [
    (["-model", "k-omega"], "must be one of"),
    (["-mesh", "nowhere.mesh"], "nowhere.mesh"),
    (["-axisymmetric", "1"], "axis"),
    (["-intensity", "2"], "between"),
    (["-reynolds", "900"], "give -model laminar"),
    (["-modle", "laminar"], "-model"),
])
def test_bad_input_is_refused(freefem, run_folder, args, says):
    refused = freefem("cases/pipe_flow.edp", "-out", run_folder, *args, check=False)
    assert refused.returncode == 3
    assert says in refused.stderr and refused.stderr.startswith("error: ")
    assert not run_folder.exists()


def test_half_a_pipe_needs_its_axis(freefem_refused, tmp_path):
    mesh = write_box(tmp_path / "pipe.mesh", 1.0, 0.0, 0.1, 24, 6, bottom=8)
    assert "-axisymmetric 1" in freefem_refused(3, "cases/pipe_flow.edp", "-mesh", mesh, "-model", "laminar", "-reynolds", 100,
        "-out", tmp_path / "run")


def test_pipe_flow_refuses_an_inlet_on_the_right(tmp_path, run_folder, coarse_pipe):
    script, mesh = tmp_path / "mirror.edp", tmp_path / "mirror.mesh"
    script.write_text(f'mesh Th = readmesh("{coarse_pipe}");\nTh = movemesh(Th, [1 - x, y]);\nsavemesh(Th, "{mesh}");\n')
    run_freefem(script)
    done = run_freefem("cases/pipe_flow.edp", "-mesh", mesh, *SHORT, "-out", run_folder, check=False)
    assert done.returncode == 3 and "one upright inlet" in done.stderr


# A case of one's own in a box; SIDES: labels below, on the right, above, on the left.
OWN = """
include "lib/core/output.idp"
include "lib/mesh/read_mesh.idp"
optCase("own", "a box");
optDefault("-model", "laminar");
string meshFile = "";
int[int] sides = [SIDES];
mesh Th = square(4, 4, [x, y - LOW], label = sides);
real densityFluid = 1, viscosityFluid = 1, steadySpeed = 1, steadyLength = 1, steadyForce = 0, outletPressure = 0, steadyZoneLeast = 0.1, inletEnergy = 1, inletLength = 1;
int steadyAxis = AXIS;
string steadySetting = "own";
macro inletU() 1. // EOM
include "scripts/steady.edp"
"""


@pytest.mark.parametrize("sides, low, axis, says", [
    ("3, 8, 2, 1", 0, 0, "must be horizontal"),  # let the fluid through, in silence
    ("3, 2, 3, 1", 0.5, 1, "begins at y = -0.5"),  # "give more -steps, a larger -tolerance, a finer mesh"
])
def test_an_axis_that_is_none_is_refused(sides, low, axis, says, freefem_text, run_folder):
    done = freefem_text(OWN.replace("SIDES", sides).replace("LOW", str(low)).replace("AXIS", str(axis)), "-out", run_folder,
        check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1
    assert not run_folder.exists()


@pytest.mark.parametrize("model", ["laminar", "k-epsilon"])
def test_a_stream_may_enter_aslant(model, freefem_text, run_folder):
    """What a case gives at the inlet stands there, whether the flow is found or not."""
    text = OWN.replace("SIDES", "3, 2, 3, 1").replace("LOW", "0").replace("AXIS", "0").replace("macro inletU() 1. // EOM",
        "macro inletU() y // EOM\nmacro inletV() 0.5*y*(1. - y) // EOM")
    freefem_text(text.replace("viscosityFluid = 1,", "viscosityFluid = 1e-4,"), "-model", model, "-steps", 1, "-out", run_folder,
        check=False)
    fine, values = read_field(run_folder / "fields.vtu")
    y = fine.points[np.abs(fine.points[:, 0]) < 1e-12, 1]
    inside = (y > 1e-9) & (y < 1 - 1e-9)
    at = values["velocity"][np.abs(fine.points[:, 0]) < 1e-12]
    assert len(y) == 9 and at[inside, 0] == pytest.approx(y[inside], abs=1e-6) and at[inside, 1] == pytest.approx(0.5
        * (y * (1 - y))[inside], abs=1e-6)


# Half of Poiseuille's flow; TURNED 1: along y.
HALF = r"""
include "lib/case.idp"
optCase("half", "half a channel"); optDefault("-mesh", "FOLDER/half.mesh");
real rhoFluid = 2, mu = 0.3, speed = 1, size = 1;
include "lib/mesh/labels.idp"
int[int] labelsStill = [labelWall], labelsMoving = [labelInlet], labelsFree = [labelOutlet], sides = [labelAxis, labelOutlet, labelWall, labelInlet];
int turned = TURNED;
{
    mesh box = square(12, 5, [2*x, 0.5*y + SLANT*x], label = sides);
    if (turned) box = movemesh(box, [-y, x]);
    savemesh(box, "FOLDER/half.mesh");
}
macro inletU() (turned ? 0. : 1 - 4*y^2) // EOM
macro inletV() (turned ? 1 - 4*x^2 : 0.) // EOM
macro caseSymmetry() [PLANES] // EOM
macro caseResult() {
    real[int] pull(2);
    steadyForceOn(labelWall, pull);
    resultPut("wall_along", pull[turned], ""); resultPut("wall_across", (turned ? -pull[0] : pull[1]), "");
    steadyForceOn(labelAxis, pull);
    resultPut("plane_along", pull[turned], ""); resultPut("plane_across", (turned ? -pull[0] : pull[1]), "");
} // EOM
include "scripts/steady_laminar.edp"
"""


@pytest.mark.parametrize("turned", [0, 1])
def test_force_on_a_plane_of_symmetry_and_on_a_wall_that_ends_where_it_begins(freefem_text, run_folder, tmp_path, turned):
    """Shear 4 mu U/H over a length of 2, mean pressure 8 mu U/H2; no shear on the plane."""
    freefem_text(HALF.replace("FOLDER", str(tmp_path)).replace("TURNED", str(turned)).replace("SLANT", "0").replace("PLANES",
        "labelAxis"), "-fields", 1, "-out", run_folder)
    found = results(run_folder)
    fine, values = read_field(run_folder / "fields.vtu")
    assert found["reynolds"] == pytest.approx(2 / 0.3) and values["pressure"] == pytest.approx(2.4 * (2 - fine.points[:, turned]),
        abs=1e-6)
    assert [found[name] for name in ("wall_along", "wall_across", "plane_across")] == pytest.approx([2.4, 4.8, -4.8],
        rel=1e-8) and abs(found["plane_along"]) < 1e-8


@pytest.mark.parametrize("planes, slant, says", [("labelAxis", "0.1", "must be horizontal or upright"), ("labelAxis, labelWall",
    "0", "label 3 (wall) is listed twice"), ("labelAxis, labelLeft", "0", "no edge with label 11 (left)")])
def test_planes_of_symmetry_that_cannot_be_are_refused(freefem_text, run_folder, tmp_path, planes, slant, says):
    done = freefem_text(HALF.replace("FOLDER", str(tmp_path)).replace("TURNED", "0").replace("SLANT", slant).replace("PLANES",
        planes), "-out", run_folder, check=False)
    assert done.returncode == 3 and says in done.stderr and len(done.stderr.strip().splitlines()) == 1
