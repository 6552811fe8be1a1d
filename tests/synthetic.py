"""Run folders made up for the tests of the tools: the files a driver writes, with
invented but smooth contents. Fields and mesh come from FreeFEM itself, so that the
readers meet its real formats.
"""
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np

from tests.conftest import FREEFEM, ROOT

SCRIPT = """
load "iovtk"
real R = 0.1, L = 1., tip = 0.04, x1 = 0.3, x2 = 0.31, a1 = 0.6, a2 = 0.68;
int n = NUMBER;
border in(s = R, -R) { x = 0.; y = s; label = 1; }
border b1(s = 0., x1) { x = s; y = -R; label = 3; }
border d1(s = -R, -tip) { x = x1; y = s; label = 4; }
border d2(s = x1, x2) { x = s; y = -tip; label = 4; }
border d3(s = -tip, -R) { x = x2; y = s; label = 4; }
border b2(s = x2, a1) { x = s; y = -R; label = 3; }
border o1(s = 0., 1.) { x = a1 + s*(a2 - a1)/2.; y = -R + 0.05*s; label = 5; }
border o2(s = 1., 0.) { x = a2 - s*(a2 - a1)/2.; y = -R + 0.05*s; label = 5; }
border b3(s = a2, L) { x = s; y = -R; label = 3; }
border out(s = -R, R) { x = L; y = s; label = 2; }
border top(s = L, 0.) { x = s; y = R; label = 3; }
mesh Th = buildmesh(in(n) + b1(2*n) + d1(n/2) + d2(2) + d3(n/2) + b2(2*n) + o1(n/2) + o2(n/2)
                    + b3(2*n) + out(n) + top(5*n));
savemesh(Th, "mesh.mesh");
fespace Vh(Th, P1);
int[int] linear = [1, 1];
int number = FIELDS;
{ ofstream f("fields.pvd"); f << "<VTKFile type=\\"Collection\\" version=\\"0.1\\"><Collection>" << endl; }
for (int k = 0; k <= number; ++k) {
    real now = k*TEND/number, ramp = 1. - exp(-5.*now);
    Vh u = ramp*2.*(1. - y^2/R^2)*(1. + 0.3*sin(12.*x - 20.*now)), v = ramp*0.4*cos(12.*x - 20.*now)*(1. - y^2/R^2), p = 100.*(L - x);
    string name = "fields_" + (k*10) + ".vtu";
    savevtk(name, Th, [u, v, 0], p, order = linear, dataname = "velocity pressure", bin = BINARY,
            floatmesh = true, floatsol = true, withsurfacemesh = false);
    { ofstream f("fields.pvd", append); f << "<DataSet timestep=\\"" << now << "\\" file=\\"" << name << "\\"/>" << endl; }
}
{ ofstream f("fields.pvd", append); f << "</Collection></VTKFile>" << endl; }
"""


def write_csv(path, names, rows):
    """Rows of numbers under a header."""
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(",".join(names) + "\n")
        for row in rows:
            stream.write(",".join(f"{value:.12g}" for value in row) + "\n")


def write_run(folder, number=12, t_end=1.0, steps=100, seed=1, speed=0.9, fields=0, n=12, binary=True):
    """A made-up run of the pipe: particles enter one by one and drift to the outlet.

    fields > 0 also makes the mesh and that many field files with FreeFEM."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    draw = np.random.default_rng(seed)
    radius = draw.uniform(0.005, 0.015, number)
    height = draw.uniform(-0.03, 0.03, number)
    entry = np.linspace(0, 0.5 * t_end, number)
    particles, fluid, contacts = [], [], []
    for step in range(steps + 1):
        t = t_end * step / steps
        inside = 0
        for k in range(number):
            s = t - entry[k]
            x = speed * (0.6 + 0.8 * k / number) * s
            if s < 0 or x > 1:
                continue
            inside += 1
            particles.append([step, t, k, x, height[k] * np.cos(6 * x), 10 * s, speed, 0, 10, radius[k]])
        ramp = 1 - np.exp(-5 * t)
        fluid.append([step, t, t_end / steps, 8, 0.2 * ramp**2, 1e-9, -0.2667 * ramp, 0.2667 * ramp * (1 - 1e-4),
                      100 * ramp, inside, inside // 3, -1e-9 * (step % 7), .01, .02, .03, .01, .002, .001])
        if step % 10 == 0 and inside > 1:
            contacts.append([t, 0, 1, 1e-9, 1, 0, 1e-4])
    write_csv(folder / "particles.csv", "step,t,id,x,y,theta,u,v,omega,radius".split(","), particles)
    write_csv(folder / "fluid.csv", ("step,t,dt,iterations,kinetic_energy,divergence,flux_in,flux_out,pressure_drop,"
                                     "particles,contacts,worst_gap,time_convection,time_rigid,time_solve,"
                                     "time_pressure,time_contact,time_output").split(","), fluid)
    write_csv(folder / "wallforces.csv", "t,label,fx,fy".split(","), [[row[1], label, 0.5 * label, 0] for row in fluid
        for label in (3, 4)])
    write_csv(folder / "fluxes.csv", "t,label,flux".split(","), [[row[1], label, flux] for row in fluid for label,
        flux in ((1, row[6]), (2, 0.75 * row[7]), (12, 0.25 * row[7]))])
    write_csv(folder / "forces.csv", "t,id,fx,fy,torque".split(","), [[row[1], k, 2 + k, row[1], 0.5] for row in fluid
        for k in (0, 1)])
    write_csv(folder / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), contacts)
    (folder / "run.json").write_text(json.dumps({
        "case": "pipe_obstacles", "about": "made up for a test", "parameters": {"-dt": t_end / steps, "-tend": t_end},
        "versions": {"freefem": "4.9"}, "mesh": "mesh.mesh", "mesh_hash": "0", "start": "", "end": "", "status": "finished"}))
    if fields:
        text = SCRIPT.replace("NUMBER", str(n)).replace("FIELDS", str(fields)).replace("TEND", repr(float(t_end)))
        (folder / "made_up.edp").write_text(text.replace("BINARY", "true" if binary else "false"))
        shutil.copy(ROOT / "freefem++.pref", folder)
        done = subprocess.run([FREEFEM, "-nw", "made_up.edp"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
    return folder


if __name__ == "__main__":
    import sys
    write_run(sys.argv[1], number=30, fields=24, n=24)
