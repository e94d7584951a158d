"""rcr.half_step_start makes velocities those of the present time; test_chart.py has its order."""

import pytest
import rcr
from scenes import G, build, material, stadium
from yade import O

def test_gravity_and_permanent_loads_of_what_is_free():
    m = material()
    _, grain = build(rcr.wall("y", 0, material=m), stadium(0.2, 0.1, (0, 5), material=m), dt=1e-2)
    clump, _ = rcr.clump([rcr.disc((3 + k, 5), 0.4, m) for k in range(2)])
    guided = O.bodies.append(rcr.particle((8, 5), 0.2, 0.5, material=m))
    O.bodies[guided].state.blockedDOFs = "xzXYZ"
    wall = O.bodies.append(rcr.mobile_wall("x", 20, 2.0, material=m))  # without inertia
    s = O.bodies[grain].state
    O.forces.setPermF(grain, (3 * s.mass, 0, 0))
    O.forces.setPermT(grain, (0, 0, 2 * s.inertia[2]))
    O.forces.setPermF(guided, (1, 0, 0))
    O.forces.setPermF(wall, (3, 0, 0))
    starts = {i: O.bodies[i].state.pos for i in (grain, clump, guided, wall)}
    rcr.half_step_start()
    O.run(20, True)
    t = 20 * O.dt
    for i, (x, y) in {grain: (1.5 * t**2, -0.5 * G * t**2), clump: (0, -0.5 * G * t**2),
                      guided: (0, -0.5 * G * t**2), wall: (0.75 * t**2, 0)}.items():
        assert tuple(O.bodies[i].state.pos - starts[i]) == pytest.approx((x, y, 0), abs=1e-9), i
    assert s.rot()[2] == pytest.approx(t**2, abs=1e-9)


def test_a_pile_at_rest_stays_at_rest():
    m = material(friction=0.5)
    ids = build(rcr.wall("y", 0, material=m), *(stadium(0.2, 0.1, (0, 0.1 + 0.2 * k), material=m)
                                                for k in range(5)))
    rcr.half_step_start()
    O.run(100, True)
    assert max(O.bodies[i].state.vel.norm() for i in ids) < 1e-6
    assert max(O.bodies[i].state.displ().norm() for i in ids) < 1e-6
