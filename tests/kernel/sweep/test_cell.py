"""Contacts stretch a periodic cell: an additional body of the problem (contact_problem.hpp)."""

import numpy as np
import pytest
from kernel.contact_problems import (SWEEPS, assert_lanes_and_threads_change_no_bit, assert_laws,
                                     models_in_a_workspace, pile)

MASS = np.array([400.0, 240.0])  # M_c [kg m²]


def in_a_cell(seed, stretches=True):
    problem, rng = pile(seed, 20, 12), np.random.default_rng(seed)
    pairs, pair_of = np.unique(problem["bodies"], axis=0, return_inverse=True)
    images = rng.choice([-1.0, 0, 1], (len(pairs), 2), p=[0.05, 0.9, 0.05]) * (20.0, 12.0)
    problem["shift"] = images[pair_of.ravel()]
    return problem.copy(f"cell {seed}", **dict(inverse_stretch_mass=1 / MASS) if stretches else {})


@pytest.mark.parametrize("solver", [*SWEEPS, "exact", "auto"])
def test_contacts_stretch_the_cell_and_hold_their_laws(solver):
    problem = in_a_cell(4)
    found = problem.solve(solver, tolerance=1e-6, max_iterations=20000)
    p, n = found["impulse"], problem["normal"]
    forces = p[:, :1] * n + p[:, 1:] * np.column_stack([-n[:, 1], n[:, 0]])
    stretch = (forces * problem["shift"]).sum(0) / MASS
    np.testing.assert_allclose(found["stretch_rate"], stretch, rtol=1e-12, atol=1e-14)
    assert np.abs(stretch * problem["shift"]).max() > 1e-4, "contacts must stretch the cell"
    assert_laws(problem.copy(problem.name, drift=stretch * problem["shift"]), found, 1e-6)


def test_workspace_follows_cells_that_stretch_or_not():
    """Bodies at the boundary of a stretching cell belong to one island."""
    settings = dict(tolerance=0, max_iterations=25)
    still, stretching = in_a_cell(4, False), in_a_cell(4)
    models_in_a_workspace(still, stretching, still, stretching, **settings)
    assert_lanes_and_threads_change_no_bit(stretching, "nesterov", **settings)
