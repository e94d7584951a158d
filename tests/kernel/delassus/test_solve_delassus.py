"""Solvers of W and q: closed forms, brute force, the contact laws, stop criteria, equal bits.

Velocities and residuals are recomputed with NumPy on the dense W, from the impulses alone.
"""

import itertools

import numpy as np
import pytest
from common import refused
from kernel.contact_problems import dense, problem_of
from oracle import residual
from rcr import _kernel, problems


class Problem(problems.DelassusProblem):
    """With the dense W (2 nc, 2 nc) [1/kg]."""

    def __init__(self, w, q, friction, impulse=None):
        self.w = np.asarray(w, float)
        row, column = np.nonzero(self.w)
        super().__init__((row, column, self.w[row, column]), q, friction, impulse)

    def solve(self, solver="nesterov", **settings):
        w = self.row_start, self.column, self.block.reshape(-1, 4)
        return _kernel.solve_delassus(*w, self.q, self.friction, self.impulse, solver=solver,
                                      **settings)

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


def test_one_row_is_the_problem_of_one_point():
    """Separate points: apart, stick, slide ±, µ = 0, a singular block and Painlevé's case."""
    rng = np.random.default_rng(5)
    count = 500
    w, q = np.zeros((2 * count, 2 * count)), rng.normal(0, 1, (count, 2))
    mu = rng.choice([0.0, 0.3, 0.8, 3.0], count)
    expected = np.zeros((count, 2))
    painleve = 0
    for k in range(count):
        a = rng.normal(0, 1, (2, 2))
        block = np.diag([1.0, 0.0]) if k % 7 == 0 else a @ a.T + 0.1 * np.eye(2)
        painleve += mu[k] * abs(block[0, 1]) > block[0, 0]
        w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = block
        expected[k] = _kernel.solve_coulomb(block[0, 0], block[0, 1], block[1, 1], *q[k], mu[k])
    assert painleve > 20
    found = Problem(w, q, mu).solve("nlgs", tolerance=1e-12)
    assert found["converged"] and found["iterations"] == 10
    # the condition of the blocks is up to 100
    np.testing.assert_allclose(found["impulse"], expected, rtol=1e-12, atol=1e-14)


def test_column_carries_the_weight_above(solver):
    """Ten bodies of mass m fall onto each other at speed v: contact k carries Σ m v above it."""
    count, mass, speed = 10, 2.0, 0.1
    jacobian = np.eye(count) - np.eye(count, k=-1)
    w = np.kron(jacobian @ jacobian.T / mass, np.diag([1.0, 0.0]))
    w += np.kron(np.eye(count), np.diag([0.0, 1.0]))
    q = np.column_stack([jacobian @ np.full(count, -speed), np.zeros(count)])
    found = Problem(w, q, np.full(count, 0.5)).solve(solver, tolerance=1e-12, max_iterations=10000)
    expected = mass * speed * np.arange(count, 0, -1)
    np.testing.assert_allclose(found["impulse"][:, 0], expected, rtol=1e-9)


def test_brute_force_finds_the_same_impulses(solver):
    """Three points on three bodies, small µ: one solution, found by trying all 4³ states."""
    compared = 0
    for seed in range(40):
        problem = heap(seed, 3, 3)
        oracle = enumerated(problem)
        if len(oracle) != 1:
            continue
        compared += 1
        found = problem.solve(solver, tolerance=1e-11, max_iterations=10000)
        np.testing.assert_allclose(found["impulse"], oracle[0], atol=1e-8, err_msg=f"seed {seed}")
    assert compared > 20


@pytest.mark.parametrize("name", PROBLEMS)
def test_solutions_satisfy_the_laws(name, solver):
    """Repeated runs give the same bits; a warm start from the solution needs no sweep."""
    problem = PROBLEMS[name]()
    solve = lambda: problem.solve(solver, tolerance=1e-8, max_iterations=100000)
    found, again = solve(), solve()
    p, u = found["impulse"], found["relative_velocity"]
    recomputed = problem.residual(p)
    assert found["converged"] and recomputed <= 1e-8 * (1 + 1e-6), found["iterations"]
    # rounding of the sums that make u
    assert recomputed == pytest.approx(found["residual"], rel=1e-6, abs=1e-14)
    np.testing.assert_allclose(u, problem.velocity(p), rtol=0, atol=1e-12)
    for key in ("impulse", "relative_velocity", "iterations", "residual"):
        np.testing.assert_array_equal(found[key], again[key], err_msg=key)
    problem.impulse = p
    assert problem.solve(solver, tolerance=1e-6)["iterations"] == 0


@pytest.mark.parametrize("tolerance, count", [(0, 1), (0, 300), (0, 7), (1e-8, 7)])
def test_too_few_sweeps_are_reported_as_not_converged(solver, tolerance, count):
    problem = PROBLEMS["heaps"]()
    found = problem.solve(solver, tolerance=tolerance, max_iterations=count)
    assert not found["converged"] and found["iterations"] == count
    n, t = found["impulse"].T
    assert (n >= 0).all() and (abs(t) <= problem.friction * n + 1e-15).all()
    assert found["residual"] == pytest.approx(problem.residual(found["impulse"]), rel=1e-6)


