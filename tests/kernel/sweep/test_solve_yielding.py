"""Steps without a solution: detected by a certificate, solved with yielding contacts.

Closed form: a body of mass m between two walls that close at V₁ and V₂, without friction. W = 1/m
at both points, and the contacts yield by ε W p:

    p₁ ε/m + (p₁ − p₂)/m = V₁,  p₂ ε/m − (p₁ − p₂)/m = V₂
"""

import numpy as np
import pytest
from kernel.contact_problems import Problem, frictionless, jacobian_times, stored, velocity

WEDGE = "wedge_without_solution"
COMPLIANCE = 0.01


def vice(v1=1.0, v2=1.0, mass=2.0, mu=0.0):
    """A body between two closing walls: the left one moves at v1, the right one at −v2."""
    still = [0.0, 0, 0]
    return Problem("vice", inverse_mass=np.array([still, [1 / mass, 1 / mass, 1 / mass], still]),
                   free_velocity=np.array([[v1, 0, 0], still, [-v2, 0, 0]]),
                   bodies=np.array([[0, 1], [1, 2]], np.int32), normal=np.array([[1.0, 0]] * 2),
                   arm1=np.zeros((2, 2)), arm2=np.zeros((2, 2)), bias=np.zeros(2),
                   friction=np.full(2, mu), impulse=np.zeros((2, 2)))


def kinetic(problem, v):
    inverse = problem["inverse_mass"]
    return (v**2 / np.where(inverse > 0, inverse, np.inf)).sum() / 2


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "exact", "auto"])
@pytest.mark.parametrize("compliance", [1e-3, 1e-2, 1e-1])
def test_vice_closes_as_in_its_closed_form(solver, compliance):
    problem, (v1, v2), mass = vice(1.0, 0.5), (1.0, 0.5), 2.0
    found = problem.solve(
        solver, tolerance=1e-8, yield_compliance=compliance, kinematic_tolerance=1e-6)
    p = np.linalg.solve(np.array([[compliance + 1, -1], [-1, compliance + 1]]) / mass, [v1, v2])
    assert found["yielded"] and not found["converged"]
    np.testing.assert_allclose(found["impulse"][:, 0], p, rtol=1e-5)  # error 1e-8/√ε
    np.testing.assert_allclose(found["closing_speed"], compliance * p.max() / mass, rtol=1e-5)


@pytest.mark.parametrize("start", [0.0, 1.0, 1e6], ids="cold warm grown".split())
def test_wedge_has_bounded_forces(start):
    problem = stored(WEDGE)
    size = np.linalg.norm(problem["impulse"])
    problem["impulse"] = problem["impulse"] * (start / size)
    rigid = problem.solve("auto")
    found = problem.solve("auto", yield_compliance=COMPLIANCE)
    assert not rigid["yielded"] and found["yielded"]
    drive = 0.08  # m/s, of lid and wall
    assert 0 < found["closing_speed"] < 0.1 * drive
    assert found["impulse"][:, 0].max() < 0.1  # N s; weights are 0.005, rigid forces exceed 13
    assert abs(found["velocity"][:, :2]).max() < 10 * drive
    assert kinetic(problem, velocity(problem, found["impulse"])) <= kinetic(
        problem, problem["free_velocity"]
    ) * (1 + 1e-12)


def test_yielding_contacts_obey_their_laws():
    """u + ε W p obeys Signorini and Coulomb at every point."""
    problem = stored(WEDGE)
    p = problem.solve("auto", yield_compliance=COMPLIANCE, tolerance=1e-7)["impulse"]
    u = jacobian_times(problem, velocity(problem, p))
    for k, (n, t) in enumerate(p):
        block = np.array([response(problem, k, direction) for direction in ((1, 0), (0, 1))]).T
        un, ut = u[k] + COMPLIANCE * block @ [n, t] + [problem["bias"][k], 0]
        small = 1e-4 * abs(problem["free_velocity"]).max()
        assert n >= 0 and abs(t) <= problem["friction"][k] * n * (1 + 1e-9)
        assert un > -small and (n == 0 or abs(un) < small), f"point {k}: u_n = {un}, p_n = {n}"
        if abs(t) < problem["friction"][k] * n * (1 - 1e-6):
            assert abs(ut) < small, f"point {k} sticks with u_t = {ut}"
        elif n > 0:
            assert ut * t <= small * abs(
                t
            ), f"point {k} slides with friction: u_t = {ut}, p_t = {t}"


def response(problem, k, direction):
    """Change of u at point k by a unit impulse there."""
    p = np.zeros_like(problem["impulse"])
    p[k] = direction
    return (
        jacobian_times(problem, velocity(problem, p))
        - jacobian_times(problem, problem["free_velocity"])
    )[k]


def test_a_step_with_a_solution_keeps_its_bits():
    """Without friction the wedge can open."""
    problem = frictionless(stored(WEDGE)).cold()
    rigid, found = (problem.solve("auto", yield_compliance=c) for c in (0, COMPLIANCE))
    assert rigid["converged"] and not found["yielded"]
    np.testing.assert_array_equal(found["impulse"], rigid["impulse"])


def test_a_step_that_stops_early_keeps_its_bits():
    problem = frictionless(stored(WEDGE)).cold()
    rigid, found = (
        problem.solve("nesterov", tolerance=1e-12, max_iterations=20, yield_compliance=c)
        for c in (0, COMPLIANCE)
    )
    assert not rigid["converged"] and not found["yielded"]
    np.testing.assert_array_equal(found["impulse"], rigid["impulse"])


