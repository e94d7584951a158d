"""Observables of ξ-networks, the contacts with f_n ≤ ξ ⟨f_n⟩: O14 to O18.

Angular functions ⟨·⟩(θ, ξ) are means over the contacts of S(ξ) with a normal near θ. The paper's
forms are fitted by least squares. Tangential components are along n turned by −90°: then
⟨f_t⟩ = ⟨f_n⟩ a_ft sin 2(θ − θσ) with a_ft > 0.
"""

import functools

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rcr import statistics
from rcr._pictures.curves import (add_letters, column, legend_outside, marker, of_each_eta, plain,
                                  plot_xi)
from rcr._pictures.drawing import COLUMN, PAGE
from rcr._pictures.polar import plot_contact_directions, plot_vector_directions, row_near
from rcr.observables.packings import SEEDS
from rcr.observables.registry import register

_CURVES = "Each colour is an elongation η; bands and bars are one standard error."
_XI = "of the contacts with f_n ≤ ξ ⟨f_n⟩, over all contacts, against the cutoff ξ"


def contact_directions(e, grids):
    """Return P(θ, ξ), with integral 1 over [0, π], and its Fourier fit (1 + a cos 2(θ − θ_c))/π.

    ``amplitude`` is a cos 2 ``off_axis``, ``off_axis`` is θ_c − θσ [rad].
    """
    picks = [e.fn <= xi for xi in grids.xi_polar]
    pdf = np.array([statistics.density(e.angle[pick], grids.theta) for pick in picks])
    waves = [np.exp(2j * e.theta[pick]) for pick in picks]
    moments = np.array([2 * np.mean(wave) if len(wave) else np.nan for wave in waves])
    return dict(pdf=pdf, amplitude=moments.real, off_axis=0.5 * np.angle(moments),
                theta_sigma=e.stress_angle)


def _polar(value, analysis, paper):
    """Make the figure of P(θ, ξ)."""
    fig = Figure(figsize=(COLUMN, 1.1 * COLUMN), layout="constrained")
    row = row_near(value, paper.polar_eta)
    ax = plot_contact_directions(value, row, fig.add_subplot(projection="polar"))
    ax.set_title(rf"$P_\theta(\theta, \xi)$, $\eta = {value['eta'][row]:g}$", fontsize=8)
    legend_outside(fig, ax, "lower center", 4)
    return fig


register("O14", "Probability density of the directions of contact normals with f_n ≤ ξ ⟨f_n⟩, and "
         "its Fourier fit.", contact_directions, dict(theta="theta", xi="xi_polar"),
         figure=_polar, unit="θ in rad, pdf in 1/rad, the rest -")


@functools.lru_cache(maxsize=1)
def anisotropies(e, grids):
    """Return {name: anisotropy (ξ,)} of `Anisotropies`."""
    return e.xi_networks.anisotropies(grids.xi)._asdict()


def drift(runs, ensemble, grids):
    """Return the change of a_c over the strains of the networks.

    A straight line is fitted, with one slope for all seeds; NaN for fewer than three networks. The
    error is that over the slopes of the seeds if there are `SEEDS`, else that of the fit.
    """
    strains = [np.array([n.attributes["strain"] for n in run.networks]) for run in runs]
    values = [np.array([n.anisotropies()[0] for n in run.networks]) for run in runs]
    slope, error = statistics.common_slope([*zip(strains, values)])
    if len(runs) >= SEEDS:
        error = statistics.standard_error(
            [statistics.common_slope([seed])[0] for seed in zip(strains, values)])
    length = np.ptp(np.concatenate(strains))
    return dict(a_c_drift=slope * length, a_c_drift_error=error * length)


register("O15", f"Anisotropy a_c of the contact normals {_XI}. {_CURVES}",
         lambda e, grids: dict(a_c=anisotropies(e, grids)["a_c"]), dict(xi="xi"), drift,
         plain(lambda value, ax: plot_xi(value, "a_c", r"$a_c(\xi)$", ax)))


def angular_function(e, grids, value, form):
    """Return means of a column of contacts by the direction of their normals, and their fit.

    Returns the means (ξ, θ), then mean and amplitude (ξ,) of the fit: mean + amplitude
    cos 2(θ − θσ) if `form` is np.cos, or amplitude sin 2(θ − θσ) if it is np.sin; NaN without any
    contact.
    """
    function, fits = [], []
    for xi in grids.xi_polar:
        pick = e.fn <= xi
        wave = form(2 * e.theta[pick])
        constant = np.full_like(wave, form is np.cos)
        function.append(statistics.bin_means(e.angle[pick], value[pick], grids.theta))
        fit = np.linalg.lstsq(np.column_stack([constant, wave]), value[pick], rcond=None)[0]
        fits.append(fit if pick.any() else np.full(2, np.nan))
    return np.array(function), *np.array(fits).T


