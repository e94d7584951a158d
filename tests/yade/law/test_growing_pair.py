"""A pair that gains points within a step is gathered again: a disc falls at 50 m/s on a tilted
brick that rests on one end; the second end comes within the alert distance of the floor.
"""

import math

import numpy as np
import rcr
from scenes import build, material, solver
from yade import O


def test_points_and_forces_belong_together():
    rough, tilt, a, r = material(), 0.01, 0.9, 0.1
    brick = rcr.particle((0, r + a * math.sin(tilt)), 1, 0.9, angle=tilt, material=rough)
    top = r + a * math.sin(tilt) + 0.5 * math.tan(tilt) + r / math.cos(tilt)
    disc = rcr.particle((0.5, top + 0.2 + 1e-4), 0.2, 0, material=rough, velocity=(0, -50))
    floor, brick, disc = build(rcr.wall("y", 0, material=rough), brick, disc)
    O.step()
    pair = O.interactions[floor, brick]
    assert pair.phys.points == pair.geom.points == 2  # a disc at 20 m/s leaves the pair at one
    # The problem holds every point of the pair: the forces on the brick are those of its contacts.
    assert solver().contactPoints == sum(i.geom.points for i in O.interactions)
    assert O.bodies[brick].state.pos[1] > 0 and np.isfinite(O.bodies[disc].state.vel[1])
