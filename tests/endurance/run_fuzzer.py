"""Random runs, which PyRunners change as users do: steps in arrays must give the bits of YADE's
engines. A difference is printed with the least scene that still shows it.

    scripts/lib/run python3 tests/endurance/run_fuzzer.py --scenes 500 [--first 0]
"""

import os
import sys
import tempfile

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Quaternion
from yade.utils import typedEngine

import children
import scene_fuzzer
from scene_fuzzer import R, scenes

KINDS = ["Rcr", "Sphere", "RoundedPolygon"]
RUNNERS = 3  # most PyRunners of a scene
PLACES = ["first", "before solver", "after solver", "last"]
COLUMNS = 7


def above(rng):
    top = max((b.state.pos[1] for b in O.bodies if b.dynamic), default=0)
    return (rng.uniform(0, COLUMNS * 2 * R), top + 3 * R, 0)


def of_a_grain(change):
    """The event of a function of a grain that can move, if there is one, and random numbers."""

    def event(rng):
        free = [b for b in O.bodies if type(b.shape).__name__ in KINDS and b.dynamic]
        if free:
            change(free[rng.integers(len(free))], rng)

    return event


def of_a_state(**values):
    """The event that sets attributes of a grain's state to functions of random numbers."""
    return of_a_grain(lambda body, rng: scenes.set_state(
        body.id, **{name: value(rng) for name, value in values.items()}))


def retune(rng):
    name = ["tolerance", "maxIterations", "solver", "correction", "threads"][rng.integers(5)]
    values = dict(tolerance=[1e-2, 1e-6], maxIterations=[10, 500], solver=["nlgs", "exact", "auto"],
                  correction=[0.0, 0.2], threads=[1, 2])  # fmt: skip
    setattr(typedEngine("ContactDynamics"), name, values[name][rng.integers(len(values[name]))])


def stop_engine(rng):
    for e in O.engines:
        if type(e).__name__ in ("ForceEngine", "TorqueEngine", "RotationEngine"):
            e.dead = not e.dead


def new_material(body, rng):
    body.mat = w.FrictMat(density=1000, frictionAngle=rng.uniform(0, 0.8), young=1e7)


def reshape(body, rng):
    """Makes a grain smaller; its mass stays."""
    shape, factor = body.shape, rng.uniform(0.8, 1)
    if isinstance(shape, w.Sphere):
        shape.radius *= factor
    elif isinstance(shape, rcr.Rcr):
        shape.halfLength *= factor
    else:
        shape.vertices = [factor * v for v in shape.vertices]


def material(rng):
    of_a_grain(new_material)(rng)
    O.materials[0].frictionAngle = rng.uniform(0, 0.8)


def drive(rng, speed=0.5):
    held = [b for b in O.bodies if b.state.blockedDOFs == "xyzXYZ"]
    held[rng.integers(len(held))].state.vel = (*rng.uniform(-speed, speed, 2), 0)


def save(rng):
    with tempfile.TemporaryDirectory() as folder:
        O.save(os.path.join(folder, "scene.yade"), quiet=True)


def look(rng):
    """Reads of a script change nothing."""
    sum(i.phys.force1[0] + i.geom.gap[0] for i in O.interactions)
    return [(O.forces.f(b.id), b.state.pos) for b in O.bodies]


