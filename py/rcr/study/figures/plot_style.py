"""Colours, markers and axes of the figures of the study. Needs NumPy and Matplotlib."""

import matplotlib
import numpy as np

from rcr.study.claims.statements import ETAS

MARKERS = "osD^v<>p"


def color(eta):
    """Return the colour of an elongation, black for discs; each is legible on white."""
    return matplotlib.colormaps["gnuplot"](0.75 * min(eta / max(ETAS), 1))


def marker(eta):
    """Return the marker of an elongation."""
    return MARKERS[int(round(10 * eta)) % len(MARKERS)]


def xi_color(k, count):
    """Return the colour of the k-th of `count` cutoffs ξ; each is legible on white."""
    return matplotlib.colormaps["inferno"](0.66 * k / max(count - 1, 1))


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
