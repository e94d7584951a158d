"""Nesterov's β, and when it starts anew."""

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


def test_beta_while_the_error_falls():
    seen = advance(_kernel.Momentum(), 0.5 ** np.arange(60))
    np.testing.assert_allclose(seen, betas(61), rtol=1e-15)
    assert seen[0] == 0 and 0.94 < seen[-1] < 1


def test_some_growth_is_let_pass_more_starts_anew():
    """Three times the least error of the run is let pass: it comes down again by itself."""
    momentum = _kernel.Momentum()
    assert advance(momentum, [1, 0.5, 1.5])[-1] == pytest.approx(betas(4)[3])
    assert advance(momentum, [1.51])[-1] == 0


def test_less_growth_where_a_run_ends_no_lower_than_the_last():
    """Each run that reaches no new low halves what is let pass, from 2 on; one that does lets 1.2 times as much pass."""
    momentum = _kernel.Momentum()
    starts_anew = lambda error: advance(momentum, [error])[-1] == 0
    assert not starts_anew(1.0) and starts_anew(3.01)  # the first run always has a new low: 1.2 × 2, at most 2
    assert not starts_anew(3.01 * 3) and starts_anew(3.01 * 3.01)  # ended at 3.01, above 1: now 1
    assert not starts_anew(3.01 * 3.01 * 1.99) and starts_anew(3.01 * 3.01 * 2.01)  # above 3.01: now 0.5
    last = 3.01 * 3.01 * 2.01
    assert not starts_anew(last / 100) and not starts_anew(last / 100 * 1.49) and starts_anew(last / 100 * 1.51)  # a new low: 0.6
    assert not starts_anew(last / 100 * 1.51 * 1.59) and starts_anew(last / 100 * 1.51 * 1.61)


def test_never_less_than_a_twentieth():
    momentum, error = _kernel.Momentum(), 1.0
    momentum.advance(error)
    for _ in range(30):
        error *= 4
        momentum.advance(error)
    momentum.advance(error * 1.049)
    assert momentum.beta > 0
    momentum.advance(error * 1.051)
    assert momentum.beta == 0
