"""Scenes with driven bodies, drawn at random, under rigid contacts and under springs.

Rigid grains with friction cannot follow every prescribed motion: a step may have no solution (a
frictional wedge), or none exists any more (a jam). A bed of grains settles in a box, then one of
`MOTIONS` begins, for the same time under both laws; springs end soon after they are crushed. If the
rigid run stops and springs are not crushed, the runs may have diverged before: springs then start
from the rigid grains before the first step without a solution.
"""

import dataclasses
import math
import random
import time
from functools import partial

import numpy as np
from yade import O
from yade.wrapper import RotationEngine

import rcr

from . import stage
from .stage import (DT, G, R, SCENES, ContactDynamics, Smooth, angle, box, build, material,
                    open_box, positions, real_contacts, solver)

TITLES = dict(  # of the hard scenes S21 to S26, one a motion
    lid="lid driven into a bed", piston="side wall driven into a bed",
    receding="lid driven beside a receding wall",
    shear="shear box with a row that sinks onto the bed",
    rotating="closed box that turns", wedge="ram between two slopes",
)  # fmt: skip
MOTIONS = list(TITLES)
CRUSHED = 0.02  # overlap over R₁ + R₂ at which grains count as crushed
RIGID, SPRINGS = ContactDynamics(), Smooth(young=1e8, damping=0.3)
PACE = 0.02  # largest displacement of the drive in a step, over R
RIGID_STEPS, SPRING_STEPS = 1500, 20000  # largest numbers; the shorter run sets the duration
LATE = 50  # rigid steps within which the error has to come
LOOKS = 1000  # largest number of samples of springs; rigid contacts are sampled at each step


@dataclasses.dataclass(frozen=True)
class Scene:
    """Parameters of a driven scene."""

    seed: int
    motion: str
    eta: float  # elongation of all grains [-]
    friction: float  # µ of all contacts [-]
    grains: int
    dt: float  # of rigid contacts [s]
    speed: float  # of the drive [m/s]
    steps: int  # of rigid contacts

    @property
    def width(self):
        return 2.2 * R * math.sqrt(self.grains)


def draw(seed, grains=(20, 300), steps=RIGID_STEPS):
    """Scene of a seed, with a number of grains in this range and at most so many rigid steps."""
    dice = random.Random(seed)
    log_uniform = lambda low, high: math.exp(dice.uniform(math.log(low), math.log(high)))
    dt = log_uniform(1e-4, 1e-2)
    speed = log_uniform(0.005, min(0.3, PACE * R / dt))
    return Scene(seed=seed, motion=MOTIONS[seed % len(MOTIONS)],
                 eta=dice.choice([0, dice.uniform(0, 0.9)]), friction=dice.uniform(0, 1),
                 grains=round(log_uniform(*grains)), dt=dt, speed=speed,
                 steps=min(steps, math.ceil(3 * R / (speed * dt))))


@dataclasses.dataclass
class Course:
    """Results of one run of a scene under one law."""

    fall: float = 0.0  # largest height of fall of a grain [m]
    duration: float = 0.0  # planned time [s]
    fastest: float = 0.0  # largest speed of a grain [m/s]
    force: float = 0.0  # largest normal force of a contact [N/m]
    overlap: float = 0.0  # largest overlap over R₁ + R₂ [-]
    crushed: float = math.inf  # time at which `overlap` exceeded CRUSHED [s]
    stopped: float = math.inf  # time of the error [s]
    median: float = 0.0  # processor time of a step [s]
    slowest: float = 0.0  # processor time of the slowest step without the first [s]
    taken_over: float = 0.0  # overlap of springs that start from the rigid grains, or 0
    yielded: int = 0  # steps without a solution
    missed: int = 0  # steps that missed the tolerance, those without a solution included
    steps: int = 0
    ended: bool = True  # False after an exception other than the error of a jam


def run(scene):
    """Courses (rigid, springs) of a scene."""
    bed = _settled(scene)
    springs = _follow(scene, SPRINGS, bed, scene.steps * scene.dt)[0]
    rigid, times, wedged = _follow(scene, RIGID, bed, springs.duration)
    again = _follow(scene, RIGID, bed, springs.duration, looks=0)[1]  # repeated for the minimum
    count = min(len(times), len(again))
    least = np.min([times[1:count], again[1:count]], axis=0)
    rigid.median, rigid.slowest = float(np.median(least)), float(least.max())
    if rigid.stopped < math.inf and springs.crushed == math.inf and wedged:
        rest = rigid.stopped - wedged.time + LATE * scene.dt
        rigid.taken_over = _follow(scene, SPRINGS, bed, rest, start=wedged.motion)[0].overlap
    return rigid, springs


