"""Shared parts of the hard scenes: laws, bodies, and a clock that checks energy and overlaps.

R = 0.01 m is the circumscribed radius of every body unless a scene states another; d = 2R.
"""

import dataclasses
import math
import time
from collections.abc import Callable

import numpy as np
from yade import O
from yade.minieigenHP import Vector3
from yade import wrapper as w

import rcr
from bodies import (DENSITY, G, angle, box, free, kinetic, material, open_box, positions, solver,
                    stadium, state, tilted, twist)  # noqa: F401: for the scenes

R = 0.01  # m
D = 2 * R
DT = 1e-3  # s, the default: a grain at rest falls 5e-4 d in a step
COARSE = 10 * DT
SAMPLES = 1000  # of an advance of the clock, at most about
X = 0.1234567  # x of stacks [m]; at 0 sums would be exact, without rounding

_inscribed = {}  # inscribed radii of the polygons of the present scene [m]
_pushes = {}  # constant forces on bodies of the present scene, by id; YADE cannot list them


@dataclasses.dataclass(frozen=True)
class ContactDynamics:
    """Rigid contacts; `options` are attributes of the engine that differ from the defaults."""

    options: dict = dataclasses.field(default_factory=dict)
    young = 1e9  # not used

    def parts(self, restitution):
        ip2 = rcr.Ip2_FrictMat_FrictMat_CdPhys()
        if restitution:
            ip2.restitution = w.MatchMaker(algo="val", val=restitution)
        return (ip2, rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb(),
                rcr.ContactDynamics(**self.options))


@dataclasses.dataclass(frozen=True)
class Smooth:
    """Springs `young` [Pa] or `kn` [N/m], `damping` over critical damping; without restitution."""

    young: float = 1e8
    damping: float = 0.2
    kn: float = 0.0

    def parts(self, restitution):
        ip2 = w.Ip2_FrictMat_FrictMat_FrictPhys()
        if self.kn:
            ip2.kn, ip2.ks = (w.MatchMaker(algo="val", val=k) for k in (self.kn, 0.8 * self.kn))
        return ip2, rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=self.damping)


def build(law, dt, *bodies, gravity=(0, -G, 0), restitution=0):
    """A fresh scene of these bodies under the law, gravity in m/s², one restitution; their ids."""
    for body in bodies:
        body.material.young = law.young
    O.reset()
    _pushes.clear()
    _inscribed.clear()
    O.dt = dt
    ip2, law2, *solver = law.parts(restitution)
    boxes = [rcr.Bo1_Rcr_Aabb(), rcr.Bo1_RoundedPolygon_Aabb(), w.Bo1_Wall_Aabb(),
             w.Bo1_Box_Aabb()]
    points = [getattr(rcr, f"Ig2_{pair}_RcrGeom")() for pair in (
        "Rcr_Rcr", "Wall_Rcr", "Box_Rcr", "RoundedPolygon_RoundedPolygon", "Wall_RoundedPolygon",
        "Rcr_RoundedPolygon")]
    O.engines = [w.ForceResetter(), w.InsertionSortCollider(boxes, verletDist=0.1 * R),
                 w.InteractionLoop(points, [ip2], [law2]), *solver,
                 w.NewtonIntegrator(gravity=gravity, damping=0)]
    return [O.bodies.append(body) for body in bodies]


def on_floor(make, rough, *bodies, **options):
    """`make` of these bodies on a floor of the material `rough`; returns the ids of the bodies."""
    return make(rcr.wall("y", 0, material=rough), *bodies, **options)[1:]


@dataclasses.dataclass(frozen=True)
class Scene:
    """A hard scene; measured ≤ BOUND must hold. `run(make, clock)` builds it by `make`, which is
    `build` with a law and a time step, and advances it. It returns the measured number, or ids of
    bodies that must not move in 10 s.
    """

    run: Callable
    TITLE: str
    PREDICATE: str
    BOUND: float
    REASON: str
    RIGID_ONLY: bool  # the predicate is meaningless for springs


SCENES = {}  # by name


def hard_scene(title, predicate="largest displacement in 10 s, in diameters", bound=1e-3,
               reason="geometric error of 1e-3 diameters, as in all scenes", rigid_only=False):
    """Add a function as `run` of a scene with its name."""
    def add(run):
        SCENES[run.__name__] = Scene(run, title, predicate, bound, reason, rigid_only)
        return run

    return add


def flat(center, rough):
    """A flat RCR, 2 R long and R high."""
    return stadium(R / 2, R / 2, center, material=rough)


def flat_row(row):
    """Height of the centres in a row of flat RCRs on each other."""
    return R * (row + 0.5)


def dense_row(row):
    """Height of the centres in a row of discs in a dense packing."""
    return R + row * math.sqrt(3) * R


