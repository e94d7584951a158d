"""Curves of the figures of the study. Needs NumPy and Matplotlib.

See `rcr.study.figures` for the arguments of each ``plot_…``.
"""

import matplotlib.ticker
import numpy as np
from matplotlib.lines import Line2D

from rcr.study.figures.plot_style import column, color, error_of, marker

XI_MAX = 6  # end of the ξ axes; few forces are larger
MIN_DENSITY = 1e-4  # lower densities come from single contacts


def _draw_curves(value, y, ax):
    """Draw y(ξ) of every elongation, with a band of one standard error."""
    xi = column(value, "xi")
    for eta, row, error in zip(value["eta"], column(value, y), error_of(value, y)):
        ax.plot(xi, row, color=color(eta), label=rf"$\eta = {eta:g}$")
        ax.fill_between(xi, row - error, row + error, color=color(eta), alpha=0.2, lw=0)


def _draw_points(value, x, y, ax, line="", least=-np.inf, **style):
    """Draw y(x) > least of every elongation as markers."""
    for eta, row in zip(value["eta"], column(value, y)):
        seen = row > least
        ax.plot(column(value, x)[seen], row[seen], line, marker=marker(eta), color=color(eta),
                mew=0, label=rf"$\eta = {eta:g}$", **style)


def _draw_by_eta(value, name, ax, label=None, style="k", mark="o", **options):
    """Draw a number against η, with error bars."""
    ax.errorbar(column(value, "eta"), column(value, name), error_of(value, name), color=style,
                marker=mark, lw=0.8, label=label, **options)
    ax.set_xlabel(r"$\eta$")


def plot_strain(value, ax):
    """Draw sin φ against the strain [O1]."""
    for eta, row in zip(value["eta"], column(value, "sin_phi_strain")):
        ax.plot(column(value, "strain"), row, color=color(eta), lw=0.8, label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"strain $\varepsilon$", ylabel=r"$\sin\varphi = q/p$",
           xlim=(0, column(value, "strain")[-1]), ylim=(0, None))
    return ax


def plot_strength(value, ax):
    """Draw the mean sin φ against η, with the paper's line [O1]."""
    line = np.array([0, 0.7])
    ax.plot(line, 0.3 + 0.3 * line, color="0.5", ls="--", label=r"paper: $0.30 + 0.30\,\eta$")
    _draw_by_eta(value, "sin_phi", ax, label="mean over the strains")
    ax.set(ylabel=r"$\sin\varphi$", ylim=(0, None))
    ax.legend(loc="lower right")
    return ax


def _plot_forces(value, ax, suffix, exponent, place, **axes):
    """Draw P(f), with an exponent against η inset; return the inset."""
    name = f"f_{suffix}"
    bare = name if suffix == "n" else f"|{name}|"
    _draw_points(value, name, "pdf", ax, least=MIN_DENSITY, ms=2.5)
    ax.set(xlabel=rf"${bare}/\langle {bare}\rangle$", ylabel=rf"$P({name})$", yscale="log", **axes)
    inset = ax.inset_axes(place)
    _draw_by_eta(value, f"{exponent}_{suffix}", inset, ms=2, elinewidth=0.6)
    inset.set_ylabel(rf"$\{exponent}_{suffix}$", labelpad=1, fontsize=8)
    inset.set_xlabel(r"$\eta$", labelpad=0, fontsize=8)
    inset.tick_params(labelsize=6.5)
    return inset


def plot_force_tail(value, ax, suffix="n"):
    """Draw P(f) in log-linear scales, with α(η) inset [O3, O4]."""
    limits = dict(xlim=(0, 10), ylim=(MIN_DENSITY, 30))
    _plot_forces(value, ax, suffix, "alpha", (0.57, 0.6, 0.4, 0.37), **limits)
    return ax


def plot_force_power(value, ax, suffix="n"):
    """Draw P(f) in log-log scales, with β(η) inset, and as + from f = 0.1 ⟨f⟩ on [O3, O4]."""
    limits = dict(xlim=(1e-3, 20), ylim=(MIN_DENSITY, 300 if suffix == "t" else 100))
    place = (0.2, 0.18, 0.4, 0.37)
    inset = _plot_forces(value, ax, suffix, "beta", place, xscale="log", **limits)
    inset.plot(value["eta"], column(value, f"beta_{suffix}_tenth"), "k+", ms=3, mew=0.6)
    return ax


def plot_mobilization(value, ax):
    """Draw I_M(η) [O5]."""
    _draw_by_eta(value, "friction_mobilization", ax)
    ax.set(ylabel=r"$I_M$", ylim=(0, 1))
    return ax