BLOCKED = ["xzXY", "yzXY", "zXYZ", "xyzXYZ", "zXY"]
EVENTS = dict(  # each changes the scene during a run
    insert=lambda rng: scene_fuzzer.grain(KINDS[rng.integers(3)], above(rng)[:2],
                                          rng.uniform(0, 0.9), 1.0, O.materials[0], rng),
    erase=of_a_grain(lambda body, rng: O.bodies.erase(body.id)),
    teleport=of_a_state(pos=above),
    kick=of_a_state(vel=lambda rng: (*rng.uniform(-8, 8, 2), 0)),
    spin=of_a_state(angVel=lambda rng: (0, 0, rng.uniform(-300, 300))),
    reshape=of_a_grain(reshape),
    turn=of_a_state(ori=lambda rng: Quaternion((0, 0, 1), rng.uniform(0, 3))),
    push=of_a_grain(lambda body, rng: (
        O.forces.addF(body.id, (*rng.uniform(-500, 500, 2), 0)),
        O.forces.addT(body.id, (0, 0, rng.uniform(-20, 20))))),
    push_permanently=of_a_grain(
        lambda body, rng: O.forces.setPermF(body.id, (*rng.uniform(-50, 50, 2), 0))),
    retune=retune,
    add_engine=of_a_grain(lambda body, rng: scenes.insert(
        3, w.ForceEngine(ids=[body.id], force=(*rng.uniform(-50, 50, 2), 0)))),
    remove_engine=lambda rng: setattr(
        O, "engines", [e for e in O.engines if type(e).__name__ != "ForceEngine"]),
    stop_engine=stop_engine,
    time_step=lambda rng: setattr(O, "dt", O.dt * [0.5, 0.9, 1.1][rng.integers(3)]),
    gravity=lambda rng: setattr(typedEngine("NewtonIntegrator"), "gravity",
                                (*rng.uniform(-10, 10, 2), 0)),
    mask=of_a_grain(lambda body, rng: setattr(body, "mask", int(rng.integers(1, 4)))),
    material=material,
    contact_friction=lambda rng: utils.setContactFriction(rng.uniform(0, 0.8)),
    block=of_a_state(blockedDOFs=lambda rng: BLOCKED[rng.integers(5)]),
    drive=drive,
    fast_obstacle=lambda rng: drive(rng, speed=5),
    save=save,
    pause=lambda rng: O.pause(),
    stop_at=lambda rng: setattr(O, "stopAtIter", O.iter + int(rng.integers(1, 30))),
    clear=lambda rng: O.interactions.clear(),
    verlet=lambda rng: setattr(typedEngine("InsertionSortCollider"), "verletDist",
                               0.5 * typedEngine("InsertionSortCollider").verletDist),
    track=lambda rng: setattr(O, "trackEnergy", not O.trackEnergy),
    look=look,
)  # fmt: skip
MOTIONS = ["TranslationEngine", "RotationEngine", "HarmonicMotionEngine", "ForceEngine",
           "TorqueEngine", "LinearDragEngine", "shakers", "none", "none"]  # fmt: skip
current = {}  # scene that runs


def draw(seed):
    """A scene as plain data, so that it can be printed and made smaller."""
    rng = np.random.default_rng(seed)
    pick = lambda *values: values[rng.integers(len(values))]
    event = lambda: dict(event=pick(*EVENTS), at=int(rng.integers(1, 400)),
                         every=pick(0, 0, 0, 0, 83, 37, 7), place=pick(*PLACES))  # fmt: skip
    return dict(
        seed=seed, law="rigid",
        count=int(rng.integers(3, 40)), eta=pick(0.0, 0.3, 0.6, 0.9),
        kinds=pick(["Rcr"], ["Rcr", "Sphere"], ["Sphere"], ["Rcr"] * 5 + ["moving clump"],
                   ["RoundedPolygon"], KINDS),
        friction=pick(0.0, 0.3, 0.8), restitution=pick(0.0, 0.0, 0.5, 1.0),
        gravity=pick(0.0, 9.81), dt=pick(2e-4, 1e-3, 2e-3), solver=pick("auto", "nlgs", "nesterov"),
        threads=pick(1, 1, 2), overdamped=pick(*[False] * 9, True),
        floor=pick(*scenes.FLOORS), turning=pick(False, False, True),
        speed=pick(0.0, 0.5, 5.0, 20.0), motion=pick(*MOTIONS), strength=pick(0.3, 1.0, 5.0),
        blocked=pick(0, 0, 0, 3), violent=pick(0, 0, 2),
        runs=[int(n) for n in rng.integers(20, 400, rng.integers(1, 4))],
        events=[event() for _ in range(rng.integers(0, RUNNERS + 1))],
        periodic=pick(False, False, False, True), width=17 * R,
        gradient=[pick(0.0, 0.0, -0.5, 0.3) for _ in range(4)], homoDeform=pick(0, 1, 2, 2),
        cell_stress=pick(0, 0, 0, 50.0), flip=pick(False, True), energy=pick(False, False, True),
    )  # fmt: skip


