"""S21. A lid moves into a bed. See `driven`."""

from . import driven

TITLE = "lid driven into a bed"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("lid")
