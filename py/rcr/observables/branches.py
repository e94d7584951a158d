"""Observables of branch vectors and contact types: O9 to O13."""

from functools import partial

import numpy as np

from rcr import statistics
from rcr._pictures import network_maps
from rcr._pictures.curves import column, draw_by_eta, draw_points, of_each_eta, plain
from rcr._pictures.drawing import TYPES
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE
from rcr.observables.registry import SLACK, register

register("O9", "Last network: grains with a side-side contact, coloured by the direction of their "
         "long axis; normal forces as thickness of segments.",
         map=(network_maps.plot_nematic, [], True))


def _reduced_length(e):
    """Return ℓ_r clipped to its range, and the mask of its contacts, (C,) bool.

    The mask leaves out contacts that exceed the range by more than `SLACK`, as those of clumps.
    """
    low, high = 1 - e.eta, 1
    pick = (e.reduced_length > low - SLACK) & (e.reduced_length < high + SLACK)
    return np.clip(e.reduced_length[pick], low + 1e-9, high - 1e-9), pick


def plot_length_pdf(value, ax):
    """Draw P(ℓ_r) of each elongation, except discs, where ℓ_r is 1."""
    for eta, row, _, style in of_each_eta(value, "pdf"):
        seen = column(value, "l_r") > 1 - eta
        if eta > 0:
            ax.plot(column(value, "l_r")[seen], row[seen], lw=0.8, **style)
    ax.set(xlabel=r"$\ell_r$", ylabel=r"$P(\ell_r)$", ylim=(0, None),
           xlim=(column(value, "l_r")[0] - 0.01, 1.005))
    return ax


register("O10", "Probability density of the reduced branch length ℓ/(R₁ + R₂).",
         lambda e, grids: dict(
             pdf=statistics.density(_reduced_length(e)[0], grids.reduced_length)),
         dict(l_r="reduced_length"), figure=plain(plot_length_pdf))
_MARKS = [dict(color=tint, lw=2, label=name) for name, tint in TYPES.items()]
register("O11", "Last network: contacts coloured by their type.", lambda e, grids: dict(
    fraction_cc=np.mean(e.type == CAP_CAP), fraction_cs=np.mean(e.type == CAP_SIDE),
    fraction_ss=np.mean(e.type == SIDE_SIDE)), map=(network_maps.plot_types, _MARKS, False))


def plot_correlation(value, ax):
    """Draw Pearson coefficients of force and branch length against η."""
    ax.axhline(0, color="0.7", lw=0.6)
    draw_by_eta(value, "c_f_lr", ax, label=r"$C_{f\ell_r}$")
    draw_by_eta(value, "c_f_l", ax, label=r"$C_{f\ell}$", style="tab:red", mark="s")
    ax.set_ylabel("Pearson coefficient")
    ax.legend()
    return ax


register("O12", "Correlation of the contact force with the branch length ℓ and the reduced branch "
         "length ℓ_r = ℓ/(R₁ + R₂), against the elongation.",
         lambda e, grids: e.correlations(), figure=plain(plot_correlation, legend=False))


def force_by_length(e, grids):
    """Return the mean force by bins of ℓ_r and ℓ."""
    force = e.force / e.force.mean()
    reduced_length, pick = _reduced_length(e)
    return dict(f_l_r=statistics.bin_means(reduced_length, force[pick], grids.reduced_length),
                f_l=statistics.bin_means(e.length, force, grids.length))


def plot_force_by_length(value, ax, length="l_r"):
    """Draw the mean force of bins of ℓ_r or ℓ."""
    ax.axhline(1, color="0.7", lw=0.6)
    draw_points(value, length, f"f_{length}", ax, line="-", ms=2, lw=0.6)
    label, symbol = (r"\ell_r", r"\ell_r") if length == "l_r" else (r"\ell/R_{\max}", r"\ell")
    ax.set(xlabel=f"${label}$", ylabel=rf"$\langle f\rangle_{{{symbol}}}/\langle f\rangle$",
           ylim=(0, None))
    return ax


register("O13", "Mean contact force, over the mean of all contacts, of the contacts of (a) a "
         "reduced branch length, (b) a branch length.",
         force_by_length, dict(l_r="reduced_length", l="length"),
         figure=plain(plot_force_by_length, partial(plot_force_by_length, length="l")))
