"""Mixed precision: sweeps of large islands in floats about a reference in doubles."""

import numpy as np
import pytest
from kernel.contact_problems import (assert_lanes_and_threads_change_no_bit, assert_solved, discs,
                                     frictionless, pile)

UNCHECKED = dict(tolerance=0, check_interval=1_000_000)  # no evaluation returns to doubles


def large():
    """One island of some 4000 pairs."""
    return pile(2, 60, 40)


def warm(problem):
    """The problem with the impulses of 20 sweeps."""
    impulse = problem.solve("nesterov", max_iterations=20, **UNCHECKED)["impulse"]
    return problem.copy(f"{problem.name}, warm", impulse=impulse)


def on_a_plate(problem):
    """The floor is a heavy free body with more contacts than colours: most are overflow."""
    mass = problem["inverse_mass"].copy()
    floor = np.bincount(problem["bodies"].ravel(), minlength=len(mass)).argmax()
    assert not mass[floor].any()
    mass[floor] = 1e-2 * np.median(mass[mass[:, 0] > 0], axis=0)
    return problem.copy(f"{problem.name}, on a plate", inverse_mass=mass)


@pytest.fixture(params=[lambda problem: problem, frictionless, discs, on_a_plate],
                ids=["frictional", "frictionless", "discs", "overflow"], scope="module")
def problem(request):
    return request.param(large())


@pytest.mark.parametrize("solver, residual", [("nesterov", 1e-6), ("sor", 1e-6), ("nlgs", 2e-5)])
def test_floats_alone_reach_their_rounding(problem, solver, residual):
    """Impulses are rounded to 6e-8. A wrong reference or contact law would end above 1e-3."""
    choices = [(1, 1), (4, 1), (8, 1), (8, 2), (0, 4)]
    assert_lanes_and_threads_change_no_bit(problem, solver, choices, max_iterations=130,
                                           **UNCHECKED)
    assert problem.solve(solver, max_iterations=12_000, **UNCHECKED)["residual"] < residual


@pytest.mark.parametrize("solver", ["nesterov", "sor", "nlgs"])
def test_rounding_does_not_accumulate(problem, solver):
    """Floats come as close to the solution as doubles, but for 4e-7."""
    end = problem.solve("nesterov", tolerance=1e-10, accuracy=np.inf,
                        max_iterations=60_000)
    assert end["converged"]
    noise = np.random.default_rng(0).normal(1, 1e-4, end["impulse"].shape)
    floats = problem.copy("floats", impulse=noise * end["impulse"])
    doubles = floats.copy("doubles", impulse=1e20 * floats["impulse"],  # beyond floats
                          inverse_mass=1e-20 * floats["inverse_mass"])
    for sweeps in (50, 100, 200, 399):  # less than to the next reference
        residuals = [start.solve(solver, max_iterations=sweeps, **UNCHECKED)["residual"]
                     for start in (floats, doubles)]
        assert residuals[0] < 1.1 * residuals[1] + 4e-7, sweeps


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
def test_tolerances_are_met_in_doubles(problem, tolerance):
    """The finest one without friction alone: with friction sweeps may stall."""
    if tolerance > 1e-10 or not problem["friction"].any():
        found = assert_solved(problem, tolerance=tolerance, max_iterations=100_000)
        assert found["residual"] <= tolerance


def test_a_common_velocity_changes_no_accuracy():
    """Floats hold velocities relative to the reference, so a common velocity cancels."""
    problem = large()
    moving = problem.copy(f"{problem.name}, moving")
    moving["free_velocity"][:, 0] += 1e5 * np.abs(problem["free_velocity"]).max()
    still, fast = (p.solve("nesterov", max_iterations=1000, **UNCHECKED)["residual"]
                   for p in (problem, moving))
    assert fast < 3 * still + 1e-5


@pytest.mark.parametrize("scale", [1e-30, 1e-10, 1e10, 1e30])
def test_masses_of_any_size(scale):
    """Numbers out of the range of floats are swept in doubles."""
    problem = warm(large())
    scaled = problem.copy(f"{problem.name} x {scale:g}", impulse=problem["impulse"] * scale,
                          inverse_mass=problem["inverse_mass"] / scale)
    assert_solved(scaled, tolerance=1e-4)


def test_growth_refers_to_the_last_hundred_sweeps(problem):
    """`auto` detects a step without a solution by this growth; below 100 sweeps it is unknown."""
    end, earlier = (problem.solve("nesterov", max_iterations=sweeps, **UNCHECKED)
                    for sweeps in (230, 130))
    change = np.linalg.norm(end["impulse"] - earlier["impulse"]) / np.linalg.norm(end["impulse"])
    assert end["impulse_growth"] == pytest.approx(change, rel=1e-3) and change > 0
    assert problem.solve("nesterov", max_iterations=99, **UNCHECKED)["impulse_growth"] == np.inf
