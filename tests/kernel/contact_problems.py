"""Contact problems for the tests of the kernels.

Velocities and errors are recomputed with NumPy from the impulses alone.
"""

import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from oracle import REDUCTIONS, error, generalised, without  # noqa: F401: for the tests
from rcr import _kernel, problems
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

DATA = Path(__file__).parents[1] / "data"
ROUNDING = 1e-13  # of a residual: sums of some thousand velocities with errors of 1e-16
BODY_ARRAYS = "inverse_mass", "free_velocity", "place"
LANES_AND_THREADS = [(lanes, threads) for lanes in (1, 4, 8) for threads in (1, 2, 4)]
EQUAL = "impulse", "velocity", "iterations", "residual", "error_estimate"  # of repeated solves


class Problem(dict):
    """Arrays of `_kernel.solve`, with a name and the seed."""

    def __init__(self, name, seed=None, **arrays):
        super().__init__(arrays)
        self.name, self.seed = name, seed

    def copy(self, name, **changes):
        arrays = {key: value.copy() for key, value in self.items()}
        return Problem(name, self.seed, **arrays | changes)

    def cold(self):
        return self.copy(f"{self.name}, cold", impulse=np.zeros_like(self["impulse"]))

    def at_points(self, name, rows):
        """The problem of the points `rows` alone, in this order."""
        points = {key: value[rows] for key, value in self.items() if key not in BODY_ARRAYS}
        return self.copy(name, **points)

    def solve(self, solver="nesterov", **settings):
        return _kernel.solve(**self, solver=solver, **settings)


def jacobian_times(problem, v):
    """Relative velocities (nc, 2) for body velocities (nb, 3)."""
    a, b = problem["bodies"].T
    n, r1, r2 = problem["normal"], problem["arm1"], problem["arm2"]
    rotated = lambda w, r: w[:, None] * np.stack([-r[:, 1], r[:, 0]], 1)
    u = v[b, :2] + rotated(v[b, 2], r2) - v[a, :2] - rotated(v[a, 2], r1) + problem.get("drift", 0)
    return np.stack([(u * n).sum(1), n[:, 0] * u[:, 1] - n[:, 1] * u[:, 0]], 1)


def velocity(problem, p):
    """v_free + M⁻¹Jᵀp, (nb, 3)."""
    free, names = problem["free_velocity"], ("bodies", "normal", "arm1", "arm2")
    sums = generalised(*(problem[name] for name in names), p, len(free))
    return free + problem["inverse_mass"] * sums


def dense(problem):
    """W (2 nc, 2 nc) and q (nc, 2) with b_n, by unit impulses."""
    units = np.eye(problem["impulse"].size).reshape(-1, *problem["impulse"].shape)
    q = jacobian_times(problem, problem["free_velocity"])
    columns = [(jacobian_times(problem, velocity(problem, unit)) - q).ravel() for unit in units]
    return np.transpose(columns), q + problem["bias"][:, None] * [1, 0]


def kinetic_energy(problem, v):
    """Kinetic energy [J] of body velocities (nb, 3), without prescribed motions."""
    inverse = problem["inverse_mass"]
    return (v**2 / np.where(inverse > 0, inverse, np.inf)).sum() / 2


def weights(problem):
    """w_nn of every point (nc,), without the stretch of a cell."""
    a, b = problem["bodies"].T
    n, m = problem["normal"], problem["inverse_mass"]
    lever = lambda r: r[:, 0] * n[:, 1] - r[:, 1] * n[:, 0]
    rotation = m[a, 2] * lever(problem["arm1"]) ** 2, m[b, 2] * lever(problem["arm2"]) ** 2
    return ((m[a, :2] + m[b, :2]) * n**2).sum(1) + rotation[0] + rotation[1]


def errors(problem, p):
    """Natural-map error of every point (nc,), and ‖p‖ (residual.hpp)."""
    w = weights(problem)
    u = jacobian_times(problem, velocity(problem, p))
    u[:, 0] += problem["bias"]
    return error(p, u, problem["friction"], w), np.linalg.norm(p[w > 0])


