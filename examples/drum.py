"""Measures the slope and the velocity field in a rotating drum.

A ring of fixed discs rotates and carries long grains. Their surface flows at a steady slope. A
`rcr.Profile` averages the velocity field over time.

Run it with YADE:  scripts/yade-rcr -n -x examples/drum.py
Writes DIR/drum.png, DIR/velocity.png (time average of the speed), and DIR/slope.csv.
"""

import math
import random

import numpy as np
from matplotlib.figure import Figure
from yade import plot

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01
RADIUS = (10 if options.quick else 20) * R
SPIN = 1.0  # angular velocity [rad/s]
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))

# the drum: a ring of overlapping fixed discs
count = round(2 * math.pi * RADIUS / R)
angles = np.linspace(0, 2 * math.pi, count, endpoint=False)
places = [(RADIUS * math.cos(a), RADIUS * math.sin(a)) for a in angles]
ring = O.bodies.append([disc(place, 0.8 * R, material=rough, fixed=True) for place in places])
draw = random.Random(3)
step = 2.05 * R
cells = np.arange(-RADIUS, RADIUS, step)
free = [(x, y) for x in cells for y in cells
        if math.hypot(x, y) < RADIUS - 2 * R and y < 0.5 * RADIUS]
grains = O.bodies.append([particle(place, draw.uniform(0.8, 1) * R, 0.5,
                                   draw.uniform(0, math.pi), rough) for place in free])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Sphere_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Sphere_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    RotationEngine(ids=ring, rotateAroundZero=True, zeroPoint=(0, 0, 0), rotationAxis=(0, 0, 1),
                   angularVelocity=SPIN),
    ContactDynamics(tolerance=1e-4, maxIterations=10_000),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    PyRunner(command="record()", iterPeriod=10),
]
O.dt = 1e-3
flow = rcr.Profile(cells=(20, 20), limits=((-RADIUS, -RADIUS), (RADIUS, RADIUS)))


def record():
    """Store the slope, from the centre of mass; average the flow after the first second."""
    x, y, _ = np.mean([O.bodies[k].state.pos for k in grains], axis=0)
    plot.addData(t=O.time, slope=math.degrees(math.atan2(x, -y)))
    if O.time > 1 and O.iter % 50 == 0:
        flow.compute(reset=False)


rcr.advance(1200 if options.quick else 4000, "turning")
t, slope = np.array([plot.data["t"], plot.data["slope"]])
np.savetxt(options.out / "slope.csv", np.column_stack([t, slope]), delimiter=",",
           header="t,slope", comments="", fmt="%g")
rcr.snapshot(options.out / "drum.png", color="speed")
if O.time <= 1:
    raise SystemExit("stopped before the flow was steady")
figure = Figure(figsize=(4, 3.2), layout="constrained")
flow.plot(figure.add_subplot(), "speed").set_title(f"mean of {t[-1] - 1:.1f} s", fontsize=9)
figure.savefig(options.out / "velocity.png", dpi=150)
late = slope[t > 1]
print(f"{len(grains)} grains at {SPIN} rad/s: slope {late.mean():.1f}°, "
      f"standard deviation {late.std():.1f}°")
