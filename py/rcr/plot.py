"""Pictures of a scene or a saved network, without a window: `packing` and `snapshot`.

    rcr.snapshot("pile.png", color="speed", contacts="force")
    ax = rcr.plot.packing("network-0.2000.h5", contacts="type")

Needs NumPy and Matplotlib, not YADE. `rcr.movie` makes films.
"""

import os

import matplotlib
import numpy as np
from matplotlib.colors import to_rgba, to_rgba_array

from rcr._data import checks
from rcr._pictures import drawing, keys
from rcr._pictures.drawing import STYLE, TYPES
from rcr._pictures.keys import MOBILIZATION, OBSTACLE_CONTACT
from rcr._data.files import atomic_path
from rcr._pictures.grain_colors import CATEGORIES, SCALES, grain_colors  # noqa: F401
from rcr.frame import Frame

CONTACTS = dict(force="black above the mean force, red up to it, blue in tension",
                type="blue cap-cap, green cap-side, red side-side, grey with an obstacle; a corner "
                "of a polygon is a cap",
                mobilization="dark without friction to yellow where it slides: |f_t|/(µ f_n)")


def packing(
    what=None, ax=None, color="orientation", contacts=None, range=None, cmap=None, limits=None,
    legend=None, force_width=None, reference_force=None,
):  # fmt: skip
    """Draw grains and obstacles, and optionally contacts; return the Axes.

    Grains with prescribed motion are grey. In a periodic cell, grains are drawn inside the cell;
    pale images show where they cross its edge. A ValueError reports a scene with nothing to draw,
    or an unknown name.

    Parameters
    ----------
    what : None, Frame, Network or path
        None is the present scene of YADE; see `Frame.of`.
    ax : Axes, optional
        By default Axes of a new Figure, ``ax.figure``.
    color : str or (N,) array
        ``orientation``, ``speed``, ``spin``, ``load``, ``pressure``, ``contacts``, ``chain``,
        ``type`` (Rcr, polygon, …), ``shape`` (colours of YADE's view), a colour of Matplotlib, or a
        number for each grain of ``Frame.of(what)``.
    contacts : str, optional
        By default contacts are not drawn. Segments join centre, contact and centre; their width
        shows the normal force. Their colour shows the ``force`` (black above the mean, red up to
        it), the ``type`` (cap-cap, cap-side, side-side) or the ``mobilization`` |f_t|/(µ f_n), for
        which a ValueError reports contacts of unknown µ.
    range : (float, float), optional
        Numbers at the ends of the colour scale; by default the smallest and the largest.
    cmap : str or Colormap, optional
        Colour map of the grains. A ValueError reports a `range` or `cmap` without a colour scale.
    limits : ((float, float), (float, float)), optional
        Lower left and upper right corner [m]; by default `Frame.extent`.
    legend : bool, optional
        Add scales of length and force, and keys of colours; by default True for a new Figure.
    force_width : float, optional
        Width of a segment with the mean force, over the mean thickness 2R′ of the grains [-]; the
        widest segment has five times it. By default 0.08, within 0.2 and 3.8 pt.
    reference_force : float, optional
        Replaces the mean force in widths and colours [N/m]: one scale for several pictures.
    """
    frame = Frame.of(what)
    if not (len(frame.grains["id"]) or len(frame.walls["id"]) or frame.outlines):
        raise ValueError("the scene holds no Rcr, Sphere, RoundedPolygon, Wall, Box or Facet: "
                         "nothing to draw")
    _check_contacts(frame, contacts)
    share = _positive("force_width", force_width, "a width over the thickness 2R′ > 0")
    mean = _positive("reference_force", reference_force, "a normal force > 0 [N/m]")
    limits = frame.extent() if limits is None else checks.rectangle("limits", limits)
    legend = ax is None if legend is None else legend
    faces, key = grain_colors(frame, color, range, cmap)
    with matplotlib.rc_context(STYLE):
        foot = legend * keys.height(key, contacts)
        ax = drawing.page(limits, foot) if ax is None else drawing.canvas(limits, ax)
        radius = frame.mean_radius() if len(frame.grains["id"]) else 0.01 * np.ptp(limits)
        unit = drawing.line_unit(ax, radius)
        drawing.add_obstacles(ax, frame, unit)
        _add_grains(ax, frame, faces, unit)
        scale = None if contacts is None else _add_contacts(ax, frame, contacts, share, mean)
        if legend:
            keys.add(ax, frame, key, contacts, scale)
    return ax