def islands(moves, bodies):
    """Number of the island of each pair of bodies (n, 2); −1 where neither moves."""
    links = bodies[moves[bodies].all(1)].T
    graph = coo_array((np.ones(len(links[0])), links), (len(moves), len(moves)))
    label = connected_components(graph, directed=False)[1]
    return np.where(moves[bodies], label[bodies], -1).max(1)


def assert_laws(problem, result, tolerance):
    """Check residual, tolerance, and velocities against the impulses."""
    miss, size = errors(problem, result["impulse"])
    residual, k = np.linalg.norm(miss) / size, int(miss.argmax())
    replay = (
        f"{problem.name}, seed {problem.seed}: worst point {k}, bodies {problem['bodies'][k]}, "
        f"impulse {result['impulse'][k]}, error {miss[k]:.3e} of {size:.3e}, "
        f"u {result['relative_velocity'][k]}; residual {residual:.12e}, reported "
        f"{result['residual']:.12e} after {result['iterations']} iterations, tolerance {tolerance}")
    # velocities are sums of some thousand terms; a residual of 1e-4 amplifies their rounding
    assert residual == pytest.approx(result["residual"], rel=1e-9, abs=ROUNDING), replay
    assert residual <= tolerance + ROUNDING and result["converged"], replay
    expected = velocity(problem, result["impulse"])
    rounding = 1e-15 + 1e-12 * abs(expected).max()
    np.testing.assert_allclose(result["velocity"], expected, rtol=0, atol=rounding, err_msg=replay)


def assert_solved(problem, solver="nesterov", tolerance=1e-6, max_iterations=20_000, **settings):
    """Solve a problem; the result obeys the laws to the tolerance, and is returned."""
    result = problem.solve(solver, tolerance=tolerance, max_iterations=max_iterations, **settings)
    assert_laws(problem, result, tolerance)
    return result


def bits(values):
    """Bits as integers. All NaNs are equal: sign and payload depend on the processor."""
    values = np.asarray(values, float).ravel()
    return np.where(np.isnan(values), np.nan, values).view(np.int64)


def assert_same_bits(one, other, where, keys=("impulse", "velocity")):
    for key in keys:
        differ = np.flatnonzero(bits(one[key]) != bits(other[key]))
        size = np.size(one[key])
        assert not len(differ), f"{where}: {key} differs first at entry {differ[0]} of {size}"


def assert_lanes_and_threads_change_no_bit(problem, solver, choices=LANES_AND_THREADS, **settings):
    """Compare solves with (lanes, threads) of `choices` and two of the first choice."""
    solve = lambda lanes, threads: problem.solve(solver, lanes=lanes, threads=threads, **settings)
    first = solve(*choices[0])
    for lanes, threads in choices:
        where = f"{problem.name}, {solver}, {lanes} lanes, {threads} threads"
        assert_same_bits(solve(lanes, threads), first, where, EQUAL)


def models_in_a_workspace(*problems, **settings):
    """Models of problems that one workspace solves, with the bits of separate solves."""
    workspace, models = _kernel.Workspace(), []
    for problem in problems:
        kept = problem.solve(workspace=workspace, **settings)
        assert_same_bits(kept, problem.solve(**settings), problem.name, EQUAL)
        models.append(workspace.model)
    return models


def model(problem, **settings):
    return models_in_a_workspace(problem, tolerance=0, max_iterations=1, **settings)[0]


