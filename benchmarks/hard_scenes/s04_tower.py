"""S4. A tower of seven RCRs, each ten times as heavy as the one below.

The lowest carries 10⁶ times its weight. A solver error that is small beside the forces moves the
light bodies.
"""

from .stage import D, DENSITY, R, X, farthest, material, on_floor, stadium

TITLE = "tower of seven, each ten times as heavy as the one below"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"


def tower(x):
    return [stadium(R / 2, R / 2, (x, R * (k + 0.5)), material=material(density=DENSITY * 10**k))
            for k in range(7)]


def build(law, dt):
    return on_floor(law, dt, material(), *tower(X))


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
