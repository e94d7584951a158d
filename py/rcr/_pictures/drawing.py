"""Matplotlib collections of grains, contacts and obstacles, for `rcr.plot` and the study's maps.

A packing takes a few collections: 13 000 grains take a second and stay vectors in a PDF. The
functions make Figures without pyplot, so they need no display and leave no figure open.
"""

import typing

import matplotlib
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from rcr._data import checks
from rcr.geometry import polygons

COLUMN, PAGE = 3.4, 7.0  # widths of a figure [in]
LOWEST, TALLEST = 0.05, 9.0  # bounds of the height of a picture [in]
LEGEND, FOOT = 5.5, 0.45  # smallest width of a picture with keys below; their height [in]
SCALE_ROW = 0.24  # height of the row above the keys, with the scales of length and force [in]
STYLE = {
    "font.size": 8, "font.family": "sans-serif", "mathtext.fontset": "dejavusans",
    "axes.labelsize": 9, "axes.linewidth": 0.6, "axes.grid": False,
    "legend.fontsize": 7, "legend.frameon": False, "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "lines.linewidth": 1.0, "lines.markersize": 3, "errorbar.capsize": 1.5,
    "xtick.direction": "in", "xtick.top": True, "xtick.labelsize": 8,
    "ytick.direction": "in", "ytick.right": True, "ytick.labelsize": 8,
    "pdf.fonttype": 42, "svg.fonttype": "none", "savefig.dpi": 300,
}  # fmt: skip
LARGEST = 24.0  # grain radius above which line widths stop growing [pt]; wider lines hide grains
FORCE_WIDTH = 0.08  # width of a segment with the mean force, over the mean thickness 2R′ [-]
LEAST_WIDTH = 0.2  # the same, at least [pt]; thinner lines fade
WIDEST = 5  # force over the mean above which the width stops growing [-]
EVEN = 1 + 1e-3  # largest weak force over the reference [-], above rounding and a tolerance of 1e-4
STRONG, WEAK, PULLED, MOBILIZED = "black", "#d62728", "#1f77b4", "#ffd92f"
TYPES = {"cap-cap": "#1f77b4", "cap-side": "#2ca02c", "side-side": "#d62728"}
GRAIN, RATTLER, OBSTACLE = "#d9d9d9", "#f5f5f5", "#9c9c9c"


def resolution(dpi):
    """Return the resolution of a picture [pixels per inch], or a ValueError."""
    return checks.number("dpi", dpi, "1 to 10000 pixels per inch", lambda v: 1 <= v <= 10_000)


def save(figure, stem):
    """Write a figure as `stem`.png and `stem`.pdf; return the paths."""
    paths = [stem.with_name(f"{stem.name}.{suffix}") for suffix in ("png", "pdf")]
    with matplotlib.rc_context(STYLE):
        for path in paths:
            figure.savefig(path)
    return paths


def page(limits, foot=0.0):
    """Return Axes in a new Figure of the limits (2, 2) [m], above a `foot` of this height [in]."""
    smallest = 1e-9 * np.abs(limits).max() + 1e-300
    across, up = np.maximum(limits[1] - limits[0], smallest)
    least = LEGEND if foot else 1
    body = min(max(PAGE * up / across, LOWEST), TALLEST)
    width, height = min(PAGE, max(body * across / up, least)), body + foot
    figure = Figure(figsize=(width, height))
    return canvas(limits, figure.add_axes((0, foot / height, 1, body / height)))


def canvas(limits, ax):
    """Set the limits of Axes with a margin and equal scales, and remove the ticks."""
    pad = 0.005 * (limits[1] - limits[0]).max()
    (left, bottom), (right, top) = limits[0] - pad, limits[1] + pad
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.axis("off")
    return ax


def points_a_metre(ax):
    """Return the scale of printed Axes [pt/m]; widths of lines are in points."""
    width, height = ax.figure.get_size_inches() * ax.get_position(original=True).size
    return 72 * min(width / np.ptp(ax.get_xlim()), height / np.ptp(ax.get_ylim()))


def line_unit(ax, radius):
    """Return the unit of line widths [m]: the mean radius of the grains, at most `LARGEST`."""
    return min(radius, LARGEST / points_a_metre(ax))


