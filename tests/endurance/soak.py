#!/usr/bin/env python3
"""Soak: random scenes with repeated changes in one process.

After each step all numbers are finite, no grain has left the box, and the residual is within the
tolerance. No overlap is deep unless a message says why. Rigid contacts create no energy where the
time step resolves the motion.

    scripts/check soak -- --minutes 20 [--first 0]
    scripts/lib/run python3 tests/endurance/soak.py --only SEED
"""

import collections
import ctypes
import gc
import math
import os
import sys
import tempfile
import time

import numpy as np
import yade
import rcr
from rcr.study.summary import memory
from yade import O, utils
from yade.minieigenHP import Vector3
from yade.wrapper import InteractionLoop

import children
import scene_fuzzer
from scene_fuzzer import R, WIDTH, scenes

EVENTS = 12  # events of a scene
STEPS = 80  # steps between two events
HIT = 100.0  # largest speed of a hit [m/s]
MISSED_STEPS_HEAL = 200  # steps; overlaps may stay deep after a step that missed the tolerance
RESOLVED = 1.0  # displacement of a surface in a step over R; beyond it a rod may meet a pair twice
ENERGY = 0.02  # gain of rigid contacts over the total: the tolerance, step after step
AT_REST = 1e-2  # error of velocities over g dt: ContactDynamics.accuracy
WARM_UP = 0.25  # share of the time; memory is constant afterwards
SAME_BITS = 5  # steps that are compared after a reload


def draw(rng):
    """A scene of the scene fuzzer as plain data, without faults, closed, and with more grains."""
    scene = scene_fuzzer.draw(rng)
    scene.update(fault="none", overdamped=scene["overdamped"] and scene["law"] == "rigid",
                 turning=scene["turning"] and not scene["periodic"])
    scene["floor"] = str(rng.choice(["Wall", "Box", "Facet", "Rcr"]))
    scene["count"] = int(rng.integers(2, 50))
    scene["speed"] = min(scene["speed"], 20.0)
    scene["width"] = WIDTH
    if scene["gradient"]:
        a, b, c = (float(rate) for rate in rng.choice([0, 0, -0.3, 0.3], 3))
        scene["gradient"] = [a, b, c, -a]  # constant volume: no compression of the grains
    return scene


def container(scene, material):
    """Four obstacles around |x|, |y| < WIDTH/2; some scenes have a turning box inside."""
    half, out, held = WIDTH / 2, 3 * WIDTH, dict(material=material, fixed=True)
    for axis in (0, 1):
        swap = lambda along, across: (along, across) if axis == 0 else (across, along)
        for at, side in ((-half, -1), (half, 1)):
            O.bodies.append({
                "Wall": lambda: rcr.wall("xy"[axis], at, sense=-side, material=material),
                "Box": lambda: utils.box((*swap(at + 0.5 * side, 0), 0), (*swap(0.5, out), 1),
                                         **held),
                "Facet": lambda: utils.facet([(*swap(at, y), z) for y, z in
                                              ((-out, -1), (out, -1), (0, 1))], material=material),
                "Rcr": lambda: rcr.particle(swap(at + 0.1 * side, 0), 5, 0.98,
                                            angle=0 if axis else math.pi / 2, **held),
            }[scene["floor"]]())  # fmt: skip
    if scene["turning"]:
        scene_fuzzer.add_turning_box((0, 0, 0), material)


def movable():
    return [b for b in O.bodies if not b.isClumpMember and "x" not in b.state.blockedDOFs]


def places():
    """Centres of the movable bodies, (n, 2) [m]."""
    return np.array([[b.state.pos[0], b.state.pos[1]] for b in movable()]).reshape(-1, 2)


