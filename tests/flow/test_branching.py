"""A channel that divides: what flows through each outlet, who leaves, when and where."""
import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base.run_folder import RunFolder
from tools.meshing.main import main as make_mesh

CASE = "cases/branching_channel.edp"
# The same flow by another way: Stokes' equations all at once, the outlets' condition that of the weak form.
STOKES = """
mesh Th = readmesh("{mesh}");
fespace Vh(Th, [P2, P2, P1]);
Vh [u, v, p], [a, b, q];
solve stokes([u, v, p], [a, b, q], solver = UMFPACK) = int2d(Th)(dx(u)*dx(a) + dy(u)*dy(a) + dx(v)*dx(b) + dy(v)*dy(b) - p*(dx(a) + dy(b)) - q*(dx(u) + dy(v)))
    + on(3, 5, u = 0, v = 0) + on(1, u = 80*y*(1 - y), v = 0);
cout.precision(12);
cout << "fluxes " << int1d(Th, 1)(N.x*u + N.y*v) << " " << int1d(Th, 2)(N.x*u + N.y*v) << " " << int1d(Th, 12)(N.x*u + N.y*v) << endl;
"""


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    """The channel of the gmsh script with elements of 0.06."""
    file = tmp_path_factory.mktemp("branching") / "channel.mesh"
    with pytest.MonkeyPatch.context() as patch:
        script = file.parent / "channel.geo"
        script.write_text((ROOT / "meshes" / "branching_channel.geo").read_text().replace("size = 1/24", "size = 0.06"))
        patch.setattr("sys.argv", ["mesh", "own", "--from", str(script), "--out", str(file)])
        assert make_mesh() == 0
    return file


def test_outlets_share_the_flow_as_in_stokes_equations(mesh, freefem, freefem_text, tmp_path):
    freefem(CASE, "-mesh", mesh, "-number", 0, "-convection", 0, "-tend", 0.4, "-out", tmp_path / "run")
    rows = RunFolder(tmp_path / "run").table("fluxes")
    last = {int(label): flux for t, label, flux in zip(rows["t"], rows["label"], rows["flux"]) if t == rows["t"].max()}
    exact = next(line.split()[1:] for line in freefem_text(STOKES.format(mesh=mesh)).stdout.splitlines()
        if line.startswith("fluxes"))
    assert list(last) == [1, 2, 12]
    for label, value in zip(last, map(float, exact)):
        assert last[label] == pytest.approx(value, rel=2e-3)
    assert sum(last.values()) == pytest.approx(0, abs=1e-3 * last[2])


def test_who_leaves_is_told_once_and_goes_where_the_water_goes(mesh, freefem, tmp_path):
    """The height of entry that parts those that leave below from those above is that of the streamline which ends at the island."""
    freefem(CASE, "-mesh", mesh, "-diameter", 0.2, "-number", 12, "-interval", 0.03, "-tend", 0.85, "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    entered, left = (run.table(name) for name in ("entries", "exits"))
    inside = {int(one) for one in run.particles["id"][run.particles["t"] == run.fluid["t"].max()]}
    assert sorted(entered["id"]) == list(range(12))
    assert sorted([*left["id"], *inside]) == list(range(12)) and len(left["id"]) >= 10
    assert (np.diff(left["t"]) >= 0).all() and (left["x"] > 6.1).all() and (left["radius"] == 0.1).all()
    for one, t, y in zip(left["id"], left["t"], left["y"]):
        own = run.particles["id"] == one
        assert run.particles["t"][own].max() < t <= run.particles["t"][own].max() + 0.011  # -every, and a step
        assert run.particles["y"][own][-1] == pytest.approx(y, abs=0.03)
    below = {int(one) for one, y in zip(left["id"], left["y"]) if y < 0.5}
    above = {int(one) for one, y in zip(left["id"], left["y"]) if y > 0.65}
    assert below and above and len(below) + len(above) == len(left["id"])
    sides = {int(one): int(label) for one, label in zip(left["id"], left["label"])}
    assert sides == dict.fromkeys(below, 2) | dict.fromkeys(above, 12)
    height = dict(zip(entered["id"].astype(int), entered["y"]))
    fluxes = run.table("fluxes")
    share = fluxes["flux"][fluxes["label"] == 2][-1] / -fluxes["flux"][fluxes["label"] == 1][-1]
    parting = np.interp(share, *((lambda h: (3 * h**2 - 2 * h**3, h))(np.linspace(0, 1, 1001))))
    assert max(height[one] for one in below) < parting + 0.03
    assert min(height[one] for one in above) > parting - 0.03
