"""Paper against measured: the verdict on each statement of the text. Needs NumPy.

A criterion accepts a value within its tolerance or two standard errors, whichever is wider, and a
trend beyond two standard errors. Statements without the data they need are not tested.
"""

import dataclasses

from rcr.study.claims import anisotropies, branches, forces  # noqa: F401  register
from rcr.study.claims.criteria import CLAIMS, NotTested

AGREES, DIFFERS, NOT_TESTED = "agrees", "does not agree", "not tested"


@dataclasses.dataclass(frozen=True)
class Finding:
    """One row of the table.

    Attributes
    ----------
    observable : str
        O1 … O18.
    statement, criterion : str
        Statement of the paper, and the condition under which it agrees.
    value, error : str
        Measured value, and its standard error over seeds or snapshots; see `rcr.study.analysis`.
    verdict : str
        `AGREES`, `DIFFERS` or `NOT_TESTED`.
    """

    observable: str
    statement: str
    criterion: str
    value: str
    error: str
    verdict: str


def findings(analysis):
    """Return the table.

    Parameters
    ----------
    analysis : dict
        Result of `rcr.study.analysis.analyse`.

    Returns
    -------
    list of Finding
        In the order of the observables.
    """
    values = {key: entry["value"] for key, entry in analysis.items()}
    rows = []
    for observables, statement, criterion, test in CLAIMS:
        try:
            agrees, value, error = test(*(values[key] for key in observables))
            verdict = AGREES if agrees else DIFFERS
        except NotTested as reason:
            value, error, verdict = str(reason), "", NOT_TESTED
        rows.append(Finding(observables[0], statement, criterion, value, error, verdict))
    return sorted(rows, key=lambda row: int(row.observable[1:]))
