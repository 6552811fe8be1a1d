"""tools.stress: classes by checks on made-up run folders, overlaps, awkward meshes, limits, a few real cells."""
import csv
import json
import math
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ROOT, run_freefem
from tests.synthetic import write_csv, write_run
from tools.base.run_folder import RunFolder
from tools.base.runner import Done
from tools.base.tables import read_table
from tools.meshing import CASES
from tools.meshing.main import parser
from tools.meshing.medit import write
from tools.meshing.plane_mesh import signed_areas, smallest_angles
from tools.stress import __main__ as stress
from tools.stress import runs as stress_runs
from tools.stress.awkward import KINDS, spoiled
from tools.stress.cells import Axis, Cell, Disks, Map
from tools.stress.classes import GOOD, Checks, created, judge
from tools.stress.limits import defaults_inside, limits_of, write_limits
from tools.stress.maps_energy import KINDS as ROOMS, SIZE, room, scene
from tools.stress.overlap import crossing, pair_overlap, solid_segments, wall_overlap
from tools.stress.runs import name_of, run_map

WELL = Done(0, "", 1.0, 1.0, 30.0, "")
CHECKS = Checks({"fluid.kinetic_energy": 1.0, "particles.u": 2.0}, 1.0)


def apart(folder, **more):
    """A made-up run whose few particles keep clear of each other."""
    write_run(folder, number=3, **more)
    rows = read_table(folder / "particles.csv")
    rows["y"] = 0.03 * rows["id"]
    write_csv(folder / "particles.csv", list(rows), np.column_stack(list(rows.values())))
    return folder


def changed(folder, table, column, row, value):
    """One entry of a CSV replaced by a text."""
    path = folder / f"{table}.csv"
    lines = path.read_text().splitlines()
    at = lines[0].split(",").index(column)
    cells = lines[row].split(",")
    cells[at] = value
    lines[row] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


def test_a_whole_run_is_stable_and_accurate_only_near_its_reference(tmp_path):
    folder = apart(tmp_path / "run")
    assert judge(WELL, CHECKS, folder)[0] == "stable"
    assert judge(WELL, CHECKS, folder, lambda run: (0.01, 0.02))[0] == "accurate"
    kind, why, depth = judge(WELL, CHECKS, folder, lambda run: (0.03, 0.02))
    assert kind == "stable" and "0.03" in why and depth == 0
    for error in (math.nan, math.inf, -math.inf):
        kind, why, _ = judge(WELL, CHECKS, folder, lambda run: (error, 0.02))
        assert kind == "stable" and "no error to judge by" in why


@pytest.mark.parametrize("table, column, row, value, words", [
    ("fluid", "kinetic_energy", 30, "nan", "kinetic_energy is nan in row 30"),
    ("fluid", "pressure_drop", 30, "inf", "pressure_drop is inf"),
    ("fluid", "kinetic_energy", 50, "1e30", "above the bound 1"),
    ("particles", "u", 20, "-7.5", "above the bound 2"),
    ("particles", "x", 20, "-nan", "x is nan"),
    ("fluid", "kinetic_energy", 5, "1.2e", "cannot be read"),
    ("contacts", "impulse", 1, "nan", "impulse is nan")])
def test_garbage_with_exit_status_0_is_blown_up(tmp_path, table, column, row, value, words):
    folder = apart(tmp_path / "run")
    changed(folder, table, column, row, value)
    kind, why, _ = judge(WELL, CHECKS, folder, lambda run: (0.0, 1.0))
    assert kind == "blown up" and words in why


