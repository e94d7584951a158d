"""Observables of contact forces and friction: O3 to O8.

Exponents are those of `rcr.distributions.exponents`. ``_fit_error`` is the error of the fit.
``_tenth`` is β fitted from a tenth of the mean on, which shows the effect of the range.
``strip_force`` and ``strip_stress`` compare normal forces and σ_xx between grains in vertical
strips from wall to wall.
"""

from functools import partial

import matplotlib.ticker
import numpy as np

from rcr import distributions, statistics
from rcr._pictures import network_maps
from rcr._pictures.curves import (XI_MAX, column, draw_by_eta, draw_points, marker, of_each_eta,
                                  plain)
from rcr._pictures.drawing import MOBILIZED
from rcr.distributions import over_mean
from rcr.observables.registry import register

MIN_DENSITY = 1e-4  # lower densities come from single contacts


def force_distribution(force, edges, suffix):
    """Return the density of f/⟨f⟩, α above and β below the mean [eqs. strong_fn, strong_ft]."""
    force = over_mean(force)
    fit, tenth = distributions.exponents(force), distributions.exponents(force, 0.1)
    return {"pdf": statistics.density(force, edges), f"alpha_{suffix}": fit.alpha,
            f"alpha_{suffix}_fit_error": fit.alpha_error, f"beta_{suffix}": fit.beta,
            f"beta_{suffix}_fit_error": fit.beta_error, f"beta_{suffix}_tenth": tenth.beta}


def _plot_forces(value, ax, suffix, exponent, place, **axes):
    """Draw P(f); at a place, if given, inset an exponent against η, and return the inset."""
    name = f"f_{suffix}"
    bare = name if suffix == "n" else f"|{name}|"
    draw_points(value, name, "pdf", ax, least=MIN_DENSITY, ms=2.5)
    ax.set(xlabel=rf"${bare}/\langle {bare}\rangle$", ylabel=rf"$P({name})$", yscale="log", **axes)
    if place is None:
        return None
    inset = ax.inset_axes(place)
    draw_by_eta(value, f"{exponent}_{suffix}", inset, ms=2, elinewidth=0.6)
    inset.set_ylabel(rf"$\{exponent}_{suffix}$", labelpad=1, fontsize=8)
    inset.set_xlabel(r"$\eta$", labelpad=0, fontsize=8)
    inset.tick_params(labelsize=6.5)
    return inset


def plot_force_tail(value, ax, suffix="n", place=(0.57, 0.6, 0.4, 0.37)):
    """Draw P(f) in log-linear scales, with α(η) inset at a place, if given."""
    limits = dict(xlim=(0, 10), ylim=(MIN_DENSITY, 30))
    _plot_forces(value, ax, suffix, "alpha", place, **limits)
    return ax


def plot_force_power(value, ax, suffix="n"):
    """Draw P(f) in log-log scales, with β(η) inset, and as + from f = 0.1 ⟨f⟩ on."""
    limits = dict(xlim=(1e-3, 20), ylim=(MIN_DENSITY, 300 if suffix == "t" else 100))
    place = (0.2, 0.18, 0.4, 0.37)
    inset = _plot_forces(value, ax, suffix, "beta", place, xscale="log", **limits)
    inset.plot(value["eta"], column(value, f"beta_{suffix}_tenth"), "k+", ms=3, mew=0.6)
    return ax


register("O3", "Probability density of the normal forces between grains over their mean: (a) "
         "log-linear with the exponent α_n of the tail inset, (b) log-log with the exponent β_n of "
         "the weak forces inset; crosses: β_n fitted from a tenth of the mean on.",
         lambda e, grids: force_distribution(e.fn, grids.force, "n")
         | dict(weak_fraction=np.mean(e.fn < 1)), dict(f_n="force"),
         figure=plain(plot_force_tail, plot_force_power),
         small=plain(partial(plot_force_tail, place=None)))