def rows(count, columns, height):
    """Centres in rows, shifted in turn, of `columns` and one less; `height` is that of a row."""
    return [(R * (1 + row % 2) + D * k, height(row)) for row in range(count)
            for k in range(columns - row % 2)]


def push(i, force):
    """A constant force (x, y) on body i [N/m]."""
    _pushes[i] = np.array([*force, 0.0])
    O.forces.setPermF(i, Vector3(*_pushes[i]))


def real_contacts():
    return [i for i in O.interactions if i.isReal]


def potential():
    """Energy in gravity and in constant forces [J/m]."""
    gravity = np.array(next(e for e in O.engines if isinstance(e, w.NewtonIntegrator)).gravity)
    return -sum(
        (b.state.mass * gravity + _pushes.get(b.id, 0)) @ np.array(b.state.pos) for b in free())


def _work_of(prescribed):
    """Work of the driven bodies on the free ones in the step [J/m]."""
    return -O.dt * sum(
        O.forces.f(b.id).dot(b.state.vel) + O.forces.t(b.id).dot(b.state.angVel)
        for b in prescribed)


def inscribed_radius(shape):
    """Inscribed radius of a grain about its centre [m]; infinite for an obstacle."""
    if isinstance(shape, rcr.Rcr):
        return shape.capRadius
    if not isinstance(shape, rcr.RoundedPolygon):
        return math.inf
    if shape not in _inscribed:
        _inscribed[shape] = rcr._kernel.polygon_radii(shape.vertices, shape.radius)[1]
    return _inscribed[shape]


def deepest():
    """Largest overlap over the inscribed radius of the smaller body [-]; 0 without overlaps."""
    overlaps = [0.0]
    for i in real_contacts():
        radius = min(inscribed_radius(O.bodies[k].shape) for k in (i.id1, i.id2))
        overlaps += [-gap / radius for gap in tuple(i.geom.gap)[: i.geom.points]]
    return max(overlaps)


def farthest(ids, clock, seconds):
    """Advance by `seconds` and return the largest displacement of these bodies [m]."""
    start = positions(ids)
    return clock.largest(seconds, lambda: np.linalg.norm(positions(ids) - start, axis=1).max())


def overlap_of_spinning(make, clock, rough, body, disc):
    """The deepest overlap of a body that turns by 0.1 rad a step in a narrow box with a disc."""
    half = 1.2 * R
    walls = [rcr.wall(axis, side * half, sense=-side, material=rough) for axis in "xy"
             for side in (-1, 1)]
    ids = make(*walls, body, disc, gravity=(0, 0, 0))[4:]
    state(ids[0]).angVel = (0, 0, 100.0)
    clock.pass_(1.0)
    return clock.overlap if abs(positions(ids)).max() < half else math.inf


class Clock:
    """Advances the scene, and records the energy gain and the largest overlap.

    `gain` [J/m] is the largest kinetic energy beyond that of the start and the work of loads and
    drives: 0 if contacts give no energy. `scale` [J/m] is the kinetic energy of the start and the
    work of all loads over d. `overlap` is over the inscribed radius of the smaller body; at 1 bodies
    tunnel.
    """

    def __init__(self):
        self.began = None  # processor time before the first step [s]
        self.gain = self.overlap = self.steps = 0

    def restart(self):
        """Count the energy from here: the first step, or a change of the scene by hand."""
        self.began = self.began or time.process_time()
        self.kinetic, self.potential, self.driven = kinetic(), potential(), 0.0
        self.prescribed = [b for b in O.bodies if b and b.state.blockedDOFs == "xyzXYZ"]
        loads = sum(b.state.mass for b in free()) * G + sum(
            np.linalg.norm(force) for force in _pushes.values())
        self.scale = self.kinetic + loads * D

    def pass_(self, seconds, each=None):
        """Advance by `seconds`, rounded to steps; calls `each()` at every sample."""
        self.step(max(1, round(seconds / O.dt)), each)

    def largest(self, seconds, value):
        """Advance by `seconds` and return the largest of the samples of `value()`; NaN stays."""
        seen = []
        self.pass_(seconds, lambda: seen.append(value()))
        return np.max(seen)

    def step(self, count, each=None):
        """Advance by `count` steps; calls `each()` at every sample."""
        if self.began is None:
            self.restart()
        chunk = max(1, count // SAMPLES)
        while count > 0:
            for _ in range(min(chunk, count)):  # O.run(…, True) returns up to 40 ms late
                O.step()
                self.driven += _work_of(self.prescribed)
            self.steps += min(chunk, count)
            count -= chunk
            gain = kinetic() - self.kinetic - max(0, self.potential - potential())
            self.gain = np.maximum(self.gain, gain - max(0, self.driven))  # keeps NaN
            self.overlap = np.maximum(self.overlap, deepest())
            if each:
                each()
