"""Converged steps of random small scenes against exact solutions.

The reference is `exact_solution`. The error of an island is its distance to the exact solution, in
velocities (energy norm, over v − v_free) and forces. `auto` must meet the goal of an island, 1 %
or that of packings with friction (docs/law.md). Other solvers stop at the estimate of their error,
which is too small by up to a factor of 3. Only unique results count. A case is a
seed: three steps of its problem without YADE, or with `--yade` its scene in YADE. `--least` finds
the least scene of each failure.

    scripts/lib/run python3 tests/endurance/truth.py --scenes 3000 [--first 0] [--yade]
    scripts/lib/run python3 tests/endurance/truth.py --only SEED [--yade]
"""

import collections
import math

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from rcr import _kernel
from rcr._yade.last_problem import last_problem
from yade import O
from yade import wrapper as w

import children
import exact_solution
import loaded_scenes
from loaded_scenes import DT, R

ACCURACY = 0.01
SETTINGS = dict(accuracy=ACCURACY, tolerance=1e-4, max_iterations=1000)  # as ContactDynamics
UNDERESTIMATE = 3  # of errors, largest factor
STEPS = 3
STEPS_IN_YADE = 1, 2, 3, 10, 30


def errors(problem, impulse, counts):
    """(true error, goal, name of the error) of each island with a unique solution."""
    for island in exact_solution.islands(problem):
        if island is None:
            counts["islands without a reference"] += 1
            continue
        given, goal = impulse[island.points], island.goal(ACCURACY)
        found = exact_solution.distances(problem, island, given)
        if max(found["points"], found["velocities"]) > goal:
            names = exact_solution.unique(problem, island, given)
            # two points of a pair may share friction at will
            forces = "pairs" if island.frictional else "points"
            found = {name: found[name] for name in ("velocities", forces) if name in names}
            own = exact_solution.from_impulses(problem, island, given)
            if own is not None:  # the solver may have found another solution
                other = exact_solution.distances(problem, island, own)
                found = {name: error for name, error in found.items() if other[name] < goal / 10}
        if found:
            counts["islands compared"] += 1
            name = max(found, key=found.get)
            yield found[name], goal, name
        else:
            counts["islands with several solutions"] += 1


def judge(problem, solver, impulse, converged, estimate, residual, counts):
    """A sentence on a converged solve that is wrong, or None."""
    if not converged:
        counts["not converged"] += 1
        return None
    counts["converged"] += 1
    for error, goal, name in errors(problem, impulse, counts):
        if not error <= goal * (1 if solver == "auto" else UNDERESTIMATE):
            counts["wrong"] += 1
            return (f"error of {name} {error:.3g}, goal {goal:g}, estimate {estimate:.3g}, "
                    f"residual {residual:.2g}, {len(problem['bodies'])} points")
    return None


def in_numpy(scene, counts):
    """A sentence on the first wrong step of the problem, or None."""
    found, state = loaded_scenes.problem(scene)
    if not len(found["bodies"]):
        return None
    for step in range(1, STEPS + 1):
        loaded_scenes.impact(found, state, scene["restitution"])
        solved = _kernel.solve(**found, solver=scene["solver"], **SETTINGS)
        wrong = judge(found, scene["solver"], solved["impulse"], solved["converged"],
                      solved["error_estimate"], solved["residual"], counts)
        if wrong:
            return f"step {step} of {scene['solver']}: {wrong}"
        impulse = solved["impulse"] * scene["warm"]
        found, state = loaded_scenes.advance(
            found, state, solved["velocity"], solved["relative_velocity"], impulse)
    return None


