"""Polar diagrams of the figures of the study. Needs NumPy and Matplotlib.

See `rcr.study.figures` for the arguments of each ``plot_…``.
"""

import matplotlib.ticker
import numpy as np

from rcr.study.claims.statements import POLAR_ETA, nearest
from rcr.study.figures.plot_style import MARKERS, column, color, xi_color


def xi_labels(value, name):
    """Return the labels of cutoffs; the last one is infinite."""
    return [*(rf"$\xi = {xi:g}$" for xi in column(value, name)[:-1]), r"$\xi = \infty$"]


def plot_polar(theta, rows, fits, labels, ax):
    """Draw angular functions of period π and their fits as polar curves.

    `rows` (K, T) has a function of `theta` (T,) in [0, π) for each ξ, `fits` the fit of each, a
    function of an angle [rad]. Open markers are the sizes of negative values.
    """
    circle, dense = np.concatenate([theta, theta + np.pi]), np.linspace(0, 2 * np.pi, 361)
    for k, (row, fit, label) in enumerate(zip(rows, fits, labels)):
        tint, around = xi_color(k, len(rows)), np.tile(row, 2)
        ax.plot(dense, np.abs(fit(dense)), color=tint, lw=0.9)
        style = dict(ls="", marker=MARKERS[k], ms=2.5, color=tint)
        positive, negative = around >= 0, around < 0
        ax.plot(circle[positive], around[positive], mew=0, label=label, **style)
        ax.plot(circle[negative], -around[negative], mfc="none", mew=0.5, **style)
    last, known = np.abs(rows[-1]), np.isfinite(rows[-1]).any()
    lowest = np.degrees(theta[np.nanargmin(last)]) if known else 0  # room for the radial labels
    return style_polar(ax, lowest)


def style_polar(ax, labels_at=None):
    """Put radial labels at an angle [°], in the outer half; none without an angle."""
    top = ax.get_ylim()[1]
    ticks = matplotlib.ticker.MaxNLocator(4).tick_values(0, top)
    ticks = [tick for tick in ticks if 0 < tick < 0.85 * top]
    shown = [f"{tick:g}" if labels_at is not None and tick > 0.45 * top else "" for tick in ticks]
    ax.set_yticks(ticks, shown)
    ax.set_rlabel_position(labels_at or 0)
    ax.set_axisbelow(True)
    ax.tick_params(labelsize=7, pad=0)
    ax.grid(lw=0.3, color="0.8")
    return ax


def polar_row(value):
    """Return the index of the elongation nearest to that of the paper's polar diagrams."""
    return list(value["eta"]).index(nearest(value["eta"], [POLAR_ETA])[0])


def plot_contact_directions(value, ax):
    """Draw P(θ, ξ) with its Fourier fit (1 + a cos 2(θ − θ_c))/π [O14]."""
    row = polar_row(value)
    sigma = column(value, "theta_sigma")[row]

    def fit(amplitude, off):
        size = amplitude / np.cos(2 * off)
        return lambda theta: (1 + size * np.cos(2 * (theta - sigma - off))) / np.pi

    fits = map(fit, column(value, "amplitude")[row], column(value, "off_axis")[row])
    labels = xi_labels(value, "xi")
    return plot_polar(column(value, "theta"), column(value, "pdf")[row], fits, labels, ax)


def plot_vector_directions(value, name, sigma, ax):
    """Draw a normal (…_n) or tangential (…_t) mean by direction, and its fit [O16, O17]."""
    row = polar_row(value)
    amplitudes = column(value, f"{name}_amplitude")[row]
    means = column(value, f"{name}_mean")[row] if name.endswith("n") else np.zeros_like(amplitudes)
    wave = np.cos if name.endswith("n") else np.sin
    fits = [lambda theta, m=m, a=a: m + a * wave(2 * (theta - sigma))
            for m, a in zip(means, amplitudes)]
    labels = xi_labels(value, "xi_polar")
    return plot_polar(column(value, "theta"), column(value, name)[row], fits, labels, ax)


def plot_isotropy(value, ax):
    """Draw P(θ) of every elongation after compaction, and the circle 1/π [O2]."""
    theta = column(value, "theta")
    for eta, row in zip(value["eta"], column(value, "pdf")):
        closed = np.append(np.tile(row, 2), row[0])
        ax.plot(np.linspace(theta[0], theta[0] + 2 * np.pi, len(closed)), closed, color=color(eta),
                lw=0.7, label=rf"$\eta = {eta:g}$")
    ax.plot(
        np.linspace(0, 2 * np.pi, 361), np.full(361, 1 / np.pi), "k--", lw=0.9, label=r"$1/\pi$")
    ax.set_ylim(0, None)
    return style_polar(ax)
