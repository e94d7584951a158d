"""What makes no problem is refused, with the body or contact point, before anything is solved."""

import numpy as np
import pytest
from kernel.contact_problems import pile


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
        ("impulse", (11, 1), np.nan, "contact point 11: a number is not finite"),
    ],
)
def test_refuses_a_problem_that_makes_no_sense(name, index, value, says):
    problem = pile(1)
    problem[name] = problem[name].copy()
    problem[name][index] = value
    with pytest.raises(ValueError, match=says):
        problem.solve()
