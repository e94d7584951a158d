"""Scenes for the tests: engines, bodies, and results."""

import functools
import os
import sys

import common
import numpy as np
import pytest
import yade.utils  # before rcr, which loads its plugin into it
import rcr
from bodies import (G, box, kinetic, material, open_box, solver, stadium, tilted,
                    twist as velocity)  # noqa: F401
from common import refused, wait_until, warns  # noqa: F401: for the tests
from yade import O
from yade import wrapper as w
from yade.minieigenHP import Matrix3

LAWS = pytest.mark.parametrize("law", ["rigid", "smooth"])
ALL_IG2 = [name for name in dir(rcr) if name.startswith("Ig2_") and name != "Ig2_Planar_RcrGeom"]
KN, KS = 1e6, 8e5  # of springs [N/m] a point
# for closed forms: only rounding remains
EXACT = dict(tolerance=1e-14, maxIterations=3000, solver="nlgs")


def engines(gravity=(0, -G, 0), before=(), restitution=None, law="rigid", **options):
    """`before` precedes the solver; `options` set attributes of ContactDynamics or springs."""
    if law == "rigid":
        ip2, law2 = rcr.Ip2_FrictMat_FrictMat_CdPhys(), rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()
        before = [*before, rcr.ContactDynamics(**(options or EXACT))]
    else:
        ip2 = w.Ip2_FrictMat_FrictMat_FrictPhys()
        law2 = rcr.Law2_RcrGeom_FrictPhys_CundallStrack(**options)
    if restitution is not None:
        ip2.restitution = w.MatchMaker(algo="val", val=restitution)
    boxes = w.Bo1_Wall_Aabb(), w.Bo1_Box_Aabb(), w.Bo1_Sphere_Aabb(), w.Bo1_Facet_Aabb()
    return [w.ForceResetter(),
            w.InsertionSortCollider(
                [rcr.Bo1_Rcr_Aabb(), rcr.Bo1_RoundedPolygon_Aabb(), *boxes], verletDist=0.01),
            w.InteractionLoop([getattr(rcr, name)() for name in ALL_IG2], [ip2], [law2]),
            *before, w.NewtonIntegrator(gravity=gravity, damping=0)]


def build(*bodies, dt=1e-3, cell=None, **options):
    """A fresh scene of these bodies, in a cell of this side [m] if any; returns their ids."""
    O.reset()
    O.dt = dt
    if cell:
        O.periodic = True
        O.cell.setBox(cell, cell, cell)
    O.engines = engines(**options)
    return [O.bodies.append(body) for body in bodies]


weightless = functools.partial(build, gravity=(0, 0, 0))


def springs(*bodies, share=0.02, local_damping=0.0, **options):
    """`build` with springs KN and KS, and a share of the critical time step; returns the ids."""
    ids = build(*bodies, law="smooth", **options)
    prescribe("kn", KN)
    prescribe("ks", KS)
    O.engines[-1].damping = local_damping
    O.dt = share * rcr.critical_time_step()
    return ids


def grain_on_floor(a, friction=0.5, height=0.1, angle=0, make=build, **options):
    """A grain (half length a, cap radius 0.1 m) at `height` [m], by default on a floor; its id."""
    rough = material(friction)
    return make(rcr.wall("y", 0, material=rough),
                stadium(a, 0.1, (0, height), angle, material=rough), **options)[1]


def springy(friction=0.5, young=1e7, poisson=0.5):
    """A material for both laws, whose springs have the stiffness `young` [Pa]."""
    made = material(friction)
    made.young, made.poisson = young, poisson
    return made


def walls(rough, x=(), y=()):
    """Walls at these places that bear from inside only: the first from +, the second from −."""
    return [rcr.wall(axis, at, sense, material=rough) for axis, places in (("x", x), ("y", y))
            for at, sense in zip(places, (1, -1))]


def set_state(body=1, **values):
    for name, value in values.items():
        setattr(O.bodies[body].state, name, value)


def prescribe(name, value):
    """Give all new contacts this stiffness, restitution or friction angle."""
    setattr(O.engines[2].physDispatcher.functors[0], name, w.MatchMaker(algo="val", val=value))


FLOORS = {
    "Wall": lambda m: rcr.wall("y", 0, material=m),
    "Box": lambda m: yade.utils.box((0, -0.5, 0), (9, 0.5, 1), material=m, fixed=True),
    "Facet": lambda m: yade.utils.facet([(-9, 0, -1), (9, 0, -1), (0, 0, 1)], material=m),
    "Rcr": lambda m: rcr.particle((0, -0.1), 5, 0.98, fixed=True, material=m),
    "RoundedPolygon": lambda m: rcr.polygon(
        (0, -0.5), [(9, 0.4), (-9, 0.4), (-9, -0.4), (9, -0.4)], 0.1, fixed=True, material=m),
}


def without(kind):
    O.engines = [e for e in O.engines if not isinstance(e, kind)]


def exchange(new):
    """Put this engine in the place of the engine of its class."""
    O.engines = [new if isinstance(e, type(new)) else e for e in O.engines]


