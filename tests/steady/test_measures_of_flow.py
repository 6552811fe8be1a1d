"""Measures of steady flows: heads, zones of separation, shear on walls, means over sections."""
import math

import numpy as np
import pytest

from tests.scenes import sides, write_box
from tests.tables import numeric_records, results, results_of
from tools.base.mesh_files import read_field
from tools.base.tables import read_table


def test_what_enters_and_heads_are_those_of_the_fields(freefem, run_folder, tmp_path):
    """A turbulent channel: k and eddy viscosity at the inlet by their formulas; pressure and loss from the fields, p + 2/3 rho k +
    rho u^2/2 weighted by the flux."""
    box = write_box(tmp_path / "box.mesh", 0.5, -0.1, 0.1, 20, 16, 3)
    found = results_of(freefem, run_folder, "pipe_flow", "-mesh", box, "-model", "k-epsilon", "-pressure", 50000, "-intensity",
        0.1, "-profile", "parabola")
    mesh, data = read_field(run_folder / "fields.vtu")
    points = mesh.points
    ends = []
    for x in (0, 0.5):
        side = np.flatnonzero(np.abs(points[:, 0] - x) < 1e-9)
        y, order = np.unique(points[side, 1].round(9), return_index=True)
        ends.append((y, {name: np.asarray(values)[side[order]] for name, values in data.items()}))
    (y, inlet), (_, outlet) = ends
    energy = 1.5 * (0.1 * 2 * 2 / 3) ** 2
    assert inlet["k"] == pytest.approx(energy, rel=1e-6)
    # from the wall, of which the mesh leaves out 30 wall units at least
    away = 0.1 - np.abs(y[::2]) + 30 * 2 * 0.2 / found["reynolds"] / (0.09**0.25 * energy**0.5)
    assert inlet["epsilon"][::2] == pytest.approx(0.09**0.75 * energy**1.5 / np.minimum(0.07 * 0.2, 0.41 * away), rel=1e-5)
    assert data["nu_t"].max() == pytest.approx(found["turbulent_viscosity_over_molecular_most"] * 2 * 0.2 / found["reynolds"],
        rel=1e-6)

    def mean(weight, values):  # the nodes are ends and middles of edges: Simpson's rule
        rule = np.resize([2.0, 4.0], len(y))
        rule[[0, -1]] = 1
        return rule @ (weight * values) / (rule @ weight)

    heads = [mean(side["velocity"][:, 0], side["pressure"] + 2 / 3 * 1000 * side["k"] + 500 * (side["velocity"] ** 2).sum(axis=1))
        for side in (inlet, outlet)]
    # an outlet free of traction: the pressure is without 2/3 rho k, here 40 Pa
    assert abs(mean(np.ones(len(y)), outlet["pressure"] + 2 / 3 * 1000 * outlet["k"])) < 5
    assert found["head_loss"] == pytest.approx(heads[0] - heads[1], rel=0.01)  # without 2/3 rho k a quarter less
    walls, length = numeric_records(run_folder / "wall.csv"), 0.2
    borne = sum(row["shear"] * row["length"] for row in walls)
    push = [length * mean(np.ones(len(y)), side["pressure"] + 2 / 3 * 1000 * side["k"] + 1000 * side["velocity"][:, 0] ** 2)
        for side in (inlet, outlet)]
    # pressure and momentum that go in and do not come out
    assert len(walls) == 40 and borne == pytest.approx(push[0] - push[1], rel=0.05)
    assert found["pressure_inlet"] == pytest.approx(50000 + mean(np.ones(len(y)), inlet["pressure"]), abs=0.1)
    assert found["loss_coefficient"] == pytest.approx(found["head_loss"] / (500 * (4 / 3) ** 2), rel=5e-3)


def test_the_jet_of_a_narrow_slit_contracts(freefem, run_folder):
    # The standard production makes turbulence where the stream is only accelerated: 0.72 (within 20 %).
    found = results_of(freefem, run_folder, "diaphragm_loss", "-opening", 0.2, "-cells", 6, "-outlet", 8, "-tolerance", 1e-3)
    assert found["contraction"] == pytest.approx(found["contraction_mises"], rel=0.05)
    assert found["loss_over_borda_carnot"] == pytest.approx(1, abs=0.1)
    # 12 where old factors serve only a residual that falls to six tenths (to a tolerance of 1e-6: 34 for 7)
    assert found["factorisations"] < 10


