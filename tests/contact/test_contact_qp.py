"""Random problems against a QP package and against the conditions of the minimum."""
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from tools.base.command import BadInput
from tools.peers.contact_problems import Scene, box, constraints, packing, project, qp_piqp, residual, scaled

FEW = settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


@st.composite
def scenes(draw):
    """Up to 40 disks of sizes up to 1:20 that do not overlap, in a box with a sloping obstacle."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    number, ratio = draw(st.integers(1, 40)), draw(st.sampled_from([1.0, 4.0, 20.0]))
    r = 0.01 * np.exp(rng.uniform(-np.log(ratio), 0, number))
    side = draw(st.sampled_from([1.1, 1.5])) * np.sqrt(4 * (r**2).sum()) + 0.02
    slope = [0.3 * side, 0.25 * side, 0.6 * side, 0.45 * side]
    kept = []
    for k in np.argsort(-r):
        for _ in range(60):
            x = r[k] + (side - 2 * r[k]) * rng.random(2)
            start, along = np.array(slope[:2]), np.array(slope[2:]) - slope[:2]
            foot = start + np.clip((x - start) @ along / (along @ along), 0, 1) * along
            clear = all(np.hypot(*(x - y)) > r[k] + r[j] for j, y in kept)
            if clear and np.hypot(*(x - foot)) > r[k]:
                kept.append((k, x))
                break
    order = [k for k, _ in kept]
    speed = draw(st.sampled_from([0.1, 1.0, 10.0]))
    mass = np.pi * r[order]**2 * np.exp(rng.normal(0, draw(st.sampled_from([0.0, 1.5])), len(order)))
    walls = np.vstack([box(side, side), slope])
    return Scene(np.array([x for _, x in kept]), r[order], mass, speed * rng.standard_normal((len(order), 2)), walls,
                 rng.permutation(10 * len(order))[: len(order)])


def check_minimum(scene, answer, dt, tol):
    """Feasible, complementary, stationary: together the minimum."""
    rows = constraints(scene, scene.reach(dt))
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    length = scene.radius.mean()
    q = dt / length * answer.velocity.ravel()
    after = matrix @ q + d
    press = answer.multipliers(rows)
    assert after.min(initial=0) > -20 * tol
    assert (press >= 0).all()
    assert np.abs(press * after).max(initial=0) < 200 * tol * max(1, press.max(initial=0))
    scale = max(1.0, np.abs(weight * q0).max(initial=0))
    np.testing.assert_allclose(weight * (q - q0), matrix.T @ press, atol=1e-9 * scale)
    moved = Scene(scene.x + dt * answer.velocity, scene.radius, scene.mass, scene.velocity, scene.walls)
    assert constraints(moved, scene.reach(dt)).gap.min(initial=0) > -1e-7 * scene.radius.min()  # the true gaps
    return rows, q


@FEW
@given(scenes(), st.sampled_from(["newton", "accelerated"]))
def test_the_minimum_is_that_of_a_qp_package(scene, solver):
    dt, tol = 0.01, 1e-10
    answer = project(scene, dt, tol, solver, options={"-contact-maxit": 2000000})
    rows, q = check_minimum(scene, answer, dt, tol)
    if len(rows.i):
        matrix, d, weight, q0 = scaled(rows, scene, dt)
        other = q0 + matrix.T @ np.maximum(qp_piqp(scene, rows, dt), 0) / weight
        energy = lambda p: 0.5 * (weight * (p - q0)**2).sum()  # noqa: E731
        assert abs(energy(q) - energy(other)) <= 1e-7 * max(energy(other), 1e-3)
        # Strong convexity turns the energies into a distance.
        assert (weight * (q - other)**2).sum() <= 1e-6 * max((weight * q0**2).sum(), 1e-3)


@pytest.mark.parametrize("kind", ["random", "gravity"])
def test_a_dense_packing_against_the_qp_package(kind):
    scene, dt = packing(800, kind, seed=11), 0.01
    answer = project(scene, dt, 1e-10)
    rows, q = check_minimum(scene, answer, dt, 1e-10)
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    press = qp_piqp(scene, rows, dt, 1e-12)
    assert residual(rows, scene, dt, press) < 1e-7
    np.testing.assert_allclose(q, q0 + matrix.T @ np.maximum(press, 0) / weight, atol=1e-6)


def test_a_mixture_of_100_to_1_is_solved():
    rng = np.random.default_rng(4)
    big = np.array([[0.5, 0.5], [1.6, 0.5]])
    small = np.array([[x, y] for x in np.arange(0.005, 2.2, 0.011) for y in np.arange(1.006, 1.05, 0.011)])
    x = np.vstack([big, small + 0.0005 * rng.uniform(-1, 1, small.shape)])
    r = np.r_[0.5, 0.5, np.full(len(small), 0.005)]
    velocity = np.outer(np.ones(len(x)), [0.0, -1.0])
    scene = Scene(x, r, 1000 * np.pi * r**2, velocity, [[0, 0, 2.3, 0]])
    answer = project(scene, 0.01, 1e-11)
    check_minimum(scene, answer, 0.01, 1e-11)


def lattice(across, kind, rough, seed=0, r=0.01):
    """Rows of equal disks that touch all their neighbours but for a share `rough` of r, thrown down into a box or a wedge they
    fill."""
    rng = np.random.default_rng(seed)
    rows = range(across) if kind == "box" else range(4, across + 4)
    x = np.array([[2 * k + m % 2 if kind == "box" else 2 * k - m + 1, 3**0.5 * j] for j, m in enumerate(rows)
        for k in range(across if kind == "box" else m)]) * r
    x += rough * r * rng.standard_normal(x.shape)
    fits = min(r, 0.5 * min(np.hypot(*(x[k + 1:] - x[k]).T).min() for k in range(len(x) - 1)))
    out = np.array([[0, -1], [1, 0], [-1, 0]] if kind == "box" else [[0, -1], [0.75**0.5, -0.5], [-(0.75**0.5), -0.5]])
    walls = [np.r_[p - 10 * e, p + 10 * e] for n in out for p, e in [(((x @ n).max() + fits) * n, np.array([-n[1], n[0]]))]]
    velocity = np.array([0.0, -0.25]) + 0.05 * rng.standard_normal(x.shape)
    return Scene(x, fits * (1 - 1e-12), 1.0, velocity, walls)


@pytest.mark.parametrize("across, kind, rough", [(7, "box", 1e-4), (7, "wedge", 0), (7, "wedge", 1e-10), (14, "box", 1e-8),
    (14, "wedge", 1e-6), (26, "wedge", 1e-4)])
def test_a_lattice_of_equal_disks_costs_few_factorisations(across, kind, rough):
    """Its contacts are redundant, and what they ask for differs by the roughness: active sets alone turned in circles for 200,000
    steps."""
    scene, dt = lattice(across, kind, rough), 0.01
    answer = project(scene, dt, 1e-10)
    rows, q = check_minimum(scene, answer, dt, 1e-10)
    assert answer.figures[0]["factorisations"] < 70 and answer.figures[0]["steps"] < 3000
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    press = np.maximum(qp_piqp(scene, rows, dt, 1e-12), 0)
    np.testing.assert_allclose(q, q0 + matrix.T @ press / weight, atol=1e-8)


@pytest.mark.parametrize("seed", [0, 5])
def test_masses_of_one_to_ten_million_at_thirty_radii_a_step_are_solved(seed):
    """Light disks that heavy ones drive before them: pushes are 1e7 times as long as what they leave, and are known to rounding of
    that. Two or three passes of about 40 factorisations."""
    scene, dt = packing(50, "random", seed, filled=0.5), 0.01
    scene.mass = 10 ** np.random.default_rng(seed).uniform(-3.5, 3.5, 50)
    scene.velocity *= 40.0
    answer = project(scene, dt, 1e-10)
    assert answer.figures[0]["factorisations"] < 160 and answer.figures[0]["residual"] < 1e-7
    rows = constraints(scene, 3 * dt * np.hypot(*answer.velocity.T).max())
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    q = dt / scene.radius.mean() * answer.velocity.ravel()
    other = q0 + matrix.T @ np.maximum(qp_piqp(scene, rows, dt, 1e-10), 0) / weight
    assert (matrix @ q + d).min() > -1e-7
    assert (weight * (q - other)**2).sum() < 1e-12 * (weight * q0**2).sum()


@pytest.mark.parametrize("squeeze", [1e-5, 1e-7])
def test_a_lattice_that_is_squeezed_by_little_is_said_to_have_no_room(squeeze):
    """Its upper row is pushed down by so many radii. Below 1e-5 this was searched for a motion for 200,000 steps, which "did not
    converge"."""
    scene, dt = lattice(5, "box", 0), 0.01
    scene.mass = 10 ** np.random.default_rng(1).uniform(-1.5, 1.5, len(scene.mass))
    top = scene.x[:, 1] > scene.x[:, 1].max() - 0.005
    scene.mass[top], scene.velocity[:] = -1, 0
    scene.velocity[top] = [0, -squeeze]
    rows = constraints(scene, scene.reach(dt) + 1e-6)
    matrix, d, weight, q0 = scaled(rows, scene, dt)
    bounds = [(q, q) if w == np.inf else (None, None) for q, w in zip(q0, weight)]
    least = linprog(np.r_[np.zeros(len(q0)), 1], np.hstack([-matrix.toarray(), -np.ones((len(d), 1))]), d,
        bounds=[*bounds, (None, None)])
    assert least.fun > 0.1 * squeeze  # the least of the largest overlaps, in radii, that any motion leaves
    with pytest.raises(BadInput, match="leave a body no room: no motion satisfies the contacts"):
        project(scene, dt, options={"-contact-maxit": 2000})
