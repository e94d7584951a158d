#!/usr/bin/env python3
"""Soak: random scenes with repeated changes in one process.

Scenes hold discs, Rcrs and clumps within walls, boxes, facets, fixed Rcrs, or in a periodic cell.
Grains are added, erased and hit at up to 100 m/s. Friction, threads, solver and law change. Scenes
are saved and loaded. After each step these must hold:

  * all numbers are finite, and no grain has left the box
  * no overlap is deep, unless a message says why
  * the residual is within the tolerance
  * rigid contacts create no energy, where the time step resolves the motion

    scripts/check soak -- --minutes 20 [--first 0]
    scripts/lib/run python3 tests/endurance/soak.py --only SEED

The last line prints counts, memory and the next seed. A failed scene is printed with its seed. The
scenes run in a child process; a crash or hang is printed, and the soak continues after it.
"""

import argparse
import collections
import ctypes
import gc
import os
import signal
import subprocess
import sys
import tempfile
import time
import warnings

import scene_fuzzer
from scene_fuzzer import R, WIDTH

EVENTS = 12  # events of a scene
STEPS = 80  # steps between two events
LIMIT = 600  # processor time of a scene [s]
HIT = 100.0  # largest speed of a hit [m/s]
MISSED_STEPS_HEAL = 200  # steps; overlaps may stay deep after a step that missed the tolerance
# Displacement of a surface in a step over R. Beyond it a rod may meet the same neighbour twice in a
# step, which its laws exclude.
RESOLVED = 1.0
# apparent energy gain of rigid contacts over the total: the tolerance, step after step
ENERGY = 0.02
# error of velocities at rest over g dt: kinematicTolerance times Settings::velocityFloor
AT_REST = 1e-4
WARM_UP = 0.25  # share of the time after which memory stays constant
SAME_BITS = 5  # steps that are compared after a reload


def draw(rng):
    """A scene of the scene fuzzer as plain data, without faults, closed, and with more grains."""
    scene = scene_fuzzer.draw(rng)
    scene.update(fault="none", overdamped=scene["overdamped"] and scene["law"] == "rigid",
                 turning=scene["turning"] and not scene["periodic"])
    scene["floor"] = str(rng.choice(["Wall", "Box", "Facet", "Rcr"]))
    scene["count"] = int(rng.integers(2, 50))
    scene["speed"] = min(scene["speed"], 20.0)
    if scene["gradient"]:
        a, b, c = (float(rate) for rate in rng.choice([0, 0, -0.3, 0.3], 3))
        scene["gradient"] = [a, b, c, -a]  # constant volume: no compression of the grains
    return scene


def container(scene, material):
    """Four obstacles around |x|, |y| < WIDTH/2; some scenes have a turning box inside."""
    import rcr
    from yade import O, utils

    half, out = WIDTH / 2, 3 * WIDTH
    for axis in (0, 1):
        for side in (-1, 1):
            swap = lambda along, across: (along, across) if axis == 0 else (across, along)
            if scene["floor"] == "Wall":
                O.bodies.append(rcr.wall("xy"[axis], side * half, sense=-side, material=material))
            elif scene["floor"] == "Box":
                O.bodies.append(utils.box((*swap(side * (half + 0.5), 0), 0), (*swap(0.5, out), 1),
                                          material=material, fixed=True))
            elif scene["floor"] == "Facet":
                O.bodies.append(
                    utils.facet([(*swap(side * half, -out), -1), (*swap(side * half, out), -1),
                                 (*swap(side * half, 0), 1)], material=material))
            else:
                O.bodies.append(rcr.particle(swap(side * (half + 0.1), 0), 5, 0.98, angle=0 if axis
                                             else 3.141592653589793 / 2, fixed=True,
                                             material=material))
    if scene["turning"]:
        box = utils.box((0, 0, 0), (3 * R, 0.2 * R, 1), material=material, fixed=True)
        box.state.angVel = (0, 0, 5)
        O.bodies.append(box)


def movable():
    """Grains and clumps that can move, without members of clumps."""
    from yade import O

    return [b for b in O.bodies if not b.isClumpMember and "x" not in b.state.blockedDOFs]


