"""Maps of one network: grains, forces, friction mobilisation, orientations, contact types.

Each map is a few collections: 13 000 grains take seconds and are vectors in a PDF. Each
``plot_…(network)`` returns Axes of a new figure with room for a legend; `draw` adds the legend.
Needs NumPy and Matplotlib.
"""

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize, to_rgba_array
from matplotlib.lines import Line2D

from rcr._pictures import drawing, keys
from rcr._pictures.drawing import GRAIN, MOBILIZED, RATTLER, STYLE, TYPES
from rcr._pictures.grain_colors import HUES, grain_colors
from rcr.network import SIDE_SIDE


def _canvas(network):
    """Return Axes with the extent of a network."""
    return drawing.page(network.extent(), drawing.FOOT + drawing.SCALE_ROW)


def _grains(network, ax, colors, edge="0.5"):
    """Draw the grains within their periodic cell."""
    at = network.grains["position"]
    grains = network.grains | dict(position=at + network.wrap(at))
    drawing.add_grains(
        ax, grains, network.shapes, network.mean_radius(), edge, facecolors=colors)


def _forces(network, ax):
    """Draw forces between grains, with the scales of length and force."""
    pick = network.between_particles
    force = network.normal_force()[pick]
    scale = drawing.force_scale(ax, network, float(force.mean()))
    drawing.add_forces(ax, network.segments()[pick], force, scale)
    _scales(ax, scale)


def _scales(ax, scale=None):
    """Add the scales of length and force above the legend."""
    keys.add_scales(ax, drawing.FOOT + 0.5 * drawing.SCALE_ROW, scale)


def _grey(network):
    """Return the colour of each grain, pale without a contact, (N,) str."""
    bearing = network.per_grain(np.ones(len(network.contacts["body1"]))) > 0
    return np.where(bearing, GRAIN, RATTLER)


def plot_packing(network):
    """Draw grains coloured by the orientation of their long axes, discs grey."""
    ax = _canvas(network)
    _grains(network, ax, _orientation_colors(network), "0.2")
    _scales(ax)
    return ax


def plot_mobilization(network):
    """Draw normal forces as thickness of segments, I_m as diameter of discs."""
    ax = _canvas(network)
    _grains(network, ax, _grey(network))
    _forces(network, ax)
    size = 0.5 * network.mean_radius() * np.minimum(network.friction_mobilization(), 1)
    at = network.contacts["position"][network.between_particles]
    centres = at + network.wrap(at)
    wide = 0.02 * drawing.points_a_metre(ax) * network.mean_radius()
    discs = EllipseCollection(
        size, size, np.zeros_like(size), units="xy", offsets=centres, offset_transform=ax.transData)
    discs.set(facecolor=MOBILIZED, edgecolor="0.3", linewidth=wide, zorder=5)
    ax.add_collection(discs)
    return ax


def _orientation_colors(network):
    return grain_colors(network, "orientation", None, None)[0]


def plot_nematic(network):
    """Draw forces, and grains with a side-side contact coloured by their orientation."""
    ax = _canvas(network)
    chained = network.per_grain(network.contacts["type"] == SIDE_SIDE) > 0
    grey = to_rgba_array(_grey(network))
    _grains(network, ax, np.where(chained[:, None], _orientation_colors(network), grey))
    _forces(network, ax)
    return ax


def plot_types(network):
    """Draw centre-to-contact segments coloured by contact type."""
    ax = _canvas(network)
    _grains(network, ax, _grey(network))
    lines = network.segments()
    types = np.where(network.between_particles, network.contacts["type"], -1)
    for code, tint in enumerate(TYPES.values()):
        pick = types == code
        drawing.add_segments(ax, lines[pick], np.full(pick.sum(), 0.25 * network.mean_radius()),
                             colors=tint, zorder=3 + code)
    _scales(ax)
    return ax


def draw(network, plot, marks, oriented):
    """Return a figure of a plot, as wide as a page, with a legend below.

    It has these `marks`, and a scale of orientations if grains are `oriented`.
    """
    eta = float(network.attributes["eta"])
    with matplotlib.rc_context(STYLE):
        figure = plot(network).figure
        height = figure.get_figheight()
        figure.text(0.01, 0.2 / height, rf"$\eta = {eta:g}$", va="center", fontsize=9)
        if oriented and eta > 0:
            bar = figure.add_axes((0.6, 0.26 / height, 0.36, 0.1 / height))
            figure.colorbar(ScalarMappable(Normalize(0, 180), HUES), cax=bar,
                            orientation="horizontal", ticks=[0, 45, 90, 135, 180])
            bar.tick_params(labelsize=7, pad=1, top=False)
            figure.text(
                0.59, 0.31 / height, "long axis from $x$ [°]", ha="right", va="center", fontsize=8)
        if marks:
            figure.legend(handles=[Line2D([], [], **mark) for mark in marks], loc="center left",
                          bbox_to_anchor=(0.09, 0.2 / height), ncol=3, fontsize=8)
        return figure
