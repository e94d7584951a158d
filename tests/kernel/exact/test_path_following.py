"""One proximal step: its end satisfies the softened law; a fold stops it.

    the contact law between p and u + (p − p_ref)/k,  k = ρ/w_nn:  p = law(p_ref − k u)

The tests recompute u with NumPy.
"""

import numpy as np
import pytest
from kernel.contact_problems import (dense, grain, jacobian_times, pile, problem_of_rows,
                                     square_discs, stored, velocity, wall_of_bricks, weights)
from rcr import _kernel

MANY = 5000  # pivots


def softened_error(problem, p, rho):
    """Largest error of the softened law over the largest impulse [-]."""
    w = weights(problem)
    moves = w > 0
    k = np.where(moves, rho / np.where(moves, w, 1), 0)
    u = jacobian_times(problem, velocity(problem, p))
    u[:, 0] += problem["bias"]
    predictor = problem["impulse"] - k[:, None] * u
    n = np.maximum(predictor[:, 0], 0)  # the law projects onto the cone at constant n
    t = np.clip(predictor[:, 1], -problem["friction"] * n, problem["friction"] * n)
    error = (p - np.column_stack([n, t]))[moves]
    return abs(error).max() / max(abs(p).max(), 1e-300)


@pytest.mark.parametrize("rho", [1e-2, 1.0, 1e3])
@pytest.mark.parametrize("v, friction, slides", [
    ((0.3, -1.0), 0.5, False), ((3.0, -1.0), 0.5, True), ((-3.0, -1.0), 0.5, True),
    ((3.0, -1.0), 0.0, True),
])
def test_one_grain(rho, v, friction, slides):
    """w_nn = w_tt = w, no coupling: p_n = −u_n k/(1 + k w), p_t likewise or µ p_n; k = ρ/w."""
    mass = 2.0
    stop = mass * rho / (1 + rho)
    expected = [-v[1] * stop, v[0] * stop]  # u_t = −v_x
    limit = friction * expected[0]
    assert (abs(expected[1]) > limit) == slides
    expected[1] = np.clip(expected[1], -limit, limit)
    end = _kernel.follow_path(rho, MANY, **grain((0, 0), v=v, friction=friction, mass=mass))
    assert end["complete"] and end["unstable"] == []
    np.testing.assert_allclose(end["impulse"], [expected], rtol=1e-15 * (1 + rho))  # of p_ref − k u


def test_no_pivot_if_nothing_changes():
    for p, v in ((2, 1), (0.9, -1)), ((2, 0.8), (0.4, -1)), ((0, 0), (0.4, 1)):
        problem = grain(p, v=v)
        end = _kernel.follow_path(1e3, MANY, **problem)
        assert end["complete"] and end["pivots"] == 0
        np.testing.assert_allclose(end["impulse"], problem["impulse"], rtol=0, atol=1e-14)


@pytest.mark.parametrize("make", [
    pytest.param(lambda: pile(1), id="pile 1"),
    pytest.param(lambda: pile(2, 20, 12), id="pile 2"),
    pytest.param(lambda: wall_of_bricks(1), id="bricks"),
    pytest.param(lambda: square_discs(1), id="discs"),
    pytest.param(lambda: stored("shear-500-eta-0.7"), id="500 eta 0.7"),
])
@pytest.mark.parametrize("rho", [0.1, 10.0])
def test_the_softened_law_holds_at_the_end(make, rho):
    """Steps from zero, from the last solution and from random impulses in their cones."""
    problem, rng = make(), np.random.default_rng(0)
    count = len(problem["impulse"])
    n = rng.exponential(0.05, count) * (rng.random(count) < 0.6)
    t = problem["friction"] * n * np.clip(rng.normal(0, 1, count), -1, 1)
    arrived = 0
    for start in np.zeros((count, 2)), np.column_stack([n, t]):
        problem["impulse"] = start
        for _ in range(3):
            end = _kernel.follow_path(rho, MANY, **problem)
            if not end["complete"]:
                assert end["unstable"] or end["pivots"] == MANY
                break
            arrived += 1
            # rounding of some hundred pivots accumulates
            assert softened_error(problem, end["impulse"], rho) < 1e-9, f"{end['pivots']} pivots"
            problem["impulse"] = end["impulse"]
    assert arrived >= 3, "too few complete paths"


def test_soft_steps_converge_to_the_solution():
    problem = square_discs(3)
    for _ in range(200):
        end = _kernel.follow_path(1e3, MANY, **problem)
        assert end["complete"]
        problem["impulse"] = end["impulse"]
    assert _kernel.residual(**problem) < 1e-10


def test_pivots_are_counted_and_limited():
    problem = pile(2, 20, 12)
    whole = _kernel.follow_path(1.0, MANY, **problem)
    assert whole["complete"] and whole["pivots"] > 50
    for most in (0, 1, 19, 20, 21, 40):  # a new factorisation after every twenty
        end = _kernel.follow_path(1.0, most, **problem)
        assert not end["complete"] and end["pivots"] == most and end["unstable"] == []
    last = _kernel.follow_path(1.0, whole["pivots"], **problem)
    np.testing.assert_array_equal(last["impulse"], whole["impulse"])


def test_a_rod_beyond_painleve():
    """A steep, rough rod slides on its lower end: w_nn − µ |w_nt| < 0.

    A soft law has one solution; a stiff one pulls the rod into the floor: the path stops.
    """
    arm = -0.5 * np.array([np.cos(np.pi / 3), np.sin(np.pi / 3)])
    problem = problem_of_rows("rod", [[0, 0, 0], [1, 1, 12]], [[0, 0, 0], [-1, -1e-3, 0]],
                              [(0, 1, 0, 1, 0, 0, *arm, 0, 2.0)])
    (w_nn, w_nt), _ = dense(problem)[0]
    assert w_nn < 2.0 * abs(w_nt), "no paradox"
    soft, stiff = (_kernel.follow_path(rho, MANY, **problem) for rho in (0.01, 1e3))
    assert soft["complete"] and softened_error(problem, soft["impulse"], 0.01) < 1e-12
    assert not stiff["complete"] and stiff["pivots"] == 0


def test_a_fold_lists_the_unstable_contacts():
    """Stiff steps from zero in rough piles and brick walls: some fold in a finite state."""
    folded = 0
    for problem in [pile(seed) for seed in range(4)] + [wall_of_bricks(seed) for seed in range(4)]:
        problem["friction"] = np.full_like(problem["friction"], 0.9)
        end = _kernel.follow_path(1e6, MANY, **problem)
        assert np.isfinite(end["impulse"]).all()
        if not end["complete"] and end["unstable"]:
            folded += 1
            assert end["unstable"] == sorted(set(end["unstable"]))
            assert len(end["unstable"]) < len(problem["bodies"])
    assert folded > 0, "no path folds"
