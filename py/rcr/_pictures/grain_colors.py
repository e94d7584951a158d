"""Colours of grains in a picture: scales of numbers, categories, single colours."""

from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, is_color_like, to_rgba, to_rgba_array

from rcr._pictures.drawing import GRAIN

KIND_COLORS = ("#8fb3d9", "#f0c87a", "#9ccf9c", "#a6a6a6")  # of `rcr.frame.KINDS`


@dataclass(frozen=True)
class Scale:
    """Colour scale of a number of each grain."""

    label: str
    values: object  # function of a Frame, returns (N,)
    cmap: str = "viridis"
    range: tuple = None  # None: from the smallest to the largest number
    ticks: tuple = None


def _orientation(frame):
    """Return the angle of the long axis [°], masked for discs."""
    disc = frame.grains["half_length"] == 0
    return np.ma.masked_where(disc, np.degrees(frame.grains["angle"]) % 180)


ANGLES = (0, 45, 90, 135, 180)
SCALES = dict(
    orientation=Scale("long axis from $x$ [°]", _orientation, "hsv", (0, 180), ANGLES),
    speed=Scale("speed [m/s]", lambda f: np.hypot(*f.velocities()[:, :2].T)),
    spin=Scale("angular velocity [1/s]", lambda f: f.grains["velocity"][:, 2], "coolwarm"),
    load=Scale("sum of normal forces [N/m]", lambda f: f.per_grain(f.normal_force()), "magma_r"),
    pressure=Scale("pressure in the grain [Pa]",
                   lambda f: 0.5 * np.einsum("naa->n", f.stress_tensors()), "magma_r"),
    contacts=Scale("contacts with a force", lambda f: f.per_grain(f.normal_force() > 0), "YlGnBu"))
CATEGORIES = dict(type="Rcr, disc, member of a clump, prescribed motion",
                  shape="the colours of YADE's view, `particle(…, color=…)`")


@dataclass
class GrainColors:
    """Faces (N, 4) of the grains, and what the key of the picture shows."""

    faces: np.ndarray
    mappable: ScalarMappable = None
    scale: Scale = None
    kinds: bool = False

    @property
    def has_key(self):
        """True if the picture needs a colour bar or a legend of the grains."""
        return self.kinds or self.mappable is not None

    @classmethod
    def of(cls, frame, color, range, cmap):
        """Return the colours of a Frame for the arguments of `rcr.plot.packing`."""
        if isinstance(color, str) and color in CATEGORIES:
            tints = frame.grains["color"]
            if color == "type":
                tints = to_rgba_array(KIND_COLORS)[frame.kinds()]
            return cls(to_rgba_array(tints), kinds=color == "type")
        count = len(frame.grains["id"])
        if isinstance(color, str) and color in SCALES:
            return cls._of_scale(frame, SCALES[color], range, cmap)
        if not isinstance(color, (str, tuple)) and np.shape(color) == (count,):
            scale = Scale("", lambda frame: np.asarray(color, float))
            return cls._of_scale(frame, scale, range, cmap)
        if is_color_like(color):
            return cls(np.tile(to_rgba(color), (count, 1)))
        given = repr(color) if isinstance(color, str) else f"an array of the shape {np.shape(color)}"
        names = ", ".join([*SCALES, *CATEGORIES])
        numbers = f"a number for each of the {count} grains"
        raise ValueError(f"color = {given}; expected {names}, a colour of Matplotlib, or {numbers}")

    @classmethod
    def _of_scale(cls, frame, scale, range, cmap):
        values = np.ma.masked_invalid(scale.values(frame))
        shown = values[~frame.grains["fixed"]].compressed()
        if not len(shown):
            return cls(np.tile(to_rgba(GRAIN), (len(values), 1)), scale=scale)
        given = scale.range if range is None else range
        low, high = (shown.min(), shown.max()) if given is None else given
        map_ = cmap or scale.cmap
        map_ = matplotlib.colormaps[map_] if isinstance(map_, str) else map_
        mappable = ScalarMappable(Normalize(low, high), map_.with_extremes(bad=GRAIN))
        return cls(mappable.to_rgba(values), mappable, scale)
