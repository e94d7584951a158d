"""Rows of W in batches: colours, islands, rows at rest, rows in any order."""

import numpy as np
import pytest
from kernel.delassus_problems import PROBLEMS, Problem, heap, of, packed
from rcr import _kernel


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("seed", range(3))
def test_rows_in_any_order(name, seed):
    """What solves the problem with its rows permuted solves the problem."""
    problem = of(name)
    order = np.random.default_rng(seed).permutation(len(problem.q))
    found = problem.permuted(order).solve("exact", tolerance=1e-10, max_iterations=100000)
    p = np.zeros_like(problem.q)
    p[order] = found["impulse"]
    assert problem.residual(p) <= 1e-10 * (1 + 1e-4), f"{name}, order {seed}"


def test_islands_do_not_disturb_each_other():
    """A heap among others ends where it ends alone: without friction the solution is unique where W is positive definite."""
    parts = [heap(seed, 4, 4) for seed in range(30)]
    for part in parts:
        part.friction[:] = 0
        part.w += 0.1 * np.eye(len(part.w))
    parts = [Problem(part.w, part.q, part.friction) for part in parts]
    size = sum(len(part.q) for part in parts)
    order = np.random.default_rng(size).permutation(size)
    found = np.zeros((size, 2))
    found[order] = packed(*parts).solve("nesterov", tolerance=1e-12, max_iterations=10000)["impulse"]
    alone = np.concatenate([part.solve("nlgs", tolerance=1e-12, max_iterations=10000)["impulse"] for part in parts])
    np.testing.assert_allclose(found, alone, rtol=0, atol=1e-9 * abs(alone).max())


def test_what_is_at_rest_needs_no_sweep():
    problem = packed(*[heap(seed, 4, 6, load=-5) for seed in range(20)])
    assert (problem.q[:, 0] >= 0).all()
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["iterations"] == 0 and found["converged"] and found["residual"] == 0
    assert not found["impulse"].any()
    np.testing.assert_array_equal(found["relative_velocity"], problem.q)
    problem.impulse = np.ones_like(problem.q)  # wrong impulses to start from go away
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["converged"] and not found["impulse"].any()


def test_what_nothing_moves_carries_nothing():
    """w_nn = 0, between two prescribed bodies: no impulse, even where it approaches or is told to start with one."""
    w = np.diag([2.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    for start in (np.zeros((3, 2)), np.full((3, 2), 0.1)):
        found = Problem(w, [[-2, -3], [-1, 1], [-1, 2]], [0.5] * 3, start).solve("nesterov", tolerance=1e-12)
        np.testing.assert_allclose(found["impulse"], [[1, 0.5], [0, 0], [0, 0]], rtol=1e-12)
        np.testing.assert_allclose(found["relative_velocity"], [[0, -2.5], [-1, 1], [-1, 2]], atol=1e-12)