def test_only_the_island_without_a_solution_yields():
    """A body beside the vice falls on the floor at 1 m/s and stops."""
    vice_, mass = vice(), 2.0
    problem = Problem(
        "vice and body", **{name: np.concatenate([vice_[name], vice_[name][:0]]) for name in vice_})
    fall = dict(inverse_mass=[[0.0, 0, 0], [1 / mass] * 3],
                free_velocity=[[0.0, 0, 0], [0, -1.0, 0]], bodies=[[3, 4]], normal=[[0.0, 1]],
                arm1=[[0.0, 0]], arm2=[[0.0, 0]], bias=[0.0], friction=[0.0], impulse=[[0.0, 0]])
    for name, value in fall.items():
        problem[name] = np.concatenate([problem[name], np.array(value, problem[name].dtype)])
    found = problem.solve("auto", yield_compliance=COMPLIANCE)
    assert found["yielded"]
    assert abs(found["velocity"][4, 1]) < 1e-12


def test_bits_do_not_depend_on_lanes_and_threads():
    problem = stored(WEDGE)
    results = [
        problem.solve("auto", yield_compliance=COMPLIANCE, lanes=lanes, threads=threads)["impulse"]
        for lanes in (1, 4, 8)
        for threads in (1, 2)
    ]
    for other in results[1:]:
        np.testing.assert_array_equal(other, results[0])


@pytest.mark.parametrize("compliance", [-1.0, np.nan])
def test_refuses_a_compliance_out_of_range(compliance):
    with pytest.raises(ValueError, match="yieldCompliance"):
        vice().solve("auto", yield_compliance=compliance)


def pushed_row(speed=1.0, mass=2.0):
    """A wall pushes two bodies in a row at `speed`: p = 2 m V at the wall."""
    problem = vice(speed, 0.0, mass)
    problem["inverse_mass"][2] = 1 / mass
    return problem


def test_contacts_yield_beyond_the_most_impulse():
    problem, speed, mass, compliance = pushed_row(), 1.0, 2.0, 0.1
    found = problem.solve("auto", yield_compliance=compliance, yield_impulse=3.9, tolerance=1e-8)
    p = np.linalg.solve(
        np.array([[1 + compliance, -1], [-1, 2 * (1 + compliance)]]) / mass, [speed, 0])
    assert found["yielded"] and not found["converged"]
    np.testing.assert_allclose(found["impulse"][:, 0], p, rtol=1e-6)


@pytest.mark.parametrize(
    "recovery, recovered",
    [([-0.25, 0.0], [0.25, 0.0]), ([-0.25, -5.0], [0.25, 1.0]), ([0.5, 0.5], [0.0, 0.0])])
def test_overlaps_recover_no_faster_than_driven(recovery, recovered):
    """u + b yields, with b = max(recovery, −V) ≤ 0 of an overlap and V = 1."""
    problem, speed, mass, compliance = pushed_row(), 1.0, 2.0, 0.1
    problem["recovery"] = np.array(recovery)
    found = problem.solve("auto", yield_compliance=compliance, yield_impulse=0.5, tolerance=1e-8)
    p = np.linalg.solve(np.array([[1 + compliance, -1], [-1, 2 * (1 + compliance)]]) / mass,
                        np.array([speed, 0]) + recovered)
    assert found["yielded"]
    np.testing.assert_allclose(found["impulse"][:, 0], p, rtol=1e-6)


@pytest.mark.parametrize(
    "settings",
    [dict(yield_compliance=0.1, yield_impulse=4.1), dict(yield_compliance=0, yield_impulse=1.0)],
    ids=["less", "never"])
def test_smaller_impulses_keep_their_bits(settings):
    found, rigid = pushed_row().solve("auto", **settings), pushed_row().solve("auto")
    assert rigid["converged"] and not found["yielded"]
    np.testing.assert_array_equal(found["impulse"], rigid["impulse"])
    np.testing.assert_allclose(found["impulse"][:, 0], [4.0, 2.0], rtol=1e-4)


@pytest.mark.parametrize("yield_impulse", [0.0, -1.0, np.nan])
def test_refuses_a_most_impulse_out_of_range(yield_impulse):
    with pytest.raises(ValueError, match="yieldImpulse"):
        vice().solve("auto", yield_impulse=yield_impulse)


@pytest.mark.parametrize("push", [0.0, 0.01])
def test_overlaps_that_open_are_no_wedge(push):
    """Overlaps push a row of bodies from a wall, against a load that moves its end at −push.

    Body k leaves at k times the speed of one overlap: the rigid solution.
    """
    bodies, speed = 50, 1.0
    inverse = np.zeros((bodies + 1, 3))
    inverse[1:] = 1.0
    free = np.zeros((bodies + 1, 3))
    free[bodies, 0] = -push
    rows = np.stack([np.arange(bodies), np.arange(1, bodies + 1)], axis=1).astype(np.int32)
    problem = Problem("row", inverse_mass=inverse, free_velocity=free, bodies=rows,
                      normal=np.tile([1.0, 0], (bodies, 1)), arm1=np.zeros((bodies, 2)),
                      arm2=np.zeros((bodies, 2)), bias=np.full(bodies, -speed),
                      friction=np.zeros(bodies), impulse=np.zeros((bodies, 2)))
    found = problem.solve(
        "auto", tolerance=1e-9, max_iterations=20_000, yield_compliance=COMPLIANCE)
    assert not found["yielded"] and found["converged"]
    np.testing.assert_allclose(found["velocity"][:, 0], speed * np.arange(bodies + 1), rtol=1e-4)
