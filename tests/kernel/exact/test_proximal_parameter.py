"""ρ of proximal steps rises while they converge, falls after a failure, then waits longer."""

import pytest
from rcr import _kernel


def parameter(**changes):
    settings = dict(start=100, min=1, max=1e6, rise=10, fall=10, max_patience=8)
    return _kernel.ProximalParameter(**{**settings, **changes})


def after(one, steps):
    """ρ after each step: + converged, − failed."""
    seen = []
    for step in steps:
        one.step_converged() if step == "+" else one.step_failed()
        seen.append(one.rho)
    return seen


@pytest.mark.parametrize("changes, steps, expected", [
    ({}, "+++++", [1e3, 1e4, 1e5, 1e6, 1e6]), (dict(rise=4, max=1500), "+++", [400, 1500, 1500]),
    ({}, "---", [10, 1, 1]), (dict(fall=16, min=0.5), "---", [6.25, 0.5, 0.5]),
    (dict(max_patience=1), "-+-+", [10, 100, 10, 100]),  # without patience every step counts
])
def test_rises_and_falls_within_its_limits(changes, steps, expected):
    assert after(parameter(**changes), steps) == expected


def test_every_failure_doubles_the_steps_before_the_next_rise():
    """Two steps after the first failure, four after the second."""
    one = parameter()
    assert after(one, "-++") == [10, 10, 100]
    assert after(one, "-++++") == [10, 10, 10, 10, 100]


def test_patience_has_a_limit_and_recovers():
    """At most eight steps; two rises in succession halve the number."""
    one = parameter()
    after(one, "-----")
    assert after(one, "+" * 8) == [1] * 7 + [10]
    assert after(one, "+" * 4) == [10] * 3 + [100]
    assert after(one, "+" * 4) == [100, 1e3, 1e4, 1e5]


def test_a_failed_step_restarts_the_count():
    one = parameter()
    after(one, "-+")
    assert after(one, "-++++") == [1, 1, 1, 1, 10]
