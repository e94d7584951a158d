"""S18. A flat RCR on a slope at 0.95 of the friction angle, for 1000 s.

It creeps if friction slips a little in every step or if a correction moves it along the slope.
"""

import math

from .rest import BOUND, REASON
from .stage import D, R, farthest, material, on_floor, stadium, tilted

TITLE = "slope below the friction angle"
PREDICATE = "displacement at the end, in diameters"
SECONDS = 1000.0


def build(law, dt):
    rough = material(0.5)
    grain = stadium(R / 2, R / 2, (0, R / 2), material=rough)
    return on_floor(law, dt, rough, grain, gravity=tilted(math.atan(0.95 * 0.5)))


def measure(ids, clock, seconds=SECONDS):
    return farthest(ids, clock, seconds) / D
