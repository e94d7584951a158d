"""S19. A pyramid of 210 discs on a rough floor, twenty at the base, µ = 0.7.

Three discs need µ > tan(π/12) = 0.27 (tests/yade/law/test_closed_forms.py). A base of ten needs
0.5 to 0.6, by a linear program over all forces in their cones. Below that the pyramid collapses.
"""

import math

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import D, R, material, on_floor, stadium

TITLE = "pyramid of 210 discs"
BASE = 20


def build(law, dt):
    rough = material(0.7)
    centers = [(R * row + D * k, R + row * math.sqrt(3) * R) for row in range(BASE)
               for k in range(BASE - row)]
    return on_floor(law, dt, rough, *(stadium(0, R, c, material=rough) for c in centers))
