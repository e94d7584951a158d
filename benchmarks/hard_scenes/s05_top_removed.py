"""S5. The upper half of a stack at rest is taken away.

The forces of the last step, from which the solver starts, are twice what they should be: what trusts them throws the rest up.
"""

import rcr
from yade import O

from .stage import D, R, X, build as scene, farthest, material, stadium

TITLE = "stack whose upper half is removed"
PREDICATE = "largest displacement of the rest in 1 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"


def build(law, dt):
    rough = material()
    bricks = [stadium(R / 2, R / 2, (X, R * (k + 0.5)), material=rough) for k in range(10)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *bricks)[1:]


def measure(ids, clock):
    clock.pass_(0.5)
    for i in ids[5:]:
        O.bodies.erase(i)
    clock.restart()
    return farthest(ids[:5], clock, 1.0) / D
