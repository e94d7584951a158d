"""The residual and the kinematic violation against NumPy, and where they must be zero or blind."""

import numpy as np
import pytest
from kernel.contact_problems import pile
from rcr import _kernel


def test_residual_of_an_open_contact_without_friction_or_sliding():
    """u_t = µ = 0 lies on the edge of two faces of the projection; an open contact has no error there."""
    problem = pile(1)
    problem["friction"] = np.zeros_like(problem["friction"])
    problem["free_velocity"] = np.zeros_like(problem["free_velocity"])
    problem["bias"] = np.ones_like(problem["bias"])
    result = problem.solve(tolerance=1e-4)
    assert result["residual"] == 0 and result["iterations"] == 0 and not result["impulse"].any()
