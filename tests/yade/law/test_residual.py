"""Residual of the engine against NumPy on YADE's state; its model follows the scene."""

import numpy as np
import pytest
import rcr
from kernel.contact_problems import jacobian_times, problem_of_rows, weights
from oracle import error
from scenes import box, build, material, pile, solver as engine, stadium, steps, warns
from yade import O, utils


def residual():
    """Residual from the geometry at the beginning of the step and the velocities at its end."""
    v, inverse_mass, p, rows = [], [], [], []
    for s in (b.state for b in O.bodies):
        v.append((s.vel[0], s.vel[1], s.angVel[2]))
        free = [axis not in s.blockedDOFs for axis in "xyZ"]
        inverse_mass.append(free / np.array([s.mass or 1, s.mass or 1, s.inertia[2] or 1]))
    center = [np.array(b.state.pos)[:2] - O.dt * np.array(b.state.vel)[:2] for b in O.bodies]
    for i in O.interactions:
        for k in range(i.geom.points):
            x = np.array((i.geom.position1, i.geom.position2)[k])[:2]
            p.append(O.dt * np.array((i.phys.force1, i.phys.force2)[k]))
            n = np.array((i.geom.normal1, i.geom.normal2)[k])[:2]
            rows.append((i.id1, i.id2, *n, *x - center[i.id1], *x - center[i.id2], i.phys.bias[k],
                         i.phys.tangensOfFrictionAngle))
    problem = problem_of_rows("scene", inverse_mass, v, rows)
    u = jacobian_times(problem, np.array(v)) + problem["bias"][:, None] * [1, 0]
    miss = error(np.array(p), u, problem["friction"], weights(problem))
    return np.linalg.norm(miss) / np.linalg.norm(p)


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


def test_model_follows_the_scene():
    """With friction a point has two unknowns, bodies rotate; a freed floor joins the heaps."""
    smooth = material(0)
    build(box((3, -0.1), (6, 0.1), material=smooth),  # three heaps that do not touch
          *(stadium(0, 0.05, (2 * heap + 0.1 * column + 0.03 * (row % 2), 0.05 + 0.09 * row),
                    material=smooth)
            for heap in range(3) for row in range(4) for column in range(5)),
          tolerance=1e-6, maxIterations=5000, solver="nesterov")
    with warns("bodies #26 and #31 overlap .* more pairs"):
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
