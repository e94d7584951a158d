"""Bodies of a scene: grains, clumps and obstacles in the plane z = 0.

Masses and forces are per unit depth: kg and N per metre. The functions that make bodies are also in
`rcr`.
"""

import math
import numbers
from collections.abc import Sequence

import numpy as np
from yade import utils
from yade.minieigenHP import Quaternion, Vector2, Vector3
from yade.wrapper import Body, FrictMat, Omega, Rcr, Sphere

from rcr import _kernel, _plugin, geometry
from rcr._data import checks
from rcr._yade.scene_arrays import GRAINS, angle as angle_of, lengths

O = Omega()
_number = checks.number


def particle(
    center, R, eta, angle=0, material=-1, fixed=False, color=None, mask=1, velocity=(0, 0),
    angular_velocity=0,
):  # fmt: skip
    """Return a body with the shape of a rounded-cap rectangle; ``O.bodies.append`` adds it.

    A ValueError reports a number that is not finite or outside its range.

    Parameters
    ----------
    center : (float, float) or (float, float, float)
        Centre of mass [m]. All grains of a scene have the same z, 0 by default.
    R : float
        Radius of the circumscribed circle [m], > 0.
    eta : float
        Elongation (R − R')/R [-], 0 ≤ eta < 1; 0 is a disc.
    angle : float
        Angle from x to the long axis [rad].
    material : FrictMat, int or str
        Material, or its id or label in O.materials. Its density [kg/m³] sets the mass. The default
        −1 is the last material; an empty O.materials gets YADE's default material (density
        1000 kg/m³, friction angle 0.5).
    fixed : bool
        True blocks all degrees of freedom. False lets the body move in the plane.
    color : (float, float, float) or None
        Red, green, blue, 0 to 1; None is a random colour.
    mask : int
        Group mask, as ``Body.mask``.
    velocity : (float, float)
        Velocity of the centre [m/s].
    angular_velocity : float
        Angular velocity about z [1/s].
    """
    R = _number("R", R, "a finite radius of the circumscribed circle > 0 [m]", _positive)
    eta = _number("eta", eta, "an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1)
    shape = Rcr(capRadius=(1 - eta) * R, halfLength=eta * R)
    area = _kernel.area(shape.halfLength, shape.capRadius)
    moment = _kernel.polar_moment(shape.halfLength, shape.capRadius)
    return grain_body(shape, area, moment, center, angle, material, fixed, color, mask, velocity,
                  angular_velocity)


def disc(
    center, R, material=-1, angle=0, fixed=False, color=None, mask=1, velocity=(0, 0),
    angular_velocity=0,
):  # fmt: skip
    """Return a YADE `Sphere` with the mass π R² ρ and the moment of inertia m R²/2 of a disc.

    ``utils.sphere`` gives the mass of a ball, which is inconsistent with `particle`. Parameters,
    errors and the returned body are those of `particle`, without the elongation.
    """
    R = _number("R", R, "a finite radius > 0 [m]", _positive)
    area, moment = math.pi * R**2, math.pi * R**4 / 2
    return grain_body(Sphere(radius=R), area, moment, center, angle, material, fixed, color, mask,
                  velocity, angular_velocity)


def clump(members, mass=None, inertia=None):
    """Join `Rcr`, `Sphere` and `RoundedPolygon` bodies into one body and append it to the scene.

    YADE's ``O.bodies.appendClumped`` makes three-dimensional bodies: with the mass of balls, and
    with principal axes that may leave the plane. The function returns the id of the clump and the
    ids of its members; set velocities on the clump: ``O.bodies[id].state.vel``. A ValueError says
    that there is no member, that one has another shape, is fixed or moves, or that a number is
    outside its range.

    Parameters
    ----------
    members : list of Body
        Bodies of `particle`, `disc`, `polygon` and so on, not yet in the scene. They may overlap.
        The density is that of the first member's material.
    mass : float or None
        Mass [kg]; None is density × area of the union of the members.
    inertia : float or None
        Moment of inertia about z through the centre of the union [kg m²]; None is that of the
        union with this mass.
    """
    members = list(members)
    grains = [isinstance(b, Body) and isinstance(b.shape, GRAINS) for b in members]
    if not members or not all(grains):
        expected = "at least one body of rcr.particle, rcr.disc or rcr.polygon"
        raise checks.error("members", members, expected)
    for number, state in enumerate(b.state for b in members):
        if state.blockedDOFs != "zXY" or any(state.vel) or any(state.angVel):
            raise ValueError(f"members[{number}] is fixed or moves; block or move the clump "
                             "instead: O.bodies[id].state")
    if known := [b.id for b in members if b.id >= 0]:
        raise ValueError(f"members holds body #{known[0]} of a scene; expected new bodies")
    if len({id(b) for b in members}) < len(members):
        raise ValueError("members holds a body twice; expected each body once")
    area, (x, y), polar_moment = geometry.union(*_outlines_of(members))
    given, density = mass is not None, members[0].material.density
    mass = mass if given else density * area
    mass = _number("mass", mass, "a finite mass > 0 [kg]", _positive)
    if inertia is None:
        inertia = mass / area * polar_moment
    inertia = _number("inertia", inertia, "a finite moment of inertia > 0 [kg m²]", _positive)
    ids = O.bodies.append(members)
    number = _plugin.planar_clump(ids, x, y, mass, inertia)
    if given:
        O.bodies[number].material = FrictMat(density=mass / area)  # that of its mass
    return number, ids


def union_area(ids):
    """Return the area of the union of grains of the scene [m²]."""
    return float(geometry.union(*_outlines_of([O.bodies[k] for k in ids]))[0])


def wall(axis, position, sense=0, velocity=0, material=-1):
    """Return an infinite wall with prescribed motion.

    A ValueError reports an unknown axis or sense, or a number that is not finite.

    Parameters
    ----------
    axis : str or int
        Axis of the normal: 'y' (or 1) for a floor or a lid, 'x' (or 0) for a side wall.
    position : float
        Coordinate along that axis [m].
    sense : int
        Active side: +1, −1, or 0 for both.
    velocity : float
        Velocity along the axis [m/s]. ``body.state.vel`` changes it later.
    material : FrictMat, int or str
        As for `particle`.
    """
    expected = "'x' or 'y' (or 0 or 1), the axis of the wall's normal"
    k = "xy".index(axis) if axis in ("x", "y") else checks.integer(
        "axis", axis, expected, lambda v: v in (0, 1))
    sense = checks.integer("sense", sense, "+1, −1, or 0 for both sides", lambda v: abs(v) <= 1)
    position = _number("position", position, "a finite coordinate [m]")
    body = utils.wall(position, k, sense=sense, material=_material(material))
    body.state.vel[k] = _number("velocity", velocity, "a finite velocity [m/s]")
    return body


def mobile_wall(axis, position, mass, sense=0, material=-1):
    """Return a wall that forces move along its normal (``WallStress``, ``O.forces.setPermF``).

    `mass` [kg] replaces the velocity; the other parameters are those of `wall`.
    """
    body = wall(axis, position, sense=sense, material=material)
    body.state.mass = _number("mass", mass, "a finite mass > 0 [kg]", _positive)
    body.state.blockedDOFs = "yzXYZ" if body.shape.axis == 0 else "xzXYZ"
    return body


def segment(start, end, material=-1):
    """Return a fixed `Facet` that intersects the plane in the segment between two points [m].

    `start` and `end` have two or three coordinates, at the z of the grains; the material is that of
    `particle`. Both sides are active. ``utils.facet`` takes the corners of a triangle in space,
    which intersects the plane only in a part of its edge. A ValueError reports a coordinate that
    is not finite, or ends that differ in z or coincide.
    """
    start, end = _point("start", start), _point("end", end)
    length = (end - start).norm()
    if not length > 0 or start[2] != end[2]:
        given = f"start = {tuple(start)}, end = {tuple(end)}"
        raise ValueError(f"{given}; expected two different points at one z [m]")
    middle, out = (start + end) / 2, Vector3(0, 0, 0.1 * length)
    # the ends are the midpoints of two edges
    corners = (2 * start - middle - out, 2 * end - middle - out, middle + out)
    return utils.facet(corners, material=_material(material))


def grain_body(
    shape, area, polar_moment, center, angle=0, material=-1, fixed=False, color=None, mask=1,
    velocity=(0, 0), angular_velocity=0,
):  # fmt: skip
    """Return a body in the plane with the mass and inertia of its shape per unit depth.

    `area` [m²] and `polar_moment` = ∫ |x|² dA about the centre [m⁴] are those of `shape`. The other
    parameters are those of `particle`.
    """
    material = _material(material)
    expected = "a finite density > 0 [kg/m³]"
    density = _number("material.density", material.density, expected, _positive)
    body = Body(shape=shape, material=material)
    state = body.state
    state.mass = _number("density × area", density * area, "a finite mass > 0 [kg]", _positive)
    # the moment about z alone acts, but YADE requires three positive ones
    state.inertia = Vector3(1, 1, 1) * (density * polar_moment)
    state.pos = state.refPos = _point("center", center)
    angle = _number("angle", angle, "a finite angle [rad]")
    state.ori = state.refOri = Quaternion(Vector3(0, 0, 1), angle)
    expected = "two components (v_x, v_y) in the plane [m/s]"
    state.vel = _vector("velocity", velocity, expected, "a finite velocity [m/s]")
    if state.vel[2] != 0:
        raise checks.error("velocity", velocity, expected)
    expected = "a finite angular velocity [1/s]"
    state.angVel = Vector3(0, 0, _number("angular_velocity", angular_velocity, expected))
    state.blockedDOFs = "xyzXYZ" if fixed else "zXY"
    shape.color = _color(color) if color is not None else utils.randomColor()
    body.mask = checks.integer("mask", mask, "a mask of 32 bits", lambda v: -(2**31) <= v < 2**31)
    return body


def _positive(value):
    return value > 0


def _material(material):
    """Return a material from itself, its id or its label."""
    if material == -1 and len(O.materials) == 0:
        O.materials.append(utils.defaultMaterial())
    found = material
    if isinstance(material, (numbers.Integral, str)) and not isinstance(material, bool):
        try:
            found = O.materials[material if isinstance(material, str) else int(material)]
        except (IndexError, KeyError, OverflowError):
            found = None
    if not isinstance(found, FrictMat):
        raise checks.error("material", material, "a FrictMat, or the id or label of one")
    return found


def _color(given):
    """Return red, green and blue as a Vector3."""
    values = checks.array("color", given, (3,))
    checks.require((values >= 0) & (values <= 1), "color", values, "a number from 0 to 1")
    return Vector3(*values.tolist())


def _point(name, given):
    """Return two or three finite coordinates as a Vector3."""
    expected = "two or three coordinates (x, y) or (x, y, z) [m]"
    return _vector(name, given, expected, "a finite coordinate [m]")


def _vector(name, given, expected, expected_component):
    """Return two or three finite components as a Vector3."""
    vector = isinstance(given, (Sequence, np.ndarray, Vector2, Vector3))
    components = list(given) if vector else []
    if len(components) not in (2, 3):
        raise checks.error(name, given, expected)
    finite = [_number(f"{name}[{k}]", v, expected_component) for k, v in enumerate(components)]
    return Vector3(*finite, *[0] * (3 - len(finite)))


def _outlines_of(bodies):
    """Return grains and their `shapes` as `rcr.geometry` takes them."""
    columns, shapes = lengths(b.shape for b in bodies)
    return columns | dict(
        position=np.array([(b.state.pos[0], b.state.pos[1]) for b in bodies]),
        angle=np.array([angle_of(b.state.ori) for b in bodies])), shapes
