"""S6. The overlap that the same three discs keep."""

from .s06_overlap import DEPTH, build
from .stage import R, deepest

TITLE = "initial overlap heals"
PREDICATE = "overlap left after 10 s, over the first"
BOUND = 0.01
REASON = "the slop is 2e-3 of it"


def measure(ids, clock):
    clock.pass_(10.0)
    return deepest() * R / DEPTH
