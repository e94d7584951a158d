"""Scenes of detection, overlaps and indeterminate forces, S6 to S10, S16 and S17."""

import dataclasses
import math

import numpy as np
import rcr
from rcr._yade.last_problem import last_problem

from .stage import (D, G, R, X, box, deepest, flat, flat_row, hard_scene, kinetic, material,
                    on_floor, open_box, overlap_of_spinning, positions, real_contacts, solver,
                    stadium, state, tilted, twist)

DEPTH = 0.1 * R  # overlap of S6


def overlapping(make):
    rough = material()
    discs = [stadium(0, R, (0, R - DEPTH + k * (D - DEPTH)), material=rough) for k in range(3)]
    return on_floor(make, rough, *discs)


@hard_scene("initial overlap of 0.1 R", "largest kinetic energy in 3 s, over m g d", 1e-4,
            "work of gravity over the slop, 1e-4 (R₁ + R₂)")
def s06_overlap(make, clock):
    """S6. A position correction through velocities throws them up; ours moves positions only."""
    ids = overlapping(make)
    return clock.largest(3.0, kinetic) / (state(ids[0]).mass * G * D)


@hard_scene("initial overlap heals", "overlap left after 10 s, over the first", 0.01,
            "the slop is 2e-3 of it")
def s06_overlap_heals(make, clock):
    """S6. The overlap that the same three discs keep."""
    overlapping(make)
    clock.pass_(10.0)
    return deepest() * R / DEPTH


def kinds():
    """Type and points of the touching pairs; pairs with a gap depend on the speed."""
    return sorted((i.id1, i.id2, i.geom.type, i.geom.points) for i in real_contacts()
                  if min(i.geom.gap) < 1e-4 * D)


def long_stack(make, clock, mu_floor, gravity, count):
    """Long RCRs on each other; measures the steps that change a contact."""
    rough = material()
    rods = [stadium(0.9 * R, 0.1 * R, (X, 0.1 * R * (1 + 2 * k)), material=rough)
            for k in range(count)]
    on_floor(make, material(mu_floor), *rods, gravity=gravity)
    clock.step(1)
    seen = [kinds()]
    clock.step(1000, lambda: seen.append(kinds()))
    complete = [points for *_, points in seen[-1]] == [2] * count
    return sum(map(list.__ne__, seen, seen[1:])) if complete else math.inf


CHANGES = "steps (of 1000) in which a contact changes its type or points"


@hard_scene("long parallel RCRs at rest", CHANGES, 0, "nothing moves, so no contact changes")
def s07_parallel_at_rest(make, clock):
    """S7. If an angle decides between one point and two, rounding switches the second one."""
    return long_stack(make, clock, 0.5, tilted(0), 8)


@hard_scene("long parallel RCRs sliding", CHANGES, 0, "they slide as one block")
def s07_parallel_sliding(make, clock):
    """S7. The floor has µ = 0.3, the RCRs have 0.5."""
    return long_stack(make, clock, 0.3, tilted(math.atan(0.4)), 3)


@hard_scene("disc rolls over the joints of a floor", "largest |v/v₀ − 1| in 1 s and 8 joints",
            reason="rounding on a floor without joints; 1e-3, as in all scenes")
def s08_joints(make, clock):
    """S8. It can touch a joint only from above; a detector that misses this brakes or jams it."""
    rough, speed = material(), 30 * R  # m/s
    floor = [box((4 * R * (k + 0.3), -R), (2 * R, R), material=rough) for k in range(-1, 11)]
    disc = make(*floor, stadium(0, R, (0, R), material=rough))[-1]
    state(disc).vel, state(disc).angVel = (speed, 0, 0), (0, 0, -speed / R)
    return clock.largest(1.0, lambda: abs(twist(disc)[0] / speed - 1))


def pairs_of(problem):
    """Number of the pair of bodies of each point, (nc,)."""
    return np.unique(problem.bodies, axis=0, return_inverse=True)[1].ravel()


