"""The angle of repose against the elongation: a wall is taken away, and what stays on the rough floor has the slope of rest.

Run it with YADE:  scripts/yade-rcr -n -x examples/angle_of_repose.py
Writes DIR/slope-ETA.png, DIR/angle_of_repose.png and DIR/angle_of_repose.csv.
"""

import math
import os
import random

import matplotlib.pyplot as plt
import numpy as np

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01  # m, radius of the largest discs; long grains have their area
ETAS, GRAINS, LENGTH = ((0, 0.6), 60, 14 * R) if options.quick else ((0, 0.2, 0.4, 0.6), 280, 29 * R)  # of the floor: what passes its end falls away


def settle(eta):
    """A box with a floor of fixed grains; returns the wall on the right, the gate."""
    O.reset()
    draw = random.Random(2)
    rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
    O.bodies.append([particle((0.9 * R * i, -R), 0.5 * R, 0, fixed=True, material=rough) for i in range(round(LENGTH / (0.9 * R)) + 1)])
    O.bodies.append(rcr.wall("x", 0, +1, material=rough))
    gate = O.bodies.append(rcr.wall("x", LENGTH, -1, material=rough))
    long = R * math.sqrt(math.pi / (math.pi * (1 - eta) ** 2 + 4 * eta * (1 - eta)))  # circumscribed radius for the area of the disc
    columns = int(LENGTH / (2.1 * long))
    O.bodies.append([particle((LENGTH / columns * (k % columns + 0.5), 2.1 * long * (k // columns + 0.5)), draw.uniform(0.8, 1) * long, eta,
                              draw.uniform(0, math.pi), rough) for k in range(GRAINS)])
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                        [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        ContactDynamics(tolerance=1e-4),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
    ]
    O.dt = 1e-3
    return gate


def slope():
    """Angle of the line through the highest grains over seven stretches of the floor [°]."""
    x, y = rcr.contact_network().particles["position"].T
    edges = np.linspace(0.1, 0.9, 8) * LENGTH
    tops = [(x[k], y[k]) for low, high in zip(edges, edges[1:]) if (over := np.flatnonzero((x >= low) & (x < high) & (y > 0))).size
            for k in [over[y[over].argmax()]]]
    return math.degrees(math.atan(-np.polyfit(*np.transpose(tops), 1)[0]))


found = []
for eta in ETAS:
    gate = settle(eta)
    going = rcr.advance(400 if options.quick else 800, f"η = {eta}, filling")
    O.bodies.erase(gate)
    # at rest when no grain on the floor moves by a hundredth of its size in a tenth of a second
    still = lambda: max(b.state.vel.norm() for b in O.bodies if b.dynamic and b.state.pos[1] > 0) < 0.1 * R
    going = going and rcr.advance(600 if options.quick else 2500, f"η = {eta}, flowing out", until=still, every=100)
    found.append((eta, slope()))
    print(f"eta = {eta}: the slope rests at {found[-1][1]:.1f}°")
    rcr.snapshot(os.path.join(options.out, f"slope-{eta}.png"), limits=((0, -2 * R), (LENGTH, 0.9 * LENGTH)))
    if not going:
        break

np.savetxt(os.path.join(options.out, "angle_of_repose.csv"), found, delimiter=",", header="eta,angle", comments="", fmt="%g")
fig, ax = plt.subplots(figsize=(4, 3), layout="constrained")
ax.plot(*np.array(found).T, "o-")
ax.set(xlabel=r"elongation $\eta$", ylabel="angle of repose [°]", ylim=(0, None))
fig.savefig(os.path.join(options.out, "angle_of_repose.png"), dpi=150)
