"""Paper against measured: the verdict on each statement of a paper. Needs NumPy.

Unless its text says otherwise, a criterion accepts a value within its tolerance or two standard
errors, whichever is wider. A trend counts if it exceeds two standard errors. Statements without the
data they need are not tested.
"""

import dataclasses
import typing
from collections.abc import Callable

import numpy as np

import rcr.observables  # noqa: F401: it registers them
from rcr import papers
from rcr.observables.registry import OBSERVABLES
from rcr.study.criteria import NotTested, at_every_eta, row_of, rows_of

ALWAYS = "O1", "O15"  # observables of the sentences at the top of each report
AGREES, DIFFERS, NOT_TESTED = "agrees", "does not agree", "not tested"


class Finding(typing.NamedTuple):
    """One row of the table."""

    observable: str  # its key
    statement: str  # of the paper
    criterion: str  # condition under which the statement agrees
    value: str  # measured
    error: str  # standard error over seeds or networks; see `rcr.study.analysis`
    verdict: str  # `AGREES`, `DIFFERS` or `NOT_TESTED`


@dataclasses.dataclass
class Paper:
    """What a report compares with measurements, and which figures it shows.

    Attributes
    ----------
    about : str
        A sentence about the paper, which is HTML.
    statements : dict
        What the paper states, by observable, in the order of the report.
    maps : dict
        Elongations of the maps, by observable; the last network, or the isotropic one of O2.
    first : list of (observable, caption)
        Figures of the first screen of the report; "map" is a map of forces.
    polar_eta : float
        Elongation of the polar diagrams.
    strength, strength_label : callable and str, optional
        Shear strength sin φ(η) of the paper, and its label in figures.
    averages : float
        First strain of the averages over the last one, by default.
    compares : bool
        Whether runs may differ in shape and rolling friction; else in their elongation alone.
    abscissa, abscissa_label : callable and str
        Abscissa of figures that compare shapes, a function of the value of an observable, and its
        label; by default the elongation.
    """

    about: str
    statements: dict
    maps: dict
    first: list
    polar_eta: float = 0.5
    strength: Callable = None
    strength_label: str = ""
    averages: float = 0.5
    compares: bool = False
    abscissa: Callable = lambda value: value["eta"]
    abscissa_label: str = r"$\eta$"
    claims: list = dataclasses.field(default_factory=list)

    def observables(self):
        """Return the keys of the report: those of the paper, and those that no paper mentions."""
        known = {key for name in papers.names() for key in papers.load(name).statements}
        free = (key for key in OBSERVABLES if key not in known)
        return list(dict.fromkeys([*self.statements, *ALWAYS, *free]))

    def claim(self, observables, statement, criterion, etas=None, least=1):
        """Return a decorator that registers a criterion as a row of the table.

        The row belongs to the first of `observables`. The criterion takes the values of each: of
        all elongations, of one (a number), or of those in a range, at least `least`; see
        `rcr.study.criteria`.
        """
        return lambda test: self.claims.append(
            (observables.split(), statement, criterion, test, etas, least))

    def findings(self, analysis):
        """Return a `Finding` for each statement, by observable, from a result of `analyse`.

        Statements about observables that the analysis lacks are left out.
        """
        values = {key: entry["value"] for key, entry in analysis.items()}
        own = [([key], *claim) for key in self.observables() for claim in OBSERVABLES[key].claims]
        rows = [_finding(values, *claim) for claim in [*self.claims, *own]
                if values.keys() >= set(claim[0])]
        order = list(analysis)
        return sorted(rows, key=lambda row: order.index(row.observable))


def _finding(values, keys, statement, criterion, test, etas=None, least=1):
    """Return the `Finding` of one claim."""
    try:
        parts = [_chosen(values[key], etas, least) for key in keys]
        agrees, value, *error = test(*parts)
        if np.ndim(agrees):
            agrees, value, *error = at_every_eta(parts[0]["eta"], agrees, value, *error)
        (error,), verdict = error, AGREES if agrees else DIFFERS
    except NotTested as reason:
        value, error, verdict = str(reason), "", NOT_TESTED
    return Finding(keys[0], statement, criterion, value, error, verdict)


def _chosen(v, etas, least):
    """Return the values of the elongations of a criterion."""
    if etas is None:
        return v
    axes = {"strain", "theta", "files"}.union(*(one.axes for one in OBSERVABLES.values()))
    rows = rows_of(v, *etas, least) if isinstance(etas, tuple) else row_of(v, etas)
    return {name: array if name in axes else array[rows] for name, array in v.items()}
