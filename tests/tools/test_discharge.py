"""Contacts alone, judged by the discharge: tools.stress, and the projection against LIGGGHTS in tools.bench."""
import math

import numpy as np
import pytest

from tests.synthetic import write_csv
from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.base.runner import Done
from tools.bench import __main__ as bench
from tools.bench import discrete
from tools.bench.page import write_page
from tools.bench.rounds import Point, collect, cost_at, earlier, run_rounds
from tools.peers import with_liggghts
from tools.stress import __main__ as stress
from tools.stress import maps_contacts
from tools.stress.classes import judge
from tools.stress.runs import classed, run_map

HEADER = "step t id x y theta u v omega radius".split()


def glass(folder, half, number=200, end=0.6, start=1.0):
    """A made-up run whose disks pass the height 0 one after the other, half of them by the time `half`, s."""
    folder.mkdir()
    times, rows = np.linspace(0, end, 61), []
    for step, t in enumerate(times):
        for k in range(number):
            pass_at = 2 * half * (k + 1) / number
            rows.append([step, t, k, 0.1 * k, start * (pass_at - t), 0, 0, -start, 0, 0.013])
    write_csv(folder / "particles.csv", HEADER, rows)
    write_csv(folder / "motion.csv", "step t kinetic_energy potential_energy momentum_x momentum_y momentum_error".split(),
        [[step, t, 1 + t, -t, 1, 0, 0] for step, t in enumerate(times)])
    return folder


@pytest.mark.parametrize("late, kind", [(1.0, "accurate"), (1.03, "accurate"), (1.1, "stable"), (0.9, "stable"), (9.0, "stable")])
def test_a_late_discharge_is_not_accurate(late, kind, tmp_path):
    """The map was judged by its energy alone: eight times the default step, a fifth late, was called accurate."""
    number, end, limit = maps_contacts.DISCHARGE[0.3]
    folder = glass(tmp_path / "run", late * limit, end=end)
    one, cell = stress.MAPS["discharge"], stress.MAPS["discharge"].build(0.002, 0.3)
    assert judge(Done(0, "", 1, 1, 1, ""), cell.checks, folder, lambda run: (float(cell.quantity(run)[0]),
        cell.tolerance))[0] == kind
    record = {"status": 0, "reason": "", "cpu_s": 1.0, "memory_mib": 1.0, "log": "", "run": str(folder), "fresh": True}
    row = classed(one, (0.002, 0.3), record, {})
    assert row["class"] == kind
    if late < 2:
        assert row["error"] == pytest.approx(abs(late - 1), abs=0.01)
        assert maps_contacts.half_discharge(RunFolder(folder)) == pytest.approx(late * limit, rel=0.01)
    else:
        assert row["error"] == 1
        with pytest.raises(BadInput, match="not half of them"):
            maps_contacts.half_discharge(RunFolder(folder))


@pytest.mark.parametrize("slow, kind", [(1.0, "accurate"), (0.97, "accurate"), (0.85, "stable"), (1.1, "stable")])
def test_a_lattice_that_runs_too_slowly_is_not_accurate(slow, kind, tmp_path):
    folder = glass(tmp_path / "run", 0.3, end=0.4, start=slow * maps_contacts.LATTICE[50] / 0.4)
    record = {"status": 0, "reason": "", "cpu_s": 1.0, "memory_mib": 1.0, "log": "", "run": str(folder), "fresh": True}
    assert classed(stress.MAPS["lattice"], (50, 0.002), record, {})["class"] == kind


@pytest.mark.parametrize("late, kind", [(1.0, "accurate"), (1.15, "stable")])
def test_the_map_of_the_cases_judges_the_hourglass_by_its_discharge(late, kind, tmp_path):
    """At eight times the default step half of the disks were 15 % late, and the map called it accurate."""
    _, end, limit = maps_contacts.DISCHARGE[0.3]
    folder = glass(tmp_path / "run", late * limit, end=end)
    record = {"status": 0, "reason": "", "cpu_s": 1.0, "memory_mib": 1.0, "log": "", "run": str(folder), "fresh": True}
    assert classed(stress.MAPS["defaults"], (8, "hourglass"), record, {})["class"] == kind
    assert stress.MAPS["defaults"].build(1, "hourglass").options["-dt"] == 0.002


@pytest.mark.parametrize("share, kind", [(1.0, "accurate"), (1.06, "stable"), (0.94, "stable")])
def test_the_map_of_the_cases_judges_falling_disks_by_their_height(share, kind, tmp_path):
    rows = [[0, 0, 0, 0, 2.0, 0, 0, 0, 0, 0.1], [1, 8, 0, 0, 2 * share * maps_contacts.FALLEN, 0, 0, 0, 0, 0.1],
            [2, 20, 0, 0, 0.1, 0, 0, 0, 0, 0.1]]
    (tmp_path / "run").mkdir()
    write_csv(tmp_path / "run" / "particles.csv", HEADER, rows)
    write_csv(tmp_path / "run" / "motion.csv",
        "step t kinetic_energy potential_energy momentum_x momentum_y momentum_error".split(),
        [[0, 0, 1, 0, 1, 0, 0], [2, 20, 1, 0, 1, 0, 0]])
    record = {"status": 0, "reason": "", "cpu_s": 1.0, "memory_mib": 1.0, "log": "", "run": str(tmp_path / "run"), "fresh": True}
    assert classed(stress.MAPS["defaults"], (1, "falling_particles"), record, {})["class"] == kind


