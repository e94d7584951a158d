"""Densities, class means, correlation and exponents of samples. Needs NumPy.

Samples are (n,) arrays of finite numbers. Edges of bins rise. Results of too few values are NaN.
"""

import numpy as np

LEAST = 10  # values of a bin, at least, for a mean


def density(x, edges):
    """Return the fraction of x in each bin over the bin width, (bins,) [1/unit of x]."""
    if len(x) == 0:
        return np.full(len(edges) - 1, np.nan)
    return np.histogram(x, edges)[0] / (np.diff(edges) * len(x))


def centres(edges):
    """Return the centre of each bin; (bins,)."""
    return 0.5 * (edges[1:] + edges[:-1])


def bin_means(x, y, edges):
    """Return the mean of y by bins of x; (bins,), NaN for fewer than `LEAST` values."""
    count = np.histogram(x, edges)[0]
    total = np.histogram(x, edges, weights=y)[0]
    return np.where(count >= LEAST, total / np.maximum(count, 1), np.nan)


def pearson(x, y):
    """Return Pearson's coefficient of x and y [-; paper, eq. pearson]; NaN for a constant."""
    if len(x) < 2 or min(np.ptp(x), np.ptp(y)) == 0:
        return np.nan
    return float(np.corrcoef(x, y)[0, 1])


def exponential_rate(x):
    """Return the rate α of a density ∝ e^{−αx} for x > 1, and its standard error α/√n.

    Maximum likelihood: 1/α = ⟨x − 1⟩. Both are NaN if no x is above 1.
    """
    x = x[x > 1]
    if len(x) == 0:
        return np.nan, np.nan
    rate = 1 / np.mean(x - 1)
    return rate, rate / np.sqrt(len(x))


def power_exponent(x, low):
    """Return the exponent β of a density ∝ x^β for low < x < 1, and its standard error.

    Maximum likelihood: u = ln x/ln low in (0, 1) has the density ∝ e^{−κu} with
    κ = −(β + 1) ln low. Its mean m(κ) = 1/κ − 1/(e^κ − 1) falls with κ, so m(κ) = ⟨u⟩ has one root.
    The variance of u is −dm/dκ, that of κ its inverse over n. Both are NaN if fewer than two x lie
    in the range.
    """
    x = x[(x > low) & (x < 1)]
    if len(x) < 2:
        return np.nan, np.nan
    scale = np.log(1 / low)
    kappa = _root_of_mean(np.mean(np.log(1 / x)) / scale)
    return kappa / scale - 1, 1 / (scale * np.sqrt(len(x) * _variance(kappa)))


def common_slope(groups):
    """Return the slope of straight lines through groups (x, y), and its standard error.

    The slope is that of all groups. Both are NaN for too few points or equal x.
    """
    varies = any(np.ptp(x) > 0 for x, _ in groups)  # the mean of equal numbers is rounded
    x, y = (np.concatenate([part - np.mean(part) for part in parts]) for parts in zip(*groups))
    left = len(x) - len(groups) - 1
    if left < 1 or not varies:
        return np.nan, np.nan
    slope = x @ y / (x @ x)
    return slope, np.sqrt(np.sum((y - slope * x) ** 2) / left / (x @ x))


def standard_error(values):
    """Return standard deviations over √(number) of finite values, first axis; NaN for one value."""
    values = np.ma.masked_invalid(np.asarray(values, dtype=float))
    variance = values.var(axis=0, ddof=1) / values.count(axis=0)
    return np.sqrt(np.ma.filled(variance, np.nan))


def mean_of_finite(values):
    """Return the mean of finite values along the first axis; NaN without any."""
    values = np.ma.masked_invalid(np.asarray(values, dtype=float))
    return np.ma.filled(values.mean(axis=0), np.nan)


def _mean(kappa):
    """Return m(κ) = 1/κ − 1/(e^κ − 1), by its series below 1e-3, where the terms cancel."""
    return 0.5 - kappa / 12 if abs(kappa) < 1e-3 else 1 / kappa - 1 / np.expm1(kappa)


def _variance(kappa):
    """Return −dm/dκ = 1/κ² − 1/(4 sinh² κ/2)."""
    if abs(kappa) < 1e-2:
        return 1 / 12 - kappa**2 / 240
    return 1 / kappa**2 - 0.25 / np.sinh(0.5 * kappa) ** 2


def _root_of_mean(mean):
    """Return κ with m(κ) = mean, by bisection in ±500; beyond, u is within 1/500 of an end."""
    low, high = -500.0, 500.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _mean(middle) > mean else (low, middle)
    return 0.5 * (low + high)
