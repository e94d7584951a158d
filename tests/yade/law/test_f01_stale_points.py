"""A pair that gains points within a step is gathered again.

A brick (R = 1, η = 0.9, tilted by 0.02) rests with one end on the floor; a disc (R = 0.2) 1e-4
above
it falls at 50 m/s. The brick leaves its alert distance, the floor detects its second end, and the
pair grows from one point to two within the step.
"""

import math

import numpy as np
import rcr
from scenes import build, material, solver, steps
from yade import O


def least_case(y_of_disc=1e-4):
    rough = material()
    tilt = 0.02
    a, r = 0.9, 0.1
    brick = rcr.particle((0, r + a * math.sin(tilt)), 1, 0.9, angle=tilt, material=rough)
    top = r + a * math.sin(tilt) + 0.5 * math.tan(tilt) + r / math.cos(tilt)
    disc = rcr.particle((0.5, top + 0.2 + y_of_disc), 0.2, 0, material=rough)
    disc.state.vel = (0, -50, 0)
    return build(rcr.wall("y", 0, material=rough), brick, disc)


def test_points_and_forces_belong_together():
    floor, brick, disc = least_case()
    steps(1)
    pair = O.interactions[floor, brick]
    assert pair.phys.points == pair.geom.points
    # The problem holds every point of the pair: the forces on the brick are those of its contacts.
    assert solver().contactPoints == sum(i.geom.points for i in O.interactions if i.isReal)
    assert O.bodies[brick].state.pos[1] > 0 and np.isfinite(O.bodies[disc].state.vel[1])
