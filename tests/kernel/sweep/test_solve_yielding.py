"""Steps without a solution: detected by a certificate, solved with yielding contacts.

Closed form: a body of mass m between two walls that close at V₁ and V₂, without friction. W = 1/m
at both points, and the contacts yield by ε W p:

    p₁ ε/m + (p₁ − p₂)/m = V₁,  p₂ ε/m − (p₁ − p₂)/m = V₂
"""

import numpy as np
import pytest
from kernel.contact_problems import (assert_lanes_and_threads_change_no_bit, beside, dense,
                                     frictionless, jammed_box, kinetic_energy, parts_of, pile,
                                     problem_of, stored, velocity)

COMPLIANCE = 0.01
MASS = 2.0  # kg, of each body
STILL, FREE = [0, 0, 0], [1 / MASS] * 3  # velocity or inverse mass; inverse mass


def wedge():
    return stored("wedge_without_solution")


def closing_speed(problem, found):
    """Largest −(u_n + b_n) [m/s]."""
    return -(found["relative_velocity"][:, 0] + problem["bias"]).min()


def yielding_impulses(w, compliance, speeds):
    """p_n [N s] of (W + ε diag W) p = V, for W over 1/m."""
    return np.linalg.solve(w * (1 + compliance * np.eye(2)) / MASS, speeds)


@pytest.mark.parametrize("compliance", [1e-3, 1e-2, 1e-1])
def test_vice_closes_as_in_its_closed_form(solver, compliance):
    problem = problem_of("vice", [STILL, FREE, STILL], [[1, 0, 0], STILL, [-0.5, 0, 0]],
                         [[0, 1], [1, 2]], normal=(1, 0))
    found = problem.solve(
        solver, tolerance=1e-8, yield_compliance=compliance, accuracy=1e-6)
    p = yielding_impulses([[1, -1], [-1, 1]], compliance, [1.0, 0.5])
    assert found["yielded"] and not found["converged"]
    np.testing.assert_allclose(found["impulse"][:, 0], p, rtol=1e-5)  # error 1e-8/√ε
    np.testing.assert_allclose(closing_speed(problem, found), compliance * p.max() / MASS,
                               rtol=1e-5)


@pytest.mark.parametrize("start", [0.0, 1.0, 1e6], ids="cold warm grown".split())
def test_wedge_has_bounded_forces(start):
    problem = wedge()
    problem["impulse"] = problem["impulse"] * (start / np.linalg.norm(problem["impulse"]))
    rigid = problem.solve("auto")
    found = problem.solve("auto", yield_compliance=COMPLIANCE)
    assert not rigid["yielded"] and found["yielded"]
    drive = 0.08  # m/s, of lid and wall
    assert 0 < closing_speed(problem, found) < 0.1 * drive
    assert found["impulse"][:, 0].max() < 0.1  # N s; weights are 0.005, rigid forces exceed 13
    assert abs(found["velocity"][:, :2]).max() < 10 * drive
    free = kinetic_energy(problem, problem["free_velocity"])
    assert kinetic_energy(problem, velocity(problem, found["impulse"])) <= free * (1 + 1e-12)


@pytest.mark.parametrize("sweeps", [100, 130, 200, 300])
def test_wedge_yields_after_few_sweeps(sweeps):
    """The growth of the impulses in the last 100 sweeps, or in all, gives the hint."""
    for solver in "auto", "nesterov", "nlgs":
        found = wedge().cold().solve(solver, yield_compliance=COMPLIANCE, max_iterations=sweeps)
        assert found["yielded"], solver


def test_yielding_contacts_obey_their_laws():
    problem = wedge()
    p = problem.solve("auto", yield_compliance=COMPLIANCE, tolerance=1e-7)["impulse"]
    w, q = dense(problem)
    u = (w @ p.ravel()).reshape(-1, 2) + q
    small = 1e-4 * abs(problem["free_velocity"]).max()
    for k, (n, t) in enumerate(p):
        limit = problem["friction"][k] * n
        un, ut = u[k] + COMPLIANCE * w[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] @ [n, t]
        where = f"point {k}: u = ({un}, {ut}), p = ({n}, {t})"
        assert n >= 0 and abs(t) <= limit * (1 + 1e-9), where
        assert un > -small and (n == 0 or abs(un) < small), where
        if abs(t) < limit * (1 - 1e-6):
            assert abs(ut) < small, f"sticks, {where}"
        elif n > 0:
            assert ut * t <= small * abs(t), f"slides along its friction, {where}"


@pytest.mark.parametrize("solver, settings, converged", [
    pytest.param("auto", {}, True, id="with a solution"),
    pytest.param("nesterov", dict(tolerance=1e-12, max_iterations=20), False, id="stopped early"),
])
def test_a_step_without_yielding_keeps_its_bits(solver, settings, converged):
    """Without friction the wedge can open."""
    problem = frictionless(wedge()).cold()
    rigid, found = (problem.solve(solver, yield_compliance=c, **settings) for c in (0, COMPLIANCE))
    assert rigid["converged"] == converged and not found["yielded"]
    np.testing.assert_array_equal(found["impulse"], rigid["impulse"])


@pytest.mark.parametrize("yielded", [0.0, 1.0])
def test_only_the_island_without_a_solution_yields(solver, yielded):
    """A body beside the vice falls on the floor at 1 m/s and stops, also if it yielded before."""
    problem = problem_of("vice and body", [STILL, FREE, STILL, STILL, FREE],
                         [[1, 0, 0], STILL, [-1, 0, 0], STILL, [0, -1, 0]],
                         [[0, 1], [1, 2], [3, 4]], normal=[(1, 0), (1, 0), (0, 1)])
    problem["yielded"] = yielded * problem["inverse_mass"].any(1)
    found = problem.solve(solver, yield_compliance=COMPLIANCE)
    assert found["yielded"] and found["yielded_bodies"] == [False, True, False, False, False]
    assert abs(found["velocity"][4, 1]) < (1e-4 if solver == "sor" else 1e-12)


