"""S19. A house of cards (η = 0.95): two tents, a card across their tops, and a tent on it, µ = 1.

Every contact is cap on cap or cap on side; friction alone holds the feet.
"""

import math

from .stage import D, R, farthest, material, on_floor, stadium

TITLE = "house of cards"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"
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
    cards = [
        *tent(-width, 0, rough), *tent(width, 0, rough), roof, *tent(0, height + 2 * CAP, rough)
    ]
    return on_floor(law, dt, rough, *cards)


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
