"""No more model than a problem needs: every reduction is seen from the problem, changes nothing but the time, and can be switched off.

"Nothing" is not a bit where the arithmetic stays the same; where an order changes, the velocities of a problem that has only
one solution (no friction), to the accuracy it is solved to.
"""

import numpy as np
import pytest
from kernel.contact_problems import (
    ALL, SWEEPS, Problem, assert_laws, assert_same_bits, beside, discs, errors, frictionless, grains_on_a_floor, heaps, model, parts_of, pile, square_discs,
    stored, without,
)  # fmt: skip
from rcr import _kernel


@pytest.mark.parametrize("solver", SWEEPS)
@pytest.mark.parametrize("make", [lambda: pile(1), lambda: pile(2, 30, 12), lambda: square_discs(3)], ids=["pile 1", "pile 2", "discs"])
def test_one_unknown_a_point_changes_no_bit(make, solver):
    problem = frictionless(make())
    full = problem.solve(solver, tolerance=0, max_iterations=35, reductions=without("frictionless", "discs"))
    reduced = problem.solve(solver, tolerance=0, max_iterations=35, reductions=without("discs"))
    assert_same_bits(full, reduced, problem.name, ("impulse", "velocity", "residual", "violation"))


@pytest.mark.parametrize("solver", SWEEPS)
def test_pairs_without_friction_among_others_change_no_bit_of_a_sweep(solver):
    """Half of the pairs slide freely: they stand in blocks of their own. (Momentum sums errors in another order.)"""
    problem = pile(4, 30, 12)
    first = problem["bodies"][:, 0]
    problem["friction"] = np.where(first % 2, 0.4, 0.0)
    full = problem.solve(solver, tolerance=0, max_iterations=20, reductions=without("frictionless"))
    reduced = problem.solve(solver, tolerance=0, max_iterations=20)
    if solver == "nesterov":
        np.testing.assert_allclose(reduced["velocity"], full["velocity"], rtol=0, atol=1e-12)
    else:
        assert_same_bits(full, reduced, problem.name)
    points = int(problem["inverse_mass"][problem["bodies"]].any(2).any(1).sum())
    assert points < model(problem)["unknowns"] < 2 * points == model(problem, reductions=without("frictionless"))["unknowns"]


@pytest.mark.parametrize("solver", SWEEPS)
def test_discs_without_rotations_change_no_bit_where_levers_are_zero(solver):
    problem = square_discs(1)
    full, reduced = (problem.solve(solver, tolerance=0, max_iterations=35, reductions=r) for r in (without("discs", "frictionless"), ALL))
    assert model(problem)["rotations"] == 0 < model(problem, reductions=without("discs"))["rotations"]
    assert_same_bits(full, reduced, problem.name, ("impulse", "residual"))
    np.testing.assert_array_equal(reduced["velocity"][:, :2], full["velocity"][:, :2])
    # the full model scales the spins by the radius of gyration and back
    np.testing.assert_allclose(reduced["velocity"][:, 2], full["velocity"][:, 2], rtol=4e-16)
    np.testing.assert_array_equal(reduced["velocity"][:, 2], problem["free_velocity"][:, 2])


@pytest.mark.parametrize("make", [lambda: discs(pile(5, 30, 12)), lambda: frictionless(stored("shear-1000-eta-0"))], ids=["pile", "1000 eta 0"])
def test_discs_without_rotations_are_equal_to_rounding(make):
    """Levers of 1e-17: the same number of sweeps, velocities equal to rounding; the spins stay as they were."""
    problem = make()
    problem["impulse"] = problem["impulse"] * [1, 0]
    full, reduced = (problem.solve(tolerance=1e-4, max_iterations=20000, reductions=r) for r in (without("discs"), ALL))
    assert reduced["iterations"] == full["iterations"] and model(problem)["rotations"] == 0 < model(problem, reductions=without("discs"))["rotations"]
    scale = abs(full["velocity"]).max()
    np.testing.assert_allclose(reduced["velocity"], full["velocity"], rtol=0, atol=1e-9 * scale)  # rounding, through some hundred sweeps
    assert reduced["violation"] == pytest.approx(full["violation"], rel=1e-6)
    np.testing.assert_allclose(reduced["velocity"][:, 2], problem["free_velocity"][:, 2], rtol=4e-16, atol=0)  # taken times the gyration and back
    assert_laws(problem, reduced, 1e-4)


