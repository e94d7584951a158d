"""Empties a hopper of discs, then one of long grains of the same area.

A gate below the outlet is erased when the grains are at rest. The script records the fraction of
grains below the outlet. Discs flow out, long grains can jam.

Run it with YADE:  scripts/yade-rcr -n -x examples/hopper.py
Writes DIR/hopper-ETA.png (during each discharge), DIR/discharge.png, and DIR/discharge.csv (time,
fraction of the grains below the outlet).
"""

import math
import random

import matplotlib.pyplot as plt
import numpy as np
from yade import plot

import rcr
from rcr import *
from rcr import script

options = script.options(__doc__)
R = 0.01  # radius of the largest discs [m]; long grains have the same area
GRAINS, SECONDS = (60, 0.3) if options.quick else (320, 1.4)
OUTLET = 12 * R
SLOPE = math.radians(50)  # slope of the inclined walls [rad]
TOP = 0.45  # distance of the upright walls [m]


def size_of(eta):
    """Return the circumscribed radius of a grain with the area of a disc of the radius R."""
    return R * math.sqrt(math.pi / (math.pi * (1 - eta) ** 2 + 4 * eta * (1 - eta)))


def places_above(eta):
    """Return the places of the grains in rows above the outlet."""
    places, size = [], size_of(eta)
    y = size
    while len(places) < GRAINS:
        half = min(0.5 * OUTLET + (y - size) / math.tan(SLOPE), 0.5 * TOP) - 1.3 * size
        places += [(x, y) for x in np.linspace(-half, half, max(2, int(half / (1.05 * size)) + 1))]
        y += 2.1 * size
    return places[:GRAINS]


def fill(eta):
    """Make walls, gate and grains; return the ids of the gate and of the grains."""
    O.reset()
    plot.resetData()
    smooth = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.2)))
    rough = O.materials.append(FrictMat(density=2600, frictionAngle=math.atan(0.5)))
    run = 0.5 * (TOP - OUTLET)  # length of an inclined wall along x
    rise, thick = run * math.tan(SLOPE), 0.5 * R
    for side in (-1, 1):
        x = side * (0.5 * OUTLET + 0.5 * run + thick * math.sin(SLOPE))
        middle = (x, 0.5 * rise - thick * math.cos(SLOPE), 0)
        extents = (0.5 * run / math.cos(SLOPE), thick, R)
        turn = Quaternion((0, 0, 1), side * SLOPE)
        O.bodies.append(box(middle, extents, orientation=turn, fixed=True, material=smooth))
        O.bodies.append(rcr.wall("x", side * 0.5 * TOP, sense=-side, material=smooth))
    gate = O.bodies.append(rcr.wall("y", 0, +1, material=smooth))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Rcr_Aabb(), Bo1_Wall_Aabb(), Bo1_Box_Aabb()],
                              verletDist=0.1 * R),
        InteractionLoop([Ig2_Rcr_Rcr_RcrGeom(), Ig2_Wall_Rcr_RcrGeom(), Ig2_Box_Rcr_RcrGeom()],
                        [Ip2_FrictMat_FrictMat_CdPhys()], [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
        ContactDynamics(tolerance=1e-4, maxIterations=100_000),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),
        PyRunner(command="record()", iterPeriod=10, dead=True, label="recorder"),
    ]
    O.dt = 1e-3
    draw, size = random.Random(1), size_of(eta)
    grains = [particle(place, draw.uniform(0.8, 1) * size, eta, draw.uniform(0, math.pi), rough)
              for place in places_above(eta)]
    return gate, O.bodies.append(grains)


def record():
    out = sum(O.bodies[k].state.pos[1] < 0 for k in grains)
    plot.addData(t=O.time - opened, out=out / len(grains))


curves = {}
for eta in (0, 0.6):
    gate, grains = fill(eta)
    complete = rcr.advance(200 if options.quick else 700, f"η = {eta}, filling")
    O.bodies.erase(gate)
    opened, recorder.dead = O.time, False
    complete = complete and rcr.advance(round(0.4 * SECONDS / O.dt), f"η = {eta}, discharge")
    rcr.snapshot(options.out / f"hopper-{eta}.png", color="speed", range=(0, 1),
                 cmap="Blues", contacts="force", limits=((-0.5 * TOP, -0.15), (0.5 * TOP, 0.5)))
    complete = complete and rcr.advance(round(0.6 * SECONDS / O.dt), f"η = {eta}, discharge")
    if not complete:
        break
    curves[eta] = np.array([plot.data["t"], plot.data["out"]])

rows = [(eta, t, out) for eta, curve in curves.items() for t, out in zip(*curve)]
np.savetxt(options.out / "discharge.csv", rows, delimiter=",", header="eta,t,out",
           comments="", fmt="%g")
fig, ax = plt.subplots(figsize=(4, 3), layout="constrained")
for eta, (t, out) in curves.items():
    ax.plot(t, out, label=f"$\\eta$ = {eta}")
    print(f"eta = {eta}: {out[-1]:.0%} of the grains are out {t[-1]:.2f} s after the opening, "
          f"the last one at {t[out.searchsorted(out[-1])]:.2f} s")
ax.set(xlabel="time [s]", ylabel="fraction of the grains below the outlet")
ax.legend()
fig.savefig(options.out / "discharge.png", dpi=150)
