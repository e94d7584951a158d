"""The residual and the kinematic violation: against NumPy at any impulses, zero at solutions, and where they must be blind."""

import numpy as np
import pytest
from kernel.contact_problems import errors, grain, jacobian_times, pile, problem_of, square_discs, velocity, weights
from rcr import _kernel

ROUNDING = 1e-11  # sums of some hundred points


@pytest.mark.parametrize("seed", range(5))
def test_against_numpy_at_any_impulses(seed):
    problem, rng = pile(seed), np.random.default_rng(seed)
    problem["impulse"] = rng.normal(0.05, 0.1, problem["impulse"].shape)  # pulling ones, and outside the cone, too
    p, w, rest = problem["impulse"], weights(problem), 0.01
    error, size = errors(problem, p)
    assert _kernel.residual(**problem) == pytest.approx(np.linalg.norm(error) / size, rel=ROUNDING)
    moves = w > 0
    u = jacobian_times(problem, velocity(problem, p))[moves]
    free = jacobian_times(problem, problem["free_velocity"])[moves]
    for rest in (0.01, 100.0):  # relative to the velocities, or to the free ones
        scale = max(np.linalg.norm(u), rest * np.linalg.norm(free))
        assert _kernel.violation(rest, **problem) == pytest.approx(np.linalg.norm(w[moves] * error[moves]) / scale, rel=ROUNDING), rest


@pytest.mark.parametrize(
    "problem, why",
    [
        (grain((2, 1), v=(0.9, -1)), "slides along +x, against the tangent: p_t = µ p_n"),
        (grain((2, 1), v=(0.4, -1)), "slides no more: the most that friction can do is 0.8"),
        (grain((2, 0.8), v=(0.4, -1)), "sticks"),
        (grain((0, 0), v=(0.4, 1)), "separates"),
        (grain((0, 0), bias=1.0), "does not reach the floor in this step"),
        (grain((1, 0.5), bias=0.5), "stops at the floor, and is not there yet"),
        (grain((3, 1), bias=-0.5, friction=1 / 3), "bounces"),
        (grain((2, 0), friction=0), "has no friction"),
    ],
)
def test_zero_at_closed_forms(problem, why):
    """v⁺ = v + p/m in (n, t) with the normal +y and the tangent −x; residual of the laws 0 or not, as the sentence says."""
    solved = "no more" not in why
    assert (_kernel.residual(**problem) < 1e-15) == solved, why
    assert (_kernel.violation(0.01, **problem) < 1e-15) == solved, why


@pytest.mark.parametrize("p, expected", [((1, 0), 1), ((4, 0), 0.5), ((0, 0), 1e8)])
def test_size_of_an_error(p, expected):
    """A grain at −1 m/s, w_nn = 1/2 kg⁻¹: p_n = 2 stops it, the error is what p_n misses. From nothing the scale is 1e-8 of that."""
    assert _kernel.residual(**grain(p, v=(0, -1), friction=0)) == pytest.approx(expected, rel=1e-14)


def test_points_between_prescribed_bodies_do_not_count():
    problem = grain((1, 0))
    problem["inverse_mass"][:] = 0
    assert _kernel.residual(**problem) == 0 == _kernel.violation(0.01, **problem)


def test_residual_of_an_open_contact_without_friction_or_sliding():
    """u_t = µ = 0 lies on the edge of two faces of the projection; an open contact has no error there."""
    problem = pile(1)
    for key, value in ("friction", 0), ("free_velocity", 0), ("bias", 1):
        problem[key] = np.full_like(problem[key], value)
    result = problem.solve(tolerance=1e-4)
    assert result["residual"] == 0 and result["iterations"] == 0 and not result["impulse"].any()


def test_where_nothing_presses_rounding_is_no_error():
    """A grain that just touches: an approach of 1e-17 of its speed away from the floor is rounding, not an error of 100 %."""
    problem = grain((0, 0), bias=1.0, v=(0.0, -1.0 - 2e-16))
    assert 0 < _kernel.residual(**problem) < 1e-7
    assert _kernel.residual(**grain((0, 0), v=(0.0, -1.0))) > 1e7, "a grain that falls onto the floor is one"


@pytest.mark.parametrize("solver", ["nlgs", "nesterov", "exact"])
@pytest.mark.parametrize("make", [lambda: pile(4), lambda: square_discs(2)])
def test_the_solvers_report_it(make, solver):
    """The packed sums of the sweeps are those of the definition."""
    problem = make()
    result = problem.solve(solver, tolerance=1e-5, max_iterations=77, violation=np.inf)
    problem["impulse"] = result["impulse"]
    assert result["residual"] == pytest.approx(_kernel.residual(**problem), rel=1e-9, abs=1e-15)
    assert result["violation"] == pytest.approx(_kernel.violation(0.01, **problem), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("size", [1e155, 1e200, 1e300])
def test_impulses_whose_squares_overflow_have_no_residual(size):
    """‖p‖² = ∞ would hide every error: their residual is no number. A solver that ends with such ones begins anew from none."""
    problem = pile(1)
    problem["impulse"] = np.full_like(problem["impulse"], size)
    assert np.isnan(_kernel.residual(**problem)) and np.isnan(_kernel.violation(0.01, **problem))
    found = problem.solve("nlgs", tolerance=1e-4, max_iterations=20)
    assert found["residual"] < 0.01 and not found["converged"]


def test_a_scale_that_overflows_hides_no_error():
    """A grain squeezed from both sides by 1e160, which is a solution, beside one that its floor does not hold."""
    squeezed = [(0, 1, 0, side, 0, 0, 0, -0.1, 0, 0) for side in (1, -1)]
    falling = (0, 2, 0, 1, 0, 0, 0, -0.1, 0, 0)
    problem = problem_of("squeezed", None, [[0, 0, 0], [1, 1, 0], [1, 1, 0]], [[0, 0, 0], [0, 0, 0], [0, -1, 0]], [*squeezed, falling])
    problem["impulse"] = np.array([[1e160, 0], [1e160, 0], [0.5, 0]])
    assert np.isnan(_kernel.residual(**problem))
    problem["impulse"][:2] = 1e150, 0
    assert 0 < _kernel.residual(**problem) < 1e-149
