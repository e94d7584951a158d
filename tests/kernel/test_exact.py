"""The exact solver: residuals of 1e-10 where sweeps stall, the same bits each time, an honest end where there is none.

Residuals are recomputed with NumPy from the impulses alone (test_solvers).
"""

import numpy as np
import pytest
from rcr import _kernel
from test_solvers import Problem, errors, pile, stored, velocity

TOLERANCE = 1e-10
BUDGET = 20000  # iterations; the problems below need a tenth of it
ROUNDING = 1e-13  # of a residual: sums of some thousand velocities, each to 1e-16


def assert_solved(problem, result, tolerance=TOLERANCE):
    error, size = errors(problem, result["impulse"])
    residual, k = np.linalg.norm(error) / size, int(error.argmax())
    replay = (
        f"{problem.name}, seed {problem.seed}: worst point {k}, bodies {problem['bodies'][k]}, impulse {result['impulse'][k]}, "
        f"error {error[k]:.3e} of {size:.3e}; reported {result['residual']:.3e} after {result['iterations']} iterations, "
        f"recomputed {residual:.3e}, wanted {tolerance:g}"
    )
    assert result["converged"] and residual <= tolerance + ROUNDING, replay
    assert abs(residual - result["residual"]) <= ROUNDING, replay


def problem_of(name, seed, inverse_mass, free_velocity, points):
    """From rows (body 1, body 2, normal, arm 1, arm 2, bias, friction)."""
    t = np.array(points, float)
    return Problem(
        name, seed, inverse_mass=np.array(inverse_mass, float), free_velocity=np.array(free_velocity, float), bodies=t[:, :2].astype(np.int32),
        normal=t[:, 2:4], arm1=t[:, 4:6], arm2=t[:, 6:8], bias=t[:, 8], friction=t[:, 9], impulse=np.zeros((len(t), 2)),
    )


def wall_of_bricks(seed, courses=8, bricks=10, tilt=1e-3):
    """Long particles in courses, each on two of the course below: pairs of near-parallel sides, two points each, so that
    the forces are indeterminate. Gravity and small random velocities; the floor is fixed, the ends are free."""
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
        """Two points at the ends of the common side; positions along x are those of the centres."""
        low, high = max(x1, x2) - length / 2, min(x1, x2) + length / 2
        if high - low < 0.05 * length:
            return
        angle = np.pi / 2 + rng.normal(0, tilt)
        normal = [np.cos(angle), np.sin(angle)]
        for at in (low, high):
            arm1 = [0, 0] if below == floor else [at - x1, height / 2]
            points.append((below, above, *normal, *arm1, at - x2, -height / 2, 0, 0.5))

    for k in range(bricks):
        side(floor, k, x(0, k), x(0, k))
    for course in range(1, courses):
        for k in range(bricks):
            for under in (k - 1, k, k + 1):
                if 0 <= under < bricks:
                    side((course - 1) * bricks + under, course * bricks + k, x(course - 1, under), x(course, k))
    return problem_of(f"bricks {seed}", seed, m, v, points)


def jammed_box(seed, size=14, closing=0.0):
    """Discs on a square grid that fills a box of four prescribed walls, in contact with all neighbours; the top wall comes
    down at the speed `closing`, which nothing can follow."""
    rng = np.random.default_rng(seed)
    count = size * size
    m = np.tile([1.0, 1.0, 8.0], (count + 4, 1))
    m[count:] = 0
    v = rng.normal(0, 0.3, (count + 4, 3))
    v[count:] = 0
    v[count + 3, 1] = -closing
    points = []
    for i in range(size):
        for j in range(size):
            here = i * size + j
            for other, normal in (
                (here + 1 if j + 1 < size else count + 1, (1, 0)),
                (here + size if i + 1 < size else count + 3, (0, 1)),
                (count if j == 0 else None, (-1, 0)),
                (count + 2 if i == 0 else None, (0, -1)),
            ):
                if other is not None:
                    n = np.array(normal)
                    points.append((here, other, *n, *(0.5 * n), *(-0.5 * n if other < count else 0 * n), 0, 0.4))
    return problem_of(f"jammed box {seed}", seed, m, v, points)


PROBLEMS = [
    pytest.param(lambda: pile(1), id="pile 1"),
    pytest.param(lambda: pile(2, 30, 12), id="pile 2"),
    pytest.param(lambda: pile(4, 20, 20), id="pile 4"),
    pytest.param(lambda: wall_of_bricks(1), id="bricks 1"),
    pytest.param(lambda: wall_of_bricks(2, 15, 20), id="bricks 2"),
    pytest.param(lambda: wall_of_bricks(3, tilt=0), id="bricks parallel"),
    pytest.param(lambda: jammed_box(1), id="jammed box"),
    pytest.param(lambda: stored("n500_e0_0"), id="n500 eta 0"),
    pytest.param(lambda: stored("n500_e0.7_0"), id="n500 eta 0.7"),
    pytest.param(lambda: stored("n2000_e0_0"), id="n2000 eta 0"),
]


