"""Outlines of grains: extents, polygons and the area of their union. Needs NumPy.

`grains` is a dict of arrays, one row per grain: ``position`` (N, 2) [m], ``angle`` (N,) from x to
the long axis [rad], ``half_length`` and ``cap_radius`` (N,) [m]. A disc has the half length 0.
"""

import numpy as np

UNION_STRIPS = 20_000  # vertical strips of a union; the relative error of its area is about 1e-6
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)  # of a panel of strips


def areas(grains):
    """Return the area of each grain, (N,) [m²]."""
    r, a = grains["cap_radius"], grains["half_length"]
    return np.pi * r**2 + 4 * a * r


def half_extents(grains):
    """Return half the width of each grain along x and along y, (N, 2) [m]."""
    along = np.abs(np.column_stack([np.cos(grains["angle"]), np.sin(grains["angle"])]))
    return grains["half_length"][:, None] * along + grains["cap_radius"][:, None]


def bounds(grains):
    """Return the lower left and upper right corner of the box around all grains, (2, 2) [m]."""
    reach = half_extents(grains)
    low, high = grains["position"] - reach, grains["position"] + reach
    return np.stack([low.min(axis=0), high.max(axis=0)])


def polygons(grains, points=12):
    """Return the outlines as polygons with `points` vertices per cap, (N, 2 points, 2) [m]."""
    half = np.linspace(-np.pi / 2, np.pi / 2, points)
    turn = np.concatenate([half, half + np.pi])
    sign = np.repeat([1, -1], points)
    x = grains["cap_radius"][:, None] * np.cos(turn) + sign * grains["half_length"][:, None]
    y = grains["cap_radius"][:, None] * np.sin(turn)
    z = (x + 1j * y) * np.exp(1j * grains["angle"])[:, None]
    return np.stack([z.real, z.imag], axis=-1) + grains["position"][:, None]


def union(grains, strips=UNION_STRIPS):
    """Return area [m²], centroid (2,) [m] and polar moment about it [m⁴] of the union of grains.

    The integral is exact along y. Along x it is Gauss's over panels between the ends of grains.
    """
    at, width = _strips(grains, strips)
    low, high = _sections(grains, at)
    order = np.argsort(low, axis=0)
    low, high = np.take_along_axis(low, order, axis=0), np.take_along_axis(high, order, axis=0)
    # each line: cut every interval to the part above the previous intervals
    below = np.vstack([np.full((1, len(at)), -np.inf), high[:-1]])
    counted = np.maximum.accumulate(below, axis=0)
    low, high = np.maximum(low, counted), np.maximum(high, counted)
    there = np.isfinite(low) & (high > low)
    low, high = np.where(there, low, 0), np.where(there, high, 0)
    # ∫ 1, y, y² dy along each line
    length, first, second = ((high**k - low**k).sum(axis=0) / k for k in (1, 2, 3))
    area = width @ length
    center = np.array([width @ (at * length), width @ first]) / area
    polar = width @ (at**2 * length + second) - area * (center @ center)
    return area, center, polar


def _strips(grains, count):
    """Return x and width of about `count` vertical strips over all grains, (L,) each [m].

    No strip contains an end of a grain, so that thin grains have strips of their own. With x =
    sin t between two ends, the sections of caps are smooth in t.
    """
    x, reach = grains["position"][:, 0], half_extents(grains)[:, 0]
    ends = np.unique([x - reach, x + reach])
    panels = max(1, count // (len(_NODES) * (len(ends) - 1)))
    t = np.pi / panels * (np.arange(panels)[:, None] + (1 + _NODES) / 2).ravel() - np.pi / 2
    weight = np.pi / (2 * panels) * np.tile(_WEIGHTS, panels) * np.cos(t)
    middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    return (middle[:, None] + half[:, None] * np.sin(t)).ravel(), np.outer(half, weight).ravel()


def _sections(grains, x):
    """Return lower and upper y of each grain on the vertical lines at x (L,), (N, L) each.

    A line that misses the grain has ∞ and −∞. The outline is convex, so the extremes over caps and
    sides bound the section.
    """
    a, r = grains["half_length"][:, None], grains["cap_radius"][:, None]
    c, s = np.cos(grains["angle"])[:, None], np.sin(grains["angle"])[:, None]
    along = x - grains["position"][:, :1]
    ends = []
    with np.errstate(divide="ignore", invalid="ignore"):
        for sign in (-1, 1):
            half = np.sqrt(r**2 - (along - sign * a * c) ** 2)  # of a cap; NaN beside it
            ends += [sign * a * s - half, sign * a * s + half]
            core = (along + sign * r * s) / c  # position along the core where the line cuts a side
            ends.append(np.where(np.abs(core) <= a, core * s + sign * r * c, np.nan))
    y = grains["position"][:, 1:]
    low, high = np.fmin.reduce(ends) + y, np.fmax.reduce(ends) + y
    return np.nan_to_num(low, nan=np.inf), np.nan_to_num(high, nan=-np.inf)
