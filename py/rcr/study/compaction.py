"""Scene and isotropic compaction of the biaxial test. Needs YADE.

The compaction has no friction and no inertia (`ContactDynamics.overdamped`). It has two phases:

collapse
    The loose packing contracts homogeneously, by 0.5 % a step or less, until its contacts carry
    the load. Each step moves the grains by as little as the contacts require.
relaxation
    The packing comes to rest under the load of the walls. Long steps are fast, but grains must
    follow their curved paths: a step displaces no grain by more than 0.1 d, nor by more than 20 d
    times the unbalance. The factor 20 d decreases while the unbalance stagnates.

The unbalance is the mean net force of a grain over the mean contact force [-].
"""

import math

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
from yade.wrapper import (Bo1_Wall_Aabb, ForceResetter, FrictMat, InsertionSortCollider,
                          InteractionLoop, NewtonIntegrator, Omega)

import rcr
from rcr import _kernel
from rcr.study import grains
from rcr.study.protocol import PROTOCOL

O = Omega()

SOLVER_ITERATIONS = 3000  # of a step of the compaction, at most


def random_radii(count, rng, span=2):
    """Return radii uniform in volume fraction: number density ∝ R⁻² in [R_min, span R_min] [m]."""
    return PROTOCOL.smallest_radius / (1 - (1 - 1 / span) * rng.random(count))


def deposited(radii):
    """Return centres of circles (N, 2) and the width of their box [m].

    They are deposited layer by layer in a box about as high as wide (`deposition.hpp`).
    """
    area = math.pi * np.sum(radii**2)
    width = max(math.sqrt(area / PROTOCOL.deposited_fraction), 2 * radii.max())
    return _kernel.deposit(radii, width), width


def make_scene(parameters, place=deposited):
    """Make the loose packing, its walls and its engines in the running YADE.

    Each grain is inscribed in a circle, at a random angle. `place` returns the circles as
    `deposited` does; they do not depend on the shape.
    """
    O.reset()
    count = parameters["particles"]
    rng = np.random.default_rng(parameters["seed"])
    radii = random_radii(count, rng, parameters["size_span"])
    centres, width = place(radii)
    height = (centres[:, 1] + radii).max()
    grain, plate = (O.materials.append(FrictMat(density=PROTOCOL.density, frictionAngle=0, label=k))
                    for k in ("grain", "plate"))
    grains.append(parameters, centres, radii, rng.random(count), grain)
    mass = math.fsum(O.bodies[k].state.mass for k in grains.ids())
    wall_mass = mass / math.sqrt(count)  # of a row of grains; heavier walls lag behind
    left, right, top = (rcr.mobile_wall(axis, at, wall_mass, sense, plate)
                        for axis, at, sense in (("x", 0, 1), ("x", width, -1), ("y", height, -1)))
    left.state.blockedDOFs = "xyzXYZ"  # until the shear
    walls = O.bodies.append([left, rcr.wall("y", 0, +1, material=plate), right, top])
    shortest, _ = PROTOCOL.relaxation_time_steps
    O.dt = shortest * math.sqrt(mass / count / PROTOCOL.confining_stress)
    O.engines = _engines(walls, parameters)


