"""Random scenes run with residual, overlap and energy within their bounds, or are refused before
anything moves. Prints counts, and seed and outcome of each scene that does neither.

    scripts/lib/run python3 tests/endurance/scene_fuzzer.py --scenes 2000 [--first 0] [--steps 60]
"""

import math
import os
import pathlib
import sys

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Quaternion

import children
import outlines

TESTS = pathlib.Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / "yade"), str(TESTS)]
import scenes  # noqa: E402
from scenes import insert, set_state, without  # noqa: E402

NAN = math.nan
R = 0.1  # radius of the grains [m]
WIDTH = 24 * R  # of the box of soak.py [m]
CELL = 13.4 * R  # width of a periodic cell, in which images of a full row nearly meet [m]
DEEPEST = 0.01  # largest overlap of free grains over R₁ + R₂
SPEED = 3.0  # largest speed over that of start, drives and fall
KINDS = ["Rcr", "Sphere", "RoundedPolygon", "moving clump"]  # of grains
SHARES = [0.35, 0.2, 0.35, 0.1]


def draw(rng):
    """A scene as plain data, so that it can be printed."""
    periodic = rng.random() < 0.2
    law = "rigid" if rng.random() < 0.7 else "smooth"
    return dict(
        law=law, periodic=periodic, count=int(rng.integers(1, 25)),
        eta=float(rng.choice([0, 0.3, 0.6, 0.9])), friction=float(rng.choice([0, 0.3, 0.8])),
        restitution=float(rng.choice([0, 0, 0.5, 1])),
        gravity=float(rng.choice([0, 9.81])) if not periodic else 0.0,
        dt=float(rng.choice([1e-4, 1e-3, 5e-3])) if law == "rigid" else None,
        solver=str(rng.choice(["auto", "nlgs", "sor", "nesterov", "exact"])),
        threads=int(rng.integers(1, 4)), overdamped=bool(rng.random() < 0.05),
        kinds=[str(k) for k in rng.choice(KINDS, 25, p=SHARES)],
        floor=str(rng.choice([*scenes.FLOORS, "none"])),
        turning=bool(rng.random() < 0.1), speed=float(rng.choice([0, 1, 20])),
        energy=bool(rng.random() < 0.3),
        gradient=[float(g) for g in rng.choice([0, 0, -1, 0.5], 4)] if periodic else None,
        homoDeform=int(rng.choice([0, 1, 2])) if periodic else None, width=CELL,
        fault=str(rng.choice(["none"] * 12 + list(FAULTS))), reload=bool(rng.random() < 0.1),
        erase=bool(rng.random() < 0.2) and not periodic,  # YADE's collider fails in a cell
    )  # fmt: skip


def obstacles(scene, material):
    """Append the floor, and a turning box above it if the scene has one."""
    if scene["floor"] != "none":
        O.bodies.append(scenes.FLOORS[scene["floor"]](material))
    if scene["turning"]:
        add_turning_box((0.3, 0.3, 0), material)


def add_turning_box(center, material):
    box = utils.box(center, (0.3, 0.02, 1), material=material, fixed=True)
    set_state(O.bodies.append(box), angVel=(0, 0, 5))


def corners_of(rng, size, eta):
    """Corners and rounding radius of a random polygon with the circumscribed radius `size` [m].

    3 to 8 corners lie on an ellipse of the elongation `eta`.
    """
    count, rounding = int(rng.integers(3, 9)), float(rng.choice([0, 0, 0.05, 0.3]))
    turn = 2 * np.pi / count * (np.arange(count) + rng.uniform(-0.4, 0.4, count))
    corners = np.column_stack([np.cos(turn), (1 - eta) * np.sin(turn)])
    for _ in range(20):  # the rounding moves the centroid
        corners = corners - rcr._kernel.polygon_moments(corners, rounding)[1]
        corners *= (1 - rounding) / np.hypot(*corners.T).max()
    return size * corners, size * rounding


