"""Spheres in a cellular flow with SciPy's integrators: a thousand at once, arrays of NumPy.

Forces: Brown-Lawler drag, weight less buoyancy, added mass, fluid acceleration, lift (the
formulas of tools/peers/spheres_exact.py). PROBLEM: vortex (Runge-Kutta 5(4)) or reference (order 8,
tolerance 1e-12, not timed, LEVEL 0); LEVEL: tolerance 1e-2, 1e-4, 1e-6. A third word, FILE.npy, names a file for
the positions and velocities at the end.
"""
import sys
import time

from tools.peers.common import asked, report

import numpy as np
from scipy.integrate import solve_ivp

from tools.peers.spheres_exact import brown_lawler

NUMBER, RADIUS, DENSITY, START_X, SPREAD, END = 1000, 0.001, 2500.0, 0.5, 1.5, 0.5
RHO, MU, GRAVITY = 1000.0, 0.001, 9.81
TOLERANCES = [1e-2, 1e-4, 1e-6]


def change(t, state):
    """d(x, y, U, V)/dt of all spheres."""
    x, y, up, vp = state.reshape(4, -1)
    sx, cx, sy, cy = np.sin(x), np.cos(x), np.sin(y), np.cos(y)
    u, v, ux, uy, vx, vy = sx * cy, -cx * sy, cx * cy, -sx * sy, sx * sy, -cx * cy
    volume = 4 / 3 * np.pi * RADIUS**3
    rx, ry, omega = u - up, v - vp, vx - uy
    slip = np.hypot(rx, ry)
    drag = 0.5 * RHO * np.pi * RADIUS**2 * brown_lawler(np.maximum(RHO * slip * 2 * RADIUS / MU, 1e-14)) * slip
    fx = drag * rx + 1.5 * RHO * volume * (u * ux + v * uy) + 0.5 * RHO * volume * omega * ry
    fy = drag * ry + 1.5 * RHO * volume * (u * vx + v * vy) - 0.5 * RHO * volume * omega * rx - volume * (DENSITY - RHO) * GRAVITY
    mass = volume * (DENSITY + 0.5 * RHO)
    return np.concatenate([up, vp, fx / mass, fy / mass])


def start():
    """All at one x, in a row along y, at rest."""
    return np.concatenate([np.full(NUMBER, START_X), np.linspace(0, SPREAD, NUMBER), np.zeros(2 * NUMBER)])


def solve(method, tolerance):
    return solve_ivp(change, (0, END), start(), method=method, rtol=tolerance, atol=1e-3 * tolerance).y[:, -1].reshape(4, -1)


if __name__ == "__main__":
    target = sys.argv.pop() if len(sys.argv) == 4 and sys.argv[3].endswith(".npy") else None
    problem, level = asked({"vortex": len(TOLERANCES), "reference": 1})
    begin = time.process_time()
    found = solve("DOP853", 1e-12) if problem == "reference" else solve("RK45", TOLERANCES[level])
    report(begin, 4 * NUMBER)
    if target:
        np.save(target, found)
