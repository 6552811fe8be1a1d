"""Exact and accurate answers for spheres carried by a flow, written apart from the suite's.

SI units. Laws of the drag coefficient by name; the right-hand side of a sphere's motion in a
flow in closed form, for an integrator of scipy; closed solutions.
"""
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import wofz


def brown_lawler(re):
    return 24 / re * (1 + 0.150 * re**0.681) + 0.407 / (1 + 8710 / re)


def flemmer_banks(re):
    return 24 / re * 10 ** (0.261 * re**0.369 - 0.105 * re**0.431 - 0.124 / (1 + np.log10(re) ** 2))


def schiller_naumann(re):
    return 24 / re * (1 + 0.15 * re**0.687) if re <= 1000 else 0.44


def haider_levenspiel(re):
    return 24 / re * (1 + 0.1806 * re**0.6459) + 0.4251 / (1 + 6880.95 / re)


def clift(re):
    w = np.log10(re)
    if re <= 0.01:
        return 3 / 16 + 24 / re
    if re <= 20:
        return 24 / re * (1 + 0.1315 * re ** (0.82 - 0.05 * w))
    if re <= 260:
        return 24 / re * (1 + 0.1935 * re**0.6305)
    if re <= 1500:
        return 10 ** (1.6435 - 1.1242 * w + 0.1558 * w**2)
    if re <= 1.2e4:
        return 10 ** (-2.4571 + 2.5558 * w - 0.9295 * w**2 + 0.1049 * w**3)
    if re <= 4.4e4:
        return 10 ** (-1.9181 + 0.6370 * w - 0.0636 * w**2)
    if re <= 3.38e5:
        return 10 ** (-4.3390 + 1.5809 * w - 0.1546 * w**2)
    if re <= 4e5:
        return 29.78 - 5.3 * w
    return 0.1 * w - 0.49 if re <= 1e6 else 0.19 - 8e4 / re


LAWS = {"stokes": lambda re: 24 / re, "constant": lambda re: 0.44, "brown-lawler": brown_lawler,
        "flemmer-banks": flemmer_banks, "clift": clift, "schiller-naumann": schiller_naumann,
        "haider-levenspiel": haider_levenspiel}
# Coefficients given with the laws: Re: Brown-Lawler, Flemmer-Banks, Schiller-Naumann, Haider-Levenspiel.
VECTORS = {0.1: (247.504, 245.971, 247.401, 249.796), 1: (27.6001, 25.8352, 27.6, 28.3345),
           10: (4.12751, 4.41962, 4.15107, 4.31853), 100: (1.07314, 1.04461, 1.09173, 1.09474),
           1000: (0.46338, 0.44205, 0.43829, 0.45346), 1e4: (0.41061, 0.41808, None, 0.42038)}
VECTOR_LAWS = ("brown-lawler", "flemmer-banks", "schiller-naumann", "haider-levenspiel")


def terminal_velocities(law, radius, density, rho=1000.0, mu=0.001, g=9.81):
    """All speeds (m/s) at which drag balances the weight less buoyancy (more than one where
    a law in pieces jumps or falls)."""
    d = 2 * radius

    def excess(log_re):
        re = np.exp(log_re)
        speed = re * mu / (rho * d)
        return np.log(LAWS[law](re) * 0.5 * rho * np.pi * radius**2 * speed**2
                      / (4 / 3 * np.pi * radius**3 * abs(density - rho) * g))
    grid = np.linspace(np.log(1e-9), np.log(1e7), 4000)
    values = np.array([excess(a) for a in grid])
    places = np.flatnonzero(np.diff(np.sign(values)))
    return [np.exp(brentq(excess, grid[k], grid[k + 1], xtol=1e-13)) * mu / (rho * d) for k in places]


def basset_velocity(t, radius, density, rho=1000.0, mu=0.001, g=9.81):
    """Velocity downwards of a sphere released from rest with Stokes drag, added mass and
    history: (m_p + m_f/2) v' = (m_p - m_f) g - 6 pi mu R v - 6 R^2 sqrt(pi rho mu) int v'/sqrt(t - s)."""
    volume = 4 / 3 * np.pi * radius**3
    mass = volume * (density + 0.5 * rho)
    a = 6 * np.pi * mu * radius / mass
    b = 6 * radius**2 * np.sqrt(np.pi * rho * mu) * np.sqrt(np.pi) / mass
    drive = volume * (density - rho) * g / mass
    root = np.sqrt(complex(b * b - 4 * a))
    p, q = (b + root) / 2, (b - root) / 2  # x^2 + b x + a = (x + p)(x + q)
    s = np.sqrt(np.asarray(t, dtype=float))

    def scaled(k):  # exp(k^2 t) erfc(k sqrt t)
        return wofz(1j * k * s)
    return np.real(drive / a * (1 - (p * scaled(q) - q * scaled(p)) / (p - q)))


