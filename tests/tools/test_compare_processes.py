"""tools.compare_processes: how far apart the tables of two runs are."""
import math

import pytest

from tools.compare_processes import difference

TABLE = "t,u,flux,name,time_solve,kinetic_energy\n0,2,1e-17,wall,1,8\n1,4,3e-17,wall,1,9\n"
OTHERS = "step,t,id,x,y,theta,u,v,omega,radius\n0,0,0,0,0,0,0,0,0,0.5\n1,1,0,0,0,0,0,0,0,0.5\n"  # of a domain of the length 1


@pytest.mark.parametrize("other, apart", [
    (TABLE, 0),
    (TABLE.replace("4,3e-17", "4.004,9e-17"), 1e-3),
    (TABLE.replace("wall,1,8\n1", "wall,7,8\n1"), 0),
    (TABLE.replace("wall,1,8\n1", "inlet,1,8\n1"), math.inf),
    (TABLE + "2,5,0,wall,1,9\n", math.inf),
    (TABLE.replace("4,3e-17", "nan,3e-17"), math.inf),
    (TABLE.replace("u,flux", "u,flow"), math.inf),
])
def test_difference(tmp_path, other, apart):
    runs(tmp_path, TABLE, other)
    assert difference(tmp_path / "one", tmp_path / "many") == pytest.approx(apart, rel=1e-9)
    (tmp_path / "many/forces.csv").write_text(TABLE)
    assert difference(tmp_path / "one", tmp_path / "many") == math.inf


def test_a_normal_that_has_no_part_along_an_axis_but_for_rounding_is_the_same(tmp_path):
    """On an incline of one process it was 0 and on two 2e-15, which counted as all of it."""
    contacts = "t,nx,ny\n1,1,0\n"
    runs(tmp_path, TABLE, TABLE)
    for name, text in (("one", contacts), ("many", contacts.replace(",0\n", ",2e-15\n"))):
        (tmp_path / name / "contacts.csv").write_text(text)
    assert difference(tmp_path / "one", tmp_path / "many") < 1e-9
    (tmp_path / "many/contacts.csv").write_text(contacts.replace(",0\n", ",0.01\n"))
    assert difference(tmp_path / "one", tmp_path / "many") > 1


def runs(folder, first, second, tracks=OTHERS):
    """Two run folders with these texts of fluid.csv."""
    for name, text in (("one", first), ("many", second)):
        (folder / name).mkdir()
        (folder / name / "fluid.csv").write_text(text)
        (folder / name / "particles.csv").write_text(tracks)
        (folder / name / "run.json").write_text('{"case": "trial"}')


@pytest.mark.parametrize("length, speed, mass", [(1, 1, 1), (1e-6, 1e-9, 1e-15), (1e5, 1e-11, 1e20)])
def test_what_counts_as_rounding_does_not_hang_on_units(tmp_path, length, speed, mass):
    """Before: a column below 1e-5 in the units of the case was left out: all speeds of a colloid. Now 1e-3 of its speed counts, and
    a flux that is rounding counts over 1e-5 of speed times length."""
    energy, flux = mass * speed**2, speed * length

    def table(u, q):
        return f"t,u,flux,kinetic_energy\n0,{2 * speed},0,{energy}\n1,{u * speed},{q * flux},{energy}\n"
    tracks = OTHERS.replace("0.5", f"{0.5 * length}")
    runs(tmp_path, table(4, 1e-16), table(4.004, 3e-16), tracks)
    assert difference(tmp_path / "one", tmp_path / "many") == pytest.approx(1e-3, rel=1e-6)
    (tmp_path / "b").mkdir()
    runs(tmp_path / "b", table(4, 1e-16), table(4, 3e-16), tracks)
    assert difference(tmp_path / "b/one", tmp_path / "b/many") == pytest.approx(2e-16 / 4e-5, rel=1e-6)