def add(scene, material, rng):
    """Append a grain at a free place; False if there is none."""
    others = places()
    for _ in range(30):
        at = rng.uniform(-WIDTH / 2 + 1.2 * R, WIDTH / 2 - 1.2 * R, 2)
        at = at + (WIDTH / 2 if scene["periodic"] else 0)
        away = others - at
        if scene["periodic"]:
            cell = np.array(O.cell.hSize)[:2, :2]
            away = away - np.rint(away @ np.linalg.inv(cell).T) @ cell.T
        in_box = scene["turning"] and np.hypot(*at) < 4.2 * R
        if (np.hypot(*away.T) > 2.1 * R).all() and not in_box:
            kind = str(rng.choice(scene_fuzzer.KINDS, p=scene_fuzzer.SHARES))
            eta = rng.choice([0, 0.3, 0.6, 0.9])
            scene_fuzzer.grain(kind, tuple(at), eta, scene["speed"], material, rng)
            return True
    return False


def change(what, scene, material, rng):
    """Apply one event; False where it does not fit the scene."""
    grains, solver = movable(), scene_fuzzer.solver()
    if what == "added":
        return add(scene, material, rng)
    if ((what == "erased" and (scene["periodic"] or len(grains) < 2))  # collider fails in a cell
            or (what in ("threads", "solvers") and not solver)
            or (what == "gradients" and not scene["periodic"])):
        return False
    if what == "erased":
        body = grains[rng.integers(len(grains))]
        O.bodies.erase(body.id, body.isClump)
    elif what == "hits":
        body = grains[rng.integers(len(grains))]
        body.state.vel = (*(rng.uniform(-1, 1, 2) * HIT / 2**0.5
                            * (1 if scene["law"] == "rigid" else 0.05)), 0)
    elif what == "frictions":
        utils.setContactFriction(float(rng.uniform(0, 0.8)))
    elif what == "threads":
        solver.threads = int(rng.integers(1, 5))
    elif what == "solvers":
        solver.solver = str(rng.choice(["auto", "nlgs", "sor", "nesterov", "exact"]))
    elif what == "laws":
        scene["law"] = "smooth" if solver else "rigid"
        scene["dt"] = float(rng.choice([1e-4, 1e-3, 5e-3]))
        O.interactions.clear()
        scene_fuzzer.engines(scene)
        for state in (body.state for body in movable() if scene["law"] == "smooth"):
            state.vel *= min(1, 5 / (state.vel.norm() or 5))  # springs need slower grains
    elif what == "gradients":
        scene["gradient"] = [-rate for rate in scene["gradient"]]
        O.cell.velGrad = scenes.plane(*scene["gradient"])
    else:
        check_reload(scene)
    return True


def check_reload(scene):
    """Save and run, load and run again; both must give the same bits, with springs to rounding."""
    with tempfile.NamedTemporaryFile(suffix=".yade") as file:
        O.save(file.name)
        scenes.steps(SAME_BITS)
        straight = scene_fuzzer.state()
        O.load(file.name)
        scenes.steps(SAME_BITS)
        rounding = 1e-13 * np.abs(straight).max() if scene["law"] == "smooth" else 0
        if not np.allclose(scene_fuzzer.state(), straight, rtol=0, atol=rounding):
            raise Wrong(f"other bits after a reload: they differ by up to "
                        f"{np.abs(scene_fuzzer.state() - straight).max():.3g}")
        O.load(file.name)


class Wrong(Exception):
    """A condition is violated."""


