"""Outlines of grains: extents, polygons, and the area that overlapping ones cover together. Needs NumPy.

`grains` is a dict of arrays with one row a grain: ``position`` (N, 2) [m], ``angle`` (N,) of the long axis to x [rad], ``half_length`` and
``cap_radius`` (N,) [m]; a disc has the half length 0.
"""

import numpy as np

STRIPS = 20_000  # that a union is cut into: its area is right to 1e-6


def areas(grains):
    """Area within each outline, (N,) [m²]."""
    r, a = grains["cap_radius"], grains["half_length"]
    return np.pi * r**2 + 4 * a * r


def half_extents(grains, axis):
    """Half the width of grains along x (axis 0) or y (1), (N,) [m]."""
    along = np.abs(np.cos(grains["angle"]) if axis == 0 else np.sin(grains["angle"]))
    return grains["half_length"] * along + grains["cap_radius"]


def polygons(grains, points=12):
    """Outlines of grains as polygons, `points` on each cap; (N, 2 points, 2) [m]."""
    half = np.linspace(-np.pi / 2, np.pi / 2, points)
    turn = np.concatenate([half, half + np.pi])
    sign = np.repeat([1, -1], points)
    x = grains["cap_radius"][:, None] * np.cos(turn) + sign * grains["half_length"][:, None]
    y = grains["cap_radius"][:, None] * np.sin(turn)
    z = (x + 1j * y) * np.exp(1j * grains["angle"])[:, None]
    return np.stack([z.real, z.imag], axis=-1) + grains["position"][:, None]


def union(grains, strips=STRIPS):
    """Area [m²], centre (2,) [m] and polar moment about it [m⁴] of what grains cover together: exact along y, midpoint rule along x."""
    x, reach = grains["position"][:, 0], half_extents(grains, 0)
    left, right = (x - reach).min(), (x + reach).max()
    width = (right - left) / strips
    at = left + width * (np.arange(strips) + 0.5)
    low, high = _sections(grains, at)
    order = np.argsort(low, axis=0)
    low, high = np.take_along_axis(low, order, axis=0), np.take_along_axis(high, order, axis=0)
    counted = np.maximum.accumulate(np.vstack([np.full((1, strips), -np.inf), high[:-1]]), axis=0)  # below it all is
    low, high = np.maximum(low, counted), np.maximum(high, counted)
    there = np.isfinite(low) & (high > low)
    low, high = np.where(there, low, 0), np.where(there, high, 0)
    length, first, second = ((high**k - low**k).sum(axis=0) / k for k in (1, 2, 3))  # ∫ 1, y, y² dy along each line
    area = width * length.sum()
    center = width * np.array([(at * length).sum(), first.sum()]) / area
    return area, center, width * ((at**2 * length).sum() + second.sum()) - area * (center @ center)


def _sections(grains, x):
    """Lower and upper y at which grains meet the vertical lines at x (L,), (N, L) each; ∞ and −∞ where a line misses the grain.

    The outline is convex: its caps and sides hold both ends."""
    a, r = grains["half_length"][:, None], grains["cap_radius"][:, None]
    c, s = np.cos(grains["angle"])[:, None], np.sin(grains["angle"])[:, None]
    along = x - grains["position"][:, :1]
    ends = []
    with np.errstate(divide="ignore", invalid="ignore"):
        for sign in (-1, 1):
            half = np.sqrt(r**2 - (along - sign * a * c) ** 2)  # of a cap; NaN beside it
            ends += [sign * a * s - half, sign * a * s + half]
            share = (along + sign * r * s) / c  # along the core, where the side at the distance r from it crosses the line
            ends.append(np.where(np.abs(share) <= a, share * s + sign * r * c, np.nan))
    y = grains["position"][:, 1:]
    return np.nan_to_num(np.fmin.reduce(ends) + y, nan=np.inf), np.nan_to_num(np.fmax.reduce(ends) + y, nan=-np.inf)
