"""Reductions follow from the problem, can be switched off, and change only the run time.

Results are equal to the bit if the arithmetic is the same. If an order of sums changes, the
velocities of problems with a unique solution (no friction) agree to the accuracy of the solution.
"""

import numpy as np
import pytest
from kernel.contact_problems import (EQUAL, REDUCTIONS, assert_laws, assert_same_bits,
                                     assert_solved,
                                     beside, discs, errors, frictionless, grains_on_a_floor, heaps,
                                     model, models_in_a_workspace, parts_of, pile, square_discs,
                                     stored, without)


def full_and_reduced(problem, *left_out, solver="nesterov", **settings):
    """Results without the reductions `left_out` and with all; the models of both."""
    chosen = without(*left_out), REDUCTIONS
    return ([problem.solve(solver, reductions=r, **settings) for r in chosen],
            [model(problem, reductions=r) for r in chosen])


@pytest.mark.parametrize("make",
                         [lambda: pile(1), lambda: pile(2, 30, 12), lambda: square_discs(3)],
                         ids=["pile 1", "pile 2", "discs"])
def test_normal_impulses_alone_change_no_bit(make, sweeper):
    problem = frictionless(make())
    full, reduced = (
        problem.solve(sweeper, tolerance=0, max_iterations=35, reductions=without("discs", *more))
        for more in (("frictionless",), ()))
    assert_same_bits(full, reduced, problem.name, EQUAL)


def test_some_frictionless_pairs_change_no_bit_of_a_sweep(sweeper):
    """Frictionless pairs have separate blocks. Momentum then sums errors in another order."""
    problem = pile(4, 30, 12)
    problem["friction"] = np.where(problem["bodies"][:, 0] % 2, 0.4, 0.0)
    (full, reduced), models = full_and_reduced(problem, "frictionless", solver=sweeper, tolerance=0,
                                               max_iterations=20)
    if sweeper == "nesterov":
        np.testing.assert_allclose(reduced["velocity"], full["velocity"], rtol=0, atol=1e-12)
    else:
        assert_same_bits(full, reduced, problem.name)
    points = int(problem["inverse_mass"][problem["bodies"]].any(2).any(1).sum())
    assert points < models[1]["unknowns"] < models[0]["unknowns"] == 2 * points


def test_zero_levers_without_rotations_change_no_bit(sweeper):
    problem = square_discs(1)
    (full, reduced), models = full_and_reduced(problem, "discs", "frictionless", solver=sweeper,
                                               tolerance=0, max_iterations=35)
    assert models[0]["rotations"] > 0 == models[1]["rotations"]
    assert_same_bits(full, reduced, problem.name, ("impulse", "residual"))
    np.testing.assert_array_equal(reduced["velocity"][:, :2], full["velocity"][:, :2])
    # the full model scales the spins by the radius of gyration and back
    np.testing.assert_allclose(reduced["velocity"][:, 2], full["velocity"][:, 2], rtol=4e-16)
    np.testing.assert_array_equal(reduced["velocity"][:, 2], problem["free_velocity"][:, 2])


@pytest.mark.parametrize(
    "make", [lambda: discs(pile(5, 30, 12)), lambda: frictionless(stored("shear-1000-eta-0"))],
    ids=["pile", "1000 eta 0"])
def test_discs_without_rotations_are_equal_to_rounding(make):
    """Levers of 1e-17: the same number of sweeps, equal velocities to rounding, constant spins."""
    problem = make()
    problem["impulse"] = problem["impulse"] * [1, 0]
    (full, reduced), models = full_and_reduced(problem, "discs", tolerance=1e-4,
                                               max_iterations=20000)
    assert reduced["iterations"] == full["iterations"]
    assert models[0]["rotations"] > 0 == models[1]["rotations"]
    rounding = 1e-9 * abs(full["velocity"]).max()  # after some hundred sweeps
    np.testing.assert_allclose(reduced["velocity"], full["velocity"], rtol=0, atol=rounding)
    assert reduced["error_estimate"] == pytest.approx(full["error_estimate"], rel=1e-6)
    # spins are scaled by the radius of gyration and back
    spins, expected = reduced["velocity"][:, 2], problem["free_velocity"][:, 2]
    np.testing.assert_allclose(spins, expected, rtol=4e-16, atol=0)
    assert_laws(problem, reduced, 1e-4)


def test_bodies_without_rotation_need_no_levers():
    """Long particles without rotation count as discs, unless a prescribed spin moves points."""
    long, drum = frictionless(pile(6)), discs(pile(13))
    long["inverse_mass"] = long["inverse_mass"] * [1, 1, 0]
    still = long.copy("still", free_velocity=long["free_velocity"] * [1, 1, 0])
    floor = np.flatnonzero(~drum["inverse_mass"].any(1))[0]  # its rim moves discs
    drum["free_velocity"][floor, 2] = 0.5
    at_floor = drum["bodies"] == floor
    drum["arm1"][at_floor[:, 0]] = drum["arm2"][at_floor[:, 1]] = 2.0, 0.3
    for problem, rotates in (long, True), (still, False), (drum, True):
        assert (model(problem)["rotations"] > 0) == rotates
        assert_solved(problem)


