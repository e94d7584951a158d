"""Polar diagrams of observables, see `rcr._pictures.curves`. Needs NumPy and Matplotlib."""

import matplotlib
import matplotlib.ticker
import numpy as np

from rcr._pictures.curves import MARKERS, column, of_each_eta


def xi_color(k, count):
    """Return the colour of the k-th of `count` cutoffs ξ; each is legible on white."""
    return matplotlib.colormaps["inferno"](0.66 * k / max(count - 1, 1))


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


def row_near(value, eta):
    """Return the index of the elongation nearest to η."""
    return int(np.argmin(np.abs(column(value, "eta") - eta)))


def plot_contact_directions(value, row, ax):
    """Draw P(θ, ξ) of an elongation with its Fourier fit (1 + a cos 2(θ − θ_c))/π."""
    sigma = column(value, "theta_sigma")[row]

    def fit(amplitude, off):
        size = amplitude / np.cos(2 * off)
        return lambda theta: (1 + size * np.cos(2 * (theta - sigma - off))) / np.pi

    fits = map(fit, column(value, "amplitude")[row], column(value, "off_axis")[row])
    labels = xi_labels(value, "xi")
    return plot_polar(column(value, "theta"), column(value, "pdf")[row], fits, labels, ax)


def plot_vector_directions(value, name, row, sigma, ax):
    """Draw a normal (…_n) or tangential (…_t) mean of an elongation by direction, and its fit."""
    amplitudes = column(value, f"{name}_amplitude")[row]
    means = column(value, f"{name}_mean")[row] if name.endswith("n") else np.zeros_like(amplitudes)
    wave = np.cos if name.endswith("n") else np.sin
    fits = [lambda theta, m=m, a=a: m + a * wave(2 * (theta - sigma))
            for m, a in zip(means, amplitudes)]
    labels = xi_labels(value, "xi_polar")
    return plot_polar(column(value, "theta"), column(value, name)[row], fits, labels, ax)


def plot_isotropy(value, ax):
    """Draw P(θ) of every elongation after compaction, and the circle 1/π."""
    theta = column(value, "theta")
    for _, row, _, style in of_each_eta(value, "pdf"):
        closed = np.append(np.tile(row, 2), row[0])
        turn = np.linspace(theta[0], theta[0] + 2 * np.pi, len(closed))
        ax.plot(turn, closed, lw=0.7, **style)
    ax.plot(
        np.linspace(0, 2 * np.pi, 361), np.full(361, 1 / np.pi), "k--", lw=0.9, label=r"$1/\pi$")
    ax.set_ylim(0, None)
    return style_polar(ax)
