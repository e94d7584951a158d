"""S19. A stack of a hundred RCRs, for 100 s."""

from .rest import BOUND, REASON
from .stage import D, R, X, farthest, material, on_floor, stadium

TITLE = "stack of 100"
PREDICATE = "largest displacement at the end, in diameters"
SECONDS = 100.0


def build(law, dt):
    rough = material()
    bricks = [stadium(R / 2, R / 2, (X, R * (k + 0.5)), material=rough) for k in range(100)]
    return on_floor(law, dt, rough, *bricks)


def measure(ids, clock, seconds=SECONDS):
    return farthest(ids, clock, seconds) / D
