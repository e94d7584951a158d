"""S2. A chain of 50 discs against a wall is loaded at its free end.

Rigid grains carry the load to the wall at once. Sweeps that stop early carry it part of the way, as
an elastic wave of the speed c = √(q N_I) d/dt (Unger, Brendel, Wolf and Kertész 2002).
"""

import rcr

from .stage import D, G, R, build as scene, material, push, real_contacts, stadium, state

TITLE = "chain of 50 discs, loaded at one end"
PREDICATE = "|force at the far end / load − 1| after the first step"
BOUND = 0.01
REASON = "kinematic tolerance of the engine"
COUNT, LOAD = 50, 1000  # the load in weights of a disc


def build(law, dt):
    rough = material()
    discs = [stadium(0, R, (R + D * k, 0), material=rough) for k in range(COUNT)]
    ids = scene(law, dt, rcr.wall("x", COUNT * D, material=rough), *discs, gravity=(0, 0, 0))
    push(ids[1], (LOAD * G * state(ids[1]).mass, 0))
    return ids


def measure(ids, clock):
    clock.step(1)
    end = [i.phys.normalForce.norm() for i in real_contacts() if ids[0] in (i.id1, i.id2)]
    return abs(sum(end) / (LOAD * G * state(ids[1]).mass) - 1)
