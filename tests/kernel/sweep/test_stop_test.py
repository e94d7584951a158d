"""Each stop criterion alone, the interval of evaluations, and a stalled residual."""

import math

import pytest
from rcr import _kernel


def run(residual, error=0.0, change=math.inf, early=lambda sweep: False, **settings):
    """Sweeps until the test stops; the measures are numbers or functions of the sweep.

    Returns the number of sweeps and the sweeps at which the criteria were evaluated.
    """
    test = _kernel.StopTest(**settings)
    sweep, measured = 0, []
    at = lambda value: value(sweep) if callable(value) else value

    def measure():
        measured.append(sweep)
        return at(residual), at(error), at(change)

    while not test.reached(measure, early=early(sweep)):
        sweep += 1
        assert sweep < 10_000
    assert test.sweeps == sweep
    return sweep, measured


def sweeps(*arguments, **settings):
    return run(*arguments, **settings)[0]


def falling(sweep):
    return 0.5**sweep


def test_tolerance_at_the_next_interval():
    count, measured = run(falling, tolerance=0.5**14)
    assert count == 20 and measured == [0, 10, 20]


def test_equal_to_the_tolerance_is_enough():
    assert sweeps(falling, tolerance=0.5**10) == 10
    assert sweeps(falling, tolerance=0.5**10.01) == 20


def test_early_evaluation():
    count, measured = run(falling, tolerance=0.5**14, early=lambda sweep: sweep in (1, 13, 14))
    assert count == 14 and measured == [0, 1, 10, 13, 14]


def test_minimal_sweeps():
    assert sweeps(0, check_interval=1) == 0
    assert sweeps(0, check_interval=1, min_iterations=7) == 7
    assert sweeps(0, min_iterations=7) == 10
    assert sweeps(0, min_iterations=7, max_iterations=5) == 5
    assert sweeps(0, min_iterations=7, early=lambda sweep: True) == 7


@pytest.mark.parametrize("most", [1, 10, 37])
def test_tolerance_zero_runs_all_sweeps(most):
    assert sweeps(0, tolerance=0, max_iterations=most) == most


def test_the_kinematic_tolerance_must_be_met_too():
    assert sweeps(falling, 0.01, max_iterations=50) == 20
    assert sweeps(falling, 0.0101, max_iterations=50) == 50
    assert sweeps(falling, 0.0101, max_iterations=50, kinematic_tolerance=1.0) == 20
    assert sweeps(falling, 1e300, max_iterations=50, kinematic_tolerance=math.inf) == 20
    assert sweeps(0.9, lambda sweep: 0.3**sweep, tolerance=1, check_interval=1) == 4


def test_the_mean_force_alone_suffices():
    """The change must be less than the setting."""
    change, every = lambda sweep: 0.1**sweep, dict(check_interval=1, max_iterations=30)
    assert sweeps(0.9, 0.9, change, mean_force_change=1e-3, **every) == 4
    assert sweeps(0.9, 0.9, change, **every) == 30
    assert sweeps(0.9, 0.9, math.nan, mean_force_change=1e-3, **every) == 30


def test_stops_when_the_residual_stalls():
    valley = lambda sweep: abs(sweep - 20) + 1
    assert sweeps(valley, check_interval=1, stall_sweeps=15) == 35
    assert sweeps(valley, check_interval=10, stall_sweeps=15) == 40
    assert sweeps(valley, check_interval=1, max_iterations=90) == 90
    assert sweeps(math.nan, check_interval=1, stall_sweeps=15, max_iterations=90) == 15
