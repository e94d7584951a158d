"""S22. A side wall moves into a bed under a lid. See `driven`."""

from . import driven

TITLE = "side wall driven into a bed"
PREDICATE, BOUND, REASON = driven.PREDICATE, driven.BOUND, driven.REASON
build, measure = driven.staged("piston")