register("O4", "The same of the sizes of the tangential forces.",
         lambda e, grids: force_distribution(np.abs(e.ft), grids.force, "t"), dict(f_t="force"),
         figure=plain(partial(plot_force_tail, suffix="t"), partial(plot_force_power, suffix="t")))


def mean_mobilization(e, grids):
    """Return the mean of I_m, the share of contacts with I_m > 0.99, and their weak share."""
    weak = e.fn < 1
    full = e.mobilization > 0.99
    return dict(friction_mobilization=e.mobilization.mean(), mobilized_fraction=np.mean(full),
                mobilized_weak_share=np.mean(weak[full]) if full.any() else np.nan)


def plot_mobilization(value, ax):
    """Draw I_M(η)."""
    draw_by_eta(value, "friction_mobilization", ax)
    ax.set(ylabel=r"$I_M$", ylim=(0, 1))
    return ax


register("O5", "Mean friction mobilisation |f_t|/(µ f_n) of the contacts between grains against "
         "the elongation.", mean_mobilization, figure=plain(plot_mobilization, legend=False))


def strip_forces(e, grids):
    """Return mean normal force and σ_xx in vertical strips over the means of the network.

    σ_xx is 1 in a sample without inertia; contacts with the walls are left out.
    """
    f_x, l_x = (n * np.cos(e.angle) - t * np.sin(e.angle) for n, t in ((e.fn, e.ft), (e.ln, e.lt)))
    stress = np.histogram(e.across, grids.strip, weights=f_x * l_x)[0]
    return dict(strip_force=statistics.bin_means(e.across, e.fn, grids.strip),
                strip_stress=stress / stress.mean())


def plot_strips(value, ax, name="strip_force", symbol=r"\langle f_n\rangle"):
    """Draw a mean of vertical strips from wall to wall, over that of the sample."""
    ax.axhspan(0.9, 1.1, color="0.92", lw=0)
    for eta, row, error, style in of_each_eta(value, name):
        ax.errorbar(column(value, "strip"), row, error, marker=marker(eta), ms=3, lw=0.8,
                    elinewidth=0.6, **style)
    ax.set(xlabel=r"$x/W$ (left wall at 0, right wall at 1)",
           ylabel=rf"${symbol}$ of a strip over the mean", xlim=(0, 1))
    return ax


_DISC = dict(ls="", marker="o", ms=5, mfc=MOBILIZED, mec="0.3", mew=0.5,
             label=r"diameter $\propto I_m$")
register("O6", "(a) Mean normal force and (b) lateral stress in five vertical strips of the "
         "packing over the mean; grey: ±10 %. Maps: normal forces of the last network as thickness "
         "of segments, red up to the mean and black above; the diameter of the yellow discs is the "
         "friction mobilisation.", strip_forces, dict(strip="strip"),
         figure=plain(plot_strips,
                      partial(plot_strips, name="strip_stress", symbol=r"\sigma_{xx}")),
         map=(network_maps.plot_mobilization, [_DISC], False))


def plot_mobilization_by_force(value, ax):
    """Draw I_mf(f_n)."""
    draw_points(value, "f_n", "i_mf", ax, line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$f_n/\langle f_n\rangle$", ylabel=r"$I_{mf}$", xlim=(0, XI_MAX), ylim=(0, 1))
    return ax


register("O7", "Mean friction mobilisation of the contacts with a normal force f_n.",
         lambda e, grids: dict(i_mf=statistics.bin_means(e.fn, e.mobilization, grids.force)),
         dict(f_n="force"), figure=plain(plot_mobilization_by_force))


def plot_mobilization_pdf(value, ax):
    """Draw P(I_m)."""
    draw_points(value, "i_m", "pdf", ax, line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$I_m$", ylabel=r"$P(I_m)$", xlim=(0, 1), yscale="log")
    ax.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    ax.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    return ax


register("O8", "Probability density of the friction mobilisation.", lambda e, grids: dict(
    pdf=statistics.density(np.minimum(e.mobilization, 1), grids.mobilization)),
         dict(i_m="mobilization"), figure=plain(plot_mobilization_pdf))
