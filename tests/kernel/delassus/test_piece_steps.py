"""Newton's steps on the pieces of the law, where sweeps lead no further."""

import numpy as np
from kernel.delassus_problems import Problem


def test_newton_where_sweeps_lead_no_further():
    """A column of which the uppermost is a million times heavier than each of the rest."""
    count = 30
    jacobian = np.eye(count) - np.eye(count, k=-1)
    inverse_mass = np.append(np.ones(count - 1), 1e-6)
    w = np.kron(jacobian * inverse_mass @ jacobian.T, np.diag([1.0, 0.0])) + np.kron(np.eye(count), np.diag([0.0, 1.0]))
    problem = Problem(w, np.column_stack([jacobian @ np.full(count, -0.1), np.zeros(count)]), np.full(count, 0.5))
    swept = problem.solve("nesterov", tolerance=1e-12, max_iterations=20000)
    found = problem.solve("exact", tolerance=1e-12, max_iterations=100000)
    assert not swept["converged"] and found["converged"] and problem.residual(found["impulse"]) <= 2e-12  # rounding of W p: p is 1e6 times u
    momentum = (0.1 / inverse_mass)[::-1].cumsum()[::-1]  # of all that is above
    np.testing.assert_allclose(found["impulse"][:, 0], momentum, rtol=1e-3)  # 1e-12 times the condition, 1e9
