"""S6. Three discs in a column, each 0.1 R deep in the one below, the lowest in the floor.

A position correction through velocities throws them up; ours moves positions only.
"""

from .stage import D, G, R, kinetic, material, on_floor, stadium, state

TITLE = "initial overlap of 0.1 R"
PREDICATE = "largest kinetic energy in 3 s, over m g d"
BOUND = 1e-4
REASON = "work of gravity over the slop, 1e-4 (R₁ + R₂)"
DEPTH = 0.1 * R


def build(law, dt):
    rough = material()
    discs = [stadium(0, R, (0, R - DEPTH + k * (D - DEPTH)), material=rough) for k in range(3)]
    return on_floor(law, dt, rough, *discs)


def measure(ids, clock):
    energies = [kinetic()]
    clock.pass_(3.0, lambda: energies.append(kinetic()))
    return max(energies) / (state(ids[0]).mass * G * D)
