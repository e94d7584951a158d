"""Stable time step of springs, and the first half step of the leapfrog."""

import functools
import math

import numpy as np
from yade.minieigenHP import Vector3
from yade.wrapper import (
    Box, Facet, FrictPhys, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys,
    Law2_RcrGeom_FrictPhys_CundallStrack, NewtonIntegrator, Omega,
)  # fmt: skip

from rcr._data import checks
from rcr._yade.scene_arrays import GRAINS, lengths

O = Omega()


def critical_time_step(points=6):
    """Return the largest stable time step of a scene with springs [s]; take half of it or less.

    A body with `points` contact points at the worst places, among equal neighbours, vibrates along
    normals and tangents at most at

        ω_n² = 2 z k_n max(1/m, a²/I),   ω_s² = 2 z k_s max(1/m, R²/I),   z = `points`.

    The largest lever arm a of a normal force is the half length of an Rcr. For a polygon it is the
    largest distance, along a side, of a corner of this side from the centre.
    A clump has mass and inertia of its own, `points` contact points of each member, and a and R up
    to its furthest core end and surface. A wall, box or facet that can move has √N contact points,
    with N the number of grains, or its present number if that is larger.

    The leapfrog is stable for dt ω < 2 (√(1 + ζ²) − ζ). ζ is the damping ratio of this motion: the
    law's ratio, which belongs to one point between two bodies (ω² = 2 k_n/m), times the ratio of
    the frequencies. Tangents have no dashpot. k_n and k_s are the largest of the body's contacts.
    A body without contacts takes the stiffness that the Ip2 functor will set: the largest value
    of its MatchMaker for the body's material and any material of the bodies, else k_n = E R and
    k_s = k_n times `FrictMat.poisson`.

    YADE's PWaveTimeStep supports spheres alone. GlobalStiffnessTimeStepper counts a side-side
    contact of two points as one and ignores the dashpots; give it timestepSafetyCoefficient ≤ 0.4.

    Dense packings in the plane have 4 to 6 contact points per body. A ValueError reports a scene
    without a free grain or without Law2_RcrGeom_FrictPhys_CundallStrack, or a number outside its
    range.
    """
    points = checks.number("points", points, "a finite number of contact points > 0",
                           lambda v: v > 0)
    loops = [e for e in O.engines if isinstance(e, InteractionLoop) and not e.dead]
    laws = [law for loop in loops for law in loop.lawDispatcher.functors
            if isinstance(law, Law2_RcrGeom_FrictPhys_CundallStrack)]
    if not laws:
        raise ValueError("O.engines holds no Law2_RcrGeom_FrictPhys_CundallStrack; rigid contacts "
                         "do not bound the time step")
    damping = checks.number("Law2_RcrGeom_FrictPhys_CundallStrack.damping", laws[0].damping,
                            "a finite damping ratio ≥ 0", lambda v: v >= 0)
    stiffness_of = _stiffnesses(loops)
    steps, plates, stiffest, heaviest = [], [], 0.0, 0.0
    for body in O.bodies:
        members = [O.bodies[k] for k in body.shape.members] if body.isClump else [body]
        grain = all(isinstance(member.shape, GRAINS) for member in members)
        if body.isClumpMember or body.state.blockedDOFs == "xyzXYZ":
            continue
        if not all(member.shape and member.material for member in members):
            continue  # it touches nothing
        if grain:
            stiffness = np.max([stiffness_of(member) for member in members], axis=0)
            steps.append(_stable_step(body, members, *stiffness, points, damping))
            stiffest, heaviest = max(stiffest, *stiffness), max(heaviest, body.state.mass)
        else:
            plates.append(body)
    if not steps:
        raise ValueError("no Rcr, Sphere or RoundedPolygon is free to move: nothing bounds the "
                         "time step")
    row = math.sqrt(len(steps))
    return min(steps + [_stable_step_of_plate(plate, row, stiffest, heaviest, damping)
                        for plate in plates])


def _stiffnesses(loops):
    """Return a function that gives k_n and k_s [N/m] of a body."""
    functors = [ip2 for loop in loops for ip2 in loop.physDispatcher.functors]
    stock = [ip2 for ip2 in functors if isinstance(ip2, Ip2_FrictMat_FrictMat_FrictPhys)]
    makers = {name: [getattr(ip2, name) for ip2 in stock] for name in ("kn", "ks")}
    materials = {body.material.id for body in O.bodies if body.material and not body.isClump}
    stiffest = {}  # (k_n, k_s) by id of the body
    for i in O.interactions:
        if i.isReal and isinstance(i.phys, FrictPhys):
            for id_ in (i.id1, i.id2):
                stiffest[id_] = np.maximum((i.phys.kn, i.phys.ks), stiffest.get(id_, 0))

    @functools.cache
    def largest_match(name, material):
        """Return the largest value of the MatchMakers for a material, None without a value."""
        values = []
        for maker in filter(None, makers[name]):
            for other in materials:
                try:
                    values.append(maker(material, other))
                except ValueError:  # no match; the average of two materials has no values here
                    pass
        return max(values, default=None)

    def stiffness(body):
        _, R = _arms(body.shape)
        kn = body.material.young * R
        own = dict(kn=kn, ks=kn * body.material.poisson)
        future = []
        for name in own:
            match = largest_match(name, body.material.id)
            future.append(own[name] if match is None else match)
        return stiffest.get(body.id, future)

    return stiffness


