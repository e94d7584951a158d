"""Exponents of known samples with their errors; densities, means, correlation."""

import numpy as np
import pytest
from rcr import statistics


def power_sample(rng, beta, count, low=0.01):
    """Sample of a density ∝ x^β on [low, 1], by inversion."""
    u = rng.uniform(size=count)
    if beta == -1:
        return low ** (1 - u)
    return (low ** (beta + 1) + u * (1 - low ** (beta + 1))) ** (1 / (beta + 1))


def assert_fits(fits, expected, bias):
    """Means of 200 samples of 500 within 4 errors plus a bias of 1/n; scatter 20 % (4 × 1/√400)."""
    found, errors = np.array(list(fits)).T
    assert found.mean() == pytest.approx(expected, abs=4 * found.std() / np.sqrt(200) + bias)
    assert errors.mean() == pytest.approx(found.std(), rel=0.2)


@pytest.mark.parametrize("beta", [0.1, -0.4, 0.0, -1.0, -1.5, 2.0])
def test_power_exponent_and_its_error(beta):
    rng = np.random.default_rng(1)
    samples = (power_sample(rng, beta, 500) for _ in range(200))
    assert_fits((statistics.power_exponent(x, 0.01) for x in samples), beta, 3 / 500)


def test_exponential_rate_and_its_error_and_ranges():
    """Exponents of both kinds follow from the values in their range only."""
    rng = np.random.default_rng(2)
    for alpha in 0.6, 1.6:
        samples = (1 + rng.exponential(1 / alpha, 500) for _ in range(200))
        assert_fits((statistics.exponential_rate(x) for x in samples), alpha, 3 * alpha / 500)
    x = power_sample(rng, -0.3, 1000)
    more = np.append(x, [1e-9, 0.005, 5, 100])
    assert statistics.power_exponent(more, 0.01) == statistics.power_exponent(x, 0.01)
    tail = 1 + rng.exponential(1, 100)
    more = np.append(tail, [0.1, 1.0])
    assert statistics.exponential_rate(more) == statistics.exponential_rate(tail)
    assert np.isnan(statistics.exponential_rate(np.array([0.5]))).all()
    assert np.isnan(statistics.power_exponent(np.array([0.5]), 0.01)).all()


def test_mean_and_variance_of_the_power_law_join_their_series():
    """m(κ) and −dm/dκ agree with a difference quotient on both sides of the series."""
    for kappa in (1e-4, 9e-4, 1.1e-3, 9e-3, 1.1e-2, 0.5, -3, 40):
        step = 1e-4
        slope = (statistics._mean(kappa + step) - statistics._mean(kappa - step)) / (2 * step)
        assert statistics._variance(kappa) == pytest.approx(-slope, rel=1e-4), kappa


def test_density_class_means_and_correlation():
    """y = c x + √(1 − c²) z has the coefficient c; of n pairs with the error (1 − c²)/√n."""
    x, edges = np.array([0.1, 0.2, 0.6, 5.0]), np.array([0.0, 0.5, 1.0])
    assert statistics.density(x, edges) == pytest.approx([1.0, 0.5])
    x = np.repeat([0.1, 0.6], [statistics.LEAST, statistics.LEAST - 1])
    means = statistics.bin_means(x, 2 * x, edges)
    assert means[0] == pytest.approx(0.2) and np.isnan(means[1])  # too few for a mean
    x, z = np.random.default_rng(4).normal(size=(2, 100_000))
    y = -0.22 * x + np.sqrt(1 - 0.22**2) * z
    assert statistics.pearson(x, y) == pytest.approx(-0.22, abs=4 / np.sqrt(100_000))
    assert np.isnan(statistics.pearson(np.ones(5), x[:5])) and np.isnan(statistics.pearson([], []))
    assert np.isnan(statistics.density(np.zeros(0), edges)).all()
    assert np.isnan(statistics.bin_means(np.zeros(0), np.zeros(0), edges)).all()
    equal = np.full(3, 0.1)  # its mean is 0.10000000000000002
    assert np.isnan(statistics.common_slope([(equal, np.arange(3)), (equal, np.ones(3))])).all()
