"""Measures of a scene with Rcrs. Needs NumPy; a scene needs YADE, a saved network does not.

YADE's own functions know spheres only. In a scene with Rcrs they warn, and name their counterparts here and in `Network`; all are in the
plane and per unit depth.
"""

import numpy as np

from rcr._files import atomic_path
from rcr.frame import Frame
from rcr._outlines import half_extents


def extent(what=None):
    """Lower left and upper right corner of the box around all grains.

    Parameters
    ----------
    what : None, Frame, Network or path
        The present scene of YADE, or what `Frame.of` takes.

    Returns
    -------
    (2, 2) float array
        [m]

    Raises
    ------
    ValueError
        If there is no grain.
    """
    grains = _grains(what).grains
    reach = np.column_stack([half_extents(grains, axis) for axis in (0, 1)])
    return np.stack([(grains["position"] - reach).min(axis=0), (grains["position"] + reach).max(axis=0)])


def areas(what=None):
    """Area that each grain adds to the solid: members of a clump share the area of their union by their own.

    Returns
    -------
    ids : (N,) int array
    areas : (N,) float array
        [m²]
    """
    frame = _grains(what)
    return frame.grains["id"], frame.areas()


def porosity(volume=None, what=None):
    """Share of voids, 1 − Σ areas/volume; overlaps of grains that are not clumped count twice.

    Parameters
    ----------
    volume : float, optional
        Area of the region [m²]; by default that of the periodic cell, or else of the box around all grains.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If the volume is not > 0, smaller than the grains, or there is no grain.
    """
    frame = _grains(what)
    filled = areas(frame)[1].sum()
    if volume is not None and 0 < volume < filled:
        raise ValueError(f"volume = {volume!r}; wanted the area of the region [m²], which holds grains of {filled:.6g} m²")
    if volume is None:
        volume = abs(np.linalg.det(frame.cell)) if frame.cell is not None else np.prod(np.diff(extent(frame), axis=0))
    if not volume > 0:
        raise ValueError(f"volume = {volume!r}; wanted the area of the region > 0 [m²]")
    return float(1 - filled / volume)


def stress_tensors(what=None):
    """Mean stress in each grain by the moments of its contact forces (Love, Weber); see `Frame.stress_tensors`.

    Returns
    -------
    ids : (N,) int array
    stresses : (N, 2, 2) float array
        Compression positive [Pa].
    """
    frame = _grains(what)
    return frame.grains["id"], frame.stress_tensors()


def text(path, what=None):
    """Write the grains as a table of numbers, one a line; its head names the columns. The file appears whole or not at all.

    Returns
    -------
    int
        Number of grains.
    """
    grains = _grains(what).grains
    columns = dict(id=grains["id"], x=grains["position"][:, 0], y=grains["position"][:, 1], angle=grains["angle"], half_length=grains["half_length"],
                   cap_radius=grains["cap_radius"], mass=grains["mass"], vx=grains["velocity"][:, 0], vy=grains["velocity"][:, 1],
                   spin=grains["velocity"][:, 2], clump=grains["clump"], fixed=grains["fixed"])  # fmt: skip
    integers = ("id", "clump", "fixed")
    with atomic_path(path) as partial:
        np.savetxt(partial, np.column_stack(list(columns.values())), ["%d" if name in integers else "%.17g" for name in columns], header=" ".join(columns))
    return len(grains["id"])


def _grains(what):
    frame = Frame.of(what)
    if not len(frame.grains["id"]):
        raise ValueError("the scene holds no Rcr and no Sphere: there is nothing to measure")
    return frame
