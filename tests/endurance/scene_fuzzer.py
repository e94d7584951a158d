"""Random scenes: shapes, laws, engines, their order, states of bodies, boundary conditions.

A scene runs with residual, overlap and energy within their bounds, or is rejected before anything
moves.

    scripts/lib/run python3 tests/endurance/scene_fuzzer.py --scenes 2000 [--first 0] [--steps 60]

prints counts, and seed and outcome of each scene that does neither. `--only SEED` runs one scene in
this process.
"""

import math
import os
import sys

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Matrix3, Quaternion

import children

R = 0.1  # radius of the grains [m]
WIDTH = 24 * R  # of a periodic cell [m]
DEEPEST = 0.05  # largest overlap of free grains over R₁ + R₂
SPEED = 3.0  # largest speed over that of start, drives and fall


def draw(rng):
    """A scene as plain data, so that it can be printed."""
    periodic = rng.random() < 0.2
    law = "rigid" if rng.random() < 0.7 else "smooth"
    return dict(
        law=law,
        periodic=periodic,
        count=int(rng.integers(1, 25)),
        eta=float(rng.choice([0, 0.3, 0.6, 0.9])),
        friction=float(rng.choice([0, 0.3, 0.8])),
        restitution=float(rng.choice([0, 0, 0.5, 1])),
        gravity=float(rng.choice([0, 9.81])) if not periodic else 0.0,
        dt=float(rng.choice([1e-4, 1e-3, 5e-3])) if law == "rigid" else None,
        solver=str(rng.choice(["auto", "nlgs", "sor", "nesterov", "exact"])),
        threads=int(rng.integers(1, 4)),
        overdamped=bool(rng.random() < 0.05),
        kinds=[str(k) for k in rng.choice(["Rcr", "Sphere", "clump"], 25, p=[0.6, 0.3, 0.1])],
        floor=str(rng.choice(["Wall", "Box", "Facet", "Rcr", "none"])),
        turning=bool(rng.random() < 0.1),
        speed=float(rng.choice([0, 1, 20])),
        energy=bool(rng.random() < 0.3),
        gradient=[float(g) for g in rng.choice([0, 0, -0.3, 0.5], 4)] if periodic else None,
        fault=str(rng.choice(["none"] * 12 + FAULTS)),
        reload=bool(rng.random() < 0.1),
        # YADE's collider fails after an erase in a cell
        erase=bool(rng.random() < 0.2) and not periodic,
    )


FAULTS = [
    "no solver", "dead solver", "two solvers", "no integrator", "two integrators", "no collider",
    "no bound", "no resetter", "late force", "damping",
    "solver first", "no law", "no physics", "no geometry", "stock geometry", "nan position",
    "nan velocity", "nan orientation", "zero mass", "zero inertia",
    "free z", "tilted", "another plane", "box out of plane", "elastic material", "nan force",
    "huge friction", "negative restitution", "zero dt", "wall in cell",
    "stepper", "facet out of plane", "stock clump",
]  # fmt: skip


def obstacles(scene, material):
    """Append the floor, and a turning box above it if the scene has one."""
    floors = {
        "Wall": lambda: rcr.wall("y", 0, material=material),
        "Box": lambda: utils.box((0, -0.5, 0), (9, 0.5, 1), material=material, fixed=True),
        "Facet": lambda: utils.facet([(-9, 0, -1), (9, 0, -1), (0, 0, 1)], material=material),
        "Rcr": lambda: rcr.particle((0, -0.1), 5, 0.98, fixed=True, material=material),
    }
    if scene["floor"] != "none":
        O.bodies.append(floors[scene["floor"]]())
    if scene["turning"]:
        box = utils.box((0.3, 0.3, 0), (0.3, 0.02, 1), material=material, fixed=True)
        box.state.angVel = (0, 0, 5)
        O.bodies.append(box)


def grain(kind, at, eta, speed, material, rng):
    """Append a grain of this kind with a velocity up to `speed` along each axis."""
    more = dict(material=material, velocity=tuple(rng.uniform(-1, 1, 2) * speed),
                angular_velocity=rng.uniform(-1, 1) * speed / R)
    if kind == "Sphere":
        O.bodies.append(rcr.disc(at, R, **more))
    elif kind == "Rcr":
        O.bodies.append(rcr.particle(at, R, eta, angle=rng.uniform(0, 3), **more))
    else:
        half = R / 2
        rcr.clump([rcr.disc((at[0] + s * half, at[1]), half, material=material) for s in (-1, 1)])