def test_the_quick_form_tells_the_default_step_from_eight_times_that(tmp_path):
    """Bounds set before: 4 % is accurate; a wide neck, whose discharge is the same from seed to seed within 1 %."""
    rows = run_map(stress.MAPS["discharge"], tmp_path, True, say=lambda line: None)[1]
    assert {pair: row["class"] for pair, row in rows.items()} == {(0.002, 0.3): "accurate", (0.016, 0.3): "stable"}
    assert rows[0.016, 0.3]["error"] > 0.05


def test_time_of_half_and_mean_height():
    times, heights = np.arange(5.0), np.array([[1, 1, 1, 1], [1, 1, 1, -1], [1, 1, -1, -1], [1, -1, -1, -1], [-1, -1, -1, -1.0]])
    assert discrete.discharge_time(times, heights) == 2
    assert discrete.discharge_time(times, heights[:, :3]) == pytest.approx(2.5)
    with pytest.raises(BadInput, match="1 of 4 disks had passed at 1 s"):
        discrete.discharge_time(times[:2], heights[:2])
    found = discrete.mean_height(np.array([0, 16.0]), np.array([[4.0, 2], [2.0, 2]]), np.array([3.0, 1]))
    assert found == pytest.approx(2.75 / 3.5)
    times, places = np.array([0, 0.2, 0.6]), np.array([[0, 0.0], [0.1, -0.2], [0.3, -0.4]])
    assert discrete.mean_distance(times, places, np.array([3.0, 1])) == pytest.approx(0.225 / discrete.HALF)


def test_the_input_of_liggghts_holds_the_scene(tmp_path):
    centres, radius, walls = np.array([[0.1, 0.4], [0.2, 0.3]]), np.array([0.05, 0.1]), np.array([[-1, 0, 1, 0.0]])
    masses = np.pi * radius**2 * 100
    text = with_liggghts.data_text(centres, radius, masses, walls)
    atoms = np.array([line.split() for line in text.split("Atoms\n\n")[1].splitlines()], float)
    assert atoms[:, 2] == pytest.approx(2 * radius) and atoms[:, 4:6] == pytest.approx(centres.T)
    assert np.pi / 6 * atoms[:, 2] ** 3 * atoms[:, 3] == pytest.approx(masses)  # the spheres weigh what the disks weigh
    box = {line.split()[2]: [float(word) for word in line.split()[:2]] for line in text.splitlines() if line.endswith("hi")}
    assert box["xlo"][0] < -1 and box["xlo"][1] > 1 and box["ylo"][0] < 0 and box["ylo"][1] > 0.4  # the walls lie in it
    assert with_liggghts.walls_text(walls, 0.3).count("facet normal") == 2
    soft, hard = (with_liggghts.collision(young, 0.013, 0.5)[1] for young in (1e7, 1e9))
    assert soft / hard == pytest.approx(100**0.4)  # stiffness as the modulus to the power 4/5


def test_rows_of_liggghts_are_read_by_disks(tmp_path):
    rows = "".join(f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y \n"
        f"2 {step} 5 \n1 0.5 -{step} \n" for step in (0, 10))
    path = tmp_path / "dump"
    path.write_text(rows)
    times, ids, places = with_liggghts.read_dump(path, 0.01)
    assert list(times) == [0, 0.1] and list(ids) == [1, 2]
    assert places.tolist() == [[[0.5, 0], [0, 5]], [[0.5, -10], [10, 5]]]
    for wrong in (rows.replace("OF ATOMS\n2", "OF ATOMS\n1", 1), "", rows.replace("2 10 5", "2 nan 5")):
        path.write_text(wrong)
        with pytest.raises(BadInput):
            with_liggghts.read_dump(path, 0.01)


def test_without_liggghts_one_line_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(with_liggghts, "PROGRAM", "liggghts-that-is-not-there")
    jobs = discrete.discrete_jobs(tmp_path, {"fall": {discrete.ELEMENTS: [0, 1, 2]}}, 1, 9)
    samples = run_rounds(jobs, 1, 9, say=lambda text: None)
    assert len(samples) == 3 and {sample.note for sample in samples} == {with_liggghts.MISSING}
    page = write_page(collect(samples), samples, [], [with_liggghts.MISSING], tmp_path, True, 1.0, (0.1, 0.1),
        "a machine").read_text()
    assert "apt-get install liggghts" in page
    assert [s.note for s in earlier(tmp_path / "bench.csv", ("flow",))] == [with_liggghts.MISSING] * 3
    (tmp_path / "particles.csv").write_text(",".join(HEADER) + "\n")
    assert with_liggghts.main([str(tmp_path), "1e7", str(tmp_path / "out")]) == 3
    assert capsys.readouterr().err == f"error: {with_liggghts.MISSING}\n"


