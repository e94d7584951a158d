"""The residual of the contact laws, recomputed with NumPy."""

import numpy as np


def error(p, u, mu, w):
    """‖p − P_K(p − (u + µ|u_t| n)/w_nn)‖ of every point; 0 where no impulse moves it."""
    moves, w = w > 0, np.where(w > 0, w, 1)
    x, y = p[:, 0] - (u[:, 0] + mu * abs(u[:, 1])) / w, p[:, 1] - u[:, 1] / w
    face = np.maximum(x + mu * abs(y), 0) / (1 + mu**2)
    inside = (abs(y) <= mu * x) & (x > 0)
    n, t = np.where(inside, x, face), np.where(inside, y, mu * face * np.sign(y))
    return np.where(moves, np.hypot(p[:, 0] - n, p[:, 1] - t), 0)


def residual(w, q, mu, p):
    """‖error‖/‖p‖ with u = W p + q on a dense W; the numerator alone for p = 0."""
    wnn = np.diag(w)[::2]
    miss = np.linalg.norm(error(p, (w @ p.ravel()).reshape(-1, 2) + q, mu, wnn))
    return miss / (np.linalg.norm(p[wnn > 0]) or 1)
