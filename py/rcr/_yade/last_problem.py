"""The contact problem of the last step of a ContactDynamics, and its files. Needs YADE."""

import os

import numpy as np
from yade.wrapper import ContactDynamics, Omega

from rcr import problems

O = Omega()


def last_problem(engine):
    """Return the contact problem of the last step of a ContactDynamics, with its warm start."""
    raw = engine._problem()
    column = lambda name, width, kind=np.float64: np.frombuffer(raw[name], kind).reshape(-1, width)
    inverse_mass, points = column("inverse_mass", 3), column("points", 8)
    if not len(inverse_mass):
        raise ValueError("ContactDynamics has solved no step yet; call O.step() before save()")
    return problems.BodyProblem(
        inverse_mass=inverse_mass, free_velocity=column("free_velocity", 3),
        bodies=column("bodies", 2, np.int32), normal=points[:, 0:2], arm1=points[:, 2:4],
        arm2=points[:, 4:6], bias=points[:, 6], friction=points[:, 7], impulse=column("impulse", 2))


def save_problem(engine, path):
    """Save the contact problem of the last step with its warm start: ``ContactDynamics.save``.

    `path` ends in ``.h5`` for FCLIB (W, q, µ) or ``.npz`` (with the bodies); see `rcr.problems`. A
    ValueError reports another suffix, no step since the scene was made or loaded, or contacts
    across the boundary of a deforming periodic cell.
    """
    problems.save(path, last_problem(engine))


def save_not_finite():
    """Save the last problem, whose solution is not finite; return a sentence for the exception."""
    engine = next(e for e in O.engines if isinstance(e, ContactDynamics))
    path = os.path.abspath(f"not-finite-{O.iter}.npz")
    try:
        save_problem(engine, path)
    except (OSError, ValueError) as error:
        return f"Its problem cannot be saved: {error}."
    return f"Its problem is in {path}; rcr.solve({path!r}, warm=True) replays it."


def _grain(
    shape, area, polar_moment, center, angle, material, fixed, color, mask, velocity,
    angular_velocity,
):  # fmt: skip
    """Return a body in the plane with mass and inertia per unit depth."""
    material = _material(material)
    expected = "a finite density > 0 [kg/m³]"
    density = _number("material.density", material.density, expected, _positive)
    body = Body(shape=shape, material=material)
    state = body.state
    state.mass = density * area
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
    shape.color = Vector3(*color) if color is not None else utils.randomColor()
    body.mask = mask
    return body


def _positive(value):
    return value > 0


def _material(material):
    """Return a material from itself, its id or its label."""
    if material == -1 and len(O.materials) == 0:
        O.materials.append(utils.defaultMaterial())
    material = O.materials[material] if isinstance(material, (int, str)) else material
    if not isinstance(material, FrictMat):
        raise checks.error("material", material, "a FrictMat, or the id or label of one")
    return material


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
    """Return grains as `rcr._pictures.outlines` takes them."""
    half_length, cap_radius = np.array([lengths(b.shape) for b in bodies]).T.copy()
    return dict(position=np.array([(b.state.pos[0], b.state.pos[1]) for b in bodies]),
                angle=np.array([angle_of(b.state.ori) for b in bodies]),
                half_length=half_length, cap_radius=cap_radius)