def build(scene):
    """The scene in YADE: a box without lid or a cell, grains in rows, engines, PyRunners."""
    rng = np.random.default_rng(scene["seed"] + 1)
    rough = scene_fuzzer.begin(scene)
    if scene["periodic"]:
        O.bodies.append(rcr.particle((0, -0.1), R, 0.5, fixed=True, material=rough))
    else:
        scene_fuzzer.obstacles(scene, rough)
        O.bodies.append([rcr.wall("x", x, material=rough) for x in (-1.2 * R, COLUMNS * 2.3 * R)])
    first = len(O.bodies)
    for k in range(scene["count"]):
        above_box = scene["turning"] and not scene["periodic"]
        height = (6.5 if above_box else 1.2) * R + 2.3 * R * (k // COLUMNS)
        at = (2.3 * R * (k % COLUMNS) + rng.uniform(0, 0.1 * R), height)
        kind = scene["kinds"][k % len(scene["kinds"])]
        scene_fuzzer.grain(kind, at, scene["eta"], scene["speed"], rough, rng)
    if scene["motion"] == "shakers":  # driven grains whose speeds change within a step
        height = O.bodies[len(O.bodies) - 1].state.pos[1] + 3 * R
        O.bodies.append([rcr.particle((x, height), R, 0.5, fixed=True, material=rough)
                         for x in (2 * R, 8 * R)])
    for _ in range(scene["blocked"]):
        EVENTS["block"](rng)
    for _ in range(scene["violent"]):
        EVENTS["spin"](rng)
    scene_fuzzer.engines(scene)
    O.trackEnergy = scene["energy"]
    if scene["periodic"]:
        xx, xy, yx, yy = scene["gradient"]
        O.cell.velGrad = scenes.plane(xx, xy, yx, yy)
        O.cell.homoDeform, O.cell.flipFlippable = scene["homoDeform"], scene["flip"]
        if scene["cell_stress"] and scene["homoDeform"] == 2:
            scenes.insert(3, rcr.CellStress(stress=(scene["cell_stress"],) * 2))
    set_engines(scene, list(range(first, min(first + 3, len(O.bodies)))))


def set_engines(scene, grains):
    """Adds the motion and the PyRunners of the scene to its engines."""
    floor, s = [0], scene["strength"]
    motions = dict(TranslationEngine=dict(ids=floor, translationAxis=(1, 0, 0), velocity=0.2 * s),
                   RotationEngine=dict(ids=[1], rotationAxis=(0, 0, 1), angularVelocity=6 * s),
                   HarmonicMotionEngine=dict(ids=floor, A=(0, 0.3 * R * s, 0), f=(0, 8, 0)),
                   ForceEngine=dict(ids=grains, force=(20 * s, 30 * s, 0)),
                   TorqueEngine=dict(ids=grains, moment=(0, 0, 3 * s)),
                   LinearDragEngine=dict(ids=grains, nu=s))
    engines = list(O.engines)
    if scene["motion"] == "shakers":
        rng, last = np.random.default_rng(scene["seed"] + 2), len(O.bodies)
        # in a cell, a body that moves by a quarter of it has no unique nearest image
        slow = 0.01 if scene["periodic"] else 1.0
        for body, f in zip((last - 2, last - 1), rng.uniform(5, 0.3 / scene["dt"], 2)):
            engine = w.HarmonicMotionEngine(ids=[body], A=(R * s * slow,) * 2 + (0,), f=(f, f, 0))
            engines.insert(3, engine)
    elif scene["motion"] in motions:
        engines.insert(scene.get("motion_at", 3),
                       getattr(w, scene["motion"])(**motions[scene["motion"]]))
    for k, event in enumerate(scene["events"]):
        command, period = f"import run_fuzzer; run_fuzzer.happen({k})", event["every"] or 10**9
        runner = w.PyRunner(command=command, firstIterRun=event["at"], iterPeriod=period)
        solver = next(n for n, e in enumerate(engines) if type(e).__name__ == "ContactDynamics")
        # YADE replays a force that is added after the integrator when bodies are inserted later
        late_push = event["event"] == "push" and event["place"] == "last"
        place = dict(zip(PLACES, [0, solver, solver + 1, len(engines)]))
        engines.insert(place["after solver" if late_push else event["place"]], runner)
    O.engines = engines


def happen(k):
    """Run the event of PyRunner k, with random numbers that depend on seed and step only."""
    event = current["events"][k]["event"]
    if O.periodic and event == "erase":
        return  # YADE's collider fails in a cell
    EVENTS[event](np.random.default_rng([current["seed"], k, O.iter]))


def state():
    """Step, time, cell, energies, motion of the bodies and forces on them, contacts; −0 is 0."""
    row = lambda *numbers: tuple(x + 0 for x in numbers)
    bodies = [row(b.id, *b.state.pos, *b.state.ori, *b.state.vel, *b.state.angVel,
                  *O.forces.f(b.id), *O.forces.t(b.id)) for b in O.bodies]
    contacts = sorted(
        row(i.id1, i.id2, geom.points, geom.type, *geom.gap, *geom.along, *geom.position1,
            *geom.normal1, *geom.normal, *geom.contactPoint, geom.refR1, geom.refR2, phys.points,
            *phys.along, *phys.force1, *phys.force2, *phys.normalForce, *phys.shearForce,
            phys.tangensOfFrictionAngle, phys.restitution, i.iterMadeReal, *i.cellDist)
        for i in O.interactions for geom, phys in [(i.geom, i.phys)] if hasattr(phys, "points"))
    names = ("hSize", "trsf", "velGrad", "prevVelGrad") if O.periodic else ()
    edges = [row(*line) for name in names for line in getattr(O.cell, name)]
    return dict(step=O.iter, time=O.time, dt=O.dt, bodies=bodies, contacts=contacts, cell=edges,
                energy=[(name, value + 0) for name, value in sorted(O.energy.items())])


def play(scene, arrays):
    """States after each run of the scene, with the error that ended it, and its steps in arrays."""
    np.random.seed(scene["seed"])
    current.clear()
    current.update(scene)
    build(scene)
    solver = typedEngine("ContactDynamics")
    solver.arrays = arrays
    states = []
    for steps in scene["runs"]:
        end = O.iter + steps
        for _ in range(20):  # events end runs early
            try:
                O.run(end - O.iter, True)
            except (ValueError, RuntimeError) as error:
                failure = dict(step=O.iter, error=str(error).split("\n")[0][:60])
                return [*states, failure], solver.model["array_steps"]
            if O.iter >= end:
                break
        states.append(state())
    return states, solver.model["array_steps"]


def difference(scene):
    """The first difference in words, or "same"; and the number of steps in arrays."""
    expected, _ = play(scene, False)
    found, steps = play(scene, True)
    for k, (one, two) in enumerate(zip(expected, found)):
        for name in one.keys() | two.keys():
            if repr(one.get(name)) != repr(two.get(name)):  # all digits; nan equals nan
                return f"run {k}, to step {one['step']}: {name} differ{by(name, one, two)}", steps
    return "same", steps


def by(name, one, two):
    if name != "bodies" or "error" in two or len(one[name]) != len(two[name]):
        return f": {one.get(name)!s:.60} in engines, {two.get(name)!s:.60} in arrays"
    far = [max(abs(a - b) for a, b in zip(p, q)) for p, q in zip(one[name], two[name])]
    return f" by up to {max(far):.3g}, {sum(d > 0 for d in far)} of {len(far)}"


def smaller(scene):
    plain = dict(periodic=False, cell_stress=0, flip=False, energy=False, homoDeform=2,
                 restitution=0.0, overdamped=False, turning=False, speed=0.0, motion="none",
                 blocked=0, violent=0, threads=1, floor="Wall", friction=0.0, gravity=0.0,
                 eta=0.0, kinds=["Rcr"], solver="nlgs")  # fmt: skip
    events, count = scene["events"], scene["count"]
    changes = [dict(events=events[:k] + events[k + 1 :]) for k in range(len(events))]
    changes += [{name: value} for name, value in plain.items()]
    changes += [dict(runs=scene["runs"][:-1])] if len(scene["runs"]) > 1 else []
    changes += [dict(count=fewer) for fewer in (count // 2, count - 1) if 0 < fewer]
    return ({**scene, **change} for change in changes)


def outcome(seed):
    """The first difference with the least scene that shows it, or None; steps in arrays."""
    scene = draw(seed)
    found, steps = difference(scene)
    if found == "same":
        return None, dict(steps=steps)
    least = children.shrink(scene, smaller, lambda scene: difference(scene)[0] != "same")
    return f"{found}\n  least: {difference(least)[0]}\n  {least}", dict(steps=steps)


if __name__ == "__main__":
    sys.modules["run_fuzzer"] = sys.modules["__main__"]  # for the PyRunners
    children.main(children.parser(__doc__, 500).parse_args(), outcome, draw,
                  lambda counts: print(f"{counts['steps']} steps in arrays"))