def test_walls_of_a_body_in_the_stream(freefem, freefem_text, run_folder, tmp_path):
    """A long block in mid-channel leaves two gaps: in the middle of them both walls have the shear of a plane Poiseuille flow, and
    nothing flows back."""
    outer, pipe = sides("outer", (0, -0.1, 3, 60), (1, -0.1, 2, 16), (1, 0.1, 3, 60), (0, 0.1, 1, 16))
    inner, block = sides("inner", (0.25, -0.05, 5, 12), (0.25, 0.05, 5, 50), (0.75, 0.05, 5, 12), (0.75, -0.05, 5, 50))
    freefem_text(f'{outer}\n{inner}\nmesh Th = buildmesh({pipe} + {block});\nsavemesh(Th, "{tmp_path}/block.mesh");\n')
    found = results_of(freefem, run_folder, "pipe_flow", "-mesh", tmp_path / "block.mesh", "-model", "laminar", "-reynolds", 1,
        "-vmax", 1)
    mu = 998.2 * 0.2
    exact = 6 * mu * found["flux_in"] / 2 / 0.05**2
    middle = [r for r in numeric_records(run_folder / "wall.csv") if 0.45 < r["x"] < 0.55]
    assert len({(r["wall"], r["side"]) for r in middle}) == 4
    for r in middle:
        assert r["shear"] == pytest.approx(exact, rel=0.02)
    assert numeric_records(run_folder / "zones.csv") == []


def test_the_profile_is_that_of_a_narrow_inlet(freefem, freefem_text, run_folder, tmp_path):
    outer, calls = sides("outer", (0, 0, 8, 50), (1, 0, 2, 12), (1, 0.1, 3, 40), (0.3, 0.1, 3, 8), (0.3, 0.05, 3, 20),
        (0, 0.05, 1, 8))
    freefem_text(f'{outer}\nmesh Th = buildmesh({calls});\nsavemesh(Th, "{tmp_path}/wider.mesh");\n')
    found = results_of(freefem, run_folder, "pipe_flow", "-mesh", tmp_path / "wider.mesh", "-model", "laminar", "-reynolds", 20,
        "-vmax", 2, "-axisymmetric", 1)
    assert found["flux_in"] == pytest.approx(math.pi * 0.05**2, rel=1e-9) and found["mean_velocity"] == pytest.approx(1, rel=1e-9)


def test_pipe_flow_tells_what_large_elements_at_the_walls_do(freefem, run_folder, tmp_path):
    """A straight round pipe: the stream of the inlet's profile, and the friction of the law of the wall that stands far off the
    wall."""
    coarse = write_box(tmp_path / "pipe.mesh", 1.0, 0.0, 0.1, 20, 8, bottom=8)
    out = freefem("cases/pipe_flow.edp", "-mesh", coarse, "-axisymmetric", 1, "-profile", "power", "-out", run_folder).stdout
    found = results(run_folder)
    assert f"its mean is {found['mean_velocity']:.6g} m/s, not 1.63333" in out
    assert f"at a mean distance of {100 * found['wall_distance_mean'] / 0.1:.0f} % of the pipe's radius" in out and "take smaller elements at the walls" in out
    out = freefem("cases/pipe_flow.edp", "-mesh", coarse, "-axisymmetric", 1, "-reynolds", 5000, "-out", run_folder, "-overwrite",
        1).stdout
    found = results(run_folder)
    assert found["wall_distance_least"] == pytest.approx(30,
        rel=1e-9) and found["wall_distance_most"] == 30 and f"here {100 * found['wall_distance_mean'] / 0.1:.0f} %, whatever the elements: take a higher Reynolds number" in out