def calls(function, period, **options):
    """A PyRunner that calls a function of a module every `period` steps."""
    module, name = function.__module__, function.__name__
    return w.PyRunner(command=f"import {module}; {module}.{name}()", iterPeriod=period, **options)


def insert(place, *new):
    """Insert engines at this place of O.engines; at 3 they follow the InteractionLoop."""
    O.engines = [*O.engines[:place], *new, *O.engines[place:]]


def resting(law="rigid"):
    """A grain (1) at rest on a wall (0)."""
    grain_on_floor(0.2, law=law, dt=1e-3 if law == "rigid" else 1e-5)


def assert_reload_changes_nothing(path, run):
    """After a reload, `run()` returns what it returned before."""
    O.save(str(path), quiet=True)
    first = run()
    O.load(str(path), quiet=True)
    assert run() == first


def inertia(a, r, density=1000.0):
    body = stadium(a, r, (0, 0), material=material(density=density))
    return body.state.mass, body.state.inertia[2]


def steps(n):
    for _ in range(n):
        O.step()


def iterations(n):
    """Iterations of each of the next n steps."""
    return [(O.step(), solver().iterations)[1] for _ in range(n)]


def point_forces(id1, id2):
    """Forces (normal, tangential) of a contact's points, (points, 2), in order along the core."""
    phys = O.interactions[id1, id2].phys
    return np.array([phys.force1, phys.force2])[: phys.points]


def snapshot():
    """Positions, orientations, velocities, forces and torques of the bodies, (n, 19)."""
    rows = []
    for b in O.bodies:
        s = b.state
        rows.append([*s.pos, *s.ori, *s.vel, *s.angVel, *O.forces.f(b.id), *O.forces.t(b.id)])
    return np.array(rows)


def contact_forces():
    """Point forces of all contacts by the ids of their bodies."""
    return {(i.id1, i.id2): (i.phys.points, *i.phys.force1, *i.phys.force2) for i in O.interactions}


def plane(xx, xy, yx, yy):
    """A matrix that acts in the plane."""
    return Matrix3(xx, xy, 0, yx, yy, 0, 0, 0, 0)


def gaps():
    """Gaps of all contact points at the beginning of the last step [m]."""
    return [i.geom.gap[k] for i in O.interactions for k in range(i.geom.points)]


def environment(**changes):
    """Environment of a process whose Python may import the modules of the tests."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **changes}


def python(code, **changes):
    """Run code in another Python with changed environment variables: CompletedProcess."""
    return common.python(code, env=environment(**changes))


def assert_refused(match, moved=False):
    """Take a step; it raises a ValueError with these words, and the scene stays as it was."""
    before = snapshot()[:, :13]
    refused(match, O.step)
    assert moved or np.array_equal(snapshot()[:, :13], before, equal_nan=True)


def shrinking_cell():
    """Take 100 steps of a sheared periodic cell of 25 rods that shrinks until they touch."""
    rng = np.random.default_rng(0)
    grains = [rcr.particle((0.2 * (k % 5) + 0.1, 0.2 * (k // 5) + 0.1), rng.uniform(0.07, 0.098),
                           0.5, rng.uniform(0, 3), material(0.3)) for k in range(25)]
    weightless(*grains, cell=1.0, tolerance=1e-8)
    O.cell.velGrad = plane(-4, 0.5, 0, -4)
    steps(100)


def pile(count=40, **options):
    """Falling grains of all elongations in a box without lid, by default with restitution."""
    rng, rough = np.random.default_rng(11), material(0.5)
    grains = [rcr.particle((0.15 + 0.2 * (k % 5), 0.12 + 0.22 * (k // 5)), rng.uniform(0.06, 0.09),
                           rng.uniform(0, 0.8), rng.uniform(0, 3), rough) for k in range(count)]
    build(*open_box(1.1, rough), *grains,
          **options or dict(dt=2e-3, restitution=0.2, tolerance=1e-4))
    return grains


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


def squeezed(*others):
    """Discs of R = 0.1 m: a driven one presses another on a fixed one; `others` lie apart."""
    rough = material(0.3)
    disc = lambda x, y, **more: rcr.disc((x, y), 0.1, material=rough, **more)
    weightless(disc(0, 0, fixed=True), disc(0, 0.2), disc(0, 0.4, fixed=True, velocity=(0, -0.1)),
               *(disc(*at, velocity=velocity) for at, velocity in others), tolerance=1e-4)


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
    grains = []
    for k in range(16):
        at, surface = (0.06 + 0.09 * (k % 4), 0.1 + 0.09 * (k // 4)), rough if k % 2 else smooth
        grains.append(rcr.disc(at, 0.04, surface) if k % 3 == 0
                      else rcr.particle(at, 0.04, 0.5, rng.uniform(0, 3), surface))
    ids = build(*fixed, *grains, dt=5e-4, tolerance=1e-10)
    clump, members = rcr.clump([rcr.particle((0.15 + x, 0.6), 0.06, 0.6, angle, rough)
                                for x, angle in ((0, 0.3), (0.03, 1.8))])
    O.trackEnergy = False
    return dict(obstacles=ids[:4], grains=ids[4:], clump=clump, members=members)
