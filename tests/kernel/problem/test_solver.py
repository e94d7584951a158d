"""The solver chosen by name: settings refused, problems without contacts, which tier `auto` takes."""

import numpy as np
import pytest
from kernel.contact_problems import Problem, assert_solved, frictionless, pile, stored

BUDGET = 20000  # iterations; the problems below need a tenth of it


@pytest.mark.parametrize(
    "change, says",
    [
        ({"solver": "newton"}, "newton"),
        ({"tolerance": -1.0}, "tolerance = -1"),
        ({"tolerance": float("nan")}, "tolerance = nan"),
        ({"max_iterations": 0}, "maxIterations = 0"),
        ({"threads": 0}, "threads = 0"),
        ({"lanes": 3}, "lanes = 3"),
    ],
)
def test_refuses_what_makes_no_sense(change, says):
    with pytest.raises(ValueError, match=says):
        pile(1).solve(**change)


def test_a_problem_without_contacts():
    problem = pile(1)
    none = Problem("none", **{k: v if k in ("inverse_mass", "free_velocity") else v[:0] for k, v in problem.items()})
    result = none.solve("exact", tolerance=1e-10)
    assert result["converged"] and result["residual"] == 0


@pytest.mark.parametrize("name", ["shear-500-eta-0.7", "shear-1000-eta-0"])
def test_auto_takes_the_exact_tier_for_fine_tolerances(name):
    problem = stored(name).cold()
    assert_solved(problem, problem.solve("auto", tolerance=1e-9, max_iterations=BUDGET), 1e-9)


@pytest.mark.parametrize("friction, same", [(0.0, "nesterov"), (0.5, "exact")])
def test_auto_sweeps_to_fine_tolerances_where_nothing_has_friction(friction, same):
    problem = pile(1, 30, 30).cold()
    problem["friction"][:] = friction
    auto, other = (problem.solve(solver, tolerance=1e-9, max_iterations=1500) for solver in ("auto", same))
    assert auto["iterations"] == other["iterations"] and (auto["impulse"] == other["impulse"]).all()
    if not friction:
        assert_solved(problem, auto, 1e-9)


def test_iterations_of_auto_bound_its_time():
    """Exact iterations cost some twenty sweeps each, and counted as one: steps that asked for them took 16 times as long as others of as many iterations."""
    problem = stored("ram_between_slopes").cold()
    seconds = lambda solver, **settings: min(problem.solve(solver, max_iterations=1000, **settings)["processor_seconds"] for _ in range(5))
    assert seconds("auto", tolerance=2e-6, violation=1e-3) < 4 * seconds("nesterov", tolerance=0)


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "auto"])
def test_a_start_far_off_gives_no_energy(solver):
    """Steps that end before the tolerance kept impulses of the start that were worse than none: grains left at a hundred times their speed."""
    problem = frictionless(pile(1).cold())
    problem["bias"][:] = 0
    kinetic = lambda v: (0.5 * np.divide(v**2, problem["inverse_mass"], out=np.zeros_like(v), where=problem["inverse_mass"] > 0)).sum()
    scale = np.abs(problem.solve("exact")["impulse"]).max()
    problem["impulse"][:, 0] = 1e3 * scale * np.random.default_rng(0).random(len(problem["impulse"]))
    found = problem.solve(solver, max_iterations=3, tolerance=1e-8)
    assert not found["converged"] and kinetic(found["velocity"]) <= kinetic(problem["free_velocity"])
