"""Scenes: bodies with the right mass and blocked degrees of freedom, walls, and the contact network of the present step.

Everything is in the plane z = 0 and per unit depth: masses in kg a metre of depth, forces in N a metre.
"""

import math
import numbers
import os
from collections.abc import Sequence

import numpy as np
from yade import utils
from yade.wrapper import (
    Body, ContactDynamics, FrictMat, FrictPhys, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, Law2_RcrGeom_FrictPhys_CundallStrack, Omega, Rcr, Sphere, Wall,
)  # fmt: skip
from yade.minieigenHP import Quaternion, Vector2, Vector3

from rcr import _kernel, _plugin, _outlines as outlines, problems
from rcr.frame import Frame
from rcr.network import BOTTOM, LEFT, OTHER, RIGHT, TOP, WALL, Network

O = Omega()


def _number(name, value, wanted, fits):
    """`value` as a float, or ValueError with what was given and what is wanted."""
    if not isinstance(value, numbers.Real) or not math.isfinite(value) or not fits(value):
        raise ValueError(f"{name} = {value!r}; wanted {wanted}")
    return float(value)


def _material(material):
    """The material itself, from an id or a label too; YADE's default if there is none yet."""
    if material == -1 and len(O.materials) == 0:
        O.materials.append(utils.defaultMaterial())
    material = O.materials[material] if isinstance(material, (int, str)) else material
    if not isinstance(material, FrictMat):
        raise ValueError(f"material = {material!r}; wanted a FrictMat, or the id or label of one")
    return material


def _place(name, given):
    """A place of two or three finite coordinates as a Vector3."""
    coordinates = list(given) if isinstance(given, (Sequence, np.ndarray, Vector2, Vector3)) else None
    if coordinates is None or len(coordinates) not in (2, 3):
        raise ValueError(f"{name} = {given!r}; wanted two or three coordinates (x, y) or (x, y, z) [m]")
    return Vector3(*[_number(f"{name}[{k}]", value, "a finite coordinate [m]", lambda v: True) for k, value in enumerate(coordinates)], *[0] * (3 - len(coordinates)))


def _velocity(velocity):
    components = list(velocity)
    if len(components) not in (2, 3) or (len(components) == 3 and components[2] != 0):
        raise ValueError(f"velocity = {velocity!r}; wanted two components (v_x, v_y) in the plane [m/s]")
    return Vector3(*[_number(f"velocity[{k}]", value, "a finite velocity [m/s]", lambda v: True) for k, value in enumerate(components[:2])], 0)


def _grain(shape, center, angle, material, area, polar_moment, *, fixed, color, mask, velocity, angular_velocity):
    """A body in the plane with mass and inertia per unit depth."""
    material = _material(material)
    density = _number("material.density", material.density, "a finite density > 0 [kg/m³]", lambda v: v > 0)
    body = Body(shape=shape, material=material)
    state = body.state
    state.mass = density * area
    state.inertia = Vector3(1, 1, 1) * (density * polar_moment)  # only the moment about z acts; YADE wants all three > 0
    state.pos = state.refPos = _place("center", center)
    state.ori = state.refOri = Quaternion(Vector3(0, 0, 1), _number("angle", angle, "a finite angle [rad]", lambda v: True))
    state.vel = _velocity(velocity)
    state.angVel = Vector3(0, 0, _number("angular_velocity", angular_velocity, "a finite angular velocity [1/s]", lambda v: True))
    state.blockedDOFs = "xyzXYZ" if fixed else "zXY"
    shape.color = Vector3(*color) if color is not None else utils.randomColor()
    body.mask = mask
    return body