def test_a_body_that_cannot_turn_needs_no_levers():
    """Long particles whose rotation is blocked are as good as discs, unless they turn for ever: then points off their centre move."""
    problem = frictionless(pile(6))
    problem["inverse_mass"] = problem["inverse_mass"] * [1, 1, 0]
    assert model(problem)["rotations"] > 0
    assert_laws(problem, problem.solve(tolerance=1e-6, max_iterations=20000), 1e-6)
    problem["free_velocity"] = problem["free_velocity"] * [1, 1, 0]
    assert model(problem)["rotations"] == 0
    assert_laws(problem, problem.solve(tolerance=1e-6, max_iterations=20000), 1e-6)


def test_discs_against_a_fixed_body_that_turns():
    """The rim of a drum moves: its contacts have a lever on a body without unknowns."""
    problem = discs(pile(13))
    floor = np.flatnonzero(~problem["inverse_mass"].any(1))[0]
    problem["free_velocity"][floor, 2] = 0.5
    at_floor = problem["bodies"] == floor
    problem["arm1"][at_floor[:, 0]] = problem["arm2"][at_floor[:, 1]] = 2.0, 0.3
    assert model(problem)["rotations"] > 0
    assert_laws(problem, problem.solve(tolerance=1e-6, max_iterations=20000), 1e-6)


@pytest.mark.parametrize("change", ["friction", "lever", "freed"])
def test_the_model_follows_the_problem(change):
    """Friction switched on, a disc that becomes long, a fixed body that is freed: seen in the next step, and back again."""
    before = discs(pile(7, 20, 10))
    after = Problem(f"{change} changed", 7, **{key: value.copy() for key, value in before.items()})
    floor = int(np.flatnonzero(~before["inverse_mass"].any(1))[0])
    if change == "friction":
        after["friction"][11] = 0.3
    elif change == "lever":
        after["arm1"][11] += 0.1 * np.array([-after["normal"][11, 1], after["normal"][11, 0]])
    else:
        after["inverse_mass"][floor] = 0.01
    workspace = _kernel.Workspace()
    models = []
    for problem in (before, after, before):
        kept = problem.solve(tolerance=0, max_iterations=25, workspace=workspace)
        assert_same_bits(kept, problem.solve(tolerance=0, max_iterations=25), problem.name, ("impulse", "velocity", "residual"))
        models.append(workspace.model)
        del models[-1]["layouts"]
    first, second, third = models
    assert first == third != second
    assert first["rotations"] == 0 and first["frictionless"]
    if change == "freed":
        assert second["fixed"] == first["fixed"] - 1 and second["bodies"] == first["bodies"] + 1
    else:
        assert second["rotations"] > 0 and second["frictionless"] == (change == "lever")


def test_fixed_bodies_without_unknowns():
    problem = discs(pile(8, 40, 5))
    reduced, full = (problem.solve(tolerance=1e-11, max_iterations=100000, violation=np.inf, reductions=r) for r in (ALL, without("fixed")))
    np.testing.assert_allclose(reduced["velocity"][:, :2], full["velocity"][:, :2], rtol=0, atol=1e-8)
    assert reduced["converged"] and full["converged"]
    assert model(problem)["bodies"] == model(problem, reductions=without("fixed"))["bodies"] - 2  # floor and left wall


@pytest.mark.parametrize("solver", SWEEPS)
def test_an_island_does_not_depend_on_others(solver):
    """The same bits alone and beside others, for any number of threads and lanes; each to its own convergence."""
    problems = [*heaps(10), *(grains_on_a_floor(1, k, 1 + k % 2) for k in range(40)), *(pile(60 + k, 2, 2) for k in range(20))]
    settings = dict(tolerance=1e-3, max_iterations=20000)
    alone = [problem.solve(solver, **settings) for problem in problems]
    for threads, lanes in (1, 8), (2, 4), (4, 1):
        together = beside(*problems).solve(solver, threads=threads, lanes=lanes, **settings)
        for problem, one, part in zip(problems, alone, parts_of(together, problems)):
            assert_same_bits(one, part, f"{problem.name}, seed {problem.seed}, {threads} threads, {lanes} lanes")
        assert together["iterations"] == max(one["iterations"] for one in alone)
        assert together["work"] == sum(one["work"] for one in alone), "an island was swept that had converged"
        assert together["converged"] == all(one["converged"] for one in alone)
        assert together["converged"] or solver == "sor"  # which cycles on one of the small piles


