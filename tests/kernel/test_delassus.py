"""Problems of W and q: one row against one point, what must not change a bit, islands, rows in any order, hard ones, refusals.

Residuals and velocities are recomputed here with NumPy from the impulses alone, on the dense W.
"""

import numpy as np
import pytest
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


# ---------------------------------------------------------------------------------------------- one row


@pytest.mark.parametrize("lanes", [1, 4, 8])
def test_one_row_is_the_problem_of_one_point(lanes):
    """Each an island of its own: apart, stick, slide either way, no friction, nothing that friction moves, Painlevé's case."""
    rng = np.random.default_rng(5)
    count = 500
    w, q, mu = np.zeros((2 * count, 2 * count)), rng.normal(0, 1, (count, 2)), rng.choice([0.0, 0.3, 0.8, 3.0], count)
    expected = np.zeros((count, 2))
    painleve = 0
    for k in range(count):
        a = rng.normal(0, 1, (2, 2))
        block = np.diag([1.0, 0.0]) if k % 7 == 0 else a @ a.T + 0.1 * np.eye(2)
        painleve += mu[k] * abs(block[0, 1]) > block[0, 0]
        w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = block
        expected[k] = _kernel.solve_coulomb(block[0, 0], block[0, 1], block[1, 1], *q[k], mu[k])
    assert painleve > 20
    found = Problem(w, q, mu).solve("nlgs", tolerance=1e-12, lanes=lanes)
    assert found["converged"] and found["iterations"] <= 2
    np.testing.assert_allclose(found["impulse"], expected, rtol=1e-12, atol=1e-14)  # condition of the blocks up to 100


