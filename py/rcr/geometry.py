"""Outlines and areas of grains: extents, polygons, sample points, unions. Needs NumPy.

`grains` is a dict of arrays, one row per grain: ``position`` (N, 2) [m], ``angle`` (N,) from x to
the long axis [rad], ``half_length`` and ``cap_radius`` (N,) [m]. A disc has the half length 0.
"""

import numpy as np

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)  # of the integral over x between two kinks
ON_OUTLINE = 1e-6  # distance from an outline that counts as rounding, over the length of the grain


def areas(grains):
    """Return the area of each grain, (N,) [m²]."""
    r, a = grains["cap_radius"], grains["half_length"]
    return np.pi * r**2 + 4 * a * r


def _axes(grains):
    """Return the long axis of each grain as x + i y, (N,).

    NumPy before 2 rounds np.cos, np.sin and powers differently on different processors.
    """
    return np.exp(1j * grains["angle"])


def half_extents(grains):
    """Return half the width of each grain along x and along y, (N, 2) [m]."""
    axis = _axes(grains)
    along = np.abs(np.column_stack([axis.real, axis.imag]))
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
    z = (x + 1j * y) * _axes(grains)[:, None]
    return np.stack([z.real, z.imag], axis=-1) + grains["position"][:, None]


def samples(grains, count):
    """Return points spread evenly over each grain, `count` along and across, and their weights.

    The points (N, K, 2) [m] are relative to the centre. The weights (N, K),
    fractions of the grain, add up to 1.
    """
    r, a = (grains[name][:, None] for name in ("cap_radius", "half_length"))
    even = (2 * np.arange(count) + 1) / count - 1
    u, v = (c.ravel() for c in np.meshgrid(even, even))
    x, y = u * (a + r), v * r
    inside = np.maximum(np.abs(x) - a, 0) ** 2 + y**2 <= r**2
    turned = (x + 1j * y) * _axes(grains)[:, None]
    points = np.stack([turned.real, turned.imag], axis=-1)
    return points, inside / inside.sum(axis=1, keepdims=True)


def union(grains):
    """Return area [m²], centroid (2,) [m] and polar moment about it [m⁴] of the union of grains.

    The integral over y is exact. That over x is Gauss's between kinks of the outline of the union.
    """
    origin = grains["position"].mean(axis=0)  # digits of large coordinates would cancel
    grains = dict(grains, position=grains["position"] - origin)
    at, width = _lines(grains)
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
    length, first = (high - low).sum(axis=0), (high * high - low * low).sum(axis=0) / 2
    second = (high * high * high - low * low * low).sum(axis=0) / 3
    area = width @ length
    center = np.array([width @ (at * length), width @ first]) / area
    polar = width @ (at**2 * length + second) - area * (center @ center)
    return area, origin + center, polar


def _lines(grains):
    """Return x and weight of vertical lines for an integral over x, (L,) each [m].

    Sections are smooth between two kinks. With x = sin t there, they are also smooth at caps.
    """
    x, reach = grains["position"][:, 0], half_extents(grains)[:, 0]
    kinks = np.unique(np.concatenate([x - reach, x + reach, _crossings(grains)]))
    middle, half = (kinks[1:] + kinks[:-1]) / 2, np.diff(kinks) / 2
    turn = np.exp(1j * np.pi / 2 * _NODES)
    weight = np.pi / 2 * _WEIGHTS * turn.real
    return (middle[:, None] + half[:, None] * turn.imag).ravel(), np.outer(half, weight).ravel()


def _crossings(grains):
    """Return abscissas at which outlines of grains cross on the outline of the union.

    The ends of sides on the outline of the union are included.
    """
    center, axis = grains["position"] @ [1, 1j], _axes(grains)
    a, r = grains["half_length"], grains["cap_radius"]
    caps, radii = np.concatenate([center - a * axis, center + a * axis]), np.tile(r, 2)
    side = r * 1j * axis
    sides, along = np.concatenate([center - side, center + side]), np.tile(axis, 2)

    def gap(points, k):
        """Distances of points from the outlines of grains k, < 0 inside, in lengths of the grain."""
        local = (points - center[k]) / axis[k]
        return (np.abs(local - np.clip(local.real, -a[k], a[k])) - r[k]) / (a[k] + r[k])

    with np.errstate(divide="ignore", invalid="ignore"):
        # line and circle: the foot of the centre on the line, and half the chord
        foot = sides[:, None] + along[:, None] * ((caps - sides[:, None]) / along[:, None]).real
        half = np.sqrt(radii**2 - np.abs(foot - caps) ** 2) * along[:, None]
        # two circles: the foot of the common chord, and half of it
        way = caps - caps[:, None]
        share = (1 + (radii[:, None] ** 2 - radii**2) / np.abs(way) ** 2) / 2
        chord = np.sqrt(radii[:, None] ** 2 - np.abs(share * way) ** 2) * 1j * way / np.abs(way)
        middle = caps[:, None] + share * way
        # two lines
        reach = ((sides - sides[:, None]) / along[:, None]).imag
        lines = sides - along * reach / (along / along[:, None]).imag
        points = np.stack([foot, foot - half, foot + half, middle - chord, middle + chord, lines])
        one, two = np.arange(2 * len(r))[:, None] % len(r), np.arange(2 * len(r)) % len(r)
        apart = np.maximum(np.abs(gap(points, one)), np.abs(gap(points, two)))
    points = points[apart < ON_OUTLINE]  # not NaN, which marks lines and circles that do not meet
    outside = gap(points[:, None], np.arange(len(r))).min(axis=1) > -ON_OUTLINE
    return points[outside].real


def _sections(grains, x):
    """Return lower and upper y of each grain on the vertical lines at x (L,), (N, L) each.

    A line that misses the grain has ∞ and −∞. The outline is convex, so the extremes over caps and
    sides bound the section.
    """
    a, r = grains["half_length"][:, None], grains["cap_radius"][:, None]
    axis = _axes(grains)[:, None]
    c, s = axis.real, axis.imag
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
