"""S24. A row of discs slides and sinks over a bed in a box.

Rigid grains with friction cannot always do what walls of prescribed motion ask for, for an instant (a frictional wedge) or for good (a jam).
"""

from . import driven

TITLE = "shear box whose row sinks"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("shear")