def resultants(problem, **settings):
    """Solve; (pairs, 3): impulse (x, y) of each pair and its moment about body 2 over R [N s/m]."""
    impulse = rcr.solve(problem, max_iterations=1_000_000, **settings).reaction
    n = problem.normal
    p = impulse[:, :1] * n + impulse[:, 1:] * np.column_stack((-n[:, 1], n[:, 0]))
    moment = (problem.arm2[:, 0] * p[:, 1] - problem.arm2[:, 1] * p[:, 0]) / R
    pair = pairs_of(problem)
    return np.array([np.bincount(pair, column) for column in (*p.T, moment)]).T


@hard_scene("indeterminate side contacts",
            "largest difference of a pair's resultant between solvers, relative", 1e-6,
            "residual 1e-10 times the condition of the stack, n² = 25, with a margin", True)
def s09_side_contacts(make, clock):
    """S9. Flat RCRs under oblique gravity: resultant and moment of a pair are unique."""
    rough = material()
    bricks = [flat((0.1 * R * k, flat_row(k)), rough) for k in range(5)]
    on_floor(make, rough, *bricks, gravity=tilted(0.2))
    clock.step(5)
    problem = last_problem(solver())
    first, *others = [resultants(problem, solver=solver, tolerance=1e-10)
                      for solver in ("nlgs", "sor", "nesterov", "exact")]
    return max(abs(other - first).max() for other in others) / abs(first).max()


@hard_scene("contacts in a shuffled order",
            "largest change of a force, over the mean force", 1e-12,
            "contacts are sorted, so sums are equal; other starts change forces by up to 24 %",
            True)
def s10_shuffled(make, clock):
    """S10. The step is solved twice from a cold start, with its contacts in two orders."""
    rng, rough = np.random.default_rng(10), material()
    centers = [(D * 1.1 * (k % 10 + 0.5), D * 1.1 * (k // 10 + 0.5)) for k in range(150)]
    grains = [rcr.particle(c, R * rng.uniform(0.7, 1), 0.5, rng.uniform(0, np.pi), rough)
              for c in centers]
    make(*open_box(11 * D, rough), *grains)
    clock.pass_(2.0)
    problem = last_problem(solver())
    names = "bodies normal arm1 arm2 bias friction impulse".split()
    pair = pairs_of(problem)
    shuffled = np.random.default_rng(10).permutation(pair.max() + 1)[pair]
    forces = []
    for order in np.arange(len(pair)), np.argsort(shuffled, kind="stable"):
        arrays = {name: getattr(problem, name)[order] for name in names}
        found = resultants(dataclasses.replace(problem, **arrays), solver="auto", tolerance=1e-8)
        forces.append(np.hypot(*found[:, :2].T))
    return abs(forces[1] - forces[0]).max() / forces[0].mean()


@hard_scene("near miss of a corner and of a disc", "|change of velocity| / speed",
            reason="the exact value is 0; 1e-3, as in all scenes")
def s16_near_miss(make, clock):
    """S16. The contact plane is a tangent; a curved path around it can look like a hit."""
    rough, speed, clearance = material(), 100 * R, 1e-3 * D
    obstacle = stadium(0, R, (4 * R, -R), material=rough, fixed=True)
    disc = stadium(0, R, (-5.03 * R, R + clearance), material=rough)
    disc = make(box((0, -R), (R / 2, R), material=rough), obstacle, disc, gravity=(0, 0, 0))[-1]
    state(disc).vel = (speed, 0, 0)
    clock.pass_(10 * R / speed)
    return np.linalg.norm((twist(disc) - [speed, 0, 0]) * [1, 1, R]) / speed


@hard_scene("fast spin of a long particle", "deepest overlap, over the smaller cap radius", 0.5,
            "at 1 the contact reaches a centre line, beyond it the force reverses")
def s17_fast_spin(make, clock):
    """S17. It hits a small disc in a narrow box. Its ends move by two cap radii a step."""
    rough = material()
    rod = stadium(0.95 * R, 0.05 * R, (0.1 * R, 0), 0.3, material=rough)
    disc = stadium(0, 0.1 * R, (0, 0.7 * R), material=rough)
    return overlap_of_spinning(make, clock, rough, rod, disc)
