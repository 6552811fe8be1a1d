"""The two solvers of the pressure of spheres (lib/spheres/pressure_solver.idp): a Cholesky factor, and conjugate gradients."""
import numpy as np
import pytest

from tools.base.tables import read_table


@pytest.mark.parametrize("case, end", [("cases/settling_sphere.edp", 0.02), ("cases/held_sphere.edp", 0.2)])
def test_both_solvers_give_the_same_flow(case, end, freefem, tmp_path):
    """Closed (the pressure is known up to a constant) and open: with -direct 0 the velocities are those of the factor, to the
    tolerance of the iterations."""
    column = "w" if "settling" in case else "fx"
    table = "particles" if "settling" in case else "forces"
    found = {}
    for direct in (200000, 0):
        freefem(case, "-tend", end, "-direct", direct, "-out", tmp_path / str(direct))
        found[direct] = read_table(tmp_path / str(direct) / f"{table}.csv")[column]
    assert np.abs(found[0]).min() > 0
    assert found[0] == pytest.approx(found[200000], rel=1e-5)
