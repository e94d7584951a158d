"""The elimination order: a permutation with little fill."""

import pytest
from kernel.graphs import grid, star
from rcr import _kernel


def fill(size, pairs, order):
    """Off-diagonal entries of the factor: eliminate node by node."""
    neighbours = [set() for _ in range(size)]
    for i, j in pairs:
        neighbours[i].add(j), neighbours[j].add(i)
    entries = 0
    for k in order:
        entries += len(neighbours[k])
        for i in neighbours[k]:
            neighbours[i] |= neighbours[k]
            neighbours[i] -= {i, k}
    return entries


@pytest.mark.parametrize("size, pairs", [star(30), (40, [(i, i + 1) for i in range(39)]), (31, [((k - 1) // 2, k) for k in range(1, 31)])])
def test_order_of_a_tree_has_no_fill(size, pairs):
    order = _kernel.minimum_degree_order(size, pairs)
    assert sorted(order) == list(range(size))
    assert fill(size, pairs, order) == len(pairs)


def test_order_of_a_grid_has_little_fill():
    """20 × 20: the natural order gives about n^1.5 = 8000 entries, AMD of SuiteSparse 3302."""
    size, pairs = grid(20, 20)
    order = _kernel.minimum_degree_order(size, pairs)
    assert sorted(order) == list(range(size))
    assert fill(size, pairs, order) < 3500 < 7000 < fill(size, pairs, range(size))
