"""Point particles in a flow of tools.flow: its values between nodes and times, paths against exact ones, restarts, refusals."""
import re
import shutil

import meshio
import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base.tables import read_table
from tools.peers.openfoam_paths import passages
from tools.validation.given_flow import END, SCRIPT, astray, made, vortex_file

SAMPLES = (0.1, 0.9, 0.31), (0.2, 0.6, 0.83)  # x, y


def quadratic(x, y, t):
    """u and v, linear in time from 0 to 2 s, and v zero after 2 s."""
    return (1 + t) * (1 + x * y - x * x), (2 - t) * (y * y + x)


@pytest.fixture(scope="module")
def growing(tmp_path_factory):
    """The folder of a flow at 0, 2 and 3 s, quadratic in space, with k and epsilon."""
    folder = tmp_path_factory.mktemp("growing")
    data = meshio.read(vortex_file(folder / "mesh.vtu", 5))
    x, y, _ = data.points.T
    files = []
    for t in (0, 2, 3):
        u, v = quadratic(x, y, t)
        if t == 3:
            v = 0 * v
        arrays = {"u": u, "v": v, "k": np.full(len(x), 1.5 * (0.1 + 0.1 * t) ** 2), "epsilon": np.full(len(x), 1.5 * (0.1 + 0.1 * t)
            ** 2 * (1 + t))}
        files.append(folder / f"{t}.vtu")
        meshio.Mesh(data.points, data.cells, point_data=arrays).write(files[-1])
    return made(folder, "flow", files, "--times", "5,7,8")  # begins at 5 s


SHOW = """
caseCarrier
{{
    real[int] px = [{x}], py = [{y}], times = [{times}];
    for (int i = 0; i < times.n; ++i) {{
        givenAt(times[i]);
        carrierSample(px, py, times[i]);
        for (int k = 0; k < px.n; ++k) cout << "at " << times[i] << " " << px[k] << " " << py[k] << " " << carrierU[k] << " "
            << carrierV[k] << " " << carrierUX[k] << " " << carrierVY[k] << " " << carrierUT[k] << " " << carrierVT[k] << " "
            << carrierSigma[k] << " " << carrierRate[k] << endl;
    }}
    exit(0);
}}
"""


def shown(freefem_text, flow, times, *words):
    """Rows (t, x, y, u, v, du/dx, dv/dy, du/dt, dv/dt, sigma, rate) of the samples at these times of the run."""
    x, y = (", ".join(map(str, one)) for one in SAMPLES)
    driver = (ROOT / "scripts/transport.edp").read_text()
    show = SHOW.format(x=x, y=y, times=", ".join(f"{float(time)}" for time in times))
    text = (ROOT / SCRIPT).read_text().replace('include "scripts/transport.edp"', driver.replace("\ncaseCarrier\n", show, 1))
    done = freefem_text(text, "-flow", flow, "-turbulence", "fluctuation", *words)
    return np.array([line.split() for line in re.findall(r"^at (.*)", done.stdout, re.M)], float)


def test_values_between_nodes_and_times(freefem_text, growing):
    """Exact for what is quadratic in space and linear in time, with its gradient and time derivative; forwards and backwards."""
    for t, x, y, u, v, ux, vy, ut, vt, sigma, rate in shown(freefem_text, growing, (0, 1.5, 2, 0.5), "-tend", 3):
        wanted = *quadratic(x, y, t), (1 + t) * (y - 2 * x), (2 - t) * 2 * y, 1 + x * y - x * x, -(y * y + x) if t < 2 else 0
        assert [u, v, ux, vy, ut, vt] == pytest.approx(wanted, abs=2e-5)
        assert [sigma, rate] == pytest.approx([0.1 + 0.1 * t, 1 + t], rel=1e-5)


@pytest.mark.parametrize("beyond, times, same", [("hold", (3, 4.5), 3), ("repeat", (3.5, 6.5), 0.5)])
def test_after_the_last_time(beyond, times, same, freefem_text, growing):
    rows = shown(freefem_text, growing, times, "-tend", 9, "-flow-beyond", beyond)
    for t, x, y, u, v, *_, ut, vt, _, _ in rows:
        wanted = quadratic(x, y, same)
        assert u == pytest.approx(wanted[0], abs=2e-5)
        if beyond == "repeat":
            assert [v, ut] == pytest.approx([wanted[1], 1 + x * y - x * x], abs=2e-5)
        elif t > 3:
            assert ut == vt == 0


