"""The flow that carries particles: its values at points, over the seam of a period, and the saved flow that it is."""
import re

import numpy as np
import pytest

from tests.conftest import ROOT
from tests.tables import records
from tools.base.tables import read_table


def test_flow_at_points_is_exact_for_a_quadratic(freefem):
    text = freefem("tests/transport/scripts/carrier.edp").stdout
    number = {name: float(value) for name, value in re.findall(r"^(time|worst|outside|edges|lost) (\S+)", text, re.M)}
    assert number["worst"] < 1e-10 and number["outside"] == 0
    assert number["edges"] > 1000 and number["lost"] == 0
    assert "flags 01010" in text
    values = [float(word) for word in re.search(r"^rim (.*)", text, re.M)[1].split()]
    assert values[0] == pytest.approx(values[1], abs=0.02) and values[2] == pytest.approx(values[3], abs=0.02)


LAMINAR = ["-model", "laminar", "-reynolds", 100]


@pytest.mark.slow
def test_pipe_transport_reuses_its_flow_and_loses_nobody(freefem, tmp_path):
    folder = tmp_path / "flow"
    words = [*LAMINAR, "-flow", folder, "-tend", 0.5, "-number", 20]
    first = freefem("cases/pipe_transport.edp", *words, "-out", tmp_path / "one", timeout=900)
    second = freefem("cases/pipe_transport.edp", *words, "-out", tmp_path / "two", timeout=300)
    assert "computing the steady flow" in first.stdout and "is taken from" in second.stdout
    assert (tmp_path / "one/particles.csv").read_text() == (tmp_path / "two/particles.csv").read_text()
    last = records(tmp_path / "two/steps.csv")[-1]
    assert int(last["lost"]) == 0 and int(last["entered"]) == int(last["particles"]) + int(last["left"])
    worst = min(float(row["worst_gap"]) for row in records(tmp_path / "two/steps.csv"))
    assert worst > -1e-8 * 0.01
    refused = freefem("cases/pipe_transport.edp", *LAMINAR, "-vmax", 1, "-flow", folder, "-out", tmp_path / "three", check=False)
    assert refused.returncode == 3 and len(refused.stderr.splitlines()) == 1 and "another setting" in refused.stderr


def test_a_run_that_is_no_steady_flow_is_not_overwritten(freefem, freefem_refused, tmp_path):
    freefem("cases/settling_disk.edp", "-tend", 0.01, "-out", tmp_path / "run")
    kept = (tmp_path / "run/particles.csv").read_text()
    line = freefem_refused(3, "cases/pipe_transport.edp", *LAMINAR, "-flow", tmp_path / "run", "-out", tmp_path / "other")
    assert "no steady flow" in line and (tmp_path / "run/particles.csv").read_text() == kept


def test_a_missing_mesh_is_one_line_and_status_3(freefem, tmp_path):
    done = freefem("cases/pipe_transport.edp", "-out", tmp_path / "run", "-mesh", "nowhere.mesh", check=False)
    assert done.returncode == 3 and "cannot read the mesh file" in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("name", ["README.md", "README.md/flow"])
def test_a_flow_that_cannot_be_a_folder_is_refused(name, freefem_refused, tmp_path):
    readme = (ROOT / "README.md").read_bytes()
    line = freefem_refused(3, "cases/pipe_transport.edp", *LAMINAR, "-flow", name, "-out", tmp_path / "other")
    assert name in line and (ROOT / "README.md").read_bytes() == readme and not (ROOT / "README.md.log").exists()


@pytest.fixture
def no_flow(tmp_path, monkeypatch):
    """The run within the run, which computes the steady flow, fails."""
    fake = tmp_path / "fake"
    fake.write_text("#!/bin/sh\necho step 1\necho 'error: the residual is 3 after 80 factorisations'\nexit 4\n")
    fake.chmod(0o755)
    monkeypatch.setenv("FREEFEM", str(fake))


def test_a_flow_of_older_sources_is_not_taken(freefem, no_flow, tmp_path):
    """The folder of a steady flow goes by its case and all that this includes."""
    part, flow, script, folders = tmp_path / "part.idp", tmp_path / "flow.edp", tmp_path / "mine.edp", []
    flow.write_text(f'    include "{part}"\n')
    script.write_text((ROOT / "cases/pipe_transport.edp").read_text().replace("cases/pipe_flow.edp", str(flow)))
    for text in ("// one", "// one", 'include "lib/core/errors.idp"'):
        part.write_text(text)
        said = freefem(script, "-out", tmp_path / "run", check=False).stdout
        folders.append(re.search(r"computing the steady flow into (results/pipe_flow/steady_\w{16}) ", said)[1])
        (ROOT / folders[-1]).rmdir()
    assert folders[0] == folders[1] != folders[2]


def test_a_steady_flow_that_does_not_come_about_says_why(freefem_refused, no_flow, tmp_path):
    line = freefem_refused(4, "cases/pipe_transport.edp", "-flow", tmp_path / "flow", "-out", tmp_path / "run")
    assert "was not computed (status 4): the residual is 3 after 80 factorisations; see " in line and "/flow.log" in line


PERIODIC = """include "lib/case.idp"
optCase("periodic", "spheres go round in a periodic flow");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
optDefault("-mesh", "meshes/periodic_box.mesh");
{flow}
macro caseParticles() {{
    contactPeriodic(0, 0, 1, 1);
    real[int] x0 = [0.9, 0.2], y0 = [0.5, 0.1], r = [1e-3, 1e-3], d = [2500., 2500.], u0 = [0., 1.], v0 = [0., -0.8], z = [0., 0.];
    transportAppend(x0, y0, r, d, u0, v0, z);
}} // EOM
include "scripts/transport.edp"
"""


def test_a_flow_on_a_mesh_goes_on_over_the_seam_of_a_period(freefem_text, tmp_path):
    """Who went over the seam stood outside the mesh and was taken out; now as in the same flow by a formula, for three periods
    along both."""
    flows = {"mesh": "macro caseCarrier() carrierWh u = 1 + 0.5*sin(2*pi*x), v = -0.8; carrierFlow(u[], v[]); // EOM",
             "formula": 'macro carrierExact(px, py, t) carrierU = (2*pi)*px; carrierUX = cos(carrierU); carrierUX *= pi; '
                 'carrierU = sin(carrierU); carrierU *= 0.5; carrierU += 1.; carrierV = -0.8; // EOM'}
    found = {}
    for name, flow in flows.items():
        text = PERIODIC.format(flow=flow)
        if name == "formula":
            text = text.replace('optDefault("-mesh", "meshes/periodic_box.mesh");\n', "")
        freefem_text(text, "-drag", "schiller-naumann", "-dt", 0.005, "-tend", 4, "-every", 0.5, "-out", tmp_path / name)
        found[name] = read_table(tmp_path / name / "particles.csv")
        assert records(tmp_path / name / "exits.csv") == []
    assert found["mesh"]["x"].max() > 3 and found["mesh"]["y"].min() < -2.5
    for name in "xyuv":
        np.testing.assert_allclose(found["mesh"][name], found["formula"][name], atol=3e-3)