def no_history(t, radius, density, rho=1000.0, mu=0.001, g=9.81, added=0.5):
    """The same without history: an exponential."""
    volume = 4 / 3 * np.pi * radius**3
    rate = 6 * np.pi * mu * radius / (volume * (density + added * rho))
    return volume * (density - rho) * g / (6 * np.pi * mu * radius) * (1 - np.exp(-rate * np.asarray(t)))


def flow_at(name, x, y, t, speed=1.0, rate=1.0):
    """(u, v, ux, uy, vx, vy, ut) of the flows of tests/transport/scripts/analytic.edp."""
    if name == "rest":
        return 0, 0, 0, 0, 0, 0, 0
    if name == "uniform":
        return speed, 0, 0, 0, 0, 0, 0
    if name == "shear":
        return rate * y, 0, 0, rate, 0, 0, 0
    if name == "straining":
        return rate * x, -rate * y, rate, 0, 0, -rate, 0
    if name == "oscillating":
        return speed * np.cos(rate * t), 0, 0, 0, 0, 0, -speed * rate * np.sin(rate * t)
    sx, cx, sy, cy = np.sin(x), np.cos(x), np.sin(y), np.cos(y)
    return tuple(speed * f for f in (sx * cy, -cx * sy, cx * cy, -sx * sy, sx * sy, -cx * cy, 0))


def path(flow, start, end, radius, density, rho=1000.0, mu=0.001, g=9.81, law="constant", buoyancy=1, added=0.5,
         fluid=0, lift=0.5, magnus=0, speed=1.0, rate=1.0, rtol=1e-11):
    """(x, y, U, V, Omega) at the time `end` (s) of a sphere that starts as `start`, by an eighth-order method
    (a stiff one where its drag is): every force but history and turbulence, each from its own formula."""
    volume = 4 / 3 * np.pi * radius**3
    m_p, m_f = volume * density, volume * rho

    def change(t, state):
        x, y, U, V, Omega = state
        u, v, ux, uy, vx, vy, ut = flow_at(flow, x, y, t, speed, rate)
        ax, ay = ut + u * ux + v * uy, u * vx + v * vy
        rx, ry, omega = u - U, v - V, vx - uy
        slip = np.hypot(rx, ry)
        re = max(rho * slip * 2 * radius / mu, 1e-14)
        drag = 0.5 * rho * np.pi * radius**2 * LAWS[law](re) * slip if law else 0.0
        fx, fy = drag * rx, drag * ry
        if buoyancy:
            fy -= (m_p - m_f) * g
        fx += (added + fluid) * m_f * ax
        fy += (added + fluid) * m_f * ay
        fx += rho * volume * lift * omega * ry  # r x omega e_z = omega (r_y, -r_x)
        fy -= rho * volume * lift * omega * rx
        if magnus:  # w e_z x (-r) = w (r_y, -r_x)
            w = np.pi * radius**3 * rho * (Omega - omega / 2)
            fx, fy = fx + w * ry, fy - w * rx
        turn = 8 * np.pi * mu * radius**3 * (omega / 2 - Omega) / (0.4 * m_p * radius**2) if magnus else 0.0
        mass = m_p + added * m_f
        return [U, V, fx / mass, fy / mass, turn]
    found = solve_ivp(change, (0, end), start, method="Radau" if law and rtol <= 1e-9 and stiff(radius, density, rho, mu, end)
        else "DOP853", rtol=rtol, atol=1e-13)
    return found.y[:, -1]


def stiff(radius, density, rho, mu, end):
    """Whether the response time is far below the time of the run."""
    return 2 / 9 * radius**2 * (density + 0.5 * rho) / mu < 1e-3 * end


def dispersion(t, sigma, lagrangian):
    """Taylor's variance of the displacement (m2) in homogeneous turbulence."""
    return 2 * sigma**2 * lagrangian**2 * (t / lagrangian - 1 + np.exp(-t / lagrangian))


def inertial(t, sigma, lagrangian, tau):
    """Variances of place (m2) and velocity (m2/s2) of a sphere that starts at rest in stationary turbulence, its drag linear: those
    of (w, U, X), a linear system."""
    rates = np.array([[-1 / lagrangian, 0, 0], [1 / tau, -1 / tau, 0], [0, 1, 0]])

    def change(_, parts):
        p = parts.reshape(3, 3)
        return (rates @ p + p @ rates.T + np.diag([2 * sigma**2 / lagrangian, 0, 0])).ravel()
    p = solve_ivp(change, (0, t), np.diag([sigma**2, 0, 0]).ravel(), rtol=1e-9, atol=1e-14).y[:, -1].reshape(3, 3)
    return p[2, 2], p[1, 1]
