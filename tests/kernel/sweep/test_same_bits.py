"""Sweeps of islands of up to 1024 pairs, which have one partition, keep their bits."""

import hashlib

import numpy as np
import pytest
import rcr
from kernel.contact_problems import DATA

# SHA-1 of the impulses
DIGESTS = {  # cold and warm
    ("shear-500-eta-0", "nlgs"): ("c3ecb956", "2f5b1c0c"),
    ("shear-500-eta-0", "sor"): ("590fad71", "03422cf9"),
    ("shear-500-eta-0", "nesterov"): ("938f2141", "ac0ab5cf"),
    ("shear-500-eta-0.7", "nlgs"): ("0df4da1d", "4236febf"),
    ("shear-500-eta-0.7", "sor"): ("942bb14a", "f86da9d9"),
    ("shear-500-eta-0.7", "nesterov"): ("aaed5903", "398922c2"),
}


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("name, solver", DIGESTS, ids=" ".join)
def test_sweeps_keep_their_bits(name, solver, warm):
    solution = rcr.solve(str(DATA / f"{name}.npz"), solver=solver, tolerance=0, max_iterations=37,
                         warm=warm)
    impulses = np.ascontiguousarray(solution.reaction).tobytes()
    assert hashlib.sha1(impulses).hexdigest()[:8] == DIGESTS[name, solver][warm]
