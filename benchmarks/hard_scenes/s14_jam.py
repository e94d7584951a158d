"""S14. A lid with a prescribed velocity crushes a box of 39 discs.

Rigid grains have no solution. A solver that accepts its last sweep lets them overlap silently.
"""

import math

import rcr

from .stage import D, R, build as scene, deepest, material, open_box, stadium

TITLE = "box crushed by a driven lid"
PREDICATE = "overlap at which the run stops with an error, over R"
BOUND = 0.2
REASON = "far below the overlap at which two discs change places"
RIGID_ONLY = True  # springs give way
SPEED = 5 * R


def build(law, dt):
    rough = material()
    centers = [(R * (1 + row % 2) + D * k, R + row * math.sqrt(3) * R) for row in range(6)
               for k in range(7 - row % 2)]
    top = 2 * R + 5 * math.sqrt(3) * R
    lid = rcr.wall("y", top, sense=-1, velocity=-SPEED, material=rough)
    discs = [stadium(0, R, c, material=rough) for c in centers]
    return scene(law, dt, *open_box(7 * D, rough), lid, *discs)


def measure(ids, clock):
    try:
        clock.pass_(0.5)
    except RuntimeError as stopped:
        assert "jam" in str(stopped), stopped
        return deepest()
    return math.inf
