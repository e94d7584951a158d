"""Predicate of the scenes at rest, in which nothing may move."""

from .stage import D, farthest

PREDICATE = "largest displacement in 10 s, in diameters"
BOUND = 1e-3
REASON = "geometric error of 1e-3 diameters, as in all scenes"


def measure(ids, clock):
    return farthest(ids, clock, 10.0) / D
