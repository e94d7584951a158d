"""Problems of W and q for the tests of the kernels.

Tests recompute velocities and residuals with NumPy on the dense W, from the impulses alone.
"""

import itertools

import numpy as np
from kernel.contact_problems import dense, problem_of
from natural_map import residual
from rcr import _kernel, problems

SOLVERS = ["nlgs", "sor", "nesterov", "exact", "auto"]


class Problem:
    """Dense W (2 nc, 2 nc) [1/kg], q (nc, 2) [m/s], µ (nc,) and initial impulses (nc, 2) [N s]."""

    def __init__(self, w, q, friction, impulse=None):
        self.w, self.q = np.asarray(w, float), np.asarray(q, float)
        self.friction = np.asarray(friction, float)
        self.impulse = np.zeros_like(self.q) if impulse is None else impulse
        row, column = np.nonzero(self.w)
        entries = (row, column, self.w[row, column])
        sparse = problems.DelassusProblem(entries, self.q, self.friction)
        block = sparse.block.reshape(-1, 4)
        self.rows = dict(row_start=sparse.row_start, column=sparse.column, block=block)

    def solve(self, solver="nesterov", **settings):
        arrays = dict(self.rows, free_velocity=self.q, friction=self.friction, impulse=self.impulse)
        return _kernel.solve_delassus(**arrays, solver=solver, **settings)

    def velocity(self, p):
        return (self.w @ p.ravel()).reshape(-1, 2) + self.q

    def residual(self, p):
        return residual(self.w, self.q, self.friction, p)


def heap(seed, bodies, contacts, load=0.5):
    """Bodies with random contacts, also with the ground; `load` is the mean approach speed."""
    rng = np.random.default_rng(seed)
    pairs = [(k, rng.integers(k) if k else bodies) if k < bodies else
             rng.choice(bodies + 1, 2, replace=False) for k in range(contacts)]
    angle, mass = rng.uniform(0, 2 * np.pi, contacts), rng.uniform(0.5, 2, (bodies + 1, 1))
    inverse_mass = [1, 1, 8] / mass * (np.arange(bodies + 1)[:, None] < bodies)
    w, _ = dense(problem_of("heap", inverse_mass, 0 * inverse_mass, pairs,
                            np.column_stack([np.cos(angle), np.sin(angle)]),
                            *rng.normal(0, 0.5, (2, contacts, 2))))
    q = rng.normal(0, 0.3, (contacts, 2)) - [load, 0]
    return Problem(w, q, rng.choice([0.0, 0.2, 0.4], contacts))


def wall(seed, length=90):
    """Bodies in a row that touch their neighbours and one wall: each wall point couples to all."""
    rng, k = np.random.default_rng(seed), np.arange(length)
    mass = rng.uniform(0.5, 2, (length, 1))
    inverse_mass = np.vstack([[1, 1, 0] / mass, [1 / length, 0, 0]])
    pairs = np.vstack([np.column_stack([k - k + length, k]), np.column_stack([k[:-1], k[1:]])])
    normals = np.repeat([[1, 0], [0, 1]], [length, length - 1], axis=0)
    w, _ = dense(problem_of("wall", inverse_mass, 0 * inverse_mass, pairs, normals))
    q = rng.normal(-0.3, 0.3, (2 * length - 1, 2))
    return Problem(w, q, rng.choice([0.0, 0.3], 2 * length - 1))


def enumerated(problem, tolerance=1e-9):
    """Distinct solutions (nc, 2) by brute force over apart, stick and slide ± of each point."""
    found = []
    count = len(problem.q)
    for states in itertools.product(["apart", "stick", 1, -1], repeat=count):
        a, b = np.eye(2 * count), np.zeros(2 * count)  # a p = b
        for k, state in enumerate(states):
            n, t = 2 * k, 2 * k + 1
            if state == "apart":
                continue
            a[n], b[n] = problem.w[n], -problem.q[k, 0]  # u_n = 0
            if state == "stick":
                a[t], b[t] = problem.w[t], -problem.q[k, 1]  # u_t = 0
            else:
                a[t, n] = -state * problem.friction[k]  # p_t = ±µ p_n
        if abs(np.linalg.det(a)) < 1e-12:
            continue
        p = np.linalg.solve(a, b).reshape(-1, 2)
        if problem.residual(p) < tolerance and not any(np.allclose(p, q) for q in found):
            found.append(p)
    return found


PROBLEMS = {
    "heap": lambda: heap(1, 30, 60),
    "heaps": lambda: heap(2, 60, 100),
    "wall": lambda: wall(3),
    "one": lambda: heap(4, 1, 1),
}