def build_in_yade(scene):
    """Build the scene in YADE; return its ContactDynamics."""
    O.reset()
    materials = {}
    for friction in {scene["friction"], *(wall["friction"] for wall in scene["walls"])}:
        materials[friction] = O.materials.append(
            w.FrictMat(density=loaded_scenes.DENSITY, frictionAngle=math.atan(friction)))
    own = materials[scene["friction"]]
    for g in scene["grains"]:
        at = g["x"], g["y"]
        if "half" in g:
            corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * g["half"]
            body = rcr.polygon(at, corners, material=own)
        else:
            turn = scene["along"] * math.pi / 2
            body = (rcr.particle(at, g["R"], g["eta"], turn, own) if g["eta"]
                    else rcr.disc(at, g["R"], own))
        body.state.mass *= g["mass"]
        body.state.inertia = body.state.inertia * g["mass"]
        body.state.vel = (*g["v"], 0)
        O.bodies.append(body)
    for wall in scene["walls"]:
        material = materials[wall["friction"]]
        body = (rcr.mobile_wall(wall["axis"], wall["at"], wall["mass"], wall["sense"], material)
                if wall["mass"] else rcr.wall(wall["axis"], wall["at"], wall["sense"], 0, material))
        velocity = [0.0, 0.0, 0.0]
        velocity[wall["axis"]] = wall["v"]
        body.state.vel = velocity
        k = O.bodies.append(body)
        if wall["load"]:
            force = [0.0, 0.0, 0.0]
            force[wall["axis"]] = wall["load"]
            O.forces.setPermF(k, force)
    ip2 = rcr.Ip2_FrictMat_FrictMat_CdPhys()
    ip2.restitution = w.MatchMaker(algo="val", val=scene["restitution"])
    ig2 = [getattr(rcr, name)() for name in dir(rcr)
           if name.startswith("Ig2_") and name != "Ig2_Planar_RcrGeom"]
    solver = rcr.ContactDynamics(solver=scene["solver"])
    O.engines = [
        w.ForceResetter(),
        w.InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), rcr.Bo1_RoundedPolygon_Aabb(),
                                 w.Bo1_Sphere_Aabb(), w.Bo1_Wall_Aabb()], verletDist=0.1 * R),
        w.InteractionLoop(ig2, [ip2], [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        solver, w.NewtonIntegrator(gravity=(0, -scene["gravity"], 0), damping=0)]
    O.dt = DT
    return solver


def impulses(problem):
    """Impulses (nc, 2) of the last step in YADE, in the order of the problem."""
    result, seen = np.zeros((len(problem["bodies"]), 2)), collections.Counter()
    for k, (one, two) in enumerate(problem["bodies"].tolist()):
        phys = O.interactions[one, two].phys
        result[k] = DT * np.array((phys.force1, phys.force2)[seen[one, two]])
        seen[one, two] += 1
    return result


def in_yade(scene, counts):
    """A sentence on the first wrong step of the scene in YADE, or None."""
    solver = build_in_yade(scene)
    for step in range(1, max(STEPS_IN_YADE) + 1):
        try:
            O.step()
        except (ValueError, RuntimeError) as error:
            counts[f"rejected: {error!s:.40}"] += 1
            return None
        if step not in STEPS_IN_YADE:
            continue
        problem = last_problem(solver).arrays()
        if not len(problem["bodies"]):
            continue
        wrong = judge(problem, scene["solver"], impulses(problem), solver.converged,
                      solver.errorEstimate, solver.residual, counts)
        if wrong:
            return f"step {step} of {scene['solver']} in YADE: {wrong}"
    return None


def smaller(scene):
    """Scenes with fewer grains, walls or properties."""
    grains, walls = scene["grains"], scene["walls"]
    n = len(grains)
    for size in (n // 2, n // 4, n // 8, 1):
        if size:
            for first in {0, n - size, (n - size) // 2}:
                yield {**scene, "grains": grains[:first] + grains[first + size:]}
    for k in range(len(walls)):
        yield {**scene, "walls": walls[:k] + walls[k + 1:]}
    yield {**scene, "restitution": 0.0}
    yield {**scene, "friction": 0.0, "walls": [{**w, "friction": 0.0} for w in walls]}
    yield {**scene, "grains": [{**g, "mass": 1.0} for g in grains]}
    yield {**scene, "grains": [{**g, "v": (0.0, 0.0)} for g in grains],
           "walls": [{**w, "v": 0.0} for w in walls]}
    yield {**scene, "warm": False}


def outcome_with(check, least):
    """A function of a seed for `children`; `least`: it finds the least scenes of failures."""
    def outcome(seed):
        scene, counts = loaded_scenes.draw(seed), collections.Counter()
        wrong = check(scene, counts)
        if wrong:
            wrong = f"{scene['family']} of {len(scene['grains'])}: {wrong}"
            if least:
                fails = lambda less: less["grains"] and check(less, collections.Counter())
                small = children.shrink(scene, smaller, fails)
                wrong += (f"\n  least, {len(small['grains'])} grains: "
                          f"{check(small, collections.Counter())}\n  {small}")
        return wrong, dict(counts)
    return outcome


if __name__ == "__main__":
    parser = children.parser(__doc__, 3000)
    parser.add_argument("--yade", action="store_true", help="scenes in YADE (default: problems)")
    parser.add_argument("--least", action="store_true", help="find the least scene of a failure")
    options = parser.parse_args()
    children.main(options, outcome_with(in_yade if options.yade else in_numpy, options.least))
