"""Choice of the solver by name, invalid settings, and the steps of `auto`."""

import numpy as np
import pytest
from kernel.contact_problems import (assert_laws, assert_same_bits, assert_solved, frictionless,
                                     kinetic_energy, pile, stored)


@pytest.mark.parametrize("change, message", [
    ({"solver": "newton"}, "newton"), ({"tolerance": -1.0}, "tolerance = -1"),
    ({"tolerance": float("nan")}, "tolerance = nan"), ({"threads": 0}, "threads = 0"),
    ({"max_iterations": 0}, "maxIterations = 0"), ({"lanes": 3}, "lanes = 3"),
    *(({"yield_compliance": value}, "yieldCompliance") for value in (-1.0, np.nan)),
    *(({"yield_impulse": value}, "yieldImpulse") for value in (0.0, -1.0, np.nan)),
    ({"reductions": ["islands", "walls"]},
     "reduction 'walls' is not known; expected one of frictionless, discs, fixed, islands"),
])
def test_invalid_settings_are_rejected(change, message):
    with pytest.raises(ValueError, match=message):
        pile(1).solve(**change)


def test_problem_without_contacts():
    result = pile(1).at_points("none", []).solve("exact", tolerance=1e-10)
    assert result["converged"] and result["residual"] == 0


@pytest.mark.parametrize("name", ["shear-500-eta-0.7", "shear-1000-eta-0"])
def test_auto_runs_exact_steps_for_fine_tolerances(name):
    assert_solved(stored(name).cold(), "auto", 1e-9)


@pytest.mark.parametrize("friction, same", [(0.0, "nesterov"), (0.5, "exact")])
def test_auto_sweeps_without_friction(friction, same):
    problem = pile(1, 30, 30).cold()
    problem["friction"][:] = friction
    settings = dict(tolerance=1e-9, max_iterations=1500)
    auto, other = (problem.solve(solver, **settings) for solver in ("auto", same))
    assert_same_bits(auto, other, same, ("iterations", "impulse"))
    if not friction:
        assert_laws(problem, auto, 1e-9)


def test_iterations_of_auto_bound_its_time():
    """An exact iteration costs about twenty sweeps and must count as twenty iterations."""
    problem = stored("ram_between_slopes").cold()

    def seconds(solver, **settings):
        results = (problem.solve(solver, max_iterations=1000, **settings) for _ in range(5))
        return min(result["processor_seconds"] for result in results)

    exact = seconds("auto", tolerance=2e-6, kinematic_tolerance=1e-3)
    assert exact < 4 * seconds("nesterov", tolerance=0)


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "auto"])
def test_distant_start_adds_no_energy(solver):
    """An unconverged solve from huge impulses must not keep them."""
    problem = frictionless(pile(1).cold())
    problem["bias"][:] = 0
    scale = np.abs(problem.solve("exact")["impulse"]).max()
    start = np.random.default_rng(0).random(len(problem["impulse"]))
    problem["impulse"][:, 0] = 1e3 * scale * start
    found = problem.solve(solver, max_iterations=3, tolerance=1e-8)
    assert not found["converged"]
    free = kinetic_energy(problem, problem["free_velocity"])
    assert kinetic_energy(problem, found["velocity"]) <= free
