"""What tests read of runs and compare with: rows of the output, tables, exact values, outlines, refusals."""
import csv
import shutil

import meshio
import numpy as np
from scipy.special import iv, ivp, kv, kvp

from tests.conftest import run_freefem
from tests.scenes import FORMULA
from tools.base.tables import read_table
from tools.meshing.plane_mesh import PlaneMesh


def rows(text, word):
    """The numbers behind a word in the lines of an output that begin with it: (lines, numbers of a line)."""
    return np.array([[float(w) for w in line.split()[1:]] for line in text.splitlines() if line.startswith(word + " ")])


def force(r, far, rho, mu, rate):
    """Force on a cylinder of radius r with the velocity exp(i rate t) in a concentric container of radius far, over that
    velocity: Stokes flow with inertia, stream function (a/x + b x + c I1(k x) + d K1(k x)) sin(angle), k^2 = i rate rho/mu
    (after G. G. Stokes, 1851, and Chen, Wambsganss & Jendrzejczyk, J. Appl. Mech. 43 (1976) 325)."""
    k = np.sqrt(1j * rate * rho / mu)
    parts = lambda x: np.array([1 / x, x, iv(1, k * x), kv(1, k * x)])
    slopes = lambda x: np.array([-1 / x**2, 1, k * ivp(1, k * x), k * kvp(1, k * x)])
    a = np.linalg.solve([parts(r) / r, slopes(r), parts(far), slopes(far)], [1, 1, 0, 0])
    bends = (1 / r**2 + k**2) * parts(r) - slopes(r) / r
    bends[:2] = 2 / r**3, 0
    return np.pi * r * (1j * rate * rho * (a[1] * r - a[0] / r) + mu * (a @ bends))


HIT = """
include "lib/case.idp"
optCase("hit", "a disk hits others in a doubly periodic box");
optDefault("-dt", "0.002"); optDefault("-tend", "0.1"); optDefault("-every", "0"); optDefault("-tolerance", "1e-8");
real rhoFluid = 1, mu = 0.005, gravityX = 0, gravityY = 0, flowPeriodX = 1, flowPeriodY = 1, motionBound = 1e30;
include "lib/mesh/labels.idp"
int[int] flowNoSlip(0), flowMoving(0), flowOutlet(0), flowSlip(0);
macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]);
    fespace Qh(Th, P1, periodic = [[labelLeft, y], [labelRight, y], [labelBottom, x], [labelTop, x]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight, labelBottom, labelTop] // EOM
func real boundaryRamp(real t) { return 1; }
macro caseParticles() BODIES // EOM
macro caseStep() {
    int n = bodyNumber;
    real[int] mu0 = flowM*flowU, mv0 = flowM*flowV, own(n), arm(n);
    bodyShape(own, arm);
    arm = bodyDensity; arm -= 1.; own = own .* arm;
    real[int] bu = bodyQ(0:n - 1), bv = bodyQ(n:2*n - 1);
    real press = 0;
    if (motionTouching > 0) press = contactImpulse.sum;
    cout << "momentum " << mu0.sum + own'*bu << " " << mv0.sum + own'*bv << " " << press << endl;
} // EOM
include "scripts/resolved.edp"
"""


def momentum_told(freefem_text, folder, bodies, more="", words=()):
    """Rows of a run of the scene HIT with these bodies: total momentum along x and y, and the contacts' impulse. Without films, so
    that they do touch."""
    mesh = f"{folder}.mesh"
    text = f'{{ int[int] sides = [13, 12, 14, 11]; savemesh(square(40, 40, label = sides), "{mesh}"); }}\ncout.precision(12);\n{more}' + HIT.replace("BODIES", bodies)
    return rows(freefem_text(text, "-film", 0, "-mesh", mesh, "-out", folder, *words).stdout, "momentum")


def outline(x, y, turn, a, aspect, angles):
    """Points on an ellipse."""
    px, py = a * np.cos(angles), a * aspect * np.sin(angles)
    return np.array([x + np.cos(turn) * px - np.sin(turn) * py, y + np.sin(turn) * px + np.cos(turn) * py])


def distances_to_segments(x, y, a, b):
    """(points, segments): distance of each point to each of the segments a-b, m."""
    p = np.column_stack([x, y])[:, None, :]
    along = np.clip(((p - a) * (b - a)).sum(2) / ((b - a) ** 2).sum(1), 0, 1)
    return np.sqrt(((p - a - along[..., None] * (b - a)) ** 2).sum(2))


def assert_refused(done, statuses, says=""):
    """A status of the project and one line that says what is wrong."""
    assert done.returncode in statuses, f"status {done.returncode}\n{done.stdout[-800:]}\n{done.stderr[-800:]}"
    lines = done.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and says in lines[0], done.stderr


def assert_whole_rows(path):
    """Every row has the header's columns and its end."""
    text = path.read_text()
    rows = text.splitlines()
    assert text.endswith("\n") and len(rows) > 1
    assert {row.count(",") for row in rows} == {rows[0].count(",")}, path.name


def numbers(folder, name):
    """The CSV without the columns that hold seconds of computing."""
    table = np.genfromtxt(folder / name, delimiter=",", names=True)
    return {column: table[column] for column in table.dtype.names if not column.startswith("time_")}


def broken_off(words, tmp_path, keep):
    """(an unbroken run, the same broken off after the checkpoint of step `keep` and gone on with)."""
    run_freefem(*words, "-out", tmp_path / "whole")
    shutil.copytree(tmp_path / "whole", tmp_path / "broken", ignore=shutil.ignore_patterns(".writer"))
    for seal in (tmp_path / "broken").glob("restart_*.sha"):
        if seal.stem != f"restart_{keep:09d}":
            seal.unlink()
    again = run_freefem(*words, "-restart", tmp_path / "broken")
    assert f"step {keep}" in again.stdout
    return tmp_path / "whole", tmp_path / "broken"


def read_medit(file):
    """A .mesh file as a PlaneMesh."""
    content = meshio.read(file)
    refs = content.cell_data_dict["medit:ref"]
    cells = content.cells_dict
    return PlaneMesh(content.points, cells["triangle"], cells["line"], refs["line"])


def particles_of(freefem, folder, case, *args):
    """particles.csv of a run of a case."""
    freefem(f"cases/{case}.edp", "-out", folder, *args)
    return read_table(folder / "particles.csv")


def results(folder):
    """results.csv of a run as {quantity: value}."""
    with open(folder / "results.csv", newline="") as file:
        return {row["quantity"]: float(row["value"]) for row in csv.DictReader(file)}


def numeric_records(path):
    """A CSV as a list of {column: number}."""
    with open(path, newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def results_of(freefem, folder, case, *args):
    """results.csv of a run of a case as {quantity: value}."""
    freefem(f"cases/{case}.edp", "-out", folder, *args)
    return results(folder)


def records(path):
    """A CSV as a list of {column: text}."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def in_formula(freefem_text, folder, carrier, bodies, *words):
    """particles.csv of spheres in a flow by a formula (FreeFEM statements)."""
    freefem_text(FORMULA.format(carrier=carrier, bodies=bodies), "-out", folder, *words)
    return read_table(folder / "particles.csv")
