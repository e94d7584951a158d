"""Sweeps of islands of up to 1024 pairs, which have one partition, keep their bits."""

import hashlib

import numpy as np
import pytest
import rcr
from kernel.contact_problems import DATA

# SHA-1 of the impulses
DIGESTS = {
    ("shear-500-eta-0", "nlgs", "cold"): "c3ecb956",
    ("shear-500-eta-0", "nlgs", "warm"): "2f5b1c0c",
    ("shear-500-eta-0", "sor", "cold"): "590fad71",
    ("shear-500-eta-0", "sor", "warm"): "03422cf9",
    ("shear-500-eta-0", "nesterov", "cold"): "938f2141",
    ("shear-500-eta-0", "nesterov", "warm"): "ac0ab5cf",
    ("shear-500-eta-0.7", "nlgs", "cold"): "0df4da1d",
    ("shear-500-eta-0.7", "nlgs", "warm"): "4236febf",
    ("shear-500-eta-0.7", "sor", "cold"): "942bb14a",
    ("shear-500-eta-0.7", "sor", "warm"): "f86da9d9",
    ("shear-500-eta-0.7", "nesterov", "cold"): "aaed5903",
    ("shear-500-eta-0.7", "nesterov", "warm"): "398922c2",
}


@pytest.mark.parametrize("name, solver, start", DIGESTS, ids=" ".join)
def test_sweeps_keep_their_bits(name, solver, start):
    solution = rcr.solve(str(DATA / f"{name}.npz"), solver=solver, tolerance=0, max_iterations=37,
                         warm=start == "warm")
    impulses = np.ascontiguousarray(solution.reaction).tobytes()
    assert hashlib.sha1(impulses).hexdigest()[:8] == DIGESTS[name, solver, start]
