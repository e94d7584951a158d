"""Observables of histories and packings: shear strength O1, and the isotropic state O2.

sin φ is that of the mean wall stresses over the history. The mean of sin φ would be too small in
large packings, whose stresses fluctuate by inertia. ``sin_phi_std`` is the scatter of records.
With fewer than three seeds, its error is over `BLOCKS` parts of each history.
"""

from functools import partial

import numpy as np

from rcr import statistics
from rcr._pictures import network_maps
from rcr._pictures.curves import column, draw_by_eta, of_each_eta, plain
from rcr._pictures.polar import plot_isotropy
from rcr.network import sin_phi
from rcr.observables.registry import register
from rcr.statistics import mean_of_finite, standard_error

WINDOW = 0.01  # strain over which stresses are averaged for the curve of sin φ
SEEDS = 3  # number of seeds from which on errors are those over the seeds
BLOCKS = 5  # of a history, each longer than the correlation of sin φ, for its standard error
ISOTROPIC = ("a_c", "contacts", "order", "packing_fraction", "coordination_number",
             "coordination_number_twice")


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
        particles=np.mean([run.size for run in runs]), seeds=len(runs))


def plot_strain(value, ax):
    """Draw sin φ against the strain."""
    for _, row, _, style in of_each_eta(value, "sin_phi_strain"):
        ax.plot(column(value, "strain"), row, lw=0.8, **style)
    ax.set(xlabel=r"strain $\varepsilon$", ylabel=r"$\sin\varphi = q/p$",
           xlim=(0, column(value, "strain")[-1]), ylim=(0, None))
    return ax


def plot_strength(value, ax, paper=None):
    """Draw the mean sin φ against η, with the line of a paper."""
    if paper and paper.strength:
        line = np.array([0, 0.7])
        ax.plot(line, paper.strength(line), color="0.5", ls="--", label=paper.strength_label)
    draw_by_eta(value, "sin_phi", ax, label="mean over the strains")
    ax.set(ylabel=r"$\sin\varphi$", ylim=(0, None))
    ax.legend(loc="lower right")
    return ax


def _strength_figure(*plots, **options):
    """Return a function that makes a figure of `plots` and of `plot_strength`."""
    return lambda value, analysis, paper: plain(
        *plots, partial(plot_strength, paper=paper), **options)(value, analysis, paper)


register("O1", "(a) Shear strength sin φ of the wall stresses, averaged over 0.01 of strain, "
         "against the strain. (b) Its mean over the averaged strains against the elongation; "
         "dashed: the paper.", axes=dict(strain="strain"), of_runs=strength,
         figure=_strength_figure(plot_strain), small=_strength_figure(legend=False))


def compaction(runs, ensemble, grids):
    """Return observables of the isotropic state; NaN without isotropic.h5."""
    unknown = dict.fromkeys(ISOTROPIC, np.nan) | dict(pdf=np.full(len(grids.theta) - 1, np.nan))
    states = [isotropic(run.isotropic, grids) for run in runs if run.isotropic is not None]
    states = states or [unknown]
    mean = {name: np.mean([state[name] for state in states], axis=0) for name in states[0]}
    return mean | dict(a_c=np.abs(mean["a_c"]), order=np.abs(mean["order"]),
                       a_c_error=np.sqrt(2 / mean["contacts"] / len(states)))


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
                packing_fraction=network.areas().sum() / network.attributes["volume"],
                coordination_number=network.coordination(),
                coordination_number_twice=network.coordination(count_side_contacts_twice=True))


def plot_coordination(value, ax):
    """Draw Z and Z_c of the isotropic packings against η, with the isostatic numbers."""
    for count in (4, 6):
        ax.axhline(count, color="0.8", lw=0.8)
    ax.plot(value["eta"], column(value, "coordination_number"), "ks-", ms=4, lw=0.8, label="$Z$")
    ax.plot(value["eta"], column(value, "coordination_number_twice"), "ko-", ms=4, lw=0.8,
            mfc="w", label="$Z_c$: side-side contacts twice")
    ax.set(xlabel=r"$\eta$", ylabel="coordination number", ylim=(3, 7))
    ax.legend(loc="lower right")
    return ax


register("O2", "(a) Directions of the contact normals after the compaction; dashed: isotropic. (b) "
         "Contacts of a grain without rattlers; Z_c counts side-side contacts twice. Maps: "
         "packings after the compaction, coloured by the direction of the long axes.",
         axes=dict(theta="theta"), of_runs=compaction, unit="θ in rad, pdf in 1/rad, the rest -",
         figure=plain(plot_isotropy, plot_coordination, projection="polar"),
         map=(network_maps.plot_packing, [], True))
