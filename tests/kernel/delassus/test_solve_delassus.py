"""Solvers of W and q: one row against one point, the laws, what must not change a bit, when to stop."""

import numpy as np
import pytest
from kernel.delassus_problems import PROBLEMS, SOLVERS, SWEEPS, Problem, of
from rcr import _kernel


@pytest.mark.parametrize("lanes", [1, 4, 8])
def test_one_row_is_the_problem_of_one_point(lanes):
    """Each an island of its own: apart, stick, slide either way, no friction, nothing that friction moves, Painlevé's case."""
    rng = np.random.default_rng(5)
    count = 500
    w, q, mu = np.zeros((2 * count, 2 * count)), rng.normal(0, 1, (count, 2)), rng.choice([0.0, 0.3, 0.8, 3.0], count)
    expected = np.zeros((count, 2))
    painleve = 0
    for k in range(count):
        a = rng.normal(0, 1, (2, 2))
        block = np.diag([1.0, 0.0]) if k % 7 == 0 else a @ a.T + 0.1 * np.eye(2)
        painleve += mu[k] * abs(block[0, 1]) > block[0, 0]
        w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = block
        expected[k] = _kernel.solve_coulomb(block[0, 0], block[0, 1], block[1, 1], *q[k], mu[k])
    assert painleve > 20
    found = Problem(w, q, mu).solve("nlgs", tolerance=1e-12, lanes=lanes)
    assert found["converged"] and found["iterations"] <= 2
    np.testing.assert_allclose(found["impulse"], expected, rtol=1e-12, atol=1e-14)  # condition of the blocks up to 100


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_solutions_satisfy_the_laws(name, solver):
    problem = of(name)
    tolerance = 1e-9 if solver in ("exact", "auto") else 1e-6
    found = problem.solve(solver, tolerance=tolerance, max_iterations=100000)
    recomputed = problem.residual(found["impulse"])
    assert found["converged"] and recomputed <= tolerance * (1 + 1e-6), f"{name}, {solver}: {recomputed:.3e} after {found['iterations']}"
    assert recomputed == pytest.approx(found["residual"], rel=1e-6, abs=1e-14)  # rounding of the sums that make u
    np.testing.assert_allclose(found["relative_velocity"], problem.velocity(found["impulse"]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_lanes_change_no_bit(name, solver):
    problem = of(name)
    first, *others = [problem.solve(solver, tolerance=1e-6, max_iterations=3000, lanes=lanes) for lanes in (1, 4, 8, 0)]
    for other in others:
        for key in ("impulse", "relative_velocity", "iterations", "residual"):
            np.testing.assert_array_equal(first[key], other[key], err_msg=f"{name}, {solver}, {key}")


@pytest.mark.parametrize("solver", SWEEPS)
def test_tolerance_zero_takes_every_sweep(solver):
    for count in (1, 7, 300):
        assert of("heaps").solve(solver, tolerance=0, max_iterations=count)["iterations"] == count


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SWEEPS)
def test_stops_when_the_tolerance_is_met(name, solver):
    """Not only at every tenth sweep: what sweeps change tells of it. At most two more than with the residual measured after each."""
    problem = of(name)
    for tolerance in (1e-2, 1e-4, 1e-6):
        each, tenth = [problem.solve(solver, tolerance=tolerance, max_iterations=100000, check_interval=count) for count in (1, 10)]
        assert tenth["residual"] <= tolerance
        assert each["iterations"] <= tenth["iterations"] <= each["iterations"] + 2, f"{name}, {solver}, {tolerance:g}"


def test_warm_start():
    """From its own solution a problem needs no sweep."""
    problem = of("heaps")
    problem.impulse = problem.solve("exact", tolerance=1e-9, max_iterations=100000)["impulse"]
    for solver in SOLVERS:
        assert problem.solve(solver, tolerance=1e-6)["iterations"] == 0
