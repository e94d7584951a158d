"""S26. A large disc is driven into grains between two slopes.

Rigid grains with friction cannot always do what walls of prescribed motion ask for, for an instant (a frictional wedge) or for good (a jam).
"""

from . import driven

TITLE = "ram between two slopes"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("wedge")
