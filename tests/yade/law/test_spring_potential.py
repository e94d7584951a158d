"""Springs without friction have a potential: forces are the gradient of the elastic energy."""

import math

import numpy as np
import pytest
import rcr
from scenes import KN, build, material, prescribe, set_state
from yade import O
from yade.minieigenHP import Quaternion

DEEP, HALF = 1e-4, 0.05  # overlap, half length of the sides that slide [m]
SQUARE = [(HALF, HALF), (-HALF, HALF), (-HALF, -HALF), (HALF, -HALF)]
PAIRS = {  # two grains whose upper and lower sides are parallel to x; half their height; R
    "rods": (lambda at, **more: rcr.particle(at, 0.1, 0.5, 0, **more), 0.05, 0.1),
    "rounded squares": (lambda at, **more: rcr.polygon(at, SQUARE, 0.05, **more), 0.1,
                        math.sqrt(2) * HALF + 0.05),
    "squares": (lambda at, **more: rcr.polygon(at, SQUARE, **more), 0.05, math.sqrt(2) * HALF),
}


def place(pair, **options):
    """A fixed grain, and another one above it: id of the upper one, half the height of both, the
    shadow below which the second point loses weight."""
    make, height, radius = PAIRS[pair]
    m = material(0)
    _, upper = build(make((0, 0), fixed=True, material=m), make((0, 5), material=m), law="smooth",
                     dt=1e-6, gravity=(0, 0, 0), **options)
    prescribe("kn", KN)
    O.trackEnergy = True
    return upper, height, 0.1 * radius


def elastic(upper, x, y, angle):
    """Elastic energy [J/m] and force (f_x, f_y, torque) on a body at this pose."""
    set_state(upper, pos=(x, y, 0), ori=Quaternion((0, 0, 1), angle), vel=(0, 0, 0),
              angVel=(0, 0, 0))
    O.step()
    force, torque = O.forces.f(upper), O.forces.t(upper)
    return O.energy["elastPotential"], np.array([force[0], force[1], torque[2]])


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("adhesion", [0, 1])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.8, 1.5])
def test_forces_are_the_gradient_of_the_energy(pair, adhesion, side, share):
    """The upper grain slides off the lower one; `share` of the fading length is left."""
    upper, height, fading = place(pair, adhesion=adhesion)
    for tilt in (DEEP, -DEEP):
        pose = np.array([side * (2 * HALF - share * fading), 2 * height - DEEP, tilt])
        _, force = elastic(upper, *pose)
        contact = O.interactions[0, upper]
        assert contact.geom.points == 2 and contact.geom.slide == side
        assert contact.geom.shadow == pytest.approx(share * fading, abs=0.02 * fading)
        assert contact.phys.edge != (0, 0) or share > 1
        step, gradient = 1e-7 * np.array([1, 1, 10]), []
        for k in range(3):
            change = step[k] * np.eye(3)[k]
            ahead, behind = (elastic(upper, *pose + way * change)[0] for way in (1, -1))
            gradient.append((ahead - behind) / (2 * step[k]))
        scale = KN * DEEP
        assert force[:2] == pytest.approx(-np.array(gradient[:2]), abs=1e-5 * scale)
        # the edge force acts at the surface, half an overlap and a radius from the vertex
        assert force[2] == pytest.approx(-gradient[2], abs=1e-3 * scale)


@pytest.mark.parametrize("pair", ["rods", "rounded squares"])
def test_two_points_become_one_without_a_jump(pair):
    """Energy and force near the end of the shadow: a millionth of the side changes neither."""
    upper, height, _ = place(pair)
    for end in (1, -1):
        before = elastic(upper, end * (2 * HALF - 1e-7), 2 * height - DEEP, 0)
        both = O.interactions[0, upper].geom.points
        after = elastic(upper, end * (2 * HALF + 1e-7), 2 * height - DEEP, 0)
        assert (both, O.interactions[0, upper].geom.points) == (2, 1)
        assert after[0] == pytest.approx(before[0], rel=1e-3)
        assert after[1] == pytest.approx(before[1], abs=1e-3 * KN * DEEP)
