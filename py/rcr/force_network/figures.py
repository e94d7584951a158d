"""Figures of force networks of any scene, from the measures of `rcr.force_network.analysis`.

Each function takes {name of a set: its measures} and returns a Figure. Needs NumPy and Matplotlib.
"""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from rcr._pictures.drawing import PAGE, STYLE
from rcr.plot import packing

COLORS = ("#1f4e9c", "#c23b22", "#2a7f3f", "#7b3fa0", "#8a5a00", "#00788a")  # dark on white
MARKERS = "osD^v<>p"


def _styles(measures):
    """Yield name, measures, colour and marker of each set."""
    for k, (name, one) in enumerate(measures.items()):
        yield name, one, COLORS[k % len(COLORS)], MARKERS[k % len(MARKERS)]


def _finish(figure, measures, ax):
    if len(measures) > 1:
        ax.legend()
    return figure


def forces(measures, component="normal"):
    """Draw P(f) of a component with the fits of its exponents: log-linear and log-log axes."""
    figure = Figure(figsize=(PAGE, 0.45 * PAGE), layout="constrained")
    axes = figure.subplots(1, 2)
    symbol = "f_n" if component == "normal" else "|f_t|"
    for name, one, tint, mark in _styles(measures):
        found = one[f"{component}_force"]
        if found is None:
            continue
        pdf, seen = np.array(found["pdf"]), np.array(found["pdf"]) > 0
        for ax, fit in zip(axes, (_tail, _power)):
            ax.plot(np.array(found["force"])[seen], pdf[seen], ls="", marker=mark, color=tint,
                    mew=0, label=name)
            ax.plot(*fit(found), color=tint, lw=0.9)
    for ax, scale in zip(axes, ("linear", "log")):
        ax.set(xlabel=rf"${symbol}/\langle {symbol}\rangle$", ylabel=r"$P$", yscale="log",
               xscale=scale)
    return _finish(figure, measures, axes[0])


def _weak(found):
    """Return the share of forces below their mean in the bins of a density."""
    edges, pdf = np.array(found["edges"]), np.array(found["pdf"])
    return np.sum(pdf * (np.minimum(edges[1:], 1) - np.minimum(edges[:-1], 1)))


def _tail(found):
    """Return the fitted α e^{−α(f − 1)} times the share of the forces above the mean."""
    f = np.linspace(1, max(found["edges"][-1], 1), 50)
    return f, (1 - _weak(found)) * found["alpha"] * np.exp(-found["alpha"] * (f - 1))


def _power(found):
    """Return the fitted power law of the forces below the mean, with their share as integral."""
    f, beta = np.geomspace(0.01, 1, 50), found["beta"]
    return f, _weak(found) * (beta + 1) / (1 - 0.01 ** (beta + 1)) * f**beta


def directions(measures):
    """Draw P(θ) and ⟨f_n⟩(θ)/⟨f_n⟩ as polar diagrams."""
    figure = Figure(figsize=(PAGE, 0.5 * PAGE), layout="constrained")
    axes = figure.subplots(1, 2, subplot_kw=dict(projection="polar"))
    for name, one, tint, mark in _styles(measures):
        for ax, column in zip(axes, ("pdf", "force_n")):
            theta, values = (np.array(one["directions"][key]) for key in ("theta", column))
            around = np.concatenate([theta, theta + np.pi, theta[:1] + 2 * np.pi])
            ax.plot(around, np.append(np.tile(values, 2), values[0]), color=tint, marker=mark,
                    ms=2.5, lw=0.8, label=name)
    for ax, title in zip(axes, (r"$P(\theta)$ [1/rad]", r"$\langle f_n\rangle(\theta)/\langle f_n"
                                r"\rangle$")):
        ax.set_ylim(0, None)
        ax.set_title(title, fontsize=9)
        ax.tick_params(labelsize=7)
        ax.grid(lw=0.3, color="0.8")
    return _finish(figure, measures, axes[0])


def fabric(measures):
    """Draw a_c(ξ) and q(ξ)/p."""
    figure = Figure(figsize=(PAGE, 0.45 * PAGE), layout="constrained")
    axes = figure.subplots(1, 2)
    for name, one, tint, _ in _styles(measures):
        for ax, column in zip(axes, ("a_c", "q_over_p")):
            ax.plot(np.array(one["xi"])[:-1], np.array(one[column])[:-1], color=tint, label=name)
    for ax, symbol in zip(axes, (r"$a_c(\xi)$", r"$q(\xi)/p$")):
        ax.axhline(0, color="0.7", lw=0.6)
        ax.set(xlabel=r"$\xi$", ylabel=symbol, xlim=(0, 6))
    return _finish(figure, measures, axes[0])


def map_of(network):
    """Draw the grains and forces of a network."""
    return packing(network, color="0.85", contacts="force").figure


def chains_of(network):
    """Draw the grains of force chains in colour, and all forces."""
    return packing(network, color="chain", contacts="force").figure


def draw(function, *arguments):
    """Return the figure of a function in the style of all pictures."""
    with matplotlib.rc_context(STYLE):
        return function(*arguments)
