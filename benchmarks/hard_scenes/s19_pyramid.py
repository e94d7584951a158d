"""S19. A pyramid of 210 RCRs (η = 0.5), twenty flat ones at the base, each on the ends of two, µ = 0.5."""

import rcr

from .stage import D, R, build as scene, farthest, material, stadium

TITLE = "pyramid of 210 RCRs"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"
BASE = 20


def build(law, dt):
    rough = material()
    centers = [(R * row + D * k, R * (row + 0.5)) for row in range(BASE) for k in range(BASE - row)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *(stadium(R / 2, R / 2, c, material=rough) for c in centers))[1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
