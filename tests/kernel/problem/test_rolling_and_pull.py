"""Rolling resistance and pulls: the laws of each point, recomputed with NumPy."""

import numpy as np
import pytest

from ..contact_problems import (EQUAL, LANES_AND_THREADS, assert_same_bits, errors, frictionless,
                                grain, pile, square_discs, velocity)

SOLVERS = "nlgs", "sor", "nesterov", "auto", "exact"


def rolling(problem, friction=0.1, length=1.0):
    """The problem with rolling resistance at points that are alone between their bodies."""
    pair = problem["bodies"]
    alone = np.array([(pair == row).all(1).sum() == 1 for row in pair])
    return problem.copy(f"{problem.name}, rolling", rolling_friction=np.where(alone, friction, 0.0),
                        rolling_length=np.full(len(pair), length),
                        rolling_impulse=np.zeros(len(pair)))


def velocities(problem, impulse, rolled):
    """v_free + M⁻¹ (Jᵀ p + ℓ p_r), (nb, 3)."""
    moment = np.zeros(len(problem["inverse_mass"]))
    np.add.at(moment, problem["bodies"][:, 0], -problem["rolling_length"] * rolled)
    np.add.at(moment, problem["bodies"][:, 1], problem["rolling_length"] * rolled)
    v = velocity(problem, impulse)
    v[:, 2] += problem["inverse_mass"][:, 2] * moment
    return v


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("make", [lambda: square_discs(1, side=4), lambda: pile(2)])
def test_laws_hold(solver, make):
    problem = rolling(make())
    result = problem.solve(solver, tolerance=1e-9, max_iterations=100_000)
    assert result["converged"]
    p, rolled = result["impulse"], result["rolling_impulse"]
    v = velocities(problem, p, rolled)
    np.testing.assert_allclose(result["velocity"], v, atol=1e-12)
    a, b = problem["bodies"].T
    turning = problem["rolling_length"] * (v[b, 2] - v[a, 2])
    most = problem["rolling_friction"] * p[:, 0]
    size = np.linalg.norm(p)
    assert (abs(rolled) <= most + 1e-12 * size).all()
    inverse = problem["inverse_mass"][:, 2]
    response = problem["rolling_length"] ** 2 * (inverse[a] + inverse[b])
    turns = (abs(turning) > 1e-7 * size * response) & (most > 1e-7 * size)
    np.testing.assert_allclose(rolled[turns], -(np.sign(turning) * most)[turns], atol=1e-7 * size)
    # points that turn and points that stick both occur
    assert turns.any() and (abs(rolled) < 0.99 * most).any()
    # the rest of the laws: those of a problem whose free velocity contains the moments
    moved = problem.copy("moved", free_velocity=problem["free_velocity"] + v - velocity(problem, p))
    miss, _ = errors(moved, p)
    assert np.linalg.norm(miss) <= 1e-8 * size


@pytest.mark.parametrize("solver", ["nlgs", "nesterov"])
def test_lanes_and_threads_change_no_bit(solver):
    problem = rolling(square_discs(3, side=60))
    solve = lambda lanes, threads: problem.solve(solver, lanes=lanes, threads=threads,
                                                 tolerance=0, max_iterations=40)
    first = solve(*LANES_AND_THREADS[0])
    assert np.abs(first["rolling_impulse"]).max() > 0
    for lanes, threads in LANES_AND_THREADS[1:]:
        assert_same_bits(solve(lanes, threads), first, f"{lanes}, {threads}",
                         (*EQUAL, "rolling_impulse"))


def test_resistance_is_warm_started():
    problem = rolling(square_discs(4, side=20))
    cold = problem.solve("nesterov", tolerance=1e-9, max_iterations=20_000)
    warm = problem.copy("warm", impulse=cold["impulse"], rolling_impulse=cold["rolling_impulse"])
    assert warm.solve("nesterov", tolerance=1e-8)["iterations"] <= 10 < cold["iterations"]


@pytest.mark.parametrize("friction", [0, 0.02, 0.3, 5])
def test_exact_iterations_reach_rounding(friction):
    """In fewer iterations than sweeps alone."""
    problem = rolling(square_discs(8, side=10), friction)
    exact, swept = (problem.solve(solver, tolerance=1e-13, max_iterations=20_000)
                    for solver in ("exact", "nesterov"))
    assert exact["converged"] and exact["residual"] <= 1e-13
    assert exact["iterations"] < swept["iterations"]
    assert abs(exact["rolling_impulse"]).max() > 0 or friction == 0


@pytest.mark.parametrize("changes, match", [
    (dict(pull=-1.0), "the pull is negative"),
    (dict(rolling_friction=-0.1, rolling_length=1.0), "rolling friction is outside"),
    (dict(rolling_friction=0.1), "needs a rolling length > 0"),
    (dict(rolling_friction=np.nan, rolling_length=1.0), "not finite"),
])
def test_wrong_coefficients_are_refused(changes, match):
    problem = grain((0.0, 0.0))
    count = len(problem["impulse"])
    with pytest.raises(ValueError, match=match):
        problem.copy("wrong", **{k: np.full(count, v) for k, v in changes.items()}).solve()


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("make", [lambda: square_discs(5, side=5), lambda: frictionless(pile(6))])
def test_a_pull_lowers_the_free_velocity(solver, make):
    """p + c solves the problem whose free velocity contains −c n."""
    problem = make()
    pull = np.random.default_rng(1).uniform(0, 0.1, len(problem["impulse"]))
    pulls = np.stack([pull, 0 * pull], 1)
    settings = dict(solver=solver, tolerance=1e-9, max_iterations=20_000)
    result = problem.copy("pulled", pull=pull).solve(**settings)
    other = problem.copy("by hand", free_velocity=velocity(problem, -pulls),
                         impulse=problem["impulse"] + pulls).solve(**settings)
    assert result["converged"] and other["converged"]
    scale = np.linalg.norm(other["impulse"])
    np.testing.assert_allclose(result["impulse"] + pulls, other["impulse"], atol=1e-6 * scale)
    np.testing.assert_allclose(result["velocity"], other["velocity"], atol=1e-6)
    assert (result["impulse"][:, 0] < 0).any()