def test_ten_heaps_cost_what_each_needs():
    problems = heaps(10)
    settings = dict(tolerance=1e-4, max_iterations=20000)
    apart, at_once = (beside(*problems).solve(reductions=r, **settings) for r in (ALL, without("islands")))
    points = [sum(p["inverse_mass"][p["bodies"]].any(2).any(1)) for p in problems]
    sweeps = [p.solve(**settings)["iterations"] for p in problems]
    assert apart["work"] == np.dot(points, sweeps) and apart["iterations"] == max(sweeps)
    assert at_once["work"] == at_once["iterations"] * sum(points)
    assert apart["work"] < 0.8 * at_once["work"], (apart["work"], at_once["work"])


def test_islands_are_equal_to_one_problem():
    """Without friction velocities are unique: solved apart or at once they are the same."""
    whole = discs(beside(pile(30, 8, 6), pile(31, 5, 9), grains_on_a_floor(25)))
    apart, at_once = (whole.solve(tolerance=1e-11, max_iterations=100000, violation=np.inf, reductions=r) for r in (ALL, without("islands")))
    np.testing.assert_allclose(apart["velocity"][:, :2], at_once["velocity"][:, :2], rtol=0, atol=1e-8)
    assert model(whole)["islands"] > 25 and model(whole, reductions=without("islands"))["islands"] == 1


def test_what_connects():
    """Fixed bodies do not, a wall that can move does."""
    heap = discs(pile(9, 8, 6))
    wall = int(np.flatnonzero((heap["inverse_mass"] > 0).sum(1) == 1)[0])  # along x
    both = beside(heap, heap)
    assert model(both)["islands"] == 2 * model(heap)["islands"]
    both["bodies"][both["bodies"] == wall + len(heap["inverse_mass"])] = wall
    assert model(both)["islands"] == 2 * model(heap)["islands"] - 1
    both["inverse_mass"][wall] = 0
    assert model(both)["islands"] >= 2 * model(heap)["islands"]


@pytest.mark.parametrize("solver", SWEEPS)
def test_many_single_grains(solver):
    """Islands of one pair, sixteen in a register, with one point and with two, some at rest before they begin."""
    problems = [grains_on_a_floor(333, 1), grains_on_a_floor(200, 2, 2), frictionless(grains_on_a_floor(40, 3, 2))]
    problems[0]["free_velocity"][:333:3, 1] = 0.2  # these fly off
    whole = beside(*problems)
    assert model(whole)["islands"] == 573
    result = whole.solve(solver, tolerance=1e-10, max_iterations=1000)
    assert_laws(whole, result, 1e-10)
    assert result["work"] < result["iterations"] * len(whole["bodies"])


def test_a_grain_that_lands_beside_a_heap_at_rest_is_not_missed():
    """The impulses of the heap hide the error of the grain in one common residual; islands have their own (scene S1)."""
    heap = pile(2, 30, 12)
    heap["impulse"] = heap.solve(tolerance=1e-8, max_iterations=50000)["impulse"]
    grain = grains_on_a_floor(1, points=2)
    grain["inverse_mass"] = grain["inverse_mass"] * 1e5
    whole = beside(heap, grain)
    residual_alone = dict(tolerance=1e-4, violation=np.inf)
    approach = lambda result: -result["relative_velocity"][-2:, 0].min()
    missed, seen = (whole.solve(reductions=r, **residual_alone) for r in (without("islands"), ALL))
    assert missed["iterations"] == 0 and missed["converged"] and approach(missed) > 0.1, "the scene does not show the failure"
    assert seen["converged"] and approach(seen) < 1e-4
    error, size = errors(grain, seen["impulse"][-2:])
    assert np.linalg.norm(error) < 1e-4 * size
    assert seen["work"] == 2 * seen["iterations"], "the heap was swept too"


def test_refuses_an_unknown_reduction():
    with pytest.raises(ValueError, match="reduction 'walls' is not known: give some of frictionless discs fixed islands layout"):
        pile(1).solve(reductions=["islands", "walls"])
