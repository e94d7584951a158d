"""S19. A pyramid of 210 flat RCRs (η = 0.5), each on the ends of two, µ = 0.5."""

from .stage import D, R, farthest, material, on_floor, stadium

TITLE = "pyramid of 210 RCRs"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"
BASE = 20


def build(law, dt):
    rough = material()
    centers = [(R * row + D * k, R * (row + 0.5)) for row in range(BASE) for k in range(BASE - row)]
    return on_floor(law, dt, rough, *(stadium(R / 2, R / 2, c, material=rough) for c in centers))


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
