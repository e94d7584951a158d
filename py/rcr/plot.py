"""Pictures of a scene or of a saved network, without a window: `packing`, `snapshot` and `movie`. Needs NumPy and Matplotlib, not YADE.

    rcr.snapshot("pile.png", color="speed", contacts="force")
    ax = rcr.plot.packing("network-0.2000.h5", contacts="type")
"""

import os
import pathlib
import re
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import ScalarFormatter

from rcr import _drawing as drawing
from rcr._drawing import GRAIN, STYLE, TYPES
from rcr._files import atomic_path
from rcr.frame import KINDS, Frame

FOOT = 0.45  # below a picture, for its legend [in]
KIND_COLORS = ("#8fb3d9", "#f0c87a", "#9ccf9c", "#a6a6a6")  # of KINDS


@dataclass(frozen=True)
class Scale:
    """How a number of each grain becomes a colour."""

    label: str
    values: object  # of a Frame, (N,)
    cmap: str = "viridis"
    range: tuple = None  # None: from the smallest to the largest
    ticks: tuple = None


def _orientation(frame):
    """Angle of the long axis, masked for discs."""
    return np.ma.masked_where(frame.grains["half_length"] == 0, np.degrees(frame.grains["angle"]) % 180)


def _pressure(frame):
    return 0.5 * np.einsum("naa->n", frame.stress_tensors())


SCALES = dict(
    orientation=Scale("long axis from $x$ [°]", _orientation, "hsv", (0, 180), (0, 45, 90, 135, 180)),
    speed=Scale("speed [m/s]", lambda frame: np.hypot(*frame.grains["velocity"][:, :2].T)),
    spin=Scale("angular velocity [1/s]", lambda frame: frame.grains["velocity"][:, 2], "coolwarm"),
    load=Scale("sum of normal forces [N/m]", lambda frame: frame.per_grain(frame.normal_force()), "magma_r"),
    pressure=Scale("mean stress of its contacts [Pa]", _pressure, "magma_r"),
    contacts=Scale("contacts with a force", lambda frame: frame.per_grain((frame.normal_force() > 0).astype(float)), "YlGnBu"),
)
CATEGORIES = dict(type="Rcr, disc, member of a clump, prescribed motion", shape="the colours of YADE's view, `particle(…, color=…)`")
CONTACTS = dict(
    force="black above the mean force, red up to it",
    type="blue cap-cap, green cap-side, red side-side, grey with an obstacle",
    mobilization="dark without friction to yellow where it slides: |f_t|/(µ f_n)",
)