def test_a_run_that_ends_early_or_writes_nothing_is_blown_up(tmp_path):
    folder = apart(tmp_path / "run", t_end=0.9)
    assert judge(WELL, CHECKS, folder)[:2] == ("blown up", "its rows end at t = 0.9 of 1")
    (folder / "particles.csv").write_text("step,t,id,x,y,theta,u,v,omega,radius\n")
    (folder / "fluid.csv").write_text("t,kinetic_energy\n")
    assert judge(WELL, Checks({}, 1.0), folder)[0] == "blown up"
    (folder / "fluid.csv").unlink()
    assert "has no kinetic_energy" in judge(WELL, CHECKS, folder)[1]
    assert judge(WELL, CHECKS, tmp_path / "nothing")[0] == "blown up"


@pytest.mark.parametrize("status, log, kind", [
    (4, "error: not converged at t = 0.1 s; use a smaller -dt", "stopped"), (5, "error: particles overlap", "stopped"),
    (4, "not converged", "blown up"), (5, " Meshing error: Bamg", "blown up"), (6, "error: assertion", "blown up"),
    (-11, "", "blown up"), (8, "", "blown up"), (24, "", "late"), (-24, "", "late"), (124, "", "late")])
def test_a_status_other_than_0_counts_as_clean_only_with_a_reason(tmp_path, status, log, kind):
    assert judge(Done(status, log, 1, 1, 1, log), CHECKS, apart(tmp_path / "run"))[0] == kind


def test_overlap_is_recomputed_whatever_the_run_says_of_its_gaps(tmp_path):
    folder = apart(tmp_path / "run")
    table = read_table(folder / "particles.csv")
    late = np.flatnonzero(table["t"] == 0.5)
    first, second = (int(table["id"][k]) for k in late[:2])
    reach = table["radius"][late[0]] + table["radius"][late[1]] - 1e-3 * table["radius"][late[:2]].min()
    changed(folder, "particles", "x", late[1] + 1, f"{table['x'][late[0]]:.12g}")
    changed(folder, "particles", "y", late[1] + 1, f"{table['y'][late[0]] + reach:.12g}")
    kind, why, depth = judge(WELL, CHECKS, folder, lambda run: (0.0, 1.0))
    assert kind == "overlap" and f"particles {first} and {second} overlap" in why and "t = 0.5" in why
    assert depth == pytest.approx(1e-3, rel=1e-6)
    assert judge(WELL, Checks({}, 1.0, deepest=2e-3), folder)[0] == "stable"


def test_a_disk_that_jumps_over_a_wall_is_found(tmp_path):
    folder = apart(tmp_path / "run")
    table = read_table(folder / "particles.csv")
    keep = np.isin(table["step"], [0, 100]) | (table["step"] > 100)  # rows so far apart that none touches the wall
    write_csv(folder / "particles.csv", list(table), np.column_stack(list(table.values()))[keep | (table["step"] == 40)])
    write_csv(folder / "walls.csv", ["x1", "y1", "x2", "y2"], [[0.15, -1, 0.15, 1]])
    kind, why, _ = judge(WELL, Checks({}, 1.0), folder)
    assert kind == "overlap" and "passed through a wall" in why
    assert judge(WELL, Checks({}, 1.0, within={"x": (0, 0.2)}), folder)[0] == "overlap"


@pytest.mark.parametrize("low, high", [(-1, 0.5), (0.2, 2)])
def test_a_centre_beyond_where_it_can_go_is_found_on_either_side(tmp_path, low, high):
    kind, why, _ = judge(WELL, Checks({}, 1.0, within={"x": (low, high)}), apart(tmp_path / "run"))
    assert kind == "overlap" and "beyond where it can go" in why
    assert judge(WELL, Checks({}, 1.0, within={"x": (-1, 2)}), tmp_path / "run")[0] == "stable"


def test_a_disk_within_a_wall_is_named(tmp_path):
    """Deeper than all pairs: at y = 0.03, beside a wall a fifth of its radius off."""
    folder = apart(tmp_path / "run")
    table = read_table(folder / "particles.csv")
    radius = table["radius"][table["id"] == 1][0]
    write_csv(folder / "walls.csv", ["x1", "y1", "x2", "y2"], [[-1, 0.03 - 0.2 * radius, 2, 0.03 - 0.2 * radius]])
    kind, why, depth = judge(WELL, Checks({}, 1.0), folder)
    assert kind == "overlap" and "particle 1 overlaps a wall by 0.8 radii" in why and depth == pytest.approx(0.8, rel=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.9])
