"""Distances of bodies in the plane with NumPy, independent of the kernels.

The separation of two convex cores along a unit vector n is min(n · vertices 2) − max(n · vertices
1). Its largest value over all n is their signed distance. It lies at the normal of a side or along
a line of two vertices.
"""

import itertools

import numpy as np
import rcr
from yade import O
from yade import wrapper as w


def core(body):
    """Vertices (n, 2) of the core of a body in the plane and its rounding radius [m]; or None."""
    shape, (x, y, _) = body.shape, body.state.pos
    rounding = getattr(shape, "radius", 0.0)
    if isinstance(shape, w.Sphere):
        corners = [(0, 0)]
    elif isinstance(shape, rcr.Rcr):
        corners, rounding = [(-shape.halfLength, 0), (shape.halfLength, 0)], shape.capRadius
    elif isinstance(shape, rcr.RoundedPolygon):
        corners = [tuple(v) for v in shape.vertices]
    elif isinstance(shape, w.Box):
        a, b, _ = shape.extents
        corners = [(a, b), (-a, b), (-a, -b), (a, -b)]
    else:
        return None
    turn = 2 * np.arctan2(body.state.ori[2], body.state.ori[3])
    c, s = np.cos(turn), np.sin(turn)
    return np.array(corners) @ np.array([[c, s], [-s, c]]) + [x, y], rounding


def distance(one, two):
    """Signed distance of two cores (n, 2) and (m, 2) [m]."""
    normals = [(one[:, None] - two).reshape(-1, 2) * -1]
    for corners, sign in ((one, 1), (two, -1)):
        if len(corners) > 1:
            sides = np.roll(corners, -1, axis=0) - corners
            normals.append(sign * np.column_stack([sides[:, 1], -sides[:, 0]]))
    n = np.concatenate(normals)
    length = np.hypot(*n.T)
    n = n[length > 0] / length[length > 0, None]
    if not len(n):
        return 0.0
    return float(((n @ two.T).min(axis=1) - (n @ one.T).max(axis=1)).max())


def deepest_overlap():
    """Deepest overlap over R₁ + R₂ of all pairs of grains and boxes of which one can move.

    R is the circumscribed radius, that of the grain at a box.
    """
    deepest, bodies = 0.0, [(b, core(b)) for b in O.bodies if b.shape]
    grains = w.Sphere, rcr.Rcr, rcr.RoundedPolygon
    for (one, a), (two, b) in itertools.combinations([x for x in bodies if x[1]], 2):
        both = [isinstance(body.shape, grains) for body in (one, two)]
        fixed = all(x.state.blockedDOFs == "xyzXYZ" and not x.isClumpMember for x in (one, two))
        if not any(both) or fixed or (one.isClumpMember and one.clumpId == two.clumpId):
            continue
        radii = [np.hypot(*(corners - list(body.state.pos)[:2]).T).max() + rounding
                 for body, (corners, rounding), grain in zip((one, two), (a, b), both) if grain]
        gap = distance(a[0], b[0]) - a[1] - b[1]
        deepest = max(deepest, -gap / (sum(radii) * 2 / len(radii)))
    return deepest