def particle(center, R, eta, angle=0, material=-1, fixed=False, color=None, mask=1, velocity=(0, 0), angular_velocity=0):
    """Body with the shape of a rounded-cap rectangle.

    Parameters
    ----------
    center : (float, float) or (float, float, float)
        Centre of mass [m]; all grains of a scene lie at one z, 0 by default.
    R : float
        Radius of the circumscribed circle [m], > 0.
    eta : float
        Elongation (R − R')/R [-], 0 ≤ eta < 1; 0 is a disc.
    angle : float
        Angle of the long axis to x [rad].
    material : FrictMat, int or str
        Material, or its id or label in O.materials; its density [kg/m³] sets the mass. −1, the default, is the last one of O.materials,
        or where there is none YADE's own: density 1000 kg/m³, friction angle 0.5.
    fixed : bool
        Block all degrees of freedom; else the body moves in the plane.
    color : (float, float, float) or None
        Red, green, blue, 0 to 1; None: a random one.
    mask : int
        Group mask, as ``Body.mask``.
    velocity : (float, float)
        [m/s]
    angular_velocity : float
        About z [1/s].

    Returns
    -------
    Body
        To be given to ``O.bodies.append``.

    Raises
    ------
    ValueError
        If a number is not finite or out of its range.
    """
    R = _number("R", R, "a finite radius of the circumscribed circle > 0 [m]", lambda v: v > 0)
    eta = _number("eta", eta, "an elongation 0 ≤ eta < 1", lambda v: 0 <= v < 1)
    shape = Rcr(capRadius=(1 - eta) * R, halfLength=eta * R)
    area, moment = _kernel.area(shape.halfLength, shape.capRadius), _kernel.polar_moment(shape.halfLength, shape.capRadius)
    return _grain(shape, center, angle, material, area, moment, fixed=fixed, color=color, mask=mask, velocity=velocity, angular_velocity=angular_velocity)


def disc(center, R, material=-1, angle=0, fixed=False, color=None, mask=1, velocity=(0, 0), angular_velocity=0):
    """YADE `Sphere` in the plane with the mass π R² ρ and the moment of inertia m R²/2 of a disc, per unit depth.

    ``utils.sphere`` gives the mass of a ball, which does not fit to those of `particle`. Parameters, errors and the returned
    body are those of `particle`, without the elongation.
    """
    R = _number("R", R, "a finite radius > 0 [m]", lambda v: v > 0)
    keywords = dict(fixed=fixed, color=color, mask=mask, velocity=velocity, angular_velocity=angular_velocity)
    return _grain(Sphere(radius=R), center, angle, material, math.pi * R**2, math.pi * R**4 / 2, **keywords)


def _outlines(bodies):
    """Grains as `rcr._outlines` takes them."""
    long = [isinstance(b.shape, Rcr) for b in bodies]
    return dict(
        position=np.array([(b.state.pos[0], b.state.pos[1]) for b in bodies]),
        angle=np.array([2 * math.atan2(b.state.ori[2], b.state.ori[3]) for b in bodies]),
        half_length=np.array([b.shape.halfLength if is_long else 0.0 for b, is_long in zip(bodies, long)]),
        cap_radius=np.array([b.shape.capRadius if is_long else b.shape.radius for b, is_long in zip(bodies, long)]),
    )


def clump(members, mass=None, inertia=None):
    """Join `Rcr` and `Sphere` bodies into one that moves rigidly in the plane, and append it to the scene.

    YADE's own ``O.bodies.appendClumped`` makes three-dimensional bodies: with the mass of balls, and turned to principal axes that
    may lie out of the plane.

    Parameters
    ----------
    members : list of Body
        Of `particle` and `disc`, not appended yet; they may overlap. All have the density of the first one's material.
    mass : float or None
        [kg], per unit depth; None: density × area of the union of the members.
    inertia : float or None
        Moment about z through the centre of the union [kg m²]; None: that of the union, for this mass.

    Returns
    -------
    int, list of int
        Ids of the clump and of its members. Velocities are set on the clump: ``O.bodies[id].state.vel``.

    Raises
    ------
    ValueError
        If there are no members, one has another shape, or a number is out of its range.
    """
    members = list(members)
    if not members or not all(isinstance(b, Body) and isinstance(b.shape, (Rcr, Sphere)) for b in members):
        raise ValueError(f"members = {members!r}; wanted at least one body of rcr.particle or rcr.disc")
    if len({id(b) for b in members}) < len(members):
        raise ValueError("members holds a body twice; wanted each once")
    area, (x, y), polar_moment = outlines.union(_outlines(members))
    mass = members[0].material.density * area if mass is None else _number("mass", mass, "a finite mass > 0 [kg]", lambda v: v > 0)
    inertia = mass / area * polar_moment if inertia is None else _number("inertia", inertia, "a finite moment of inertia > 0 [kg m²]", lambda v: v > 0)
    ids = O.bodies.append(members)
    return _plugin.planar_clump(ids, x, y, mass, inertia), ids


def _axis(axis):
    """0 or 1 of an axis that is named "x" or "y", or has its number as in YADE."""
    for k, name in enumerate("xy"):
        if axis == name or (isinstance(axis, numbers.Integral) and not isinstance(axis, bool) and axis == k):
            return k
    raise ValueError(f"axis = {axis!r}; wanted 'x' or 'y' (or 0 or 1), the axis of the wall's normal")


