"""Residual against NumPy, at closed forms, and at its limits."""

import numpy as np
import pytest
from kernel.contact_problems import errors, grain, pile, problem_of_rows, square_discs
from rcr import _kernel

ROUNDING = 1e-11  # sums of some hundred points


@pytest.mark.parametrize("seed", range(5))
def test_residual_equals_numpy_at_any_impulses(seed):
    problem, rng = pile(seed), np.random.default_rng(seed)
    # includes pulling impulses, and impulses outside the cone
    problem["impulse"] = rng.normal(0.05, 0.1, problem["impulse"].shape)
    error, size = errors(problem, problem["impulse"])
    assert _kernel.residual(**problem) == pytest.approx(np.linalg.norm(error) / size, rel=ROUNDING)


@pytest.mark.parametrize("problem, state", [
    (grain((2, 1), v=(0.9, -1)), "slides along +x, against the tangent: p_t = µ p_n"),
    (grain((2, 1), v=(0.4, -1)), "no solution: friction of 0.8 suffices to stick"),
    (grain((2, 0.8), v=(0.4, -1)), "sticks"),
    (grain((0, 0), v=(0.4, 1)), "separates"),
    (grain((0, 0), bias=1.0), "stays open in this step"),
    (grain((1, 0.5), bias=0.5), "closes its gap and stops"),
    (grain((3, 1), bias=-0.5, friction=1 / 3), "bounces"),
    (grain((2, 0), friction=0), "has no friction"),
    (grain((1, 0)).copy("held", inverse_mass=np.zeros((2, 3))), "is prescribed, as the floor"),
])
def test_zero_at_closed_forms(problem, state):
    """v⁺ = v + p/m in (n, t), with the normal +y and the tangent −x."""
    solved = "no solution" not in state
    assert (_kernel.residual(**problem) < 1e-15) == solved, state


@pytest.mark.parametrize("p, expected", [((1, 0), 1), ((4, 0), 0.5), ((0, 0), 1e8)])
def test_size_of_an_error(p, expected):
    """A grain at −1 m/s with w_nn = 1/2 kg⁻¹: the error is p_n − 2. For p = 0 its scale is 2e-8."""
    assert _kernel.residual(**grain(p, v=(0, -1), friction=0)) == pytest.approx(expected, rel=1e-14)


def test_open_contact_without_friction_has_no_error():
    """u_t = µ = 0 lies on the edge between two cases of the projection."""
    problem = pile(1)
    for key, value in ("friction", 0), ("free_velocity", 0), ("bias", 1):
        problem[key] = np.full_like(problem[key], value)
    result = problem.solve(tolerance=1e-4)
    assert result["residual"] == 0 and result["iterations"] == 0 and not result["impulse"].any()
    # a grain that just touches closes at 1e-16 of its speed: rounding, not an error of 100 %
    assert 0 < _kernel.residual(**grain((0, 0), bias=1.0, v=(0.0, -1.0 - 2e-16))) < 1e-7
    assert _kernel.residual(**grain((0, 0), v=(0.0, -1.0))) > 1e7


@pytest.mark.parametrize("make", [lambda: pile(4), lambda: square_discs(2)])
def test_solvers_report_this_residual(make, solver):
    """The packed sums of the sweeps agree with the definition."""
    problem = make()
    result = problem.solve(solver, tolerance=1e-5, max_iterations=77, accuracy=np.inf)
    problem["impulse"] = result["impulse"]
    assert result["residual"] == pytest.approx(_kernel.residual(**problem), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("size", [1e155, 1e200, 1e300])
def test_overflowing_impulses_have_a_nan_residual(size):
    """‖p‖² = ∞ would hide every error. Solvers then start again from zero impulses."""
    problem = pile(1)
    problem["impulse"] = np.full_like(problem["impulse"], size)
    assert np.isnan(_kernel.residual(**problem))
    found = problem.solve("nlgs", tolerance=1e-4, max_iterations=20)
    assert found["residual"] < 0.01 and not found["converged"]


def test_overflowing_scale_hides_no_error():
    """A grain squeezed from both sides by 1e160, a solution, beside a grain with an error."""
    squeezed = [(0, 1, 0, side, 0, 0, 0, -0.1, 0, 0) for side in (1, -1)]
    falling = (0, 2, 0, 1, 0, 0, 0, -0.1, 0, 0)
    inverse_mass = [[0, 0, 0], [1, 1, 0], [1, 1, 0]]
    velocity = [[0, 0, 0], [0, 0, 0], [0, -1, 0]]
    problem = problem_of_rows("squeezed", inverse_mass, velocity, [*squeezed, falling])
    problem["impulse"] = np.array([[1e160, 0], [1e160, 0], [0.5, 0]])
    assert np.isnan(_kernel.residual(**problem))
    problem["impulse"][:2] = 1e150, 0
    assert 0 < _kernel.residual(**problem) < 1e-149
