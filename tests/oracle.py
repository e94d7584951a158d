"""Errors of contact problems in NumPy, independent of the kernels, for tests and benchmarks.

Needs NumPy; `matrix` and `residual_of` need SciPy.
"""

import numpy as np

REDUCTIONS = ["frictionless", "discs", "fixed", "islands", "layout"]  # of the solver's model


def without(*names):
    """Return the reductions except for these."""
    return [name for name in REDUCTIONS if name not in names]


def error(p, u, friction, w):
    """‖p − P_K(p − (u + µ|u_t| n)/w_nn)‖ of every point [N s/m]; 0 where no impulse moves it."""
    moves, w = w > 0, np.where(w > 0, w, 1)
    x, y = p[:, 0] - (u[:, 0] + friction * abs(u[:, 1])) / w, p[:, 1] - u[:, 1] / w
    # normal part of the projection onto the edge of the cone
    edge = np.maximum(x + friction * abs(y), 0) / (1 + friction**2)
    inside = (abs(y) <= friction * x) & (x > 0)
    n, t = np.where(inside, x, edge), np.where(inside, y, friction * edge * np.sign(y))
    return np.where(moves, np.hypot(p[:, 0] - n, p[:, 1] - t), 0)


def residual(matrix, q, friction, p):
    """Relative residual ‖error‖/‖p‖ with u = W p + q [-]; 1 for p = 0 with errors.

    `matrix` is W (2 nc, 2 nc), sparse or dense, in the order n₀, t₀, n₁, t₁ …; q includes b_n; q
    and the impulses p are (nc, 2).
    """
    w = matrix.diagonal()[::2]
    miss = error(p, (matrix @ p.ravel()).reshape(-1, 2) + q, friction, w)
    size = np.linalg.norm(p[w > 0])
    return float(np.linalg.norm(miss) / size) if size else float(miss.any())


def matrix(problem):
    """W of a `DelassusProblem` as a SciPy `csc_array`, (2 nc, 2 nc) [1/kg]."""
    from scipy.sparse import csc_array

    rows, columns, values = problem.entries()
    return csc_array((values, (rows, columns)), shape=(2 * problem.contacts,) * 2)


def residual_of(problem, p):
    """The same residual, of a `DelassusProblem`."""
    return residual(matrix(problem), problem.q, problem.friction, p)


def generalised(bodies, normal, arm1, arm2, impulse, count):
    """Jᵀp, (count, 3)."""
    force = impulse[:, :1] * normal + impulse[:, 1:] * np.stack([-normal[:, 1], normal[:, 0]], 1)
    result = np.zeros((count, 3))
    for side, arm, sign in (0, arm1, -1), (1, arm2, 1):
        torque = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        np.add.at(result, bodies[:, side], sign * np.column_stack([force, torque]))
    return result