def grain(kind, at, eta, speed, material, rng):
    """Append a grain of this kind with a velocity up to `speed` along each axis; a clump rests."""
    more = dict(material=material, velocity=tuple(rng.uniform(-1, 1, 2) * speed),
                angular_velocity=rng.uniform(-1, 1) * speed / R)
    if kind == "Sphere":
        O.bodies.append(rcr.disc(at, R, **more))
    elif kind == "Rcr":
        O.bodies.append(rcr.particle(at, R, eta, angle=rng.uniform(0, 3), **more))
    elif kind == "RoundedPolygon":
        corners, rounding = corners_of(rng, R, eta)
        O.bodies.append(rcr.polygon(at, corners, rounding, angle=rng.uniform(0, 3), **more))
    else:
        half = R / 2
        members = [rcr.disc((at[0] + s * half, at[1]), half, material=material) for s in (-1, 1)]
        state = O.bodies[rcr.clump(members)[0]].state
        if kind == "moving clump":
            state.vel, state.angVel = (*more["velocity"], 0), (0, 0, more["angular_velocity"])


def engines(scene):
    """Put the engines of the scene's law into O, with its time step."""
    rigid = scene["law"] == "rigid"
    options = {name: scene[name] for name in ("solver", "threads", "overdamped")}
    options |= dict(restitution=scene["restitution"] or None)
    O.engines = scenes.engines(gravity=(0, -scene["gravity"], 0), **(
        options if rigid else dict(law="smooth", damping=0.3)))
    O.dt = scene["dt"] if rigid else 2e-5


def solver():
    """The first engine ContactDynamics, or None."""
    return next((e for e in O.engines if isinstance(e, rcr.ContactDynamics)), None)


def loose_grains():
    """Free grains outside clumps."""
    return [b for b in O.bodies if b.state.blockedDOFs == "zXY" and not b.isClump
            and not b.isClumpMember]


def begin(scene):
    """An empty scene, in a cell of its width if periodic; returns the material of its bodies."""
    O.reset()
    material = scenes.springy(scene["friction"])
    O.materials.append(material)
    if scene["periodic"]:
        O.periodic = True
        O.cell.setBox(*3 * [scene["width"]])
    return material


