"""Scenes of impacts and sudden loads, S1, S2 and S11 to S14."""

import math

import numpy as np
import rcr
from yade import O

from .stage import (D, G, R, deepest, dense_row, hard_scene, kinetic, material, on_floor, open_box,
                    push, real_contacts, rows, stadium, state, twist)


@hard_scene("light grain lands on a settled pile", "deepest overlap of the grain, in its diameters")
def s01_grain_on_pile(make, clock):
    """S1. When 234 heavy grains meet the criterion, the light one's impulse is still wrong."""
    rough, columns, small = material(), 20, R / 5
    make(*open_box(columns * D, rough),
         *[stadium(0, R, c, material=rough) for c in rows(12, columns, dense_row)])
    clock.pass_(0.2)
    center = 0.4 * columns * D, dense_row(11) + 3 * R
    grain = O.bodies.append(stadium(0, small, center, material=material()))
    overlap = lambda: max((-gap for i in real_contacts() if grain in (i.id1, i.id2)
                           for gap in tuple(i.geom.gap)[: i.geom.points]), default=0)
    clock.restart()
    return max(0, clock.largest(0.5, overlap)) / (2 * small)


@hard_scene("chain of 50 discs, loaded at one end",
            "|force at the far end / load − 1| after the first step", 0.01,
            "kinematic tolerance of the engine")
def s02_chain(make, clock):
    """S2. Rigid grains carry the load to the wall at once.

    Sweeps that stop early carry it part of the way, as an elastic wave of the speed c = √(q N_I)
    d/dt (Unger, Brendel, Wolf and Kertész 2002).
    """
    rough, count = material(), 50
    discs = [stadium(0, R, (R + D * k, 0), material=rough) for k in range(count)]
    wall, first, *_ = make(rcr.wall("x", count * D, material=rough), *discs, gravity=(0, 0, 0))
    load = 1000 * G * state(first).mass
    push(first, (load, 0))
    clock.step(1)
    end = [i.phys.normalForce.norm() for i in real_contacts() if wall in (i.id1, i.id2)]
    return abs(sum(end) / load - 1)


@hard_scene("Painlevé rod", "relative error of velocity and spin after the impact",
            reason="tolerance 1e-4, and the curvature s²/2ρ of a step, which the closed form "
            "neglects", rigid_only=True)  # springs need many steps for the impact
def s11_painleve(make, clock):
    """S11. A slender rod slides on its tip against its lean, like a pushed chalk, µ = 2.

    With w_nn − µ w_nt ≤ 0 no finite force is consistent, but an impact without collision is: the
    tip stops at once, p = −W⁻¹ u (Génot and Brogliato 1999).
    """
    mu, angle, a, cap, speed = 2.0, math.atan(2), 0.95 * R, 0.05 * R, 30 * R
    rough = material(mu)
    rod = stadium(a, cap, (0, cap + a * math.sin(angle)), angle, material=rough)
    (rod,) = on_floor(make, rough, rod)
    state(rod).vel = (-speed, 0, 0)

    def stopped():
        """(v_x, v_y, ω) after the impact that stops the tip, from v + dt g."""
        m, inertia = state(rod).mass, state(rod).inertia[2]
        x, y = -a * math.cos(angle), -a * math.sin(angle) - cap
        jacobian = np.array([[0, 1, x], [1, 0, -y]])  # of the tip: normal, tangential
        inverse = np.diag([1 / m, 1 / m, 1 / inertia])
        w = jacobian @ inverse @ jacobian.T
        assert w[0, 0] - mu * abs(w[0, 1]) <= 0, "this rod is no paradox"
        free = np.array([-speed, -G * O.dt, 0])
        p = -np.linalg.solve(w, jacobian @ free)
        assert p[0] > 0 and abs(p[1]) <= mu * p[0]
        return free + inverse @ jacobian.T @ p
    expected = stopped()
    clock.step(1)
    error = abs(twist(rod) - expected) * [1, 1, R]
    clock.pass_(0.5)
    return max(error) / speed if np.isfinite(twist(rod)).all() else math.inf


@hard_scene("slip reversal with restitution", "largest gain of kinetic energy of a rod, relative",
            reason="contacts give no energy; the solver has an error of 1e-4 in each velocity")
def s12_slip_reversal(make, clock):
    """S12. 72 rods hit a rough floor at all angles and slips, e = 1.

    Where the slip reverses, the impulse of Newton's rule exceeds the one that the compression has
    stored (Kane and Levinson 1985, Stronge 1991).
    """
    slips, speed = np.array([-4, -2, -1, -0.5, 0, 0.5, 1, 2, 4]), 10 * R  # over the approach
    rough, rods = material(0.5), []
    for j, angle in enumerate(map(math.radians, np.linspace(10, 80, 8))):
        y = (0.1 + 0.9 * math.sin(angle)) * R
        rods += [stadium(0.9 * R, 0.1 * R, (4 * R * (9 * j + k), y), angle, material=rough)
                 for k in range(len(slips))]
    ids = on_floor(make, rough, *rods, gravity=(0, 0, 0), restitution=1)
    for k, i in enumerate(ids):
        state(i).vel = (speed * slips[k % len(slips)], -speed, 0)
    energies = lambda: np.array([kinetic([O.bodies[i]]) for i in ids])
    before = energies()
    clock.pass_(0.02)
    return max(energies() / before - 1)


@hard_scene("Newton's cradle", "largest |kinetic energy / first − 1| in 0.5 s",
            reason="tolerance 1e-4 in each velocity, squared, over some impacts")
def s13_cradle(make, clock):
    """S13. One of five discs in touch is hit, e = 1; Newton's rule has no waves: all move on."""
    smooth = material(0)
    discs = [stadium(0, R, (D * k - (R if k == 0 else 0), 0), material=smooth) for k in range(6)]
    state(make(*discs, gravity=(0, 0, 0), restitution=1)[0]).vel = (10 * R, 0, 0)
    first = kinetic()
    return clock.largest(0.5, lambda: abs(kinetic() / first - 1))


@hard_scene("box crushed by a driven lid", "overlap at which the run stops with an error, over R",
            0.2, "far below the overlap at which two discs change places",
            rigid_only=True)  # springs give way
def s14_jam(make, clock):
    """S14. Rigid grains have no solution; the last sweep would let them overlap silently."""
    rough = material()
    lid = rcr.wall("y", 2 * R + 5 * math.sqrt(3) * R, sense=-1, velocity=-5 * R, material=rough)
    make(*open_box(7 * D, rough), lid,
         *[stadium(0, R, c, material=rough) for c in rows(6, 7, dense_row)])
    try:
        clock.pass_(0.5)
    except RuntimeError as stopped:
        assert "jam" in str(stopped), stopped
        return deepest()
    return math.inf
