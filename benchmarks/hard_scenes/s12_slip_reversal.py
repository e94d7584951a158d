"""S12. 72 rods hit a rough floor at all angles and slips, with restitution e = 1.

Newton's rule returns the normal velocity for any friction. Where the slip reverses, the impulse
exceeds the one that the compression has stored (Kane and Levinson 1985, Stronge 1991).
"""

import math

import numpy as np

from .stage import R, material, on_floor, stadium, state

TITLE = "slip reversal with restitution"
PREDICATE = "largest gain of kinetic energy of a rod, relative"
BOUND = 1e-3
REASON = "contacts give no energy; the solver has an error of 1e-4 in each velocity"
ANGLES = np.linspace(10, 80, 8)  # degrees
SLIPS = np.array([-4, -2, -1, -0.5, 0, 0.5, 1, 2, 4])  # over the speed of approach
SPEED = 10 * R


def build(law, dt):
    rough = material(0.5)
    rods = []
    for j, angle in enumerate(map(math.radians, ANGLES)):
        y = (0.1 + 0.9 * math.sin(angle)) * R
        rods += [stadium(0.9 * R, 0.1 * R, (4 * R * (9 * j + k), y), angle, material=rough)
                 for k in range(len(SLIPS))]
    ids = on_floor(law, dt, rough, *rods, gravity=(0, 0, 0), restitution=1)
    for k, i in enumerate(ids):
        state(i).vel = (SPEED * SLIPS[k % len(SLIPS)], -SPEED, 0)
    return ids


def energies(ids):
    return np.array([0.5 * s.mass * s.vel.squaredNorm() + 0.5 * s.inertia[2] * s.angVel[2]**2
                     for s in map(state, ids)])


def measure(ids, clock):
    before = energies(ids)
    clock.pass_(0.02)
    return max(energies(ids) / before - 1)
