"""Scenes for the tests: engines, bodies, and results."""

import collections
import os
import subprocess
import sys
import time

import numpy as np
import rcr
from benchmarks.hard_scenes.stage import G, box, material, stadium, tilted
from yade import O
from yade.wrapper import (
    Bo1_Box_Aabb, Bo1_Facet_Aabb, Bo1_Sphere_Aabb, Bo1_Wall_Aabb, ForceResetter,
    InsertionSortCollider, InteractionLoop, MatchMaker,
    NewtonIntegrator,
)  # fmt: skip

ALL_IG2 = [name for name in dir(rcr) if name.startswith("Ig2_") and name != "Ig2_Planar_RcrGeom"]
# for closed forms: only rounding remains
EXACT = dict(tolerance=1e-14, maxIterations=3000, solver="nlgs")


def engines(gravity=(0, -G, 0), before=(), restitution=None, **solver):
    """Engines of a rigid scene; `before` comes before ContactDynamics, `solver` sets its
    attributes.
    """
    ip2 = rcr.Ip2_FrictMat_FrictMat_CdPhys()
    if restitution is not None:
        ip2.restitution = MatchMaker(algo="val", val=restitution)
    return [
        ForceResetter(),
        InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb(),
                               Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist=0.01),
        InteractionLoop(
            [getattr(rcr, name)() for name in ALL_IG2],
            [ip2],
            [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()],
        ),
        *before,
        rcr.ContactDynamics(**(solver or EXACT)),
        NewtonIntegrator(gravity=gravity, damping=0),
    ]


def build(*bodies, dt=1e-3, **options):
    """A fresh scene of these bodies; returns their ids."""
    O.reset()
    O.dt = dt
    O.engines = engines(**options)
    return [O.bodies.append(body) for body in bodies]


def inertia(a, r, density=1000.0):
    """Mass and moment of inertia of a stadium."""
    body = stadium(a, r, (0, 0), material=material(density=density))
    return body.state.mass, body.state.inertia[2]


def steps(n):
    for _ in range(n):
        O.step()


def wait_until(condition, limit=60):
    """Returns once the condition holds; fails after `limit` seconds, which only a hang takes."""
    end = time.monotonic() + limit
    while not condition():
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.005)


def velocity(body_id):
    """(v_x, v_y, ω)."""
    state = O.bodies[body_id].state
    return np.array([state.vel[0], state.vel[1], state.angVel[2]])


def point_forces(id1, id2):
    """Forces (normal, tangential) of the points of a contact, (points, 2), in order along the core.
    """
    phys = O.interactions[id1, id2].phys
    return np.array([phys.force1, phys.force2])[: phys.points]


def snapshot():
    """States of the bodies and forces on them, (n, 20), for comparisons of bits."""
    rows = []
    for b in O.bodies:
        s = b.state
        rows.append([*s.pos, *s.ori, *s.vel, *s.angVel, *O.forces.f(b.id), *O.forces.t(b.id)])
    return np.array(rows)


def contact_forces():
    """Point forces of all contacts by the ids of their bodies."""
    return {(i.id1, i.id2): (i.phys.points, *i.phys.force1, *i.phys.force2) for i in O.interactions
            if i.isReal}


def python(code, **environment):
    """Run a script in another Python with these environment variables; return the CompletedProcess.
    """
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120,
                          env={**os.environ, **environment})


ClosedPoint = collections.namedtuple("ClosedPoint", "ids force")


def closed_points():
    """Contact points that carry a force: ids of the bodies, normal force [N]."""
    return [
        ClosedPoint((i.id1, i.id2), force[0])
        for i in O.interactions
        if i.isReal
        for force in (i.phys.force1, i.phys.force2)[: i.phys.points]
        if force[0] > 0
    ]
