"""S19. A house of cards (η = 0.95): two tents, a card across their tops, and a tent on it, µ = 1.

Every contact is cap on cap or cap on side; friction alone holds the feet.
"""

import math

from .rest import BOUND, PREDICATE, REASON, measure
from .stage import R, material, on_floor, stadium

TITLE = "house of cards"
A, CAP, LEAN = 0.95 * R, 0.05 * R, math.radians(70)


def tent(x, floor, rough):
    """Two cards that lean on each other; their caps touch at the top, 2 r apart."""
    reach, height = A * math.cos(LEAN) + CAP, A * math.sin(LEAN)
    return [stadium(A, CAP, (x - side * reach, floor + CAP + height), side * LEAN, material=rough)
            for side in (1, -1)]


def build(law, dt):
    rough = material(1.0)
    width, height = 2 * (A * math.cos(LEAN) + CAP), 2 * (A * math.sin(LEAN) + CAP)
    roof = stadium(1.2 * width, CAP, (0, height + CAP), material=rough)
    return on_floor(law, dt, rough, *tent(-width, 0, rough), *tent(width, 0, rough), roof,
                    *tent(0, height + 2 * CAP, rough))