def wall(axis, position, sense=0, velocity=0, material=-1):
    """Infinite wall whose motion is prescribed.

    Parameters
    ----------
    axis : str or int
        Axis of its normal: 'y' (or 1) for a floor or a lid, 'x' (or 0) for a wall at a side.
    position : float
        Coordinate along that axis [m].
    sense : int
        Side that acts: +1, −1, or 0 for both.
    velocity : float
        Prescribed velocity along the axis [m/s]; change it later by ``body.state.vel``.
    material : FrictMat, int or str
        As of `particle`.

    Returns
    -------
    Body

    Raises
    ------
    ValueError
        If the axis or the sense is none of these, or a number is not finite.
    """
    k = _axis(axis)
    if sense not in (-1, 0, 1):
        raise ValueError(f"sense = {sense!r}; wanted +1, −1, or 0 for both sides")
    body = utils.wall(_number("position", position, "a finite coordinate [m]", lambda v: True), k, sense=sense, material=_material(material))
    body.state.vel[k] = _number("velocity", velocity, "a finite velocity [m/s]", lambda v: True)
    return body


def mobile_wall(axis, position, mass, sense=0, material=-1):
    """Wall with one degree of freedom, along its normal: forces move it (``WallStress``, ``O.forces.setPermF``).

    Parameters are those of `wall`, with the mass [kg] in the place of the velocity.
    """
    body = wall(axis, position, sense=sense, material=material)
    body.state.mass = _number("mass", mass, "a finite mass > 0 [kg]", lambda v: v > 0)
    body.state.blockedDOFs = "yzXYZ" if body.shape.axis == 0 else "xzXYZ"
    return body


def segment(start, end, material=-1):
    """Fixed `Facet` that cuts the plane in the straight line from one point to another; both sides act.

    ``utils.facet`` takes the corners of a triangle in space, which cuts the plane in a part of its edge only.

    Parameters
    ----------
    start, end : (float, float) or (float, float, float)
        Ends of the line [m], both at the z of the grains.
    material : FrictMat, int or str
        As of `particle`.

    Returns
    -------
    Body

    Raises
    ------
    ValueError
        If a coordinate is not finite, the ends have different z, or they are one point.
    """
    start, end = _place("start", start), _place("end", end)
    length = (end - start).norm()
    if not length > 0 or start[2] != end[2]:
        raise ValueError(f"start = {tuple(start)}, end = {tuple(end)}; wanted two points at one z [m]")
    middle, out = (start + end) / 2, Vector3(0, 0, 0.1 * length)
    corners = (2 * start - middle - out, 2 * end - middle - out, middle + out)  # the ends are the middles of two edges
    return utils.facet(corners, material=_material(material))


