"""Lets a column of grains of several elongations collapse over a block.

A PyRunner saves a picture every few steps, and `rcr.movie` makes a film of them. One picture shows
the orientation of the long axes. Another one shows the contact forces.

Run it with YADE:  scripts/yade-rcr -n -x examples/packing.py
Writes DIR/packing.png (orientations), DIR/forces.png (contact forces) and DIR/pile.gif.
"""

import math
import random

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
pictures = options.out / "film"
pictures.mkdir(exist_ok=True)
for earlier in pictures.glob("*.png"):
    earlier.unlink()  # the film shows every picture of the folder

R = 0.01  # circumscribed radius of the largest grain [m]
WIDE, HIGH, SECONDS = (5, 10, 0.8) if options.quick else (12, 28, 1.6)

rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
LENGTH = 5 * WIDE * R
O.bodies.append(rcr.wall("y", 0, +1, material=rough))
O.bodies.append([rcr.wall("x", x, sense, material=rough) for x, sense in ((0, +1), (LENGTH, -1))])
O.bodies.append(box((0.7 * LENGTH, R, 0), (2 * R, R, R), orientation=Quaternion((0, 0, 1), 0.4),
                    fixed=True, material=rough))
draw = random.Random(1)
for i in range(WIDE):
    for j in range(HIGH):
        place = (2.1 * R * (i + 0.5), 2.1 * R * (j + 0.5))
        size, eta = draw.uniform(0.7, 1) * R, draw.choice((0, 0.3, 0.5, 0.7))
        O.bodies.append(particle(place, size, eta, draw.uniform(0, math.pi), rough))

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom(), Ig2_Box_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4, maxIterations=10_000),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
]
O.dt = 1e-3

steps = round(SECONDS / O.dt)
picture = str(pictures / "{:05d}.png")
view = ((0, 0), (LENGTH, 2.2 * R * HIGH))
command = "rcr.snapshot(picture.format(O.iter), limits=view, legend=False, dpi=60)"
O.engines += [PyRunner(command=command, iterPeriod=steps // 20, initRun=True)]
rcr.advance(steps, "collapse")

rcr.movie(pictures, options.out / "pile.gif")
print(rcr.snapshot(options.out / "packing.png"))
print(rcr.snapshot(options.out / "forces.png", color="#e8e4da", contacts="force"))
