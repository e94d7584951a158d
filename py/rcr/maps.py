"""Pictures of one snapshot: grains, forces, friction mobilisation, orientations, contact types. Needs NumPy and Matplotlib.

Everything is drawn by a few collections, so that 13 000 grains take seconds and stay sharp in a PDF. Each ``plot_…(network,
ax=None)`` returns the Axes; `draw` makes the whole figure of an observable.
"""

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rcr.figures import PAGE, STYLE
from rcr.network import SIDE_SIDE

WIDTH = 0.16  # of a segment that carries ⟨f_n⟩, in mean radii
WIDEST = 0.8  # of any segment, likewise
STRONG, WEAK, MOBILIZED = "black", "#d62728", "#ffd92f"
TYPES = dict(zip(("cap-cap", "cap-side", "side-side"), ("#1f77b4", "#2ca02c", "#d62728")))
GRAIN, RATTLER = "#d9d9d9", "#f5f5f5"


def outlines(particles, points=12):
    """Outlines of the grains as polygons; (N, 2 points, 2) [m]."""
    half = np.linspace(-np.pi / 2, np.pi / 2, points)
    turn = np.concatenate([half, half + np.pi])
    sign = np.repeat([1, -1], points)
    x = particles["cap_radius"][:, None] * np.cos(turn) + sign * particles["half_length"][:, None]
    y = particles["cap_radius"][:, None] * np.sin(turn)
    z = (x + 1j * y) * np.exp(1j * particles["angle"])[:, None]
    return np.stack([z.real, z.imag], axis=-1) + particles["position"][:, None]


def _canvas(network, ax):
    """Axes with the extent of the packing, of equal scales and without ticks."""
    vertices = outlines(network.particles)
    low, high = vertices.min(axis=(0, 1)), vertices.max(axis=(0, 1))
    width, height = high - low
    if ax is None:
        ax = Figure(figsize=(PAGE, PAGE * height / width)).add_axes((0, 0, 1, 1))
    pad = 0.005 * max(width, height)
    ax.set(xlim=(low[0] - pad, high[0] + pad), ylim=(low[1] - pad, high[1] + pad), aspect="equal")
    ax.axis("off")
    return ax


def _grains(network, ax, colors, edge="0.5"):
    """The grains, their lines a twentieth of the mean radius."""
    wide = 0.05 * _points_a_metre(network, ax) * network.particles["R"].mean()
    ax.add_collection(PolyCollection(outlines(network.particles), facecolors=colors, edgecolors=edge, linewidths=wide))


def _points_a_metre(network, ax):
    """Of the printed Axes: lines have their widths in points."""
    low, high = ax.get_xlim()
    return 72 * ax.figure.get_figwidth() * ax.get_position().width / (high - low)


def _bearing(network):
    """Mask of the particles that a contact holds, (N,) bool."""
    bodies = np.concatenate([network.contacts["body1"], network.contacts["body2"]])
    return np.isin(network.particles["id"], bodies)


def _segments(network):
    """From the centre of 1 to the contact to the centre of 2, (C, 3, 2) [m], of the contacts between particles."""
    pick = network.between_particles
    order = np.argsort(network.particles["id"])
    index = order[np.searchsorted(network.particles["id"], [network.contacts[body][pick] for body in ("body1", "body2")], sorter=order)]
    one, two = network.particles["position"][index]
    return np.stack([one, network.contacts["position"][pick], two], axis=1)


def _scaled_force(network):
    """f_n/⟨f_n⟩ of the contacts between particles, (C,) [-]."""
    force = np.einsum("ca,ca->c", network.contacts["force"], network.contacts["normal"])[network.between_particles]
    return force / force.mean()


def _forces(network, ax, scale=1.0):
    """Segments as thick as their force, strong ones on top of weak ones."""
    force, segments = _scaled_force(network), _segments(network)
    widths = scale * _points_a_metre(network, ax) * network.particles["R"].mean() * np.minimum(WIDTH * force, WIDEST)
    for pick, tint, layer in ((force < 1, WEAK, 3), (force >= 1, STRONG, 4)):
        ax.add_collection(LineCollection(segments[pick], linewidths=widths[pick], colors=tint, capstyle="round", zorder=layer))


def _grey(network):
    return np.where(_bearing(network), GRAIN, RATTLER)


def plot_packing(network, ax=None):
    """The grains, coloured by the orientation of their long axes, discs grey [O2]."""
    ax = _canvas(network, ax)
    long = network.particles["half_length"] > 0
    _grains(network, ax, np.where(long[:, None], _orientation_colors(network), matplotlib.colors.to_rgba(GRAIN)), "0.2")
    return ax