@pytest.mark.parametrize("make", PROBLEMS)
def test_reaches_1e_10_from_a_cold_start(make):
    problem = make().cold()
    assert_solved(problem, problem.solve("exact", tolerance=TOLERANCE, max_iterations=BUDGET))


@pytest.mark.parametrize("name", ["n500_e0_0", "n500_e0.7_0"])
def test_reaches_1e_10_from_a_warm_start(name):
    problem = stored(name)
    assert_solved(problem, problem.solve("exact", tolerance=TOLERANCE, max_iterations=BUDGET))


@pytest.mark.parametrize("make", [lambda: pile(3), lambda: wall_of_bricks(4)])
def test_reaches_1e_10_without_friction(make):
    problem = make()
    problem["friction"] = np.zeros_like(problem["friction"])
    result = problem.solve("exact", tolerance=TOLERANCE, max_iterations=BUDGET)
    assert_solved(problem, result)
    assert not result["impulse"][:, 1].any()


def test_resultant_of_an_indeterminate_support_is_the_weight():
    """A beam falls at 1 m/s onto five points of a floor: Σ p_n = m v, Σ x p_n = 0, no sliding, whatever the shares."""
    mass = 3.0
    points = [(0, 1, 0, 1, 0, 0, x, -0.1, 0, 0.5) for x in (-2.0, -1.0, 0.0, 0.5, 2.0)]
    problem = problem_of("beam", None, [[0, 0, 0], [1 / mass, 1 / mass, 0.2]], [[0, 0, 0], [0, -1, 0]], points)
    result = problem.solve("exact", tolerance=1e-12, max_iterations=BUDGET)
    assert_solved(problem, result, 1e-12)
    p = result["impulse"]
    assert p[:, 0].sum() == pytest.approx(mass, rel=1e-11)
    assert (p[:, 0] * problem["arm2"][:, 0]).sum() == pytest.approx(0, abs=1e-11)
    np.testing.assert_allclose(result["velocity"][1], 0, atol=1e-11)


def test_every_run_gives_the_same_bits():
    problem = pile(2, 30, 12)
    first = problem.solve("exact", tolerance=1e-8, max_iterations=BUDGET)
    for settings in ({}, {"lanes": 1}, {"lanes": 4}, {"threads": 2}):
        other = problem.solve("exact", tolerance=1e-8, max_iterations=BUDGET, **settings)
        np.testing.assert_array_equal(other["impulse"], first["impulse"], err_msg=str(settings))
        assert other["iterations"] == first["iterations"]


