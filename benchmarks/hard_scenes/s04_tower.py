"""S4. A tower of seven RCRs, each ten times as heavy as the one below.

The lowest carries 10⁶ times its weight. A solver error that is small beside the forces moves the
light bodies.
"""

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import DENSITY, R, X, material, on_floor, stadium

TITLE = "tower of seven, each ten times as heavy as the one below"


def tower(x):
    return [stadium(R / 2, R / 2, (x, R * (k + 0.5)), material=material(density=DENSITY * 10**k))
            for k in range(7)]


def build(law, dt):
    return on_floor(law, dt, material(), *tower(X))
