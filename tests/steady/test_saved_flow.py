"""A steady flow kept in a folder: what is saved is what is loaded, and what is not converged is not kept."""
import shutil

import numpy as np
import pytest

from tests.steady.conftest import SHORT
from tests.tables import results
from tools.base.mesh_files import read_field


def test_laminar_pipe_and_its_state(freefem_text, run_folder, pipe_run):
    shutil.copytree(pipe_run, run_folder)
    found = results(run_folder)
    assert found["residual"] <= 1e-6 and found["factorisations"] <= 10
    assert abs(found["flux_defect"]) < 1e-6
    assert found["speed_most_at_the_walls_edge_of_the_mesh"] < 1e-9
    assert found["diaphragm_lower_length"] > 0 and found["obstacle_upper_length"] > 0
    assert found["diaphragm_throat_speed_most"] > 2
    fine, values = read_field(run_folder / "fields.vtu")
    speed = np.hypot(*values["velocity"][:, :2].T)
    fastest = np.hypot(fine.points[:, 0] - found["speed_most_x"], fine.points[:, 1] - found["speed_most_y"])
    assert fastest.min() < 1e-6 and speed[fastest.argmin()] == pytest.approx(found["speed_most"],
        rel=1e-5) and found["speed_most"] > 0.98 * speed.max()
    text = f'''
include "lib/mesh/read_mesh.idp"
mesh Th = meshRead("{run_folder}/mesh.mesh");
include "lib/steady/saved_flow.idp"
steadyLoad("{run_folder}");
cout.precision(12);
cout << "FOUND " << int1d(Th, labelInlet)(-steadyU*N.x) << " " << steadyDensity << " " << steadyModel
     << " " << steadyMatches("{run_folder}", "another setting") << endl;
'''
    words = freefem_text(text).stdout.split("FOUND")[1].split()
    assert float(words[0]) == pytest.approx(found["flux_in"], rel=1e-9)
    assert words[1:4] == ["998.2", "laminar", "0"]
    # a state whose mesh was changed is refused
    with open(run_folder / "mesh.mesh", "a") as file:
        file.write("\n")
    refused = freefem_text(text, check=False)
    assert refused.returncode == 3 and "does not belong" in refused.stderr


def test_a_state_that_is_saved_is_the_one_that_is_loaded(freefem_text, tmp_path):
    out = freefem_text(f"""
mesh Th = square(3, 3);
savemesh(Th, "{tmp_path}/mesh.mesh");
include "lib/steady/saved_flow.idp"
steadyU = x*y; steadyV = x - y^2; steadyP = 3.*x; steadyK = 1. + y; steadyEpsilon = 2. + x*y; steadyNut = 0.1*x;
steadyDensity = 7; steadyViscosity = 0.5; steadyResidual = 1e-7; steadyModel = "k-epsilon";
real[int] u = steadyU[], v = steadyV[], p = steadyP[], k = steadyK[], e = steadyEpsilon[], n = steadyNut[];
steadySave("{tmp_path}", "one");
steadyU = 0; steadyV = 0; steadyP = 0; steadyK = 0; steadyEpsilon = 0; steadyNut = 0; steadyDensity = 1; steadyViscosity = 1; steadyResidual = 1; steadyModel = "none";
steadyLoad("{tmp_path}");
u -= steadyU[]; v -= steadyV[]; p -= steadyP[]; k -= steadyK[]; e -= steadyEpsilon[]; n -= steadyNut[];
cout << "FOUND " << u.linfty + v.linfty + p.linfty + k.linfty + e.linfty + n.linfty << " " << steadyDensity << " " << steadyViscosity << " " << steadyResidual << " " << steadyModel
    << " " << steadyMatches("{tmp_path}", "one") << steadyMatches("{tmp_path}", "two") << endl;
exec("sed -i '$d' '{tmp_path}/steady_flow.txt'"); // its last line
cout << "BROKEN " << steadyMatches("{tmp_path}", "one") << endl;
""").stdout
    words = out.split("FOUND")[1].split()
    assert float(words[0]) < 1e-14 and words[1:6] == ["7", "0.5", "1e-07", "k-epsilon",
        "10"] and out.split("BROKEN")[1].split()[0] == "0"


def test_a_flow_that_is_not_converged_is_not_kept(freefem, freefem_refused, run_folder, coarse_pipe, pipe_run):
    words = ["-mesh", coarse_pipe, *SHORT]
    shutil.copytree(pipe_run, run_folder)
    assert (run_folder / "steady_flow.txt").is_file()
    refused = freefem_refused(4, "cases/pipe_flow.edp", *words, "-out", run_folder, "-overwrite", 1, "-steps", 1)
    assert "the residual is" in refused and (run_folder / "fields.vtu").is_file()
    assert not list(run_folder.glob("steady_flow.txt*"))
    taken = freefem("cases/pipe_transport.edp", *words, "-flow", run_folder, "-number", 1, "-tend", 0.004, "-out",
        run_folder / "carried")
    assert "computing the steady flow" in taken.stdout
