"""Random small scenes of the rigid law as plain data, their transforms and their steps.

Points and vectors are complex numbers x + iy.
"""

import cmath
import math

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from rcr._yade import scene_arrays
from yade import O, utils
from yade import wrapper as w
from yade.minieigenHP import Matrix3, Quaternion

from scene_fuzzer import R, corners_of, deepest_overlap, scenes, set_state, solver

SLOP = 1.01e-4  # overlap over R₁ + R₂; corrections of deeper ones depend on the order of bodies
SETTLING = 25  # steps
FINE = dict(solver="exact", tolerance=1e-11, accuracy=1e-9, maxIterations=20000)


def part(kind, at, angle, size=R, form=0.0):
    """A shape: `size` is R or half the length [m], `form` eta, height over width, or sense."""
    return dict(kind=kind, at=at, angle=angle, size=size, form=form)


def random_scene(seed):
    rng = np.random.default_rng(seed)
    scene = column(rng)
    return settled(with_polygons(scene, seed) if seed % 4 == 3 else scene, rng)


def with_polygons(scene, seed):
    """The scene with polygons of random corners in the place of its Rcrs."""
    rng = np.random.default_rng([seed, 1])

    def polygon(p):
        if p["kind"] != "Rcr":
            return p
        corners, rounding = corners_of(rng, p["size"], p["form"])
        return {**p, "kind": "RoundedPolygon", "form": rounding / p["size"],
                "corners": corners @ [1, 1j]}

    return {**scene, "bodies": [{**b, "parts": list(map(polygon, b["parts"]))}
                                for b in scene["bodies"]]}


def column(rng):
    """A column of grains above an obstacle, or in a periodic cell. More than two grains, or clumps,
    are without friction, since they have several solutions.
    """
    pick = lambda *values: values[rng.integers(len(values))]
    about = lambda by: by * complex(*rng.uniform(-0.7, 0.7, 2))
    dt, tilt, periodic = 10 ** rng.uniform(-4, -2), pick(0, 0, about(1).real), rng.random() < 0.15
    fast = pick(0, 1e-3, 0.1, 1)  # R and rad a step
    motion = lambda: dict(v=about(fast * R / dt), spin=pick(0, 1) * about(fast / dt).real)
    floor = pick(part("Wall", 0j, math.pi / 2, form=pick(0, 1)), part("Facet", 0j, tilt, 5 * R),
                 part("Box", 0j, tilt, 3 * R, pick(0.1, 0.5)), None,
                 part("Rcr", 0j, tilt, pick(1, 5) * R, pick(0.0, 0.9)))  # fmt: skip
    bodies, height = [], 0
    if floor and not periodic:
        driven = {name: pick(0, 0, 1) * value for name, value in motion().items()}
        if floor["kind"] in ("Wall", "Facet"):
            driven = dict(v=1j * driven["v"].imag, spin=0)
        bodies, height = [dict(fixed=True, parts=[floor], **driven)], 3 * R
    for _ in range(rng.integers(1, 5)):
        size, eta, gap = R * pick(0.5, 1, 1, 2), pick(0.0, 0.3, 0.6, 0.9), pick(1e-3, 0.1) * R
        center, kind = complex(about(R).real, height + size), pick("Rcr", "Rcr", "Sphere")
        grain = lambda at, size: part(kind, at, pick(tilt, rng.uniform(0, 3)), size,
                                      eta * (kind == "Rcr"))  # fmt: skip
        arm = about(size / 2)
        parts = pick([grain(center, size)], [grain(center, size)],
                     [grain(center + arm, size / 2), grain(center - arm, size / 2)])
        bodies.append(dict(fixed=False, parts=parts, **motion()))
        height += 2 * size + gap
    rough = sum(not b["fixed"] for b in bodies) < 3 and all(len(b["parts"]) < 2 for b in bodies)
    cell = dict(sides=np.diag([6 * R, max(height, 6 * R)]),
                gradient=rng.uniform(-0.03, 0.03, (2, 2)) * pick(0, 1) / dt,
                stress=pick(None, 0, 0.01) if periodic else None)
    if cell["stress"]:
        cell["stress"] *= 1000.0 * R**2 / dt**2
    return dict(bodies=bodies, dt=dt, density=1000.0, verlet=0.1 * R,
                friction=pick(0.0, 0.3, 0.3) if rough else 0.0,
                gravity=0j if periodic else pick(0, 0.001, 0.05) * pick(-1j, 0.5 - 1j) * R / dt**2,
                restitution=pick(0.0, 0.0, 0.5, 1.0), **(cell if periodic else {}))