def violations(scene, rigid, springs):
    """Names of the bounds that the rigid run breaks."""
    late = LATE * scene.dt
    springs_last = springs.crushed == math.inf and rigid.taken_over <= CRUSHED
    crushed = max(rigid.crushed, springs.crushed)  # the error comes if springs are crushed too
    broken = dict(
        ended=not rigid.ended,  # by an exception other than the error of a jam
        speed=rigid.fastest > 10 * scene.speed + math.sqrt(2 * G * rigid.fall),
        force=rigid.force > 100 * springs.force,
        step_time=rigid.slowest > 10 * rigid.median,
        false_alarm=rigid.stopped < math.inf and springs_last,
        no_alarm=rigid.stopped == math.inf and crushed + late < rigid.duration,
        late_alarm=math.inf > rigid.stopped > rigid.crushed + late,
    )  # fmt: skip
    return [name for name, is_broken in broken.items() if is_broken]


def _boundary(scene, top, rough):
    """Bodies around the grains, whose highest point is at `top`."""
    v, width = scene.speed, scene.width
    if scene.motion == "rotating":
        x, y, thick = width / 2, top / 2, 3 * R
        sides = [((x, -thick), (x + 2 * thick, thick)), ((x, top + thick), (x + 2 * thick, thick)),
                 ((-thick, y), (thick, y)), ((width + thick, y), (thick, y))]
        return [box(center, half_extent, material=rough) for center, half_extent in sides]
    walls = open_box(width, rough)
    if scene.motion == "shear":  # a row of discs that sinks at a tenth of its speed
        row = [rcr.particle((x, top + R), R, 0, material=rough, fixed=True, velocity=(v, -0.1 * v))
               for x in np.arange(-9 * R, width + 9 * R, 2 * R)]
        ends = [box((x, 0.45 * top), (R, 0.5 * top), material=rough) for x in (-R, width + R)]
        return walls[2:] + row + ends  # the sides end below the row
    if scene.motion == "wedge":  # a ram between two slopes
        lean = math.radians(50)
        reach = width / 2 / math.cos(lean)
        y = width / 4 * math.tan(lean) - R
        slopes = [box((x, y), (reach / 2, R), angle, rough)
                  for x, angle in ((width / 4, -lean), (0.75 * width, lean))]
        ram = rcr.particle((width / 2, top + 0.25 * width), 0.25 * width, 0, material=rough,
                           fixed=True, velocity=(0, -v))
        return walls + slopes + [ram]
    lid = rcr.wall("y", top, sense=-1, material=rough)
    if scene.motion != "piston":
        lid.state.vel[1] = -v
    walls[1].state.vel[0] = dict(lid=0, receding=1.7 * v, piston=-v)[scene.motion]
    return walls + [lid]


def _settled(scene):
    """Radii [m] and (x, y, angle) of the bed at rest, (grains, 3) [m, m, rad]."""
    dice = random.Random(scene.seed + 1)
    radii = [R * dice.uniform(0.6, 1) for _ in range(scene.grains)]
    rough = material(scene.friction)
    centers = rcr._kernel.deposit(np.array(radii), scene.width)
    lift = 0.25 * scene.width * math.tan(math.radians(50)) * 2 if scene.motion == "wedge" else 0
    walls = open_box(scene.width, rough)
    if scene.motion == "wedge":
        walls = _boundary(dataclasses.replace(scene, speed=0), 1e3, rough)
    place = lambda x, y, r: rcr.particle((x, y + lift), r, scene.eta,
                                         angle=dice.uniform(0, math.pi), material=rough)
    grains = [place(x, y, r) for (x, y), r in zip(centers, radii)]
    ids = build(ContactDynamics(), DT, *walls, *grains)[len(walls) :]
    for _ in range(600):
        O.step()
    return radii, np.column_stack([positions(ids), [angle(i) for i in ids]])


