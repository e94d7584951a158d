"""Sweep solvers of the contact problem: one problem set, every solver, one residual; what must not change a bit.

The residual and the velocities are recomputed here with NumPy from the impulses alone.
"""

from pathlib import Path

import numpy as np
import pytest
from rcr import _kernel

SWEEPS = ["nlgs", "sor", "nesterov"]
DATA = Path(__file__).parents[3] / "shared" / "data"


class Problem(dict):
    """Arrays of `_kernel.solve`, with the seed that made them."""

    def __init__(self, name, seed=None, **arrays):
        super().__init__(arrays)
        self.name, self.seed = name, seed

    def cold(self):
        return Problem(self.name, self.seed, **{**self, "impulse": np.zeros_like(self["impulse"])})

    def solve(self, solver="nesterov", **settings):
        return _kernel.solve(**self, solver=solver, **settings)


def jacobian_times(problem, v):
    """Relative velocities (nc, 2) for body velocities (nb, 3)."""
    a, b = problem["bodies"].T
    n, r1, r2 = problem["normal"], problem["arm1"], problem["arm2"]
    turned = lambda w, r: w[:, None] * np.stack([-r[:, 1], r[:, 0]], 1)
    u = v[b, :2] + turned(v[b, 2], r2) - v[a, :2] - turned(v[a, 2], r1)
    return np.stack([(u * n).sum(1), n[:, 0] * u[:, 1] - n[:, 1] * u[:, 0]], 1)


def velocity(problem, p):
    """v_free + M⁻¹Jᵀp, (nb, 3)."""
    a, b = problem["bodies"].T
    n, r1, r2 = problem["normal"], problem["arm1"], problem["arm2"]
    f = p[:, :1] * n + p[:, 1:] * np.stack([-n[:, 1], n[:, 0]], 1)
    cross = lambda r: r[:, 0] * f[:, 1] - r[:, 1] * f[:, 0]
    sums = np.zeros_like(problem["free_velocity"])
    np.add.at(sums, b, np.column_stack([f, cross(r2)]))
    np.add.at(sums, a, -np.column_stack([f, cross(r1)]))
    return problem["free_velocity"] + problem["inverse_mass"] * sums


def errors(problem, p):
    """Natural-map error of every point (nc,) and ‖p‖; residual.hpp."""
    a, b = problem["bodies"].T
    n, m = problem["normal"], problem["inverse_mass"]
    turn = lambda r: r[:, 0] * n[:, 1] - r[:, 1] * n[:, 0]
    w = ((m[a, :2] + m[b, :2]) * n**2).sum(1) + m[a, 2] * turn(problem["arm1"]) ** 2 + m[b, 2] * turn(problem["arm2"]) ** 2
    mu, moves = problem["friction"], w > 0
    u = jacobian_times(problem, velocity(problem, p))
    w = np.where(moves, w, 1)
    x = p[:, 0] - (u[:, 0] + problem["bias"] + mu * abs(u[:, 1])) / w
    y = p[:, 1] - u[:, 1] / w
    face = np.maximum(x + mu * abs(y), 0) / (1 + mu**2)
    inside = (abs(y) <= mu * x) & (x > 0)
    error = np.hypot(p[:, 0] - np.where(inside, x, face), p[:, 1] - np.where(inside, y, mu * face * np.sign(y)))
    return np.where(moves, error, 0), np.linalg.norm(p[moves])


def pile(seed, columns=12, rows=9):
    """Polydisperse particles in loose rows on a fixed floor between a fixed wall and one pushed along x; some pairs touch
    at two points, some contacts are open, some rub against a body that may only turn."""
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
        for k in range(points):
            along = 0.0 if points == 1 else (0.3 if k else -0.3)
            arm1 = 0.5 * normal + along * tangent
            arm2 = -0.5 * normal + (along + 0.05) * tangent
            if a >= count:
                arm1 = np.zeros(2) if a != spinner else arm1
            if b >= count:
                arm2 = np.zeros(2) if b != spinner else arm2
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
    t = t[np.lexsort((t[:, 1], t[:, 0]))]
    return Problem(
        f"pile {seed}", seed, inverse_mass=inverse_mass, free_velocity=v, bodies=t[:, :2].astype(np.int32), normal=t[:, 2:4],
        arm1=t[:, 4:6], arm2=t[:, 6:8], bias=t[:, 8], friction=t[:, 9], impulse=np.zeros((len(t), 2)),
    )


