"""Closed forms of the stadium against numerical integration and its sampled boundary."""

import numpy as np
import pytest
from rcr import _kernel
from scipy.integrate import quad

DISC, SHORT, LONG, NEEDLE = (0.0, 0.7), (0.3, 0.7), (2.0, 0.5), (1.0, 1e-4)
STADIUMS = [DISC, SHORT, LONG, NEEDLE]
ROUNDING = 1e-14  # a handful of operations on numbers of order 1


def integral(a, r, of_half_height):
    """∫ f(x, y(x)) dx over the stadium, y its half height: a rectangle between two half circles."""
    body = quad(lambda x: of_half_height(x, r), 0, a)[0]
    cap = quad(lambda t: of_half_height(a + r * np.sin(t), r * np.cos(t)) * r * np.cos(t), 0, np.pi / 2)[0]
    return 2 * (body + cap)


def boundary(a, r, angle, n=20000):
    """Points of the boundary, (n, 2)."""
    t = np.linspace(-np.pi, np.pi, n)
    x, y = np.where(np.abs(t) < np.pi / 2, a, -a) + r * np.cos(t), r * np.sin(t)
    return np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)], axis=1)


@pytest.mark.parametrize("a, r", STADIUMS)
def test_area_and_polar_moment_integrate_the_shape(a, r):
    """A = ∫ 2y dx,  ∫ |x|² dA = ∫ (2 x² y + 2 y³/3) dx."""
    tolerance = 1e-12  # quadrature of smooth integrands
    assert _kernel.area(a, r) == pytest.approx(integral(a, r, lambda x, y: 2 * y), rel=tolerance)
    assert _kernel.polar_moment(a, r) == pytest.approx(integral(a, r, lambda x, y: 2 * x**2 * y + 2 * y**3 / 3), rel=tolerance)


def test_disc_limit():
    """a = 0: A = πr², ∫ |x|² dA = πr⁴/2."""
    r = 0.7
    assert _kernel.area(0, r) == pytest.approx(np.pi * r**2, rel=ROUNDING)
    assert _kernel.polar_moment(0, r) == pytest.approx(np.pi * r**4 / 2, rel=ROUNDING)


@pytest.mark.parametrize("r", [1e-3, 1e-6, 1e-9])
def test_needle_limit(r):
    """r → 0: A → 4ar and the polar moment per area → a²/3, each with the next term (π/4)(r/a) and (π/2)(r/a)."""
    a = 1.0
    area, gyration = _kernel.area(a, r), _kernel.polar_moment(a, r) / _kernel.area(a, r)
    tolerance = 3 * r**2 + ROUNDING  # the term after
    assert area / (4 * a * r) == pytest.approx(1 + np.pi / 4 * r / a, abs=tolerance)
    assert gyration / (a**2 / 3) == pytest.approx(1 + np.pi / 2 * r / a, abs=tolerance)


@pytest.mark.parametrize("a, r", STADIUMS)
@pytest.mark.parametrize("angle", [0, 0.3, np.pi / 2, 2.5, -1.1])
def test_bounds_and_support_enclose_the_boundary(a, r, angle):
    """The support point is on the boundary and no point of it lies farther along the direction."""
    points = boundary(a, r, angle)
    sampling = (r * 2 * np.pi / len(points)) ** 2 / r + ROUNDING  # sagitta of one sampling step, generously
    assert _kernel.half_extent(a, r, angle) == pytest.approx(points.max(axis=0), abs=sampling)
    axis = np.array([np.cos(angle), np.sin(angle)])
    for direction in np.linspace(0, 2 * np.pi, 17) + 0.01:
        point, along = np.array(_kernel.support(a, r, angle, direction)), np.array([np.cos(direction), np.sin(direction)])
        assert point @ along == pytest.approx((points @ along).max(), abs=sampling), f"angle {angle}, direction {direction}"
        core = np.clip(point @ axis, -a, a) * axis
        assert np.linalg.norm(point - core) == pytest.approx(r, abs=4 * ROUNDING), f"angle {angle}, direction {direction}"