def critical_time_step(points=6):
    """Largest stable time step of a scene with the smooth law [s]; take half of it or less.

    A body on which `points` contact points press at the worst place, its neighbours being like it, vibrates at most at

        ω_n² = 2 z k_n max(1/m, a²/I),   ω_s² = 2 z k_s max(1/m, R²/I),   z = `points`,

    along the normals and the tangents; the leapfrog is stable for dt ω < 2 (√(1 + ζ²) − ζ), where ζ is the damping ratio of that
    motion: the one of the law, which is of one point and two bodies (ω² = 2 k_n/m), times the ratio of the ω; tangents have no
    dashpot. k_n and k_s are those of the body's contacts; of a body without any, those that the Ip2 functor is
    going to give it: its MatchMaker of the kind "val", else k_n = E R and k_s = k_n times `FrictMat.poisson`.

    YADE's PWaveTimeStep knows spheres only. Its GlobalStiffnessTimeStepper works, but counts a side-side contact of two points
    as one and knows no dashpot of ours: give it timestepSafetyCoefficient ≤ 0.4.

    Parameters
    ----------
    points : int
        Contact points on one body; dense packings in the plane have 4 to 6.

    Returns
    -------
    float
        Time step [s]; per unit depth, k in N/m.

    Raises
    ------
    ValueError
        If no grain is free, the scene has no Law2_RcrGeom_FrictPhys_CundallStrack, or a stiffness is not > 0.
    """
    loops = [engine for engine in O.engines if isinstance(engine, InteractionLoop) and not engine.dead]
    laws = [law for loop in loops for law in loop.lawDispatcher.functors if isinstance(law, Law2_RcrGeom_FrictPhys_CundallStrack)]
    if not laws:
        raise ValueError("O.engines holds no Law2_RcrGeom_FrictPhys_CundallStrack; rigid contacts do not bound the time step")
    stock = [ip2 for loop in loops for ip2 in loop.physDispatcher.functors if isinstance(ip2, Ip2_FrictMat_FrictMat_FrictPhys)]
    given = lambda name: next((maker.val for ip2 in stock if (maker := getattr(ip2, name)) and maker.algo == "val"), None)
    stiffness = {}  # a body: its stiffest contact
    for i in O.interactions:
        if i.isReal and isinstance(i.phys, FrictPhys):
            for body in (i.id1, i.id2):
                stiffness[body] = np.maximum((i.phys.kn, i.phys.ks), stiffness.get(body, 0))
    steps = []
    for body in O.bodies:
        if not isinstance(body.shape, (Rcr, Sphere)) or body.state.blockedDOFs == "xyzXYZ":
            continue
        m, inertia, a = body.state.mass, body.state.inertia[2], getattr(body.shape, "halfLength", 0)
        R = a + body.shape.capRadius if isinstance(body.shape, Rcr) else body.shape.radius
        of_material = body.material.young * R
        ip2 = (of_material if given("kn") is None else given("kn"), of_material * body.material.poisson if given("ks") is None else given("ks"))
        kn, ks = stiffness.get(body.id, ip2)
        if not (kn > 0 and ks >= 0):
            raise ValueError(f"body #{body.id} has the stiffnesses kn = {kn}, ks = {ks}; wanted > 0 and ≥ 0 [N/m]")
        normal = math.sqrt(2 * points * kn * max(1 / m, a * a / inertia))
        shear = math.sqrt(2 * points * ks * max(1 / m, R * R / inertia))
        ratio = laws[0].damping * normal / math.sqrt(2 * kn / m)
        steps.append(min(2 / normal * (math.sqrt(1 + ratio**2) - ratio), 2 / shear if shear > 0 else math.inf))
    if not steps:
        raise ValueError("no Rcr and no Sphere is free to move: nothing bounds the time step")
    return min(steps)


def save_problem(engine, path):
    """Write the contact problem of the last step, from the warm start that it had; the method ``ContactDynamics.save``.

    Parameters
    ----------
    path : str
        ``.h5`` for FCLIB (W, q, µ; for other solvers) or ``.npz`` (with the bodies; see `rcr.problems`).

    Raises
    ------
    ValueError
        For another suffix, or if no step has been made since the scene was made or loaded.
    """
    raw = engine._problem()
    column = lambda name, width, kind=np.float64: np.frombuffer(raw[name], kind).reshape(-1, width)
    inverse_mass, points = column("inverse_mass", 3), column("points", 8)
    if not len(inverse_mass):
        raise ValueError("ContactDynamics has solved no step yet: make one, O.step(), before save()")
    problems.save(
        path,
        problems.BodyProblem(
            inverse_mass=inverse_mass,
            free_velocity=column("free_velocity", 3),
            bodies=column("bodies", 2, np.int32),
            normal=points[:, 0:2],
            arm1=points[:, 2:4],
            arm2=points[:, 4:6],
            bias=points[:, 6],
            friction=points[:, 7],
            impulse=column("impulse", 2),
        ),
    )


def save_not_finite():
    """Write the problem of the last step, whose solution is not finite, into the current folder; returns a sentence for the exception."""
    engine = next(e for e in O.engines if isinstance(e, ContactDynamics))
    path = os.path.abspath(f"not-finite-{O.iter}.npz")
    try:
        save_problem(engine, path)
    except (OSError, ValueError) as error:
        return f"Its problem cannot be saved: {error}."
    return f"Its problem is in {path}; rcr.solve({path!r}, warm=True) replays it."


