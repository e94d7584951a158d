"""S19. A pyramid of 210 flat RCRs (η = 0.5), each on the ends of two, µ = 0.5."""

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import D, R, material, on_floor, stadium

TITLE = "pyramid of 210 RCRs"
BASE = 20


def build(law, dt):
    rough = material()
    centers = [(R * row + D * k, R * (row + 0.5)) for row in range(BASE) for k in range(BASE - row)]
    return on_floor(law, dt, rough, *(stadium(R / 2, R / 2, c, material=rough) for c in centers))
