"""Greedy colouring: the lowest colour free at both bodies. Driven bodies take none."""

import numpy as np
import pytest
from rcr import _kernel

OVERFLOW = -1


def random_graph(seed):
    """Which bodies are driven, and pairs."""
    rng = np.random.default_rng(seed)
    bodies = int(rng.integers(2, 60))
    return rng.random(bodies) < 0.1, [rng.choice(bodies, 2, replace=False) for _ in range(200)]


STAR = [(0, k) for k in range(1, 40)]
GRAPHS = {"complete": ([0] * 4, [(0, 1), (2, 3), (1, 2), (0, 3), (0, 2), (1, 3)]),
          "driven": ([1] + [0] * 39, STAR + [pair[::-1] for pair in STAR]),
          "overflow": ([0] * 41, [*STAR, (39, 40)]),
          **{f"seed {seed}": random_graph(seed) for seed in range(20)}}


@pytest.mark.parametrize("driven, pairs", GRAPHS.values(), ids=GRAPHS)
def test_a_pair_takes_the_lowest_colour_that_is_free_at_both(driven, pairs):
    """Driven bodies and overflow pairs take none."""
    coloring, at, taken = _kernel.Coloring(len(driven)), [set() for _ in driven], []
    for a, b in pairs:
        taken.append(coloring.take(int(a), not driven[a], int(b), not driven[b]))
        used = set().union(*(at[body] for body in (a, b) if not driven[body]))
        free = [c for c in range(_kernel.Coloring.colors) if c not in used]
        assert taken[-1] == (free[0] if free else OVERFLOW)
        if free:
            at[a].add(taken[-1]), at[b].add(taken[-1])
    if pairs is GRAPHS["complete"][1]:
        assert taken == [0, 0, 1, 1, 2, 2]
