"""S10. Strong forces in a pile of 150 RCRs must not depend on the order of contacts.

The step is solved twice from a cold start, with its contacts in two orders.
"""

import dataclasses

import numpy as np
import rcr

from .s09_side_contacts import present_problem, resultants
from .stage import D, R, build as scene, material, open_box

TITLE = "contacts in a shuffled order"
PREDICATE = "mean change of the strong forces (above the mean), over their mean"
BOUND = 0.05
REASON = "forces of two starts differ by up to 24 % at any residual, strong ones by less"
RIGID_ONLY = True
SEED = 10


def build(law, dt):
    rng = np.random.default_rng(SEED)
    rough = material()
    centers = [(D * 1.1 * (k % 10 + 0.5), D * 1.1 * (k // 10 + 0.5)) for k in range(150)]
    grains = [rcr.particle(c, R * rng.uniform(0.7, 1), 0.5, rng.uniform(0, np.pi), rough)
              for c in centers]
    return scene(law, dt, *open_box(11 * D, rough), *grains)


def shuffled(problem, order):
    """The problem with its contacts in another order."""
    names = "bodies normal arm1 arm2 bias friction impulse".split()
    return dataclasses.replace(problem, **{name: getattr(problem, name)[order] for name in names})


def measure(ids, clock):
    clock.pass_(2.0)
    problem = present_problem()
    orders = np.arange(problem.contacts), np.random.default_rng(SEED).permutation(problem.contacts)
    forces = []
    for order in orders:
        other = shuffled(problem, order)
        solution = rcr.solve(other, solver="auto", tolerance=1e-8, max_iterations=1_000_000)
        forces.append(np.hypot(*resultants(other, solution.reaction)[:, :2].T))
    strong = forces[0] > forces[0][forces[0] > 0].mean()
    return abs(forces[1] - forces[0])[strong].mean() / forces[0][strong].mean()
