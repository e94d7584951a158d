"""Grains of the biaxial test, each inscribed in a circle of radius R. Needs YADE.

All shapes are those of CEGEO, EPL 98 (2012) 44008, with η = (R − R′)/R of their circumscribed and
inscribed circle; `regular` is a regular polygon. Bodies of a clump follow the clump.
"""

import math

import numpy as np
from yade.wrapper import Omega, Rcr, Sphere

import rcr

O = Omega()
_BODIES = dict(rcr="Rcr", trimer="Sphere")  # shape in YADE; all others are polygons


def functors(shape):
    """Return the functor of the boxes, and those of contacts between grains and with walls."""
    kind = _BODIES.get(shape, "RoundedPolygon")
    box = "Disc" if kind == "Sphere" else kind
    names = f"Bo1_{box}_Aabb", f"Ig2_{kind}_{kind}_RcrGeom", f"Ig2_Wall_{kind}_RcrGeom"
    return [getattr(rcr, name)() for name in names]


def append(parameters, centres, radii, turns, material):
    """Append the grains of a test to the scene.

    `parameters` are those of `rcr.study.protocol.check_parameters`, `turns` directions over a whole
    turn, (N,) in [0, 1]. Rounded-cap rectangles are symmetric, so theirs fill half a turn.
    """
    shape, eta, sides = (parameters[name] for name in ("shape", "eta", "sides"))
    of = dict(material=material)
    make = {
        "rcr": lambda center, R, angle: rcr.particle(center, R, eta, angle, **of),
        "trimer": lambda center, R, angle: trimer(center, R, eta, angle, **of),
        "regular": lambda center, R, angle: rcr.regular_polygon(center, R, sides, 0, angle, **of),
        "truncated": lambda center, R, angle: rcr.truncated_triangle(center, R, eta, angle, **of),
        "hexagon": lambda center, R, angle: rcr.elongated_hexagon(center, R, eta, angle, **of),
    }[shape]
    angles = (math.pi if shape == "rcr" else 2 * math.pi) * turns
    made = (make(*place) for place in zip(centres, radii, angles))
    if shape == "trimer":
        for members in made:
            if eta > 0:
                rcr.clump(members)
            else:
                O.bodies.append(members[0])
    else:
        O.bodies.append(list(made))


def trimer(center, R, eta, angle=0, material=-1):
    """Return the three discs of a trimer of circumscribed radius R, for `rcr.clump`.

    The discs touch the circumscribed circle; their outlines intersect on the inscribed one, of
    radius R (1 − η), 0 ≤ η ≤ 0.5. A disc lies at `angle` from the centre. All three coincide at
    η = 0.
    """
    away = eta * (2 - eta) / (1 + eta) * R  # of the centre of a disc
    turn = angle + 2 * math.pi / 3 * np.arange(3)
    places = np.asarray(center) + away * np.column_stack([np.cos(turn), np.sin(turn)])
    return [rcr.disc(place, R - away, material) for place in places]


def ids():
    """Return the ids of the grains of the scene: single bodies and clumps, in their order."""
    return [b.id for b in O.bodies if b.isClump or not b.isClumpMember and _radius(b.shape)]


def circumscribed_radii(numbers):
    """Return the circumscribed radius of each grain with these ids, (N,) [m]."""
    return np.array([_circumscribed_radius(O.bodies[k]) for k in numbers])


def _circumscribed_radius(body):
    if not body.isClump:
        return _radius(body.shape)
    members = [O.bodies[k] for k in body.shape.members]
    return max((m.state.pos - body.state.pos).norm() + _radius(m.shape) for m in members)


def _radius(shape):
    """Return the circumscribed radius of a shape [m]; 0 for a wall."""
    if isinstance(shape, Rcr):
        return shape.halfLength + shape.capRadius
    if isinstance(shape, Sphere):
        return shape.radius
    if isinstance(shape, rcr.RoundedPolygon):
        return max(corner.norm() for corner in shape.vertices) + shape.radius
    return 0.0


def contract(share):
    """Move all bodies towards the origin by a share of their coordinates; clumps stay rigid."""
    for body in O.bodies:
        if body.isClump:
            for member in body.shape.members:
                O.bodies[member].state.pos -= share * body.state.pos
        if not body.isClumpMember:
            body.state.pos *= 1 - share
