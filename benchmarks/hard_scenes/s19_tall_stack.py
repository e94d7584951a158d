"""S19. A hundred RCRs stand on each other for 100 s."""

import rcr

from .stage import D, R, X, build as scene, farthest, material, stadium

TITLE = "stack of 100"
PREDICATE = "largest displacement in 100 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"
SECONDS = 100.0


def build(law, dt):
    rough = material()
    bricks = [stadium(R / 2, R / 2, (X, R * (k + 0.5)), material=rough) for k in range(100)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *bricks)[1:]


def measure(ids, clock, seconds=SECONDS):
    return farthest(ids, clock, seconds) / D
