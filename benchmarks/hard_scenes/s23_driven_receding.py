"""S23. A lid is driven into a bed while a side wall recedes faster.

Rigid grains with friction cannot always do what walls of prescribed motion ask for, for an instant (a frictional wedge) or for good (a jam).
"""

from . import driven

TITLE = "lid driven beside a receding wall"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("receding")