def _positive(name, value, expected):
    """Return an optional number > 0."""
    return value if value is None else checks.number(name, value, expected, lambda v: v > 0)


def snapshot(path, what=None, dpi=200, **options):
    """Save a picture of the present scene, without a window; return its path.

    A PyRunner with this command makes the pictures of an `rcr.movie`, in a folder empty at first:
    ``rcr.snapshot(f'out/{O.iter:08d}.png', limits=((0, 0), (1, 1)))``.

    Parameters
    ----------
    path : path
        ``.png``, ``.pdf``, ``.svg`` or another format of Matplotlib, else a ValueError. The write
        is atomic.
    what, **options
        Arguments of `packing`.
    dpi : float
        Pixels per inch, 1 to 10000; a picture is up to 7 inches wide.
    """
    dpi = drawing.resolution(dpi)
    suffix = os.path.splitext(path)[1].lstrip(".").lower()
    figure = packing(what, **options).figure
    if suffix not in figure.canvas.get_supported_filetypes():
        raise ValueError(f"{path}: not a picture format; expected .png, .pdf or .svg")
    with matplotlib.rc_context(STYLE), atomic_path(path) as partial:
        figure.savefig(partial, dpi=dpi)
    return path


def _add_grains(ax, frame, faces, unit):
    """Add the grains, and pale images across the edges of a periodic cell."""
    grains, fixed = frame.grains, frame.grains["fixed"]
    faces = np.where(fixed[:, None], to_rgba(drawing.OBSTACLE), faces)
    at = grains["position"] + frame.wrap(grains["position"])
    placed, shapes = grains | dict(position=at), frame.shapes
    drawing.add_grains(ax, placed, shapes, unit, "0.25", facecolors=faces)
    index, shift = _images(frame, at)
    if len(index):
        images = {name: column[index] for name, column in grains.items()}
        images["position"] = at[index] + shift
        style = dict(facecolors=faces[index], alpha=0.3, zorder=0.9)
        drawing.add_grains(ax, images, shapes, unit, "0.6", **style)


def _images(frame, at):
    """Return the rows and shifts of the images that reach into the periodic cell."""
    if frame.cell is None:
        return np.empty(0, int), np.empty((0, 2))
    # heights of the cell across its edges
    heights = abs(np.linalg.det(frame.cell)) / np.linalg.norm(frame.cell, axis=0)[::-1]
    place, reach = at @ np.linalg.inv(frame.cell).T, frame.grains["R"][:, None] / heights
    rows, shifts = [], []
    for step in np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]):
        inside = (place + step > -reach) & (place + step < 1 + reach)
        rows.append(inside.all(axis=1).nonzero()[0])
        shifts.append(np.tile(frame.cell @ step, (len(rows[-1]), 1)))
    return np.concatenate(rows), np.concatenate(shifts)


def _check_contacts(frame, by):
    """Raise a ValueError for an unknown name, or for a mobilization that needs an unknown µ."""
    if by is not None and by not in CONTACTS:
        raise checks.error("contacts", by, f"None, {', '.join(map(repr, CONTACTS))}")
    unknown = np.isnan(frame.contacts["friction"][frame.normal_force() > 0])
    if by == "mobilization" and unknown.any():
        given = f"µ is NaN for {unknown.sum()} of {len(unknown)} contacts with a force"
        todo = "give a network the column friction or the attribute friction, or choose 'force'"
        raise ValueError(f"{given}; the mobilization needs all of them: {todo}")


def _add_contacts(ax, frame, by, share, reference):
    """Add the force-bearing contacts, coloured by one of `CONTACTS`.

    Return the `drawing.ForceScale`, None without any contact and reference.
    """
    force = frame.normal_force()
    bearing = force != 0
    if reference is None and not bearing.any():
        return None
    lines = frame.segments()[bearing]
    mean = float(abs(force[bearing]).mean()) if reference is None else reference
    scale = drawing.force_scale(ax, frame, mean, share, reference is None)
    force = force[bearing]
    if by == "force":
        drawing.add_forces(ax, lines, force, scale)
        return scale
    if by == "mobilization":
        tints = matplotlib.colormaps[MOBILIZATION](np.minimum(frame.mobilization()[bearing], 1))
    else:
        tints = [*TYPES.values(), OBSTACLE_CONTACT]
        tints = to_rgba_array(tints)[frame.contacts["type"][bearing]]
    drawing.add_segments(ax, lines, scale.widths(abs(force)), colors=tints, zorder=3)
    return scale
