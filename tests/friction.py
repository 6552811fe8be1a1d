"""Scenes of contacts alone with friction: their text, inclines, and how an ellipse lies on one."""
import filecmp

import numpy as np

from tools.base.tables import read_table

R, G = 0.01, 9.81
SCENE = """
include "lib/case.idp"
include "lib/contact/walls.idp"
optCase("friction", "a scene of tests/friction.py");
optDefault("-friction-tol", "1e-12"); optDefault("-contact-tol", "1e-12");
real gravityX = {gravity[0]:.17g}, gravityY = {gravity[1]:.17g};
macro caseParticles() {{ {bodies} }} // EOM
macro caseWalls() {{ {walls} }} // EOM
include "scripts/contacts.edp"
"""


def runner(freefem_text, folder):
    """A function (bodies, walls, *words, gravity, name) that runs lines of a case; it returns the folder of the run."""
    def run(bodies, walls, *words, gravity=(0.0, -G), name="run", **more):
        text = SCENE.format(bodies="\n".join(bodies), walls="\n".join(walls) or "int none = 0;", gravity=gravity)
        freefem_text(text, *words, "-out", folder / name, **more)
        return folder / name

    return run


def goes_on(run, freefem_text, bodies, walls, end, *words):
    """Whether a run that is continued from the middle (run: a runner) leaves the tables of one that was not broken off."""
    whole = run(bodies, walls, *words, "-tend", end, name="whole")
    half = run(bodies, walls, *words, "-tend", end / 2, name="half")
    text = SCENE.format(bodies="\n".join(bodies), walls="\n".join(walls), gravity=(0.0, -G))
    freefem_text(text, *words, "-tend", end, "-restart", half)
    return all(filecmp.cmp(whole / name, half / name, shallow=False) for name in ("particles.csv", "contacts.csv"))


def plane(k, angle, mu, below=0.0):
    """Plane k, which sinks to the right, from (k, -below) on, and its normal."""
    c, s = np.cos(angle), np.sin(angle)
    start = np.array([float(k), -below])
    ends = ", ".join(f"{float(value)!r}" for value in [*start, *start + 0.9 * np.array([c, -s])])
    return f"contactWallRough(contactWallSegment({ends}), {mu!r});", (s, c)


def last(folder, name="particles"):
    """The columns of the rows of the last time."""
    rows = read_table(folder / f"{name}.csv")
    return {key: rows[key][rows["t"] == rows["t"].max()] for key in rows}


def leaning(major, minor, lean):
    """Angle of the normal of a floor from the major axis, and height of the centre, of an ellipse whose point of contact lies
    `lean` (a tangent) of the height uphill of the centre: (b^2 - a^2) k = lean (a^2 + b^2 k^2), k the tangent of the angle."""
    a2, b2 = major**2, minor**2
    k = (-(a2 - b2) - np.sqrt((a2 - b2)**2 - 4 * lean**2 * a2 * b2)) / (2 * lean * b2)
    angle = np.arctan(k)
    return angle, np.sqrt(a2 * np.cos(angle)**2 + b2 * np.sin(angle)**2)


def stopped(w, rate, mu):
    """Impulses (normal, tangential) that stop the approach of a contact with these rates (2,), which sticks or slides throughout;
    w (2, 2): rates by unit impulses."""
    both = np.linalg.solve(w, -rate)
    if abs(both[1]) > mu * both[0]:
        sense = -np.sign(rate[1])
        press = -rate[0] / (w[0, 0] + sense * mu * w[0, 1])
        both = np.array([press, sense * mu * press])
    return both


def struck(mass, moment, arm, velocity, mu):
    """Impulses (normal, tangential) of a body that hits a wall with the normal (0, 1) and t = (-1, 0), and its velocity (u, v,
    omega) after it. arm: from the centre to the contact, which sticks or slides throughout."""
    rows = np.array([[0, 1, arm[0]], [-1, 0, arm[1]]])
    inertia = np.array([mass, mass, moment])
    w = (rows / inertia) @ rows.T
    velocity = np.array(velocity, float)
    both = stopped(w, rows @ velocity, mu)
    return both, velocity + rows.T @ both / inertia


def poisson(mass, moment, arm, velocity, mu, e):
    """(velocity (u, v, omega) after a collision with a floor, share of the kinetic energy that is left) in closed form; arm: from
    the centre to the contact. Compression and restitution each stick or slide throughout."""
    rows = np.array([[0, 1, arm[0]], [-1, 0, arm[1]]])
    inertia = np.array([mass, mass, moment])
    w = (rows / inertia) @ rows.T
    rate = rows @ velocity
    first = stopped(w, rate, mu)
    press = e * first[0]
    left = rate + w @ (first + [press, 0])
    both = first + [press, np.clip(-left[1] / w[1, 1], -mu * press, mu * press)]
    after = velocity + rows.T @ both / inertia
    return after, (inertia @ after**2) / (inertia @ velocity**2)
