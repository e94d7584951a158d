"""Fixtures for tests of all solvers. `scripts/check` runs tests/kernel without tests/conftest.py."""

import pytest

SWEEPERS = ["nlgs", "sor", "nesterov"]


@pytest.fixture(params=[*SWEEPERS, "exact", "auto"])
def solver(request):
    """Name of each solver."""
    return request.param


@pytest.fixture(params=SWEEPERS)
def sweeper(request):
    """Name of each solver that only sweeps."""
    return request.param