def vector_anisotropies(e, grids, vector):
    """Return anisotropies and angular functions of branch vectors ("l") or forces ("f")."""
    normal, tangential = (getattr(e, f"{vector}{component}") for component in "nt")
    scale = normal.mean()
    along, mean, along_amplitude = angular_function(e, grids, normal / scale, np.cos)
    across, _, across_amplitude = angular_function(e, grids, -tangential / scale, np.sin)
    values = {name: value for name, value in anisotropies(e, grids).items() if vector in name}
    functions = dict(n=along, n_mean=mean, n_amplitude=along_amplitude, t=across,
                     t_amplitude=across_amplitude)
    return values | {f"{vector}_{name}": value for name, value in functions.items()}


def _four(vector, symbol):
    """Return a function that makes a figure: two polar diagrams above two functions of ξ."""
    scale = rf"\langle {symbol}_n\rangle"
    titles = (rf"${scale}(\theta,\xi)/{scale}$",
              rf"$|\langle {symbol}_t\rangle(\theta,\xi)|/{scale}$")

    def figure(value, analysis, paper):
        fig = Figure(figsize=(PAGE, 0.95 * PAGE), layout="constrained")
        upper, lower = fig.subfigures(2, 1, height_ratios=(1, 0.9))
        row = row_near(value, paper.polar_eta)
        sigma = column(analysis["O14"]["value"], "theta_sigma")[row]
        polar = [upper.add_subplot(1, 2, k + 1, projection="polar") for k in range(2)]
        for ax, suffix, title in zip(polar, "nt", titles):
            plot_vector_directions(value, f"{vector}_{suffix}", row, sigma, ax)
            ax.set_title(rf"{title}, $\eta = {value['eta'][row]:g}$"
                         + (" (open: negative)" if suffix == "t" else ""), fontsize=8)
        legend_outside(upper, polar[0], "lower center", 4)
        axes = lower.subplots(1, 2)
        for ax, suffix in zip(axes, "nt"):
            plot_xi(value, f"a_{vector}{suffix}", rf"$a_{{{symbol} {suffix}}}(\xi)$", ax)
        add_letters([*polar, *axes])
        legend_outside(lower, axes[0], "upper center", 8)
        return fig

    return figure


_AXES = dict(xi="xi", xi_polar="xi_polar", theta="theta")
register("O16", "(a) Normal and (b) tangential branch components by direction, with fits; (c), (d) "
         f"their anisotropies {_XI}. {_CURVES}",
         functools.partial(vector_anisotropies, vector="l"), _AXES, figure=_four("l", r"\ell"),
         unit="θ in rad, the rest -")
register("O17", "(a) Normal and (b) tangential forces by direction, with fits; (c), (d) their "
         f"anisotropies {_XI}. {_CURVES}",
         functools.partial(vector_anisotropies, vector="f"), _AXES, figure=_four("f", "f"),
         unit="θ in rad, the rest -")


def shear_stress(e, grids):
    """Return q(ξ)/p, the half-sum of the anisotropies, and their difference.

    κ q(ξ)/p = half-sum + cross products exactly, with the pressure factor κ.
    """
    ratio = e.xi_networks.shear_stress_ratio(grids.xi)
    half_sum = 0.5 * np.sum(list(anisotropies(e, grids).values()), axis=0)
    return dict(q_over_p=ratio, half_sum=half_sum, closure=half_sum - ratio,
                cross_products=e.xi_networks.cross_products(grids.xi),
                pressure_factor=e.xi_networks.pressure_factor())


def plot_shear_stress(value, ax):
    """Draw q(ξ)/p as lines, half-sums of the anisotropies as markers."""
    plot_xi(value, "q_over_p", r"$q(\xi)/p$", ax)
    for eta, row, _, style in of_each_eta(value, "half_sum"):
        ax.plot(column(value, "xi")[::6], row[::6], ls="", marker=marker(eta),
                color=style["color"], mfc="none", mew=0.6)
    marks = Line2D([], [], color="k", ls="", marker="o", mfc="none", mew=0.6)
    ax.legend([Line2D([], [], color="k"), marks], [r"$q(\xi)/p$", "half-sum of anisotropies"],
              loc="upper left")
    return ax


register("O18", f"Share q(ξ)/p of the shear stress {_XI}; markers: half the sum of the five "
         "anisotropies.", shear_stress, dict(xi="xi"), figure=plain(plot_shear_stress))
