"""S11. A slender rod slides on its tip against its lean, like a pushed chalk, µ = 2.

With w_nn − µ w_nt ≤ 0 sliding friction presses the tip into the floor faster than the normal force
lifts it: no finite force is consistent. An impact without collision is consistent. The tip stops at
once, p = −W⁻¹ u (Génot and Brogliato 1999).
"""

import math

import numpy as np
from yade import O

from .stage import G, R, material, on_floor, stadium, state, twist

TITLE = "Painlevé rod"
PREDICATE = "relative error of the twist after the impact"
BOUND = 1e-3
REASON = "tolerance 1e-4, and the curvature s²/2ρ of a step, which the closed form neglects"
RIGID_ONLY = True  # springs need many steps for the impact
MU, ANGLE, A, CAP = 2.0, math.atan(2), 0.95 * R, 0.05 * R
SPEED = 30 * R


def build(law, dt):
    rough = material(MU)
    rod = stadium(A, CAP, (0, CAP + A * math.sin(ANGLE)), ANGLE, material=rough)
    (rod,) = on_floor(law, dt, rough, rod)
    state(rod).vel = (-SPEED, 0, 0)
    return rod


def stopped(rod, dt):
    """Twist after the impact that stops the tip, from v + dt g."""
    m, inertia = state(rod).mass, state(rod).inertia[2]
    x, y = -A * math.cos(ANGLE), -A * math.sin(ANGLE) - CAP
    jacobian = np.array([[0, 1, x], [1, 0, -y]])  # of the tip: normal, tangential
    inverse = np.diag([1 / m, 1 / m, 1 / inertia])
    w = jacobian @ inverse @ jacobian.T
    assert w[0, 0] - MU * abs(w[0, 1]) <= 0, "this rod is no paradox"
    free = np.array([-SPEED, -G * dt, 0])
    p = -np.linalg.solve(w, jacobian @ free)
    assert p[0] > 0 and abs(p[1]) <= MU * p[0]
    return free + inverse @ jacobian.T @ p


def measure(rod, clock):
    expected = stopped(rod, O.dt)
    clock.step(1)
    error = abs(twist(rod) - expected) * [1, 1, R]
    clock.pass_(0.5)
    return max(error) / SPEED if np.isfinite(twist(rod)).all() else math.inf