def _stable_step(body, members, kn, ks, points, damping):
    """Return the stable time step of a grain or clump [s]; see `critical_time_step`."""
    if not (kn > 0 and ks >= 0):
        given = f"body #{body.id} has the stiffnesses kn = {kn}, ks = {ks}"
        raise ValueError(f"{given}; expected kn > 0 and ks ≥ 0 [N/m]")
    m, inertia = body.state.mass, body.state.inertia[2]
    offsets = [(member.state.pos - body.state.pos).norm() for member in members]
    a, R = (offsets + np.array([_arms(member.shape) for member in members]).T).max(axis=1)
    z = points * len(members)
    normal = math.sqrt(2 * z * kn * max(1 / m, a * a / inertia))
    shear = math.sqrt(2 * z * ks * max(1 / m, R * R / inertia))
    ratio = damping * normal / math.sqrt(2 * kn / m)
    return min(_leapfrog_step(normal, ratio), 2 / shear if shear > 0 else math.inf)


def _arms(shape):
    """Return the largest lever arms of a normal force and of a tangential one on a grain [m]."""
    grain, shapes = lengths([shape])
    half, R = grain["half_length"][0], grain["half_length"][0] + grain["cap_radius"][0]
    return (R * shapes[0].normal_arm if shapes else half), R


def _stable_step_of_plate(body, row, stiffness, grain_mass, damping):
    """Return the stable time step of a wall, box or facet [s]; see `critical_time_step`."""
    contacts = sum(i.geom.points for i in body.intrs() if i.isReal)
    z, blocked = max(row, contacts), body.state.blockedDOFs
    inverse = 0 if "x" in blocked and "y" in blocked else 1 / body.state.mass
    if "Z" not in blocked:
        inverse = max(inverse, _farthest(body.shape) ** 2 / body.state.inertia[2])
    if inverse == 0:
        return math.inf
    m = 1 / inverse
    frequency = math.sqrt(2 * z * stiffness / m)
    ratio = damping * math.sqrt(z * min(grain_mass, m) / (2 * m))
    return _leapfrog_step(frequency, ratio)


def _farthest(shape):
    """Return the largest distance of a point of a box or facet from its centre [m]."""
    if isinstance(shape, Facet):
        return max(corner.norm() for corner in shape.vertices)
    return math.hypot(shape.extents[0], shape.extents[1]) if isinstance(shape, Box) else 0.0


def _leapfrog_step(frequency, ratio):
    """Return the stable time step of an oscillation with this damping ratio [s]."""
    return 2 / frequency * (math.sqrt(1 + ratio**2) - ratio)


def half_step_start():
    """Make the present velocities those of the present time, for second-order accuracy in dt.

    YADE's leapfrog stores velocities half a step before positions. It treats the velocities that a
    script sets (rest, for example) as those of half a step ago. A body that starts from rest under
    the acceleration a then moves a t dt/2 too far, an error of first order in dt. This function
    subtracts half a step of gravity and of permanent forces (``O.forces.setPermF``, ``setPermT``)
    from the velocities, and the first step adds it again. Contact forces of the first step count
    half, too. Velocities that a script reads stay half a step behind.

    Call it once, after setting bodies, gravity, permanent forces and ``O.dt``, or again after
    setting all velocities. After steps, velocities lag half a step already: a second call would
    double the error. It does not improve impacts, whose times are known to one step, nor springs
    that are already loaded. A ValueError reports a scene without a NewtonIntegrator, or ``O.dt``
    that is not positive.
    """
    integrators = [e for e in O.engines if isinstance(e, NewtonIntegrator) and not e.dead]
    if len(integrators) != 1:
        raise ValueError(
            f"O.engines holds {len(integrators)} NewtonIntegrators that are not dead; expected one")
    if not 0 < O.dt < float("inf"):
        raise ValueError(f"O.dt = {O.dt}; expected a time step > 0 [s]")
    half, gravity = 0.5 * O.dt, integrators[0].gravity
    loaded = O.forces.getPermForceUsed()
    if loaded:
        # permF returns new values only after this; without permanent forces YADE would read
        # beyond its arrays
        O.forces.f(0, True)
    for body in O.bodies:
        state = body.state
        if body.isClumpMember or state.blockedDOFs == "xyzXYZ":
            continue
        force, torque = Vector3.Zero, Vector3.Zero
        parts = [body.id, *body.shape.members] if body.isClump else [body.id]
        for part in parts if loaded else []:
            load, arm = O.forces.permF(part), O.bodies[part].state.pos - state.pos
            force += load
            torque += O.forces.permT(part) + arm.cross(load)
        free = [name not in state.blockedDOFs for name in "xyzXYZ"]
        linear = [gravity[k] + force[k] / state.mass if free[k] else 0 for k in range(3)]
        angular = [torque[k] / state.inertia[k] if free[3 + k] else 0 for k in range(3)]
        state.vel -= half * Vector3(*linear)
        state.angVel -= half * Vector3(*angular)
