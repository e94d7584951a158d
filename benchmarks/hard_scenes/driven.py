"""Driven scenes drawn at random: walls whose motion is prescribed ask for more than rigid grains can do, for an instant or for good.

A bed of grains settles in a box, then one of `MOTIONS` begins. The same motion from the same bed is run with rigid contacts and with springs
of 1e8 Pa. The rigid one must keep what springs keep by giving way: speeds, forces, the time of a step, and a message only where they too
are crushed (`violations`).
"""

import dataclasses
import math
import random
import time

import numpy as np
from yade import O
from yade.wrapper import RotationEngine

import rcr

from .stage import DT, G, ContactDynamics, R, Smooth, angle, box, build, material, positions, real_contacts, solver

MOTIONS = "lid piston receding shear rotating wedge".split()
CRUSHED = 0.02  # overlap over R₁ + R₂ beyond which a scene is squeezed, not resting or flowing
SPRINGS = Smooth(young=1e8, damping=0.3)
PACE = 0.02  # of R, that the drive covers in a step at most
RIGID_STEPS, SPRING_STEPS = 1500, 30000  # at most


@dataclasses.dataclass(frozen=True)
class Scene:
    """What is driven, and how."""

    seed: int
    motion: str
    eta: float  # elongation of all grains [-]
    friction: float  # µ of all contacts [-]
    grains: int
    dt: float  # [s], of the rigid law
    speed: float  # of the drive [m/s]
    steps: int  # of the rigid law

    @property
    def width(self):
        """Of the box [m]."""
        return 2.2 * R * math.sqrt(self.grains)


def draw(seed, grains=(20, 300), steps=RIGID_STEPS):
    """The scene of a seed.

    Parameters
    ----------
    seed : int
    grains : (int, int)
        Least and greatest number of grains.
    steps : int
        Most steps of the rigid law.
    """
    dice = random.Random(seed)
    log_uniform = lambda low, high: math.exp(dice.uniform(math.log(low), math.log(high)))
    dt = log_uniform(1e-4, 1e-2)
    speed = log_uniform(0.005, min(0.3, PACE * R / dt))
    return Scene(
        seed=seed, motion=MOTIONS[seed % len(MOTIONS)], eta=dice.choice([0, dice.uniform(0, 0.9)]), friction=dice.uniform(0, 1),
        grains=round(log_uniform(*grains)), dt=dt, speed=speed, steps=min(steps, math.ceil(3 * R / (speed * dt))),
    )  # fmt: skip


@dataclasses.dataclass
class Course:
    """One run of a scene under one law."""

    fall: float = 0.0  # height that a grain could fall [m]
    fastest: float = 0.0  # of all grains and steps [m/s]
    force: float = 0.0  # largest normal force of a contact [N/m]
    overlap: float = 0.0  # deepest, over R₁ + R₂ [-]
    crushed: float = math.inf  # time at which it went beyond CRUSHED [s]
    stopped: float = math.inf  # time of the message [s]
    median: float = 0.0  # processor time of a step [s]
    slowest: float = 0.0  # the same of the slowest
    yielded: int = 0  # steps without a solution
    missed: int = 0  # steps that missed the tolerance, those included
    steps: int = 0
    ended: bool = True  # without an exception other than the message of the guard


def run(scene):
    """Both laws on the same motion: (rigid, springs), two of `Course`."""
    poses = _settled(scene)
    rigid, times = _follow(scene, ContactDynamics(), poses, scene.dt)
    _, again = _follow(scene, ContactDynamics(), poses, scene.dt)  # the same steps: what else the machine did is no part of the least time
    rigid.median, rigid.slowest = _least(times, again)
    springs, times = _follow(scene, SPRINGS, poses, None)
    springs.median, springs.slowest = _least(times)
    return rigid, springs


def _least(*runs):
    """Median and slowest of the least times of the steps of runs of the same scene [s]."""
    least = np.min([times[: min(map(len, runs))] for times in runs], axis=0)
    return float(np.median(least)), float(least.max())


def violations(scene, rigid, springs):
    """Names of the bounds that the rigid run breaks; none is what is wanted.

    ended
        No exception but the message of the guard.
    speed
        No grain is ever faster than ten times the drive plus free fall.
    force
        No contact carries more than a hundred times what springs carry at most.
    time
        No step takes longer than ten times the median one.
    false_alarm, no_alarm, late_alarm
        The guard speaks where springs too overlap by more than CRUSHED, within 50 steps after its own grains do.
    """
    late = 50 * scene.dt  # steps
    broken = dict(
        ended=not rigid.ended,
        speed=rigid.fastest > 10 * scene.speed + math.sqrt(2 * G * rigid.fall),
        force=rigid.force > 100 * springs.force,
        time=rigid.slowest > 10 * rigid.median,
        false_alarm=rigid.stopped < math.inf and springs.crushed == math.inf,
        no_alarm=rigid.stopped == math.inf and max(rigid.crushed, springs.crushed) + late < scene.steps * scene.dt,
        late_alarm=math.inf > rigid.stopped > rigid.crushed + late,
    )
    return [name for name, is_broken in broken.items() if is_broken]


def _walls(scene, rough):
    walls = rcr.wall("x", 0, material=rough), rcr.wall("x", scene.width, material=rough), rcr.wall("y", 0, material=rough)
    return list(walls)