def test_zones_of_slanted_walls_end_where_the_walls_do(freefem, freefem_text, tmp_path):
    """Behind a body whose sides are slanted by 63 degrees, to its very end."""
    mesh = tmp_path / "body.mesh"
    freefem_text(f"""
border low(s = 0, 1) {{ x = s; y = -0.1; label = 3; }}
border right(s = -0.1, 0.1) {{ x = 1; y = s; label = 2; }}
border top(s = 1, 0) {{ x = s; y = 0.1; label = 3; }}
border left(s = 0.1, -0.1) {{ x = 0; y = s; label = 1; }}
border b1(s = 0, 1) {{ x = 0.3 + 0.02*s; y = 0.04*s; label = 5; }}
border b2(s = 0, 1) {{ x = 0.32 + 0.02*s; y = 0.04*(1 - s); label = 5; }}
border b3(s = 0, 1) {{ x = 0.34 - 0.02*s; y = -0.04*s; label = 5; }}
border b4(s = 0, 1) {{ x = 0.32 - 0.02*s; y = -0.04*(1 - s); label = 5; }}
savemesh(buildmesh(low(50) + right(10) + top(50) + left(10) + b1(4) + b2(4) + b3(4) + b4(4)), "{mesh}");
""")
    freefem("cases/pipe_flow.edp", "-mesh", mesh, "-model", "laminar", "-reynolds", 60, "-out", tmp_path / "run")
    zones = read_table(tmp_path / "run" / "zones.csv")
    behind = (zones["separation"] > 0.3) & (zones["separation"] < 0.34)
    assert behind.any() and zones["reattachment"][behind].max() == pytest.approx(0.34, abs=1e-6)


ZONES = """
mesh Th = square(2, 2);
int measureAxis = 0;
int[int] measureWalls = [1];
include "lib/steady/measures.idp"
real[int] shear = [-3, -1, 1, 2, -5, 2, 2, 1, -1, -4, -1, 1, 1, -1, -5], side = [-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, 1, 1, 1], piece = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 1];
wallX.resize(15); wallAlong.resize(15); wallShear.resize(15) = shear; wallSide.resize(15) = side; wallPiece.resize(15) = piece;
wallAlong = 0.1;
for (int i = 0; i < 15; ++i) wallX[i] = 0.05 + 0.1*(i < 10 ? i : i - 10);
wallX[12] = 0.05; wallX[13] = 0.15; wallX[14] = 0.65;
for (int k = 0; k < 2; ++k) {
    int number = measureZones((k ? 0.19 : 0.05));
    cout.precision(15);
    for (int i = 0; i < number; ++i) cout << "ZONE " << k << " " << zones(i, 0) << " " << zones(i, 1) << " " << zones(i, 2) << " " << zones(i, 3) << " " << zones(i, 4) << " " << zones(i, 5) << endl;
}
"""


def test_zones_are_what_the_shear_along_each_wall_says(freefem_text):
    """From the beginning of a wall or where a straight line between two edges passes 0; no zone goes over to another wall or side.
    Short ones and short parts between two are left out."""
    found = [list(map(float, line.split()[1:])) for line in freefem_text(ZONES).stdout.splitlines() if line.startswith("ZONE")]
    whole = [[-1, 0, 0.2, 0.2, -3, 0], [-1, 0.35 + 0.2 / 7, 0.45 + 0.5 / 7, 0.1 + 0.3 / 7, -5, 0], [-1, 0.8, 1, 0.2, -4, 0],
        [-1, 0, 0.1, 0.1, -1, 1], [1, 0.1, 0.2, 0.1, -1, 0], [1, 0.6, 0.7, 0.1, -5, 1]]
    long = [[-1, 0, 0.45 + 0.5 / 7, 0.45 + 0.5 / 7, -5, 0], [-1, 0.8, 1, 0.2, -4, 0]]
    np.testing.assert_allclose(found, [[0, *zone] for zone in whole] + [[1, *zone] for zone in long], atol=1e-12)


MEANS = """
mesh Th = square(4, 4, [x, 2.*y]);
int measureAxis = AXIS;
int[int] measureWalls = [1], right = [2];
include "lib/steady/measures.idp"
steadyDensity = 3; steadyU = 1. + y; steadyV = 2.*y; steadyP = 5.*y; steadyK = 0.3 + 0.*x;
cout.precision(12);
cout << "FOUND " << measureFlux(right) << " " << measureMeanPressure(right) << " " << measureHead(right) << endl;
"""


@pytest.mark.parametrize("axis", [0, 1])
def test_means_over_a_section_are_those_of_the_plane_or_round_one(axis, freefem_text):
    y, rule = np.polynomial.legendre.leggauss(8)
    y, weight = 1 + y, rule * (2 * np.pi * (1 + y) if axis else 1)
    u, p, speed2 = 1 + y, 5 * y, (1 + y) ** 2 + 4 * y**2
    flux = weight @ u
    expected = [flux, weight @ p / weight.sum(), weight @ ((p + 2 / 3 * 3 * 0.3 + 1.5 * speed2) * u) / flux]
    assert list(map(float,
        freefem_text(MEANS.replace("AXIS", str(axis))).stdout.split("FOUND")[1].split()[:3])) == pytest.approx(expected, rel=1e-9)
