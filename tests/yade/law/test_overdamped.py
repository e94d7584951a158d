"""Motion without inertia: every step starts from rest or from a homogeneous flow."""

import math

import pytest
import rcr
from scenes import build, material, plane, solver, stadium
from yade import O
from yade.minieigenHP import Matrix3, Vector3


def flowing(*bodies, flow=Matrix3.Zero, gravity=(0, 0, 0), dt=1e-2):
    ids = build(*bodies, gravity=gravity, dt=dt, tolerance=1e-8)
    solver().overdamped, solver().flow = True, flow
    return [O.bodies[i] for i in ids], solver()


def test_a_body_alone_goes_with_the_flow():
    """v = flow · r, ω = half of the flow's curl in each step, whatever the velocity before."""
    (body,), _ = flowing(stadium(0.1, 0.05, (1, 2)), flow=plane(0.3, 0.1, -0.5, -0.3))
    body.state.vel = Vector3(100, 0, 0)
    for _ in range(3):
        x, y, _ = body.state.pos
        u, v = 0.3 * x + 0.1 * y, -0.5 * x - 0.3 * y
        O.step()
        assert tuple(body.state.vel) == pytest.approx((u, v, 0), rel=1e-12)
        assert tuple(body.state.angVel) == pytest.approx((0, 0, -0.3), rel=1e-12)
        assert tuple(body.state.pos) == pytest.approx((x + 1e-2 * u, y + 1e-2 * v, 0), rel=1e-12)


def test_a_load_moves_a_body_relative_to_the_flow():
    """v = flow · r + g dt in every step."""
    (body,), _ = flowing(stadium(0.1, 0.05, (1, 2)), flow=plane(0.3, 0, 0, -0.3),
                         gravity=(0, -9.81, 0))
    for _ in range(3):
        y = body.state.pos[1]
        O.step()
        assert body.state.vel[1] == pytest.approx(-0.3 * y - 9.81e-2, rel=1e-12)


def test_a_flow_exerts_no_force_on_bodies_that_follow_it():
    """A row of touching discs carries no force in a flow that separates them.

    Under compression the contacts carry m Δv/dt of the motion that they prevent.
    """
    discs = lambda: [rcr.disc((0.1 + 0.2 * k, 1), 0.1, material(0)) for k in range(5)]
    bodies, _ = flowing(*discs(), flow=plane(0.2, 0, 0, -0.2))
    O.step()
    assert max((i.phys.normalForce.norm() for i in O.interactions), default=0) == 0
    bodies, _ = flowing(*discs(), flow=plane(-0.2, 0, 0, 0.2))
    mass = bodies[0].state.mass
    O.step()
    force = {(i.id1, i.id2): i.phys.normalForce.norm() for i in O.interactions}
    # Momentum is conserved: all move at the mean, −0.1; contact k carries Σ_{j ≤ k} m (v_j − v)/dt
    # of the bodies before it.
    free = [-0.2 * (0.1 + 0.2 * k) for k in range(5)]
    for k in range(4):
        assert force[k, k + 1] == pytest.approx(mass * sum(v + 0.1 for v in free[: k + 1]) / 1e-2,
                                                rel=1e-6)


def pressed_row(follows, steps, count=20, last=100_000, rate=-0.2):
    """Touching discs between a fixed wall and a pressed one, in a flow that compresses them.

    Returns the force at the fixed wall beyond the pressure, over the drag of the row at rest,
    Σ m |rate| x/dt, in the last step, which has at most `last` sweeps.
    """
    discs = [rcr.disc((0.1 + 0.2 * k, 0), 0.1, material(0)) for k in range(count)]
    bodies, solver = flowing(rcr.wall("x", 0, material=material(0)), *discs,
                             rcr.mobile_wall("x", 0.2 * count, 1e-3, -1, material(0)),
                             flow=plane(rate, 0, 0, -rate))
    solver.trackMeanStretch, solver.kinematicTolerance = follows, 1e-8
    pressure = 1e4
    O.forces.setPermF(bodies[-1].id, (-pressure, 0, 0))
    for left in reversed(range(steps)):
        solver.maxIterations = 100_000 if left else last
        O.step()
    drag = bodies[1].state.mass * sum(0.1 + 0.2 * k for k in range(count)) * abs(rate) / O.dt
    return (-O.forces.f(0)[0] - pressure) / drag


def test_a_common_motion_has_no_drag_in_a_tracked_flow():
    """The row stretches by 0.2 beyond its flow; the next step includes this and has no drag."""
    for steps in (1, 3):
        assert pressed_row(False, steps) == pytest.approx(1, rel=1e-4)
    assert pressed_row(True, 1) == pytest.approx(1, rel=1e-4)
    assert abs(pressed_row(True, 3)) < 1e-4
    assert tuple(solver().model["mean_stretch_rate"]) == pytest.approx((0.2, 0), abs=1e-4)


def test_a_vanished_drag_is_removed_from_the_impulses():
    """Five sweeps alone reach five contacts."""
    assert abs(pressed_row(True, 2, count=100, last=5, rate=-1e-3)) < 0.05


def test_a_flow_that_follows_no_longer_is_forgotten():
    assert abs(pressed_row(True, 3)) < 1e-4
    solver().trackMeanStretch = False
    O.step()
    assert tuple(solver().model["mean_stretch_rate"]) == (0, 0)


FLOW = "ContactDynamics.flow is not zero; expected finite entries, and overdamped = True"


@pytest.mark.parametrize("overdamped, track, rate, message", [
    (False, True, 0, "ContactDynamics.trackMeanStretch = True; expected overdamped = True"),
    (False, False, 0.1, FLOW), (True, False, math.nan, FLOW), (True, False, math.inf, FLOW),
])  # fmt: skip
def test_a_flow_that_cannot_be_is_refused(overdamped, track, rate, message):
    (body,), solver = flowing(stadium(0.1, 0.05, (1, 2)), flow=plane(rate, 0, 0, 0))
    solver.overdamped, solver.trackMeanStretch = overdamped, track
    with pytest.raises(ValueError, match=message):
        O.step()
    assert tuple(body.state.pos) == (1, 2, 0)