def test_only_the_island_that_has_yielded_yields_again(solver):
    """It gets 50 sweeps as a rigid one; the island beside it takes more, as if it were alone."""
    jam, heap = jammed_box(3, 6, closing=0.3), pile(1, 20, 20)
    problem = beside(jam, heap)
    free = problem["inverse_mass"].any(1)
    problem["yielded"] = free & (np.arange(len(free)) < len(jam["inverse_mass"]))
    settings = dict(yield_compliance=COMPLIANCE, tolerance=1e-6)
    found, alone = problem.solve(solver, **settings), heap.solve(solver, **settings)
    assert found["yielded"] and alone["iterations"] > 50
    own = parts_of(found, (jam, heap))[1]
    np.testing.assert_array_equal(own["impulse"], alone["impulse"])
    all_yielded = problem.copy("all", yielded=free.astype(float)).solve(solver, **settings)
    assert abs(parts_of(all_yielded, (jam, heap))[1]["impulse"] - alone["impulse"]).max() > 0


def test_bits_do_not_depend_on_lanes_and_threads():
    assert_lanes_and_threads_change_no_bit(wedge(), "auto", yield_compliance=COMPLIANCE)


def pushed_row(bodies=((0, 1), (1, 2), (1, 3))):
    """A wall pushes two bodies in a row at V = 1 m/s: p = 2 m V at the wall.

    They move along a fixed body, which bears nothing.
    """
    return problem_of("row", [STILL, FREE, FREE, STILL], [[1, 0, 0], STILL, STILL, STILL],
                      bodies, normal=[(1, 0), (1, 0), (0, 1)][: len(bodies)])


@pytest.mark.parametrize("most, recovery, recovered", [
    (3.9, None, [0, 0]), (0.5, [-0.25, 0.0], [0.25, 0]), (0.5, [-0.25, -5.0], [0.25, 1]),
    (0.5, [0.5, 0.5], [0, 0])])
def test_contacts_yield_beyond_the_most_impulse(most, recovery, recovered):
    """Overlaps recover no faster than driven: u + b yields, b = max(recovery, −V) ≤ 0, V = 1."""
    problem = pushed_row()
    if recovery:
        problem["recovery_bias"] = np.array([*recovery, 0])
    found = problem.solve("auto", yield_compliance=0.1, yield_impulse=most, tolerance=1e-8)
    p = yielding_impulses([[1, -1], [-1, 2]], 0.1, np.add([1, 0], recovered))
    assert found["yielded"] and not found["converged"]
    np.testing.assert_allclose(found["impulse"][:2, 0], p, rtol=1e-6)


@pytest.mark.parametrize("row, settings", [
    (pushed_row(), dict(yield_compliance=0.1, yield_impulse=4.1)),
    (pushed_row(), dict(yield_compliance=0, yield_impulse=1.0)),
    (pushed_row([(0, 1), (1, 2)]), dict(yield_compliance=0.1, yield_impulse=1.0)),
], ids=["less", "never", "one translation"])
def test_other_contacts_keep_their_bits(row, settings):
    """Contacts do not yield where one translation of all bodies needs no impulses."""
    found, rigid = row.solve("auto", **settings), row.solve("auto")
    assert rigid["converged"] and not found["yielded"]
    np.testing.assert_array_equal(found["impulse"], rigid["impulse"])
    np.testing.assert_allclose(found["impulse"][:2, 0], [4.0, 2.0], rtol=1e-4)


@pytest.mark.parametrize("push", [0.0, 0.01])
def test_overlaps_that_open_are_no_wedge(push):
    """Overlaps push a row from a wall against its end: body k leaves at k times one speed."""
    bodies, speed = 50, 1.0
    inverse = np.ones((bodies + 1, 3))
    inverse[0] = 0
    free = np.zeros((bodies + 1, 3))
    free[bodies, 0] = -push
    rows = [(k, k + 1) for k in range(bodies)]
    problem = problem_of("row", inverse, free, rows, normal=(1, 0), bias=-speed)
    found = problem.solve(
        "auto", tolerance=1e-9, max_iterations=20_000, yield_compliance=COMPLIANCE)
    assert not found["yielded"] and found["converged"]
    np.testing.assert_allclose(found["velocity"][:, 0], speed * np.arange(bodies + 1), rtol=1e-4)


@pytest.mark.parametrize("solver", ["auto", "nesterov", "nlgs"])
def test_a_pile_at_rest_beside_a_jam_converges_although_it_yielded_before(solver):
    jam, heap = jammed_box(3, 6, closing=0.3), pile(1, 20, 20)
    heap["free_velocity"][heap["inverse_mass"] == 0] = 0  # nothing is driven
    problem = beside(jam, heap)
    problem["yielded"] = problem["inverse_mass"].any(1).astype(float)
    settings = dict(yield_compliance=COMPLIANCE, yield_impulse=100.0, tolerance=1e-3)
    found, alone = problem.solve(solver, **settings), heap.solve(solver, **settings)
    assert found["yielded"] and alone["converged"] and not alone["yielded"]
    own = parts_of(found, (jam, heap))[1]["impulse"]
    # forces of the pile are indeterminate
    assert np.linalg.norm(own - alone["impulse"]) < 0.1 * np.linalg.norm(alone["impulse"])
    assert not any(np.array(found["yielded_bodies"])[len(jam["inverse_mass"]):])
