"""Grains, contacts and obstacles of a `Frame` as Matplotlib collections: what the maps of the study and `rcr.plot` share.

A packing is a few collections, so that 13 000 grains take a second and stay sharp in a PDF. Nothing here uses pyplot: no display is
needed and no figure stays behind.
"""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from rcr._outlines import polygons

COLUMN, PAGE = 3.4, 7.0  # widths [in]
TALLEST = 9.0  # height of a picture [in]
LEGEND = 5.5  # what a legend below takes at least [in]
STYLE = {
    "font.size": 8,
    "font.family": "sans-serif",
    "mathtext.fontset": "dejavusans",
    "axes.labelsize": 9,
    "axes.linewidth": 0.6,
    "axes.grid": False,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 1.0,
    "lines.markersize": 3,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "errorbar.capsize": 1.5,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "savefig.dpi": 300,
}
LARGEST = 24.0  # radius of a grain up to which lines grow with it [pt]: beyond, they would cover it and reach over the edge
WIDTH = 0.16  # of a segment that carries the mean force, in mean radii
WIDEST = 0.8  # of any segment, likewise
EVEN = 1 + 1e-3  # force over the mean up to which it is no strong one: a mean is rounded, and a step's tolerance is 1e-4
STRONG, WEAK, MOBILIZED = "black", "#d62728", "#ffd92f"
TYPES = dict(zip(("cap-cap", "cap-side", "side-side"), ("#1f77b4", "#2ca02c", "#d62728")))
GRAIN, RATTLER, OBSTACLE = "#d9d9d9", "#f5f5f5", "#9c9c9c"


def page(limits, foot=0.0, width=PAGE):
    """Axes of equal scales and without ticks in a Figure of their own, as high as the limits (2, 2) want, `foot` inches free below."""
    across, up = np.maximum(limits[1] - limits[0], 1e-9 * np.abs(limits).max() + 1e-300)
    body = min(width * up / across, TALLEST)
    width = min(width, max(body * across / up, LEGEND if foot else 1))
    figure = Figure(figsize=(width, body + foot))
    return canvas(limits, figure.add_axes((0, foot / (body + foot), 1, body / (body + foot))))


def canvas(limits, ax):
    """The Axes with these limits and a margin, of equal scales, without ticks."""
    pad = 0.005 * (limits[1] - limits[0]).max()
    (left, bottom), (right, top) = limits[0] - pad, limits[1] + pad
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.axis("off")
    return ax


def points_a_metre(ax):
    """Of the printed Axes: lines have their widths in points."""
    width, height = ax.figure.get_size_inches() * ax.get_position(original=True).size
    return 72 * min(width / np.ptp(ax.get_xlim()), height / np.ptp(ax.get_ylim()))


def line_unit(ax, radius):
    """What lines are measured by [m]: this mean radius of the grains, or less where they are few and large."""
    return min(radius, LARGEST / points_a_metre(ax))


def add_grains(ax, grains, unit, edge="0.5", **style):
    """The outlines of grains, their lines a twentieth of `unit` (see `line_unit`) wide; returns the collection."""
    wide = 0.05 * points_a_metre(ax) * unit
    corners = 30 if len(grains["id"]) < 1000 else 12  # of a cap: what is seen of it
    return ax.add_collection(PolyCollection(polygons(grains, corners), edgecolors=edge, linewidths=wide, **style), autolim=False)


def add_segments(ax, lines, widths, **style):
    """Lines (n, k, 2) of these widths [m] with round ends; returns the collection."""
    wide = points_a_metre(ax) * np.asarray(widths)
    return ax.add_collection(LineCollection(lines, linewidths=wide, capstyle="round", joinstyle="round", **style), autolim=False)


def force_widths(force, unit):
    """Widths of segments with these forces over their mean [m]; see `line_unit`."""
    return unit * np.minimum(WIDTH * force, WIDEST)


def add_forces(ax, lines, force, unit, scale=1.0):
    """Segments as thick as their force (over the mean), strong ones black on top of weak red ones; equal to the mean is weak."""
    widths = scale * force_widths(force, unit)
    for pick, tint, layer in ((force <= EVEN, WEAK, 3), (force > EVEN, STRONG, 4)):
        add_segments(ax, lines[pick], widths[pick], colors=tint, zorder=layer)


def add_obstacles(ax, frame, unit):
    """Walls, boxes, facets and the periodic cell."""
    wide = 0.12 * points_a_metre(ax) * unit
    boxes = [vertices for _, kind, vertices in frame.outlines if kind == "box"]
    facets = [vertices for _, kind, vertices in frame.outlines if kind == "facet"]
    if boxes:
        ax.add_collection(PolyCollection(boxes, facecolors=OBSTACLE, edgecolors="0.25", linewidths=0.4 * wide), autolim=False)
    if facets:
        ax.add_collection(LineCollection(facets, linewidths=wide, colors="0.25", capstyle="round", zorder=2), autolim=False)
    for axis, at in zip(frame.walls["axis"], frame.walls["position"]):
        (ax.axvline if axis == 0 else ax.axhline)(at, color="0.25", lw=max(wide, 0.6), zorder=2)
    if frame.cell is not None:
        edge = (frame.cell @ np.array([[0, 1, 1, 0], [0, 0, 1, 1]])).T
        ax.add_collection(PolyCollection([edge], facecolors="none", edgecolors="0.2", linewidths=0.8, linestyles="--", zorder=5), autolim=False)