def test_open_contacts_carry_no_impulse():
    problem = heap(1, 20, 30, load=-5)
    assert (problem.q[:, 0] >= 0).all()
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["iterations"] == 0 and found["converged"] and found["residual"] == 0
    np.testing.assert_array_equal(found["relative_velocity"], problem.q)
    problem.impulse = np.ones_like(problem.q)  # a wrong initial guess vanishes
    found = problem.solve("nlgs", tolerance=1e-8)
    assert found["converged"] and not found["impulse"].any()


def test_contact_of_two_driven_bodies_carries_no_impulse(solver):
    """w_nn = 0: the impulse is zero, even where the contact closes or starts with an impulse."""
    w = np.diag([2.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    q = [[-2, -3], [-1, 1], [-1, 2]]
    for start in (np.zeros((3, 2)), np.full((3, 2), 0.1)):
        found = Problem(w, q, [0.5] * 3, start).solve(solver, tolerance=1e-12)
        p, u = found["impulse"], found["relative_velocity"]
        np.testing.assert_allclose(p, [[1, 0.5], [0, 0], [0, 0]], rtol=1e-12)
        np.testing.assert_allclose(u, [[0, -2.5], [-1, 1], [-1, 2]], atol=1e-12)


def test_rounded_asymmetry_of_w_is_solved_exactly(solver):
    """Files store W_tn and W_nt that differ by 1e-9: the residual refers to W as given."""
    problem = heap(0, 5, 8)  # point 0 sticks
    problem.w[1, 0] *= 1 + 1e-9
    problem = Problem(problem.w, problem.q, problem.friction)
    found = problem.solve(solver, tolerance=1e-11, max_iterations=20000)
    assert found["converged"] and problem.residual(found["impulse"]) <= 1e-11 * (1 + 1e-3)


def test_refuses_friction_that_hides_errors():
    """At µ = 1e5, contact 1 closes and slips at a residual of 1e-5, so no sweep would run."""
    q, start = [[-1, 0], [-1, 1]], [[1, 0], [0, 0]]
    found = Problem(np.eye(4), q, [0, 1e3], start).solve("nlgs")
    assert found["iterations"] > 0 and found["relative_velocity"][1, 0] > -1e-12
    refused(r"mu\[1\] = 100000; expected µ ≥ 0, and at most 1000", Problem, np.eye(4), q,
            [0, 1e5], start)


# ---- malformed problems

def arrays():
    """Three contacts; the first two are coupled."""
    return dict(row_start=[0, 2, 4, 5], column=[0, 1, 0, 1, 2],
                block=np.tile([1.0, 0, 0, 1], (5, 1)), free_velocity=np.zeros((3, 2)),
                friction=np.zeros(3), impulse=np.zeros((3, 2)))


def put(name, index, value):
    array = arrays()[name]
    array[index] = value
    return {name: array}


def rows(row_start, column):
    return dict(row_start=row_start, column=column, block=np.ones((len(column), 4)))


@pytest.mark.parametrize("changes, says", [
    (dict(column=[1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
    (dict(column=[0, 1, 0, 1, 3]), "row 2 of W: columns are out of range or order"),
    (dict(column=[-1, 0, 0, 1, 2]), "row 0 of W: columns are out of range or order"),
    (rows([0, 2, 3, 4], [0, 1, 1, 2]), r"block \(0, 1\) of W has no mirror image"),
    (rows([0, 1, 3, 4], [0, 0, 1, 2]), r"block \(1, 0\) of W has no mirror image"),
    (rows([0, 3, 4, 6], [0, 1, 2, 1, 0, 2]), r"block \(0, 1\) of W has no mirror image"),
    (rows([0, 2, 3, 4], [0, 1, 0, 2]), "row 1 of W has no diagonal block"),
    (dict(row_start=[0, 4, 2, 5]), "the rows of W do not fit its 5 blocks"),
    (dict(row_start=[0, 2, 4, 4]), "the rows of W do not fit its 5 blocks"),
    (put("block", (3, 2), np.nan), r"block \(1, 1\) of W is not finite"),
    (put("block", (4, 0), -1), "W has a negative diagonal at contact 2"),
    (put("free_velocity", (1, 0), np.inf), "contact 1: q or the impulse is not finite"),
    (put("impulse", (2, 1), np.nan), "contact 2: q or the impulse is not finite"),
    (put("friction", 1, -0.5), "contact 1: µ = -0.5; expected µ ≥ 0"),
    (put("friction", 0, np.inf), "contact 0: µ = inf; expected µ ≥ 0"),
    (put("friction", 1, 1e5), "contact 1: µ = 100000 is too large to measure errors"),
    (dict(solver="newton"), "solver 'newton' is not known"),
    (dict(column=[0, 1, 0, 1, 2.5]), "column holds float64"),
    (dict(row_start=[0, 2, 4, 2**32 + 5]), "row_start holds 4294967301"),
])
def test_refuses(changes, says):
    _kernel.solve_delassus(**arrays())
    refused(says, _kernel.solve_delassus, **arrays() | changes)
