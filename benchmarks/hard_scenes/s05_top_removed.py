"""S5. The upper half of a stack at rest is removed.

The warm start then has twice the correct forces; a solver that keeps them throws the rest up.
"""

from yade import O

from .rest import BOUND, REASON
from .stage import D, R, X, farthest, material, on_floor, stadium

TITLE = "stack whose upper half is removed"
PREDICATE = "largest displacement of the rest in 1 s, in diameters"


def build(law, dt):
    rough = material()
    bricks = [stadium(R / 2, R / 2, (X, R * (k + 0.5)), material=rough) for k in range(10)]
    return on_floor(law, dt, rough, *bricks)


def measure(ids, clock):
    clock.pass_(0.5)
    for i in ids[5:]:
        O.bodies.erase(i)
    clock.restart()
    return farthest(ids[:5], clock, 1.0) / D