@pytest.mark.parametrize("words", [[], ["one", "two"], ["one", "much", "out"]])
def test_the_peer_called_wrongly_is_status_3(words, capsys):
    assert with_liggghts.main(words) == 3
    assert capsys.readouterr().err.startswith("error: ")


@pytest.mark.parametrize("late", [1.0, 1.02])
def test_a_run_is_judged_by_both_limits(late, tmp_path, monkeypatch):
    monkeypatch.setitem(discrete.LIMITS, "discharge", {"own": {discrete.OURS: 1.2, discrete.ELEMENTS: 1.3}, "common": 1.25})
    own, common = 1.2, 1.25
    monkeypatch.setattr(discrete, "by_suite", lambda problem, level, seed, *more: (late * own + 0.01 * (seed - 2), 2.0 * seed,
        50.0, 1.5 * seed))
    jobs = discrete.discrete_jobs(tmp_path, {"discharge": {discrete.OURS: [1]}}, 3, 9)
    mine, both, alone = run_rounds(jobs, 1, 9, say=lambda text: None)
    assert mine.error == pytest.approx(late - 1, abs=1e-12) and both.error == pytest.approx(abs(late * own / common - 1), abs=1e-12)
    assert alone.cpu_s == 3 and alone.error == mine.error and alone.problem == "discharge, without the start"
    assert mine.cpu_s == both.cpu_s == 4 and mine.unknowns == 500 and both.problem == "discharge, common limit"


def test_the_cost_at_an_error_is_read_between_points():
    points = [Point("discrete", "discharge", "standard", k, 1, 500, error, 1, cost, math.nan) for k, (cost, error) in
        enumerate([(1, 0.1), (10, 0.01)])]
    assert cost_at(points, 0.1) == pytest.approx(1) and cost_at(points, 0.1 / 10**0.5) == pytest.approx(10**0.5)
    assert math.isnan(cost_at(points, 0.001)) and math.isnan(cost_at(points, 0.2)) and math.isnan(cost_at([], 0.05))


@pytest.mark.skipif(not with_liggghts.program(), reason="LIGGGHTS is not installed")
def test_falling_disks_of_both_agree(tmp_path):
    """The mean height at 8 s of both at their second coarsest levels, within 2 % of the limits."""
    jobs = discrete.discrete_jobs(tmp_path, {"fall": {discrete.OURS: [1], discrete.ELEMENTS: [1]}}, 1, 120)
    samples = run_rounds(jobs, 1, 120, say=lambda text: None)
    assert len(samples) == 6 and all(sample.error < 0.02 and sample.cpu_s > 0 for sample in samples), samples


def test_the_part_is_one_of_the_benchmark(tmp_path):
    for quick in (True, False):
        jobs = bench.jobs_of("discrete", set(), tmp_path, quick, 9)
        collapse = set() if quick else {"collapse", "collapse, without the start"}
        assert {job.problem for job in jobs} == {"discharge", "discharge, without the start", "fall",
            "fall, common limit", "fall, without the start", *collapse}
        assert {job.program for job in jobs} == {"standard", "standard, loose", "LIGGGHTS"}


def test_elements_start_from_any_row_and_from_some_walls(tmp_path):
    run = tmp_path / "run"
    run.mkdir()
    (run / "run.json").write_text("{}")
    (run / "particles.csv").write_text("t,id,x,y,theta,u,v,omega,radius\n0,0,0,1,0,0,0,0,0.1\n0,1,1,1,0,0,0,0,0.2\n"
        "0.5,0,0,0.5,0,0,0,0,0.1\n0.5,1,1,0.6,0,0,0,0,0.2\n")
    (run / "walls.csv").write_text("x1,y1,x2,y2,friction\n0,0,1,0,0\n5,0,6,0,0\n")
    centres, radius, walls = with_liggghts.start(run, at=0.45, kept=[1])
    assert centres.tolist() == [[0, 1], [0.5, 0.6]] and radius.tolist() == [0.1, 0.2] and walls.tolist() == [[5, 0, 6, 0]]
    assert with_liggghts.start(run)[0][1].tolist() == [1, 1] and len(with_liggghts.start(run)[2]) == 2
    assert "coefficientFriction peratomtypepair 1 0.5" in with_liggghts.script_text(1e7, 1e-5, 10, 5, 9.81, 0.01, 0.5)
    assert "coefficientRestitution peratomtypepair 1 0.7" in with_liggghts.script_text(1e7, 1e-5, 10, 5, 9.81, 0.01, 0.5, 0.7)
