"""The observables O1 to O18 of the paper, from runs of the biaxial test. Needs NumPy, not YADE.

* Contacts of all networks and seeds of an elongation are cumulated, with the forces of each
  network over its ⟨f_n⟩.
* ``NAME_error`` is the standard error: the standard deviation over √(number) over the seeds if
  there are three or more, else over the networks. It is NaN for one network. Networks of one
  test have the same packing, so errors over few seeds are too small rather than too large.
* ``a_c_drift`` is the change of a_c over the strains of the networks: the critical state of sin φ
  need not be that of the fabric.
* sin φ is that of the mean wall stresses over the history. The mean of sin φ would be too small in
  large packings, whose stresses fluctuate by inertia. ``sin_phi_std`` is the scatter of records.
  With fewer than three seeds, its error is over `BLOCKS` parts of each history.

`rcr.study.observables` has the rules of single observables.
"""

import numpy as np

from rcr._data.files import jsonable  # noqa: F401: part of this module's interface
from rcr.frame import Frame
from rcr.network import sin_phi
from rcr import statistics
from rcr.ensemble import Ensemble
from rcr.study.observables import MEASURES, Grids, measures
from rcr.study.claims.statements import MAPS, STATEMENTS
from rcr.study.runs import by_elongation
from rcr.statistics import mean_of_finite, standard_error

WINDOW = 0.01  # strain over which stresses are averaged for the curve of sin φ
SEEDS = 3  # number of seeds from which on errors are those over the seeds
BLOCKS = 5  # of a history, each longer than the correlation of sin φ, for its standard error
ISOTROPIC = ("a_c", "contacts", "order", "packing_fraction", "coordination_number",
             "coordination_number_twice")


def samples(runs):
    """Return the ensembles of the errors: one per seed if there are `SEEDS`, else per network."""
    if len(runs) >= SEEDS:
        return [Ensemble(run.networks) for run in runs]
    return [Ensemble([network]) for run in runs for network in run.networks]


def along_strain(history, strain):
    """Return sin φ of wall stresses averaged over `WINDOW` about each strain, NaN without any."""
    near = np.abs(history["strain"] - strain[:, None]) <= WINDOW / 2
    count = np.where(near.any(axis=1), near.sum(axis=1), np.nan)
    means = [near @ history[name] / count for name in ("stress_x", "stress_y")]
    return sin_phi(np.column_stack(means))


def strength(runs, ensemble, grids):
    """Return the mean sin φ, and sin φ along the strain, of the runs of one elongation."""
    late = [run.critical_stresses() for run in runs]
    seeds = [sin_phi(stresses.mean(axis=0)) for stresses in late]
    blocks = [sin_phi(block.mean(axis=0)) for stresses in late
              for block in np.array_split(stresses, min(BLOCKS, len(stresses)))]
    histories = [run.history for run in runs if run.history is not None]
    curves = [along_strain(history, grids.strain) for history in histories]
    return dict(
        sin_phi=np.mean(seeds), sin_phi_std=sin_phi(np.concatenate(late)).std(),
        sin_phi_error=standard_error(seeds if len(seeds) >= SEEDS else blocks),
        sin_phi_strain=mean_of_finite(curves) if curves else np.full_like(grids.strain, np.nan),
        networks=sum(len(run.networks) for run in runs), contacts=len(ensemble),
        particles=np.mean([len(run.networks[0].particles["id"]) for run in runs]), seeds=len(runs))


def drift(runs):
    """Return the change of a_c over the strains of the networks.

    A straight line is fitted, with one slope for all seeds; NaN for fewer than three networks.
    """
    strains = [np.array([n.attributes["strain"] for n in run.networks]) for run in runs]
    values = [np.array([n.anisotropies()[0] for n in run.networks]) for run in runs]
    slope, error = statistics.common_slope([*zip(strains, values)])
    length = np.ptp(np.concatenate(strains))
    return dict(a_c_drift=slope * length, a_c_drift_error=error * length)


def compaction(runs, grids):
    """Return observables of the isotropic state; NaN without isotropic.h5."""
    unknown = dict.fromkeys(ISOTROPIC, np.nan) | dict(pdf=np.full(len(grids.theta) - 1, np.nan))
    states = [isotropic(run.isotropic, grids) for run in runs if run.isotropic is not None]
    states = states or [unknown]
    mean = {name: np.mean([state[name] for state in states], axis=0) for name in states[0]}
    return mean | dict(a_c=np.abs(mean["a_c"]), order=np.abs(mean["order"]),
                       a_c_error=np.sqrt(2 / mean["contacts"] / len(states)))


def isotropic_contacts(runs):
    """Return the number of contacts between grains in the isotropic states; inf without any."""
    states = [run.isotropic for run in runs if run.isotropic is not None]
    return sum(int(state.between_particles.sum()) for state in states) or np.inf


def isotropic(network, grids):
    """Return observables of one isotropic packing.

    ``order`` is ⟨e^{2iφ}⟩ of the long axes, ``a_c`` is 2 ⟨e^{2iφ}⟩ of the normals. The magnitudes
    of their means over seeds enter analysis.json. The error of C independent normals is √(2/C).
    """
    n = network.contacts["normal"][network.between_particles]
    angle = np.arctan2(n[:, 1], n[:, 0])
    order = np.mean(np.exp(2j * network.particles["angle"]))
    return dict(pdf=statistics.density(angle % np.pi, grids.theta),
                a_c=2 * np.mean(np.exp(2j * angle)), contacts=len(n),
                order=order if network.attributes.get("eta", 1) else np.nan,
                packing_fraction=Frame.of(network).areas().sum() / network.attributes["volume"],
                coordination_number=network.coordination(),
                coordination_number_twice=network.coordination(count_side_contacts_twice=True))


def analyse(runs):
    """Return every observable of runs, as analysis.json holds it.

    The result is ``O1`` … ``O18``, each {value: {name: array, elongation first}, paper: statement,
    unit}. Runs of the same elongation are cumulated. A ValueError says that there is no run, or
    that runs differ in friction or have none.
    """
    if not runs:
        raise ValueError("no runs: the analysis needs at least one folder")
    groups = by_elongation(runs)
    ensembles = {eta: Ensemble([network for run in group for network in run.networks])
                 for eta, group in groups.items()}
    last = max(float(run.networks[-1].attributes["strain"]) for run in runs)
    grids = Grids.of(ensembles.values(), last, min(map(isotropic_contacts, groups.values())))
    named = grids.values()
    results = {eta: measures(e, grids, samples(groups[eta])) for eta, e in ensembles.items()}
    eta = np.array(list(groups))

    def stacked(measure, axes):
        rows = [measure(e) for e in groups]
        columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return dict(eta=eta) | {name: named[grid] for name, grid in axes.items()} | columns

    values = {key: dict(eta=eta) for key in MAPS}
    for key, (_, axes) in MEASURES.items():
        values[key] = stacked(lambda e: results[e][key], axes)
    strain = dict(strain="strain")
    values["O1"] = stacked(lambda e: strength(groups[e], ensembles[e], grids), strain)
    values["O2"] = stacked(lambda e: compaction(groups[e], grids), dict(theta="theta"))
    values["O15"] |= stacked(lambda e: drift(groups[e]), {})
    return {key: dict(value=values[key], paper=paper, unit=unit)
            for key, (paper, unit) in STATEMENTS.items()}
