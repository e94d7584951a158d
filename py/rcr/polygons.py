"""Bodies with the shape of a rounded convex polygon, in the plane z = 0.

The core is a convex polygon of 1 to 64 corners; the shape is all points within the rounding radius
of it. R and R′ are its circumscribed and inscribed radius about the centre of mass, η = (R − R′)/R.
Masses are per unit depth [kg/m]. The functions are also in `rcr`.
"""

import numpy as np
from yade.wrapper import RoundedPolygon

from rcr import _kernel
from rcr._data import checks
from rcr.outlines import distances
from rcr.scene import grain_body

_HEXAGON = 1 - np.sqrt(0.75)  # η of the regular hexagon


def polygon(center, vertices, radius=0, angle=0, **options):
    """Return a body with the shape of a rounded polygon; ``O.bodies.append`` adds it.

    A ValueError reports corners that are not convex, or a number outside its range.

    Parameters
    ----------
    center : (float, float) or (float, float, float)
        Centre of mass [m]. All grains of a scene have the same z, 0 by default.
    vertices : (n, 2) array
        Corners of the core, clockwise or counter-clockwise, 1 ≤ n ≤ 64 [m]. Their origin is
        arbitrary: the shape is placed by its centre of mass. `from_outline` makes them of any
        points.
    radius : float
        Rounding radius [m], ≥ 0; > 0 with one or two corners.
    angle : float
        Rotation of the corners [rad].
    options
        material, fixed, color, mask, velocity and angular_velocity, as for `rcr.particle`.
    """
    corners = checks.array("vertices", vertices, (None, 2))
    radius = checks.number("radius", radius, "a finite rounding radius ≥ 0 [m]", lambda v: v >= 0)
    if len(corners) > 2 and _twice_area(corners) < 0:
        corners = corners[::-1]
    area, centroid, moment = _kernel.polygon_moments(corners, radius)
    corners = (corners - centroid).tolist()
    return grain_body(RoundedPolygon(vertices=corners, radius=radius), area, moment, center, angle,
                      **options)


def regular_polygon(center, R, sides, radius=0, angle=0, **options):
    """Return a regular polygon of `sides` ≥ 3 sides with the circumscribed radius R [m].

    R contains the rounding `radius` < R. A corner lies at `angle` from the centre. Parameters and
    errors are those of `polygon`.
    """
    sides = checks.integer("sides", sides, "a number of sides from 3 to 64",
                           lambda v: 3 <= v <= 64)
    R, radius = _radii(R, radius)
    turn = 2 * np.pi * np.arange(sides) / sides
    return polygon(center, _corners(R - radius, turn), radius, angle, **options)


def truncated_triangle(center, R, eta, angle=0, **options):
    """Return an equilateral triangle with cut corners, all at the circumscribed radius R [m].

    `eta` is 0.5 for the triangle and 1 − √3/2 for the regular hexagon. A long side has its normal
    at `angle`. The corners are sharp. Options and errors are those of `polygon`.
    """
    R = _sharp(R, options)
    eta = checks.number("eta", eta, "an elongation from 1 − √3/2 (hexagon) to 0.5 (triangle)",
                        lambda v: _HEXAGON - 1e-9 <= v <= 0.5)
    normals = 2 * np.pi / 3 * np.arange(3)
    if eta == 0.5:
        return polygon(center, _corners(R, normals + np.pi / 3), 0, angle, **options)
    half = np.arccos(1 - eta)  # angle from the normal of a long side to its corners
    turn = (normals[:, None] + [-half, half]).ravel()
    return polygon(center, _corners(R, turn), 0, angle, **options)


def elongated_hexagon(center, R, eta, angle=0, **options):
    """Return a hexagon with two long parallel sides and the circumscribed radius R [m].

    `eta` ≥ 1 − √3/2, the regular hexagon. The corners at both ends have 120°. The long axis lies at
    `angle`. The corners are sharp. Options and errors are those of `polygon`.
    """
    R = _sharp(R, options)
    eta = checks.number("eta", eta, "an elongation 1 − √3/2 ≤ eta < 1",
                        lambda v: _HEXAGON - 1e-9 <= v < 1)
    height = (1 - eta) * R
    x = R - height / np.sqrt(3)
    corners = [(R, 0), (x, height), (-x, height), (-R, 0), (-x, -height), (x, -height)]
    return polygon(center, corners, 0, angle, **options)


def from_outline(points, vertices=8):
    """Return the corners of a convex polygon close to an outline, and its error.

    The corners are points of the convex hull. Corners that take away the least area are left out,
    then each one moves to where the area is largest. A ValueError reports fewer than three points,
    or points on one line.

    Parameters
    ----------
    points : (n, 2) array
        Points of an outline in any order [m]. Concave parts are filled.
    vertices : int
        Largest number of corners, 3 to 64.

    Returns
    -------
    corners : (m, 2) array
        Counter-clockwise, m ≤ `vertices` [m].
    error : float
        Largest distance of a point of the hull from the polygon [m].
    """
    from scipy.spatial import ConvexHull, QhullError

    points = checks.array("points", points, (None, 2))
    vertices = checks.integer("vertices", vertices, "a number of corners from 3 to 64",
                              lambda v: 3 <= v <= 64)
    flat = checks.error("points", points, "three points or more that are not on one line")
    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        raise flat
    size = np.ptp(hull, axis=0).max()
    kept = np.arange(len(hull))
    while True:
        corners = hull[kept]
        lost = _cross(corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners)
        if len(kept) <= vertices and lost.min() > 1e-9 * size**2:
            break
        if len(kept) == 3:
            raise flat
        kept = np.delete(kept, np.argmin(lost))
    for _ in hull:
        before = kept.copy()
        for k in range(len(kept)):
            first, last = kept[k - 1], kept[(k + 1) % len(kept)]
            between = (first + np.arange(1, (last - first) % len(hull))) % len(hull)
            chord = np.broadcast_to(hull[last] - hull[first], (len(between), 2))
            kept[k] = between[np.argmin(_cross(chord, hull[between] - hull[first]))]
        if np.array_equal(kept, before):
            break
    corners = hull[kept]
    away = distances(hull @ [1, 1j], corners @ [1, 1j])
    return corners, float(max(0, away.max()))


def _corners(R, turn):
    return R * np.column_stack([np.cos(turn), np.sin(turn)])


def _radii(R, radius):
    R = checks.number("R", R, "a finite radius of the circumscribed circle > 0 [m]", lambda v: v > 0)
    expected = f"a rounding radius from 0 to below R = {R} [m]"
    return R, checks.number("radius", radius, expected, lambda v: 0 <= v < R)


def _sharp(R, options):
    """Return R, checked; the options may have a rounding radius of 0."""
    checks.number("radius", options.pop("radius", 0),
                  "0: this shape has sharp corners; rcr.polygon makes rounded ones", lambda v: v == 0)
    return _radii(R, 0)[0]


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _twice_area(corners):
    return _cross(corners, np.roll(corners, -1, axis=0)).sum()
