"""S19. A house of cards (η = 0.95): two tents of two cards, one card across their tops, and a tent on it, µ = 1.

Every contact is a cap on a cap or on a side; nothing but friction keeps the feet together.
"""

import math

import rcr

from .stage import D, R, build as scene, farthest, material, stadium

TITLE = "house of cards"
PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometry right to 1e-3 of a diameter, as in all scenes"
A, CAP, LEAN = 0.95 * R, 0.05 * R, math.radians(70)


def tent(x, floor, rough):
    """Two cards that lean on each other: caps touch at the top, 2 r apart."""
    reach, height = A * math.cos(LEAN) + CAP, A * math.sin(LEAN)
    return [stadium(A, CAP, (x - side * reach, floor + CAP + height), side * LEAN, material=rough) for side in (1, -1)]


def build(law, dt):
    rough = material(1.0)
    width, height = 2 * (A * math.cos(LEAN) + CAP), 2 * (A * math.sin(LEAN) + CAP)
    roof = stadium(1.2 * width, CAP, (0, height + CAP), material=rough)
    cards = [*tent(-width, 0, rough), *tent(width, 0, rough), roof, *tent(0, height + 2 * CAP, rough)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *cards)[1:]


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
