"""Outlines and areas of grains: extents, polygons, sample points, unions. Needs NumPy.

`grains` is a dict of arrays, one row per grain: ``position`` (N, 2) [m], ``angle`` (N,) from x to
the long axis [rad], ``half_length`` and ``cap_radius`` (N,) [m]. A disc has the half length 0. The
optional column ``shape`` (N,) is −1, or the row of a rounded polygon in the list `shapes` of
`rcr.outlines.Outline`. A polygon has the cap radius R′, the half length R − R′ and the angle of its
corners.
"""

import numpy as np

from rcr.outlines import distances, sides

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(40)  # of the integral over x between two kinks
ON_OUTLINE = 1e-6  # distance from an outline that counts as rounding, over the length of the grain


def areas(grains, shapes=()):
    """Return the area of each grain, (N,) [m²]."""
    corners, r = _cores(grains, shapes)
    core = (corners.conj() * np.roll(corners, -1, axis=1)).imag.sum(axis=1) / 2
    return np.pi * r**2 + sides(corners)[1].sum(axis=1) * r + core  # [Steiner]


def _axes(grains):
    """Return the long axis of each grain as x + i y, (N,).

    NumPy before 2 rounds np.cos, np.sin and powers differently on different processors.
    """
    return np.exp(1j * grains["angle"])


def _shape(grains):
    """Return the row of each grain in `shapes`, −1 of discs and Rcrs, (N,)."""
    return grains.get("shape", np.full(len(grains["angle"]), -1))


def _by_shape(grains, shapes):
    """Yield each polygon of `shapes` that grains have, with the rows of these grains."""
    shape = _shape(grains)
    rows = np.argsort(shape, kind="stable")
    for same in np.split(rows, np.flatnonzero(np.diff(shape[rows])) + 1):
        if len(same) and shape[same[0]] >= 0:
            yield shapes[shape[same[0]]], same


def _cores(grains, shapes):
    """Return the corners of the cores from the centres, without rotation, and the rounding radii.

    Corners are complex numbers (N, V) [m]; the last one is repeated if a core has fewer than V.
    """
    a, r = grains["half_length"], grains["cap_radius"]
    shape = _shape(grains)
    if not (shape >= 0).any():
        return np.column_stack([-a, a]) + 0j, r
    most = max(2, *(len(outline.core) for outline in shapes))
    corners = np.column_stack([-a, *[a] * (most - 1)]) + 0j
    unit = np.array([np.pad(one.core, (0, most - len(one.core)), "edge") for one in shapes])
    round_ = np.array([one.radius for one in shapes])
    polygon, R = shape >= 0, a + r
    corners[polygon] = R[polygon, None] * unit[shape[polygon]]
    return corners, np.where(polygon, R * round_[shape], r)


def _placed_cores(grains, shapes):
    """Return the corners of the cores in the plane, complex (N, V), and the rounding radii [m]."""
    corners, r = _cores(grains, shapes)
    return corners * _axes(grains)[:, None] + (grains["position"] @ [1, 1j])[:, None], r


def boxes(grains, shapes=()):
    """Return the lower left and the upper right corner of the box of each grain, (2, N, 2) [m]."""
    corners, r = _cores(grains, shapes)
    turned = corners * _axes(grains)[:, None]
    at, r = grains["position"], r[:, None]
    low, high = (np.column_stack([end(turned.real, axis=1), end(turned.imag, axis=1)])
                 for end in (np.min, np.max))
    return np.stack([at + (low - r), at + (high + r)])


def bounds(grains, shapes=()):
    """Return the lower left and upper right corner of the box around all grains, (2, 2) [m]."""
    low, high = boxes(grains, shapes)
    return np.stack([low.min(axis=0), high.max(axis=0)])


def polygons(grains, shapes=(), points=12):
    """Return the outlines as a list of N polygons (k, 2) [m].

    Caps and rounded corners have `points` vertices per half circle.
    """
    half = np.linspace(-np.pi / 2, np.pi / 2, points)
    turn = np.concatenate([half, half + np.pi])
    sign = np.repeat([1, -1], points)
    x = grains["cap_radius"][:, None] * np.cos(turn) + sign * grains["half_length"][:, None]
    y = grains["cap_radius"][:, None] * np.sin(turn)
    found = list(_in_plane(x + 1j * y, grains))
    for outline, rows in _by_shape(grains, shapes):
        same = {name: grains[name][rows]
                for name in ("position", "angle", "half_length", "cap_radius")}
        R = same["half_length"] + same["cap_radius"]
        for row, polygon in zip(rows, _in_plane(R[:, None] * outline.points(points), same)):
            found[row] = polygon
    return found


def _in_plane(local, grains):
    """Return points (N, k) from the centres, as complex numbers, in the plane, (N, k, 2) [m]."""
    z = local * _axes(grains)[:, None]
    return np.stack([z.real, z.imag], axis=-1) + grains["position"][:, None]


