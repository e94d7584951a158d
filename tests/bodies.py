"""Bodies and states of small scenes in YADE, for tests and benchmarks."""

import math

import numpy as np
import yade.utils  # before rcr, which loads its plugin into it
import rcr
from yade import O
from yade import wrapper as w
from yade.minieigenHP import Quaternion, Vector3

G = 9.81  # m/s²
DENSITY = 1000.0  # kg/m³


def material(friction=0.5, density=DENSITY):
    """FrictMat with the friction coefficient µ [-] and the density [kg/m³]."""
    return w.FrictMat(density=density, frictionAngle=math.atan(friction), young=1e9, poisson=0.3)


def stadium(a, r, center, angle=0.0, **options):
    """Body with the half length a and the cap radius r [m]; a = 0 is a disc."""
    return rcr.particle(center, R=a + r, eta=a / (a + r), angle=angle, **options)


def box(center, half_extent, angle=0.0, material=None):
    """Fixed rectangle [m, rad]."""
    orientation = Quaternion(Vector3(0, 0, 1), angle)
    return yade.utils.box((*center, 0), (*half_extent, 1), orientation=orientation, fixed=True,
                          material=material)


def open_box(width, rough):
    """Walls left, right and bottom of a box with its corner at the origin."""
    return [rcr.wall(axis, at, material=rough) for axis, at in (("x", 0), ("x", width), ("y", 0))]


def tilted(alpha):
    """Gravity on a slope that falls by α towards +x, in the frame of the slope."""
    return (G * math.sin(alpha), -G * math.cos(alpha), 0)


def state(i):
    return O.bodies[i].state


def positions(ids):
    """Centres of the bodies, (n, 2) [m]."""
    return np.array([state(i).pos for i in ids])[:, :2]


def angle(i):
    """Angle of the long axis to x, in (−π, π] [rad]."""
    q = state(i).ori
    return math.remainder(2 * math.atan2(q[2], q[3]), 2 * math.pi)


def twist(i):
    """(v_x, v_y, ω) [m/s, m/s, rad/s]."""
    s = state(i)
    return np.array([s.vel[0], s.vel[1], s.angVel[2]])


def free():
    return [b for b in O.bodies if b and b.state.blockedDOFs != "xyzXYZ" and b.state.mass > 0]


def kinetic(bodies=None):
    """Kinetic energy of these bodies, by default of all free ones [J/m]."""
    return sum(0.5 * b.state.mass * b.state.vel.squaredNorm()
               + 0.5 * b.state.inertia[2] * b.state.angVel[2]**2 for b in bodies or free())


def solver():
    return yade.utils.typedEngine("ContactDynamics")
