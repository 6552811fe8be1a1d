"""Observed order, Richardson extrapolation and grid convergence index; Pareto points.

Sizes are anything that an error shrinks with: element size or time step. Sources:
P. J. Roache, J. Fluids Eng. 116 (1994) 405-413 (the index); I. B. Celik et al., J. Fluids
Eng. 130 (2008) 078001 (sizes with any ratios); W. L. Oberkampf and C. J. Roy,
Verification and Validation in Scientific Computing (2010), section 8.8 (which factor).
"""
import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

LARGEST_ORDER = 12.0
ROUNDING = 1e-11  # of the values: differences within it are of the 12 digits that are written


@dataclass
class Estimate:
    """What a family of values says of the limit. order: nan where none is seen;
    limit: the extrapolated value; uncertainty: half a width about the limit that should
    hold the exact value (95 %); note: how it was found, in words; extrapolated: False where
    limit is the finest value itself."""
    order: float
    limit: float
    uncertainty: float
    note: str
    extrapolated: bool = True


def observed_order(sizes, values):
    """The p of f = f0 + c h^p through three values; nan if they oscillate or stand still,
    or if p is not between 0.05 and 12."""
    (h1, f1), (h2, f2), (h3, f3) = sorted(zip(sizes, values))[:3]
    if f2 == f1 or (f3 - f2) / (f2 - f1) <= 0:
        return math.nan
    ratio = (f3 - f2) / (f2 - f1)

    def miss(p):
        return ((h3 / h2) ** p - 1) / (1 - (h1 / h2) ** p) - ratio
    low, high = 0.05, LARGEST_ORDER
    if miss(low) * miss(high) > 0:
        return math.nan
    return float(brentq(miss, low, high))


def fitted_order(sizes, errors):
    """Slope of log |error| over log size by least squares; nan with fewer than two."""
    pairs = [(h, abs(e)) for h, e in zip(sizes, errors) if math.isfinite(e) and e != 0]
    if len({h for h, _ in pairs}) < 2:
        return math.nan
    h, e = np.log(np.array(pairs)).T
    return float(np.polyfit(h, e, 1)[0])


def estimate(sizes, values, formal=2.0):
    """An Estimate from values at two or more different sizes (nan values left out).

    Three values in order that fall with the formal order within 10 %: factor of safety
    1.25; in order, but with another one: 3 with the order kept between 0.5 and the formal;
    two values: 3 with the formal order; values that oscillate: no extrapolation, and
    three times their spread; the finest two equal to rounding: no extrapolation, and three
    times the error that the change before leaves there with the formal order."""
    pairs = sorted((h, f) for h, f in zip(sizes, values) if math.isfinite(f))
    if len({h for h, _ in pairs}) < len(pairs):
        raise ValueError("two values of one size")
    if len(pairs) < 2:
        value = pairs[0][1] if pairs else math.nan
        return Estimate(math.nan, value, math.nan, "one size only: no extrapolation", False)
    (h1, f1), (h2, f2) = pairs[:2]
    finest = [f for _, f in pairs[:3]]
    spread, rounding = max(finest) - min(finest), ROUNDING * max(map(abs, finest))
    if spread <= rounding:
        return Estimate(math.nan, f1, spread, "the value does not depend on the size", False)
    if abs(f2 - f1) <= rounding:
        left = spread * h1**formal / (pairs[2][0] ** formal - h2**formal)
        return Estimate(math.nan, f1, 3 * left, f"the finest two stand still: no extrapolation, three times what the change "
            f"before leaves with order {formal:g}", False)
    if len(pairs) == 2:
        p, safety, order, note = formal, 3.0, math.nan, f"two sizes: order {formal:g} assumed, factor of safety 3"
    else:
        order = observed_order(*zip(*pairs[:3]))
        if math.isnan(order):
            back = (f2 - f1) * (finest[2] - f2) < 0 and abs(finest[2] - f2) > rounding
            why = "the finest three oscillate" if back else "the finest three do not fall with any order"
            return Estimate(order, f1, 3 * spread, f"{why}: no extrapolation, three times their spread", False)
        if abs(order - formal) <= 0.1 * formal:
            p, safety, note = formal, 1.25, f"the order is within 10 % of {formal:g}: factor of safety 1.25"
        else:
            p, safety = min(max(0.5, order), formal), 3.0
            note = f"the order is not {formal:g}: order {p:.3g} used, factor of safety 3"
    step = (f1 - f2) / ((h2 / h1) ** p - 1)
    return Estimate(order, f1 + step, safety * abs(step), note)


def pareto(costs, errors):
    """Numbers of the points that no other beats in both cost and |error|, by rising cost."""
    points = sorted((c, abs(e), k) for k, (c, e) in enumerate(zip(costs, errors)) if math.isfinite(c) and math.isfinite(e))
    best, front = math.inf, []
    for _, error, k in points:
        if error < best:
            best = error
            front.append(k)
    return front
