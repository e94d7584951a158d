"""Curves of observables: colours, markers, axes and figures. Needs NumPy and Matplotlib.

A ``plot_…(value, ax)`` takes the value of an observable, as analysis.json has it, draws all
elongations into the Axes and returns them. Colour and marker of an elongation are the same in all
figures.
"""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from rcr._pictures.drawing import COLUMN, PAGE

LARGEST_ETA = 0.7  # elongation at the end of the colours
MARKERS = "osD^v<>p"
XI_MAX = 6  # end of the ξ axes; few forces are larger


def color(eta):
    """Return the colour of an elongation, black for discs; each is legible on white."""
    return matplotlib.colormaps["gnuplot"](0.75 * min(eta / LARGEST_ETA, 1))


def marker(eta):
    """Return the marker of an elongation."""
    return MARKERS[int(round(10 * eta)) % len(MARKERS)]


def column(value, name):
    """Return an array of an observable; None of the file is NaN."""
    return np.asarray(value[name], dtype=float)


def error_of(value, name):
    """Return the standard error of an array, with 0 for unknown errors."""
    return np.nan_to_num(column(value, f"{name}_error"))


def legend_outside(figure, ax, place, columns, **options):
    """Add the legend of `ax` beside all axes; Matplotlib before 3.7 draws it over them."""
    loc = place if matplotlib.__version_info__ < (3, 7) else f"outside {place}"
    figure.legend(*ax.get_legend_handles_labels(), loc=loc, ncol=columns, **options)


def add_letters(axes):
    """Add titles (a), (b), … to Axes."""
    for letter, ax in zip("abcd", axes):
        ax.set_title(f"({letter})", loc="left", fontsize=9)


def plain(*plots, legend=True, projection=None, columns=4):
    """Return a function that makes a figure of one plot, or of two, the first in a projection.

    The legend above them has this number of columns a plot.
    """

    def figure(value, analysis, paper):
        size = (COLUMN, 0.95 * COLUMN) if len(plots) == 1 else (PAGE, 0.45 * PAGE)
        fig = Figure(figsize=size, layout="constrained")
        axes = [plot(value, fig.add_subplot(1, len(plots), k, projection=shape))
                for k, (plot, shape) in enumerate(zip(plots, (projection, None)), 1)]
        if len(plots) > 1:
            add_letters(axes)
        if legend:
            legend_outside(fig, axes[0], "upper center", columns * len(plots))
        return fig

    return figure


def of_each_eta(value, name):
    """Yield elongation, its array of a name, its error if known, and the style of its curve."""
    errors = error_of(value, name) if f"{name}_error" in value else column(value, name)
    for eta, row, error in zip(value["eta"], column(value, name), errors):
        yield eta, row, error, dict(color=color(eta), label=rf"$\eta = {eta:g}$")


def draw_curves(value, y, ax):
    """Draw y(ξ) of every elongation, with a band of one standard error."""
    xi = column(value, "xi")
    ax.axhline(0, color="0.7", lw=0.6)
    for eta, row, error, style in of_each_eta(value, y):
        ax.plot(xi, row, **style)
        ax.fill_between(xi, row - error, row + error, color=color(eta), alpha=0.2, lw=0)


def draw_points(value, x, y, ax, line="", least=-np.inf, **more):
    """Draw y(x) > least of every elongation as markers."""
    for eta, row, _, style in of_each_eta(value, y):
        seen = row > least
        ax.plot(column(value, x)[seen], row[seen], line, marker=marker(eta), mew=0, **style, **more)


def draw_by_eta(value, name, ax, label=None, style="k", mark="o", **options):
    """Draw a number against η, with error bars."""
    ax.errorbar(column(value, "eta"), column(value, name), error_of(value, name), color=style,
                marker=mark, lw=0.8, label=label, **options)
    ax.set_xlabel(r"$\eta$")


def plot_xi(value, name, symbol, ax):
    """Draw a function of ξ for every elongation."""
    draw_curves(value, name, ax)
    ax.set(xlabel=r"$\xi$", ylabel=symbol, xlim=(0, XI_MAX))
    return ax
