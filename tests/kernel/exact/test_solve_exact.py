"""The exact solver: residuals of 1e-10 where sweeps stall, equal bits, honest reports.

Residuals are recomputed with NumPy from the impulses alone.
"""

import numpy as np
import pytest
from kernel.contact_problems import (PROBLEMS, ROUNDING, assert_lanes_and_threads_change_no_bit,
                                     assert_solved, errors, frictionless, jammed_box, pile,
                                     problem_of_rows, stored, velocity, wall_of_bricks)


@pytest.mark.parametrize("make", [
    *PROBLEMS,
    pytest.param(lambda: pile(4, 20, 20), id="pile 4"),
    pytest.param(lambda: wall_of_bricks(1), id="bricks 1"),
    pytest.param(lambda: wall_of_bricks(2, 15, 20), id="bricks 2"),
    pytest.param(lambda: wall_of_bricks(3, tilt=0), id="bricks parallel"),
    pytest.param(lambda: jammed_box(1), id="jammed box"),
])
def test_reaches_1e_10_from_cold_and_warm_starts(make):
    problem = make()
    for start in (problem.cold(), problem) if problem["impulse"].any() else (problem, ):
        assert_solved(start, "exact", 1e-10)


def test_every_run_gives_the_same_bits():
    choices = [(0, 1), (1, 1), (4, 1), (0, 2)]  # 0: all lanes of the processor
    assert_lanes_and_threads_change_no_bit(pile(2, 30, 12), "exact", choices, tolerance=1e-8,
                                           max_iterations=20_000)


@pytest.mark.parametrize("make", [lambda: pile(3), lambda: wall_of_bricks(4)])
def test_reaches_1e_10_without_friction(make):
    assert not assert_solved(frictionless(make()), "exact", 1e-10)["impulse"][:, 1].any()


def test_resultant_of_an_indeterminate_support_is_the_weight():
    """A beam falls at 1 m/s onto five points: Σ p_n = m v, Σ x p_n = 0, no sliding."""
    mass = 3.0
    points = [(0, 1, 0, 1, 0, 0, x, -0.1, 0, 0.5) for x in (-2.0, -1.0, 0.0, 0.5, 2.0)]
    inverse_mass = [[0, 0, 0], [1 / mass, 1 / mass, 0.2]]
    problem = problem_of_rows("beam", inverse_mass, [[0, 0, 0], [0, -1, 0]], points)
    result = assert_solved(problem, "exact", 1e-12)
    p = result["impulse"]
    assert p[:, 0].sum() == pytest.approx(mass, rel=1e-11)
    assert (p[:, 0] * problem["arm2"][:, 0]).sum() == pytest.approx(0, abs=1e-11)
    np.testing.assert_allclose(result["velocity"][1], 0, atol=1e-11)


@pytest.mark.parametrize("budget", [1, 7, 50, 200, 300])
def test_reports_an_early_stop_honestly(budget):
    """The reported residual is that of the result, and no worse than that of the first sweeps."""
    problem = pile(4, 20, 20)
    swept = problem.solve("nesterov", tolerance=1e-5, max_iterations=(budget + 1) // 2)
    result = problem.solve("exact", tolerance=0, max_iterations=budget)
    error, size = errors(problem, result["impulse"])
    assert not result["converged"] and result["iterations"] == budget
    assert abs(np.linalg.norm(error) / size - result["residual"]) <= ROUNDING
    assert result["residual"] <= swept["residual"] * (1 + 1e-9)
    expected = velocity(problem, result["impulse"])
    np.testing.assert_allclose(result["velocity"], expected, rtol=0, atol=1e-11)


def test_the_best_iterate_is_kept():
    """An incomplete step raises the residual; more iterations must not return it."""
    problem = stored("shear-500-eta-0.7")
    settings = dict(tolerance=0, accuracy=np.inf)
    left = [problem.solve("exact", max_iterations=budget, **settings)["residual"]
            for budget in range(900, 1500, 10)]
    assert left == sorted(left, reverse=True)


@pytest.mark.parametrize(
    "tolerance, accuracy", [(0, 0.01), (0, np.inf), (1e-10, 1e-300), (0, 1e-300)])
def test_a_criterion_that_is_never_met_runs_all_iterations(tolerance, accuracy):
    """The criterion cannot be met, but exact steps improve the best iterate."""
    problem = pile(4, 20, 20)
    swept, result = (problem.solve(solver, tolerance=tolerance, max_iterations=2000,
                                   accuracy=accuracy)
                     for solver in ("nesterov", "exact"))
    error, size = errors(problem, result["impulse"])
    assert not result["converged"] and result["iterations"] == 2000
    assert np.linalg.norm(error) / size < 1e-6 * swept["residual"]
    assert result["error_estimate"] < 1e-3 * swept["error_estimate"]


def test_box_that_is_crushed_has_no_solution():
    """Impulses diverge and stay finite, the residual falls, and the step does not converge."""
    problem = jammed_box(2, 6, closing=0.1)
    for tolerance in (1e-4, 1e-6, 1e-8):
        result = problem.solve("exact", tolerance=tolerance, max_iterations=3000, accuracy=0.01)
        assert not result["converged"], tolerance
        assert np.isfinite(result["impulse"]).all() and np.isfinite(result["velocity"]).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_start_whose_squares_overflow_is_dropped(seed):
    """Its residual is NaN, so the solver starts again from zero."""
    problem = pile(seed)
    cold = assert_solved(problem, "exact", 1e-8)
    problem["impulse"] = np.full_like(problem["impulse"], 1e200)
    found = assert_solved(problem, "exact", 1e-8)
    np.testing.assert_allclose(found["velocity"], cold["velocity"], rtol=0, atol=1e-6)
    assert problem.solve("exact", tolerance=1e-8, max_iterations=30)["iterations"] <= 30