class Watch:
    """Checks the conditions after each step of a scene."""

    def __init__(self, scene):
        self.scene, self.healing, self.missed, self.steps = scene, 0, 0, 0
        self.too_soft = self.astray = False
        self.inherited = 0.0  # overlap left by springs; rigid contacts remove it by 1e-4 R a step
        self.rigid = True  # contacts of the last step
        self.restart()

    def restart(self):
        """Forget energies after a change from outside."""
        self.given, self.way, self.lifted = None, 0.0, 0.0

    def energies(self):
        """Kinetic energy, work of gravity in a step [J], longest displacement of a surface [m]."""
        kinetic = work = way = 0.0
        for b in movable():
            v, w = b.state.vel, b.state.angVel[2]
            way = max(way, O.dt * (v.norm() + abs(w) * R))
            kinetic += 0.5 * (b.state.mass * (v[0] ** 2 + v[1] ** 2) + b.state.inertia[2] * w**2)
            work -= b.state.mass * self.scene["gravity"] * v[1] * O.dt
        return kinetic, work, way

    def step(self):
        O.step()
        self.steps += 1
        now = scene_fuzzer.state()
        if not np.isfinite(now).all():
            raise Wrong("numbers that are not finite")
        solver = scene_fuzzer.solver()
        if solver:
            self.missed += not solver.converged
            self.healing = MISSED_STEPS_HEAL if not solver.converged else max(0, self.healing - 1)
            if not np.isfinite(solver.residual):
                raise Wrong(f"a residual of {solver.residual}")
            if (solver.converged and not solver.yielded
                    and max(solver.residual / solver.tolerance, solver.errorEstimate) > 1):
                raise Wrong(f"a converged step with a residual of {solver.residual:.3g} and an "
                            f"estimated error of {solver.errorEstimate:.3g}")
        if not self.scene["periodic"]:
            farthest = np.abs(places()).max()
            self.astray = self.astray or (farthest > WIDTH / 2 and self.warned())
            if farthest > WIDTH / 2 and not self.astray:
                raise Wrong(f"a grain at {farthest:.3g} m, outside the box of half width "
                            f"{WIDTH / 2:.3g}")
        # YADE measures overlaps at the beginning of a step, so springs leave that of the next step
        inherits, self.rigid = not (solver and self.rigid), bool(solver)
        if self.steps % 4 == 0 or (inherits and solver):
            deepest = scene_fuzzer.deepest_overlap()
            self.inherited = deepest if inherits else min(self.inherited, deepest)
            bound = max(scene_fuzzer.DEEPEST, 1.05 * self.inherited) if solver else 0.5
            if deepest > bound and not (self.healing if solver else self.warned()):
                raise Wrong(f"an overlap of {deepest:.3g} (R₁ + R₂)")
        driven = self.scene["turning"] or (self.scene["gradient"] and any(self.scene["gradient"]))
        if solver and not driven and not self.scene["overdamped"]:
            self.no_gain()

    def warned(self):
        """True if a missed tolerance or too soft springs explain stray grains and deep overlaps."""
        laws = [functor for e in O.engines if isinstance(e, InteractionLoop)
                for functor in e.lawDispatcher.functors]
        self.too_soft = self.too_soft or any(getattr(law, "deepOverlapCount", 0) for law in laws)
        return self.healing or self.too_soft

    def no_gain(self):
        """Kinetic energy grows by at most the work of gravity at the mean velocity of each step.

        A body that leaves its support more slowly than g dt is back on it at the end of the step.
        Moreau's step then adds m u (g dt − u)/2 at its speed u, at most m (g dt)²/8.
        """
        kinetic, work, way = self.energies()
        if self.given is None or max(way, self.way) > RESOLVED * R:
            self.given, self.reference, self.work, self.way = kinetic, kinetic, work, way
            return
        self.given += 0.5 * (work + self.work)
        self.reference += 0.5 * (abs(work) + abs(self.work))
        self.work, self.way = work, way
        mass = sum(b.state.mass for b in movable())
        fall = (self.scene["gravity"] * O.dt) ** 2 * mass
        self.lifted += AT_REST * fall
        if kinetic - self.given > ENERGY * self.reference + self.lifted + fall / 8 + 1e-9:
            raise Wrong(f"a kinetic energy of {kinetic:.4g} J where {self.given:.4g} J were given, "
                        f"after {self.reference:.4g} J in all")


def outcome(seed, counts):
    """Run one scene; None, or a sentence that describes the error. Counts events and steps."""
    rng = np.random.default_rng([seed, 1])
    scene = draw(rng)
    material = scene_fuzzer.begin(scene)
    if not scene["periodic"]:
        container(scene, material)
    for _ in range(scene["count"]):
        add(scene, material, rng)
    scene_fuzzer.engines(scene)
    if scene["periodic"]:
        O.cell.velGrad = scenes.plane(*scene["gradient"])
    watch, what = Watch(scene), "the start"
    try:
        for _ in range(EVENTS):
            for _ in range(STEPS):
                watch.step()
            what = str(rng.choice(["added", "added", "erased", "hits", "frictions", "threads",
                                   "solvers", "laws", "saves", "gradients"]))
            if change(what, scene, O.materials[0], rng):
                counts[what] += 1
                watch.restart()
            if not movable():
                break
    except Wrong as wrong:
        return f"{wrong}, {watch.steps} steps after the start, the last event {what}, in {scene}"
    except (ValueError, RuntimeError) as error:
        for words, name, possible in (("jam", "jams", scene["turning"] or scene["periodic"]),
                                      ("O.cell.flipCell", "sheared", scene["periodic"]),
                                      ("overlap by", "too soft", watch.too_soft),
                                      ("Take a smaller O.dt", "too fast", HIT * O.dt > R)):
            if words in str(error) and possible:
                counts[name] += 1
                return None
        return f"refused: {error}, step {watch.steps}, the last event {what}, in {scene}"
    finally:
        counts["steps"] += watch.steps
        counts["missed"] += watch.missed
    return None