def add(scene, material, rng):
    """Append a grain at a free place; False if there is none."""
    import numpy as np
    from yade import O

    others = np.array([[b.state.pos[0], b.state.pos[1]] for b in movable()]).reshape(-1, 2)
    for _ in range(30):
        at = rng.uniform(-WIDTH / 2 + 1.2 * R, WIDTH / 2 - 1.2 * R, 2) + (WIDTH / 2
            if scene["periodic"] else 0)
        away = others - at
        if scene["periodic"]:
            cell = np.array(O.cell.hSize)[:2, :2]
            away = away - np.rint(away @ np.linalg.inv(cell).T) @ cell.T
        if (np.hypot(*away.T) > 2.1 * R).all() and not (scene["turning"] and np.hypot(*at) < 4.2
                                                        * R):
            scene_fuzzer.grain(str(rng.choice(["Rcr", "Sphere", "clump"], p=[0.6, 0.3, 0.1])),
                               tuple(at), rng.choice([0, 0.3, 0.6, 0.9]), scene["speed"], material,
                               rng)
            return True
    return False


def change(what, scene, material, rng):
    """Apply one event; False where it does not fit the scene."""
    import rcr
    from yade import O, utils

    grains = movable()
    solver = next((e for e in O.engines if isinstance(e, rcr.ContactDynamics)), None)
    if what == "added":
        return add(scene, material, rng)
    if what == "erased":
        if scene["periodic"] or len(
                grains) < 2:  # YADE's collider fails after an erase in a cell
            return False
        body = grains[rng.integers(len(grains))]
        O.bodies.erase(body.id, body.isClump)
    elif what == "hits":
        body = grains[rng.integers(len(grains))]
        body.state.vel = (*(rng.uniform(-1, 1, 2) * HIT / 2**0.5
                            * (1 if scene["law"] == "rigid" else 0.05)), 0)
    elif what == "frictions":
        utils.setContactFriction(float(rng.uniform(0, 0.8)))
    elif what == "threads":
        if not solver:
            return False
        solver.threads = int(rng.integers(1, 5))
    elif what == "solvers":
        if not solver:
            return False
        solver.solver = str(rng.choice(["auto", "nlgs", "sor", "nesterov", "exact"]))
    elif what == "laws":
        scene["law"] = "smooth" if solver else "rigid"
        scene["dt"] = float(rng.choice([1e-4, 1e-3, 5e-3]))
        O.interactions.clear()
        scene_fuzzer.engines(scene)
        if scene["law"] == "smooth":  # springs need slower grains than rigid contacts
            for body in movable():
                if body.state.vel.norm() > 5:
                    body.state.vel = body.state.vel * (5 / body.state.vel.norm())
    elif what == "gradients":
        if not scene["periodic"]:
            return False
        scene["gradient"] = [-rate for rate in scene["gradient"]]
        scene_fuzzer.shear_cell(scene["gradient"])
    else:
        return same_bits_after_reload(scene)
    return True


def same_bits_after_reload(scene):
    """Save and run, load and run again; both must give the same bits, with springs to rounding."""
    import numpy as np
    from yade import O

    with tempfile.NamedTemporaryFile(suffix=".yade") as file:
        O.save(file.name)
        run(SAME_BITS)
        straight = scene_fuzzer.state()
        O.load(file.name)
        run(SAME_BITS)
        rounding = 1e-13 * np.abs(straight).max() if scene["law"] == "smooth" else 0
        if not np.allclose(scene_fuzzer.state(), straight, rtol=0, atol=rounding):
            raise Wrong(f"other bits after a reload: they differ by up to "
                        f"{np.abs(scene_fuzzer.state() - straight).max():.3g}")
        O.load(file.name)
    return True


def run(steps):
    from yade import O

    for _ in range(steps):
        O.step()


class Wrong(Exception):
    """A condition is violated."""


