"""Observables of papers that compare shapes of grains: S1 to S6.

A row is a kind of grains: a shape, its elongation, sides and rolling friction; all figures have a
curve per shape, over the abscissa of the paper. A *neighbour* is a grain in contact, at one or more
contact points; clumps are grains. Errors are over the seeds if there are `SEEDS`, else NaN or those
of the registry.
"""

from functools import partial

import numpy as np

from rcr._pictures.curves import MARKERS, column, error_of, plain
from rcr.observables.packings import SEEDS, along_strain, strength
from rcr.observables.registry import OBSERVABLES, register
from rcr.statistics import standard_error
from rcr.study.protocol import SHAPE_NAMES

COLORS = "k", "tab:blue", "tab:green", "tab:orange", "tab:red"
ANISOTROPIES = {"a_c": "a_c", "a_ln": r"a_{\ell n}", "a_lt": r"a_{\ell t}", "a_fn": "a_{fn}",
                "a_ft": "a_{ft}"}


def rows_of_shape(value, shape):
    """Return the rows of a shape by η, then rolling friction; trimers begin with the disc."""
    names = "eta", "rolling_friction", "shape"
    eta, rolling, shapes = (np.asarray(value[name]) for name in names)
    disc = (shape == "trimer") & (shapes == "rcr") & (eta == 0) & (rolling == 0)
    rows = np.flatnonzero((shapes == shape) | disc)
    return rows[np.lexsort((rolling[rows], eta[rows]))]


def draw_shapes(value, name, paper, ax, filled=True, legend=True):
    """Draw a number of all kinds of grains, one curve per shape."""
    x = np.asarray(paper.abscissa(value), float)
    for shape, mark, tint in zip(SHAPE_NAMES, MARKERS, COLORS):
        rows = rows_of_shape(value, shape)
        rows = rows[np.argsort(x[rows], kind="stable")]
        if shape in value["shape"]:
            y, error = column(value, name)[rows], error_of(value, name)[rows]
            label = SHAPE_NAMES[shape]
            if shape == "rcr" and not np.asarray(value["eta"])[rows].any():
                label = "disc"
            ax.errorbar(x[rows], y, error, marker=mark, color=tint, lw=0.8, ms=4,
                        mfc=None if filled else "w", label=label if legend else None)
    ax.set_xlabel(paper.abscissa_label)
    return ax


def _figure(*plots):
    """Return a function that makes a figure of one or two pairs of a name and its label."""

    def plot(name, symbol, paper, value, ax):
        draw_shapes(value, name, paper, ax).set_ylabel(symbol)
        return ax

    return lambda value, analysis, paper: plain(
        *(partial(plot, *pair, paper) for pair in plots), columns=2)(value, analysis, paper)


def _of_seeds(rows):
    """Return {name: mean over seeds, name_error: its error} of one dict per seed."""
    found = {}
    for name in rows[0]:
        values = [row[name] for row in rows]
        found[name] = np.mean(values)
        found[f"{name}_error"] = standard_error(values) if len(values) >= SEEDS else np.nan
    return found


def steady_state(runs, ensemble, grids):
    """Return the strength, its peak, and the packing fraction of the sheared networks."""
    mean = strength(runs, ensemble, grids)
    peaks, fractions = [], []
    for run in runs:
        if run.history is not None:
            peaks.append(np.nanmax(along_strain(run.history, grids.strain)))
        area = run.networks[0].areas().sum()  # of the same grains in all networks
        fractions += [area / network.attributes["volume"] for network in run.networks]
    return {name: mean[name] for name in ("sin_phi", "sin_phi_error")} | dict(
        sin_phi_peak=np.mean(peaks) if peaks else np.nan, packing_fraction=np.mean(fractions),
        packing_fraction_error=standard_error(fractions))


register("S1", "(a) Shear strength sin φ and (b) packing fraction of the sheared packings.",
         of_runs=steady_state, figure=_figure(("sin_phi", r"$\sin\varphi^*$"),
                                              ("packing_fraction", r"$\rho$")))