def _boundary(scene, top, rough):
    """The bodies that hold and drive the grains, and the engines that move them."""
    v, width = scene.speed, scene.width
    if scene.motion == "rotating":
        centre, half = (width / 2, top / 2), (width / 2, top / 2)
        thick = 3 * R
        side = lambda x, y, a, b: box((x, y), (a, b), material=rough)
        boxes = [
            side(centre[0], -thick, half[0] + 2 * thick, thick), side(centre[0], top + thick, half[0] + 2 * thick, thick),
            side(-thick, centre[1], thick, half[1]), side(width + thick, centre[1], thick, half[1]),
        ]  # fmt: skip
        rate = scene.speed / math.hypot(*half)
        return boxes, lambda ids: [RotationEngine(ids=ids, angularVelocity=rate, rotationAxis=(0, 0, 1), rotateAroundZero=True, zeroPoint=(*centre, 0))]
    walls = _walls(scene, rough)
    lid = rcr.wall("y", top, sense=-1, material=rough)
    if scene.motion in ("lid", "receding"):
        lid.state.vel[1] = -v
        if scene.motion == "receding":
            walls[1].state.vel[0] = 1.7 * v
    if scene.motion == "piston":
        walls[1].state.vel[0] = -v
    if scene.motion == "shear":  # by a row of discs that sinks at a tenth of its speed
        row = [rcr.particle((x, top + R), R, 0, material=rough, fixed=True) for x in np.arange(-9 * R, width + 9 * R, 2 * R)]
        for disc in row:
            disc.state.vel = (v, -0.1 * v, 0)
        return walls[2:] + row + _ends(scene, top, rough), lambda ids: []
    if scene.motion == "wedge":  # a ram between two slopes
        lean = math.radians(50)
        reach = width / 2 / math.cos(lean)
        slope = lambda x, angle: box((x, width / 4 * math.tan(lean) - R), (reach / 2, R), angle, rough)
        slopes = [slope(width / 4, -lean), slope(0.75 * width, lean)]
        ram = rcr.particle((width / 2, top + 0.25 * width), 0.25 * width, 0, material=rough, fixed=True)
        ram.state.vel[1] = -v
        return walls + slopes + [ram], lambda ids: []
    return walls + [lid], lambda ids: []


def _ends(scene, top, rough):
    """Sides of a shear box that end below its moving row."""
    return [box((x, 0.45 * top), (R, 0.5 * top), material=rough) for x in (-R, scene.width + R)]


def _settled(scene):
    """Positions and angles of the bed at rest, (grains, 3) [m, rad], and radii."""
    dice = random.Random(scene.seed + 1)
    radii = [R * dice.uniform(0.6, 1) for _ in range(scene.grains)]
    rough = material(scene.friction)
    centers = rcr._kernel.deposit(np.array(radii), scene.width)
    lift = 0.25 * scene.width * math.tan(math.radians(50)) * 2 if scene.motion == "wedge" else 0
    walls, _ = _boundary(dataclasses.replace(scene, speed=0), 1e3, rough) if scene.motion == "wedge" else (_walls(scene, rough), None)
    grains = [rcr.particle((x, y + lift), r, scene.eta, angle=dice.uniform(0, math.pi), material=rough) for (x, y), r in zip(centers, radii)]
    ids = build(ContactDynamics(), DT, *walls, *grains)[len(walls) :]
    for _ in range(600):
        O.step()
    return radii, np.column_stack([positions(ids), [angle(i) for i in ids]])


def _top(radii, poses, eta):
    return max(float(y) + r * ((1 - eta) + eta * abs(math.sin(angle))) for r, (_, y, angle) in zip(radii, poses))


def _follow(scene, law, bed, dt):
    radii, poses = bed
    rough = material(scene.friction)
    top = _top(radii, poses, scene.eta) + 1e-3 * R
    boundary, engines = _boundary(scene, top, rough)
    grains = [rcr.particle((x, y), r, scene.eta, angle=a, material=rough) for r, (x, y, a) in zip(radii, poses)]
    ids = build(law, dt or 1e-6, *boundary, *grains)
    walls, ids = ids[: len(boundary)], ids[len(boundary) :]
    O.engines = O.engines[:3] + engines(walls) + O.engines[3:]
    duration = scene.steps * scene.dt
    if dt is None:
        O.dt = min(0.5 * rcr.critical_time_step(), scene.dt)
        duration = min(duration, SPRING_STEPS * O.dt)
    steps = math.ceil(duration / O.dt)
    every = 1 if dt else max(1, steps // 2000)
    course, times = Course(fall=top), []
    rigid = dt is not None
    states = [O.bodies[i].state for i in ids]
    for step in range(steps):
        start = time.process_time()
        try:
            O.step()
        except RuntimeError as stop:
            course.ended = "jam" in str(stop)
            course.stopped = step * O.dt
            break
        times.append(time.process_time() - start)
        course.steps = step + 1
        if rigid:
            engine = solver()
            course.yielded += engine.yielded
            course.missed += not engine.converged
        if step % every == 0:
            course.fastest = max(course.fastest, max(s.vel.norm() for s in states))
            for i in real_contacts():
                course.force = max(course.force, i.phys.normalForce.norm())
                gap = min(tuple(i.geom.gap)[: i.geom.points])
                course.overlap = max(course.overlap, -gap / (i.geom.refR1 + i.geom.refR2))
            if course.overlap > CRUSHED and course.crushed == math.inf:
                course.crushed = (step + 1) * O.dt
    return course, times
