"""Numbers of a run's tables by expressions, and their units."""
import json
import math

import numpy as np
import pytest

from tests.synthetic import write_csv
from tools.base import quantities
from tools.base.command import BadInput
from tools.base.expressions import product, unit_of
from tools.base.run_folder import RunFolder

TIMES = (0, 1, 3)


@pytest.fixture
def run(tmp_path):
    """Two particles at three times that are not equally far apart; y of particle 1 is 10, 20, 60."""
    write_csv(tmp_path / "particles.csv", "t,id,x,y,theta,radius".split(","), [[t, one, t + one, (10, 20, 60)[k] * one, 0, 0.1]
        for k, t in enumerate(TIMES) for one in (1, 2)])
    write_csv(tmp_path / "fluid.csv", "t,kinetic_energy,flux_in,flux_out".split(","), [[t, t * t, -1, 1] for t in TIMES])
    write_csv(tmp_path / "exits.csv", "t,id,outlet".split(","), [[1, 1, 2], [3, 2, 9]])
    (tmp_path / "results.csv").write_text("quantity,value,unit\ndrag,5.5,N/m\n")
    (tmp_path / "run.json").write_text(json.dumps({"units": {"-d": "cm", "-mu": "g/(cm s)"}}))
    return RunFolder(tmp_path)


@pytest.mark.parametrize("text, value", [
    ("particles.csv:y:last", 120), ("particles.csv:y:first", 10), ("particles.csv:y:id=1:last", 60), ("particles.csv:y:id=1:mean",
        30), ("particles.csv:y:id=1:timemean", (15 + 2 * 40) / 3), ("particles.csv:y:t=last:mean", 90),
    ("particles.csv:y:t>=1:t<3:sum", 60), ("particles.csv:y:t=first:id>1:max", 20), ("particles.csv:y:id<=1:range", 50),
    ("particles.csv:y:id=2:std", np.std([20, 40, 120], ddof=1)), ("particles.csv:y:y>15:min", 20), ("fluid.csv:kinetic:max", 9),
    ("exits.csv:rows", 2), ("exits.csv:outlet=2:rows", 1), ("exits.csv:t>5:rows", 0), ("results.csv:drag", 5.5),
    ("particles.csv:rows", 6), ("fluid.csv:kinetic_energy:t=1:std", 0),
])
def test_an_expression_gives_its_number(run, text, value):
    assert quantities.evaluate(quantities.parse(text, {}), run) == (pytest.approx(value), "")


@pytest.mark.parametrize("text, says", [
    ("particles.csv:z:last", "has no column z; it has t, id"), ("fluid.csv:flux:max", "is it flux_in or flux_out?"),
    ("forces.csv:fx:max", "has no forces.csv"), ("particles.csv:y:id=7:last", "no rows that meet the conditions"),
    ("particles.csv:y:timemean", "id=N selects"), ("results.csv:lift", "has no lift; it has drag"),
    ("fluid.csv:speed=1:rows", "has no column speed"),
])
def test_what_a_run_does_not_have_is_told(run, text, says):
    value, why = quantities.evaluate(quantities.parse(text, {}), run)
    assert math.isnan(value) and says in why


@pytest.mark.parametrize("text", ["particles.csv", "particles.csv:y", "particles.csv:last", "particles.csv:y:id:last",
    "particles.csv:y:id=one:last", "particles.csv:id=1:last", "../a.csv:y:last", "particles.csv:y:median", "results.csv:"])
def test_what_is_no_expression_is_refused(text):
    with pytest.raises(BadInput, match="expression|ends with|condition|no column"):
        quantities.parse(text, {})


def test_units_are_those_of_the_case(run):
    assert [unit_of(text, run) for text in ("particles.csv:y:last", "fluid.csv:kinetic:max", "exits.csv:rows", "results.csv:drag",
        "particles.csv:theta:last", "particles.csv:t:last")] == ["cm", "g cm/s$^2$", "", "N/m", "", "s"]
    si = {"length": "m", "time": "s", "mass": "kg"}
    assert [product(powers, si) for powers in ((-1, -2, 1), (0, -1, 0), (2, -1, 0), (0, -2, 1))] == ["Pa", "1/s", "m$^2$/s", "N/m"]
