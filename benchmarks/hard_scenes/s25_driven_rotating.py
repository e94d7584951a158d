"""S25. A closed box of grains turns. See `driven`."""

from . import driven

TITLE = "closed box that turns"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("rotating")