@pytest.mark.parametrize("depth", [-0.4, 0.02, 0.3])
def test_overlaps_of_ellipses_of_known_depth(turn, depth):
    """Two that lie on each other, over a seam; one on a wall. The disks round them overlap in every case."""
    up, along = np.array([-np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), np.sin(turn)])
    other = np.array([1.5, 0.2]) + (0.8 - 0.3 * depth) * up + [8.0, 0]
    table = {"t": np.zeros(2), "id": np.array([0, 1]), "radius": np.array([1, 0.6]), "theta": np.full(2, turn),
        "x": np.array([1.5, other[0]]), "y": np.array([0.2, other[1]])}
    aspect = np.array([0.5, 0.5])
    assert pair_overlap(table, (4.0, 0.0), aspect)[0] == pytest.approx(max(depth, 0), abs=1e-4)
    assert pair_overlap(table, (4.0, 0.0))[0] > 0.5
    foot = np.array([1.5, 0.2]) - 0.5 * (1 - depth) * up
    wall = np.concatenate([foot - 0.7 * along, foot + 3 * along])[None]
    one = {name: values[:1] for name, values in table.items()}
    assert wall_overlap(one, wall, (0.0, 0.0), aspect[:1])[0] == pytest.approx(max(depth, 0), abs=1e-9)


def test_depths_at_the_tip_of_an_ellipse_are_in_semi_minor_axes():
    """A tip 0.05 semi-major axes deep in a wall, and in another tip; aspect 0.1."""
    table = {"t": np.zeros(2), "id": np.array([0, 1]), "radius": np.ones(2), "theta": np.zeros(2), "x": np.array([0, 1.95]),
        "y": np.zeros(2)}
    aspect = np.array([0.1, 0.1])
    assert pair_overlap(table, (0.0, 0.0), aspect)[0] == pytest.approx(0.5, rel=0.15)
    one = {name: values[:1] for name, values in table.items()}
    assert wall_overlap(one, np.array([[0.95, -1, 0.95, 1]]), (0.0, 0.0), aspect[:1])[0] == pytest.approx(0.5, rel=0.1)


@settings(max_examples=60, deadline=None)
@given(x=st.floats(-3, 3), y=st.floats(-3, 3), shift=st.integers(-3, 3), r=st.floats(0.05, 0.4), angle=st.floats(0, 6.28),
    depth=st.floats(-0.5, 0.5))
def test_overlaps_of_known_depth(x, y, shift, r, angle, depth):
    """Two disks a known gap apart, in a periodic box too; a disk and a wall in any direction."""
    reach = 2 * r - depth * r
    table = {"t": np.zeros(2), "id": np.array([0, 1]), "radius": np.full(2, r),
        "x": np.array([x, x + reach * np.cos(angle) + 4 * shift]),
             "y": np.array([y, y + reach * np.sin(angle)])}
    assert pair_overlap(table, (4.0, 0.0))[0] == pytest.approx(max(depth, 0), abs=1e-9)
    normal, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    foot = np.array([x, y]) + (r - depth * r) * normal
    wall = np.concatenate([foot - 0.7 * along, foot + 0.9 * along])[None]
    one = {name: values[:1] for name, values in table.items()}
    assert wall_overlap(one, wall)[0] == pytest.approx(max(depth, 0), abs=1e-9)
    step = {name: np.repeat(values[:1], 2) for name, values in one.items()} | {"t": np.array([0.0, 1.0])}
    step["x"], step["y"] = x + np.array([0, 2 * r * normal[0]]), y + np.array([0, 2 * r * normal[1]])
    assert (crossing(step, wall) is not None) == (0 < (r - depth * r) < 2 * r)


