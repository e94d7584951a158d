"""Sparse LU of 3×3 blocks against dense LU."""

import numpy as np
import pytest
from common import refused
from rcr import _kernel


def grid(rows, columns):
    at = lambda i, j: i * columns + j
    across = [(at(i, j), at(i, j + 1)) for i in range(rows) for j in range(columns - 1)]
    up = [(at(i + 1, j), at(i, j)) for i in range(rows - 1) for j in range(columns)]
    return rows * columns, across + up


GRAPHS = {"one row": (1, []), "two rows": (2, [(1, 0)]), "diagonal": (7, []),
          "star": (31, [(0, k) for k in range(1, 31)]), "grid": grid(9, 13),
          "chain": (40, [(i, i + 1) for i in range(39)]),
          "full": (12, [(i, j) for i in range(12) for j in range(i)])}


@pytest.mark.parametrize("size, pairs", GRAPHS.values(), ids=GRAPHS)
def test_block_lu_solves_like_a_dense_one(size, pairs):
    """Rows in order and shuffled, each pair in either order, b full and with one number."""
    rng = np.random.default_rng(size)
    block = lambda i, j: (slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3))
    for row in (np.arange(size), rng.permutation(size)):
        pairs = [(row[i], row[j])[:: rng.choice([-1, 1])] for i, j in pairs]
        dense = np.zeros((3 * size, 3 * size))
        for i in range(size):
            dense[block(i, i)] = rng.normal(0, 1, (3, 3)) + 8 * np.eye(3)
        for i, j in pairs:
            dense[block(i, j)], dense[block(j, i)] = rng.normal(0, 1, (2, 3, 3))
        stack = lambda places: np.array([dense[block(i, j)] for i, j in places]).reshape(-1, 3, 3)
        for b in (rng.normal(0, 1, (size, 3)), np.eye(1, 3 * size, 3 * size // 2).reshape(-1, 3)):
            x = _kernel.solve_blocks(pairs, stack([(i, i) for i in range(size)]), stack(pairs),
                                     stack([(j, i) for i, j in pairs]), b)
            # heavy diagonals: stable without pivoting across blocks
            np.testing.assert_allclose(x.ravel(), np.linalg.solve(dense, b.ravel()), rtol=0,
                                       atol=1e-13)


@pytest.mark.parametrize("small", [0.0, 1e-12])
def test_a_block_may_have_a_zero_diagonal(small):
    """Rows are exchanged within a block: a pivot of 1e-12 would leave four digits."""
    block = np.array([[small, 2.0, 1.0], [1.0, small, 3.0], [4.0, 1.0, small]])
    b, none = np.array([[1.0, 2.0, 3.0]]), np.zeros((0, 3, 3))
    x = _kernel.solve_blocks([], block[None], none, none, b)
    np.testing.assert_allclose(block @ x[0], b[0], rtol=0, atol=1e-14)


def test_refuses_a_singular_matrix():
    blocks = np.eye(3)[None]
    refused("singular", _kernel.solve_blocks, [(0, 1)], np.zeros((2, 3, 3)), blocks, blocks,
            np.ones((2, 3)))