def stored(name):
    """A packing under shear (data README), or a skip where it is not there."""
    path = DATA / f"{name}.npz"
    if not path.exists():
        pytest.skip(f"{path.name} is not here")
    d = np.load(path)
    order = np.lexsort((d["b"], d["a"]))
    m = np.column_stack([d["im"], d["im"], d["iI"]])
    m[int(d["meta"][2]) :, 1] = 0  # walls move along x only
    take = lambda key: np.ascontiguousarray(d[key][order], float)
    return Problem(
        name, inverse_mass=m, free_velocity=d["vfree"], bodies=np.column_stack([d["a"], d["b"]])[order].astype(np.int32), normal=take("n"),
        arm1=take("ra"), arm2=take("rb"), bias=take("bn"), friction=take("mu"), impulse=take("p0"),
    )


PROBLEMS = [
    pytest.param(lambda: pile(1), id="pile 1"),
    pytest.param(lambda: pile(2, 30, 12), id="pile 2"),
    pytest.param(lambda: stored("n500_e0_0"), id="n500 eta 0"),
    pytest.param(lambda: stored("n500_e0.7_0"), id="n500 eta 0.7"),
    pytest.param(lambda: stored("n2000_e0_0"), id="n2000 eta 0"),
]


def assert_laws(problem, result, tolerance):
    """The residual is the one reported and below the tolerance; the velocities follow from the impulses."""
    error, size = errors(problem, result["impulse"])
    k = int(error.argmax())
    replay = (
        f"{problem.name}, seed {problem.seed}: worst point {k}, bodies {problem['bodies'][k]}, impulse {result['impulse'][k]}, "
        f"u {result['relative_velocity'][k]}, error {error[k]:.3e} of {size:.3e}; reported residual {result['residual']:.6e}, tolerance {tolerance:g}"
    )
    residual = np.linalg.norm(error) / size
    # rounding: velocities are sums of some thousand terms, and a residual of 1e-4 holds 1e-16 / 1e-4 of them
    assert residual == pytest.approx(result["residual"], rel=1e-9), f"recomputed {residual:.12e}. {replay}"
    assert residual <= tolerance and result["converged"], replay
    expected = velocity(problem, result["impulse"])
    np.testing.assert_allclose(result["velocity"], expected, rtol=0, atol=1e-12 * abs(expected).max(), err_msg=replay)


@pytest.mark.parametrize("make", PROBLEMS)
@pytest.mark.parametrize("solver", SWEEPS)
def test_reaches_the_tolerance_and_says_so(make, solver):
    problem = make().cold()
    tolerance = 1e-4 if solver == "nesterov" else 1e-3
    assert_laws(problem, problem.solve(solver, tolerance=tolerance, max_iterations=20000), tolerance)


@pytest.mark.parametrize("make", PROBLEMS)
@pytest.mark.parametrize("solver", SWEEPS)
def test_lanes_and_threads_change_no_bit(make, solver):
    problem = make()
    first = problem.solve(solver, tolerance=0, max_iterations=35, lanes=1)
    for lanes in (1, 4, 8):
        for threads in (1, 2, 4):
            other = problem.solve(solver, tolerance=0, max_iterations=35, lanes=lanes, threads=threads)
            for key in ("impulse", "velocity", "residual", "violation"):
                differ = np.flatnonzero(np.asarray(other[key]) != np.asarray(first[key]))
                assert not len(differ), f"{problem.name}, seed {problem.seed}: {key} differs at {differ[0]} with {lanes} lanes, {threads} threads"


def test_residual_of_an_open_contact_without_friction_or_sliding():
    """u_t = µ = 0 lies on the edge of two faces of the projection; an open contact has no error there."""
    problem = pile(1)
    problem["friction"] = np.zeros_like(problem["friction"])
    problem["free_velocity"] = np.zeros_like(problem["free_velocity"])
    problem["bias"] = np.ones_like(problem["bias"])
    result = problem.solve(tolerance=1e-4)
    assert result["residual"] == 0 and result["iterations"] == 0 and not result["impulse"].any()


def test_momentum_needs_fewer_sweeps():
    problem = pile(2, 30, 12)
    plain, fast = (problem.solve(s, tolerance=1e-4, max_iterations=20000)["iterations"] for s in ("nlgs", "nesterov"))
    assert fast < plain / 2, f"{fast} accelerated sweeps against {plain}"