def settled(scene, rng):
    """The scene after its grains have fallen; half of the bodies get their first motion again."""
    fall = {**scene, "gravity": -0.05j * R / scene["dt"] ** 2, "restitution": 0.0,
            "bodies": [{**b, "v": 0j, "spin": 0} for b in scene["bodies"]]}  # fmt: skip
    falls = "sides" not in scene and rng.random() < 0.7
    end = [scene, *(advance(fall, SETTLING) if falls else [])][-1]["bodies"]
    return {**scene, "bodies": [
        {**old, "parts": new["parts"]} if new["fixed"] or rng.random() < 0.5 else new
        for old, new in zip(scene["bodies"], end)]}  # fmt: skip


def transformed(scene, turn=1, flip=False, shift=0, drift=0, step=1, length=1, time=1, density=1):
    """The scene after a mirror in x, a turn and a shift, with bodies in another order and units.

    `drift` is the change of the velocities with the shift.
    """
    vector = lambda z: turn * (-z.conjugate() if flip else z)
    matrix = np.array([[vector(1).real, vector(1j).real], [vector(1).imag, vector(1j).imag]])
    tensor = lambda m: matrix @ m @ matrix.T
    corners = lambda z: length * (z.conjugate() if flip else z)
    shape = lambda p: {**p, "at": length * (vector(p["at"]) + shift), "size": length * p["size"],
                       "angle": cmath.phase(vector(cmath.rect(1, p["angle"]))),
                       **({"corners": corners(p["corners"])} if "corners" in p else {})}
    bodies = [{**b, "v": (vector(b["v"]) + drift) * length / time,
               "spin": (-1) ** flip * b["spin"] / time,
               "parts": [shape(p) for p in b["parts"][::step]]} for b in scene["bodies"][::step]]
    cell = {} if "sides" not in scene else dict(
        sides=length * tensor(scene["sides"]), gradient=tensor(scene["gradient"]) / time,
        stress=scene["stress"] and scene["stress"] * density * length**2 / time**2)
    return {**scene, "bodies": bodies, "gravity": vector(scene["gravity"]) * length / time**2,
            "dt": scene["dt"] * time, "verlet": scene["verlet"] * length,
            "density": scene["density"] * density, **cell}


def times(gradient, z):
    return complex(*(gradient @ [z.real, z.imag]))


def shifts(scene, found, shift):
    """Shift and drift of a moved scene, at its start and after each step that is found.

    A cell moves its bodies with its flow: Δv = ΔG · r + dt G · v.
    """
    gradient = scene.get("gradient", np.zeros((2, 2)))
    drift, before = times(gradient, shift), np.zeros((2, 2))
    yield dict(shift=shift, drift=drift)
    for end in found:
        now = end.get("gradient", gradient)
        drift += scene["dt"] * times(before, drift) + times(now - gradient, shift)
        shift += scene["dt"] * drift
        before = gradient = now
        yield dict(shift=shift, drift=drift)


def yade_body(p, material, fixed):
    along, at = cmath.rect(1, p["angle"]), (p["at"].real, p["at"].imag)
    if p["kind"] == "Wall":
        axis = int(abs(along.imag) > abs(along.real))
        sense = round(p["form"] * (along.real + along.imag))
        return rcr.wall(axis, at[axis], sense, material=material)
    if p["kind"] == "Facet":
        ends = [p["at"] + side * p["size"] * along for side in (-1, 1)]
        return rcr.segment(*[(z.real, z.imag) for z in ends], material=material)
    if p["kind"] == "Box":
        extents = (p["size"], p["form"] * p["size"], p["size"])
        return utils.box((*at, 0), extents, Quaternion((0, 0, 1), p["angle"]), fixed=True,
                         material=material)  # fmt: skip
    if p["kind"] == "RoundedPolygon":
        corners = np.column_stack([p["corners"].real, p["corners"].imag])
        return rcr.polygon(at, corners, p["form"] * p["size"], p["angle"], material=material,
                           fixed=fixed)
    if p["kind"] == "Sphere":
        return rcr.disc(at, p["size"], material, p["angle"], fixed)
    return rcr.particle(at, p["size"], p["form"], p["angle"], material, fixed)