def engines(scene):
    """Put the engines of the scene's law into O, with its time step."""
    names = [f"Ig2_{one}_{two}_RcrGeom" for two in ("Rcr", "Sphere")
             for one in ("Wall", "Box", "Facet", "Sphere")] + ["Ig2_Rcr_Rcr_RcrGeom"]
    ig2 = [getattr(rcr, name)() for name in names]
    bounds = [rcr.Bo1_Rcr_Aabb(), w.Bo1_Sphere_Aabb(),
              *([] if scene["periodic"] else [w.Bo1_Wall_Aabb(), w.Bo1_Box_Aabb(),
                                              w.Bo1_Facet_Aabb()])]
    newton = w.NewtonIntegrator(gravity=(0, -scene["gravity"], 0), damping=0)
    collider = w.InsertionSortCollider(bounds, verletDist=0.1 * R)
    if scene["law"] == "rigid":
        ip2 = rcr.Ip2_FrictMat_FrictMat_CdPhys()
        if scene["restitution"]:
            ip2.restitution = w.MatchMaker(algo="val", val=scene["restitution"])
        loop = w.InteractionLoop(ig2, [ip2], [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()])
        solve = rcr.ContactDynamics(solver=scene["solver"], threads=scene["threads"],
                                    overdamped=scene["overdamped"])
        O.engines = [w.ForceResetter(), collider, loop, solve, newton]
        O.dt = scene["dt"]
    else:
        loop = w.InteractionLoop(ig2, [w.Ip2_FrictMat_FrictMat_FrictPhys()],
                                 [rcr.Law2_RcrGeom_FrictPhys_CundallStrack(damping=0.3)])
        O.engines = [w.ForceResetter(), collider, loop, newton]
        O.dt = 2e-5


def solver():
    """The first engine ContactDynamics, or None."""
    return next((e for e in O.engines if isinstance(e, rcr.ContactDynamics)), None)


def loose_grains():
    """Free grains outside clumps."""
    return [b for b in O.bodies if b.state.blockedDOFs == "zXY" and not b.isClump
            and not b.isClumpMember]


def begin(scene):
    """An empty scene, in a cell if it is periodic; returns the material of its bodies."""
    O.reset()
    material = w.FrictMat(density=1000, frictionAngle=math.atan(scene["friction"]), young=1e7,
                          poisson=0.5)
    O.materials.append(material)
    if scene["periodic"]:
        O.periodic = True
        O.cell.setBox(WIDTH, WIDTH, WIDTH)
    return material


def shear_cell(gradient):
    a, b, c, d = gradient
    O.cell.velGrad = Matrix3(a, b, 0, c, d, 0, 0, 0, 0)


def build(scene, rng):
    """The scene in YADE."""
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
        shear_cell(scene["gradient"])
    O.trackEnergy = scene["energy"]


LATE = {"no geometry", "huge friction", "negative restitution"}  # found by the first contact
NEED_SOLVER = {"no solver", "dead solver", "two solvers", "late force", "damping", "solver first",
               "stepper", "huge friction", "negative restitution", "nan force"}  # fmt: skip
NEED_BODY = {"nan position", "nan velocity", "nan orientation", "nan force", "zero mass",
             "zero inertia", "free z", "tilted", "another plane", "elastic material"}  # fmt: skip
NOT_IN_CELL = {"box out of plane", "facet out of plane"}


def engine_faults():
    """{fault: function that puts it into the engines}."""
    engines = list(O.engines)
    of = lambda kind: next((e for e in engines if isinstance(e, kind)), None)
    solver, newton = of(rcr.ContactDynamics), of(w.NewtonIntegrator)
    loop, collider = of(w.InteractionLoop), of(w.InsertionSortCollider)
    use = lambda *changed: lambda: setattr(O, "engines", list(changed))
    empty = lambda dispatcher: lambda: setattr(dispatcher, "functors", [])
    spheres = [*loop.geomDispatcher.functors, w.Ig2_Sphere_Sphere_ScGeom()]
    return {
        "no solver": use(*(e for e in engines if e is not solver)),
        "dead solver": lambda: setattr(solver, "dead", True),
        "two solvers": use(*engines[:3], rcr.ContactDynamics(), *engines[3:]),
        "no integrator": use(*engines[:-1]),
        "two integrators": use(*engines, w.NewtonIntegrator(damping=0)),
        "no collider": use(*(e for e in engines if e is not collider)),
        "no bound": empty(collider.boundDispatcher),
        "no resetter": use(*engines[1:]),
        "late force": use(*engines[:-1], w.ForceEngine(force=(1, 0, 0), ids=[0]), newton),
        "damping": lambda: setattr(newton, "damping", 0.3),
        "solver first": use(engines[0], engines[1], solver, loop, newton),
        "no law": empty(loop.lawDispatcher),
        "no physics": empty(loop.physDispatcher),
        "no geometry": empty(loop.geomDispatcher),
        "stock geometry": lambda: setattr(loop.geomDispatcher, "functors", spheres),
        "negative restitution": lambda: setattr(
            loop.physDispatcher.functors[0], "restitution", w.MatchMaker(algo="val", val=-0.5)),
        "zero dt": lambda: setattr(O, "dt", 0),
        "stepper": use(w.GlobalStiffnessTimeStepper(), *engines),
    }