def test_walls_of_a_mesh_leave_out_open_ends_and_sides_with_an_image(tmp_path):
    (tmp_path / "fluid.csv").write_text("t\n")
    (tmp_path / "mesh.mesh").write_bytes((ROOT / "meshes/couette_disk.mesh").read_bytes())
    sides = solid_segments(RunFolder(tmp_path), (1.0, 0.0))
    assert set(sides[:, 1]) == set(sides[:, 3]) == {0.0, 1.0} and len(sides) == 64
    (tmp_path / "mesh.mesh").write_bytes((ROOT / "meshes/poiseuille.mesh").read_bytes())
    assert set(solid_segments(RunFolder(tmp_path))[:, 1]) == {0.0, 1.0}


@pytest.mark.parametrize("kind", KINDS[1:])
def test_awkward_meshes_are_what_they_are_called(kind):
    options = parser().parse_args(["box", "--width", "2", "--height", "2", "--size", "0.125", "--out", "unused.mesh"])
    _, good = CASES["box"][0].build(options)
    bad = spoiled(good, kind)
    areas, angle = signed_areas(bad.points, bad.triangles), smallest_angles(bad.points, bad.triangles).min()
    assert abs(areas).sum() == pytest.approx(4.0, rel=1e-12) and len(bad.edges) == len(good.edges)
    assert (areas < 0).all() if kind == "clockwise" else (areas > 0).all()
    ends = bad.points[bad.edges]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(8.0)
    if kind.startswith("slivers"):
        assert angle == pytest.approx(float(kind.split()[2]), rel=0.2)
    if kind.startswith("graded"):
        spaces = np.diff(np.unique(np.round(bad.points[:, 0], 12)))
        assert spaces.max() / spaces.min() == pytest.approx(float(kind.split()[1].split(":")[0]), rel=1e-6)
    if kind == "renumbered":
        assert not np.array_equal(bad.points, good.points) and sorted(map(tuple, bad.points)) == sorted(map(tuple, good.points))


def test_every_map_builds_its_cells_under_names_of_their_own():
    for one in stress.MAPS.values():
        grid, extra = one.pairs()
        names = [name_of(one, *pair) for pair in grid + extra]
        assert len(set(names)) == len(names)
        assert one.default in grid and set(one.pairs(quick=True)[0]) <= set(grid)
        for pair in grid + extra:
            cell = one.build(*pair)
            assert (ROOT / cell.script).is_file() and cell.checks is not None
            assert not any(isinstance(value, Disks) and len(value.rows) and not np.isfinite(value.rows).all()
                for value in cell.options.values())


LOOP = """
include "getARGV.idp"
string out = getARGV("-out", "out");
real way = getARGV("-way", 0.), tall = getARGV("-tall", 1.);
exec("mkdir -p '" + out + "'");
if (way == 2) { exec("echo 'error: it did not converge; use a smaller -way' >&2"); exit(4); }
{ ofstream f(out + "/fluid.csv"); f << "t,kinetic_energy\\n0,0\\n1," << tall << "\\n"; }
real a = 1;
while (way == 1) a = sqrt(a + 1);
"""


def toy(script, values):
    """A map of runs of LOOP: y 1 never ends, y 2 stops, y 0 gives the energy x."""
    def build(x, y):
        return Cell(str(script), {"-way": y, "-tall": x}, Checks({"fluid.kinetic_energy": 50}, 1.0),
                    lambda run: run.fluid["kinetic_energy"][-1:], (1.0, 0), 0.1)
    return Map("toy", "A toy", Axis("energy", "J/m", values, values[:1]), Axis("way", "", [0, 1, 2], [0]), build,
        "energy 1 J/m within 10 %",
               {"stopped": "another way", "stable": "less"}, (1.0, 0))


