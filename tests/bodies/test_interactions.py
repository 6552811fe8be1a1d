"""Bodies that feel each other: less and less with their distance, and equally from both sides."""
import numpy as np
import pytest
from scipy.optimize import root

from tests.scenes import case
from tools.base.run_folder import RunFolder

STREAM = "macro boundaryU() (4*y*(1 - y)) // EOM"


def drag(freefem_text, folder, places, cells=16):
    """Of held disks of radius 0.15 on the midline of a channel of 5 by 1, in Stokes flow; a mesh that repeats itself every
    sixteenth."""
    folder.mkdir()
    text = f'int[int] sides = [3, 2, 3, 1];\nsavemesh(square({5 * cells}, {cells}, [5*x, y], label = sides), "{folder}/channel.mesh");\n'
    bodies = " ".join(f"bodyHeld(bodyDisk({x}, 0.5, 0.15, 1));" for x in places)
    text += case("{ " + bodies + " }", walls="labelWall", moving="labelInlet", outlet="labelOutlet", mu=1, gravity=0, more=STREAM)
    freefem_text(text, "-mesh", folder / "channel.mesh", "-dt", 0.04, "-cfl", 0, "-every", 0, "-tend", 0.8, "-convection", 0,
        "-tolerance", 1e-9, "-forces", 1, "-out", folder / "run")
    forces = RunFolder(folder / "run").table("forces")
    return [forces["fx"][forces["id"] == body][-1] for body in range(len(places))]


def test_two_disks_feel_each_other_as_slow_eddies_between_walls_die_away(freefem_text, tmp_path):
    """Far from a disk in a channel of width 1 its disturbance is Re C exp(-w x), with w the first root of sin w = w: streams along
    the midline that wall eddies turn back (Moffatt,
    J. Fluid Mech. 18 (1964) 1). So what a second disk changes in the drag of two, 0.17 % at a distance of 1, changes its sign near
    1.2 and is 1e-5 of the drag at 1.75."""
    w = complex(*root(lambda z: [(np.sin(complex(*z)) - complex(*z)).real, (np.sin(complex(*z)) - complex(*z)).imag], [7.5, 2.8]).x)
    assert abs(np.sin(w) - w) < 1e-8 and w.real > 7
    alone = drag(freefem_text, tmp_path / "alone", [2.013])[0]
    apart = np.array([1, 1.5, 1.75])
    change = np.array([np.mean(drag(freefem_text, tmp_path / f"{s}", [2.013, 2.013 + s])) / alone - 1 for s in apart])
    terms = np.exp(-w.real * apart)[:, None] * np.column_stack([np.cos(w.imag * apart), np.sin(w.imag * apart)])
    parts = np.linalg.solve(terms[:2], change[:2])
    assert change[2] == pytest.approx(terms[2] @ parts, rel=0.03) and 5e-6 < change[2] < 2e-5


def test_a_disk_goes_between_two_fixed_ones_in_the_middle(freefem_text, tmp_path):
    """On a mesh without symmetry, Reynolds number 0.3: along the midline, and about as fast behind the two as before them (Stokes
    flow can be run backwards)."""
    text = f"""border below(s = 0, 3) {{ x = s; y = 0; label = 3; }}
border out(s = 0, 1) {{ x = 3; y = s; label = 2; }}
border above(s = 3, 0) {{ x = s; y = 1; label = 3; }}
border into(s = 1, 0) {{ x = 0; y = s; label = 1; }}
savemesh(buildmesh(below(90) + out(31) + above(97) + into(33)), "{tmp_path}/channel.mesh");
"""
    bodies = "bodyHeld(bodyDisk(1.5, 0.23, 0.1, 1)); bodyHeld(bodyDisk(1.5, 0.77, 0.1, 1)); bodyDisk(0.9, 0.5, 0.08, 1);"
    text += case("{ " + bodies + " }", walls="labelWall", moving="labelInlet", outlet="labelOutlet", mu=1, gravity=0, more=STREAM)
    freefem_text(text, "-mesh", tmp_path / "channel.mesh", "-dt", 0.02, "-cfl", 1, "-every", 0, "-tend", 1, "-out",
        tmp_path / "run")
    rows = RunFolder(tmp_path / "run").particles
    free = rows["id"] == 2
    x, y, u = (rows[name][free] for name in ("x", "y", "u"))
    before, behind = (np.interp(1.5 + side * np.linspace(0.1, 0.5, 9), x, u) for side in (-1, 1))
    assert x[-1] > 2 and abs(y - 0.5).max() < 0.002
    assert before[0] > 1.6 * before[-1] and abs(behind / before - 1).max() < 0.05  # inertia delays it by 0.02
