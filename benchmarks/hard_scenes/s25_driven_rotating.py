"""S25. A closed box of grains turns.

Rigid grains with friction cannot always do what walls of prescribed motion ask for, for an instant (a frictional wedge) or for good (a jam).
"""

from . import driven

TITLE = "closed box that turns"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("rotating")
