"""pytest adds the folder of this file to sys.path, for the modules that tests share."""

import numpy as np
import pytest
from kernel.conftest import solver  # noqa: F401
from kernel.contact_problems import dense, pile
from problem_files import npz


@pytest.fixture(scope="session")
def step():
    """Arrays of an `.npz` step, its W (2 nc, 2 nc) and q (nc, 2)."""
    rng, problem = np.random.default_rng(1), pile(1, 6, 5)
    problem = problem.at_points("step", rng.permutation(len(problem["bias"])))
    problem["impulse"] = abs(rng.normal(0, 0.01, problem["impulse"].shape)) * [1, 0]
    return npz(problem), *dense(problem)
