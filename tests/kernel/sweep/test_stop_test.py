"""When sweeps stop: each criterion alone, the intervals between measurements, a residual that finds no new low."""

import math

import pytest
from rcr import _kernel


def run(residual, error=0.0, change=math.inf, early=lambda sweep: False, **settings):
    """Sweeps until the test says so; residual, kinematic error and change of the mean force are functions of the sweep, or numbers.
    Returns the number of sweeps, those that were measured, and the test."""
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
    return sweep, measured, test


def sweeps(*arguments, **settings):
    return run(*arguments, **settings)[0]


def falling(sweep):
    return 0.5**sweep


def test_tolerance_at_the_next_interval():
    count, measured, test = run(falling, tolerance=0.5**14)
    assert count == 20 and measured == [0, 10, 20] and test.measured


def test_equal_to_the_tolerance_is_enough():
    assert sweeps(falling, tolerance=0.5**10) == 10 and sweeps(falling, tolerance=0.5**10.01) == 20


def test_measured_early():
    count, measured, _ = run(falling, tolerance=0.5**14, early=lambda sweep: sweep in (1, 13, 14))
    assert count == 14 and measured == [0, 1, 10, 13, 14]


def test_first_and_minimal_sweeps():
    assert sweeps(0, check_interval=1) == 0
    assert sweeps(0, check_interval=1, first=1) == 1
    assert sweeps(0, check_interval=1, first=1, min_iterations=7) == 7
    assert sweeps(0, min_iterations=7) == 10
    assert sweeps(0, min_iterations=7, max_iterations=5) == 5
    assert sweeps(0, min_iterations=7, early=lambda sweep: True) == 7


@pytest.mark.parametrize("most", [1, 10, 37])
def test_tolerance_zero_takes_all_sweeps(most):
    count, _, test = run(0, tolerance=0, max_iterations=most)
    assert count == most and not test.measured, "the last one is measured by who reports"


def test_the_violation_must_be_met_as_well():
    assert sweeps(falling, 0.01, max_iterations=50) == 20
    assert sweeps(falling, 0.0101, max_iterations=50) == 50
    assert sweeps(falling, 0.0101, max_iterations=50, violation=1.0) == 20
    assert sweeps(falling, 1e300, max_iterations=50, violation=math.inf) == 20
    assert sweeps(0.9, lambda sweep: 0.3**sweep, tolerance=1, check_interval=1) == 4


def test_the_mean_force_alone_is_enough():
    change = lambda sweep: 0.1**sweep
    assert sweeps(0.9, 0.9, change, check_interval=1, mean_force_change=1e-3) == 4, "less than the setting"
    assert sweeps(0.9, 0.9, change, check_interval=1, max_iterations=30) == 30
    assert sweeps(0.9, 0.9, lambda sweep: math.nan, check_interval=1, mean_force_change=1e-3, max_iterations=30) == 30


def test_stops_where_the_residual_finds_no_new_low():
    valley = lambda sweep: abs(sweep - 20) + 1
    assert sweeps(valley, check_interval=1, stall_sweeps=15) == 35
    assert sweeps(valley, check_interval=10, stall_sweeps=15) == 40
    assert sweeps(valley, check_interval=1, max_iterations=90) == 90
    assert sweeps(math.nan, check_interval=1, stall_sweeps=15, max_iterations=90) == 15