def build(scene, rng):
    material = begin(scene)
    if not scene["periodic"]:
        obstacles(scene, material)
    step = 2.6 * R
    for k in range(scene["count"]):
        along, up = step * (k % 5), step * (k // 5)
        at = (along + R, up + R) if scene["periodic"] else (along + rng.uniform(0, 0.2 * R) - 6 * R,
                                                            0.8 + up)
        grain(scene["kinds"][k], at, scene["eta"], scene["speed"], material, rng)
    engines(scene)
    if scene["periodic"]:
        O.cell.velGrad = scenes.plane(*scene["gradient"])
        O.cell.homoDeform = scene["homoDeform"]
    O.trackEnergy = scene["energy"]


LATE = {"no geometry", "huge friction", "negative restitution"}  # found by the first contact


def put(functors, *new):
    """Give a dispatcher these functors only."""
    functors.functors = list(new)


def put_box(make, *arguments, **options):
    O.bodies.append(make(*arguments, material=O.materials[0], **options))


def a_polygon():
    """The first loose polygon, or None."""
    return next((b for b in loose_grains() if isinstance(b.shape, rcr.RoundedPolygon)), None)


def reshape(**values):
    """Set attributes of a polygon, which refuses them."""
    for name, value in values.items():
        try:
            setattr(a_polygon().shape, name, value)
        except ValueError:
            pass


FAULTS = {  # {fault: (what the scene needs, function of the first loose grain)}
    "no solver": ("rigid", lambda b: without(rcr.ContactDynamics)),
    "dead solver": ("rigid", lambda b: setattr(solver(), "dead", True)),
    "two solvers": ("rigid", lambda b: insert(3, rcr.ContactDynamics())),
    "no integrator": ("", lambda b: without(w.NewtonIntegrator)),
    "two integrators": ("", lambda b: insert(9, w.NewtonIntegrator(damping=0))),
    "no collider": ("", lambda b: without(w.InsertionSortCollider)),
    "no bound": ("", lambda b: put(O.engines[1].boundDispatcher)),
    "no resetter": ("", lambda b: without(w.ForceResetter)),
    "late force": ("rigid", lambda b: insert(-1, w.ForceEngine(force=(1, 0, 0), ids=[0]))),
    "damping": ("rigid", lambda b: setattr(O.engines[-1], "damping", 0.3)),
    "solver first": ("rigid", lambda b: setattr(
        O, "engines", [O.engines[k] for k in (0, 1, 3, 2, 4)])),
    "no law": ("", lambda b: put(O.engines[2].lawDispatcher)),
    "no physics": ("", lambda b: put(O.engines[2].physDispatcher)),
    "no geometry": ("", lambda b: put(O.engines[2].geomDispatcher)),
    "stock geometry": ("", lambda b: put(
        O.engines[2].geomDispatcher, *O.engines[2].geomDispatcher.functors,
        w.Ig2_Sphere_Sphere_ScGeom())),
    "no vertices": ("polygon", lambda b: reshape(vertices=[])),
    "negative rounding": ("polygon", lambda b: reshape(radius=-1)),
    "clockwise": ("polygon", lambda b: reshape(vertices=a_polygon().shape.vertices[::-1])),
    "no functors of polygons": ("polygon two", lambda b: put(O.engines[2].geomDispatcher, *[
        f for f in O.engines[2].geomDispatcher.functors if "Polygon" not in type(f).__name__])),
    "nan position": ("grain", lambda b: set_state(b.id, pos=(NAN, 0, 0))),
    "nan velocity": ("grain", lambda b: set_state(b.id, vel=(NAN, 0, 0))),
    "nan orientation": ("grain", lambda b: set_state(b.id, ori=Quaternion(NAN, NAN, NAN, NAN))),
    "zero mass": ("grain", lambda b: set_state(b.id, mass=0)),
    "zero inertia": ("grain", lambda b: set_state(b.id, inertia=(1, 1, 0))),
    "free z": ("grain", lambda b: set_state(b.id, blockedDOFs="XY")),
    "tilted": ("grain", lambda b: set_state(b.id, ori=Quaternion((1, 0, 0), 0.3))),
    "another plane": ("grain two", lambda b: set_state(b.id, pos=(*list(b.state.pos)[:2], 0.7))),
    "box out of plane": ("open", lambda b: put_box(utils.box, (0, 0, 9), (1, 1, 1), fixed=True)),
    "elastic material": ("grain", lambda b: setattr(b, "material", w.ElastMat(density=1000))),
    "nan force": ("rigid grain", lambda b: O.forces.setPermF(b.id, (NAN, 0, 0))),
    "huge friction": ("rigid", lambda b: setattr(O.materials[0], "frictionAngle", math.pi / 2)),
    "negative restitution": ("rigid", lambda b: scenes.prescribe("restitution", -0.5)),
    "zero dt": ("", lambda b: setattr(O, "dt", 0)),
    "wall in cell": ("cell", lambda b: put_box(rcr.wall, "y", 0)),
    "stepper": ("rigid", lambda b: insert(0, w.GlobalStiffnessTimeStepper())),
    "facet out of plane": ("open", lambda b: put_box(utils.facet, [(0, 0, 3), (1, 0, 3),
                                                                   (0, 0, 4)])),
    "stock clump": ("", lambda b: O.bodies.appendClumped(
        [rcr.disc((x, 50), 0.1, material=O.materials[0]) for x in (50, 50.1)])),
}  # fmt: skip


def spoil(scene):
    """Put the fault into the scene; False where it does not apply, "late" if a contact shows it."""
    fault, body = scene["fault"], next(iter(loose_grains()), None)
    grains = sum(isinstance(b.shape, (rcr.Rcr, rcr.RoundedPolygon, w.Sphere)) for b in O.bodies)
    there = dict(rigid=scene["law"] == "rigid", grain=body is not None, two=grains > 1,
                 polygon=a_polygon() is not None, open=not scene["periodic"],
                 cell=scene["periodic"])
    needs, change = FAULTS.get(fault, ("none", None))
    if not all(there.get(need) for need in needs.split()):
        return False
    change(body)
    return "late" if fault in LATE else True


def state():
    return np.array([[*b.state.pos, *b.state.vel, *b.state.angVel] for b in O.bodies])


def deepest_overlap():
    """Deepest overlap over R₁ + R₂ of all pairs with a body that can move."""
    deepest = 0.0
    for i in O.interactions:
        moving = any(O.bodies[b].state.blockedDOFs != "xyzXYZ" or O.bodies[b].isClumpMember
                     for b in (i.id1, i.id2))
        if moving and isinstance(i.geom, rcr.RcrGeom):
            gap = min((i.geom.gap[p] for p in range(i.geom.points)), default=0)
            deepest = max(deepest, -gap / (i.geom.refR1 + i.geom.refR2))
    return deepest


class Bounds:
    """Bounds of speed, overlap and energy of a scene; `violated` returns a sentence or None."""

    def __init__(self, scene, steps):
        self.scene, self.missed, self.total, self.deepest = scene, False, None, 0
        self.speed = (scene["speed"] * 2 + 5 * 0.4 * scene["turning"] + 0.5
                      + scene["gravity"] * O.dt * steps)
        self.cell = np.abs(scene["gradient"]).max() * 2.4 * 1.5 if scene["periodic"] else 0

    def violated(self, after_first):
        now = state()
        if not np.isfinite(now).all():
            return "numbers that are not finite"
        fastest = np.abs(now[:, 3:5]).max() if len(now) else 0
        if fastest > SPEED * self.speed + self.cell:
            return f"a grain at {fastest:.3g} m/s, where {self.speed:.3g} was given"
        return self.overlap_violated() or (self.energy_violated() if after_first else None)

    def overlap_violated(self):
        """Only steps that have not converged may deepen an overlap beyond the bound."""
        bound = max(DEEPEST if self.scene["law"] == "rigid" else 0.3, self.deepest)
        self.deepest = deepest = deepest_overlap()
        solvers = [e for e in O.engines if isinstance(e, rcr.ContactDynamics)]
        before, self.missed = self.missed, not all(e.converged for e in solvers)
        if deepest > bound and not before and not self.missed:  # contacts show it a step later
            return f"an overlap of {deepest:.3g} (R₁ + R₂)"

    def detection_violated(self):
        """An overlap of the bodies at the end that no contact shows, by an independent distance."""
        if self.scene["periodic"] or self.scene["law"] != "rigid" or self.missed:
            return None
        seen, found = max(DEEPEST, self.deepest, deepest_overlap()), outlines.deepest_overlap()
        if found > seen + DEEPEST:  # of the last step
            return f"an overlap of {found:.3g} (R₁ + R₂), where contacts show {seen:.3g}"

    def energy_violated(self):
        scene = self.scene
        rigid = scene["law"] == "rigid" and not scene["overdamped"]
        if not scene["energy"] or scene["periodic"] or not rigid:
            return None
        scale = sum(abs(account) for _, account in O.energy.items()) + 1e-12
        self.total = O.energy.total() if self.total is None else self.total
        # YADE's leapfrog shifts each account by half a step
        lag = scene["gravity"] * O.dt * sum(b.state.mass * b.state.vel.norm() for b in O.bodies)
        if abs(O.energy.total() - self.total) > 0.02 * scale + lag + 1e-6:
            return f"energy off by {O.energy.total() - self.total:.3g} J of {scale:.3g}"


def disturb(scene, k, steps):
    """Reload the scene, or erase a grain, in the steps of the scene; energy is not checked then."""
    if scene["reload"] and k == steps // 2:
        path = f"/tmp/scene-fuzzer-{os.getpid()}.yade"
        O.save(path), O.load(path), os.unlink(path)
    if scene["erase"] and k == steps // 3 and len(loose := loose_grains()) > 1:
        O.bodies.erase(loose[0].id)
        scene["energy"] = False


def outcome(seed, steps):
    """'ran', 'refused' or a sentence that describes the error."""
    rng = np.random.default_rng(seed)
    scene = draw(rng)
    build(scene, rng)
    spoiled = spoil(scene)
    bounds = Bounds(scene, steps)
    zero_smooth = scene["fault"] == "zero dt" and scene["law"] == "smooth"
    for k in range(steps):
        old = state()
        try:
            O.step()
        except (ValueError, RuntimeError) as error:
            if not np.array_equal(state(), old, equal_nan=True):
                return f"refused after something had moved: {error}"
            if not spoiled and "squeeze" not in str(error) and "jam" not in str(error):
                return f"refused without a fault: {error}"
            return "refused"
        if spoiled is True and not zero_smooth:
            return f"accepted with the fault '{scene['fault']}'"
        if wrong := bounds.violated(k > 0):
            return f"{wrong} after step {k}"
        disturb(scene, k, steps)
    if not spoiled and (wrong := bounds.detection_violated()):
        return wrong
    if spoiled == "late" and scene["law"] == "rigid" and O.interactions.countReal():
        return f"ran with the fault '{scene['fault']}'"
    return "ran"


def main():
    parser = children.parser(__doc__, scenes=2000)
    parser.add_argument("--steps", type=int, default=60, help="of a scene (default %(default)s)")
    options = parser.parse_args()

    def of_seed(seed):
        what = outcome(seed, options.steps)
        return (None, {what: 1}) if what in ("ran", "refused") else (what, {})

    children.main(options, of_seed, lambda seed: draw(np.random.default_rng(seed)))


if __name__ == "__main__":
    main()
