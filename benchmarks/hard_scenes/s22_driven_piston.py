"""S22. A side wall is driven into a bed under a lid.

Rigid grains with friction cannot always do what walls of prescribed motion ask for, for an instant (a frictional wedge) or for good (a jam).
"""

from . import driven

TITLE = "side wall driven into a bed"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("piston")