def begin(scene, law, bed):
    """Make bed and drive; returns the ids of the grains and their largest height of fall [m]."""
    radii, poses = bed
    rough = material(scene.friction)
    half_height = lambda r, angle: r * ((1 - scene.eta) + scene.eta * abs(math.sin(angle)))
    top = max(float(y) + half_height(r, a) for r, (_, y, a) in zip(radii, poses)) + 1e-3 * R
    boundary = _boundary(scene, top, rough)
    grains = [rcr.particle((x, y), r, scene.eta, angle=a, material=rough)
              for r, (x, y, a) in zip(radii, poses)]
    ids = build(law, scene.dt, *boundary, *grains)
    walls, ids = ids[: len(boundary)], ids[len(boundary) :]
    if scene.motion == "rotating":
        center = scene.width / 2, top / 2
        turn = RotationEngine(ids=walls, angularVelocity=scene.speed / math.hypot(*center),
                              rotationAxis=(0, 0, 1), rotateAroundZero=True, zeroPoint=(*center, 0))
        O.engines = O.engines[:3] + [turn] + O.engines[3:]
    return ids, top


@dataclasses.dataclass(frozen=True)
class Moment:
    """Time and motion of all bodies before a step."""

    time: float  # [s]
    motion: list  # position, orientation, velocity and angular velocity of each

    @staticmethod
    def now():
        states = [body.state for body in O.bodies]
        return Moment(O.time, [(s.pos, s.ori, s.vel, s.angVel) for s in states])


def _follow(scene, law, bed, duration, looks=None, start=None):
    """Run a scene under a law, sampled `looks` times, by default at each rigid step.

    `start` replaces the initial motion of all bodies. Returns the course, the processor times of
    the steps [s] and the `Moment` before the first step without a solution, or None.
    """
    ids, top = begin(scene, law, bed)
    for body, motion in zip(O.bodies, start or []):
        body.state.pos, body.state.ori, body.state.vel, body.state.angVel = motion
    steps = math.ceil(duration / scene.dt)
    if law is SPRINGS:
        O.dt = min(0.8 * rcr.critical_time_step(), scene.dt)
        steps, looks = min(math.ceil(duration / O.dt), SPRING_STEPS), LOOKS
    stride = steps + 1 if looks == 0 else max(1, steps // looks) if looks else 1
    course, times, wedged = Course(fall=top, duration=steps * O.dt), [], None
    for step in range(1, steps + 1):
        before = Moment.now() if law is RIGID and not wedged else None
        began = time.process_time()
        try:
            O.step()
        except RuntimeError as stop:
            course.ended = "jam" in str(stop)
            course.stopped = (step - 1) * O.dt
            break
        times.append(time.process_time() - began)
        course.steps = step
        if law is RIGID:
            course.yielded += solver().yielded
            course.missed += not solver().converged
            wedged = wedged or (before if solver().yielded else None)
        if step % stride == 0:
            _look(course, ids)
            if course.crushed == math.inf and course.overlap > CRUSHED:
                course.crushed = step * O.dt
        if law is SPRINGS and step * O.dt > course.crushed + LATE * scene.dt:
            break
    return course, times, wedged


def _look(course, ids):
    """Sample speeds, forces and overlaps of the grains; obstacles may overlap each other."""
    course.fastest = max(course.fastest, max(O.bodies[i].state.vel.norm() for i in ids))
    grains = set(ids)
    for i in real_contacts():
        if grains.isdisjoint((i.id1, i.id2)):
            continue
        geom = i.geom
        course.force = max(course.force, i.phys.normalForce.norm())
        gap = min(tuple(geom.gap)[: geom.points])
        course.overlap = max(course.overlap, -gap / (geom.refR1 + geom.refR2))


# ---- one scene of each motion, for the suite of hard scenes

SECONDS = 0.5  # duration of a hard scene, in which the drive moves by 3 R


def staged(make, clock, motion):
    law, dt = make.args
    scene = Scene(seed=0, motion=motion, eta=0.5, friction=0.5, grains=60, dt=dt,
                  speed=3 * R / SECONDS, steps=math.ceil(SECONDS / dt))
    ids, top = begin(scene, law, _settled(scene))
    allowed, speeds = 10 * scene.speed + math.sqrt(2 * G * top), [0.0]
    look = lambda: speeds.append(max(O.bodies[i].state.vel.norm() for i in ids))
    try:
        clock.pass_(SECONDS, look)
    except RuntimeError as stopped:
        assert "jam" in str(stopped), stopped
    return max(speeds) / allowed


SCENES |= {f"s{number}_driven_{motion}": stage.Scene(
    partial(staged, motion=motion), title,
    "speed of the fastest grain over (10 × speed of the drive + free fall)", 1,
    "a slow drive throws no grain", False)
    for number, (motion, title) in enumerate(TITLES.items(), 21)}
