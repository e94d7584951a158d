"""S4. Heavy on light: seven columns of two RCRs, the upper one 1, 10, … 10⁶ times as heavy.

Gauss–Seidel needs as many sweeps as the ratio of the masses to find the force under the light one.
"""

import rcr

from .stage import D, DENSITY, R, build as scene, farthest, material, stadium

TITLE = "heavy on light, mass ratios 1 to 10⁶"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"


def columns():
    def brick(k, storey, ratio):
        return stadium(R / 2, R / 2, (3 * R * k, R * (storey + 0.5)), material=material(density=DENSITY * ratio))

    return [brick(k, storey, 10 ** (k * storey)) for k in range(7) for storey in range(2)]


def build(law, dt):
    return scene(law, dt, rcr.wall("y", 0, material=material()), *columns())[1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
