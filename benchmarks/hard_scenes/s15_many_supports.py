"""S15. A long RCR rests on seven discs, five more than it needs.

The single forces are not unique, but their sum is its weight and it must not move.
"""

from .stage import D, R, build as scene, farthest, material, stadium

TITLE = "body on more contacts than it needs"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"


def build(law, dt):
    rough = material()
    pegs = [stadium(0, R / 10, (0.25 * R * k, -R / 10), material=rough, fixed=True)
            for k in range(-3, 4)]
    return scene(law, dt, *pegs, stadium(0.9 * R, 0.1 * R, (0, 0.1 * R), material=rough))[-1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
