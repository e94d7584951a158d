"""Colours of grains in a picture: scales of numbers, categories, single colours."""

from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import (Colormap, ListedColormap, Normalize, is_color_like, to_rgba,
                               to_rgba_array)
from matplotlib.ticker import MaxNLocator

from rcr._data import checks
from rcr._pictures.drawing import GRAIN
from rcr.force_chains import force_chains

# pale hues of an angle, on which black and red forces stand out
HUES = ListedColormap(1 - 0.5 * (1 - matplotlib.colormaps["hsv"](np.linspace(0, 1, 256))), "hues")
KIND_COLORS = ("#8fb3d9", "#f0c87a", "#9ccf9c", "#a6a6a6", "#d9a0c4")  # of `rcr.frame.KINDS`


@dataclass(frozen=True)
class Scale:
    """Colour scale of a number of each grain."""

    label: str
    values: object  # function of a Frame, returns (N,)
    cmap: object = "viridis"  # a Colormap of Matplotlib, or its name
    range: tuple = None  # None: from the smallest to the largest number
    ticks: object = None  # tuple, or a Locator of Matplotlib


def _orientation(frame):
    """Return the angle of the long axis or of the corners [°], masked for discs."""
    disc = frame.grains["half_length"] == 0
    return np.ma.masked_where(disc, np.degrees(frame.grains["angle"]) % 180)


def _chain_length(frame):
    """Return the number of grains in the force chain of each grain, masked outside chains."""
    chains = force_chains(frame)
    length = np.append(chains.grains, 0)[chains.chain]
    return np.ma.masked_where(chains.chain < 0, length)


ANGLES = (0, 45, 90, 135, 180)
WHOLE = MaxNLocator(5, steps=[1, 2, 5, 10], integer=True)
SCALES = dict(
    orientation=Scale("angle from $x$ [°]", _orientation, HUES, (0, 180), ANGLES),
    speed=Scale("speed [m/s]", lambda f: np.hypot(*f.velocities()[:, :2].T)),
    spin=Scale("angular velocity [1/s]", lambda f: f.grains["velocity"][:, 2], "coolwarm"),
    load=Scale("sum of normal forces [N/m]", lambda f: f.per_grain(f.normal_force()), "magma_r"),
    pressure=Scale("pressure in the grain [Pa]",
                   lambda f: 0.5 * np.einsum("naa->n", f.grain_stresses()), "magma_r"),
    contacts=Scale("number of contacts with a force",
                   lambda f: f.per_grain(f.normal_force() > 0), "YlGnBu", ticks=WHOLE),
    chain=Scale("grains in the force chain", _chain_length, "autumn_r", ticks=WHOLE))
CATEGORIES = dict(type="Rcr, disc, polygon, member of a clump",
                  shape="the colours of YADE's view, `particle(…, color=…)`")


def grain_colors(frame, color, range, cmap):
    """Return faces (N, 4) of grains and their key: (mappable, scale), "kinds" or None."""
    count, name = len(frame.grains["id"]), color if isinstance(color, str) else None
    if name in SCALES:
        return _of_scale(frame, SCALES[name], range, cmap)
    if not isinstance(color, (str, tuple)) and np.shape(color) == (count,):
        scale = Scale("", lambda frame: np.asarray(color, float))
        return _of_scale(frame, scale, range, cmap)
    if name in CATEGORIES or is_color_like(color):
        _check_no_scale(color, dict(range=range, cmap=cmap))
    if name == "shape":
        return to_rgba_array(frame.grains["color"]), None
    if name == "type":
        return to_rgba_array(KIND_COLORS)[frame.kinds()], "kinds"
    if is_color_like(color):
        return np.tile(to_rgba(color), (count, 1)), None
    given = repr(name) if name else f"an array of the shape {np.shape(color)}"
    names = ", ".join([*SCALES, *CATEGORIES])
    numbers = f"a number for each of the {count} grains"
    raise ValueError(f"color = {given}; expected {names}, a colour of Matplotlib, or {numbers}")


def _check_no_scale(color, options):
    """Raise a ValueError if an option of colour scales is given with a colour without one."""
    given = " and ".join(f"{name} = {value!r}" for name, value in options.items()
                         if value is not None)
    if given:
        expected = f"{', '.join(SCALES)} or a number for each grain, or no such options"
        raise ValueError(f"{given}, but color = {color!r} has no scale; expected {expected}")


def _ends(range):
    """Return the numbers at the ends of a colour scale."""
    low, high = checks.array("range", range, (2,))
    if low > high:
        raise checks.error("range", range, "the ends of the colour scale, the smaller one first")
    return low, high


def _color_map(cmap):
    """Return a colour map by its name, or a Colormap itself."""
    if isinstance(cmap, str) and cmap in matplotlib.colormaps:
        return matplotlib.colormaps[cmap]
    if not isinstance(cmap, Colormap):
        raise checks.error("cmap", cmap, "a Colormap or the name of one, such as 'viridis'")
    return cmap


def _of_scale(frame, scale, range, cmap):
    given = scale.range if range is None else _ends(range)
    map_ = _color_map(scale.cmap if cmap is None else cmap)
    values = np.ma.masked_invalid(scale.values(frame))
    shown = values[~frame.grains["fixed"]].compressed()
    if not len(shown):
        return np.tile(to_rgba(GRAIN), (len(values), 1)), None
    low, high = (shown.min(), shown.max()) if given is None else given
    mappable = ScalarMappable(Normalize(low, high), map_.with_extremes(bad=GRAIN))
    return mappable.to_rgba(values), (mappable, scale)
