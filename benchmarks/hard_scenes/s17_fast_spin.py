"""S17. A long RCR (η = 0.95) spins fast in a narrow box and hits a small disc.

Its ends move by more than the cap radius in a step.
"""

import math

import rcr

from .stage import R, build as scene, material, positions, stadium, state

TITLE = "fast spin of a long particle"
PREDICATE = "deepest overlap, over the smaller cap radius"
BOUND = 0.5
REASON = "at 1 the contact reaches a centre line, beyond it the force reverses"
SPIN = 100.0  # rad/s: 0.1 rad and two cap radii a step
HALF = 1.2 * R


def build(law, dt):
    rough = material()
    walls = [rcr.wall(axis, side * HALF, sense=-side, material=rough) for axis in "xy"
             for side in (-1, 1)]
    rod = stadium(0.95 * R, 0.05 * R, (0.1 * R, 0), 0.3, material=rough)
    disc = stadium(0, 0.1 * R, (0, 0.7 * R), material=rough)
    ids = scene(law, dt, *walls, rod, disc, gravity=(0, 0, 0))
    state(ids[4]).angVel = (0, 0, SPIN)
    return ids[4:]


def measure(ids, clock):
    clock.pass_(1.0)
    return clock.overlap if abs(positions(ids)).max() < HALF else math.inf
