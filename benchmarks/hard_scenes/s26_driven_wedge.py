"""S26. A large disc moves into grains between two slopes. See `driven`."""

from . import driven

TITLE = "ram between two slopes"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("wedge")
