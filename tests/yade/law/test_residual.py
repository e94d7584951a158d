"""Residual of the engine against NumPy on YADE's state; its model follows the scene."""

import numpy as np
import pytest
import rcr
from natural_map import error
from scenes import box, build, material, pile, solver as engine, stadium, steps
from yade import O, utils


def residual():
    """Residual from the geometry at the beginning of the step and the velocities at its end."""
    points = []  # (p_n, p_t, u_n + b_n, u_t, µ, w_nn)
    for i in O.interactions:
        for k in range(i.geom.points):
            n = np.array((i.geom.normal1, i.geom.normal2)[k])[:2]
            x = np.array((i.geom.position1, i.geom.position2)[k])[:2]
            p = O.dt * np.array((i.phys.force1, i.phys.force2)[k])
            w_nn, u = 0.0, np.zeros(2)
            for body, sign in ((i.id1, -1), (i.id2, 1)):
                s = O.bodies[body].state
                v = np.array(s.vel)[:2]
                r = x - (np.array(s.pos)[:2] - O.dt * v)
                u += sign * (v + s.angVel[2] * np.array((-r[1], r[0])))
                free = [axis not in s.blockedDOFs for axis in "xyZ"]
                lever = r[0] * n[1] - r[1] * n[0]
                w_nn += (free[0] * n[0] ** 2 + free[1] * n[1] ** 2) / (s.mass or 1)
                w_nn += free[2] * lever**2 / (s.inertia[2] or 1)
            slip = n[0] * u[1] - n[1] * u[0]
            points.append((p[0], p[1], n @ u + i.phys.bias[k], slip,
                           i.phys.tangensOfFrictionAngle, w_nn))
    points = np.array(points)
    p, u, mu, w_nn = points[:, :2], points[:, 2:4], points[:, 4], points[:, 5]
    return np.linalg.norm(error(p, u, mu, w_nn)) / np.linalg.norm(p)


@pytest.mark.parametrize("solver", ["nlgs", "sor", "nesterov", "exact", "auto"])
def test_reported_residual_is_that_of_the_scene(solver):
    # Position correction would change the arms, which are computed from final positions.
    pile(dt=1e-3, solver=solver, tolerance=1e-5, maxIterations=400, correction=0)
    compared = 0
    for _ in range(30):
        O.run(10, True)
        told = engine().residual
        if engine().contactPoints and told > 1e-9:
            # Rounding: the integrator adds force/mass of 1e-3 m/s to velocities of 1 m/s.
            assert residual() == pytest.approx(told, rel=1e-6, abs=1e-12), f"step {O.iter}"
            compared += 1
    assert compared > 10


@pytest.mark.parametrize("tolerance", [0, 1e-18])
def test_an_unreachable_tolerance_gives_the_best_residual(tolerance):
    """It leaves at most the residual of a reachable one: all passes have all iterations."""

    def reached(tolerance):
        rough = material(0.5)
        rods = [rcr.particle((0.001 * k, 0.0105 + 0.021 * k), 0.01, 0.5, 0.3 * k, rough)
                for k in range(6)]
        build(rcr.wall("y", 0, sense=1, material=rough), *rods, tolerance=1e-4)
        steps(80)
        engine().solver, engine().tolerance = "nlgs", tolerance
        O.step()
        return engine().residual

    assert reached(tolerance) <= 10 * reached(1e-12)


def heaps(count, friction):
    """Heaps of 5 × 4 discs side by side on a fixed floor, too far apart to touch."""
    one = material(friction=friction)
    build(box((count, -0.1), (2 * count, 0.1), material=one),
          *(stadium(0, 0.05, (2 * heap + 0.1 * column + 0.03 * (row % 2), 0.05 + 0.09 * row),
                    material=one)
            for heap in range(count) for row in range(4) for column in range(5)),
          tolerance=1e-6, maxIterations=5000, solver="nesterov")


def test_model_follows_the_scene():
    """With friction a point has two unknowns, bodies rotate; a freed floor joins the heaps."""
    heaps(3, 0)
    steps(3)
    model = engine().model
    assert model["islands"] == 3 and model["fixed"] == 1
    assert model["bodies"] == 60 and model["rotations"] == 0
    assert model["frictionless"] and model["unknowns"] == model["points"] == engine().contactPoints
    utils.setContactFriction(0.5)
    O.step()
    model = engine().model
    assert not model["frictionless"] and model["unknowns"] > model["points"]
    assert model["rotations"] > 0 and model["islands"] == 3
    O.bodies[0].dynamic = True
    O.bodies[0].state.blockedDOFs = "xzXYZ"
    O.bodies[0].state.mass = 100.0
    O.step()
    assert engine().model["fixed"] == 0 and engine().model["islands"] == 1
