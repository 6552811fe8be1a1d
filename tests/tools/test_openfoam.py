"""The second scheme for turbulence: its meshes and files, which need no OpenFOAM, and its refusals."""
import subprocess
import sys

import numpy as np
import pytest
from tests.conftest import ROOT

from tools.peers.openfoam_case import field, read_field
from tools.peers.with_openfoam import Pipe, Slit, Step
from tools.validation.turbulence import OPENFOAM, openfoam


def area(mesh):
    """Sum of the cells, corners anticlockwise."""
    x, y = mesh.points[mesh.corners].transpose(2, 0, 1)
    return 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)


@pytest.mark.parametrize("flow, cells, exact, ends", [
    (Step(1.5, 44000), 8, 20 * 2 + 25 * 3, (2, 3)),
    (Pipe(), 20, 0.2 - 2 * 0.05 * 0.01 - 0.1 * 0.04, (0.2, 0.2)),
    (Slit(0.5), 8, 0.5 * 14.01 - 0.01 * 0.25, (0.5, 0.5)),
])
def test_a_mesh_fills_its_domain(flow, cells, exact, ends):
    mesh = flow.mesh(cells)
    each = area(mesh)
    assert each.min() > 0 and each.sum() == pytest.approx(exact, rel=2e-3)
    for name, length in zip(("inlet", "outlet"), ends):
        cell, _, normal, lengths, distance = mesh.along(name)
        assert lengths.sum() == pytest.approx(length)
        assert np.allclose(normal, [-1 if name == "inlet" else 1, 0]) and distance.min() > 0
    # Gauss: the normals of a closed boundary cancel
    total = sum((mesh.along(name)[2] * mesh.along(name)[3][:, None]).sum(axis=0) for name in mesh.patches)
    assert abs(total).max() < 1e-9


def test_a_field_is_read_as_it_is_written(tmp_path):
    values = np.random.default_rng(1).random((7, 2))
    for wanted in (values, values[:, 0]):
        (tmp_path / "U").write_text(f"internalField {field(wanted)};\nboundaryField {{}}\n")
        np.testing.assert_allclose(read_field(tmp_path / "U"), wanted, rtol=1e-11)


def test_without_openfoam_one_line_says_so(tmp_path):
    command = [sys.executable, "-m", "tools.peers.with_openfoam", "step", "8"]
    done = subprocess.run(command, cwd=ROOT, env={"PATH": str(tmp_path)}, capture_output=True, text=True)
    assert done.returncode == 3 and done.stderr.strip() == "error: simpleFoam is not there; Debian's package openfoam has it"


def test_each_flow_has_its_targets():
    for name in OPENFOAM:
        rows = openfoam(name)
        assert rows and all(0 < low < high for _, _, low, high in rows)
