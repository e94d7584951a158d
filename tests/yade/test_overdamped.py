"""Motion without inertia: every step starts from rest, which may be a homogeneous flow."""

import math

import pytest
import rcr
from scenes import build, material, stadium
from yade import O
from yade.minieigenHP import Matrix3, Vector3


def flowing(*bodies, flow=Matrix3.Zero, gravity=(0, 0, 0), dt=1e-2):
    ids = build(*bodies, gravity=gravity, dt=dt, tolerance=1e-8)
    solver = next(engine for engine in O.engines if isinstance(engine, rcr.ContactDynamics))
    solver.overdamped, solver.flow = True, flow
    return [O.bodies[i] for i in ids], solver


def test_a_body_alone_goes_with_the_flow():
    """v = flow · r, ω = half of the flow's curl, in each step anew; what it had before is forgotten."""
    (body,), _ = flowing(stadium(0.1, 0.05, (1, 2)), flow=Matrix3(0.3, 0.1, 0, -0.5, -0.3, 0, 0, 0, 0))
    body.state.vel = Vector3(100, 0, 0)
    for _ in range(3):
        x, y, _ = body.state.pos
        O.step()
        assert tuple(body.state.vel) == pytest.approx((0.3 * x + 0.1 * y, -0.5 * x - 0.3 * y, 0), rel=1e-12)
        assert tuple(body.state.angVel) == pytest.approx((0, 0, -0.3), rel=1e-12)
        assert tuple(body.state.pos) == pytest.approx((x + 1e-2 * body.state.vel[0], y + 1e-2 * body.state.vel[1], 0), rel=1e-12)


def test_a_load_moves_a_body_relative_to_the_flow():
    """A step from rest: v = flow · r + g dt, and no more in the next one."""
    (body,), _ = flowing(stadium(0.1, 0.05, (1, 2)), flow=Matrix3(0.3, 0, 0, 0, -0.3, 0, 0, 0, 0), gravity=(0, -9.81, 0))
    for _ in range(3):
        y = body.state.pos[1]
        O.step()
        assert body.state.vel[1] == pytest.approx(-0.3 * y - 9.81e-2, rel=1e-12)


def test_a_flow_presses_nothing_on_what_goes_with_it():
    """A row of touching discs in a flow that draws them apart carries no force; pressed together, m Δv/dt of the motion that contacts prevent."""
    discs = lambda: [rcr.disc((0.1 + 0.2 * k, 1), 0.1, material(0)) for k in range(5)]
    bodies, _ = flowing(*discs(), flow=Matrix3(0.2, 0, 0, 0, -0.2, 0, 0, 0, 0))
    O.step()
    assert max((i.phys.normalForce.norm() for i in O.interactions if i.isReal), default=0) == 0
    bodies, _ = flowing(*discs(), flow=Matrix3(-0.2, 0, 0, 0, 0.2, 0, 0, 0, 0))
    mass = bodies[0].state.mass
    O.step()
    force = {(i.id1, i.id2): i.phys.normalForce.norm() for i in O.interactions if i.isReal}
    # Momentum stays: all go on at the mean, −0.1; contact k carries Σ_{j ≤ k} m (v_j − v) / dt of the bodies before it.
    free = [-0.2 * (0.1 + 0.2 * k) for k in range(5)]
    for k in range(4):
        assert force[k, k + 1] == pytest.approx(mass * sum(v + 0.1 for v in free[: k + 1]) / 1e-2, rel=1e-6)


def pressed_row(follows, count=20, overlap=1e-4):
    """A row of discs that overlap their neighbours, between a fixed wall and one that a force presses. Returns Δσ/σ at the fixed wall in the first step.

    The step takes all overlaps back: disc k moves by k δ, against its drag m k δ/dt².
    """
    discs = [rcr.disc((0.1 + k * (0.2 - overlap), 1), 0.1, material(0)) for k in range(count)]
    end = 0.2 * count - (count - 1) * overlap
    bodies, solver = flowing(rcr.wall("x", 0, material=material(0)), *discs, rcr.mobile_wall("x", end, 1e-9, -1, material(0)))
    solver.followFlow, solver.maxIterations = follows, 20_000
    pressure = 1e4
    O.forces.setPermF(bodies[-1].id, (-pressure, 0, 0))
    O.step()
    for k, body in enumerate(bodies[1:-1]):
        assert body.state.vel[0] == pytest.approx(k * overlap / O.dt, abs=1e-3 * overlap / O.dt)
    drag = bodies[1].state.mass * sum(range(count)) * overlap / O.dt**2
    return (-O.forces.f(0)[0] - pressure) / drag


def test_what_bodies_do_together_meets_no_drag_of_a_flow_that_follows():
    """Each disc drags less than that of its own place in the row, some twentieth of the row."""
    assert pressed_row(False) == pytest.approx(1, rel=1e-3)
    assert abs(pressed_row(True)) < 0.05


def test_a_flow_that_follows_is_one_without_inertia():
    (body,), solver = flowing(stadium(0.1, 0.05, (1, 2)))
    solver.overdamped, solver.followFlow = False, True
    with pytest.raises(ValueError, match="ContactDynamics.followFlow = True; wanted only with overdamped"):
        O.step()
    assert tuple(body.state.pos) == (1, 2, 0)


def test_iterations_left_by_a_flow_that_fits_are_used():
    """Nothing stretches as a whole beside a fast flow, so there is one pass, which has them all: it ended after a quarter of them."""
    m = material(0)
    flow = Matrix3(0, 1e6, 0, 0, 0, 0, 0, 0, 0)
    _, solver = flowing(rcr.wall("y", 0, +1, material=m), *(rcr.disc((0, 0.1 + 0.2 * k), 0.1, m) for k in range(30)), flow=flow, gravity=(0, -9.81, 0))
    solver.followFlow, solver.tolerance, solver.maxIterations, solver.solver = True, 1e-14, 40, "nlgs"
    O.step()
    assert not solver.converged and solver.iterations == 40


@pytest.mark.parametrize("overdamped, value", [(False, 0.1), (True, math.nan), (True, math.inf)])
def test_a_flow_that_cannot_be_is_refused(overdamped, value):
    (body,), solver = flowing(stadium(0.1, 0.05, (1, 2)), flow=Matrix3(value, 0, 0, 0, 0, 0, 0, 0, 0))
    solver.overdamped = overdamped
    with pytest.raises(ValueError, match="ContactDynamics.flow is not zero; wanted finite, and only with overdamped"):
        O.step()
    assert tuple(body.state.pos) == (1, 2, 0)
