"""Scenes for the tests: engines, bodies, and results."""

import collections
import os
import subprocess
import sys
import time

import numpy as np
import pytest
import rcr
import yade.utils
from benchmarks.hard_scenes.stage import G, box, material, solver, stadium, tilted
from yade import O
from yade.minieigenHP import Matrix3
from yade.wrapper import (
    Bo1_Box_Aabb, Bo1_Facet_Aabb, Bo1_Sphere_Aabb, Bo1_Wall_Aabb, ForceResetter,
    InsertionSortCollider, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, MatchMaker,
    NewtonIntegrator,
)  # fmt: skip

ALL_IG2 = [name for name in dir(rcr) if name.startswith("Ig2_") and name != "Ig2_Planar_RcrGeom"]
# for closed forms: only rounding remains
EXACT = dict(tolerance=1e-14, maxIterations=3000, solver="nlgs")


def engines(gravity=(0, -G, 0), before=(), restitution=None, law="rigid", **options):
    """`before` precedes the solver; `options` set attributes of ContactDynamics or smooth law."""
    if law == "rigid":
        ip2, law2 = rcr.Ip2_FrictMat_FrictMat_CdPhys(), rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()
        before = [*before, rcr.ContactDynamics(**(options or EXACT))]
    else:
        ip2 = Ip2_FrictMat_FrictMat_FrictPhys()
        law2 = rcr.Law2_RcrGeom_FrictPhys_CundallStrack(**options)
    if restitution is not None:
        ip2.restitution = MatchMaker(algo="val", val=restitution)
    return [
        ForceResetter(),
        InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb(),
                               Bo1_Sphere_Aabb(), Bo1_Facet_Aabb()], verletDist=0.01),
        InteractionLoop([getattr(rcr, name)() for name in ALL_IG2], [ip2], [law2]),
        *before,
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
    """Forces (normal, tangential) of a contact's points, (points, 2), in order along the core."""
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
    """Run code in another Python with these environment variables: CompletedProcess."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120,
                          env={**os.environ, **environment})


def assert_refused(match, moved=False):
    """Take a step; it raises a ValueError with these words, and the scene stays as it was."""
    before = snapshot()[:, :13]
    with pytest.raises(ValueError, match=match):
        O.step()
    assert moved or np.array_equal(snapshot()[:, :13], before, equal_nan=True)


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


def smooth(*bodies):
    """A grain on a floor, or these bodies, under the smooth law."""
    rough = material()
    rough.young, rough.poisson = 1e8, 0.5
    return build(*bodies or (rcr.wall("y", 0, material=rough),
                             stadium(0.2, 0.1, (0, 0.1), material=rough)), dt=1e-5, law="smooth")


def periodic_scene(law, *bodies, size=2.0, gravity=(0, 0, 0), dt=1e-3, periodic=True, **options):
    O.reset()
    O.dt = dt
    O.periodic = periodic
    if periodic:
        O.cell.setBox(size, size, size)
    O.engines = engines(gravity=gravity, law=law, **options)
    return [O.bodies.append(b) for b in bodies]


def shrinking_cell():
    """Take 100 steps of a sheared periodic cell of 25 rods that shrinks until they touch."""
    rng = np.random.default_rng(0)
    grains = [rcr.particle((0.2 * (k % 5) + 0.1, 0.2 * (k // 5) + 0.1), rng.uniform(0.07, 0.098),
                           0.5, rng.uniform(0, 3), material(0.3)) for k in range(25)]
    periodic_scene("rigid", *grains, size=1.0, dt=1e-3, tolerance=1e-8)
    O.cell.velGrad = Matrix3(-4, 0.5, 0, 0, -4, 0, 0, 0, 0)
    steps(100)


def pressed_box(make=build, friction=0.3, **options):
    """20 grains between walls of this friction; a stress pushes two of them."""
    rng = np.random.default_rng(12)
    rough, plate = material(0.3), material(friction)
    walls = [rcr.wall(axis, 0, material=plate) for axis in "xy"]
    walls += [rcr.mobile_wall(axis, end, mass=50, material=plate)
              for axis, end in (("x", 1.0), ("y", 0.8))]
    grains = [rcr.particle((0.12 + 0.19 * (k % 5), 0.1 + 0.19 * (k // 5)), 0.08,
                           rng.uniform(0, 0.8), rng.uniform(0, 3), rough) for k in range(20)]
    press = [rcr.WallStress(wall=2, start=1, end=3, stress=-1e3),
             rcr.WallStress(wall=3, start=0, end=2, stress=-1e3)]
    # the exact tier solves 1e-6
    make(*walls, *grains, gravity=(0, 0, 0), before=press, **options or dict(tolerance=1e-6))


def heap(seed=0):
    """Grains, discs, a clump at rest on a wall, a box, a facet, a fixed grain; ids by kind."""
    rng = np.random.default_rng(seed)
    rough, smooth = material(0.5), material(0.1)
    fixed = [
        rcr.wall("y", 0, sense=+1, material=rough),
        yade.utils.box((-0.1, 0.2, 0), (0.1, 0.3, 0.1), fixed=True, material=smooth),
        yade.utils.facet([(0.5, -0.5, -2), (0.5, -0.5, 2), (0.9, 3, 0)], material=rough),
        rcr.particle((0.25, 0.02), 0.04, 0.5, fixed=True, material=rough),
    ]
    grains = [
        (rcr.disc if k % 3 == 0 else rcr.particle)((0.06 + 0.09 * (k % 4), 0.1 + 0.09 * (k // 4)),
                                                   0.04, material=rough if k % 2 else smooth,
                                                  **({} if k % 3 == 0
                                                     else dict(eta=0.5, angle=rng.uniform(0, 3))))
                                                  for k in range(16)
    ]  # fmt: skip
    ids = build(*fixed, *grains, dt=5e-4, tolerance=1e-10)
    clump, members = rcr.clump([rcr.particle((0.15 + x, 0.6), 0.06, 0.6, angle, rough)
                                for x, angle in ((0, 0.3), (0.03, 1.8))])
    O.trackEnergy = False
    return dict(obstacles=ids[:4], grains=ids[4:], clump=clump, members=members)