class Watch:
    """Conditions of a scene after each step."""

    def __init__(self, scene):
        self.scene, self.healing, self.missed, self.steps = scene, 0, 0, 0
        self.deepOverlapCount = self.astray = False
        # overlap left by springs; rigid contacts remove it by 1e-4 R a step
        self.inherited = 0.0
        self.restart()

    def restart(self):
        """Forget energies after a change from outside."""
        self.given, self.way, self.lifted = None, 0.0, 0.0

    def energies(self):
        """Kinetic energy, work of gravity in a step [J], longest displacement of a surface [m]."""
        from yade import O

        kinetic = work = way = 0.0
        for b in movable():
            v, w = b.state.vel, b.state.angVel[2]
            way = max(way, O.dt * (v.norm() + abs(w) * R))
            kinetic += 0.5 * (b.state.mass * (v[0] ** 2 + v[1] ** 2) + b.state.inertia[2] * w**2)
            work -= b.state.mass * self.scene["gravity"] * v[1] * O.dt
        return kinetic, work, way

    def step(self):
        import numpy as np
        import rcr
        from yade import O

        O.step()
        self.steps += 1
        now = scene_fuzzer.state()
        if not np.isfinite(now).all():
            raise Wrong("numbers that are not finite")
        solver = next((e for e in O.engines if isinstance(e, rcr.ContactDynamics)), None)
        if solver:
            self.missed += not solver.converged
            self.healing = MISSED_STEPS_HEAL if not solver.converged else max(0, self.healing - 1)
            if not np.isfinite([solver.residual, solver.kinematicError]).all():
                raise Wrong(f"a residual of {solver.residual}, a violation of "
                            f"{solver.kinematicError}")
            if solver.converged and not solver.yielded and solver.residual > solver.tolerance:
                raise Wrong(f"a converged step with a residual of {solver.residual:.3g}")
        if not self.scene["periodic"]:
            places = np.array([[b.state.pos[0], b.state.pos[1]] for b in movable()])
            self.astray = self.astray or (np.abs(places).max() > WIDTH / 2 and self.told())
            if np.abs(places).max() > WIDTH / 2 and not self.astray:
                raise Wrong(f"a grain at {np.abs(places).max():.3g} m, outside the box of half "
                            f"width {WIDTH / 2:.3g}")
        if self.steps % 4 == 0:
            deepest = scene_fuzzer.deepest_overlap()
            self.inherited = min(self.inherited, deepest) if solver else deepest
            if deepest > (max(scene_fuzzer.DEEPEST, 1.05 * self.inherited) if solver
                          else 0.5) and not self.healing:
                raise Wrong(f"an overlap of {deepest:.3g} (R₁ + R₂)")
        driven = self.scene["turning"] or (self.scene["gradient"] and any(self.scene["gradient"]))
        if solver and not driven and not self.scene["overdamped"]:
            self.no_gain()

    def told(self):
        """True if a message has told of grains outside: missed tolerance, or too soft springs."""
        from yade import O
        from yade.wrapper import InteractionLoop

        laws = [functor for e in O.engines if isinstance(e, InteractionLoop)
                for functor in e.lawDispatcher.functors]
        self.deepOverlapCount = self.deepOverlapCount or any(getattr(law, "deepOverlapCount", 0) for law in laws)
        return self.healing or self.deepOverlapCount

    def no_gain(self):
        """Kinetic energy grows by at most the work of gravity, m g v̄ dt.

        v̄ is the mean of the velocities before and after the step.
        """
        from yade import O

        kinetic, work, way = self.energies()
        if self.given is None or max(way, self.way) > RESOLVED * R:
            self.given, self.reference, self.work, self.way = kinetic, kinetic, work, way
            return
        self.given += 0.5 * (work + self.work)
        self.reference += 0.5 * (abs(work) + abs(self.work))
        self.work, self.way = work, way
        self.lifted += AT_REST * (self.scene["gravity"] * O.dt) ** 2 * sum(b.state.mass
            for b in movable())
        if kinetic - self.given > ENERGY * self.reference + self.lifted + 1e-9:
            raise Wrong(f"a kinetic energy of {kinetic:.4g} J where {self.given:.4g} J were given, "
                        f"after {self.reference:.4g} J in all")


def outcome(seed, counts):
    """Run one scene; None, or a sentence that describes the error."""
    import numpy as np
    from yade import O

    rng = np.random.default_rng([seed, 1])
    scene = draw(rng)
    material = scene_fuzzer.begin(scene)
    if not scene["periodic"]:
        container(scene, material)
    for _ in range(scene["count"]):
        add(scene, material, rng)
    scene_fuzzer.engines(scene)
    if scene["periodic"]:
        scene_fuzzer.shear_cell(scene["gradient"])
    watch = Watch(scene)
    what = "the start"
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
        if "jam" in str(error) and (scene["turning"] or scene["periodic"]):
            counts["jams"] += 1
            return None
        if "O.cell.flipCell" in str(error) and scene["periodic"]:
            counts["sheared"] += 1
            return None
        return f"refused: {error}, step {watch.steps}, the last event {what}, in {scene}"
    finally:
        counts["steps"] += watch.steps
        counts["missed"] += watch.missed
    return None


