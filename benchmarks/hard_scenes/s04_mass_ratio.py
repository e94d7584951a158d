"""S4. Heavy on light: seven columns of two RCRs, the upper one 1, 10, … 10⁶ times as heavy.

Gauss–Seidel needs about as many sweeps as the mass ratio to find the force under the light body.
"""

from .stage import D, DENSITY, R, farthest, material, on_floor, stadium

TITLE = "heavy on light, mass ratios 1 to 10⁶"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"


def columns():
    def brick(k, storey, ratio):
        return stadium(R / 2, R / 2, (3 * R * k, R * (storey + 0.5)),
                       material=material(density=DENSITY * ratio))

    return [brick(k, storey, 10 ** (k * storey)) for k in range(7) for storey in range(2)]


def build(law, dt):
    return on_floor(law, dt, material(), *columns())


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
