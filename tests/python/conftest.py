"""pytest adds the folder of this file to sys.path, for the modules that tests share."""

import pytest
from problem_files import dense, heap


@pytest.fixture(scope="session")
def step():
    """Arrays of an `.npz` step, its W (2 nc, 2 nc) and q (nc, 2)."""
    arrays = heap(1)
    return arrays, *dense(arrays)