def packing(what=None, ax=None, color="orientation", contacts=None, range=None, cmap=None, limits=None, legend=None):
    """Draw the grains, obstacles and, if wanted, the contacts.

    Grains whose motion is prescribed are grey. In a periodic cell grains are drawn inside it, and pale again wherever they cross its
    edge.

    Parameters
    ----------
    what : None, Frame, Network or path
        The present scene of YADE, or what `Frame.of` takes.
    ax : Axes, optional
        Where to draw; by default Axes in a Figure of their own, ``ax.figure``.
    color : str or (N,) array
        ``orientation``, ``speed``, ``spin``, ``load``, ``pressure``, ``contacts``, ``type`` (Rcr, disc, clumped), ``shape`` (the
        colours of YADE's view), any colour of Matplotlib, or a number for each grain of ``Frame.of(what)``.
    contacts : str, optional
        None draws no contact. ``force``: segments from centre to contact to centre, as thick as the normal force, black above the
        mean and red up to it; ``type``: as thick, coloured by cap-cap, cap-side and side-side; ``mobilization``: as thick, coloured by
        |f_t|/(µ f_n).
    range : (float, float), optional
        Numbers at the ends of the colours; by default the smallest and largest.
    cmap : str or Colormap, optional
    limits : ((float, float), (float, float)), optional
        Lower left and upper right corner [m]; by default everything that `Frame.extent` finds.
    legend : bool, optional
        Scale of colours and key below the picture; by default where the Figure is ours.

    Returns
    -------
    Axes

    Raises
    ------
    ValueError
        If the scene holds nothing that can be drawn, or a name is not known.
    """
    frame = Frame.of(what)
    if not (len(frame.grains["id"]) or len(frame.walls["id"]) or frame.outlines):
        raise ValueError("the scene holds no Rcr, Sphere, Wall, Box or Facet: there is nothing to draw")
    if contacts is not None and contacts not in CONTACTS:
        raise ValueError(f"contacts = {contacts!r}; wanted None, {' or '.join(map(repr, CONTACTS))}")
    if limits is not None and not (np.shape(limits) == (2, 2) and np.isfinite(limits).all() and (np.diff(limits, axis=0) > 0).all()):
        raise ValueError(f"limits = {limits!r}; wanted ((left, bottom), (right, top)) [m], finite and in this order")
    legend = ax is None if legend is None else legend
    style = _Style.of(frame, color, range, cmap)
    with matplotlib.rc_context(STYLE):
        limits = np.asarray(frame.extent() if limits is None else limits, float)
        keys = legend and (style.has_key or contacts in ("type", "mobilization"))
        ax = drawing.page(limits, FOOT if keys else 0) if ax is None else drawing.canvas(limits, ax)
        unit = drawing.line_unit(ax, frame.mean_radius() if len(frame.grains["id"]) else 0.01 * np.ptp(limits))
        drawing.add_obstacles(ax, frame, unit)
        _add_grains(ax, frame, style, unit)
        if contacts is not None:
            _add_contacts(ax, frame, contacts, unit)
        if keys:
            _add_keys(ax, frame, style, contacts)
    return ax


@dataclass
class _Style:
    """Colours of the grains: faces, or numbers to be mapped."""

    faces: np.ndarray = None
    mappable: ScalarMappable = None
    scale: Scale = None
    kinds: bool = False

    @property
    def has_key(self):
        return self.kinds or self.mappable is not None

    @classmethod
    def of(cls, frame, color, range, cmap):
        count = len(frame.grains["id"])
        if isinstance(color, str) and color in CATEGORIES:
            tints = matplotlib.colors.to_rgba_array(KIND_COLORS)[frame.kinds()] if color == "type" else frame.grains["color"]
            return cls(faces=matplotlib.colors.to_rgba_array(tints), kinds=color == "type")
        if isinstance(color, str) and color in SCALES:
            scale = SCALES[color]
        elif not isinstance(color, (str, tuple)) and np.shape(color) == (count,):
            scale = Scale("", lambda frame: np.asarray(color, float))
        elif matplotlib.colors.is_color_like(color):
            return cls(faces=np.tile(matplotlib.colors.to_rgba(color), (count, 1)))
        else:
            given = repr(color) if isinstance(color, str) else f"an array of the shape {np.shape(color)}"
            raise ValueError(f"color = {given}; wanted {', '.join([*SCALES, *CATEGORIES])}, a colour of Matplotlib, or a number for each of the {count} grains")
        values = np.ma.masked_invalid(scale.values(frame))
        shown = values[~frame.grains["fixed"]].compressed()
        low, high = range or scale.range or ((shown.min(), shown.max()) if len(shown) else (0, 1))
        map_ = matplotlib.colormaps[cmap or scale.cmap] if isinstance(cmap or scale.cmap, str) else cmap
        mappable = ScalarMappable(Normalize(low, high), map_.with_extremes(bad=GRAIN)) if len(shown) else None
        return cls(faces=mappable.to_rgba(values) if mappable else np.tile(matplotlib.colors.to_rgba(GRAIN), (count, 1)), mappable=mappable, scale=scale)


def _add_grains(ax, frame, style, unit):
    """Three collections: free grains, fixed ones, and pale images across the edges of a periodic cell."""
    grains, fixed = frame.grains, frame.grains["fixed"]
    faces = np.where(fixed[:, None], matplotlib.colors.to_rgba(drawing.OBSTACLE), style.faces)
    at = grains["position"] + frame.wrap(grains["position"])
    drawing.add_grains(ax, grains | dict(position=at), unit, "0.25", facecolors=faces)
    index, shift = _images(frame, at)
    if len(index):
        again = {name: column[index] for name, column in grains.items()} | dict(position=at[index] + shift)
        drawing.add_grains(ax, again, unit, "0.6", facecolors=faces[index], alpha=0.3, zorder=0.9)


