"""Yielding of driven scenes (yield_bounds.hpp): compliance V m̄/(P + 10 L) and yield impulse
3 P + 200 L.

P = r/N Σ m (V + |v_free|), L = r/N Σ m |v_free − v⁻|; r = N in a row.
"""

import numpy as np
import pytest
from kernel.contact_problems import problem_of
from rcr import _kernel

V, G = 0.2, 9.81


def scale(masses, before, free, wall=(0.0, V, 0.0), inverse=None, below=None):
    """Return the bounds of a row of bodies above a moving wall; each touches the one below it."""
    inverse = np.array([[1 / m, 1 / m, 10 / m] for m in masses]) if inverse is None else inverse
    points = np.arange(len(masses))
    below = points if below is None else below
    problem = problem_of("row", np.vstack([np.zeros(3), inverse]), np.vstack([wall, free]),
                         np.stack([below, points + 1], axis=1), normal=(0, 1), friction=0.5)
    return _kernel.yield_bounds(np.vstack([wall, before]), **problem)


def test_closed_form():
    masses, dt = [1.0, 3.0], 1e-3
    before = np.array([[0.3, 0.4, 7.0], [0, 0, 0]])
    free = before - [0, G * dt, 0]
    speed, compliance, most = scale(masses, before, free)
    momentum, load = 1 * (V + np.hypot(0.3, 0.4 - G * dt)) + 3 * (V + G * dt), 4 * G * dt
    assert speed == V
    expected = [V * 2.0 / (momentum + 10 * load), 3 * momentum + 200 * load]
    np.testing.assert_allclose([compliance, most], expected, rtol=1e-14)
    at_rest = scale([1.0], np.ones((1, 3)), np.ones((1, 3)), wall=(0.0, 0, 0))
    assert at_rest == (0, 0.01, np.inf)  # no drive


def test_turning_obstacles_drive_by_the_speed_of_their_points():
    problem = problem_of("drum", [[0, 0, 0], [1, 1, 1]], [[0, 0, 0.5], [0, 0, 0]], [[0, 1]],
                         normal=(0, 1), arm1=(2, 0))
    speed, _, _ = _kernel.yield_bounds(np.zeros((2, 3)), **problem)
    assert speed == 1.0


@pytest.mark.parametrize("sideways, fastest", [(0.0, V), (5.0, 5.0)])
def test_partly_blocked_bodies_drive_without_momentum(sideways, fastest):
    """A body with a prescribed v_x, free along y: v_x is a drive, and only v_y has momentum."""
    body = np.array([[0.0, 0.5, 0.0]])
    before, free = np.array([[sideways, 0, 0]]), np.array([[sideways, 0.1, 0]])
    speed, _, most = scale([2.0], before, free, inverse=body)
    assert speed == fastest
    np.testing.assert_allclose(most, 2.0 * (3 * (fastest + 0.1) + 200 * 0.1))


def test_a_hinged_body_counts_as_a_mass_at_a_tenth_of_its_radius():
    """Disc of radius 2 m and I = 4 kg m² that turns at 0.5 rad/s: 4/(0.1 · 2)² kg, 0.1 m/s."""
    problem = problem_of("hinged body", [[0, 0, 0], [0, 0, 1 / 4]], [[0, V, 0], [0, 0, 0.5]],
                         [[0, 1]], normal=(0, 1), arm2=(0, -2))
    _, compliance, most = _kernel.yield_bounds(np.array([[0, V, 0], [0, 0, 0.5]]), **problem)
    mass = 4 / 0.2**2
    np.testing.assert_allclose([compliance, most], [V / (V + 0.1), 3 * mass * (V + 0.1)])


def test_a_row_that_is_struck_at_its_end_stays_rigid():
    """The impulse of the first contact is N m V: below the bound, however long the row.

    A drive reaches √N bodies of a packing.
    """
    for count in 10, 100, 1000:
        rest = np.zeros((count, 3))
        np.testing.assert_allclose(scale([2.0] * count, rest, rest)[2], 3 * count * 2.0 * V)
    most = scale([1.0] * 25, rest[:25], rest[:25], below=np.zeros(25))[2]
    np.testing.assert_allclose(most, 3 * 5 * V)
