"""Extrema between samples, and the numbers of a vortex street (DFG 2D-2): for runs of the suite and of other packages alike."""
import numpy as np

VORTICES = ("drag_most", "drag_least", "lift_range", "strouhal")


def peak(t, f):
    """(time, value) of the largest of three samples or more, by the parabola through it and its neighbours."""
    k = int(np.clip(np.argmax(f), 1, len(f) - 2))
    a, b, c = f[k - 1:k + 2]
    bend = a - 2 * b + c
    shift = 0.5 * (a - c) / bend if bend else 0.0
    return t[k] + shift * 0.5 * (t[k + 1] - t[k - 1]), b - 0.25 * (a - c) * shift


def top(f):
    """The value of peak()."""
    return peak(np.arange(len(f)), f)[1]


def vortices(t, drag, lift, since):
    """{name of VORTICES: value} after the time `since` (s), of a cylinder of diameter 0.1 in a flow of mean speed 1; nan
    where the lift does not rise through its middle twice."""
    late = t > since
    t, drag, lift = t[late], drag[late], lift[late]
    if len(t) < 3:
        return dict.fromkeys(VORTICES, np.nan)
    middle = 0.5 * (lift.max() + lift.min())
    k = np.flatnonzero((lift[:-1] < middle) & (lift[1:] >= middle))
    rises = t[k] + (middle - lift[k]) * (t[k + 1] - t[k]) / (lift[k + 1] - lift[k])
    return dict(zip(VORTICES, (top(drag), -top(-drag), top(lift) + top(-lift), 0.1 / np.diff(rises).mean() if len(rises) > 1
        else np.nan)))
