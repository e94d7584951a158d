"""S18. A flat RCR on a slope at 0.95 of the friction angle, for 1000 s.

It creeps if friction slips a little in every step or if a correction moves it along the slope.
"""

import math

import rcr

from .stage import D, R, build as scene, farthest, material, stadium, tilted

TITLE = "slope below the friction angle"
PREDICATE = "displacement at the end, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"
SECONDS = 1000.0


def build(law, dt):
    rough = material(0.5)
    wall = rcr.wall("y", 0, material=rough)
    return scene(law, dt, wall, stadium(R / 2, R / 2, (0, R / 2), material=rough),
                 gravity=tilted(math.atan(0.95 * 0.5)))[1:]


def measure(ids, clock, seconds=SECONDS):
    return farthest(ids, clock, seconds) / D
