"""S19. A pyramid of 210 discs on a rough floor, twenty at the base, µ = 0.7.

Three discs need a friction above tan(π/12) = 0.27 (tests/yade/test_closed_forms.py), ten at the base between 0.5 and 0.6: below that a
linear program over all forces in their cones has no balance, and the pyramid collapses as it should.
"""

import math

import rcr

from .stage import D, R, build as scene, farthest, material, stadium

TITLE = "pyramid of 210 discs"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"
BASE = 20


def build(law, dt):
    rough = material(0.7)
    centers = [(R * row + D * k, R + row * math.sqrt(3) * R) for row in range(BASE) for k in range(BASE - row)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *(stadium(0, R, c, material=rough) for c in centers))[1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
