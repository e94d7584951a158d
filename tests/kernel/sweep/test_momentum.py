"""Nesterov's β and its restart."""

import numpy as np
import pytest
from rcr import _kernel


def betas(count):
    """β_k = (τ_k − 1)/τ_{k+1},  τ_{k+1} = (1 + √(1 + 4 τ_k²))/2,  τ_0 = 1."""
    tau = [1.0]
    for _ in range(count):
        tau.append((1 + np.sqrt(1 + 4 * tau[-1] ** 2)) / 2)
    return [(tau[k] - 1) / tau[k + 1] for k in range(count)]


def advance(momentum, errors):
    seen = []
    for error in errors:
        seen.append(momentum.beta)
        momentum.advance(error)
    return [*seen, momentum.beta]


def test_beta_while_the_error_falls_and_its_restart():
    """An error of three times the minimum of the run is allowed, more restarts."""
    seen = advance(_kernel.Momentum(), 0.5 ** np.arange(60))
    np.testing.assert_allclose(seen, betas(61), rtol=1e-15)
    assert seen[0] == 0 and 0.94 < seen[-1] < 1
    momentum = _kernel.Momentum()
    assert advance(momentum, [1, 0.5, 1.5])[-1] == pytest.approx(betas(4)[3])
    assert advance(momentum, [1.51])[-1] == 0


def test_allowed_growth_halves_without_a_new_minimum():
    """Down to a twentieth; a run with a new minimum raises it by 1.2, at most to 2."""
    momentum, last = _kernel.Momentum(), 1.0
    restarts = lambda error: advance(momentum, [error])[-1] == 0
    for first, growth in (1, 2), (1, 2), (1, 1), (0.01, 0.5), (1, 0.6):  # first error of a run
        last *= first
        assert not restarts(last) and not restarts(last * (1 + growth - 0.01)), growth
        last *= 1 + growth + 0.01
        assert restarts(last), growth
    for _ in range(30):
        last *= 4
        momentum.advance(last)
    assert not restarts(last * 1.049) and restarts(last * 1.051)
