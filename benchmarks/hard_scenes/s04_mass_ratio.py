"""S4. Heavy on light: seven columns of two RCRs, the upper one 1, 10, … 10⁶ times as heavy.

Gauss–Seidel needs about as many sweeps as the mass ratio to find the force under the light body.
"""

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import DENSITY, R, material, on_floor, stadium

TITLE = "heavy on light, mass ratios 1 to 10⁶"


def columns():
    return [stadium(R / 2, R / 2, (3 * R * k, R * (storey + 0.5)),
                    material=material(density=DENSITY * 10 ** (k * storey)))
            for k in range(7) for storey in range(2)]


def build(law, dt):
    return on_floor(law, dt, material(), *columns())
