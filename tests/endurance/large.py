#!/usr/bin/env python3
"""Large scenes: 2^20 separate grains on a floor, more than one slice of the shared loop holds; and
10^5 grains in a pile. Numbers are finite, residuals within the tolerance, overlaps small.

    scripts/check large
    scripts/lib/run python3 tests/endurance/large.py --grains 1048576 --pile 100000 --steps 100
"""

import math
import resource
import sys
import time

import numpy as np
from scene_fuzzer import O, rcr, scenes, solver  # imports YADE before rcr
from rcr import script

R, G, DT, THREADS = 0.01, 9.81, 1e-3, 2
DEEPEST = 0.02  # overlap over R₁ + R₂


def scene(grains, x=()):
    """Grains at these places and of these elongations on a floor, between walls; its solver."""
    rough = scenes.material(0.5)
    scenes.build(*scenes.walls(rough, x=x, y=[0]),
                 *(rcr.particle(at, R, eta, angle, rough) for at, eta, angle in grains), dt=DT,
                 tolerance=1e-4, maxIterations=3000, threads=THREADS)
    O.engines[1].verletDist = 0.1 * R
    return solver()


def check(right, what):
    if not right:
        sys.exit(f"large.py: {what}")


def apart(count, steps=3):
    """Seconds for each step of `count` grains at rest on a floor."""
    solver = scene((((3 * R * k, R), 0, 0) for k in range(count)))
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
    solver = scene(((at, rng.choice([0, 0.5, 0.7]), rng.uniform(0, math.pi)) for at in places),
                   x=(0, width))
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
    parser = script.Parser(prog="large.py", description=__doc__)
    parser.add_argument("--grains", type=int, default=2**20, help="on the floor")
    parser.add_argument("--pile", type=int, default=10**5, help="in the pile")
    parser.add_argument("--steps", type=int, default=100, help="of the pile")
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
