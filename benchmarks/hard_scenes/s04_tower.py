"""S4. A tower of seven RCRs, each ten times as heavy as the one below.

The lowest has to find 10⁶ times its own weight; an error of the solver that is small beside the forces throws the light ones about.
"""

import rcr

from .stage import D, DENSITY, R, X, build as scene, farthest, material, stadium

TITLE = "tower of seven, each ten times as heavy as the one below"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"


def tower(x):
    return [stadium(R / 2, R / 2, (x, R * (k + 0.5)), material=material(density=DENSITY * 10**k)) for k in range(7)]


def build(law, dt):
    return scene(law, dt, rcr.wall("y", 0, material=material()), *tower(X))[1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
