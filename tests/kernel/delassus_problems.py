"""Problems of W and q that the kernels' tests share; residuals and velocities are recomputed on the dense W, from the impulses alone."""

import numpy as np
from natural_map import residual
from rcr import _kernel, problems

SWEEPS = ["nlgs", "sor", "nesterov"]
SOLVERS = [*SWEEPS, "exact", "auto"]


class Problem:
    """Dense W (2 nc, 2 nc), q (nc, 2), µ (nc,) and impulses to start from; blocks that are zero are left out."""

    def __init__(self, w, q, friction, impulse=None):
        self.w, self.q, self.friction = np.asarray(w, float), np.asarray(q, float), np.asarray(friction, float)
        self.impulse = np.zeros_like(self.q) if impulse is None else impulse
        row, column = np.nonzero(self.w)
        sparse = problems.DelassusProblem((row, column, self.w[row, column]), self.q, self.friction)
        self.rows = dict(row_start=sparse.row_start, column=sparse.column, block=sparse.block.reshape(-1, 4))

    def solve(self, solver="nesterov", **settings):
        return _kernel.solve_delassus(**self.rows, free=self.q, friction=self.friction, impulse=self.impulse, solver=solver, **settings)

    def velocity(self, p):
        return (self.w @ p.ravel()).reshape(-1, 2) + self.q

    def residual(self, p):
        return residual(self.w, self.q, self.friction, p)

    def permuted(self, order):
        place = (2 * order[:, None] + [0, 1]).ravel()
        return Problem(self.w[np.ix_(place, place)], self.q[order], self.friction[order], self.impulse[order])


def packed(*parts):
    """Problems side by side, rows of all mixed."""
    size = sum(len(part.q) for part in parts)
    w = np.zeros((2 * size, 2 * size))
    at = 0
    for part in parts:
        w[at : at + len(part.w), at : at + len(part.w)] = part.w
        at += len(part.w)
    join = lambda name: np.concatenate([getattr(part, name) for part in parts])
    whole = Problem(w, join("q"), join("friction"), join("impulse"))
    return whole.permuted(np.random.default_rng(size).permutation(size))


def heap(seed, bodies, contacts, load=0.5):
    """Bodies with random contact points among themselves and with the ground, all joined; `load` is the speed of the approach."""
    rng = np.random.default_rng(seed)
    jacobian = np.zeros((contacts, 2, bodies + 1, 3))  # the last body is the ground
    for k in range(contacts):
        a = k if k < bodies else rng.integers(bodies)
        b = (rng.integers(a) if a else bodies) if k < bodies else rng.integers(bodies + 1)
        angle = rng.uniform(0, 2 * np.pi)
        for row, d in enumerate(np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])):
            for body, sign in ((a, 1), (b, -1)):
                r = rng.normal(0, 0.5, 2)
                jacobian[k, row, body] += sign * np.array([d[0], d[1], r[0] * d[1] - r[1] * d[0]])
    inverse_mass = np.repeat(1 / rng.uniform(0.5, 2, bodies + 1), 3) * np.tile([1, 1, 8], bodies + 1)
    inverse_mass[-3:] = 0
    jacobian = jacobian.reshape(2 * contacts, -1)
    q = rng.normal(0, 0.3, (contacts, 2)) - [load, 0]
    return Problem(jacobian * inverse_mass @ jacobian.T, q, rng.choice([0.0, 0.2, 0.4], contacts))


def heaps(seed, count=120):
    """Many small ones, some at rest, and one that is larger: several batches."""
    rng = np.random.default_rng(seed)
    small = [heap(1000 * seed + k, n := int(rng.integers(1, 6)), n + int(rng.integers(3)), load=rng.choice([-2.0, 0.5])) for k in range(count)]
    return packed(heap(seed, 60, 100), *small)


def wall(seed, length=90):
    """Bodies in a row, each with its neighbours and with a wall that one mass drives: rows that all touch each other."""
    rng = np.random.default_rng(seed)
    jacobian = np.zeros((2 * length - 1, 2, length + 1, 2))
    for k in range(length):
        jacobian[k, :, k], jacobian[k, :, length] = np.eye(2), -np.eye(2) * [[1.0], [0.0]]  # the wall moves along n
        if k + 1 < length:
            jacobian[length + k, :, k], jacobian[length + k, :, k + 1] = -np.eye(2)[::-1], np.eye(2)[::-1]
    inverse_mass = np.append(np.repeat(1 / rng.uniform(0.5, 2, length), 2), [1 / length, 1 / length])
    jacobian = jacobian.reshape(4 * length - 2, -1)
    return Problem(jacobian * inverse_mass @ jacobian.T, rng.normal(-0.3, 0.3, (2 * length - 1, 2)), rng.choice([0.0, 0.3], 2 * length - 1))


PROBLEMS = {"heap": lambda: heap(1, 30, 60), "heaps": lambda: heaps(2), "wall": lambda: wall(3), "one": lambda: heap(4, 1, 1)}


def of(name):
    return PROBLEMS[name]()