def samples(grains, count, shapes=()):
    """Return points spread evenly over each grain, `count` along and across, and their weights.

    The points (N, K, 2) [m] are relative to the centre. The weights (N, K),
    fractions of the grain, add up to 1.
    """
    r, a = (grains[name][:, None] for name in ("cap_radius", "half_length"))
    even = (2 * np.arange(count) + 1) / count - 1
    u, v = (c.ravel() for c in np.meshgrid(even, even))
    x, y = u * (a + r), v * r
    inside = np.maximum(np.abs(x) - a, 0) ** 2 + y**2 <= r**2
    local = x + 1j * y
    for outline, rows in _by_shape(grains, shapes):
        core, reach = outline.core, outline.radius * np.array([-1, 1])
        (left, right), (low, high) = ((part.min(), part.max()) + reach
                                      for part in (core.real, core.imag))
        unit = (left + right + (right - left) * u + 1j * (low + high + (high - low) * v)) / 2
        within = distances(unit, core) <= outline.radius
        if not within.any():  # a thin, oblique shape between the points: its centre
            unit, within = 0 * unit, np.ones(len(unit), bool)
        inside[rows] = within
        local[rows] = (a + r)[rows] * unit
    turned = local * _axes(grains)[:, None]
    points = np.stack([turned.real, turned.imag], axis=-1)
    return points, inside / inside.sum(axis=1, keepdims=True)


def union(grains, shapes=()):
    """Return area [m²], centroid (2,) [m] and polar moment about it [m⁴] of the union of grains.

    The integral over y is exact. That over x is Gauss's between kinks of the outline of the union.
    """
    origin = grains["position"].mean(axis=0)  # digits of large coordinates would cancel
    grains = dict(grains, position=grains["position"] - origin)
    corners, r = _placed_cores(grains, shapes)
    at, width = _lines(corners, r)
    low, high = _sections(corners, r, at)
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


def _lines(corners, r):
    """Return x and weight of vertical lines for an integral over x, (L,) each [m].

    Sections are smooth between two kinks. With x = sin t there, they are also smooth at caps.
    """
    left, right = corners.real.min(axis=1) - r, corners.real.max(axis=1) + r
    kinks = np.unique(np.concatenate([left, right, _crossings(corners, r)]))
    middle, half = (kinks[1:] + kinks[:-1]) / 2, np.diff(kinks) / 2
    turn = np.exp(1j * np.pi / 2 * _NODES)
    weight = np.pi / 2 * _WEIGHTS * turn.real
    return (middle[:, None] + half[:, None] * turn.imag).ravel(), np.outer(half, weight).ravel()


def _crossings(corners, r):
    """Return abscissas at which outlines of grains cross on the outline of the union.

    The ends of sides on the outline of the union are included. Caps are circles of the radius r
    about the corners.
    """
    number, most = corners.shape
    owner = np.arange(number * most) // most
    caps, radii = corners.ravel(), r[owner]
    _, length, along = (part.ravel() for part in sides(corners))
    start = caps - radii * 1j * along
    size = np.abs(corners - corners.mean(axis=1, keepdims=True)).max(axis=1) + r
    margin = ON_OUTLINE * size[owner]

    def on_sides(points, k):
        """Points on the sides k, NaN elsewhere."""
        along_side = ((points - start[k]) / along[k]).real
        on = (along_side > -margin[k]) & (along_side < length[k] + margin[k])
        return np.where(on, points, np.nan)

    rows, columns = np.arange(len(caps))[:, None], np.arange(len(caps))
    with np.errstate(divide="ignore", invalid="ignore"):
        # line and circle: the foot of the centre on the line, and half the chord
        foot = start[rows] + along[rows] * ((caps - start[rows]) / along[rows]).real
        half = np.sqrt(radii**2 - np.abs(foot - caps) ** 2) * along[rows]
        # two circles: the foot of the common chord, and half of it
        way = caps - caps[rows]
        share = (1 + (radii[rows] ** 2 - radii**2) / np.abs(way) ** 2) / 2
        chord = np.sqrt(radii[rows] ** 2 - np.abs(share * way) ** 2) * 1j * way / np.abs(way)
        middle = caps[rows] + share * way
        # two lines
        reach = ((start - start[rows]) / along[rows]).imag
        lines = start - along * reach / (along / along[rows]).imag
        lines = on_sides(on_sides(lines, rows), columns)
        cuts = (on_sides(points, rows) for points in (foot, foot - half, foot + half))
        points = np.stack([*cuts, middle - chord, middle + chord, lines])
    met = np.isfinite(points)  # NaN marks lines and circles that do not meet
    one, two = (np.broadcast_to(owner[k], points.shape)[met] for k in (rows, columns))
    points = points[met]
    for _ in range(2):
        on = np.abs(_gaps(points, corners[one], r[one], size[one])) < ON_OUTLINE
        points, one, two = points[on], two[on], one[on]
    inside = np.zeros(len(points), bool)
    for k in range(number):
        inside |= _gaps(points, corners[k], r[k], size[k]) < -ON_OUTLINE
    return points[~inside].real


def _gaps(points, corners, r, size):
    """Return distances of points from outlines, < 0 inside, in lengths of the grains."""
    return (distances(points, corners) - r) / size


def _sections(corners, r, x):
    """Return lower and upper y of each grain on the vertical lines at x (L,), (N, L) each.

    A line that misses the grain has ∞ and −∞. The outline is convex, so the extremes over caps and
    sides bound the section.
    """
    _, lengths, directions = sides(corners)
    low, high = np.full((len(r), len(x)), np.inf), np.full((len(r), len(x)), -np.inf)
    r = r[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        for corner, length, along in zip(*(part.T[..., None]
                                           for part in (corners, lengths, directions))):
            half = np.sqrt(r**2 - (x - corner.real) ** 2)  # of a cap; NaN beside it
            start = corner - r * 1j * along
            way = (x - start.real) / along.real  # along the side to the line
            side = np.where((way >= 0) & (way <= length), start.imag + way * along.imag, np.nan)
            low = np.fmin(low, np.fmin(corner.imag - half, side))
            high = np.fmax(high, np.fmax(corner.imag + half, side))
    return low, high
