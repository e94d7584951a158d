"""Greedy colouring: the lowest colour free at both bodies. Driven bodies take none."""

import numpy as np
from rcr import _kernel

OVERFLOW = -1


def test_lowest_colour_that_is_free_at_both():
    """The complete graph of four bodies needs three."""
    coloring, pairs = _kernel.Coloring(4), [(0, 1), (2, 3), (1, 2), (0, 3), (0, 2), (1, 3)]
    assert [coloring.take(a, True, b, True) for a, b in pairs] == [0, 0, 1, 1, 2, 2]


def test_a_driven_body_takes_no_colour():
    coloring = _kernel.Coloring(40)
    assert [coloring.take(0, False, k, True) for k in range(1, 40)] == [0] * 39
    assert [coloring.take(k, True, 0, False) for k in range(1, 40)] == [1] * 39


def test_overflow_of_a_body_with_many_contacts():
    coloring, most = _kernel.Coloring(40), _kernel.Coloring.colors
    taken = [coloring.take(0, True, k, True) for k in range(1, 30)]
    assert taken == [*range(most), *[OVERFLOW] * (29 - most)]
    assert coloring.take(29, True, 30, True) == 0, "overflow pairs take no colour"


def test_random_graphs():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        bodies = int(rng.integers(2, 60))
        fixed = rng.random(bodies) < 0.1
        coloring, at = _kernel.Coloring(bodies), [set() for _ in range(bodies)]
        for _ in range(200):
            a, b = rng.choice(bodies, 2, replace=False)
            color = coloring.take(int(a), not fixed[a], int(b), not fixed[b])
            used = (set() if fixed[a] else at[a]) | (set() if fixed[b] else at[b])
            free = [c for c in range(_kernel.Coloring.colors) if c not in used]
            assert color == (free[0] if free else OVERFLOW), f"seed {seed}"
            if color != OVERFLOW:
                at[a].add(color), at[b].add(color)
