"""S6. Three discs stand on each other, each 0.1 R deep in the one below, the lowest as deep in the floor.

A correction that works through velocities shoots them up; ours displaces.
"""

import rcr

from .stage import D, G, R, build as scene, kinetic, material, stadium, state

TITLE = "initial overlap of 0.1 R"
PREDICATE = "largest kinetic energy in 3 s, over m g d"
BOUND = 1e-4
REASON = "what gravity gives over the slop, 1e-4 (R₁ + R₂)"
DEPTH = 0.1 * R


def build(law, dt):
    rough = material()
    discs = [stadium(0, R, (0, R - DEPTH + k * (D - DEPTH)), material=rough) for k in range(3)]
    return scene(law, dt, rcr.wall("y", 0, material=rough), *discs)[1:]


def measure(ids, clock):
    energies = [kinetic()]
    clock.pass_(3.0, lambda: energies.append(kinetic()))
    return max(energies) / (state(ids[0]).mass * G * D)
