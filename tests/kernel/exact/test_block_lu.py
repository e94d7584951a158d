"""Sparse LU of 3×3 blocks against a dense one."""

import numpy as np
import pytest
from kernel.graphs import grid, star
from rcr import _kernel


@pytest.mark.parametrize(
    "size, pairs",
    [(1, []), (2, [(1, 0)]), (7, []), star(30), grid(9, 13), (40, [(i, i + 1) for i in range(39)]), (12, [(i, j) for i in range(12) for j in range(i)])],
    ids=["one row", "two rows", "diagonal", "star", "grid", "chain", "full"],
)
def test_block_lu_solves_like_a_dense_one(size, pairs):
    rng = np.random.default_rng(size)
    dense = np.zeros((3 * size, 3 * size))
    block = lambda i, j: (slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3))
    for i in range(size):
        dense[block(i, i)] = rng.normal(0, 1, (3, 3)) + 8 * np.eye(3)
    for i, j in pairs:
        dense[block(i, j)], dense[block(j, i)] = rng.normal(0, 1, (2, 3, 3))
    stack = lambda places: np.array([dense[block(i, j)] for i, j in places]).reshape(-1, 3, 3)
    b = rng.normal(0, 1, (size, 3))
    x = _kernel.solve_blocks(
        np.array(pairs, np.int32).reshape(-1, 2), stack([(i, i) for i in range(size)]), stack(pairs), stack([(j, i) for i, j in pairs]), b
    )
    # backward stable without pivoting across blocks, the diagonal being heavy
    np.testing.assert_allclose(x.ravel(), np.linalg.solve(dense, b.ravel()), rtol=0, atol=1e-12 * np.linalg.cond(dense))


def test_block_lu_says_that_a_block_is_singular():
    with pytest.raises(ValueError, match="singular"):
        _kernel.solve_blocks(np.zeros((0, 2), np.int32), np.zeros((2, 3, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3, 3)), np.ones((2, 3)))
