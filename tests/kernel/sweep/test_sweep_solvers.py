"""Sweep solvers: one problem set, every solver, one residual, equal bits."""

import numpy as np
import pytest
from kernel.contact_problems import (PROBLEMS, assert_lanes_and_threads_change_no_bit, assert_laws,
                                     assert_solved, discs, frictionless, hub, jacobian_times,
                                     models_in_a_workspace, pile)
from rcr import _kernel

CELL_MASS = np.array([400.0, 240.0])  # M_c [kg m²]


@pytest.mark.parametrize("make", PROBLEMS)
def test_reaches_the_tolerance_and_reports_it(make, sweeper):
    """Lanes and threads change no bit."""
    assert_solved(make().cold(), sweeper, 1e-4 if sweeper == "nesterov" else 1e-3)
    assert_lanes_and_threads_change_no_bit(make(), sweeper, tolerance=0, max_iterations=35)


@pytest.mark.parametrize("size, special", [(1e-322, lambda x: (x == 0) & np.signbit(x)),
                                           (1.7e308, np.isinf), (1.7e308, np.isnan)])
def test_lanes_change_no_bit_of_special_numbers(size, special, sweeper):
    """Denormal numbers, zeros of either sign, infinities and NaNs. Squares vanish or overflow."""
    rng, found = np.random.default_rng(0), []
    for problem in pile(1), frictionless(pile(1)), discs(pile(1)):
        for key in "impulse", "free_velocity", "bias":
            problem[key] = size * rng.uniform(-1, 1, problem[key].shape)
        settings = dict(tolerance=0, max_iterations=5)
        assert_lanes_and_threads_change_no_bit(problem, sweeper, [(1, 1), (4, 1), (8, 1)],
                                               **settings)
        found.append(special(problem.solve(sweeper, **settings)["velocity"]).any())
    assert any(found)


def test_lane_widths():
    """The width is the given one, or less if the processor has less; 8 lanes stand for 16."""
    width = {lanes: _kernel.lane_width(lanes) for lanes in (1, 4, 8, 0)}
    assert width[1] == 1 and width[4] in (1, 4) and width[8] in (1, 4, 16) and width[0] == width[8]


@pytest.mark.parametrize("share", [0.05, 0.6])
def test_points_that_drift(solver, share):
    """Body 1 touches a moving image of body 2, as across the boundary of a sheared cell."""
    problem, rng = pile(7, 20, 12), np.random.default_rng(7)
    count = len(problem["bodies"])
    drift = rng.normal(0, 0.1, (count, 2))
    problem["drift"] = drift * (rng.random((count, 1)) < share)
    tolerance = 1e-6 if solver in ("exact", "auto") else 1e-3
    result = assert_solved(problem, solver, tolerance)
    expected = jacobian_times(problem, result["velocity"])
    np.testing.assert_allclose(result["relative_velocity"], expected, rtol=0, atol=1e-12)
    assert_lanes_and_threads_change_no_bit(problem, solver, [(0, 1), (4, 2)],
                                           tolerance=tolerance, max_iterations=20_000)


def test_momentum_needs_fewer_sweeps():
    problem = pile(2, 30, 12)
    plain, fast = (problem.solve(solver, tolerance=1e-4, max_iterations=20000)["iterations"]
                   for solver in ("nlgs", "nesterov"))
    assert fast < plain / 2, f"{fast} accelerated sweeps against {plain}"


def test_body_with_more_contacts_than_colours(sweeper):
    """A disc with 40 contacts: most pairs find no colour, and all are solved."""
    problem = hub(40)
    problem["free_velocity"][1:, :2] = -0.1 * problem["normal"] + 0.01
    assert_solved(problem, sweeper, max_iterations=5000)


def test_stop_criteria():
    problem = pile(2, 30, 12)
    loose, tight = (problem.solve(tolerance=0.5, max_iterations=5000, check_interval=1,
                                  accuracy=accuracy) for accuracy in (np.inf, 1e-3))
    goal = 30 * 1e-3  # of a packing with friction
    assert loose["error_estimate"] > goal >= tight["error_estimate"] and tight["converged"]
    assert tight["iterations"] > loose["iterations"]
    assert problem.solve(tolerance=0.5, min_iterations=77)["iterations"] >= 77
    mean_force = problem.solve(
        "nlgs", tolerance=0, max_iterations=5000, check_interval=1, mean_force_change=1e-3)
    assert mean_force["converged"] and 1 < mean_force["iterations"] < 5000
    stuck = problem.solve("nlgs", tolerance=1e-300, max_iterations=20000, stall_sweeps=50)
    assert not stuck["converged"] and stuck["iterations"] < 20000
    assert problem.solve(tolerance=0, max_iterations=33)["iterations"] == 33


# ---- a periodic cell that contacts stretch: an additional body of the problem

def in_a_cell(seed, stretches=True, moves_bodies=True, mass=CELL_MASS):
    problem, rng = pile(seed, 20, 12), np.random.default_rng(seed)
    pairs, pair_of = np.unique(problem["bodies"], axis=0, return_inverse=True)
    images = rng.choice([-1.0, 0, 1], (len(pairs), 2), p=[0.05, 0.9, 0.05]) * (20.0, 12.0)
    problem["shift"] = images[pair_of.ravel()]
    if moves_bodies:
        problem["place"] = 100.0 + rng.uniform(0, 2, (len(problem["inverse_mass"]), 2))
    cell = dict(inverse_stretch_mass=1 / mass) if stretches else {}
    return problem.copy(f"cell {seed}", **cell)


@pytest.mark.parametrize("heavier", [1, 4000])  # the rate of a heavy cell lags behind sweeps
@pytest.mark.parametrize("moves_bodies", [False, True])
def test_contacts_stretch_the_cell_and_hold_their_laws(solver, moves_bodies, heavier):
    mass = heavier * CELL_MASS
    problem = in_a_cell(4, moves_bodies=moves_bodies, mass=mass)
    place = problem.get("place", np.zeros((len(problem["inverse_mass"]), 2)))
    found = problem.solve(solver, tolerance=1e-6, max_iterations=20000)
    p, n = found["impulse"], problem["normal"]
    forces = p[:, :1] * n + p[:, 1:] * np.column_stack([-n[:, 1], n[:, 0]])
    a, b = problem["bodies"].T
    stretch = (forces * (problem["shift"] + place[b] - place[a])).sum(0) / mass
    np.testing.assert_allclose(found["stretch_rate"], stretch, rtol=1e-10, atol=1e-12)
    moved = np.abs(stretch * problem["shift"]).max()
    assert moved > 1e-4 / heavier, "contacts must stretch the cell"
    free = problem["free_velocity"] + np.pad(stretch * place, ((0, 0), (0, 1)))
    moved = dict(drift=stretch * problem["shift"], free_velocity=free)
    assert_laws(problem.copy(problem.name, **moved), found, 1e-6)


def test_workspace_follows_cells_that_stretch_or_not():
    """Bodies at the boundary of a stretching cell belong to one island."""
    settings = dict(tolerance=0, max_iterations=25)
    still, stretching = in_a_cell(4, False), in_a_cell(4)
    models_in_a_workspace(still, stretching, still, stretching, **settings)
    assert_lanes_and_threads_change_no_bit(stretching, "nesterov", **settings)