def body_faults(body):
    """{fault: function that puts it into this grain or appends a faulty body}."""
    nan, rough = math.nan, O.materials[0]
    state = lambda name, value: lambda: setattr(body.state, name, value)
    far = lambda x: rcr.disc((x, 50), 0.1, material=rough)
    raised = lambda: setattr(body.state, "pos", (body.state.pos[0], body.state.pos[1], 0.7))
    box = lambda: utils.box((0, 0, 9), (1, 1, 1), material=rough, fixed=True)
    facet = lambda: utils.facet([(0, 0, 3), (1, 0, 3), (0, 0, 4)], material=rough)
    return {
        "nan position": state("pos", (nan, 0, 0)),
        "nan velocity": state("vel", (nan, 0, 0)),
        "nan orientation": state("ori", Quaternion(nan, nan, nan, nan)),
        "zero mass": state("mass", 0),
        "zero inertia": state("inertia", (1, 1, 0)),
        "free z": state("blockedDOFs", "XY"),
        "tilted": state("ori", Quaternion((1, 0, 0), 0.3)),
        "another plane": raised,
        "box out of plane": lambda: O.bodies.append(box()),
        "facet out of plane": lambda: O.bodies.append(facet()),
        "elastic material": lambda: setattr(body, "material", w.ElastMat(density=1000)),
        "nan force": lambda: O.forces.setPermF(body.id, (nan, 0, 0)),
        "huge friction": lambda: setattr(rough, "frictionAngle", math.pi / 2),
        "wall in cell": lambda: O.bodies.append(rcr.wall("y", 0, material=rough)),
        "stock clump": lambda: O.bodies.appendClumped([far(50), far(50.1)]),
    }


def spoil(scene):
    """Put the fault into the scene; False where it does not apply, "late" if a contact shows it."""
    fault, rigid = scene["fault"], scene["law"] == "rigid"
    body = next(iter(loose_grains()), None)
    grains = sum(isinstance(b.shape, (rcr.Rcr, w.Sphere)) for b in O.bodies)
    if fault == "none" or (fault in NEED_BODY and body is None):
        return False
    if (fault in NEED_SOLVER and not rigid) or (fault == "another plane" and grains < 2):
        return False
    if fault in NOT_IN_CELL and scene["periodic"]:
        return False
    if fault == "wall in cell" and not scene["periodic"]:
        return False
    {**engine_faults(), **body_faults(body)}[fault]()
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
        self.scene, self.missed, self.total = scene, False, None
        given = scene["speed"] * 2 + 5 * 0.4 * scene["turning"] + 0.5
        self.speed = given + scene["gravity"] * O.dt * steps
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
        deepest = deepest_overlap()
        bound = DEEPEST if self.scene["law"] == "rigid" else 0.3
        solvers = [e for e in O.engines if isinstance(e, rcr.ContactDynamics)]
        before, self.missed = self.missed, not all(e.converged for e in solvers)
        # contacts show an overlap one step after the step that left it
        if deepest > bound and not before and not self.missed:
            return f"an overlap of {deepest:.3g} (R₁ + R₂)"

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
    if spoiled == "late" and scene["law"] == "rigid" and O.interactions.countReal():
        return f"ran with the fault '{scene['fault']}'"
    return "ran"


def main():
    parser = children.parser(__doc__, scenes=2000)
    parser.add_argument("--steps", type=int, default=60, help="of a scene (default %(default)s)")
    options = parser.parse_args()
    if options.only is not None:
        print(draw(np.random.default_rng(options.only)))

    def of_seed(seed):
        what = outcome(seed, options.steps)
        return (None, {what: 1}) if what in ("ran", "refused") else (what, {})

    counts, wrong = children.check(of_seed, options)
    print(dict(counts))
    print(f"{counts['ran'] + counts['refused']} passed, {len(wrong)} failed")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
