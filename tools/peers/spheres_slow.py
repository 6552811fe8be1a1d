"""Exact resistances of spheres in slow flow, written apart from the suite."""
import numpy as np


def approach(gap, free=False):
    """Resistance of a sphere that moves straight towards a plane, over 6 pi mu R V (Brenner, Chem. Eng. Sci. 16 (1961) 242).

    gap: distance of the surfaces over the radius, above 0. free: the plane does not resist motion along itself; that is the plane
    between two equal spheres that approach with V each, at 2 gap.

        lambda = 4/3 sinh a sum_n n (n + 1)/((2 n - 1)(2 n + 3)) (T_n/B_n - 1),   cosh a = 1 + gap,   k = 2 n + 1:
        no slip:  T = 2 sinh(k a) + k sinh(2 a),                 B = 4 sinh^2(k a/2) - k^2 sinh^2 a
        free:     T = 4 cosh^2(k a/2) + k^2 sinh^2 a,            B = 2 sinh(k a) - k sinh(2 a)

    with both divided by exp(k a). Raises ValueError where the gap is not above 0.
    """
    if not gap > 0:
        raise ValueError("the gap must be above 0")
    a = np.arccosh(1 + gap)
    n = np.arange(1, int(40 / a) + 20.0)
    k = 2 * n + 1
    e = np.exp(-k * a)
    hyperbolic, odd, even = k**2 * np.sinh(a) ** 2 * e, k * np.sinh(2 * a) * e, 1 - e**2
    top, bottom = ((1 + e) ** 2 + hyperbolic, even - odd) if free else (even + odd, (1 - e) ** 2 - hyperbolic)
    return float(4 / 3 * np.sinh(a) * np.sum(n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (top / bottom - 1)))
