"""Areas, extent, porosity and stresses of the grains of a scene or a network. Needs NumPy.

YADE's functions for these quantities support spheres alone; in a scene with Rcrs or polygons they
print a warning that names the function to use. All quantities are in the plane and per unit depth.

The argument `what` is None (the present scene of YADE), a Frame, a Network or the path of one, see
`Frame.of`. A ValueError reports a scene without grains.
"""

import numpy as np

from rcr import geometry
from rcr._data import checks
from rcr._data.files import atomic_path
from rcr.frame import Frame


def extent(what=None):
    """Return the lower left and upper right corner of the box around all grains, (2, 2) [m]."""
    frame = _frame(what)
    return geometry.bounds(frame.grains, frame.shapes)


def areas(what=None):
    """Return the ids (N,) and `Frame.areas` of the grains, (N,) [m²]."""
    frame = _frame(what)
    return frame.grains["id"], frame.areas()


def porosity(volume=None, what=None):
    """Return the fraction of voids, 1 − Σ areas/volume [-].

    `volume` is the area of the region [m²], by default that of the periodic cell or of the box
    around all grains. Overlaps count twice, except within a clump. A volume that is not > 0 or
    smaller than the grains raises a ValueError.
    """
    frame = _frame(what)
    filled = frame.areas().sum()
    if volume is not None:
        expected = "the area of the region > 0 [m²]"
        volume = checks.number("volume", volume, expected, lambda v: v > 0)
        if volume < filled:
            expected = f"the area of the region [m²], which holds grains of {filled:.6g} m²"
            raise checks.error("volume", volume, expected)
    elif frame.cell is not None:
        volume = abs(np.linalg.det(frame.cell))
    else:
        volume = np.prod(np.diff(extent(frame), axis=0))
    return float(1 - filled / volume)


def stress_tensors(what=None):
    """Return ids (N,) and `Table.grain_stresses`, (N, 2, 2), compression positive [Pa]."""
    frame = _frame(what)
    return frame.grains["id"], frame.grain_stresses()


def write_table(path, what=None):
    """Write a text table, names of columns and a row per grain; return the number of grains."""
    grains = _frame(what).grains
    x, y = grains["position"].T
    vx, vy, spin = grains["velocity"].T
    given = {name: grains[name] for name in ("angle", "half_length", "cap_radius", "mass")}
    columns = dict(id=grains["id"], x=x, y=y, **given, vx=vx, vy=vy, spin=spin,
                   clump=grains["clump"], fixed=grains["fixed"], shape=grains["shape"])  # fmt: skip
    formats = ["%d" if name in ("id", "clump", "fixed", "shape") else "%.17g" for name in columns]
    table = np.column_stack(list(columns.values()))
    with atomic_path(path) as partial:
        np.savetxt(partial, table, formats, header=" ".join(columns))
    return len(grains["id"])


def _frame(what):
    frame = Frame.of(what)
    if not len(frame.grains["id"]):
        raise ValueError("the scene holds no Rcr, Sphere or RoundedPolygon: nothing to measure")
    return frame
