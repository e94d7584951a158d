"""ρ of proximal steps rises while they converge, falls after a failure, then waits longer."""

import pytest
from rcr import _kernel


@pytest.mark.parametrize("changes, steps, expected", [
    ({}, "+++++", [1e3, 1e4, 1e5, 1e6, 1e6]), (dict(rise=4, max=1500), "+++", [400, 1500, 1500]),
    ({}, "---", [10, 1, 1]), (dict(fall=16, min=0.5), "---", [6.25, 0.5, 0.5]),
    (dict(max_patience=1), "-+-+", [10, 100, 10, 100]),  # without patience every step counts
    # two steps before the next rise after the first failure, four after the second
    ({}, "-++-++++", [10, 10, 100, 10, 10, 10, 10, 100]),
    # at most eight steps; two rises in succession halve the number
    ({}, "-----" + 16 * "+", [10, *[1] * 11, *[10] * 4, 100, 100, 1e3, 1e4, 1e5]),
    ({}, "-+-++++", [10, 10, 1, 1, 1, 1, 10]),  # a failed step restarts the count
])
def test_rises_and_falls(changes, steps, expected):
    """ρ after each step: + converged, − failed."""
    one = _kernel.ProximalParameter(**dict(start=100, min=1, max=1e6, rise=10, fall=10,
                                           max_patience=8) | changes)
    step = {"+": one.step_converged, "-": one.step_failed}
    assert [(step[sign](), one.rho)[1] for sign in steps] == expected
