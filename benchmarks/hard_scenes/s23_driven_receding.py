"""S23. A lid moves into a bed while a side wall recedes faster. See `driven`."""

from . import driven

TITLE = "lid driven beside a receding wall"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("receding")