def shear_steps(seed, steps):
    """The pile again and again, a few per cent of its pairs gone or back each third step."""
    rng = np.random.default_rng(seed)
    whole = pile(seed, 20, 12)
    pairs, pair_of = np.unique(whole["bodies"], axis=0, return_inverse=True)
    there = rng.random(len(pairs)) < 0.9
    for step in range(steps):
        if step % 3 == 0:
            flips = np.where(there, rng.random(len(pairs)) < 0.03, rng.random(len(pairs)) < 0.3)
            there = there ^ flips
        kept = there[pair_of.ravel()]
        yield Problem(
            f"step {step}", seed,
            **{key: value if key in ("inverse_mass", "free_velocity") else np.ascontiguousarray(value[kept]) for key, value in whole.items()},
        )


@pytest.mark.parametrize("solver", SWEEPS)
def test_a_workspace_follows_pairs_that_come_and_go(solver):
    workspace = _kernel.Workspace()
    before, changes = None, 0
    for problem in shear_steps(5, 60):
        result = problem.solve(solver, tolerance=1e-3, max_iterations=20000, workspace=workspace)
        assert_laws(problem, result, 1e-3)
        changes += before is None or not np.array_equal(before, problem["bodies"])
        before = problem["bodies"]
    assert workspace.layouts == changes < 60, "laid out anew where nothing changed, or not where something did"


def altered(problem, rng):
    """A problem that comes before: pairs gone or turned round, one point instead of two or two instead of one, other
    impulses, velocities and friction, now and then other masses."""
    count = len(problem["bodies"])
    rows = np.repeat(np.arange(count), rng.choice([0, 1, 2], count, p=[0.1, 0.8, 0.1]))
    new = Problem(
        f"before {problem.name}", problem.seed,
        **{key: value.copy() if key in ("inverse_mass", "free_velocity") else value[rows] for key, value in problem.items()},
    )
    turned = rng.random(len(rows)) < 0.05
    new["bodies"][turned] = new["bodies"][turned, ::-1]
    new["impulse"] = rng.normal(0, 1, new["impulse"].shape)
    new["free_velocity"] *= rng.uniform(0, 100)
    new["friction"] = rng.uniform(0, 1, len(rows))
    if rng.random() < 0.3:
        new["inverse_mass"][rng.integers(len(new["inverse_mass"]), size=5)] = rng.choice([0.0, 1.0, 2.0], (5, 3))
    return new


@pytest.mark.parametrize("solver", SWEEPS)
def test_a_workspace_remembers_nothing(solver):
    """Bitwise the same whatever the workspace solved before: a simulation that is saved and loaded starts with a new one."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        problem = pile(seed, 14, 8)
        workspace = _kernel.Workspace()
        for _ in range(rng.integers(1, 4)):
            altered(problem, rng).solve(solver, tolerance=0, max_iterations=int(rng.integers(1, 30)), workspace=workspace)
        kept = [problem.solve(solver, tolerance=0, max_iterations=25, workspace=workspace) for _ in range(2)]
        alone = problem.solve(solver, tolerance=0, max_iterations=25)
        for number, result in enumerate(kept):
            for key in ("impulse", "velocity", "residual", "violation"):
                differ = np.flatnonzero(np.asarray(result[key]) != np.asarray(alone[key]))
                assert not len(differ), f"seed {seed}, solve {number}: {key} differs first at {differ[0]} of {len(differ)}"


def test_a_workspace_changes_no_bit_with_lanes_and_threads():
    results = []
    for lanes, threads in ((1, 1), (4, 1), (8, 2), (8, 4)):
        workspace = _kernel.Workspace()
        results.append([p.solve(tolerance=0, max_iterations=10, lanes=lanes, threads=threads, workspace=workspace) for p in shear_steps(6, 30)])
    for step, (first, *others) in enumerate(zip(*results)):
        for other in others:
            differ = np.flatnonzero((other["velocity"] != first["velocity"]).any(1))
            assert not len(differ), f"step {step}, body {differ[0]}: {other['velocity'][differ[0]]} against {first['velocity'][differ[0]]}"


def test_a_workspace_takes_any_problem():
    """Other bodies, other kinds of bodies, unsorted points, none at all: laid out anew, same answer as without."""
    workspace = _kernel.Workspace()
    a, b = pile(1), pile(3, 5, 4)
    order = np.random.default_rng(0).permutation(len(a["bodies"]))
    mixed = Problem("mixed", **{k: v if k in ("inverse_mass", "free_velocity") else np.ascontiguousarray(v[order]) for k, v in a.items()})
    none = Problem("none", **{k: v if k in ("inverse_mass", "free_velocity") else v[:0] for k, v in a.items()})
    for problem in (a, b, mixed, none, a):
        alone, kept = problem.solve(tolerance=0, max_iterations=20), problem.solve(tolerance=0, max_iterations=20, workspace=workspace)
        np.testing.assert_array_equal(kept["impulse"], alone["impulse"], err_msg=problem.name)
    assert none.solve()["converged"] and none.solve()["iterations"] == 0


def test_body_with_more_contacts_than_colours():
    """A disc of 40 contacts between 40 fixed neighbours' rims: most pairs find no colour; all are solved."""
    count = 40
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    m = np.ones((count + 1, 3))
    v = np.zeros((count + 1, 3))
    v[1:, :2] = -0.1 * normal + 0.01
    problem = Problem(
        "hub", inverse_mass=m, free_velocity=v, bodies=np.column_stack([np.zeros(count), np.arange(1, count + 1)]).astype(np.int32),
        normal=normal, arm1=3 * normal, arm2=-0.5 * normal, bias=np.zeros(count), friction=np.full(count, 0.4), impulse=np.zeros((count, 2)),
    )
    for solver in SWEEPS:
        assert_laws(problem, problem.solve(solver, tolerance=1e-6, max_iterations=5000), 1e-6)


