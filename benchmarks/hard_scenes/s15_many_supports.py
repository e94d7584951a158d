"""S15. A long RCR rests on seven discs, five more than it needs.

The single forces are not unique, but their sum is its weight and it must not move.
"""

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import R, build as scene, material, stadium

TITLE = "body on more contacts than it needs"


def build(law, dt):
    rough = material()
    pegs = [stadium(0, R / 10, (0.25 * R * k, -R / 10), material=rough, fixed=True)
            for k in range(-3, 4)]
    return scene(law, dt, *pegs, stadium(0.9 * R, 0.1 * R, (0, 0.1 * R), material=rough))[-1:]
