"""tools.compare_processes: how far apart the tables of two runs are."""
import math

import pytest

from tools.compare_processes import difference

TABLE = "t,u,flux,name,time_solve\n0,2,1e-17,wall,1\n1,4,3e-17,wall,1\n"


@pytest.mark.parametrize("other, apart", [
    (TABLE, 0),
    (TABLE.replace("4,3e-17", "4.004,9e-17"), 1e-3),
    (TABLE.replace("wall,1\n1", "wall,7\n1"), 0),
    (TABLE.replace("wall,1\n1", "inlet,1\n1"), math.inf),
    (TABLE + "2,5,0,wall,1\n", math.inf),
    (TABLE.replace("u,flux", "u,flow"), math.inf),
])
def test_difference(tmp_path, other, apart):
    for name, text in (("one", TABLE), ("many", other)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "fluid.csv").write_text(text)
    assert difference(tmp_path / "one", tmp_path / "many") == pytest.approx(apart, rel=1e-9)
    (tmp_path / "many/forces.csv").write_text(TABLE)
    assert difference(tmp_path / "one", tmp_path / "many") == math.inf
