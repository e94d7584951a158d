#!/usr/bin/env python3
"""Large scenes: 2^20 separate grains on a floor, and 10^5 grains in a pile.

    scripts/check large
    scripts/lib/run python3 tests/endurance/large.py --grains 1048576 --pile 100000 --steps 100

Each grain on the floor is an island and must come to rest; the count exceeds one word of the
shared loop. In the pile numbers stay finite, residuals within the tolerance, overlaps small. The
last line prints times and memory.
"""

import argparse
import math
import resource
import sys
import time

import numpy as np
import yade  # noqa: F401  before rcr
import rcr
from yade import O
from yade.wrapper import (
    Bo1_Sphere_Aabb, Bo1_Wall_Aabb, ForceResetter, FrictMat, InsertionSortCollider, InteractionLoop,
    NewtonIntegrator,
)  # fmt: skip

R, G, DT, THREADS = 0.01, 9.81, 1e-3, 2
DEEPEST = 0.02  # overlap over R₁ + R₂


def engines():
    solver = rcr.ContactDynamics(tolerance=1e-4, maxIterations=3000, threads=THREADS)
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()],
                              verletDist=0.1 * R),
        InteractionLoop([rcr.Ig2_Rcr_Rcr_RcrGeom(), rcr.Ig2_Wall_Rcr_RcrGeom()],
                        [rcr.Ip2_FrictMat_FrictMat_CdPhys()],
                        [rcr.Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        solver,
        NewtonIntegrator(gravity=(0, -G, 0), damping=0),
    ]
    O.dt = DT
    return solver


def scene(walls, grains):
    O.reset()
    material = O.materials.append(FrictMat(density=2600, frictionAngle=0.46))
    O.bodies.append([rcr.wall(*wall, material=material) for wall in walls])
    O.bodies.append([rcr.particle(at, R, eta, angle=angle, material=material)
                     for at, eta, angle in grains])
    return engines()


def check(right, what):
    if not right:
        sys.exit(f"large.py: {what}")


def apart(count, steps=3):
    """Seconds for each step of `count` grains at rest on a floor."""
    solver = scene([("y", 0, 1)], (((3 * R * k, R), 0, 0) for k in range(count)))
    O.step()
    start = time.monotonic()
    for _ in range(steps - 1):
        O.step()
    seconds = (time.monotonic() - start) / (steps - 1)
    model = solver.model
    check(solver.converged and model["points"] == count, f"{model['points']} points of {count} "
          f"grains, converged {solver.converged}")
    check(model["islands"] == count, f"{model['islands']} islands of {count} grains")
    fastest = max(abs(b.state.vel[1]) for b in O.bodies)
    check(fastest < 1e-9 * G * DT * count, f"a grain on the floor at {fastest:.3g} m/s")
    return seconds


def pile(count, steps):
    """Seconds for each step of falling grains, and the share of steps that missed the tolerance."""
    rng = np.random.default_rng(1)
    columns = math.ceil(math.sqrt(count))
    width = 2.1 * R * columns
    places = ((2.1 * R * (k % columns + 0.5), 2.1 * R * (k // columns + 0.5)) for k in range(count))
    solver = scene([("y", 0, 1), ("x", 0, 1), ("x", width, -1)],
                   ((at, rng.choice([0, 0.5, 0.7]), rng.uniform(0, math.pi)) for at in places))
    start = time.monotonic()
    for _ in range(steps):
        O.step()
        check(not solver.converged or solver.residual <= solver.tolerance,
              f"a converged step with a residual of {solver.residual:.3g}")
    seconds = (time.monotonic() - start) / steps
    numbers = np.array([[*b.state.pos, *b.state.vel, *b.state.angVel] for b in O.bodies])
    check(np.isfinite(numbers).all(), "numbers that are not finite")
    check(solver.deepestOverlap < DEEPEST, f"an overlap of {solver.deepestOverlap:.3g} (R₁ + R₂)")
    return seconds, solver.missedSteps / steps


def main():
    parser = argparse.ArgumentParser(prog="large.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grains", type=int, default=2**20,
                        help="on the floor (default %(default)s)")
    parser.add_argument("--pile", type=int, default=10**5, help="in the pile (default %(default)s)")
    parser.add_argument("--steps", type=int, default=100, help="of the pile (default %(default)s)")
    options = parser.parse_args()
    one = apart(options.grains)
    two, missed = pile(options.pile, options.steps)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"large: {options.grains} grains apart: {one:.2f} s a step; {options.pile} in a pile: "
          f"{two:.2f} s a step over {options.steps}, "
          f"{100 * missed:.0f} % missed the tolerance; {THREADS} threads, {memory:.1f} GB at "
          f"most")  # fmt: skip


if __name__ == "__main__":
    main()
