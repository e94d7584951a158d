"""Compares stresses in discs and in long grains of one bed.

Discs and long grains are poured into a box. `rcr.contact_network` gives the stress and the number
of contacts of each grain. The script compares their means over discs and over long grains.

Run it with YADE:  scripts/yade-rcr -n -x examples/mixture.py
Writes DIR/mixture.png (kinds of grains), DIR/pressure.png (mean stress of each grain), and
DIR/grains.csv, one row per grain.
"""

import math
import random

import numpy as np

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01
WIDE, HIGH = (6, 8) if options.quick else (14, 24)
LENGTH = 2.1 * R * WIDE
draw = random.Random(5)
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
O.bodies.append(rcr.wall("y", 0, +1, material=rough))
O.bodies.append([rcr.wall("x", x, sense, material=rough) for x, sense in ((0, +1), (LENGTH, -1))])
for i in range(WIDE):
    for j in range(HIGH):
        at = (2.1 * R * (i + 0.5), 2.1 * R * (j + 0.5))
        if draw.random() < 0.5:
            # rcr.disc has the mass of a disc; utils.sphere has that of a ball
            O.bodies.append(disc(at, 0.6 * R, material=rough))
        else:
            O.bodies.append(particle(at, R, 0.7, draw.uniform(0, math.pi), rough))
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Sphere_Rcr_RcrGeom(), Ig2_Sphere_Sphere_RcrGeom(),
                     Ig2_Wall_Rcr_RcrGeom(), Ig2_Wall_Sphere_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4, maxIterations=10_000),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
]
O.dt = 1e-3
rcr.advance(500 if options.quick else 1500, "pouring")

network = rcr.contact_network(volume=LENGTH * rcr.measure.extent()[1, 1])
grains = network.particles
pressure = 0.5 * np.einsum("naa->n", network.grain_stresses())
contacts = network.grain_coordination()
long = grains["half_length"] > 0
rcr.snapshot(options.out / "mixture.png", color="type", contacts="force")
rcr.snapshot(options.out / "pressure.png", color="pressure")
table = np.column_stack([grains["id"], long, grains["position"], pressure, contacts])
np.savetxt(options.out / "grains.csv", table, delimiter=",",
           header="id,long,x,y,pressure,contacts", comments="", fmt="%.10g")
for name, pick in (("discs", ~long), ("long grains", long)):
    print(f"{pick.sum()} {name}: {contacts[pick].mean():.2f} contacts per grain, "
          f"mean stress {pressure[pick].mean():.0f} Pa")