@pytest.mark.parametrize("change", ["friction", "lever", "freed"])
def test_the_model_follows_the_problem(change):
    """The model changes at the next step, and back, with friction, a lever or a released body."""
    before = discs(pile(7, 20, 10))
    after = before.copy(f"{change} changed")
    floor = int(np.flatnonzero(~before["inverse_mass"].any(1))[0])
    if change == "friction":
        after["friction"][11] = 0.3
    elif change == "lever":
        after["arm1"][11] += 0.1 * np.array([-after["normal"][11, 1], after["normal"][11, 0]])
    else:
        after["inverse_mass"][floor] = 0.01
    models = models_in_a_workspace(before, after, before, tolerance=0, max_iterations=25)
    first, second, third = ({**found, "layouts": None} for found in models)
    assert first == third != second
    assert first["rotations"] == 0 and first["frictionless"]
    if change == "freed":
        assert second["fixed"] == first["fixed"] - 1
        assert second["bodies"] == first["bodies"] + 1
    else:
        assert second["rotations"] > 0
        assert second["frictionless"] == (change == "lever")


def test_islands_are_independent(sweeper):
    """An island has the same bits alone and beside others, and its own number of sweeps."""
    grains = [grains_on_a_floor(1, k, 1 + k % 2) for k in range(40)]
    problems = [*heaps(10), *grains, *(pile(60 + k, 2, 2) for k in range(20))]
    settings = dict(tolerance=1e-3, max_iterations=20000)
    alone = [problem.solve(sweeper, **settings) for problem in problems]
    for threads, lanes in (1, 8), (2, 4), (4, 1):
        together = beside(*problems).solve(sweeper, threads=threads, lanes=lanes, **settings)
        for problem, one, part in zip(problems, alone, parts_of(together, problems)):
            where = f"{problem.name}, seed {problem.seed}, {threads} threads, {lanes} lanes"
            assert_same_bits(one, part, where)
        assert together["iterations"] == max(one["iterations"] for one in alone)
        # converged islands are not swept
        assert together["work"] == sum(one["work"] for one in alone)
        assert together["converged"] == all(one["converged"] for one in alone)
        assert together["converged"] or sweeper == "sor"  # sor cycles on one of the small piles


def test_work_of_heaps_is_the_sum_of_their_work():
    problems = heaps(10)
    settings = dict(tolerance=1e-4, max_iterations=20000)
    (at_once, apart), _ = full_and_reduced(beside(*problems), "islands", **settings)
    points = [sum(p["inverse_mass"][p["bodies"]].any(2).any(1)) for p in problems]
    sweeps = [p.solve(**settings)["iterations"] for p in problems]
    assert apart["work"] == np.dot(points, sweeps)
    assert apart["iterations"] == max(sweeps)
    assert at_once["work"] == at_once["iterations"] * sum(points)
    assert apart["work"] < 0.8 * at_once["work"], (apart["work"], at_once["work"])


def test_fixed_bodies_and_islands_change_no_unique_velocity():
    several = discs(beside(pile(30, 8, 6), pile(31, 5, 9), grains_on_a_floor(25)))
    for whole, reduction in (discs(pile(8, 40, 5)), "fixed"), (several, "islands"):
        (full, reduced), models = full_and_reduced(
            whole, reduction, tolerance=1e-11, max_iterations=100_000, accuracy=np.inf)
        np.testing.assert_allclose(full["velocity"][:, :2], reduced["velocity"][:, :2], rtol=0,
                                   atol=1e-8)
        assert full["converged"] and reduced["converged"]
        if reduction == "fixed":  # without floor and left wall
            assert models[1]["bodies"] == models[0]["bodies"] - 2
        else:
            assert models[0]["islands"] == 1 and models[1]["islands"] > 25


def test_bodies_that_connect_islands():
    """Fixed bodies do not connect islands; a wall that can move does."""
    heap = discs(pile(9, 8, 6))
    wall = int(np.flatnonzero((heap["inverse_mass"] > 0).sum(1) == 1)[0])  # along x
    both = beside(heap, heap)
    assert model(both)["islands"] == 2 * model(heap)["islands"]
    both["bodies"][both["bodies"] == wall + len(heap["inverse_mass"])] = wall
    assert model(both)["islands"] == 2 * model(heap)["islands"] - 1
    both["inverse_mass"][wall] = 0
    assert model(both)["islands"] >= 2 * model(heap)["islands"]


def test_many_single_grains(sweeper):
    """Islands of one pair, sixteen per register, with one point or two, some without error."""
    problems = [grains_on_a_floor(333, 1), grains_on_a_floor(200, 2, 2)]
    problems.append(frictionless(grains_on_a_floor(40, 3, 2)))
    problems[0]["free_velocity"][:333:3, 1] = 0.2  # these separate
    whole = beside(*problems)
    assert model(whole)["islands"] == 573
    result = assert_solved(whole, sweeper, 1e-10, max_iterations=1000)
    assert result["work"] < result["iterations"] * len(whole["bodies"])


def test_heap_does_not_hide_the_error_of_a_grain():
    """One residual for the scene misses a falling grain beside a heap; one an island shows it."""
    heap = pile(2, 30, 12)
    heap["impulse"] = heap.solve(tolerance=1e-8, max_iterations=50000)["impulse"]
    grain = grains_on_a_floor(1, points=2)
    grain["inverse_mass"] = grain["inverse_mass"] * 1e5
    whole = beside(heap, grain)
    residual_alone = dict(tolerance=1e-4, accuracy=np.inf)
    approach = lambda result: -result["relative_velocity"][-2:, 0].min()
    (missed, seen), _ = full_and_reduced(whole, "islands", **residual_alone)
    # the common residual fails on this scene
    assert missed["iterations"] == 0 and missed["converged"] and approach(missed) > 0.1
    assert seen["converged"] and approach(seen) < 1e-4
    error, size = errors(grain, seen["impulse"][-2:])
    assert np.linalg.norm(error) < 1e-4 * size
    assert seen["work"] == 2 * seen["iterations"]  # the heap is not swept