def run(code, seconds=120):
    """Start `code` in a new process without helpers; lost work would block it, so it is limited."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    command = ["timeout", str(seconds), sys.executable, "-c", code]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)


# ---- problems

def problem_of(name, inverse_mass, free_velocity, bodies, normal, arm1=(0, 0), arm2=(0, 0), bias=0,
               friction=0, seed=None):
    """Problem without impulses; a single vector or number applies to every point."""
    def each(value, *shape):
        return np.broadcast_to(value, (len(bodies), *shape)).astype(float, order="C")

    return Problem(name, seed, inverse_mass=np.array(inverse_mass, float),
                   free_velocity=np.array(free_velocity, float), bodies=np.array(bodies, np.int32),
                   normal=each(normal, 2), arm1=each(arm1, 2), arm2=each(arm2, 2), bias=each(bias),
                   friction=each(friction), impulse=np.zeros((len(bodies), 2)))


def problem_of_rows(name, inverse_mass, free_velocity, points, seed=None):
    """Problem from rows (body 1, body 2, normal, arm 1, arm 2, bias, friction)."""
    t = np.array(points, float)
    return problem_of(name, inverse_mass, free_velocity, t[:, :2], t[:, 2:4], t[:, 4:6], t[:, 6:8],
                      t[:, 8], t[:, 9], seed)


def grain(p, bias=0.0, v=(0.5, -1.0), friction=0.5, mass=2.0):
    """A grain without rotation on a floor (body 0), with the impulse p."""
    point = (0, 1, 0, 1, 0, 0, 0, -0.1, bias, friction)
    inverse_mass = [[0, 0, 0], [1 / mass, 1 / mass, 0]]
    problem = problem_of_rows("grain", inverse_mass, [[0, 0, 0], [*v, 0]], [point])
    problem["impulse"] = np.array([p], float)
    return problem


def pile(seed, columns=12, rows=9):
    """Polydisperse particles in loose rows on a fixed floor, between a fixed and a pushed wall.
    Some pairs touch at two points, some contacts are open, one body can only rotate.
    """
    rng = np.random.default_rng(seed)
    count = columns * rows
    floor, left, right, spinner = count, count + 1, count + 2, count + 3
    mass = rng.uniform(0.5, 2, count)
    inverse_mass = np.zeros((count + 4, 3))
    inverse_mass[:count] = np.column_stack([1 / mass, 1 / mass, rng.uniform(4, 9, count) / mass])
    inverse_mass[right, 0], inverse_mass[spinner, 2] = 0.02, 1.0
    inverse_mass[rng.integers(count), 2] = 0  # one particle cannot turn
    v = rng.normal(0, 0.02, (count + 4, 3))
    v[:count, 1] -= 0.1
    v[[floor, left]] = 0
    v[right] = -0.3, 0, 0
    v[spinner] = 0, 0, 0.2
    rows_of_points = []

    def touch(a, b, angle, points):
        normal = np.array([np.cos(angle), np.sin(angle)])
        tangent = np.array([-normal[1], normal[0]])
        for along in ((0.0,), (-0.3, 0.3))[points - 1]:
            arm1 = (0.5 * normal + along * tangent) * (a < count or a == spinner)
            arm2 = ((along + 0.05) * tangent - 0.5 * normal) * (b < count or b == spinner)
            bias = rng.uniform(0, 0.1) if rng.random() < 0.2 else 0
            rows_of_points.append((a, b, *normal, *arm1, *arm2, bias, rng.choice([0.0, 0.3, 0.6])))

    id_of = rng.permutation(count).reshape(rows, columns)
    for i in range(rows):
        for j in range(columns):
            here = id_of[i, j]
            if i == 0:
                touch(here, floor, -np.pi / 2, 1)
            if j == 0:
                touch(here, left, np.pi, 1)
            if j == columns - 1:
                touch(here, right, 0, 1)
            if j + 1 < columns and rng.random() < 0.8:
                touch(here, id_of[i, j + 1], rng.normal(0, 0.1), rng.integers(1, 3))
            if i + 1 < rows:
                touch(here, id_of[i + 1, j], np.pi / 2 + rng.normal(0, 0.2), rng.integers(1, 3))
            if i + 1 < rows and j and rng.random() < 0.5:
                touch(here, id_of[i + 1, j - 1], 2.3, 1)
    touch(id_of[-1, 0], spinner, np.pi / 2, 1)
    touch(floor, left, 0, 1)  # both prescribed: carries nothing
    t = np.array(rows_of_points)
    return problem_of_rows(f"pile {seed}", inverse_mass, v, t[np.lexsort((t[:, 1], t[:, 0]))], seed)


def stored(name):
    """A packing under shear (tests/data)."""
    return Problem(name, **problems.load(DATA / f"{name}.npz").arrays())


def wall_of_bricks(seed, courses=8, bricks=10, tilt=1e-3):
    """Long particles in courses on a fixed floor under gravity, each on two of the course below.
    Near-parallel sides with two points each: the forces are indeterminate.
    """
    rng = np.random.default_rng(seed)
    length, height = 1.0, 0.2
    floor = courses * bricks
    m = np.ones((floor + 1, 3)) * [1, 1, 12 / (length**2 + height**2)]
    m[floor] = 0
    v = rng.normal(0, 0.05, (floor + 1, 3)) + [0, -1, 0]
    v[floor] = 0
    x = lambda course, k: (k + 0.5 * (course % 2)) * length * 1.02
    points = []

    def side(below, above, x1, x2):
        """Add two points at the ends of the common side; x1, x2 are positions of the centres."""
        low, high = max(x1, x2) - length / 2, min(x1, x2) + length / 2
        if high - low < 0.05 * length:
            return
        angle = np.pi / 2 + rng.normal(0, tilt)
        for at in (low, high):
            arm1 = [0, 0] if below == floor else [at - x1, height / 2]
            points.append((below, above, np.cos(angle), np.sin(angle), *arm1, at - x2, -height / 2,
                           0, 0.5))

    for k in range(bricks):
        side(floor, k, x(0, k), x(0, k))
    for course, k in itertools.product(range(1, courses), range(bricks)):
        for under in range(max(k - 1, 0), min(k + 2, bricks)):
            side((course - 1) * bricks + under, course * bricks + k, x(course - 1, under),
                 x(course, k))
    return problem_of_rows(f"bricks {seed}", m, v, points, seed)


def square_bonds(side, left=None, floor=None, right=None, top=None):
    """Bodies (points, 2) and normals (points, 2) of discs on a square lattice between walls."""
    ids = np.arange(side * side).reshape(side, side)
    walls = ((left, ids[:, 0], (-1, 0)), (floor, ids[0], (0, -1)), (right, ids[:, -1], (1, 0)),
             (top, ids[-1], (0, 1)))
    sides = [(ids[:, :-1].ravel(), ids[:, 1:].ravel(), (1, 0)),
             (ids[:-1].ravel(), ids[1:].ravel(), (0, 1)),
             *((edge, np.full(side, wall), n) for wall, edge, n in walls if wall is not None)]
    bodies = np.concatenate([np.column_stack(part[:2]) for part in sides])
    return bodies, np.concatenate([np.tile(np.array(n, float), (len(a), 1)) for a, _, n in sides])


def jammed_box(seed, size=14, closing=0.0):
    """Discs that fill a box of four prescribed walls; a lid with the speed `closing` jams them."""
    count = size * size
    bodies, n = square_bonds(size, *range(count, count + 4))
    m = np.repeat([[1.0, 1.0, 8.0], [0, 0, 0]], [count, 4], axis=0)
    v = np.random.default_rng(seed).normal(0, 0.3, (count + 4, 3)) * (m > 0)
    v[count + 3, 1] = -closing
    return problem_of(f"jammed box {seed}", m, v, bodies, n, 0.5 * n,
                      -0.5 * n * (bodies[:, 1:] < count), friction=0.4, seed=seed)


def frictionless(problem):
    return problem.copy(f"{problem.name}, no friction", friction=0 * problem["friction"])


def discs(problem):
    """The problem without friction and with all arms along the normals: no rotations."""
    n = problem["normal"]
    return frictionless(problem).copy(f"{problem.name}, discs", arm1=0.5 * n, arm2=-0.5 * n)


def square_discs(seed, side=20):
    """Discs on a square lattice: normals along the axes, so all levers are exactly 0."""
    rng, floor, wall = np.random.default_rng(seed), side * side, side * side + 1
    bodies, n = square_bonds(side, floor=floor, right=wall)
    grains = rng.uniform(0.5, 2, (side * side, 1)) * [1, 1, 8]
    inverse_mass = np.vstack([grains, [[0, 0, 0], [0.1, 0, 0]]])
    velocity = rng.normal([0, -0.1, 0.5], 0.02, (side * side + 2, 3))
    velocity[floor], velocity[wall] = 0, (-0.3, 0, 0)
    bias = np.where(rng.random(len(bodies)) < 0.2, 0.05, 0)
    return problem_of(f"square discs {seed}", inverse_mass, velocity, bodies, n, 0.5 * n, -0.5 * n,
                      bias, seed=seed)


def hub(count):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    n = np.column_stack([np.cos(angle), np.sin(angle)])
    bodies = [(0, k) for k in range(1, count + 1)]
    return problem_of("hub", np.ones((count + 1, 3)), np.zeros((count + 1, 3)), bodies, n, 3 * n,
                      -0.5 * n, friction=0.4)


def grains_on_a_floor(count, seed=0, points=1):
    """Grains that touch only a fixed floor (the last body), each at one or two points."""
    rng = np.random.default_rng(seed)
    mass, pairs = rng.uniform(0.5, 2, count), np.repeat(np.arange(count), points)
    along = np.where(np.arange(len(pairs)) % 2, 0.3, -0.3) + rng.normal(0, 0.01, len(pairs))
    floor = np.zeros(3)
    inverse_mass = np.column_stack([1 / mass, 1 / mass, 6 / mass])
    free_velocity = rng.normal([0.1, -0.3, 1], 0.05, (count, 3))
    return problem_of(f"{count} grains on a floor", np.vstack([inverse_mass, floor]),
                      np.vstack([free_velocity, floor]),
                      bodies=np.column_stack([pairs, np.full_like(pairs, count)]),
                      normal=(0, -1), arm1=np.column_stack([along, np.full(len(pairs), -0.5)]),
                      friction=0.4, seed=seed)


def beside(*problems):
    """Combine problems that share only a floor: the first prescribed body at rest of each."""
    bodies, count, floor = [], 0, None
    for problem in problems:
        number = np.arange(count, count + len(problem["inverse_mass"]))
        at_rest = ~problem["inverse_mass"].any(1) & ~problem["free_velocity"].any(1)
        body = np.flatnonzero(at_rest)[0]
        floor = number[body] = number[body] if floor is None else floor
        count += len(number)
        bodies.append(number[problem["bodies"]].astype(np.int32))
    together = {key: np.concatenate([p[key] for p in problems]) for key in problems[0]}
    together["bodies"] = np.concatenate(bodies)
    return Problem(" beside ".join(p.name for p in problems), **together)


def parts_of(result, problems):
    """The part of each problem in the result of `beside`."""
    parts = lambda key, of: np.split(result[key], np.cumsum([len(p[of]) for p in problems[:-1]]))
    return [dict(velocity=v, impulse=p)
            for v, p in zip(parts("velocity", "inverse_mass"), parts("impulse", "bodies"))]


def heaps(count):
    """Piles that need different numbers of sweeps, with and without friction and rotations."""
    kinds = (lambda p: p), frictionless, discs
    return [kinds[k % 3](pile(20 + k, 6 + 3 * k, 4 + k % 5)) for k in range(count)]


PROBLEMS = [
    pytest.param(lambda: pile(1), id="pile 1"),
    pytest.param(lambda: pile(2, 30, 12), id="pile 2"),
    pytest.param(lambda: stored("shear-500-eta-0"), id="500 eta 0"),
    pytest.param(lambda: stored("shear-500-eta-0.7"), id="500 eta 0.7"),
    pytest.param(lambda: stored("shear-1000-eta-0"), id="1000 eta 0"),
]
