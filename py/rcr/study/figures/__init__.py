"""The figures of the paper, drawn from the analysis. Needs NumPy and Matplotlib.

`draw` makes the figure of an observable. Each ``plot_…(value, ax)`` takes the value of an
observable, as `rcr.study.analysis.analyse` or analysis.json gives it, draws all elongations into
the Axes and returns them. Colour and marker of an elongation, and the colour of a cutoff ξ, are
the same in all figures.
"""

from functools import partial

import matplotlib
from matplotlib.figure import Figure

from rcr._pictures.drawing import COLUMN, PAGE, STYLE
from rcr.study.figures.curves import (
    plot_coordination, plot_correlation, plot_force_by_length, plot_force_power, plot_force_tail,
    plot_length_pdf, plot_mobilization, plot_mobilization_by_force, plot_mobilization_pdf,
    plot_shear_stress, plot_strain, plot_strength, plot_strips, plot_xi)
from rcr.study.figures.plot_style import column, legend_outside
from rcr.study.figures.polar import (plot_contact_directions, plot_isotropy,
                                      plot_vector_directions, polar_row)


def _plain(*plots, legend=True, projection=None):
    """Return a function that makes a figure of one plot, or of two, the first in a projection."""

    def figure(value, analysis):
        size = (COLUMN, 0.95 * COLUMN) if len(plots) == 1 else (PAGE, 0.45 * PAGE)
        fig = Figure(figsize=size, layout="constrained")
        axes = [plot(value, fig.add_subplot(1, len(plots), k, projection=shape))
                for k, (plot, shape) in enumerate(zip(plots, (projection, None)), 1)]
        if len(plots) > 1:
            _letters(axes)
        if legend:
            legend_outside(fig, axes[0], "upper center", 4 * len(plots))
        return fig

    return figure


def _letters(axes):
    for letter, ax in zip("abcd", axes):
        ax.set_title(f"({letter})", loc="left", fontsize=9)


def _four(vector, symbol):
    """Return a function that makes a figure: two polar diagrams above two functions of ξ."""
    scale = rf"\langle {symbol}_n\rangle"
    titles = (rf"${scale}(\theta,\xi)/{scale}$",
              rf"$|\langle {symbol}_t\rangle(\theta,\xi)|/{scale}$")

    def figure(value, analysis):
        fig = Figure(figsize=(PAGE, 0.95 * PAGE), layout="constrained")
        upper, lower = fig.subfigures(2, 1, height_ratios=(1, 0.9))
        row = polar_row(value)
        sigma = column(analysis["O14"]["value"], "theta_sigma")[row]
        polar = [upper.add_subplot(1, 2, k + 1, projection="polar") for k in range(2)]
        for ax, suffix, title in zip(polar, "nt", titles):
            plot_vector_directions(value, f"{vector}_{suffix}", sigma, ax)
            ax.set_title(rf"{title}, $\eta = {value['eta'][row]:g}$"
                         + (" (open: negative)" if suffix == "t" else ""), fontsize=8)
        legend_outside(upper, polar[0], "lower center", 4)
        axes = lower.subplots(1, 2)
        for ax, suffix in zip(axes, "nt"):
            plot_xi(value, f"a_{vector}{suffix}", rf"$a_{{{symbol} {suffix}}}(\xi)$", ax)
        _letters([*polar, *axes])
        legend_outside(lower, axes[0], "upper center", 8)
        return fig

    return figure


def _polar(value, analysis):
    """Make the figure of P(θ, ξ)."""
    fig = Figure(figsize=(COLUMN, 1.1 * COLUMN), layout="constrained")
    ax = plot_contact_directions(value, fig.add_subplot(projection="polar"))
    ax.set_title(
        rf"$P_\theta(\theta, \xi)$, $\eta = {value['eta'][polar_row(value)]:g}$", fontsize=8)
    legend_outside(fig, ax, "lower center", 4)
    return fig


FIGURES = dict(
    O1=_plain(plot_strain, plot_strength),
    O2=_plain(plot_isotropy, plot_coordination, projection="polar"),
    O3=_plain(plot_force_tail, plot_force_power),
    O4=_plain(partial(plot_force_tail, suffix="t"), partial(plot_force_power, suffix="t")),
    O5=_plain(plot_mobilization, legend=False),
    O6=_plain(plot_strips, partial(plot_strips, name="strip_stress", symbol=r"\sigma_{xx}")),
    O7=_plain(plot_mobilization_by_force),
    O8=_plain(plot_mobilization_pdf),
    O10=_plain(plot_length_pdf),
    O12=_plain(plot_correlation, legend=False),
    O13=_plain(plot_force_by_length, partial(plot_force_by_length, length="l")),
    O14=_polar,
    O15=_plain(lambda value, ax: plot_xi(value, "a_c", r"$a_c(\xi)$", ax)),
    O16=_four("l", r"\ell"),
    O17=_four("f", "f"),
    O18=_plain(plot_shear_stress),
)


def draw(observable, analysis):
    """Return the figure of an observable (a key of `FIGURES`) of a result of `analyse`."""
    with matplotlib.rc_context(STYLE):
        return FIGURES[observable](analysis[observable]["value"], analysis)


SMALL = dict(  # observable: its figure on the first screen of the report
    O1=_plain(plot_strength, legend=False), O3=_plain(plot_force_tail), O15=FIGURES["O15"])


def draw_small(observable, analysis):
    """Return the small figure of an observable (a key of `SMALL`)."""
    with matplotlib.rc_context(STYLE):
        return SMALL[observable](analysis[observable]["value"], analysis)