def _images(frame, at):
    """Grains that reach over an edge of the periodic cell: their rows and the shifts of their images."""
    if frame.cell is None:
        return np.empty(0, int), np.empty((0, 2))
    heights = abs(np.linalg.det(frame.cell)) / np.linalg.norm(frame.cell, axis=0)[::-1]  # of the cell, across its edges
    place, reach = at @ np.linalg.inv(frame.cell).T, frame.radius[:, None] / heights
    rows, shifts = [], []
    for step in np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]):
        seen = ((place + step > -reach) & (place + step < 1 + reach)).all(axis=1).nonzero()[0]
        rows.append(seen)
        shifts.append(np.tile(frame.cell @ step, (len(seen), 1)))
    return np.concatenate(rows), np.concatenate(shifts)


def _add_contacts(ax, frame, by, unit):
    force = frame.normal_force()
    bearing = force > 0
    if not bearing.any():
        return
    lines = (frame.segments() + frame.wrap(frame.contacts["position"])[:, None])[bearing]
    force = force[bearing] / force[bearing].mean()
    if by == "force":
        drawing.add_forces(ax, lines, force, unit)
        return
    widths = drawing.force_widths(force, unit)
    if by == "mobilization":
        tints = matplotlib.colormaps[_MOBILIZATION](np.minimum(frame.mobilization()[bearing], 1))
    else:
        tints = matplotlib.colors.to_rgba_array([*TYPES.values(), _WALL])[frame.contacts["type"][bearing]]
    drawing.add_segments(ax, lines, widths, colors=tints, zorder=3)


_MOBILIZATION, _WALL = "plasma", "0.3"


def _add_keys(ax, frame, style, contacts):
    """Scale of the grains' colours on the right of the foot, key or scale of the contacts on the left; a scale has its label above."""
    figure = ax.figure
    height = figure.get_figheight()

    def bar(left, mappable, label, ticks=None):
        scale = figure.add_axes((left, 0.17 / height, 0.38, 0.09 / height))
        numbers = ScalarFormatter(useOffset=False, useMathText=True)
        shown = figure.colorbar(mappable, cax=scale, orientation="horizontal", ticks=ticks, format=numbers)
        numbers.set_locs(shown.get_ticks())
        power = numbers.get_offset()  # stands in the label: below the scale it would be off the picture
        scale.xaxis.get_offset_text().set_visible(False)
        scale.tick_params(labelsize=7, pad=1, top=False)
        figure.text(left + 0.19, 0.29 / height, f"{label}  {power}" if power else label, ha="center", va="bottom", fontsize=8)

    def key(handles, left):
        figure.legend(handles=handles, loc="center left", bbox_to_anchor=(left, 0.21 / height), ncols=2, fontsize=8)

    if style.mappable is not None:
        bar(0.57, style.mappable, style.scale.label, style.scale.ticks)
    elif style.kinds:
        key([Patch(fc=KIND_COLORS[k], ec="0.3", lw=0.5, label=KINDS[k]) for k in np.unique(frame.kinds())], 0.55)
    if contacts == "type":
        key([Line2D([], [], color=tint, lw=2, label=name) for name, tint in (*TYPES.items(), ("obstacle", _WALL))], 0.0)
    elif contacts == "mobilization":
        bar(0.05, ScalarMappable(Normalize(0, 1), _MOBILIZATION), r"$|f_t|/\mu f_n$")