def test_what_nothing_moves_carries_nothing():
    """w_nn = 0, between two prescribed bodies: no impulse, even where it approaches or is told to start with one."""
    w = np.diag([2.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    for start in (np.zeros((3, 2)), np.full((3, 2), 0.1)):
        found = Problem(w, [[-2, -3], [-1, 1], [-1, 2]], [0.5] * 3, start).solve("nesterov", tolerance=1e-12)
        np.testing.assert_allclose(found["impulse"], [[1, 0.5], [0, 0], [0, 0]], rtol=1e-12)
        np.testing.assert_allclose(found["relative_velocity"], [[0, -2.5], [-1, 1], [-1, 2]], atol=1e-12)


# ---------------------------------------------------------------------------------------------- laws, bits, order


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_solutions_satisfy_the_laws(name, solver):
    problem = of(name)
    tolerance = 1e-9 if solver in ("exact", "auto") else 1e-6
    found = problem.solve(solver, tolerance=tolerance, max_iterations=100000)
    recomputed = problem.residual(found["impulse"])
    assert found["converged"] and recomputed <= tolerance * (1 + 1e-6), f"{name}, {solver}: {recomputed:.3e} after {found['iterations']}"
    assert recomputed == pytest.approx(found["residual"], rel=1e-6, abs=1e-14)  # rounding of the sums that make u
    np.testing.assert_allclose(found["relative_velocity"], problem.velocity(found["impulse"]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_lanes_change_no_bit(name, solver):
    problem = of(name)
    first, *others = [problem.solve(solver, tolerance=1e-6, max_iterations=3000, lanes=lanes) for lanes in (1, 4, 8, 0)]
    for other in others:
        for key in ("impulse", "relative_velocity", "iterations", "residual"):
            np.testing.assert_array_equal(first[key], other[key], err_msg=f"{name}, {solver}, {key}")


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("seed", range(3))
def test_rows_in_any_order(name, seed):
    """What solves the problem with its rows permuted solves the problem."""
    problem = of(name)
    order = np.random.default_rng(seed).permutation(len(problem.q))
    found = problem.permuted(order).solve("exact", tolerance=1e-10, max_iterations=100000)
    p = np.zeros_like(problem.q)
    p[order] = found["impulse"]
    assert problem.residual(p) <= 1e-10 * (1 + 1e-4), f"{name}, order {seed}"


def test_islands_do_not_disturb_each_other():
    """A heap among others ends where it ends alone: without friction the solution is unique where W is positive definite."""
    parts = [heap(seed, 4, 4) for seed in range(30)]
    for part in parts:
        part.friction[:] = 0
        part.w += 0.1 * np.eye(len(part.w))
    parts = [Problem(part.w, part.q, part.friction) for part in parts]
    size = sum(len(part.q) for part in parts)
    order = np.random.default_rng(size).permutation(size)
    found = np.zeros((size, 2))
    found[order] = packed(*parts).solve("nesterov", tolerance=1e-12, max_iterations=10000)["impulse"]
    alone = np.concatenate([part.solve("nlgs", tolerance=1e-12, max_iterations=10000)["impulse"] for part in parts])
    np.testing.assert_allclose(found, alone, rtol=0, atol=1e-9 * abs(alone).max())


def test_what_is_at_rest_needs_no_sweep():
    problem = packed(*[heap(seed, 4, 6, load=-5) for seed in range(20)])
    assert (problem.q[:, 0] >= 0).all()
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["iterations"] == 0 and found["converged"] and found["residual"] == 0
    assert not found["impulse"].any()
    np.testing.assert_array_equal(found["relative_velocity"], problem.q)
    problem.impulse = np.ones_like(problem.q)  # wrong impulses to start from go away
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["converged"] and not found["impulse"].any()


# ---------------------------------------------------------------------------------------------- when to stop


@pytest.mark.parametrize("solver", SWEEPS)
def test_tolerance_zero_takes_every_sweep(solver):
    for count in (1, 7, 300):
        assert of("heaps").solve(solver, tolerance=0, max_iterations=count)["iterations"] == count


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("solver", SWEEPS)
def test_stops_when_the_tolerance_is_met(name, solver):
    """Not only at every tenth sweep: what sweeps change tells of it. At most two more than with the residual measured after each."""
    problem = of(name)
    for tolerance in (1e-2, 1e-4, 1e-6):
        each, tenth = [problem.solve(solver, tolerance=tolerance, max_iterations=100000, check_interval=count) for count in (1, 10)]
        assert tenth["residual"] <= tolerance
        assert each["iterations"] <= tenth["iterations"] <= each["iterations"] + 2, f"{name}, {solver}, {tolerance:g}"


def test_warm_start():
    """From its own solution a problem needs no sweep."""
    problem = of("heaps")
    problem.impulse = problem.solve("exact", tolerance=1e-9, max_iterations=100000)["impulse"]
    for solver in SOLVERS:
        assert problem.solve(solver, tolerance=1e-6)["iterations"] == 0


def test_newton_where_sweeps_lead_no_further():
    """A column of which the uppermost is a million times heavier than each of the rest."""
    count = 30
    jacobian = np.eye(count) - np.eye(count, k=-1)
    inverse_mass = np.append(np.ones(count - 1), 1e-6)
    w = np.kron(jacobian * inverse_mass @ jacobian.T, np.diag([1.0, 0.0])) + np.kron(np.eye(count), np.diag([0.0, 1.0]))
    problem = Problem(w, np.column_stack([jacobian @ np.full(count, -0.1), np.zeros(count)]), np.full(count, 0.5))
    swept = problem.solve("nesterov", tolerance=1e-12, max_iterations=20000)
    found = problem.solve("exact", tolerance=1e-12, max_iterations=100000)
    assert not swept["converged"] and found["converged"] and problem.residual(found["impulse"]) <= 2e-12  # rounding of W p: p is 1e6 times u
    momentum = (0.1 / inverse_mass)[::-1].cumsum()[::-1]  # of all that is above
    np.testing.assert_allclose(found["impulse"][:, 0], momentum, rtol=1e-3)  # 1e-12 times the condition, 1e9


# ---------------------------------------------------------------------------------------------- refusals


def spoiled(**changes):
    arrays = dict(row_start=[0, 2, 4, 5], column=[0, 1, 0, 1, 2], block=np.tile([1.0, 0, 0, 1], (5, 1)), free=np.zeros((3, 2)), friction=np.zeros(3),
                  impulse=np.zeros((3, 2)))  # fmt: skip
    return _kernel.solve_delassus(**{**arrays, **changes})


def put(shape, index, value):
    array = np.tile([1.0, 0, 0, 1], (5, 1)) if shape is None else np.zeros(shape)
    array[index] = value
    return array


@pytest.mark.parametrize(
    "changes, says",
    [
        (dict(column=[1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
        (dict(column=[0, 1, 0, 1, 3]), "row 2 of W: columns are out of range or order"),
        (dict(column=[-1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
        (dict(row_start=[0, 2, 3, 4], column=[0, 1, 1, 2], block=np.ones((4, 4))), r"block \(0, 1\) of W has no mirror image"),
        (dict(row_start=[0, 1, 3, 4], column=[0, 0, 1, 2], block=np.ones((4, 4))), r"block \(1, 0\) of W has no mirror image"),
        (dict(row_start=[0, 3, 4, 6], column=[0, 1, 2, 1, 0, 2], block=np.ones((6, 4))), r"block \(0, 1\) of W has no mirror image"),
        (dict(row_start=[0, 2, 3, 4], column=[0, 1, 0, 2], block=np.ones((4, 4))), "row 1 of W has no diagonal block"),
        (dict(row_start=[0, 4, 2, 5]), "the rows of W do not fit its 5 blocks"),
        (dict(row_start=[0, 2, 4, 4]), "the rows of W do not fit its 5 blocks"),
        (dict(block=put(None, (3, 2), np.nan)), r"block \(1, 1\) of W holds a number that is not finite"),
        (dict(block=put(None, (4, 0), -1)), "W has a negative diagonal at contact 2"),
        (dict(free=put((3, 2), (1, 0), np.inf)), "contact 1: q or the impulse is not finite"),
        (dict(impulse=put((3, 2), (2, 1), np.nan)), "contact 2: q or the impulse is not finite"),
        (dict(friction=put(3, 1, -0.5)), "contact 1: µ = -0.5; wanted µ ≥ 0"),
        (dict(friction=put(3, 0, np.inf)), "contact 0: µ = inf; wanted µ ≥ 0"),
        (dict(lanes=3), "lanes = 3"),
    ],
)
def test_refuses(changes, says):
    spoiled()
    with pytest.raises(ValueError, match=says):
        spoiled(**changes)
