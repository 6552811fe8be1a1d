"""Orders, limits and their uncertainty."""
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tools.study import convergence


@settings(max_examples=80, deadline=None)
@given(p=st.floats(0.5, 5), ratio1=st.floats(1.2, 3), ratio2=st.floats(1.2, 3), c=st.floats(0.01, 10),
       sign=st.sampled_from([-1, 1]), limit=st.floats(-5, 5))
def test_the_order_of_a_power_law_is_found(p, ratio1, ratio2, c, sign, limit):
    sizes = np.array([1, ratio1, ratio1 * ratio2]) * 0.1
    values = limit + sign * c * sizes**p
    assert convergence.observed_order(sizes, values) == pytest.approx(p, rel=1e-4, abs=1e-4)
    assert convergence.fitted_order(sizes, values - limit) == pytest.approx(p, rel=1e-3, abs=1e-3)
    one = convergence.estimate(sizes, values, formal=p)
    assert one.limit == pytest.approx(limit, abs=1e-6)
    two = convergence.estimate(sizes, values, formal=2)
    assert abs(two.limit - limit) <= two.uncertainty + 1e-9 or p < 0.5


def test_values_that_oscillate_or_stand_still_give_no_order():
    one = convergence.estimate([1, 0.5, 0.25], [1.0, 1.2, 1.1])
    assert math.isnan(one.order) and one.limit == 1.1 and one.uncertainty == pytest.approx(0.6)
    assert "oscillate" in one.note and not one.extrapolated and "oscillate" not in convergence.estimate([1, 0.5, 0.25],
        [1.0, 1.0, 1.1]).note
    assert convergence.estimate([1, 0.5, 0.25], [2.0, 2.0, 2.0]).uncertainty == 0
    assert convergence.estimate([1, 0.5, 0.25], [2.0, 2.0 + 1e-15, 2.0 - 1e-15]).uncertainty < 1e-14
    assert "one size" in convergence.estimate([1, 0.5], [2.0, math.nan]).note
    assert "order 2 assumed" in convergence.estimate([1, 0.5], [5.0, 2.0]).note
    # 1 + h^2: the order is seen
    assert convergence.estimate([1, 0.5, 0.25], [2.0, 1.25, 1.0625]).uncertainty == pytest.approx(1.25 / 16)


@pytest.mark.parametrize("p, used, safety", [(2.19, 2.0, 1.25), (1.81, 2.0, 1.25), (2.25, 2.0, 3), (1.7, 1.7, 3), (0.3, 0.5, 3)])
def test_the_grid_convergence_index_of_a_power_law(p, used, safety):
    """Celik et al.: F |f1 - f2|/(r^p - 1), F = 1.25 and the formal order where p is within 10 % of it, else 3 with p kept between
    0.5 and it; of the finest three of four."""
    values = [7.0, *(1 + h**p for h in (1, 0.5, 0.25))]
    one = convergence.estimate([2, 1, 0.5, 0.25], values)
    step = abs(values[3] - values[2]) / (2**used - 1)
    assert one.order == pytest.approx(p, rel=1e-6) and one.uncertainty == pytest.approx(safety * step,
        rel=1e-5) and one.limit == pytest.approx(values[3] - step, rel=1e-6)


def test_what_an_estimate_makes_of_few_or_odd_values():
    # two sizes, order 2: 3 |f1 - f2|/(2^2 - 1)
    assert convergence.estimate([1, 0.5], [5.0, 2.0]).uncertainty == pytest.approx(3 * 3 / 3)
    assert convergence.estimate([8, 1, 0.5, 0.25], [9.0, 1.0, 1.2, 1.1]).uncertainty == pytest.approx(0.6)
    assert convergence.estimate([1, 0.5, 0.25], [2.0, 2.0 + 1e-12, 2.0]).uncertainty == pytest.approx(1e-12, rel=1e-2, abs=0)
    assert "oscillate" not in convergence.estimate([1, 0.5, 0.25], [1.0 + 1e-13, 1.0, 1.1]).note  # the first two differ by rounding
    assert convergence.fitted_order([1, 0.5, 0.25], [4.0, -1.0, 0.0]) == pytest.approx(2)  # an error of 0 has no logarithm
    with pytest.raises(ValueError, match="one size"):
        convergence.estimate([1, 1, 0.5], [1.0, 1.1, 1.2])


@pytest.mark.parametrize("last", [1.1, 1.1 + 2e-16, 1.1 - 1e-13])
def test_two_finest_values_that_stand_still_are_said_to(last):
    """Uncertain by three times what a change of 0.1 from size 1 to 1/2 leaves at 1/4 with order 2."""
    one = convergence.estimate([1, 0.5, 0.25], [1.2, 1.1, last])
    assert "stand still" in one.note and one.limit == last and not one.extrapolated
    assert one.uncertainty == pytest.approx(3 * 0.1 / 12, rel=1e-9)


@given(st.lists(st.tuples(st.floats(0.1, 100), st.floats(-10, 10)), max_size=12))
def test_pareto_points_are_those_that_nothing_beats(points):
    costs, errors = [p[0] for p in points], [p[1] for p in points]
    front = convergence.pareto(costs, errors)
    for k, (cost, error) in enumerate(points):
        beaten = any((c < cost and abs(e) <= abs(error)) or (c <= cost and abs(e) < abs(error)) for c, e in points)
        assert (k in front) <= (not beaten)
    assert bool(front) == bool(points)