def snapshot(path, what=None, dpi=200, **options):
    """Write a picture of the present scene, without a window.

    As a command of a PyRunner it makes the pictures of a `movie`:
    ``PyRunner(command="rcr.snapshot(f'out/{O.iter:08d}.png', limits=((0, 0), (1, 1)))", iterPeriod=100)``.

    Parameters
    ----------
    path : path
        ``.png``, ``.pdf``, ``.svg`` or another format of Matplotlib. The file appears whole or not at all.
    what, **options
        As `packing` takes them.
    dpi : float
        Pixels an inch; a picture is up to 7 inches wide.

    Returns
    -------
    path

    Raises
    ------
    ValueError
        If the format is not known, and what `packing` raises.
    """
    suffix = os.path.splitext(path)[1].lstrip(".").lower()
    figure = packing(what, **options).figure
    if suffix not in figure.canvas.get_supported_filetypes():
        raise ValueError(f"{path}: no picture format; wanted a name that ends in .png, .pdf or .svg")
    with matplotlib.rc_context(STYLE), atomic_path(path) as partial:
        figure.savefig(partial, dpi=dpi)
    return path


# --- movies -------------------------------------------------------------------------------------------------------------


def movie(folder, path=None, fps=10, dpi=100, **options):
    """Film of a run's snapshots.

    Parameters
    ----------
    folder : path
        Holds networks (``*.h5``), which are drawn, by time, all to one scale, or else pictures that `snapshot` wrote (``*.png``), by name.
    path : path, optional
        ``.gif`` (always), or ``.mp4`` and other formats of ffmpeg where that is installed; by default ``movie.gif`` in the folder.
    fps : float
        Pictures a second.
    dpi : float
        Pixels an inch of networks' pictures, 7 inches wide.
    **options
        As `packing` takes them, for networks.

    Returns
    -------
    pathlib.Path
        The film.

    Raises
    ------
    ValueError
        If the folder holds no snapshot, or no writer for the format is installed.
    """
    folder = pathlib.Path(folder)
    path = folder / "movie.gif" if path is None else pathlib.Path(path)
    writer = _writer(path, fps)
    networks = [file for file in folder.glob("*.h5")]
    pictures = sorted(folder.glob("*.png"), key=_natural)
    if networks:
        figure, shots = _film_networks(networks, options)
    elif pictures:
        figure, shots = _film_pictures(pictures, dpi)
    else:
        raise ValueError(f"{folder} holds no snapshots; wanted *.h5 (Network.save) or *.png (rcr.snapshot)")
    from tqdm import tqdm

    with atomic_path(path) as partial:
        writer.setup(figure, partial, dpi)
        for shot in tqdm(shots, desc=path.name, unit="picture", delay=5, disable=None):
            shot()
            writer.grab_frame()
        writer.finish()
    return path


def _natural(path):
    """Key by which 9.png stands before 10.png."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.name)]


def _writer(path, fps):
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if path.suffix == ".gif":
        return PillowWriter(fps=fps)
    if not FFMpegWriter.isAvailable():
        raise ValueError(f"{path}: films in this format need ffmpeg, which is not installed; give a name that ends in .gif")
    return FFMpegWriter(fps=fps)


def _film_networks(paths, options):
    """The figure and, for each network, a function that draws it; limits and range of colours are those of all."""
    frames = sorted((Frame.of(path) for path in paths), key=lambda frame: frame.time)
    corners = np.array([frame.extent() for frame in frames])
    limits = options.pop("limits", None)
    if limits is None:
        limits = np.stack([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])
    color = options.get("color", "orientation")
    scale = SCALES.get(color) if isinstance(color, str) else None
    if scale is not None and scale.range is None and "range" not in options:
        values = np.concatenate([scale.values(frame) for frame in frames])
        options["range"] = (values.min(), values.max())
    figure = packing(frames[0], limits=limits, **options).figure

    def shot(frame):
        ax = figure.axes[0]
        ax.clear()
        packing(frame, ax=ax, limits=limits, **options)

    return figure, [lambda frame=frame: shot(frame) for frame in frames]


def _film_pictures(paths, dpi):
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    height, width = imread(paths[0]).shape[:2]
    figure = Figure(figsize=(width / dpi, height / dpi))
    ax = figure.add_axes((0, 0, 1, 1))

    def shot(path):
        ax.clear()
        ax.axis("off")
        ax.imshow(imread(path), aspect="auto", interpolation="none")

    return figure, [lambda path=path: shot(path) for path in paths]
