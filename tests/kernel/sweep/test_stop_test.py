"""Each stop criterion alone, the interval of evaluations, and a stalled residual."""

import math

import pytest
from kernel.contact_problems import pile
from rcr import _kernel


def run(residual, error=0.0, change=math.inf, early=(), **settings):
    """Sweeps until the stop, and those of evaluations, which are early at the sweeps `early`. The
    measures are numbers or functions of the sweep.
    """
    test = _kernel.StopTest(**settings)
    sweep, measured = 0, []
    at = lambda value: value(sweep) if callable(value) else value

    def measure():
        measured.append(sweep)
        return at(residual), at(error), at(change)

    while not test.must_stop(measure, early=sweep in early):
        sweep += 1
        assert sweep < 10_000
    assert test.sweeps == sweep
    return sweep, measured


def falling(sweep):
    return 0.5**sweep


def valley(sweep):
    return abs(sweep - 20) + 1


def test_criteria_are_evaluated_at_intervals_and_early():
    assert run(falling, tolerance=0.5**14) == (20, [0, 10, 20])
    assert run(falling, tolerance=0.5**14, early=(1, 13, 14)) == (14, [0, 1, 10, 13, 14])


ALWAYS = dict(check_interval=1)
MEAN = dict(residual=0.9, error=0.9, check_interval=1, max_iterations=30)
FAST = lambda sweep: 0.1**sweep
STALL = dict(residual=valley, stall_sweeps=15)


@pytest.mark.parametrize("settings, sweeps", [
    pytest.param(dict(tolerance=0.5**10), 10, id="equal to the tolerance"),
    pytest.param(dict(tolerance=0.5**10.01), 20, id="above the tolerance"),
    pytest.param(dict(residual=0, **ALWAYS), 0, id="solved at the start"),
    pytest.param(dict(residual=0, min_iterations=7, **ALWAYS), 7, id="least sweeps"),
    pytest.param(dict(residual=0, min_iterations=7), 10, id="least sweeps, at an interval"),
    pytest.param(dict(residual=0, min_iterations=7, max_iterations=5), 5, id="most below least"),
    pytest.param(dict(residual=0, min_iterations=7, early=range(9)), 7, id="least sweeps, early"),
    *(pytest.param(dict(residual=0, tolerance=0, max_iterations=most), most,
                   id=f"tolerance 0 runs {most} sweeps") for most in (1, 10, 37)),
    pytest.param(dict(error=0.01, max_iterations=50), 20, id="accuracy met"),
    pytest.param(dict(error=0.0101, max_iterations=50), 50, id="accuracy missed"),
    pytest.param(dict(error=0.0101, max_iterations=50, accuracy=1.0), 20,
                 id="larger accuracy"),
    pytest.param(dict(error=1e300, max_iterations=50, accuracy=math.inf), 20,
                 id="no accuracy"),
    pytest.param(dict(residual=0.9, error=lambda sweep: 0.3**sweep, tolerance=1, **ALWAYS), 4,
                 id="estimate falls"),
    pytest.param(dict(change=FAST, mean_force_change=1e-3, **MEAN), 4,
                 id="change of the mean force below its bound"),
    pytest.param(dict(change=FAST, **MEAN), 30, id="change of the mean force without a bound"),
    pytest.param(dict(change=math.nan, mean_force_change=1e-3, **MEAN), 30, id="change unknown"),
    pytest.param(STALL | ALWAYS, 35, id="the residual stalls"),
    pytest.param(STALL, 40, id="the residual stalls, at an interval"),
    pytest.param(dict(residual=valley, max_iterations=90, **ALWAYS), 90, id="stalls are allowed"),
    pytest.param(STALL | ALWAYS | dict(residual=math.nan, max_iterations=90), 15,
                 id="a residual that is not a number stalls"),
])
def test_sweeps_until_the_stop(settings, sweeps):
    assert run(**dict(residual=falling) | settings)[0] == sweeps


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_auto_waits_for_the_estimate_of_sweeps(seed):
    """A pile of 700 points: its residual meets the tolerance before the estimate meets the goal."""
    settings = dict(tolerance=1e-4, accuracy=0.01, max_iterations=3000)
    auto, sweeps = (pile(seed, 15, 15).cold().solve(s, **settings) for s in ("auto", "nesterov"))
    assert auto["converged"] and sweeps["converged"]
    assert auto["iterations"] <= sweeps["iterations"]