def test_a_map_is_run_classed_drawn_and_goes_on_where_it_was(tmp_path):
    script = tmp_path / "toy.edp"
    script.write_text(LOOP)
    one, said, out = toy(script, [1.0, 1.05, 2.0, 99.0]), [], tmp_path / "out"
    begin = time.perf_counter()
    grid, rows = run_map(one, out, limit=1, say=said.append)
    assert time.perf_counter() - begin < 60  # the loops were ended
    kinds = {pair: rows[pair]["class"] for pair in grid}
    assert [kinds[x, 0] for x in one.x.values] == ["accurate", "accurate", "stable", "blown up"]
    assert {kinds[x, 1] for x in one.x.values} == {"late"} and {kinds[x, 2] for x in one.x.values} == {"stopped"}
    with open(out / "toy.csv", newline="") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == 12 and {row["class"] for row in table if row["y"] == "2"} == {"stopped"}
    assert float(table[2]["error"]) == pytest.approx(1.0) and "above the bound" in table[3]["reason"]
    # A second time nothing runs; another script is run again; what was late gets its chance with more time.
    (out / "toy/runs/1__2.json").unlink()
    assert sum(row["fresh"] for row in run_map(one, out, limit=1, say=said.append)[1].values()) == 1
    assert "done before" in said[-1]
    assert sum(row["fresh"] for row in run_map(one, out, True, limit=1, say=said.append)[1].values()) == 0
    script.write_text(LOOP + "\n")
    assert sum(row["fresh"] for row in run_map(one, out, True, limit=1, say=said.append)[1].values()) == 1
    # limits and figures
    assert stress.draw_map(one, grid, rows, out).stat().st_size > 10_000
    assert stress.draw_all([(one, grid, rows)], out / "stress.png").stat().st_size > 10_000
    found = {row[1]: row for row in limits_of(one, grid, rows)}
    assert set(found) == {"stable", "stopped", "late", "blown up"}
    assert found["stopped"][2] == "energy all J/m at way 2" and found["stopped"][5] == "another way"
    assert found["stable"][2] == "energy 2 J/m at way 0" and "did not converge" in found["stopped"][4]
    write_limits([(one, grid, rows)], out, "head")
    text = (out / "limits.md").read_text()
    assert "| toy | stopped cleanly, with a reason | 4 |" in text
    # the default (1, 0): its neighbour in y never ends
    assert defaults_inside([(one, grid, rows)])[0][1] is False and "out of time" in text
    assert len(stress.failures([(one, grid, rows)])) == 1


def test_a_cell_on_the_mesh_of_its_case_is_run_again_when_that_has_changed(tmp_path):
    script, mesh = tmp_path / "toy.edp", tmp_path / "own.mesh"
    script.write_text(f'// optDefault("-mesh", "{mesh}");\n' + LOOP)
    one, fresh = toy(script, [1.0]), []
    for text in ("1", "1", "2"):
        mesh.write_text(text)
        fresh.append(run_map(one, tmp_path, True, say=lambda line: None)[1][1.0, 0]["fresh"])
    assert fresh == [True, False, True]


def test_a_record_cut_short_is_run_again(tmp_path):
    script = tmp_path / "toy.edp"
    script.write_text(LOOP)
    one = toy(script, [1.0])
    run_map(one, tmp_path, True, say=lambda line: None)
    note = tmp_path / "toy/runs/1__0.json"
    assert json.loads(note.read_text())["status"] == 0
    note.write_text(note.read_text()[:40])
    assert run_map(one, tmp_path, True, say=lambda line: None)[1][1.0, 0]["fresh"]


