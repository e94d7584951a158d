"""Rows of W in batches: colours, islands, rows at rest, rows in any order."""

import numpy as np
import pytest
from kernel.delassus_problems import PROBLEMS, Problem, heap, of, packed
from rcr import _kernel
from scipy.sparse.csgraph import connected_components

TOGETHER = 256  # rows of small islands in one batch
OVERFLOW = 64  # the colour of rows that find none


@pytest.fixture(params=[*PROBLEMS, "large heaps"])
def case(request):
    """A problem, which of its rows share a block, and its batches."""
    problem = packed(*[heap(seed, 90, 150) for seed in range(5)], *[heap(seed, 3, 4) for seed in range(100)]) if request.param == "large heaps" else of(request.param)
    blocks = problem.w.reshape(len(problem.q), 2, -1, 2).any((1, 3))
    np.fill_diagonal(blocks, False)
    return problem, blocks, _kernel.batches(**problem.rows, free=problem.q, friction=problem.friction, impulse=problem.impulse)


def test_rows_of_one_colour_share_no_block(case):
    """Each has the lowest colour that none of its earlier neighbours has; where all are taken it is overflow."""
    _, blocks, found = case
    colors = np.array(found["colors"])
    for k, color in enumerate(colors):
        taken = set(colors[:k][blocks[k, :k]].tolist())
        assert color == next((c for c in range(OVERFLOW) if c not in taken), OVERFLOW), f"row {k}"


def test_a_batch_holds_whole_islands_that_move(case):
    """Each row that is not at rest once; small islands together, ordered by size, as many as fit."""
    problem, blocks, found = case
    island = connected_components(blocks, directed=False)[1]
    moves = np.zeros(island.max() + 1, bool)
    np.logical_or.at(moves, island, (problem.q[:, 0] < 0) | problem.impulse.any(1))
    rows = np.concatenate(found["batches"])
    np.testing.assert_array_equal(np.sort(rows), np.flatnonzero(moves[island]))
    for batch in found["batches"]:
        islands = np.unique(island[batch])
        assert len(batch) == np.isin(island, islands).sum(), "a part of an island"
        assert len(batch) <= TOGETHER or len(islands) == 1
        assert batch == sorted(batch), "rows in the order of the problem"
    if len(found["batches"]) > 1:
        first, second = found["batches"][:2]
        smallest = min(np.bincount(island)[np.unique(island[second])])
        assert len(first) + smallest > TOGETHER, "more would have fitted"


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
