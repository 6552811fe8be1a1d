"""Collapse in fluid: a few steps of cases/collapse_in_fluid.edp, and heavy grains against the same grains without a fluid."""
import numpy as np
import pytest

from tests.conftest import ROOT, make_mesh
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table

WALLS = """
func int casePlane() { contactWallSegment(0, 0, 5, 0); return contactWallSegment(0, 0, 0, 2.4); }
macro caseWalls() casePlane(); // EOM
include "scripts/contacts.edp"
"""


def test_a_few_steps_of_collapse_in_fluid(freefem, run_folder):
    freefem("cases/collapse_in_fluid.edp", "-tend", "0.01", "-number", 12, "-out", run_folder)
    run = RunFolder(run_folder)
    assert run.status == "finished" and run.case == "collapse_in_fluid"
    for table in ("particles", "fluid", "runout"):
        rows = run.table(table, finite=True)  # a nan or an infinite number is refused
        assert len(rows["t"]) > 0, table


@pytest.mark.slow
def test_heavy_grains_in_a_thin_fluid_collapse_as_without_it(freefem, freefem_text, tmp_path):
    """Grains of a thousand times the fluid's density, which resists them by less than a hundredth of their weight, against the same
    grains by contacts alone: the mean distance from the wall, at four times, as a mean of four seeds. A single run is chaotic: half
    the step changes it by up to a tenth."""
    mesh = make_mesh(tmp_path / "tank.mesh", "box", "--width", 5, "--height", 2.4, "--size", 0.08, "--sides", "named")
    column, start, _ = (ROOT / "cases/collapse_in_fluid.edp").read_text().partition("macro caseStart()")
    assert start
    dry = column.replace('optDefault("-mesh", "meshes/collapse_in_fluid.mesh");', "") + WALLS
    ways, moments = {"wet": [], "dry": []}, np.arange(1, 5) * 0.08
    for seed in range(1, 5):
        options = ["-number", 24, "-seed", seed, "-rhos", 1000, "-dt", 0.002, "-tend", 0.32, "-every", 0.01]
        freefem("cases/collapse_in_fluid.edp", "-mesh", mesh, "-mu", 0.005, *options, "-out", tmp_path / f"wet{seed}")
        freefem_text(dry, *options, "-out", tmp_path / f"dry{seed}")
        for way, found in ways.items():
            table = read_table(tmp_path / f"{way}{seed}" / "particles.csv")
            times = np.unique(table["t"])
            found.append(np.interp(moments, times, [table["x"][table["t"] == t].mean() for t in times]))
    wet, alone = (np.mean(found, axis=0) for found in ways.values())
    assert wet == pytest.approx(alone, rel=0.1) and alone[-1] > 2.5 * alone[0]
