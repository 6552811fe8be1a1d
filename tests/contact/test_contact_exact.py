"""The projection against answers known exactly: pairs, rows, columns, instances, momentum."""
import numpy as np
import pytest
from scipy.optimize import isotonic_regression

from tools.base.command import BadInput
from tools.peers.contact_problems import Scene, constraints, packing, project, read_scene, residual

DATA = "tests/data/contact/random_{}_{}.csv"
SOLVERS = ["newton", "accelerated", "uzawa"]
FLOOR = [[-100.0, 0.0, 100.0, 0.0]]


def row(masses, velocities, radius=0.01):
    """Touching disks along x; the velocities are far above a radius a step."""
    n = len(masses)
    x = np.column_stack([2 * radius * np.arange(n), np.zeros(n)])
    return Scene(x, radius, masses, np.column_stack([velocities, np.zeros(n)]))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_head_on_pair_leaves_with_the_mean_velocity(solver):
    answer = project(row([1.0, 3.0], [2.0, -1.0]), tol=1e-12, solver=solver)
    np.testing.assert_allclose(answer.velocity, [[-0.25, 0], [-0.25, 0]], atol=1e-10)
    assert answer.contacts[0, 6] == pytest.approx(2.25, abs=1e-9)  # impulse: 1 kg/m slowed from 2 to -0.25 m/s


def test_an_oblique_pair_keeps_its_tangential_velocities():
    angle = 0.7
    e, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    x = np.array([[0.0, 0.0], 0.03 * e])
    u = np.array([1.5 * e + 0.3 * t, -0.5 * e - 0.8 * t])
    answer = project(Scene(x, [0.01, 0.02], [1.0, 4.0], u), tol=1e-12)
    np.testing.assert_allclose(answer.velocity @ t, [0.3, -0.8], atol=1e-12)
    np.testing.assert_allclose(answer.velocity @ e, -0.1, atol=1e-11)


def test_disks_of_less_than_a_micron_slide_along_a_slanted_wall():
    """Rounding of places of the order of 1 turns the wall's normal at them: 1e-8 of such a radius was asked for in vain."""
    along, across = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
    places = np.outer(np.linspace(1, 2, 20), along) + 1e-7 * across
    scene = Scene(places, 1e-7, 1.0, np.tile(along - 0.1 * across, (20, 1)), walls=[[0, 0, 4, 3]])
    np.testing.assert_allclose(project(scene).velocity, np.tile(along, (20, 1)), atol=1e-7)


def test_disks_that_would_pass_closely_meet_in_a_long_step():
    """Disks of the radius R that pass each other at the distance b, and are a move s apart along it, meet in the step where
    b^4 < 4 R^2 (s^2 + b^2), although b > 2 R: the normal is that at its start. So a step widens the disks by about s^2/(4 R)."""
    r, dt = 0.01, 0.01
    moves = np.repeat([0.1, 0.3, 1.0, 2.4], 2)
    wide = r * np.sqrt(2 * (1 + np.sqrt(1 + moves**2))) * (1 + np.tile([-1e-4, 1e-4], 4))
    pair = np.arange(8)[:, None] * [0.0, 1.0]
    x = np.concatenate([pair, pair + np.column_stack([moves * r, wide])])
    u = np.concatenate([np.zeros((8, 2)), np.column_stack([-moves * r / dt, np.zeros(8)])])
    answer = project(Scene(x, np.full(16, r), np.full(16, 1.0), u), tol=1e-12)
    assert (np.abs(answer.velocity - u).max(axis=1)[8:] > 0).tolist() == [True, False] * 4
    assert (wide > 2 * r).all()
    np.testing.assert_allclose((wide / r - 2)[:4], moves[:4]**2 / 4, rtol=0.1, atol=3e-4)


def test_a_gap_is_used_up_and_no_more():
    scene = row([1.0, 1.0], [0.5, -0.5])
    scene.x[1, 0] += 0.004
    answer = project(scene, dt=0.01, tol=1e-13)
    assert answer.velocity[0, 0] - answer.velocity[1, 0] == pytest.approx(0.4, abs=1e-11)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_row_hit_by_one_disk_moves_as_a_whole(solver):
    answer = project(row(np.ones(8), [4.0] + 7 * [0.0]), tol=1e-11, solver=solver)
    np.testing.assert_allclose(answer.velocity, np.outer(np.full(8, 0.5), [1, 0]), atol=1e-8)


@pytest.mark.parametrize("number", [3, 30, 300, 1000])
def test_a_row_of_any_masses_follows_the_isotonic_regression(number):
    rng = np.random.default_rng(number)
    masses, velocities = np.exp(rng.normal(size=number)), rng.normal(size=number)
    answer = project(row(masses, velocities), tol=1e-11)
    np.testing.assert_allclose(answer.velocity[:, 0], isotonic_regression(velocities, weights=masses).x, atol=1e-9)
    assert abs(answer.velocity[:, 1]).max() < 1e-12


