"""S19. A flat arch: nine upright RCRs between a wall and a press hang by friction alone.

    2 µ N ≥ W        friction at the two ends carries the weight
    W L/8 ≤ N a      the line of thrust stays in the row of length L and height 2a

The press gives 1.3 times the larger N. Mass ratios and cold starts let the row sag.
"""

import math

import rcr

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import G, R, build as scene, material, push, stadium

TITLE = "flat arch of nine"
COUNT, MU = 9, 0.5


def build(law, dt):
    rough = material(MU)
    a, r = 0.8 * R, 0.2 * R
    stones = [stadium(a, r, (r * (1 + 2 * k), 0), math.pi / 2, material=rough)
              for k in range(COUNT)]
    weight = G * sum(s.state.mass for s in stones)
    press = rcr.mobile_wall("x", 2 * r * COUNT, stones[0].state.mass, sense=-1, material=rough)
    ids = scene(law, dt, rcr.wall("x", 0, material=rough), press, *stones)
    thrust = 1.3 * max(weight / (2 * MU), weight * 2 * r * COUNT / 8 / a)
    push(ids[1], (-thrust, 0))
    return ids[2:]