def test_meshes_are_made_by_two_threads_at_a_time(tmp_path):
    """gmsh ends the process when two threads use it at once; hence in a process of its own."""
    script = ("import sys, concurrent.futures as c; from tools.stress.cells import Mesh; pool = c.ThreadPoolExecutor(2);"
              "print(len(list(pool.map(lambda h: Mesh(('pipe_obstacles', '--size', h)).make(sys.argv[1]), [0.03, 0.028, 0.032, "
                  "0.026]))))")
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path)], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split()[-1] == "4", done.stderr
    assert len(list(tmp_path.glob("*.mesh"))) == 4


def test_the_last_shorter_step_lets_nothing_overlap(tmp_path):
    """3.125 steps of 0.032 s in a suspension of 70 %: the contacts of the last step are those of its own length."""
    one = stress.MAPS["area_fraction"]
    cell = Map(one.name, one.title, Axis("time step", "s", [0.032], [0.032]), Axis("area fraction", "%", [70], [70]),
               lambda x, y: Cell(**{**vars(one.build(x, y)), "reference": None}), "", {})
    row = run_map(cell, tmp_path, True, say=lambda line: None)[1][0.032, 70]
    assert row["class"] in GOOD, row["reason"]
    assert RunFolder(row["run"]).fluid["contacts"].max() > 0  # some touch


def test_a_clockwise_mesh_is_refused_in_one_line(tmp_path):
    options = parser().parse_args(["box", "--width", "2", "--height", "2", "--size", "0.25", "--out", "unused.mesh"])
    write(spoiled(CASES["box"][0].build(options)[1], "clockwise"), tmp_path / "bad.mesh")
    done = run_freefem("cases/settling_disk.edp", "-mesh", tmp_path / "bad.mesh", "-out", tmp_path / "run", check=False)
    assert done.returncode == 3 and done.stderr.count("\n") == 1 and "run clockwise" in done.stderr


