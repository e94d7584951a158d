"""Paper against measured: the verdict on each statement of the text. Needs NumPy.

Unless its text says otherwise, a criterion accepts a value within its tolerance or two standard
errors, whichever is wider. A trend counts if it exceeds two standard errors. Statements without the
data they need are not tested.
"""

import typing

from rcr.study.claims import forces, networks  # noqa: F401: they register criteria
from rcr.study.claims.comparisons import CLAIMS, NotTested

AGREES, DIFFERS, NOT_TESTED = "agrees", "does not agree", "not tested"


class Finding(typing.NamedTuple):
    """One row of the table."""

    observable: str  # O1 … O18
    statement: str  # of the paper
    criterion: str  # condition under which the statement agrees
    value: str  # measured
    error: str  # standard error over seeds or networks; see `rcr.study.analysis`
    verdict: str  # `AGREES`, `DIFFERS` or `NOT_TESTED`


def findings(analysis):
    """Return a `Finding` for each statement, by observable, from a result of `analyse`."""
    values = {key: entry["value"] for key, entry in analysis.items()}
    rows = []
    for observable, statement, criterion, test in CLAIMS:
        try:
            agrees, value, error = test(values)
            verdict = AGREES if agrees else DIFFERS
        except NotTested as reason:
            value, error, verdict = str(reason), "", NOT_TESTED
        rows.append(Finding(observable, statement, criterion, value, error, verdict))
    return sorted(rows, key=lambda row: int(row.observable[1:]))
