"""S9. Five flat RCRs on each other under oblique gravity.

A side contact has two points and one force too many. The tangential force divides between the
points in any ratio; the resultant and its moment are unique.
"""

import os
import tempfile

import numpy as np
import rcr
from rcr import problems

from .stage import R, material, on_floor, solver, stadium, tilted

TITLE = "indeterminate side contacts"
PREDICATE = "largest difference of a pair's resultant between solvers, relative"
BOUND = 1e-6
REASON = "residual 1e-10 times the condition of the stack, n² = 25, with a margin"
RIGID_ONLY = True
SOLVERS = "nlgs", "sor", "nesterov", "exact"


def build(law, dt):
    rough = material()
    bricks = [stadium(R / 2, R / 2, (0.1 * R * k, R / 2 * (1 + 2 * k)), material=rough)
              for k in range(5)]
    return on_floor(law, dt, rough, *bricks, gravity=tilted(0.2))


def present_problem():
    """Contact problem of the last step."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "step.npz")
        solver().save(path)
        return problems.load(path)


def resultants(problem, impulse):
    """(pairs, 3): impulse (x, y) of each pair and its moment about body 2 over R [N s/m]."""
    n = problem.normal
    t = np.column_stack((-n[:, 1], n[:, 0]))
    p = impulse[:, :1] * n + impulse[:, 1:] * t
    moment = (problem.arm2[:, 0] * p[:, 1] - problem.arm2[:, 1] * p[:, 0]) / R
    _, pair = np.unique(problem.bodies, axis=0, return_inverse=True)
    return np.array([np.bincount(pair.ravel(), column) for column in (*p.T, moment)]).T


def measure(ids, clock):
    clock.step(5)
    problem = present_problem()
    solve = lambda s: rcr.solve(problem, solver=s, tolerance=1e-10, max_iterations=1_000_000)
    found = [resultants(problem, solve(s).reaction) for s in SOLVERS]
    return max(abs(other - found[0]).max() for other in found[1:]) / abs(found[0]).max()
