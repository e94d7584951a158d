"""Drops sixty-four long grains on a floor, as in the README.

The script lists the engines of a scene with rigid contacts. It saves a picture of the grains and
their contact forces. It counts contacts with `rcr.contact_network`.

Run it with YADE:  scripts/yade-rcr -n -x examples/first_scene.py
Writes DIR/first_scene.png and DIR/grains.csv, one row per grain.
"""

import numpy as np

import rcr  # loads the plugin into the running YADE
from rcr import *  # Rcr, Bo1_Rcr_Aabb, Ig2_…, ContactDynamics, particle, disc, …
from rcr import script

options = script.options(__doc__)

rough = O.materials.append(FrictMat(density=2600, frictionAngle=0.46))
O.bodies.append(rcr.wall("y", 0, sense=+1, material=rough))  # `wall` is YADE's function
O.bodies.append([particle((0.03 * i, 0.05 + 0.03 * j), R=0.01, eta=0.5, angle=i + j, material=rough)
                 for i in range(8) for j in range(8)])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.001),
    InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4),  # solves all contacts of the step together
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
]
O.dt = 1e-3  # [s], bounded by accuracy, not by a stiffness
rcr.advance(300 if options.quick else 1000, "fall")

network = rcr.contact_network()
rcr.snapshot(options.out / "first_scene.png", contacts="force")
grains = network.particles
table = np.column_stack([grains["id"], grains["position"], grains["angle"]])
np.savetxt(options.out / "grains.csv", table, delimiter=",", header="id,x,y,angle", comments="")
print(f"{network.between_particles.sum()} contacts between {len(grains['id'])} grains, "
      f"{network.grain_coordination().mean():.2f} per grain including the floor")