def _engines(walls, parameters):
    left, bottom, right, top = walls
    box, *contacts = grains.functors(parameters["shape"])
    stress = -PROTOCOL.confining_stress
    return [
        ForceResetter(),
        InsertionSortCollider([box, Bo1_Wall_Aabb()], verletDist=0.1 * PROTOCOL.smallest_radius),
        InteractionLoop(contacts, [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                        [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        rcr.WallStress(wall=left, start=bottom, end=top, stress=-stress, dead=True),
        rcr.WallStress(wall=right, start=bottom, end=top, stress=stress),
        rcr.WallStress(wall=top, start=left, end=right, stress=stress),
        rcr.ContactDynamics(  # walls under stress give way, so each step has a solution
            maxIterations=SOLVER_ITERATIONS, solver=parameters["solver"],
            threads=parameters["threads"], overdamped=True, yieldCompliance=0),
        NewtonIntegrator(damping=0),
    ]


def relaxation_interval(solver):
    """Return the number of steps per time step length; 1 at large unbalance."""
    smooth = solver.unbalancedForce < PROTOCOL.rough_unbalance
    return PROTOCOL.relaxation_steps if smooth else 1


def relaxation_time_step(state, solver):
    """Return dt/t₀ of the next relaxation interval [-], from the unbalance of the solver.

    Under the net force F ⟨f⟩ a grain moves by about F d (dt/t₀)² in a step. The function updates
    the `state` of the relaxation, a dict that is empty at first.
    """
    before = state.get("steps", 0)
    steps = before + relaxation_interval(solver)
    unbalances = state.get("unbalances", [])
    if steps // PROTOCOL.relaxation_steps > before // PROTOCOL.relaxation_steps:
        unbalances = [*unbalances, solver.unbalancedForce]
    state.update(unbalances=unbalances, steps=steps)
    state.setdefault("displacement", PROTOCOL.displacement_per_unbalance)
    if len(unbalances) == 2 * PROTOCOL.unbalance_window:
        _reduce_displacement(state)
    bound = min(PROTOCOL.max_grain_displacement, state["displacement"] * solver.unbalancedForce)
    shortest, longest = PROTOCOL.relaxation_time_steps
    largest = max(solver.largestUnbalancedForce, 1e-300)  # 0 in perfect balance
    return min(longest, max(shortest, math.sqrt(bound / largest)))


def _reduce_displacement(state):
    """Reduce the displacement over the unbalance where the unbalance has not decreased.

    Long steps can make grains flip to and fro; very short ones make large packings creep.
    """
    window = PROTOCOL.unbalance_window
    earlier, state["unbalances"] = state["unbalances"][:window], state["unbalances"][window:]
    if math.fsum(state["unbalances"]) > PROTOCOL.unbalance_decrease * math.fsum(earlier):
        _shorten_steps(state)


def _shorten_steps(state):
    """Reduce the displacement over the unbalance; below the least one, restart it.

    Each restart is at a smaller value, since the flips of long steps undo the relaxation.
    """
    state["displacement"] *= PROTOCOL.displacement_reduction
    state["flip_displacement"] = state["displacement"]
    if state["displacement"] <= PROTOCOL.min_displacement_per_unbalance:
        first = state.get("restart", PROTOCOL.displacement_per_unbalance)
        first *= PROTOCOL.restart_reduction
        if first <= PROTOCOL.min_displacement_per_unbalance:
            first = PROTOCOL.displacement_per_unbalance
        state.update(displacement=first, restart=first)
        del state["flip_displacement"]


def accept_creep(state, stress_deviation):
    """Return whether a balanced packing off the isotropic stress is accepted as creeping.

    Otherwise lengthen the steps, since longer steps shorten the creep. Steps longer than
    ``flip_displacement``, which kept up flips, follow after `Protocol.creep_intervals` only.
    """
    longer = state["displacement"] / PROTOCOL.displacement_reduction
    intervals = state.get("balanced_intervals", 0) + 1
    state.update(unbalances=[], balanced_intervals=intervals)
    if longer > state.get("flip_displacement", longer):
        if intervals < PROTOCOL.creep_intervals:
            return False
        if stress_deviation < PROTOCOL.creep_isotropy_tolerance:
            return True
        del state["flip_displacement"]
    state.update(displacement=longer, balanced_intervals=0)
    return False


def compact(test, balance_tolerance):
    """Make a step of the collapse or an interval of the relaxation; return True at the end."""
    solver = test.solver
    if O.iter > PROTOCOL.max_compaction_steps:
        raise RuntimeError(
            f"the compaction has not come to rest after {O.iter} steps: mean net force of a "
            f"grain {solver.unbalancedForce:.1e} of the mean contact force (expected "
            f"{balance_tolerance:g}), wall stresses "
            f"{test.mean_stresses / PROTOCOL.confining_stress} σ₀ (expected 1); "
            "try another seed or a smaller tolerance")
    unbalance = min(0.1, max(solver.unbalancedForce, balance_tolerance))
    solver.tolerance = PROTOCOL.relaxation_tolerance * unbalance
    if test.progress["phase"] == "collapse":
        _collapse(test)
        return False
    _relax(test)
    if solver.unbalancedForce >= balance_tolerance:
        return False
    # a few grains may still flip, and end their long, curved paths in others; the loop detects the
    # contacts at the end of the step
    utils.typedEngine("InteractionLoop")()
    if test.overlaps().max(initial=0) > PROTOCOL.largest_overlap:
        _shorten_steps(test.progress["relaxation"])
        return False
    deviation = stress_deviation(test)
    if deviation < PROTOCOL.isotropy_tolerance:
        return True
    return accept_creep(test.progress["relaxation"], deviation)


def rest():
    """Set all velocities to zero."""
    for body in O.bodies:
        body.state.vel = body.state.angVel = Vector3.Zero


def stress_deviation(test):
    """Return the largest deviation of the wall stresses from σ₀ [σ₀]."""
    return float(np.abs(test.mean_stresses / PROTOCOL.confining_stress - 1).max())


def _collapse(test):
    """Contract the packing by one step; end the phase once the contacts carry the load."""
    contraction = PROTOCOL.max_contraction
    # The first step counts the contact points.
    if O.iter == 0 or test.solver.contactPoints > PROTOCOL.sparse_points * len(test.grains):
        wall = PROTOCOL.max_wall_displacement * test.diameter
        contraction = min(contraction, wall / max(test.width, test.height))
    grains.contract(contraction)
    width, height = test.width, test.height
    test.step(1)
    expands = max(test.width / width, test.height / height) > 1 + contraction / 2
    most = PROTOCOL.max_collapse_stress * PROTOCOL.confining_stress
    if expands or test.mean_stresses.min() > most:
        test.progress.update(phase="relaxation", relaxation={})
        # The next step is up to ten times as long, and contacts are sought within 2 dt v.
        rest()


def _relax(test):
    """Make one relaxation interval."""
    solver = test.solver
    O.dt = test.time_unit * relaxation_time_step(test.progress["relaxation"], solver)
    test.step(relaxation_interval(solver))
    drag = PROTOCOL.drag_ratio * solver.unbalancedForce
    solver.trackMeanStretch = bool(stress_deviation(test) > drag)
