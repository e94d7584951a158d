"""S7. Three long RCRs (η = 0.9) on each other slide down a slope.

The floor has µ = 0.3, the RCRs have 0.5.
"""

import math

from .s07_parallel_at_rest import BOUND, PREDICATE, long_stack, measure
from .stage import tilted

TITLE = "long parallel RCRs sliding"
REASON = "they slide as one block"


def build(law, dt):
    return long_stack(law, dt, 0.3, tilted(math.atan(0.4)), 3)
