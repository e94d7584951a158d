"""Closed forms of the stadium against numerical integration and its sampled boundary."""

import numpy as np
import pytest
from rcr import _kernel
from scipy.integrate import quad

STADIUMS = [(0.0, 0.7), (0.3, 0.7), (2.0, 0.5), (1.0, 1e-4), (1.0, 1e-9)]  # disc to needle
ROUNDING = 1e-14  # some operations on numbers of order 1


def integral(a, r, f):
    """∫ f(x, y(x)) dx over the stadium with half height y(x): a rectangle and two half circles."""
    body = quad(lambda x: f(x, r), 0, a)[0]
    on_cap = lambda t: f(a + r * np.sin(t), r * np.cos(t)) * r * np.cos(t)
    return 2 * (body + quad(on_cap, 0, np.pi / 2)[0])


def boundary(a, r, angle, n=20000):
    t = np.linspace(-np.pi, np.pi, n)
    x, y = np.where(np.abs(t) < np.pi / 2, a, -a) + r * np.cos(t), r * np.sin(t)
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * x - s * y, s * x + c * y])


@pytest.mark.parametrize("a, r", STADIUMS)
def test_area_polar_moment_and_bounds(a, r):
    """A = ∫ 2y dx,  ∫ |x|² dA = ∫ (2 x² y + 2 y³/3) dx; bounds enclose the boundary."""
    area = integral(a, r, lambda x, y: 2 * y)
    moment = integral(a, r, lambda x, y: 2 * x**2 * y + 2 * y**3 / 3)
    found = _kernel.area(a, r), _kernel.polar_moment(a, r)
    assert found == pytest.approx((area, moment), rel=1e-12)  # quadrature of smooth integrands
    for angle in 0, 0.3, np.pi / 2, 2.5, -1.1:
        points = boundary(a, r, angle)
        # upper bound of the sagitta of one sampling step
        sampling = (r * 2 * np.pi / len(points)) ** 2 / r + ROUNDING
        found = _kernel.half_extent(a, r, angle)
        assert found == pytest.approx(points.max(axis=0), abs=sampling), angle