def coordination(network):
    """Return Z, the neighbours of a grain, and Z_c, its contact points, without rattlers.

    ``multiple_fraction`` is the share of pairs of neighbours with two contact points or more.
    """
    pairs, points = network.neighbors()
    between = pairs[:, 0] >= 0  # obstacles have negative ids
    count = len(np.unique(pairs[pairs >= 0]))
    weight = 1 + between
    return dict(neighbors=(weight.sum() / count if count else np.nan),
                contact_points=(weight @ points / count if count else np.nan),
                multiple_fraction=np.mean(points[between] > 1) if between.any() else np.nan)


def isotropic_state(runs, ensemble, grids):
    """Return packing fraction and coordination of the packings after the compaction."""
    states = [run.isotropic for run in runs if run.isotropic is not None]
    rows = [coordination(n) | dict(packing_fraction=n.areas().sum() / n.attributes["volume"])
            for n in states]
    names = "neighbors", "contact_points", "multiple_fraction", "packing_fraction"
    return _of_seeds(rows or [dict.fromkeys(names, np.nan)])


register("S2", "(a) Packing fraction after the frictionless compaction and (b) mean number of "
         "contact points of a grain in it.", of_runs=isotropic_state,
         figure=_figure(("packing_fraction", r"$\rho_{iso}$"), ("contact_points", r"$Z_c$")))


def sheared_contacts(runs, ensemble, grids):
    """Return the coordination of the sheared networks."""
    networks = [network for run in runs for network in run.networks]
    return _of_seeds([coordination(network) for network in networks])


register("S3", "(a) Neighbours of a grain and (b) share of neighbours with two contact points or "
         "more, in the sheared packings.", of_runs=sheared_contacts,
         figure=_figure(("neighbors", "$Z$"), ("multiple_fraction", "share of multiple contacts")))
register("S4", "Mean friction mobilisation |f_t|/(µ f_n) of the sheared packings.",
         lambda e, grids: dict(friction_mobilization=e.mobilization.mean()),
         figure=_figure(("friction_mobilization", "$M$")))


def _plot_anisotropies(value, analysis, paper):
    plots = [("a_c", "a_ln", "a_lt"), ("a_fn", "a_ft")]

    def plot(names, value, ax):
        ax.axhline(0, color="0.7", lw=0.6)
        for name in names:
            first = name in ("a_c", "a_fn")
            draw_shapes(value, name, paper, ax, filled=first, legend=first)
        ax.set_ylabel(", ".join(f"${ANISOTROPIES[name]}$" for name in names))
        return ax

    figure = plain(*(partial(plot, names) for names in plots), columns=2)
    return figure(value, analysis, paper)


register("S5", "Anisotropies of (a) contact normals (filled) and branch vectors, (b) normal "
         "(filled) and tangential forces.",
         lambda e, grids: e.xi_networks.anisotropies(np.inf)._asdict(), figure=_plot_anisotropies)


def _plot_forces(value, analysis, paper):
    def plot(scale, value, ax):
        x = np.asarray(paper.abscissa(value), float)
        for k, row in enumerate(column(value, "pdf")):
            shape = list(SHAPE_NAMES).index(value["shape"][k])
            seen = row > 1e-4
            ax.plot(column(value, "f_n")[seen], row[seen], marker=MARKERS[shape], ms=2.5, lw=0.5,
                    color=COLORS[shape], alpha=0.3 + 0.7 * k / len(x),
                    label=f"{value['sides'][k]} sides" if value["sides"][k] else
                    f"{paper.abscissa_label} = {x[k]:.3g}")
        ax.set(xlabel=r"$f_n/\langle f_n\rangle$", ylabel="$P(f_n)$", xscale=scale, yscale="log")
        return ax

    figure = plain(partial(plot, "linear"), partial(plot, "log"))
    return figure(value, analysis, paper)


register("S6", "Probability density of the normal forces over their mean.",
         OBSERVABLES["O3"].measure, dict(f_n="force"), figure=_plot_forces)