def plot_mobilization(network, ax=None):
    """Normal forces as thickness of centre-to-contact segments, I_m as diameter of discs [O6]."""
    ax = _canvas(network, ax)
    _grains(network, ax, _grey(network))
    _forces(network, ax)
    size = 0.5 * network.particles["R"].mean() * np.minimum(network.friction_mobilization(), 1)
    centres = network.contacts["position"][network.between_particles]
    wide = 0.02 * _points_a_metre(network, ax) * network.particles["R"].mean()
    discs = EllipseCollection(size, size, np.zeros_like(size), units="xy", offsets=centres, offset_transform=ax.transData)
    discs.set(facecolor=MOBILIZED, edgecolor="0.3", linewidth=wide, zorder=5)
    ax.add_collection(discs)
    return ax


def _orientation_colors(network):
    return matplotlib.colormaps["hsv"]((network.particles["angle"] % np.pi) / np.pi)


def plot_nematic(network, ax=None):
    """Particles with a side-side contact coloured by the orientation of their long axes, the others grey, with forces [O9]."""
    ax = _canvas(network, ax)
    side = network.contacts["type"] == SIDE_SIDE
    chained = np.isin(network.particles["id"], [network.contacts[body][side] for body in ("body1", "body2")])
    colors = np.array([matplotlib.colors.to_rgba(c) for c in (RATTLER, GRAIN)])[_bearing(network).astype(int)]
    _grains(network, ax, np.where(chained[:, None], _orientation_colors(network), colors))
    _forces(network, ax, 0.7)
    return ax


def plot_types(network, ax=None):
    """Centre-to-contact segments coloured by contact type [O11]."""
    ax = _canvas(network, ax)
    _grains(network, ax, _grey(network))
    types, segments = network.contacts["type"][network.between_particles], _segments(network)
    wide = 0.25 * _points_a_metre(network, ax) * network.particles["R"].mean()
    for code, tint in enumerate(TYPES.values()):
        ax.add_collection(LineCollection(segments[types == code], linewidths=wide, colors=tint, capstyle="round", zorder=3 + code))
    return ax


def _force_keys():
    keys = [Line2D([], [], color=STRONG, lw=2), Line2D([], [], color=WEAK, lw=1)]
    return keys, [r"$f_n > \langle f_n\rangle$", r"$f_n < \langle f_n\rangle$"]


def _mobilization_keys():
    keys, labels = _force_keys()
    disc = Line2D([], [], ls="", marker="o", ms=5, mfc=MOBILIZED, mec="0.3", mew=0.5)
    return [*keys, disc], [*labels, r"diameter $\propto I_m$"]


def _type_keys():
    return [Line2D([], [], color=tint, lw=2) for tint in TYPES.values()], list(TYPES)


MAPS = dict(  # observable: (plot, keys of its legend or None, has it a scale of orientations)
    O2=(plot_packing, None, True),
    O6=(plot_mobilization, _mobilization_keys, False),
    O9=(plot_nematic, _force_keys, True),
    O11=(plot_types, _type_keys, False),
)


def draw(observable, network):
    """The map of an observable (a key of `MAPS`), as wide as a page, with its legend below.

    Returns
    -------
    matplotlib.figure.Figure
    """
    plot, keys, oriented = MAPS[observable]
    eta = float(network.attributes["eta"])
    with matplotlib.rc_context(STYLE):
        vertices = outlines(network.particles)
        width, height = np.ptp(vertices.reshape(-1, 2), axis=0)
        foot, body = 0.45, PAGE * height / width
        figure = Figure(figsize=(PAGE, body + foot))
        ax = plot(network, figure.add_axes((0, foot / (body + foot), 1, body / (body + foot))))
        figure.text(0.01, 0.2 / (body + foot), rf"$\eta = {eta:g}$", va="center", fontsize=9)
        if oriented and eta > 0:
            bar = figure.add_axes((0.6, 0.26 / (body + foot), 0.36, 0.1 / (body + foot)))
            figure.colorbar(ScalarMappable(Normalize(0, 180), "hsv"), cax=bar, orientation="horizontal", ticks=[0, 45, 90, 135, 180])
            bar.tick_params(labelsize=7, pad=1, top=False)
            figure.text(0.59, 0.31 / (body + foot), "long axis from $x$ [°]", ha="right", va="center", fontsize=8)
        if keys:
            figure.legend(*keys(), loc="center left", bbox_to_anchor=(0.09, 0.2 / (body + foot)), ncols=3, fontsize=8)
        return figure
