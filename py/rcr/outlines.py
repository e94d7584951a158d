"""Outlines of rounded convex polygons of the circumscribed radius 1. Needs NumPy.

The core is a convex polygon, the outline all points at the rounding radius from it. Two corners
make a rounded-cap rectangle, one makes a disc. Points in the plane are complex numbers x + i y
within this package.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rcr._data import checks

MOST = 64  # corners
_ROUNDING = 1e-6  # relative, of lengths in files


@dataclass(frozen=True, eq=False)
class Outline:
    """Core corners and rounding radius of a shape, divided by its circumscribed radius R."""

    corners: np.ndarray  # (n, 2), counter-clockwise, from the centre of mass [-]
    radius: float  # [-]

    @cached_property
    def core(self):
        """Corners as complex numbers, (n,)."""
        return self.corners @ [1, 1j]

    @cached_property
    def inscribed(self):
        """Inscribed radius about the centre R′/R [-]."""
        side, length, along = sides(self.core)
        nearest = -(self.core / along).imag[length > 0] if len(self.core) > 2 else np.zeros(1)
        return float(nearest.min() + self.radius)

    @cached_property
    def normal_arm(self):
        """Largest lever arm of a normal force about the centre, over R [-]."""
        _, _, along = sides(self.core)
        ends = np.array([self.core, np.roll(self.core, -1)]) / along
        return float(np.abs(ends.real).max())

    def points(self, count):
        """Return points of the outline with `count` per half circle, complex (k,)."""
        if len(self.core) == 1:
            return self.core + self.radius * np.exp(2j * np.pi * np.arange(2 * count) / (2 * count))
        normal = sides(self.core)[2] * -1j
        arcs = []
        for corner, before, after in zip(self.core, np.roll(normal, 1), normal):
            turn = np.angle(after / before) % (2 * np.pi)
            pieces = int(np.ceil((count - 1) * turn / np.pi - 1e-9)) if self.radius else 0
            turned = before * np.exp(1j * np.linspace(0, turn, pieces + 1))
            arcs.append(corner + self.radius * turned)
        return np.concatenate(arcs)


def sides(corners):
    """Return the sides of closed polygons (…, n), their lengths and directions, (…, n) each.

    Corners are complex numbers. A side without length has the direction 1.
    """
    side = np.roll(corners, -1, axis=-1) - corners
    length = np.abs(side)
    return side, length, np.divide(side, length, out=np.ones_like(side), where=length > 0)


def distances(points, corners):
    """Return the distances of points (…) from convex polygons (…, n), < 0 inside.

    Points and corners are complex numbers; repeated corners have no effect.
    """
    _, length, along = sides(corners)
    local = (points[..., None] - corners) / along
    away = np.abs(local - np.clip(local.real, 0, length)).min(axis=-1)
    inside = ((local.imag >= 0) | (length == 0)).all(axis=-1) & ((length > 0).sum(axis=-1) > 2)
    return np.where(inside, -away, away)


def checked(shapes):
    """Return shapes, (corners, radius) each, as a list of `Outline`s, or a ValueError."""
    return [shape if isinstance(shape, Outline) else _checked(f"shapes[{k}]", *shape)
            for k, shape in enumerate(shapes)]


def _checked(name, corners, radius):
    corners = checks.array(f"{name}.corners", corners, (None, 2))
    expected = "a rounding radius from 0 to 1, over R"
    radius = checks.number(f"{name}.radius", radius, expected, lambda v: 0 <= v <= 1 + _ROUNDING)
    outline, given = Outline(corners, radius), f"{name}.corners has {len(corners)} rows"
    if not 1 <= len(corners) <= MOST or (len(corners) < 3 and radius == 0):
        raise ValueError(f"{given}; expected 1 to {MOST}, three or more without rounding")
    side, length, along = sides(outline.core)
    turned = np.angle(along / np.roll(along, 1))
    convex = len(corners) < 3 or (turned > 0).all() and turned.sum() < 3 * np.pi
    if not convex or len(corners) > 1 and not (length > 0).all():
        raise ValueError(f"{name}.corners is not a convex polygon, counter-clockwise")
    reach = np.abs(outline.core).max() + radius
    if abs(reach - 1) > _ROUNDING or not outline.inscribed > 0:
        given = f"{name} reaches {reach:g} from its centre, which lies {outline.inscribed:g} within"
        raise ValueError(f"{given} its sides; expected 1, and a number > 0")
    return outline


def columns(shapes):
    """Return `Outline`s as the columns of a file: ``corners`` (K, 2), ``count``, ``radius``."""
    return dict(corners=np.concatenate([shape.corners for shape in shapes]),
                count=np.array([len(shape.corners) for shape in shapes]),
                radius=np.array([shape.radius for shape in shapes]))


def of_columns(found):
    """Return the `Outline`s of the columns of a file, or a ValueError."""
    if missing := sorted({"corners", "count", "radius"} - set(found)):
        raise ValueError(f"group 'shapes' lacks {', '.join(missing)}")
    corners = checks.reals("shapes/corners", found["corners"], (None, 2))
    radius = checks.reals("shapes/radius", found["radius"], (None,))
    count = checks.reals("shapes/count", found["count"], (len(radius),))
    valid = (count >= 1) & (count == np.floor(count)) & (count <= MOST)
    checks.require(valid, "shapes/count", count, f"1 to {MOST} corners")
    if count.sum() != len(corners):
        raise ValueError(f"shapes/corners has {len(corners)} rows; expected {count.sum():g}, the "
                         "sum of shapes/count")
    parts = np.split(corners, np.cumsum(count.astype(int))[:-1]) if len(count) else []
    return checked(zip(parts, radius))
