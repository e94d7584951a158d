"""Motion without inertia: every step starts from rest or from a homogeneous flow."""

import numpy as np
import pytest
import rcr
from scenes import build, material, plane, solver, stadium, warns
from yade import O
from yade.minieigenHP import Matrix3, Vector3


def flowing(*bodies, flow=Matrix3.Zero, gravity=(0, 0, 0), dt=1e-2):
    ids = build(*bodies, gravity=gravity, dt=dt, tolerance=1e-8)
    solver().overdamped, solver().flow = True, flow
    return [O.bodies[i] for i in ids], solver()


@pytest.mark.parametrize("g", [0, -9.81])
def test_a_body_alone_goes_with_the_flow(g):
    """v = flow · r + g dt and ω = half of the flow's curl, whatever the velocity before."""
    (body,), _ = flowing(stadium(0.1, 0.05, (1, 2)), flow=plane(0.3, 0.1, -0.5, -0.3),
                         gravity=(0, g, 0))
    body.state.vel = Vector3(100, 0, 0)
    for _ in range(3):
        x, y, _ = body.state.pos
        u, v = 0.3 * x + 0.1 * y, -0.5 * x - 0.3 * y + 1e-2 * g
        O.step()
        assert tuple(body.state.vel) == pytest.approx((u, v, 0), rel=1e-12)
        assert tuple(body.state.angVel) == pytest.approx((0, 0, -0.3), rel=1e-12)
        assert tuple(body.state.pos) == pytest.approx((x + 1e-2 * u, y + 1e-2 * v, 0), rel=1e-12)


def test_a_flow_exerts_no_force_on_bodies_that_follow_it():
    """Touching discs carry no force in a flow that separates them; under compression all move at
    the mean velocity v = −0.1, and contact k carries Σ_{j ≤ k} m (v_j − v)/dt.
    """
    for rate in (0.2, -0.2):
        bodies, _ = flowing(*(rcr.disc((0.1 + 0.2 * k, 1), 0.1, material(0)) for k in range(5)),
                            flow=plane(rate, 0, 0, -rate))
        O.step()
        force = {(i.id1, i.id2): i.phys.normalForce.norm() for i in O.interactions}
        beyond = np.cumsum([-0.2 * (0.1 + 0.2 * k) + 0.1 for k in range(4)])
        expected = (rate < 0) * bodies[0].state.mass * beyond / 1e-2
        assert [force.get((k, k + 1), 0) for k in range(4)] == pytest.approx(expected, rel=1e-6,
                                                                             abs=0)


def pressed_row(follows, steps, count=20, last=100_000, rate=-0.2):
    """Force on the fixed wall of a row beyond the pressure on its other wall, over the drag of the
    row at rest Σ m |rate| x/dt, in a flow; the last step has at most `last` sweeps.
    """
    discs = [rcr.disc((0.1 + 0.2 * k, 0), 0.1, material(0)) for k in range(count)]
    bodies, solver = flowing(rcr.wall("x", 0, material=material(0)), *discs,
                             rcr.mobile_wall("x", 0.2 * count, 1e-3, -1, material(0)),
                             flow=plane(rate, 0, 0, -rate))
    solver.trackMeanStretch, solver.accuracy = follows, 1e-8
    pressure = 1e4
    O.forces.setPermF(bodies[-1].id, (-pressure, 0, 0))
    for left in reversed(range(steps)):
        solver.maxIterations = 100_000 if left else last
        O.step()
    drag = bodies[1].state.mass * sum(0.1 + 0.2 * k for k in range(count)) * abs(rate) / O.dt
    return (-O.forces.f(0)[0] - pressure) / drag


def test_a_common_motion_has_no_drag_in_a_tracked_flow():
    """The row stretches by 0.2 beyond its flow; the next step has no drag while this is tracked."""
    for follows, steps, drag in ((False, 1, 1), (False, 3, 1), (True, 1, 1), (True, 3, 0)):
        assert pressed_row(follows, steps) == pytest.approx(drag, abs=1e-4)
    assert tuple(solver().model["mean_stretch_rate"]) == pytest.approx((0.2, 0), abs=1e-4)
    solver().trackMeanStretch = False
    O.step()
    assert tuple(solver().model["mean_stretch_rate"]) == (0, 0)
    # a vanished drag is removed from the impulses: five sweeps alone reach five contacts
    assert abs(pressed_row(True, 2, count=100, last=5, rate=-1e-3)) < 0.05


def test_a_last_pass_still_removes_overlaps():
    """A disc pushes a row together, one contact in each pass; two discs elsewhere overlap."""
    smooth, R = material(0), 0.01
    disc = lambda x, y: rcr.disc((x * R, y * R), R, material=smooth)
    bodies, _ = flowing(*(disc(2.2 * k, 0) for k in range(25)), disc(0, 10), disc(1.9, 10), dt=1e-3)
    O.forces.setPermF(0, (20 * bodies[0].state.mass * R / O.dt**2, 0, 0))
    with warns("bodies #25 and #26 overlap"):
        O.step()
    assert not solver().converged, "no contact is missing in the last pass: the test tests nothing"
    left, right = (b.state.pos[0] for b in bodies[-2:])
    assert right - left == pytest.approx(2 * R, rel=1e-6)