TRACK = "-tend", END, "-dt", 0.005, "-every", 0.1


def test_paths_converge_as_the_interpolation_does(freefem, tmp_path):
    """At least third order from values at points, second from those in cells, and in time where these are far apart."""
    def track(flow, name):
        freefem(SCRIPT, "-flow", flow, *TRACK, "-out", tmp_path / name)
        return read_table(tmp_path / name / "particles.csv")

    for where, kind, least, most in (("points", "triangle", 2.7, 4e-4), ("cells", "quad", 1.8, 1.6e-2)):
        errors = []
        for cells in (8, 16):
            flow = made(tmp_path, f"{where}{cells}", [vortex_file(tmp_path / "one.vtu", cells, kind, where)])
            errors.append(astray(track(flow, f"{where}{cells}_run")))
        assert errors[1] < most and np.log2(errors[0] / errors[1]) > least, (where, errors)
    errors = []
    for n in (4, 8):
        files = [vortex_file(tmp_path / f"{k}.vtu", 24, t=END * k / n, swell=0.5) for k in range(n + 1)]
        flow = made(tmp_path, f"times{n}", files, "--times", ",".join(f"{END * k / n:g}" for k in range(n + 1)))
        errors.append(astray(track(flow, f"times{n}_run"), 0.5))
    assert errors[1] < 0.013 and np.log2(errors[0] / errors[1]) > 1.7, errors


def test_a_restart_goes_on_in_an_unsteady_flow(freefem, growing, tmp_path):
    words = "-flow", growing, "-flow-start", 0.5, "-dt", 0.01, "-high", 0.3
    freefem(SCRIPT, *words, "-tend", 0.3, "-checkpoint", 20, "-out", tmp_path / "whole")
    shutil.copytree(tmp_path / "whole", tmp_path / "part")
    wanted = (tmp_path / "whole/particles.csv").read_text()
    (last := sorted((tmp_path / "part").glob("restart_*30*")))[0].unlink()
    assert len(last) > 1
    freefem(SCRIPT, *words, "-tend", 0.3, "-checkpoint", 20, "-restart", tmp_path / "part", "-out", tmp_path / "part")
    assert (tmp_path / "part/particles.csv").read_text() == wanted


def test_what_does_not_fit_is_refused(freefem_refused, growing, tmp_path):
    def line(*words):
        return freefem_refused(3, SCRIPT, *words, "-out", tmp_path / "run")

    assert "no flow is given: -flow FOLDER" in line("-mesh", ROOT / "meshes/channel.mesh")
    assert "nowhere/flow.txt" in (said := line("-flow", "nowhere")) and "python -m tools.flow has made" in said
    assert "lasts 3 s, the run needs 4" in line("-flow", growing, "-flow-start", 2, "-tend", 2)
    assert "does not belong to the mesh" in line("-flow", growing, "-mesh", ROOT / "meshes/channel.mesh")
    assert "has no k and epsilon" in line("-flow", ROOT / "meshes/openfoam_pipe", "-turbulence", "fluctuation")
    shutil.copytree(growing, tmp_path / "cut")
    (tmp_path / "cut/frame_00001.txt").unlink()
    assert "frame_00001.txt is not there or not whole" in line("-flow", tmp_path / "cut", "-tend", 1)
    (tmp_path / "cut/flow.txt").write_text("given_flow 1\nmesh")
    assert "is no whole flow" in line("-flow", tmp_path / "cut")


def test_spheres_in_openfoams_flow_go_as_in_our_own(freefem, tmp_path):
    """Heights and times at which they pass places in the pipe, from 10 cells in the radius; the differences fall with these (python
    -m tools.peers.openfoam_paths)."""
    own = read_table(ROOT / "tests/reference/pipe_passages.csv")
    freefem(SCRIPT, "-flow", ROOT / "meshes/openfoam_pipe", "-rhof", 998.2, "-mu", 3.9928, "-density", 2495.5, "-radius", 0.001,
        "-start-x", 0.02, "-low", -0.08, "-high", 0.07, "-number", 8, "-dt", 0.002, "-tend", 2, "-out", tmp_path / "run")
    found = passages(read_table(tmp_path / "run/particles.csv"))
    height, time = zip(*(found[place, name] for place, name in zip(own["x"], own["id"])))
    assert np.abs(height - own["y"]).max() < 0.06 * 0.1 and np.abs(time / own["t"] - 1).max() < 0.08
