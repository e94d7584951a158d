"""Pours pentagons, hexagons, squares and triangles into a box.

`rcr.regular_polygon` makes the grains. Each pair of shapes that can meet has an `Ig2`. The script
compares the numbers of contacts of each shape.

Run it with YADE:  scripts/yade-rcr -n -x examples/polygons.py
Writes DIR/polygons.png (contact forces), DIR/types.png (types of contacts) and
DIR/shapes.csv, one row per shape.
"""

import math
import random

import numpy as np

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R, SIDES = 0.01, (3, 4, 5, 6)
WIDE, HIGH = (6, 6) if options.quick else (12, 16)
draw = random.Random(3)
rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
O.bodies.append(rcr.wall("y", 0, +1, material=rough))
O.bodies.append([rcr.wall("x", x, sense, material=rough)
                 for x, sense in ((0, +1), (2.1 * R * WIDE, -1))])
O.bodies.append([
    regular_polygon((2.1 * R * (i + 0.5), 2.1 * R * (j + 0.5)), R * draw.uniform(0.7, 1),
                    draw.choice(SIDES), angle=draw.uniform(0, math.pi), material=rough)
    for i in range(WIDE) for j in range(HIGH)])
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_RoundedPolygon_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
    InteractionLoop([Ig2_RoundedPolygon_RoundedPolygon_RcrGeom(),
                     Ig2_Wall_RoundedPolygon_RcrGeom()],
                    [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
    ContactDynamics(tolerance=1e-4),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
]
O.dt = 5e-4
rcr.advance(800 if options.quick else 2400, "pouring")

network = rcr.contact_network()
sides = np.array([len(shape.corners) for shape in network.shapes])[network.particles["shape"]]
rows = [(n, (sides == n).sum(), network.grain_coordination()[sides == n].mean()) for n in SIDES]
np.savetxt(options.out / "shapes.csv", rows, "%g", ",", header="sides,grains,contacts", comments="")
rcr.snapshot(options.out / "polygons.png", contacts="force")
rcr.snapshot(options.out / "types.png", color="type", contacts="type")
