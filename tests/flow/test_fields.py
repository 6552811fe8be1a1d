"""The fields for ParaView: vorticity and stream function of exact flows, and their precision."""
import numpy as np
import pytest

from tests.conftest import mesh, run_freefem
from tools.base.run_folder import RunFolder


def last(folder):
    """(t, x, y, values) of the last field of a run, and where the stream function is to be 0."""
    run = RunFolder(folder)
    grid, values = run.field(len(run.fields) - 1)
    x, y = grid.points.T
    return run.fields[-1][0], x, y, values, np.argmin(y + 1e-6 * x)


def test_poiseuille_has_its_vorticity_and_stream_function(meshes, run_folder):
    """u = 4 U y (1 - y) once it is steady: omega = -du/dy, psi = int_0^y u."""
    run_freefem("cases/poiseuille.edp", "-mesh", mesh(meshes, "poiseuille", "--size", 0.125), "-dt", 0.1, "-tend", 20,
        "-fields", 20, "-fields-precision", "double", "-out", run_folder)
    _, x, y, values, low = last(run_folder)
    u = values["velocity"][:, 0]
    assert np.allclose(u, 4 * y * (1 - y), atol=1e-6)
    assert np.allclose(values["vorticity"], -4 * (1 - 2 * y), atol=1e-5)
    assert values["stream"][low] == 0 and y[low] == 0
    assert np.allclose(values["stream"], 2 * y**2 - 4 * y**3 / 3, atol=1e-3)


def test_vorticity_is_of_second_and_the_stream_function_of_third_order(meshes, tmp_path):
    """Taylor-Green vortices that move: u = 1 - cos a sin b e, v = 1 + sin a cos b e. Fluid crosses every side."""
    errors = []
    for size in (1 / 10, 1 / 20):
        folder = tmp_path / f"{size:g}"
        run_freefem("cases/taylor_green.edp", "-mesh", mesh(meshes, "taylor_green", "--size", size), "-dt", 0.002, "-tend", 0.01,
            "-fields", 0.01, "-out", folder)
        t, x, y, values, low = last(folder)
        a, b, decay = 2 * np.pi * (x - t), 2 * np.pi * (y - t), np.exp(-8 * np.pi**2 * 0.01 * t)
        vorticity = 4 * np.pi * np.cos(a) * np.cos(b) * decay
        stream = y - x + np.cos(a) * np.cos(b) * decay / (2 * np.pi)
        errors.append([np.sqrt(np.mean((values["vorticity"] - vorticity)**2)), abs(values["stream"] - stream + stream[low]).max()])
    first, second = np.array(errors)
    assert second[0] < 0.01 * 4 * np.pi and second[1] < 2e-4
    assert np.all(np.log2(first / second) > [1.8, 2.6])


@pytest.mark.parametrize("word, kind", [("single", "Float32"), ("double", "Float64")])
def test_the_precision_of_the_fields(meshes, run_folder, word, kind):
    run_freefem("cases/poiseuille.edp", "-mesh", mesh(meshes, "poiseuille", "--size", 0.25), "-dt", 0.05, "-tend", 0.05,
        "-fields", 0.05, "-fields-precision", word, "-out", run_folder)
    for path in run_folder.glob("fields_*.vtu"):
        assert f'<DataArray type="{kind}" Name="velocity"'.encode() in path.read_bytes()
