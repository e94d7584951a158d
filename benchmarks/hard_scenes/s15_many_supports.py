"""S15. A long RCR rests on seven discs, five more than it needs.

Which of them carry is free; that they carry its weight, and that it lies still, is not.
"""

import numpy as np

from .stage import D, G, R, build as scene, farthest, material, stadium, state
from yade import O

TITLE = "body on more contacts than it needs"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"


def build(law, dt):
    rough = material()
    pegs = [stadium(0, R / 10, (0.25 * R * k, -R / 10), material=rough, fixed=True) for k in range(-3, 4)]
    return scene(law, dt, *pegs, stadium(0.9 * R, 0.1 * R, (0, 0.1 * R), material=rough))[-1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