def plot_coordination(value, ax):
    """Draw Z and Z_c of the isotropic packings against η, with the isostatic numbers [O2]."""
    for count in (4, 6):
        ax.axhline(count, color="0.8", lw=0.8)
    ax.plot(value["eta"], column(value, "coordination_number"), "ks-", ms=4, lw=0.8, label="$Z$")
    ax.plot(value["eta"], column(value, "coordination_number_twice"), "ko-", ms=4, lw=0.8,
            mfc="w", label="$Z_c$: side-side contacts twice")
    ax.set(xlabel=r"$\eta$", ylabel="coordination number", ylim=(3, 7))
    ax.legend(loc="lower right")
    return ax


def plot_strips(value, ax, name="strip_force", symbol=r"\langle f_n\rangle"):
    """Draw a mean of vertical strips from wall to wall, over that of the sample [O6]."""
    ax.axhspan(0.9, 1.1, color="0.92", lw=0)
    for eta, row, error in zip(value["eta"], column(value, name), error_of(value, name)):
        ax.errorbar(column(value, "strip"), row, error, color=color(eta), marker=marker(eta), ms=3,
                    lw=0.8, elinewidth=0.6, label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"$x/W$ (fixed wall at 0, free wall at 1)",
           ylabel=rf"${symbol}$ of a strip over the mean", xlim=(0, 1))
    return ax


def plot_mobilization_by_force(value, ax):
    """Draw I_mf(f_n) [O7]."""
    _draw_points(value, "f_n", "i_mf", ax, line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$f_n/\langle f_n\rangle$", ylabel=r"$I_{mf}$", xlim=(0, XI_MAX), ylim=(0, 1))
    return ax


def plot_mobilization_pdf(value, ax):
    """Draw P(I_m) [O8]."""
    _draw_points(value, "i_m", "pdf", ax, line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$I_m$", ylabel=r"$P(I_m)$", xlim=(0, 1), yscale="log")
    ax.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    ax.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    return ax


def plot_length_pdf(value, ax):
    """Draw P(ℓ_r) of each elongation, except discs, where ℓ_r is 1 [O10]."""
    for eta, row in zip(value["eta"], column(value, "pdf")):
        seen = column(value, "l_r") > 1 - eta
        if eta > 0:
            ax.plot(column(value, "l_r")[seen], row[seen], color=color(eta), lw=0.8,
                    label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"$\ell_r$", ylabel=r"$P(\ell_r)$", ylim=(0, None),
           xlim=(column(value, "l_r")[0] - 0.01, 1.005))
    return ax


def plot_correlation(value, ax):
    """Draw Pearson coefficients of force and branch length against η [O12]."""
    ax.axhline(0, color="0.7", lw=0.6)
    _draw_by_eta(value, "c_f_lr", ax, label=r"$C_{f\ell_r}$")
    _draw_by_eta(value, "c_f_l", ax, label=r"$C_{f\ell}$", style="tab:red", mark="s")
    ax.set_ylabel("Pearson coefficient")
    ax.legend()
    return ax


def plot_force_by_length(value, ax, length="l_r"):
    """Draw the mean force of bins of ℓ_r or ℓ [O13]."""
    ax.axhline(1, color="0.7", lw=0.6)
    _draw_points(value, length, f"f_{length}", ax, line="-", ms=2, lw=0.6)
    label, symbol = (r"\ell_r", r"\ell_r") if length == "l_r" else (r"\ell/R_{\max}", r"\ell")
    ax.set(xlabel=f"${label}$", ylabel=rf"$\langle f\rangle_{{{symbol}}}/\langle f\rangle$",
           ylim=(0, None))
    return ax


def plot_xi(value, name, symbol, ax):
    """Draw a function of ξ for every elongation [O15 to O17]."""
    ax.axhline(0, color="0.7", lw=0.6)
    _draw_curves(value, name, ax)
    ax.set(xlabel=r"$\xi$", ylabel=symbol, xlim=(0, XI_MAX))
    return ax


def plot_shear_stress(value, ax):
    """Draw q(ξ)/p as lines, half-sums of the anisotropies as markers [O18]."""
    ax.axhline(0, color="0.7", lw=0.6)
    _draw_curves(value, "q_over_p", ax)
    for eta, row in zip(value["eta"], column(value, "half_sum")):
        ax.plot(column(value, "xi")[::6], row[::6], ls="", marker=marker(eta), color=color(eta),
                mfc="none", mew=0.6)
    ax.set(xlabel=r"$\xi$", ylabel=r"$q(\xi)/p$", xlim=(0, XI_MAX))
    marks = Line2D([], [], color="k", ls="", marker="o", mfc="none", mew=0.6)
    ax.legend([Line2D([], [], color="k"), marks], [r"$q(\xi)/p$", "half-sum of anisotropies"],
              loc="upper left")
    return ax