def test_a_resting_column_carries_the_weight_above_each_contact():
    r = np.array([0.01, 0.03, 0.02, 0.015, 0.04])
    y = np.cumsum(r) + np.r_[0, np.cumsum(r[:-1])]
    mass, g, dt = 1000 * np.pi * r**2, 9.81, 0.01
    answer = project(Scene(np.column_stack([0 * y, y]), r, mass, np.outer(np.ones(5), [0, -g * dt]), FLOOR), dt, 1e-12)
    np.testing.assert_allclose(answer.velocity, 0, atol=1e-12)
    above = {frozenset((k, k - 1 if k else -1)): g * dt * mass[k:].sum() for k in range(5)}
    found = {frozenset((int(c[1]), int(c[2]))): c[6] for c in answer.contacts}
    assert found.keys() == above.keys()
    for key, impulse in above.items():
        assert found[key] == pytest.approx(impulse, rel=1e-9)


@pytest.mark.parametrize("number, solver", [(50, "newton"), (50, "accelerated"), (50, "uzawa"), (500, "newton"),
    (500, "accelerated")])
def test_packings_with_exact_solutions(number, solver):
    scene = read_scene(DATA.format(number, "bodies"), DATA.format(number, "walls"))
    exact = np.loadtxt(DATA.format(number, "exact"), delimiter=",", skiprows=1)[:, 1:]
    answer = project(scene, 0.01, 1e-10 if solver == "newton" else 2e-11, solver)
    assert abs(answer.velocity - exact).max() < 1e-8


def test_momentum_holds_to_round_off_with_unequal_radii():
    scene = packing(300, "random", seed=5, spread=0.6)
    scene.walls = np.zeros((0, 4))
    answer = project(scene, tol=1e-8)
    before, after = scene.mass @ scene.velocity, scene.mass @ answer.velocity
    assert abs(after - before).max() < 1e-12 * scene.mass @ np.hypot(*scene.velocity.T)
    assert len(answer.contacts) > 200


def test_the_residual_that_is_printed_is_the_true_one():
    scene = packing(400, "gravity", seed=2)
    rows = constraints(scene, scene.reach(0.01))
    for tol in (1e-4, 1e-8):
        answer = project(scene, tol=tol, solver="accelerated")
        own = residual(rows, scene, 0.01, answer.multipliers(rows))
        assert own <= tol * 1.01
        assert own == pytest.approx(answer.figures[0]["residual"], rel=0.05)


def test_a_prescribed_disk_keeps_its_velocity_and_pushes():
    scene = row([-1.0, 1.0, 2.0], [0.3, 0.0, -1.0])
    answer = project(scene, tol=1e-12)
    np.testing.assert_allclose(answer.velocity[:, 0], 0.3, atol=1e-11)


def test_nothing_within_reach_changes_nothing():
    scene = row([1.0, 1.0], [0.1, 0.1])
    scene.x[1, 0] += 1.0
    answer = project(scene)
    np.testing.assert_array_equal(answer.velocity, scene.velocity)
    assert answer.figures[0]["constraints"] == 0 and len(answer.contacts) == 0


def test_a_warm_start_needs_no_steps():
    answer = project(packing(300, "gravity", seed=3), tol=1e-9, repeat=2)
    assert answer.figures[0]["steps"] > 0 and answer.figures[1]["steps"] == 0


def test_too_few_steps_end_with_words_and_status_4():
    with pytest.raises(BadInput, match=r"did not converge: residual .*status 4"):
        project(packing(100, "random"), solver="uzawa", tol=1e-12, options={"-contact-maxit": 20})


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("number", [1, 30])
def test_a_row_squeezed_between_two_prescribed_disks_is_said_at_once(number, solver):
    scene = row([-1.0] + [1.0] * number + [-1.0], [0.1] + [0.0] * number + [-0.1])
    with pytest.raises(BadInput, match=r"leave a body no room: no motion satisfies the contacts of .*body \d+ and body \d+ have "
        r"the largest contact force .*status 4"):
        project(scene, solver=solver)


@pytest.mark.parametrize("number", [50, 500])
def test_a_residual_below_what_rounding_leaves_is_as_good_as_it_gets(number):
    """A stack: the pushes at its foot are `number` times as long as one disk's, and known to 4e-16 of that."""
    x = np.column_stack([np.zeros(number), 0.01 * (2 * np.arange(number) + 1)])
    answer = project(Scene(x, 0.01 * (1 - 1e-13), 1.0, np.outer(np.ones(number), [0, -0.25]), FLOOR), tol=1e-16)
    assert answer.figures[0]["residual"] < 1e-15 * number and answer.figures[0]["factorisations"] < 100
    np.testing.assert_allclose(answer.velocity, 0, atol=1e-10)
