"""The packed problem of a workspace follows changes and keeps no trace of earlier problems."""

import numpy as np
from kernel.contact_problems import (EQUAL, assert_same_bits, assert_solved,
                                     models_in_a_workspace, pile, without)
from rcr import _kernel


def shear_steps(seed, steps):
    """A pile that loses or regains a few per cent of its pairs each third step."""
    rng = np.random.default_rng(seed)
    whole = pile(seed, 20, 12)
    pairs, pair_of = np.unique(whole["bodies"], axis=0, return_inverse=True)
    there = rng.random(len(pairs)) < 0.9
    for step in range(steps):
        if step % 3 == 0:
            flips = np.where(there, rng.random(len(pairs)) < 0.03, rng.random(len(pairs)) < 0.3)
            there = there ^ flips
        yield whole.at_points(f"step {step}", there[pair_of.ravel()])


def test_a_workspace_follows_pairs_that_come_and_go(sweeper):
    """It has a new layout exactly where pairs change. Kept layouts change no bit at any lanes and
    threads.
    """
    workspaces = {choice: _kernel.Workspace() for choice in ((1, 1), (4, 1), (8, 2), (8, 4))}
    other, before, changes = _kernel.Workspace(), None, 0
    for problem in shear_steps(5, 60):
        fresh = assert_solved(problem, sweeper, 1e-3, workspace=other, reductions=without("layout"))
        for (lanes, threads), workspace in workspaces.items():
            kept = problem.solve(sweeper, tolerance=1e-3, max_iterations=20_000, lanes=lanes,
                                 threads=threads, workspace=workspace)
            assert_same_bits(kept, fresh, f"{problem.name}, {lanes} lanes, {threads} threads")
        changes += before is None or not np.array_equal(before, problem["bodies"])
        before = problem["bodies"]
    assert workspaces[1, 1].model["layouts"] == changes < 60 == other.model["layouts"]


def altered(problem, rng):
    count = len(problem["bodies"])
    rows = np.repeat(np.arange(count), rng.choice([0, 1, 2], count, p=[0.1, 0.8, 0.1]))
    new = problem.at_points(f"before {problem.name}", rows)
    turned = rng.random(len(rows)) < 0.05
    new["bodies"][turned] = new["bodies"][turned, ::-1]
    new["impulse"] = rng.normal(0, 1, new["impulse"].shape)
    new["free_velocity"] *= rng.uniform(0, 100)
    new["friction"] = rng.uniform(0, 1, len(rows))
    if rng.random() < 0.3:
        new["inverse_mass"][rng.integers(len(new["inverse_mass"]), size=5)] = rng.choice(
            [0.0, 1.0, 2.0], (5, 3))
    return new


def test_a_workspace_keeps_no_trace(sweeper):
    """Earlier problems change no bit: a loaded simulation starts with a new workspace."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        problem = pile(seed, 14, 8)
        workspace = _kernel.Workspace()
        for _ in range(rng.integers(1, 4)):
            altered(problem, rng).solve(
                sweeper, tolerance=0, max_iterations=int(rng.integers(1, 30)), workspace=workspace)
        alone = problem.solve(sweeper, tolerance=0, max_iterations=25)
        for number in range(2):
            kept = problem.solve(sweeper, tolerance=0, max_iterations=25, workspace=workspace)
            assert_same_bits(kept, alone, f"seed {seed}, solve {number}", EQUAL)


def test_a_workspace_takes_any_problem():
    a, b = pile(1), pile(3, 5, 4)
    mixed = a.at_points("mixed", np.random.default_rng(0).permutation(len(a["bodies"])))
    none = a.at_points("none", [])
    models_in_a_workspace(a, b, mixed, none, a, tolerance=0, max_iterations=20)
    assert none.solve()["converged"] and none.solve()["iterations"] == 0


def test_islands_come_and_go_in_a_workspace():
    """Pairs that vanish and return split and join islands: equal bits."""
    whole, rng = pile(11, 24, 3), np.random.default_rng(0)
    kept = lambda: rng.random(len(whole["bodies"])) < rng.choice([0.1, 0.4, 0.9])
    problems = [whole.at_points(f"step {step}", kept()) for step in range(30)]
    models = models_in_a_workspace(*problems, tolerance=1e-3, max_iterations=20_000)
    assert len({model["islands"] for model in models}) > 5
    for problem in problems:
        assert_solved(problem, tolerance=1e-3)