def add_grains(ax, grains, shapes, unit, edge="0.5", **style):
    """Add the outlines of grains, with lines of a twentieth of `unit`; return the collection.

    `shapes` are those of `rcr.geometry`. The lines of needles are thinner, at most 0.15 of the mean
    cap radius.
    """
    wide = min(0.05 * unit, 0.15 * grains["cap_radius"].mean()) if len(grains["id"]) else 0
    style |= dict(edgecolors=edge, linewidths=points_a_metre(ax) * wide)
    corners = 30 if len(grains["id"]) < 1000 else 12  # per half circle
    outlines = PolyCollection(polygons(grains, shapes, corners), **style)
    return ax.add_collection(outlines, autolim=False)


def add_segments(ax, lines, widths, **style):
    """Add lines (n, k, 2) of these widths [m] with round ends; return the collection."""
    style |= dict(capstyle="round", joinstyle="round")
    style["linewidths"] = points_a_metre(ax) * np.asarray(widths)
    return ax.add_collection(LineCollection(lines, **style), autolim=False)


class ForceScale(typing.NamedTuple):
    """Widths of the segments of contacts."""

    force: float  # reference force [N/m]
    width: float  # of a segment with this force [m]
    widest: float  # of any segment [m]
    is_mean: bool = True  # whether the reference is the mean of the contacts drawn

    def widths(self, force):
        """Return the widths of segments [m] for forces [N/m]."""
        return np.minimum(self.width * np.asarray(force) / self.force, self.widest)


def force_scale(ax, frame, force, share=None, is_mean=True):
    """Return the `ForceScale` of a reference force [N/m].

    Its width is `share` of the mean thickness 2R′ of the grains. By default that is `FORCE_WIDTH`,
    at least `LEAST_WIDTH` points, and lines of few large grains stop growing as in `line_unit`. The
    widest segment has `WIDEST` times this share, so that it leaves needles visible.
    """
    thickness, points = 2 * frame.mean_cap_radius(), points_a_metre(ax)
    if share is not None:
        return ForceScale(force, share * thickness, WIDEST * share * thickness, is_mean)
    usual = FORCE_WIDTH * min(thickness, 2 * LARGEST / points)
    width = max(usual, LEAST_WIDTH / points)
    return ForceScale(force, width, max(WIDEST * usual, width), is_mean)


def add_forces(ax, lines, force, scale):
    """Add segments of the width of their force: strong ones black, above weak ones in red.

    Forces in tension, below 0, are blue.
    """
    widths, weak = scale.widths(abs(force)), force <= EVEN * scale.force
    pulls = force < 0
    for pick, tint, layer in ((weak & ~pulls, WEAK, 3), (~weak, STRONG, 4), (pulls, PULLED, 4)):
        add_segments(ax, lines[pick], widths[pick], colors=tint, zorder=layer)


def add_obstacles(ax, frame, unit):
    """Add the walls, boxes, facets and the periodic cell of a `Frame`."""
    wide = 0.12 * points_a_metre(ax) * unit
    boxes = [vertices for _, kind, vertices in frame.outlines if kind == "box"]
    facets = [vertices for _, kind, vertices in frame.outlines if kind == "facet"]
    add = lambda shape: ax.add_collection(shape, autolim=False)
    if boxes:
        style = dict(facecolors=OBSTACLE, edgecolors="0.25", linewidths=0.4 * wide)
        add(PolyCollection(boxes, **style))
    if facets:
        add(LineCollection(facets, linewidths=wide, colors="0.25", capstyle="round", zorder=2))
    for axis, at in zip(frame.walls["axis"], frame.walls["position"]):
        (ax.axvline if axis == 0 else ax.axhline)(at, color="0.25", lw=max(wide, 0.6), zorder=2)
    if frame.cell is not None:
        edge = (frame.cell @ np.array([[0, 1, 1, 0], [0, 0, 1, 1]])).T
        style = dict(facecolors="none", edgecolors="0.2", linewidths=0.8, linestyles="--")
        add(PolyCollection([edge], **style, zorder=5))