def test_cells_of_the_real_maps(tmp_path, capsys):
    """Disks of density ratio 0.001 to 1000, and disks on a neck that they do not pass."""
    assert stress.main(["dt_density", "neck", "--quick", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "FAILED" not in said and (tmp_path / "limits.md").is_file() and (tmp_path / "stress.png").stat().st_size > 10_000
    for name in ("dt_density", "neck"):
        with open(tmp_path / f"{name}.csv", newline="") as stream:
            rows = [row for row in csv.DictReader(stream) if row["part"] == "grid"]
        assert rows and {row["class"] for row in rows} <= set(GOOD)
        assert all(float(row["overlap_radii"]) < 1e-4 for row in rows)


def test_a_penalty_below_the_rounding_is_refused(tmp_path):
    options = ["-scheme", "published", "-mesh", "meshes/box.mesh", "-tend", "0.001", "-out", tmp_path / "run"]
    done = run_freefem("cases/settling_disk.edp", "-penalty", "1e-14", *options, check=False)
    assert done.returncode == 3 and done.stderr.count("\n") == 1 and "lost in rounding" in done.stderr


@pytest.mark.parametrize("words", [["nothing"], ["--jobs", "0"], ["--limit", "-1"], ["--speed"]])
def test_bad_input_is_status_3(words, capsys):
    with pytest.raises((SystemExit, stress.BadInput)) as caught:
        stress.main(words)
    assert caught.type is stress.BadInput or caught.value.code == 3


def test_cells_side_by_side_share_a_file_of_particles(tmp_path):
    """Eight threads make each of fifty files; all find it whole."""
    wanted = [Disks(np.array([[0, 0.1 * k, 0.2, 0.05, 1, 0, 0, 0]])) for k in range(50) for _ in range(8)]
    with ThreadPoolExecutor(8) as pool:
        paths = list(pool.map(lambda disks: disks.make(tmp_path), wanted))
    assert len(set(paths)) == 50 and all(len(path.read_text().splitlines()) == 2 for path in paths)
    assert len(list(tmp_path.iterdir())) == 50


@pytest.mark.parametrize("status, again", [(24, 1), (-24, 1), (124, 1), (4, 0), (0, 0)])
def test_a_cell_that_was_late_in_any_way_is_run_again_with_more_time(status, again, tmp_path, monkeypatch):
    """One that its wall-clock time ended was late for ever."""
    one = toy("cases/poiseuille.edp", [1.0])
    monkeypatch.setattr(stress_runs, "run_command", lambda command, limit: Done(status, "", 1.0, 1.0, 1.0, ""))
    assert [stress_runs.run_cell(one, 1.0, 0, tmp_path, limit)["fresh"] for limit in (1, 1, 2)] == [True, False, bool(again)]


def budget(kinetic, work, dissipated, numerical=(0,)):
    """A budget.csv as judge() reads it."""
    columns = {"kinetic_energy": kinetic, "work": work, "dissipated": dissipated, "numerical": numerical}
    return {name: np.array(values, float) for name, values in columns.items()}


@pytest.mark.parametrize("start, table, words", [
    (1.0, budget([0.9, 0.8, 0.5], [0, 0.1, 0.1], [0.1, 0.3, 0.6]), ""),
    (1.0, budget([0.9, 1.2, 0.5], [0, 0.1, 0.1], [0.1, 0.3, 0.6]), "exceeds work and energy at the start by 0.091"),
    (1.0, budget([0.9, 0.1, 0.5], [0, 0.0, 0.0], [0.1, 0.3, 0.4]), "gains 0.4 of work"),
    (0.0, budget([0.5, 1.0, 0.5], [0.6, 1.5, 2.0], [0.0, 1.0, 2.1]), "kinetic energy and dissipation exceed work and energy at "
        "the start by 0.3"),
    (1.0, budget([0.9, 0.8, 0.5], [0, 0.1, 0.1], [0.1, 0.3, 0.6], [0.1, -0.04, 0]), ""),
    (1.0, budget([0.9, 0.8, 0.5], [0, 0.1, 0.1], [0.1, 0.3, 0.6], [0.1, -0.1, 0]), "the numerical dissipation is -0.091 of work"),
    (None, {}, "")])
def test_energy_that_nothing_supplied_is_told_from_a_budget(start, table, words):
    said = created({"budget": table}, start)
    assert words in said and bool(said) == bool(words)


def test_random_closed_scenes_lie_within_their_walls_apart_from_each_other_and_cover_what_they_should():
    scenes = [scene(seed) for seed in range(1, 201)]
    for one in scenes:
        x, r = one.rows[:, 1:3], one.rows[:, 3]
        assert all(room(one.corners, *at) > size for at, size in zip(x, r))
        apart = np.hypot(*(x[:, None] - x).transpose(2, 0, 1)) - r[:, None] - r
        assert apart[~np.eye(len(r), dtype=bool)].min(initial=1) > 0
        assert (2 * r * one.rows[:, 8] >= 1.99 * SIZE).all() and (r <= 5 * SIZE).all()
    density = np.concatenate([one.rows[:, 4] for one in scenes])
    assert density.min() < 0.015 and density.max() > 15 and {one.kind for one in scenes} == set(ROOMS)
    assert max(len(one.rows) for one in scenes) > 20 and sum(len(one.rows) == 1 for one in scenes) > 10


@pytest.mark.parametrize("name", ["friction_size_ratio", "friction_stack"])
def test_friction_of_the_quick_form_keeps_energy_momentum_and_the_law(name, tmp_path):
    grid, rows = run_map(stress.MAPS[name], tmp_path, True, say=lambda line: None)
    assert {rows[pair]["class"] for pair in grid} == {"accurate"}, [rows[pair]["reason"] for pair in grid]


def test_closed_scenes_of_the_quick_form_keep_their_energy(tmp_path):
    grid, rows = run_map(stress.MAPS["energy"], tmp_path, True, say=lambda line: None)
    assert {rows[pair]["class"] for pair in grid} == {"stable"}, [rows[pair]["reason"] for pair in grid]
