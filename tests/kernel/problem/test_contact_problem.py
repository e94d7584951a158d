"""Invalid problems are rejected before any solver runs; messages name the body or point."""

import numpy as np
import pytest
from common import refused
from kernel.contact_problems import Problem, pile


@pytest.mark.parametrize("name, index, value, message", [
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
    ("friction", 10, 1.6e16, "contact point 10: the friction coefficient is above 1000"),
    ("friction", 10, np.inf, "contact point 10: a number is not finite"),
    ("impulse", (11, 1), np.nan, "contact point 11: a number is not finite"),
    *(("bodies", (5, 0), value, f"{holds}; expected integers") for value, holds in (
        (0.7, "bodies holds float64"), ("1", "bodies holds .*"), (None, "bodies holds object"))),
    *(("bodies", (5, 0), value, f"{holds}expected integers of 32 bits") for value, holds in (
        (2**32 + 1, "bodies holds 4294967297; "), (-(2**33), "bodies holds -8589934592; "),
        (2**63, ""))),
])
def test_invalid_numbers_are_rejected(name, index, value, message):
    """Ids are not rounded or truncated: 0.7 is not body 0, and 2³² + 1 is not body 1."""
    problem = pile(1)
    problem[name] = problem[name].astype(np.array(value).dtype)
    problem[name][index] = value
    refused(message, problem.solve)


@pytest.mark.parametrize("kind", [np.int8, np.uint16, np.int64, np.uint64])
def test_ids_of_any_integer_type(kind):
    problem = pile(1)
    expected = problem.solve(tolerance=0, max_iterations=5)["impulse"]
    problem["bodies"] = problem["bodies"].astype(kind)
    np.testing.assert_array_equal(problem.solve(tolerance=0, max_iterations=5)["impulse"], expected)


@pytest.mark.parametrize("name", pile(1))
def test_arrays_of_inconsistent_shapes_are_rejected(name):
    problem = pile(1)
    for wrong in (problem[name][:-1], problem[name][..., None]):
        refused("has shape", Problem("wrong", **{**problem, name: wrong}).solve)
    refused(f"'no_{name}' is neither a setting nor an array", problem.solve, error=TypeError,
            **{f"no_{name}": problem[name]})