def append(body, material):
    """Append a body or a clump; returns its id and those of its parts."""
    made = [yade_body(p, material, body["fixed"]) for p in body["parts"]]
    ids, states = O.bodies.append(made), [b.state for b in made]
    if len(ids) == 1:
        return ids[0], ids
    # rcr.clump finds the centre with an error of 1e-6, which depends on the direction
    mass = sum(s.mass for s in states)
    center = sum((s.mass * s.pos for s in states[1:]), states[0].mass * states[0].pos) / mass
    inertia = sum(s.inertia[2] + s.mass * (s.pos - center).squaredNorm() for s in states)
    return rcr._plugin.planar_clump(ids, center[0], center[1], mass, inertia), ids


def build(scene, **options):
    """The scene in YADE; returns the ids of bodies and of their parts."""
    O.reset()
    material = w.FrictMat(density=scene["density"], frictionAngle=math.atan(scene["friction"]))
    O.materials.append(material)
    O.dt, gravity = scene["dt"], scene["gravity"]
    O.engines = scenes.engines((gravity.real, gravity.imag, 0), restitution=scene["restitution"],
                               **options)
    O.engines[1].verletDist = scene["verlet"]
    if "sides" in scene:
        O.periodic = True
        O.cell.hSize = scenes.plane(*scene["sides"].flat) + Matrix3(
            0, 0, 0, 0, 0, 0, 0, 0, scene["sides"].max())
        O.cell.velGrad = scenes.plane(*scene["gradient"].flat)
        if scene["stress"] is not None:
            O.engines = [*O.engines[:3], rcr.CellStress(stress=2 * [scene["stress"]]),
                         *O.engines[3:]]  # fmt: skip
    ids = [append(body, material) for body in scene["bodies"]]
    for body, (owner, parts) in zip(scene["bodies"], ids):
        flow, spin = mean_flow(scene, O.bodies[owner].state.pos)  # YADE adds it in the first step
        v = body["v"] - flow
        set_state(owner, vel=(v.real, v.imag, 0), angVel=(0, 0, body["spin"] - spin))
    return ids


def mean_flow(scene, at):
    if "sides" not in scene:
        return 0, 0
    g = scene["gradient"]
    return complex(*(g @ [at[0], at[1]])), 0.5 * (g[1, 0] - g[0, 1])


def center(body):
    x, y, _ = O.bodies[body].state.pos
    return complex(x, y)


def angle(body):
    return scene_arrays.angle(O.bodies[body].state.ori)


def advance(scene, steps):
    """The scene after each step, until one has not converged or begins with overlaps; `shifts` [m]
    are those of the position correction.
    """
    ids = build(scene, **FINE)
    start = {k: (center(k), angle(k)) for _, parts in ids for k in parts}
    found = []
    for _ in range(steps):
        before = [center(owner) for owner, _ in ids]
        try:
            O.step()
        except (ValueError, RuntimeError):
            break
        if not solver().converged or deepest_overlap() > SLOP:
            break
        bodies = [moved(body, *of_body, start) for body, of_body in zip(scene["bodies"], ids)]
        cell = {} if "sides" not in scene else {
            "sides": np.array(O.cell.hSize)[:2, :2].copy(),
            "gradient": np.array(O.cell.velGrad)[:2, :2].copy()}
        shifts = [center(owner) - at - O.dt * body["v"]
                  for body, at, (owner, _) in zip(bodies, before, ids)]
        found.append({**scene, "bodies": bodies, "shifts": shifts, **cell})
    return found


def moved(body, owner, parts, start):
    s, shapes = O.bodies[owner].state, []
    for p, k in zip(body["parts"], parts):
        at, turn = start[k]
        shapes.append({**p, "at": p["at"] + center(k) - at, "angle": p["angle"] + angle(k) - turn})
    return {**body, "v": complex(s.vel[0], s.vel[1]), "spin": s.angVel[2], "parts": shapes}
