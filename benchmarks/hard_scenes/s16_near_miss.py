"""S16. A disc flies past the corner of a box, 1e-3 d above it, and past another disc.

A contact with a gap is a plane, the tangent at the closest point. The curved path around it can
look like a hit.
"""

import numpy as np

from .stage import D, R, box, build as scene, material, stadium, state, twist

TITLE = "near miss of a corner and of a disc"
PREDICATE = "|change of velocity| / speed"
BOUND = 1e-3
REASON = "the exact value is 0; 1e-3, as in all scenes"
SPEED = 100 * R
CLEARANCE = 1e-3 * D


def build(law, dt):
    rough = material()
    obstacle = stadium(0, R, (4 * R, -R), material=rough, fixed=True)
    disc = stadium(0, R, (-5.03 * R, R + CLEARANCE), material=rough)
    corner = box((0, -R), (R / 2, R), material=rough)
    disc = scene(law, dt, corner, obstacle, disc, gravity=(0, 0, 0))[-1]
    state(disc).vel = (SPEED, 0, 0)
    return disc


def measure(disc, clock):
    clock.pass_(10 * R / SPEED)
    change = (twist(disc) - [SPEED, 0, 0]) * [1, 1, R]
    return np.linalg.norm(change) / SPEED
