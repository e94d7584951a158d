"""S24. A row of discs slides and sinks over a bed in a box. See `driven`."""

from . import driven

TITLE = "shear box whose row sinks"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("shear")