def let_go(held):
    """Drop unowned references to objects that are not `held`; return their number.

    YADE 2025.2 keeps a reference to each member of a list that it receives (PySequence_GetItem in
    custom_vector_from_seq) and never frees engines and functors: plain YADE grows by 37 kB with
    each scene of twenty spheres. Objects with an owner in Python stay.
    """
    from yade import wrapper
    from yade.minieigenHP import Vector3

    gc.collect()
    objects = tuple([o for o in gc.get_objects() if isinstance(o, (wrapper.Serializable, Vector3))
                     and id(o) not in held])
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
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def scenes(first, seconds, most):
    """Run scenes in the child process until the time is over; print lines that `main` reads."""
    warnings.simplefilter("ignore")
    import yade
    import rcr

    held = {id(o): o for o in gc.get_objects() if isinstance(o, yade.wrapper.Serializable)}
    start, seed = time.monotonic(), first
    while time.monotonic() - start < seconds and seed < first + most:
        signal.setitimer(signal.ITIMER_PROF, LIMIT)
        print(f"seed {seed}", flush=True)
        counts = collections.Counter()
        wrong = outcome(seed, counts)
        yade.O.reset()
        counts["references"] = let_go(held)
        signal.setitimer(signal.ITIMER_PROF, 0)
        print(f"memory {time.monotonic() - start:.1f} {resident():.2f}", flush=True)
        print("counts", *(f"{name} {count}" for name, count in counts.items()), flush=True)
        if wrong:
            print(f"wrong {wrong}", flush=True)
        seed += 1


def main():
    parser = argparse.ArgumentParser(prog="soak.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=20, help="how long (default %(default)s)")
    parser.add_argument("--scenes", type=int, default=sys.maxsize, help="at most so many")
    parser.add_argument("--first", type=int, default=0, metavar="SEED",
                        help="of the first scene (default %(default)s)")
    parser.add_argument("--only", type=int, metavar="SEED", help="run this scene alone, in this "
                        "process")
    parser.add_argument("--growth", type=float, default=1.0, metavar="PERCENT",
                        help="of memory, after a quarter of the time (default %(default)s)")
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.only is not None:
        return scenes(options.only, float("inf"), 1)
    if options.child:
        return scenes(options.first, 60 * options.minutes, options.scenes)
    end = time.monotonic() + 60 * options.minutes
    counts, wrong, memory = collections.Counter(), [], []
    seed, last = options.first, options.first + options.scenes
    while time.monotonic() < end and seed < last:
        memory = []  # samples of one process
        left = (end - time.monotonic()) / 60
        command = [sys.executable, __file__, "--child", "--minutes", str(left), "--first",
                   str(seed), "--scenes", str(last - seed)]
        child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        for line in child.stdout:
            word, _, rest = line.strip().partition(" ")
            if word == "seed":
                seed = int(rest)
            elif word == "memory":
                memory.append([float(number) for number in rest.split()])
                print(f"seed {seed}: {memory[-1][1]:.1f} MB after {memory[-1][0]:.0f} s",
                      flush=True)
            elif word == "counts":
                numbers = rest.split()
                counts.update(
                    {name: int(count) for name, count in zip(numbers[::2], numbers[1::2])})
                counts["scenes"] += 1
            elif word == "wrong":
                wrong.append(seed)
                print(f"seed {seed}: {rest}", flush=True)
        if child.wait():
            counts["scenes"] += 1
            wrong.append(seed)
            print(f"seed {seed}: the process ended with {child.returncode}", flush=True)
        seed += 1
    warm = [size for at, size in memory if at > WARM_UP * memory[-1][0]] if memory else []
    growth = 100 * (sum(warm[-len(warm) // 4 :]) / len(warm[-len(warm) // 4 :]) / (
        sum(warm[: len(warm) // 4]) / (len(warm) // 4)) - 1) if len(warm) >= 8 else 0.0
    told = ", ".join(f"{counts.pop(name)} {name}" for name in ("scenes", "steps"))
    told += "".join(f", {count} {name}" for name, count in sorted(counts.items()))
    flat = growth <= options.growth
    print(f"soak: {told}; {len(wrong)} "
          f"wrong{': seeds ' + ', '.join(map(str, wrong)) if wrong else ''}; "
          f"memory {warm[0] if warm else 0:.1f} to {warm[-1] if warm else 0:.1f} MB, {growth:+.2f} "
          f"% since the warm-up{'' if flat else ': GROWS'}; seeds {options.first} to "
          f"{seed - 1}")  # fmt: skip
    sys.exit(bool(wrong) or not flat)


if __name__ == "__main__":
    main()
