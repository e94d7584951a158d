"""Random problems of bodies with blocked directions and masses of many magnitudes.

What converged must satisfy the laws on each island, with impulses far from overflow.
"""

import numpy as np
import pytest
from kernel.contact_problems import (errors, islands, jacobian_times, problem_of, velocity,
                                     weights)

BLOCKED = {0: (), 1: (0, 1, 2), 2: (1, 2), 3: (0, 1), 4: (2,)}  # kind: blocked directions


def random_problem(seed):
    rng = np.random.default_rng(seed)
    count, points = rng.integers(2, 14), rng.integers(1, 30)
    spread = rng.choice([0.3, 2, 4])
    inverse = 10 ** rng.uniform(-spread, spread, (count, 1)) * np.column_stack(
        [np.ones((count, 2)), 10 ** rng.uniform(-1, 1, count)])
    for body, kind in enumerate(rng.choice(list(BLOCKED), count, p=[0.4, 0.15, 0.15, 0.15, 0.15])):
        inverse[body, list(BLOCKED[kind])] = 0
    body1 = rng.integers(0, count, points)
    body2 = (body1 + rng.integers(1, count, points)) % count
    order = np.lexsort((body2, body1))
    angle = np.where(rng.random(points) < 0.3, rng.integers(0, 4, points) * np.pi / 2,
                     rng.uniform(-np.pi, np.pi, points))
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    central = rng.random((points, 1)) < 0.3  # a normal through both centres
    arm1, arm2 = (np.where(central, sign * 0.5 * normal, rng.normal(0, 1, (points, 2)))
                  for sign in (1, -1))
    return problem_of(
        "random", inverse, rng.normal(0, 1, (count, 3)) * (rng.random((count, 3)) < 0.8),
        np.column_stack([body1, body2])[order], normal, arm1, arm2,
        np.where(rng.random(points) < 0.3, rng.normal(0, 1, points), 0),
        np.where(rng.random(points) < 0.3, 0, rng.uniform(0, 1.2, points)), seed=seed)


@pytest.mark.parametrize("seed", range(60))
def test_what_converged_satisfies_the_laws_on_each_island(solver, seed):
    problem, rng = random_problem(seed), np.random.default_rng(seed)
    tolerance = rng.choice([1e-4, 1e-8])
    found = problem.solve(solver, tolerance=tolerance, max_iterations=rng.choice([20, 200, 1000]),
                          yield_compliance=rng.choice([0, 0.01]))
    if not found["converged"]:
        return
    p = found["impulse"]
    of_point = islands(problem["inverse_mass"].any(1), problem["bodies"])
    blocked = weights(problem) < 1e-18 * problem["inverse_mass"].max()
    u = jacobian_times(problem, velocity(problem, p))[:, 0] + problem["bias"]
    stopping = (abs(u) + abs(problem["bias"])) / np.where(blocked, np.inf, weights(problem))
    error = np.where(blocked, 0, errors(problem, p)[0])
    for island in set(of_point) - {-1}:
        part = of_point == island
        scale = max(np.linalg.norm(p[part]), 1e-8 * np.linalg.norm(stopping[part]))
        assert np.linalg.norm(error[part]) <= 1.01 * tolerance * scale, f"island {island}"
    assert u[blocked & (of_point >= 0)].min(initial=0) > -1e-9
    assert abs(found["velocity"]).max() < 1e6