def test_stop_criteria():
    problem = pile(2, 30, 12)
    loose = problem.solve(tolerance=0.5, max_iterations=5000, check_interval=1, violation=np.inf)
    tight = problem.solve(tolerance=0.5, max_iterations=5000, check_interval=1, violation=1e-4)
    assert loose["violation"] > 1e-4 >= tight["violation"] and tight["converged"], (loose["violation"], tight["violation"])
    assert tight["iterations"] > loose["iterations"]
    assert problem.solve(tolerance=0.5, min_iterations=77)["iterations"] >= 77
    mean_force = problem.solve("nlgs", tolerance=0, max_iterations=5000, check_interval=1, mean_force_change=1e-3)
    assert mean_force["converged"] and 1 < mean_force["iterations"] < 5000
    stuck = problem.solve("nlgs", tolerance=1e-300, max_iterations=20000, stall_sweeps=50)
    assert not stuck["converged"] and stuck["iterations"] < 20000
    assert problem.solve(tolerance=0, max_iterations=33)["iterations"] == 33


@pytest.mark.parametrize(
    "change, says",
    [
        ({"solver": "newton"}, "newton"),
        ({"tolerance": -1.0}, "tolerance = -1"),
        ({"tolerance": float("nan")}, "tolerance = nan"),
        ({"max_iterations": 0}, "maxIterations = 0"),
        ({"threads": 0}, "threads = 0"),
        ({"lanes": 3}, "lanes = 3"),
    ],
)
def test_refuses_what_makes_no_sense(change, says):
    with pytest.raises(ValueError, match=says):
        pile(1).solve(**change)


@pytest.mark.parametrize(
    "name, index, value, says",
    [
        ("inverse_mass", (3, 1), -1.0, "body 3: an inverse mass is negative"),
        ("inverse_mass", (3, 2), np.inf, "body 3: a mass or velocity is not finite"),
        ("free_velocity", (4, 0), np.nan, "body 4: a mass or velocity is not finite"),
        ("bodies", (5, 0), -1, "contact point 5: body id out of range"),
        ("bodies", (5, 1), 10**6, "contact point 5: body id out of range"),
        ("bodies", 6, 7, "contact point 6: both bodies are the same"),
        ("normal", (7, 0), 2.0, "contact point 7: the normal is not of unit length"),
        ("normal", (7, 0), np.nan, "contact point 7: a number is not finite"),
        ("arm1", (8, 1), np.inf, "contact point 8: a number is not finite"),
        ("arm2", (8, 1), -np.inf, "contact point 8: a number is not finite"),
        ("bias", 9, np.nan, "contact point 9: a number is not finite"),
        ("friction", 10, -0.1, "contact point 10: the friction coefficient is negative"),
        ("friction", 10, np.inf, "contact point 10: a number is not finite"),
        ("friction", 10, 1.6e16, "contact point 10: the friction coefficient is above 1000"),
        ("impulse", (11, 1), np.nan, "contact point 11: a number is not finite"),
    ],
)
def test_refuses_a_problem_that_makes_no_sense(name, index, value, says):
    problem = pile(1)
    problem[name] = problem[name].copy()
    problem[name][index] = value
    with pytest.raises(ValueError, match=says):
        problem.solve()