@pytest.mark.parametrize("budget", [1, 7, 50, 200, 300])
def test_stops_short_honestly(budget):
    """The budget is kept; what is reported is what is left, and it is no worse than where the sweeps handed over."""
    problem = pile(4, 20, 20)
    swept = problem.solve("nesterov", tolerance=1e-5, max_iterations=(budget + 1) // 2)
    result = problem.solve("exact", tolerance=0, max_iterations=budget)
    error, size = errors(problem, result["impulse"])
    assert not result["converged"] and result["iterations"] == budget
    assert abs(np.linalg.norm(error) / size - result["residual"]) <= ROUNDING
    assert result["residual"] <= swept["residual"] * (1 + 1e-9)
    np.testing.assert_allclose(result["velocity"], velocity(problem, result["impulse"]), rtol=0, atol=1e-11)


@pytest.mark.parametrize("tolerance, violation", [(0, 0.01), (0, np.inf), (1e-10, 0), (0, 0)])
def test_all_iterations_count_where_a_criterion_is_0(tolerance, violation):
    """Nothing meets it, but the best iterate is that of the steps, not that of the sweeps before them."""
    problem = pile(4, 20, 20)
    settings = dict(tolerance=tolerance, violation=violation, max_iterations=2000)
    swept, result = (problem.solve(solver, **settings) for solver in ("nesterov", "exact"))
    error, size = errors(problem, result["impulse"])
    assert not result["converged"] and result["iterations"] == 2000
    assert np.linalg.norm(error) / size < 1e-6 * swept["residual"] and result["violation"] < 1e-6 * swept["violation"]


def test_box_that_is_crushed_has_no_solution():
    """No impulse keeps rigid discs out of a wall that comes down on a full box. The impulses grow without bound, so that a
    relative residual falls all the same; the velocities tell, and all numbers stay finite."""
    problem = jammed_box(2, 6, closing=0.1)
    for tolerance in (1e-4, 1e-6, 1e-8):
        result = problem.solve("exact", tolerance=tolerance, max_iterations=3000)
        assert not result["converged"] and result["violation"] > 0.01, (tolerance, result["residual"], result["violation"])
        assert np.isfinite(result["impulse"]).all() and np.isfinite(result["velocity"]).all()


def test_a_problem_without_contacts():
    problem = pile(1)
    none = Problem("none", **{k: v if k in ("inverse_mass", "free_velocity") else v[:0] for k, v in problem.items()})
    result = none.solve("exact", tolerance=1e-10)
    assert result["converged"] and result["residual"] == 0


@pytest.mark.parametrize("name", ["n500_e0.7_0", "n2000_e0_0"])
def test_auto_takes_the_exact_tier_for_fine_tolerances(name):
    problem = stored(name).cold()
    assert_solved(problem, problem.solve("auto", tolerance=1e-9, max_iterations=BUDGET), 1e-9)


@pytest.mark.parametrize("friction, same", [(0.0, "nesterov"), (0.5, "exact")])
def test_auto_sweeps_to_fine_tolerances_where_nothing_has_friction(friction, same):
    problem = pile(1, 30, 30).cold()
    problem["friction"][:] = friction
    auto, other = (problem.solve(solver, tolerance=1e-9, max_iterations=1500) for solver in ("auto", same))
    assert auto["iterations"] == other["iterations"] and (auto["impulse"] == other["impulse"]).all()
    if not friction:
        assert_solved(problem, auto, 1e-9)


# --- linear algebra -----------------------------------------------------------------------------------------------------


def grid(rows, columns):
    at = lambda i, j: i * columns + j
    across = [(at(i, j), at(i, j + 1)) for i in range(rows) for j in range(columns - 1)]
    return rows * columns, across + [(at(i + 1, j), at(i, j)) for i in range(rows - 1) for j in range(columns)]


def star(leaves):
    return leaves + 1, [(0, k) for k in range(1, leaves + 1)]


@pytest.mark.parametrize(
    "size, pairs",
    [(1, []), (2, [(1, 0)]), (7, []), star(30), grid(9, 13), (40, [(i, i + 1) for i in range(39)]), (12, [(i, j) for i in range(12) for j in range(i)])],
    ids=["one row", "two rows", "diagonal", "star", "grid", "chain", "full"],
)
def test_block_lu_solves_like_a_dense_one(size, pairs):
    rng = np.random.default_rng(size)
    dense = np.zeros((3 * size, 3 * size))
    block = lambda i, j: (slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3))
    for i in range(size):
        dense[block(i, i)] = rng.normal(0, 1, (3, 3)) + 8 * np.eye(3)
    for i, j in pairs:
        dense[block(i, j)], dense[block(j, i)] = rng.normal(0, 1, (2, 3, 3))
    stack = lambda places: np.array([dense[block(i, j)] for i, j in places]).reshape(-1, 3, 3)
    b = rng.normal(0, 1, (size, 3))
    x = _kernel.solve_blocks(
        np.array(pairs, np.int32).reshape(-1, 2), stack([(i, i) for i in range(size)]), stack(pairs), stack([(j, i) for i, j in pairs]), b
    )
    # backward stable without pivoting across blocks, the diagonal being heavy
    np.testing.assert_allclose(x.ravel(), np.linalg.solve(dense, b.ravel()), rtol=0, atol=1e-12 * np.linalg.cond(dense))


def test_block_lu_says_that_a_block_is_singular():
    with pytest.raises(ValueError, match="singular"):
        _kernel.solve_blocks(np.zeros((0, 2), np.int32), np.zeros((2, 3, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3, 3)), np.ones((2, 3)))


def fill(size, pairs, order):
    """Off-diagonal entries of the factor: eliminate node by node."""
    neighbours = [set() for _ in range(size)]
    for i, j in pairs:
        neighbours[i].add(j), neighbours[j].add(i)
    entries = 0
    for k in order:
        entries += len(neighbours[k])
        for i in neighbours[k]:
            neighbours[i] |= neighbours[k]
            neighbours[i] -= {i, k}
    return entries


@pytest.mark.parametrize("size, pairs", [star(30), (40, [(i, i + 1) for i in range(39)]), (31, [((k - 1) // 2, k) for k in range(1, 31)])])
def test_order_of_a_tree_has_no_fill(size, pairs):
    order = _kernel.minimum_degree_order(size, pairs)
    assert sorted(order) == list(range(size))
    assert fill(size, pairs, order) == len(pairs)


def test_order_of_a_grid_has_little_fill():
    """20 × 20: the natural order gives about n^1.5 = 8000 entries, AMD of SuiteSparse 3302."""
    size, pairs = grid(20, 20)
    order = _kernel.minimum_degree_order(size, pairs)
    assert sorted(order) == list(range(size))
    assert fill(size, pairs, order) < 3500 < 7000 < fill(size, pairs, range(size))
