"""ρ of proximal steps rises while they converge, falls after a failure, then waits longer."""

import pytest
from rcr import _kernel


@pytest.mark.parametrize("steps, expected", [
    ("++++", [1e4, 1e5, 1e6, 1e6]), ("------", [100, 10, 1, 0.1, 0.01, 0.01]),
    # two steps before the next rise after the first failure, four after the second
    ("-++-++++", [100, 100, 1e3, 100, 100, 100, 100, 1e3]),
    # at most 64 steps; two rises in succession halve the number
    (8 * "-" + 126 * "+", [100, 10, 1, 0.1, *67 * [0.01], *32 * [0.1], *16 * [1], *8 * [10],
                           *4 * [100], *2 * [1e3], 1e4]),
    ("-+-++++", [100, 100, 10, 10, 10, 10, 100]),  # a failed step restarts the count
])
def test_rises_and_falls(steps, expected):
    """ρ after each step: + converged, − failed."""
    one = _kernel.ProximalParameter()
    step = {"+": one.step_converged, "-": one.step_failed}
    assert [(step[sign](), one.rho)[1] for sign in steps] == pytest.approx(expected)
