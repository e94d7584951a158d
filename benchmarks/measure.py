"""Shared parts of the benchmarks: times of sweeps, larger problems. Needs NumPy."""

import os
import time
from functools import partial
from operator import itemgetter

import numpy as np

FEW = 10  # sweeps of the shorter call; the difference cancels the cost of a call
UNITS_OF_WORK = 300_000  # points times sweeps of one timing: a few ms, often undisturbed


def rounds(repeats, budget, functions):
    """Yield the results of all functions, at most `repeats` times; none begins after `budget` s."""
    start = time.perf_counter()
    for _ in range(repeats):
        yield [function() for function in functions]
        if time.perf_counter() - start > budget:
            break


def best(repeats, budget, *functions, by="processor_seconds"):
    """The result of each function, a dict, with the shortest time."""
    return [min(results, key=itemgetter(by)) for results in zip(*rounds(repeats, budget, functions))]


def sweep_times(runs, repeats, budget=60):
    """Wall-clock and processor time a point and sweep, (runs, 2) [ns]; a run is (points, solve)."""

    def run(solve, count):
        found = solve(tolerance=0, max_iterations=count, check_interval=10**9)
        return found["seconds"], found["processor_seconds"]

    points = np.array([count for count, _ in runs])
    many = FEW + np.maximum(40, UNITS_OF_WORK // points)
    calls = [partial(run, solve, int(count)) for (_, solve), most in zip(runs, many)
             for count in (FEW, most)]
    least = np.min([*rounds(repeats, budget, calls)], axis=0)
    return 1e9 * (least[1::2] - least[::2]) / ((many - FEW) * points)[:, None]


# ---- problems

def given(paths):
    """(name, problem) of each file; without files, of lattices of 500, 2000 and 8000 discs."""
    from rcr import problems

    if paths:
        return [(os.path.splitext(os.path.basename(path))[0], problems.load(path))
                for path in paths]
    return [(f"lattice-{count}", problems.BodyProblem(**lattice(count)))
            for count in (500, 2000, 8000)]


def mirrored(problem, seed=1, change=0.05):
    """A problem twice as large: the problem and its mirror image at a straight wall.

    The wall is a prescribed body whose contacts share one normal along x or y. It disappears:
    grains that touched it touch their own images, at twice the gap and without friction. The
    solution is the solution of the problem and its mirror image. Random relative changes of the
    free velocities, of the standard deviation `change`, break the symmetry.
    """
    axis, speed, gone = _straight_wall(problem)
    flip = 1 - 2 * np.eye(2)[axis]
    turn = np.append(flip, -1)
    count = len(problem.inverse_mass)
    at_wall = np.isin(problem.bodies, gone).any(1)
    kept = ~at_wall

    image_velocity = problem.free_velocity * turn
    image_velocity[:, axis] += 2 * speed
    free = (problem.inverse_mass > 0).any(1)
    velocity = np.concatenate([problem.free_velocity, image_velocity])
    noise = 1 + change * np.random.default_rng(seed).normal(size=2 * count)
    velocity *= np.where(np.tile(free, 2), noise, 1)[:, None]

    # index of the grain in its wall contact
    inside = np.where(np.isin(problem.bodies[at_wall, 0], gone), 1, 0)
    rows = np.arange(len(inside))
    grain = problem.bodies[at_wall][rows, inside]
    arm = np.stack([problem.arm1[at_wall], problem.arm2[at_wall]], 1)[rows, inside]
    normal = problem.normal[at_wall] * np.where(inside, -1, 1)[:, None]  # outward from the grain
    join = lambda name, image, wall: np.concatenate(
        [getattr(problem, name)[kept], image[kept], wall])
    return type(problem)(
        inverse_mass=np.tile(problem.inverse_mass, (2, 1)),
        free_velocity=velocity,
        bodies=join("bodies", problem.bodies + count, np.column_stack([grain, grain + count])),
        normal=join("normal", problem.normal * flip, normal),
        arm1=join("arm1", problem.arm1 * flip, arm),
        arm2=join("arm2", problem.arm2 * flip, arm * flip),
        bias=join("bias", problem.bias, 2 * problem.bias[at_wall]),
        friction=join("friction", problem.friction, 0 * problem.friction[at_wall]),
        impulse=join("impulse", problem.impulse * [1, -1], problem.impulse[at_wall]))


def _straight_wall(problem):
    """(axis of the normal, speed along it, bodies) of the first prescribed straight wall."""
    walls = {}
    for body in np.flatnonzero(~(problem.inverse_mass > 0).any(1)):
        first, second = (problem.bodies == body).T
        normals = np.concatenate([problem.normal[first], -problem.normal[second]])
        if len(normals) and (normals == normals[0]).all() and abs(normals[0]).max() == 1:
            axis = int(abs(normals[0, 1]) == 1)
            speed = problem.free_velocity[body, axis]
            walls.setdefault((axis, speed, normals[0, axis]), []).append(body)
    if not walls:
        raise ValueError("expected a prescribed body whose contacts share one normal along x or y; "
                         "give a problem with a straight wall")
    (axis, speed, _), bodies = next(iter(walls.items()))
    return axis, speed, bodies


def lattice(count, seed=1):
    """Arrays of a triangular lattice of about `count` equal discs under a load, a third of its
    bonds open. It is not at rest: times of a sweep are realistic, numbers of sweeps are not.
    """
    from benchmarks.packing import Packing

    rng = np.random.default_rng(seed)
    side = max(2, round(np.sqrt(count)))
    discs = side * side
    row, column = np.divmod(np.arange(discs), side)
    height = np.sqrt(0.75)  # of a row; odd rows are shifted by half a diameter
    walls = [(-0.5, 0), (0, -0.5), (side, 0), (0, height * (side - 1) + 0.5)]
    place = np.concatenate([np.column_stack([column + 0.5 * (row % 2), height * row]), walls])
    velocity = np.zeros((discs + 4, 3))
    velocity[:discs] = rng.normal(0, 0.01, (discs, 3))
    velocity[-1, 1], velocity[-2, 0] = -0.01, -0.01
    packing = Packing(np.column_stack([place, np.zeros(discs + 4)]), np.tile([0, 0.5], (discs, 1)),
                      np.append(np.ones(discs), [0, 0, side, 0]), np.full(discs, 1 / 8), velocity,
                      np.zeros((discs + 4, 2)), dt=1.0)
    arrays = packing.problem(friction=0.5, alert=1e-6).arrays()
    is_closed = (arrays["bodies"] >= discs).any(1) | (rng.random(len(arrays["bias"])) < 2 / 3)
    return dict(arrays, bias=np.where(is_closed, 0, 0.1))
