"""The residual of the contact laws on a dense W, recomputed with NumPy."""

import numpy as np


def residual(w, q, mu, p):
    """‖p − P_K(p − (u + µ|u_t| n)/w_nn)‖/‖p‖ with u = W p + q.

    It is the numerator alone for p = 0. Points that no impulse moves do not count.
    """
    u = (w @ p.ravel()).reshape(-1, 2) + q
    wnn = np.diag(w)[::2]
    moves = wnn > 0
    wnn = np.where(moves, wnn, 1)
    x, y = p[:, 0] - (u[:, 0] + mu * abs(u[:, 1])) / wnn, p[:, 1] - u[:, 1] / wnn
    face = np.maximum(x + mu * abs(y), 0) / (1 + mu**2)
    inside = (abs(y) <= mu * x) & (x > 0)
    error = p - np.where(inside[:, None], np.column_stack([x, y]),
                         np.column_stack([face, mu * face * np.sign(y)]))
    size = np.linalg.norm(p[moves])
    return np.linalg.norm(error[moves]) / size if size else np.linalg.norm(error[moves])