def let_go(held):
    """Drop references to objects that are not `held` and have no owner in Python; their number.

    YADE 2025.2 keeps a reference to each member of a list that it receives (PySequence_GetItem in
    custom_vector_from_seq): plain YADE grows by 37 kB with each scene of twenty spheres.
    """
    gc.collect()
    kinds = yade.wrapper.Serializable, Vector3
    objects = tuple([o for o in gc.get_objects() if isinstance(o, kinds) and id(o) not in held])
    owned = {id(o) for owner in gc.get_referrers(*objects) if owner is not objects
             for o in gc.get_referents(owner)}
    dropped = 0
    for o in objects:
        unowned = 0 if id(o) in owned else sys.getrefcount(o) - 3  # `objects`, `o` and the argument
        for _ in range(unowned):
            ctypes.pythonapi.Py_DecRef(ctypes.py_object(o))
        dropped += unowned
    return dropped


def resident():
    """Memory of this process after free memory was returned [MB]."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return memory("VmRSS") / 1e6


def growth(samples):
    """Growth [%] from the first to the last quarter of (seconds, MB) after the warm-up; sizes."""
    sizes = [size for at, size in samples if at > WARM_UP * samples[-1][0]] or [0.0]
    if len(sizes) < 8:
        return 0.0, sizes
    first, last = sizes[: len(sizes) // 4], sizes[-len(sizes) // 4 :]
    return 100 * (np.mean(last) / np.mean(first) - 1), sizes


def main():
    parser = children.parser(__doc__, scenes=sys.maxsize)
    parser.add_argument("--minutes", type=float, default=20, help="how long (default %(default)s)")
    parser.add_argument("--growth", type=float, default=1.0, metavar="PERCENT",
                        help="of memory, after a quarter of the time (default %(default)s)")
    options = parser.parse_args()
    held = {id(o): o for o in gc.get_objects() if isinstance(o, yade.wrapper.Serializable)}
    start, samples = time.monotonic(), []

    def of_seed(seed):
        counts = collections.Counter()
        wrong = outcome(seed, counts)
        O.reset()
        counts["references"] = let_go(held)
        return wrong, {**counts, "memory": (os.getpid(), time.monotonic() - start, resident())}

    def sample(seed, numbers):
        if numbers:  # no crash
            samples.append(numbers.pop("memory"))
            _, at, size = samples[-1]
            print(f"seed {seed}: {size:.1f} MB after {at:.0f} s", flush=True)

    counts, wrong = children.check(of_seed, options, 60 * options.minutes, sample)
    grown, sizes = growth([sample[1:] for sample in samples if sample[0] == samples[-1][0]])
    first = options.first if options.only is None else options.only
    last = first + counts["scenes"] - 1
    told = ", ".join(f"{counts.pop(name)} {name}" for name in ("scenes", "steps"))
    told += "".join(f", {count} {name}" for name, count in sorted(counts.items()))
    seeds = f": seeds {', '.join(map(str, wrong))}" if wrong else ""
    flat = grown <= options.growth
    print(f"soak: {told}; {len(wrong)} wrong{seeds}; memory {sizes[0]:.1f} to {sizes[-1]:.1f} MB, "
          f"{grown:+.2f} % since the warm-up{'' if flat else ': GROWS'}; seeds {first} to {last}")
    sys.exit(bool(wrong) or not flat)


if __name__ == "__main__":
    main()
