"""Residual of the engine against NumPy on YADE's state after the step."""

import numpy as np
import pytest
import rcr
import yade.utils
from yade import O

from scenes import build, material, stadium, steps


def residual():
    """Residual of the last step from forces, geometry and velocities
    (pkg/kernel/problem/residual.hpp).

    Interactions hold the geometry at the beginning of the step, bodies the velocities at its end.
    """
    error2 = norm2 = 0.0
    for i in O.interactions:
        if not i.isReal:
            continue
        bodies = O.bodies[i.id1], O.bodies[i.id2]
        mu = i.phys.tangensOfFrictionAngle
        for k in range(i.geom.points):
            n = np.array(((i.geom.normal1, i.geom.normal2)[k][0],
                          (i.geom.normal1, i.geom.normal2)[k][1]))
            t = np.array((-n[1], n[0]))
            x = np.array(((i.geom.position1, i.geom.position2)[k][0],
                          (i.geom.position1, i.geom.position2)[k][1]))
            force = (i.phys.force1, i.phys.force2)[k]
            p = O.dt * np.array((force[0], force[1]))
            w_nn, u = 0.0, np.zeros(2)
            for body, sign in zip(bodies, (-1, 1)):
                s = body.state
                r = x - np.array((s.pos[0] - O.dt * s.vel[0], s.pos[1] - O.dt * s.vel[1]))
                u += sign * (np.array((s.vel[0], s.vel[1])) + s.angVel[2] * np.array((-r[1], r[0])))
                free = [axis not in s.blockedDOFs for axis in "xyZ"]
                lever = r[0] * n[1] - r[1] * n[0]
                w_nn += (free[0] * n[0] ** 2 + free[1] * n[1] ** 2) / (s.mass
                    or 1) + free[2] * lever**2 / (s.inertia[2] or 1)
            u = np.array((n @ u, t @ u))
            q = p - np.array((u[0] + i.phys.bias[k] + mu * abs(u[1]), u[1])) / w_nn
            if mu * abs(q[1]) <= -q[0]:
                q = np.zeros(2)
            elif abs(q[1]) > mu * q[0]:
                length = (q[0] + mu * abs(q[1])) / (1 + mu**2)
                q = np.array((length, np.copysign(mu * length, q[1])))
            error2 += (p - q) @ (p - q)
            norm2 += p @ p
    return np.sqrt(error2 / norm2)


def pile(seed=1, count=40):
    rng = np.random.default_rng(seed)
    grain = material(friction=0.4)
    walls = [rcr.wall("y", 0, +1, material=grain), rcr.wall("x", 0, +1, material=grain),
             rcr.wall("x", 0.2, -1, material=grain)]
    grains = [
        stadium(0.006, 0.008, (0.03 + 0.03 * (k % 6), 0.03 + 0.03 * (k // 6)),
                rng.uniform(0, np.pi), material=grain) for k in range(count)
    ]
    return [*walls, *grains]


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "exact", "auto"])
def test_reported_residual_is_that_of_the_scene(solver):
    """Residual of the engine against NumPy on YADE's state after the step."""
    # Without position correction, which moves bodies: arms are computed from final positions.
    build(*pile(), dt=1e-3, solver=solver, tolerance=1e-5, maxIterations=400, correction=0)
    engine = yade.utils.typedEngine("ContactDynamics")
    compared = 0
    for _ in range(30):
        O.run(10, True)
        if engine.contactPoints and engine.residual > 1e-9:
            # Rounding: the integrator adds force/mass of 1e-3 m/s to velocities of 1 m/s.
            assert residual() == pytest.approx(engine.residual, rel=1e-6,
                                               abs=1e-12), f"step {O.iter}"
            compared += 1
    assert compared > 10


@pytest.mark.parametrize("tolerance", [0, 1e-18])
def test_an_unreachable_tolerance_gives_the_best_residual(tolerance):
    """It leaves at most the residual of a reachable one: all passes have all iterations."""

    def reached(tolerance):
        rough = material(0.5)
        build(
            rcr.wall("y", 0, sense=1, material=rough),
            *(rcr.particle((0.001 * k, 0.0105 + 0.021 * k), R=0.01, eta=0.5, angle=0.3 * k,
                           material=rough) for k in range(6)),
            tolerance=1e-4,
        )
        steps(80)
        solver = O.engines[-2]
        solver.solver, solver.tolerance = "nlgs", tolerance
        O.step()
        return solver.residual

    assert reached(tolerance) <= 10 * reached(1e-12)