def contact_network(walls=None, volume=None, **attributes):
    """Force-bearing contacts of the step that has just been made, one row a pair; of any scene, under any law.

    Grains are the free and clumped `Rcr` and `Sphere` (discs). Walls, boxes, facets and grains whose motion is prescribed are
    obstacles: always body 2, with a negative id, and contacts among them are left out. Positions, branch vectors and normals are those
    that the forces belong to: a step moves the bodies after its forces.

    Parameters
    ----------
    walls : (int, int, int, int), optional
        Ids of the left, bottom, right and top wall of a box, which get the ids −1, −2, −3, −4 in the network. Any other obstacle, the
        body #k of YADE, has the id −5 − k.
    volume : float, optional
        Area of the region that the stress is the mean of [m²]; by default that of the periodic cell, or of the box of four walls. Where
        there is neither, `Network.stress` asks for it; ratios of stresses, fabric and forces need none.
    **attributes
        Stored with the network: ``strain``, ``eta``, ``friction``, ``seed``.

    Returns
    -------
    Network

    Raises
    ------
    ValueError
        If no grain is free, the volume is not > 0, `walls` are not four walls of a box, or an attribute is what the scene tells.
    """
    own = {"time", "dt", "cell", "cell_velocity"} & attributes.keys()
    if own:
        raise ValueError(f"contact_network({', '.join(sorted(own))}=…): the network takes it from the scene; wanted attributes of your own")
    frame = Frame.of_scene()
    free = ~frame.grains["fixed"]
    if not free.any():
        raise ValueError("the scene holds no free Rcr and no free Sphere: there is no network of grains")
    grains = {name: column[free] for name, column in frame.grains.items()}
    codes = {}
    if walls is not None:
        codes, box_area = _box(walls)
        volume = box_area if volume is None else volume
    if frame.cell is not None:
        attributes |= dict(cell=frame.cell, cell_velocity=frame.cell_velocity)
        volume = abs(np.linalg.det(frame.cell)) if volume is None else volume
    if volume is not None:
        attributes |= dict(volume=_number("volume", volume, "the area of the region > 0 [m²]", lambda v: v > 0))
    return Network(
        particles={name: grains[name] for name in ("id", "half_length", "cap_radius", "mass", "velocity", "clump")}
        | dict(
            position=grains["position"] - O.dt * grains["velocity"][:, :2],
            angle=grains["angle"] - O.dt * grains["velocity"][:, 2],
            center=frame.centers[free],
            R=grains["half_length"] + grains["cap_radius"],
        ),
        contacts=_pairs(frame, codes),
        attributes=dict(time=O.time, dt=O.dt, **attributes),
    )


def _pairs(frame, codes):
    """Columns of `Network.contacts`: contacts of a `Frame` that carry a force, turned so that an obstacle is body 2, by ids."""
    contacts = frame.contacts
    fixed = np.append(frame.grains["fixed"], True)  # row −1: no grain
    first, second = (fixed[frame.rows(contacts[body])] for body in ("body1", "body2"))
    bearing = (frame.normal_force() > 0) & ~(first & second)
    turned, at_obstacle = first[bearing], (first | second)[bearing]
    c = {name: column[bearing] for name, column in contacts.items()}
    swap = lambda one, two: np.where(turned.reshape(-1, *[1] * (one.ndim - 1)), two, one)
    sign = np.where(turned, -1, 1)[:, None]
    other = swap(c["body2"], c["body1"])
    arm1, arm2 = swap(c["arm1"], c["arm2"]), swap(c["arm2"], c["arm1"])
    columns = dict(
        body1=swap(c["body1"], c["body2"]),
        body2=np.where(at_obstacle, [codes.get(int(id_), OTHER - int(id_)) for id_ in other], other),
        type=np.where(at_obstacle, WALL, c["type"]),
        points=c["points"],
        normal=sign * c["normal"],
        branch=np.where(at_obstacle[:, None], arm1, arm1 - arm2),
        force=sign * c["force"],
        position=frame.centers[frame.rows(swap(c["body1"], c["body2"]))] + arm1,  # beside body 1, also across the edge of a cell
        friction=c["friction"],
    )
    order = np.lexsort((columns["body2"], columns["body1"]))  # YADE's order changes when a scene is reloaded
    return {name: column[order] for name, column in columns.items()}


def _box(walls):
    """Codes of the four walls of a box by their ids, and the area between them when the forces acted [m²]."""
    ids = [int(w) for w in walls] if np.shape(walls) == (4,) else []
    bodies = [O.bodies[k] if 0 <= k < len(O.bodies) else None for k in ids]
    if [getattr(getattr(b, "shape", None), "axis", None) for b in bodies] != [0, 1, 0, 1]:
        raise ValueError(f"walls = {walls!r}; wanted the ids of the left, bottom, right and top Wall of a box, or None")
    left, bottom, right, top = (b.state.pos - O.dt * b.state.vel for b in bodies)
    if left[0] >= right[0] or bottom[1] >= top[1]:
        raise ValueError(f"walls = {walls!r} are not in the order left, bottom, right, top: they stand at x = {left[0]:g}, y = {bottom[1]:g}, x = {right[0]:g}, y = {top[1]:g}")
    return dict(zip(ids, (LEFT, BOTTOM, RIGHT, TOP))), (right[0] - left[0]) * (top[1] - bottom[1])
