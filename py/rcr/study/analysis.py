"""Values of all observables of a report, from runs of the biaxial test. Needs NumPy, not YADE.

* Contacts of all networks and seeds of an elongation are cumulated, with the forces of each
  network over its ⟨f_n⟩.
* ``NAME_error`` is the standard error: the standard deviation over √(number) over the seeds if
  there are three or more, else over the networks. It is NaN for one network. Networks of one
  test have the same packing, so errors over few seeds are too small rather than too large.
* ``a_c_drift`` is the change of a_c over the strains of the networks: the critical state of sin φ
  need not be that of the fabric.

The modules of `rcr.observables` have the rules of single observables.
"""

import numpy as np

from rcr import papers
from rcr._data.files import jsonable  # noqa: F401: part of this module's interface
from rcr.ensemble import Ensemble
from rcr.observables.packings import SEEDS
from rcr.observables.registry import OBSERVABLES, Grids, measures
from rcr.study.runs import by_kind


def samples(runs):
    """Return the ensembles of the errors: one per seed if there are `SEEDS`, else per network."""
    if len(runs) >= SEEDS:
        return [Ensemble(run.networks) for run in runs]
    return [Ensemble([network]) for run in runs for network in run.networks]


def isotropic_contacts(runs):
    """Return the number of contacts between grains in the isotropic states; inf without any."""
    states = [run.isotropic for run in runs if run.isotropic is not None]
    return sum(int(state.between_particles.sum()) for state in states) or np.inf


def analyse(runs, paper=None):
    """Return every observable of runs in a report on a paper, as analysis.json holds it.

    The result has an entry {value: {name: array, elongation first}, paper: statement, unit} for
    each of `Paper.observables`. Runs of the same elongation are cumulated. For a paper that
    compares shapes, a row is a `Kind` of grains, with its ``shape``, ``sides`` and
    ``rolling_friction``. A ValueError says that there is no run, or that runs differ in friction or
    have none.
    """
    if not runs:
        raise ValueError("no runs: the analysis needs at least one folder")
    paper = papers.load() if paper is None else paper
    groups = by_kind(runs, paper.compares)
    ensembles = {kind: Ensemble([network for run in group for network in run.networks])
                 for kind, group in groups.items()}
    last = max(float(run.networks[-1].attributes["strain"]) for run in runs)
    grids = Grids.of(ensembles.values(), last, min(map(isotropic_contacts, groups.values())))
    results = {kind: measures(e, grids, samples(groups[kind]), paper.observables())
               for kind, e in ensembles.items()}
    names = ("eta", "shape", "sides", "rolling_friction") if paper.compares else ("eta",)
    rows_of = {name: np.array([getattr(kind, name) for kind in groups]) for name in names}
    found = {}
    for key in paper.observables():
        one = OBSERVABLES[key]
        rows = [results[k].get(key, {}) | (one.of_runs(groups[k], ensembles[k], grids)
                                           if one.of_runs else {}) for k in groups]
        axes = {name: grids.values(grid) for name, grid in one.axes.items()}
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        found[key] = dict(value=rows_of | axes | columns,
                          paper=paper.statements.get(key, ""), unit=one.unit)
    return found
