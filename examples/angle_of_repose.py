"""Measures the angle of repose of grains of different elongations.

Grains are poured at a wall onto a rough floor and roll off its end. Erased and new grains keep the
heap in a steady state. The slope of its surface grows with the elongation.

Run it with YADE:  scripts/yade-rcr -n -x examples/angle_of_repose.py
Writes DIR/slope-ETA.png, DIR/angle_of_repose.png, and DIR/angle_of_repose.csv (elongation, mean
angle, standard deviation in time).
"""

import math
import random

import matplotlib.pyplot as plt
import numpy as np

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01  # radius of the largest discs [m]; long grains have the same area
ETAS, LENGTH, SECONDS = (0, 0.2, 0.4, 0.6), 36 * R, 5.0
if options.quick:
    ETAS, LENGTH, SECONDS = (0, 0.6), 16 * R, 1.5


def start(eta):
    """Make a wall and a floor of fixed grains."""
    global draw, size, angles
    O.reset()
    draw, angles = random.Random(2), []
    # circumscribed radius of a grain with the area of the disc
    size = R * math.sqrt(math.pi / (math.pi * (1 - eta) ** 2 + 4 * eta * (1 - eta)))
    rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5), label="rough"))
    O.bodies.append([particle((0.9 * R * i, -0.5 * R), 0.5 * R, 0, fixed=True, material=rough)
                     for i in range(round(LENGTH / (0.9 * R)) + 1)])
    O.bodies.append(rcr.wall("x", 0, +1, material=rough))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * R),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom()],
                        [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        ContactDynamics(tolerance=1e-4, maxIterations=10_000),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
        PyRunner(command="pour()", virtPeriod=0.07, initRun=True),
        PyRunner(command="measure()", virtPeriod=0.1),
    ]
    O.dt = 1e-3


def grains():
    return [b for b in O.bodies if isinstance(b.shape, Rcr) and b.dynamic]


def pour():
    """Erase grains below the floor and add three grains above the heap."""
    for body in grains():
        if body.state.pos[1] < -10 * R:
            O.bodies.erase(body.id)
    top = max([b.state.pos[1] for b in grains() if b.state.pos[0] < 8 * R] + [0])
    for k in range(3):
        place = (size * (1.05 + 2.1 * k), top + 3 * size)
        radius, angle = draw.uniform(0.8, 1) * size, draw.uniform(0, math.pi)
        O.bodies.append(particle(place, radius, eta, angle, "rough"))


def measure():
    """Fit a line through the highest resting grains of eight floor sections; store its angle."""
    if O.time < 0.5 * SECONDS:
        return
    network = rcr.contact_network()
    heap = network.particles
    slow = np.hypot(heap["velocity"][:, 0], heap["velocity"][:, 1]) < 0.2
    resting = slow & (network.grain_coordination() > 0) & (heap["position"][:, 1] > 0)
    places = heap["position"][resting]
    section = np.floor(10 * places[:, 0] / LENGTH)
    tops = [max(places[section == k], key=lambda place: place[1])
            for k in range(1, 9) if (section == k).any()]
    angles.append(math.degrees(math.atan(-np.polyfit(*np.transpose(tops), 1)[0])))


found = []
for eta in ETAS:
    start(eta)
    complete = rcr.advance(round(SECONDS / O.dt), f"η = {eta}")
    rcr.snapshot(options.out / f"slope-{eta}.png", limits=((0, -2 * R), (LENGTH, 0.85 * LENGTH)))
    if not complete:
        break
    found.append((eta, np.mean(angles), np.std(angles)))
    print(f"eta = {eta}: slope {found[-1][1]:.1f}°, standard deviation {found[-1][2]:.1f}°")

np.savetxt(options.out / "angle_of_repose.csv", np.reshape(found, (-1, 3)),
           delimiter=",", header="eta,angle,deviation", comments="", fmt="%g")
fig, ax = plt.subplots(figsize=(4, 3), layout="constrained")
ax.errorbar(*np.reshape(found, (-1, 3)).T, fmt="o-", capsize=3)
ax.set(xlabel=r"elongation $\eta$", ylabel="angle of repose [°]", ylim=(0, None))
fig.savefig(options.out / "angle_of_repose.png", dpi=150)
